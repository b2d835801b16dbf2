"""One limit for every reader: what is too large, no regular file, or says a thing twice is refused
in one line.
"""

import os
import zlib

import h5py
import numpy as np
import pytest
from refusals import refused

from cyclemap.cli.main import run
from cyclemap.errors import DataFileError
from cyclemap.evidence import load_pushes, read_theta0_pairs
from cyclemap.mechanics import load_footprint, load_material
from cyclemap.protocol import read_protocol
from cyclemap.text_files import LARGEST_CONTENT

READERS = {".csv": (read_theta0_pairs, load_footprint), ".toml": (load_material, read_protocol)}
TABLES = ("object_pose", "tip_pose", "ft_wrench")


def reasons(path) -> str:
    """Why a file of pushes is left out."""
    loaded = load_pushes(path)
    assert loaded.table.empty and loaded.scans.empty
    return loaded.unreadable[0].reason


@pytest.mark.parametrize("suffix", READERS)
def test_a_pipe_a_device_and_an_endless_file_are_refused_at_once(tmp_path, suffix) -> None:
    os.mkfifo(tmp_path / f"pipe{suffix}")
    (tmp_path / f"device{suffix}").symlink_to("/dev/zero")
    with (tmp_path / f"large{suffix}").open("wb") as file:
        file.truncate(2**34)
    (tmp_path / f"folder{suffix}").mkdir()
    for reader in READERS[suffix]:
        for name, said in (
            ("pipe", "a pipe"),
            ("device", "a device"),
            ("large", "MB"),
            ("folder", "directory"),
        ):
            refused(reader, tmp_path / f"{name}{suffix}", told=said, kind=DataFileError)


@pytest.mark.slow
def test_tables_that_unpack_to_gigabytes_are_refused_before_they_do(tmp_path) -> None:
    """The limit is on what is decoded: bytes become doubles, and a chunk may hold more than its
    size says.
    """
    wide, bomb = tmp_path / "wide.h5", tmp_path / "bomb.h5"
    with h5py.File(wide, "w") as file:
        for name in TABLES:
            file.create_dataset(
                name, data=np.zeros((LARGEST_CONTENT // 32 + 1, 4), "i1"), compression="gzip"
            )
    with h5py.File(bomb, "w") as file:
        for name in TABLES:
            table = file.create_dataset(
                name, shape=(100, 4), dtype="f8", chunks=(100, 4), compression="gzip"
            )
            table.id.write_direct_chunk((0, 0), zlib.compress(bytes(2**26)))
    assert wide.stat().st_size < 10**6 and "takes more than 17 MB" in reasons(wide)
    assert bomb.stat().st_size < 10**6 and "unpacks to more than its size" in reasons(bomb)


def test_other_packings_are_refused_by_name(tmp_path) -> None:
    with h5py.File(tmp_path / "lzf.h5", "w") as file:
        for name in TABLES:
            file.create_dataset(name, data=np.zeros((10, 4)), compression="lzf")
    assert "write it with gzip" in reasons(tmp_path / "lzf.h5")


def test_columns_and_keys_that_are_there_twice_are_refused(tmp_path) -> None:
    table, push = tmp_path / "twice.csv", tmp_path / "twice.json"
    table.write_text("theta0_deg,theta_next_deg,Theta0_deg\n1,2,3\n")
    push.write_text('{"object_pose": [], "tip_pose": [], "ft_wrench": [], "tip_pose": []}')
    refused(
        read_theta0_pairs,
        table,
        told="line 1: the column theta0_deg is there twice",
        kind=DataFileError,
    )
    assert "the key 'tip_pose' is there twice" in reasons(push)


@pytest.mark.slow
@pytest.mark.parametrize("number", ["1_0", "١٢", "0x10", "1e", "--1"])
def test_numbers_are_written_in_plain_digits(tmp_path, capsys, number) -> None:
    table = tmp_path / "odd.csv"
    table.write_text(f"theta0_deg\n1\n{number}\n")
    refused(
        read_theta0_pairs,
        table,
        told=r"line 3: theta0_deg is '.*'; it must be a finite",
        kind=DataFileError,
    )
    for option in (["--theta0-deg", number], ["--theta0-deg", "0", "--set", f"mu_a={number}"]):
        assert run(["cycle", "plywood", *option]) == 2
    for option in (["--cycles", number], ["--seed", number]):
        assert run(["staircase", "plywood", *option]) == 2
    assert run(["sweep", "plywood", "--over", f"mu_a={number}"]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 5


def test_deep_nesting_and_many_digits_are_told_in_one_line(tmp_path, capsys) -> None:
    digits, deep = "9" * 400, "[" * 100_000
    (tmp_path / "digits.toml").write_text(f"[friction]\nmu_a = 0.3\nmu_b = {digits}\n")
    (tmp_path / "deep.toml").write_text(f"a = {deep}\n")
    (tmp_path / "dots.toml").write_text(f"{'a.' * 50_000}a = 1\n")
    for name in ("digits", "deep", "dots"):
        assert run(["cycle", str(tmp_path / f"{name}.toml")]) == 2
    for value in (deep, f"[[{digits}, 0]]", f"[[{'9' * 5000}, 0]]"):
        assert run(["cycle", "plywood", "--set", f"way_points_mm={value}"]) == 2
    assert run(["sweep", "plywood", "--over", f"way_points_mm={deep}"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 7 and max(map(len, lines)) < 4500
