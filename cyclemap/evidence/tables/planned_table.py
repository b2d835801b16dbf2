"""A table of planned pushes to fill in with a ruler or by a robot, and what it tells once it is
filled in.

A row is a push. It tells how to set it up, in the object's frame and in the room's, and has room
for what is measured before the push (0), after it (1) and after the drag back (2): a pose each, or
the places of two marks on the object. Millimetres and degrees throughout; what is in the object's
frame makes the table readable without the object.
"""

from __future__ import annotations

import cmath
import io
import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cyclemap.arrays import TWO_PI, Place, shorter_way
from cyclemap.errors import DataFileError, DoubtfulInput
from cyclemap.evidence.tables.columns import DRAG_ENDS, ENDS, FRAMES_AGREE, RODS
from cyclemap.evidence.tables.own_files import raw_columns
from cyclemap.evidence.tables.text_tables import Columns
from cyclemap.mechanics import Ellipse, Pose, Slider

# How a push is set up: its number, where the rod touches, how far it goes; the pose that the object
# is put in.
SET_UP = (
    "push",
    "object",
    "side",
    "fraction",
    "angle_deg",
    "push_mm",
    "set_x_mm",
    "set_y_mm",
    "set_theta_deg",
)
# In the object's frame: the rod's centre as it touches, the way it goes, the ring, and the two
# marks.
IN_OBJECT = (
    "rod_x_mm",
    "rod_y_mm",
    "way_x",
    "way_y",
    "mark_a_x_mm",
    "mark_a_y_mm",
    "mark_b_x_mm",
    "mark_b_y_mm",
)
# By what is planned of a push alone such a table is known.
PLANNED = {*SET_UP[6:], *IN_OBJECT}
# How far off a reading of a place or an angle is, a standard deviation.
ERRORS = ("error_mm", "error_deg")
# Where a robot's rod was, in the frame of the poses; left empty, it went as it was planned from the
# object as it lay.
ROD = ("rod_x0_mm", "rod_y0_mm", "rod_x1_mm", "rod_y1_mm")
_STATES = "012"
_WHEN = dict(zip(_STATES, ("before the push", "after the push", "after the drag"), strict=True))
# Marks that are further off than this, or than four readings allow, were mistaken, mm.
_MISTAKEN = 5.0
# An object so near to half a turn from how it was to be set has marks that were swapped, rad.
_SWAPPED = math.radians(30.0)


def pose_columns(state: str) -> tuple[str, str, str]:
    """Return the columns of a measured pose, such as x0_mm."""
    return f"x{state}_mm", f"y{state}_mm", f"theta{state}_deg"


def mark_columns(state: str) -> tuple[str, str, str, str]:
    """Return the columns of the measured places of both marks, such as a_x0_mm."""
    return f"a_x{state}_mm", f"a_y{state}_mm", f"b_x{state}_mm", f"b_y{state}_mm"


def marks_of(slider: Slider) -> tuple[Place, Place]:
    """Return the two places on an object (m, its frame) that are measured: corner 0 and the one
    farthest from it.

    Of an ellipse the ends of its axis along x.

    >>> marks_of(Slider.mit("rect1"))
    ((0.045, 0.045), (-0.045, -0.045))
    """
    outline = slider.outline
    if isinstance(outline, Ellipse):
        return (outline.semi_x, 0.0), (-outline.semi_x, 0.0)
    first = outline.vertices[0]
    return first, max(outline.vertices, key=lambda corner: round(math.dist(corner, first), 9))


def filled_text(path: Path) -> tuple[str, list[str]]:
    """Return what a filled table of planned pushes tells, as a CSV table of measured pushes and
    drags.

    Parameters
    ----------
    path : Path
        The filled table, CSV or Excel.

    Returns
    -------
    text : str
        A CSV table; poses in m and rad. Rows without a measurement before and after the push
        are left out; a drag counts where there is one.
    words : list of str
        What was read.

    Raises
    ------
    DataFileError
        Naming the row, where a state is half measured, marks are where they cannot be, or a
        pose and marks contradict each other; and where no push is filled in.

    Warns
    -----
    DoubtfulInput
        For marks that seem to be swapped, half a turn from `set_theta_deg`.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from cyclemap.evidence import filled_text
    >>> header = "push,object,side,fraction,angle_deg,push_mm,set_x_mm,set_y_mm,set_theta_deg"
    >>> header += ",x0_mm,y0_mm,theta0_deg,x1_mm,y1_mm,theta1_deg"
    >>> header += ",rod_x_mm,rod_y_mm,way_x,way_y,mark_a_x_mm,mark_a_y_mm,mark_b_x_mm,mark_b_y_mm"
    >>> row = "1,rect1,0,0.3,0,100,295,228,30,295,228,30,305,153,-22,18,49.75,0,-1,45,45,-45,-45"
    >>> with tempfile.TemporaryDirectory() as place:
    ...     count = Path(place, "plan.csv").write_text(f"{header}\\n{row}\\n")
    ...     text, words = filled_text(Path(place, "plan.csv"))
    >>> words
    ['plan.csv: 1 of 1 planned pushes filled in, 0 with their drag back']
    >>> text.splitlines()[1].split(",")[:4]
    ['rect1', '1.0', '0.295', '0.228']
    """
    columns = raw_columns(path, {}, growing=False)
    missing = [name for name in (*SET_UP, *IN_OBJECT) if name not in columns]
    if missing:
        raise DataFileError(
            f"{path}: the table has lost its column {missing[0]}: leave all that were planned as "
            "they are"
        )
    planned = [_Row(path, columns, index) for index in range(len(columns["push"]))]
    filled = [row for row in planned if row.pose("0") and row.pose("1")]
    if not filled:
        raise DataFileError(
            f"{path}: no push is filled in: measure the object before and after each, and write "
            "it down"
        )
    swapped = [row for row in filled if row.lies_half_turned]
    if swapped:
        warnings.warn(
            f"{swapped[0].name}: the object lay half a turn from set_theta_deg, as in "
            f"{len(swapped)} of {len(filled)} pushes: if marks a and b were swapped, swap "
            "their columns before, after and after the drag",
            DoubtfulInput,
            stacklevel=2,
        )
    names = ["object", "rep", *ENDS, *RODS, *DRAG_ENDS[3:], *ERRORS]
    import pandas

    frame = pandas.DataFrame([row.told() for row in filled], columns=names)
    if np.isnan([row.numbers(ROD)[0] for row in filled]).all():
        frame[FRAMES_AGREE] = 1
    # Without drags and errors the table tells of none.
    text = str(frame.dropna(axis="columns", how="all").to_csv(index=False, lineterminator="\n"))
    with_drag = sum(row.pose("2") is not None for row in filled)
    return text, [
        f"{path.name}: {len(filled)} of {len(planned)} planned pushes filled in, {with_drag} with "
        "their drag back"
    ]


@dataclass(frozen=True, eq=False)
class _Row:
    """A planned push as it was filled in."""

    path: Path
    columns: Columns
    index: int

    @property
    def name(self) -> str:
        """How it is called: by the number of the push, where that is not lost."""
        push = self.columns["push"][self.index]
        known = math.isfinite(push)
        what = f"push {push:g}" if known else f"row {self.index + 1} below the header"
        return f"{self.path}, {what}"

    def error(self, words: str) -> DataFileError:
        """What is wrong with it."""
        return DataFileError(f"{self.name}: {words}")

    def numbers(self, names: Sequence[str]) -> list[float]:
        """What it has in columns; NaN where there is none."""
        return [
            float(self.columns[name][self.index]) if name in self.columns else math.nan
            for name in names
        ]

    def planned(self, names: Sequence[str]) -> list[float]:
        """What it has in columns that were planned; DataFileError where that was lost."""
        values = self.numbers(names)
        for name, value in zip(names, values, strict=True):
            if not math.isfinite(value):
                raise self.error(f"{name} is no number: leave what was planned as it was")
        return values

    def told(self) -> list[object]:
        """What it tells, m and rad: its object and number, poses and rod of the push, the pose
        after the drag, and how far off readings are.
        """
        start, end, back = (self.pose(state) for state in _STATES)
        assert start is not None and end is not None
        turned = start.theta + shorter_way(end.theta - start.theta)
        rod = self._rod(start)
        dragged = [math.nan] * 3 if back is None else [back.x, back.y, back.theta]
        errors = self.numbers(ERRORS)
        for name, error in zip(ERRORS, errors, strict=True):
            if error < 0.0 or math.isinf(error):
                raise self.error(f"{name} is {error:g}: give 0 or more, or nothing")
        called = [str(self.columns["object"][self.index]), self.columns["push"][self.index]]
        poses = [start.x, start.y, start.theta, end.x, end.y, turned]
        return [*called, *poses, *rod, *dragged, *errors]

    def pose(self, state: str) -> Pose | None:
        """The object's pose in a state, m and rad, by its pose or by its marks; None where neither
        is filled in.
        """
        x, y, theta = self._measured(state, pose_columns(state))
        seen = np.reshape(self._measured(state, mark_columns(state)), (2, 2))
        written = None if math.isnan(x) else Pose(1e-3 * x, 1e-3 * y, math.radians(theta))
        if np.isnan(seen).any():
            return written
        marks = np.reshape(self.planned(IN_OBJECT[4:]), (2, 2))
        reading, reading_turn = np.nan_to_num(self.numbers(ERRORS)).tolist()
        allowed = max(_MISTAKEN, 4.0 * reading)
        if written is not None:
            by_pose = 1e3 * np.array([written.to_world(*mark) for mark in (1e-3 * marks).tolist()])
            off = float(np.max(np.hypot(*(seen - by_pose).T)))
            reach = float(np.max(np.hypot(*marks.T)))
            if off > allowed + 4.0 * math.radians(reading_turn) * reach:
                words = f"{_WHEN[state]} marks and pose contradict each other by {off:.1f} mm"
                raise self.error(f"{words}: leave one of them empty")
            return written
        apart, measured = (complex(*(ends[1] - ends[0])) for ends in (marks, seen))
        if abs(abs(measured) - abs(apart)) > allowed:
            words = f"{_WHEN[state]} marks a and b are {abs(measured):.1f} mm apart, on the object"
            raise self.error(
                f"{words} {abs(apart):.1f} mm: measure them again, or leave the row empty"
            )
        turned = cmath.phase(measured) - cmath.phase(apart)
        middle = Pose(theta=turned).to_world(*marks.mean(axis=0).tolist())
        place = 1e-3 * (seen.mean(axis=0) - middle)
        return Pose(float(place[0]), float(place[1]), turned)

    def _measured(self, state: str, names: Sequence[str]) -> list[float]:
        """What it has in columns that are filled in together, or not at all."""
        values = self.numbers(names)
        empty = [name for name, value in zip(names, values, strict=True) if math.isnan(value)]
        if 0 < len(empty) < len(names):
            raise self.error(
                f"{_WHEN[state]} {empty[0]} is no number; fill in {', '.join(names)}, or none"
            )
        return values

    @property
    def lies_half_turned(self) -> bool:
        """Whether marks say that the object lay half a turn from how it was to be set; a robot's
        poses have any frame.
        """
        start = self.pose("0")
        if start is None or not math.isnan(self.numbers(pose_columns("0"))[0]):
            return False
        planned = math.radians(self.numbers(("set_theta_deg",))[0])
        return math.pi - abs(math.remainder(start.theta - planned, TWO_PI)) < _SWAPPED

    def _rod(self, start: Pose) -> list[float]:
        """Where the rod's centre was before and after a push, m: as a robot says, else as planned
        from where it lay.
        """
        places = self.numbers(ROD)
        if not np.isnan(places).any():
            return [1e-3 * place for place in places]
        if not np.isnan(places).all():
            raise self.error(f"fill in all of {', '.join(ROD)}, or none")
        length, *touch = self.planned(("push_mm", *IN_OBJECT[:4]))
        if length <= 0.0:
            raise self.error(f"push_mm is {length:g}: a push is longer than nothing")
        first = 1e-3 * np.array(touch[:2])
        last = first + 1e-3 * length * np.array(touch[2:])
        return [*start.to_world(*first.tolist()), *start.to_world(*last.tolist())]


def table_bytes(header: Sequence[str], rows: Sequence[Sequence[object]], excel: bool) -> bytes:
    """Return a table as a CSV or an Excel file."""
    import pandas

    frame = pandas.DataFrame(list(rows), columns=list(header))
    if not excel:
        return str(frame.to_csv(index=False, lineterminator="\n")).encode()
    made = io.BytesIO()
    frame.to_excel(made, index=False)
    return made.getvalue()
