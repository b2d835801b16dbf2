"""Cells of one turn of θ on each of which an iterate Fⁿ - shift·id is known at both ends, and the iterate itself."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.lifts.circle_map import CircleMap

Mask = npt.NDArray[np.bool_]
Turns = npt.NDArray[np.int64]

INSET = 1e-12  # radians: how far beside a break of an iterate its one-sided values are read
_ARRAYS = ("start", "end", "g_start", "g_end", "slope_start", "slope_end", "cut")


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
    cut: Mask
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


def taken(cells: Cells, index: Mask | Turns) -> Cells:
    """The cells with these indices."""
    return replace(cells, **{name: getattr(cells, name)[index] for name in _ARRAYS})


def in_order(parts: list[Cells]) -> Cells:
    """All the cells, sorted by start."""
    arrays: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in _ARRAYS}
    order = np.argsort(arrays["start"])
    return replace(parts[0], **{name: array[order] for name, array in arrays.items()})


def joined(cells: Cells) -> Cells:
    """Give both sides of every smooth node the very same value, so that no root is lost or doubled."""
    g_end = np.where(np.roll(cells.cut, -1), cells.g_end, np.roll(cells.g_start, -1))
    if not cells.cut[0]:
        g_end[-1] = cells.g_start[0] + cells.climb
    return replace(cells, g_end=g_end, end=np.append(cells.start[1:], TWO_PI))


def is_continuous(cells: Cells) -> Mask:
    """Whether g is continuous at the start of each cell (the last cell's end is the first cell's start)."""
    before, slope = np.roll(cells.g_end, 1), np.abs(np.roll(cells.slope_end, 1))
    before[0] -= cells.climb
    allowed = 1e-9 + 4.0 * INSET * (slope + np.abs(cells.slope_start))
    return np.asarray(~cells.cut | (np.abs(before - cells.g_start) <= allowed))


def is_rising(cells: Cells) -> Mask:
    """Whether g climbs along each cell."""
    trend = cells.slope_start + cells.slope_end
    return np.where(trend == 0.0, cells.g_end > cells.g_start, trend > 0.0)
