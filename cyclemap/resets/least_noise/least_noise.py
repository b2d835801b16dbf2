"""The least width of an independent random extra turn that makes the stationary law even enough."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cyclemap.checks import read_only, whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.arcs import Array
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise_law import Noise
from cyclemap.resets.least_noise.cycle_cells import checked_own_noise
from cyclemap.resets.least_noise.least_correction import LeastCorrection, checked_allowance
from cyclemap.resets.least_noise.noise_bound import independent_noise_bound, pushed_moments
from cyclemap.resets.least_noise.noise_families import NoiseFamily, noise_family
from cyclemap.resets.least_noise.turn_costs import TurnCost, turn_cost

_EVEN = 1e-12  # moments of F#u below this: F keeps the uniform law
_RELATIVE = 1e-9  # of the width, to which a crossing is sought

Found = Callable[[float], Estimate]


@dataclass(frozen=True, eq=False)
class LeastNoise:
    """The least width of one family of extra turns that leaves TV ≤ ``allowed_tv`` there and at all scanned above.

    family : with its ``parameter``. width : radians (probability for "lazy"), with a bound on its error; nan where
    no scanned width is enough. parameter_value : the law's own parameter at ``width.upper``.
    tv : left over at ``width.upper``; where none is enough, the least that was found. is_met : whether tv.upper is
    within the allowance. is_monotone : whether TV fell from each scanned width to the next, within its errors;
    if not, a smaller width may also do, and ``width`` is where TV last crosses the allowance on the scan.
    is_below_scan : whether every scanned width does: then ``width`` is the least scanned one, not the least there is.
    mean_cost : E c(ξ) at ``width.upper``. lower_bound : proven, on the mean cost of every independent law
    (and of every correction, if one was given). widths, tvs : the scan.
    """

    family: NoiseFamily
    cost: str
    allowed_tv: float
    width: Estimate
    parameter_value: float
    tv: Estimate
    is_met: bool
    is_monotone: bool
    is_below_scan: bool
    mean_cost: float
    lower_bound: float
    widths: Array
    tvs: Array

    @property
    def factor(self) -> float:
        """Mean cost over the lower bound: no law whatever is better by more; inf where the bound is 0 and it is not."""
        if self.lower_bound > 0.0:
            return self.mean_cost / self.lower_bound
        return 1.0 if self.mean_cost == 0.0 else np.inf


def least_noise(
    circle_map: CircleMap,
    allowed_tv: float,
    family: str = "normal",
    own_noise: Noise | None = None,
    cost: str = "absolute",
    correction: LeastCorrection | None = None,
    scanned: int = 16,
) -> LeastNoise:
    """The least extra random turn ξ of one family with which θ' = F(θ) + η + ξ is within ``allowed_tv`` of uniform.

    family : "normal", "uniform", "von-mises", "cauchy" or "lazy" (see ``noise_family``). own_noise : law of η.
    cost : what ``mean_cost`` and ``lower_bound`` count. correction : of the same map, allowance, cost and own noise:
    its proven bound, which holds for independent turns too, is used where it is the larger. scanned : widths tried,
    at least 4, in geometric steps.

    Every width is judged by its stationary law with a bound on its error (from ``transfer_operator``; measured, by a
    coarser basis or grid, for uniform and lazy turns); the crossing is refined to where TV less its bound is above
    the allowance on one side, and TV with its bound is not on the other. For an allowance of 0 the answer is closed:
    only a turn that is uniform on the circle does it, or nothing at all where F keeps the uniform law; or, where F#u
    has only moments of orders that k divides, one that is uniform on the k-th part of it.

    Raises InvalidInput for values that cannot be used, ConvergenceError where the crossing cannot be certified.

    >>> found = least_noise(CircleMap.arnold(0.1, 0.9), 0.05, "lazy", scanned=6)
    >>> found.is_met, 0.5 < found.width < 1.0, found.factor >= 1.0
    (True, True, True)
    """
    allowed, price, kind = checked_allowance(allowed_tv), turn_cost(cost), noise_family(family)
    if not isinstance(circle_map, CircleMap):
        raise InvalidInput(f"the map is {circle_map!r}: give a CircleMap")
    own, count = checked_own_noise(own_noise), whole_number("scanned", scanned, least=4)
    lower = _lower_bound(circle_map, allowed, price, own, correction)
    made = _Maker(kind, price, allowed, lower)
    uneven = np.flatnonzero(pushed_moments(circle_map) > _EVEN) + 1
    if uneven.size == 0:
        return made.closed(0.0)
    if allowed == 0.0:
        # A uniform turn of half-width π/k has no moment whose order k divides.
        return made.closed(np.pi / np.gcd.reduce(uneven) if kind.name == "uniform" else kind.even)
    return made.searched(kind.left_over(circle_map, own), count)


def _lower_bound(
    circle_map: CircleMap, allowed: float, price: TurnCost, own: Noise | None, correction: LeastCorrection | None
) -> float:
    lower = independent_noise_bound(circle_map, allowed, price.name, own).lower
    if correction is None:
        return lower
    if not isinstance(correction, LeastCorrection):
        raise InvalidInput(f"correction is {correction!r}: give what least_correction returned, or None")
    same = correction.cost == price.name and correction.allowed_tv == allowed and correction.grid.target is None
    if not (same and correction.grid.circle_map is circle_map and correction.grid.own_noise == own):
        raise InvalidInput("correction is of another map, allowance, cost, own noise or target: give one of the same")
    return max(lower, correction.lower)


@dataclass(frozen=True)
class _Maker:
    """The parts of a result that are known before the search."""

    kind: NoiseFamily
    price: TurnCost
    allowed: float
    lower: float

    def closed(self, width: float | None) -> LeastNoise:
        """For an answer that needs no search: a width at which the law is exactly uniform, or none."""
        if width is None:
            return self._result(Estimate(np.nan, 0.0), Estimate(1.0, 1.0), np.zeros(0), [], True, False)
        return self._result(Estimate(width, 0.0), Estimate(0.0, 0.0), np.zeros(0), [], True, False)

    def searched(self, left_over: Found, count: int) -> LeastNoise:
        """Scan, then refine the last crossing."""
        widths = np.geomspace(self.kind.least, self.kind.most, count)
        widths[-1] = self.kind.most
        tvs = [left_over(float(width)) for width in widths]
        falls = all(after.lower <= before.upper for before, after in pairwise(tvs))
        over = [i for i, tv in enumerate(tvs) if tv.upper > self.allowed]
        if not over:
            return self._result(Estimate(float(widths[0]), 0.0), tvs[0], widths, tvs, falls, True)
        if over[-1] == count - 1:
            return self._result(Estimate(np.nan, 0.0), min(tvs), widths, tvs, falls, False)
        width = certified_crossing(left_over, self.allowed, float(widths[over[-1]]), float(widths[over[-1] + 1]))
        return self._result(width, left_over(width.upper), widths, tvs, falls, False)

    def _result(
        self, width: Estimate, tv: Estimate, widths: Array, tvs: list[Estimate], falls: bool, below: bool
    ) -> LeastNoise:
        met = not np.isnan(width) and tv.upper <= self.allowed
        return LeastNoise(
            family=self.kind,
            cost=self.price.name,
            allowed_tv=self.allowed,
            width=width,
            parameter_value=self.kind.value(width.upper) if width > 0.0 else np.nan,
            tv=tv,
            is_met=met,
            is_monotone=falls,
            is_below_scan=below,
            mean_cost=np.nan if np.isnan(width) else self.kind.mean_cost(width.upper, self.price),
            lower_bound=self.lower,
            widths=read_only(widths),
            tvs=read_only(tvs),
        )


def certified_crossing(left_over: Found, allowed: float, low: float, high: float) -> Estimate:
    """A width whose bound holds a crossing: TV is above ``allowed`` at its lower end, by TV's bounds, not at its upper.

    low, high : TV above the allowance, or not known to be below, at the first; below at the second.
    Raises ConvergenceError where the errors of TV hide the crossing.
    """
    from scipy.optimize import brentq

    if left_over(low) <= allowed:
        raise ConvergenceError(f"TV at width {low:g} is {allowed:g} within its error: ask for a larger allowance")
    middle = float(brentq(lambda width: left_over(width) - allowed, low, high, xtol=_RELATIVE * low))
    half = 10.0 * _RELATIVE * middle
    while half < 0.1 * middle:
        below, above = max(low, middle - half), min(high, middle + half)
        if left_over(below).lower > allowed and left_over(above).upper <= allowed:
            centre = 0.5 * (below + above)
            return Estimate(centre, 0.5 * (above - below) * (1.0 + 1e-6))
        half *= 4.0
    raise ConvergenceError(f"the crossing near width {middle:g} is hidden by the error of TV there")
