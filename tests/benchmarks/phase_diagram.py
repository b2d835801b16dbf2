"""A phase diagram at full size: its pace, how well workers share it, its memory, and what `kill -9`
does to it.

Run `python -m tests.benchmarks.phase_diagram --side 100 --kills 3` from the repository's root, with
nothing else running. The diagram is that of the documentation: the place of the ring all over MIT's
square on plywood. First few of its points are run by one worker and by two in turns; then the whole
diagram, once left alone and once killed at random moments and gone on with. Both are to be the same
to the byte. Its time is told in maps, too: one to 1e-5 rad, computed alone on one core.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# One worker is to be one core, as each of several is.
os.environ.setdefault("CYCLEMAP_THREADS", "1")

import argparse
import json
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from cyclemap.collection import CollectionLoop
from cyclemap.sweeps.run_sweep import run_sweep
from cyclemap.sweeps.sweep_plan import SweepPlan
from cyclemap.sweeps.sweep_results import load_sweep, write_csv, write_netcdf
from tests.benchmarks.timing import map_alone, seconds

REACH_MM = 40.0


def child(store: str, side: str, workers: str) -> None:
    """The sweep itself: the points stored, a line a chunk; last, seconds of processor and the
    largest memories (MB).
    """
    places = np.linspace(-REACH_MM, REACH_MM, int(side)).tolist()
    plan = SweepPlan.grid("plywood", {"hitch_x_mm": places, "hitch_y_mm": places})
    run_sweep(
        plan, store, workers=int(workers), progress=lambda status: print(status.stored, flush=True)
    )
    both = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    processor = sum(one.ru_utime + one.ru_stime for one in both)
    print(json.dumps([processor, *(one.ru_maxrss / 1024 for one in both)]))


def go(
    store: Path, side: int, workers: int, kill_at: float = np.inf, delay: float = 0.0
) -> tuple[float, list[float]]:
    """Run a sweep in a process of its own to its end, or kill it so long (s) after so many points
    are stored.

    Returns its pace, points a second once the workers are at work, and what it tells at its end.
    """
    command = [sys.executable, "-m", "tests.benchmarks.phase_diagram", "--child"]
    command += [str(store), str(side), str(workers)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    moments, told = [], []
    for line in process.stdout:
        if line.startswith("["):
            told = json.loads(line)
        elif int(line):
            moments.append((time.monotonic(), int(line)))
            if int(line) >= kill_at:
                time.sleep(delay)
                process.send_signal(signal.SIGKILL)
                break
    if process.wait() != (-signal.SIGKILL if kill_at < np.inf else 0):
        sys.exit(f"the sweep into {store} ended with {process.returncode}")
    (begun, first), (ended, last) = moments[0], moments[-1]
    return (last - first) / max(ended - begun, 1e-9), told


def compare_workers(folder: Path, side: int, rounds: int, workers: int) -> None:
    """One worker and several in turns, so that a disturbance hits both."""
    paces: dict[int, list[float]] = {1: [], workers: []}
    for number in range(rounds):
        for many in (1, workers):
            pace, (processor, *_) = go(folder / f"subset {number} {many}.sqlite", side, many)
            paces[many].append(pace)
            each = 1e3 * processor / side**2
            print(
                f"{many} at work on {side**2} points: {pace:.1f} points a second, {each:.0f} ms "
                "of processor each"
            )
    ratios = np.divide(paces[workers], paces[1])
    told = ", ".join(f"{ratio / workers:.2f}" for ratio in ratios)
    print(f"{workers} over 1: {np.median(ratios):.2f} times as fast (efficiency {told})")


def whole(store: Path, side: int, workers: int, kills: int, seed: int) -> tuple[float, float]:
    """The whole diagram, killed so many times on the way; its seconds, and those of the processor
    in its last go.
    """
    moments, points, begun = random.Random(seed), side**2, time.monotonic()
    for kill_at in sorted(moments.uniform(0.02, 0.98) * points for _ in range(kills)):
        go(store, side, workers, kill_at, moments.uniform(0.0, 1.0))
        print(f"killed after {int(kill_at)} points were stored")
    pace, (processor, parent, worker) = go(store, side, workers)
    wall = time.monotonic() - begun
    print(
        f"{store.stem}: {points} points in {wall:.0f} s, at last {pace:.1f} a second; "
        f"{processor:.0f} s of processor"
    )
    print(
        f"  peaks: parent {parent:.0f} MB, worker {worker:.0f} MB; load of the machine "
        f"{os.getloadavg()[0]:.1f}"
    )
    return wall, processor


def same_bytes(one: Path, other: Path) -> bool:
    """Whether two stores give the same tables, to the byte, and hold all points."""
    for store in (one, other):
        sweep = load_sweep(store)
        assert len(sweep) == sweep.description["count"]
        write_csv(sweep, store.with_suffix(".csv"))
        write_netcdf(sweep, store.with_suffix(".nc"))
    return all(
        one.with_suffix(kind).read_bytes() == other.with_suffix(kind).read_bytes()
        for kind in (".csv", ".nc")
    )


def main() -> None:
    """Print what was measured; fail where the killed diagram differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--side", type=int, default=100)
    parser.add_argument("--kills", type=int, default=3)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument(
        "--subset", type=int, default=14, help="side of what one worker and several run in turns"
    )
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1, help="of the moments of the kills")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        alone, killed = Path(place) / "undisturbed.sqlite", Path(place) / "killed.sqlite"
        if asked.rounds:
            compare_workers(Path(place), asked.subset, asked.rounds, asked.workers)
        wall, processor = whole(alone, asked.side, asked.workers, 0, asked.seed)
        run = map_alone(CollectionLoop.mit("plywood"), 1e-5)
        single, work = seconds(run, 9), seconds(run, 9, time.process_time)
        print(
            f"one map alone: {1e3 * single:.0f} ms; the diagram took as long as "
            f"{wall / single:,.0f} of them"
        )
        print(
            f"one map's work: {1e3 * work:.0f} ms of processor, the diagram "
            f"{processor / work:,.0f} times that"
        )
        if asked.kills:
            whole(killed, asked.side, asked.workers, asked.kills, asked.seed)
            if not same_bytes(alone, killed):
                sys.exit("the killed diagram differs from the undisturbed one")
            print(f"killed {asked.kills} times: complete, CSV and NetCDF the same to the byte")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        child(*sys.argv[2:])
    else:
        main()
