"""One recorded push or friction scan: its time series, checked, and brought to our axes and sense
of angles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TypeVar

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import read_only
from cyclemap.errors import InvalidInput
from cyclemap.evidence.tables.conventions import RIGHT_HANDED, Convention
from cyclemap.mechanics.slider import Pose

PUSH_TABLES = ("object_pose", "tip_pose", "ft_wrench")
# Beyond these no table-top measurement lies: a damaged number, or one in other units.
LARGEST_POSITION, LARGEST_ANGLE = 100.0, 1e4
_POSE_LIMITS = (1e11, LARGEST_POSITION, LARGEST_POSITION, LARGEST_ANGLE)
_WRENCH_LIMITS = (1e11, 1e5, 1e5, 1e5)


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
        bound = f"it must be a number within {limits[column]:g}"
        raise InvalidInput(
            f"{name}, row {row}, column {column} is {array[row, column]:g}; {bound} (SI units)"
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
