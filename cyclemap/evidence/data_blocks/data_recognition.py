"""What a file of measured data holds that can identify a surface, told by its header or its folder."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.data_blocks.wrench_twist_block import TWIST_COLUMNS, WRENCH_COLUMNS
from cyclemap.evidence.pushes.push_files import SUFFIXES
from cyclemap.evidence.pushes.push_table import CSV_SUFFIX
from cyclemap.text_files import read_csv_table

PUSH_ENDS, DRAG_BACKS, WRENCHES, CYCLES, RECORDS = "push ends", "drag-backs", "wrenches", "cycles", "records"

_START, _END = ({"x0", "y0", "th0"}, {"x1", "y1", "th1"})
_TIP = {"tip_x0", "tip_y0", "tip_x1", "tip_y1"}
_RESET = {"x0n", "y0n", "th0n"}
_ORIENTATIONS = ({"theta0_accum_deg"}, {"theta0_deg"})
LAYOUTS = (
    "files of the MIT layout (.h5, .json), or a CSV table with the columns of poses and tip "
    "(x0,y0,th0,x1,y1,th1,tip_x0,tip_y0,tip_x1,tip_y1), of drag-backs (x1,y1,th1,x0n,y0n,th0n), of orientations "
    "(theta0_deg), or of wrenches and twists (fx,fy,m_over_rho,vx,vy,w_times_rho)"
)


@dataclass(frozen=True)
class DataFile:
    """A CSV file, or a file or folder of the MIT layout, and the sort of data it holds."""

    path: Path
    sort: str


@dataclass(frozen=True)
class UnusedFile:
    """A file that tells nothing of a surface, and why."""

    path: Path
    reason: str


def recognise(path: str | Path) -> tuple[tuple[DataFile, ...], tuple[UnusedFile, ...]]:
    """Return what a file, folder or tree holds; a file may hold two sorts, files of no known kind are passed over.

    Raises InvalidInput where there is nothing at `path`.
    """
    place = Path(path)
    if not place.exists():
        raise InvalidInput(f"{place}: there is nothing there; give a file or a folder of data")
    if not place.is_dir():
        return _file(place)
    below = sorted(Path(folder, name) for folder, _, names in os.walk(place) for name in names)
    found: list[DataFile] = []
    unused: list[UnusedFile] = []
    if any(file.suffix.lower() in SUFFIXES for file in below):
        found.append(DataFile(place, RECORDS))
    for file in below:
        if file.suffix.lower() == CSV_SUFFIX:
            sorts, not_used = _file(file)
            found += sorts
            unused += not_used
    if not found and not unused:
        unused.append(UnusedFile(place, "the folder holds no .h5, .json or .csv file"))
    return tuple(found), tuple(unused)


def _file(path: Path) -> tuple[tuple[DataFile, ...], tuple[UnusedFile, ...]]:
    if path.suffix.lower() in SUFFIXES:
        return (DataFile(path, RECORDS),), ()
    if path.suffix.lower() != CSV_SUFFIX:
        return (), (UnusedFile(path, f"a file of another kind ({path.suffix or 'no suffix'})"),)
    try:
        header = read_csv_table(path).header
    except DataFileError as error:
        return (), (UnusedFile(path, str(error).removeprefix(f"{path}").lstrip(":, ")),)
    sorts = csv_sorts(header)
    if not sorts:
        return (), (UnusedFile(path, f"a CSV table of unknown columns ({', '.join(header[:8])})"),)
    return tuple(DataFile(path, sort) for sort in sorts), ()


def csv_sorts(header: tuple[str, ...]) -> tuple[str, ...]:
    """Return the sorts of data that a CSV header announces.

    >>> csv_sorts(("surface", "x1", "y1", "th1", "x0n", "y0n", "th0n"))
    ('drag-backs',)
    """
    columns, sorts = set(header), []
    if columns >= _START | _END | _TIP:
        sorts.append(PUSH_ENDS)
    if columns >= _END | _RESET:
        sorts.append(DRAG_BACKS)
    if columns >= {*WRENCH_COLUMNS, *TWIST_COLUMNS}:
        sorts.append(WRENCHES)
    if any(columns >= names for names in _ORIENTATIONS) or (not sorts and columns >= _START | _END):
        sorts.append(CYCLES)
    return tuple(sorts)
