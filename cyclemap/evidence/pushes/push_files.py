"""Reading one .h5 or .json file of the MIT layout: its tables, refused where the file is damaged or lies."""

from __future__ import annotations

import math
import zlib
from pathlib import Path
from typing import Any

from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.pushes.mit_names import scan_facts
from cyclemap.evidence.pushes.push_record import PushRecord, ScanRecord
from cyclemap.text_files import LARGEST_CONTENT, read_json

TABLES = ("object_pose", "tip_pose", "tip_array", "ft_wrench")
HDF5_SUFFIXES = (".h5", ".hdf5")
SUFFIXES = (*HDF5_SUFFIXES, ".json")

# HDF5's numbers of the filters shuffle, gzip and fletcher32, in the only order that is read.
_FILTERS = (2, 1, 3)
_GZIP = 1


def read_push_file(path: str | Path) -> PushRecord | ScanRecord:
    """Read one push (or, where its name or its tables say so, one friction scan) from a .h5, .hdf5 or .json file.

    A push has the tables `object_pose`, `tip_pose` and `ft_wrench`, a scan `tip_array` (or `tip_pose`) and
    `ft_wrench`; see `PushRecord` for their columns. Any name will do, but scans (`record_...`) must be straight.
    Other tables are passed over. In JSON they are lists of rows.

    Raises DataFileError, naming the file and the reason, where it is absent, cut short, damaged, lacks a table,
    has wrong columns, text or NaN among the numbers, or a clock that runs backwards; and, before anything is read,
    where it is no regular file, a table would take more than 16 MB as doubles, is packed otherwise than by gzip, or
    lies outside the file.
    """
    path = Path(path)
    try:
        _refuse_other_scans(path)
        tables = _tables(path)
        if scan_facts(path) is not None or ("object_pose" not in tables and "tip_array" in tables):
            return ScanRecord.from_tables(tables)
        return PushRecord.from_tables(tables)
    except DataFileError:
        raise
    except InvalidInput as error:
        raise DataFileError(f"{path}: {error}") from error


def _refuse_other_scans(path: Path) -> None:
    """Scans that also turn the object may hold all tables of a push, yet are none."""
    if path.name.startswith("record_") and scan_facts(path) is None:
        raise InvalidInput("its name begins as a friction scan's, but is not that of a straight one; leave it out")


def _tables(path: Path) -> dict[str, Any]:
    if path.suffix.lower() not in SUFFIXES:
        raise InvalidInput(f"'{path.suffix}' is no suffix of push data; it must be one of {', '.join(SUFFIXES)}")
    # A pipe is no file either: opening one would wait for ever.
    if not path.is_file():
        raise InvalidInput("there is no such file; check the path")
    if path.stat().st_size == 0:
        raise InvalidInput("the file is empty; restore it or remove it")
    return _json_tables(path) if path.suffix.lower() == ".json" else _hdf5_tables(path)


def _json_tables(path: Path) -> dict[str, Any]:
    content = read_json(path)
    if not isinstance(content, dict):
        raise InvalidInput(f"holds a {type(content).__name__}; it must be an object with the tables of a push")
    return {name: content[name] for name in TABLES if name in content}


def _hdf5_tables(path: Path) -> dict[str, Any]:
    import h5py

    try:
        with h5py.File(path, "r") as file:
            return {name: _hdf5_table(file, name) for name in TABLES if name in file}
    except InvalidInput:
        raise
    except PermissionError as error:
        raise InvalidInput("there is no permission to read it") from error
    # A damaged file makes h5py raise any of these, and now and then others, from any of its calls.
    except (
        OSError,
        RuntimeError,
        ValueError,
        TypeError,
        KeyError,
        LookupError,
        MemoryError,
        AttributeError,
        zlib.error,
    ) as error:
        raise InvalidInput(f"not a whole HDF5 file, cut short or damaged ({_first_line(error)})") from error


def _hdf5_table(file: Any, name: str) -> Any:
    import h5py

    if not isinstance(file.get(name, getlink=True), h5py.HardLink):
        raise InvalidInput(f"{name} is a link to elsewhere; it must be a table of this file")
    table = file[name]
    if not isinstance(table, h5py.Dataset) or table.is_virtual or table.external:
        raise InvalidInput(f"{name} is no table kept in this file itself")
    if table.ndim != 2 or table.shape[1] != 4 or table.dtype.kind not in "iuf":
        raise InvalidInput(f"{name} is of type {table.dtype} and shape {table.shape}; it must be numbers in 4 columns")
    _refuse_false_size(name, table)
    return table[()]


def _refuse_false_size(name: str, table: Any) -> None:
    """Raise InvalidInput where a table is larger than any push's, or not in its file as it claims to be."""
    chunk, stored = math.prod(table.chunks or (1,)), int(table.id.get_storage_size())
    if 8 * max(table.size, chunk) > LARGEST_CONTENT or stored > LARGEST_CONTENT:
        raise InvalidInput(f"{name} takes more than {LARGEST_CONTENT / 1e6:.0f} MB; no push is so long: split it")
    # HDF5 reads what was never written as zeros: they would pass for poses.
    if stored == 0 or (table.chunks and table.id.get_num_chunks() < _chunks_needed(table)):
        raise InvalidInput(f"{name} has rows that are not in the file; restore the file or remove it")
    if table.chunks:
        _refuse_false_packing(name, table, chunk * table.dtype.itemsize)


def _refuse_false_packing(name: str, table: Any, room: int) -> None:
    """Raise InvalidInput where a chunk would unpack to more than its `room` (bytes): HDF5 unpacks whatever there is."""
    properties = table.id.get_create_plist()
    filters = [properties.get_filter(number)[0] for number in range(properties.get_nfilters())]
    if filters != [code for code in _FILTERS if code in filters]:
        raise InvalidInput(f"{name} is packed in a way that is not known; write it with gzip or without packing")
    if _GZIP not in filters:
        return
    skipped, faults = 1 << filters.index(_GZIP), []

    def check(chunk: Any) -> None:
        if not chunk.filter_mask & skipped:
            packed = table.id.read_direct_chunk(chunk.chunk_offset)[1]
            faults.extend([chunk] if len(zlib.decompressobj().decompress(packed, room + 1)) > room else [])

    table.id.chunk_iter(check)
    if faults:
        raise InvalidInput(f"{name} unpacks to more than its size; restore the file or remove it")


def _chunks_needed(table: Any) -> int:
    return math.prod(-(-length // chunk) for length, chunk in zip(table.shape, table.chunks, strict=True))


def _first_line(error: BaseException) -> str:
    lines = str(error).splitlines()
    return lines[0][:200] if lines else type(error).__name__
