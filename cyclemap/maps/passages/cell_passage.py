"""Cells of angles under noise whose density jumps: chances of going from one to another in a cycle,
exact where F is straight on each cell (Ulam 1960), and passages by them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Mask
from cyclemap.errors import ConvergenceError
from cyclemap.maps.estimate import EPS, SOLUTION, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.bounded_noise import wrapped_window
from cyclemap.maps.passages.killed_chain import Arc, eliminated

_POINT = 1e-7  # radians: images shorter than this are points
_APART = 1e-9  # radians: a break nearer to an edge of a cell is that edge
_CHORD = 1.25  # times the distance from its chord that three points of a cell show of F
_NONE = 1e-11  # chances that may be rounding


@dataclass(frozen=True, eq=False)
class Cells:
    """Neighbouring cells, the images on which F runs straight from end to end, and ξ uniform on
    [-h, h], or 0.

    Parameters
    ----------
    halfwidth : h, radians. edges : (n + 1,), radians, rising.
    ends : (2, n), radians, lifted: F at the start and the end of every cell, from inside.
    bend : radians, how far F, with its ``max_error``, may lie from straight.
    """

    halfwidth: float
    edges: Array
    ends: Array
    bend: float

    @property
    def width(self) -> Array:
        """(n,): the cells' lengths."""
        return np.diff(self.edges)

    @cached_property
    def low(self) -> Array:
        """(n,): the lower ends of the images."""
        return np.asarray(self.ends.min(axis=0))

    @cached_property
    def high(self) -> Array:
        """(n,): the upper ends."""
        return np.asarray(self.ends.max(axis=0))

    @property
    def rounding(self) -> float:
        """What the chances of one cell, added up, may be off by rounding."""
        shortest = max(float(np.min(self.high - self.low)), _POINT)
        return 64.0 * EPS * (TWO_PI + self.halfwidth) / shortest + _NONE * self.width.size

    def below(self, lines: Array) -> Array:
        """(n, m): the chance of being below each line on the real line a cycle later; lines may be
        infinite.
        """
        finite = np.isfinite(lines)
        chances = _chance_below(self.low, self.high, self.halfwidth, np.where(finite, lines, 0.0))
        return np.where(finite, chances, (lines > 0.0).astype(np.float64))

    def between(self, start: Array, end: Array, lifted: bool = False) -> Array:
        """(n, m): the chance of being in each arc from start to end, mod 2π, or ``lifted`` on the
        real line.
        """
        if lifted:
            return _without_rounding(self.below(end) - self.below(start))
        if start.size == 0:
            return np.zeros((self.width.size, 0))
        share, window, centre = wrapped_window(self.halfwidth)
        shift = TWO_PI * np.floor(self.low / TWO_PI) - centre
        low = self.low - shift
        high = self.high - shift
        begin = start - TWO_PI * np.floor(start / TWO_PI)
        laps = np.floor((end - start) / TWO_PI)  # of the arc
        rest = end - start - TWO_PI * laps
        most = int(np.ceil((np.max(high) + window) / TWO_PI))
        total = np.zeros((low.size, start.size))
        for turn in TWO_PI * np.arange(-2, most + 1):
            total += _chance_below(low, high, window, begin + rest + turn)
            total -= _chance_below(low, high, window, begin + turn)
        return _without_rounding(laps + share * rest / TWO_PI + (1.0 - share) * total)


def cells_between(
    circle_map: CircleMap, halfwidth: float, start: float, end: float, count: int
) -> Cells:
    """``count`` even cells from start to end, cut at F's breaks."""
    even = np.linspace(start, end, count + 1)
    turns = TWO_PI * np.arange(np.floor(start / TWO_PI), np.ceil(end / TWO_PI) + 1.0)
    breaks = np.add.outer(turns, circle_map.breaks).ravel()
    after = np.searchsorted(even, breaks).clip(1, count)
    apart = np.minimum(np.abs(even[after] - breaks), np.abs(even[after - 1] - breaks)) > _APART
    edges = np.union1d(even, breaks[apart & (breaks > start) & (breaks < end)])
    ends = np.stack([circle_map.right(edges[:-1]), circle_map.left(edges[1:])])
    share = np.array([[0.25], [0.5], [0.75]])
    off = np.abs(
        circle_map(edges[:-1] + share * np.diff(edges)) - ends[0] - share * (ends[1] - ends[0])
    )
    return Cells(
        halfwidth, edges, ends, _CHORD * float(np.max(off)) + _POINT + circle_map.max_error
    )


def _without_rounding(chances: Array) -> Array:
    return np.where(chances > _NONE, chances, 0.0)


def _chance_below(low: Array, high: Array, halfwidth: float, lines: Array) -> Array:
    """(n, m): P(x + ξ < line) for x uniform on [low, high], shape (n,), and ξ uniform
    on [-h, h]."""
    length = (high - low)[:, None]
    over = lines - low[:, None]
    under = lines - high[:, None]
    middle = 0.5 * (over + under)
    if halfwidth == 0.0:
        rising = np.maximum(over, 0.0) - np.maximum(under, 0.0)
        point = (middle > 0.0).astype(np.float64)
    else:
        inner, outer = (np.clip(part, -halfwidth, halfwidth) + halfwidth for part in (over, under))
        rising = (inner - outer) * (inner + outer) / (4.0 * halfwidth)
        rising += np.maximum(over - halfwidth, 0.0) - np.maximum(under - halfwidth, 0.0)
        point = np.clip((middle + halfwidth) / (2.0 * halfwidth), 0.0, 1.0)
    return np.where(length > _POINT, rising / np.maximum(length, _POINT), point)


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
