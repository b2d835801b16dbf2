"""A collection of pushes as one table: a file, a folder or a tree of the MIT layout, or CSV, bad
files reported.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cyclemap.arrays import shorter_way
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.pushes.push_files import push_row, read_push_file, scan_row
from cyclemap.evidence.pushes.recordings import (
    LARGEST_ANGLE,
    LARGEST_POSITION,
    PushRecord,
    as_ours,
)
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs, doubt_degrees, pairs_in_table
from cyclemap.evidence.tables.columns import (
    AS_READ,
    ENDS,
    OURS,
    RODS,
    Convention,
    Row,
    convention_of,
    known_columns,
    our_names,
    written_convention,
)
from cyclemap.evidence.tables.data_kinds import CSV_SUFFIX, SUFFIXES, is_csv, is_record
from cyclemap.progress import Progress, part_of
from cyclemap.text_files import LARGEST_CONTENT, CsvTable, read_csv_table

if TYPE_CHECKING:
    import pandas

# As a table of twenty columns they are as large as any file may be.
_MOST_PUSHES = LARGEST_CONTENT // 8 // 20
# The share of rows that may have no pose; m, beyond which no push goes.
_MOST_LOST = 0.5
_LONGEST_PUSH = 3.0
_TWO_TURNS = 4.0 * math.pi
SET_FACTS = ("surface", "object", "acceleration", "speed", "side", "fraction", "angle")
PUSH_COLUMNS = (
    *SET_FACTS,
    "repetition",
    "length",
    *RODS,
    *ENDS,
    "dx",
    "dy",
    "dtheta",
    "theta_next",
    "force_ratio",
    "tip_error",
    "samples",
    "path",
    "line",
)
_SCAN_ORDER = ("surface", "object", "acceleration", "speed", "direction", "repetition")
SCAN_COLUMNS = (*_SCAN_ORDER, "force_along", "force_across", "ratio", "samples", "path")
_TEXT = ("surface", "object", "path")


def pushes_in_table(
    table: CsvTable, convention: Convention = OURS
) -> tuple[pandas.DataFrame, Theta0Pairs | None]:
    """Return the pushes of a CSV table of ours, a row each, with the columns of `PushTable.table`,
    in the order of the table; of orientations alone also the pairs.

    A table of poses has a header with `x0,y0,theta0,x1,y1,theta1` (m, rad; also `th0`, `th1`,
    `theta0_deg`, `theta1_deg`); it may have `surface`, `object` (or `shape`), `acceleration`
    (`a_mm_s2`), `speed` (`v_mm_s`), `side` (`i`), `fraction` (`s`), `angle` (`t`), `repetition`
    (`rep`), `dtheta`, `theta_next` (`th0n`, `theta_next_deg`), `force_ratio`, and how far the rod
    moved: `length` (`push_mm`), or its places `tip_x0,tip_y0,tip_x1,tip_y1` (m). Columns of other
    names are passed over. What is absent or empty is NaN; `dtheta` is then the shorter way round,
    for two poses cannot tell more. `theta_next` is put on the lift nearest to theta1.

    Any other table is read by `read_theta0_pairs`: a row a pair, with theta0 and theta_next alone
    (and its `rep`, where the file has it).

    convention : of the file's angles and axes. DataFileError names the file, the line and the mend.
    """
    import pandas

    if len(table.rows) > _MOST_PUSHES:
        raise DataFileError(f"{table.path}: holds more than {_MOST_PUSHES} pushes; split it")
    if {*our_names(table.header)} >= {*ENDS}:
        return _posed(table, convention), None
    pairs = pairs_in_table(table, convention)
    is_numbered = "theta0_accum_deg" in table.header and pairs.cycle is not None
    columns = {
        "theta0": pairs.theta,
        "theta_next": pairs.theta_next,
        "repetition": pairs.cycle if is_numbered else math.nan,
    }
    return pandas.DataFrame(columns).assign(samples=0, path=str(table.path)), pairs


def _posed(table: CsvTable, convention: Convention) -> pandas.DataFrame:
    """The pushes of a table of poses."""
    doubt_degrees(table, ("theta0_deg", "theta1_deg"))
    written = known_columns(table, ENDS, _MOST_LOST)
    _refuse_degrees(table, written)
    frame = convention.rows(written)
    _refuse_other_units(table, frame)
    x0, y0, theta0, x1, y1, theta1 = frame[[*ENDS]].to_numpy().T
    tip_x0, tip_y0, tip_x1, tip_y1 = frame[[*RODS]].to_numpy().T
    moved = (x1 - x0 + 1j * (y1 - y0)) * np.exp(-1j * theta0)
    turn = np.where(frame["dtheta"].notna(), frame["dtheta"], shorter_way(theta1 - theta0))
    end = theta0 + turn
    rod = np.hypot(tip_x1 - tip_x0, tip_y1 - tip_y0)
    return frame.assign(
        length=np.where(np.isnan(rod), frame["length"], rod),
        dx=moved.real,
        dy=moved.imag,
        dtheta=turn,
        theta1=end,
        theta_next=end + shorter_way(frame["theta_next"] - end),
        samples=0,
    )


def _refuse_degrees(table: CsvTable, frame: pandas.DataFrame) -> None:
    """Refuse angles in radians that go beyond two turns and change by more than half a turn in most
    pushes, or from most pushes to the next: lifts of radians go on slowly, and wrapped ones do not
    go so far.
    """
    for column, other in (("theta0", "theta1"), ("theta1", "theta0")):
        if f"{column}_deg" in table.header:
            continue
        angles = frame[column]
        turns = (angles - frame[other]).abs().median()
        steps = angles.diff().abs().median()
        if angles.abs().max() > _TWO_TURNS and max(turns, steps) > math.pi:
            farthest = frame.loc[angles.abs().idxmax()]
            raise table.error(
                farthest["line"],
                f"{column} is {farthest[column]:g}, and most pushes are half a turn apart: are "
                "these degrees? Say so, --units deg, or --units rad where they are not",
            )


def _refuse_other_units(table: CsvTable, frame: pandas.DataFrame) -> None:
    """Refuse poses that no table top holds."""
    for column in ENDS:
        turns = column.startswith("theta")
        limit, unit = (LARGEST_ANGLE, "deg") if turns else (LARGEST_POSITION, "mm")
        beyond = frame[~(frame[column].abs() <= limit)]
        for line, value in zip(beyond["line"], beyond[column], strict=True):
            raise table.error(
                line,
                f"{column} is {value:g}; it must be a number within {limit:g} (SI units): is "
                f"it in other units? Say them, --units {unit}",
            )
    far = np.hypot(frame["x1"] - frame["x0"], frame["y1"] - frame["y0"])
    for line, length in zip(frame["line"], far, strict=True):
        if length > _LONGEST_PUSH:
            raise table.error(
                line,
                f"the push moves the object by {length:.4g} m: are its places in millimetres? "
                "Say so, --units mm,rad",
            )


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
    pairs : mapping of str to Theta0Pairs
        Of each CSV table of orientations alone, by its path, the pairs with what a row cannot tell:
        their whole path, and what was dropped of it.

    Notes
    -----
    Columns of ``table``: `surface`, `object` (text), `acceleration` (m/s^2), `speed` (m/s), `side`,
    `fraction`, `angle` (rad), `repetition`: from the file's name. `length` (m): of the rod's path,
    from `tip_x0`, `tip_y0` to `tip_x1`, `tip_y1` (m, world). `x0`, `y0` (m), `theta0` (rad), `x1`,
    `y1`, `theta1`: first and last pose there. `dx`, `dy` (m): displacement in the object's initial
    frame. `dtheta` (rad): theta1 - theta0, counted along the series, so never wrapped. `theta_next`
    (rad): start of the next repetition of the same set (same folder or CSV table, same facts), on
    the lift nearest to theta1; so theta_next - theta0 is the turn of the cycle where the drag back
    turns by less than half a turn. `force_ratio`: see `contact_force_ratio`. `tip_error` (m): how
    far the robot was from where it was sent, where a table tells. `samples`: poses of the object, 0
    in a CSV table. `path`: the file, and in a CSV table the `line`.

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
    pairs: Mapping[str, Theta0Pairs] = field(default_factory=dict)


def load_pushes(
    path: str | Path,
    *,
    angles: str | None = None,
    frame: str | None = None,
    offset_deg: float | None = None,
    progress: Progress | None = None,
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
    `pushes_in_table`.

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
    is_told = angles is not None or frame is not None or offset_deg is not None
    convention = convention_of(path, angles, frame, offset_deg)
    if not is_told:
        _refuse_mixed(path, files, convention)
    loaded = _loaded(files, convention, progress)
    unreadable += loaded.unreadable
    written, all_told = written_convention(path)
    return replace(
        loaded,
        unreadable=tuple(sorted(unreadable, key=lambda entry: entry.path)),
        # Of a table that was brought to ours before its name tells in which it was.
        convention=convention if is_told else written,
        convention_told=all_told or (angles is not None and frame is not None),
    )


def _refuse_mixed(path: str | Path, files: Sequence[Path], convention: Convention) -> None:
    """Refuse files of which some are in another convention than their folder."""
    places = {file if file.name.endswith(AS_READ) else file.parent for file in files}
    for place in sorted(places):
        own = convention_of(place)
        if own != convention:
            raise InvalidInput(
                f"{path} is read with {convention.words()}, but {place} with {own.words()}: read "
                "each of them alone"
            )


def table_pushes(table: CsvTable) -> PushTable:
    """Return the pushes of a CSV table of ours that was read already, as `load_pushes` does."""
    written, all_told = written_convention(table.path)
    loaded = _loaded([table], convention_of(table.path))
    return replace(loaded, convention=written, convention_told=all_told)


def _loaded(
    files: Sequence[Path | CsvTable], convention: Convention, progress: Progress | None = None
) -> PushTable:
    """The pushes and scans of files, in our convention."""
    frames: list[pandas.DataFrame] = []
    pairs = dict[str, Theta0Pairs]()
    pushes = list[Row]()
    scans = list[Row]()
    unreadable = list[UnreadableFile]()
    for index, file in enumerate(files):
        path = file.path if isinstance(file, CsvTable) else file
        try:
            if is_csv(path):
                table = file if isinstance(file, CsvTable) else read_csv_table(file)
                rows, own = pushes_in_table(table, convention)
                frames.append(rows)
                pairs |= {} if own is None else {str(path): own}
            else:
                record = as_ours(read_push_file(path), convention)
                if isinstance(record, PushRecord):
                    pushes.append(push_row(path, record))
                else:
                    scans.append(scan_row(path, record, convention))
        except DataFileError as error:
            reason = str(error).removeprefix(f"{path}").lstrip(":, ")
            unreadable.append(UnreadableFile(path, reason))
        part_of(progress, index, len(files))(1.0)
    table = _push_frame([*frames, _frame(pushes, PUSH_COLUMNS)])
    scan_table = _sorted(_frame(scans, SCAN_COLUMNS), _SCAN_ORDER)
    return PushTable(table, scan_table, tuple(unreadable), pairs=pairs)


def homes(table: pandas.DataFrame) -> pandas.Series:
    """Return the folder, or the CSV table, of each push."""
    paths = table["path"]
    return paths.where(in_csv(paths), paths.map(os.path.dirname))


def in_csv(paths: pandas.Series) -> pandas.Series:
    """Return which paths are of CSV tables."""
    return paths.map(is_csv).astype(bool)


def _next_start(table: pandas.DataFrame) -> pandas.Series:
    """The orientation before the next repetition of each push's set, on the lift nearest to its
    end.
    """
    sets = table.groupby([homes(table), *SET_FACTS], dropna=False, sort=False).ngroup()
    keys = list(zip(sets, table["repetition"], strict=True))
    starts = dict(zip(reversed(keys), reversed(table["theta0"].tolist()), strict=True))
    ahead = [starts.get((own, number + 1.0), math.nan) for own, number in keys]
    return table["theta1"] + shorter_way(np.array(ahead) - table["theta1"].to_numpy())


def _files(path: Path) -> tuple[list[Path], list[UnreadableFile]]:
    """The files of push data at or below `path`, in order, and the folders that could not be
    entered.
    """
    if not path.exists():
        raise InvalidInput(f"{path}: there is nothing there; give a file or a folder of pushes")
    if not path.is_dir():
        return [path], []
    errors = list[OSError]()
    below = list[Path]()
    for folder, _, names in os.walk(path, onerror=errors.append):
        below += [Path(folder, name) for name in names]
    files = sorted(file for file in below if is_record(file) or is_csv(file))
    if not files:
        raise InvalidInput(
            f"{path}: the folder holds no push data ({', '.join((*SUFFIXES, CSV_SUFFIX))}); "
            "check the path"
        )
    return files, [
        UnreadableFile(Path(e.filename), f"the folder cannot be entered ({e.strerror})")
        for e in errors
    ]


def _push_frame(frames: Sequence[pandas.DataFrame]) -> pandas.DataFrame:
    """Pushes of all files as one table, each with the start of the next of its set."""
    import pandas

    known = [_frame(frame, PUSH_COLUMNS) for frame in frames if len(frame)]
    rows = pandas.concat(known) if known else _frame([], PUSH_COLUMNS)
    table = _sorted(rows, (*SET_FACTS, "repetition"))
    table["theta_next"] = table["theta_next"].fillna(_next_start(table))
    return table


def _frame(rows: list[Row] | pandas.DataFrame, columns: tuple[str, ...]) -> pandas.DataFrame:
    """Rows with these columns; what is not known is NaN, of texts, too."""
    import pandas

    # Not "str": pandas 2 makes the word "None" of a fact that is not known.
    kinds = {
        name: "object" if name in _TEXT else "int64" if name == "samples" else "float64"
        for name in columns
    }
    frame = pandas.DataFrame(rows, columns=list(columns)).astype(kinds)
    return frame.where(frame.notna(), math.nan)


def _sorted(frame: pandas.DataFrame, order: tuple[str, ...]) -> pandas.DataFrame:
    return frame.sort_values([*order, "path"], kind="stable", ignore_index=True)
