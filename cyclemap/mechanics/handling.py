"""What comes of handling the slider once: the results of a push and of a drag."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cyclemap.errors import InvalidInput
from cyclemap.mechanics.protocol import Pose
from cyclemap.mechanics.push_run import PushRun, RunPhase
from cyclemap.mechanics.trajectory import Frame, Trajectory, trajectory_of


@dataclass(frozen=True)
class PushResult:
    """A push: poses before and after, and why it ended: `distance`, or `left` where the rod no longer approaches.

    A rod that still sticks when it stops approaching could pull the object along by friction for a while: here it
    leaves.

    `run` holds the computed phases in normalised units, `frame` how they lie in the world.
    """

    start: Pose
    end: Pose
    ended: str
    run: PushRun
    frame: Frame

    @property
    def turn(self) -> float:
        """Turn of the object, rad."""
        return self.end.theta - self.start.theta

    @property
    def travel(self) -> float:
        """Rod travel in contact, m."""
        return self.frame.unit * self.run.length

    @property
    def displacement(self) -> NDArray[np.float64]:
        """Displacement of the object's origin in its initial frame, (2,), m."""
        return np.array(self.start.to_object(self.end.x, self.end.y))

    @cached_property
    def trajectory(self) -> Trajectory:
        """The course of the push in the world."""
        return trajectory_of(self.run.phases, self.frame)


@dataclass(frozen=True)
class DragLeg:
    """One straight leg of a drag: its phase in normalised units, and how it lies in the world."""

    phase: RunPhase
    frame: Frame


@dataclass(frozen=True)
class DragResult:
    """A drag: poses before and after, and its legs (none where the ring was already there)."""

    start: Pose
    end: Pose
    legs: tuple[DragLeg, ...]

    @property
    def turn(self) -> float:
        """Turn of the object, rad."""
        return self.end.theta - self.start.theta

    @property
    def length(self) -> float:
        """Path of the ring, m."""
        return math.fsum(leg.frame.unit * leg.phase.phase.length for leg in self.legs)

    @cached_property
    def trajectory(self) -> Trajectory:
        """The course of the drag in the world."""
        parts = [trajectory_of((leg.phase,), leg.frame) for leg in self.legs]
        if not parts:
            raise InvalidInput("this drag has no length, so that it has no trajectory")
        starts = np.cumsum([0.0, *(part.path[-1] for part in parts)])
        path = np.concatenate([part.path + start for part, start in zip(parts, starts, strict=False)])
        return Trajectory(
            path,
            np.concatenate([part.pose for part in parts]),
            np.concatenate([part.pusher for part in parts]),
            np.concatenate([part.contact_point for part in parts]),
            np.concatenate([part.contact_force for part in parts]),
            np.concatenate([part.mode for part in parts]),
            max(part.residual for part in parts),
        )
