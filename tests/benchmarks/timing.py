"""What the benchmarks share: the median times of repeated runs, and a table of ratios."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import count

import numpy as np
from rich.console import Console
from rich.table import Table

from cyclemap.collection import CollectionLoop


@dataclass(frozen=True)
class Row:
    """One line of the table: what was run, the seconds it took, and what is to be known of it."""

    name: str
    seconds: float
    note: str


def seconds(
    run: Callable[[], object], repeats: int = 5, clock: Callable[[], float] = time.perf_counter
) -> float:
    """Median time of a run, after one that is not counted."""
    return in_turns([run], repeats, clock)[0]


def timed(name: str, run: Callable[[], object], note: str, repeats: int = 5) -> Row:
    """The row of a run."""
    return Row(name, seconds(run, repeats), note)


def in_turns(
    runs: list[Callable[[], object]], rounds: int, clock: Callable[[], float] = time.perf_counter
) -> list[float]:
    """Median time of each run: all run one after another in every round, and once before, which
    does not count.

    So a machine that slows down slows all alike.
    """
    times = np.empty((rounds + 1, len(runs)))
    for row in times:
        for i, run in enumerate(runs):
            start = clock()
            run()
            row[i] = clock() - start
    found: list[float] = np.median(times[1:], axis=0).tolist()
    return found


def map_alone(loop: CollectionLoop, tolerance: float) -> Callable[[], object]:
    """A run of a cycle map that shares no push with maps before it: each push is a nanometre
    longer.
    """
    longer = count(1)

    def run() -> object:
        push = replace(loop.push, distance=loop.push.distance + 1e-9 * next(longer))
        return replace(loop, push=push).circle_map(tolerance)

    return run


def show(title: str, rows: list[Row]) -> None:
    """Print rows with their ratio to the first."""
    table = Table("what", "ms", "over the first", "of", title=title, title_justify="left")
    for row in rows:
        table.add_row(
            row.name, f"{1e3 * row.seconds:.3g}", f"{row.seconds / rows[0].seconds:.3g}", row.note
        )
    Console(width=120).print(table)
