"""Cells: one turn of θ cut so finely that each iterate Fⁿ runs monotonely through every cell.

What root finding, envelopes and orbit counts share. Complete down to the resolution: in one cell the slope of
Fⁿ - shift·id is taken to change sign at most once.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.optimize.elementwise import find_root

from cyclemap.errors import ConvergenceError
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.circle_map import CircleMap

MAX_CELLS = 2_000_000
INSET = 1e-12  # radians: how far beside a break of an iterate its one-sided values are read
_LONGEST_IMAGE = 0.5  # radians: no cell's image under any iterate is longer
_PASSES = 60


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells [a, b] in order over [0, 2π] and the values there of ``g = Fⁿ(θ) - shift·θ`` with its slopes.

    ``cut[i]`` says that a break of the iterate lies at the start of cell i (and at the end of cell i - 1);
    there ``start`` and ``end`` hold the break, while values are one-sided limits.
    """

    start: Array
    end: Array
    g_start: Array
    g_end: Array
    slope_start: Array
    slope_end: Array
    cut: npt.NDArray[np.bool_]
    period: int
    shift: float
    degree: int

    @property
    def climb(self) -> float:
        """g(θ + 2π) - g(θ), radians."""
        return float(TWO_PI * (self.degree**self.period - self.shift))

    @property
    def size(self) -> int:
        """Number of cells."""
        return int(self.start.size)

    def inner(self) -> tuple[Array, Array]:
        """The cells' ends moved inside by ``INSET`` where a break lies there."""
        cut_after = np.roll(self.cut, -1)
        return self.start + INSET * self.cut, self.end - INSET * cut_after


def iterate(circle_map: CircleMap, theta: Array, period: int) -> Array:
    """Fⁿ(θ), radians, lifted."""
    image = np.asarray(theta, dtype=np.float64)
    for _ in range(period):
        image = circle_map(image)
    return image


def iterate_slope(circle_map: CircleMap, theta: Array, period: int) -> Array:
    """(Fⁿ)'(θ) by the chain rule."""
    image, slope = theta, np.ones_like(theta)
    for step in range(period):
        slope = np.asarray(slope * circle_map.derivative(image))
        if step + 1 < period:
            image = circle_map(image)
    return slope


def monotone_cells(circle_map: CircleMap, period: int, shift: float, resolution: int) -> Cells:
    """Cells on each of which g = Fⁿ - shift·id is monotone, down to the resolution."""
    breaks = iterate_breaks(circle_map, period, resolution)
    nodes = _base_nodes(circle_map, breaks, resolution)
    for _ in range(_PASSES):
        cells, parts = _evaluated(circle_map, nodes, breaks, period, shift)
        if np.all(parts == 1):
            return _split_at_extrema(circle_map, cells)
        if parts.sum() > MAX_CELLS:
            break
        nodes = np.append(_subdivided(cells.start, cells.end, parts), TWO_PI)
    raise ConvergenceError(
        f"period {period} needs more than {MAX_CELLS} cells: the map is too steep; ask for a shorter period"
    )


def iterate_breaks(circle_map: CircleMap, period: int, resolution: int) -> Array:
    """Breaks of Fⁿ in [0, 2π): those of F and their preimages up to n - 1 cycles back."""
    found = latest = circle_map.breaks
    if found.size == 0:
        return found
    once = None
    for _ in range(period - 1):
        once = once or monotone_cells(circle_map, 1, 0.0, resolution)
        latest = np.concatenate([crossings(circle_map, once, float(b))[0] for b in latest])
        if latest.size == 0:
            break
        found = np.append(found, latest)
        if found.size > MAX_CELLS // 8:
            raise ConvergenceError(f"period {period} has more than {found.size} breaks: ask for a shorter period")
    return _merged(np.mod(found, TWO_PI))


def _merged(angles: Array) -> Array:
    ordered = np.sort(np.where(angles > TWO_PI - 8.0 * INSET, 0.0, angles))
    return np.asarray(ordered[np.append(True, np.diff(ordered) > 8.0 * INSET)])


def _base_nodes(circle_map: CircleMap, breaks: Array, resolution: int) -> Array:
    grid = np.linspace(0.0, TWO_PI, resolution + 1)
    knots = circle_map.pieces.knots if circle_map.pieces is not None else np.zeros(0)
    smooth = np.union1d(grid, knots)
    if breaks.size:
        around = np.concatenate([[-TWO_PI], breaks, [2.0 * TWO_PI]])
        above = np.searchsorted(around, smooth)
        nearest = np.minimum(around[above] - smooth, smooth - around[above - 1])
        smooth = smooth[(nearest > 8.0 * INSET) | (smooth == 0.0) | (smooth == TWO_PI)]
    nodes = np.union1d(smooth, breaks)
    return np.asarray(nodes[np.append(np.diff(nodes) > 4.0 * INSET, True)])


def _evaluated(
    circle_map: CircleMap, nodes: Array, breaks: Array, period: int, shift: float
) -> tuple[Cells, npt.NDArray[np.int64]]:
    start, end = nodes[:-1], nodes[1:]
    cut = np.isin(start, breaks)
    here = np.concatenate([start + INSET * cut, end - INSET * np.roll(cut, -1)])
    image, slope, size = here, np.ones_like(here), start.size
    longest = np.zeros(size)
    for _ in range(period):
        slope = slope * circle_map.derivative(image)
        image = circle_map(image)
        steepest = np.maximum(np.abs(slope[:size]), np.abs(slope[size:])) * (end - start)
        longest = np.maximum(longest, np.maximum(steepest, np.abs(image[size:] - image[:size])))
    parts = np.clip(np.ceil(longest / _LONGEST_IMAGE), 1, 64).astype(np.int64)
    parts[end - start < 32.0 * INSET] = 1
    g, g_slope = image - shift * here, slope - shift
    cells = Cells(start, end, g[:size], g[size:], g_slope[:size], g_slope[size:], cut, period, shift, circle_map.degree)
    return _joined(cells), parts


def _joined(cells: Cells) -> Cells:
    """Give both sides of every smooth node the very same value, so that no root is lost or doubled."""
    g_end = np.where(np.roll(cells.cut, -1), cells.g_end, np.roll(cells.g_start, -1))
    if not cells.cut[0]:
        g_end[-1] = cells.g_start[0] + cells.climb
    return replace(cells, g_end=g_end)


def _subdivided(start: Array, end: Array, parts: npt.NDArray[np.int64]) -> Array:
    owner = np.repeat(np.arange(start.size), parts)
    rank = np.arange(owner.size) - np.repeat(np.cumsum(parts) - parts, parts)
    return start[owner] + (end - start)[owner] * (rank / parts[owner])


def _split_at_extrema(circle_map: CircleMap, cells: Cells) -> Cells:
    turning = np.flatnonzero(cells.slope_start * cells.slope_end < 0.0)
    if turning.size == 0:
        return cells
    inner_start, inner_end = cells.inner()
    found = find_root(
        lambda x: iterate_slope(circle_map, x, cells.period) - cells.shift,
        (inner_start[turning], inner_end[turning]),
    )
    theta = np.asarray(found.x, dtype=np.float64)
    g = iterate(circle_map, theta, cells.period) - cells.shift * theta
    flat = np.zeros_like(g)
    after = turning + 1
    return Cells(
        np.insert(cells.start, after, theta),
        np.insert(cells.end, turning, theta),
        np.insert(cells.g_start, after, g),
        np.insert(cells.g_end, turning, g),
        np.insert(cells.slope_start, after, flat),
        np.insert(cells.slope_end, turning, flat),
        np.insert(cells.cut, after, False),
        cells.period,
        cells.shift,
        cells.degree,
    )


def crossings(
    circle_map: CircleMap, cells: Cells, level: float
) -> tuple[Array, npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """All θ in [0, 2π] with g(θ) = level + 2πw, their w, and the cell of each."""
    low = np.floor((cells.g_start - level) / TWO_PI).astype(np.int64)
    high = np.floor((cells.g_end - level) / TWO_PI).astype(np.int64)
    return roots_between(circle_map, cells, level, low, high)


def roots_between(
    circle_map: CircleMap,
    cells: Cells,
    level: float,
    turn_start: npt.NDArray[np.int64],
    turn_end: npt.NDArray[np.int64],
) -> tuple[Array, npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """The roots of g = level + 2πw for every w in (min, max] of the whole turns at a cell's two ends."""
    count = np.abs(turn_end - turn_start)
    owner = np.repeat(np.arange(cells.size), count)
    rank = np.arange(owner.size) - np.repeat(np.cumsum(count) - count, count)
    whole = np.minimum(turn_start, turn_end)[owner] + 1 + rank
    if owner.size == 0:
        return np.zeros(0), whole, owner
    inner_start, inner_end = cells.inner()
    low, high, target = inner_start[owner], inner_end[owner], level + TWO_PI * whole

    def residual(theta: Array, wanted: Array) -> Array:
        return iterate(circle_map, theta, cells.period) - cells.shift * theta - wanted

    at_low, at_high = residual(low, target), residual(high, target)
    theta = np.where(np.abs(at_low) <= np.abs(at_high), low, high)
    bracketed = at_low * at_high < 0.0
    if np.any(bracketed):
        found = find_root(residual, (low[bracketed], high[bracketed]), args=(target[bracketed],))
        theta[bracketed] = found.x
    return theta, whole, owner
