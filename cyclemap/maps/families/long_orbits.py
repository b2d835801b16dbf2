"""What long orbits show: where they settle, and whether neighbouring ones diverge."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, Whole, shorter_way
from cyclemap.checks import (
    finite_array,
    finite_number,
    read_only,
    require_room,
    whole_number,
)
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import EPS, Estimate
from cyclemap.maps.families.family import (
    Family,
    ParametricFunction,
    each_done,
    family_member,
    parametric_form,
)
from cyclemap.maps.lifts.circle_map import CircleMap, require_map
from cyclemap.maps.noise import Noise
from cyclemap.maps.orbits.rotation_number import orbit_angles, orbits_angles, weighted_mean
from cyclemap.maps.quadrature import arc_rule
from cyclemap.progress import Progress

_START = 0.9  # radians: an angle that no symmetry favours
_PARTS = 20
_DEVIATIONS = 4.0  # standard errors of the batches' mean


@dataclass(frozen=True, eq=False)
class OrbitDiagram:
    """Where the orbits of a family are after a transient; made by ``orbit_diagram``.

    Attributes
    ----------
    parameter : ndarray, shape (m,)
        In the order in which they were gone through.
    theta : ndarray, shape (m, cycles)
        Radians in [0, 2π).

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, orbit_diagram
    >>> diagram = orbit_diagram(lambda K: CircleMap.arnold(0.1, K), [0.5, 0.9], cycles=10)
    >>> diagram.theta.shape
    (2, 10)
    """

    parameter: Array
    theta: Array


@dataclass(frozen=True, eq=False)
class LyapunovExponents:
    """Made by ``lyapunov_exponents``: arrays of the parameters' broadcast shape.

    Attributes
    ----------
    parameters : tuple of ndarray
        As they were given; they broadcast to the shape of the others.
    value : ndarray
        Mean of ln|F'| along one orbit, per cycle; -inf where it meets F' = 0.
    error : ndarray
        Four standard errors of the means over 20 parts of the orbit: statistical where it is
        chaotic, and no bound.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, lyapunov_exponents
    >>> lyapunov_exponents(CircleMap.arnold, 0.1, [0.7, 0.9]).value.shape
    (2,)
    """

    parameters: tuple[Array, ...]
    value: Array
    error: Array


def orbit_diagram(
    family: Family,
    values: ArrayLike,
    *,
    cycles: int = 200,
    transient: int = 500,
    start: float = _START,
) -> OrbitDiagram:
    """Where the orbit of each member of a family is, after cycles that are left out.

    Parameters
    ----------
    family : callable
        Parameter → CircleMap.
    values : array_like, shape (m,)
        In the order in which they are gone through: each orbit starts where the one before has
        ended, so that an attractor is followed for as long as it lasts; through the values in
        reverse order the other branch of a hysteresis loop shows.
    cycles : int, default 200
        How many cycles are kept.
    transient : int, default 500
        How many are left out before.
    start : float, optional
        Where the first orbit starts, radians.

    Returns
    -------
    OrbitDiagram
        The angles of every orbit.

    Raises
    ------
    InvalidInput
        For values that are not finite, none at all, or a family that gives no CircleMap.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import CircleMap, orbit_diagram
    >>> flips = orbit_diagram(lambda K: CircleMap.arnold(0.1, K), [1.8, 2.2], transient=2000)
    >>> [np.unique(row.round(6)).size for row in flips.theta]  # the period doubles at K = 2.0964
    [1, 2]
    """
    rows = finite_array("values", values, ndim=1)
    count = whole_number("cycles", cycles, least=1)
    skipped = whole_number("transient", transient, least=0)
    theta = finite_number("start", start)
    if rows.size == 0:
        raise InvalidInput("values is empty: give the parameters to go through")
    require_room("the diagram", rows.size * count, "give fewer values or cycles")
    visited = np.empty((rows.size, count))
    for row, value in zip(visited, rows.tolist(), strict=True):
        row[:] = orbit_angles(family_member(family, value), theta, skipped + count)[skipped:]
        theta = float(row[-1])
    return OrbitDiagram(read_only(rows), read_only(visited))


def lyapunov_exponents(
    family: Callable[..., CircleMap],
    *parameters: ArrayLike,
    cycles: int = 2_000,
    transient: int = 500,
    start: float = _START,
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> LyapunovExponents:
    """The Lyapunov exponents of orbits from one angle, over arrays of parameters.

    Parameters
    ----------
    family : callable
        Parameters → CircleMap. A ``ParametricLift`` that has a derivative, ``CircleMap.arnold``
        and ``CircleMap.moebius`` are followed all together, others one by one, a hundred times
        slower.
    *parameters : array_like
        Numbers or arrays that broadcast together.
    cycles : int, default 2000
        How many cycles the mean is taken over.
    transient : int, default 500
        How many are left out before.
    start : float, optional
        Where the orbits start, radians.
    progress : callable or None, optional
        Called with the fraction done of what goes one by one.
    executor : Executor or None, optional
        As of ``rotation_plane``; of what goes one by one.

    Returns
    -------
    LyapunovExponents
        Arrays of the parameters' broadcast shape.

    Raises
    ------
    InvalidInput
        For parameters that are not finite, none at all, or a family that gives no CircleMap.

    Notes
    -----
    The mean of ln|F'|, good to about 1/cycles on periodic orbits; ``lyapunov_exponent`` solves one
    map's far better.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, lyapunov_exponents
    >>> found = lyapunov_exponents(CircleMap.arnold, 0.1, [0.9, 5.0])
    >>> bool(found.value[0] < -1.0 < 1.0 < found.value[1])
    True
    """
    if not parameters:
        raise InvalidInput("parameters are missing: give an array for each parameter of the family")
    arrays = [finite_array(f"parameter {i}", values) for i, values in enumerate(parameters)]
    count = whole_number("cycles", cycles, least=_PARTS)
    skipped = whole_number("transient", transient, least=0)
    theta = finite_number("start", start)
    shape = np.broadcast_shapes(*(array.shape for array in arrays))
    flat = [np.broadcast_to(array, shape).ravel() for array in arrays]
    formula = parametric_form(family)
    lengths = np.diff(np.linspace(0, count, _PARTS + 1).astype(int))
    if formula is not None and formula.derivative is not None:
        sums = _sums_together(formula.lift, formula.derivative, flat, theta, skipped, lengths)
    else:
        rows = list(zip(*(array.tolist() for array in flat), strict=True))
        work = partial(_sums, family, theta, skipped, lengths)
        sums = np.array(list(each_done(work, rows, executor, progress, 16))).T
    value = sums.sum(axis=0) / count
    with np.errstate(invalid="ignore"):
        spread = np.std(sums / lengths[:, None], axis=0, ddof=1)
    error = np.where(np.isneginf(value), 0.0, _DEVIATIONS * spread / np.sqrt(_PARTS))
    return LyapunovExponents(
        tuple(read_only(array) for array in arrays),
        read_only(value.reshape(shape)),
        read_only(error.reshape(shape)),
    )


def _sums_together(
    lift: ParametricFunction,
    derivative: ParametricFunction,
    parameters: list[Array],
    start: float,
    skipped: int,
    lengths: Whole,
) -> Array:
    """(parts, m): the sum of ln|F'| over each part of many orbits."""
    angle = np.full(parameters[0].size, start)
    for _ in range(skipped):
        angle = np.mod(lift(angle, *parameters), TWO_PI)
    sums = np.zeros((lengths.size, angle.size))
    for row in np.repeat(np.arange(lengths.size), lengths).tolist():
        sums[row] += _log(derivative(angle, *parameters))
        angle = np.mod(lift(angle, *parameters), TWO_PI)
    return sums


def _sums(
    family: Family, start: float, skipped: int, lengths: Whole, parameters: tuple[float, ...]
) -> Array:
    """(parts,): the same of one orbit."""
    member = family_member(family, *parameters)
    visited = orbit_angles(member, start, skipped + int(lengths.sum()))[skipped:]
    logs = _log(member.derivative(visited))
    return np.add.reduceat(logs, np.cumsum(lengths) - lengths)


def _log(slope: Array) -> Array:
    with np.errstate(divide="ignore"):
        return np.log(np.abs(slope))


ITERATES = 40_000
MAX_PERIOD = 512
TRANSIENT = 2_000
_STARTS = TWO_PI * np.mod(0.1 + np.sqrt(2.0) * np.arange(1.0, 6.0), 1.0)
_SAME = 1e-6  # exponents that differ by less, their bounds apart, belong to one attractor
_NEAR = 0.05  # radians: an orbit that comes back nearer than this may be close to a periodic one
_NEWTON = 30
_BATCHES = 40
_DECIDED = 0.05  # a weighted mean this much sharper than a plain one shows a quasi-periodic orbit
_FLOOR = 1e-18  # |F'| at nodes that rounding puts on a fold
_EVERYWHERE = TWO_PI * np.mod(np.sqrt(2.0) * np.arange(1.0, 65.0), 1.0)
_LOST = 0.05  # of 1 + |F'|: an error this large says that differences do not settle
_BLUR = 50.0  # how far off ln|F'| is where F' is lost in rounding


def lyapunov_exponent(
    circle_map: CircleMap,
    noise: Noise | None = None,
    *,
    start: float | None = None,
    transient: int = TRANSIENT,
) -> Estimate:
    """The Lyapunov exponent E ln|F'(θ)|, per cycle (natural logarithm), with a bound on its error.

    Parameters
    ----------
    circle_map : CircleMap
        The map.
    noise : Noise or None, optional
        What is added to every cycle; None: none.
    start : float or None, optional
        Without noise, where the orbit starts, radians; None: the orbits from five angles that
        no symmetry favours, so that none lies on a repelling orbit; a small basin may be
        missed.
    transient : int, optional
        Cycles that are left out before.

    Returns
    -------
    Estimate
        Per cycle; -inf where F' = 0 on a set that the law or the orbit visits.

    Raises
    ------
    InvalidInput
        Where orbits from those angles have different exponents: the map has several attractors.
    ConvergenceError
        Where F has no derivative that differences can follow.

    Notes
    -----
    With noise: the integral over the stationary law, on panels graded towards the folds; the bound
    is that of ``TransferOperator.expectation`` (``max_error`` counts through the law only) and the
    error of F'. Without noise, for the orbit of ``start`` after ``transient`` cycles:

    - where that settles on a periodic orbit of period n ≤ 512, ln|multiplier|/n of the orbit
      itself, solved by Newton's method; the bound is a measured one of rounding;
    - where it is quasi-periodic, the weighted Birkhoff average, with the estimated error of
      ``birkhoff_average``;
    - where it is chaotic, the plain mean over 40,000 cycles and four standard errors from the means
      of 40 batches: a statistical bound, and it is about 1e-2.

    To each the error of F' adds (``derivative_and_error``); inf where F' is lost in it.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CircleMap, WrappedNormal, lyapunov_exponent
    >>> round(lyapunov_exponent(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.1 * np.pi)), 9)
    -0.978129142
    """
    require_map(circle_map)
    skipped = whole_number("transient", transient, least=0)
    # Refused before thousands of iterates are made: a lift that is nowhere smooth.
    slope, error = circle_map.derivative_and_error(_EVERYWHERE)
    lost = error > _LOST * (1.0 + np.abs(slope))
    if 2 * np.count_nonzero(lost) > lost.size:
        raise ConvergenceError(
            f"F' cannot be told from differences at {np.count_nonzero(lost)} of {lost.size} "
            f"angles, such as {_EVERYWHERE[int(np.argmax(lost))]:.6g}: give the derivative, or the "
            "lift has none and no exponent"
        )
    if noise is not None:
        if start is not None:
            raise InvalidInput(
                f"start is {start!r}, but under noise the exponent is of the stationary law: "
                "leave it out"
            )
        return _under_noise(circle_map, noise)
    begin = _STARTS if start is None else np.array([finite_number("start", start)])
    visited = orbits_angles(circle_map, begin, skipped + ITERATES)[:, skipped:]
    exponents = [_along_orbit(circle_map, row) for row in visited]
    low, high = (int(pick(exponents)) for pick in (np.argmin, np.argmax))
    least = exponents[low]
    most = exponents[high]
    allowed = _SAME + 4.0 * (least.error_bound + most.error_bound)
    if least != most and most - least > allowed:
        raise InvalidInput(
            f"the map has several attractors: the exponent is {least:.6g} from θ = "
            f"{_STARTS[low]:.4f}, {most:.6g} from {_STARTS[high]:.4f}; give the start that is meant"
        )
    return min(exponents, key=lambda exponent: exponent.error_bound)


def _under_noise(circle_map: CircleMap, noise: Noise) -> Estimate:
    from cyclemap.maps.operator.transfer_operator import transfer_operator  # slow to import

    operator = transfer_operator(circle_map, noise)
    theta, _ = arc_rule(circle_map, 0.0, TWO_PI, operator.modes)
    flat = circle_map.derivative(theta) == 0.0
    if np.any(flat & np.roll(flat, 1)):  # neighbouring nodes: a flat piece, not a fold
        return Estimate(float("-inf"), 0.0)

    def blur(at: Array) -> Array:
        slope, error = circle_map.derivative_and_error(at)
        return np.minimum(error / np.maximum(np.abs(slope), _FLOOR), _BLUR)

    mean = operator.expectation(
        lambda at: np.log(np.maximum(np.abs(circle_map.derivative(at)), _FLOOR)), folds=True
    )
    blurred = operator.expectation(blur, folds=True)
    return Estimate(mean, mean.error_bound + blurred.upper)


def _along_orbit(circle_map: CircleMap, visited: Array) -> Estimate:
    last = visited[-1]
    back = np.abs(shorter_way(visited[-2 : -2 - MAX_PERIOD : -1] - last))
    for period in 1 + np.flatnonzero((back <= np.minimum.accumulate(back)) & (back < _NEAR)):
        orbit = _attracting_orbit(circle_map, float(last), int(period))
        if orbit is not None:
            return _exponent_of(circle_map, orbit)
    slopes, errors = circle_map.derivative_and_error(visited)
    stretch = np.abs(slopes)
    if np.any(stretch == 0.0):
        return Estimate(float("-inf"), 0.0)
    values = np.log(stretch)
    inexact = _from_slopes(errors, stretch)
    smooth = weighted_mean(values)
    means = values.reshape(_BATCHES, -1).mean(axis=1)
    spread = float(np.std(means, ddof=1)) / np.sqrt(_BATCHES)
    if smooth.error_bound <= _DECIDED * spread or spread <= EPS * (1.0 + abs(smooth)):
        return Estimate(smooth, smooth.error_bound + inexact)
    return Estimate(float(np.mean(values)), _DEVIATIONS * spread + inexact)


def _from_slopes(errors: Array, stretch: Array) -> float:
    """What the errors of F' make of the mean of ln|F'|; inf where F' may be zero."""
    share = errors / stretch
    return float(-np.mean(np.log1p(-share))) if np.all(share < 1.0) else float("inf")


def _attracting_orbit(circle_map: CircleMap, start: float, period: int) -> Array | None:
    """The points of the period's orbit nearest to ``start``, by Newton's method, if it attracts
    ``start``.
    """
    theta = start
    for _ in range(_NEWTON):
        visited = orbit_angles(circle_map, theta, period + 1)
        multiplier = float(np.prod(circle_map.derivative(visited[:-1])))
        if abs(multiplier) >= 1.0:
            return None
        step = float(shorter_way(visited[-1] - theta)) / (1.0 - multiplier)
        theta += step
        if abs(step) <= 4.0 * EPS * (1.0 + abs(theta)) / (1.0 - abs(multiplier)):
            near = abs(theta - start) < _NEAR
            return orbit_angles(circle_map, theta, period) if near else None
    return None


def _exponent_of(circle_map: CircleMap, points: Array) -> Estimate:
    slopes, errors = circle_map.derivative_and_error(points)
    slopes = np.abs(slopes)
    if np.any(slopes == 0.0):
        return Estimate(float("-inf"), 0.0)
    exponent = float(np.mean(np.log(slopes)))
    # The orbit is known to rounding over 1 - |multiplier|: what so small a shift changes is the
    # bound.
    gap = 1.0 - min(float(np.prod(slopes)), 1.0 - EPS)
    shift = 16.0 * EPS * (1.0 + np.max(np.abs(points))) / gap
    nearby = [np.abs(circle_map.derivative(points + side * 1e3 * shift)) for side in (-1.0, 1.0)]
    with np.errstate(divide="ignore"):
        changes = np.mean(np.abs(np.log(nearby) - np.log(slopes)), axis=1)
    moved = float(np.max(changes)) / 1e3
    rounding = 8.0 * EPS * (1.0 + abs(exponent))
    return Estimate(exponent, moved + _from_slopes(errors, slopes) + rounding)
