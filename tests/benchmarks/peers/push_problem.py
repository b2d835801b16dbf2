"""The pushes that every simulator is given, how one is described, and how far off it leaves the
object.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cyclemap.mechanics import (
    EllipseFriction,
    Footprint,
    Polygon,
    Pose,
    Pusher,
    QuasiStaticModel,
    SidePush,
    Slider,
    corner_footprint,
    grid_footprint,
    load_material,
)

# Directions of the push from the side's inward normal, rad: the rod sticks and slides both ways,
# and never loses the object, whose end would then be a matter of when.
ANGLES = tuple(math.radians(angle_deg) for angle_deg in (0.0, 10.0, 20.0))
PUSHES = 12
# What may be missing from converged for a simulator to be compared.
NEAR_MM, NEAR_DEG = 0.2, 0.1

CORNERS, GRID = "four corners, isotropic", "8 x 8 points, plywood"

EndPose = Callable[[Pose, SidePush], Pose]


@dataclass(frozen=True)
class Distance:
    """How far poses are from others: the worst of the pushes, place in mm and orientation in
    degrees.
    """

    place_mm: float
    turn_deg: float

    @property
    def near(self) -> bool:
        """Whether both are within what is asked."""
        return self.place_mm <= NEAR_MM and self.turn_deg <= NEAR_DEG

    def __str__(self) -> str:
        return f"{self.place_mm:.2g} mm, {self.turn_deg:.2g}°"


@dataclass(frozen=True)
class PushProblem:
    """An object that stands on points, the rod that pushes it, and twelve pushes of 150 mm.

    name : what the tables call it.
    slider, friction, footprint, pusher : as `QuasiStaticModel` takes them.
    """

    name: str
    slider: Slider
    friction: EllipseFriction
    footprint: Footprint
    pusher: Pusher = Pusher()

    @property
    def pushes(self) -> list[tuple[Pose, SidePush]]:
        """Start poses around the circle, each with one of the angles of approach."""
        turns = (np.arange(PUSHES) + 0.25) / PUSHES
        poses = [Pose(0.0, 0.0, math.tau * turn) for turn in turns.tolist()]
        return [(pose, SidePush(angle=ANGLES[i % len(ANGLES)])) for i, pose in enumerate(poses)]

    def model(self, accuracy: float) -> QuasiStaticModel:
        """The quasi-static model of this package, to an accuracy in rad."""
        return QuasiStaticModel(self.slider, self.friction, self.pusher, self.footprint, accuracy)

    @cached_property
    def converged(self) -> list[Pose]:
        """The quasi-static end poses, to 1e-10 rad."""
        model = self.model(1e-10)
        return [model.push(pose, push).end for pose, push in self.pushes]

    def ends(self, end_pose: EndPose, pushes: int = PUSHES) -> list[Pose]:
        """Where a simulator leaves the object in the first so many pushes."""
        return [end_pose(pose, push) for pose, push in self.pushes[:pushes]]

    def rod_path(
        self, pose: Pose, push: SidePush
    ) -> tuple[tuple[float, float], tuple[float, float]]:
        """Where the rod's centre is at first touch (m) and the unit vector along which it goes,
        world frame.
        """
        outline = self.slider.outline
        assert isinstance(outline, Polygon)
        first, second = np.roll(outline.vertices, -push.side, axis=0)[:2]
        along = (second - first) / np.hypot(*(second - first))
        outward = np.array([along[1], -along[0]])
        place = first + push.fraction * (second - first) + self.pusher.radius * outward
        direction = pose.theta + math.atan2(outward[1], outward[0]) + math.pi + push.angle
        return pose.to_world(float(place[0]), float(place[1])), (
            math.cos(direction),
            math.sin(direction),
        )


@dataclass(frozen=True)
class Simulator:
    """One simulator.

    build : from a problem, and whether its results are to stand for its limit of ever finer steps,
        all else being the same; gives where a push from a pose ends.
    problems : the names of those in which it takes part.
    """

    name: str
    version: str
    build: Callable[..., EndPose]
    problems: tuple[str, ...] = (CORNERS, GRID)


def distance(ends: Sequence[Pose], others: Sequence[Pose]) -> Distance:
    """The worst distance of poses from as many others."""
    gaps = np.array(
        [(a.x - b.x, a.y - b.y, a.theta - b.theta) for a, b in zip(ends, others, strict=True)]
    )
    if not np.isfinite(gaps).all():
        return Distance(math.inf, math.inf)
    return Distance(
        1e3 * float(np.hypot(gaps[:, 0], gaps[:, 1]).max()),
        math.degrees(float(np.abs(gaps[:, 2]).max())),
    )


def four_corners() -> PushProblem:
    """MIT's square on its four corners, the same friction in all directions: what rigid-body
    engines can do as well.
    """
    slider = Slider.mit("rect1")
    return PushProblem(
        CORNERS, slider, EllipseFriction.isotropic(0.25), corner_footprint(slider.outline)
    )


def plain_grid() -> PushProblem:
    """MIT's square on the paper's 8 x 8 points, on plywood as Table I has it."""
    square, friction = four_corners(), load_material("plywood").friction
    return replace(
        square, name=GRID, friction=friction, footprint=grid_footprint(square.slider.outline, 8)
    )
