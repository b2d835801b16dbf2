"""A collection of pushes as one table: a file, a folder or a tree of the MIT layout, or CSV, bad
files reported.
"""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import shorter_way
from cyclemap.errors import DataFileError, DoubtfulInput, InvalidInput
from cyclemap.evidence.pushes.contact_forces import contact_force_ratio, scan_forces
from cyclemap.evidence.pushes.conventions import OURS, Convention, convention_of, written_convention
from cyclemap.evidence.pushes.mit_names import PushFacts, ScanFacts, push_facts, scan_facts
from cyclemap.evidence.pushes.push_files import (
    LARGEST_ANGLE,
    LARGEST_POSITION,
    SUFFIXES,
    PushRecord,
    read_push_file,
)
from cyclemap.evidence.pushes.theta0_pairs import doubt_degrees, read_theta0_pairs
from cyclemap.mechanics.slider import MIT_SHAPE_NAMES, Pose, Slider
from cyclemap.text_files import LARGEST_CONTENT, CsvRow, CsvTable, read_csv_table

if TYPE_CHECKING:
    import pandas

# A column of the push table, the names it goes by in a file, and the factor to SI units; None: a
# text.
COLUMN_NAMES: dict[str, dict[str, float | None]] = {
    "surface": {"surface": None},
    "object": {"object": None, "shape": None},
    "acceleration": {"acceleration": 1.0, "a_mm_s2": 1e-3},
    "speed": {"speed": 1.0, "v_mm_s": 1e-3},
    "side": {"side": 1.0, "i": 1.0},
    "fraction": {"fraction": 1.0, "s": 1.0},
    "angle": {"angle": 1.0, "t": 1.0},
    "repetition": {"repetition": 1.0, "rep": 1.0},
    "length": {"length": 1.0, "push_mm": 1e-3},
    **{
        name: {name: 1.0}
        for name in ("tip_x0", "tip_y0", "tip_x1", "tip_y1", "x0", "y0", "x1", "y1")
    },
    **{name: {name: 1.0} for name in ("dtheta", "force_ratio")},
    "theta0": {"theta0": 1.0, "th0": 1.0, "theta0_deg": math.pi / 180.0},
    "theta1": {"theta1": 1.0, "th1": 1.0, "theta1_deg": math.pi / 180.0},
    "theta_next": {"theta_next": 1.0, "th0n": 1.0},
}
ENDS = ("x0", "y0", "theta0", "x1", "y1", "theta1")
_RODS = ("tip_x0", "tip_y0", "tip_x1", "tip_y1")
# As a table of twenty columns they are as large as any file may be.
_MOST_PUSHES = LARGEST_CONTENT // 8 // 20
# What stands in a field without a number; the share of rows that may have no pose; m, beyond which
# no push goes.
_NOTHING, _MOST_LOST, _LONGEST_PUSH = ("", "nan", "na", "null", "none"), 0.5, 3.0
SET_FACTS = ("surface", "object", "acceleration", "speed", "side", "fraction", "angle")
_POSES = ("tip_x0", "tip_y0", "tip_x1", "tip_y1", *ENDS, "dx", "dy", "dtheta")
PUSH_COLUMNS = (
    *SET_FACTS,
    "repetition",
    "length",
    *_POSES,
    "theta_next",
    "force_ratio",
    "samples",
    "path",
)
_SCAN_ORDER = ("surface", "object", "acceleration", "speed", "direction", "repetition")
SCAN_COLUMNS = (*_SCAN_ORDER, "force_along", "force_across", "ratio", "samples", "path")
CSV_SUFFIX = ".csv"
_TEXT = ("surface", "object", "path")


def named_column(table: CsvTable, column: str) -> str | None:
    """The first of the names of a column of the push table that a file's header has;
    None without."""
    return next((name for name in COLUMN_NAMES[column] if name in table.header), None)


def column_value(table: CsvTable, row: CsvRow, column: str) -> Any:
    """What a row of a file tells for a column of the push table, SI units; NaN, of texts None,
    where it does not.
    """
    name = named_column(table, column)
    text = table.text(row, name) if name is not None else ""
    factor = (
        COLUMN_NAMES[column][name]
        if name is not None
        else next(iter(COLUMN_NAMES[column].values()))
    )
    if factor is None:
        return text or None
    return factor * table.number(row, name) if name is not None and text else math.nan


def read_push_csv(path: str | Path, convention: Convention = OURS) -> list[dict[str, Any]]:
    """Read a CSV file of pushes: a list of rows with the columns of `PushTable.table`, in the order
    of the file.

    A table of poses has a header with `x0,y0,theta0,x1,y1,theta1` (m, rad; also `th0`, `th1`,
    `theta0_deg`, `theta1_deg`); it may have `surface`, `object` (or `shape`), `acceleration`
    (`a_mm_s2`), `speed` (`v_mm_s`), `side` (`i`), `fraction` (`s`), `angle` (`t`), `repetition`
    (`rep`), `dtheta`, `theta_next` (`th0n`), `force_ratio`, and how far the rod moved: `length`
    (`push_mm`), or its places `tip_x0,tip_y0,tip_x1,tip_y1` (m). Columns of other names are passed
    over. What is absent or empty is NaN; `dtheta` is then the shorter way round, for two poses
    cannot tell more. `theta_next` is put on the lift nearest to theta1.

    Any other table is read by `read_theta0_pairs`: a row a pair, with theta0 and theta_next alone
    (and its `rep`, where the file has it).

    convention : of the file's angles and axes. DataFileError names the file, the line and the mend.
    """
    table = convention.table(read_csv_table(path))
    if len(table.rows) > _MOST_PUSHES:
        raise DataFileError(f"{table.path}: holds more than {_MOST_PUSHES} pushes; split it")
    unknown = asdict(PushFacts()) | {"samples": 0, "path": str(table.path)}
    if all(named_column(table, column) for column in ENDS):
        doubt_degrees(
            table, [name for name in ("theta0_deg", "theta1_deg") if name in table.header]
        )
        return [unknown | _pose_row(table, row) for row in _posed_rows(table)]
    pairs = read_theta0_pairs(table.path, convention=convention)
    number = pairs.cycle if "theta0_accum_deg" in table.header else None
    numbers = np.full(pairs.theta.size, math.nan) if number is None else number
    columns = zip(numbers.tolist(), pairs.theta.tolist(), pairs.theta_next.tolist(), strict=True)
    return [
        unknown | {"repetition": rep, "theta0": now, "theta_next": later}
        for rep, now, later in columns
    ]


def _posed_rows(table: CsvTable) -> list[CsvRow]:
    """The rows that have both poses; those without are warned of."""
    names = [named_column(table, column) or "" for column in ENDS]
    lost = [
        row
        for row in table.rows
        if any(table.text(row, name).lower() in _NOTHING for name in names)
    ]
    if not lost:
        return list(table.rows)
    if len(lost) >= _MOST_LOST * len(table.rows):
        name, text = next(
            (name, table.text(lost[0], name))
            for name in names
            if table.text(lost[0], name).lower() in _NOTHING
        )
        told = (
            f"{name} is '{text}'; it must be a number, and {len(lost)} of {len(table.rows)} "
            "rows lack one"
        )
        raise table.error(lost[0].line, told)
    told = (
        f"{table.path}: {len(lost)} of {len(table.rows)} rows left out for want of a pose, "
        "the first in line"
    )
    warnings.warn(f"{told} {lost[0].line}", DoubtfulInput, stacklevel=4)
    gone = {row.line for row in lost}
    return [row for row in table.rows if row.line not in gone]


def _pose_row(table: CsvTable, row: CsvRow) -> dict[str, Any]:
    found = {column: column_value(table, row, column) for column in COLUMN_NAMES}
    for column in ENDS:
        limit = LARGEST_ANGLE if column.startswith("theta") else LARGEST_POSITION
        if not abs(found[column]) <= limit:
            value, unit = (
                f"{column} is {found[column]:g}",
                "deg" if column.startswith("theta") else "mm",
            )
            bound = f"it must be a number within {limit:g} (SI units)"
            raise table.error(
                row.line, f"{value}; {bound}: is it in other units? Say them, --units {unit}"
            )
    far = math.hypot(found["x1"] - found["x0"], found["y1"] - found["y0"])
    if far > _LONGEST_PUSH:
        told = f"the push moves the object by {far:.4g} m: are its places in millimetres?"
        raise table.error(row.line, f"{told} Say so, --units mm,rad")
    if all(name in table.header and table.text(row, name) for name in _RODS):
        x0, y0, x1, y1 = (table.number(row, name) for name in _RODS)
        found["length"] = math.hypot(x1 - x0, y1 - y0)
    if math.isnan(found["dtheta"]):
        found["dtheta"] = float(shorter_way(found["theta1"] - found["theta0"]))
    found["theta1"] = found["theta0"] + found["dtheta"]
    found["theta_next"] = found["theta1"] + float(
        shorter_way(found["theta_next"] - found["theta1"])
    )
    dx, dy = Pose(found["x0"], found["y0"], found["theta0"]).to_object(found["x1"], found["y1"])
    return found | {"dx": dx, "dy": dy}


@dataclass(frozen=True)
class UnreadableFile:
    """A file (or folder) that could not be read.

    Attributes
    ----------
    path : Path
        The file.
    reason : str
        Why, in words.

    Examples
    --------
    >>> from pathlib import Path
    >>> from cyclemap.evidence import UnreadableFile
    >>> UnreadableFile(Path("cut.json"), "it is cut short").reason
    'it is cut short'
    """

    path: Path
    reason: str


@dataclass(frozen=True, eq=False)
class PushTable:
    """Pushes and friction scans, a row each, and the files that could not be read.

    Attributes
    ----------
    table : pandas.DataFrame
        A row a push; its columns are listed below.
    scans : pandas.DataFrame
        A row a friction scan; its columns are listed below.
    unreadable : tuple of UnreadableFile
        The files left out, in order of their paths.
    convention : Convention
        In which they were written; all of the table is in ours.
    convention_told : bool
        Whether somebody said it.

    Notes
    -----
    Columns of ``table``: `surface`, `object` (text), `acceleration` (m/s^2), `speed` (m/s), `side`,
    `fraction`, `angle` (rad), `repetition`: from the file's name. `length` (m): of the rod's path,
    from `tip_x0`, `tip_y0` to `tip_x1`, `tip_y1` (m, world). `x0`, `y0` (m), `theta0` (rad), `x1`,
    `y1`, `theta1`: first and last pose there. `dx`, `dy` (m): displacement in the object's initial
    frame. `dtheta` (rad): theta1 - theta0, counted along the series, so never wrapped. `theta_next`
    (rad): start of the next repetition of the same set (same folder or CSV table, same facts), on
    the lift nearest to theta1; so theta_next - theta0 is the turn of the cycle where the drag back
    turns by less than half a turn. `force_ratio`: see `contact_force_ratio`. `samples`: poses of
    the object, 0 in a CSV table. `path`: the file.

    Columns of ``scans``: `direction` (rad) of the motion in the world, by the name; `force_along`
    and `force_across` (N): see `scan_forces`; `ratio`: force_across / force_along, zero where
    friction is isotropic; `samples`: wrenches; the rest as above.

    What is unknown is NaN: facts of a file whose name is not of the layout, the repetition of a
    single push, theta_next of the last of a set, the force ratio of an object that is no MIT shape
    or without contact.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from cyclemap import load_pushes
    >>> with tempfile.TemporaryDirectory() as place:
    ...     count = Path(place, "slate.csv").write_text("theta0_deg\\n0\\n10\\n25\\n")
    ...     pushes = load_pushes(f"{place}/slate.csv")
    >>> len(pushes.table), len(pushes.scans), pushes.unreadable
    (2, 0, ())
    """

    table: pandas.DataFrame
    scans: pandas.DataFrame
    unreadable: tuple[UnreadableFile, ...]
    convention: Convention = OURS
    convention_told: bool = False


def load_pushes(
    path: str | Path,
    *,
    angles: str | None = None,
    frame: str | None = None,
    offset_deg: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> PushTable:
    """Read pushes and friction scans in the MIT layout (.h5, .hdf5, .json) or as CSV: a file, a
    folder or a tree.

    Parameters
    ----------
    path : str or Path
        A file, a folder or a tree. Other files are passed over; links to folders are not
        followed.
    angles : str or None, optional
        How the data count angles, as in `Convention`; None: what a collection.toml with the
        data says in its table [data], else counter-clockwise.
    frame : str or None, optional
        How they lay their axes, as in `Convention`; None: what a collection.toml says, else
        right-handed.
    offset_deg : float or None, optional
        What they count angles from, as in `Convention`; None: what a collection.toml says, else
        0.
    progress : callable or None, optional
        Called with the fraction done, in (0, 1].

    Returns
    -------
    PushTable
        Rows sorted by the facts in the order of their columns, then by path, then as in their
        file; a push that stands in two files makes two rows.

    Raises
    ------
    InvalidInput
        Where there is nothing at `path`, or no file of push data below it.

    Notes
    -----
    A file that cannot be read - cut short, damaged, a table missing, wrong columns, text or NaN
    among the numbers, a clock that runs backwards, a size that its file cannot hold - is listed in
    `unreadable` with the reason, and the rest is kept. For CSV tables of poses or of θ0 see
    `read_push_csv`.

    Examples
    --------
    >>> import json, pathlib, tempfile
    >>> from cyclemap import load_pushes
    >>> poses = [[0.0, 0.3, 0.0, 1.5], [0.1, 0.3, 0.05, 1.6]]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     tables = {"object_pose": poses, "tip_pose": poses, "ft_wrench": poses}
    ...     name = "motion_surface=abs_shape=hex_a=0_v=20_i=0.000_s=0.700_t=0.000_rep=0000.json"
    ...     _ = pathlib.Path(folder, name).write_text(json.dumps(tables))
    ...     _ = pathlib.Path(folder, "cut.json").write_text(json.dumps(tables)[:50])
    ...     pushes = load_pushes(folder)
    >>> pushes.table[["object", "speed", "dtheta"]].round(9).values.tolist()
    [['hex', 0.02, 0.1]]
    >>> pushes.unreadable[0].path.name
    'cut.json'
    """
    files, unreadable = _files(Path(path))
    convention = convention_of(path, angles, frame, offset_deg)
    report = progress or (lambda fraction: None)
    pushes: list[dict[str, Any]] = []
    scans: list[dict[str, Any]] = []
    for done, file in enumerate(files, 1):
        try:
            found = _rows(file, convention)
        except DataFileError as error:
            unreadable.append(
                UnreadableFile(file, str(error).removeprefix(f"{file}").lstrip(":, "))
            )
        else:
            pushes += found[0]
            scans += found[1]
        report(done / len(files))
    table = _sorted_frame(pushes, PUSH_COLUMNS, (*SET_FACTS, "repetition", "path"))
    # The start of the next repetition of each push's set, on the lift nearest to its end.
    homes = [
        path if path.lower().endswith(CSV_SUFFIX) else os.path.split(path)[0]
        for path in table["path"]
    ]
    sets = [
        tuple(map(str, facts))
        for facts in zip(homes, *(table[name] for name in SET_FACTS), strict=True)
    ]
    starts: dict[tuple[tuple[str, ...], float], float] = {}
    for key, number, start in zip(sets, table["repetition"], table["theta0"], strict=True):
        starts.setdefault((key, number), start)
    ahead = [
        starts.get((key, number + 1.0), math.nan)
        for key, number in zip(sets, table["repetition"], strict=True)
    ]
    end = table["theta1"].to_numpy()
    table["theta_next"] = table["theta_next"].fillna(
        table["theta1"] + shorter_way(np.array(ahead) - end)
    )
    unreadable.sort(key=lambda entry: entry.path)
    scan_table = _sorted_frame(scans, SCAN_COLUMNS, (*_SCAN_ORDER, "path"))
    if convention.is_ours:
        # Of a table that was brought to ours before its name tells in which it was.
        convention, all_told = written_convention(path)
    else:
        all_told = angles is not None and frame is not None
    return PushTable(table, scan_table, tuple(unreadable), convention, all_told)


def _files(path: Path) -> tuple[list[Path], list[UnreadableFile]]:
    """The files of push data at or below `path`, in order, and the folders that could not be
    entered.
    """
    if not path.exists():
        raise InvalidInput(f"{path}: there is nothing there; give a file or a folder of pushes")
    if not path.is_dir():
        return [path], []
    kinds, errors = (*SUFFIXES, CSV_SUFFIX), list[OSError]()
    below = [
        Path(folder, name)
        for folder, _, names in os.walk(path, onerror=errors.append)
        for name in names
    ]
    files = sorted(file for file in below if file.suffix.lower() in kinds)
    if not files:
        raise InvalidInput(
            f"{path}: the folder holds no push data ({', '.join(kinds)}); check the path"
        )
    return files, [
        UnreadableFile(Path(e.filename), f"the folder cannot be entered ({e.strerror})")
        for e in errors
    ]


def _rows(path: Path, convention: Convention) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """The rows of pushes and of scans that a file holds."""
    if path.suffix.lower() == CSV_SUFFIX:
        if not path.is_file():
            raise DataFileError(f"{path}: there is no such file; check the path")
        return read_push_csv(path, convention), []
    record = convention.record(read_push_file(path))
    if not isinstance(record, PushRecord):
        along, across = scan_forces(record)
        forces = {
            "force_along": along,
            "force_across": across,
            "ratio": across / along if along else math.nan,
        }
        rest = {"samples": len(record.ft_wrench), "path": str(path)}
        scan = scan_facts(path) or ScanFacts()
        scan = (
            scan
            if convention.is_ours
            else replace(scan, direction=convention.direction(scan.direction))
        )
        return [], [asdict(scan) | forces | rest]
    facts = push_facts(path) or PushFacts()
    outline = _mit_outline(facts.object)
    ratio = math.nan if outline is None else contact_force_ratio(record, outline)
    tips = record.tip_pose[[0, -1], 1:3].ravel().tolist()
    poses = dict(
        zip(
            _POSES,
            (*tips, *record.start, *record.end, *record.displacement, record.turn),
            strict=True,
        )
    )
    rest = {
        "length": record.length,
        "force_ratio": ratio,
        "samples": len(record.object_pose),
        "path": str(path),
    }
    return [asdict(facts) | poses | rest], []


@cache
def _mit_outline(name: str | None) -> NDArray[np.float64] | None:
    """The closed outline of an MIT shape as a polyline, m; None for any other object."""
    return Slider.mit(name).outline_points(360) if name in MIT_SHAPE_NAMES else None


def _sorted_frame(
    rows: list[dict[str, Any]], columns: tuple[str, ...], order: tuple[str, ...]
) -> pandas.DataFrame:
    import pandas

    # Not "str": pandas 2 makes the word "None" of a fact that is not known; here it is NaN as in
    # other columns.
    kinds = {
        name: "object" if name in _TEXT else "int64" if name == "samples" else "float64"
        for name in columns
    }
    frame = pandas.DataFrame(rows, columns=list(columns)).astype(kinds)
    frame = frame.where(frame.notna(), math.nan)
    return frame.sort_values(list(order), kind="stable", ignore_index=True)
