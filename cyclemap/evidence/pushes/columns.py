"""The columns of tables of pushes: what each holds, by which names it goes, in which units.

Whatever reads, turns or writes a table asks here. A column has one name in code, such as theta0; in
tables of ours also names with a unit, such as theta0_deg; elsewhere names that fit its patterns.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np

from cyclemap.arrays import Array
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.text_files import CsvRow, CsvTable

# A row of a table by its columns: numbers, NaN where unknown, and texts, None where unknown.
Row = dict[str, Any]

DEGREE = math.radians(1.0)
ANGLE_UNITS = {"deg": DEGREE, "rad": 1.0, "turn": 2.0 * math.pi}
LENGTH_UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "inch": 0.0254}
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
UNITS = ANGLE_UNITS | LENGTH_UNITS | TIME_UNITS
UNIT_WORDS = dict.fromkeys(("degrees", "degree", "°", "grad"), "deg") | {
    "radians": "rad",
    "metres": "m",
    "meters": "m",
    **dict.fromkeys(("in", "inches"), "inch"),
    **dict.fromkeys(("turns", "rev", "revs", "revolutions"), "turn"),
}
# Angles beyond this are no radians, not even where they go on past a turn; places beyond this no
# metres of a table.
_NO_RADIANS, _NO_RADIANS_UNWRAPPED, _NO_METRES = 7.0, 4.0 * math.pi, 3.0
# So many angles that fill so much of one and no more are turns as likely as radians.
_TELLING, _MOST_OF_A_TURN = 8, 0.7
# Times beyond this count from 1970, seconds to 1e11, thousandths of them from there to 1e14, and so
# on.
_AN_EPOCH = 1e8


class Kind(Enum):
    """What a column holds; a turn is a difference of two angles, a place one of two ordinates."""

    ANGLE = "angle"
    TURN = "turn"
    PLACE = "place"
    LENGTH = "length"
    TIME = "time"
    NUMBER = "number"
    TEXT = "text"


UNITS_OF: Mapping[Kind, Mapping[str, float]] = {
    Kind.ANGLE: ANGLE_UNITS,
    Kind.PLACE: LENGTH_UNITS,
    Kind.LENGTH: LENGTH_UNITS,
    Kind.TIME: TIME_UNITS,
}


@dataclass(frozen=True)
class Column:
    """A column: its name in code, its kind, its other names in tables of ours with the factor to SI
    units, and patterns of its names in any other table.
    """

    name: str
    kind: Kind
    others: Mapping[str, float] = field(default_factory=dict)
    patterns: tuple[str, ...] = ()

    @property
    def names(self) -> dict[str, float]:
        """All names in tables of ours, that of code first, with the factor to SI units."""
        return {self.name: 1.0, **self.others}

    def fits(self, bare_name: str) -> bool:
        """Whether a name without its unit is this column's by one of the patterns."""
        return any(re.fullmatch(pattern, bare_name) for pattern in self.patterns)


_ANGLE = r"(?:yaw|theta|th|angle|orientation|heading|rot|rotation|rz|winkel)"
_ENDS = {
    "0": r"(?:0|before|start|initial|init|pre|vorher|first)",
    "1": r"(?:1|after|end|final|post|nachher|last)",
}
_ROD = r"(?:tip|rod|pusher|finger|tool|ee|tcp)_"
QUATERNION = ("qx", "qy", "qz", "qw")
# The object's pose before and after a push, and the places of the rod then.
ENDS = ("x0", "y0", "theta0", "x1", "y1", "theta1")
PLACES = {"x0", "y0", "x1", "y1"}
RODS = ("tip_x0", "tip_y0", "tip_x1", "tip_y1")


def _at_ends(
    name: str, kind: Kind, what: str, owner: str = "", others: Mapping[str, float] | None = None
) -> tuple[Column, ...]:
    """A column before a push and one after it, `{}` in names standing for 0 and 1; patterns of what
    it is and of whom.
    """
    return tuple(
        Column(
            name.format(end),
            kind,
            {other.format(end): factor for other, factor in (others or {}).items()},
            (rf"{owner}{what}_?{words}", rf"{owner}{words}_{what}"),
        )
        for end, words in _ENDS.items()
    )


def _quaternion(name: str) -> Column:
    words = r"orientation|quat(?:ernion)?"
    return Column(name, Kind.NUMBER, {}, (rf"(?:(?:{words})_)?{name}", rf"(?:{words})_{name[1]}"))


_NEXT = rf"(?:{_ANGLE}_next|next_{_ANGLE}|th0n)(?:_?0)?"
_REPETITION = r"rep|repetition|push(?:_(?:nr|no|number|index))?|cycle|nr|no|number|id|index"
_LENGTH = r"push_?length|push_?distance|push(?=_mm)|push"
# In the order in which columns of other tables are looked for; those without a pattern stand in
# tables of ours alone.
_ALL = (
    *_at_ends("theta{}", Kind.ANGLE, _ANGLE, others={"th{}": 1.0, "theta{}_deg": DEGREE}),
    Column("theta_next", Kind.ANGLE, {"th0n": 1.0}, (_NEXT,)),
    Column("theta", Kind.ANGLE, {}, (_ANGLE,)),
    *_at_ends("x{}", Kind.PLACE, "(?:pos_?)?x"),
    *_at_ends("y{}", Kind.PLACE, "(?:pos_?)?y"),
    Column("x", Kind.PLACE, {}, (r"(?:pos(?:ition)?_)?x",)),
    Column("y", Kind.PLACE, {}, (r"(?:pos(?:ition)?_)?y",)),
    Column("t", Kind.TIME, {}, (r"t|time|timestamp|stamp|secs?|seconds|zeit",)),
    Column("episode", Kind.NUMBER, {}, (r"episode(?:_index|_id)?|trial|push_id",)),
    Column("repetition", Kind.NUMBER, {"rep": 1.0}, (_REPETITION,)),
    Column("length", Kind.LENGTH, {"push_mm": 1e-3}, (_LENGTH,)),
    Column("side", Kind.NUMBER, {"i": 1.0}, ("side",)),
    Column("fraction", Kind.NUMBER, {"s": 1.0}, ("fraction",)),
    Column("surface", Kind.TEXT, {}, ("surface",)),
    Column("object", Kind.TEXT, {"shape": 1.0}, ("object|shape",)),
    *_at_ends("tip_x{}", Kind.PLACE, "x", _ROD),
    *_at_ends("tip_y{}", Kind.PLACE, "y", _ROD),
    *(_quaternion(name) for name in QUATERNION),
    Column("angle", Kind.NUMBER, {"t": 1.0}),
    Column("acceleration", Kind.NUMBER, {"a_mm_s2": 1e-3}),
    Column("speed", Kind.NUMBER, {"v_mm_s": 1e-3}),
    Column("dtheta", Kind.TURN),
    Column("force_ratio", Kind.NUMBER),
    # After the drag back; of staircases and pairs.
    Column("x0n", Kind.PLACE),
    Column("y0n", Kind.PLACE),
    Column("theta0_accum", Kind.ANGLE, {"theta0_accum_deg": DEGREE}),
    Column("theta0_mod360", Kind.ANGLE, {"theta0_mod360_deg": DEGREE}),
    Column("theta_following", Kind.ANGLE, {"theta_next_deg": DEGREE}),
    Column("dtheta_to_next", Kind.TURN, {"dtheta_to_next_deg": DEGREE}),
)
COLUMNS: Mapping[str, Column] = {column.name: column for column in _ALL}


def named_column(table: CsvTable, column: str) -> str | None:
    """Return the first of a column's names that the header of a table of ours has; None without."""
    return next((name for name in COLUMNS[column].names if name in table.header), None)


def column_value(table: CsvTable, row: CsvRow, column: str) -> Any:
    """Return what a row of a table of ours tells for a column, SI units; NaN, of texts None, where
    it does not.
    """
    name = named_column(table, column)
    text = "" if name is None else table.text(row, name)
    if COLUMNS[column].kind is Kind.TEXT:
        return text or None
    if name is None or not text:
        return math.nan
    return COLUMNS[column].names[name] * table.number(row, name)


# -- tables of one's own
# ---------------------------------------------------------------------------------------------


def _bare(column: str) -> tuple[str, str]:
    """A column's name without its unit, and the unit; both in small letters."""
    name = re.sub(r"[\s.\-/]+", "_", column.strip().lower())
    # One bracket, not a run of them: the search takes no longer than the name is.
    found = re.search(
        r"[_\[(](deg|degrees?|rad|radians|grad|°|mm|cm|m|metres|meters|in|inch|inches|turns?|revs?|revolutions|s|ms|us|ns)[\])]*$",
        name,
    )
    told = name[: found.start()].rstrip("_[(") if found else ""
    if found and told:
        return told.strip("_"), UNIT_WORDS.get(found.group(1), found.group(1))
    return name.strip("_"), ""


def meaning_of(raw: Mapping[str, Array], told: Mapping[str, str]) -> dict[str, str]:
    """Return the column of a file for each name that is told or recognised; InvalidInput where one
    is wanted, or two would do.
    """
    have = ", ".join(list(raw)[:20])
    meaning = {name: column for name, column in told.items() if name != "pose"}
    for name, column in meaning.items():
        if column not in raw:
            raise InvalidInput(f"no column {column} for {name}; it has {have}")
    for name, known in COLUMNS.items():
        if name in meaning:
            continue
        free = [column for column in raw if column not in meaning.values()]
        hits = [column for column in free if known.fits(_bare(column)[0])]
        if len(hits) > 1:
            both = f"{' and '.join(hits)} may both be {name}"
            raise InvalidInput(f"{both}: say which, --columns {name}={hits[0]}")
        if hits:
            meaning[name] = hits[0]
    if "theta1" in meaning and "theta1" not in told and not set(meaning) >= PLACES:
        after = meaning["theta1"]
        told_by = f"Say --columns theta1={after} or theta_next={after}"
        raise InvalidInput(
            f"is {after} the orientation after the push, or before the next one? {told_by}"
        )
    if 0 < len({*QUATERNION} & set(meaning)) < len(QUATERNION):
        raise InvalidInput(f"of a quaternion all of qx, qy, qz, qw are wanted; it has {have}")
    if not {"theta0", "theta", "qw"} & set(meaning):
        # Of a moving object the orientation is wanted at every moment, and pushes are found in it.
        wanted = "theta" if {"t", "episode"} & set(meaning) else "theta0"
        mend = f"say which, --columns {wanted}=NAME"
        raise InvalidInput(
            f"no column of the object's orientation before each push: {mend}; it has {have}"
        )
    return meaning


def unit_of(
    name: str, meaning: Mapping[str, str], raw: Mapping[str, Array], units: Sequence[str]
) -> tuple[str, str]:
    """Return the unit of a column, and how that is said. All angles, and all places, are guessed to
    be alike.
    """
    kind = COLUMNS[name].kind
    known = UNITS_OF[kind]
    told = next((unit for unit in units if unit in known), None)
    if told is not None:
        return told, f" in {told}"
    alike = [name]
    if kind in (Kind.ANGLE, Kind.PLACE):
        alike = [other for other in meaning if COLUMNS[other].kind is kind]
    named = {other: _bare(meaning[other])[1] for other in alike}
    if named[name] in known:
        return named[name], f" in {named[name]}, by its name"
    of_others = {unit for unit in named.values() if unit in known}
    if len(of_others) == 1:
        unit = of_others.pop()
        return unit, f" in {unit}, as its like"
    return _guessed_unit(
        kind, {meaning[other]: raw[meaning[other]] for other in alike if named[other] not in known}
    )


def _guessed_unit(kind: Kind, columns: Mapping[str, Array]) -> tuple[str, str]:
    """The unit of columns that are alike, by their size, and how that is said."""
    reaches = [
        float(np.abs(values[np.isfinite(values)]).max(initial=0.0)) for values in columns.values()
    ]
    least, most = min(reaches), max(reaches)
    if kind is Kind.TIME and most > _AN_EPOCH:
        # A count since 1970: its size tells the unit.
        unit = list(TIME_UNITS)[min(3, math.floor(math.log10(most / _AN_EPOCH) / 3.0))]
        return unit, f" in {unit} since 1970"
    if kind is Kind.TIME:
        unit = "s"
    elif kind is Kind.ANGLE:
        _refuse_likely_turns(most, *next(iter(columns.items())))
        unit = "rad" if least <= _NO_RADIANS and most <= _NO_RADIANS_UNWRAPPED else "deg"
    else:
        unit = "m" if most <= _NO_METRES else "mm"
    reach = "they reach" if len(columns) > 1 else "it reaches"
    return unit, f" in {unit}, guessed: {reach} {most:.4g}"


def _refuse_likely_turns(most: float, name: str, values: Array) -> None:
    """Refuse angles of up to 1 that fill as much of one turn as of one radian."""
    angles = values[np.isfinite(values)]
    if most <= 1.0 and angles.size >= _TELLING and float(np.ptp(angles)) > _MOST_OF_A_TURN:
        told = f"{name} runs from {angles.min():.3g} to {angles.max():.3g}"
        raise DataFileError(f"{told}: are these turns, or radians? Say --units turn or --units rad")
