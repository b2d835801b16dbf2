"""Time one push beside its peers: `python -m tests.benchmarks.peers` from the repository's root.

Everything runs on one core, in turns, so that whatever else the machine does slows all alike. How
far each ends from the quasi-static answer, and from its own limit of ever finer steps, is measured
in the same run: a time counts only where both are within 0.2 mm and 0.1 degrees, and the table says
so. It asserts nothing: times are for people.
"""

import os

# Before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import platform

from tests.benchmarks.engine import processor
from tests.benchmarks.peers.entrants import (
    DRAGGED,
    EVEN,
    ONE_CALL,
    Entrant,
    entrants,
    even_entrants,
    simulators,
)
from tests.benchmarks.peers.push_problem import four_corners, plain_grid
from tests.benchmarks.timing import Row, in_turns, show


def rows(those: list[Entrant], rounds: int) -> list[Row]:
    """One line for each that takes part, in seconds a push."""
    times = in_turns([one.run for one in those], rounds)
    return [
        Row(one.name, taken / one.pushes, f"{one.pushes / taken:,.3g} a second; {one.note}")
        for one, taken in zip(those, times, strict=True)
    ]


def in_the_time_of_one(found: list[Row]) -> str:
    """How many pushes this package does, many in one call, in the time of one of each other
    simulator.
    """
    told = []
    for own in (row for row in found if row.name in (ONE_CALL, EVEN)):
        others = [row for row in found if row.name not in (ONE_CALL, EVEN, DRAGGED)]
        shares = ", ".join(f"{row.name} {row.seconds / own.seconds:,.3g}" for row in others)
        told.append(f"pushes ({own.name}) in the time of one push: {shares}\n")
    return "".join(told)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.peers")
    parser.add_argument("--rounds", type=int, default=9)
    rounds = parser.parse_args().rounds
    # One core where the system can, and one thread of this package everywhere.
    os.environ["CYCLEMAP_THREADS"] = "1"
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    system = f"{platform.system()}, Python {platform.python_version()}"
    print(f"{processor()}, one of {os.cpu_count()} cores, {system}, load {os.getloadavg()[0]:.1f}")
    for reason in simulators():
        if isinstance(reason, str):
            print(reason)
    even = even_entrants()
    for problem in (four_corners(), plain_grid()):
        found = rows([*entrants(problem), *even], rounds)
        show(f"one push, {problem.name}; last, under even pressure on plywood", found)
        print(in_the_time_of_one(found))
    print(f"load {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
