"""Quasi-stationary distributions: where a noisy path is, and how fast it leaves, once it has stayed for long."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import finite_array, finite_number, whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import QUASI_STATIONARY, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise import Noise
from cyclemap.maps.passages.killed_chain import (
    Arc,
    KilledChain,
    arc_chain,
    arc_ends,
    required_inside,
)
from cyclemap.maps.passages.passage_times import LONGEST

_ROUNDS = 400  # of one power and one inverse iteration each
_CONVERGED = 1e-13  # relative change of every entry of the law
_SMALLEST = 1e-290  # entries of the law below this are not judged
_ACCEPTED = 1e-6  # relative error bound that is accepted at all
_STRETCH = 1.3  # bandwidth of the second solution over that of the first
_ENDLESS = "the path stays in the arc for more than 1e300 cycles: raise the noise"
_BLOCK = 2_048  # angles at which the density is evaluated together


def quasi_stationary_distribution(
    circle_map: CircleMap, noise: Noise, arc: Arc, *, lifted: bool = False
) -> QuasiStationaryDistribution:
    """The law ν of θ given that the path θ' = F(θ) + ξ has stayed in ``arc`` for long.

    arc : (start, end), counter-clockwise, radians, length in (0, 2π). lifted : False counts positions mod 2π;
        True follows the path on the real line, where the arc may be a whole turn and ``up`` and ``down`` are told.

    ν K = λ ν, K the transitions within the arc: a path that starts with law ν is still inside after n cycles with
    probability exactly λⁿ, and where and when it leaves are independent (Darroch & Seneta 1965; Collet, Martínez &
    San Martín 2013). By alternating power and inverse iteration on Nyström's nodes, the latter without
    subtraction; 1 - λ is summed from the exactly known chances of leaving, so that 1e-100 keeps its digits.

    Bounds: the relative bound of the mean passage time at the law's mode (at most 1e-12 for rounding; the map's
    ``max_error`` is included to first order) plus three times the difference from a solution on other nodes:
    measured, not proved.

    Raises InvalidInput for an arc outside the circle, for noise that is too narrow and for ``UniformNoise``;
    ConvergenceError when the bound exceeds 1e-6 of 1 - λ (``max_error`` apart), when the path stays for more than
    1e300 cycles, or when two parts of the arc are left equally slowly, so that the law is not one.

    >>> from cyclemap.maps.noise.noise import WrappedNormal
    >>> stuck = quasi_stationary_distribution(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.1 * np.pi), (0.0, np.pi / 2))
    >>> round(stuck.residence_cycles, 3)
    44.003
    """
    return law_between(circle_map, noise, arc_ends(arc, "arc", whole=lifted), lifted)


@dataclass(frozen=True, eq=False)
class QuasiStationaryDistribution:
    """Made by ``quasi_stationary_distribution``.

    arc : (start, end), radians. lifted : whether positions are on the real line.
    survival : λ, the probability of staying one more cycle. escape_probability : 1 - λ.
    up, down : the parts of that above the arc's end and below its start; None unless lifted.
    residence_cycles : 1/(1 - λ), the mean time until the path is first outside.
    density_error : bound on the error of ``density``, per radian (measured on other nodes).
    """

    arc: Arc
    lifted: bool
    survival: Estimate
    escape_probability: Estimate
    up: Estimate | None
    down: Estimate | None
    density_error: float
    _chain: KilledChain
    _mass: Array

    @property
    def residence_cycles(self) -> Estimate:
        """1/(1 - λ) cycles."""
        escape = self.escape_probability
        return Estimate(1.0 / escape, escape.error_bound / escape / escape)

    def residence_probability(self, cycles: Any) -> Array:
        """P(residence > n) = λⁿ for numbers of cycles n, any shape, from a start with this law."""
        count = finite_array("cycles", cycles)
        stay = np.log1p(-self.escape_probability) if self.escape_probability < 0.5 else np.log(self.survival)
        return np.asarray(np.exp(count * stay))

    def density(self, theta: Any) -> Array:
        """Density per radian at ``theta`` (radians, any shape): 0 outside the arc; mod 2π unless lifted."""
        angles = finite_array("theta", theta)
        flat = angles.ravel() if self.lifted else self.arc[0] + np.mod(angles.ravel() - self.arc[0], TWO_PI)
        values = np.zeros_like(flat)
        inside = np.flatnonzero((flat >= self.arc[0]) & (flat <= self.arc[1]))
        for at in range(0, inside.size, _BLOCK):
            part = inside[at : at + _BLOCK]
            values[part] = _density_at(self._chain, self._mass, flat[part]) / self.survival
        return values.reshape(angles.shape)


def survival_probabilities(
    circle_map: CircleMap, noise: Noise, start: float, arc: Arc, cycles: int, *, lifted: bool = False
) -> Array:
    """P(the path from ``start`` has not left ``arc`` in n cycles) for n = 0, ..., ``cycles``: shape (cycles + 1,).

    S_0 = 1, S_{n+1}(x) = ∫_arc g(y - F(x)) S_n(y) dy on Nyström's nodes; arguments as for ``mean_passage_time``,
    which is the sum of S_n over all n. Rows of transitions are scaled to the exactly known chances of staying; the
    relative error grows with n, by about 1e-15 a cycle.

    >>> from cyclemap.maps.noise.noise import WrappedNormal
    >>> chances = survival_probabilities(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.3), 0.77, (0.0, 1.5), 2)
    >>> bool(chances[0] == 1.0 and chances[0] > chances[1] > chances[2])
    True
    """
    count, ends = whole_number("cycles", cycles, least=0), arc_ends(arc, "arc", whole=lifted)
    inside = required_inside(start, ends)
    chain = arc_chain(circle_map, noise, ends, lifted)
    images = np.append(chain.images, circle_map(inside))
    moves = chain.transitions(images)
    moves *= ((1.0 - chain.departures(images).sum(axis=0)) / moves.sum(axis=1))[:, None]
    staying, chances = np.ones(chain.theta.size), np.ones(count + 1)
    for n in range(1, count + 1):
        after = moves @ staying
        staying, chances[n] = after[:-1], after[-1]
    return chances


# -- inside --------------------------------------------------------------------------------------------------


def law_between(circle_map: CircleMap, noise: Noise, ends: Arc, lifted: bool) -> QuasiStationaryDistribution:
    """The law on an arc whose ends are sound; on the line it may be up to two turns long."""
    chain, other = (arc_chain(circle_map, noise, ends, lifted, stretch=stretch) for stretch in (1.0, _STRETCH))
    (mass, gone, stay), (mass_other, gone_other, _) = _fixed(chain), _fixed(other)
    # The relative error of the mean passage time at the law's mode: its own, and from the map. Where the arc holds
    # several deep wells its own drowns in rounding, while the elimination does not.
    expected = chain.expected(1.0, np.zeros(len(chain.exits)))
    mode = float(chain.theta[np.argmax(mass / chain.weight)])
    own, from_map = np.array(expected.error_bounds(mode)) / expected.value_at(mode)
    own = min(own, QUASI_STATIONARY)
    chances, again = np.append(gone, gone.sum()), np.append(gone_other, gone_other.sum())
    # Rounding grows with the height of the barrier, as the logarithm of the chance does.
    barrier = np.log(np.maximum(chances, _SMALLEST)) / min(np.log(max(chances[-1], _SMALLEST)), -1.0)
    bounds = (own * np.maximum(barrier, 1.0) + from_map) * chances + 3.0 * np.abs(chances - again)
    leaving = [Estimate(value, bound) for value, bound in zip(chances, bounds, strict=True)]
    escape = leaving[-1]
    if not escape.error_bound - from_map * escape <= _ACCEPTED * escape:
        raise ConvergenceError(
            f"the escape probability came out as {escape:.9g} with error bound {escape.error_bound:.3g}: "
            "raise the noise, give the map's breaks, or take an arc with one stable part"
        )
    error = np.abs(_density_at(chain, mass, other.theta) / stay - mass_other / other.weight)
    down, up = leaving[:2] if lifted else (None, None)
    survival = Estimate(1.0 - escape if escape < 0.5 else stay, escape.error_bound)
    return QuasiStationaryDistribution(
        ends, lifted, survival, escape, up, down, 3.0 * float(np.max(error)), chain, mass
    )


def _fixed(chain: KilledChain) -> tuple[Array, Array, float]:
    """The law's mass on the nodes, its chances of leaving by each exit, and of staying."""
    moves, mass, change = chain.transitions(chain.images), np.full(chain.theta.size, 1.0 / chain.theta.size), np.inf
    if not chain.elimination.leaves:
        raise ConvergenceError(_ENDLESS)
    for _ in range(_ROUNDS):
        after = mass @ moves
        after = chain.elimination.visits(after / after.sum())
        if not after.sum() < LONGEST:
            raise ConvergenceError(_ENDLESS)
        after /= after.sum()
        change = float(np.max(np.abs(after - mass) / np.maximum(after, _SMALLEST)))
        mass = after
        if change <= _CONVERGED:
            break
    if change > _ACCEPTED:
        raise ConvergenceError(
            f"the quasi-stationary law still changes by {change:.3g} a round: two parts of the arc are left "
            "almost equally slowly; take an arc with one stable part"
        )
    gone = chain.departures(chain.images) @ mass
    return mass, gone, float(np.sum(mass @ moves))


def _density_at(chain: KilledChain, mass: Array, theta: Array) -> Array:
    """∫ ν(x) g(θ - F(x)) dx, per radian: λ times the density."""
    gap = theta[:, None] - chain.images
    return np.asarray((chain.noise.line_density(gap) if chain.lifted else chain.noise.density(gap)) @ mass)


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

    They are the two ways out of (below, above) under the quasi-stationary distribution of that arc on the line: a slip
    is complete when the next stable point is reached, so that the many paths that look over the unstable point and
    fall back do not count. (Kramers 1940; Hänggi, Talkner & Borkovec 1990.) Even 1e-100 keeps its digits; what is below
    1e-300 may read 0. Bounds: measured, see ``quasi_stationary_distribution``.

    Raises InvalidInput unless the degree is 1 and below < centre < above, each at most a turn away, and
    InvalidInput and ConvergenceError as ``quasi_stationary_distribution``.

    >>> from cyclemap.maps.noise.noise import WrappedNormal
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
