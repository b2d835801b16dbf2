"""Measured pushes and drags with known rod paths and end poses, from CSV tables."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from cyclemap.arrays import shorter_way
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import Pose
from cyclemap.text_files import CsvRow, CsvTable, read_csv_table, require_columns

Place = tuple[float, float]

# The robot was further than this from where it was sent: the push is not the one that was asked for.
LARGEST_TIP_ERROR = 5e-3
PUSH_END_COLUMNS = ("x0", "y0", "th0", "x1", "y1", "th1", "tip_x0", "tip_y0", "tip_x1", "tip_y1")
_DRAG_COLUMNS = ("x1", "y1", "th1", "x0n", "y0n", "th0n")
_CONTACT_COLUMNS = ("i", "s", "t")


@dataclass(frozen=True)
class MeasuredPush:
    """A straight push: the object's poses before and after, the rod's centre before and after (m, world frame).

    end.theta is on the lift nearest to start.theta. contact : label of the place touched, alike for pushes there.
    """

    start: Pose
    end: Pose
    tip_start: Place
    tip_end: Place
    contact: int = 0

    def __post_init__(self) -> None:
        if self.tip_start == self.tip_end:
            raise InvalidInput(f"a push whose rod stays at {self.tip_start} m moves nothing: leave it out")

    @property
    def direction(self) -> float:
        """Direction of the rod's motion, rad, world frame."""
        return math.atan2(self.tip_end[1] - self.tip_start[1], self.tip_end[0] - self.tip_start[0])

    @property
    def length(self) -> float:
        """Length of the rod's path, m."""
        return math.hypot(self.tip_end[0] - self.tip_start[0], self.tip_end[1] - self.tip_start[1])


@dataclass(frozen=True)
class MeasuredDrag:
    """A straight drag by the ring: the object's poses before and after; end.theta nearest to start.theta.

    contact : label of drags that belong together.
    """

    start: Pose
    end: Pose
    contact: int = 0


def read_measured_pushes(
    path: str | Path, select: Mapping[str, str] | None = None, largest_tip_error: float = LARGEST_TIP_ERROR
) -> tuple[MeasuredPush, ...]:
    """Read pushes from a CSV table with `x0,y0,th0,x1,y1,th1,tip_x0,tip_y0,tip_x1,tip_y1` (m, rad).

    select : texts that columns must have, such as {"surface": "abs", "shape": "rect1"}. Rows whose `tip_err_mm`, where
    there is such a column, exceeds `largest_tip_error` (m) are left out. Columns `i` and `s` (side, fraction), where
    present, label the contact. Raises DataFileError naming file, line and mend; InvalidInput where no row is selected.
    """
    table = read_csv_table(path)
    require_columns(table, PUSH_END_COLUMNS)
    rows = [row for row in _selected(table, select) if tip_error(table, row) <= largest_tip_error]
    labels = _contact_labels(table, rows, ("i", "s"))
    return tuple(_push(table, row, label) for row, label in zip(rows, labels, strict=True))


def read_measured_drags(path: str | Path, select: Mapping[str, str] | None = None) -> tuple[MeasuredDrag, ...]:
    """Read drags from a CSV table with `x1,y1,th1` before and `x0n,y0n,th0n` after (m, rad), as pushes are read."""
    table = read_csv_table(path)
    require_columns(table, _DRAG_COLUMNS)
    rows = _selected(table, select)
    labels = range(len(rows))
    return tuple(_drag(table, row, label) for row, label in zip(rows, labels, strict=True))


def _selected(table: CsvTable, select: Mapping[str, str] | None) -> list[CsvRow]:
    wanted = dict(select or {})
    require_columns(table, tuple(wanted))
    rows = [row for row in table.rows if all(table.text(row, key) == value for key, value in wanted.items())]
    if not rows:
        raise InvalidInput(f"{table.path}: no row has {wanted}; look at the columns {', '.join(wanted)}")
    return rows


def tip_error(table: CsvTable, row: CsvRow) -> float:
    """Return how far the robot was from where it was sent (m), 0 where no column tells."""
    return 1e-3 * table.number(row, "tip_err_mm") if "tip_err_mm" in table.header else 0.0


def _contact_labels(table: CsvTable, rows: list[CsvRow], columns: tuple[str, ...]) -> list[int]:
    """A number for each row, equal where all the columns are; its own number where the table lacks them."""
    if any(column not in table.header for column in columns):
        return list(range(len(rows)))
    keys = [tuple(table.number(row, column) for column in columns) for row in rows]
    number = {key: index for index, key in enumerate(sorted(set(keys)))}
    return [number[key] for key in keys]


def _push(table: CsvTable, row: CsvRow, contact: int) -> MeasuredPush:
    x0, y0, theta0, x1, y1, theta1, *tips = (table.number(row, column) for column in PUSH_END_COLUMNS)
    end = Pose(x1, y1, theta0 + float(shorter_way(theta1 - theta0)))
    try:
        return MeasuredPush(Pose(x0, y0, theta0), end, (tips[0], tips[1]), (tips[2], tips[3]), contact)
    except InvalidInput as cause:
        raise table.error(row.line, str(cause)) from cause


def _drag(table: CsvTable, row: CsvRow, contact: int) -> MeasuredDrag:
    x1, y1, theta1, x2, y2, theta2 = (table.number(row, column) for column in _DRAG_COLUMNS)
    return MeasuredDrag(Pose(x1, y1, theta1), Pose(x2, y2, theta1 + float(shorter_way(theta2 - theta1))), contact)
