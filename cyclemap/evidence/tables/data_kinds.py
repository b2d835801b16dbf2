"""What a file of measured data is, by its name and its first lines: the one place that decides it.

Whoever is given data asks `file_kind`; what the rows of a table of ours tell, `sorts_of_rows`.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from enum import Enum
from itertools import islice
from pathlib import Path

from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.tables.columns import (
    COLUMNS,
    DRAG_ENDS,
    ENDS,
    PLACES,
    RODS,
    TWIST_COLUMNS,
    WRENCH_COLUMNS,
    our_names,
)
from cyclemap.evidence.tables.meaning import has_unit
from cyclemap.evidence.tables.own_files import (
    BAG_INFO,
    BAGS,
    EXCEL,
    JSON_LINES,
    LEROBOT_INFO,
    PARQUET,
    raw_columns,
)
from cyclemap.evidence.tables.planned_table import PLANNED
from cyclemap.plain_text import json_value
from cyclemap.text_files import CsvTable, read_csv_table, read_text

HDF5_SUFFIXES = (".h5", ".hdf5")
# Of recorded pushes and friction scans, and the tables in them.
SUFFIXES = (*HDF5_SUFFIXES, ".json")
TABLES = ("object_pose", "tip_pose", "ft_wrench", "tip_array")
CSV_SUFFIX = ".csv"
TEXTS = (CSV_SUFFIX, ".tsv", ".txt", ".dat")
# Columns by which a table is known to be one of ours; else all of its columns have to be.
_OURS = ({"theta0_accum_deg"}, {"x1", "y1", "x0n", "y0n"}, {"fx", "fy", "vx", "vy"})
_ORIENTATIONS = {"theta0_deg", "theta_next_deg", "flag"}
_LONGEST_LINE = 100_000


def is_csv(path: str | Path) -> bool:
    """Return whether a name is that of a CSV table."""
    return Path(path).suffix.lower() == CSV_SUFFIX


def is_record(path: Path) -> bool:
    """Return whether a name may be that of a recorded push or friction scan."""
    return path.suffix.lower() in SUFFIXES


class FileKind(Enum):
    """What a file, or a folder, is."""

    PLANNED = "a table of planned pushes, filled in or not"
    OURS = "a CSV table under our names, those of the MIT dataset among them"
    OTHER = "a table, a stream of poses, a bag or a data set under names of its own"
    RECORDS = "recorded pushes and friction scans in the MIT layout, or a folder of such files"
    UNKNOWN = "nothing of that, or not there"


def file_kind(path: str | Path) -> FileKind:
    """Return what a file or a folder is."""
    place = Path(path)
    suffix = place.suffix.lower()
    if place.is_dir():
        is_other = (place / LEROBOT_INFO).is_file() or (place / BAG_INFO).is_file()
        return FileKind.OTHER if is_other else FileKind.RECORDS
    if suffix in EXCEL and _is_planned_sheet(place):
        return FileKind.PLANNED
    if suffix in (*EXCEL, *PARQUET, *BAGS, *JSON_LINES):
        return FileKind.OTHER
    if suffix == ".json" and place.is_file() and _has_rows(place):
        return FileKind.OTHER
    if is_record(place):
        return FileKind.RECORDS
    return _kind_of_text(place) if suffix in TEXTS else FileKind.UNKNOWN


def _is_planned_sheet(place: Path) -> bool:
    try:
        return set(raw_columns(place, {}, growing=False)) >= PLANNED
    except DataFileError:
        return False


def _has_rows(place: Path) -> bool:
    """Whether a JSON file has rows of numbers, and not the tables of a push."""
    try:
        text = read_text(place, "JSON")
    except DataFileError:
        return False
    for start in (text, text.partition("\n")[0]):
        try:
            content = json_value(start)
        except ValueError:
            continue
        return not isinstance(content, dict) or not set(content) & set(TABLES)
    return False


def _kind_of_text(place: Path) -> FileKind:
    """What a text is, by its header and the line below."""
    header, first = _first_lines(place)
    # Whatever parts its names.
    if is_csv(place) and all(name in header for name in PLANNED):
        return FileKind.PLANNED
    # A header that is still being written tells nothing.
    if not header.endswith("\n"):
        return FileKind.UNKNOWN
    if _are_ours(_names_in(header)) and not any(map(has_unit, first.split(","))):
        return FileKind.OURS
    return FileKind.OTHER


def _first_lines(place: Path) -> tuple[str, str]:
    """The first two lines of a text that are not blank."""
    if not place.is_file():
        return "", ""
    with place.open(encoding="utf-8-sig", errors="replace") as file:
        lines = iter(lambda: file.readline(_LONGEST_LINE), "")
        first, second, *_ = [*islice(filter(str.strip, lines), 2), "", ""]
        return first, second


def _names_in(header: str) -> set[str]:
    return {name.strip().strip('"') for name in header.lower().split(",")}


def _are_ours(names: set[str]) -> bool:
    """Whether readers of our own tables take all that a header of these names tells."""
    if any(names >= wanted for wanted in _OURS):
        return True
    if not names >= PLACES:
        return "theta0_deg" in names and names <= _ORIENTATIONS
    if names >= {*RODS, "th0", "th1"}:
        return True
    known = {name for column in COLUMNS.values() for name in column.names}
    return names <= known and {*ENDS} <= {*our_names(names)}


# -- what the rows of a table of ours tell

PUSH_ENDS = "push ends"
DRAG_BACKS = "drag-backs"
WRENCHES = "wrenches"
CYCLES = "cycles"
RECORDS = "records"
SORT_COLUMNS = {
    PUSH_ENDS: (*ENDS, *RODS),
    DRAG_BACKS: DRAG_ENDS,
    WRENCHES: (*WRENCH_COLUMNS, *TWIST_COLUMNS),
}


def sorts_of_rows(header: Collection[str]) -> list[str]:
    """Return the sorts of data that rows below a header of ours tell: of poses without a rod's
    places, and of orientations alone, cycles.
    """
    known = {*our_names(header)}
    sorts = [sort for sort, wanted in SORT_COLUMNS.items() if known >= {*wanted}]
    posed = not sorts and known >= {*ENDS}
    if posed or {"theta0_accum_deg", "theta0_deg"} & {*header}:
        sorts.append(CYCLES)
    return sorts


@dataclass(frozen=True, eq=False)
class DataFile:
    """A file of data, or a folder in the MIT layout, and the sort of data that is taken of it.

    table : what a CSV file holds.
    """

    path: Path
    sort: str
    table: CsvTable | None = None


def files_of_data(path: str | Path) -> list[Path]:
    """Return what is looked at of a file, folder or tree: each CSV table, and the folder itself
    where it has files of the MIT layout, or nothing.

    Raises InvalidInput where there is nothing at `path`.
    """
    place = Path(path)
    if not place.exists():
        raise InvalidInput(f"{place}: there is nothing there; give a file or a folder of data")
    if not place.is_dir():
        return [place]
    below = sorted(place.rglob("*"))
    tables = [file for file in below if is_csv(file)]
    has_records = any(is_record(file) for file in below)
    return [place, *tables] if has_records or not tables else tables


def recognise(place: Path) -> list[DataFile]:
    """Return a CSV table once for each sort of data that it holds, a file or a folder of the MIT
    layout once; DataFileError, saying why, where it is neither.
    """
    if is_csv(place) and not place.is_dir():
        table = read_csv_table(place)
        sorts = sorts_of_rows(table.header)
        if not sorts:
            header = ", ".join(table.header[:8])
            raise DataFileError(f"{place}: a CSV table of unknown columns ({header})")
        return [DataFile(place, sort, table) for sort in sorts]
    files = place.rglob("*") if place.is_dir() else [place]
    if any(is_record(file) for file in files):
        return [DataFile(place, RECORDS)]
    if place.is_dir():
        raise DataFileError(f"{place}: the folder holds no .h5, .json or .csv file")
    raise DataFileError(f"{place}: a file of another kind ({place.suffix or 'no suffix'})")


def tells_orientations_alone(path: Path) -> bool:
    """Return whether a file is a CSV table without poses."""
    is_table = is_csv(path) and not path.is_dir()
    return is_table and not _names_in(_first_lines(path)[0]) >= {"x0", "x1"}


def tells_radians_alone(path: Path) -> bool:
    """Return whether a file is a CSV table of poses before pushes, by our names, and has no θ0 in
    degrees.
    """
    if not is_csv(path) or not path.is_file():
        return False
    names = _names_in(_first_lines(path)[0])
    degrees = {"theta0_deg", "theta0_accum_deg"}
    return names >= {"x0", "y0"} and bool({"theta0", "th0"} & names) and not degrees & names
