"""Fixed points and periodic orbits: all of them down to a stated resolution, tangencies included."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cyclemap.checks import positive_number, read_only, whole_number
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.circle_map import CircleMap
from cyclemap.maps.diagonal import DiagonalScan, JumpCrossing, Turns, diagonal_scan
from cyclemap.maps.scan import roots_between

RESOLUTION = 512
TANGENCY = 1e-12  # radians
_NEUTRAL = 1e-7


@dataclass(frozen=True, eq=False)
class Orbit:
    """A periodic orbit of a circle map.

    points : shape (period,), radians in [0, 2π), in the order in which they are visited, the smallest first.
    period : prime period, cycles.
    winding : w with Fⁿ(points[0]) = points[0] + 2πw: whole turns in one period.
    multiplier : (Fⁿ)' along the orbit; on a kink the one from the right.
    left_multiplier : the same from the left; equal to ``multiplier`` away from kinks.
    stable : whether points on both sides are attracted.
    kind : "stable", "unstable", "saddle-node" (Fⁿ - id touches 2πw without crossing it: two orbits merged) or
        "neutral" (crosses with | |multiplier| - 1 | ≤ 1e-7, where the derivative does not decide).
    """

    points: Array
    period: int
    winding: int
    multiplier: float
    left_multiplier: float
    stable: bool
    kind: str


def fixed_points(circle_map: CircleMap, *, resolution: int = RESOLUTION, tangency: float = TANGENCY) -> list[Orbit]:
    """All θ in [0, 2π) with F(θ) = θ + 2πw for some whole w, sorted by angle.

    The turn F - id is cut into cells (at least ``resolution`` a turn, the samples of a sampled map and its
    breaks among their ends, none with an image longer than half a radian) and split at its extrema, so
    that it is monotone in each; every sign change is bracketed and solved to rounding. An extremum within
    ``tangency`` (radians) of 2πw is one fixed point of kind "saddle-node", never two and never none.
    Complete unless the turn has two extrema in one cell. A fixed point on a kink carries both one-sided
    multipliers. Jumps across the diagonal are no fixed points: see ``crossings_by_jump``.

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

    winding : keep only orbits with this w (for degree 1: rotation number w/n); None keeps all.
    Orbits whose prime period is a proper divisor of n are left out; cyclic shifts are one orbit. Found as in
    ``fixed_points`` from the n-th iterate, complete down to its resolution. Points are solved one by one,
    so they keep full accuracy, about 1e-15/|multiplier - 1|, however expanding the map.

    >>> [o.winding for o in periodic_orbits(CircleMap.arnold(0.5, 0.9), 2)]
    [1, 1]
    """
    n = whole_number("period", period, least=1)
    cells_a_turn = whole_number("resolution", resolution, least=8)
    wanted = None if winding is None else whole_number("winding", winding)
    scan = diagonal_scan(circle_map, n, cells_a_turn, positive_number("tangency", tangency))
    theta, whole, touching = _roots(circle_map, scan, wanted)
    orbits = [
        _orbit(circle_map, points, n, int(whole[first]), bool(touching[first]))
        for points, first in _grouped(circle_map, theta, n)
    ]
    return sorted(orbits, key=lambda orbit: float(orbit.points[0]))


def crossings_by_jump(circle_map: CircleMap, *, resolution: int = RESOLUTION) -> list[JumpCrossing]:
    """Where a jump of F carries the turn F - id across a multiple of 2π, sorted by angle.

    A downward jump (``attracting``) gathers orbits from both sides as a stable fixed point would.
    """
    cells_a_turn = whole_number("resolution", resolution, least=8)
    return sorted(diagonal_scan(circle_map, 1, cells_a_turn, TANGENCY).jumps, key=lambda jump: jump.theta)


# -- roots to orbits ---------------------------------------------------------------------------------------


def _roots(
    circle_map: CircleMap, scan: DiagonalScan, winding: int | None
) -> tuple[Array, Turns, npt.NDArray[np.bool_]]:
    """Every θ in [0, 2π) with Fⁿ(θ) = θ + 2πw, sorted, its w, and whether Fⁿ - id only touches there."""
    theta, whole, _ = roots_between(circle_map, scan.cells, 0.0, scan.turn_start, scan.turn_end)
    crossing = theta.size + len(scan.kink_theta)
    theta = np.concatenate([theta, scan.kink_theta, scan.touch_theta])
    whole = np.concatenate([whole, scan.kink_winding, scan.touch_winding]).astype(np.int64)
    touching = np.arange(theta.size) >= crossing
    beyond = theta >= TWO_PI
    theta = np.where(beyond, theta - TWO_PI, theta)
    whole = whole - beyond * round(scan.cells.climb / TWO_PI)
    if winding is not None:
        keep = whole == winding
        theta, whole, touching = theta[keep], whole[keep], touching[keep]
    order = np.argsort(theta, kind="stable")
    return theta[order], whole[order], touching[order]


def _grouped(circle_map: CircleMap, theta: Array, period: int) -> list[tuple[Array, int]]:
    """The roots as orbits (points in order of visit, index of the first), lower prime periods left out."""
    if period == 1 or theta.size == 0:
        return [(theta[i : i + 1], i) for i in range(theta.size)]
    following = _nearest(theta, np.mod(circle_map(theta), TWO_PI))
    seen = np.zeros(theta.size, dtype=bool)
    orbits = []
    for first in range(theta.size):
        if seen[first]:
            continue
        visited = [first]
        while len(visited) <= period and following[visited[-1]] != first and following[visited[-1]] >= 0:
            visited.append(int(following[visited[-1]]))
        if following[visited[-1]] == first and len(visited) <= period:
            seen[visited] = True
            if len(visited) == period:
                orbits.append((theta[visited], first))
        else:
            orbits.extend(_followed(circle_map, float(theta[first]), period, first))
    return orbits


def _nearest(theta: Array, images: Array) -> Turns:
    """Index of the root nearest to each image on the circle, or -1 where none is near."""
    around = np.concatenate([theta[-1:] - TWO_PI, theta, theta[:1] + TWO_PI])
    above = np.clip(np.searchsorted(around, images), 1, around.size - 1)
    pick = np.where(images - around[above - 1] <= around[above] - images, above - 1, above)
    near = np.abs(around[pick] - images) <= 1e-5
    return np.where(near, (pick - 1) % theta.size, -1)


def _followed(circle_map: CircleMap, start: float, period: int, index: int) -> list[tuple[Array, int]]:
    """The orbit of ``start`` by iteration, if it closes after one period, not sooner, and starts smallest."""
    points = [start]
    for _ in range(period):
        points.append(float(np.mod(circle_map(points[-1]), TWO_PI)))
    back = np.abs(np.mod(np.array(points[1:]) - start + np.pi, TWO_PI) - np.pi)
    if back[-1] > 1e-6 or np.any(back[:-1] <= 1e-6) or min(points) < start - 1e-6:
        return []
    return [(np.array(points[:-1]), index)]


def _orbit(circle_map: CircleMap, points: Array, period: int, winding: int, touching: bool) -> Orbit:
    right, left = (_one_sided_multiplier(circle_map, points, side) for side in (1, -1))
    stable = not touching and _attracts(left, right)
    neutral = min(abs(abs(left) - 1.0), abs(abs(right) - 1.0)) <= _NEUTRAL
    if touching:
        kind = "saddle-node"
    elif neutral:
        kind, stable = "neutral", False
    else:
        kind = "stable" if stable else "unstable"
    return Orbit(read_only(points), period, winding, right, left, stable, kind)


def _one_sided_multiplier(circle_map: CircleMap, points: Array, side: int) -> float:
    """Product of the slopes on the side where a nearby orbit passes: a negative slope changes the side."""
    on_kink = circle_map.breaks.size and np.min(
        np.abs(np.mod(points[:, None] - circle_map.breaks + np.pi, TWO_PI) - np.pi)
    )
    slopes = circle_map.derivative(points)
    if circle_map.breaks.size == 0 or on_kink > 1e-9:
        return float(np.prod(slopes))
    product = 1.0
    for point in points:
        gap = np.abs(np.mod(point - circle_map.breaks + np.pi, TWO_PI) - np.pi)
        snapped = float(circle_map.breaks[np.argmin(gap)]) if np.min(gap) <= 1e-9 else float(point)
        one_sided = circle_map.right_derivative if side > 0 else circle_map.left_derivative
        slope = float(one_sided(snapped))
        product, side = product * slope, side if slope >= 0.0 else -side
    return product


def _attracts(left: float, right: float) -> bool:
    """Stability of 0 under x → left·x (x < 0), right·x (x > 0)."""
    if left < 0.0 and right < 0.0:
        return left * right < 1.0
    return max(left, right) < 1.0
