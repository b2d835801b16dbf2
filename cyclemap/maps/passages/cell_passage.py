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
    """The chain of the cells of some arcs until it enters an exit; ``lifted`` on the real line,
    else on the circle.

    origins : where the path begins, a cell without length, and the cells of each arc.
    exits : arcs, on the line with an end at ±inf.
    """

    origins: tuple[Cells, ...]
    exits: tuple[Arc, ...]
    lifted: bool

    def moved(self, shift: float) -> CellChain:
        """The same for F + ``shift``."""
        moved = tuple(replace(cells, ends=cells.ends + shift) for cells in self.origins)
        return replace(self, origins=moved)

    def chances(self) -> tuple[Array, Array]:
        """(1 + n, n): of going from the start and each of the n cells to the cells; (1 + n, exits):
        of leaving by each exit.
        """
        low = np.concatenate([cells.edges[:-1] for cells in self.origins[1:]])
        high = np.concatenate([cells.edges[1:] for cells in self.origins[1:]])
        starts, ends = np.array(self.exits).T
        moves = [cells.between(low, high, self.lifted) for cells in self.origins]
        gone = [cells.between(starts, ends, self.lifted) for cells in self.origins]
        return np.concatenate(moves), np.concatenate(gone)

    def collected(self, each: float, at: Array, off: float = 0.0) -> tuple[float, float]:
        """What a path collects on average: ``each`` a cycle, ``at[e]`` when it leaves by exit e.

        And what that changes, to first order, where every image may be ``off`` by so much, each to
        its own side. Paths that can leave no more collect nothing further, or for ever where
        ``each`` is above 0.
        """
        moves, gone = self.chances()
        inner = moves[1:]
        out = gone[1:].sum(axis=1)
        leads = _grown(out > 0.0, inner.T > 0.0)
        visited = _grown(moves[0] > 0.0, inner > 0.0)
        if each > 0.0 and np.any(visited & ~leads):
            return float("inf"), 0.0
        kept = np.flatnonzero(leads)
        if not kept.size:
            return float(each + gone[0] @ at), 0.0
        lost = inner[np.ix_(leads, ~leads)].sum(axis=1)
        chain = eliminated(inner[np.ix_(kept, kept)], out[kept] + lost)
        solved = chain.solve(each + gone[1 + kept] @ at)
        here = gone @ at + moves[:, kept] @ solved
        change = np.zeros_like(here)
        for shift in (-off, off) if off else ():
            there, gone_there = self.moved(shift).chances()
            change = np.maximum(change, np.abs(gone_there @ at + there[:, kept] @ solved - here))
        later = moves[0, kept] @ chain.solve(change[1 + kept])
        return float(each + here[0]), float(change[0] + later)


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
    whole = sum(high - low for low, high in arcs)
    begin = Cells(halfwidth, np.zeros(2), np.full((2, 1), float(circle_map(start))), 0.0)

    def chain(count: int) -> CellChain:
        cells = []
        for low, high in arcs:
            share = max(8, round(count * (high - low) / whole))
            cells.append(cells_between(circle_map, halfwidth, low, high, share))
        return CellChain((begin, *cells), exits, lifted)

    few = chain(_CELLS)
    many = chain(2 * _CELLS)
    error = circle_map.max_error
    value, moved = many.collected(each, at, error)
    coarse, _ = few.collected(each, at)
    if np.isinf(value) and np.isinf(coarse):
        return Estimate(np.inf, 0.0)
    with np.errstate(invalid="ignore"):
        bound = 2.0 * abs(value - coarse) + SOLUTION * value
    if not bound <= max(_ACCEPTED * value, SOLUTION):
        raise ConvergenceError(
            f"the passage came out as {value:.6g} with error bound {bound:.2g}: it hangs on a gap "
            f"as narrow as a cell of the arcs; raise the halfwidth {halfwidth:g} or take a noise "
            "with a smooth density"
        )
    if error > 0.0:
        above, below = (few.moved(shift).collected(each, at)[0] for shift in (error, -error))
        bound += max(moved, abs(above - below))
    return Estimate(value, bound)
