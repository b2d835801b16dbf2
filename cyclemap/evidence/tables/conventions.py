"""How data count angles and lay their axes: what a robot, a camera or a compass writes, brought to
our own convention.

Ours: x and y in a right-handed frame seen from above, angles counter-clockwise from x.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import finite_number
from cyclemap.errors import DataFileError, unknown_name
from cyclemap.evidence.tables.columns import COLUMNS, WRENCH_COLUMNS, Kind
from cyclemap.protocol.collection_file import data_table

if TYPE_CHECKING:
    import pandas

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
