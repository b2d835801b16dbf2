"""Forces of a recorded push in the frame of its contact, and of a friction scan in the frame of its motion."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cyclemap.evidence.pushes.push_record import PushRecord, ScanRecord

Array = NDArray[np.float64]

MIT_ROD_RADIUS = 0.00475
# The rod's centre lies this close to one radius from the outline while it touches: poses and clocks are no better.
CONTACT_SLACK = 0.003
# Newtons: a tenth of what it takes to push the dataset's objects, and above the sensor's drift.
LEAST_PRESSING = 0.5
FEWEST_SAMPLES = 10
# A scan's stroke begins and ends with the robot's own start and stop: its middle half counts.
_SCAN_MIDDLE = (0.25, 0.75)
_SHORTEST_STROKE = 1e-3


def contact_force_ratio(push: PushRecord, outline: Array, rod_radius: float = MIT_ROD_RADIUS) -> float:
    """Return the median over the push of |tangential| over normal contact force; NaN where it cannot be had.

    outline : (k, 2) m, the object's closed outline in its own frame as a polyline. rod_radius : m.

    Poses of object and tip are interpolated to the times of the wrenches that both clocks cover. The contact
    normal points from the rod's centre to the nearest point of the outline; the force of the rod on the object is
    minus the recorded one. A sample counts as contact where the rod's centre is outside the object, within 3 mm of
    one radius from its outline, and the normal force is at least 0.5 N; with fewer than 10 such samples the ratio
    is NaN. In a sliding contact under Coulomb's law it is the friction coefficient, in a sticking one it is less.
    """
    time, force = _within(push.ft_wrench, (push.object_pose, push.tip_pose))
    if time.size < FEWEST_SAMPLES:
        return math.nan
    rod, force = _in_object_frame(push, time, -force)
    offset = _nearest_point(rod, outline) - rod
    distance = np.hypot(*offset.T)
    with np.errstate(divide="ignore", invalid="ignore"):
        normal = offset / distance[:, None]
    pressing = np.sum(force * normal, axis=1)
    sliding = normal[:, 0] * force[:, 1] - normal[:, 1] * force[:, 0]
    touching = ~_inside(rod, outline) & (np.abs(distance - rod_radius) <= CONTACT_SLACK) & (pressing >= LEAST_PRESSING)
    if np.count_nonzero(touching) < FEWEST_SAMPLES:
        return math.nan
    return float(np.median(np.abs(sliding[touching]) / pressing[touching]))


def scan_forces(scan: ScanRecord) -> tuple[float, float]:
    """Return the force (N) of the rod on the object along the stroke and across it, to its left: medians.

    Over the middle half of the stroke, by way of the tip along the line from its first to its last place; the recorded
    wrench is taken to be the object's on the rod, as in the push files, and its sign turned. NaN
    where the stroke is shorter than 1 mm or fewer than 10 wrenches fall into it.
    """
    length = math.hypot(*scan.stroke)
    time, force = _within(scan.ft_wrench, (scan.tip,))
    if length < _SHORTEST_STROKE or not time.size:
        return math.nan, math.nan
    along = np.array(scan.stroke) / length
    way = (_places(scan.tip, time) - scan.tip[0, 1:3]) @ along / length
    middle = force[(way >= _SCAN_MIDDLE[0]) & (way <= _SCAN_MIDDLE[1])]
    if len(middle) < FEWEST_SAMPLES:
        return math.nan, math.nan
    across = np.array([-along[1], along[0]])
    return float(np.median(-middle @ along)), float(np.median(-middle @ across))


def _within(wrench: Array, clocks: tuple[Array, ...]) -> tuple[Array, Array]:
    """Times and forces of the wrenches that lie within every clock."""
    time = wrench[:, 0]
    kept = (time >= max(clock[0, 0] for clock in clocks)) & (time <= min(clock[-1, 0] for clock in clocks))
    return time[kept], wrench[kept, 1:3]


def _places(pose: Array, time: Array) -> Array:
    return np.stack([np.interp(time, pose[:, 0], pose[:, column]) for column in (1, 2)], axis=-1)


def _in_object_frame(push: PushRecord, time: Array, force: Array) -> tuple[Array, Array]:
    """The tip's places (m) and the forces (N), both (n, 2), in the object's frame at each time."""
    angle = np.interp(time, push.object_pose[:, 0], push.object_angle)
    offset = _places(push.tip_pose, time) - _places(push.object_pose, time)
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    back = np.array([1.0, -1.0])
    return c * offset + s * back * offset[:, ::-1], c * force + s * back * force[:, ::-1]


def _nearest_point(points: Array, outline: Array) -> Array:
    """The nearest point of a polyline (k, 2) to each of the points (n, 2)."""
    first, edge = outline[:-1], np.diff(outline, axis=0)
    share = np.sum((points[:, None] - first) * edge, axis=-1) / np.sum(edge * edge, axis=-1)
    on_edge = first + np.clip(share, 0.0, 1.0)[..., None] * edge
    nearest = np.argmin(np.sum((points[:, None] - on_edge) ** 2, axis=-1), axis=1)
    return np.asarray(on_edge[np.arange(len(points)), nearest])


def _inside(points: Array, outline: Array) -> NDArray[np.bool_]:
    """Whether points (n, 2) lie inside a convex outline whose corners go counter-clockwise."""
    edge, offset = np.diff(outline, axis=0), points[:, None] - outline[:-1]
    return np.asarray(np.all(edge[:, 0] * offset[..., 1] - edge[:, 1] * offset[..., 0] > 0.0, axis=1))
