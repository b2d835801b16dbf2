"""What instruments record of a simulated push or friction scan: series on their own clocks, with
noise.
"""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass, fields

import numpy as np

from cyclemap.arrays import Array, shorter_way
from cyclemap.checks import non_negative_number, positive_number
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import InvalidInput
from cyclemap.evidence.pushes.contact_forces import MIT_ROD_RADIUS
from cyclemap.evidence.pushes.recordings import PushRecord, ScanFacts, ScanRecord
from cyclemap.mechanics import EllipseFriction, PushResult

SAMPLES_PER_SECOND = 250.0
# As in the measured files: the rod rests a quarter of a second before and after its stroke, and the
# clocks of the tip and of the force sensor start a little after the object's.
REST_SECONDS = 0.25
TIP_LAG = 0.009
WRENCH_LAG = 0.011
# Seconds since 1970, as robots count: the first of January 2016, the year of the dataset.
FIRST_CLOCK = 1_451_606_400.0
# Where the reset brings the ring to, (x, y) in the robot's frame, m: the origin of the mechanics.
MIT_TARGET = (0.350, -0.030)
# The rod starts this far (m) before it touches.
APPROACH = 0.001
# As in the dataset: 120 mm through this place (m, robot's frame), every five degrees, twice each.
SCAN_CENTRE = (0.350, -0.018)
SCAN_STROKE = 0.120


@dataclass(frozen=True)
class RecordingNoise:
    """Standard deviations of normal noise in a simulated collection, independent from draw to draw.

    Parameters
    ----------
    turn : float, optional
        Scatter of θ0 from cycle to cycle, rad, added to what the cycle map gives: the object
        really lies there.
    position : float, default 0.0
        Error of each recorded place of the object (x and y alike), m; the robot's tip has none.
    angle : float, default 0.0
        Error of each recorded orientation of the object, rad.
    force : float, default 0.0
        Error of each recorded force component, N; the torque's is this times the rod's radius.

    Raises
    ------
    InvalidInput
        For a deviation that is negative or not finite.

    Examples
    --------
    >>> from cyclemap.evidence import RecordingNoise
    >>> RecordingNoise(turn=0.0, position=5e-4).angle
    0.0
    """

    turn: float = DEFAULT_SIGMA
    position: float = 0.0
    angle: float = 0.0
    force: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            name = f"noise of the {field.name}"
            object.__setattr__(
                self, field.name, non_negative_number(name, getattr(self, field.name))
            )

    def of_wrenches(self, count: int, lever: float, generator: np.random.Generator) -> Array:
        """Errors (count, 3) of wrenches: N, N, N m, the torque's by a `lever` (m)."""
        return generator.standard_normal((count, 3)) * (self.force, self.force, self.force * lever)


@dataclass(frozen=True)
class Recording:
    """How a stroke is recorded.

    speed : m/s, of the rod.
    start : seconds since 1970.
    noise : of the instruments.
    rod_radius : m.
    """

    speed: float = 0.020
    start: float = FIRST_CLOCK
    noise: RecordingNoise = RecordingNoise()
    rod_radius: float = MIT_ROD_RADIUS

    def __post_init__(self) -> None:
        object.__setattr__(self, "speed", positive_number("speed of the rod", self.speed))

    def samples(self, first: float, last: float, lag: float = 0.0) -> tuple[Array, Array]:
        """Times of samples at 250 Hz from `lag` on, as recorded, and where the rod then is on its
        way, m, which goes from `first` to `last`.

        Where it is follows the recorded times, which a double holds to a quarter of a microsecond
        only.
        """
        count = math.ceil(recorded_seconds(last - first, self.speed) * SAMPLES_PER_SECOND) + 1
        seen = self.start + (lag + np.arange(count) / SAMPLES_PER_SECOND)
        moved = self.speed * (seen - self.start - REST_SECONDS)
        return seen, np.clip(moved + first, first, last)


def recorded_seconds(way: float, speed: float) -> float:
    """Seconds that the record of a rod that goes so far (m) lasts."""
    return 2.0 * REST_SECONDS + way / speed


def record_push(
    push: PushResult, distance: float, recording: Recording, generator: np.random.Generator
) -> PushRecord:
    """Return what the instruments record of `push`, whose rod goes `distance` (m) on from first
    touch.

    250 Hz, as in the MIT files: the rod rests for 0.25 s, approaches over 1 mm, pushes, and rests
    for 0.25 s pressed against the object. If it lost the object it goes on to the end of its stroke
    alone. Wrenches are the object's on the rod, in the world; the torque is about the rod's axis.
    The object's angle is wrapped.

    Rests, first and last pose are those of `push` to rounding; between, poses and forces are cubic
    splines of the rod's travel through the ends of the integration's steps. With steps of a
    sixtieth of 150 mm they came, over 48 pushes of four shapes, within 4 micrometres, 4e-6 rad and
    0.2 mN of a run ten times finer.
    """
    # The rod's way from first touch, m, negative before it.
    (object_time, object_way), (tip_time, tip_way), (wrench_time, wrench_way) = (
        recording.samples(-APPROACH, distance, lag) for lag in (0.0, TIP_LAG, WRENCH_LAG)
    )
    states = _states(push, distance, np.concatenate([object_way, wrench_way]))
    pose = states[: len(object_way), :3] + (*MIT_TARGET, 0.0)
    noise = recording.noise
    scatter = (noise.position, noise.position, noise.angle)
    pose += generator.standard_normal((len(pose), 3)) * scatter
    pose[:, 2] = shorter_way(pose[:, 2])
    force = -states[len(object_way) :, 3:5]
    lever = states[len(object_way) :, 5:]
    wrench = np.column_stack([force, lever[:, 0] * force[:, 1] - lever[:, 1] * force[:, 0]])
    wrench += noise.of_wrenches(len(wrench), recording.rod_radius, generator)
    strokes = push.course.strokes
    direction = strokes.direction + (push.start.theta if strokes.with_object else 0.0)
    toward = np.array([math.cos(direction), math.sin(direction)])
    tip = push.trajectory.pusher[0] + tip_way[:, None] * toward + MIT_TARGET
    return PushRecord(
        np.column_stack([object_time, pose]),
        np.column_stack([tip_time, tip, np.zeros(len(tip))]),
        np.column_stack([wrench_time, wrench]),
    )


def _states(push: PushResult, distance: float, travel: Array) -> Array:
    """Pose of the object, force on it, contact from the rod's centre at travels (n,), m: (n, 7),
    zero where apart.
    """
    from scipy.interpolate import CubicSpline

    if push.travel > distance * (1.0 + 1e-9):
        raise InvalidInput(
            f"the push went {push.travel:g} m, further than the stroke of {distance:g} m"
        )
    course = push.trajectory
    rows = np.column_stack(
        [course.pose, course.contact_force, course.contact_point - course.pusher]
    )
    state = np.empty((len(travel), 7))
    # Each phase begins with a row of its own, where the one before it ended, and is constant where
    # it has no length.
    for phase in range(course.phase[-1] + 1):
        path = course.path[course.phase == phase]
        own = rows[course.phase == phase]
        on = travel >= (path[0] if phase else -math.inf)
        kept = np.diff(path, prepend=-math.inf) > 0.0
        state[on] = (
            CubicSpline(path[kept], own[kept])(travel[on])
            if np.count_nonzero(kept) > 1
            else own[-1]
        )
    state[travel < 0.0] = (*astuple(push.start), 0.0, 0.0, 0.0, 0.0)
    last = rows[-1, 3:] if push.ended != "left" else np.zeros(4)
    state[travel >= push.travel] = (*astuple(push.end), *last)
    return state


def scan_set(surface: str, shape: str, speed: float) -> list[ScanFacts]:
    """The scans of one object on one surface, as the dataset names them; speed in m/s."""
    directions = np.radians((np.arange(0, 360, 5) + 180) % 360).tolist()
    return [
        ScanFacts(surface, shape, 0.0, speed, direction, repetition)
        for direction in directions
        for repetition in (0.0, 1.0)
    ]


def record_scan(
    friction: EllipseFriction,
    weight: float,
    direction: float,
    recording: Recording,
    generator: np.random.Generator,
) -> ScanRecord:
    """Return what the instruments record of a stroke in `direction` (rad) of an object of `weight`
    (N).

    Every point of the object slides the same way, so that the rod's force on it is the traction of
    the point's friction times the weight, however the pressure is spread; it is zero while the rod
    rests, 0.25 s before and after. The rod holds the object at the friction's centre: no torque.
    """
    way = np.array([math.cos(direction), math.sin(direction)])
    half = SCAN_STROKE / 2.0
    tip_time, travel = recording.samples(-half, half)
    time, pulled = recording.samples(-half, half, WRENCH_LAG)
    force = -weight * friction.traction(way)
    wrench = np.outer(np.abs(pulled) < half, [*force, 0.0])
    wrench += recording.noise.of_wrenches(len(wrench), recording.rod_radius, generator)
    return ScanRecord(
        np.column_stack([tip_time, SCAN_CENTRE + np.outer(travel, way), np.zeros(len(travel))]),
        np.column_stack([time, wrench]),
    )
