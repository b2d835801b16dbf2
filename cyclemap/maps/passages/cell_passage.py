"""Passages under noise whose density jumps, by chances of going from cell to cell (Ulam)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cyclemap.arrays import Array, Mask
from cyclemap.errors import ConvergenceError
from cyclemap.maps.estimate import SOLUTION, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.cells import Cells, cells_between
from cyclemap.maps.passages.killed_chain import Arc, eliminated

_CELLS = 256  # of the arcs together, and twice as many for the error
_ACCEPTED = 0.02  # relative error bound


@dataclass(frozen=True, eq=False)
class CellChain:
    """The chain of the cells of some ``arcs`` until it enters an exit; ``lifted`` on the real line, else on the circle.

    exits : arcs, on the line with an end at ±inf.
    """

    parts: tuple[Cells, ...]
    exits: tuple[Arc, ...]
    lifted: bool

    def chances(self, cells: Cells) -> tuple[Array, Array]:
        """(m, n): of going from ``cells`` to those of the chain; (m, exits): of leaving by each exit."""
        starts = np.concatenate([part.edges[:-1] for part in self.parts])
        ends = np.concatenate([part.edges[1:] for part in self.parts])
        low, high = np.array(self.exits).T
        return cells.between(starts, ends, self.lifted), cells.between(low, high, self.lifted)

    def collected(self, image: float, each: float, at: Array) -> float:
        """What a path with F(θ) = ``image`` collects on average: ``each`` a cycle, ``at[e]`` when it leaves by exit e.

        Paths that can leave no more collect nothing further, or for ever where ``each`` is above 0.
        """
        rows = [self.chances(part) for part in self.parts]
        moves, gone = (np.concatenate(part) for part in zip(*rows, strict=True))
        begin = Cells(self.parts[0].halfwidth, np.zeros(2), np.full((2, 1), image), 0.0)
        step, left = (row[0] for row in self.chances(begin))
        out = gone.sum(axis=1)
        leads = _grown(out > 0.0, moves.T > 0.0)
        visited = _grown(step > 0.0, moves > 0.0)
        if each > 0.0 and np.any(visited & ~leads):
            return float("inf")
        kept = np.flatnonzero(visited & leads)
        lost = moves[np.ix_(kept, np.flatnonzero(~leads))].sum(axis=1)
        reward = each + gone[kept] @ at
        solved = eliminated(moves[np.ix_(kept, kept)], out[kept] + lost).solve(reward) if kept.size else reward
        return float(each + left @ at + step[kept] @ solved)


def _grown(mask: Mask, leads: Mask) -> Mask:
    """All states that are reached from those of ``mask``, leads[i, j] saying that i leads to j."""
    while True:
        more = mask | np.any(leads[mask], axis=0)
        if np.array_equal(more, mask):
            return mask
        mask = more


def cell_passage(
    circle_map: CircleMap,
    halfwidth: float,
    start: float,
    arcs: tuple[Arc, ...],
    exits: tuple[Arc, ...],
    lifted: bool,
    each: float,
    at: Array,
) -> Estimate:
    """What a path collects on average until it leaves the arcs: of ``mean_passage_time``, ``hitting_probability``.

    The arcs are cut into 512 cells, on each of which F is taken for straight; chances of going from cell to cell are
    exact then, and nothing is subtracted when the chain is eliminated. ``error_bound``: twice the difference from half
    as many cells, the error being of their second order, and what the map's ``max_error`` changes, moved up and down by
    it; measured. inf where a part of the arcs that the path comes to is left by none of the cells' chances.

    Raises ConvergenceError where the bound is above 2 %: where a passage hangs on a gap as narrow as a cell.
    """

    def value(count: int, shift: float = 0.0) -> float:
        whole = sum(high - low for low, high in arcs)
        parts = []
        for low, high in arcs:
            cells = cells_between(circle_map, halfwidth, low, high, max(8, round(count * (high - low) / whole)))
            parts.append(replace(cells, ends=cells.ends + shift))
        return CellChain(tuple(parts), exits, lifted).collected(float(circle_map(start)) + shift, each, at)

    few, many = value(_CELLS), value(2 * _CELLS)
    if np.isinf(many) and np.isinf(few):
        return Estimate(np.inf, 0.0)
    with np.errstate(invalid="ignore"):
        bound = 2.0 * abs(many - few) + SOLUTION * many
    if circle_map.max_error > 0.0:
        bound += abs(value(_CELLS, circle_map.max_error) - value(_CELLS, -circle_map.max_error))
    if not bound <= max(_ACCEPTED * many, SOLUTION):
        raise ConvergenceError(
            f"the passage came out as {many:.6g} with error bound {bound:.2g}: it hangs on a gap as narrow as a cell "
            f"of the arcs; raise the halfwidth {halfwidth:g} or take a noise with a smooth density"
        )
    return Estimate(many, bound)
