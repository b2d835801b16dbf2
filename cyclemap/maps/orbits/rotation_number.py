"""Rotation numbers with an enclosure that holds the truth; rotation intervals of folded lifts, by
their monotone envelopes: the nearest nondecreasing maps above and below (water levels).
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache, partial
from math import ceil, floor, inf, nextafter

import numpy as np

from cyclemap.arrays import TWO_PI, Array, stretches
from cyclemap.checks import non_negative_number, require_room, whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import LIFT, Estimate
from cyclemap.maps.lifts.branches import cell_limits
from cyclemap.maps.lifts.circle_map import CircleMap, require_degree_one, require_map
from cyclemap.maps.lifts.lift_checks import SIDE_STEP, within_turn
from cyclemap.maps.lifts.piecewise_lifts import GivenBranch, Piece, on_base_turn
from cyclemap.maps.lifts.scan import GRAIN, INSET, bracketed_root, monotone_cells
from cyclemap.maps.orbits.orbit_means import ITERATES, FollowedOrbit, birkhoff_average
from cyclemap.maps.orbits.proofs import LockingProof, proved_rotation

SLACK = 1e-12  # radians: a smaller descent is rounding
_GRID = np.linspace(0.0, TWO_PI, ceil(TWO_PI / GRAIN) + 1)
MAX_PERIOD = 2_000
# iterates after which locking is tried first; then every eight times as many, or two
_FIRST_LOOK = 64
_SETTLED = 1e-9  # radians: an orbit that comes back this near has settled
# radians beside an orbit where the witnesses of locking are sought
_REACH = np.pi * 4.0 ** -np.arange(0.0, 19.0)
_MARGIN = 2e-14  # radians: a gap above it is no rounding of the comparison itself
_ZOOMS = 6  # times that the search narrows around the best angle so far
# at most so many iterates, periods to try, and the half-width at which to stop
_Budget = tuple[int, int, float]


def is_nondecreasing(circle_map: CircleMap) -> bool:
    """Whether a lift falls nowhere, by more than rounding: 1e-12 radians from any angle to a later
    one.

    Parameters
    ----------
    circle_map : CircleMap
        The map.

    Returns
    -------
    bool
        True where it does not fall.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, is_nondecreasing
    >>> is_nondecreasing(CircleMap.arnold(0.2, 0.9)), is_nondecreasing(CircleMap.arnold(0.2, 1.1))
    (True, False)
    """
    return largest_descent(circle_map) <= SLACK


def largest_descent(circle_map: CircleMap) -> float:
    """The largest F(x) - F(y) over x < y, radians; 0 for a nondecreasing lift.

    Folds as wide as a tenth of a milliradian are found, narrower ones may be missed (see
    ``GRAIN``).
    """
    require_map(circle_map)
    pieces = circle_map.pieces
    if circle_map.breaks.size == 0 and pieces is not None and pieces.surely_rises():
        return 0.0
    smooth = circle_map.breaks.size == 0 and pieces is None
    try:
        value = _skeleton(circle_map)[1]
    except ConvergenceError:
        if not smooth or np.max(-np.diff(circle_map(_GRID))) > 2.0 * circle_map.max_error:
            raise
        return 0.0  # too rough for cells, and rising all the same
    twice = np.concatenate([value, value + TWO_PI * circle_map.degree])
    descent = float(np.max(np.maximum.accumulate(twice) - twice))
    # A nondecreasing lift lies within max_error of one that falls by twice that.
    return 0.0 if smooth and descent <= 2.0 * circle_map.max_error else descent


def upper_envelope(circle_map: CircleMap) -> CircleMap:
    """The upper monotone envelope F⁺(x) = sup of F over (-∞, x].

    Parameters
    ----------
    circle_map : CircleMap
        A map F of degree 1.

    Returns
    -------
    CircleMap
        Nondecreasing, at or above F.

    Notes
    -----
    Folds and downward jumps become plateaus, whose ends are the breaks of the result.
    (Chenciner, Gambaudo & Tresser 1984; Alsedà, Llibre & Misiurewicz, Combinatorial Dynamics
    and Entropy in Dimension One, ch. 3.) Levels and ends are found to a few rounding units of
    the angle, so its ``max_error`` is that of F plus 6e-15·max|F'|.

    References
    ----------
    - Chenciner, A., Gambaudo, J.-M. & Tresser, C. (1984), Une remarque sur la structure des
      endomorphismes de degré 1 du cercle, Comptes Rendus 299.
    - Alsedà, L., Llibre, J. & Misiurewicz, M., Combinatorial dynamics and entropy in dimension one,
      chapter 3.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, upper_envelope
    >>> raised = upper_envelope(CircleMap.arnold(0.0, 3.0))
    >>> bool(raised(0.0) > CircleMap.arnold(0.0, 3.0)(0.0))
    True
    """
    return _envelope(circle_map, 1)


def lower_envelope(circle_map: CircleMap) -> CircleMap:
    """The lower monotone envelope F⁻(x) = inf of F over [x, ∞).

    Parameters
    ----------
    circle_map : CircleMap
        A map F of degree 1.

    Returns
    -------
    CircleMap
        Nondecreasing, at or below F; see ``upper_envelope``.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, lower_envelope
    >>> lowered = lower_envelope(CircleMap.arnold(0.0, 3.0))
    >>> bool(lowered(0.0) <= CircleMap.arnold(0.0, 3.0)(0.0))
    True
    """
    return _envelope(circle_map, -1)


def _envelope(circle_map: CircleMap, mirror: int) -> CircleMap:
    """The upper envelope, or with ``mirror`` -1 the lower one: F, and on each plateau its level."""
    require_map(circle_map)
    require_degree_one(circle_map, "rotation")
    theta, value, steepest = _skeleton(circle_map)
    # x → -F(-x) swaps infimum from the right with supremum from the left
    nodes, values = (mirror * column[::mirror] for column in (theta, value))
    plateaus = _plateaus(circle_map, nodes, values, mirror)
    start, end, level = (mirror * column[::mirror] for column in plateaus)
    if mirror < 0:
        start, end = end, start
    if start.size == 0:
        return circle_map
    pieces = []
    following = np.append(start[1:], start[0] + TWO_PI)
    for first, last, height, after in zip(start, end, level, following, strict=True):
        flat = GivenBranch(partial(np.full_like, fill_value=height), np.zeros_like, first, last)
        pieces += [Piece(first, last, flat), Piece(last, after, circle_map)]
    breaks = np.concatenate([start, end, circle_map.breaks])
    error = circle_map.max_error + SIDE_STEP * steepest
    return CircleMap(on_base_turn(pieces, 1), None, breaks, max_error=error)


@lru_cache(maxsize=2)  # both envelopes and the descent of one map ask for it
def _skeleton(circle_map: CircleMap) -> tuple[Array, Array, float]:
    """Points (θ, F) in order over [0, 2π], F monotone between neighbours, a jump one θ twice; the
    largest |F'|.
    """
    cells = monotone_cells(circle_map, 1, 0.0)
    theta = np.stack([cells.start, cells.end], axis=1).ravel()
    value = np.stack(cell_limits(circle_map, cells), axis=1).ravel()
    if cells.cut[0]:
        theta = np.append(theta, TWO_PI)
        value = np.append(value, value[0] + cells.climb)
    return theta, value, float(np.max(np.abs([cells.slope_start, cells.slope_end])))


def _plateaus(
    circle_map: CircleMap, nodes: Array, values: Array, mirror: int
) -> tuple[Array, Array, Array]:
    """Starts (one turn of them), ends and levels of the intervals where the running maximum exceeds
    F.
    """
    laps = TWO_PI * np.array([[-1.0], [0.0], [1.0]])
    theta = (nodes + laps).ravel()
    value = (values + laps).ravel()
    highest = np.maximum.accumulate(value)
    under = value < highest - SLACK
    runs = [run for run in stretches(under) if run[0] > 0 and run[1] < under.size]
    first, after = np.reshape(runs, (-1, 2)).astype(np.int64).T
    first = first - 1
    begins = theta[first]
    keep = (begins >= nodes[0]) & (begins < nodes[0] + TWO_PI)
    first, after, level = first[keep], after[keep], highest[first[keep]]
    # F climbs back to each level in the cell that ends at node ``after``, or at its upward jump.
    low = theta[after - 1] + INSET
    high = theta[after] - INSET

    def residual(x: Array, wanted: Array) -> Array:
        return mirror * circle_map(mirror * x) - wanted

    met = bracketed_root(lambda x, index: residual(x, level[index]), low, high)
    end = np.where((high > low) & (residual(high, level) > 0.0), met, theta[after])
    return theta[first], end, level


@dataclass(frozen=True)
class RotationNumber:
    """A rotation number in turns a cycle.

    Attributes
    ----------
    value : float
        The best estimate, inside [lower, upper].
    lower, upper : float
        The truth lies between them (both included; rounded outward).
    locked : Fraction or None
        p/q when a periodic orbit proves the rotation number to be exactly that, else None.
    proof : LockingProof or None
        The witness of ``locked``, else None.
    estimate : Estimate or None
        The weighted Birkhoff average with its estimated (not proved) error, None when locked.

    Examples
    --------
    >>> from cyclemap import CircleMap, rotation_number
    >>> found = rotation_number(CircleMap.arnold(0.5, 0.9))
    >>> found.value, found.locked, found.estimate
    (0.5, Fraction(1, 2), None)
    """

    value: float
    lower: float
    upper: float
    locked: Fraction | None
    proof: LockingProof | None = None
    estimate: Estimate | None = None


@dataclass(frozen=True)
class RotationInterval:
    """All rotation numbers of a lift.

    Attributes
    ----------
    lower, upper : float
        Ends of the interval, turns a cycle.
    lower_number, upper_number : RotationNumber
        Both ends, with their enclosures.

    Examples
    --------
    >>> from cyclemap import CircleMap, rotation_interval
    >>> found = rotation_interval(CircleMap.arnold(0.3, 3.0))
    >>> found.lower, found.upper
    (0.0, 0.5)
    """

    lower: float
    upper: float
    lower_number: RotationNumber
    upper_number: RotationNumber


def rotation_number(
    circle_map: CircleMap,
    *,
    iterates: int = ITERATES,
    max_period: int = MAX_PERIOD,
    tolerance: float = 0.0,
    proved: bool = False,
) -> RotationNumber:
    """The rotation number ρ = lim (Fⁿ(θ) - θ)/2πn of a degree-1 lift, with bounds.

    Parameters
    ----------
    circle_map : CircleMap
        A map of degree 1.
    iterates : int, optional
        How many cycles are followed at most.
    max_period : int, optional
        The longest period that locking is looked for with.
    tolerance : float, default 0.0
        Turns a cycle; as soon as [lower, upper] is no wider than twice that, no further
        iterates are made.
    proved : bool, optional
        Make the bounds theorems by interval arithmetic (the extra ``proofs``), about the formula of
        an exact, smooth lift as for ``periodic_points``, rounding and folds included. Of a lift
        that is proved to rise, F' > 0, they come from its orbit from 0, about 0.2 ms an iterate,
        and ``locked`` from the two angles of ``proof``; of any other from Fⁿ(θ) - θ at all θ, n ≤
        6 (fewer where those are too steep), and ``locked`` is None.

    Returns
    -------
    RotationNumber
        With bounds, and whether it is locked.

    Raises
    ------
    InvalidInput
        For another degree.
    ConvergenceError
        When the bounds contradict each other.

    Notes
    -----
    Nondecreasing lifts (jumps allowed): every iterate bounds ρ, since Fⁿ(θ) ≥ θ + 2πp at one θ
    implies ρ ≥ p/n, and ≤ likewise (Poincaré 1885). The lower bound is the best of ``iterates``
    iterates of F - e, the upper one of F + e. e adds up the map's ``max_error``, what a lift
    taken as nondecreasing falls (≤ 1e-12), and rounding; no orbit of F lies below the one or
    above the other, so the bounds hold however F amplifies errors, for every nondecreasing lift
    within ``max_error`` of F. Proved, given that a computed image is good to 4 units (8.9e-16)
    of 2π + max|F|: a lift that is computed worse must say so by ``max_error``. Folds narrower
    than a tenth of a milliradian may pass unseen. About 1/iterates² wide where ρ is irrational,
    F smooth and max_error 0; 1/(q·iterates) where ρ is p/q without being locked.

    Where F^q - e and F^q + e leave values on both sides of 2πp (q ≤ ``max_period``), ρ = p/q is
    proved and ``locked``, with the two angles as ``proof``; at the very edge of a tongue the
    sides cannot be told apart. Otherwise ``estimate`` is ``birkhoff_average`` of the turn, and
    ``value`` is the same where it lies inside the bounds and has a sharper one of its own, else
    their middle.

    Lifts that fold have an interval of rotation numbers: [lower, upper] encloses all of it (see
    ``rotation_interval``), ``estimate`` is that of the orbit from θ = 0, and ``locked`` is set
    only when the interval is one proved fraction.

    Examples
    --------
    >>> from cyclemap import CircleMap, rotation_number
    >>> found = rotation_number(CircleMap.arnold(0.1, 0.9))
    >>> found.locked, found.proof is not None
    (Fraction(0, 1), True)
    >>> free = rotation_number(CircleMap.moebius(0.5, 0.3))
    >>> round(free.estimate, 14), free.upper - free.lower < 1e-8
    (0.26253675589882, True)
    """
    budget = _budget(circle_map, iterates, max_period, tolerance)
    if proved:
        return _proved_rotation(circle_map, budget)
    return _computed_rotation(circle_map, budget)


def _computed_rotation(circle_map: CircleMap, budget: _Budget) -> RotationNumber:
    """The number in double precision, of a folded lift that of the interval."""
    descent = largest_descent(circle_map)
    if descent <= SLACK:
        return _monotone_rotation(circle_map, budget, descent)
    low, high = _interval(circle_map, budget)
    if low.proof and high.proof and low.locked == high.locked:
        proof = LockingProof(low.proof.ratio, high.proof.below, low.proof.above)
        return RotationNumber(low.value, low.lower, high.upper, low.locked, proof)
    # Of n cycles a mean is good to 1/n.
    iterates, _, tolerance = budget
    enough = (
        iterates if tolerance == 0.0 else min(iterates, max(_FIRST_LOOK, ceil(1.0 / tolerance)))
    )
    return _unlocked(circle_map, low.lower, high.upper, enough)


def rotation_interval(
    circle_map: CircleMap,
    *,
    iterates: int = ITERATES,
    max_period: int = MAX_PERIOD,
    tolerance: float = 0.0,
) -> RotationInterval:
    """All rotation numbers of a degree-1 lift: [ρ(F⁻), ρ(F⁺)] of its lower and upper monotone
    envelopes.

    Parameters
    ----------
    circle_map : CircleMap
        A map of degree 1.
    iterates : int, optional
        As of ``rotation_number``.
    max_period : int, optional
        As of ``rotation_number``.
    tolerance : float, default 0.0
        As of ``rotation_number``.

    Returns
    -------
    RotationInterval
        Its ends, with their enclosures.

    Raises
    ------
    InvalidInput
        As ``rotation_number``.

    Notes
    -----
    For continuous lifts every number between is the rotation number of some orbit (Chenciner,
    Gambaudo & Tresser 1984; Misiurewicz 1986); with downward jumps it still contains all of
    them. A nondecreasing lift gives one point. The enclosures of both ends, and what they
    cover, are as in ``rotation_number``.

    References
    ----------
    - Chenciner, A., Gambaudo, J.-M. & Tresser, C. (1984), Une remarque sur la structure des
      endomorphismes de degré 1 du cercle, Comptes Rendus 299.
    - Misiurewicz, M. (1986), Rotation intervals for a class of maps of the real line into itself,
      Ergodic Theory and Dynamical Systems 6.

    Examples
    --------
    >>> from cyclemap import CircleMap, rotation_interval
    >>> found = rotation_interval(CircleMap.arnold(0.5, 3.0))
    >>> found.lower_number.locked, found.upper_number.locked
    (Fraction(1, 6), Fraction(5, 6))
    """
    low, high = _interval(circle_map, _budget(circle_map, iterates, max_period, tolerance))
    return RotationInterval(low.value, high.value, low, high)


def _interval(circle_map: CircleMap, budget: _Budget) -> tuple[RotationNumber, RotationNumber]:
    """The numbers of both envelopes, which fall by no more than was left of a descent."""
    low_map = lower_envelope(circle_map)
    high_map = upper_envelope(circle_map)
    low = _monotone_rotation(low_map, budget, SLACK)
    high = low if high_map is low_map else _monotone_rotation(high_map, budget, SLACK)
    return low, high


def _budget(circle_map: CircleMap, iterates: int, max_period: int, tolerance: float) -> _Budget:
    require_map(circle_map)
    require_degree_one(circle_map, "rotation")
    count = whole_number("iterates", iterates, least=16)
    require_room("the orbit", count, "give fewer iterates")
    longest = whole_number("max_period", max_period, least=1)
    return count, longest, non_negative_number("tolerance", tolerance)


def _monotone_rotation(circle_map: CircleMap, budget: _Budget, descent: float) -> RotationNumber:
    """The number of a lift that falls by no more than ``descent``."""
    iterates, max_period, tolerance = budget
    # A computed image is F to a few roundings; a nondecreasing F stays near F(0) on [0, 2π].
    push = float(circle_map.max_error + LIFT * (2.0 * TWO_PI + abs(float(circle_map(0.0)))))
    push += descent
    under = _PushedOrbit(circle_map, -push)
    over = _PushedOrbit(circle_map, push)
    # Where the bounds may be wide enough soon, they are looked at more often.
    factor = 2 if tolerance > 0.0 else 8
    looks = [look for look in (_FIRST_LOOK * factor**k for k in range(60)) if look < iterates]
    for count in [*looks, iterates]:
        under.run_to(count)
        over.run_to(count)
        low = under.best_ratio()
        high = over.best_ratio()
        if low > high:
            raise ConvergenceError(
                f"the iterates prove ρ ≥ {low} and ρ ≤ {high}: the lift is computed with errors "
                f"above {push:.2g} radians, or folds unseen; give it its max_error"
            )
        candidate = simplest_between(low, high)
        if (
            candidate.denominator <= max_period
            and under.settles(candidate)
            and over.settles(candidate)
        ):
            proof = _locking_proof(
                circle_map, candidate, push, (under.visited[-1], over.visited[-1])
            )
            if proof is not None:
                return RotationNumber(
                    float(candidate), *_floats(candidate, candidate), candidate, proof
                )
        if high - low <= 2.0 * tolerance:
            break
    return _unlocked(circle_map, *_floats(low, high), count)


def _proved_rotation(circle_map: CircleMap, budget: _Budget) -> RotationNumber:
    if circle_map.max_error > 0.0 or circle_map.pieces is not None:
        raise InvalidInput(
            "no proof: a map that is not exact has bounds that hold for all within its max_error; "
            "leave out proved"
        )
    iterates, _, tolerance = budget
    searched = _computed_rotation(circle_map, budget)
    low, high = proved_rotation(circle_map, iterates, 2.0 * tolerance, searched.proof)
    if low < high:
        return _unlocked(circle_map, *_floats(low, high), iterates)
    return RotationNumber(float(low), *_floats(low, low), low, searched.proof)


class _PushedOrbit(FollowedOrbit):
    """The orbit of θ = 0 under F + push, which bounds the rotation number from one side."""

    def settles(self, ratio: Fraction) -> bool:
        """Whether F^q - id - 2πp kept shrinking along the last half of the orbit: else q is no
        period of it.
        """
        period = ratio.denominator
        last = max(2 * ratio.denominator, len(self.laps) // 2)
        if period + last > len(self.laps):
            return False
        theta = np.array(self.visited[-last - period :])
        turns = np.array(self.laps[-last - period :], dtype=float)
        gap = np.abs(
            theta[period:]
            - theta[:-period]
            + TWO_PI * (turns[period:] - turns[:-period] - ratio.numerator)
        )
        near = _SETTLED + abs(self.push)
        return bool(
            gap[-1] <= max(0.9 * gap[0], near)
            and np.all(gap[period:] <= np.maximum(gap[:-period], near))
        )

    def best_ratio(self) -> Fraction:
        """The largest p/n with Fⁿ(0) ≥ 2πp if the push is down, the smallest with ≤ if it is up."""
        up = self.push > 0.0
        whole = np.array(self.laps[1:]) + up
        ratio = whole / np.arange(1.0, whole.size + 1.0)
        best = int(np.argmin(ratio) if up else np.argmax(ratio))
        return Fraction(int(whole[best]), best + 1)


def _locking_proof(
    circle_map: CircleMap, ratio: Fraction, push: float, near: tuple[float, float]
) -> LockingProof | None:
    """Angles where F^q - id - 2πp is above 0 even for F - push, and below 0 even for F + push, if
    any are found.
    """
    side = np.array([[1.0], [-1.0]])
    beside = np.concatenate([-_REACH, [0.0], _REACH])
    start = np.array([near]).T + beside
    for _ in range(_ZOOMS):
        theta = start
        turns = np.zeros(start.shape)
        for _ in range(ratio.denominator):
            theta, laps = within_turn(circle_map(theta) - side * push)
            turns = turns + laps
        wanted = side * ((theta - start) + TWO_PI * (turns - ratio.numerator))
        best = np.argmax(wanted, axis=1)
        most = np.max(wanted, axis=1)
        if np.all(most > _MARGIN):
            above, below = start[[0, 1], best].tolist()
            return LockingProof(ratio, below, above)
        low = np.maximum(best - 1, 0)
        high = np.minimum(best + 1, beside.size - 1)
        start = np.linspace(start[[0, 1], low], start[[0, 1], high], beside.size, axis=1)
    return None


def _unlocked(circle_map: CircleMap, lower: float, upper: float, iterates: int) -> RotationNumber:
    mean = birkhoff_average(circle_map, iterates=iterates)
    estimate = Estimate(mean / TWO_PI, mean.error_bound / TWO_PI)
    known = lower <= estimate <= upper and estimate.error_bound <= 0.5 * (upper - lower)
    value = float(estimate) if known else 0.5 * (lower + upper)
    return RotationNumber(value, lower, upper, None, None, estimate)


def simplest_between(low: Fraction, high: Fraction) -> Fraction:
    """The fraction of smallest denominator in [low, high] (Stern-Brocot descent)."""
    whole = ceil(low)
    if whole <= high:
        return Fraction(whole)
    base = floor(low)
    return base + 1 / simplest_between(1 / (high - base), 1 / (low - base))


def _floats(low: Fraction, high: Fraction) -> tuple[float, float]:
    """The two as floats, rounded outward."""
    lower = float(low)
    upper = float(high)
    lower = lower if lower <= low else nextafter(lower, -inf)
    return lower, upper if upper >= high else nextafter(upper, inf)
