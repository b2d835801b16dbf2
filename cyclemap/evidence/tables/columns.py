"""The columns of tables of pushes: what each holds, by which names it goes, in which units; and how
data count angles and lay their axes, brought to our own convention.

Whatever reads, turns or writes a table asks here. A column has one name in code, such as theta0; in
tables of ours also names with a unit, such as theta0_deg; elsewhere names that fit its patterns.
`columns.toml` lists them. Our convention: x and y in a right-handed frame seen from above, angles
counter-clockwise from x.
"""

from __future__ import annotations

import math
import re
import tomllib
import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Mask
from cyclemap.checks import finite_number
from cyclemap.errors import DataFileError, DoubtfulInput, unknown_name
from cyclemap.protocol.collection_file import data_table
from cyclemap.text_files import CsvTable, says_nothing

if TYPE_CHECKING:
    import pandas

# A row of a table by its columns: numbers, NaN where unknown, and texts, None where unknown.
Row = dict[str, Any]
# The values of facts, SI units and radians, by which rows are chosen.
Selection = Mapping[str, str | float]

DEGREE = math.radians(1.0)
ANGLE_UNITS = {"deg": DEGREE, "rad": 1.0, "turn": TWO_PI}
LENGTH_UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "inch": 0.0254}
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
UNITS = ANGLE_UNITS | LENGTH_UNITS | TIME_UNITS
Number = TypeVar("Number", float, Array)

# The sense of an angle, and where its zero lies, rad: theta = sense * angle + zero.
ANGLES: Mapping[str, tuple[float, float]] = {
    "counter-clockwise": (1.0, 0.0),
    "clockwise": (-1.0, 0.0),
    "compass": (-1.0, 0.5 * math.pi),
}
RIGHT_HANDED = "right-handed"
MIRRORED = "mirrored"
SWAPPED = "swapped"
FRAMES = (RIGHT_HANDED, MIRRORED, SWAPPED)
OFFSET = "offset_deg"
KEYS = ("angles", "frame", OFFSET)
# A table that was brought to our convention already ends so: what its folder says of the data is
# done.
AS_READ = "_as_read.csv"
_SAID = (
    r"counter-clockwise|clockwise|compass",
    r"right-handed|mirrored|swapped",
    r"plus(-?\d+(?:\.\d+)?(?:e[+-]?\d+)?)deg",
)
_NAMED_LAST = re.compile(
    rf"(?:_({_SAID[0]}))?(?:_({_SAID[1]}))?(?:_{_SAID[2]})?{re.escape(AS_READ)}$"
)


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
    others: Mapping[str, float]
    patterns: tuple[str, ...]

    @property
    def names(self) -> dict[str, float]:
        """All names in tables of ours, that of code first, with the factor to SI units."""
        return {self.name: 1.0, **self.others}

    def fits(self, bare_name: str) -> bool:
        """Whether a name without its unit is this column's by one of the patterns."""
        return any(re.fullmatch(pattern, bare_name) for pattern in self.patterns)


QUATERNION = ("qx", "qy", "qz", "qw")
# The object's pose before and after a push, and the places of the rod then.
ENDS = ("x0", "y0", "theta0", "x1", "y1", "theta1")
PLACES = {"x0", "y0", "x1", "y1"}
RODS = ("tip_x0", "tip_y0", "tip_x1", "tip_y1")
# Its pose before and after a drag.
DRAG_ENDS = ("x1", "y1", "theta1", "x0n", "y0n", "theta_next")
# How far off readings are; and what is told of a table that was planned, in which no rod was
# measured: rods were set by marks on the object.
FRAMES_AGREE = "frames_agree"
READ_ERRORS = ("read_error", "read_turn_error")
# Rows that are alike are one push where no more of them are, and where this share of the others, so
# many at least, has numbers, or orientations, of its own.
_MOST_COPIES = 3
_FEWEST = 6
_TELLING = 0.9
# Forces and torque on an object, N, and the twist they keep up, m/s, both with the same length.
WRENCH_COLUMNS = ("fx", "fy", "m_over_rho")
TWIST_COLUMNS = ("vx", "vy", "w_times_rho")

_TABLE = tomllib.loads(
    (resources.files("cyclemap.evidence.tables") / "columns.toml").read_text(encoding="utf-8")
)
# Units by what else they are called.
UNIT_WORDS: dict[str, str] = {
    word: unit for unit, words in _TABLE["unit_words"].items() for word in words
}


def _columns() -> Iterator[Column]:
    """The columns of the table, words put into their patterns."""
    words = dict[str, str]()
    for word, pattern in _TABLE["words"].items():
        words[word] = pattern.format(**words)
    for name, facts in _TABLE["columns"].items():
        ends = _TABLE["when"] if "{end}" in name else {"": ""}
        for end, when in ends.items():
            known = {**words, "end": end, "when": when}
            others = facts.get("names", {}).items()
            yield Column(
                name.format(**known),
                Kind(facts.get("kind", "number")),
                {other.format(**known): UNITS[unit] if unit else 1.0 for other, unit in others},
                tuple(pattern.format(**known) for pattern in facts.get("patterns", ())),
            )


COLUMNS: Mapping[str, Column] = {column.name: column for column in _columns()}


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

    Rows without a number in a column that is needed, and such as are there again, are left out, and
    warned of. Raises DataFileError where one of these columns is missing, or so large a share of
    the rows or more is lost.
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
    every = pandas.DataFrame(columns, range(len(lines)))
    kept, words = without_repeats(every, lines, "line")
    if words:
        warnings.warn(f"{table.path}: {words}", DoubtfulInput, stacklevel=5)
    placed = every.assign(path=str(table.path), line=lines)
    return placed if kept.all() else placed[kept].reset_index(drop=True)


def without_repeats(rows: pandas.DataFrame, places: Sequence[int], what: str) -> tuple[Mask, str]:
    """Return which measured rows (n,) count: of such as are alike in all columns the first alone;
    and in words which do not.

    Alike rows are the same push where its number, or the orientations before and after it, are
    hardly ever another's: not where coarse readings are of an object that comes to rest. Of a table
    that was planned all stay, to be refused. places : (n,), of the rows in the file, and `what`
    these are.
    """
    again = rows.duplicated()
    marks = rows.filter([FRAMES_AGREE, *READ_ERRORS])
    if not again.any() or marks.notna().any(axis=None):
        return np.full(len(rows), True), ""
    distinct = rows[~again]
    most = int(rows.groupby([*rows], dropna=False, sort=False).size().max())
    own = [
        distinct[[*names]].nunique().min() >= _TELLING * len(distinct)
        for names in (("repetition",), ("theta0", "theta1"))
        if {*names} <= {*rows}
    ]
    if most > _MOST_COPIES or len(distinct) < _FEWEST or not any(own):
        return np.full(len(rows), True), ""
    index = int(np.flatnonzero(again)[0])
    alike = rows.eq(rows.iloc[index]) | (rows.isna() & rows.iloc[index].isna())
    first = int(np.flatnonzero(alike.all(axis=1))[0])
    return ~again.to_numpy(), (
        f"{int(again.sum())} of {len(rows)} rows are there again, all readings the same, and count "
        f"once: the first, {what} {places[index]}, is {what} {places[first]}"
    )


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


@dataclass(frozen=True)
class Convention:
    """How data count angles and lay their axes, seen from above.

    Parameters
    ----------
    angles : str, default 'counter-clockwise'
        "counter-clockwise" from x, "clockwise" from x, or "compass": clockwise from y.
    frame : str, optional
        "right-handed"; "mirrored": y points the other way, as in pictures; "swapped": x stands
        for y and y for x.
    offset : float, default 0.0
        Added to every angle then, rad: the orientation of an object whose angle reads as zero.

    Examples
    --------
    >>> heading = Convention("compass")
    >>> round(math.degrees(heading.theta(math.radians(30.0))))
    60
    >>> Convention(frame="mirrored").place(1.0, 2.0)
    (1.0, -2.0)
    """

    angles: str = "counter-clockwise"
    frame: str = RIGHT_HANDED
    offset: float = 0.0

    def __post_init__(self) -> None:
        if self.angles not in ANGLES:
            raise unknown_name("sense of angles", self.angles, ANGLES)
        if self.frame not in FRAMES:
            raise unknown_name("frame", self.frame, FRAMES)
        object.__setattr__(self, "offset", finite_number("offset of angles", self.offset))

    @classmethod
    def of_keys(cls, given: Mapping[str, object]) -> Convention:
        """Return what keys of a file, or options, say; None says nothing. InvalidInput for an
        unknown key or word.
        """
        for key in given:
            if key not in KEYS:
                raise unknown_name("key of [data]", key, KEYS)
        words = {
            name: str(given[name]) for name in ("angles", "frame") if given.get(name) is not None
        }
        degrees = given.get("offset_deg")
        return cls(
            **words,
            offset=0.0 if degrees is None else math.radians(finite_number("offset_deg", degrees)),
        )

    @property
    def is_ours(self) -> bool:
        """Whether nothing is to be changed."""
        return self == Convention()

    @property
    def sense(self) -> float:
        """1 where angles grow counter-clockwise, else -1."""
        return ANGLES[self.angles][0]

    def theta(self, angle: Number) -> Number:
        """Return the orientation, rad, of an angle of the data."""
        sense, zero = ANGLES[self.angles]
        return sense * angle + (zero + self.offset)

    def place(self, x: Number, y: Number) -> tuple[Number, Number]:
        """Return a place, or a vector, of the data in our frame."""
        if self.frame == SWAPPED:
            return y, x
        return (x, -y) if self.frame == MIRRORED else (x, y)

    @property
    def said(self) -> dict[str, str]:
        """What it says, by the keys of [data]."""
        degrees = f"{math.degrees(self.offset) + 0.0:.6g}"
        return dict(zip(KEYS, (self.angles, self.frame, degrees), strict=True))

    def changes(self, *others: Convention) -> dict[str, str]:
        """Return what it says otherwise than one of the others."""
        return {
            key: value
            for key, value in self.said.items()
            if any(other.said[key] != value for other in others)
        }

    def options(self, instead: Convention | None = None) -> str:
        """Return the options of the command line that say it.

        instead : what a collection file says; what differs from that is said, too.

        >>> Convention("clockwise", "mirrored").options()
        '--angles clockwise --frame mirrored'
        >>> Convention().options(instead=Convention("clockwise"))
        '--angles counter-clockwise'
        """
        changes = self.changes(OURS, OURS if instead is None else instead).items()
        options = (f"--{key.replace('_', '-')} {value}" for key, value in changes)
        return " ".join(options) or "--angles counter-clockwise --frame right-handed"

    def words(self) -> str:
        """Return what it says, in words."""
        angle = f"{self.angles} from x, seen from above"
        if self.angles == "compass":
            angle = "compass headings, clockwise from y"
        offset = f", {math.degrees(self.offset):.6g}° added" if self.offset else ""
        return f"axes {self.frame}, angles {angle}{offset}"

    def direction(self, angle: float) -> float:
        """Return the direction of a motion, rad, that data tell by its angle from their x towards
        their y.
        """
        x, y = self.place(math.cos(angle), math.sin(angle))
        return math.atan2(y, x)

    def rows(self, rows: pandas.DataFrame) -> pandas.DataFrame:
        """Return rows, SI units and our names, in our convention.

        Of a place of which one ordinate is NaN both are. DataFileError for wrenches and twists, of
        which nobody knows how they were turned.
        """
        if not self.is_ours and rows.filter(WRENCH_COLUMNS).notna().any(axis=None):
            raise DataFileError(
                f"{rows['path'].iloc[0]}: wrenches and twists are read with {OURS.words()} alone, "
                f"not {self.options()}: bring them to that"
            )
        columns = {name: rows[name].to_numpy() for name in COLUMNS if name in rows}
        ours = dict[str, Array]()
        for name, values in columns.items():
            kind = COLUMNS[name].kind
            y_name = name.replace("x", "y")
            if kind is Kind.ANGLE:
                ours[name] = self.theta(values)
            elif kind is Kind.TURN:
                ours[name] = self.sense * values
            elif kind is Kind.PLACE and name != y_name and y_name in columns:
                known = np.isfinite(values) & np.isfinite(columns[y_name])
                for own, place in zip(
                    (name, y_name), self.place(values, columns[y_name]), strict=True
                ):
                    ours[own] = np.where(known, place, math.nan)
        return rows.assign(**ours)


OURS = Convention()


def as_read_name(stem: str, given: Mapping[str, object]) -> str:
    """Return the file name of a table brought to our convention: it says what was told of the one
    it was in.

    >>> as_read_name("log", {"angles": "clockwise", "frame": None})
    'log_clockwise_as_read.csv'
    >>> written_convention("log_clockwise_as_read.csv")[0].angles
    'clockwise'
    """
    words = [str(given[name]) for name in ("angles", "frame") if given.get(name)]
    words += [f"plus{given['offset_deg']}deg"] if given.get("offset_deg") else []
    return "_".join((stem, *words)) + AS_READ


def written_convention(data: str | Path) -> tuple[Convention, bool]:
    """Return the convention in which data were written before anything was done to them, and
    whether all was told.
    """
    name = Path(data).name
    keys: dict[str, object] = dict(data_table(data))
    if name.endswith(AS_READ):
        ending = _NAMED_LAST.search(name)
        assert ending is not None
        keys = {key: value for key, value in zip(KEYS, ending.groups(), strict=True) if value}
        if "offset_deg" in keys:
            keys["offset_deg"] = float(str(keys["offset_deg"]))
    return Convention.of_keys(keys), {"angles", "frame"} <= {*keys}


def convention_of(
    data: str | Path,
    angles: str | None = None,
    frame: str | None = None,
    offset_deg: float | None = None,
) -> Convention:
    """Return the convention of data: what is told, else what the table [data] of their folder's
    collection.toml says.

    A file that was brought to ours already, as its name tells, is in ours. Raises InvalidInput for
    an unknown word.
    """
    keys = {"angles": angles, "frame": frame, "offset_deg": offset_deg}
    given = {name: value for name, value in keys.items() if value is not None}
    if Path(data).name.endswith(AS_READ):
        return Convention.of_keys(given)
    return Convention.of_keys({**data_table(data), **given})
