"""The columns of tables of pushes: what each holds, by which names it goes, in which units.

Whatever reads, turns or writes a table asks here. A column has one name in code, such as theta0; in
tables of ours also names with a unit, such as theta0_deg; elsewhere names that fit its patterns.
"""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from cyclemap.arrays import Array
from cyclemap.errors import DataFileError, DoubtfulInput, InvalidInput
from cyclemap.text_files import CsvTable, says_nothing

if TYPE_CHECKING:
    import pandas

# A row of a table by its columns: numbers, NaN where unknown, and texts, None where unknown.
Row = dict[str, Any]
# The values of facts, SI units and radians, by which rows are chosen.
Selection = Mapping[str, str | float]

DEGREE = math.radians(1.0)
ANGLE_UNITS = {"deg": DEGREE, "rad": 1.0, "turn": 2.0 * math.pi}
LENGTH_UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "inch": 0.0254}
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
UNITS = ANGLE_UNITS | LENGTH_UNITS | TIME_UNITS
UNIT_WORDS = dict.fromkeys(("degrees", "degree", "°", "grad"), "deg") | {
    **dict.fromkeys(("radian", "radians"), "rad"),
    **dict.fromkeys(("metres", "meters"), "m"),
    **dict.fromkeys(("millimetres", "millimeters"), "mm"),
    "seconds": "s",
    **dict.fromkeys(("in", "inches"), "inch"),
    **dict.fromkeys(("turns", "rev", "revs", "revolutions"), "turn"),
}
# Angles beyond this are no radians, not even where they go on past a turn; places beyond this no
# metres of a table.
_NO_RADIANS, _NO_RADIANS_UNWRAPPED, _NO_METRES = 7.0, 4.0 * math.pi, 3.0
# So many angles that fill so much of one and no more are turns as likely as radians.
_TELLING, _MOST_OF_A_TURN = 8, 0.7
# No cycle scatters by as many radians, and hardly one by as few degrees; orientations all around
# reach over more than so many radians.
_ROUGH, _MOST_OF_A_CIRCLE, _MANY_TURNS = 0.35, 5.6, 200.0
# Times beyond this count from 1970, seconds to 1e11, thousandths of them from there to 1e14, and so
# on.
_AN_EPOCH = 1e8


class Kind(Enum):
    """What a column holds; a turn is a difference of two angles, a place one of two ordinates, a
    slant an angle against the object's own side, which no convention changes.
    """

    ANGLE = "angle"
    TURN = "turn"
    SLANT = "slant"
    PLACE = "place"
    LENGTH = "length"
    TIME = "time"
    NUMBER = "number"
    TEXT = "text"


UNITS_OF: Mapping[Kind, Mapping[str, float]] = {
    Kind.ANGLE: ANGLE_UNITS,
    Kind.SLANT: ANGLE_UNITS,
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
    "0": r"(?:0|i|before(?:_push)?|start|initial|init|pre|vorher|vor|first)",
    "1": r"(?:1|f|after(?:_push)?|end|final|post|nachher|nach|last)",
}
_ROD = r"(?:tip|rod|pusher|finger|tool|robot|ee|tcp)_"
# Words of a name that tell no column from another, where others stand beside them.
_IDLE = (
    r"field|pose|pos|position|transform|translation"
    r"|object|objekt|obj|box|block|slider|tag|marker|body"
)
QUATERNION = ("qx", "qy", "qz", "qw")
# What may be told of a file beside its columns: the topic of a bag, the sheet of a workbook.
OF_THE_FILE = ("pose", "sheet")
# The object's pose before and after a push, and the places of the rod then.
ENDS = ("x0", "y0", "theta0", "x1", "y1", "theta1")
PLACES = {"x0", "y0", "x1", "y1"}
RODS = ("tip_x0", "tip_y0", "tip_x1", "tip_y1")
# Its pose before and after a drag.
DRAG_ENDS = ("x1", "y1", "theta1", "x0n", "y0n", "theta_next")
# Forces and torque on an object, N, and the twist they keep up, m/s, both with the same length.
WRENCH_COLUMNS = ("fx", "fy", "m_over_rho")
TWIST_COLUMNS = ("vx", "vy", "w_times_rho")


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


def _quaternion(name: str) -> tuple[Column, ...]:
    """A part of a moving object's quaternion, and of those before and after a push."""
    words = r"orientation|quat(?:ernion)?|rotation"
    part = rf"(?:(?:(?:{words})_)?q_?{name[1]}|(?:{words})_{name[1]})"
    return Column(name, Kind.NUMBER, {}, (part,)), *_at_ends(f"{name}{{}}", Kind.NUMBER, part)


_NEXT = rf"(?:{_ANGLE}_(?:next|after_reset|after_drag)|next_{_ANGLE}|th0n)(?:_?0)?"
_TIME = r"(?:header_)?(?:stamp_)?(?:t|time|secs?|seconds|zeit)|(?:header_)?stamp"
_MOMENT = r"(?:utc|local|ros|unix|system|elapsed)_time|time_?stamp|date(?:_?time)?|zeitstempel"
_NANOSECONDS = r"(?:header_)?(?:stamp_)?n(?:ano)?secs?"
_REPETITION = r"rep|repetition|push(?:_(?:nr|no|number|index))?|cycle|nr|no|number|id|index"
_LENGTH = r"push_?length|push_?distance|push"
_GOOD = r"(?:is_?)?(?:success(?:ful)?|succeeded|ok|okay|valid|good)"
_BAD = r"(?:is_?)?(?:fail(?:ed|ure)?|invalid|bad|outlier|excluded?|discard(?:ed)?|skip(?:ped)?)"
# In the order in which columns of other tables are looked for; those without a pattern stand in
# tables of ours alone.
_ALL = (
    *_at_ends("theta{}", Kind.ANGLE, _ANGLE, others={"th{}": 1.0, "theta{}_deg": DEGREE}),
    Column("theta_next", Kind.ANGLE, {"th0n": 1.0, "theta_next_deg": DEGREE}, (_NEXT,)),
    Column("theta", Kind.ANGLE, {}, (_ANGLE,)),
    *_at_ends("x{}", Kind.PLACE, "(?:pos_?|t)?x"),
    *_at_ends("y{}", Kind.PLACE, "(?:pos_?|t)?y"),
    Column("x", Kind.PLACE, {}, (r"(?:pos|t)?x",)),
    Column("y", Kind.PLACE, {}, (r"(?:pos|t)?y",)),
    Column("z", Kind.PLACE, {}, (r"(?:pos|t)?z",)),
    Column("t", Kind.TIME, {}, (_TIME, _MOMENT)),
    Column("nanoseconds", Kind.NUMBER, {}, (_NANOSECONDS,)),
    Column("episode", Kind.NUMBER, {}, (r"episode(?:_index|_id)?|trial|push_id",)),
    Column("repetition", Kind.NUMBER, {"rep": 1.0}, (_REPETITION,)),
    Column("length", Kind.LENGTH, {"push_mm": 1e-3}, (_LENGTH,)),
    Column("side", Kind.NUMBER, {"i": 1.0}, ("side",)),
    Column("fraction", Kind.NUMBER, {"s": 1.0}, ("fraction",)),
    Column("surface", Kind.TEXT, {}, ("surface",)),
    Column("object", Kind.TEXT, {"shape": 1.0}, ("object|shape",)),
    *_at_ends("tip_x{}", Kind.PLACE, "x", _ROD),
    *_at_ends("tip_y{}", Kind.PLACE, "y", _ROD),
    *chain.from_iterable(map(_quaternion, QUATERNION)),
    Column("good", Kind.NUMBER, {}, (_GOOD,)),
    Column("bad", Kind.NUMBER, {}, (_BAD,)),
    # Between collections that one table holds.
    Column("run", Kind.TEXT, {}, (r"run(?:_(?:nr|no|number|index|id))?|session|series",)),
    Column("angle", Kind.SLANT, {"t": 1.0}),
    Column("acceleration", Kind.NUMBER, {"a_mm_s2": 1e-3}),
    Column("speed", Kind.NUMBER, {"v_mm_s": 1e-3}),
    Column("tip_error", Kind.LENGTH, {"tip_err_mm": 1e-3}),
    # How far off readings are, and whether rod and object were seen in one frame.
    Column("read_error", Kind.NUMBER, {"error_mm": 1e-3}),
    Column("read_turn_error", Kind.NUMBER, {"error_deg": DEGREE}),
    Column("frames_agree", Kind.NUMBER),
    *(Column(name, Kind.NUMBER) for name in (*WRENCH_COLUMNS, *TWIST_COLUMNS)),
    Column("source", Kind.TEXT),
    Column("dtheta", Kind.TURN),
    Column("force_ratio", Kind.NUMBER),
    # After the drag back; of staircases and pairs.
    Column("x0n", Kind.PLACE),
    Column("y0n", Kind.PLACE),
    Column("theta0_accum", Kind.ANGLE, {"theta0_accum_deg": DEGREE}),
    Column("theta0_mod360", Kind.ANGLE, {"theta0_mod360_deg": DEGREE}),
    Column("dtheta_to_next", Kind.TURN, {"dtheta_to_next_deg": DEGREE}),
    Column("flag", Kind.TEXT),
)
COLUMNS: Mapping[str, Column] = {column.name: column for column in _ALL}
# What may be told of a table: the angle of pushes goes by no name of its own.
_TO_BE_TOLD = (*(name for name, known in COLUMNS.items() if known.patterns), "angle", *OF_THE_FILE)
# Names of the MIT dataset that say what nobody else's do: letters of its file names, and others.
_MIT_LETTERS = {"side": "i", "fraction": "s", "angle": "t"}
_MIT_NAMES = _MIT_LETTERS | {
    "speed": "v_mm_s",
    "acceleration": "a_mm_s2",
    "tip_error": "tip_err_mm",
}


def our_names(header: Collection[str]) -> dict[str, str]:
    """Return the name by which a header of ours has each of the columns that are in it."""
    named = {}
    for column in COLUMNS.values():
        there = [name for name in column.names if name in header]
        if there:
            named[column.name] = there[0]
    return named


def known_columns(
    table: CsvTable, needed: Collection[str] = (), most_lost: float = 1.0
) -> pandas.DataFrame:
    """Return what a table of ours tells: every known column, SI units, NaN (of texts None) where it
    tells nothing, and the `path` and `line` of each row.

    Rows without a number in a column that is needed are left out, and warned of. Raises
    DataFileError where one of these columns is missing, or so large a share of the rows or more
    is lost.
    """
    import pandas

    named = our_names(table.header)
    missing = [column for column in needed if column not in named]
    if missing:
        have = ", ".join(table.header)
        raise table.error(1, f"column {', '.join(missing)} is missing; the header has {have}")
    whole = _with_numbers(table, [named[column] for column in needed], most_lost)
    columns: dict[str, Any] = {}
    for column in COLUMNS.values():
        name = named.get(column.name)
        if column.kind is Kind.TEXT:
            texts = [whole.text(row, name) or None for row in whole.rows] if name else None
            columns[column.name] = texts
        else:
            numbers = column.names[name] * whole.numbers(name, blank=True) if name else math.nan
            columns[column.name] = numbers
    lines = [row.line for row in whole.rows]
    return pandas.DataFrame(columns, range(len(lines))).assign(path=str(table.path), line=lines)


def _with_numbers(table: CsvTable, names: Sequence[str], most_lost: float) -> CsvTable:
    """The rows of a table that have something in all of these columns."""
    lost = dict[int, str]()
    for index, row in enumerate(table.rows):
        for name in names:
            if says_nothing(table.text(row, name)):
                lost.setdefault(index, name)
    if not lost:
        return table
    first, name = next(iter(lost.items()))
    row, count = table.rows[first], f"{len(lost)} of {len(table.rows)} rows"
    if len(lost) >= most_lost * len(table.rows):
        empty = f"{name} is '{table.text(row, name)}'; it must be a number"
        raise table.error(row.line, f"{empty}, and {count} lack one")
    words = f"{count} left out for want of a pose, the first in line {row.line}"
    warnings.warn(f"{table.path}: {words}", DoubtfulInput, stacklevel=6)
    kept = (row for index, row in enumerate(table.rows) if index not in lost)
    return replace(table, rows=tuple(kept))


def our_text(columns: Mapping[str, Any]) -> str:
    """Return columns, SI units, as a table of ours: a CSV text that every reader takes.

    Orientations alone are in degrees, as people look at them.
    """
    import pandas

    if "theta1" in columns:
        return str(pandas.DataFrame(columns).to_csv(index=False, lineterminator="\n"))
    written = {}
    for column, values in columns.items():
        name, factor = [*COLUMNS[column].names.items()][-1]
        is_text = COLUMNS[column].kind is Kind.TEXT
        written[name] = values if is_text else (1.0 / factor) * values
    return str(pandas.DataFrame(written).to_csv(index=False, lineterminator="\n"))


# -- tables of one's own
# ---------------------------------------------------------------------------------------------


# Pixels are no length, but are told from a name.
_PIXELS = "px"
_UNIT = re.compile(
    rf"[_\[(]({'|'.join(sorted([*UNITS, *UNIT_WORDS, _PIXELS], key=len, reverse=True))})[\])]*$"
)


def _bare(column: str) -> tuple[str, str]:
    """A column's name without its unit and idle words, and the unit; both in small letters."""
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", column.strip().lstrip("%/"))
    name = re.sub(r"[\s.\-/]+", "_", apart.lower())
    # One bracket, not a run of them: the search takes no longer than the name is.
    found = _UNIT.search(name)
    told = name[: found.start()].rstrip("_[(") if found else ""
    unit = found.group(1) if found and told else ""
    words = (told if unit else name).strip("_").split("_")
    busy = [word for word in words if not re.fullmatch(_IDLE, word)]
    # A number of an object is none of a push.
    idle = not busy or (len(busy) < len(words) and re.fullmatch(_REPETITION, "_".join(busy)))
    return "_".join(words if idle else busy), UNIT_WORDS.get(unit, unit)


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


def meaning_of(raw: Mapping[str, Array], told: Mapping[str, str]) -> dict[str, str]:
    """Return the column of a file for each name that is told, is the MIT dataset's alone, or is
    recognised; InvalidInput where one is wanted, or two would do.
    """
    have = ", ".join(list(raw)[:20])[:400]
    for name, column in told.items():
        if name not in _TO_BE_TOLD:
            raise InvalidInput(f"--columns {name}=...: know {', '.join(_TO_BE_TOLD)}")
        if name not in OF_THE_FILE and column not in raw:
            raise InvalidInput(f"no column {column} for {name}; it has {have}")
    meaning = {name: column for name, column in told.items() if name not in OF_THE_FILE}
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
            both = f"{' and '.join(hits)} may both be {name}"
            raise InvalidInput(f"{both}: say which, --columns {name}={hits[0]}")
        if hits:
            meaning[name] = hits[0]
    _refuse_half_told(meaning, told, have)
    return meaning


def _mit_columns(raw: Collection[str]) -> dict[str, str]:
    """The columns of a file whose names, with their units, are the MIT dataset's: in the letters of
    its file names where it has all three of them.
    """
    by_name = {column.strip().lower(): column for column in raw}
    names = dict(_MIT_NAMES) if {*_MIT_LETTERS.values()} <= {*by_name} else {}
    names |= {name: own for name, own in _MIT_NAMES.items() if own not in _MIT_LETTERS.values()}
    return {name: by_name[own] for name, own in names.items() if own in by_name}


def _refuse_half_told(meaning: Mapping[str, str], told: Mapping[str, str], have: str) -> None:
    """Refuse columns of which another reading is possible, or some are missing."""
    asked = {"theta1", "theta_next"} & {*told} or "theta_next" in meaning
    if "theta1" in meaning and not asked and not set(meaning) >= PLACES:
        after = meaning["theta1"]
        told_by = f"Say --columns theta1={after} or theta_next={after}; it has no x0, y0, x1, y1"
        raise InvalidInput(
            f"is {after} the orientation after the push, or before the next one? {told_by}"
        )
    for end in ("", "0", "1"):
        if 0 < len({f"{part}{end}" for part in QUATERNION} & set(meaning)) < len(QUATERNION):
            raise InvalidInput(f"of a quaternion all of qx, qy, qz, qw are wanted; it has {have}")
    if not {"theta0", "theta", "qw", "qw0"} & set(meaning):
        # Of a moving object the orientation is wanted at every moment, and pushes are found in it.
        wanted = "theta" if {"t", "episode"} & set(meaning) else "theta0"
        mend = f"say which, --columns {wanted}=NAME"
        raise InvalidInput(
            f"no column of the object's orientation before each push: {mend}; it has {have}"
        )


def unit_of(
    name: str, meaning: Mapping[str, str], raw: Mapping[str, Array], units: Sequence[str]
) -> tuple[float, str]:
    """Return the unit of a column, as its factor to SI units, and how that is said. All angles, and
    all places, are guessed to be alike.
    """
    known, column = UNITS_OF.get(COLUMNS[name].kind, {}), meaning[name]
    told = next((unit for unit in units if unit in known), None)
    if told is not None:
        return known[told], f" in {told}"
    if _MIT_NAMES.get(name) == column.strip().lower():
        return COLUMNS[name].names[_MIT_NAMES[name]], ", as the MIT dataset names it"
    if not known:
        return 1.0, ""
    unit, said = _unit_by_name_or_size(name, meaning, raw)
    return known[unit], f" in {unit}{said}"


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
        mend = "multiply its pixels by the length of one, and name it x0_mm or the like"
        raise InvalidInput(f"{meaning[name]}: {mend}")
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
    least, most = min(reaches), max(reaches)
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
                told = f"{next(iter(columns))} reaches {most:.4g} in steps that may be of either"
                mend = "radians, or degrees? Say --units rad or --units deg"
                raise InvalidInput(f"{told}: {mend}")
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
        low, high = float(known[0].min()), float(known[0].max())
        # Radians that are wrapped begin at 0 or at minus half a turn.
        is_wrapped = low >= -math.pi - 0.01 and high <= (math.pi if low < -0.01 else 6.3) + 0.01
        around = is_wrapped and high - low >= _MOST_OF_A_CIRCLE
        return len(known) == 1 and not around and _scatter(known[0]) > _ROUGH
    # Rows before and after pushes may take turns.
    return most < _MANY_TURNS and any(
        all(_goes_on_in_radians(values[::every]) for values in known) for every in (1, 2)
    )


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
        told = f"{name} runs from {angles.min():.3g} to {angles.max():.3g}"
        raise DataFileError(f"{told}: are these turns, or radians? Say --units turn or --units rad")
