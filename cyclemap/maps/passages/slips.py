"""Slips: how likely a cycle is to carry a noisy path from one stable zone on to the next."""

from __future__ import annotations

from dataclasses import dataclass

from cyclemap.checks import finite_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise_law import Noise
from cyclemap.maps.passages.quasi_stationary import law_between


@dataclass(frozen=True)
class Slip:
    """Made by ``slip_probabilities``: chances a cycle, of a path that has not slipped for long.

    centre, below, above : stable points on the lift, radians. up, down : probability a cycle of reaching ``above``,
    and ``below``, first. residence_cycles : mean time until either, 1/(up + down).
    """

    centre: float
    below: float
    above: float
    up: Estimate
    down: Estimate
    residence_cycles: Estimate

    @property
    def mean_turn(self) -> Estimate:
        """Radians a cycle that the slips make together: up·(above - centre) - down·(centre - below).

        For equal zones it tends to the mean turn, 2π times the rotation number, as the zones get deep: the relative
        difference is of the order of the time within a zone over the residence. The bound does not cover that.
        """
        climb, fall = self.above - self.centre, self.centre - self.below
        error = climb * self.up.error_bound + fall * self.down.error_bound
        return Estimate(climb * self.up - fall * self.down, error)


def slip_probabilities(
    circle_map: CircleMap, noise: Noise, centre: float, below: float | None = None, above: float | None = None
) -> Slip:
    """Probability a cycle of slipping up or down from the stable zone about ``centre`` to the next zone.

    centre : a stable point, radians on the lift. below, above : the stable points of the zones next to it, at most a
    turn away; None for a turn below and above, the right choice where there is one zone a turn.

    They are the two ways out of (below, above) under the quasi-stationary law of that arc on the line
    (``quasi_stationary_law``): a slip is complete when the next stable point is reached, so that the many paths that
    look over the unstable point and fall back do not count. (Kramers 1940; Hänggi, Talkner & Borkovec 1990.) Even
    1e-100 keeps its digits; what is below 1e-300 may read 0. Bounds: measured, see ``quasi_stationary_law``.

    Raises InvalidInput unless the degree is 1 and below < centre < above, each at most a turn away, and
    InvalidInput and ConvergenceError as ``quasi_stationary_law``.

    >>> from cyclemap.maps.noise.noise_law import WrappedNormal
    >>> slip = slip_probabilities(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.3), 0.77278)
    >>> round(1e4 * slip.up, 4), slip.down < 1e-30
    (2.0725, True)
    """
    if circle_map.degree != 1:
        raise InvalidInput(f"the map has degree {circle_map.degree}: slips need a lift of degree 1")
    middle = finite_number("centre", centre)
    low = middle - TWO_PI if below is None else finite_number("below", below)
    high = middle + TWO_PI if above is None else finite_number("above", above)
    if not (0.0 < middle - low <= TWO_PI and 0.0 < high - middle <= TWO_PI):
        raise InvalidInput(f"below, centre, above are {low:g}, {middle:g}, {high:g}: they must rise by at most a turn")
    law = law_between(circle_map, noise, (low, high), True)
    assert law.up is not None and law.down is not None
    return Slip(middle, low, high, law.up, law.down, law.residence_cycles)
