"""How long a cycle takes, beside a plain SciPy solver of the same push: one table, with ratios.

Run `python -m tests.benchmarks` from the repository's root. It prints the median of repeated runs and asserts nothing:
times are for people. The peer is tests/mechanics/test_second_route.py's brute-force solver, on the paper's 8 x 8 grid,
for the push alone; the package's row beside it is the same push on the same points.
"""

import math
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from cyclemap.collection.loop import CollectionLoop
from cyclemap.mechanics import Pose, QuasiStaticModel, SidePush, grid_footprint

sys.path.insert(0, str(Path(__file__).parents[1] / "mechanics"))
from test_second_route import brute_force_push

MIT = CollectionLoop.mit()
LAW, OUTLINE = MIT.material.friction, MIT.slider.outline
THETA_0 = math.radians(150.0)
COUNTS = (25, 50, 100, 200)

Row = tuple[str, float, str]


def seconds(run: Callable[[], object], repeats: int = 5) -> float:
    """Median time of a run, after one that is not counted."""
    run()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def cycle_rows() -> list[Row]:
    """One cycle at two accuracies, and with its derivatives: averages over the circle."""
    theta = np.linspace(-math.pi, math.pi, 40, endpoint=False).tolist()
    rows = []
    for accuracy in (1e-6, 1e-8):
        loop = replace(MIT, accuracy=accuracy)
        rows.append(
            (f"cycle at {accuracy:g}", seconds(lambda loop=loop: [loop.cycle(t) for t in theta]) / 40, "push and drag")
        )
        found = seconds(lambda loop=loop: [loop.sensitivity(t) for t in theta], 3) / 40
        rows.append((f"with 13 derivatives at {accuracy:g}", found, "push and drag"))
    return rows


def peer_rows() -> list[Row]:
    """The push of one cycle on 8 x 8 points: the package, and SciPy with brute force."""
    footprint = grid_footprint(OUTLINE, 8)
    model = QuasiStaticModel(MIT.slider, LAW, MIT.pusher, footprint, 1e-6)
    pose, push, points = Pose(theta=THETA_0), SidePush(), np.array(footprint.positions)
    ours = seconds(lambda: model.push(pose, push))
    peer = seconds(lambda: brute_force_push(LAW, THETA_0, 0.15, 0.15, points, 0.7), 1)
    return [("push on 8 x 8 points at 1e-6", ours, "push"), ("SciPy solve_ivp on 8 x 8 points", peer, "push")]


def growth_rows() -> list[Row]:
    """Time of n cycles, over n: level where the cost grows linearly."""
    loop, rows = replace(MIT, accuracy=1e-6), []
    for count in COUNTS:
        theta = np.linspace(-3.0, 3.0, count)
        rows.append(
            (f"{count} cycles, each", seconds(lambda theta=theta: loop.next_theta(theta), 3) / count, "push and drag")
        )
    return rows


def cold_rows() -> list[Row]:
    """The whole command, from a cold start."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "cyclemap", "portrait", "plywood", "--out", folder]
        start = time.perf_counter()
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        taken = time.perf_counter() - start
    told = "cold start, with its picture" if done.returncode == 0 else f"failed: {done.stderr.strip()[-60:]}"
    return [("cyclemap portrait plywood", taken, told)]


def main() -> None:
    """Print the table."""
    rows = [*cycle_rows(), *peer_rows(), *growth_rows(), *cold_rows()]
    table = Table("what", "ms", "over the first", "of", title="cyclemap benchmarks")
    for name, taken, note in rows:
        table.add_row(name, f"{1e3 * taken:.2f}", f"{taken / rows[0][1]:.2f}", note)
    Console(width=110).print(table)


if __name__ == "__main__":
    main()
