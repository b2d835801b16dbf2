"""What planned pushes tell of worlds that are drawn, beside random ones: `python -m
tests.calibration.planned_pushes`.

`own [200 [FIRST [COUNT ...]]]`: floor, rod and ring of a sample of `unknown`, the plate of
another, both turned by any angle; rods are set off their marks, pushes and drags run at a
ten-thousandth of the error that identification works with, and err as much as measured ones do.
From each set of pushes the floor is identified as `cyclemap plan --after` does it. Asked are the
error of the stable direction, whether 95 % intervals hold it, and whether the loop locks in, with
the chance told. `dynamic` and `mujoco` ask the same of worlds of the dynamic simulation, whose rod
is fast, and of MuJoCo (the `peers` extra), whose ellipse has its centre in its middle and whose
ring has no friction; the truth is their own map then.

`measured [10]`: of the pushes that MIT's robot made (the data folder), ten chosen by the criterion
of the plan predict those at other contacts, beside so many draws of ten. The floor is known, the
plate is not: its shape is left out of the floor's file, though the floor's own shape was found with
all seven plates.

`summary FILE ...`: the table of what worlds printed, of some counts in one file or in several.
"""

import json
import math
import os
import sys
import tempfile
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

# As the command line does, and before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import pandas as pd

import cyclemap as cm
from cyclemap.arrays import shorter_way
from cyclemap.collection.loop_surfaces import on_material
from cyclemap.errors import CycleMapError
from cyclemap.evidence.data_blocks.stroke_block import loop_on, push_end_block
from cyclemap.evidence.identification.data_block import usual_beliefs
from cyclemap.evidence.identification.known_floor import known_beliefs
from cyclemap.evidence.identification.surface_parameters import (
    FLOOR_NAMES,
    PLATE_NAMES,
    SURFACE,
    SurfaceParameters,
    starting_space,
)
from cyclemap.evidence.identified_material import sampled_values
from cyclemap.evidence.measured_plan import identified_plan
from cyclemap.evidence.push_plan.candidates import APPROACH, SetPush, candidate_pushes
from cyclemap.evidence.push_plan.plan_pushes import Design, plan_pushes
from cyclemap.evidence.push_plan.plan_table import empty_table
from cyclemap.evidence.push_plan.sensitivity import (
    UNKNOWNS,
    Target,
    cycle_map_by_unknowns,
    over_noise,
)
from cyclemap.evidence.pushes.measured_strokes import SET_OFF, MeasuredPush, push_noise
from cyclemap.evidence.tables.planned_table import filled_text, mark_columns, marks_of
from cyclemap.mechanics import Pose, Slider, WorldPush, load_material
from tests.calibration.other_worlds import DynamicWorld, OwnWorld, World, stable_directions
from tests.inference.measured_floors import FLOORS, PLATES, measured as measured_pushes

READ = (1e-3, math.radians(1.0))
COUNTS = (4, 8, 16)
TIP_NAMES = ("tip_offset_x", "tip_offset_y")
THETA = 2.0 * np.pi * np.arange(720) / 720
# Of a direction of which nothing is known.
NOTHING = math.radians(90.0)


def own_loop() -> cm.CollectionLoop:
    """MIT's loop with a plate that nobody has measured, on a floor that nobody has."""
    return cm.CollectionLoop.mit(
        material="unknown", slider=replace(Slider.mit("rect1"), name="plate")
    )


def drawn_world(loop: cm.CollectionLoop, rng: np.random.Generator) -> SurfaceParameters:
    """A floor with rod and ring, a plate of another sample, the floor turned by any angle, the
    plate by any other.
    """
    count = len(loop.material.posterior)
    floor, plate = (
        starting_space(on_material(loop, loop.material.sample(int(number)))).nominal
        for number in rng.integers(0, count, 2)
    )
    values = floor | {name: plate[name] for name in ("plate_dome", "plate_warp_x", "plate_warp_y")}
    turns = {"ellipticity": 2.0, "offset": 1.0, "floor_bow": 2.0, "plate_warp": 2.0}
    about = {"plate_warp": float(rng.uniform(0.0, 2.0 * np.pi))}
    angle = float(rng.uniform(0.0, 2.0 * np.pi))
    for name, order in turns.items():
        x, y = values[f"{name}_x"], values[f"{name}_y"]
        c, s = math.cos(order * about.get(name, angle)), math.sin(order * about.get(name, angle))
        values |= {f"{name}_x": c * x - s * y, f"{name}_y": s * x + c * y}
    return SurfaceParameters.from_values(values)


def filled(
    loop: cm.CollectionLoop,
    world: World,
    pushes: list[SetPush],
    rng: np.random.Generator,
) -> str:
    """The table of pushes as it is filled in by somebody with a ruler, and read."""
    header, rows = empty_table(loop, pushes, READ, "corners")
    frame = pd.DataFrame(rows, columns=header).astype(
        {name: float for name in header if name.endswith("_mm")}
    )
    slider, missed = loop.slider, push_noise((0.0, 0.0))
    reading = np.array((READ[0], READ[0], READ[1]))
    for number, planned in enumerate(pushes):
        # The object lies about where it was read to be, and the rod is set off its mark.
        first, last = (np.array(place) for place in planned.rod(slider, loop.pusher.radius))
        way = (last - first) / planned.push.distance
        read = np.array((planned.start.x, planned.start.y, planned.start.theta))
        lying = Pose(*(read + reading * rng.normal(size=3)).tolist())
        sent = (first - APPROACH * way + SET_OFF * rng.normal(size=2)).tolist()
        far = planned.push.distance + APPROACH
        end = world.push(lying, WorldPush((sent[0], sent[1]), math.atan2(way[1], way[0]), far))
        # What no model says of a push moves the object, and the drag begins there.
        ended = Pose(*(np.array((end.x, end.y, end.theta)) + missed[:3] * rng.normal(size=3)))
        goal = planned.start.to_world(*slider.hitch)
        back = world.drag(ended, goal)
        seen = Pose(*(np.array((ended.x, ended.y, ended.theta)) + reading * rng.normal(size=3)))
        turned = back.theta + float(missed[3] * rng.normal() + reading[2] * rng.normal())
        lever = Pose(theta=turned).to_world(*slider.hitch)
        states = (planned.start, seen, Pose(goal[0] - lever[0], goal[1] - lever[1], turned))
        for state, pose in zip("012", states, strict=True):
            places = [1e3 * part for mark in marks_of(slider) for part in pose.to_world(*mark)]
            frame.loc[number, list(mark_columns(state))] = places
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "plan.csv")
        frame.to_csv(path, index=False)
        return filled_text(path)[0]


@dataclass(frozen=True)
class Answer:
    """What is believed after pushes: chance of locking in, its direction and the 95 % interval
    about it, rad.
    """

    chance: float
    direction: float
    lower: float
    upper: float


def answered(loop: cm.CollectionLoop, text: str) -> Answer:
    """Identify, and look at the stable directions of draws, whose maps are to first order about the
    best one's.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "read.csv")
        path.write_text(text)
        found, _ = identified_plan(loop, [path], starts=1)
    best = {**found.values}
    turn, _, by = cycle_map_by_unknowns(loop, best, THETA)
    draws = np.array([[one[name] for name in UNKNOWNS] for one in sampled_values(found, 400)])
    turns = turn + (draws - [best[name] for name in UNKNOWNS]) @ by.T
    points = []
    for row in turns:
        crossing = np.flatnonzero((row > 0.0) & (np.roll(row, -1) <= 0.0))
        points.append(THETA[crossing])
    locks = [row for row in points if row.size]
    if not locks:
        return Answer(0.0, float(THETA[np.argmin(np.abs(turn))]), 0.0, 0.0)
    middle = float(np.angle(np.exp(1j * np.concatenate(locks)).sum()))
    nearest = [shorter_way(row - middle) for row in locks]
    away = np.array([row[np.argmin(np.abs(row))] for row in nearest])
    centre, lower, upper = np.quantile(away, (0.5, 0.025, 0.975)).tolist()
    return Answer(len(locks) / len(points), middle + centre, middle + lower, middle + upper)


def identified_errors(count: int) -> np.ndarray:
    """(count, k): how far the unknowns of so many worlds are from what eight planned pushes tell of
    them, in standard deviations of what is believed then.
    """
    loop = own_loop()
    plan = list(plan_pushes(loop, 8, read=READ).pushes)
    errors = []
    for number in range(count):
        rng = np.random.default_rng([37, number])
        surface = drawn_world(loop, rng)
        world = OwnWorld(replace(loop_on(surface, loop), accuracy=1e-7))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "read.csv")
            path.write_text(filled(loop, world, plan, rng))
            found, _ = identified_plan(loop, [path], starts=1)
        draws = np.array([[row[name] for name in UNKNOWNS] for row in sampled_values(found, 400)])
        truth = surface.values()
        off = np.array([truth[name] - found.values[name] for name in UNKNOWNS])
        errors.append(off / draws.std(axis=0))
    return np.array(errors)


def world_of(kind: str, surface: SurfaceParameters, loop: cm.CollectionLoop) -> World:
    """Return a world of a kind with these numbers, as far as it has them."""
    if kind == "mujoco":
        from tests.benchmarks.peers.mujoco_world import MujocoWorld

        left_out = dict.fromkeys(("offset_x", "offset_y", "pin_friction_radius"), 0.0)
        surface = SurfaceParameters.from_values(surface.values() | left_out)
        return MujocoWorld(loop_on(surface, loop))
    exact = replace(loop_on(surface, loop), accuracy=1e-7)
    return DynamicWorld(exact) if kind == "dynamic" else OwnWorld(exact)


def worlds(kind: str, count: int, first: int = 0, *counts: int) -> None:
    """Print a line of JSON for each world of a kind: of so many of them, from number `first` on,
    after these counts of pushes; what is drawn depends on world and count alone.
    """
    loop = own_loop()
    plans = {
        number: list(plan_pushes(loop, number, read=READ).pushes) for number in counts or COUNTS
    }
    offered = list(candidate_pushes(loop, 400, math.radians(15.0), 0.36, 1))
    for number in range(first, first + count):
        surface = drawn_world(loop, np.random.default_rng([31, number]))
        world = world_of(kind, surface, loop)
        if isinstance(world, OwnWorld):
            orbits = cm.fixed_points(world.loop.circle_map(1e-4))
            stable = [float(orbit.points[0]) for orbit in orbits if orbit.stable]
        else:
            stable = stable_directions(world, loop)
        told: dict[str, object] = {"world": number, "stable": stable}
        for pushes, planned in plans.items():
            for name, seed in (("planned", 77), ("random", 78)):
                rng = np.random.default_rng([seed, number, pushes])
                chosen = planned
                if name == "random":
                    chosen = [offered[index] for index in rng.permutation(len(offered))[:pushes]]
                with suppress(CycleMapError):
                    text = filled(loop, world, chosen, rng)
                    told[f"{name} {pushes}"] = vars(answered(loop, text))
        print(json.dumps(told), flush=True)


def summary(lines: list[str]) -> None:
    """Print the table of what worlds came to."""
    worlds_by_number: dict[int, dict[str, Any]] = {}
    for line in lines:
        row = json.loads(line)
        worlds_by_number.setdefault(row["world"], {}).update(row)
    rows = list(worlds_by_number.values())
    locking = [row for row in rows if row["stable"]]
    print(f"{len(rows)} worlds, {len(locking)} lock in")
    for key in [f"{name} {count}" for count in COUNTS for name in ("planned", "random")]:
        if not any(key in row for row in rows):
            continue
        off, held = [], []
        for row in locking:
            answer = row.get(key)
            if answer is None:
                continue
            away = [float(shorter_way(answer["direction"] - theta)) for theta in row["stable"]]
            nearest = row["stable"][int(np.argmin(np.abs(away)))]
            off.append(min(map(abs, away)) if answer["chance"] else NOTHING)
            if answer["chance"] > 0.05:
                half = 0.5 * (answer["upper"] - answer["lower"])
                middle = 0.5 * (answer["upper"] + answer["lower"])
                held.append(abs(float(shorter_way(nearest - middle))) <= half)
        told = [(row[key]["chance"], bool(row["stable"])) for row in rows if key in row]
        chance, truth = np.array(told, dtype=float).T
        right = np.mean((chance > 0.5) == (truth > 0.5))
        brier = np.mean((chance - truth) ** 2)
        curve = []
        for low, high in ((0.0, 0.1), (0.1, 0.3), (0.3, 0.7), (0.7, 0.9), (0.9, 1.01)):
            inside = (chance >= low) & (chance < high)
            curve.append(
                f"{low:g}-{min(high, 1.0):g}: {truth[inside].mean():.2f} of {inside.sum()}"
                if inside.any()
                else ""
            )
        median, mean = math.degrees(np.median(off)), math.degrees(np.mean(off))
        kept = f"held {np.mean(held):.0%} of {len(held)}"
        print(f"{key:11} direction off by median {median:5.1f}, mean {mean:5.1f} deg; {kept}")
        print(
            f"{'':11} whether right {right:.1%} of {len(told)}, Brier {brier:.3f}; "
            f"{'; '.join(filter(None, curve))}"
        )


def of_known_floor(floor: str, plate: str) -> dict[str, tuple[float, float]]:
    """What is believed of pushes of a plate that was never seen on a known floor,
    in a new session."""
    known = load_material(floor)
    seen = replace(known, plates=(), posterior=None, sessions=(), frames=())
    names = ("pusher_friction", *FLOOR_NAMES)
    told = known_beliefs(known, names, plate)
    told |= {
        name: (told[name][0], math.hypot(told[name][1], spread))
        for name, spread in zip(FLOOR_NAMES, seen.session_spread, strict=True)
    }
    return told | usual_beliefs((*PLATE_NAMES, *TIP_NAMES))


def chosen_of(
    pushes: list[MeasuredPush], slider: Slider, beliefs: dict[str, tuple[float, float]]
) -> list[int]:
    """Ten of the pushes by the plan's criterion: what tells most of where all of them end, over
    draws of beliefs.
    """
    block, rng, noise = (
        push_end_block(pushes, slider),
        np.random.default_rng(0),
        push_noise(READ)[:3],
    )
    columns, rod = (
        [block.parameters.index(name) for name in names] for names in (beliefs, TIP_NAMES)
    )
    centre, width = np.array([*beliefs.values()]).T
    rows = []
    for draw in rng.standard_normal((8, len(beliefs))):
        values = SurfaceParameters().values() | dict(
            zip(beliefs, (centre + 0.7 * width * draw).tolist(), strict=True)
        )
        jacobian = block.residuals(values)[1].reshape(len(pushes), 3, -1)
        rows.append(over_noise(jacobian[..., columns], SET_OFF * jacobian[..., rod], noise))
    by = np.array(rows)
    asked = Target(
        by.reshape(len(by), -1, len(beliefs)),
        lambda variance: variance.mean(axis=(-2, -1)),
        lambda _: {},
    )
    design = Design(np.diag(width**2), by, asked)
    return design.exchanged(design.greedy(10))


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
    found = cm.identify(
        [block], list(beliefs), held, priors=beliefs, noise=sizes, starts=1, student=4.0
    )
    contacts = {pushes[index].contact for index in chosen}
    rest = [push for push in pushes if push.contact not in contacts]
    off = push_end_block(rest, slider).residuals(found.values)[0].reshape(-1, 3)
    return float(1e3 * np.hypot(off[:, 0], off[:, 1]).mean()), float(
        np.degrees(np.abs(off[:, 2]).mean())
    )


def measured(draws: int) -> None:
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
    what, *rest = sys.argv[1:] or ["own"]
    if what == "measured":
        measured(int((rest or ["10"])[0]))
    elif what in ("own", "dynamic", "mujoco"):
        worlds(what, *(int(number) for number in rest or ["200"]))
    else:
        summary([line for path in rest for line in Path(path).read_text().splitlines()])
