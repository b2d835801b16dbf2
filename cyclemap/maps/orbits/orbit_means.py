"""What one long orbit tells: means of a function along it, and whether its neighbours diverge."""

from __future__ import annotations

from math import floor

import numpy as np

from cyclemap.arrays import TWO_PI, Array, shorter_way
from cyclemap.checks import finite_array, finite_number, require_room, whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import ANGLE, EPS, LIFT, MEAN, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap, require_degree_one, require_map
from cyclemap.maps.lifts.lift_checks import Lift, within_turn
from cyclemap.maps.lifts.map_algebra import slope_and_error_beside
from cyclemap.maps.noise import Noise
from cyclemap.maps.quadrature import arc_rule

ITERATES = 40_000


def birkhoff_average(
    circle_map: CircleMap,
    function: Lift | None = None,
    *,
    start: float = 0.0,
    iterates: int = ITERATES,
    transient: int = 0,
) -> Estimate:
    """The weighted mean of a function along one orbit.

    Parameters
    ----------
    circle_map : CircleMap
        The map.
    function : callable, optional
        Vectorised, of angles in [0, 2π) (radians); None averages the turn F(θ) - θ, radians a
        cycle, which needs degree 1. -inf is allowed as a value and makes the mean -inf.
    start : float, default 0.0
        Where the orbit starts, radians.
    iterates : int, optional
        N, at least 16.
    transient : int, default 0
        Cycles run before the averaging begins.

    Returns
    -------
    Estimate
        The mean, with an estimated bound.

    Notes
    -----
    The weights are exp(-1/t(1 - t)), t = k/(N + 1), k = 1..N. On a quasi-periodic orbit with
    Diophantine rotation number of a smooth map the error falls faster than any power of 1/N; a
    plain mean has 1/N. On a chaotic orbit it is about that of a plain mean, 1/√N.

    The error bound is estimated, not proved: the largest distance from the means over the first and
    the last half of the orbit, and over its first and last five twelfths, which converge like the
    whole at such a length, plus rounding. Where qρ is whole to less than about 1/N, q up to 64,
    the mean is one over q points, which no part of the orbit shows: it is then bounded by means
    over q cycles from angles all round, among whose extremes the mean of every invariant law lies,
    and by what the weights leave of these. inf where the orbit creeps otherwise, through a
    bottleneck or towards an orbit of multiplier ±1, so that its second half lies nowhere among its
    first: it has not been round once.

    References
    ----------
    Das, S., Saiki, Y., Sander, E. & Yorke, J. A. (2017), Quantitative quasiperiodicity,
    Nonlinearity 30.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import CircleMap, birkhoff_average
    >>> mean = birkhoff_average(CircleMap.moebius(0.5, 0.3))
    >>> abs(mean / (2 * np.pi) - 0.262536755898823346733597549046) < 1e-14, mean.error_bound < 1e-13
    (True, True)
    """
    require_map(circle_map)
    if function is None:
        require_degree_one(circle_map, "a mean turn")
    count = whole_number("iterates", iterates, least=16)
    skipped = whole_number("transient", transient, least=0)
    visited = orbit_angles(circle_map, finite_number("start", start), skipped + count)[skipped:]
    of_angles = function or circle_map.turn
    values = np.asarray(of_angles(visited), dtype=np.float64)
    if values.shape != visited.shape:
        raise InvalidInput(
            f"function turns shape {visited.shape} into {values.shape}: it must act entry by entry"
        )
    mean = weighted_mean(values)
    off = mean.error_bound
    if np.isfinite(mean) and np.ptp(values) > ANGLE * (1.0 + np.max(np.abs(values))):
        unseen = _unseen(circle_map, of_angles, visited, mean)
        if unseen is None:
            unseen = float("inf") if _creeps(visited) else 0.0
        off = max(off, unseen)
    # A turn is told to half a spacing of floats at 2π, whatever its size.
    return Estimate(mean, off if function is not None else off + EPS * np.pi)


def orbit_angles(circle_map: CircleMap, start: float, count: int) -> Array:
    """The first ``count`` angles of the orbit of ``start``, itself included, radians, each within
    [0, 2π).
    """
    return np.asarray(orbits_angles(circle_map, np.array([start]), count)[0])


def orbits_angles(circle_map: CircleMap, starts: Array, count: int) -> Array:
    """The same of several starts, shape (m,): (m, count); together where the lift knows arrays
    only.
    """
    require_room("the orbit", starts.size * count, "follow it for fewer cycles")
    visited = np.empty((starts.size, count))
    if not circle_map.has_scalar:
        theta = starts
        for n in range(count):
            theta, _ = within_turn(theta)
            visited[:, n] = theta
            theta = circle_map(theta)
        return visited
    for row, start in zip(visited, within_turn(starts)[0].tolist(), strict=True):
        orbit = FollowedOrbit(circle_map, start=start)
        orbit.run_to(count - 1)
        row[:] = orbit.visited
    return visited


class FollowedOrbit:
    """The orbit of ``start`` in [0, 2π) under F + push, kept there with its whole turns counted
    apart.
    """

    def __init__(self, circle_map: CircleMap, push: float = 0.0, start: float = 0.0) -> None:
        self._lift = circle_map.scalar()
        self.push = push
        self.visited = [start]
        self.laps = [0]

    def run_to(self, count: int) -> None:
        """Go on to the iterate of that number."""
        lift = self._lift
        push = self.push
        theta = self.visited[-1]
        turns = self.laps[-1]
        for _ in range(count + 1 - len(self.laps)):
            image = lift(theta) + push
            lap = floor(image / TWO_PI)
            theta = image - TWO_PI * lap
            turns += lap
            self.visited.append(theta)
            self.laps.append(turns)


def window(count: int) -> Array:
    """Weights exp(-1/t(1 - t)), t = k/(count + 1), k = 1..count, that sum to 1."""
    t = np.arange(1.0, count + 1.0) / (count + 1.0)
    weight = np.exp(-1.0 / (t * (1.0 - t)))
    return np.asarray(weight / np.sum(weight))


def weighted_mean(values: Array) -> Estimate:
    """The mean of ``values``, shape (n,), n ≥ 16, in the order of time,
    as in ``birkhoff_average``."""
    if np.any(np.isneginf(values)):
        return Estimate(-np.inf, 0.0)
    sequence = finite_array("values", values, ndim=1)
    mean = _windowed(sequence)
    # Two lengths: the error changes its sign with it, and may be next to nothing at one.
    apart = max(
        abs(_windowed(stretch) - mean)
        for size in (sequence.size // 2, 5 * sequence.size // 12)
        for stretch in (sequence[:size], sequence[-size:])
    )
    return Estimate(mean, apart + MEAN * float(np.max(np.abs(sequence))))


def _windowed(values: Array) -> float:
    # Sums of numpy are pairwise: their rounding grows with log n only.
    return float(np.sum(window(values.size) * values))


def _unseen(circle_map: CircleMap, function: Lift, visited: Array, mean: float) -> float | None:
    """How far the mean of a function along an orbit that nearly closes, and drifts on by a few gaps
    between its points, may be from that all round; None for an orbit that does no such thing.

    visited : (n,) rad, n ≥ 16, in the order of time; mean : as ``weighted_mean`` has it.

    Whatever q is, the means over q cycles have all invariant means between their extremes; of how
    they vary from gap to gap the weights leave little, the more gaps the less.
    """
    back = _returns(visited, _FEW)
    nearest = np.minimum.accumulate(np.append(TWO_PI, back[:-1]))
    for index in np.flatnonzero(back < 0.25 * nearest).tolist():
        period = index + 1
        steps = shorter_way(visited[period:] - visited[:-period])
        # Gaps between q points are a whole turn together, and all q are drifted through at once.
        gaps = abs(float(np.sum(steps))) / TWO_PI
        rests = bool(np.abs(steps[-1]) <= ANGLE * TWO_PI)
        drifts = np.all(steps > 0.0) or np.all(steps < 0.0)
        if gaps > _MOST_GAPS or not (drifts or rests):
            continue
        size = np.abs(steps[::-1][::period])
        # On the way to a periodic orbit steps fade.
        if rests or (gaps < 1.0 and size[0] < 0.5 * size[size.size // 2]):
            return None
        ahead = np.mod(visited[-period:-1] - visited[-1], TWO_PI)
        starts = visited[-1] + ahead.min(initial=TWO_PI) * np.arange(_BETWEEN) / _BETWEEN
        # Over q cycles from each angle of the orbits that begin there, which lie all round.
        along = orbits_angles(circle_map, starts, 2 * period)
        values = function(along.ravel()).reshape(along.shape)
        if not np.isfinite(values).all():
            return float("inf")
        sums = np.cumsum(values, axis=1)
        means = (sums[:, period:] - sums[:, :-period]) / period
        spread = float(np.ptp(means)) * _left_over(gaps)
        return min(float(np.max(np.abs(means - mean))), 2.0 * spread)
    return None


def _returns(visited: Array, most: int) -> Array:
    """How far the last angle of an orbit lies from those 1, 2, ... ``most`` cycles before, rad."""
    return np.abs(shorter_way(visited[-2 : -2 - most : -1] - visited[-1]))


def _left_over(turns: float) -> float:
    """What a weighted mean over so many turns of a wave, or up to twice as many, leaves of it at
    most.
    """
    weight = window(_SAMPLES)
    share = np.arange(1.0, _SAMPLES + 1.0) / (_SAMPLES + 1.0)
    tried = turns * np.linspace(1.0, 2.0, 64)
    return float(np.max(np.abs(np.exp(1j * TWO_PI * np.outer(tried, share)) @ weight)))


MAX_PERIOD = 512
TRANSIENT = 2_000
_STARTS = TWO_PI * np.mod(0.1 + np.sqrt(2.0) * np.arange(1.0, 6.0), 1.0)
_SAME = 1e-6  # exponents that differ by less, their bounds apart, belong to one attractor
_NEAR = 0.05  # radians: an orbit that comes back nearer than this may be close to a periodic one
_NEWTON = 30
_BATCHES = 40
DEVIATIONS = 4.0  # standard errors of the batches' mean
_FEW = 64  # cycles within which an orbit nearly closes
_MOST_GAPS = 10.0  # between its points, that it drifts by until its mean tells
_BETWEEN = 64  # angles in such a gap
_SAMPLES = 500  # of the weights
_CREEPS = 0.02  # an orbit of which a smaller share lies among its first half has not gone round
_CREEP = 10  # decimals of an angle: what moves less than 1e-10 radians stands still
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
      of 40 batches: a statistical bound, and it is about 1e-2; inf where the orbit still creeps,
      as of ``birkhoff_average``.

    To each the error of F' adds (``derivative_and_error``); inf where F' is lost in it. Of the
    orbits from five angles the least bound is told, and no less than the others lie from its value.

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
    least = min(exponents)
    most = max(exponents)
    allowed = _SAME + 4.0 * (least.error_bound + most.error_bound)
    if least != most and most - least > allowed:
        raise InvalidInput(
            f"the map has several attractors: the exponent is {least:.6g} from θ = "
            f"{_STARTS[exponents.index(least)]:.4f}, {most:.6g} from "
            f"{_STARTS[exponents.index(most)]:.4f}; give the start that is meant"
        )
    best = min(exponents, key=lambda exponent: exponent.error_bound)
    known = [each for each in exponents if each != best and np.isfinite(each.error_bound)]
    apart = max((abs(each - best) for each in known), default=0.0)
    return Estimate(best, max(best.error_bound, apart))


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
    back = _returns(visited, MAX_PERIOD)
    for period in 1 + np.flatnonzero((back <= np.minimum.accumulate(back)) & (back < _NEAR)):
        orbit = _attracting_orbit(circle_map, float(last), int(period))
        if orbit is not None:
            return _exponent_of(circle_map, orbit)
    values, inexact = _log_slopes(circle_map, visited, 0.0)
    smooth = weighted_mean(values)
    if np.isneginf(smooth):
        return smooth
    means = values.reshape(_BATCHES, -1).mean(axis=1)
    spread = float(np.std(means, ddof=1)) / np.sqrt(_BATCHES)
    unseen = _unseen(circle_map, lambda at: _log_slopes(circle_map, at, 0.0)[0], visited, smooth)
    decided = smooth.error_bound <= _DECIDED * spread or spread <= EPS * (1.0 + abs(smooth))
    if decided or unseen is not None:
        return Estimate(smooth, max(smooth.error_bound, unseen or 0.0) + inexact)
    off = float("inf") if _creeps(visited) else DEVIATIONS * spread + inexact
    return Estimate(float(np.mean(values)), off)


def _creeps(visited: Array) -> bool:
    """Whether an orbit's second half lies beside its first, and not among it."""
    first, last = (np.unique(np.round(half, _CREEP)) for half in np.array_split(visited, 2))
    among = np.unique(np.searchsorted(first, last))
    return bool(among.size < _CREEPS * last.size)


def _log_slopes(circle_map: CircleMap, theta: Array, off: Array | float) -> tuple[Array, float]:
    """ln|F'| at angles that may be off by so much, and what the errors of F' make of its mean: inf
    where F' may be zero.
    """
    slopes, errors = slope_and_error_beside(circle_map, theta, off)
    with np.errstate(divide="ignore"):
        values = np.log(np.abs(slopes))
    if np.any(errors >= np.abs(slopes)):
        return values, float("inf")
    return values, float(-np.mean(np.log1p(-errors / np.abs(slopes))))


def _attracting_orbit(circle_map: CircleMap, start: float, period: int) -> Array | None:
    """The points of the period's orbit nearest to ``start``, by Newton's method, if it attracts
    ``start``.
    """
    theta = start
    for _ in range(_NEWTON):
        visited = orbit_angles(circle_map, theta, period + 1)
        with np.errstate(over="ignore"):
            multiplier = float(np.prod(circle_map.derivative(visited[:-1])))
        if abs(multiplier) >= 1.0:
            return None
        step = float(shorter_way(visited[-1] - theta)) / (1.0 - multiplier)
        theta += step
        moved, _ = _moved_along(circle_map, visited[:-1], 0.0)
        if abs(step) <= float(moved[-1]) / (1.0 - abs(multiplier)):
            near = abs(theta - start) < _NEAR
            return orbit_angles(circle_map, theta, period) if near else None
    return None


def _exponent_of(circle_map: CircleMap, points: Array) -> Estimate:
    returned, steepest = _moved_along(circle_map, points, 0.0)
    # What a round adds is carried through every later one.
    first = float(returned[-1]) / (1.0 - steepest) if steepest < 1.0 else np.pi
    moved, _ = _moved_along(circle_map, points, first)
    values, inexact = _log_slopes(circle_map, points, moved[:-1])
    exponent = float(np.mean(values))
    if exponent == -np.inf:
        return Estimate(exponent, 0.0)
    return Estimate(exponent, inexact + 8.0 * EPS * (1.0 + abs(exponent)))


def _moved_along(circle_map: CircleMap, points: Array, first: float) -> tuple[Array, float]:
    """How far off the points of an orbit and its return may be when the first is off by so much and
    each image by its rounding; and the most that its multiplier may be.
    """
    moved = [first]
    steepest = 1.0
    rounding = LIFT * (TWO_PI + np.abs(circle_map(points)))
    for theta, rounded in zip(points, rounding, strict=True):
        slope, error = slope_and_error_beside(circle_map, np.array(theta), moved[-1])
        steepness = float(np.abs(slope) + error)
        moved.append(min(steepness * moved[-1] + float(rounded), np.pi))
        steepest *= steepness
    return np.array(moved), steepest
