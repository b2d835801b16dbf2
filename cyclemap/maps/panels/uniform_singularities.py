"""Where the law of a map with uniform noise is not smooth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.orbits.scan import Cells, crossings, monotone_cells

_SAME = 1e-9  # radians: singular points nearer than this are one
_GENERATIONS = 8
_MOST = 1_500
_TURN_CELLS = 128


@dataclass(frozen=True, eq=False)
class Singularities:
    """Angles in [0, 2π), sorted; ``generation`` 0 is the roughest; ``root`` marks half-integer powers."""

    theta: Array
    generation: npt.NDArray[np.int64]
    root: npt.NDArray[np.bool_]

    def upto(self, generation: int) -> Singularities:
        """Those of this generation and rougher ones."""
        keep = self.generation <= generation
        return Singularities(self.theta[keep], self.generation[keep], self.root[keep])


def law_singularities(circle_map: CircleMap, cells: Cells, halfwidth: float) -> Singularities:
    """The points F(break±) ± h and (critical value) ± h, and F(those) ± h, each image one power smoother.

    A break makes the density kink (or jump, where F is flat beside it), a critical value gives it a square root.
    """
    values, root = _sources(circle_map, cells)
    ends = _trap_ends(circle_map, halfwidth)
    values, root = np.append(values, circle_map(ends)), np.append(root, np.zeros(ends.size, dtype=bool))
    theta, generation, roots = np.zeros(0), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=bool)
    for step in range(_GENERATIONS):
        latest = np.mod(np.concatenate([values - halfwidth, values + halfwidth]), TWO_PI)
        theta = np.append(theta, latest)
        generation = np.append(generation, np.full(latest.size, step))
        roots = np.append(roots, np.tile(root, 2))
        theta, generation, roots = _merged(theta, generation, roots)
        now = generation == step
        if theta.size > _MOST or not np.any(now):
            break
        values, root = circle_map(theta[now]), roots[now]
    return Singularities(theta, generation, roots)


def _sources(circle_map: CircleMap, cells: Cells) -> tuple[Array, npt.NDArray[np.bool_]]:
    """One-sided values at the breaks, and the values at the smooth extrema of F (True)."""
    at_breaks = np.concatenate([circle_map.left(circle_map.breaks), circle_map.right(circle_map.breaks)])
    rising = np.sign(cells.g_end - cells.g_start)
    turning = (rising * np.roll(rising, 1) < 0.0) & ~cells.cut
    extrema = cells.g_start[turning]
    values = np.append(at_breaks, extrema)
    return values, np.arange(values.size) >= at_breaks.size


def _trap_ends(circle_map: CircleMap, halfwidth: float) -> Array:
    """The fixed points of F ± h: where the support of a law trapped in an arc ends, smooth but not analytic."""
    turning = monotone_cells(circle_map, 1, 1.0, _TURN_CELLS)
    found = [crossings(circle_map, turning, level)[0] for level in (-halfwidth, halfwidth)]
    return np.concatenate(found)


def _merged(
    theta: Array, generation: npt.NDArray[np.int64], root: npt.NDArray[np.bool_]
) -> tuple[Array, npt.NDArray[np.int64], npt.NDArray[np.bool_]]:
    """Sorted, with points that are the same joined into the roughest of them."""
    order = np.argsort(theta, kind="stable")
    theta, generation, root = theta[order], generation[order], root[order]
    group = np.cumsum(np.diff(theta, prepend=theta[:1]) > _SAME)
    leader = np.lexsort((~root, generation, group))
    leader = leader[np.diff(group[leader], prepend=-1) > 0]
    return theta[leader], generation[leader], root[leader]
