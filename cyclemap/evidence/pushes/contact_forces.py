"""Forces of a recorded push in the frame of its contact, and of a friction scan in the frame of its
motion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.evidence.pushes.push_files import PushRecord, ScanRecord

MIT_ROD_RADIUS = 0.00475
# The rod's centre lies this close to one radius from the outline while it touches: poses and clocks
# are no better.
CONTACT_SLACK = 0.003
# Newtons: a tenth of what it takes to push the dataset's objects, and above the sensor's drift.
LEAST_PRESSING = 0.5
FEWEST_SAMPLES = 10
# A scan's stroke begins and ends with the robot's own start and stop: its middle half counts.
_SCAN_MIDDLE = (0.25, 0.75)
_SHORTEST_STROKE = 1e-3
# Rates are slopes of straight lines through the samples of so much of the rod's travel (m), and of
# so many at least.
SLIP_WINDOW = 0.004
_FEWEST_IN_WINDOW = 7
# Samples in which the rod goes slower than this share of its fastest belong to its start and stop.
_MOVING = 0.5


@dataclass(frozen=True, eq=False)
class ContactSamples:
    """A recorded push in the frame of its contact, at the times of its n wrenches.

    Attributes
    ----------
    pressing, tangential : ndarray, shape (n,)
        Force of the rod on the object, N: along the normal into the object, and along the
        tangent, a quarter turn counter-clockwise from it.
    touching : ndarray of bool, shape (n,)
        Whether rod and object touch (see `contact_force_ratio`).
    slip : ndarray, shape (n,)
        How far the rod's surface slides over the object along the tangent, per travel of the
        rod, over a window of samples; 0 where the rod sticks (and rolls), nan where the rod
        does not move or the record ends.
    window : int
        Samples in the window.
    """

    pressing: Array
    tangential: Array
    touching: NDArray[np.bool_]
    slip: Array
    window: int


def contact_force_ratio(
    push: PushRecord, outline: Array, rod_radius: float = MIT_ROD_RADIUS
) -> float:
    """Return the median over a push of |tangential| over normal contact force.

    Parameters
    ----------
    push : PushRecord
        The recording.
    outline : ndarray, shape (k, 2)
        The object's closed outline in its own frame as a polyline, m.
    rod_radius : float, optional
        Radius of the rod, m.

    Returns
    -------
    float
        NaN where it cannot be had.

    Notes
    -----
    Poses of object and tip are interpolated to the times of the wrenches that both clocks
    cover. The contact normal points from the rod's centre to the nearest point of the outline;
    the force of the rod on the object is minus the recorded one. A sample counts as contact
    where the rod's centre is outside the object, within 3 mm of one radius from its outline,
    and the normal force is at least 0.5 N; with fewer than 10 such samples the ratio is NaN. In
    a sliding contact under Coulomb's law it is the friction coefficient, in a sticking one it
    is less.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import Slider
    >>> from cyclemap.evidence import PushRecord, contact_force_ratio
    >>> still = [[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]
    >>> tip = [[0.0, 0.0, 0.04975, 0.0], [1.0, 0.01, 0.04975, 0.0]]
    >>> forces = [[time, -0.1, 1.0, 0.0] for time in np.linspace(0.0, 1.0, 20)]
    >>> outline = Slider.mit("rect1").outline_points()
    >>> round(contact_force_ratio(PushRecord(still, tip, forces), outline), 6)
    0.1
    """
    pressing, tangential, touching, _ = _contact_frame(push, outline, rod_radius)
    if np.count_nonzero(touching) < FEWEST_SAMPLES:
        return math.nan
    return float(np.median(np.abs(tangential[touching]) / pressing[touching]))


def contact_samples(
    push: PushRecord, outline: Array, rod_radius: float = MIT_ROD_RADIUS
) -> ContactSamples:
    """Return a push in the frame of its contact; arguments as in `contact_force_ratio`.

    The rod does not turn in the world. With q the rod's centre in the object's frame, t the tangent
    there and omega the object's rate of turning, its surface slides over the object at t . dq/dt -
    omega rod_radius.
    """
    pressing, tangential, touching, (time, rod, tangent, angle, tip) = _contact_frame(
        push, outline, rod_radius
    )
    stroke = push.tip_pose[-1, 1:3] - push.tip_pose[0, 1:3]
    travel = tip @ stroke / max(float(np.hypot(*stroke)), _SHORTEST_STROKE)
    steps, slip, window = np.diff(travel), np.full(len(time), math.nan), _FEWEST_IN_WINDOW
    moving = steps[steps > _MOVING * np.max(steps, initial=0.0)]
    if moving.size:
        window = max(round(SLIP_WINDOW / float(np.median(moving))) | 1, _FEWEST_IN_WINDOW)
    if moving.size and window <= len(time):
        # Rates are slopes of straight lines through a window of samples about each, nan at the
        # ends.
        views, values = (
            np.lib.stride_tricks.sliding_window_view,
            np.column_stack([rod, angle, travel]),
        )
        lever = views(time, window) - np.mean(views(time, window), axis=1, keepdims=True)
        inner = (
            np.einsum("ij,ikj->ik", lever, views(values, window, axis=0))
            / np.sum(lever**2, axis=1)[:, None]
        )
        rates = np.full(values.shape, math.nan)
        rates[window // 2 : window // 2 + len(inner)] = inner
        speed = rates[:, 3]
        with np.errstate(divide="ignore", invalid="ignore"):
            slip = (np.sum(tangent * rates[:, :2], axis=1) - rod_radius * rates[:, 2]) / speed
        slip = np.where(speed > _MOVING * np.nanmax(speed), slip, math.nan)
    return ContactSamples(pressing, tangential, touching, slip, window)


def _contact_frame(
    push: PushRecord, outline: Array, rod_radius: float
) -> tuple[Array, Array, NDArray[np.bool_], tuple[Array, Array, Array, Array, Array]]:
    """Normal and tangential force, contact, times with the rod's places and tangents in the
    object's frame, its tip.
    """
    time, force = _within(push.ft_wrench, (push.object_pose, push.tip_pose))
    tip, centre = (
        interpolated(time, pose[:, 0], pose[:, 1:3]) for pose in (push.tip_pose, push.object_pose)
    )
    angle = np.interp(time, push.object_pose[:, 0], push.object_angle)
    rod, c, s = tip - centre, np.cos(angle), np.sin(angle)
    # Both turned back into the object's frame.
    rod, force = (np.stack([c * x + s * y, c * y - s * x], axis=-1) for x, y in (rod.T, -force.T))
    offset = nearest_on_polyline(rod, outline)[0] - rod
    distance = np.hypot(*offset.T)
    with np.errstate(divide="ignore", invalid="ignore"):
        normal = offset / distance[:, None]
    tangent = np.stack([-normal[:, 1], normal[:, 0]], axis=-1)
    pressing, tangential = np.sum(force * normal, axis=1), np.sum(force * tangent, axis=1)
    # The outline is convex, its corners counter-clockwise.
    edge, away = np.diff(outline, axis=0), rod[:, None] - outline[:-1]
    inside = np.all(edge[:, 0] * away[..., 1] - edge[:, 1] * away[..., 0] > 0.0, axis=1)
    near = ~inside & (np.abs(distance - rod_radius) <= CONTACT_SLACK)
    return (
        pressing,
        tangential,
        near & (pressing >= LEAST_PRESSING),
        (time, rod, tangent, angle, tip),
    )


def scan_forces(scan: ScanRecord) -> tuple[float, float]:
    """Return the force (N) of the rod on the object along the stroke and across it, to its left:
    medians.

    Over the middle half of the stroke, by way of the tip along the line from its first to its last
    place; the recorded wrench is taken to be the object's on the rod, as in the push files, and its
    sign turned. NaN where the stroke is shorter than 1 mm or fewer than 10 wrenches fall into it.
    """
    length = math.hypot(*scan.stroke)
    time, force = _within(scan.ft_wrench, (scan.tip,))
    if length < _SHORTEST_STROKE or not time.size:
        return math.nan, math.nan
    along = np.array(scan.stroke) / length
    way = (interpolated(time, scan.tip[:, 0], scan.tip[:, 1:3]) - scan.tip[0, 1:3]) @ along / length
    middle = force[(way >= _SCAN_MIDDLE[0]) & (way <= _SCAN_MIDDLE[1])]
    if len(middle) < FEWEST_SAMPLES:
        return math.nan, math.nan
    across = np.array([-along[1], along[0]])
    return float(np.median(-middle @ along)), float(np.median(-middle @ across))


def _within(wrench: Array, clocks: tuple[Array, ...]) -> tuple[Array, Array]:
    """Times and forces of the wrenches that lie within every clock."""
    time = wrench[:, 0]
    kept = (time >= max(clock[0, 0] for clock in clocks)) & (
        time <= min(clock[-1, 0] for clock in clocks)
    )
    return time[kept], wrench[kept, 1:3]


def interpolated(at: Array, known: Array, rows: Array) -> Array:
    """Rows (n, k), known at (n,), at other places (...): shape (..., k)."""
    return np.stack([np.interp(at, known, column) for column in rows.T], axis=-1)


def nearest_on_polyline(points: Array, polyline: Array) -> tuple[Array, NDArray[np.intp]]:
    """Return the nearest point (n, 2) of a polyline (k, 2) to each of the points (n, 2), and the
    edge (n,) it is on.
    """
    first, edge = polyline[:-1], np.diff(polyline, axis=0)
    share = np.sum((points[:, None] - first) * edge, axis=-1) / np.sum(edge * edge, axis=-1)
    on_edge = first + np.clip(share, 0.0, 1.0)[..., None] * edge
    nearest = np.argmin(np.sum((points[:, None] - on_edge) ** 2, axis=-1), axis=1)
    return np.asarray(on_edge[np.arange(len(points)), nearest]), nearest
