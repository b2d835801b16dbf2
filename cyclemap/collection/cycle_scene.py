"""One cycle as a scene in the plane: outlines, rod path, ring and forces of its push and of its drag."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.collection.loop import CollectionLoop, Cycle
from cyclemap.mechanics import Trajectory

OUTLINE_POINTS = 400
# Where along the rod's path a force is shown.
FORCE_PLACES = (0.04, 0.36, 0.68)


@dataclass(frozen=True, eq=False)
class StrokeScene:
    """One stroke of the rod, in the world frame (m, N).

    before, after : (k, 2) closed outlines of the object. ring_before, ring_after : (2,).
    centre : (n, 2) path of the object's centre. rod : (n, 2) path of the rod's centre. rod_radius : m.
    sliding : (n,) bool, where the rod slides along the object.
    force_point, force : (m, 2) some contact points and the forces on the object there.
    """

    before: Array
    after: Array
    ring_before: Array
    ring_after: Array
    centre: Array
    rod: Array
    rod_radius: float
    sliding: NDArray[np.bool_]
    force_point: Array
    force: Array

    @property
    def reach(self) -> Array:
        """(2, 2) m: the lowest and the highest x, y of anything in the scene."""
        radius = self.rod_radius
        tips = self.force_point
        everything = np.concatenate([self.before, self.after, self.rod - radius, self.rod + radius, tips])
        return np.array([everything.min(axis=0), everything.max(axis=0)])


@dataclass(frozen=True, eq=False)
class CycleScene:
    """The push and the drag of one cycle; the world's origin is the reset target."""

    push: StrokeScene
    drag: StrokeScene

    @property
    def strongest_force(self) -> float:
        """N, the largest of the forces shown."""
        return float(max(np.hypot(*stroke.force.T).max() for stroke in (self.push, self.drag)))


def cycle_scene(loop: CollectionLoop, cycle: Cycle) -> CycleScene:
    """The scene of `cycle`, which `loop` ran."""
    return CycleScene(push=_stroke(loop, cycle.trajectory.push), drag=_stroke(loop, cycle.trajectory.drag))


def _stroke(loop: CollectionLoop, trajectory: Trajectory) -> StrokeScene:
    outline = loop.slider.outline_points(OUTLINE_POINTS)
    hitch = np.asarray(loop.slider.hitch, dtype=float)
    first, last = trajectory.pose[0], trajectory.pose[-1]
    travelled = trajectory.path / max(trajectory.path[-1], np.finfo(float).tiny)
    shown = np.unique(np.searchsorted(travelled, FORCE_PLACES).clip(0, len(travelled) - 1))
    return StrokeScene(
        before=placed(first, outline),
        after=placed(last, outline),
        ring_before=placed(first, hitch),
        ring_after=placed(last, hitch),
        centre=trajectory.pose[:, :2],
        rod=trajectory.pusher,
        rod_radius=loop.pusher.radius,
        sliding=np.char.startswith(np.asarray(trajectory.mode, dtype=str), "slide"),
        force_point=trajectory.contact_point[shown],
        force=trajectory.contact_force[shown],
    )


def placed(pose: Array, points: Array) -> Array:
    """`points` (..., 2) of the object's frame, in the world, for the pose (x, y, θ)."""
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    x, y = points[..., 0], points[..., 1]
    return np.stack([pose[0] + cosine * x - sine * y, pose[1] + sine * x + cosine * y], axis=-1)
