"""What comes of the dynamic simulation: the results of a push and of a drag, with their course and their energies."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.protocol import Pose

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class DynamicTrajectory:
    """A motion sampled evenly in time while the rod moves, and once more when the object rests, in the world frame.

    time : (n,) s. path : (n,) rod travel, m. pose : (n, 3) object's x, y (m) and theta (rad).
    velocity : (n, 3) of the centre of mass, m/s, and spin, rad/s. pusher : (n, 2) rod's centre, m.
    contact_point : (n, 2) m. contact_force : (n, 2) force of the rod on the object, N; zero where they do not touch.
    """

    time: Array
    path: Array
    pose: Array
    velocity: Array
    pusher: Array
    contact_point: Array
    contact_force: Array


@dataclass(frozen=True)
class EnergyBalance:
    """Where the rod's work went, J.

    work : done by the rod. floor : dissipated under the object. contact : dissipated by sliding and damping between
    rod and object. stored : left in the contact's spring and in motion at the end.
    """

    work: float
    floor: float
    contact: float
    stored: float

    @property
    def residual(self) -> float:
        """Work that is not accounted for, as a share of the work: the error of the integration."""
        return (self.work - self.floor - self.contact - self.stored) / self.work


@dataclass(frozen=True, eq=False)
class DynamicPush:
    """A push: poses before and after, and why it ended: `distance`, or `left` where the rod has lost the object."""

    start: Pose
    end: Pose
    ended: str
    trajectory: DynamicTrajectory
    energy: EnergyBalance

    @property
    def turn(self) -> float:
        """Turn of the object, rad."""
        return self.end.theta - self.start.theta

    @property
    def displacement(self) -> Array:
        """Displacement of the object's origin in its initial frame, (2,), m."""
        return np.array(self.start.to_object(self.end.x, self.end.y))


@dataclass(frozen=True, eq=False)
class DynamicDrag:
    """A drag: poses before and after, the path of the rod (m), its course and energies."""

    start: Pose
    end: Pose
    length: float
    trajectory: DynamicTrajectory
    energy: EnergyBalance

    @property
    def turn(self) -> float:
        """Turn of the object, rad."""
        return self.end.theta - self.start.theta
