"""What planned pushes tell of worlds that are drawn, beside random ones: `python -m
tests.calibration.planned_pushes`.

`own [200 [FIRST [COLUMN ...]]]`: floor, rod and ring of a sample of `unknown`, the plate of
another, both turned by any angle; rods are set off their marks, pushes and drags run at a
ten-thousandth of the error that identification works with, and err as much as measured ones do.
From each set of pushes the floor is identified as `cyclemap plan --after` does it. Asked are the
error of the stable direction, whether 95 % intervals hold it, and whether the loop locks in, with
the chance told. `dynamic` and `mujoco` ask the same of worlds of the dynamic simulation, whose rod
is fast, and of MuJoCo (the `peers` extra), whose ellipse has its centre in its middle and whose
ring has no friction; the truth is their own map then.

A column is a sort of choice and a number of pushes: `planned-8`; `random-8`; `staged-8`, half of
them planned, the others by what the first told; `knowing-8`, chosen by who knows the world, which
no plan can.

`summary FILE ...`: the table of what worlds printed, of some columns in one file or in several.
"""

import cmath
import json
import math
import os
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
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
from cyclemap.evidence.identification.identify import Identification
from cyclemap.evidence.identification.stroke_block import loop_on
from cyclemap.evidence.identification.surface_parameters import (
    PLATE_NAMES,
    SurfaceParameters,
    starting_space,
)
from cyclemap.evidence.identified_material import identified_material, sampled_values
from cyclemap.evidence.measured_plan import empty_table, identified_plan
from cyclemap.evidence.plan_pushes import APPROACH, SetPush, candidate_pushes, plan_pushes
from cyclemap.evidence.push_design import (
    UNKNOWNS,
    Design,
    SampledBeliefs,
    cycle_map_by_unknowns,
    push_sensitivity,
    sampled_beliefs,
    target_of,
)
from cyclemap.evidence.pushes.measured_strokes import SET_OFF, push_noise
from cyclemap.evidence.tables.planned_table import filled_text, mark_columns, marks_of
from cyclemap.mechanics import Pose, Slider, WorldPush
from tests.calibration.other_worlds import DynamicWorld, OwnWorld, World, stable_directions

READ = (1e-3, math.radians(1.0))
COLUMNS = (
    *("planned-4", "random-4", "planned-8", "random-8", "staged-8", "knowing-8"),
    *("planned-16", "random-16"),
)
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
    values = floor | {name: plate[name] for name in PLATE_NAMES}
    turns = {"ellipticity": 2.0, "offset": 1.0, "floor_bow": 2.0, "plate_warp": 2.0}
    about = {"plate_warp": float(rng.uniform(0.0, 2.0 * np.pi))}
    angle = float(rng.uniform(0.0, 2.0 * np.pi))
    for name, order in turns.items():
        vector = complex(values[f"{name}_x"], values[f"{name}_y"])
        vector *= cmath.exp(1j * order * about.get(name, angle))
        values |= {f"{name}_x": vector.real, f"{name}_y": vector.imag}
    return SurfaceParameters.from_values(values)


def filled(
    loop: cm.CollectionLoop,
    world: World,
    pushes: Sequence[SetPush],
    rng: np.random.Generator,
) -> str:
    """The table of pushes as it is filled in by somebody with a ruler, and read."""
    header, rows = empty_table(loop, pushes, READ, "corners")
    lengths = [name for name in header if name.endswith("_mm")]
    frame = pd.DataFrame(rows, columns=header).astype(dict.fromkeys(lengths, float))
    slider = loop.slider
    missed = push_noise((0.0, 0.0))
    reading = np.array((READ[0], READ[0], READ[1]))
    for number, planned in enumerate(pushes):
        # The object lies about where it was read to be, and the rod is set off its mark.
        first, last = planned.rod(slider, loop.pusher.radius)
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
            places = [1e3 * size for mark in marks_of(slider) for size in pose.to_world(*mark)]
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


def identified(loop: cm.CollectionLoop, texts: Sequence[str]) -> Identification:
    """What tables that were filled in tell of the floor."""
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder, f"read_{number}.csv") for number in range(len(texts))]
        for path, text in zip(paths, texts, strict=True):
            path.write_text(text)
        return identified_plan(loop, paths, starts=1)[0]


def answered(loop: cm.CollectionLoop, identification: Identification) -> Answer:
    """Look at the stable directions of draws, whose maps are to first order about the best one's."""
    best = {**identification.values}
    turn, _, by = cycle_map_by_unknowns(loop, best, THETA)
    rows = sampled_values(identification, 400)
    draws = np.array([[row[name] for name in UNKNOWNS] for row in rows])
    turns = turn + (draws - [best[name] for name in UNKNOWNS]) @ by.T
    points = [THETA[(row > 0.0) & (np.roll(row, -1) <= 0.0)] for row in turns]
    locks = [row for row in points if row.size]
    if not locks:
        return Answer(0.0, float(THETA[np.argmin(np.abs(turn))]), 0.0, 0.0)
    middle = float(np.angle(np.exp(1j * np.concatenate(locks)).sum()))
    nearest = [shorter_way(row - middle) for row in locks]
    away = np.array([row[np.argmin(np.abs(row))] for row in nearest])
    centre, lower, upper = np.quantile(away, (0.5, 0.025, 0.975)).tolist()
    return Answer(len(locks) / len(points), middle + centre, middle + lower, middle + upper)


def world_of(kind: str, surface: SurfaceParameters, loop: cm.CollectionLoop) -> World:
    """Return a world of a kind with these numbers, as far as it has them."""
    if kind == "mujoco":
        from tests.benchmarks.peers.mujoco_world import MujocoWorld

        left_out = dict.fromkeys(("offset_x", "offset_y", "pin_friction_radius"), 0.0)
        surface = SurfaceParameters.from_values(surface.values() | left_out)
        return MujocoWorld(loop_on(surface, loop))
    exact = replace(loop_on(surface, loop), accuracy=1e-7)
    return DynamicWorld(exact) if kind == "dynamic" else OwnWorld(exact)


@cache
def planned(loop: cm.CollectionLoop, count: int) -> tuple[SetPush, ...]:
    """So many pushes as `cyclemap plan` chooses them."""
    return plan_pushes(loop, count, read=READ).pushes


@cache
def offered(loop: cm.CollectionLoop) -> tuple[SetPush, ...]:
    """Pushes of which some are made at random, or by who knows the world."""
    return candidate_pushes(loop, 400, math.radians(15.0), 0.36, 1)


def knowing(loop: cm.CollectionLoop, surface: SurfaceParameters, count: int) -> list[SetPush]:
    """The pushes that the plan's criterion chooses where the world is known."""
    believed = SampledBeliefs(loop, (surface.values(),), sampled_beliefs(loop, 2).covariance)
    pushes = offered(loop)[:160]
    made = [push.measured(loop.slider, loop.pusher.radius) for push in pushes]
    _, by, derivatives = push_sensitivity(believed, made, READ)
    target = target_of(believed, "direction", by, push_noise(READ)[:3])
    design = Design(believed.covariance, derivatives, target)
    chosen = design.exchanged(design.greedy(count, range(len(pushes))))
    return [pushes[index] for index in chosen]


def tables(
    sort: str,
    count: int,
    loop: cm.CollectionLoop,
    world: World,
    surface: SurfaceParameters,
    rng: np.random.Generator,
) -> list[str]:
    """The tables that are filled in, of so many pushes of a sort of choice."""
    if sort == "knowing":
        return [filled(loop, world, knowing(loop, surface, count), rng)]
    if sort == "random":
        order = rng.permutation(len(offered(loop)))[:count]
        return [filled(loop, world, [offered(loop)[index] for index in order], rng)]
    if sort == "planned":
        return [filled(loop, world, planned(loop, count), rng)]
    first = filled(loop, world, planned(loop, count // 2), rng)
    known = {"plate": loop.slider.name, "floor": loop.material}
    material = identified_material(identified(loop, [first]), "measured", ["plan.csv"], **known)
    after = replace(loop, footprint=None).with_material(material)
    return [first, filled(loop, world, plan_pushes(after, count // 2, read=READ).pushes, rng)]


def identified_errors(count: int) -> np.ndarray:
    """(count, k): how far the unknowns of so many worlds are from what eight planned pushes tell of
    them, in standard deviations of what is believed then.
    """
    loop = own_loop()
    plan = planned(loop, 8)
    errors = []
    for number in range(count):
        rng = np.random.default_rng([37, number])
        surface = drawn_world(loop, rng)
        world = world_of("own", surface, loop)
        identification = identified(loop, [filled(loop, world, plan, rng)])
        rows = sampled_values(identification, 400)
        draws = np.array([[row[name] for name in UNKNOWNS] for row in rows])
        truth, best = surface.values(), identification.values
        off = np.array([truth[name] - best[name] for name in UNKNOWNS])
        errors.append(off / draws.std(axis=0))
    return np.array(errors)


def worlds(kind: str, count: int, first: int, columns: Sequence[str]) -> None:
    """Print a line of JSON for each world of a kind: of so many of them, from number `first` on;
    what is drawn depends on world and column alone.
    """
    loop, sorts = own_loop(), ("planned", "random", "staged", "knowing")
    for number in range(first, first + count):
        surface = drawn_world(loop, np.random.default_rng([31, number]))
        world = world_of(kind, surface, loop)
        if isinstance(world, OwnWorld):
            orbits = cm.fixed_points(world.loop.circle_map(1e-4))
            stable = [float(orbit.points[0]) for orbit in orbits if orbit.stable]
        else:
            stable = stable_directions(world, loop)
        row: dict[str, object] = {"world": number, "stable": stable}
        for column in columns:
            sort, _, pushes = column.partition("-")
            rng = np.random.default_rng([77 + sorts.index(sort), number, int(pushes)])
            with suppress(CycleMapError):
                filled_in = tables(sort, int(pushes), loop, world, surface, rng)
                row[column] = vars(answered(loop, identified(loop, filled_in)))
        print(json.dumps(row), flush=True)


def summary(lines: list[str]) -> None:
    """Print the table of what worlds came to."""
    worlds_by_number: dict[int, dict[str, Any]] = {}
    for line in lines:
        row = json.loads(line)
        worlds_by_number.setdefault(row["world"], {}).update(row)
    rows = list(worlds_by_number.values())
    print(f"{len(rows)} worlds, {sum(bool(row['stable']) for row in rows)} lock in")
    for column in COLUMNS:
        known = [(row["stable"], row[column]) for row in rows if column in row]
        if known:
            print(f"{column:11} {direction_words(known)}\n{'':11} {chance_words(known)}")


def direction_words(known: list[tuple[list[float], dict[str, float]]]) -> str:
    """How far stable directions are off what is believed, and how often intervals hold them."""
    off = []
    held = []
    for stable, answer in known:
        if not stable:
            continue
        away = shorter_way(answer["direction"] - np.array(stable))
        off.append(float(np.abs(away).min()) if answer["chance"] else NOTHING)
        if answer["chance"] > 0.05:
            half = 0.5 * (answer["upper"] - answer["lower"])
            middle = 0.5 * (answer["upper"] + answer["lower"])
            nearest = stable[int(np.argmin(np.abs(away)))]
            held.append(abs(float(shorter_way(nearest - middle))) <= half)
    median, mean = math.degrees(np.median(off)), math.degrees(np.mean(off))
    words = f"direction off by median {median:5.1f}, mean {mean:5.1f} deg of {len(off)}"
    return f"{words}; held {sum(held)} of {len(held)}"


def chance_words(known: list[tuple[list[float], dict[str, float]]]) -> str:
    """How often it is right whether worlds lock in, and how often they do by the chance told."""
    chance = np.array([answer["chance"] for _, answer in known])
    truth = np.array([bool(stable) for stable, _ in known])
    right, brier = np.mean((chance > 0.5) == truth), np.mean((chance - truth) ** 2)
    words = [f"whether right {right:.1%} of {len(known)}, Brier {brier:.3f}"]
    for low, high in ((0.0, 0.1), (0.1, 0.3), (0.3, 0.7), (0.7, 0.9), (0.9, 1.01)):
        inside = (chance >= low) & (chance < high)
        if inside.any():
            share = f"{truth[inside].mean():.2f} of {inside.sum()}"
            words.append(f"{low:g}-{min(high, 1.0):g}: {share}")
    return "; ".join(words)


if __name__ == "__main__":
    what, *rest = sys.argv[1:] or ["own"]
    if what == "summary":
        summary([line for path in rest for line in Path(path).read_text().splitlines()])
    else:
        count, first = (int(word) for word in (*rest[:2], *("200", "0")[len(rest) :]))
        worlds(what, count, first, rest[2:] or COLUMNS)
