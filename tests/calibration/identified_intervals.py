"""Do 95 % intervals hold the truth? `python -m tests.calibration.identified_intervals [200]`, by
the real mechanics.

Truths are drawn from what is believed beforehand, the floor's shape in each of three sessions from
its mean and spread; a robot whose frame is shifted pushes and drags on each, its camera errs, and
`identify` explains what was recorded. The number is that of collections.
"""

import math
import os
import sys
from contextlib import suppress
from dataclasses import replace

# As the command line does, and before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import cyclemap as cm
from cyclemap.errors import ConvergenceError, UnsupportedContact
from cyclemap.evidence import (
    MeasuredDrag,
    MeasuredPush,
    SurfaceParameters,
    drag_turn_block,
    push_end_block,
)
from cyclemap.evidence.identification.data_block import session_block
from cyclemap.evidence.identification.session_blocks import SESSION_OWNED
from cyclemap.evidence.identification.stroke_block import surface_model
from cyclemap.evidence.identification.surface_parameters import FLOOR_NAMES
from cyclemap.mechanics import Pose, Slider, WorldPush

RECT1 = Slider.mit("rect1")
PUSHES, DRAGS, SESSIONS, SPREAD = 24, 12, 3, 2.0
# Errors of the camera (m, rad) and of where a drag ends (rad).
PLACE, TURN, DRAGGED = 5e-4, math.radians(0.5), math.radians(1.5)
# Centre, deviation and bounds of each unknown.
BELIEVED = {
    "ellipticity_x": (0.0, 0.2, -0.6, 0.6),
    "ellipticity_y": (0.0, 0.2, -0.6, 0.6),
    "offset_x": (0.0, 0.1, -0.3, 0.3),
    "offset_y": (0.0, 0.1, -0.3, 0.3),
    "pusher_friction": (0.15, 0.05, 0.02, 0.4),
    "floor_dome": (0.0, 3.0, -9.0, 9.0),
    "floor_bow_x": (0.0, 3.0, -9.0, 9.0),
    "floor_bow_y": (0.0, 3.0, -9.0, 9.0),
    "plate_dome": (0.0, 3.0, -9.0, 9.0),
    "plate_warp_x": (0.0, 3.0, -9.0, 9.0),
    "plate_warp_y": (0.0, 3.0, -9.0, 9.0),
    "pin_friction_radius": (1.5e-3, 1e-3, 0.0, 5e-3),
    "tip_offset_x": (0.0, 1.5e-3, -4e-3, 4e-3),
    "tip_offset_y": (0.0, 1.5e-3, -4e-3, 4e-3),
}


def drawn_truth(rng: np.random.Generator) -> dict[str, float]:
    """A value of each unknown, within its bounds."""
    truth = {}
    for name, (centre, deviation, low, high) in BELIEVED.items():
        value = math.inf
        while not low <= value <= high:
            value = float(rng.normal(centre, deviation))
        truth[name] = value
    return truth


def recorded(
    truth: dict[str, float], rng: np.random.Generator
) -> tuple[list[MeasuredPush], list[MeasuredDrag]]:
    """50 mm pushes at random places and angles and drags from random poses, as camera and robot
    tell of them.
    """
    model = surface_model(SurfaceParameters.from_values(truth), RECT1, accuracy=1e-5)
    shift, pushes, drags = np.array((truth["tip_offset_x"], truth["tip_offset_y"])), [], []
    while len(pushes) < PUSHES:
        start = Pose(0.0, 0.0, float(rng.uniform(-3.0, 3.0)))
        way = float(rng.uniform(-math.pi, math.pi))
        along = np.array((math.cos(way), math.sin(way)))
        first = np.array(start.to_world(*rng.uniform(-0.02, 0.02, 2).tolist())) - 0.115 * along
        with suppress(ConvergenceError, UnsupportedContact):
            end = model.push(start, WorldPush(tuple(first.tolist()), way, 0.115)).end
            places = (first - shift, first + 0.115 * along - shift)
            tips = (tuple(place.tolist()) for place in places)
            off = rng.normal(0.0, (PLACE, PLACE, TURN))
            seen = Pose(*np.add(off, (end.x, end.y, end.theta)).tolist())
            pushes.append(MeasuredPush(start, seen, *tips, len(pushes)))
    while len(drags) < DRAGS:
        start = Pose(*rng.uniform(-0.08, 0.08, 2).tolist(), float(rng.uniform(-3.0, 3.0)))
        with suppress(ConvergenceError, UnsupportedContact):
            radius = truth["pin_friction_radius"]
            end = model.drag(start, ((0.0, 0.0),), pin_friction_radius=radius).end
            seen = replace(end, theta=end.theta + rng.normal(0.0, DRAGGED))
            drags.append(MeasuredDrag(start, seen, len(drags)))
    return pushes, drags


def held(count: int, seed: int = 0) -> dict[str, list[bool]]:
    """Whether the interval of each unknown held the truth, collection by collection."""
    found: dict[str, list[bool]] = {}
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        truth, blocks = drawn_truth(rng), []
        sessions = [f"s{session}" for session in range(SESSIONS)]
        for session in sessions:
            off = SPREAD * rng.standard_normal(len(FLOOR_NAMES))
            own = {name: truth[name] + by for name, by in zip(FLOOR_NAMES, off, strict=True)}
            pushes, drags = recorded(truth | own, rng)
            for block in (push_end_block(pushes, RECT1), drag_turn_block(drags, RECT1)):
                named = replace(block, name=f"{session} {block.name}")
                blocks.append(named.of_owner(session, SESSION_OWNED))
            truth |= {f"{name}[{session}]": value for name, value in own.items()}
        beliefs = {name: belief[:2] for name, belief in BELIEVED.items()}
        try:
            every = [*blocks, session_block(sessions)]
            told = cm.identify(every, list(truth), priors=beliefs, starts=1)
        except ConvergenceError:
            continue
        for name, value in truth.items():
            plain = name.partition("[")[0] + " of a session" * ("[" in name)
            is_held = told[name].lower - 1e-12 <= value <= told[name].upper + 1e-12
            found.setdefault(plain, []).append(is_held)
    return found


if __name__ == "__main__":
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    counted = held(runs)
    for unknown, hits in counted.items():
        print(f"{unknown:20} {sum(hits):4} of {len(hits)}: {100.0 * np.mean(hits):.1f} %")
    print(f"all: {100.0 * np.mean([hit for hits in counted.values() for hit in hits]):.1f} %")
