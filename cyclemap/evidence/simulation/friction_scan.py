"""Simulated friction scans: straight strokes that carry the object along without turning it."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cyclemap.evidence.pushes.mit_names import ScanFacts
from cyclemap.evidence.pushes.push_record import ScanRecord
from cyclemap.evidence.simulation.recorded_motion import REST_SECONDS, WRENCH_LAG, Recording
from cyclemap.mechanics import EllipseFriction

# As in the dataset: 120 mm through this place (m, robot's frame), every five degrees, twice each.
SCAN_CENTRE = (0.350, -0.018)
SCAN_STROKE = 0.120
SCAN_STEP_DEGREES = 5
SCAN_REPETITIONS = 2


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
    tip, sensor = recording.clock(seconds), recording.clock(seconds, WRENCH_LAG)
    travel = np.clip(recording.speed * (tip.elapsed - REST_SECONDS), 0.0, SCAN_STROKE) - SCAN_STROKE / 2.0
    force = -weight * friction.traction(way)
    moving = (sensor.elapsed >= REST_SECONDS) & (sensor.elapsed <= seconds - REST_SECONDS)
    wrench = np.outer(moving, [*force, 0.0]) + recording.noise.of_wrenches(len(moving), recording.rod_radius, generator)
    return ScanRecord(
        np.column_stack([tip.seen, SCAN_CENTRE + np.outer(travel, way), np.zeros(len(travel))]),
        np.column_stack([sensor.seen, wrench]),
    )
