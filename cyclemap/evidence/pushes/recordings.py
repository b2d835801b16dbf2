"""One recorded push or friction scan: its time series, checked, and brought to our axes and sense
of angles; and what the name of its file says in the MIT push dataset (Yu et al. 2016).
"""

from __future__ import annotations

import math
import re
from dataclasses import asdict, dataclass, fields
from decimal import Decimal
from functools import cached_property
from pathlib import PurePath
from typing import TypeVar

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import finite_number, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.tables.columns import RIGHT_HANDED, Convention, Row
from cyclemap.mechanics.slider import Pose

PUSH_TABLES = ("object_pose", "tip_pose", "ft_wrench")
# Beyond these no table-top measurement lies: a damaged number, or one in other units.
LARGEST_POSITION = 100.0
LARGEST_ANGLE = 1e4
_POSE_LIMITS = (1e11, LARGEST_POSITION, LARGEST_POSITION, LARGEST_ANGLE)
_WRENCH_LIMITS = (1e11, 1e5, 1e5, 1e5)

_NUMBER = r"[-+]?\d+(?:\.\d+)?"
_BEGIN = rf"surface=(?P<surface>.+)_shape=(?P<object>.+)_a=(?P<a>{_NUMBER})_v=(?P<v>{_NUMBER})"
_END = r"(?:_rep=(?P<rep>\d+))?"
_PLACE = rf"_i=(?P<i>\d+)(?:\.0+)?_s=(?P<s>{_NUMBER})_t=(?P<t>{_NUMBER})"
_PUSH = re.compile(f"motion_{_BEGIN}{_PLACE}{_END}", re.ASCII)
_SCAN = re.compile(f"record_{_BEGIN}_deg=(?P<deg>{_NUMBER}){_END}", re.ASCII)
# The letter of a fact, in which power of ten it is written, and with how many decimals at least.
_LETTERS = {
    "acceleration": ("a", 3, 0),
    "speed": ("v", 3, 0),
    "side": ("i", 0, 3),
    "fraction": ("s", 0, 3),
    "angle": ("t", 0, 3),
    "direction": ("deg", 0, 0),
}
# Letters and digits behind a point; decimals of a number are no suffix.
_SUFFIX = re.compile(r"\.[A-Za-z][A-Za-z0-9]*")


@dataclass(frozen=True, eq=False)
class PushRecord:
    """The time series of one push, each on its own clock, in the world frame.

    Parameters
    ----------
    object_pose : array_like, shape (n, 4)
        Time (s), x (m), y (m), angle (rad, wrapped or not) of the object.
    tip_pose : array_like, shape (m, 4)
        The same of the rod.
    ft_wrench : array_like, shape (k, 4)
        Time (s), fx (N), fy (N), torque (N m), of the object on the rod as the MIT files have
        it.

    Raises
    ------
    InvalidInput
        Naming the table and the row, for a wrong shape, fewer than two rows of a pose, a number
        that is not finite or beyond what a table top holds (100 m, 1e4 rad, 1e5 N: mind the
        units), and for a clock that runs backwards.

    Examples
    --------
    >>> from cyclemap.evidence import PushRecord
    >>> poses = [[0.0, 0.1, 0.0, 3.1], [0.1, 0.1, 0.2, -3.1]]
    >>> push = PushRecord(poses, poses, [[0.0, 0.0, 1.0, 0.0]])
    >>> round(push.turn, 6)
    0.083185
    """

    object_pose: Array
    tip_pose: Array
    ft_wrench: Array

    def __post_init__(self) -> None:
        for name in PUSH_TABLES:
            object.__setattr__(self, name, _checked_series(name, getattr(self, name)))

    @cached_property
    def object_angle(self) -> Array:
        """(n,) rad, the object's angle without jumps of a full turn, from its first value."""
        return read_only(np.unwrap(self.object_pose[:, 3]))

    @property
    def start(self) -> tuple[float, float, float]:
        """The object's first pose: x (m), y (m), angle (rad) as recorded."""
        x, y, theta = self.object_pose[0, 1:].tolist()
        return x, y, theta

    @property
    def end(self) -> tuple[float, float, float]:
        """The object's last pose: x (m), y (m), angle (rad) on the lift that begins at the first
        pose.
        """
        x, y = self.object_pose[-1, 1:3].tolist()
        return x, y, float(self.object_angle[-1])

    @property
    def displacement(self) -> tuple[float, float]:
        """How far the object moved, m, along x and y of its own frame at the start."""
        return Pose(*self.start).to_object(*self.end[:2])

    @property
    def turn(self) -> float:
        """How far the object turned, rad, counted along the series: full turns are not lost."""
        return float(self.object_angle[-1] - self.object_angle[0])

    @property
    def length(self) -> float:
        """How far the rod moved, m: from its first recorded place to its last."""
        x, y = (self.tip_pose[-1, 1:3] - self.tip_pose[0, 1:3]).tolist()
        return math.hypot(x, y)


@dataclass(frozen=True, eq=False)
class ScanRecord:
    """The time series of one friction scan: a straight stroke of the rod that carries the object
    with it.

    Parameters
    ----------
    tip : array_like, shape (m, 4)
        Time (s), x (m), y (m), angle (rad) of the rod.
    ft_wrench : array_like, shape (k, 4)
        As in `PushRecord`, and refused alike.

    Raises
    ------
    InvalidInput
        As `PushRecord`.

    Examples
    --------
    >>> from cyclemap.evidence import ScanRecord
    >>> tip = [[0.0, 0.3, 0.0, 0.0], [1.0, 0.3, 0.1, 0.0]]
    >>> ScanRecord(tip, [[0.0, 0.0, 2.0, 0.0]]).stroke
    (0.0, 0.1)
    """

    tip: Array
    ft_wrench: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "tip", _checked_series("tip_array", self.tip))
        object.__setattr__(self, "ft_wrench", _checked_series("ft_wrench", self.ft_wrench))

    @property
    def stroke(self) -> tuple[float, float]:
        """From the first to the last place of the tip, m, in the world frame."""
        x, y = (self.tip[-1, 1:3] - self.tip[0, 1:3]).tolist()
        return x, y


def _checked_series(name: str, value: object) -> Array:
    """Return a table of (time, and three numbers) as a read-only array, or raise InvalidInput."""
    try:
        array = np.asarray(value)
    except ValueError as cause:
        raise InvalidInput(
            f"{name} has rows of different lengths; it must have 4 columns throughout"
        ) from cause
    if array.dtype.kind not in "iuf":
        raise InvalidInput(
            f"{name} holds something other than numbers (type {array.dtype}); it must hold "
            "numbers only"
        )
    array = array.astype(float)
    least = 1 if name == "ft_wrench" else 2
    if array.ndim != 2 or array.shape[1] != 4 or len(array) < least:
        raise InvalidInput(
            f"{name} has shape {array.shape}; it must have at least {least} rows of 4 columns"
        )
    limits = np.array(_WRENCH_LIMITS if name == "ft_wrench" else _POSE_LIMITS)
    # Written so that NaN counts as out of bounds.
    for row, column in np.argwhere(~(np.abs(array) <= limits))[:1]:
        raise InvalidInput(
            f"{name}, row {row}, column {column} is {array[row, column]:g}; it must be a "
            f"number within {limits[column]:g} (SI units)"
        )
    for row in np.flatnonzero(np.diff(array[:, 0]) < 0.0)[:1]:
        back = array[row, 0] - array[row + 1, 0]
        raise InvalidInput(
            f"{name}: the clock runs backwards by {back:.3g} s behind row {row}; restore the file"
        )
    return read_only(array)


Record = TypeVar("Record", bound=PushRecord | ScanRecord)


def as_ours(record: Record, convention: Convention) -> Record:
    """Return a recording that was written in a convention in ours."""
    if convention.is_ours:
        return record
    handed = 1.0 if convention.frame == RIGHT_HANDED else -1.0

    def ours(series: Array, is_posed: bool) -> Array:
        """Rows of time, x, y and an angle, or time, two forces and a torque."""
        turned = convention.theta(series[:, 3]) if is_posed else handed * series[:, 3]
        places = convention.place(series[:, 1], series[:, 2])
        return np.column_stack([series[:, 0], *places, turned])

    names = [field.name for field in fields(record)]
    return type(record)(*(ours(getattr(record, name), name != "ft_wrench") for name in names))


# -- names of files


@dataclass(frozen=True)
class PushFacts:
    """What the name of a push file says; a fact it does not give is NaN (text: None).

    Attributes
    ----------
    surface, object : str or None
        Names, such as "plywood" and "rect1".
    acceleration : float
        m/s^2, 0 for a push at constant speed.
    speed : float
        m/s; NaN where the name gives a negative one, as names of accelerated pushes do.
    side : float
        Side of the object, counter-clockwise from 0.
    fraction : float
        Place on that side, from its first vertex.
    angle : float
        Of the push against the inner normal, in the object's initial frame, rad.
    repetition : float
        Number of the push in its set.
    """

    surface: str | None = None
    object: str | None = None
    acceleration: float = math.nan
    speed: float = math.nan
    side: float = math.nan
    fraction: float = math.nan
    angle: float = math.nan
    repetition: float = math.nan


@dataclass(frozen=True)
class ScanFacts:
    """What the name of a friction scan says; a fact it does not give is NaN (text: None).

    direction : rad in [0, 2π), the way the object moves in the world: half a turn from the `deg` of
        the name.

    The rest as in `PushFacts`.
    """

    surface: str | None = None
    object: str | None = None
    acceleration: float = math.nan
    speed: float = math.nan
    direction: float = math.nan
    repetition: float = math.nan


def push_facts(path: str | PurePath) -> PushFacts | None:
    """Return the facts in the name of a push file (folders and suffix do not matter); None for any
    other name.

    Names are `motion_surface=S_shape=O_a=A_v=V_i=I_s=F_t=T` with A in mm/s^2, V in mm/s and T in
    rad, and `_rep=NNNN` behind it in repeated sets.
    """
    matched = _PUSH.fullmatch(_bare(path))
    if matched is None:
        return None
    side, fraction, angle = (float(matched[letter]) for letter in "ist")
    return PushFacts(*_motion(matched), side, fraction, angle, float(matched["rep"] or "nan"))


def scan_facts(path: str | PurePath) -> ScanFacts | None:
    """Return the facts in the name of a straight friction scan; None for any other name.

    Names are `record_surface=S_shape=O_a=A_v=V_deg=D_rep=RRR`; scans that also turn the object
    (`rotdeg` in the name) are another kind, and none of these.
    """
    matched = _SCAN.fullmatch(_bare(path))
    if matched is None:
        return None
    direction = math.radians((float(matched["deg"]) + 180.0) % 360.0)
    return ScanFacts(*_motion(matched), direction, float(matched["rep"] or "nan"))


def _bare(path: str | PurePath) -> str:
    """The name of a file without its suffix."""
    name = PurePath(path)
    return name.stem if _SUFFIX.fullmatch(name.suffix) else name.name


def _motion(matched: re.Match[str]) -> tuple[str, str, float, float]:
    """Surface, object, acceleration and speed."""
    # The numbers nearest to a thousandth of the text's.
    acceleration, speed = (float(f"{matched[letter]}e-3") for letter in "av")
    return matched["surface"], matched["object"], acceleration, speed if speed >= 0.0 else math.nan


def push_name(facts: PushFacts) -> str:
    """Return the name of a push file, without folder and suffix, that says these facts: the inverse
    of `push_facts`.

    Numbers have the decimals that names of the dataset have, and more where the exact number needs
    them. Raises InvalidInput where a fact is missing (only the repetition may be) or no name could
    say it.

    >>> push_name(PushFacts("plywood", "rect1", 0.0, 0.02, 0.0, 0.7, 0.0, 12.0))
    'motion_surface=plywood_shape=rect1_a=0_v=20_i=0.000_s=0.700_t=0.000_rep=0012'
    >>> push_facts("motion_surface=pu_shape=hex_a=0_v=5.5_i=1.000_s=0.250_t=-0.349").speed
    0.0055
    """
    name = _name("motion", asdict(facts), 4)
    _require_said(facts, push_facts(name))
    return name


def scan_name(facts: ScanFacts) -> str:
    """Return the name of a friction scan, without folder and suffix: the inverse of `scan_facts`.

    The direction is written in degrees to nine decimals. Raises InvalidInput as `push_name` does.

    >>> scan_name(ScanFacts("pu", "rect1", 0.0, 0.02, math.radians(90.0), 1.0))
    'record_surface=pu_shape=rect1_a=0_v=20_deg=270_rep=001'
    """
    degrees = round(math.degrees(finite_number("direction", facts.direction)) + 180.0, 9) % 360.0
    name = _name("record", {**asdict(facts), "direction": degrees}, 3)
    _require_said(facts, scan_facts(name))
    return name


def _name(kind: str, facts: Row, digits: int) -> str:
    """The name of a file; numbers as exact decimals without exponent."""
    said = [f"{kind}_surface={facts['surface']}_shape={facts['object']}"]
    for fact, (letter, power, decimals) in _LETTERS.items():
        if fact in facts:
            number = Decimal(repr(finite_number(fact, facts[fact]) + 0.0))
            exact = number.scaleb(power).normalize()
            places = max(decimals, -int(exact.as_tuple().exponent))
            said.append(f"{letter}={exact:.{places}f}")
    repetition = facts["repetition"]
    if not math.isnan(repetition):
        count = int(repetition) if float(repetition).is_integer() else repetition
        said.append(f"rep={whole_number('repetition', count, 0):0{digits}d}")
    return "_".join(said)


def _require_said(facts: PushFacts | ScanFacts, seen: PushFacts | ScanFacts | None) -> None:
    """Raise InvalidInput where a name would be read as other facts."""
    again = {} if seen is None else asdict(seen)
    for fact, value in asdict(facts).items():
        is_said = value == again.get(fact)
        if isinstance(value, (int, float)) and fact in again:
            # Directions are written to nine decimals of a degree, and are the same a full turn on.
            both_unknown = math.isnan(value) and math.isnan(again[fact])
            off = math.remainder(value - again[fact], TWO_PI)
            is_said = both_unknown or abs(off) < 1e-10
        if not is_said:
            raise InvalidInput(
                f"no file name can say {facts}: it would be read as {seen}; mend the texts and "
                "numbers"
            )
