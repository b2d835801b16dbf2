"""Measured pushes and drags with known rod paths and end poses from CSV tables, which rows of data
take part, and how far off they are.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cyclemap.arrays import Array, Place, shorter_way
from cyclemap.errors import DataFileError, InvalidInput, unknown_name
from cyclemap.evidence.pushes.push_table import PushTable, in_csv, load_pushes
from cyclemap.evidence.tables.columns import DRAG_ENDS, Row, Selection
from cyclemap.evidence.tables.data_kinds import is_csv
from cyclemap.mechanics import Pose, SidePush
from cyclemap.progress import Progress
from cyclemap.text_files import file_stem

if TYPE_CHECKING:
    import pandas

# Facts of the push table by which rows are selected.
FACTS = ("surface", "object", "speed", "side", "fraction", "angle")
# The robot was further than this from where it was sent: the push is not the one that was asked
# for.
LARGEST_TIP_ERROR = 5e-3
NO_LENGTH = "the data do not tell how far the rod moved: add a column push_mm, or set push_mm"
# How far the best model is off in measured pushes, m and rad, of seven plates on two floors, and in
# drags, rad.
_MISSED = (1.5e-3, math.radians(2.0))
_MISSED_DRAG = math.radians(6.0)
# How far a ruler and a phone are off, m and rad.
READ = (1e-3, math.radians(1.0))
# How far off its mark a rod is set by hand, m along x and y; the names of how a push was set up.
SET_OFF = 2e-3
ROD_OFF = "rod_off_"
# No object lies as it was read to lie, rad.
_LEAST_TURNED = 1e-4


@dataclass(frozen=True)
class RowSelection:
    """The objects whose rows are kept (none: whatever it is), and values of other facts, SI units
    and radians.

    What a row does not tell is not held against it. Raises InvalidInput for an unknown fact.
    """

    objects: tuple[str, ...] = ()
    chosen: Selection = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in self.chosen:
            if name not in FACTS:
                raise unknown_name("fact of a push", name, FACTS)

    def refusal(self, facts: Row) -> str:
        """Return why a row of these facts stays out; empty where it is kept."""
        shape = facts.get("object")
        # Files spell a name as file names can.
        if self.objects and _known(shape) and not {shape, file_stem(str(shape))} & {*self.objects}:
            wanted = f"not {self.objects[0]}" if len(self.objects) == 1 else "of unknown outline"
            return f"of {shape}, {wanted}"
        for name, value in self.chosen.items():
            own = facts.get(name, math.nan)
            if name == "object" or not _known(own):
                continue
            if isinstance(value, str) or isinstance(own, str):
                if str(own) != str(value):
                    return f"of {name} {own}, not {value}"
            elif not math.isclose(own, value, rel_tol=1e-6, abs_tol=1e-9):
                return f"of {name} {own:g}, not {value}"
        return ""


def selected(
    rows: pandas.DataFrame, selection: RowSelection
) -> tuple[pandas.DataFrame, Counter[str]]:
    """Return the rows of a table that take part, and how many stay out, by reason."""
    reasons = [selection.refusal(row) for row in rows.to_dict("records")]
    kept = np.array([not reason for reason in reasons], dtype=bool)
    return rows[kept].reset_index(drop=True), Counter(filter(None, reasons))


def select_pushes(
    path: Path, selection: RowSelection, tables_too: bool, progress: Progress | None = None
) -> tuple[PushTable, Counter[str]]:
    """Return the pushes and scans of a file or tree that take part, and how many stay out, by
    reason.

    tables_too : whether CSV tables count; else files of the MIT layout alone do.
    """
    loaded = load_pushes(path, progress=progress)
    left_out = Counter[str]()
    if not tables_too:
        table, scans = (frame[~in_csv(frame["path"])] for frame in (loaded.table, loaded.scans))
        bad = [file for file in loaded.unreadable if not is_csv(file.path)]
        loaded = replace(loaded, table=table, scans=scans, unreadable=tuple(bad))
    kept = pushes_of(loaded, selection, left_out)
    return replace(kept, unreadable=loaded.unreadable), left_out


def pushes_of(pushes: PushTable, selection: RowSelection, left_out: Counter[str]) -> PushTable:
    """Return the pushes and scans that take part, without what could not be read; how many stay
    out, by reason, is added to ``left_out``.
    """
    (table, without), (scans, without_scans) = (
        selected(frame, selection) for frame in (pushes.table, pushes.scans)
    )
    left_out.update(without + without_scans)
    return replace(pushes, table=table, scans=scans, unreadable=())


def session_name(plate: str, speed: float | None, otherwise: str = "") -> str:
    """Return what a session is called: the plate and its speed, m/s; where that is unknown, what it
    is `otherwise`.

    >>> session_name("hex", 0.02)
    'hex 20 mm/s'
    """
    if speed is None or math.isnan(speed):
        return f"{plate} {otherwise}".strip()
    return f"{plate} {1e3 * speed:.4g} mm/s"


def told(values: Iterable[object]) -> frozenset[str]:
    """Return the texts that a column tells."""
    return frozenset(str(value) for value in values if _known(value))


def _known(value: object) -> bool:
    # NaN is unlike itself.
    return value not in (None, "") and value == value


@dataclass(frozen=True)
class MeasuredPush:
    """A straight push, as measured.

    Parameters
    ----------
    start : Pose
        The object's pose before, world frame.
    end : Pose
        The object's pose after; end.theta is on the lift nearest to start.theta.
    tip_start : tuple[float, float]
        The rod's centre before, (x, y), m, world frame.
    tip_end : tuple[float, float]
        The rod's centre after, m, world frame.
    contact : int, default 0
        Label of the place touched, alike for pushes there.

    Raises
    ------
    InvalidInput
        For a rod that stays where it is.

    Examples
    --------
    >>> from cyclemap import Pose
    >>> from cyclemap.evidence import MeasuredPush
    >>> push = MeasuredPush(Pose(), Pose(0.0, -0.03, 0.2), (0.0, 0.05), (0.0, 0.01))
    >>> round(push.length, 3)
    0.04
    """

    start: Pose
    end: Pose
    tip_start: Place
    tip_end: Place
    contact: int = 0

    def __post_init__(self) -> None:
        if self.tip_start == self.tip_end:
            raise InvalidInput(
                f"a push whose rod stays at {self.tip_start} m moves nothing: leave it out"
            )

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
    """A straight drag by the ring, as measured.

    Parameters
    ----------
    start : Pose
        The object's pose before, world frame.
    end : Pose
        The object's pose after; end.theta nearest to start.theta.
    contact : int, default 0
        Label of drags that belong together.

    Examples
    --------
    >>> from cyclemap import Pose
    >>> from cyclemap.evidence import MeasuredDrag
    >>> drag = MeasuredDrag(Pose(), Pose(0.05, 0.0, -0.4))
    >>> drag.end.theta - drag.start.theta
    -0.4
    """

    start: Pose
    end: Pose
    contact: int = 0


def measured_pushes(rows: pandas.DataFrame) -> tuple[MeasuredPush, ...]:
    """Return the pushes of rows, as `known_columns` tells them, with a pose and a place of the rod
    before and after; but those of a robot that was more than 5 mm from where it was sent.

    Side and fraction, where all are known, label the contact. Raises DataFileError naming file,
    line and mend.
    """
    rows = rows[~(rows["tip_error"] > LARGEST_TIP_ERROR)]
    places = rows[["side", "fraction"]].to_numpy()
    labels = np.arange(len(rows))
    if not np.isnan(places).any():
        labels = np.unique(places, axis=0, return_inverse=True)[1].ravel()
    ends = rows["theta0"] + shorter_way(rows["theta1"] - rows["theta0"])
    pushes = []
    for row, theta1, label in zip(rows.to_dict("records"), ends, labels.tolist(), strict=True):
        start = Pose(row["x0"], row["y0"], row["theta0"])
        end = Pose(row["x1"], row["y1"], theta1)
        rod = (row["tip_x0"], row["tip_y0"]), (row["tip_x1"], row["tip_y1"])
        try:
            pushes.append(MeasuredPush(start, end, *rod, contact=label))
        except InvalidInput as cause:
            raise DataFileError(f"{row['path']}, line {row['line']}: {cause}") from cause
    return tuple(pushes)


def told_push(push: SidePush, facts: Row, length: float) -> SidePush:
    """Return the push that a row of a table tells, and its length; what is NaN stays as in
    ``push``.
    """
    changes = {name: facts[name] for name in ("side", "fraction", "angle")} | {"distance": length}
    known = {name: value for name, value in changes.items() if not math.isnan(value)}
    return replace(push, **known)


def measured_drags(rows: pandas.DataFrame) -> tuple[MeasuredDrag, ...]:
    """Return the drags of rows, as `known_columns` tells them, with a pose before and after."""
    ends = rows["theta1"] + shorter_way(rows["theta_next"] - rows["theta1"])
    poses = rows[[*DRAG_ENDS]].assign(theta_next=ends).to_numpy().tolist()
    drags = []
    for label, (x1, y1, theta1, x2, y2, theta2) in enumerate(poses):
        drags.append(MeasuredDrag(Pose(x1, y1, theta1), Pose(x2, y2, theta2), label))
    return tuple(drags)


def push_noise(read: tuple[float, float]) -> Array:
    """Return the deviation (4,) of measured ends of a push (m, m, rad) that was set up by hand, and
    of a drag (rad), from what a model says.

    read : m and rad, how far off a reading is, before and after; what is wrong of the angle before
        a push is no noise, nor where its rod was set: what follows depends on the push
        (`set_up_errors`). What the best model misses of pushes and drags on real floors comes on
        top; it is taken as independent from push to push, and of a long push as of a short one.

    >>> along, _, turned, dragged = push_noise((1e-3, 0.0)).tolist()
    >>> round(1e3 * along, 3), round(math.degrees(turned), 3), round(math.degrees(dragged), 3)
    (2.062, 2.0, 6.0)
    """
    place, turn = read
    along = math.hypot(place, place, _MISSED[0])
    turned = math.hypot(turn, _MISSED[1])
    dragged = math.hypot(turn, turn, _MISSED_DRAG)
    return np.array((along, along, turned, dragged))


def set_up_errors(read: tuple[float, float]) -> Array:
    """Return the deviation (3,) of how a push was set up by hand from what is read of it: where the
    rod touches the object (m, m), and how the object lay turned (rad).

    read : m and rad, how far off a reading is. The rod is off its mark, and where the object lay is
        only known as well as it was read: as it moves, what is wrong of its angle grows to a place.

    >>> along, _, turned = set_up_errors((1e-3, 0.02)).tolist()
    >>> round(1e3 * along, 3), round(turned, 3)
    (2.236, 0.02)
    """
    along = math.hypot(SET_OFF, read[0])
    return np.array((along, along, max(read[1], _LEAST_TURNED)))
