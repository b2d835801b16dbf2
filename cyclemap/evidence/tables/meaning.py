"""What a column of any table means, and in which unit it is: the one place that decides it, and
brings columns to SI units by our names.

It is told (--columns, --units), or the column goes by a name of the MIT dataset, or by one that
fits a pattern of `columns`; a unit is told by the column's name, by others like it, or guessed by
its size, which is said. What two readings are possible of is asked for. In tables of ours names say
all of that (`columns.our_names`).
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cyclemap.arrays import Array
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.tables.columns import (
    COLUMNS,
    PLACES,
    QUATERNION,
    TIME_UNITS,
    UNIT_WORDS,
    UNITS,
    UNITS_OF,
    Column,
    Kind,
)

if TYPE_CHECKING:
    import pandas

# Angles beyond this are no radians, not even where they go on past a turn; places beyond this no
# metres of a table.
_NO_RADIANS = 7.0
_NO_RADIANS_UNWRAPPED = 4.0 * math.pi
_NO_METRES = 3.0
# So many angles that fill so much of one and no more are turns as likely as radians.
_TELLING = 8
_MOST_OF_A_TURN = 0.7
# No cycle scatters by as many radians, and hardly one by as few degrees; orientations all around
# reach over more than so many radians.
_ROUGH = 0.35
_MOST_OF_A_CIRCLE = 5.6
_MANY_TURNS = 200.0
# Times beyond this count from 1970, seconds to 1e11, thousandths of them from there to 1e14, and so
# on.
_AN_EPOCH = 1e8
# What may be told of a file beside its columns: the topic of a bag, the sheet of a workbook.
OF_THE_FILE = ("pose", "sheet")
# Words of a name that tell no column from another, where others stand beside them.
_IDLE = (
    r"field|pose|pos|position|transform|translation"
    r"|object|objekt|obj|box|block|slider|tag|marker|body"
)
# What may be told of a table: the angle of pushes goes by no name of its own.
_TO_BE_TOLD = (*(name for name, known in COLUMNS.items() if known.patterns), "angle", *OF_THE_FILE)
# Names of the MIT dataset that say what nobody else's do: those with a unit, and, where all of them
# are there, the letters of its file names.
_MIT_UNITS = {"speed": "v_mm_s", "acceleration": "a_mm_s2", "tip_error": "tip_err_mm"}
_MIT_LETTERS = {"side": "i", "fraction": "s", "angle": "t"}
_MIT_NAMES = _MIT_UNITS | _MIT_LETTERS
# Pixels are no length, but are told from a name.
_PIXELS = "px"
_UNIT = re.compile(
    rf"[_\[(]({'|'.join(sorted([*UNITS, *UNIT_WORDS, _PIXELS], key=len, reverse=True))})[\])]*$"
)
# The cosine of an axis' tilt from which on it is upright.
_UPRIGHT = 0.9
# Names of turns about the upright axis, and of those about the others, which tilt an object by more
# than this (rad) where it does not lie flat.
_UPRIGHT_TURN = re.compile(r"(?:rz|rot_?z|yaw)_?[01]?")
_TILT = re.compile(r"(?:rx|ry|rot_?x|rot_?y|roll|pitch)_?[01]?")
_MOST_TILTED = 0.45
# What robots write where they have no number.
_NO_NUMBERS = (-999.0, -9999.0, -99999.0, 9999.0, 99999.0)


def _bare(column: str) -> tuple[str, str]:
    """A column's name without its unit and idle words, and the unit; both in small letters."""
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", column.strip().lstrip("%/"))
    name = re.sub(r"[\s.\-/]+", "_", apart.lower())
    # One bracket, not a run of them: the search takes no longer than the name is.
    ending = _UNIT.search(name)
    begin = name[: ending.start()].rstrip("_[(") if ending else ""
    unit = ending.group(1) if ending and begin else ""
    words = (begin if unit else name).strip("_").split("_")
    busy = [word for word in words if not re.fullmatch(_IDLE, word)]
    # A number of an object is none of a push.
    is_number = len(busy) < len(words) and COLUMNS["repetition"].fits("_".join(busy))
    return "_".join(busy if busy and not is_number else words), UNIT_WORDS.get(unit, unit)


def bare_name(column: str) -> str:
    """Return a column's name without its unit and idle words, in small letters."""
    return _bare(column)[0]


def unit_word(field: str) -> bool:
    """Whether a field of a table names a unit, in brackets or not."""
    unit = field.strip().strip("[]()").lower()
    return unit in UNITS or unit in UNIT_WORDS


def has_unit(field: str) -> bool:
    """Whether a field of a row is a unit, or ends with one behind its number."""
    return unit_word(re.sub(r"^[-+\d.,]+", "", field.strip().strip('"')))


def _fits(known: Column, column: str) -> bool:
    """Whether a column is one of ours by its name, and its unit one of what that holds."""
    name, unit = _bare(column)
    lengths = (Kind.PLACE, Kind.LENGTH)
    wanted = not unit or unit in UNITS_OF.get(known.kind, ()) or known.kind is Kind.TEXT
    return known.fits(name) and (wanted or (unit == _PIXELS and known.kind in lengths))


def known_units(units: Sequence[str]) -> list[str]:
    """Return units by their names here; InvalidInput for one that nobody knows."""
    known = [UNIT_WORDS.get(unit, unit) for unit in units]
    for unit in known:
        if unit not in UNITS:
            raise InvalidInput(f"--units {unit}: know {', '.join(UNITS)}")
    return known


def meaning_of(raw: Mapping[str, Array], given: Mapping[str, str]) -> dict[str, str]:
    """Return the column of a file for each name that is told, is the MIT dataset's alone, or is
    recognised; InvalidInput where one is wanted, or two would do.
    """
    have = ", ".join(list(raw)[:20])[:400]
    for name, column in given.items():
        if name not in _TO_BE_TOLD:
            raise InvalidInput(f"--columns {name}=...: know {', '.join(_TO_BE_TOLD)}")
        if name not in OF_THE_FILE and column not in raw:
            raise InvalidInput(f"no column {column} for {name}; it has {have}")
    meaning = {name: column for name, column in given.items() if name not in OF_THE_FILE}
    for name, column in _mit_columns(raw).items():
        if column not in meaning.values():
            meaning.setdefault(name, column)
    for name, known in COLUMNS.items():
        if name in meaning:
            continue
        free = [column for column in raw if column not in meaning.values()]
        hits = [column for column in free if _fits(known, column)]
        # Of two clocks either will do.
        if len(hits) > 1 and known.kind is not Kind.TIME:
            raise InvalidInput(
                f"{' and '.join(hits)} may both be {name}: say which, --columns {name}={hits[0]}"
            )
        if hits:
            meaning[name] = hits[0]
    _refuse_half_told(meaning, given, have)
    return meaning


def _mit_columns(raw: Collection[str]) -> dict[str, str]:
    """The columns of a file whose names, with their units, are the MIT dataset's."""
    by_name = {column.strip().lower(): column for column in raw}
    names = _MIT_NAMES if {*_MIT_LETTERS.values()} <= {*by_name} else _MIT_UNITS
    return {name: by_name[own] for name, own in names.items() if own in by_name}


def _refuse_half_told(meaning: Mapping[str, str], given: Mapping[str, str], have: str) -> None:
    """Refuse columns of which another reading is possible, or some are missing."""
    asked = {"theta1", "theta_next"} & {*given} or "theta_next" in meaning
    if "theta1" in meaning and not asked and not set(meaning) >= PLACES:
        after = meaning["theta1"]
        raise InvalidInput(
            f"is {after} the orientation after the push, or before the next one? Say "
            f"--columns theta1={after} or theta_next={after}; it has no x0, y0, x1, y1"
        )
    for end in ("", "0", "1"):
        if 0 < len({f"{part}{end}" for part in QUATERNION} & set(meaning)) < len(QUATERNION):
            raise InvalidInput(f"of a quaternion all of qx, qy, qz, qw are wanted; it has {have}")
    if not {"theta0", "theta", "qw", "qw0"} & set(meaning):
        # Of a moving object the orientation is wanted at every moment, and pushes are found in it.
        wanted = "theta" if {"t", "episode"} & set(meaning) else "theta0"
        raise InvalidInput(
            "no column of the object's orientation before each push: say which, --columns "
            f"{wanted}=NAME; it has {have}"
        )


def unit_of(
    name: str, meaning: Mapping[str, str], raw: Mapping[str, Array], units: Sequence[str]
) -> tuple[float, str]:
    """Return the unit of a column, as its factor to SI units, and how that is said. All angles, and
    all places, are guessed to be alike.
    """
    known = UNITS_OF.get(COLUMNS[name].kind, {})
    column = meaning[name]
    said = next((unit for unit in units if unit in known), None)
    if said is not None:
        return known[said], f" in {said}"
    if _MIT_NAMES.get(name) == column.strip().lower():
        return COLUMNS[name].names[_MIT_NAMES[name]], ", as the MIT dataset names it"
    if not known:
        return 1.0, ""
    unit, how = _unit_by_name_or_size(name, meaning, raw)
    return known[unit], f" in {unit}{how}"


def _unit_by_name_or_size(
    name: str, meaning: Mapping[str, str], raw: Mapping[str, Array]
) -> tuple[str, str]:
    """The unit of a column that nobody told, and how it is known."""
    kind = COLUMNS[name].kind
    alike = [name]
    if kind in (Kind.ANGLE, Kind.PLACE):
        alike = [other for other in meaning if COLUMNS[other].kind is kind]
    named = {other: _bare(meaning[other])[1] for other in alike}
    if named[name] in UNITS_OF[kind]:
        return named[name], ", by its name"
    if named[name] == _PIXELS:
        raise InvalidInput(
            f"{meaning[name]}: multiply its pixels by the length of one, and name it x0_mm or "
            "the like"
        )
    of_others = {unit for unit in named.values() if unit in UNITS_OF[kind]}
    if len(of_others) == 1:
        return of_others.pop(), ", as its like"
    unnamed = [meaning[other] for other in alike if named[other] not in UNITS_OF[kind]]
    return _guessed_unit(kind, {column: raw[column] for column in unnamed})


def _guessed_unit(kind: Kind, columns: Mapping[str, Array]) -> tuple[str, str]:
    """The unit of columns that are alike, by their size, and how that is said."""
    reaches = [
        float(np.abs(values[np.isfinite(values)]).max(initial=0.0)) for values in columns.values()
    ]
    least = min(reaches)
    most = max(reaches)
    if kind is Kind.TIME and most > _AN_EPOCH:
        # A count since 1970: its size tells the unit.
        unit = list(TIME_UNITS)[min(3, math.floor(math.log10(most / _AN_EPOCH) / 3.0))]
        return unit, " since 1970"
    if kind is Kind.TIME:
        unit = "s"
    elif kind is Kind.SLANT:
        unit = "rad" if most <= 0.5 * math.pi else "deg"
    elif kind is Kind.ANGLE:
        _refuse_likely_turns(most, *next(iter(columns.items())))
        unit = "rad" if least <= _NO_RADIANS and most <= _NO_RADIANS_UNWRAPPED else "deg"
        if _may_be_either(unit, most, columns):
            if len(columns) == 1:
                reach = f"{next(iter(columns))} reaches {most:.4g} in steps that may be of either"
                raise InvalidInput(f"{reach}: radians, or degrees? Say --units rad or --units deg")
            # No two columns of degrees go on as smoothly.
            unit = "rad"
    else:
        unit = "m" if most <= _NO_METRES else "mm"
    reach = "they reach" if len(columns) > 1 else "it reaches"
    return unit, f", guessed: {reach} {most:.4g}"


def _may_be_either(unit: str, most: float, columns: Mapping[str, Array]) -> bool:
    """Whether degrees may be radians that go on past a turn, or radians of orientations alone
    scatter as degrees near 0 do.
    """
    known = [values[np.isfinite(values)] for values in columns.values()]
    if min(map(len, known)) < _TELLING:
        return False
    if unit == "rad":
        low = float(known[0].min())
        high = float(known[0].max())
        # Radians that are wrapped begin at 0 or at minus half a turn.
        is_wrapped = low >= -math.pi - 0.01 and high <= (math.pi if low < -0.01 else 6.3) + 0.01
        around = is_wrapped and high - low >= _MOST_OF_A_CIRCLE
        return len(known) == 1 and not around and _scatter(known[0]) > _ROUGH
    if most >= _MANY_TURNS:
        return False
    # Rows before and after pushes may take turns.
    every_other = [values[::2] for values in known]
    return all(map(_goes_on_in_radians, known)) or all(map(_goes_on_in_radians, every_other))


def _goes_on_in_radians(values: Array) -> bool:
    """Whether angles begin within a turn, and go on by less than half of one, smoothly."""
    steps = float(np.quantile(np.abs(np.diff(values)), 0.95))
    return abs(float(values[0])) <= 3.0 * math.pi and steps < math.pi and _scatter(values) < _ROUGH


def _scatter(angles: Array) -> float:
    """The usual deviation of an angle from the mean of its neighbours."""
    return float(np.median(np.abs(np.diff(angles, n=2)))) / 0.6745 / 6**0.5


def _refuse_likely_turns(most: float, name: str, values: Array) -> None:
    """Refuse angles of up to 1 that fill as much of one turn as of one radian."""
    angles = values[np.isfinite(values)]
    if most <= 1.0 and angles.size >= _TELLING and float(np.ptp(angles)) > _MOST_OF_A_TURN:
        raise DataFileError(
            f"{name} runs from {angles.min():.3g} to {angles.max():.3g}: are these turns, or "
            "radians? Say --units turn or --units rad"
        )


# -- in SI units


def si_rows(
    raw: Mapping[str, Array], meaning: Mapping[str, str], units: Sequence[str], growing: bool
) -> tuple[pandas.DataFrame, list[str], set[str]]:
    """Return the columns by our names, what is said of them, and whose unit is a guess."""
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


def _refuse_tilts(upright: str, raw: Mapping[str, Array], factor: float) -> None:
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


def _without_stand_ins(
    raw: Mapping[str, Array], meaning: Mapping[str, str]
) -> tuple[dict[str, Array], list[str]]:
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


def with_headings(rows: pandas.DataFrame) -> tuple[pandas.DataFrame, list[str]]:
    """Return orientations in place of quaternions, y to the right of x where that is up, as is
    said.
    """
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
    from scipy.spatial.transform import Rotation

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
