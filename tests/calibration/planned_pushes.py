"""What planned pushes tell of worlds that are drawn, beside random ones: `python -m tests.calibration.planned_pushes`.

`worlds [200]`: floor, rod and ring of a sample of `unknown`, the plate of another, all turned by any angle; pushes and
drags run at a ten-thousandth of the error that identification works with, and err as much as measured ones do. From
each set of pushes the floor is identified as `cyclemap plan --after` does it. Asked are the error of the stable
direction, whether 95 % intervals hold it, and whether the loop locks in, with the chance that was told.

`measured [50]`: of the pushes that exist (the data folder), ten chosen by the plan's criterion predict the rest, beside
ten random ones.
"""

import json
import math
import os
import sys
import tempfile
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

# As the command line does, and before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import pandas as pd

import cyclemap as cm
from cyclemap.arrays import shorter_way
from cyclemap.errors import CycleMapError
from cyclemap.evidence.data_blocks.stroke_block import loop_on
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters, starting_space
from cyclemap.evidence.identified_material import sampled_values
from cyclemap.evidence.measured_plan import identified_plan
from cyclemap.evidence.push_plan.candidates import SetPush, candidate_pushes
from cyclemap.evidence.push_plan.plan_pushes import plan_pushes
from cyclemap.evidence.push_plan.plan_table import table_of
from cyclemap.evidence.push_plan.sensitivity import UNKNOWNS, cycle_map_by_unknowns
from cyclemap.evidence.pushes.planned_table import filled_text, mark_columns, marks_of, push_noise
from cyclemap.mechanics import Pose, Slider
from cyclemap.protocol.settings import sampled_loop

READ = (1e-3, math.radians(1.0))
COUNTS = (4, 8, 16)
THETA = 2.0 * np.pi * np.arange(720) / 720
# Of a direction of which nothing is known.
NOTHING = math.radians(90.0)


def own_loop() -> cm.CollectionLoop:
    """MIT's loop with a plate that nobody has measured, on a floor that nobody has."""
    return cm.CollectionLoop.mit(material="unknown", slider=replace(Slider.mit("rect1"), name="plate"))


def drawn_world(loop: cm.CollectionLoop, rng: np.random.Generator) -> SurfaceParameters:
    """A floor with rod and ring, a plate of another sample, the floor turned by any angle, the plate by any other."""
    count = len(loop.material.posterior)
    floor, plate = (starting_space(sampled_loop(loop, int(number))).nominal for number in rng.integers(0, count, 2))
    values = floor | {name: plate[name] for name in ("plate_dome", "plate_warp_x", "plate_warp_y")}
    turns = {"ellipticity": 2.0, "offset": 1.0, "floor_bow": 2.0, "plate_warp": 2.0}
    about = {"plate_warp": float(rng.uniform(0.0, 2.0 * np.pi))}
    angle = float(rng.uniform(0.0, 2.0 * np.pi))
    for name, order in turns.items():
        x, y = values[f"{name}_x"], values[f"{name}_y"]
        c, s = math.cos(order * about.get(name, angle)), math.sin(order * about.get(name, angle))
        values |= {f"{name}_x": c * x - s * y, f"{name}_y": s * x + c * y}
    return SurfaceParameters.from_values(values)


def filled(loop: cm.CollectionLoop, world: cm.CollectionLoop, pushes: list[SetPush], rng: np.random.Generator) -> str:
    """The table of pushes as it is filled in by somebody with a ruler, and read."""
    header, rows = table_of(loop, pushes, READ, "corners")
    frame = pd.DataFrame(rows, columns=header).astype({name: float for name in header if name.endswith("_mm")})
    noise, slider = push_noise(READ), loop.slider
    for number, planned in enumerate(pushes):
        end = world.model.push(planned.start, planned.push).end
        seen = Pose(*(np.array((end.x, end.y, end.theta)) + noise[:3] * rng.standard_normal(3)).tolist())
        goal = planned.start.to_world(*slider.hitch)
        back = world.model.drag(end, (goal,), pin_friction_radius=world.reset.pin_friction_radius).end
        turned = back.theta - end.theta + seen.theta + float(noise[3] * rng.standard_normal())
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
    """What is believed after pushes: chance of locking in, its direction and the 95 % interval about it, rad."""

    chance: float
    direction: float
    lower: float
    upper: float


def answered(loop: cm.CollectionLoop, text: str) -> Answer:
    """Identify, and look at the stable directions of draws, whose maps are to first order about the best one's."""
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


def worlds(count: int, first: int = 0) -> None:
    """Print a line of JSON for each world."""
    loop = own_loop()
    plans = {number: list(plan_pushes(loop, number, read=READ).pushes) for number in COUNTS}
    offered = list(candidate_pushes(loop, 400, math.radians(15.0), 0.36, 1))
    for number in range(first, first + count):
        rng = np.random.default_rng([31, number])
        surface = drawn_world(loop, rng)
        world = replace(loop_on(surface, loop), accuracy=1e-7)
        stable = [float(orbit.points[0]) for orbit in cm.fixed_points(world.circle_map(1e-4)) if orbit.stable]
        told: dict[str, object] = {"world": number, "stable": stable}
        for pushes in COUNTS:
            random = [offered[index] for index in rng.permutation(len(offered))[:pushes]]
            for name, chosen in (("planned", plans[pushes]), ("random", random)):
                with suppress(CycleMapError):
                    told[f"{name} {pushes}"] = vars(answered(loop, filled(loop, world, chosen, rng)))
        print(json.dumps(told), flush=True)


def summary(lines: list[str]) -> None:
    """Print the table of what worlds came to."""
    rows = [json.loads(line) for line in lines]
    locking = [row for row in rows if row["stable"]]
    print(f"{len(rows)} worlds, {len(locking)} lock in")
    for key in [f"{name} {count}" for count in COUNTS for name in ("planned", "random")]:
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
                f"{low:g}-{min(high, 1.0):g}: {truth[inside].mean():.2f} of {inside.sum()}" if inside.any() else ""
            )
        median, mean = math.degrees(np.median(off)), math.degrees(np.mean(off))
        kept = f"held {np.mean(held):.0%} of {len(held)}"
        print(f"{key:11} direction off by median {median:5.1f}, mean {mean:5.1f} deg; {kept}")
        print(f"{'':11} whether right {right:.1%} of {len(told)}, Brier {brier:.3f}; {'; '.join(filter(None, curve))}")


if __name__ == "__main__":
    what, *rest = sys.argv[1:] or ["worlds"]
    if what == "worlds":
        worlds(*(int(number) for number in rest or ["200"]))
    else:
        summary([line for path in rest for line in Path(path).read_text().splitlines()])
