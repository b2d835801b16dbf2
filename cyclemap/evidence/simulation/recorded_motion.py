"""What the instruments record: clocks as in the MIT files, and the noise of poses and of the force sensor."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import non_negative_number, positive_number
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.evidence.pushes.contact_forces import MIT_ROD_RADIUS

SAMPLES_PER_SECOND = 250.0
# As in the measured files: the rod rests a quarter of a second before and after its stroke, and the clocks of the tip
# and of the force sensor start a little after the object's.
REST_SECONDS = 0.25
TIP_LAG, WRENCH_LAG = 0.009, 0.011
# Seconds since 1970, as robots count: the first of January 2016, the year of the dataset.
FIRST_CLOCK = 1_451_606_400.0
# Where the reset brings the ring to, (x, y) in the robot's frame, m.
MIT_TARGET = (0.350, -0.030)


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


@dataclass(frozen=True, eq=False)
class Clock:
    """Times of samples: `seen`, as recorded (seconds since 1970), and `elapsed`, the same since the record began."""

    seen: Array
    elapsed: Array


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

    def clock(self, seconds: float, lag: float = 0.0) -> Clock:
        """Samples at 250 Hz from `lag` on until `seconds` are past.

        `elapsed` is made of the recorded times, which a double holds to a quarter of a microsecond only.
        """
        count = math.ceil(seconds * SAMPLES_PER_SECOND) + 1
        seen = self.start + (lag + np.arange(count) / SAMPLES_PER_SECOND)
        return Clock(seen, seen - self.start)
