"""What instruments record of a simulated push or friction scan: series on their own clocks, with noise."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields

import numpy as np

from cyclemap.arrays import Array, shorter_way
from cyclemap.checks import non_negative_number, positive_number
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import InvalidInput
from cyclemap.evidence.pushes.contact_forces import MIT_ROD_RADIUS
from cyclemap.evidence.pushes.mit_names import ScanFacts
from cyclemap.evidence.pushes.push_files import PushRecord, ScanRecord
from cyclemap.mechanics import EllipseFriction, PushResult

SAMPLES_PER_SECOND = 250.0
# As in the measured files: the rod rests a quarter of a second before and after its stroke, and the clocks of the tip
# and of the force sensor start a little after the object's.
REST_SECONDS = 0.25
TIP_LAG, WRENCH_LAG = 0.009, 0.011
# Seconds since 1970, as robots count: the first of January 2016, the year of the dataset.
FIRST_CLOCK = 1_451_606_400.0
# Where the reset brings the ring to, (x, y) in the robot's frame, m.
MIT_TARGET = (0.350, -0.030)
# The rod starts this far (m) before it touches.
APPROACH = 0.001
# Object's x, y, theta; the rod's force on it, x and y; the contact point from the rod's centre, x and y.
_POSE, _FORCE, _LEVER = slice(0, 3), slice(3, 5), slice(5, 7)
# As in the dataset: 120 mm through this place (m, robot's frame), every five degrees, twice each.
SCAN_CENTRE = (0.350, -0.018)
SCAN_STROKE = 0.120
SCAN_STEP_DEGREES = 5
SCAN_REPETITIONS = 2


@dataclass(frozen=True)
class RecordingNoise:
    """Standard deviations of normal noise in a simulated collection, independent from draw to draw.

    turn : rad, scatter of θ0 from cycle to cycle, added to what the cycle map gives: the object really lies there.
    position, angle : m and rad, error of each recorded pose of the object (x and y alike); the robot's tip has none.
    force : N, error of each recorded force component; the torque's is this times the rod's radius.

    >>> RecordingNoise(turn=0.0).force
    0.0
    """

    turn: float = DEFAULT_SIGMA
    position: float = 0.0
    angle: float = 0.0
    force: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            name = f"noise of the {field.name}"
            object.__setattr__(self, field.name, non_negative_number(name, getattr(self, field.name)))

    def of_poses(self, count: int, generator: np.random.Generator) -> Array:
        """Errors (count, 3) of poses: m, m, rad."""
        return generator.standard_normal((count, 3)) * (self.position, self.position, self.angle)

    def of_wrenches(self, count: int, lever: float, generator: np.random.Generator) -> Array:
        """Errors (count, 3) of wrenches: N, N, N m, the torque's by a `lever` (m)."""
        return generator.standard_normal((count, 3)) * (self.force, self.force, self.force * lever)


@dataclass(frozen=True)
class Recording:
    """How a stroke is recorded.

    speed : m/s, of the rod. start : seconds since 1970. noise : of the instruments. rod_radius : m.
    target : (x, y) m, where the origin of the mechanics lies in the robot's frame: the reset brings the ring there.
    """

    speed: float = 0.020
    start: float = FIRST_CLOCK
    noise: RecordingNoise = RecordingNoise()
    rod_radius: float = MIT_ROD_RADIUS
    target: tuple[float, float] = MIT_TARGET

    def __post_init__(self) -> None:
        object.__setattr__(self, "speed", positive_number("speed of the rod", self.speed))

    def clock(self, seconds: float, lag: float = 0.0) -> tuple[Array, Array]:
        """Times of samples at 250 Hz from `lag` on until `seconds` are past: as recorded, and since the record began.

        The latter are made of the recorded times, which a double holds to a quarter of a microsecond only.
        """
        count = math.ceil(seconds * SAMPLES_PER_SECOND) + 1
        seen = self.start + (lag + np.arange(count) / SAMPLES_PER_SECOND)
        return seen, seen - self.start


def recorded_seconds(distance: float, speed: float) -> float:
    """Seconds that the record of a push over `distance` (m, from first touch) lasts."""
    return 2.0 * REST_SECONDS + (APPROACH + distance) / speed


def record_push(push: PushResult, distance: float, recording: Recording, generator: np.random.Generator) -> PushRecord:
    """Return what the instruments record of `push`, whose rod goes `distance` (m) on from first touch.

    250 Hz, as in the MIT files: the rod rests for 0.25 s, approaches over 1 mm, pushes, and rests for 0.25 s pressed
    against the object. If it lost the object it goes on to the end of its stroke alone. Wrenches are the object's on
    the rod, in the world; the torque is about the rod's axis. The object's angle is wrapped.

    Rests, first and last pose are those of `push` to rounding. Between, poses and forces are cubic splines of the
    rod's travel through the ends of the integration's steps, phase by phase. With steps of a sixtieth of 150 mm they
    came, over 48 pushes of four shapes, within 4 micrometres, 4e-6 rad and 0.2 mN of a run ten times finer.
    """
    seconds = recorded_seconds(distance, recording.speed)
    object_time, tip_time, wrench_time = (recording.clock(seconds, lag) for lag in (0.0, TIP_LAG, WRENCH_LAG))
    course = _Course(push, distance, recording.speed)
    pose = course.states(object_time[1])[:, _POSE] + (*recording.target, 0.0)
    pose += recording.noise.of_poses(len(pose), generator)
    pose[:, 2] = shorter_way(pose[:, 2])
    state = course.states(wrench_time[1])
    force, lever = -state[:, _FORCE], state[:, _LEVER]
    wrench = np.column_stack([force, lever[:, 0] * force[:, 1] - lever[:, 1] * force[:, 0]])
    wrench += recording.noise.of_wrenches(len(state), recording.rod_radius, generator)
    tip = course.rod(tip_time[1]) + recording.target
    return PushRecord(
        np.column_stack([object_time[0], pose]),
        np.column_stack([tip_time[0], tip, np.zeros(len(tip))]),
        np.column_stack([wrench_time[0], wrench]),
    )


class _Course:
    """A push as a function of the time since its record began, in the frame of the mechanics."""

    def __init__(self, push: PushResult, distance: float, speed: float) -> None:
        if push.travel > distance * (1.0 + 1e-9):
            raise InvalidInput(f"the push went {push.travel:g} m, further than the stroke of {distance:g} m")
        self.push, self.distance, self.speed = push, distance, speed
        course = push.trajectory
        rows = np.column_stack([course.pose, course.contact_force, course.contact_point - course.pusher])
        # Each phase begins with a row of its own, where the one before it ended.
        phases = [course.phase == number for number in range(course.phase[-1] + 1)]
        self.begins = np.array([course.path[phase][0] for phase in phases])
        self.phases = [_spline(course.path[phase], rows[phase]) for phase in phases]
        self.first_place, self.last_row = course.pusher[0], rows[-1]

    def travel(self, elapsed: Array) -> Array:
        """The rod's way from first touch, m; negative before it."""
        return np.clip(self.speed * (elapsed - REST_SECONDS) - APPROACH, -APPROACH, self.distance)

    def rod(self, elapsed: Array) -> Array:
        """(n, 2) m, the rod's centre."""
        strokes = self.push.course.strokes
        direction = strokes.direction + (self.push.start.theta if strokes.with_object else 0.0)
        way = np.array([math.cos(direction), math.sin(direction)])
        return np.asarray(self.first_place + self.travel(elapsed)[:, None] * way)

    def states(self, elapsed: Array) -> Array:
        """(n, 7): pose, force and lever; no force where the rod does not touch."""
        travel = self.travel(elapsed)
        state = np.empty((len(travel), self.last_row.size))
        number = np.maximum(np.searchsorted(self.begins, travel, side="right") - 1, 0)
        for phase, spline in enumerate(self.phases):
            state[number == phase] = spline(travel[number == phase])
        start, end = self.push.start, self.push.end
        before, after = travel < 0.0, travel >= self.push.travel
        state[before] = (start.x, start.y, start.theta, 0.0, 0.0, 0.0, 0.0)
        state[after] = (end.x, end.y, end.theta, *self.last_row[3:])
        if self.push.ended == "left":
            state[after, 3:] = 0.0
        return state


def _spline(path: Array, rows: Array) -> Callable[[Array], Array]:
    """The cubic spline through the rows (k, m) of one phase; straight where there are two, constant without length."""
    from scipy.interpolate import CubicSpline

    kept = np.diff(path, prepend=-math.inf) > 0.0
    if np.count_nonzero(kept) < 2:
        return lambda travel: np.broadcast_to(rows[-1], (len(travel), rows.shape[1]))
    return CubicSpline(path[kept], rows[kept])  # type: ignore[no-any-return]


def scan_set(surface: str, shape: str, speed: float) -> Iterator[ScanFacts]:
    """The scans of one object on one surface, as the dataset names them; speed in m/s.

    >>> sum(1 for facts in scan_set("plywood", "rect1", 0.02))
    144
    """
    for degrees in range(0, 360, SCAN_STEP_DEGREES):
        for repetition in range(SCAN_REPETITIONS):
            direction = math.radians((degrees + 180) % 360)
            yield ScanFacts(surface, shape, 0.0, speed, direction, float(repetition))


def record_scan(
    friction: EllipseFriction, weight: float, direction: float, recording: Recording, generator: np.random.Generator
) -> ScanRecord:
    """Return what the instruments record of a stroke in `direction` (rad) of an object of `weight` (N).

    Every point of the object slides the same way, so that the rod's force on it is the traction of the point's
    friction times the weight, however the pressure is spread; the recorded one is the object's on the rod, and zero
    while the rod rests, 0.25 s before and after. The rod holds the object at the friction's centre: no torque.
    """
    way = np.array([math.cos(direction), math.sin(direction)])
    seconds = 2.0 * REST_SECONDS + SCAN_STROKE / recording.speed
    (tip_seen, tip_time), (seen, time) = recording.clock(seconds), recording.clock(seconds, WRENCH_LAG)
    travel = np.clip(recording.speed * (tip_time - REST_SECONDS), 0.0, SCAN_STROKE) - SCAN_STROKE / 2.0
    force = -weight * friction.traction(way)
    moving = (time >= REST_SECONDS) & (time <= seconds - REST_SECONDS)
    wrench = np.outer(moving, [*force, 0.0]) + recording.noise.of_wrenches(len(moving), recording.rod_radius, generator)
    return ScanRecord(
        np.column_stack([tip_seen, SCAN_CENTRE + np.outer(travel, way), np.zeros(len(travel))]),
        np.column_stack([seen, wrench]),
    )
