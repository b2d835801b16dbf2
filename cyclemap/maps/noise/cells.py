"""Chances of going from cell to cell in one noisy cycle: exact where F is straight on each cell
(Ulam 1960).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.maps.estimate import EPS
from cyclemap.maps.lifts.circle_map import CircleMap

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
        shift = TWO_PI * np.floor(self.low / TWO_PI)
        low, high = self.low - shift, self.high - shift
        if start.size == 0:
            return np.zeros((low.size, 0))
        first = int(np.floor((-self.halfwidth - np.max(end)) / TWO_PI))
        last = int(np.ceil((np.max(high) + self.halfwidth - np.min(start)) / TWO_PI))
        total = np.zeros((low.size, start.size))
        for turn in TWO_PI * np.arange(first, last + 1):
            total += _chance_below(low, high, self.halfwidth, end + turn)
            total -= _chance_below(low, high, self.halfwidth, start + turn)
        return _without_rounding(total)


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
    """(n, m): P(x + ξ < line) for x uniform on [low, high], shape (n,), and ξ uniform on [-h,
    h]."""
    length = (high - low)[:, None]
    over, under = lines - low[:, None], lines - high[:, None]
    middle = 0.5 * (over + under)
    if halfwidth == 0.0:
        rising = np.maximum(over, 0.0) - np.maximum(under, 0.0)
        point = (middle > 0.0).astype(np.float64)
    else:
        inner, outer = (np.clip(part, -halfwidth, halfwidth) + halfwidth for part in (over, under))
        rising = (inner - outer) * (inner + outer) / (4.0 * halfwidth)
        rising += np.maximum(over - halfwidth, 0.0) - np.maximum(under - halfwidth, 0.0)
        point = np.clip((middle + halfwidth) / (2.0 * halfwidth), 0.0, 1.0)
    return np.asarray(np.where(length > _POINT, rising / np.maximum(length, _POINT), point))
