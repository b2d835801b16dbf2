"""Recorded sets are found by the names of their files, the paper's protocol alone, and missing ones
are named.
"""

import shutil

import pytest
from figure_cases import RECORDED_ABS, RECORDED_PLYWOOD, recorded_folder

from cyclemap.cli.run_figures import WatchedFolder
from cyclemap.collection import CollectionLoop
from cyclemap.evidence import simulate_collection
from cyclemap.figures.catalogue import MeasuredFolder
from cyclemap.figures.materials.paper_pushes import measured_run, measured_theta0
from cyclemap.mechanics import SidePush
from cyclemap.protocol import loop_from_settings


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    return recorded_folder(tmp_path_factory)


def test_sets_are_found_wherever_they_lie_below_the_folder(recorded) -> None:
    plywood, made_abs, *others = (
        measured_run(recorded, name) for name in ("plywood", "abs", "delrin", "pu")
    )
    counts = plywood.pushes.count, made_abs.pushes.count
    assert counts == (RECORDED_PLYWOOD, RECORDED_ABS) and others == [None, None]
    assert made_abs.unreadable == 0
    pairs = measured_theta0(recorded, "abs")
    assert pairs.path.size == RECORDED_ABS and pairs.theta.size == RECORDED_ABS - 1
    assert measured_theta0(recorded, "pu") is None


def test_pushes_of_another_protocol_or_too_few_are_no_set(tmp_path) -> None:
    base = CollectionLoop.mit("abs", accuracy=1e-4, push=SidePush(distance=0.02))
    simulate_collection(loop_from_settings({"fraction": 0.5}, base), tmp_path / "other", 20)
    simulate_collection(base, tmp_path / "few", 19)
    assert measured_run(MeasuredFolder(tmp_path), "abs") is None


def test_damaged_files_are_counted_and_the_rest_is_kept(recorded, tmp_path) -> None:
    shutil.copytree(recorded.path / "one", tmp_path / "one")
    files = sorted((tmp_path / "one").rglob("*.h5"))
    files[3].write_bytes(b"no HDF5")
    found = measured_run(MeasuredFolder(tmp_path), "abs")
    assert found.unreadable == 1 and found.pushes.count == RECORDED_ABS - 1


def test_who_watches_the_folder_learns_where_the_pushes_were(recorded) -> None:
    watched = WatchedFolder(recorded.path)
    assert measured_run(watched, "abs") is not None and measured_run(watched, "pu") is None
    (used,) = watched.there
    assert any("motion_surface=abs" in file.name for file in (recorded.path / used).iterdir())
