"""The columns of tables of pushes: what each holds, by which names it goes, in which units.

Whatever reads, turns or writes a table asks here. A column has one name in code, such as theta0; in
tables of ours also names with a unit, such as theta0_deg; elsewhere names that fit its patterns.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from cyclemap.text_files import CsvRow, CsvTable

# A row of a table by its columns: numbers, NaN where unknown, and texts, None where unknown.
Row = dict[str, Any]

DEGREE = math.radians(1.0)
ANGLE_UNITS = {"deg": DEGREE, "rad": 1.0, "turn": 2.0 * math.pi}
LENGTH_UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "inch": 0.0254}
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
UNITS = ANGLE_UNITS | LENGTH_UNITS | TIME_UNITS


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
