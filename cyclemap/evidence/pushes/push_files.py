"""Reading one .h5 or .json file of the MIT layout: its tables, refused where the file is damaged or lies."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.pushes.mit_names import scan_facts
from cyclemap.evidence.pushes.push_record import PushRecord, ScanRecord

TABLES = ("object_pose", "tip_pose", "tip_array", "ft_wrench")
HDF5_SUFFIXES = (".h5", ".hdf5")
SUFFIXES = (*HDF5_SUFFIXES, ".json")

# Deflate packs at most about 1032 bytes into one (zlib, technical details): a table that claims more is not there.
_LARGEST_PACKING = 1032
# A day of 250 Hz is under 700 MB; one push is a thousandth of this.
LARGEST_TABLE = 2**28


def read_push_file(path: str | Path) -> PushRecord | ScanRecord:
    """Read one push (or, where its name or its tables say so, one friction scan) from a .h5, .hdf5 or .json file.

    A push has the tables `object_pose`, `tip_pose` and `ft_wrench`, a scan `tip_array` (or `tip_pose`) and
    `ft_wrench`; see `PushRecord` for their columns. Any name will do, but scans (`record_...`) must be straight.
    Other tables are passed over. In JSON they are lists of rows.

    Raises DataFileError, naming the file and the reason, where it is absent, cut short, damaged, lacks a table,
    has wrong columns, text or NaN among the numbers, or a clock that runs backwards; and, before anything is read,
    where a table claims more than its file can hold (over 1032 times its size, or 256 MB) or lies outside the file.
    """
    path = Path(path)
    try:
        _refuse_other_scans(path)
        tables = _tables(path)
        if scan_facts(path) is not None or ("object_pose" not in tables and "tip_array" in tables):
            return ScanRecord.from_tables(tables)
        return PushRecord.from_tables(tables)
    except InvalidInput as error:
        raise DataFileError(f"{path}: {error}") from error


def _refuse_other_scans(path: Path) -> None:
    """Scans that also turn the object may hold all tables of a push, yet are none."""
    if path.name.startswith("record_") and scan_facts(path) is None:
        raise InvalidInput("its name begins as a friction scan's, but is not that of a straight one; leave it out")


def _tables(path: Path) -> dict[str, Any]:
    reader: Callable[[Path, int], dict[str, Any]] = _json_tables if path.suffix.lower() == ".json" else _hdf5_tables
    if path.suffix.lower() not in SUFFIXES:
        raise InvalidInput(f"'{path.suffix}' is no suffix of push data; it must be one of {', '.join(SUFFIXES)}")
    # A pipe is no file either: opening one would wait for ever.
    if not path.is_file():
        raise InvalidInput("there is no such file; check the path")
    size = path.stat().st_size
    if size == 0:
        raise InvalidInput("the file is empty; restore it or remove it")
    try:
        return reader(path, size)
    except PermissionError as error:
        raise InvalidInput("there is no permission to read it") from error


def _json_tables(path: Path, size: int) -> dict[str, Any]:
    if size > LARGEST_TABLE:
        raise InvalidInput(f"{size / 1e6:.0f} MB is too large for one push in JSON; split it or write HDF5")
    try:
        content = json.loads(path.read_bytes())
    except json.JSONDecodeError as error:
        place = f"{error.msg} at line {error.lineno}, column {error.colno}"
        raise InvalidInput(f"not JSON, or cut short: {place}") from error
    except (ValueError, RecursionError) as error:
        raise InvalidInput(f"not JSON of push data: {error}") from error
    if not isinstance(content, dict):
        raise InvalidInput(f"holds a {type(content).__name__}; it must be an object with the tables of a push")
    return {name: content[name] for name in TABLES if name in content}


def _hdf5_tables(path: Path, size: int) -> dict[str, Any]:
    import h5py

    try:
        with h5py.File(path, "r") as file:
            return {name: _hdf5_table(file, name, size) for name in TABLES if name in file}
    except (PermissionError, InvalidInput):
        raise
    # A damaged file makes h5py raise any of these, and now and then others, from any of its calls.
    except (OSError, RuntimeError, ValueError, TypeError, KeyError, LookupError, MemoryError, AttributeError) as error:
        raise InvalidInput(f"not a whole HDF5 file, cut short or damaged ({_first_line(error)})") from error


def _hdf5_table(file: Any, name: str, size: int) -> Any:
    import h5py

    if not isinstance(file.get(name, getlink=True), h5py.HardLink):
        raise InvalidInput(f"{name} is a link to elsewhere; it must be a table of this file")
    table = file[name]
    if not isinstance(table, h5py.Dataset) or table.is_virtual or table.external:
        raise InvalidInput(f"{name} is no table kept in this file itself")
    if table.ndim != 2 or table.shape[1] != 4 or table.dtype.kind not in "iuf":
        raise InvalidInput(f"{name} is of type {table.dtype} and shape {table.shape}; it must be numbers in 4 columns")
    _refuse_false_size(name, table, size)
    return table[()]


def _refuse_false_size(name: str, table: Any, size: int) -> None:
    """Raise InvalidInput where a table, or one of its chunks, does not fit its file."""
    chunk = table.dtype.itemsize * math.prod(table.chunks or (1,))
    claimed, stored = max(int(table.nbytes), chunk), int(table.id.get_storage_size())
    if claimed > min(size * (_LARGEST_PACKING if table.chunks else 1), LARGEST_TABLE) or stored > size:
        raise InvalidInput(f"{name} claims {max(claimed, stored)} bytes, which a file of {size} bytes cannot hold")
    # HDF5 reads what was never written as zeros: they would pass for poses.
    if stored == 0 or (table.chunks and table.id.get_num_chunks() < _chunks_needed(table)):
        raise InvalidInput(f"{name} has rows that are not in the file; restore the file or remove it")


def _chunks_needed(table: Any) -> int:
    return math.prod(-(-length // chunk) for length, chunk in zip(table.shape, table.chunks, strict=True))


def _first_line(error: BaseException) -> str:
    lines = str(error).splitlines()
    return lines[0][:200] if lines else type(error).__name__
