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
    """The chain of the cells of some ``arcs`` until it enters an exit; ``lifted`` on the real line,
    else on the circle.

    exits : arcs, on the line with an end at ±inf.
    """

    parts: tuple[Cells, ...]
    exits: tuple[Arc, ...]
    lifted: bool

    def chances(self, *origins: Cells) -> tuple[Array, Array]:
        """(m, n): of going from these cells to those of the chain; (m, exits): of leaving by each
        exit.
        """
        starts = np.concatenate([part.edges[:-1] for part in self.parts])
        ends = np.concatenate([part.edges[1:] for part in self.parts])
        low, high = np.array(self.exits).T
        moves = [cells.between(starts, ends, self.lifted) for cells in origins]
        gone = [cells.between(low, high, self.lifted) for cells in origins]
        return np.concatenate(moves), np.concatenate(gone)

    def collected(
        self, image: float, each: float, at: Array, off: float = 0.0
    ) -> tuple[float, float]:
        """What a path with F(θ) = ``image`` collects on average: ``each`` a cycle, ``at[e]`` when
        it leaves by exit e.

        And what that changes, to first order, where every image may be ``off`` by so much, each to
        its own side. Paths that can leave no more collect nothing further, or for ever where
        ``each`` is above 0.
        """
        moves, gone = self.chances(*self.parts)
        begin = Cells(self.parts[0].halfwidth, np.zeros(2), np.full((2, 1), image), 0.0)
        step, left = (rows[0] for rows in self.chances(begin))
        out = gone.sum(axis=1)
        leads = _grown(out > 0.0, moves.T > 0.0)
        visited = _grown(step > 0.0, moves > 0.0)
        if each > 0.0 and np.any(visited & ~leads):
            return float("inf"), 0.0
        kept = np.flatnonzero(leads)
        lost = moves[np.ix_(kept, np.flatnonzero(~leads))].sum(axis=1)
        reward = each + gone[kept] @ at
        if not kept.size:
            return float(each + left @ at), 0.0
        chain = eliminated(moves[np.ix_(kept, kept)], out[kept] + lost)
        solved = chain.solve(reward)
        value = float(each + left @ at + step[kept] @ solved)
        if off == 0.0:
            return value, 0.0
        changes = []
        for way in (-off, off):
            moved, gone_then = self.chances(
                *(replace(part, ends=part.ends + way) for part in (*self.parts, begin))
            )
            changes.append(moved[:, kept] @ solved + gone_then @ at)
        here = np.append(moves[:, kept] @ solved + gone @ at, value - each)
        change = np.max(np.abs(np.array(changes) - here), axis=0)
        return value, float(change[-1] + step[kept] @ chain.solve(change[kept]))


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
    """What a path collects on average until it leaves the arcs: of ``mean_passage_time``,
    ``hitting_probability``.

    The arcs are cut into 512 cells, on each of which F is taken for straight; chances of going from
    cell to cell are exact then, and nothing is subtracted when the chain is eliminated.
    ``error_bound``: twice the difference from half as many cells, the error being of their second
    order, and what the map's ``max_error`` changes, to first order where every cell's image is off
    to its own side, or moved up and down by it; measured. inf where a part of the arcs that the
    path comes to is left by none of the cells' chances.

    Raises ConvergenceError where the bound, ``max_error`` apart, is above 2 %: where a passage
    hangs on a gap as narrow as a cell.
    """

    def value(count: int, shift: float = 0.0, off: float = 0.0) -> tuple[float, float]:
        whole = sum(high - low for low, high in arcs)
        parts = []
        for low, high in arcs:
            cells = cells_between(
                circle_map, halfwidth, low, high, max(8, round(count * (high - low) / whole))
            )
            parts.append(replace(cells, ends=cells.ends + shift))
        return CellChain(tuple(parts), exits, lifted).collected(
            float(circle_map(start)) + shift, each, at, off
        )

    error = circle_map.max_error
    (few, _), (many, moved) = value(_CELLS), value(2 * _CELLS, off=error)
    if np.isinf(many) and np.isinf(few):
        return Estimate(np.inf, 0.0)
    with np.errstate(invalid="ignore"):
        bound = 2.0 * abs(many - few) + SOLUTION * many
    if not bound <= max(_ACCEPTED * many, SOLUTION):
        raise ConvergenceError(
            f"the passage came out as {many:.6g} with error bound {bound:.2g}: it hangs on a gap "
            f"as narrow as a cell of the arcs; raise the halfwidth {halfwidth:g} or take a noise "
            "with a smooth density"
        )
    if error > 0.0:
        bound += max(moved, abs(value(_CELLS, error)[0] - value(_CELLS, -error)[0]))
    return Estimate(many, bound)
