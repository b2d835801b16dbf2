"""The store keeps what it was given to the last bit, and refuses what it cannot trust."""

import multiprocessing
import os
import sqlite3
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from fake_numbers import FakeNumbers, fake_plan, opened, swept
from refusals import refused

from cyclemap.errors import DataFileError
from cyclemap.sweeps import (
    PointOutcome,
    StoreWriteError,
    SweepStore,
    load_sweep,
    run_sweep,
    sweep_status,
)


@pytest.fixture
def path(tmp_path) -> Path:
    return tmp_path / "new folder" / "sweep.sqlite"


def full_store(path, **options) -> None:
    swept(path, fake_plan(**options))


def test_every_float_comes_back_as_it_went(path) -> None:
    """Not a number, infinities, zeros, subnormals and numbers of 17 digits."""
    plan = fake_plan()
    kept = (0.1 + 0.2, np.inf, -np.inf, 5e-324, 1.7976931348623157e308)
    values = {"rotation": kept[0], "rotation_lower": np.inf, "rotation_upper": np.nan}
    with SweepStore(path, plan) as store:
        outcome = PointOutcome({**values, "fixed_point_theta": kept}, "partly refused: 'θ'")
        store.add([(plan.point(3), outcome)])
        store.add([(plan.point(3), PointOutcome({"rotation": 2.0}))])  # a point is kept once
        assert store.status().stored == store.status().refused == 1
    row = load_sweep(path).table.iloc[0]
    assert (row["rotation"], row["rotation_lower"]) == (0.1 + 0.2, np.inf)
    assert np.isnan([row["rotation_upper"], row["locked_period"]]).all()
    assert tuple(row["fixed_point_theta"].tolist()) == kept
    assert (row["refusal"], row["number"]) == ("partly refused: 'θ'", 3)


def test_anyone_can_ask_it_in_sql(path) -> None:
    full_store(path)
    connection = sqlite3.connect(path)
    asked = 'SELECT number FROM points WHERE mu_a > 0.22 AND "stable_points" = 1 ORDER BY number'
    found = [number for (number,) in connection.execute(asked)]
    mode = connection.execute("PRAGMA journal_mode").fetchone()[0]
    connection.close()
    assert (found, mode) == ([4, 5, 6, 8, 9, 10, 12, 13, 14, 16, 17, 18], "wal")


def test_the_store_of_another_plan_is_refused_and_left_alone(path) -> None:
    full_store(path)
    before = path.read_bytes()
    for options, differs in (
        ({"rows": 6}, "differs in points"),
        ({"told": "other"}, "differs in quantities"),
        ({"version": "fake 2"}, "another version of the code"),
    ):
        refused(run_sweep, fake_plan(**options), path, workers=1, told=differs)
        refused(sweep_status, path, fake_plan(**options), told=differs)
    assert path.read_bytes() == before


def written_to(path, statement) -> None:
    connection = sqlite3.connect(path)
    connection.execute(statement)
    connection.commit()
    connection.close()


def test_a_damaged_or_foreign_file_is_refused_by_name(path) -> None:
    """One number changed in a file that is otherwise sound; another database; none at all."""
    full_store(path, rows=60)
    written_to(path, "UPDATE points SET rotation = 0.5 WHERE number = 7")
    for told in (
        "a row of its table points is not as it was",
        "not a store of this version's",
        "not a database",
    ):
        before = path.read_bytes()
        told = rf"^{path}.*{told}.*remove it"
        refused(load_sweep, path, fake_plan(rows=60), told=told, kind=DataFileError)
        assert path.read_bytes() == before
        path.unlink()
        if "row" in told:
            written_to(path, "CREATE TABLE mine (x)")
        else:
            path.write_text("not a store, but words\n" * 300)


def test_an_absent_store_is_at_the_beginning_of_a_plan_and_no_results(path) -> None:
    """One begun and killed before its first table is begun again."""
    status = sweep_status(path, fake_plan())
    assert (status.points, status.stored, status.complete) == (20, 0, False)
    assert not path.exists()
    for ask in (sweep_status, load_sweep):
        refused(ask, path, told="no such store", kind=DataFileError)
    path.parent.mkdir()
    path.touch()
    assert len(swept(path, fake_plan())) == 20


def test_a_folder_is_no_store_and_a_store_that_cannot_be_made_is_a_write_error(tmp_path) -> None:
    for plan in (None, fake_plan()):
        refused(SweepStore, tmp_path, plan, told="is a folder", kind=DataFileError)
    (tmp_path / "file").write_text("")
    path, told = tmp_path / "file" / "a.sqlite", "cannot be written"
    refused(SweepStore, path, fake_plan(), told=told, kind=StoreWriteError)


def test_a_held_store_is_a_write_error(path, monkeypatch) -> None:
    full_store(path, rows=5)
    monkeypatch.setattr("cyclemap.sweeps.sweep_store._PATIENCE_SECONDS", 0.05)
    holder = sqlite3.connect(path, isolation_level=None)
    holder.execute("BEGIN IMMEDIATE")
    plan, told = fake_plan(), "held by another process"
    with SweepStore(path, plan) as store:
        added = [(plan.point(0), PointOutcome({}))]
        refused(store.add, added, told=told, kind=StoreWriteError)
    holder.close()


FULL_DISK = """
import resource, sys
from fake_numbers import fake_plan
from cyclemap.sweeps import run_sweep
from cyclemap.sweeps import StoreWriteError
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), int(sys.argv[2])))
try:
    run_sweep(fake_plan(rows=300, seconds=1e-4), sys.argv[1], workers=1)
except StoreWriteError as error:
    print(error)
"""


@pytest.mark.slow
def test_a_full_disk_stops_the_sweep_keeps_what_is_stored_and_lets_it_go_on(path, tmp_path) -> None:
    """A limit on the size of files stands for the disk: SQLite meets a refused write in both."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", FULL_DISK, str(path), "250000"]
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert "cannot be written" in ended.stdout
    assert "make room, then run the same sweep again" in ended.stdout
    kept, log, plan = load_sweep(path), tmp_path / "log", fake_plan(rows=300)
    assert 100 < len(kept) < 1200
    object.__setattr__(plan, "numbers", FakeNumbers(log=str(log)))
    whole, wanted = swept(path, plan), swept(tmp_path / "undisturbed.sqlite", fake_plan(rows=300))
    assert len(log.read_text().split()) == 1200 - len(kept)
    assert whole.table["rotation"].tolist() == wanted.table["rotation"].tolist()
    assert whole.table["number"].tolist() == list(range(1200))


@pytest.mark.slow
def test_a_flipped_byte_is_refused_or_changes_nothing(path, tmp_path) -> None:
    """Wherever it falls: in SQLite's structure, the description, a row, or in unused room."""
    full_store(path)
    whole, before, outcomes = path.read_bytes(), load_sweep(path), {True: 0, False: 0}
    chance, damaged = np.random.default_rng(5), tmp_path / "damaged.sqlite"
    for cut in (1, 100, 4096, 5000):
        damaged.write_bytes(whole[:-cut])
        refused(sweep_status, damaged, told="damaged", kind=DataFileError)
    for place in chance.integers(len(whole), size=100).tolist():
        flipped = bytes([whole[place] ^ int(chance.integers(1, 256))])
        damaged.write_bytes(whole[:place] + flipped + whole[place + 1 :])
        try:
            found = load_sweep(damaged)
        except DataFileError as error:
            assert str(damaged) in str(error)
            outcomes[False] += 1
            continue
        assert found.description == before.description
        numbers = [one.table.select_dtypes("number") for one in (found, before)]
        assert numbers[0].equals(numbers[1])
        outcomes[True] += 1
    assert min(outcomes.values()) > 10


@pytest.mark.slow
def test_sweeps_that_begin_together_share_one_healthy_store(path) -> None:
    """Four processes open a store that is not there at the same moment, twice over."""
    with ProcessPoolExecutor(4, mp_context=multiprocessing.get_context("spawn")) as pool:
        assert list(pool.map(time.sleep, [2.0] * 4)) == [None] * 4
        for number in range(2):
            found = pool.map(opened, [path.with_name(f"{number}.sqlite")] * 4)
            assert list(found) == [len(fake_plan())] * 4
