"""A sweep killed by `kill -9` three times at random moments ends as one that was left alone."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from fake_numbers import fake_plan, logged, swept

from cyclemap.sweeps import load_sweep, sweep_status, write_csv

ROWS, SECONDS = 60, 0.02
SCRIPT = """
import sys
from fake_numbers import fake_plan
from cyclemap.sweeps import run_sweep
if __name__ == "__main__":
    plan = fake_plan(rows=int(sys.argv[2]), seconds=float(sys.argv[3]), log=sys.argv[4])
    run_sweep(plan, sys.argv[1], workers=int(sys.argv[5]))
"""


def start(
    folder: Path, path: Path, log: Path, seconds: float = SECONDS, workers: int = 2
) -> subprocess.Popen:
    script = folder / "sweep.py"
    script.write_text(SCRIPT)
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    command = [
        sys.executable,
        str(script),
        str(path),
        str(ROWS),
        str(seconds),
        str(log),
        str(workers),
    ]
    return subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL)


def wait_for(condition) -> None:
    deadline = time.monotonic() + 120.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


@pytest.mark.slow
def test_killed_three_times_it_is_complete_and_the_same_to_the_byte(tmp_path) -> None:
    """Workers watch their parent: none goes on alone, to hold memory or files."""
    path, moments = tmp_path / "killed.sqlite", random.Random(7)
    for attempt, workers in enumerate((2, 1, 1)):
        log = tmp_path / f"log {attempt}"
        before = sweep_status(path, fake_plan(rows=ROWS)).stored
        process = start(tmp_path, path, log, workers=workers)
        # A random moment once it works: between 5 and 40 points of the 240, in the middle of
        # anything.
        wanted = moments.randint(5, 40)
        wait_for(lambda log=log, wanted=wanted: len(logged(log)) >= wanted)
        # Its worker processes, and the one that watches over what they share.
        numbers = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        assert process.poll() is None and (workers == 1 or len(numbers) >= 2)
        process.send_signal(signal.SIGKILL)
        process.wait()
        wait_for(
            lambda numbers=numbers: not any(Path(f"/proc/{number}").exists() for number in numbers)
        )
        assert before <= sweep_status(path).stored < 4 * ROWS
    kept, log = set(load_sweep(path).table["number"].tolist()), tmp_path / "log last"
    assert kept
    assert start(tmp_path, path, log).wait() == 0
    assert sorted(logged(log)) == sorted(set(range(4 * ROWS)) - kept)
    write_csv(load_sweep(path), tmp_path / "killed.csv")
    write_csv(
        swept(tmp_path / "undisturbed.sqlite", fake_plan(rows=ROWS)), tmp_path / "undisturbed.csv"
    )
    assert (tmp_path / "killed.csv").read_bytes() == (tmp_path / "undisturbed.csv").read_bytes()


@pytest.mark.slow
def test_ctrl_c_awaits_the_points_at_work_and_a_second_one_does_not(tmp_path) -> None:
    """Points of ten minutes: only the second interrupt can have ended them."""
    path, log = tmp_path / "slow.sqlite", tmp_path / "log"
    process = start(tmp_path, path, log, seconds=600.0)
    wait_for(lambda: len(logged(log)) >= 2)
    process.send_signal(signal.SIGINT)
    time.sleep(0.5)
    assert process.poll() is None
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=60.0) != 0
    assert sweep_status(path).stored == 0
