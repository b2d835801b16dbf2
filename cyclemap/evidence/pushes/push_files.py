"""Files of the MIT layout, one of each recorded push or friction scan, HDF5 or JSON, and what each
tells as a row of a table.
"""

from __future__ import annotations

import json
import math
import zlib
from dataclasses import asdict, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cyclemap.arrays import Array
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.pushes.contact_forces import contact_force_ratio, scan_forces
from cyclemap.evidence.pushes.recordings import (
    PUSH_TABLES,
    PushFacts,
    PushRecord,
    ScanFacts,
    ScanRecord,
    push_facts,
    scan_facts,
)
from cyclemap.evidence.tables.columns import ENDS, RODS, Convention, Row
from cyclemap.evidence.tables.data_kinds import HDF5_SUFFIXES, SUFFIXES, TABLES, is_record
from cyclemap.mechanics.slider import MIT_SHAPE_NAMES, Slider
from cyclemap.text_files import LARGEST_CONTENT, read_json, write_whole

if TYPE_CHECKING:
    import h5py

# HDF5's numbers of the filters shuffle, gzip and fletcher32, in the only order that is read.
_FILTERS = (2, 1, 3)
_GZIP = 1
# A damaged file makes h5py raise any of these, and now and then others, from any of its calls.
_HDF5_FAULTS = (
    OSError,
    RuntimeError,
    ValueError,
    TypeError,
    LookupError,
    MemoryError,
    AttributeError,
    zlib.error,
)


def read_push_file(path: str | Path) -> PushRecord | ScanRecord:
    """Read one push (or, where its name or its tables say so, one friction scan) from a .h5, .hdf5
    or .json file.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    PushRecord or ScanRecord
        The recording, checked.

    Raises
    ------
    DataFileError
        Naming the file and the reason, where it is absent, cut short, damaged, lacks a table,
        has wrong columns, text or NaN among the numbers, or a clock that runs backwards; and,
        before anything is read, where it is no regular file, a table would take more than 16 MB
        as doubles, is packed otherwise than by gzip, or lies outside the file.

    Notes
    -----
    A push has the tables `object_pose`, `tip_pose` and `ft_wrench`, a scan `tip_array` (or
    `tip_pose`) and `ft_wrench`; see `PushRecord` for their columns. Any name will do, but scans
    (`record_...`) must be straight. Other tables are passed over. In JSON they are lists of
    rows.

    Examples
    --------
    >>> import json, pathlib, tempfile
    >>> from cyclemap.evidence import read_push_file
    >>> poses = [[0.0, 0.3, 0.0, 1.5], [0.1, 0.3, 0.05, 1.6]]
    >>> tables = {"object_pose": poses, "tip_pose": poses, "ft_wrench": poses}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     count = pathlib.Path(folder, "push.json").write_text(json.dumps(tables))
    ...     push = read_push_file(f"{folder}/push.json")
    >>> round(push.turn, 6), round(push.length, 6)
    (0.1, 0.05)
    """
    path = Path(path)
    try:
        is_scan = scan_facts(path) is not None
        # Scans that also turn the object may hold all tables of a push, yet are none.
        if path.name.startswith("record_") and not is_scan:
            raise InvalidInput(
                "its name begins as a friction scan's, but is not that of a straight one; leave "
                "it out"
            )
        tables = _tables(path)
        listed = ", ".join(sorted(tables)) or "none"
        if is_scan or ("object_pose" not in tables and "tip_array" in tables):
            tip = tables.get("tip_array", tables.get("tip_pose"))
            if tip is None or "ft_wrench" not in tables:
                raise InvalidInput(
                    f"a scan needs the tables tip_array and ft_wrench; the file has {listed}"
                )
            return ScanRecord(tip, tables["ft_wrench"])
        if missing := [name for name in PUSH_TABLES if name not in tables]:
            raise InvalidInput(f"table {', '.join(missing)} is missing; the file has {listed}")
        return PushRecord(*(tables[name] for name in PUSH_TABLES))
    except DataFileError:
        raise
    except InvalidInput as error:
        raise DataFileError(f"{path}: {error}") from error


def _tables(path: Path) -> dict[str, Any]:
    if not is_record(path):
        raise InvalidInput(
            f"'{path.suffix}' is no suffix of push data; it must be one of {', '.join(SUFFIXES)}, "
            "or a table's: .csv, .xlsx, .parquet, .jsonl"
        )
    # A pipe is no file either: opening one would wait for ever.
    if not path.is_file():
        raise InvalidInput("there is no such file; check the path")
    if path.stat().st_size == 0:
        raise InvalidInput("the file is empty; restore it or remove it")
    if path.suffix.lower() not in HDF5_SUFFIXES:
        content = read_json(path)
        if not isinstance(content, dict):
            raise InvalidInput(
                f"holds a {type(content).__name__}; it must be an object with the tables of a push"
            )
        return {name: content[name] for name in TABLES if name in content}
    import h5py

    try:
        with h5py.File(path, "r") as file:
            return {name: _hdf5_table(file, name) for name in TABLES if name in file}
    except InvalidInput:
        raise
    except PermissionError as error:
        raise InvalidInput("there is no permission to read it") from error
    except _HDF5_FAULTS as error:
        cause = (str(error).splitlines() or [type(error).__name__])[0][:200]
        raise InvalidInput(f"not a whole HDF5 file, cut short or damaged ({cause})") from error


def _hdf5_table(file: h5py.File, name: str) -> Array:
    import h5py

    if not isinstance(file.get(name, getlink=True), h5py.HardLink):
        raise InvalidInput(f"{name} is a link to elsewhere; it must be a table of this file")
    table = file[name]
    if not isinstance(table, h5py.Dataset) or table.is_virtual or table.external:
        raise InvalidInput(f"{name} is no table kept in this file itself")
    if table.ndim != 2 or table.shape[1] != 4 or table.dtype.kind not in "iuf":
        raise InvalidInput(
            f"{name} is of type {table.dtype} and shape {table.shape}; it must be numbers in 4 "
            "columns"
        )
    chunk = math.prod(table.chunks or (1,))
    stored = int(table.id.get_storage_size())
    if 8 * max(table.size, chunk) > LARGEST_CONTENT or stored > LARGEST_CONTENT:
        raise InvalidInput(
            f"{name} takes more than {LARGEST_CONTENT / 1e6:.0f} MB; no push is so long: split it"
        )
    # HDF5 reads what was never written as zeros: they would pass for poses.
    needed = math.prod(
        -(-length // part) for length, part in zip(table.shape, table.chunks or (1, 1), strict=True)
    )
    if stored == 0 or (table.chunks and table.id.get_num_chunks() < needed):
        raise InvalidInput(
            f"{name} has rows that are not in the file; restore the file or remove it"
        )
    if table.chunks:
        _refuse_false_packing(name, table, chunk * table.dtype.itemsize)
    return np.asarray(table[()])


def _refuse_false_packing(name: str, table: h5py.Dataset, room: int) -> None:
    """Raise InvalidInput where a chunk would unpack to more than its `room` (bytes): HDF5 unpacks
    whatever there is.
    """
    properties = table.id.get_create_plist()
    filters = [properties.get_filter(index)[0] for index in range(properties.get_nfilters())]
    if filters != [code for code in _FILTERS if code in filters]:
        raise InvalidInput(
            f"{name} is packed in a way that is not known; write it with gzip or without packing"
        )
    if _GZIP not in filters:
        return

    def false(chunk: h5py.h5d.StoreInfo) -> bool | None:
        """True ends the walk through the chunks."""
        if chunk.filter_mask & (1 << filters.index(_GZIP)):
            return None
        packed = table.id.read_direct_chunk(chunk.chunk_offset)[1]
        return True if len(zlib.decompressobj().decompress(packed, room + 1)) > room else None

    if table.id.chunk_iter(false):
        raise InvalidInput(f"{name} unpacks to more than its size; restore the file or remove it")


def write_push_file(path: str | Path, record: PushRecord | ScanRecord) -> int:
    """Write a push or a scan to `path` (.h5, .hdf5 or .json), making its folder; return the file's
    size in bytes.

    The tables are those that `read_push_file` reads, with their very numbers: HDF5 (compressed,
    without any date, so that equal records make equal files) or JSON (lists of rows). A file that
    was there is replaced.

    Raises InvalidInput for another suffix, OSError where the disk is full or the folder cannot be
    written; then, or when the process is killed, `path` is as it was before.
    """
    path = Path(path)
    if not is_record(path):
        raise InvalidInput(
            f"{path}: '{path.suffix}' is no suffix of push data; choose one of "
            f"{', '.join(SUFFIXES)}"
        )
    if isinstance(record, PushRecord):
        tables = {name: getattr(record, name) for name in PUSH_TABLES}
    else:
        tables = {"tip_array": record.tip, "ft_wrench": record.ft_wrench}
    if path.suffix.lower() in HDF5_SUFFIXES:
        import h5py

        # Made in memory: a full disk is then met by plain writing alone, which fails cleanly.
        with h5py.File("push", "w", driver="core", backing_store=False) as file:
            for name, rows in tables.items():
                file.create_dataset(
                    name, data=rows, chunks=rows.shape, compression="gzip", shuffle=True
                )
            file.flush()
            content = bytes(file.id.get_file_image())
    else:
        content = json.dumps(
            {name: rows.tolist() for name, rows in tables.items()}, allow_nan=False
        ).encode()
    write_whole(path, content)
    return len(content)


# -- as rows of a table


def push_row(path: Path, record: PushRecord) -> Row:
    """Return what a push and the name of its file tell, as a row of `PushTable.table`."""
    facts = push_facts(path) or PushFacts()
    outline = _mit_outline(facts.object)
    tips = record.tip_pose[[0, -1], 1:3].ravel().tolist()
    dx, dy = record.displacement
    return {
        **asdict(facts),
        **dict(zip((*RODS, *ENDS), (*tips, *record.start, *record.end), strict=True)),
        "dx": dx,
        "dy": dy,
        "dtheta": record.turn,
        "length": record.length,
        "force_ratio": math.nan if outline is None else contact_force_ratio(record, outline),
        "samples": len(record.object_pose),
        "path": str(path),
    }


def scan_row(path: Path, record: ScanRecord, convention: Convention) -> Row:
    """Return what a friction scan and the name of its file tell, as a row of `PushTable.scans`;
    convention : in which it was written.
    """
    along, across = scan_forces(record)
    facts = scan_facts(path) or ScanFacts()
    if not convention.is_ours:
        facts = replace(facts, direction=convention.direction(facts.direction))
    return {
        **asdict(facts),
        "force_along": along,
        "force_across": across,
        "ratio": across / along if along else math.nan,
        "samples": len(record.ft_wrench),
        "path": str(path),
    }


@cache
def _mit_outline(name: str | None) -> Array | None:
    """The closed outline of an MIT shape as a polyline, m; None for any other object."""
    return Slider.mit(name).outline_points(360) if name in MIT_SHAPE_NAMES else None
