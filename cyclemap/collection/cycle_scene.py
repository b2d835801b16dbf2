"""One cycle as a scene of outlines, rod path and forces, ready to draw."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array, Mask
from cyclemap.mechanics import Slider, Trajectory

OUTLINE_POINTS = 400
# Where along the rod's path a force is shown.
FORCE_PLACES = (0.04, 0.36, 0.68)


@dataclass(frozen=True, eq=False)
class StrokeScene:
    """One stroke of the rod, in the world frame (m, N).

    Attributes
    ----------
    before, after : ndarray, shape (k, 2)
        Closed outlines of the object.
    ring_before, ring_after : ndarray, shape (2,)
        Places of the ring.
    centre : ndarray, shape (n, 2)
        Path of the object's centre.
    rod : ndarray, shape (n, 2)
        Path of the rod's centre.
    rod_radius : float
        m.
    sliding : ndarray of bool, shape (n,)
        Where the rod slides along the object.
    force_point, force : ndarray, shape (m, 2)
        Some contact points and the forces on the object there.
    reach : ndarray, shape (2, 2)
        The lowest and the highest x, y of anything in the scene.
    """

    before: Array
    after: Array
    ring_before: Array
    ring_after: Array
    centre: Array
    rod: Array
    rod_radius: float
    sliding: Mask
    force_point: Array
    force: Array
    reach: Array

    @classmethod
    def of_course(cls, slider: Slider, rod_radius: float, course: Trajectory) -> StrokeScene:
        """Return the scene of a stroke that ran its course."""
        outline = slider.outline_points(OUTLINE_POINTS)
        hitch = np.array(slider.hitch, dtype=float)
        first = course.pose[0]
        last = course.pose[-1]
        before = placed(first, outline)
        after = placed(last, outline)
        travelled = course.path / max(course.path[-1], np.finfo(float).tiny)
        shown = np.unique(np.searchsorted(travelled, FORCE_PLACES).clip(0, len(travelled) - 1))
        tips = course.contact_point[shown]
        rod = [course.pusher - rod_radius, course.pusher + rod_radius]
        everything = np.concatenate([before, after, *rod, tips])
        return cls(
            before=before,
            after=after,
            ring_before=placed(first, hitch),
            ring_after=placed(last, hitch),
            centre=course.pose[:, :2],
            rod=course.pusher,
            rod_radius=rod_radius,
            sliding=np.char.startswith(np.asarray(course.mode, dtype=str), "slide"),
            force_point=tips,
            force=course.contact_force[shown],
            reach=np.array([everything.min(axis=0), everything.max(axis=0)]),
        )


@dataclass(frozen=True, eq=False)
class CycleScene:
    """The push and the drag of one cycle, its origin the reset target.

    strongest_force : N, of those shown.
    """

    push: StrokeScene
    drag: StrokeScene
    strongest_force: float

    @classmethod
    def of_courses(
        cls, slider: Slider, rod_radius: float, push: Trajectory, drag: Trajectory
    ) -> CycleScene:
        """Return the scene of a cycle from the courses of both strokes."""
        push_scene = StrokeScene.of_course(slider, rod_radius, push)
        drag_scene = StrokeScene.of_course(slider, rod_radius, drag)
        forces = np.concatenate([push_scene.force, drag_scene.force])
        return cls(push_scene, drag_scene, float(np.hypot(*forces.T).max()))


def placed(pose: Array, points: Array) -> Array:
    """`points` (..., 2) of the object's frame, in the world, for the pose (x, y, θ)."""
    cosine = np.cos(pose[2])
    sine = np.sin(pose[2])
    x = points[..., 0]
    y = points[..., 1]
    return np.stack([pose[0] + cosine * x - sine * y, pose[1] + sine * x + cosine * y], axis=-1)
