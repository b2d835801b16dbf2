"""The same numbers whoever works, in whatever order, however often interrupted."""

import os
import signal
import subprocess
import sys
import time
import tracemalloc
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path

import distributed
import numpy as np
import pytest
from fake_numbers import FakeNumbers, fake_plan, fake_sample, logged
from refusals import refused

from cyclemap.errors import CycleMapError
from cyclemap.sweeps import (
    PortraitNumbers,
    SweepPlan,
    load_sweep,
    run_sweep,
    sweep_status,
    write_csv,
)
from cyclemap.sweeps.run_sweep import own_executor


class Shuffled(Executor):
    """One thread that takes its time, and then whichever of the waiting calls chance picks."""

    def __init__(self, seed: int) -> None:
        self.thread, self.random = ThreadPoolExecutor(1), np.random.default_rng(seed)
        self.held, self.largest = [], 0

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        self.held.append((future, fn, args))
        self.thread.submit(self.work)
        return future

    def work(self) -> None:
        time.sleep(0.01)
        self.largest = max(self.largest, len(self.held))
        future, fn, args = self.held.pop(self.random.integers(len(self.held)))
        if future.set_running_or_notify_cancel():
            future.set_result(fn(*args))

    def shutdown(self, wait=True, *, cancel_futures=False):
        self.thread.shutdown(wait)


def swept_csv(path, plan, **options) -> bytes:
    assert run_sweep(plan, path, **options).complete
    table = path.with_suffix(".csv")
    write_csv(load_sweep(path), table)
    return table.read_bytes()


@pytest.fixture
def alone(tmp_path) -> bytes:
    """The CSV of a sweep by one process, undisturbed."""
    return swept_csv(tmp_path / "alone.sqlite", fake_plan(rows=12), workers=1)


def test_the_order_in_which_chunks_come_back_does_not_matter(tmp_path, alone) -> None:
    for seed in range(2):
        path = tmp_path / f"order {seed}.sqlite"
        with Shuffled(seed) as shuffled:
            assert swept_csv(path, fake_plan(rows=12), executor=shuffled, workers=3) == alone
            assert shuffled.submit(int, 7).result() == 7, "the executor is left open"
        assert shuffled.largest == 6, "two chunks a worker are on their way, no more"


def test_a_refused_point_is_a_result_and_stops_nothing(tmp_path) -> None:
    path = tmp_path / "sweep.sqlite"
    status = run_sweep(fake_plan(refused_above=0.26), path, workers=1)
    assert (status.stored, status.refused, status.complete) == (20, 8, True)
    found = load_sweep(path)
    said = [*[""] * 12, *["mu_a is 0.275"] * 4, *["mu_a is 0.3"] * 4]
    assert found.table["refusal"].tolist() == said
    assert np.isnan(found.table["rotation"]).tolist() == [False] * 12 + [True] * 8


def test_a_bug_at_a_point_ends_the_sweep_by_name_and_keeps_the_others(tmp_path) -> None:
    path, log = tmp_path / "sweep.sqlite", tmp_path / "log"
    told = r"point 7 \(mu_a=0.225, hitch_x_mm=0\) failed, .* ZeroDivisionError: a bug"
    refused(run_sweep, fake_plan(fails_at=7), path, workers=1, told=told, kind=CycleMapError)
    assert 0 < sweep_status(path).stored <= 7
    assert run_sweep(fake_plan(log=str(log)), path, workers=1).complete
    assert 7 in logged(log) and 0 not in logged(log)


@pytest.mark.slow
def test_a_worker_that_dies_ends_the_sweep_with_advice(tmp_path) -> None:
    path, told = tmp_path / "sweep.sqlite", "a worker ended abruptly .* run the same sweep again"
    refused(run_sweep, fake_plan(dies_at=13), path, workers=2, told=told, kind=CycleMapError)
    assert sweep_status(path).stored < 20
    assert run_sweep(fake_plan(), path, workers=1).complete


def test_a_worker_of_another_version_is_refused(tmp_path) -> None:
    class Other(Shuffled):
        def submit(self, fn, /, numbers, points):
            return super().submit(fn, FakeNumbers(version="fake 0"), points)

    path = tmp_path / "sweep.sqlite"
    told = r"another version of the code \(fake 0, not fake 1\)"
    with Other(0) as other, pytest.raises(CycleMapError, match=told):
        run_sweep(fake_plan(), path, executor=other, workers=1)
    assert sweep_status(path).stored == 0


def test_ctrl_c_keeps_what_is_found_and_the_sweep_goes_on_from_there(tmp_path, alone) -> None:
    """A complete one is not run again."""
    path, log, seen = tmp_path / "sweep.sqlite", tmp_path / "log", []

    def interrupt(status) -> None:
        seen.append(status.stored)
        if status.stored >= 10:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_sweep(fake_plan(rows=12), path, workers=1, progress=interrupt)
    kept = sweep_status(path).stored
    assert seen[0] == 0 and 10 <= kept == seen[-1] < 48 and seen == sorted(seen)
    plan = fake_plan(rows=12, log=str(log))
    assert swept_csv(path, plan, workers=1) == swept_csv(path, plan, workers=1) == alone
    assert logged(log) == list(range(kept, 48))


def test_ctrl_c_waits_for_chunks_at_work_and_stores_them(tmp_path) -> None:
    path, told = tmp_path / "sweep.sqlite", []

    def interrupt(status) -> None:
        told.append(status.stored)
        if len(told) == 3:
            raise KeyboardInterrupt

    with ThreadPoolExecutor(2) as threads, pytest.raises(KeyboardInterrupt):
        run_sweep(fake_plan(seconds=0.02), path, executor=threads, workers=2, progress=interrupt)
    assert sweep_status(path).stored == told[-1] > told[2]


def peak_memory(path, count) -> int:
    tracemalloc.start()
    try:
        run_sweep(fake_sample(count, "uniform"), path, workers=1)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.slow
def test_memory_is_flat_over_a_sweep_of_any_length(tmp_path) -> None:
    """A point more takes less than 50 bytes: fewer than a point, an outcome or a future has."""
    peak_memory(tmp_path / "warm.sqlite", 100)
    short, long = (peak_memory(tmp_path / f"{count}.sqlite", count) for count in (1200, 4200))
    assert long - short < 50 * 3000


def test_bad_workers_are_refused(tmp_path) -> None:
    for workers in (0, -1, 1.5):
        refused(run_sweep, fake_plan(), tmp_path / "sweep.sqlite", workers=workers, told="workers")
    assert not (tmp_path / "sweep.sqlite").exists()


VARIABLES = ("OPENBLAS_NUM_THREADS", "CYCLEMAP_THREADS")


@pytest.mark.slow
def test_workers_have_one_thread_each_where_nothing_else_is_said(monkeypatch) -> None:
    """A single one is this process, with its own threads."""
    for said in ({}, {"CYCLEMAP_THREADS": "3"}, {"OPENBLAS_NUM_THREADS": "2"}):
        for name in VARIABLES:
            monkeypatch.delenv(name, raising=False)
        for name, value in said.items():
            monkeypatch.setenv(name, value)
        before = dict(os.environ)
        with own_executor(2) as pool:
            found = {name: pool.submit(os.getenv, name).result() for name in VARIABLES}
        assert found == dict.fromkeys(VARIABLES, "1") | said
        with own_executor(1) as pool:
            assert pool.submit(os.getpid).result() == os.getpid()
            found = {name: pool.submit(os.getenv, name).result() for name in VARIABLES}
        assert found == dict.fromkeys(VARIABLES) | said
        assert dict(os.environ) == before


@pytest.mark.slow
def test_two_processes_and_a_dask_cluster_find_the_same_as_one(tmp_path) -> None:
    fake = fake_plan(rows=30, refused_above=0.28)
    numbers = PortraitNumbers(tolerance=1e-2)
    real = SweepPlan.grid("isotropic", {"hitch_x_mm": (-11.0, -9.0)}, numbers=numbers)
    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        for name, plan in (("fake", fake), ("real", real)):
            here = swept_csv(tmp_path / f"{name} here.sqlite", plan, workers=1)
            for others in ({"executor": client.get_executor()}, {}):
                path = tmp_path / f"{name} {len(others)}.sqlite"
                assert swept_csv(path, plan, workers=2, **others) == here
            assert here.count(b"\n") == 1 + len(plan)


ROWS = 40
SCRIPT = """
import sys
from fake_numbers import fake_plan
from cyclemap.sweeps import run_sweep
if __name__ == "__main__":
    plan = fake_plan(rows=int(sys.argv[2]), seconds=float(sys.argv[3]), log=sys.argv[4])
    run_sweep(plan, sys.argv[1], workers=int(sys.argv[5]))
"""


def start(folder: Path, path: Path, log: Path, seconds=0.02, workers=2) -> subprocess.Popen:
    script = folder / "sweep.py"
    script.write_text(SCRIPT)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, *map(str, (script, path, ROWS, seconds, log, workers))]
    return subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL)


def wait_for(condition) -> None:
    deadline = time.monotonic() + 120.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


@pytest.mark.slow
def test_killed_twice_it_is_complete_and_the_same_to_the_byte(tmp_path) -> None:
    """At points of ten minutes, which no worker goes on with alone, and amid quick ones."""
    path = tmp_path / "killed.sqlite"
    for attempt, (workers, seconds, wanted) in enumerate(((2, 600.0, 2), (1, 0.02, 23))):
        log = tmp_path / f"log {attempt}"
        before = sweep_status(path, fake_plan(rows=ROWS)).stored
        process = start(tmp_path, path, log, seconds, workers)
        wait_for(lambda log=log, wanted=wanted: len(logged(log)) >= wanted)
        # Its worker processes, and the one that watches over what they share.
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        assert process.poll() is None and (workers == 1 or len(children) >= 2)
        process.send_signal(signal.SIGKILL)
        process.wait()
        alive = [Path("/proc") / child for child in children]
        wait_for(lambda alive=alive: not any(child.exists() for child in alive))
        assert before <= sweep_status(path).stored < 4 * ROWS
    kept, log = set(load_sweep(path).table["number"].tolist()), tmp_path / "log last"
    assert kept
    assert start(tmp_path, path, log).wait() == 0
    assert sorted(logged(log)) == sorted(set(range(4 * ROWS)) - kept)
    undisturbed = swept_csv(tmp_path / "undisturbed.sqlite", fake_plan(rows=ROWS), workers=1)
    assert swept_csv(path, fake_plan(rows=ROWS), workers=1) == undisturbed


@pytest.mark.slow
def test_ctrl_c_awaits_the_points_at_work_and_a_second_one_does_not(tmp_path) -> None:
    """Points of ten minutes: only the second interrupt can have ended them."""
    path, log = tmp_path / "slow.sqlite", tmp_path / "log"
    process = start(tmp_path, path, log, 600.0)
    wait_for(lambda: len(logged(log)) >= 2)
    process.send_signal(signal.SIGINT)
    time.sleep(0.5)
    assert process.poll() is None
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=60.0) != 0
    assert sweep_status(path).stored == 0
