"""One recorded push or friction scan: its time series, checked, and the poses at its ends."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import read_only
from cyclemap.errors import InvalidInput

PUSH_TABLES = ("object_pose", "tip_pose", "ft_wrench")

# Beyond these no table-top measurement lies: a damaged number, or one in other units.
LARGEST_POSITION = 100.0
LARGEST_ANGLE = 1e4
LARGEST_TIME = 1e11
LARGEST_FORCE = 1e5
_POSE_LIMITS = (LARGEST_TIME, LARGEST_POSITION, LARGEST_POSITION, LARGEST_ANGLE)
_WRENCH_LIMITS = (LARGEST_TIME, LARGEST_FORCE, LARGEST_FORCE, LARGEST_FORCE)


@dataclass(frozen=True, eq=False)
class PushRecord:
    """The time series of one push, each on its own clock, in the world frame.

    object_pose, tip_pose : (n, 4) and (m, 4): time (s), x (m), y (m), angle (rad, wrapped or not).
    ft_wrench : (k, 4): time (s), fx (N), fy (N), torque (N m), of the object on the rod as the MIT files have it.

    Raises InvalidInput, naming the table and the row, for a wrong shape, fewer than two rows of a pose, a number
    that is not finite or beyond what a table top holds (100 m, 1e4 rad, 1e5 N: mind the units), and for a clock
    that runs backwards.

    >>> poses = [[0.0, 0.1, 0.0, 3.1], [0.1, 0.1, 0.2, -3.1]]
    >>> push = PushRecord(poses, poses, [[0.0, 0.0, 1.0, 0.0]])
    >>> round(push.turn, 6), push.samples
    (0.083185, 2)
    """

    object_pose: Array
    tip_pose: Array
    ft_wrench: Array

    def __post_init__(self) -> None:
        for name in PUSH_TABLES:
            object.__setattr__(self, name, _checked_series(name, getattr(self, name)))

    @classmethod
    def from_tables(cls, tables: Mapping[str, object]) -> PushRecord:
        """Return the push that a file's tables hold; InvalidInput names the tables that are missing."""
        missing = [name for name in PUSH_TABLES if name not in tables]
        if missing:
            raise InvalidInput(f"table {', '.join(missing)} is missing; the file has {_listed(tables)}")
        return cls(*(tables[name] for name in PUSH_TABLES))  # type: ignore[arg-type]

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
        """The object's last pose: x (m), y (m), angle (rad) on the lift that begins at the first pose."""
        x, y = self.object_pose[-1, 1:3].tolist()
        return x, y, float(self.object_angle[-1])

    @property
    def displacement(self) -> tuple[float, float]:
        """How far the object moved, m, along x and y of its own frame at the start."""
        x0, y0, theta0 = self.start
        x1, y1, _ = self.end
        c, s = np.cos(theta0), np.sin(theta0)
        return float(c * (x1 - x0) + s * (y1 - y0)), float(-s * (x1 - x0) + c * (y1 - y0))

    @property
    def turn(self) -> float:
        """How far the object turned, rad, counted along the series: full turns are not lost."""
        return float(self.object_angle[-1] - self.object_angle[0])

    @property
    def length(self) -> float:
        """How far the rod moved, m: from its first recorded place to its last."""
        x, y = (self.tip_pose[-1, 1:3] - self.tip_pose[0, 1:3]).tolist()
        return math.hypot(x, y)

    @property
    def samples(self) -> int:
        """How many poses of the object were recorded."""
        return len(self.object_pose)


@dataclass(frozen=True, eq=False)
class ScanRecord:
    """The time series of one friction scan: a straight stroke of the rod that carries the object with it.

    tip : (m, 4): time (s), x (m), y (m), angle (rad). ft_wrench : (k, 4) as in `PushRecord`, and refused alike.
    """

    tip: Array
    ft_wrench: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "tip", _checked_series("tip_array", self.tip))
        object.__setattr__(self, "ft_wrench", _checked_series("ft_wrench", self.ft_wrench))

    @classmethod
    def from_tables(cls, tables: Mapping[str, object]) -> ScanRecord:
        """Return the scan that a file's tables hold, its tip in `tip_array` or `tip_pose`."""
        tip = tables.get("tip_array", tables.get("tip_pose"))
        if tip is None or "ft_wrench" not in tables:
            raise InvalidInput(f"a scan needs the tables tip_array and ft_wrench; the file has {_listed(tables)}")
        return cls(tip, tables["ft_wrench"])  # type: ignore[arg-type]

    @property
    def stroke(self) -> tuple[float, float]:
        """From the first to the last place of the tip, m, in the world frame."""
        x, y = (self.tip[-1, 1:3] - self.tip[0, 1:3]).tolist()
        return x, y


def _checked_series(name: str, value: object) -> Array:
    """Return a table of (time, and three numbers) as a read-only array, or raise InvalidInput."""
    array = _numbers(name, value)
    least = 1 if name == "ft_wrench" else 2
    if array.ndim != 2 or array.shape[1] != 4 or len(array) < least:
        raise InvalidInput(f"{name} has shape {array.shape}; it must have at least {least} rows of 4 columns")
    limits = np.array(_WRENCH_LIMITS if name == "ft_wrench" else _POSE_LIMITS)
    # Written so that NaN counts as out of bounds.
    for row, column in np.argwhere(~(np.abs(array) <= limits))[:1]:
        bound = f"it must be a number within {limits[column]:g}"
        raise InvalidInput(f"{name}, row {row}, column {column} is {array[row, column]:g}; {bound} (SI units)")
    for row in np.flatnonzero(np.diff(array[:, 0]) < 0.0)[:1]:
        back = array[row, 0] - array[row + 1, 0]
        raise InvalidInput(f"{name}: the clock runs backwards by {back:.3g} s behind row {row}; restore the file")
    return read_only(array)


def _numbers(name: str, value: object) -> Array:
    try:
        array = np.asarray(value)
    except ValueError as cause:
        raise InvalidInput(f"{name} has rows of different lengths; it must have 4 columns throughout") from cause
    if array.dtype.kind not in "iuf":
        raise InvalidInput(f"{name} holds something other than numbers (type {array.dtype}); it must hold numbers only")
    return array.astype(float)


def _listed(tables: Mapping[str, object]) -> str:
    return ", ".join(sorted(tables)[:10]) or "none"
