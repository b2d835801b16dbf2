"""Pushing along a chain of straight strokes: the contact goes on from one to the next."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import read_only
from cyclemap.errors import InvalidInput, UnsupportedContact
from cyclemap.evidence.pushes.contact_forces import nearest_on_polyline
from cyclemap.mechanics import Pose, QuasiStaticModel, WorldPush
from cyclemap.mechanics.first_touch import first_touch

# More than this is no offset of a calibration: the record and the outline do not fit each other.
LARGEST_SHIFT = 5e-3
# Curved outlines are cut into pieces of a thousandth of their size: gaps are exact to 0.1 micrometre.
_PIECES = 3600
# What is left between rod and object after a shift.
_CLEARANCE = 1e-7
_MOST_SHIFTS = 10
# Between its samples a predicted pose is taken to be straight: half a millimetre leaves under a micrometre.
_SAMPLE_SPACING = 0.5e-3
# Gaps of touching rods are known to this, m.
_ROUNDING = 1e-7


@dataclass(frozen=True, eq=False)
class ChainRun:
    """The object's poses (n, 3), m and rad, at travels (n,), m along a chain of strokes, that never fall.

    touched : whether the rod ever pushed. left : whether it had lost the object by the end of the chain.
    """

    travel: Array
    pose: Array
    touched: bool
    left: bool

    def pose_at(self, travel: Array) -> Array:
        """Return the poses (..., 3) at travels (...), m."""
        return np.stack([np.interp(travel, self.travel, self.pose[:, column]) for column in range(3)], axis=-1)


def rod_gap(model: QuasiStaticModel, pose: Pose, place: tuple[float, float]) -> tuple[float, Array]:
    """Return the gap (m) between a rod at `place` (m, world frame) and the object, and the outward normal (2,) there.

    The gap is negative where the rod reaches into the object; the normal is in the world frame.
    """
    outline = model.slider.outline
    rod = np.array(pose.to_object(*place))
    corners = outline.points(_PIECES)
    (place_on,), (edge,) = nearest_on_polyline(rod[np.newaxis], corners)
    offset = rod - place_on
    distance = float(np.hypot(*offset))
    inside = bool(outline.contains(rod))
    outward = -offset if inside else offset
    if distance < 1e-12:
        # On the outline itself the edge's own normal points out.
        along = corners[edge + 1] - corners[edge]
        outward = np.array([along[1], -along[0]])
    outward = outward / np.hypot(*outward)
    gap = (-distance if inside else distance) - model.pusher.radius
    return gap, np.array(Pose(theta=pose.theta).to_world(*outward))


def clearing_shift(model: QuasiStaticModel, pose: Pose, place: tuple[float, float]) -> Array:
    """Return the least shift (2,), m, world frame, that takes a rod at `place` out of the object; zero outside.

    Along the outward normal, until rod and object are 0.1 micrometre apart. Raises InvalidInput where 5 mm are not
    enough: that is no offset between two calibrations.
    """
    shift = np.zeros(2)
    for _ in range(_MOST_SHIFTS):
        gap, normal = rod_gap(model, pose, (place[0] + float(shift[0]), place[1] + float(shift[1])))
        if gap >= 0.5 * _CLEARANCE:
            return shift
        shift = shift + (_CLEARANCE - gap) * normal
        if np.hypot(*shift) > LARGEST_SHIFT:
            break
    raise InvalidInput(
        f"the rod starts {1e3 * np.hypot(*shift):.3g} mm inside the object, more than the {1e3 * LARGEST_SHIFT:.0f} mm "
        "that a calibration may be off: check the object's outline and the rod's radius"
    )


def push_along(model: QuasiStaticModel, pose: Pose, corners: Array) -> ChainRun:
    """Push the object from `pose` with a rod that goes straight from corner to corner, (k, 2), m, world frame.

    Each stroke is a push of its own that starts where the last one ended, in contact or not: quasi-static motion has
    no memory. A rod that loses the object may find it again on a later stroke. Raises UnsupportedContact where the
    rod touches two sides at once or enters the object, ConvergenceError where the contact cannot be solved.
    """
    travels, poses = [np.zeros(1)], [np.array([[pose.x, pose.y, pose.theta]])]
    done, touched, left = 0.0, False, False
    for start, end in pairwise(corners):
        length = math.hypot(*(end - start))
        if length == 0.0:
            continue
        place, direction = (float(start[0]), float(start[1])), math.atan2(*(end - start)[::-1].tolist())
        if rod_gap(model, pose, place)[0] < -_ROUNDING:
            raise UnsupportedContact(
                f"the rod would enter the object at ({place[0]:.4f}, {place[1]:.4f}) m from behind"
            )
        rod = np.array(pose.to_object(*place)) / model.unit
        touch = first_touch(model.pieces, model.radius, rod, direction - pose.theta)
        left = touched
        if touch is not None and touch[0] * model.unit < length:
            push = model.push(pose, WorldPush(place, direction, length), _SAMPLE_SPACING)
            course, at = push.trajectory, done + touch[0] * model.unit
            travels += [np.array([at]), at + course.path]
            poses += [poses[-1][-1:], course.pose]
            pose, touched, left = push.end, True, push.ended == "left"
        done += length
        travels.append(np.array([done]))
        poses.append(poses[-1][-1:])
    travel = np.maximum.accumulate(np.concatenate(travels))
    return ChainRun(read_only(travel), read_only(np.concatenate(poses)), touched, left)
