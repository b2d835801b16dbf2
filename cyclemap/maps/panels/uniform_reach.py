"""From where on an arc a path under bounded noise can reach a set at all: exact sets of intervals, no chances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.orbits.scan import Cells
from cyclemap.maps.panels.level_steps import level_steps

_SLIVER = 1e-12  # radians: an overlap no longer than this is none
_GROWTH = 1e-11  # radians: a set that grows by less in a cycle has stopped
_CYCLES = 3_000


@dataclass(frozen=True, eq=False)
class Intervals:
    """Disjoint intervals (start, end), sorted, on the line, or with ``wrapped`` on the circle (any turn)."""

    start: Array
    end: Array
    wrapped: bool

    @property
    def length(self) -> float:
        """Their total length."""
        return float(np.sum(self.end - self.start))

    def overlaps(self, low: Array, high: Array) -> npt.NDArray[np.bool_]:
        """Whether each (low, high) shares more than a point with one of the intervals."""
        low, high = low[:, None] + _SLIVER, high[:, None] - _SLIVER
        if not self.wrapped:
            return np.asarray(np.any((low < self.end) & (self.start < high), axis=1))
        # The first whole turn that lifts the interval's end above ``low`` must leave its start below ``high``.
        turns = np.floor((low - self.end) / TWO_PI) + 1.0
        return np.asarray(np.any(self.start + TWO_PI * turns < high, axis=1))

    def hold(self, theta: Array) -> npt.NDArray[np.bool_]:
        """Whether each angle lies inside one of the intervals, ends left out."""
        return self.overlaps(theta - 2.0 * _SLIVER, theta + 2.0 * _SLIVER)


@dataclass(frozen=True, eq=False)
class Reach:
    """The noisy map on a domain: the intervals inside ``domain`` from which paths go on."""

    map: CircleMap
    cells: Cells
    halfwidth: float
    domain: Intervals

    def basin(self, target: Intervals) -> Intervals:
        """The part of the domain from which the path is in ``target`` later on with a chance above zero.

        Grown backward a cycle at a time until it stops growing: x belongs to it when (F(x) - h, F(x) + h) meets the
        target or the basin so far. A domain that takes more than 3000 cycles to cross (a gap that opens by less
        than about 1e-6 of its width) is left as it is then: chances there are below 1e-300.
        """
        found = self.before(target, _none(target.wrapped))
        for _ in range(_CYCLES):
            more = self.before(target, found)
            if more.length <= found.length + _GROWTH:
                break
            found = more
        return found

    def before(self, target: Intervals, basin: Intervals) -> Intervals:
        """The part of the domain whose next positions meet ``target`` or ``basin``."""
        wanted = Intervals(np.append(target.start, basin.start), np.append(target.end, basin.end), target.wrapped)
        pieces = self._pieces(wanted)
        middle = self.map(0.5 * (pieces[1:] + pieces[:-1]))
        inside = self.domain.hold(0.5 * (pieces[1:] + pieces[:-1]))
        meets = inside & wanted.overlaps(middle - self.halfwidth, middle + self.halfwidth)
        return _joined(pieces, meets, target.wrapped)

    def without(self, part: Intervals) -> Intervals:
        """The domain less ``part`` (some of it): what is left."""
        pieces = np.unique(np.concatenate([self.domain.start, self.domain.end, part.start, part.end]))
        middle = 0.5 * (pieces[1:] + pieces[:-1])
        kept = self.domain.hold(middle) & ~part.hold(middle) & (np.diff(pieces) > _GROWTH)
        return _joined(pieces, kept, self.domain.wrapped)

    def _pieces(self, wanted: Intervals) -> Array:
        """Ends of pieces of the domain on each of which all next positions meet the same of the intervals."""
        ends = np.concatenate([wanted.start + self.halfwidth, wanted.start - self.halfwidth])
        ends = np.concatenate([ends, wanted.end + self.halfwidth, wanted.end - self.halfwidth])
        return self.cut(self.preimages(ends[np.isfinite(ends)]))

    def preimages(self, levels: Array) -> Array:
        """Angles of [0, 2π) whose images, up to whole turns, are among ``levels``; F's breaks with them."""
        steps = level_steps(self.map, self.cells, np.mod(levels, TWO_PI))
        return np.append(steps.theta, self.map.breaks)

    def cut(self, theta: Array) -> Array:
        """The domain's ends and all turns of ``theta`` between them, sorted."""
        low, high = float(self.domain.start[0]), float(self.domain.end[-1])
        first = low + np.mod(theta - low, TWO_PI)
        inner = np.concatenate([self.domain.start, self.domain.end, first, np.mod(theta, TWO_PI)])
        return np.unique(inner[(inner >= low) & (inner <= high)])


def _none(wrapped: bool) -> Intervals:
    return Intervals(np.zeros(0), np.zeros(0), wrapped)


def _joined(pieces: Array, keep: npt.NDArray[np.bool_], wrapped: bool) -> Intervals:
    """The kept pieces, neighbours joined."""
    edge = np.diff(np.concatenate([[False], keep, [False]]).astype(np.int64))
    return Intervals(pieces[edge == 1], pieces[edge == -1], wrapped)
