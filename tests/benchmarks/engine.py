"""How fast the engine is: cycles, pushes, derivatives of every footprint, batches, maps,
identification and portraits.

Run `python -m tests.benchmarks.engine` from the repository's root, with nothing else running. It
prints medians of repeated runs and asserts nothing: times are for people. Every row is one core's,
but for those that say otherwise.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import math
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from cyclemap.collection import CollectionLoop, fingerprint, run_cycles
from cyclemap.evidence.identification.stroke_block import push_end_block, surface_model
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters
from cyclemap.evidence.pushes.measured_strokes import MeasuredPush
from cyclemap.mechanics import (
    Ellipse,
    EllipseFriction,
    Footprint,
    Material,
    PatchFootprint,
    Pose,
    Slider,
    WorldPush,
    grid_footprint,
)
from cyclemap.mechanics.cycle_batch import run_batch
from cyclemap.mechanics.engine import strokes as engine
from cyclemap.mechanics.engine.schema import PARAMETERS
from cyclemap.mechanics.engine.strokes import THREADS_VARIABLE, thread_count
from cyclemap.mechanics.foundation import FLAT
from tests.benchmarks.timing import Row, in_turns, map_alone, seconds, show, timed

MIT = CollectionLoop.mit()
ACCURACIES = (1e-4, 1e-6, 1e-8, 1e-10)
THETA = np.linspace(-math.pi, math.pi, 40, endpoint=False)
# Accuracies among which the coarsest with a worst error of 10 µm is looked for.
COARSE = 10.0 ** np.arange(-2.0, -6.01, -0.25)
SQUARE = MIT.slider.outline
# Under MIT's square, each in turn.
FOOTPRINTS: dict[str, Footprint] = {
    "square": PatchFootprint(SQUARE),
    "square in four parts": PatchFootprint(SQUARE, 0.2, 0.2, 0.1),
    "leaning square": PatchFootprint(SQUARE, centre=(0.003, -0.002)),
    "disc": PatchFootprint(Ellipse(0.05, 0.05)),
    "ellipse": PatchFootprint(Ellipse(0.055, 0.035)),
    "ellipse, half of it on the rim": PatchFootprint(Ellipse(0.055, 0.035), rim_share=0.5),
    "8 x 8 points": grid_footprint(SQUARE, 8),
}
# Of a batch; made anew for each way, so that nothing of the loops is prepared.
MATERIALS, BATCH = 2_000, np.linspace(-math.pi, math.pi, 8, endpoint=False)
# Of an identification: how many pushes, from how far off (m), and the step of differences.
PUSHES, LENGTH, DIFFERENCE = 40, 0.115, 1e-5
SURFACE = SurfaceParameters(
    ellipticity_x=0.1,
    offset_x=0.04,
    pusher_friction=0.2,
    floor_dome=1.0,
    floor_bow_x=-1.0,
    plate_warp_y=0.5,
)
# What a portrait is measured by: the libraries that it needs, and six labelled panels of its size.
PANELS = """
import sys, numpy, matplotlib
matplotlib.use("Agg")
from matplotlib import pyplot
figure, panels = pyplot.subplots(2, 3, figsize=(13.0, 8.0), layout="constrained")
for number, panel in enumerate(panels.flat):
    x = numpy.linspace(0.0, 6.0, 400)
    panel.plot(x, numpy.sin(x + number), label="a line")
    panel.set(title="a title", xlabel="an angle (degrees)", ylabel="a value")
    panel.legend()
figure.savefig(sys.argv[1] + "/panels.png", dpi=150)
"""


def processor() -> str:
    """The processor's name, as far as the system tells."""
    told = Path("/proc/cpuinfo")
    lines = told.read_text().splitlines() if told.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def row(name: str, run: Callable[[], object], count: int = THETA.size, repeats: int = 5) -> Row:
    """A row of one of so many runs, which tells how many a second."""
    taken = seconds(run, repeats) / count
    return Row(name, taken, f"{1.0 / taken:,.0f} a second")


def cycle_rows() -> list[Row]:
    """One cycle, one a call and many in one, with the slope of the map and with all derivatives, at
    every accuracy.
    """
    rows = []
    for accuracy in ACCURACIES:
        loop = replace(MIT, accuracy=accuracy)
        rows.append(row(f"cycles in one call at {accuracy:g}", partial(loop.cycles, THETA)))
        rows.append(row("  one a call", lambda loop=loop: list(map(loop.cycle, THETA.tolist()))))
        for name, count in (("slopes", 1), (f"{len(PARAMETERS)} derivatives", len(PARAMETERS))):
            rows.append(row(f"  with {name}", partial(run_batch, (loop,), THETA[None], count)))
    return rows


def footprint_rows() -> list[Row]:
    """Cycles at 1e-8 over every kind of pressure under the same object: what each costs beside a
    square.
    """
    rows = []
    for name, footprint in FOOTPRINTS.items():
        loop = replace(MIT, footprint=footprint)
        for what, count in (("", 0), (", slopes", 1), (", all derivatives", len(PARAMETERS))):
            rows.append(row(f"{name}{what}", partial(run_batch, (loop,), THETA[None], count)))
    return rows


def shape_rows(rounds: int = 7) -> list[Row]:
    """Pushes at 1e-8 on floors and of plates that are not flat, beside the plain square's, all in
    turns.
    """
    names, runs = [], []
    for plate in ("rect1", "tri1", "hex", "ellip2"):
        slider = Slider.mit(plate)
        flat = CollectionLoop.mit("isotropic", slider=slider)
        loops = {"flat": replace(flat, footprint=PatchFootprint(slider.outline))}
        for floor in ("plywood-floor", "abs-floor"):
            loops[f"on {floor}, place and all"] = loop = CollectionLoop.mit(floor, slider=slider)
            both = replace(loop.footprint, field=None)
            loops[f"shape of {floor} and plate"] = replace(flat, footprint=both)
            alone = replace(both, plate=FLAT)
            loops[f"shape of {floor}"] = replace(flat, footprint=alone)
        for name, loop in loops.items():
            names.append(f"{plate}, {name}")
            runs.append(pushes(loop, THETA))
    taken = in_turns(runs, rounds, time.process_time)
    rows = zip(names, taken, strict=True)
    return [Row(name, each / THETA.size, "a push at 1e-8") for name, each in rows]


def pushes(loop: CollectionLoop, theta: NDArray[np.float64]) -> Callable[[], object]:
    """Pushes alone, without the way back, from all orientations in one call."""
    strokes = replace(loop.model.push_strokes(Pose(), loop.push), with_object=True)
    poses = np.column_stack([np.zeros((theta.size, 2)), theta])
    return partial(engine.run, [strokes], np.zeros(theta.size, int), poses)


def push_rows() -> list[Row]:
    """Pushes at the coarsest accuracy at which no corner of the object ends more than 10 µm off."""
    theta = np.linspace(-math.pi, math.pi, 400)
    exact, half_diagonal = replace(MIT, accuracy=1e-11).cycles(theta), 0.045 * math.sqrt(2.0)
    for accuracy in COARSE.tolist():
        loop = replace(MIT, accuracy=accuracy)
        found = loop.cycles(theta)
        moved = np.hypot(*(found.push_displacement - exact.push_displacement).T)
        worst = float((moved + half_diagonal * np.abs(found.push_turn - exact.push_turn)).max())
        if worst <= 10e-6:
            note = f"push, corners off by {1e6 * worst:.2g} µm at most (accuracy {accuracy:.1e})"
            return [row(note, pushes(loop, theta), theta.size)]
    return []


def map_rows() -> list[Row]:
    """A whole cycle map, on all cores; and the five numbers of the protocol, for any material."""
    grid = replace(MIT, footprint=grid_footprint(SQUARE, 8))
    maps = [(f"map at {tolerance:g}", MIT, tolerance) for tolerance in (1e-3, 1e-5, 1e-6, 1e-8)]
    rows = [
        timed(name, map_alone(loop, tolerance), "plywood, all cores")
        for name, loop, tolerance in (*maps, ("8 x 8 points, map at 1e-5", grid, 1e-5))
    ]
    return [*rows, timed("fingerprint", lambda: fingerprint(MIT), "any material", 3)]


def portrait_rows(rounds: int = 5) -> list[Row]:
    """The command from outside, beside a process that draws as many panels, and the import of what
    it needs.
    """
    python = sys.executable
    portrait = [python, "-m", "cyclemap", "portrait", "plywood", "--out"]
    commands = {
        "six labelled panels by matplotlib alone": [python, "-c", PANELS],
        "cyclemap portrait plywood": portrait,
        "  --set footprint=grid:8": [*portrait[:-1], "--set", "footprint=grid:8", "--out"],
        "import of what a portrait needs": [python, "-c", "import cyclemap.cli.run_portrait"],
    }
    with tempfile.TemporaryDirectory() as out:
        lines = [[*command, out] for command in commands.values()]
        runs = [partial(subprocess.run, line, check=True, capture_output=True) for line in lines]
        taken = in_turns(runs, rounds)
    return [Row(*row, "a process of its own") for row in zip(commands, taken, strict=True)]


def on(threads: int, run: Callable[[], object]) -> Callable[[], object]:
    """The same on so many threads."""

    def limited() -> object:
        with patch.dict(os.environ, {THREADS_VARIABLE: str(threads)}):
            return run()

    return limited


def batch_rows(repeats: int = 3) -> list[Row]:
    """Many materials from a few orientations each, per cycle; preparing the loops is part of every
    way.
    """

    def loops() -> list[CollectionLoop]:
        low, high = (0.15, 0.15, -0.05, -0.05, 0.0), (0.4, 0.4, 0.05, 0.05, math.pi)
        laws = np.random.default_rng(1).uniform(low, high, (MATERIALS, 5))
        return [replace(MIT, material=Material("random", EllipseFriction(*law))) for law in laws]

    cores, cycles = thread_count(), MATERIALS * BATCH.size
    ways = {
        "one call, 1 thread": on(1, lambda: run_cycles(loops(), BATCH)),
        f"one call, {cores} threads": on(cores, lambda: run_cycles(loops(), BATCH)),
        "a call a loop, 1 thread": on(1, lambda: [loop.cycles(BATCH) for loop in loops()]),
        f"a call a loop, {cores} threads": on(
            cores, lambda: [loop.cycles(BATCH) for loop in loops()]
        ),
        "a call a cycle": lambda: [loop.cycle(t) for loop in loops() for t in BATCH.tolist()],
    }
    rows = []
    for name, taken in zip(ways, in_turns(list(ways.values()), repeats), strict=True):
        rows.append(Row(name, taken / cycles, f"{cycles / taken:,.0f} cycles a second"))
    return rows


def thread_rows(cycles: int = 8_000, repeats: int = 9) -> list[Row]:
    """One material from many orientations on one thread and on all: what threads add."""
    theta = np.linspace(-math.pi, math.pi, cycles)
    counts = sorted({1, thread_count()})
    found = in_turns([on(n, lambda: MIT.cycles(theta)) for n in counts], repeats)
    rows = []
    for n, taken in zip(counts, found, strict=True):
        note = f"{found[0] / taken:.2f} times as fast as 1, {cycles:,} cycles"
        rows.append(Row(f"{n} thread(s)", taken, note))
    return rows


def step_rows() -> list[Row]:
    """One step of an identification with all parameters free: derivatives by the engine, and by
    differences.

    Of pushes of MIT's square from random places in random directions, without noise.
    """
    rng, slider = np.random.default_rng(0), Slider.mit("rect1")
    model, made, pushes = surface_model(SURFACE, slider), [], []
    for number in range(PUSHES):
        theta, way = rng.uniform(-math.pi, math.pi, 2).tolist()
        start = Pose(theta=theta)
        near = start.to_world(*rng.uniform(-0.02, 0.02, 2).tolist())
        first = near[0] - LENGTH * math.cos(way), near[1] - LENGTH * math.sin(way)
        pushes.append((start, WorldPush(first, way, LENGTH)))
        made.append(MeasuredPush(start, model.push(*pushes[-1]).end, first, near, number))
    block, given = push_end_block(made, slider), SURFACE.values()
    values = {name: given.get(name, 0.0) for name in block.parameters}

    def by_differences() -> None:
        for name in block.parameters:
            for sign in (-1.0, 1.0):
                block.residuals({**values, name: values[name] + sign * DIFFERENCE})

    note = f"{PUSHES} pushes, {len(block.parameters)} parameters"
    return [
        timed("residuals and derivatives", lambda: block.residuals(values), note, 9),
        timed("the pushes alone, one a call", lambda: [model.push(*row) for row in pushes], note),
        timed("residuals, derivatives by differences", by_differences, note, 1),
    ]


def main() -> None:
    """Print the tables."""
    print(
        f"{processor()}, {thread_count()} cores, {platform.system()}, Python "
        f"{platform.python_version()}"
    )
    os.environ[THREADS_VARIABLE] = "1"
    show("cycles", cycle_rows())
    show("footprints, cycles at 1e-8", footprint_rows())
    show("shapes of floor and plate, pushes at 1e-8", shape_rows())
    show("pushes to 10 µm", push_rows())
    del os.environ[THREADS_VARIABLE]
    show("maps", map_rows())
    show(f"{MATERIALS:,} materials x {BATCH.size} orientations, each cycle", batch_rows())
    show("threads", thread_rows())
    show("one step of an identification", step_rows())
    show("portraits", portrait_rows())


if __name__ == "__main__":
    main()
