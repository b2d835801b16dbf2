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


def reason(path) -> str:
    """Why a file of pushes is left out."""
    loaded = load_pushes(path)
    assert loaded.table.empty and loaded.scans.empty
    return loaded.unreadable[0].reason


@pytest.mark.parametrize("suffix", READERS)
def test_a_pipe_a_device_and_an_endless_file_are_refused_at_once(tmp_path, suffix) -> None:
    pipe, device, large, folder = (tmp_path / f"{n}{suffix}" for n in ("p", "device", "l", "f"))
    os.mkfifo(pipe)
    device.symlink_to("/dev/zero")
    with large.open("wb") as file:
        file.truncate(2**34)
    folder.mkdir()
    told = {pipe: "a pipe", device: "a device", large: "MB", folder: "directory"}
    for reader in READERS[suffix]:
        for path, words in told.items():
            refused(reader, path, told=words, kind=DataFileError)


def packed(path, **settings):
    """A file of pushes in a packing; its tables are there to be filled."""
    with h5py.File(path, "w") as file:
        for name in TABLES:
            yield file.create_dataset(name, **settings)
    assert path.stat().st_size < 10**6


@pytest.mark.slow
def test_tables_that_unpack_to_gigabytes_or_otherwise_are_refused_before_they_do(tmp_path) -> None:
    """The limit is on what is decoded: bytes become doubles, and a chunk may hold more than its
    size says.
    """
    wide, bomb, other = (tmp_path / f"{name}.h5" for name in ("wide", "bomb", "other"))
    zeros = np.zeros((LARGEST_CONTENT // 32 + 1, 4), "i1")
    list(packed(wide, data=zeros, compression="gzip"))
    shape = {"shape": (100, 4), "chunks": (100, 4), "dtype": "f8"}
    for table in packed(bomb, **shape, compression="gzip"):
        table.id.write_direct_chunk((0, 0), zlib.compress(bytes(2**26)))
    list(packed(other, data=np.zeros((10, 4)), compression="lzf"))
    assert "takes more than 17 MB" in reason(wide)
    assert "unpacks to more than its size" in reason(bomb)
    assert "write it with gzip" in reason(other)


def test_columns_and_keys_that_are_there_twice_are_refused(tmp_path) -> None:
    table, push = tmp_path / "twice.csv", tmp_path / "twice.json"
    table.write_text("theta0_deg,theta_next_deg,Theta0_deg\n1,2,3\n")
    push.write_text('{"object_pose": [], "tip_pose": [], "ft_wrench": [], "tip_pose": []}')
    told = "line 1: the column theta0_deg is there twice"
    refused(read_theta0_pairs, table, told=told, kind=DataFileError)
    assert "the key 'tip_pose' is there twice" in reason(push)


@pytest.mark.slow
@pytest.mark.parametrize("number", ["1_0", "١٢", "0x10", "1e", "--1"])
def test_numbers_are_written_in_plain_digits(tmp_path, capsys, number) -> None:
    table = tmp_path / "odd.csv"
    table.write_text(f"theta0_deg\n1\n{number}\n")
    told = r"line 3: theta0_deg is '.*'; it must be a finite"
    refused(read_theta0_pairs, table, told=told, kind=DataFileError)
    for words in (
        ["cycle", "plywood", "--theta0-deg", number],
        ["cycle", "plywood", "--theta0-deg", "0", "--set", f"mu_a={number}"],
        ["staircase", "plywood", "--cycles", number],
        ["staircase", "plywood", "--seed", number],
        ["sweep", "plywood", "--over", f"mu_a={number}"],
    ):
        assert run(words) == 2
    assert len(capsys.readouterr().err.splitlines()) == 5


def test_deep_nesting_and_many_digits_are_told_in_one_line(here, capsys) -> None:
    digits, deep = "9" * 400, "[" * 100_000
    (here / "digits.toml").write_text(f"[friction]\nmu_a = 0.3\nmu_b = {digits}\n")
    (here / "deep.toml").write_text(f"a = {deep}\n")
    (here / "dots.toml").write_text(f"{'a.' * 50_000}a = 1\n")
    asked = [["cycle", f"{name}.toml"] for name in ("digits", "deep", "dots")]
    for value in (deep, f"[[{digits}, 0]]", f"[[{'9' * 5000}, 0]]"):
        asked.append(["cycle", "plywood", "--set", f"way_points_mm={value}"])
    asked.append(["sweep", "plywood", "--over", f"way_points_mm={deep}"])
    for words in asked:
        assert run(words) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 7 and max(map(len, lines)) < 4500
