"""How fast the engine is: cycles, maps and portraits, interpreted and compiled side by side, with ratios.

Run `python -m tests.benchmarks.engine` from the repository's root, with nothing else running. It prints medians of
repeated runs and asserts nothing: times are for people. Every row is one core's, but for those that say otherwise.
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
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np

from cyclemap.collection import CollectionLoop
from cyclemap.mechanics import Pose
from cyclemap.mechanics.compiled import stroke_runner
from cyclemap.mechanics.compiled.compiler import NoCompiler, find_compiler
from cyclemap.mechanics.compiled.library_cache import CACHE_VARIABLE
from cyclemap.mechanics.compiled.recorded_strokes import stroke_row
from cyclemap.mechanics.compiled.stroke_library import stroke_source
from cyclemap.mechanics.compiled.threads import THREADS_VARIABLE, thread_count
from cyclemap.mechanics.motion import Rod
from tests.benchmarks.timing import Row, seconds, show

MIT = CollectionLoop.mit()
ACCURACIES = (1e-4, 1e-6, 1e-8, 1e-10)
THETA = np.linspace(-math.pi, math.pi, 40, endpoint=False)
# Accuracies among which the coarsest with a worst error of 10 µm is looked for.
COARSE = 10.0 ** np.arange(-2.0, -6.01, -0.25)


def processor() -> str:
    """The processor's name, as far as the system tells."""
    told = Path("/proc/cpuinfo")
    lines = told.read_text().splitlines() if told.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def each(run: Callable[[], object], repeats: int = 5) -> float:
    """Median time of one of the runs over THETA."""
    return seconds(run, repeats) / THETA.size


def cycle_rows() -> list[Row]:
    """One cycle, and with the slope of the map, at every accuracy."""
    rows = []
    for accuracy in ACCURACIES:
        loop = replace(MIT, accuracy=accuracy)
        for name, way in (("interpreted", stroke_runner.interpreted), ("compiled", nullcontext)):
            with way():
                rows.append(row(f"{name} cycle at {accuracy:g}", each(lambda loop=loop: list(map(loop.cycle, THETA)))))
                batch = each(lambda loop=loop: loop.cycles(THETA))
                rows.append(row(f"{name}, in one call", batch))
                slopes = each(lambda loop=loop: loop._values_and_slopes(THETA), 3)
                rows.append(row(f"{name}, in one call, with slopes", slopes))
    return rows


def row(name: str, taken: float) -> Row:
    """A row that tells how many a second."""
    return Row(name, taken, f"{1.0 / taken:,.0f} a second")


def push_seconds(loop: CollectionLoop, theta: np.ndarray) -> float:
    """Time of one push alone, in compiled code."""
    model = loop.model
    start, direction, _, length = model.start(Pose(), loop.push)
    rod = Rod(model.radius, model.pusher.friction, direction)
    strokes = np.tile(stroke_row(model.solver, rod, start, length), (theta.size, 1))
    strokes[:, 2], strokes[:, 7] = theta, theta + direction
    runner, pieces = stroke_runner.stroke_runner(model.stroke_kind), stroke_runner.piece_table(model.pieces)
    assert runner is not None
    return seconds(lambda: runner.run(pieces, strokes, model.step_tolerance, math.inf, False)) / theta.size


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
            return [row(note, push_seconds(loop, theta))]
    return []


def map_rows() -> list[Row]:
    """A whole cycle map, on all cores where it is compiled."""
    rows = []
    for tolerance in (1e-6, 1e-8):
        with stroke_runner.interpreted():
            rows.append(
                Row(f"interpreted map at {tolerance:g}", seconds(lambda t=tolerance: MIT.circle_map(t), 1), "plywood")
            )
        taken = seconds(lambda t=tolerance: MIT.circle_map(t), 5)
        rows.append(Row(f"compiled map at {tolerance:g}", taken, "plywood, all cores"))
    return rows


def portrait_rows() -> list[Row]:
    """The command from outside: with the interpreter, compiling, and with kernels that are kept; and the import."""
    with tempfile.TemporaryDirectory() as kept:
        return [
            Row("interpreted", command_seconds({"CYCLEMAP_COMPILER": "none"}), "cyclemap portrait plywood"),
            Row("compiled, cold", command_seconds({CACHE_VARIABLE: kept}), "kernels compiled and kept on the way"),
            Row("compiled, kept", command_seconds({CACHE_VARIABLE: kept}), "kernels found"),
            Row("import of what it needs", import_seconds(), "within each of the above"),
        ]


def command_seconds(environment: dict[str, str]) -> float:
    """Time of one portrait in a process of its own; a failure is told, not timed."""
    with tempfile.TemporaryDirectory() as out:
        return _run([sys.executable, "-m", "cyclemap", "portrait", "plywood", "--out", out], environment)


def import_seconds() -> float:
    """Time of a process that only imports what the portrait needs."""
    return _run([sys.executable, "-c", "import cyclemap.cli.run_portrait"], {})


def _run(command: list[str], environment: dict[str, str]) -> float:
    start = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True, env={**os.environ, **environment})
    return time.perf_counter() - start


def compile_rows() -> list[Row]:
    """What it takes to have kernels at all."""
    kind = MIT.model.stroke_kind
    assert kind is not None
    source = stroke_source(kind)
    return [
        Row(
            "compiling MIT's kernels",
            seconds(lambda: find_compiler().shared_library(source), 1),
            f"{len(source):,} bytes of C",
        ),
        Row("writing their C", seconds(lambda: stroke_source(kind), 3), "expressions known"),
    ]


def main() -> None:
    """Print the tables."""
    try:
        compiler = find_compiler().command[0]
    except NoCompiler as reason:
        sys.exit(f"nothing to compare: {reason}")
    stroke_runner.WORTHWHILE = 0
    MIT.next_theta(THETA)
    print(f"{processor()}, {thread_count()} cores, {platform.system()}, Python {platform.python_version()}, {compiler}")
    os.environ[THREADS_VARIABLE] = "1"
    show("cycles", cycle_rows())
    show("pushes to 10 µm", push_rows())
    del os.environ[THREADS_VARIABLE]
    show("maps", map_rows())
    show("portraits", portrait_rows())
    show("kernels", compile_rows())


if __name__ == "__main__":
    main()
