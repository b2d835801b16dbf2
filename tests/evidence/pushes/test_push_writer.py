"""Files of push data are written whole or not at all, and hold the very numbers."""

import resource
import signal

import numpy as np
import pytest
from made_pushes import PUSH_NAME, SCAN_NAME, made_push, made_scan

from cyclemap.errors import InvalidInput
from cyclemap.evidence.pushes.push_files import PushRecord, ScanRecord, read_push_file, record_tables, write_push_file

PUSH = PushRecord.from_tables(made_push())
SCAN = ScanRecord.from_tables(made_scan())


@pytest.mark.parametrize("suffix", [".h5", ".hdf5", ".json", ".H5"])
@pytest.mark.parametrize(("name", "record"), [(PUSH_NAME, PUSH), (SCAN_NAME, SCAN)])
def test_what_is_written_is_read_back_to_the_last_bit(tmp_path, name, record, suffix) -> None:
    path = tmp_path / "new" / f"{name}{suffix}"
    size = write_push_file(path, record)
    assert size == path.stat().st_size > 0
    read = read_push_file(path)
    assert type(read) is type(record)
    for table, rows in record_tables(record).items():
        assert np.array_equal(record_tables(read)[table], rows)
    assert [file.name for file in path.parent.iterdir()] == [path.name]


def test_equal_records_make_equal_files(tmp_path) -> None:
    """A file holds no date: runs can be compared byte by byte."""
    for name in ("a.h5", "b.h5"):
        write_push_file(tmp_path / name, PUSH)
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


def test_a_file_is_replaced_and_as_readable_as_any_other(tmp_path) -> None:
    path, other = tmp_path / "push.json", tmp_path / "other"
    path.write_text("old")
    other.write_text("")
    write_push_file(path, PUSH)
    assert read_push_file(path).samples == PUSH.samples
    assert path.stat().st_mode == other.stat().st_mode


def test_a_kind_of_file_that_no_reader_knows_is_refused(tmp_path) -> None:
    with pytest.raises(InvalidInput, match=r"'\.csv' is no suffix of push data"):
        write_push_file(tmp_path / "push.csv", PUSH)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_made_is_told_by_name(tmp_path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(OSError, match=r"file/push\.h5 cannot be written \(File exists: .*file\)"):
        write_push_file(tmp_path / "file" / "push.h5", PUSH)


@pytest.mark.parametrize("suffix", [".h5", ".json"])
def test_a_disk_that_is_full_leaves_the_old_file_and_nothing_else(tmp_path, suffix) -> None:
    """The system itself refuses to write beyond a limit: as a full disk does, in the middle of the file."""
    path = tmp_path / f"push{suffix}"
    write_push_file(path, PUSH)
    before = path.read_bytes()
    limits, handler = resource.getrlimit(resource.RLIMIT_FSIZE), signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) // 2, limits[1]))
    try:
        with pytest.raises(OSError, match=r"cannot be written .*nothing was left half-written"):
            write_push_file(path, PUSH)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, handler)
    assert list(tmp_path.iterdir()) == [path]
    assert path.read_bytes() == before
