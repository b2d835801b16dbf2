"""Worlds in which planned pushes are made: this package's own, its dynamic simulation, MuJoCo."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy.interpolate import CubicSpline

import cyclemap as cm
from cyclemap.collection import DynamicLoop
from cyclemap.mechanics import DynamicModel, Ellipse, Pose, SidePush, WorldPush
from cyclemap.mechanics.contact_curve import contact_curve, first_contact, first_touches

# Of the rod in the dynamic simulation, m/s: twice that of most of MIT's pushes.
SPEED = 0.02
# Orientations at which a world's own map is measured.
MAPPED = 24


class World(Protocol):
    """What a person does with an object on a floor: push it by a rod, drag it by its ring."""

    def push(self, pose: Pose, push: WorldPush) -> Pose:
        """Return where a rod that comes from afar leaves the object."""

    def drag(self, pose: Pose, goal: tuple[float, float]) -> Pose:
        """Return where the object is when its ring has come to a place."""


@dataclass(frozen=True)
class OwnWorld:
    """The quasi-static model, at a ten-thousandth of the error that identification works with."""

    loop: cm.CollectionLoop

    def push(self, pose: Pose, push: WorldPush) -> Pose:
        return self.loop.model.push(pose, push).end

    def drag(self, pose: Pose, goal: tuple[float, float]) -> Pose:
        radius = self.loop.reset.pin_friction_radius
        return self.loop.model.drag(pose, (goal,), pin_friction_radius=radius).end


@dataclass(frozen=True)
class DynamicWorld:
    """The dynamic simulation: inertia, and a contact that gives way."""

    loop: cm.CollectionLoop

    @cached_property
    def model(self) -> DynamicModel:
        """The simulation at the speed of its rod."""
        return DynamicLoop(self.loop, speed=SPEED).model

    def push(self, pose: Pose, push: WorldPush) -> Pose:
        side = pushed_side(self.loop, pose, push)
        return self.model.push(pose, side, samples=2).end

    def drag(self, pose: Pose, goal: tuple[float, float]) -> Pose:
        radius = self.loop.reset.pin_friction_radius
        return self.model.drag(pose, (goal,), 2, radius).end


def pushed_side(loop: cm.CollectionLoop, pose: Pose, push: WorldPush) -> SidePush:
    """Return a rod's straight way as a push of the side of a polygon that it first touches."""
    outline, radius = loop.slider.outline, loop.pusher.radius
    assert not isinstance(outline, Ellipse)
    start = np.array(push.start) - (pose.x, pose.y)
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    local = np.array(((c, s), (-s, c))) @ start
    direction = push.direction - pose.theta
    pieces = contact_curve(outline, radius).pieces
    travels, _, _ = first_touches(pieces, radius, local[None], np.array((direction,)))
    way = np.array((math.cos(direction), math.sin(direction)))
    centre = local + travels[0] * way
    corners = outline.array
    touched = []
    for side, first in enumerate(corners):
        along = corners[(side + 1) % len(corners)] - first
        fraction = float((centre - first) @ along / (along @ along))
        inward = math.atan2(along[0], -along[1])
        off = float(np.hypot(*(centre - first - fraction * along)))
        touched.append((off, side, fraction, math.remainder(direction - inward, math.tau)))
    off, side, fraction, angle = min(touched)
    assert off < 1.01 * radius and 0.0 <= fraction <= 1.0
    return SidePush(side, fraction, angle, push.distance - float(travels[0]))


def stable_directions(world: World, loop: cm.CollectionLoop) -> list[float]:
    """Return the stable fixed points (rad) of a world's own map, a spline through its cycles."""
    theta = math.tau * np.arange(MAPPED + 1) / MAPPED
    turns = []
    first, way = first_contact(loop.slider, loop.push, loop.pusher.radius)
    for angle in theta[:-1].tolist():
        start = loop.start_pose(angle)
        direction = angle + math.atan2(way[1], way[0])
        push = WorldPush(start.to_world(*first), direction, loop.push.distance)
        pushed = world.push(start, push)
        turns.append(world.drag(pushed, (0.0, 0.0)).theta - angle)
    spline = CubicSpline(theta, [*turns, turns[0]], bc_type="periodic")
    crossings = spline.roots(extrapolate=False)
    return [float(root) for root in crossings if spline(root, 1) < 0.0]
