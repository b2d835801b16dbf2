"""Forces of a recorded push in the frame of its contact, and of a friction scan in the frame of its
motion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from cyclemap.arrays import Array, Mask, along_way
from cyclemap.evidence.pushes.recordings import PushRecord, ScanRecord
from cyclemap.mechanics.outline import nearest_on_polyline
from cyclemap.mechanics.slider import Pusher

MIT_ROD_RADIUS = Pusher().radius
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
    """A recorded push in the frame of its contact, at the times of its n wrenches; vectors as
    complex numbers.

    Attributes
    ----------
    push : PushRecord
        The recording.
    rod_radius : float
        Of the rod, m.
    time, tip : ndarray, shape (n,)
        s; the rod's centre, m, in the world.
    rod, normal : ndarray, shape (n,)
        The rod's centre, m, and the normal into the object, in the object's frame.
    angle : ndarray, shape (n,)
        Of the object, rad.
    force : ndarray, shape (n,)
        Of the rod on the object, N: its real part along the normal, the imaginary one along the
        tangent, a quarter turn counter-clockwise from it.
    touching : ndarray of bool, shape (n,)
        Whether rod and object touch (see `contact_force_ratio`).
    """

    push: PushRecord
    rod_radius: float
    time: Array
    tip: Array
    rod: Array
    normal: Array
    angle: Array
    force: Array
    touching: Mask

    @cached_property
    def travel(self) -> Array:
        """How far the rod went along its stroke, (n,), m."""
        stroke = complex(*(self.push.tip_pose[-1, 1:3] - self.push.tip_pose[0, 1:3]))
        along = self.tip * (stroke.conjugate() / max(abs(stroke), _SHORTEST_STROKE))
        return np.asarray(along.real)

    @cached_property
    def window(self) -> int:
        """Samples over which rates are taken; as few as may be where the rod does not move."""
        steps = np.diff(self.travel)
        moving = steps[steps > _MOVING * np.max(steps, initial=0.0)]
        usual = float(np.median(moving)) if moving.size else math.inf
        return max(round(SLIP_WINDOW / usual) | 1, _FEWEST_IN_WINDOW)

    @cached_property
    def slip(self) -> Array:
        """How far the rod's surface slides over the object along the tangent, per travel of the
        rod, over a window of samples (n,): 0 where the rod sticks (and rolls), nan where the rod
        does not move or the record ends.

        The rod does not turn in the world. With q the rod's centre in the object's frame, t the
        tangent there and omega the object's rate of turning, its surface slides over the object at
        t . dq/dt - omega rod_radius.
        """
        if self.window > self.time.size or not (np.diff(self.travel) > 0.0).any():
            return np.full(self.time.size, math.nan)
        rod, angle, speed = (
            _rates(self.time, values, self.window) for values in (self.rod, self.angle, self.travel)
        )
        # Along the tangent, a quarter turn from the normal.
        along = (rod * self.normal.conj()).imag
        with np.errstate(divide="ignore", invalid="ignore"):
            slip = (along - self.rod_radius * angle) / speed
        return np.where(speed > _MOVING * np.nanmax(speed), slip, math.nan)


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
    samples = contact_samples(push, outline, rod_radius)
    force = samples.force[samples.touching]
    if force.size < FEWEST_SAMPLES:
        return math.nan
    return float(np.median(np.abs(force.imag) / force.real))


def contact_samples(
    push: PushRecord, outline: Array, rod_radius: float = MIT_ROD_RADIUS
) -> ContactSamples:
    """Return a push in the frame of its contact; arguments as in `contact_force_ratio`."""
    time, force = _within(push.ft_wrench, (push.object_pose, push.tip_pose))
    tip, centre = (
        np.interp(time, pose[:, 0], pose[:, 1] + 1j * pose[:, 2])
        for pose in (push.tip_pose, push.object_pose)
    )
    angle = np.interp(time, push.object_pose[:, 0], push.object_angle)
    rod = (tip - centre) * np.exp(-1j * angle)
    nearest = nearest_on_polyline(np.stack([rod.real, rod.imag], axis=-1), outline)[0]
    offset = nearest[:, 0] + 1j * nearest[:, 1] - rod
    distance = np.abs(offset)
    with np.errstate(divide="ignore", invalid="ignore"):
        normal = offset / distance
    force = -(force[:, 0] + 1j * force[:, 1]) * np.exp(-1j * angle) * normal.conj()
    # The outline is convex, its corners counter-clockwise.
    corners = outline[:, 0] + 1j * outline[:, 1]
    sides = np.diff(corners).conj() * (rod[:, None] - corners[:-1])
    inside = np.all(sides.imag > 0.0, axis=1)
    near = ~inside & (np.abs(distance - rod_radius) <= CONTACT_SLACK)
    touching = near & (force.real >= LEAST_PRESSING)
    return ContactSamples(push, rod_radius, time, tip, rod, normal, angle, force, touching)


def _rates(time: Array, values: Array, window: int) -> Array:
    """Slopes of straight lines through a window of samples about each, NaN at the ends."""
    times, views = (sliding_window_view(series, window) for series in (time, values))
    lever = times - np.mean(times, axis=1, keepdims=True)
    slopes = np.sum(lever * views, axis=1) / np.sum(lever**2, axis=1)
    rates = np.full(values.shape, math.nan, dtype=values.dtype)
    rates[window // 2 : window // 2 + len(slopes)] = slopes
    return rates


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
    way = (along_way(time, scan.tip[:, 0], scan.tip[:, 1:3]) - scan.tip[0, 1:3]) @ along / length
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
