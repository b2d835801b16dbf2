"""Slow passages: places where an iterate comes near the diagonal without reaching it ("ghosts" of
saddle-nodes).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Whole, shorter_way
from cyclemap.checks import whole_number
from cyclemap.maps.lifts.circle_map import CircleMap, require_map
from cyclemap.maps.lifts.lift_checks import differences
from cyclemap.maps.lifts.scan import Cells, is_continuous, is_rising, monotone_cells
from cyclemap.maps.orbits.diagonal import TANGENCY, displacement

LEAST_CYCLES = 10.0
REACH = 4.0  # widths on each side of the slowest point across which ``relative_error`` looks
_SHARE = 0.5  # of the mean |Fⁿ - id - 2πw|: a larger gap is no bottleneck
_GAUSS = 48
_FOLLOWED = 1_000.0  # iterates: longer passages are slow enough for the flow's series
_MOST_FOLLOWED = 4_000  # iterates: a path that is not across by then does not get through


@dataclass(frozen=True)
class SlowPassage:
    """A bottleneck: near ``theta`` the n-th iterate moves by ε + a x² + ..., x the distance from
    ``theta``.

    Attributes
    ----------
    theta : float
        Radians in [0, 2π), where |Fⁿ - id - 2πw| is least.
    winding : int
        w, whole turns of the iterate.
    period : int
        n, of the iterate, cycles.
    gap : float
        ε, radians an n-fold cycle; its sign is the direction of motion. Good to rounding.
    curvature : float
        a, per radian, of the same sign as ε. Good to about 1e-8 of itself.
    width : float
        √(ε/a), radians: half the width of the stretch on which the move is less than doubled.
    passage_cycles : float
        nπ/√(aε), cycles of F: the time from far on one side to far on the other, to leading
        order.
    direction : int
        1 when the orbit moves up through it, -1 down.
    relative_error : float
        At most |true/parabola - 1| for the number of cycles across ±4 widths, the stretch that
        takes 84 % of the passage; of order ε. Measured, not proved: the true number is the integral
        of dx/v, v the flow that interpolates the map, up to a thousand cycles that of the iterates
        of one path. What is unknown of its last one, and of ε by rounding, is added. inf where
        that stretch holds a zero of v, a break, or more than a turn, and where a path across it
        does not get through.

    Examples
    --------
    >>> from cyclemap import CircleMap, slow_passages
    >>> (ghost,) = slow_passages(CircleMap.arnold(0.15, 0.9))
    >>> round(ghost.gap, 6), round(ghost.curvature, 6), round(ghost.width, 4)
    (0.042478, 0.45, 0.3072)
    """

    theta: float
    winding: int
    period: int
    gap: float
    curvature: float
    width: float
    passage_cycles: float
    direction: int
    relative_error: float


def slow_passages(
    circle_map: CircleMap, period: int = 1, winding: int | None = None
) -> list[SlowPassage]:
    """All bottlenecks of the n-th iterate of a map: what saddle-nodes leave behind when their
    orbits are gone.

    Parameters
    ----------
    circle_map : CircleMap
        The map F.
    period : int, default 1
        n, cycles.
    winding : int or None, optional
        Keep only this w; None takes, at each extremum, the nearest line on the side that it
        does not cross. A passage near an orbit of period n shows at each of its n points; those
        of a divisor of n are left out, and so are kinks and jumps, where the parabola does not
        hold.

    Returns
    -------
    list of SlowPassage
        By angle.

    Raises
    ------
    InvalidInput
        For a bad request.
    ConvergenceError
        When Fⁿ is too steep to scan.

    Notes
    -----
    A bottleneck is a smooth local extremum of the move Fⁿ - id - 2πw on its own side of zero (a
    least upward or a least downward move), by more than 1e-12 radians (nearer it is a
    saddle-node, see ``periodic_points``), whose passage π/√(aε) takes at least 10 cycles of F
    in all, and whose |ε| is at most half the mean of |Fⁿ - id - 2πw| over the circle.

    x' = x + ε + a x² takes π/√(aε) steps (Pomeau & Manneville 1980; Strogatz, Nonlinear
    Dynamics and Chaos, 4.3). The flow that interpolates x' = x + g(x) is v = g - gg'/2 + gg'²/3
    + g²g''/12 + ..., so that dt = dx/v.

    References
    ----------
    - Pomeau, Y. & Manneville, P. (1980), Intermittent transition to turbulence in dissipative
      dynamical systems, Communications in Mathematical Physics 74.
    - Strogatz, S. H., Nonlinear dynamics and chaos, section 4.3.

    Examples
    --------
    >>> from cyclemap import CircleMap, slow_passages
    >>> (ghost,) = slow_passages(CircleMap.arnold(0.15, 0.9))
    >>> round(ghost.theta, 6), ghost.direction, round(ghost.passage_cycles, 3)
    (1.570796, 1, 22.723)
    """
    require_map(circle_map)
    n = whole_number("period", period, least=1)
    wanted = None if winding is None else whole_number("winding", winding)
    cells = monotone_cells(circle_map, n, 1.0)
    theta, whole, gap = _near_misses(circle_map, cells, wanted)
    near = np.abs(gap) > TANGENCY
    angle = theta
    for d in range(1, n):  # left out where a divisor of the period comes at least as near
        angle = np.mod(circle_map(angle), TWO_PI)
        near &= (n % d != 0) | (np.abs(shorter_way(angle - theta)) > np.abs(gap))
    # Half the second derivative.
    curvature, _ = differences(
        lambda x: 0.5 * displacement(circle_map, x, n, np.asarray(0))[1], circle_map.breaks, theta
    )
    near &= curvature * gap > 0.0  # else too flat for a parabola
    passages = []
    columns = (column[near].tolist() for column in (theta, whole, gap, curvature))
    for place, turns, least, bend in zip(*columns, strict=True):
        cycles = float(n * np.pi / np.sqrt(bend * least))
        if cycles >= LEAST_CYCLES:
            width = float(np.sqrt(least / bend))
            way = 1 if least > 0.0 else -1
            passage = SlowPassage(place, turns, n, least, bend, width, cycles, way, np.inf)
            error = _relative_error(circle_map, passage)
            passages.append(replace(passage, relative_error=error))
    return passages


def _near_misses(
    circle_map: CircleMap, cells: Cells, wanted: int | None
) -> tuple[Array, Whole, Array]:
    """Smooth extrema of the move that face the line 2πw, w, and their distance ε from it where that
    is small.
    """
    rising = is_rising(cells)
    place = np.flatnonzero((rising != np.roll(rising, 1)) & ~cells.cut)
    place = place[is_continuous(cells)[place]]
    theta = cells.start[place]
    g = cells.g_start[place]
    least = rising[place]
    line = np.where(least, np.floor(g / TWO_PI), np.ceil(g / TWO_PI)).astype(np.int64)
    whole = line if wanted is None else np.full(place.size, wanted)
    gap, _, _ = displacement(circle_map, theta, cells.period, whole)
    middle = 0.5 * (cells.g_start + cells.g_end)
    weight = (cells.end - cells.start) / TWO_PI
    mean = np.array([np.dot(weight, np.abs(middle - TWO_PI * w)) for w in whole])
    keep = (np.where(least, gap, -gap) > 0.0) & (np.abs(gap) <= _SHARE * mean)
    return theta[keep], whole[keep], gap[keep]


def _relative_error(circle_map: CircleMap, passage: SlowPassage) -> float:
    """How far the parabola's number of cycles across ±REACH widths is from the flow's."""
    width = passage.width
    if 2.0 * REACH * width >= TWO_PI:
        return float("inf")
    # x = width·tan(s) makes the integrand of a parabola constant.
    s, weight = np.polynomial.legendre.leggauss(_GAUSS)
    edge = np.arctan(REACH)
    x = width * np.append(np.tan(edge * s), [-REACH, REACH])
    angle = passage.theta + x
    # A break inside the stretch, or inside one of its images before the last?
    for _ in range(passage.period):
        low = float(np.min(angle))
        high = float(np.max(angle))
        if np.any(np.mod(circle_map.breaks - low, TWO_PI) < high - low):
            return float("inf")
        angle = circle_map(angle)
    g, slope, rounding = displacement(
        circle_map, passage.theta + x, passage.period, np.asarray(passage.winding)
    )
    if np.any(g * passage.gap <= 0.0):
        return float("inf")
    parabola = 2.0 * edge / np.sqrt(passage.curvature * passage.gap)
    unknown = 0.5 * float(np.max(rounding)) / abs(passage.gap)
    if parabola <= _FOLLOWED:
        true = _followed(circle_map, passage)
        unknown += abs(passage.curvature) * REACH * width / parabola
    else:
        bend = slope - 1.0
        stretch = edge * weight * width * (1.0 + (x[:-2] / width) ** 2)
        # ∫dx/v = ∫dx/g + ½[ln g] - (1/12)∫g'²/g dx - (1/12)[g'] + ...
        true = float(np.dot(stretch, (1.0 - bend[:-2] ** 2 / 12.0) / g[:-2]))
        true += 0.5 * float(np.log(g[-1] / g[-2])) - float(bend[-1] - bend[-2]) / 12.0
    return float(abs(abs(true) / parabola - 1.0) + unknown)


def _followed(circle_map: CircleMap, passage: SlowPassage) -> float:
    """Iterates from one end of the stretch to the other, ±REACH widths off, of the last one the
    share that its way has inside; inf where a path does not get through.
    """
    way = passage.direction
    reach = REACH * passage.width
    lift = circle_map.scalar()
    count = 0
    x = -reach
    while x < reach:
        before = x
        place = passage.theta + way * x
        for _ in range(passage.period):
            place = lift(place)
        x = way * (place - TWO_PI * passage.winding - passage.theta)
        count += 1
        if x <= before or count > _MOST_FOLLOWED:
            return float("inf")
    return count - (x - reach) / (x - before)
