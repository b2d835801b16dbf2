"""Pushes that a person or a robot can set up: sides, places, angles and lengths of an object, and
how it is turned.
"""

from __future__ import annotations

import itertools
import math
from contextlib import suppress
from dataclasses import astuple, dataclass, replace

import numpy as np

from cyclemap.arrays import Array, placed
from cyclemap.checks import positive_number, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput, RodMissesObject
from cyclemap.evidence.predicted_strokes import push_from_contact
from cyclemap.evidence.pushes.measured_strokes import MeasuredDrag, MeasuredPush
from cyclemap.mechanics import Ellipse, Pose, SidePush, Slider
from cyclemap.mechanics.first_touch import first_contact

# Where on a side, how slanted (rad) and, by the size of the object, how long a push may be.
_FRACTIONS = (0.15, 0.3, 0.5, 0.7, 0.85)
_ANGLES = tuple(math.radians(angle) for angle in (-20.0, 0.0, 20.0))
_LENGTHS = (0.55, 1.1, 1.65)
# Places around an ellipse, whose whole outline is one side.
_AROUND = tuple((place + 0.5) / 16 for place in range(16))
_RULED = 5e-3
# A side shorter than this share of the longest is no place for a rod.
_SHORT = 0.3
# The rod comes in from so far before it touches, m.
APPROACH = 0.03


@dataclass(frozen=True)
class SetPush:
    """A push to be set up: how the rod pushes, and the pose that the object is put in before (m,
    rad).

    The pose is in the frame of the room, whose origin is the corner at its left and near side.
    """

    push: SidePush
    start: Pose

    def rod(self, slider: Slider, radius: float) -> Array:
        """Return where the rod's centre first touches and where it ends (2, 2), m in the frame of
        `start`.
        """
        measured = self.measured(slider, radius)
        return np.array((measured.tip_start, measured.tip_end))

    def measured(self, slider: Slider, radius: float) -> MeasuredPush:
        """Return the push as one that was measured, and has not moved the object."""
        return push_from_contact(slider, radius, self.push, self.start, self.start)

    def dragged(self, slider: Slider, end: Pose) -> MeasuredDrag:
        """Return the drag by the ring from the push's end to where the ring was before it, not
        turning the object.
        """
        x, y = self.start.to_world(*slider.hitch)
        lever_x, lever_y = Pose(theta=end.theta).to_world(*slider.hitch)
        return MeasuredDrag(end, Pose(x - lever_x, y - lever_y, end.theta))


def candidate_pushes(
    loop: CollectionLoop, count: int, grid: float | None, longest: float, seed: int
) -> tuple[SetPush, ...]:
    """Return at most `count` of the pushes that can be set up, a random choice of them, of all
    sides alike.

    grid : rad, between orientations that a hand sets; None: any, for a robot.
    longest : m, of a push.

    Raises InvalidInput for an object without a place for the rod, or a grid of more than a turn.
    """
    whole_number("seed", seed, least=0)
    if grid is not None and positive_number("grid", grid) > 2.0 * math.pi:
        raise InvalidInput(f"grid must be at most 2 pi rad, not {grid:g}")
    slider = loop.slider
    radius = loop.pusher.radius
    rng = np.random.default_rng(seed)
    size = math.sqrt(slider.outline.area)
    lengths = [_RULED * max(round(share * size / _RULED), 1) for share in _LENGTHS]
    lengths = [length for length in lengths if length <= longest] or [longest]
    contacts = []
    for side, fraction, angle in itertools.product(*_places(slider), _ANGLES):
        push = SidePush(side, fraction, angle, lengths[0])
        with suppress(InvalidInput, RodMissesObject):
            first_contact(slider, push, radius)
            contacts.append(push)
    if not contacts:
        raise InvalidInput(
            f"{slider.name} has no side that a rod of {1e3 * radius:.3g} mm can push"
        )
    rounds = -(-count // len(contacts))
    order = [*itertools.chain(*(rng.permutation(len(contacts)) for _ in range(rounds)))]
    offered = []
    for index in order[:count]:
        turned = rng.uniform(0.0, 2.0 * math.pi)
        if grid is not None:
            turned = grid * math.floor(turned / grid)
        push = replace(contacts[index], distance=float(rng.choice(lengths)))
        offered.append(SetPush(push, Pose(theta=turned)))
    return tuple(dict.fromkeys(offered))


def _places(slider: Slider) -> tuple[list[int], tuple[float, ...]]:
    """The sides that are long enough, and the places on each."""
    if isinstance(slider.outline, Ellipse):
        return [0], _AROUND
    corners = slider.outline.array
    length = np.hypot(*(np.roll(corners, -1, axis=0) - corners).T)
    return np.flatnonzero(length >= _SHORT * length.max()).tolist(), _FRACTIONS


def in_room(
    push: SetPush, ends: Array, loop: CollectionLoop, room: tuple[float, float]
) -> SetPush | None:
    """Return the push in the middle of a room (m); None where object and rod need more than that.

    ends (s, 3) : poses in which it may end, from the start pose of `push`.
    """
    outline = loop.slider.outline_points(60)
    first, last = push.rod(loop.slider, loop.pusher.radius)
    begin = np.array(astuple(push.start))
    reach = [placed(pose, outline) for pose in (begin, *ends)]
    reach += [first - APPROACH * (last - first) / push.push.distance, last]
    low, high = np.min(np.vstack(reach), axis=0), np.max(np.vstack(reach), axis=0)
    if np.any(high - low > room):
        return None
    x, y = np.round(begin[:2] + 0.5 * np.array(room) - 0.5 * (low + high), 3).tolist()
    return replace(push, start=Pose(x, y, push.start.theta))
