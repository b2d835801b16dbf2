"""Tables of one's own, as `own_files` reads them, brought to pushes by our names.

What a column means is told or guessed by its name, its unit by name or size (`meaning`); every
guess is said, and nothing that two readings are possible of is guessed. What a row is, and which
rows follow each other, is told by `own_rows`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from cyclemap.arrays import Array
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.tables.columns import COLUMNS, PLACES, QUATERNION, Kind
from cyclemap.evidence.tables.conventions import OURS, Convention, convention_of
from cyclemap.evidence.tables.data_kinds import TEXTS
from cyclemap.evidence.tables.meaning import bare_name, known_units, meaning_of, unit_of
from cyclemap.evidence.tables.own_files import JSON_LINES, raw_columns
from cyclemap.evidence.tables.own_rows import (
    OwnTable,
    as_pushes,
    in_order,
    refuse_half_turns,
    refuse_several,
    with_what_follows,
)
from cyclemap.evidence.tables.text_tables import Columns
from cyclemap.file_text import located

if TYPE_CHECKING:
    import pandas

# The cosine of an axis' tilt from which on it is upright.
_UPRIGHT = 0.9
# Names of turns about the upright axis, and of those about the others, which tilt an object by more
# than this (rad) where it does not lie flat.
_UPRIGHT_TURN = re.compile(r"(?:rz|rot_?z|yaw)_?[01]?")
_TILT = re.compile(r"(?:rx|ry|rot_?x|rot_?y|roll|pitch)_?[01]?")
_MOST_TILTED = 0.45
# Columns that say of a row whether it counts, and the value with which it does.
_FLAGS = {"good": 1.0, "bad": 0.0}
# What robots write where they have no number.
_NO_NUMBERS = (-999.0, -9999.0, -99999.0, 9999.0, 99999.0)


def read_own_table(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    units: Sequence[str] = (),
    *,
    angles: str | None = None,
    frame: str | None = None,
    offset_deg: float | None = None,
) -> OwnTable:
    """Read a table of one's own, or a stream of poses, as pushes.

    columns : the file's column of each of theta0, theta1, theta_next, x0, y0, x1, y1, of a stream
        t, x, y, theta (or the quaternion qx, qy, qz, qw) and episode; of a bag pose = its topic, of
        a workbook sheet = its name. A part of a list is named[i].
    units : of angles (deg, rad, turn), lengths (mm, cm, m, inch) and times (s, ms, us, ns). What is
        not told is guessed.
    angles, frame, offset_deg : how the file counts angles and lays its axes, as in `Convention`;
        what is not told is what a collection.toml with the data says, else counter-clockwise and
        right-handed, 0.

    Raises DataFileError, saying what the file has and what is wanted, where that cannot be done.
    """
    convention = convention_of(path, angles, frame, offset_deg)
    table = _pushes(Path(path), columns or {}, units, convention)
    with located(str(path), DataFileError):
        table = with_what_follows(table)
    return table.then(table.rows, _assumed({*table.rows} >= PLACES, convention))


def _assumed(posed: bool, convention: Convention) -> str:
    """What is said of the convention: orientations alone cannot tell whether it is the right
    one.
    """
    if posed:
        return f"read with {convention.words()}"
    angles = convention.words().partition("angles ")[2]
    return (
        f"angles taken as {angles}: orientations alone cannot tell, --angles clockwise or "
        "compass says otherwise"
    )


def read_orientations(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    units: Sequence[str] = (),
    growing: bool = False,
    convention: Convention = OURS,
) -> OwnTable:
    """Read θ0 alone of a table of one's own, as `read_own_table` does: every one known, in the
    order of the rows.

    growing : a CSV file that is written to, whose last line waits for its end. Then DataFileError
        also where rows to come could change what earlier ones mean: a stream of poses, or a unit
        that would be guessed.
    """
    table = _pushes(Path(path), columns or {}, units, convention, growing)
    known = table.with_orientation()
    if known.rows.empty and not growing:
        raise DataFileError(f"{path}: no row has an orientation that counts")
    return known.then(known.rows[["theta0"]], _assumed(False, convention))


def _pushes(
    place: Path,
    given: Mapping[str, str],
    units: Sequence[str],
    convention: Convention,
    growing: bool = False,
) -> OwnTable:
    """The pushes of a file in SI units and our convention by our names, in their order."""
    known = known_units(units)
    if growing and place.suffix.lower() not in (*TEXTS, *JSON_LINES):
        raise DataFileError(
            f"{place}: read once it is whole, without --follow: only a CSV file is read while it "
            "grows"
        )
    raw = raw_columns(place, given, growing)
    with located(str(place), DataFileError):
        meaning = meaning_of(raw, given)
        if growing and "theta0" not in meaning and {"t", "episode", "qw"} & {*meaning}:
            raise InvalidInput(
                "a stream of poses is cut into pushes once it is whole: without --follow"
            )
        rows, words, guessed = _in_si_units(raw, meaning, known, growing)
        begin = f"{place.name}: {len(rows)} rows"
        rows, left_out = _counting(rows)
        rows, turned = _with_headings(rows)
        is_guessed = len(meaning) > len(given) or not units
        said = (begin, *words, *left_out, *turned)
        table = OwnTable(convention.rows(rows), said, is_guessed)
        table = as_pushes(place, table, "t" in guessed, meaning.get("theta0", "NAME"))
        if "theta1" not in table.rows:
            refuse_several(table.rows)
            refuse_half_turns(table.rows["theta0"].to_numpy())
        return table if growing else in_order(table)


def _in_si_units(
    raw: Columns, meaning: Mapping[str, str], units: Sequence[str], growing: bool
) -> tuple[pandas.DataFrame, list[str], set[str]]:
    """The columns by our names, what is said of them, and whose unit is a guess."""
    import pandas

    raw, words = _without_stand_ins(raw, meaning)
    columns = dict[str, Any]()
    guessed = set[str]()
    for name, column in meaning.items():
        values = raw[column]
        kind = COLUMNS[name].kind
        said = ""
        if kind is Kind.TEXT:
            columns[name] = (
                values if values.dtype.kind == "O" else [f"{own:.15g}" for own in values]
            )
        elif values.dtype.kind == "O":
            raise InvalidInput(f"{column} holds texts, and {name} wants numbers")
        else:
            factor, said = unit_of(name, meaning, raw, units)
            columns[name] = factor * np.where(np.isfinite(values), values, math.nan)
            if kind is Kind.ANGLE and _UPRIGHT_TURN.fullmatch(bare_name(column)):
                _refuse_tilts(column, raw, factor)
        if "guessed" in said:
            guessed.add(name)
            if growing and kind is Kind.ANGLE:
                raise InvalidInput(
                    f"later rows may tell another unit of {column}: say it, --units deg or rad"
                )
        words.append(f"{column} read as {name}{said}")
    unread = [column for column in raw if column not in meaning.values()]
    if unread:
        words.append(f"not read: {', '.join(unread)[:400]}")
    rows = pandas.DataFrame(columns)
    if "nanoseconds" in rows:
        rows["t"] = rows.get("t", 0.0) + 1e-9 * rows.pop("nanoseconds")
    return rows, words, guessed


def _refuse_tilts(upright: str, raw: Columns, factor: float) -> None:
    """Refuse turns about z beside others about x or y, in the same unit: they are no orientation on
    a table.
    """
    for column, values in raw.items():
        if values.dtype.kind != "f" or not _TILT.fullmatch(bare_name(column)):
            continue
        tilt = factor * float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
        if tilt > _MOST_TILTED:
            raise InvalidInput(
                f"{column} reaches {math.degrees(tilt):.3g} degrees, so that {upright} is not the "
                "turn on the table: bring its poses into a frame with z up, or leave "
                f"{column} out where it is not the object's"
            )


def _without_stand_ins(raw: Columns, meaning: Mapping[str, str]) -> tuple[Columns, list[str]]:
    """The columns of a file, NaN where a pose has what stands for no number, and what is said."""
    cleaned = dict(raw)
    words = list[str]()
    for name, column in meaning.items():
        if COLUMNS[name].kind in (Kind.ANGLE, Kind.PLACE):
            none = np.isin(raw[column], _NO_NUMBERS)
            if none.any():
                cleaned[column] = np.where(none, math.nan, raw[column])
                words.append(f"{column}: {none.sum()} of -999 or the like taken as no number")
    return cleaned, words


def _counting(rows: pandas.DataFrame) -> tuple[pandas.DataFrame, list[str]]:
    """The rows that count where a column tells that some do not, and what is said of it."""
    kept = np.ones(len(rows), dtype=bool)
    words = list[str]()
    for name, counts in _FLAGS.items():
        if name not in rows:
            continue
        flag = rows.pop(name)
        known = flag.dropna()
        if len(known) and known.isin((0.0, 1.0)).all():
            kept &= flag.to_numpy() != 1.0 - counts
        else:
            words.append(f"what is read as {name} is neither yes nor no, and leaves no row out")
    if kept.all():
        return rows, words
    if not {"repetition", "t", "episode"} & {*rows}:
        # What was left out is a gap.
        rows["repetition"] = np.arange(len(rows), dtype=float)
    words.append(
        f"left out, for the table says they failed: {len(rows) - kept.sum()} of {len(rows)} rows"
    )
    return rows[kept].reset_index(drop=True), words


def _with_headings(rows: pandas.DataFrame) -> tuple[pandas.DataFrame, list[str]]:
    """Orientations in place of quaternions, y to the right of x where that is up, as it is said."""
    words = list[str]()
    height = rows.pop("z") if "z" in rows else None
    for end in ("", "0", "1"):
        names = [f"{name}{end}" for name in QUATERNION]
        if not {*names} <= {*rows}:
            continue
        heading, is_y_up = _heading(rows[names].to_numpy())
        rows = rows.drop(columns=names).assign(**{f"theta{end}": heading})
        if is_y_up:
            if end or height is None or "y" not in rows:
                raise InvalidInput("turns about y, which is up: give x, y, z with z up")
            rows["y"] = -height
            words.append("turns about y: taken as up, -z for y")
    return rows, words


def _heading(quaternions: Array) -> tuple[Array, bool]:
    """The turn about the upright axis (n,), rad, of quaternions (n, 4) of any length, and whether
    that is y.
    """
    known = np.isfinite(quaternions).all(axis=1) & (quaternions != 0.0).any(axis=1)
    turns = np.full((len(quaternions), 3, 3), math.nan)
    if known.any():
        turns[known] = Rotation.from_quat(quaternions[known]).as_matrix()
    cosines = np.abs(turns[known][:, (1, 2), (1, 2)])
    if known.any():
        y_up, z_up = np.quantile(cosines, 0.1, axis=0) > _UPRIGHT
    else:
        y_up = True
        z_up = True
    if z_up:
        return np.arctan2(turns[:, 1, 0], turns[:, 0, 0]), False
    if y_up:
        return np.arctan2(turns[:, 0, 2], turns[:, 2, 2]), True
    raise InvalidInput(
        "its quaternions turn about neither z nor y: bring its poses into the frame of the table, "
        "z up"
    )
