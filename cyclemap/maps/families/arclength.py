"""Curves of orbits followed in their arclength (Keller 1977): how far a step goes, where the range
ends, loops that close.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Self

import numpy as np

from cyclemap.arrays import Array, shorter_way
from cyclemap.maps.families.family import Range

FIRST = 0.01  # scaled arclength of the first step
SMALLEST = 1e-8  # of a step that finds no way on
STRAIGHT = 0.95  # cosine of the largest turn of the tangent in one step
_LARGEST = 0.06
_GROWTH = 1.5
_MOST_STEPS = 4_000


@dataclass(eq=False, kw_only=True)
class ArclengthWalk:
    """A walk along a curve from ``at[0]`` in the direction ``initial``: where it has been, why it
    ended.

    at : scaled coordinates, angles of the orbit first, then its parameters, as many as ``ranges``.
    """

    scales: Array
    ranges: tuple[Range, ...]
    initial: Array
    at: list[Array]
    step: float = FIRST
    reason: str = ""
    direction: Array = field(init=False)

    def walked(self) -> Self:
        """The walk, once it has ended."""
        self.direction = self.initial
        while not self.reason:
            if len(self.at) > _MOST_STEPS:
                self.reason = "steps"
            elif self.step < SMALLEST:
                self.stop()
            else:
                self.advance()
        return self

    def stop(self) -> None:
        """End where steps have become too small."""
        self.reason = "lost"

    def advance(self) -> None:
        """One attempt at a step: it succeeds, ends the walk, or halves the step."""
        raise NotImplementedError

    def angles(self, at: Array) -> Array:
        """The angles of these coordinates, radians."""
        count = len(self.ranges)
        return at[:-count] * self.scales[:-count]

    def ahead(self) -> tuple[float, Array, bool]:
        """The length of the next step, across what it is corrected, and whether it leads to an end
        of the ranges.
        """
        here = self.at[-1]
        length = self.step
        row = self.direction
        at_end = False
        for k, (low, high) in enumerate(self.ranges, start=-len(self.ranges)):
            climb = float(self.direction[k])
            end = (high if climb > 0.0 else low) / self.scales[k]
            room = max((end - here[k]) / climb, 0.0) if climb else np.inf
            if room <= length:
                length = room
                row = np.eye(here.size)[k]
                at_end = True
        return length, row, at_end

    def taken(self, there: Array, direction: Array) -> None:
        """Go on to ``there``, or to the first solution where the step passes it, but for whole
        turns and the choice of the first point.
        """
        first = self._passed(there, direction)
        self.at.append(there if first is None else first)
        self.reason = "" if first is None else "closed"
        self.direction = direction
        self.step = min(_GROWTH * self.step, _LARGEST)

    def _passed(self, there: Array, direction: Array) -> Array | None:
        begin = self.at[0]
        here = self.at[-1]
        moved = there - here
        length = float(np.linalg.norm(moved))
        count = len(self.ranges)
        away = begin[-count:] - here[-count:]
        if len(self.at) < 6 or np.linalg.norm(away) > 1.5 * length:
            return None
        turn = self.scales[0]
        for k in range(begin.size - count):
            back = shorter_way(turn * (np.roll(begin[:-count], -k) - here[:-count])) / turn
            offset: Array = np.append(back, away)
            share = float(offset @ moved) / length**2
            heading = np.append(np.roll(self.initial[:-count], -k), self.initial[-count:])
            near = np.linalg.norm(offset - share * moved) < 0.3 * length
            if 0.0 < share <= 1.0 and near and heading @ direction > 0.5:
                return here + offset
        return None
