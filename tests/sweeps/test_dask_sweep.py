"""A sweep on a real Dask cluster: its own scheduler and worker processes, reached by the executor of its client."""

import distributed
import pytest
from fake_numbers import fake_plan

from cyclemap.sweeps import PortraitNumbers, SweepPlan, load_sweep, run_sweep, write_csv


@pytest.fixture(scope="module")
def executor():
    """The executor of a local cluster of two worker processes."""
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        yield client.get_executor()


def table(path, plan, **options) -> bytes:
    assert run_sweep(plan, path, **options).complete
    write_csv(load_sweep(path), path.with_suffix(".csv"))
    return path.with_suffix(".csv").read_bytes()


@pytest.mark.slow
def test_a_dask_cluster_finds_the_same_as_one_process(tmp_path, executor) -> None:
    here = table(tmp_path / "here.sqlite", fake_plan(rows=30, refused_above=0.28), workers=1)
    there = table(tmp_path / "there.sqlite", fake_plan(rows=30, refused_above=0.28), executor=executor, workers=2)
    assert there == here
    assert there.count(b"\n") == 121


@pytest.mark.slow
def test_a_dask_cluster_finds_real_portraits(tmp_path, executor) -> None:
    plan = SweepPlan.grid("isotropic", {"hitch_x_mm": (-11.0, -9.0)}, numbers=PortraitNumbers(tolerance=1e-2))
    there = table(tmp_path / "there.sqlite", plan, executor=executor, workers=2)
    assert there == table(tmp_path / "here.sqlite", plan, workers=1)
