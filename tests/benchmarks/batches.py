"""How fast many cycles at once are: many materials in one call, one by one, on one thread and on all.

Run `python -m tests.benchmarks.batches` from the repository's root, with nothing else running. Ways are run in turn, so
that a machine that slows down slows all of them; it prints medians and asserts nothing: times are for people.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cyclemap.collection import CollectionLoop
from cyclemap.collection.loop import run_cycles
from cyclemap.mechanics import EllipseFriction, Material
from cyclemap.mechanics.engine.strokes import THREADS_VARIABLE, thread_count
from tests.benchmarks.timing import Row, in_turns, show

MIT = CollectionLoop.mit()
MATERIALS, ORIENTATIONS = 2_000, 8
THETA = np.linspace(-math.pi, math.pi, ORIENTATIONS, endpoint=False)


def random_loops(count: int, seed: int = 1) -> list[CollectionLoop]:
    """MIT's loop on surfaces drawn at random; made anew, so that nothing of them is prepared."""
    rng = np.random.default_rng(seed)
    laws = [EllipseFriction(*rng.uniform(0.15, 0.4, 2), *rng.uniform(-0.05, 0.05, 2), rng.uniform(0.0, math.pi))
            for _ in range(count)]  # fmt: skip
    return [replace(MIT, material=Material("drawn", law)) for law in laws]


def on(threads: int, run: Callable[[], object]) -> Callable[[], object]:
    """The same on so many threads."""

    def limited() -> object:
        os.environ[THREADS_VARIABLE] = str(threads)
        try:
            return run()
        finally:
            del os.environ[THREADS_VARIABLE]

    return limited


def batch_rows(materials: int = MATERIALS, repeats: int = 3) -> list[Row]:
    """Many materials from a few orientations each, per cycle; preparing the loops is part of every way."""
    cores = thread_count()
    ways = {
        "one call, 1 thread": on(1, lambda: run_cycles(random_loops(materials), THETA)),
        f"one call, {cores} threads": on(cores, lambda: run_cycles(random_loops(materials), THETA)),
        "a call a loop, 1 thread": on(1, lambda: [loop.cycles(THETA) for loop in random_loops(materials)]),
        f"a call a loop, {cores} threads": on(cores, lambda: [loop.cycles(THETA) for loop in random_loops(materials)]),
        "a call a cycle": lambda: [loop.cycle(t) for loop in random_loops(materials) for t in THETA.tolist()],
    }
    cycles, found = materials * THETA.size, in_turns(list(ways.values()), repeats)
    told = zip(ways, found, strict=True)
    return [Row(name, taken / cycles, f"{cycles / taken:,.0f} cycles a second") for name, taken in told]


def thread_rows(cycles: int = 8_000, repeats: int = 9) -> list[Row]:
    """One material from many orientations on more and more threads: what each thread adds."""
    theta = np.linspace(-math.pi, math.pi, cycles)
    counts = sorted({1, thread_count()})
    found = in_turns([on(n, lambda: MIT.cycles(theta)) for n in counts], repeats)
    return [
        Row(f"{n} thread(s)", taken, f"{found[0] / taken:.2f} times as fast as 1, {cycles:,} cycles")
        for n, taken in zip(counts, found, strict=True)
    ]


def main() -> None:
    """Print the tables."""
    show(f"{MATERIALS:,} materials x {ORIENTATIONS} orientations, each cycle", batch_rows())
    show("threads", thread_rows())


if __name__ == "__main__":
    main()
