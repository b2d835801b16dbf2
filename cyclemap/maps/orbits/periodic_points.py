"""Periodic points and orbits: every solution of Fⁿ(θ) = θ + 2πw in one turn, with multipliers and
error bounds.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from cyclemap.arrays import TWO_PI, Array, Whole, shorter_way
from cyclemap.checks import read_only, require_room, unwritable, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.inline_svg import BLUE, CIRCLE, DISC, GREY, Stroke, inline_svg
from cyclemap.maps.estimate import EPS, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap, require_map
from cyclemap.maps.lifts.lift_checks import distance_to_break, nearest_on_circle
from cyclemap.maps.lifts.map_algebra import slope_and_error_beside
from cyclemap.maps.lifts.scan import solved
from cyclemap.maps.orbits.diagonal import (
    TANGENCY,
    DiagonalScan,
    JumpCrossing,
    diagonal_scan,
    displacement,
)
from cyclemap.maps.orbits.proofs import proved_points

NEUTRAL = 1e-7
_TRUSTED = 1e-3  # a multiplier that is less sure than that says nothing of neutrality
_LINKED = 1e-9  # radians: the image of a point and the point it is, beyond both their error bounds
_WIDENINGS = 60
MAX_PERIOD = 100_000  # cycles: a minute and more, whatever the map


@dataclass(frozen=True, eq=False)
class PeriodicPoints:
    """All θ in [0, 2π) with Fⁿ(θ) = θ + 2πw, whatever their prime period; each array has shape
    (count,).

    Attributes
    ----------
    theta : ndarray, shape (count,)
        Radians, sorted.
    winding : ndarray of int
        w of each point.
    multiplier, left_multiplier : ndarray
        (Fⁿ)' from the right and from the left; they differ only where the orbit meets a kink.
    multiplier_error : ndarray
        A bound on the error of both, from that of F' (by differences where none was given) and
        that of the points.
    prime_period : ndarray of int
        The least d with F^d(θ) = θ on the circle, a divisor of n.
    kind : ndarray of str
        "stable", "unstable", "neutral", "saddle-node" or "border-collision", as for ``Orbit``.
    error_bound : ndarray
        Radians. Beyond θ ± error_bound, Fⁿ - id - 2πw has left the line for certain: it has
        opposite signs at the two ends, by more than rounding (so a crossing lies between them);
        at a saddle-node it is farther from zero than 1e-12 radians on both sides. Takes the
        lift to be good to four units of rounding of 2π + |F|; the error of a sampled map is not
        in it. inf where no such bracket was found (at jumps).
    image : ndarray of int
        Index of the point that F maps each point to; -1 where that point is not in the list.
    period : int
        n, of the iterate, cycles.

    Examples
    --------
    >>> from cyclemap import CircleMap, periodic_points
    >>> found = periodic_points(CircleMap.arnold(0.5, 0.9), 2)
    >>> found.theta.round(4).tolist(), found.kind.tolist()
    ([0.0, 1.9831, 3.1416, 4.3001], ['stable', 'unstable', 'stable', 'unstable'])
    """

    theta: Array
    winding: Whole
    multiplier: Array
    left_multiplier: Array
    multiplier_error: Array
    prime_period: Whole
    kind: npt.NDArray[np.str_]
    error_bound: Array
    image: Whole
    period: int

    @property
    def count(self) -> int:
        """How many points there are."""
        return int(self.theta.size)


def periodic_points(
    circle_map: CircleMap,
    period: int,
    winding: int | None = None,
    *,
    proved: bool = False,
    slope_error: float = 0.0,
) -> PeriodicPoints:
    """All θ in [0, 2π) with Fⁿ(θ) = θ + 2πw, whatever their prime period.

    Parameters
    ----------
    circle_map : CircleMap
        The map F.
    period : int
        n, cycles: at most 100,000.
    winding : int or None, optional
        w; None: all.
    proved : bool, default False
        By interval arithmetic (the extra ``proofs``) instead: number, prime periods, images,
        and all bounds are theorems, with nothing left to a resolution, about the formula of the
        lift with the floats in it; of a sampled map about every smooth map within ``max_error``
        of its values and ``slope_error`` of its slopes. For smooth lifts written with
        arithmetic, powers and numpy's sin, cos, tan, exp, log, sqrt, sinh, cosh, tanh, arctan
        and arctan2, and for maps composed of such. Slopes come from the lift itself, not from
        ``derivative``. Takes about 0.1 ms n a cell, of which 1,000,000/n are made at most, and
        0.5 ms n a point, of which there may be 150,000/n; tangencies are refused, and with them
        saddle-nodes.
    slope_error : float, default 0.0
        For ``proved`` and sampled maps only.

    Returns
    -------
    PeriodicPoints
        Arrays, sorted by angle.

    Raises
    ------
    InvalidInput
        When a whole arc is periodic, or the period too large; with ``proved`` for lifts that do not
        take intervals.
    ConvergenceError
        When Fⁿ needs more than 2,000,000 cells; with ``proved`` for what cannot be decided.

    Notes
    -----
    One turn is cut into 512 cells or more (see ``monotone_cells``) until the cubic through each
    cell's ends meets Fⁿ at inner probes, and split at the extrema of Fⁿ - id. Then every sign
    change is bracketed and solved to rounding (Chandrupatla 1997). Complete but for pairs of
    extrema of a hump or dent of F narrower, at half its height, than a tenth of a milliradian.
    Roots between which |Fⁿ - id - 2πw| stays within 1e-12 radians (plus rounding) count as one:
    a "saddle-node" where the curve keeps its side, a crossing where it changes it; a curve that
    ends within 1e-12 of 2πw at a jump gives a "border-collision". All points of an orbit are
    judged alike.

    Examples
    --------
    >>> from cyclemap import CircleMap, periodic_points
    >>> doubling = CircleMap(lambda x: 2 * x, lambda x: 2 + 0 * x, degree=2)
    >>> found = periodic_points(doubling, 12)
    >>> found.count, int((found.prime_period == 12).sum())
    (4095, 4020)
    """
    require_map(circle_map)
    n = whole_number("period", period, least=1)
    require_room("the period", n, "give a smaller one", MAX_PERIOD)
    wanted = None if winding is None else whole_number("winding", winding)
    if slope_error and not proved:
        raise InvalidInput(
            f"slope_error is {slope_error!r}: it is a bound for proofs; give proved=True with it"
        )
    points = _proved(circle_map, n, slope_error) if proved else _computed(circle_map, n)
    # Those with the wanted winding, read-only; links to points left out are cut.
    keep = np.ones(points.count, dtype=bool) if wanted is None else points.winding == wanted
    index = np.append(np.where(keep, np.cumsum(keep) - 1, -1), -1)
    arrays: dict[str, Any] = {
        field.name: getattr(points, field.name)[keep]
        for field in fields(points)
        if field.name != "period"
    }
    arrays["image"] = index[arrays["image"]]
    for array in arrays.values():
        unwritable(array)
    return replace(points, **arrays)


def _computed(circle_map: CircleMap, n: int) -> PeriodicPoints:
    """The points that double precision finds, judged by their slopes on both sides."""
    theta, winding, role = _all_roots(diagonal_scan(circle_map, n))
    bound = _error_bounds(circle_map, theta, winding, role, n)
    image = _images(circle_map, theta, bound)
    prime, (right, left), slope_error = _followed(circle_map, theta, image, bound, n)
    # Stability of 0 under x → left·x (x < 0), right·x (x > 0).
    flips = (left < 0.0) & (right < 0.0)
    mean = np.sqrt(np.abs(left)) * np.sqrt(np.abs(right))
    growth = np.where(flips, mean, np.maximum(left, right))
    unsure = np.maximum(NEUTRAL, np.where(slope_error < _TRUSTED, slope_error, 0.0))
    kind = _kinds(growth, unsure)
    kind[role == _TOUCH] = "saddle-node"
    kind[role == _BORDER] = "border-collision"
    return PeriodicPoints(theta, winding, right, left, slope_error, prime, kind, bound, image, n)


def _proved(circle_map: CircleMap, n: int, slope_error: float) -> PeriodicPoints:
    """The proved points, whose periods follow from their images, their kinds from their
    multipliers.
    """
    points = proved_points(circle_map, n, slope_error)
    visits = _visits(points.image, n + 1)
    prime = 1 + np.argmax(visits[1:] == visits[0], axis=0)
    return PeriodicPoints(
        points.theta,
        points.winding,
        points.multiplier,
        points.multiplier,
        points.multiplier_error,
        prime,
        _kinds(np.abs(points.multiplier), points.multiplier_error),
        points.error_bound,
        points.image,
        n,
    )


def _kinds(growth: Array, unsure: Array) -> npt.NDArray[np.str_]:
    """What neighbours that grow by so much an n-fold cycle make of points."""
    neutral = np.abs(growth - 1.0) <= unsure
    kind = np.where(neutral, "neutral", np.where(growth < 1.0, "stable", "unstable"))
    return kind.astype("<U16")


_CROSSING, _KINK, _TOUCH, _BORDER = range(4)


def _all_roots(scan: DiagonalScan) -> tuple[Array, Whole, Whole]:
    """All roots, sorted, the w of each, and what it is."""
    start, end = scan.turns.reshape(-1, 2).T
    cell = np.flatnonzero(start != end)
    theta, whole, _ = solved(scan.map, scan.cells, cell, np.float64(0.0), start[cell], end[cell])
    marked = np.reshape([*scan.kink, *scan.touch, *scan.border], (-1, 2))
    role = np.repeat(np.arange(4), [theta.size, len(scan.kink), len(scan.touch), len(scan.border)])
    theta = np.concatenate([theta, marked[:, 0]])
    whole = np.concatenate([whole, np.round(marked[:, 1]).astype(np.int64)])
    beyond = theta >= TWO_PI
    theta = np.where(beyond, theta - TWO_PI, theta)
    whole = whole - beyond * scan.lap
    order = np.argsort(theta, kind="stable")
    return theta[order], whole[order], role[order]


def _error_bounds(
    circle_map: CircleMap, theta: Array, winding: Whole, role: Whole, period: int
) -> Array:
    """The half width of the bracket around each root at whose ends g = Fⁿ - id - 2πw has left the
    line beyond doubt.
    """
    residual, slope, rounding = displacement(circle_map, theta, period, winding)
    margin = np.abs(residual) + 2.0 * rounding
    with np.errstate(divide="ignore"):
        half = np.minimum(1.5 * margin / np.abs(slope - 1.0), 1e-8)
    half = np.maximum(half, 2.0 * np.spacing(theta) + 1e-300)
    touches = role >= _TOUCH
    half[touches] = np.maximum(half[touches], TANGENCY)
    bound = np.full(half.shape, np.inf)
    for _ in range(_WIDENINGS):
        wanted = np.isinf(bound) & (role != _BORDER) & (half < np.pi)
        if not np.any(wanted):
            break
        (low, _, low_noise), (high, _, high_noise) = (
            displacement(circle_map, theta + side * half, period, winding) for side in (-1, 1)
        )
        sides = np.where(touches, low * high > 0.0, low * high < 0.0)
        done = (
            sides
            & (np.abs(low) > low_noise + TANGENCY * touches)
            & (np.abs(high) > high_noise + TANGENCY * touches)
        )
        bound = np.where(wanted & done, half, bound)
        half = 2.0 * half
    return bound


def _images(circle_map: CircleMap, theta: Array, bound: Array) -> Whole:
    """Index of the root that F maps each root to, or -1 where none lies within the error bounds."""
    if theta.size == 0:
        return np.zeros(0, dtype=np.int64)
    image = np.mod(circle_map(theta), TWO_PI)
    near, nearest = nearest_on_circle(theta, image)
    away = np.abs(image - near)
    allowed = _LINKED + 4.0 * np.minimum(
        np.abs(circle_map.derivative(theta)) * bound + bound[nearest], 1e-3
    )
    return np.where(away <= allowed, nearest, -1)


@np.errstate(over="ignore", invalid="ignore")  # a multiplier beyond all floats is inf
def _followed(
    circle_map: CircleMap, theta: Array, image: Whole, bound: Array, period: int
) -> tuple[Whole, Array, Array]:
    """Prime periods; multipliers of orbits above and below the roots, shape (2, count); and a bound
    on the errors of those.

    Each root is followed by its links, where they break by iteration: so slopes are taken at roots
    that are solved on their own, and no digit is lost however expanding the map. Periods are the
    least divisor of n after which a root is back. A negative slope changes the side on which a
    nearby orbit passes. Errors are those of F', and of the angles at which it is read.
    """
    prime = np.full(theta.size, period)
    sides = np.outer([1, -1], np.ones(theta.size))
    multiplier = np.ones_like(sides)
    product = np.ones(theta.size)
    largest = product
    index = np.arange(theta.size)
    angle = theta
    for passed in range(1, period + 1):
        right, left = _slopes(circle_map, angle)
        slope = np.where(sides > 0, right, left)
        multiplier = multiplier * slope
        sides = np.where(slope >= 0.0, sides, -sides)
        off = np.where(index >= 0, bound[index], bound)
        # The sides of a break are not mixed.
        beside = np.maximum(distance_to_break(circle_map.breaks, angle) - _LINKED, 0.0)
        off = np.minimum(np.where(np.isinf(off), 1e-6, off), beside)
        slope, error = slope_and_error_beside(circle_map, angle, off)
        product = product * np.abs(slope)
        largest = largest * (np.abs(slope) + error)
        index = np.where(index >= 0, image[index], -1)
        angle = np.where(index >= 0, theta[index], np.mod(circle_map(angle), TWO_PI))
        near = np.abs(shorter_way(angle - theta)) <= _LINKED + np.minimum(bound, 1e-6)
        back = np.where(index >= 0, index == np.arange(theta.size), near)
        prime = np.where(back & (prime == period) & (period % passed == 0), passed, prime)
    size = np.max(np.abs(multiplier), axis=0)
    error = largest - product + 4.0 * EPS * period * (largest + size)
    return prime, multiplier, np.where(np.isfinite(size), error, np.inf)


def _slopes(circle_map: CircleMap, theta: Array) -> tuple[Array, Array]:
    """F' from the right and from the left; angles next to a break count as lying on it."""
    if circle_map.breaks.size == 0:
        plain = circle_map.derivative(theta)
        return plain, plain
    near, _ = nearest_on_circle(circle_map.breaks, theta)
    theta = np.where(np.abs(near - theta) <= _LINKED, near, theta)
    return circle_map.derivative(theta, 1), circle_map.derivative(theta, -1)


_SAME = 1e-6  # radians: an orbit followed by iteration is closed when it comes back this near


@dataclass(frozen=True, eq=False)
class Orbit:
    """A periodic orbit of a circle map.

    Attributes
    ----------
    points : ndarray, shape (period,)
        Radians in [0, 2π), in the order in which they are visited, the smallest first.
    period : int
        Prime period, cycles.
    winding : int
        w with Fⁿ(points[0]) = points[0] + 2πw: whole turns in one period.
    multiplier : Estimate
        (Fⁿ)' along the orbit; on a kink the one from the right. Its ``error_bound`` is of F'
        and the points.
    left_multiplier : Estimate
        The same from the left; equal to ``multiplier`` away from kinks.
    stable : bool
        Whether points on both sides are attracted.
    kind : str
        "stable", "unstable", "saddle-node" (Fⁿ - id touches 2πw without crossing it, also at a
        kink: two orbits merged), "neutral" (crosses with | |multiplier| - 1 | ≤ 1e-7, where the
        derivative does not decide; on a kink the larger multiplier, or the root of their
        product where both are negative) or "border-collision" (Fⁿ - id meets 2πw at the edge of
        a jump).
    error_bound : float
        Radians, the largest over the points: each lies within it of the true one, see
        ``PeriodicPoints`` (about rounding/|multiplier - 1|; √(tangency/curvature) at a
        saddle-node; inf at a border collision).

    Examples
    --------
    >>> from cyclemap import CircleMap, periodic_orbits
    >>> orbits = periodic_orbits(CircleMap.arnold(0.5, 0.9), 2)
    >>> [(orbit.kind, orbit.winding, round(orbit.multiplier, 4)) for orbit in orbits]
    [('stable', 1, 0.19), ('unstable', 1, 1.8513)]
    """

    points: Array
    period: int
    winding: int
    multiplier: Estimate
    left_multiplier: Estimate
    stable: bool
    kind: str
    error_bound: float = float("inf")

    def _repr_html_(self) -> str:
        around = np.linspace(0.0, TWO_PI, 91)
        circle, points = (
            np.column_stack([np.cos(theta), np.sin(theta)]) for theta in (around, self.points)
        )
        marks = Stroke(points, BLUE, DISC if self.stable else CIRCLE, 4.0)
        caption = (
            f"{self.kind} orbit, {self.winding}/{self.period} turns a cycle, multiplier "
            f"{self.multiplier:.4g}"
        )
        return inline_svg([Stroke(circle, GREY), marks], caption, equal=True)


def fixed_points(
    circle_map: CircleMap, *, proved: bool = False, slope_error: float = 0.0
) -> list[Orbit]:
    """All θ in [0, 2π) with F(θ) = θ + 2πw for some whole w.

    Parameters
    ----------
    circle_map : CircleMap
        The map.
    proved : bool, default False
        As of ``periodic_points``.
    slope_error : float, default 0.0
        As of ``periodic_points``.

    Returns
    -------
    list of Orbit
        Sorted by angle.

    Raises
    ------
    InvalidInput
        When a whole arc is fixed (the identity).
    ConvergenceError
        When the map is too steep.

    Notes
    -----
    Found and judged, with ``proved`` proved, as in ``periodic_points`` with period 1. A fixed
    point on a kink carries both one-sided multipliers. Jumps across the diagonal are no fixed
    points: see ``crossings_by_jump``.

    Examples
    --------
    >>> from cyclemap import CircleMap, fixed_points
    >>> [(round(float(p.points[0]), 6), p.kind) for p in fixed_points(CircleMap.arnold(0.0, 0.5))]
    [(0.0, 'stable'), (3.141593, 'unstable')]
    """
    return periodic_orbits(circle_map, 1, proved=proved, slope_error=slope_error)


def periodic_orbits(
    circle_map: CircleMap,
    period: int,
    winding: int | None = None,
    *,
    proved: bool = False,
    slope_error: float = 0.0,
) -> list[Orbit]:
    """All orbits of one prime period n, Fⁿ(θ) = θ + 2πw, each once.

    Parameters
    ----------
    circle_map : CircleMap
        The map F.
    period : int
        n, cycles, as of ``periodic_points``.
    winding : int or None, optional
        Keep only orbits with this w at their smallest point (for degree 1: rotation number
        w/n); None keeps all.
    proved : bool, default False
        As of ``periodic_points``.
    slope_error : float, default 0.0
        As of ``periodic_points``.

    Returns
    -------
    list of Orbit
        Sorted by their smallest angle.

    Raises
    ------
    InvalidInput
        As ``periodic_points``.
    ConvergenceError
        As ``periodic_points``.

    Notes
    -----
    Orbits whose prime period is a proper divisor of n are left out; cyclic shifts are one
    orbit. Grouped from ``periodic_points``, with its resolution, errors, accuracy and proofs.
    Every point is solved on its own, so all keep full accuracy, about 1e-15/|multiplier - 1|,
    however expanding the map.

    Examples
    --------
    >>> from cyclemap import CircleMap, periodic_orbits
    >>> [orbit.winding for orbit in periodic_orbits(CircleMap.arnold(0.5, 0.9), 2)]
    [1, 1]
    """
    wanted = None if winding is None else whole_number("winding", winding)
    every = periodic_points(circle_map, period, proved=proved, slope_error=slope_error)
    table = _visits(every.image, every.period)
    orbits = []
    broken = np.any(table < 0, axis=0)
    smallest = np.all(table >= table[0], axis=0)
    for i in np.flatnonzero((every.prime_period == every.period) & (broken | smallest)).tolist():
        points = every.theta[table[:, i]]
        bound = float(np.max(every.error_bound[table[:, i]]))
        if broken[i]:  # an image is not in the list, at a jump: by iteration
            points = every.theta[[i]]
            bound = float(every.error_bound[i])
            for _ in range(every.period - 1):
                points = np.append(points, np.mod(circle_map(points[-1]), TWO_PI))
            if np.min(points) < points[0] - _SAME:
                continue
        turns = int(every.winding[i])
        kind = str(every.kind[i])
        if wanted is None or turns == wanted:
            off = float(every.multiplier_error[i])
            slopes = Estimate(every.multiplier[i], off), Estimate(every.left_multiplier[i], off)
            orbits.append(
                Orbit(
                    read_only(points), every.period, turns, *slopes, kind == "stable", kind, bound
                )
            )
    return orbits


def _visits(image: Whole, count: int) -> Whole:
    """The index of the point where each point is after 0, 1, ..., count - 1 cycles; -1 where
    unknown.
    """
    visits = [np.arange(image.size)]
    for _ in range(count - 1):
        visits.append(np.where(visits[-1] >= 0, image[visits[-1]], -1))
    return np.stack(visits)


def crossings_by_jump(circle_map: CircleMap) -> list[JumpCrossing]:
    """Where a jump of F carries the turn F - id across a multiple of 2π.

    Parameters
    ----------
    circle_map : CircleMap
        The map.

    Returns
    -------
    list of JumpCrossing
        Sorted by angle.

    Notes
    -----
    A downward jump (``attracting``) gathers orbits from both sides as a stable fixed point
    would. A jump one side of which meets 2πw within 1e-12 radians is a fixed point of kind
    "border-collision" instead.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import CircleMap, crossings_by_jump
    >>> saw = CircleMap(lambda x: x - 0.5 + np.mod(x, 2 * np.pi) / np.pi, None, [0.0])
    >>> len(crossings_by_jump(saw)), crossings_by_jump(CircleMap.arnold(0.1, 0.9))
    (1, [])
    """
    require_map(circle_map)
    if circle_map.breaks.size == 0:
        return []
    return sorted(diagonal_scan(circle_map, 1).jumps, key=lambda jump: jump.theta)
