"""What long orbits show: where those of a family settle, whether neighbouring ones diverge, and how
much of an error the last cycles of a path keep.
"""

from __future__ import annotations

import math
from concurrent.futures import Executor
from dataclasses import dataclass, field
from functools import lru_cache, partial

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
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import ANGLE
from cyclemap.maps.families.family import (
    Family,
    ParametricFunction,
    broadcast_parameters,
    each_done,
    family_member,
    formula_values,
    parametric_form,
    require_parameters,
)
from cyclemap.maps.orbits.orbit_means import DEVIATIONS, orbit_angles
from cyclemap.progress import Progress
from cyclemap.written import DIRECTION

_START = 0.9  # radians: an angle that no symmetry favours
_PARTS = 20


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
    family: Family,
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
    arrays, shape, flat = broadcast_parameters(parameters)
    count = whole_number("cycles", cycles, least=_PARTS)
    skipped = whole_number("transient", transient, least=0)
    require_room("each orbit", skipped + count, "follow it for fewer cycles")
    theta = finite_number("start", start)
    formula = parametric_form(family)
    lengths = np.diff(np.linspace(0, count, _PARTS + 1).astype(int))
    if formula is not None:
        require_parameters(formula, len(parameters))
    if formula is not None and formula.derivative is not None:
        sums = _sums_together(formula.lift, formula.derivative, flat, theta, skipped, lengths)
    else:
        work = partial(_sums, family, theta, skipped, lengths)
        rows = each_done(work, flat.T.tolist(), executor, progress, 16)
        sums = np.array(list(rows)).T
    value = sums.sum(axis=0) / count
    with np.errstate(invalid="ignore"):
        spread = np.std(sums / lengths[:, None], axis=0, ddof=1)
    error = np.where(np.isneginf(value), 0.0, DEVIATIONS * spread / np.sqrt(_PARTS))
    return LyapunovExponents(
        tuple(read_only(array) for array in arrays),
        read_only(value.reshape(shape)),
        read_only(error.reshape(shape)),
    )


def _sums_together(
    lift: ParametricFunction,
    derivative: ParametricFunction,
    parameters: Array,
    start: float,
    skipped: int,
    lengths: Whole,
) -> Array:
    """(parts, m): the sum of ln|F'| over each part of many orbits."""
    angle = read_only(np.full(parameters.shape[1], start))
    for name, function in (("lift", lift), ("derivative", derivative)):
        formula_values(name, function, angle, *parameters)
    for _ in range(skipped):
        angle = np.mod(lift(angle, *parameters), TWO_PI)
    sums = np.zeros((lengths.size, angle.size))
    for row in np.repeat(np.arange(lengths.size), lengths).tolist():
        sums[row] += _log(derivative(angle, *parameters))
        angle = np.mod(lift(angle, *parameters), TWO_PI)
    wrong = ~np.isfinite(angle) | np.isnan(sums.sum(axis=0))
    if np.any(wrong):
        given = ", ".join(f"{value:.9g}" for value in parameters[:, np.argmax(wrong)])
        raise InvalidInput(
            f"at parameters ({given}) the lift or its derivative gives nan or inf: both must be "
            "finite everywhere"
        )
    return sums


def _sums(
    family: Family, start: float, skipped: int, lengths: Whole, parameters: list[float]
) -> Array:
    """(parts,): the same of one orbit."""
    member = family_member(family, *parameters)
    visited = orbit_angles(member, start, skipped + int(lengths.sum()))[skipped:]
    logs = _log(member.derivative(visited))
    return np.add.reduceat(logs, np.cumsum(lengths) - lengths)


def _log(slope: Array) -> Array:
    with np.errstate(divide="ignore"):
        return np.log(np.abs(slope))


LAST = 100
_LEAST = 20
_RESTS = np.pi / 2  # radians: a path that spreads over more does not rest
# Standard deviations of the way that kicks alone go; a path that goes farther is still on its way.
_DRIFTS = 2.0
# multipliers that are tried
_GRID = np.append(np.linspace(-0.95, 0.95, 77), [0.97, 0.98, 0.99, 1.0])
_PATHS = 2_000
_SEED = 1
_LEVEL = 0.95


@dataclass(frozen=True)
class RestMultiplier:
    """The multiplier of the direction about which a path rests.

    Attributes
    ----------
    value : float
        Median-unbiased estimate.
    lower, upper : float
        95 % interval, in [-1, 1]: at 1 the direction is being lost, or has been.
    cycles : int
        How many it comes from: the last ones that rest.
    theta : float
        Their mean direction, radians in [0, 2π).

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import rest_multiplier
    >>> rng, path = np.random.default_rng(0), [0.0]
    >>> for kick in rng.normal(0.0, 0.02, 60):
    ...     path.append(0.5 * path[-1] + kick)
    >>> rest = rest_multiplier(path)
    >>> rest.lower < rest.value < rest.upper < 1.0
    True
    """

    value: float
    lower: float
    upper: float
    cycles: int
    theta: float = field(metadata=DIRECTION)


def rest_multiplier(theta: ArrayLike, last: int = LAST) -> RestMultiplier | None:
    """The multiplier of the direction about which the last cycles of a path rest, with its
    interval.

    Parameters
    ----------
    theta : array_like, shape (n,)
        Radians, on the lift or not.
    last : int, optional
        How many cycles are looked at, 20 or more.

    Returns
    -------
    RestMultiplier or None
        None where the cycles do not rest, and where there are fewer than 20. They rest where
        they spread over less than a quarter of a turn about their mean, and end no farther from
        where they began than kicks alone would take them (two standard deviations); a spread of
        1e-13 rad is rounding. Where the last ``last`` do not, the last half of them may, and so
        on, down to 20: what came before was the way to the rest.

    Raises
    ------
    InvalidInput
        For angles that are not finite, and fewer than 20 ``last`` cycles.

    Notes
    -----
    Beside a stable point θ' = θ* + λ(θ - θ*) + ξ: the regression of each angle on the one before
    falls short of λ by some (1 + 3λ)/n (Kendall 1954), and its distribution is skew as λ nears 1,
    so that interval and value come from the λ for which the regression seen is no rarer than 2.5 %
    on either side, and its median (Andrews 1993), by 2,000 simulated paths for each of 81 λ from
    -0.95 to 1 and lines between. Normal kicks are taken that do not depend on the past, and a map
    that does not bend over the rest.

    References
    ----------
    - Kendall, M. G. (1954), Note on bias in the estimation of autocorrelation, Biometrika 41.
    - Andrews, D. W. K. (1993), Exactly median-unbiased estimation of first order
      autoregressive/unit root models, Econometrica 61.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import rest_multiplier
    >>> rng = np.random.default_rng(0)
    >>> path = [0.0]
    >>> for kick in rng.normal(0.0, 0.02, 200):
    ...     path.append(0.8 * path[-1] + kick)
    >>> found = rest_multiplier(path)
    >>> found.lower < 0.8 < found.upper
    True
    """
    path = finite_array("theta", theta, ndim=1)
    count = whole_number("last", last, least=_LEAST)
    if path.size < _LEAST + 1:
        return None
    path = path[-count - 1 :]
    require_room("the simulated paths", _PATHS * path.size, "give a smaller last")
    middle, away = _about_middle(path)
    while not _rests(away):
        if path.size == _LEAST + 1:
            return None
        path = path[-max(path.size // 2, _LEAST) - 1 :]
        middle, away = _about_middle(path)
    seen = float(_regression(away[None])[0])
    below, median, above = _quantiles(path.size)
    value, lower, upper = (float(np.interp(seen, row, _GRID)) for row in (median, above, below))
    return RestMultiplier(
        value, -1.0 if seen < above[0] else lower, upper, path.size - 1, middle % TWO_PI
    )


def _about_middle(path: Array) -> tuple[float, Array]:
    """The mean direction of a path, and its angles from there, the shorter way round."""
    middle = float(np.angle(np.mean(np.exp(1j * path))))
    return middle, shorter_way(path - middle)


def _rests(away: Array) -> bool:
    """Whether a path about its middle neither spreads widely nor goes from one side to the other.

    Of paths with λ = 1 one in twenty ends beyond the limit, with λ < 1 fewer.
    """
    if not ANGLE < np.ptp(away) < _RESTS:
        return False
    before = away[:-1] - away[:-1].mean()
    after = away[1:] - away[1:].mean()
    kicks = after - float(_regression(away[None])[0]) * before
    kick = math.sqrt(float(np.sum(kicks**2)) / (kicks.size - 2))
    return abs(float(away[-1] - away[0])) <= _DRIFTS * kick * math.sqrt(kicks.size)


def _regression(paths: Array) -> Array:
    """The slope of each angle on the one before, of paths (k, n)."""
    before = paths[:, :-1] - paths[:, :-1].mean(axis=1, keepdims=True)
    return np.asarray(np.sum(before * paths[:, 1:], axis=1) / np.sum(before**2, axis=1))


@lru_cache(maxsize=8)
def _quantiles(size: int) -> Array:
    """(3, 81): quantiles 2.5 %, 50 % and 97.5 % of the regression for each λ,
    made to rise with it."""
    rng = np.random.default_rng(_SEED)
    rows = []
    kicks = rng.standard_normal((_PATHS, size))  # the same for every λ, so that lines are smooth
    for multiplier in _GRID.tolist():
        paths = kicks.copy()
        if multiplier < 1.0:
            paths[:, 0] /= np.sqrt(1.0 - multiplier**2)
        for n in range(1, size):
            paths[:, n] += multiplier * paths[:, n - 1]
        rows.append(np.quantile(_regression(paths), [0.5 - 0.5 * _LEVEL, 0.5, 0.5 + 0.5 * _LEVEL]))
    return np.maximum.accumulate(np.array(rows).T, axis=1)
