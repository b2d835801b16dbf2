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

from cyclemap.errors import DoubtfulInput
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
QUATERNION = ("qx", "qy", "qz", "qw")
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
    row = table.rows[first]
    count = f"{len(lost)} of {len(table.rows)} rows"
    if len(lost) >= most_lost * len(table.rows):
        raise table.error(
            row.line,
            f"{name} is '{table.text(row, name)}'; it must be a number, and {count} lack one",
        )
    warnings.warn(
        f"{table.path}: {count} left out for want of a pose, the first in line {row.line}",
        DoubtfulInput,
        stacklevel=6,
    )
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
