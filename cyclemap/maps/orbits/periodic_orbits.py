"""Fixed points and periodic orbits: all of them down to a stated resolution, tangencies included."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cyclemap.checks import read_only, whole_number
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.orbits.diagonal import JumpCrossing, diagonal_scan
from cyclemap.maps.orbits.periodic_points import RESOLUTION, TANGENCY, PeriodicPoints, periodic_points

_SAME = 1e-6  # radians: an orbit followed by iteration is closed when it comes back this near


@dataclass(frozen=True, eq=False)
class Orbit:
    """A periodic orbit of a circle map.

    points : shape (period,), radians in [0, 2π), in the order in which they are visited, the smallest first.
    period : prime period, cycles.
    winding : w with Fⁿ(points[0]) = points[0] + 2πw: whole turns in one period.
    multiplier : (Fⁿ)' along the orbit; on a kink the one from the right.
    left_multiplier : the same from the left; equal to ``multiplier`` away from kinks.
    stable : whether points on both sides are attracted.
    kind : "stable", "unstable", "saddle-node" (Fⁿ - id touches 2πw without crossing it, also at a kink: two orbits
        merged), "neutral" (crosses with | |multiplier| - 1 | ≤ 1e-7, where the derivative does not decide) or
        "border-collision" (Fⁿ - id meets 2πw at the edge of a jump).
    error_bound : radians, the largest over the points: each lies within it of the true one, see ``PeriodicPoints``
        (about rounding/|multiplier - 1|; √(tangency/curvature) at a saddle-node; inf at a border collision).
    """

    points: Array
    period: int
    winding: int
    multiplier: float
    left_multiplier: float
    stable: bool
    kind: str
    error_bound: float = float("inf")


def fixed_points(circle_map: CircleMap, *, resolution: int = RESOLUTION, tangency: float = TANGENCY) -> list[Orbit]:
    """All θ in [0, 2π) with F(θ) = θ + 2πw for some whole w, sorted by angle.

    Found and judged as in ``periodic_points`` with period 1: complete but for pairs of extrema that F
    hides within half a milliradian; an extremum within ``tangency`` (radians) of 2πw is one fixed point of
    kind "saddle-node", never two and never none. A fixed point on a kink carries both one-sided multipliers.
    Jumps across the diagonal are no fixed points: see ``crossings_by_jump``.

    Raises InvalidInput when a whole arc is fixed (the identity), ConvergenceError when the map is too steep.

    >>> [(round(float(p.points[0]), 6), p.kind) for p in fixed_points(CircleMap.arnold(0.0, 0.5))]
    [(0.0, 'stable'), (3.141593, 'unstable')]
    """
    return periodic_orbits(circle_map, 1, resolution=resolution, tangency=tangency)


def periodic_orbits(
    circle_map: CircleMap,
    period: int,
    winding: int | None = None,
    *,
    resolution: int = RESOLUTION,
    tangency: float = TANGENCY,
) -> list[Orbit]:
    """All orbits of prime period n, Fⁿ(θ) = θ + 2πw, each once, sorted by their smallest angle.

    winding : keep only orbits with this w at their smallest point (for degree 1: rotation number w/n); None keeps all.
    Orbits whose prime period is a proper divisor of n are left out; cyclic shifts are one orbit. Grouped from
    ``periodic_points``, with its resolution, errors and accuracy. Every point is solved on its own, so all keep
    full accuracy, about 1e-15/|multiplier - 1|, however expanding the map.

    >>> [o.winding for o in periodic_orbits(CircleMap.arnold(0.5, 0.9), 2)]
    [1, 1]
    """
    wanted = None if winding is None else whole_number("winding", winding)
    found = periodic_points(circle_map, period, resolution=resolution, tangency=tangency)
    orbits = _linked(found) + _followed(circle_map, found)
    chosen = [orbit for orbit in orbits if wanted is None or orbit.winding == wanted]
    return sorted(chosen, key=lambda orbit: float(orbit.points[0]))


def crossings_by_jump(circle_map: CircleMap, *, resolution: int = RESOLUTION) -> list[JumpCrossing]:
    """Where a jump of F carries the turn F - id across a multiple of 2π, sorted by angle.

    A downward jump (``attracting``) gathers orbits from both sides as a stable fixed point would. A jump one side
    of which meets 2πw within 1e-12 radians is a fixed point of kind "border-collision" instead.
    """
    cells_a_turn = whole_number("resolution", resolution, least=8)
    return sorted(diagonal_scan(circle_map, 1, cells_a_turn, TANGENCY).jumps, key=lambda jump: jump.theta)


# -- points to orbits --------------------------------------------------------------------------------------


def _visits(found: PeriodicPoints) -> np.typing.NDArray[np.int64]:
    """(n, count): the index of the point where each point is after 0, 1, ..., n - 1 cycles; -1 where unknown."""
    rows = [np.arange(found.count)]
    for _ in range(found.period - 1):
        rows.append(np.where(rows[-1] >= 0, found.image[rows[-1]], -1))
    return np.stack(rows)


def _linked(found: PeriodicPoints) -> list[Orbit]:
    """The orbits whose points are all in the list and linked."""
    if found.count == 0:
        return []
    visits = _visits(found)
    first = np.flatnonzero((found.prime_period == found.period) & np.all(visits >= visits[0], axis=0))
    points = read_only(found.theta[visits[:, first]].T)
    bounds = np.max(found.error_bound[visits[:, first]], axis=0)
    rows = zip(points, *(column[first].tolist() for column in _columns(found)), bounds.tolist(), strict=True)
    return [
        Orbit(row, found.period, winding, right, left, kind == "stable", kind, bound)
        for row, winding, right, left, kind, bound in rows
    ]


def _columns(found: PeriodicPoints) -> tuple[np.typing.NDArray[Any], ...]:
    return found.winding, found.multiplier, found.left_multiplier, found.kind


def _followed(circle_map: CircleMap, found: PeriodicPoints) -> list[Orbit]:
    """The orbits with a point whose image is not in the list (at jumps), by iteration from their smallest point."""
    if found.count == 0 or np.all(found.image >= 0):
        return []
    broken = np.any(_visits(found) < 0, axis=0) & (found.prime_period == found.period)
    orbits = []
    for i in np.flatnonzero(broken).tolist():
        points = [float(found.theta[i])]
        for _ in range(found.period - 1):
            points.append(float(np.mod(circle_map(points[-1]), TWO_PI)))
        if min(points) >= points[0] - _SAME:
            winding, right, left, kind = (column[i].item() for column in _columns(found))
            bound = float(found.error_bound[i])
            orbits.append(Orbit(read_only(points), found.period, winding, right, left, kind == "stable", kind, bound))
    return orbits
