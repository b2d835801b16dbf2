"""Rotation numbers of many maps of one family at once, and over a plane of two parameters: phase
diagrams.
"""

from __future__ import annotations

import os
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, Mask, Whole
from cyclemap.checks import (
    finite_array,
    positive_number,
    read_only,
    require_room,
    unwritable,
    whole_number,
)
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import LIFT
from cyclemap.maps.families.family import (
    Family,
    ParametricLift,
    broadcast_parameters,
    each_done,
    family_member,
    formula_values,
    parametric_form,
    require_parameters,
)
from cyclemap.maps.orbits.rotation_number import is_nondecreasing, rotation_number
from cyclemap.progress import Progress

_WORKERS = os.cpu_count() or 1
_CHUNK = 24_576  # maps at once: many enough to hide the cost of calls, few enough for the caches
# After so many cycles: the longest period tried for locking, and how far beside the orbit, radians
# over the period.
_TRIALS = (
    (16, 2, 0.5),
    (48, 8, 0.3),
    (128, 16, 0.1),
    (128, 16, 1e-3),
    (256, 16, 0.03),
    (256, 16, 1e-5),
    (512, 24, 0.01),
    (512, 24, 1e-7),
)
_SIDES = np.array([[-1.0], [1.0]])
_ONE_MORE = np.array([[0.0], [1.0]])
# After so many cycles the finished maps are taken out, then at equal distances.
_LOOKS = (16, 24, 28, 32, 36, 40, 44, 48, 56, 64, 80, 96, 128, 192, 256, 384, 512, 768, 1024)


@dataclass(frozen=True, eq=False)
class RotationNumbers:
    """Rotation numbers of many nondecreasing lifts, turns a cycle; arrays of the parameters'
    broadcast shape.

    Attributes
    ----------
    value : ndarray
        The middle of [lower, upper].
    lower, upper : ndarray
        The truth lies between them (rounded outward).
    period, winding : ndarray of int
        q and p where ρ = p/q is proved, else 0 and 0.
    tolerance : float
        What was asked for: half the width of the enclosures that meet it.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import ARNOLD_FAMILY, rotation_numbers
    >>> found = rotation_numbers(ARNOLD_FAMILY, [0.1, 0.6], 0.5)
    >>> bool(np.all(found.upper - found.lower <= 2.0 * found.tolerance)), found.period.tolist()
    (True, [0, 0])
    """

    value: Array
    lower: Array
    upper: Array
    period: Whole
    winding: Whole
    tolerance: float


def rotation_numbers(
    family: Family,
    *parameters: ArrayLike,
    tolerance: float = 1e-3,
    threads: int | None = None,
) -> RotationNumbers:
    """The rotation numbers of a family's lifts over arrays of parameters, each within a tolerance.

    Parameters
    ----------
    family : callable
        A ``ParametricLift`` whose lifts are nondecreasing at all these parameters, or
        ``CircleMap.arnold`` or ``CircleMap.moebius``, whose formulas are known.
    *parameters : array_like
        Numbers or arrays that broadcast together.
    tolerance : float, default 0.001
        Turns a cycle, in (0, 0.1]: the wanted half-width of each enclosure.
    threads : int or None, optional
        None takes one a processor; the numbers do not depend on it.

    Returns
    -------
    RotationNumbers
        Arrays of the parameters' broadcast shape.

    Raises
    ------
    InvalidInput
        For parameters that are not finite or where F falls (its rotation numbers are an
        interval: see ``rotation_interval``, ``rotation_plane``).
    ConvergenceError
        When the bounds contradict each other.

    Notes
    -----
    Every map follows two orbits, of F - e and F + e, whose whole turns p after n cycles bound ρ
    by p/n from below and (p + 1)/n from above (Poincaré 1885), on the terms of
    ``rotation_number``; maps whose bounds are near enough drop out, most after about
    1/√tolerance cycles, all but those whose ρ depends too steeply on e within 1/tolerance + 2.
    Orbits that start beside an attracting periodic orbit, on either side of it, prove locking.

    Examples
    --------
    >>> from cyclemap.maps import ARNOLD_FAMILY, rotation_numbers
    >>> found = rotation_numbers(ARNOLD_FAMILY, [0.1, 0.5, 0.6], 0.5)
    >>> found.period.tolist(), bool(abs(found.value[2] - 0.602894830374585) < 1e-3)
    ([0, 2, 0], True)
    """
    formula = parametric_form(family)
    if formula is None:
        raise InvalidInput(
            f"family is {family!r}: give a ParametricLift; rotation_plane takes any callable"
        )
    wanted = _wanted(tolerance)
    workers = _WORKERS if threads is None else whole_number("threads", threads, least=1)
    _, shape, flat = broadcast_parameters(parameters)
    require_parameters(formula, len(parameters))
    bounds = _bounds(formula, flat, wanted, workers)
    return RotationNumbers(*_in_shape(_judged(bounds, wanted), shape), wanted)


def _wanted(tolerance: float) -> float:
    wanted = positive_number("tolerance", tolerance)
    if wanted > 0.1:
        raise InvalidInput(f"tolerance is {wanted:g}: give at most 0.1 turns a cycle")
    require_room("each orbit", 1.0 / wanted, "give a larger tolerance")
    return wanted


def _judged(bounds: Array, tolerance: float) -> Array:
    """Rows of value, lower, upper, period and winding: these where both bounds are the same
    fraction, else 0.
    """
    lower, upper = bounds
    same = np.where(lower == upper, upper, -np.inf)
    period = _simplest_periods(lower, same, int(np.floor(1.0 / tolerance)) + 2)
    value = np.where(period > 0, lower, 0.5 * (lower + upper))
    winding = np.where(period > 0, np.round(lower * period), 0.0)
    # Bounds p/n as floats, moved outward by the rounding of that division.
    low = np.where(lower == np.round(lower), lower, np.nextafter(lower, -np.inf))
    high = np.where(upper == np.round(upper), upper, np.nextafter(upper, np.inf))
    return np.stack([value, low, high, period, winding])


def _in_shape(table: Array, shape: tuple[int, ...]) -> tuple[Array, Array, Array, Whole, Whole]:
    """The five rows in this shape, for reading only."""
    value, lower, upper = read_only(table[:3].reshape(3, *shape))
    whole = unwritable(table[3:].astype(np.int64).reshape(2, *shape))
    return value, lower, upper, whole[0], whole[1]


def _bounds(family: ParametricLift, parameters: Array, tolerance: float, workers: int) -> Array:
    """(2, m): the best p/n below and above each rotation number, once they are near enough or after
    1/tolerance cycles.
    """
    size = parameters.shape[1]
    bounds = np.empty((2, size))
    # After n cycles two orbits bound ρ to 2/n: a little more than 1/tolerance are always enough.
    most = int(np.floor(1.0 / tolerance)) + 2
    looks = [look for look in _LOOKS if look < most]
    looks += [*range(2 * _LOOKS[-1], most, _LOOKS[-1]), most]
    # A little less, so that rounding outward keeps to the tolerance.
    width = 2.0 * tolerance * (1.0 - 1e-9)

    def advance(at: int) -> None:
        """Go on through the looks with one chunk of the maps,
        writing the bounds to their places."""
        orbits = _begun(family, parameters[:, at : at + _CHUNK], at)
        for look in looks:
            orbits.run_to(look)
            for longest, beside in [trial[1:] for trial in _TRIALS if trial[0] == look]:
                orbits.try_locking(width, longest, beside)
            for everywhere, here in zip(bounds, orbits.bounds, strict=True):
                everywhere[orbits.place] = here
            orbits = orbits.those(np.diff(orbits.bounds, axis=0)[0] > width)
            if orbits.place.size == 0:
                break

    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(advance, range(0, size, _CHUNK)))
    if np.any(bounds[0] > bounds[1]):
        raise ConvergenceError(
            "bounds contradict each other: the lift is computed worse than its max_error says"
        )
    return bounds


@dataclass
class _Orbits:
    """Maps still at work, m of them: the orbit of F - e (row 0) and of F + e (row 1), and their
    bounds so far.

    parameters : shape (k, m); place (m,) : index among all maps.
    push (∓e), theta (in [-π, π], where sines are quickest, -π at the start), turns (whole turns so
        far, one more in row 1), bounds : shape (2, m).
    cycles : iterates done.
    """

    family: ParametricLift
    parameters: Array
    place: Whole
    push: Array
    theta: Array
    turns: Array
    bounds: Array
    cycles: int = 0

    def those(self, which: Mask) -> _Orbits:
        """Copies of the maps where ``which`` is true."""
        index = np.flatnonzero(which)
        names = "parameters", "place", "push", "theta", "turns", "bounds"
        return replace(self, **{name: getattr(self, name).take(index, axis=-1) for name in names})

    def run_to(self, count: int, start: Array | None = None) -> None:
        """Go on to the iterate of that number; ``start`` : where the orbits began, (2, m) in [-π,
        π], None for -π.
        """
        laps = np.empty_like(self.theta)
        lower, upper = self.bounds
        while self.cycles < count:
            self.cycles += 1
            np.add(self.family.lift(self.theta, *self.parameters), self.push, out=self.theta)
            np.multiply(self.theta, 1.0 / TWO_PI, out=laps)
            np.rint(laps, out=laps)
            self.turns += laps
            laps *= TWO_PI
            self.theta -= laps
            whole = self.turns if start is None else self.turns - (self.theta < start)
            np.divide(whole, self.cycles, out=laps)
            np.maximum(lower, laps[0], out=lower)
            np.minimum(upper, laps[1], out=upper)

    def try_locking(self, width: float, longest: int, beside: float) -> None:
        """For maps with some p/q, q ≤ ``longest``, in too wide bounds: orbits that start beside the
        present angles.
        """
        lower, upper = self.bounds
        period = _simplest_periods(lower, upper, longest)
        open_still = (upper - lower > width) & (period > 0)
        trial = self.those(open_still)
        start = trial.theta + beside / period[open_still] * _SIDES
        start -= TWO_PI * np.rint(start / TWO_PI)
        trial.theta = start.copy()
        trial.turns = _ONE_MORE + np.zeros_like(start)
        trial.cycles = 0
        trial.run_to(longest, start)
        self.bounds[:, open_still] = trial.bounds


def _begun(family: ParametricLift, parameters: Array, first: int) -> _Orbits:
    """The orbits of θ = -π before the first cycle, and the check that these are nondecreasing
    lifts.
    """
    size = parameters.shape[1]
    ends = formula_values("lift", family.lift, read_only([[0.0], [TWO_PI]]), *parameters)
    gap = np.abs(ends[1] - ends[0] - TWO_PI)
    bad = ~(gap <= 1e-8 * (1.0 + np.abs(ends[0]))) | ~family.rises(*parameters)
    if np.any(bad):
        given = ", ".join(f"{value:.9g}" for value in parameters[:, np.argmax(bad)])
        raise InvalidInput(
            f"at parameters ({given}) the map is no nondecreasing lift of degree 1: a folded one "
            "has an interval of rotation numbers; ask rotation_interval(family(...)), or "
            "rotation_plane for many"
        )
    push = _SIDES * (family.max_error + LIFT * (2.0 * TWO_PI + np.abs(ends[0])))
    nothing = np.zeros((2, size))
    return _Orbits(
        family,
        parameters,
        place=np.arange(first, first + size),
        push=push,
        theta=nothing - np.pi,
        turns=nothing + _ONE_MORE,
        bounds=nothing + _SIDES * np.inf,
    )


def _simplest_periods(lower: Array, upper: Array, longest: int) -> Whole:
    """The least q ≤ longest with some p/q in [lower, upper], else 0."""
    period = np.zeros(lower.shape, dtype=np.int64)
    left = np.flatnonzero(lower <= upper)
    low = lower[left] - 1e-12
    high = upper[left] + 1e-12
    for q in range(1, longest + 1):
        if left.size == 0:
            break
        hit = np.ceil(low * q) <= high * q
        period[left[hit]] = q
        miss = np.flatnonzero(~hit)
        left = left.take(miss)
        low = low.take(miss)
        high = high.take(miss)
    return period


@dataclass(frozen=True, eq=False)
class RotationPlane:
    """Rotation numbers over a grid of parameters, turns a cycle; arrays of shape (m, n).

    Attributes
    ----------
    first_values : ndarray, shape (m,)
        The parameters of rows.
    second_values : ndarray, shape (n,)
        The parameters of columns.
    value : ndarray
        The middle of [lower, upper], or what ``rotation_number`` gives for a map done by
        itself; where the lift folds, the weighted Birkhoff average of the one orbit from θ = 0,
        or the middle where that has not gone round.
    lower, upper : ndarray
        The truth lies between them; where the lift folds, all of its rotation interval does.
    period, winding : ndarray of int
        q and p where ρ = p/q is proved for every orbit, else 0 and 0.
    folded : ndarray of bool
        Where the lift falls.
    tolerance : float
        The half-width that was asked for where the lift does not fold.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, rotation_plane
    >>> plane = rotation_plane(CircleMap.arnold, [0.0, 0.5], [0.3, 0.9])
    >>> plane.value.round(3).tolist(), bool(plane.folded.any())
    ([[0.0, 0.0], [0.5, 0.5]], False)
    """

    first_values: Array
    second_values: Array
    value: Array
    lower: Array
    upper: Array
    period: Whole
    winding: Whole
    folded: Mask
    tolerance: float


def rotation_plane(
    family: Family,
    first_values: ArrayLike,
    second_values: ArrayLike,
    tolerance: float = 1e-3,
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> RotationPlane:
    """The rotation number of ``family(first, second)`` at every pair of the two axes.

    Parameters
    ----------
    family : callable
        Any callable of two numbers that gives a CircleMap of degree 1; a ``ParametricLift``,
        ``CircleMap.arnold`` and ``CircleMap.moebius`` are done many maps at once where they do
        not fold (``rotation_numbers``). All else goes map by map (``rotation_number``), some
        milliseconds each.
    first_values : array_like, shape (m,)
        Strictly increasing or decreasing.
    second_values : array_like, shape (n,)
        Strictly increasing or decreasing.
    tolerance : float, default 0.001
        Turns a cycle, in (0, 0.1]: the wanted half-width of the enclosures where the lift does
        not fold; one that is wider shows it by its ``lower`` and ``upper``.
    progress : callable or None, optional
        Called with the fraction done of what goes map by map.
    executor : Executor or None, optional
        Of threads, processes, or a cluster (``distributed.Client.get_executor()``), on which
        what goes map by map is run; the family must then be one that can be pickled.

    Returns
    -------
    RotationPlane
        Arrays of shape (m, n).

    Raises
    ------
    InvalidInput
        For axes that are empty, not finite or not monotone, and for a map that is no CircleMap
        of degree 1.

    Notes
    -----
    Inside the tongue p/q of the plane (Arnold 1965) ``period`` is q.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, rotation_plane
    >>> plane = rotation_plane(CircleMap.arnold, [0.0, 0.5], [0.3, 0.9])
    >>> plane.period.tolist(), plane.winding.tolist()
    ([[1, 1], [2, 2]], [[0, 0], [1, 1]])
    """
    first = _axis("first_values", first_values)
    second = _axis("second_values", second_values)
    wanted = _wanted(tolerance)
    places = np.array([np.repeat(first, second.size), np.tile(second, first.size)])
    table = np.zeros((6, places.shape[1]))
    singly = np.ones(places.shape[1], dtype=bool)
    formula = parametric_form(family)
    if formula is not None:
        require_parameters(formula, 2)
        singly = ~formula.rises(*places)
        bounds = _bounds(formula, places[:, ~singly], wanted, _WORKERS)
        table[:5, ~singly] = _judged(bounds, wanted)
    work = partial(_cell, family, wanted)
    cells = list(each_done(work, places[:, singly].T.tolist(), executor, progress, 16))
    table[:, singly] = np.reshape(cells, (-1, 6)).T
    shape = (first.size, second.size)
    folded = table[5].reshape(shape) > 0.0
    numbers = _in_shape(table[:5], shape)
    return RotationPlane(read_only(first), read_only(second), *numbers, unwritable(folded), wanted)


def _cell(family: Family, tolerance: float, place: list[float]) -> tuple[float, ...]:
    """Value, lower, upper, period and winding of one map, and whether it folds."""
    member = family_member(family, *place)
    iterates = max(16, int(np.ceil(1.0 / tolerance)))
    known = rotation_number(member, iterates=iterates, tolerance=tolerance)
    locked = known.locked
    period, winding = (0, 0) if locked is None else (locked.denominator, locked.numerator)
    folds = not is_nondecreasing(member)
    return known.value, known.lower, known.upper, period, winding, folds


def _axis(name: str, values: ArrayLike) -> Array:
    axis = finite_array(name, values, ndim=1)
    if axis.size == 0:
        raise InvalidInput(f"{name} is empty: give at least one value")
    steps = np.diff(axis)
    if not (np.all(steps > 0.0) or np.all(steps < 0.0)):
        turned = int(np.argmax(steps * np.sign(axis[-1] - axis[0]) <= 0.0))
        raise InvalidInput(
            f"{name} turns back after {axis[turned]:g}: give increasing or decreasing values, "
            "each once"
        )
    return axis
