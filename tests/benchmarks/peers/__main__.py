"""Time one push beside its peers: `python -m tests.benchmarks.peers` from the repository's root.

Everything runs on one core, in turns, so that whatever else the machine does slows all alike. How far each ends from
the quasi-static answer, and from its own limit of ever finer steps, is measured in the same run: a time counts only
where both are within 0.2 mm and 0.1 degrees, and the table says so. It asserts nothing: times are for people.
"""

import os

# Before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import platform
import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from tests.benchmarks.engine import processor
from tests.benchmarks.peers.entrants import DRAGGED, EVEN, ONE_CALL, Entrant, entrants, even_entrants
from tests.benchmarks.peers.push_problem import four_corners, plain_grid
from tests.benchmarks.peers.simulators import simulators
from tests.benchmarks.timing import Row, show


def in_turns(runs: list[Callable[[], Any]], rounds: int) -> list[float]:
    """Median time of each run, s: all run one after another in every round, and once before, which does not count."""
    times = np.empty((rounds + 1, len(runs)))
    for row in times:
        for i, run in enumerate(runs):
            start = time.perf_counter()
            run()
            row[i] = time.perf_counter() - start
    return [statistics.median(column) for column in times[1:].T.tolist()]


def rows(those: list[Entrant], rounds: int) -> list[Row]:
    """One line for each that takes part, in seconds a push."""
    times = in_turns([one.run for one in those], rounds)
    return [
        Row(one.name, taken / one.pushes, f"{one.pushes / taken:,.3g} a second; {one.note}")
        for one, taken in zip(those, times, strict=True)
    ]


def in_the_time_of_one(found: list[Row]) -> str:
    """How many pushes this package does, many in one call, in the time of one of each other simulator."""
    told = []
    for own in (row for row in found if row.name in (ONE_CALL, EVEN)):
        others = [row for row in found if row.name not in (ONE_CALL, EVEN, DRAGGED)]
        shares = ", ".join(f"{row.name} {row.seconds / own.seconds:,.3g}" for row in others)
        told.append(f"pushes ({own.name}) in the time of one push: {shares}\n")
    return "".join(told)


def stay_on_one_core() -> None:
    """Keep this process to one core where the system can, and this package to one thread everywhere."""
    os.environ["CYCLEMAP_THREADS"] = "1"
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def load() -> str:
    """What else the machine does."""
    return f"load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "load unknown"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.peers")
    parser.add_argument("--rounds", type=int, default=9)
    rounds = parser.parse_args().rounds
    stay_on_one_core()
    python = f"Python {platform.python_version()}"
    print(f"{processor()}, one of {os.cpu_count()} cores, {platform.system()}, {python}, {load()}")
    for reason in simulators().values():
        if isinstance(reason, str):
            print(reason)
    even = even_entrants()
    for problem in (four_corners(), plain_grid()):
        found = rows([*entrants(problem), *even], rounds)
        show(f"one push, {problem.name}; last, under even pressure on plywood", found)
        print(in_the_time_of_one(found))
    print(load())


if __name__ == "__main__":
    main()
