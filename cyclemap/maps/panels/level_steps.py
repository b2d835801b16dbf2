"""Where one turn of a circle map crosses many levels at once: the steps of θ → ⌊(F(θ) - z)/2π⌋ for every level z."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.orbits.bracketing import bracketed_root
from cyclemap.maps.orbits.scan import Cells

Indices = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class LevelSteps:
    """The step functions n(θ; z) = ⌊(F(θ) - z)/2π⌋ on [0, 2π), one a level.

    row, theta, height : every step inside: its level's index, its angle, and by how much n rises there.
    first, last : (levels,): n just after 0 and just before 2π.
    """

    row: Indices
    theta: Array
    height: Indices
    first: Indices
    last: Indices


def level_steps(circle_map: CircleMap, cells: Cells, levels: Array) -> LevelSteps:
    """The steps for each of ``levels``, shape (m,), radians; ``cells`` are the map's own monotone cells (period 1).

    Roots of F = z + 2πw are bracketed by their cell and solved to rounding; a jump of F gives its step at the break.
    """
    low = np.floor((cells.g_start - levels[:, None]) / TWO_PI).astype(np.int64)
    high = np.floor((cells.g_end - levels[:, None]) / TWO_PI).astype(np.int64)
    rows, theta, height = _crossed(circle_map, cells, levels, low, high)
    jumped = low[:, 1:] - high[:, :-1]
    jump_row, cell = np.nonzero(jumped)
    return LevelSteps(
        np.append(rows, jump_row),
        np.append(theta, cells.start[cell + 1]),
        np.append(height, jumped[jump_row, cell]),
        low[:, 0],
        high[:, -1],
    )


def _crossed(
    circle_map: CircleMap, cells: Cells, levels: Array, low: Indices, high: Indices
) -> tuple[Indices, Array, Indices]:
    """Row, angle and height (±1) of every crossing inside a cell."""
    row, cell = np.nonzero(low != high)
    rise = (high - low)[row, cell]
    count = np.abs(rise)
    owner = np.repeat(np.arange(row.size), count)
    rank = np.arange(owner.size) - np.repeat(np.cumsum(count) - count, count)
    row, cell, sign = row[owner], cell[owner], np.sign(rise)[owner]
    target = levels[row] + TWO_PI * (np.minimum(low[row, cell], high[row, cell]) + 1 + rank)
    start, end = cells.inner()
    return row, roots_in(circle_map, start[cell], end[cell], target), sign


def roots_in(circle_map: CircleMap, start: Array, end: Array, target: Array) -> Array:
    """The root of F = target in each [start, end], where F is monotone; an end where rounding hides it."""
    if target.size == 0:
        return np.zeros(0)

    def residual(theta: Array, wanted: Array) -> Array:
        return circle_map(theta) - wanted

    at_start, at_end = residual(start, target), residual(end, target)
    theta = np.where(np.abs(at_start) <= np.abs(at_end), start, end)
    bracketed = at_start * at_end < 0.0
    if np.any(bracketed):
        wanted = target[bracketed]
        theta[bracketed] = bracketed_root(lambda x, i: residual(x, wanted[i]), start[bracketed], end[bracketed])
    return theta
