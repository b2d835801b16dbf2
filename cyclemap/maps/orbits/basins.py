"""Basins of stable orbits: the immediate basin by its end points, the whole one by preimages."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Whole
from cyclemap.checks import positive_number, read_only, whole_number
from cyclemap.maps.estimate import ANGLE, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap, require_map
from cyclemap.maps.lifts.lift_checks import Lift, base_angles
from cyclemap.maps.lifts.scan import (
    INSET,
    Cells,
    bracketed_root,
    iterate,
    monotone_cells,
    preimages,
)
from cyclemap.maps.orbits.periodic_points import (
    Orbit,
    PeriodicPoints,
    periodic_orbits,
    periodic_points,
)

MAX_PERIOD = 8
LEFT_OVER = 1e-6  # share of the circle
MAX_ARCS = 50_000
_LOCAL = 1024  # points between a stable point and the next periodic ones
_LINEAR = 1e-8  # radians: this near a stable point the iterate contracts towards it
_SETTLED = 1e-14  # radians
_ROUNDS = 200
# arcs pulled back together, and how often
_BATCH = 512
_BATCHES = 2_000


@dataclass(frozen=True, eq=False)
class Basin:
    """The set of θ whose orbit tends to one stable orbit.

    Attributes
    ----------
    orbit : Orbit
        The stable orbit.
    immediate : ndarray, shape (period, 2)
        Radians: row i is the open arc (start, end) around ``orbit.points[i]``, the connected
        part of the basin that holds it; start < end ≤ start + 2π.
    arcs : ndarray, shape (m, 2)
        Radians: all arcs found, disjoint, sorted by start in [0, 2π); an end may exceed 2π.
    measure : Estimate
        The share of the circle that the arcs cover; its error bound is ``undecided`` and
        rounding.
    undecided : float
        The share of the circle that no basin holds (the same number in every basin of a map):
        it may belong to arcs not yet found, to orbits of longer periods, or to none.

    Examples
    --------
    >>> from cyclemap import CircleMap, basins
    >>> (only,) = basins(CircleMap.arnold(0.1, 0.9), max_period=1)
    >>> only.orbit.period, only.undecided < 1e-6, round(only.measure, 9)
    (1, True, 1.0)
    """

    orbit: Orbit
    immediate: Array
    arcs: Array
    measure: Estimate
    undecided: float


def basins(
    circle_map: CircleMap,
    *,
    max_period: int = MAX_PERIOD,
    left_over: float = LEFT_OVER,
    max_arcs: int = MAX_ARCS,
) -> tuple[Basin, ...]:
    """The basins of a map's stable orbits, sorted by period, then by angle.

    Parameters
    ----------
    circle_map : CircleMap
        The map.
    max_period : int, optional
        The longest period that is looked at, cycles.
    left_over : float, optional
        Share of the circle that may stay undecided.
    max_arcs : int, optional
        About how many arcs are looked for, at most.

    Returns
    -------
    tuple of Basin
        One a stable orbit of periods 1 to ``max_period``.

    Raises
    ------
    InvalidInput
        For a bad request or where every point of an arc is periodic.
    ConvergenceError
        When the iterates up to ``max_period`` are too steep to scan.

    Notes
    -----
    Immediate basins: with G the iterate (its square where the multiplier is not positive) that
    fixes a point p, the arc around p grows from both ends for as long as G(x) lies between x
    and the arc's far end; it stops at periodic points, at preimages of its other end and at
    jumps, solved to about 1e-13 radians/(slope - 1). Exact for homeomorphisms, whose basins
    these are; else G is looked at at its extrema, its breaks and 1,024 points between p and the
    next points that G fixes. Whole basins: preimages of the immediate ones under F, arc by arc,
    the longest first (nothing is found that does not belong, down to the ends' rounding), until
    the share ``left_over`` is undecided or nothing new comes, none shorter than a thousandth of
    it, about ``max_arcs`` at most. Where orbits wander long before they settle much may stay
    undecided.

    Saddle-nodes and neutral orbits have no basin here; what tends to them stays undecided. An
    attracting jump is no orbit: what it gathers belongs to the stable orbits around it.
    (Devaney, An Introduction to Chaotic Dynamical Systems, 1.11.)

    References
    ----------
    Devaney, R. L., An introduction to chaotic dynamical systems, section 1.11.

    Examples
    --------
    >>> from cyclemap import CircleMap, basins
    >>> (only,) = basins(CircleMap.arnold(0.1, 0.9), max_period=1)
    >>> only.arcs.round(6).tolist(), round(only.measure, 9)
    ([[2.368808, 8.651993]], 1.0)
    """
    require_map(circle_map)
    longest = whole_number("max_period", max_period, least=1)
    share = positive_number("left_over", left_over)
    most = whole_number("max_arcs", max_arcs, least=1)
    orbits = []
    immediate = []
    for period in range(1, longest + 1):
        stable = [orbit for orbit in periodic_orbits(circle_map, period) if orbit.stable]
        if not stable:
            continue
        cells = monotone_cells(circle_map, period, 0.0)
        points = periodic_points(circle_map, period)
        for orbit in stable:
            rows = [
                _immediate_arc(circle_map, cells, points, orbit, point)
                for point in orbit.points.tolist()
            ]
            orbits.append(orbit)
            immediate.append(read_only(rows))
    if not orbits:
        return ()
    every = _all_preimages(circle_map, immediate, share, most)
    undecided = max(0.0, 1.0 - _share(every))
    made = []
    for index, (orbit, arcs) in enumerate(zip(orbits, immediate, strict=True)):
        own = every[every[:, 2] == index, :2]
        rounding = ANGLE * own.size / TWO_PI
        measure = Estimate(min(_share(own), 1.0), undecided + rounding)
        made.append(Basin(orbit, arcs, read_only(own[np.argsort(own[:, 0])]), measure, undecided))
    return tuple(made)


def _share(arcs: Array) -> float:
    """Of the circle, that the arcs cover."""
    return float(np.sum(arcs[:, 1] - arcs[:, 0])) / TWO_PI


def _immediate_arc(
    circle_map: CircleMap, cells: Cells, points: PeriodicPoints, orbit: Orbit, point: float
) -> tuple[float, float]:
    """The largest arc around ``point`` into which the iterate carries it, towards the point."""
    # The points of the line, up to a turn away, that the same lift Fⁿ - 2πw fixes.
    winding = int(points.winding[np.argmin(np.abs(points.theta - point))])
    laps = np.array([-1, 0, 1])[:, None]
    climb = circle_map.degree**points.period - 1
    fixed = (points.theta + TWO_PI * laps)[points.winding + climb * laps == winding]
    below = max([point - TWO_PI, *fixed[fixed < point - _LINEAR]])
    above = min([point + TWO_PI, *fixed[fixed > point + _LINEAR]])

    def local(theta: Array) -> Array:
        """The lift Fⁿ - 2πw, or its square, which fixes the point."""
        for _ in range(2 if min(orbit.multiplier, orbit.left_multiplier) <= 0.0 else 1):
            theta = iterate(circle_map, theta, points.period) - TWO_PI * winding
        return theta

    # A grid between the limits, and the ends of the iterate's monotone cells, both sides of its
    # breaks.
    edges = np.concatenate([cells.start - INSET * cells.cut, (cells.start + INSET)[cells.cut]])
    nodes = np.concatenate(
        [np.linspace(below, above, _LOCAL + 1)[1:-1], (edges + TWO_PI * laps).ravel()]
    )
    nodes = nodes[
        (np.abs(nodes - point) > _LINEAR) & (nodes > below + INSET) & (nodes < above - INSET)
    ]
    nodes = np.unique(nodes)
    images = local(nodes)
    low = point - _LINEAR
    high = point + _LINEAR
    for _ in range(_ROUNDS):
        new_high = _reach(local, nodes, images, high, low, above)
        new_low = _reach(local, nodes, images, low, new_high, below)
        grown = (new_high - high) + (low - new_low)
        low = new_low
        high = new_high
        if grown <= _SETTLED or high - low >= TWO_PI:
            break
    start = float(base_angles(np.array(low)))
    return start, start + min(high - low, TWO_PI)


def _reach(
    local: Lift, nodes: Array, images: Array, end: float, other: float, limit: float
) -> float:
    """How far the arc grows beyond ``end``, away from ``other``, at most to ``limit``."""
    way = 1.0 if limit > end else -1.0
    ahead = way * (nodes - end) > 0.0
    x = nodes[ahead][:: int(way)]
    image = images[ahead][:: int(way)]

    def room(at: Array, lifted: Array) -> Array:
        """How far the image lies between the arc's other end and its preimage; below 0 outside."""
        return np.minimum(way * (at - lifted), way * (lifted - other))

    leaves = np.flatnonzero((room(x, image) < 0.0) | (x == image))[:1]
    if leaves.size == 0:
        return limit
    inside = np.append(end, x)[leaves]
    if room(inside, local(inside)) > 0.0:
        inside = bracketed_root(lambda at, _: room(at, local(at)), inside, x[leaves])
    return float(inside[0])


def _all_preimages(
    circle_map: CircleMap, immediate: list[Array], left_over: float, most: int
) -> Array:
    """All arcs of all basins, (start, end, index of the basin); the longest are pulled back
    first.
    """
    cells = monotone_cells(circle_map, 1, 0.0)
    start = np.concatenate([np.insert(arcs, 2, index, 1) for index, arcs in enumerate(immediate)])
    every = start
    waiting = start
    for _ in range(_BATCHES):
        if waiting.size == 0 or _share(every) >= 1.0 - left_over or len(every) > most:
            break
        waiting = waiting[np.argsort(waiting[:, 0] - waiting[:, 1])]
        now, later = np.split(waiting, [max(_BATCH, len(waiting) // 4)])
        # The arcs that F maps into those: between preimages of their ends, and breaks.
        ends = np.unique(np.mod(now[:, :2].ravel(), TWO_PI))
        theta = np.mod(preimages(circle_map, cells, ends), TWO_PI)
        edges = np.unique(np.concatenate([theta, circle_map.breaks]))
        after = np.append(edges[1:], edges[:1] + TWO_PI)
        middle = 0.5 * (edges + after)
        holder = _holder(now, circle_map(middle))
        wide = after - edges > 1e-3 * left_over * TWO_PI
        fresh = (holder >= 0) & wide & (_holder(start, middle) < 0)
        new = np.column_stack([edges, after, now[holder, 2]])[fresh]
        every = np.concatenate([every, new])
        waiting = np.concatenate([later, new])
    return every


def _holder(arcs: Array, theta: Array) -> Whole:
    """Index of the arc that holds each angle, or -1; the arcs are disjoint on the circle."""
    order = np.argsort(arcs[:, 0])
    start = arcs[order, 0]
    end = arcs[order, 1]
    angle = np.mod(theta, TWO_PI)
    place = np.searchsorted(start, angle, side="right") - 1
    angle = np.where(place < 0, angle + TWO_PI, angle)
    return np.where(angle < end[place], order[place], -1)
