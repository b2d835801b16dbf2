"""The way of the rod's tip as a chain of straight strokes, and how far along it the rod is at any time."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, positive_number, read_only
from cyclemap.errors import InvalidInput

# Recorded tips of straight strokes wander by up to 0.15 mm: a bend is more than twice that.
BEND = 0.3e-3
# A tip that goes less far than this does not push.
SHORTEST_PATH = 1e-3


@dataclass(frozen=True, eq=False)
class TipPath:
    """A path of straight strokes from corner to corner.

    corners : (k, 2) m, in the world frame. time : (m,) s. travel : (m,) m along the chain at those times; it never
    falls. straightness : largest distance (m) of a recorded place from the chord between the first and the last.
    """

    corners: Array
    time: Array
    travel: Array
    straightness: float

    @property
    def start(self) -> tuple[float, float]:
        """Where the tip starts, m."""
        x, y = self.corners[0].tolist()
        return x, y

    @property
    def strokes(self) -> int:
        """How many straight strokes the path has."""
        return len(self.corners) - 1

    @property
    def length(self) -> float:
        """Length of the chain, m."""
        return float(np.hypot(*np.diff(self.corners, axis=0).T).sum())

    def travel_at(self, time: Array) -> Array:
        """Return the travel (m) at times (...), s: that of the ends before and after the record."""
        return np.asarray(np.interp(time, self.time, self.travel))

    def place_at(self, travel: Array) -> Array:
        """Return the places (..., 2), m, at travels (...), m."""
        at = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(self.corners, axis=0).T))])
        return np.stack([np.interp(travel, at, self.corners[:, axis]) for axis in (0, 1)], axis=-1)


def tip_path(tip_pose: Array, bend: float = BEND) -> TipPath:
    """Return the chain of straight strokes that stays within `bend` (m) of a recorded tip.

    tip_pose : (m, 3 or more): time (s), x (m), y (m), and what else is recorded. The corners are recorded places,
    chosen by halving at the farthest place (Ramer 1972; Douglas & Peucker 1973). Raises InvalidInput where the tip
    moves less than 1 mm.

    >>> path = tip_path(np.array([[0.0, 0.0, 0.0], [1.0, 0.03, 0.0], [2.0, 0.03, 0.02]]))
    >>> path.strokes, path.travel.round(3).tolist()
    (2, [0.0, 0.03, 0.05])
    """
    table = finite_array("tip pose", tip_pose, ndim=2)
    place = table[:, 1:3]
    corners = _corners(place, positive_number("bend", bend))
    travel = _travel(place, corners)
    if travel[-1] < SHORTEST_PATH:
        raise InvalidInput(f"the tip moves {1e3 * travel[-1]:.2g} mm: it pushes nothing")
    straightness = float(_from_chord(place).max())
    return TipPath(read_only(place[corners]), read_only(table[:, 0]), read_only(travel), straightness)


def _from_chord(place: Array) -> Array:
    """Distance of each place from the segment between the first and the last."""
    chord, offset = place[-1] - place[0], place - place[0]
    square = float(chord @ chord)
    share = np.clip(offset @ chord / square, 0.0, 1.0) if square > 0.0 else np.zeros(len(place))
    return np.asarray(np.hypot(*(offset - share[:, None] * chord).T))


def _corners(place: Array, bend: float) -> list[int]:
    kept, spans = {0, len(place) - 1}, [(0, len(place) - 1)]
    while spans:
        first, last = spans.pop()
        off = _from_chord(place[first : last + 1])
        farthest = int(off.argmax())
        if off[farthest] > bend:
            kept.add(first + farthest)
            spans += [(first, first + farthest), (first + farthest, last)]
    return sorted(kept)


def _travel(place: Array, corners: list[int]) -> Array:
    """Travel along the chain at each recorded place: its projection on its stroke, never falling."""
    travel = np.zeros(len(place))
    for first, last in pairwise(corners):
        chord = place[last] - place[first]
        length = float(np.hypot(*chord))
        if length > 0.0:
            along = (place[first : last + 1] - place[first]) @ (chord / length)
            travel[first : last + 1] = travel[first] + np.clip(along, 0.0, length)
    return np.maximum.accumulate(travel)
