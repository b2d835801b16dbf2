"""Writing one push or friction scan in the MIT layout: the file is there whole, or not at all."""

from __future__ import annotations

import json
from pathlib import Path

from cyclemap.arrays import Array
from cyclemap.errors import InvalidInput
from cyclemap.evidence.pushes.push_files import HDF5_SUFFIXES, SUFFIXES
from cyclemap.evidence.pushes.push_record import PUSH_TABLES, PushRecord, ScanRecord
from cyclemap.whole_files import write_whole

SCAN_TABLES = ("tip_array", "ft_wrench")


def write_push_file(path: str | Path, record: PushRecord | ScanRecord) -> int:
    """Write a push or a scan to `path` (.h5, .hdf5 or .json), making its folder; return the file's size in bytes.

    The tables are those that `read_push_file` reads, with their very numbers: HDF5 (compressed, without any date, so
    that equal records make equal files) or JSON (lists of rows). A file that was there is replaced.

    Raises InvalidInput for another suffix, OSError where the disk is full or the folder cannot be written; then, or
    when the process is killed, `path` is as it was before.

    >>> import tempfile
    >>> from cyclemap.evidence.pushes.push_files import read_push_file
    >>> poses = [[0.0, 0.1, 0.0, 3.1], [0.1, 0.1, 0.2, -3.1]]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = write_push_file(f"{folder}/push.h5", PushRecord(poses, poses, [[0.0, 0.0, 1.0, 0.0]]))
    ...     read_push_file(f"{folder}/push.h5").end
    (0.1, 0.2, 3.183185307179586)
    """
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise InvalidInput(f"{path}: '{path.suffix}' is no suffix of push data; choose one of {', '.join(SUFFIXES)}")
    tables = record_tables(record)
    content = _hdf5(tables) if path.suffix.lower() in HDF5_SUFFIXES else _json(tables)
    write_whole(path, content)
    return len(content)


def record_tables(record: PushRecord | ScanRecord) -> dict[str, Array]:
    """The tables of a record by their names in the files; a scan's tip is in `tip_array`."""
    if isinstance(record, PushRecord):
        return {name: getattr(record, name) for name in PUSH_TABLES}
    return dict(zip(SCAN_TABLES, (record.tip, record.ft_wrench), strict=True))


def _hdf5(tables: dict[str, Array]) -> bytes:
    """An HDF5 file made in memory: a full disk is then met by plain writing alone, which fails cleanly."""
    import h5py

    with h5py.File("push", "w", driver="core", backing_store=False) as file:
        for name, rows in tables.items():
            file.create_dataset(name, data=rows, chunks=rows.shape, compression="gzip", shuffle=True)
        file.flush()
        return bytes(file.id.get_file_image())


def _json(tables: dict[str, Array]) -> bytes:
    return json.dumps({name: rows.tolist() for name, rows in tables.items()}, allow_nan=False).encode()
