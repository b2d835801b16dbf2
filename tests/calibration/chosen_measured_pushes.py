"""Of the pushes that MIT's robot made (the data folder), ten chosen by the plan's criterion and ten
at random, by how well they predict those at other contacts: `python -m
tests.calibration.chosen_measured_pushes [DRAWS]`.

The floor is known, the plate is not: its shape is left out of the floor's file, though the floor's
own shape was found with all seven plates.
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
from cyclemap.errors import CycleMapError
from cyclemap.evidence.identification.data_block import usual_beliefs
from cyclemap.evidence.identification.known_floor import known_beliefs
from cyclemap.evidence.identification.stroke_block import push_end_block
from cyclemap.evidence.identification.surface_parameters import (
    FLOOR_NAMES,
    PLATE_NAMES,
    SURFACE,
    SurfaceParameters,
)
from cyclemap.evidence.push_design import Design, Target, over_noise
from cyclemap.evidence.pushes.measured_strokes import SET_OFF, MeasuredPush, push_noise
from cyclemap.mechanics import Slider, load_material
from tests.inference.measured_floors import FLOORS, PLATES, measured as measured_pushes

READ = (1e-3, math.radians(1.0))
TIP_NAMES = ("tip_offset_x", "tip_offset_y")


def of_known_floor(floor: str, plate: str) -> dict[str, tuple[float, float]]:
    """What is believed of pushes of a plate that was never seen on a known floor,
    in a new session."""
    known = load_material(floor)
    names = ("pusher_friction", *FLOOR_NAMES)
    beliefs = known_beliefs(known, names, plate)
    for name, spread in zip(FLOOR_NAMES, known.session_spread, strict=True):
        beliefs[name] = (beliefs[name][0], math.hypot(beliefs[name][1], spread))
    return beliefs | usual_beliefs((*PLATE_NAMES, *TIP_NAMES))


def chosen_of(
    pushes: list[MeasuredPush], slider: Slider, beliefs: dict[str, tuple[float, float]]
) -> list[int]:
    """Ten of the pushes by the plan's criterion: what tells most of where all of them end, over
    draws of beliefs.
    """
    block, noise = push_end_block(pushes, slider), push_noise(READ)[:3]
    columns, rod = ([*map(block.parameters.index, names)] for names in (beliefs, TIP_NAMES))
    centre, width = np.array([*beliefs.values()]).T
    rows = []
    for draw in np.random.default_rng(0).standard_normal((8, len(beliefs))):
        drawn = (centre + 0.7 * width * draw).tolist()
        values = SurfaceParameters().values() | dict(zip(beliefs, drawn, strict=True))
        jacobian = block.residuals(values)[1].reshape(len(pushes), 3, -1)
        rows.append(over_noise(jacobian[..., columns], SET_OFF * jacobian[..., rod], noise))
    by = np.array(rows)
    every = by.reshape(len(by), -1, len(beliefs))
    asked = Target(every, lambda variance: variance.mean(axis=(-2, -1)), lambda _: {})
    design = Design(np.diag(width**2), by, asked)
    return design.exchanged(design.greedy(10, range(len(pushes))))


def missed(
    pushes: list[MeasuredPush],
    chosen: list[int],
    slider: Slider,
    beliefs: dict[str, tuple[float, float]],
) -> tuple[float, float]:
    """Mean distance (mm) and turn (degrees) by which what the chosen pushes tell misses those at
    other contacts.
    """
    noise = push_noise(READ)
    sizes = {"push place (m)": float(noise[0]), "push turn (rad)": float(noise[2])}
    block = push_end_block([replace(pushes[index], contact=index) for index in chosen], slider)
    held = dict.fromkeys(SURFACE.names[1:5], 0.0)
    options = {"priors": beliefs, "noise": sizes, "starts": 1, "student": 4.0}
    identification = cm.identify([block], list(beliefs), held, **options)
    contacts = {pushes[index].contact for index in chosen}
    rest = [push for push in pushes if push.contact not in contacts]
    off = push_end_block(rest, slider).residuals(identification.values)[0].reshape(-1, 3)
    turn = np.degrees(np.abs(off[:, 2]).mean())
    return float(1e3 * np.hypot(off[:, 0], off[:, 1]).mean()), float(turn)


def main(draws: int) -> None:
    """Print what is missed by ten chosen and by ten random pushes, floor by floor and plate by
    plate.
    """
    every = []
    for floor in FLOORS:
        for plate in PLATES:
            pushes, slider = measured_pushes(floor, plate, 10, 120), Slider.mit(plate)
            beliefs = of_known_floor(f"{floor}-floor", plate)
            planned = missed(pushes, chosen_of(pushes, slider, beliefs), slider, beliefs)
            random = []
            for draw in range(draws):
                order = np.random.default_rng([draw, 7]).permutation(len(pushes))[:10].tolist()
                with suppress(CycleMapError):
                    random.append(missed(pushes, order, slider, beliefs))
            mean, better = np.mean(random, axis=0), np.mean(np.array(random) > planned, axis=0)
            every.append([*planned, *mean, *better])
            words = (
                "{:.2f} mm {:.2f} deg, random {:.2f} mm {:.2f} deg; better than {:.0%} and "
                "{:.0%} of them"
            )
            print(f"{floor:8}{plate:7}", words.format(*every[-1]), flush=True)
    print("mean", np.mean(every, axis=0).round(2).tolist())


if __name__ == "__main__":
    main(int((sys.argv[1:] or ["10"])[0]))
