"""The forces of the ground on the points under an object at one instant of a push."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cyclemap.arrays import Array
from cyclemap.collection.loop import CollectionLoop
from cyclemap.mechanics import PointFootprint, grid_footprint

GRID = 8
# The instant is after this share of the push's way.
SHARE = 0.3
_STEPS = 1000


@dataclass(frozen=True, eq=False)
class PatchForces:
    """The forces on the patch during one push, in the object's frame.

    angle : rad, of the object. footprint : its points. twist : (3,) m, m, rad per metre of the rod's way.
    velocity, force : (k, 2) of the points, the second in N, of the ground on the object. wrench : (3,) N, N, N m, of
    the ground on the object about its centre; rod : of the rod on it. contact : (2,) m. outline : (5, 2) m, closed.
    """

    angle: float
    footprint: PointFootprint
    twist: Array
    velocity: Array
    force: Array
    wrench: Array
    rod: Array
    contact: Array
    outline: Array


def patch_forces(loop: CollectionLoop, theta: float = 0.0) -> PatchForces:
    """Return the forces on the 8 x 8 grid of `loop` during its push from `theta` (rad).

    The twist is the slope of the computed course, by central differences; that it balances the rod is not used.
    """
    footprint = grid_footprint(loop.slider.outline, GRID)
    gridded = replace(loop, footprint=footprint)
    course = gridded.model.push(gridded.start_pose(theta), loop.push, loop.push.distance / _STEPS).trajectory
    at = int(np.searchsorted(course.path, SHARE * course.path[-1]))
    pose = course.pose[at]
    slope = (course.pose[at + 1] - course.pose[at - 1]) / (course.path[at + 1] - course.path[at - 1])
    twist = np.array([*_turned_back(slope[:2], pose[2]), slope[2]])
    points, weights = footprint.quadrature
    velocity = twist[:2] + twist[2] * np.stack([-points[:, 1], points[:, 0]], axis=-1)
    friction, load = loop.material.friction, gridded.model.weight
    force = -load * weights[:, None] * friction.traction(velocity, pose[2])
    wrench = np.array([*force.sum(axis=0), _torque(points, force).sum()])
    contact = _turned_back(course.contact_point[at] - pose[:2], pose[2])
    push = _turned_back(course.contact_force[at], pose[2])
    rod = np.array([*push, float(_torque(contact, push))])
    outline = loop.slider.outline.points(4)
    return PatchForces(float(pose[2]), footprint, twist, velocity, force, wrench, rod, contact, outline)


def _turned_back(vector: Array, angle: float) -> Array:
    """A vector of the world in the object's frame at `angle` (rad)."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * vector[0] + s * vector[1], -s * vector[0] + c * vector[1]])


def _torque(lever: Array, force: Array) -> Array:
    return np.asarray(lever[..., 0] * force[..., 1] - lever[..., 1] * force[..., 0])
