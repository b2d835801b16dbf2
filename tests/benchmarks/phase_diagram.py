"""A phase diagram at full size: its pace, how well workers share it, its memory, and what `kill -9` does to it.

Run `python -m tests.benchmarks.phase_diagram --side 100 --kills 3` from the repository's root, with nothing else
running; Linux, whose /proc tells memory and processor time. The diagram is that of the documentation: the place of the
ring all over MIT's square on plywood. First few of its points are run by one worker and by two in turns; then the whole
diagram, once left alone and once killed at random moments and gone on with. Both are to be the same to the byte, and
no worker outlives its parent. Its time is told in maps, too: one to 1e-5 rad, computed alone on one core.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# One worker is to be one core, as each of several is.
os.environ.setdefault("CYCLEMAP_THREADS", "1")

import argparse
import random
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import nullcontext, suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from cyclemap.collection import CollectionLoop
from cyclemap.sweeps.run_sweep import run_sweep
from cyclemap.sweeps.sweep_plan import SweepPlan
from cyclemap.sweeps.sweep_results import load_sweep, write_csv, write_netcdf
from tests.benchmarks.timing import map_alone, seconds

REACH_MM = 40.0
TICKS = os.sysconf("SC_CLK_TCK")
# Lines that a run prints about its pace and memory.
TOLD = 10


def ring_plan(side: int) -> SweepPlan:
    """The ring at side x side places all over the object."""
    places = np.linspace(-REACH_MM, REACH_MM, side).tolist()
    return SweepPlan.grid("plywood", {"hitch_x_mm": places, "hitch_y_mm": places})


@dataclass(frozen=True)
class Moment:
    """A run at a moment: when (s), points stored, processor time so far (s), and memory of parent and workers (MB)."""

    time: float
    stored: int
    processor: float
    parent: float
    workers: float


@dataclass
class Run:
    """A sweep in a process of its own: its moments, one a chunk, and the sum of what several goes took."""

    store: Path
    side: int
    workers: int
    moments: list[Moment] = field(default_factory=list)
    wall: float = 0.0
    processor: float = 0.0

    def go(self, kill_at: int | None = None, delay: float = 0.0) -> None:
        """Run to the end, or kill it so long (s) after so many points are stored; workers end with it."""
        begun, first = time.monotonic(), len(self.moments)
        asked = [str(self.store), str(self.side), str(self.workers)]
        command = [sys.executable, "-m", "tests.benchmarks.phase_diagram", "--child", *asked]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        for line in process.stdout:
            workers = _children(process.pid)
            used = [use for pid in (process.pid, *workers) if (use := _use(pid)) is not None]
            if used:
                processors, memory = zip(*used, strict=True)
                largest = max(memory[1:], default=0.0)
                self.moments.append(Moment(time.monotonic(), int(line), sum(processors), memory[0], largest))
            if kill_at is not None and int(line) >= kill_at:
                time.sleep(delay)
                process.send_signal(signal.SIGKILL)
                process.wait()
                while any(Path(f"/proc/{pid}").exists() for pid in workers):
                    time.sleep(0.02)
                break
        if process.wait() != (0 if kill_at is None else -signal.SIGKILL):
            sys.exit(f"the sweep into {self.store} ended with {process.returncode}")
        self.wall += time.monotonic() - begun
        self.processor += max((moment.processor for moment in self.moments[first:]), default=0.0)

    @property
    def pace(self) -> float:
        """Points a second once the workers are at work."""
        at_work = [moment for moment in self.moments if moment.stored]
        return (at_work[-1].stored - at_work[0].stored) / (at_work[-1].time - at_work[0].time)

    def told(self) -> Iterator[str]:
        """A few lines on how it went."""
        marks = np.linspace(0, len(self.moments) - 1, min(TOLD, len(self.moments))).astype(int).tolist()
        for before, moment in zip([None, *marks], (self.moments[k] for k in marks), strict=False):
            since = self.moments[before or 0]
            pace = (moment.stored - since.stored) / max(moment.time - since.time, 1e-9)
            memory = f"parent {moment.parent:5.0f} MB, largest worker {moment.workers:5.0f} MB"
            yield f"  {moment.stored:6d} points stored, {pace:6.1f} points a second since the line before; {memory}"
        parents, workers = ([getattr(m, name) for m in self.moments] for name in ("parent", "workers"))
        yield f"  peaks: parent {max(parents):.0f} MB, worker {max(workers):.0f} MB"


def _children(pid: int) -> list[int]:
    with suppress(OSError):
        return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    return []


def _use(pid: int) -> tuple[float, float] | None:
    """Processor time (s) and resident memory (MB) of a process; None where it has ended."""
    with suppress(OSError, IndexError):
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / TICKS, int(fields[21]) * os.sysconf("SC_PAGE_SIZE") / 2**20
    return None


def compare_workers(folder: Path, side: int, rounds: int, workers: int) -> None:
    """One worker and several in turns, so that a disturbance hits both."""
    paces: dict[int, list[float]] = {1: [], workers: []}
    costs: dict[int, list[float]] = {1: [], workers: []}
    for number in range(rounds):
        for many in (1, workers):
            run = Run(folder / f"subset {number} {many}.sqlite", side, many)
            run.go()
            paces[many].append(run.pace)
            costs[many].append(run.processor / side**2)
    ratios = [several / (workers * one) for one, several in zip(paces[1], paces[workers], strict=True)]
    for many in (1, workers):
        pace, cost = statistics.median(paces[many]), statistics.median(costs[many])
        print(f"{many} at work on {side**2} points: {pace:.1f} points a second, {1e3 * cost:.0f} ms of processor each")
    each = ", ".join(f"{ratio:.2f}" for ratio in ratios)
    print(f"{workers} over 1: {workers * statistics.median(ratios):.2f} times as fast (efficiency {each})")


def whole(folder: Path, name: str, side: int, workers: int, kills: int, seed: int) -> Run:
    """The whole diagram, killed so many times on the way."""
    moments = random.Random(seed)
    run = Run(folder / f"{name}.sqlite", side, workers)
    for kill_at in sorted(moments.uniform(0.02, 0.98) * side**2 for _ in range(kills)):
        run.go(int(kill_at), moments.uniform(0.0, 1.0))
        print(f"killed with {run.moments[-1].stored} points stored")
    run.go()
    points = side**2
    print(f"{name}: {points} points in {run.wall:.0f} s ({points / run.wall:.1f} a second), {run.processor:.0f} s of")
    print(f"  processor ({1e3 * run.processor / points:.0f} ms a point); load of the machine {os.getloadavg()[0]:.1f}")
    print(*run.told(), sep="\n")
    return run


def same_bytes(one: Path, other: Path) -> bool:
    """Whether two stores give the same tables, to the byte, and hold all points."""
    for store in (one, other):
        sweep = load_sweep(store)
        assert len(sweep) == sweep.description["count"]
        write_csv(sweep, store.with_suffix(".csv"))
        write_netcdf(sweep, store.with_suffix(".nc"))
    return all(one.with_suffix(kind).read_bytes() == other.with_suffix(kind).read_bytes() for kind in (".csv", ".nc"))


def main() -> None:
    """Print what was measured; fail where the killed diagram differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--side", type=int, default=100)
    parser.add_argument("--kills", type=int, default=3)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--subset", type=int, default=14, help="side of what one worker and several run in turns")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1, help="of the moments of the kills")
    parser.add_argument("--out", type=Path, help="an empty folder to keep the stores and tables in")
    asked = parser.parse_args()
    if asked.out is not None:
        asked.out.mkdir(parents=True, exist_ok=True)
        if any(asked.out.iterdir()):
            sys.exit(f"{asked.out} is not empty: runs would go on with what is there")
    with nullcontext(asked.out) if asked.out is not None else tempfile.TemporaryDirectory() as folder:
        measure(Path(folder), asked)


def measure(folder: Path, asked: argparse.Namespace) -> None:
    """Everything that is asked for, into a folder."""
    if asked.rounds:
        compare_workers(folder, asked.subset, asked.rounds, asked.workers)
    alone = whole(folder, "undisturbed", asked.side, asked.workers, 0, asked.seed)
    run = map_alone(CollectionLoop.mit("plywood"), 1e-5)
    single, work = seconds(run, 9), seconds(run, 9, time.process_time)
    print(f"one map alone: {1e3 * single:.0f} ms; the diagram took as long as {alone.wall / single:,.0f} of them")
    print(f"one map's work: {1e3 * work:.0f} ms of processor, the diagram {alone.processor / work:,.0f} times that")
    if asked.kills:
        killed = whole(folder, "killed", asked.side, asked.workers, asked.kills, asked.seed)
        if not same_bytes(alone.store, killed.store):
            sys.exit("the killed diagram differs from the undisturbed one")
        print(f"killed {asked.kills} times: complete, CSV and NetCDF the same to the byte")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        store, side, workers = sys.argv[2:]
        # The sweep itself, a line a chunk.
        plan, many = ring_plan(int(side)), int(workers)
        run_sweep(plan, store, workers=many, progress=lambda status: print(status.stored, flush=True))
    else:
        main()
