"""What the benchmarks share: the median time of repeated runs, and a table of ratios."""

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import count

from rich.console import Console
from rich.table import Table

from cyclemap.collection import CollectionLoop


@dataclass(frozen=True)
class Row:
    """One line of the table: what was run, the seconds it took, and what is to be known of it."""

    name: str
    seconds: float
    note: str


def seconds(run: Callable[[], object], repeats: int = 5, clock: Callable[[], float] = time.perf_counter) -> float:
    """Median time of a run, after one that is not counted."""
    run()
    times = []
    for _ in range(repeats):
        start = clock()
        run()
        times.append(clock() - start)
    return statistics.median(times)


def map_alone(loop: CollectionLoop, tolerance: float) -> Callable[[], object]:
    """A run of a cycle map that shares no push with maps before it: each push is a nanometre longer."""
    longer = count(1)

    def run() -> object:
        push = replace(loop.push, distance=loop.push.distance + 1e-9 * next(longer))
        return replace(loop, push=push).circle_map(tolerance)

    return run


def show(title: str, rows: list[Row]) -> None:
    """Print rows with their ratio to the first."""
    table = Table("what", "ms", "over the first", "of", title=title, title_justify="left")
    for row in rows:
        table.add_row(row.name, f"{1e3 * row.seconds:.3g}", f"{row.seconds / rows[0].seconds:.3g}", row.note)
    Console(width=120).print(table)
