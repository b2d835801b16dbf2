"""Files of the MIT layout are read as they are, refused where they are damaged,
and written whole."""

import json
import os
import random
import resource
import signal
from pathlib import Path

import h5py
import numpy as np
import pytest
from made_pushes import PUSH_NAME, SCAN_NAME, made_push, made_scan, write
from refusals import refused

from cyclemap.errors import DataFileError
from cyclemap.evidence.pushes.contact_forces import contact_force_ratio, scan_forces
from cyclemap.evidence.pushes.push_files import read_push_file, write_push_file
from cyclemap.evidence.pushes.recordings import PushRecord, ScanRecord
from cyclemap.mechanics.slider import Slider

RECT1 = Slider.mit("rect1").outline_points()


def refusal(path: Path) -> str:
    with pytest.raises(DataFileError) as refusal:
        read_push_file(path)
    assert str(refusal.value).startswith(f"{path}: ")
    return str(refusal.value).removeprefix(f"{path}: ")


@pytest.mark.parametrize("turn", [0.0, 1.2, -2.9, 3.5, -7.0, 20.0])
def test_motion_is_that_of_the_object_in_its_initial_frame_and_whole_turns_count(turn) -> None:
    push = PushRecord(**made_push(start=(0.3, 0.1, -2.5), moved=(0.03, -0.09), turn=turn))
    assert push.displacement == pytest.approx((0.03, -0.09), abs=1e-12)
    assert (push.turn, push.end[2]) == pytest.approx((turn, -2.5 + turn), abs=1e-9)


@pytest.mark.parametrize("ratio", [0.0, 0.12, -0.3])
@pytest.mark.parametrize("turn", [0.3, 5.0])
def test_force_ratio_is_tangential_over_normal_force_at_the_contact(ratio, turn) -> None:
    push = PushRecord(**made_push(ratio=ratio, turn=turn))
    assert contact_force_ratio(push, RECT1) == pytest.approx(abs(ratio), abs=1e-9)


def test_on_a_disc_the_normal_points_to_its_centre() -> None:
    tables = made_push(turn=0.5)
    towards = tables["object_pose"][:, 1:3] - tables["tip_pose"][:, 1:3]
    distance = np.hypot(*towards.T)[:, None]
    tables["tip_pose"][:, 1:3] += towards * (1.0 - (0.0525 + 0.00475) / distance)
    left = np.column_stack([-towards[:, 1], towards[:, 0]])
    tables["ft_wrench"][:, 1:3] = -(towards + 0.2 * left) * 60.0
    ratio = contact_force_ratio(PushRecord(**tables), Slider.mit("ellip1").outline_points(720))
    assert ratio == pytest.approx(0.2, abs=0.005)


def test_without_contact_there_is_no_force_ratio() -> None:
    pulling, far, unheard, inside = (made_push() for _ in range(4))
    pulling["ft_wrench"][:, 1:] *= -1.0
    far["tip_pose"][:, 1] += 0.05
    unheard["ft_wrench"][:, 0] += 100.0
    inside["tip_pose"][:, 1:3] = inside["object_pose"][:, 1:3]
    cases = [pulling, far, unheard, inside, made_push(samples=9)]
    assert np.isnan([contact_force_ratio(PushRecord(**tables), RECT1) for tables in cases]).all()
    still = made_scan()
    still["tip_array"][:, 1:3] = 0.1
    assert np.isnan(scan_forces(ScanRecord(*still.values()))).all()


@pytest.mark.parametrize("degrees", [0, 75, 210, 333])
def test_a_scan_gives_the_force_along_and_across_its_motion(tmp_path, degrees) -> None:
    made = made_scan(np.deg2rad(degrees), 2.0, -0.3)
    scan = read_push_file(write(tmp_path / f"{SCAN_NAME}.h5", made))
    assert isinstance(scan, ScanRecord)
    assert scan_forces(scan) == pytest.approx((2.0, -0.3), abs=1e-9)


def test_a_scan_is_known_by_its_name_or_by_its_tables(tmp_path) -> None:
    scan = made_scan()
    as_push = scan | {"tip_pose": scan["tip_array"], "object_pose": scan["tip_array"]}
    del as_push["tip_array"]
    assert isinstance(read_push_file(write(tmp_path / "any.h5", scan)), ScanRecord)
    assert isinstance(read_push_file(write(tmp_path / f"{SCAN_NAME}.h5", as_push)), ScanRecord)
    assert isinstance(read_push_file(write(tmp_path / "any2.h5", as_push)), PushRecord)


def put(row, column, value):
    def change(rows):
        rows[row, column] = value
        return rows

    return change


@pytest.mark.parametrize("suffix", ["h5", "json"])
@pytest.mark.parametrize(
    ("table", "change", "said"),
    [
        ("tip_pose", lambda rows: rows[:, :3], "4 columns"),
        ("ft_wrench", np.ravel, "4 columns"),
        ("object_pose", lambda rows: rows[:1], r"object_pose has shape \(1, 4\)"),
        ("object_pose", put(7, 2, np.nan), "object_pose, row 7, column 2 is nan"),
        ("ft_wrench", put(3, 1, -np.inf), "ft_wrench, row 3, column 1 is -inf"),
        (
            "tip_pose",
            put(5, 0, 9e8),
            "tip_pose: the clock runs backwards by 1e[+]08 s behind row 4",
        ),
        ("tip_pose", np.flipud, "tip_pose: the clock runs backwards"),
        ("object_pose", put(0, 1, 350.0), "column 1 is 350; it must be a number within 100 .SI"),
        ("object_pose", lambda rows: rows.astype(str).astype(object), "number"),
    ],
)
def test_bad_tables_are_refused_with_the_reason(tmp_path, suffix, table, change, said) -> None:
    tables = made_push()
    tables[table] = change(tables[table])
    path = write(tmp_path / f"bad.{suffix}", tables)
    refused(read_push_file, path, told=said, kind=DataFileError)
    del tables[table]
    missing = f"table {table} is missing; the file has"
    refused(read_push_file, write(path, tables), told=missing, kind=DataFileError)
    none = "table object_pose, tip_pose, ft_wrench is missing; the file has none"
    refused(read_push_file, write(path, {}), told=none, kind=DataFileError)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"", "the file is empty"),
        (b"{", "not JSON, or cut short"),
        (json.dumps({"object_pose": [[0, 0, 0, 0]] * 3})[:-9].encode(), "cut short"),
        (b"[1, 2]", "holds a list"),
        (b"\xff\xfe\x00", "not JSON"),
        (b"[" * 100_000, "nested too deeply"),
        (b'{"object_pose": ' + b"9" * 5000 + b"}", "not JSON that can be used"),
        (b'{"object_pose": [[0,0,0,0],[1,0,0]], %s}', "rows of different lengths"),
        (b'{"object_pose": [[0,0,0,null]], %s}', "other than numbers"),
        (b'{"object_pose": [[0,0,0,"1"]], %s}', "other than numbers"),
        (b'{"object_pose": {"a": 1}, %s}', "other than numbers"),
    ],
)
def test_bad_json_is_refused(tmp_path, text, said) -> None:
    path = tmp_path / "bad.json"
    path.write_bytes(text.replace(b"%s", b'"tip_pose": 1, "ft_wrench": 1'))
    assert said in refusal(path)


def test_a_header_that_claims_gigabytes_is_refused_before_anything_is_read(tmp_path) -> None:
    large, small = {"shape": (2**26, 4)}, {"shape": (10, 4), "maxshape": (None, 4)}
    kinds = {
        "chunked": large | {"chunks": (1000, 4)},
        "packed": large | {"compression": "gzip"},
        "plain": large,
    }
    for name, options in {**kinds, "chunk": small | {"chunks": (2**26, 4)}}.items():
        path = tmp_path / f"{name}.h5"
        with h5py.File(path, "w") as file:
            for table in made_push():
                file.create_dataset(table, dtype="f8", **options)
        assert path.stat().st_size < 20_000 and "object_pose takes more than 17 MB" in refusal(path)


PART, LAST = np.ones((20, 4)), np.s_[40:]


def elsewhere(other: str) -> h5py.ExternalLink:
    return h5py.ExternalLink(other, "object_pose")


def table(file: h5py.File, rows: int = 60, **options) -> h5py.Dataset:
    return file.create_dataset("object_pose", (rows, 4), "f8", **options)


@pytest.mark.parametrize(
    ("put", "said"),
    [
        (lambda file, _: table(file, chunks=(20, 4)), "has rows that are not in the file"),
        (lambda file, _: table(file, chunks=(20, 4)).write_direct(PART, None, LAST), "has rows"),
        (lambda file, other: table(file, 2, external=[(other, 0, 64)]), "no table"),
        (lambda file, _: file.create_group("object_pose"), "no table"),
        (lambda file, other: file.update(object_pose=elsewhere(other)), "a link to elsewhere"),
    ],
)
def test_a_table_that_is_not_wholly_in_the_file_is_refused(tmp_path, put, said) -> None:
    path, other = (write(tmp_path / f"{name}.h5", made_push()) for name in ("push", "other"))
    with h5py.File(path, "a") as file:
        del file["object_pose"]
        put(file, str(other))
    assert said in refusal(path)


def test_what_is_no_file_of_push_data_is_refused(tmp_path) -> None:
    (tmp_path / "notes.txt").write_text("pushed a lot")
    os.mkfifo(tmp_path / "pipe.h5")
    (tmp_path / "text.h5").write_text("no HDF5")
    turning = "record_surface=plywood_shape=rect1_a=0_v=20_deg=30_rotdeg=80_radius=0.050_rep=000.h5"
    assert "not that of a straight one" in refusal(write(tmp_path / turning, made_push()))
    assert "'.txt' is no suffix" in refusal(tmp_path / "notes.txt")
    assert "there is no such file" in refusal(tmp_path / "pipe.h5")
    assert "there is no such file" in refusal(tmp_path / "none.h5")
    assert "not a whole HDF5 file" in refusal(tmp_path / "text.h5")


def open_files() -> int:
    return len(list(Path("/proc/self/fd").iterdir())) if Path("/proc/self/fd").is_dir() else 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("suffix", "options"),
    [("h5", {}), ("h5", {"compression": "gzip"}), ("json", {})],
    ids=["plain", "packed", "json"],
)
def test_damage_at_random_is_refused_or_loads_finite_poses_and_leaves_no_file_open(
    tmp_path, suffix, options
) -> None:
    whole = write(tmp_path / f"whole.{suffix}", made_push(samples=12), **options).read_bytes()
    path, before, outcome = tmp_path / f"{PUSH_NAME}.{suffix}", open_files(), {True: 0, False: 0}
    for seed in range(500):
        chance, damaged = random.Random(seed), bytearray(whole)
        for _ in range(chance.choice([1, 2, 8])):
            damaged[chance.randrange(len(damaged))] = chance.choice(
                [0, 255, *b"059", chance.randrange(256)]
            )
        path.write_bytes(damaged[: chance.choice([len(damaged), chance.randrange(len(damaged))])])
        try:
            push = read_push_file(path)
        except DataFileError as error:
            assert str(path) in str(error)
            outcome[False] += 1
        else:
            assert isinstance(push, PushRecord)
            assert np.isfinite([*push.start, *push.end, *push.displacement, push.turn]).all()
            assert not np.isinf(contact_force_ratio(push, RECT1))
            outcome[True] += 1
    assert outcome[True] > 10 and outcome[False] > 100 and open_files() == before


PUSH, SCAN = PushRecord(**made_push()), ScanRecord(*made_scan().values())


@pytest.mark.parametrize("suffix", [".h5", ".hdf5", ".json", ".H5"])
@pytest.mark.parametrize(
    ("name", "record", "tables"),
    [
        (PUSH_NAME, PUSH, ("object_pose", "tip_pose", "ft_wrench")),
        (SCAN_NAME, SCAN, ("tip", "ft_wrench")),
    ],
)
def test_what_is_written_is_read_back_to_the_last_bit(
    tmp_path, name, record, tables, suffix
) -> None:
    path = tmp_path / "new" / f"{name}{suffix}"
    size = write_push_file(path, record)
    assert size == path.stat().st_size > 0
    read = read_push_file(path)
    assert type(read) is type(record)
    for table in tables:
        assert np.array_equal(getattr(read, table), getattr(record, table))
        assert not getattr(read, table).flags.writeable
    assert [file.name for file in path.parent.iterdir()] == [path.name]
    # No file holds a date: runs can be compared byte by byte.
    write_push_file(tmp_path / f"again{suffix}", record)
    assert (tmp_path / f"again{suffix}").read_bytes() == path.read_bytes()


def test_a_file_is_replaced_and_as_readable_as_any_other(tmp_path) -> None:
    path, other = tmp_path / "push.json", tmp_path / "other"
    path.write_text("old")
    other.write_text("")
    write_push_file(path, PUSH)
    assert np.array_equal(read_push_file(path).object_pose, PUSH.object_pose)
    assert path.stat().st_mode == other.stat().st_mode


def test_what_cannot_be_written_is_told_by_name(tmp_path) -> None:
    refused(write_push_file, tmp_path / "push.csv", PUSH, told=r"'\.csv' is no suffix of push data")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "file").write_text("in the way")
    told = r"file/push\.h5 cannot be written \(File exists: .*file\)"
    refused(write_push_file, tmp_path / "file" / "push.h5", PUSH, told=told, kind=OSError)


@pytest.mark.parametrize("suffix", [".h5", ".json"])
def test_a_disk_that_is_full_leaves_the_old_file_and_nothing_else(tmp_path, suffix) -> None:
    """The system itself refuses to write beyond a limit: as a full disk does, in the middle of the
    file.
    """
    path = tmp_path / f"push{suffix}"
    write_push_file(path, PUSH)
    before = path.read_bytes()
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) // 2, limits[1]))
    told = r"cannot be written .*nothing was left half-written"
    try:
        refused(write_push_file, path, PUSH, told=told, kind=OSError)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, handler)
    assert list(tmp_path.iterdir()) == [path] and path.read_bytes() == before
