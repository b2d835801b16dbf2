"""A sweep killed by `kill -9` three times at random moments ends as one that was left alone."""

import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import pytest
from fake_numbers import fake_plan, logged

from cyclemap.sweeps import load_sweep, run_sweep, sweep_status, write_csv

ROWS, SECONDS = 60, 0.02
SCRIPT = """
import sys
from fake_numbers import fake_plan
from cyclemap.sweeps import run_sweep
if __name__ == "__main__":
    plan = fake_plan(rows=int(sys.argv[2]), seconds=float(sys.argv[3]), log=sys.argv[4])
    run_sweep(plan, sys.argv[1], workers=int(sys.argv[5]))
"""


def start(folder: Path, path: Path, log: Path, seconds: float = SECONDS, workers: int = 2) -> subprocess.Popen:
    script = folder / "sweep.py"
    script.write_text(SCRIPT)
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parent)}
    command = [sys.executable, str(script), str(path), str(ROWS), str(seconds), str(log), str(workers)]
    return subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL)


def wait_for(condition, process) -> None:
    deadline = time.monotonic() + 120.0
    while not condition():
        assert process.poll() is None and time.monotonic() < deadline, "the sweep ended before it was killed"
        time.sleep(0.01)


def children(process) -> list[Path]:
    """Its worker processes, and the one that watches over what they share."""
    found = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    return [Path(f"/proc/{child}") for child in found]


def wait_for_end(workers) -> None:
    """Workers watch their parent: none goes on alone, to hold memory or files."""
    deadline = time.monotonic() + 60.0
    while any(worker.exists() for worker in workers):
        assert time.monotonic() < deadline, "a worker outlived its sweep"
        time.sleep(0.02)


def rows_of(path) -> list:
    connection = sqlite3.connect(path)
    found = connection.execute("SELECT * FROM points ORDER BY number").fetchall()
    connection.close()
    return found


@pytest.mark.slow
def test_killed_three_times_it_is_complete_and_the_same_to_the_byte(tmp_path) -> None:
    path, moments = tmp_path / "killed.sqlite", random.Random(7)
    for attempt, workers in enumerate((2, 1, 1)):
        log = tmp_path / f"log {attempt}"
        before = sweep_status(path, fake_plan(rows=ROWS)).stored
        process = start(tmp_path, path, log, workers=workers)
        # A random moment once it works: between 5 and 40 points of the 240, in the middle of anything.
        wanted = moments.randint(5, 40)
        wait_for(lambda log=log, wanted=wanted: len(logged(log)) >= wanted, process)
        at_work = children(process)
        assert workers == 1 or len(at_work) >= 2
        process.send_signal(signal.SIGKILL)
        process.wait()
        wait_for_end(at_work)
        assert before <= sweep_status(path).stored < 4 * ROWS
    kept, log = {row[1] for row in rows_of(path)}, tmp_path / "log last"
    assert kept
    assert start(tmp_path, path, log).wait() == 0
    assert sorted(logged(log)) == sorted(set(range(4 * ROWS)) - kept)

    undisturbed = tmp_path / "undisturbed.sqlite"
    run_sweep(fake_plan(rows=ROWS), undisturbed, workers=1)
    assert rows_of(path) == rows_of(undisturbed)
    assert len(rows_of(path)) == 4 * ROWS
    for store in (path, undisturbed):
        write_csv(load_sweep(store), store.with_suffix(".csv"))
    assert path.with_suffix(".csv").read_bytes() == undisturbed.with_suffix(".csv").read_bytes()


@pytest.mark.slow
def test_ctrl_c_awaits_the_points_at_work_and_a_second_one_does_not(tmp_path) -> None:
    """Points of ten minutes: only the second interrupt can have ended them."""
    path, log = tmp_path / "slow.sqlite", tmp_path / "log"
    process = start(tmp_path, path, log, seconds=600.0)
    wait_for(lambda: len(logged(log)) >= 2, process)
    process.send_signal(signal.SIGINT)
    time.sleep(0.5)
    assert process.poll() is None
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=60.0) != 0
    assert sweep_status(path).stored == 0
