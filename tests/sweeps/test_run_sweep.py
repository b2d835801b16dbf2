"""A sweep finds the same numbers whoever works, in whatever order,
however often it is interrupted."""

import os
import time
import tracemalloc
from concurrent.futures import Executor, Future, ThreadPoolExecutor

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
        self.thread, self.random, self.held, self.largest = (
            ThreadPoolExecutor(1),
            np.random.default_rng(seed),
            [],
            0,
        )

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
    for seed in range(4):
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
    assert found.table["refusal"].tolist() == [
        *[""] * 12,
        *["mu_a is 0.275"] * 4,
        *["mu_a is 0.3"] * 4,
    ]
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
    path = tmp_path / "sweep.sqlite"
    told = []

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
    """Six thousand points more take less than 50 bytes each: fewer than a point, an outcome or a
    future has.
    """
    peak_memory(tmp_path / "warm.sqlite", 100)
    short, long = (peak_memory(tmp_path / f"{count}.sqlite", count) for count in (1500, 7500))
    assert long - short < 50 * 6000


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
            assert [pool.submit(os.getenv, name).result() for name in VARIABLES] == [
                said.get(n) for n in VARIABLES
            ]
        assert dict(os.environ) == before


@pytest.fixture(scope="module")
def executor():
    """The executor of a local cluster of two worker processes."""
    options = {
        "n_workers": 2,
        "threads_per_worker": 1,
        "processes": True,
        "dashboard_address": None,
    }
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        yield client.get_executor()


@pytest.mark.slow
def test_two_processes_and_a_dask_cluster_find_the_same_as_one(tmp_path, executor) -> None:
    fake = fake_plan(rows=30, refused_above=0.28)
    real = SweepPlan.grid(
        "isotropic", {"hitch_x_mm": (-11.0, -9.0)}, numbers=PortraitNumbers(tolerance=1e-2)
    )
    for name, plan in (("fake", fake), ("real", real)):
        here = swept_csv(tmp_path / f"{name} here.sqlite", plan, workers=1)
        assert (
            swept_csv(tmp_path / f"{name} there.sqlite", plan, executor=executor, workers=2) == here
        )
        assert swept_csv(tmp_path / f"{name} two.sqlite", plan, workers=2) == here
        assert here.count(b"\n") == 1 + len(plan)
