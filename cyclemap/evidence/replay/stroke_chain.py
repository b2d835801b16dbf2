"""Pushing along a chain of straight strokes: the contact goes on from one stroke to the next."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import read_only
from cyclemap.errors import UnsupportedContact
from cyclemap.evidence.replay.chain_run import ChainRun
from cyclemap.evidence.replay.rod_gap import rod_gap
from cyclemap.mechanics import Pose, PushResult, QuasiStaticModel, WorldPush
from cyclemap.mechanics.first_touch import first_touch

# Between its samples a predicted pose is taken to be straight: half a millimetre leaves under a micrometre.
SAMPLE_SPACING = 0.5e-3
# Gaps of touching rods are known to this, m.
_ROUNDING = 1e-7


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
        found = _stroke(model, pose, start, end, length)
        if found is not None:
            touch, push = found
            course = push.trajectory
            travels += [np.array([done + touch]), done + touch + course.path]
            poses += [poses[-1][-1:], course.pose]
            pose, touched = push.end, True
        left = touched and (found is None or found[1].ended == "left")
        done += length
        travels.append(np.array([done]))
        poses.append(poses[-1][-1:])
    travel = np.maximum.accumulate(np.concatenate(travels))
    return ChainRun(read_only(travel), read_only(np.concatenate(poses)), touched, left)


def _stroke(
    model: QuasiStaticModel, pose: Pose, start: Array, end: Array, length: float
) -> tuple[float, PushResult] | None:
    """Travel before the touch (m), and the push; None where the stroke does not touch the object."""
    place = (float(start[0]), float(start[1]))
    direction = math.atan2(*(end - start)[::-1].tolist())
    rod = np.array(pose.to_object(*place)) / model.unit
    if rod_gap(model, pose, place)[0] < -_ROUNDING:
        raise UnsupportedContact(f"the rod would enter the object at ({place[0]:.4f}, {place[1]:.4f}) m from behind")
    touch = first_touch(model.pieces, model.radius, rod, direction - pose.theta)
    if touch is None or touch[0] * model.unit >= length:
        return None
    return touch[0] * model.unit, model.push(pose, WorldPush(place, direction, length), SAMPLE_SPACING)
