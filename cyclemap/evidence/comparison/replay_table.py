"""Every recorded push of a collection replayed, a row each, and the errors gathered by object or by
speed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cyclemap.arrays import Place
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.evidence.comparison.replay_push import TOLD, Replay, replay_push
from cyclemap.evidence.motion_check import check_pushes
from cyclemap.evidence.predicted_strokes import frame_shift, loop_of_session
from cyclemap.evidence.pushes.measured_strokes import (
    LARGEST_TIP_ERROR,
    RowSelection,
    select_pushes,
    session_name,
)
from cyclemap.evidence.pushes.push_files import read_push_file
from cyclemap.evidence.pushes.push_table import UnreadableFile
from cyclemap.evidence.pushes.recordings import PushRecord, as_ours
from cyclemap.evidence.tables.columns import ENDS, RODS, Row, Selection, convention_of
from cyclemap.evidence.tables.data_kinds import is_csv
from cyclemap.mechanics import Pusher, QuasiStaticModel, Slider
from cyclemap.mechanics.outline import Polygon
from cyclemap.mechanics.slider import MIT_SHAPE_NAMES
from cyclemap.progress import Progress, part_of
from cyclemap.text_files import file_stem

if TYPE_CHECKING:
    import pandas

# A quarter of the butterfly's outline, mm from its centre: from the middle of the waist to the end
# of the wing. The plate is symmetric about both axes. Nodes of the outline in the dataset's code
# (peterkty/pnpush, shape_db.py, "butt", and its CAD points), whose spline the mesh in
# mcubelab/pdproc (butter.obj) follows within 0.01 mm.
_QUARTER = (
    (27.3790177, 0.0),
    (28.021517, 4.9769114),
    (29.7530391, 9.9489481),
    (32.2795708, 14.9115157),
    (35.3071749, 19.8595996),
    (38.5418302, 24.7884652),
    (41.6895866, 29.6933079),
    (44.4564538, 34.5692232),
    (46.5484518, 39.4117064),
    (47.6716003, 44.215653),
    (47.5723138, 48.9696983),
    (46.2633978, 53.6184558),
    (43.8655401, 58.0887518),
    (40.4997342, 62.3073622),
    (36.2869737, 66.2010628),
    (31.3482126, 69.6966295),
    (25.8045628, 72.7208383),
    (19.7768994, 75.2004648),
    (13.3862555, 77.0622851),
    (6.7536245, 78.233075),
    (0.0, 78.6396103),
)

# Of the dataset's rect1, cut from the same plate: 0.8374 kg on 90 mm by 90 mm; the butterfly's own
# mass is not given there. It scales the forces alone, never the motion.
_PLATE_DENSITY = 0.8374 / 0.0081
_BUTTER_INERTIA = 0.003019
# The rod, and its friction with the objects as measured in pushes of the dataset.
DATASET_PUSHER = Pusher(friction=0.25)
# A thousandth of a degree: far below what a replay is off by.
ACCURACY = 1e-5
# Where the dataset's robot dragged objects to, m.
DATASET_TARGET = (0.35, -0.03)
_FACTS = ("surface", "object", "speed", "acceleration", "side", "fraction", "angle", "repetition")
# Reading the folder is one of so many parts of the work.
_PARTS = 10.0
_A_SCAN = "a friction scan, not a push"
_NO_TIPS = "a table of poses before and after has no tip path to replay"
REPLAY_COLUMNS = (
    *_FACTS,
    "error",
    "turn_error",
    "isotropic_error",
    "isotropic_turn_error",
    "rms_error",
    "rms_turn_error",
    "measured_motion",
    "predicted_motion",
    "measured_turn",
    "predicted_turn",
    "shift",
    *TOLD,
    "path",
)
# What is told of a group of pushes: a column of theirs, and what is taken of it.
_GATHERED = {
    "count": ("error", "size"),
    "mean_error": ("error", "mean"),
    "median_error": ("error", "median"),
    "mean_turn_error": ("turn_error", "mean"),
    "median_turn_error": ("turn_error", "median"),
    "mean_motion": ("measured_motion", "mean"),
    "mean_turn": ("measured_turn", "mean"),
    "mean_rms_error": ("rms_error", "mean"),
    "touch_agrees": ("touch_agrees", "mean"),
    "leaving_agrees": ("leaving_agrees", "mean"),
    "isotropic_mean_error": ("isotropic_error", "mean"),
    "isotropic_mean_turn_error": ("isotropic_turn_error", "mean"),
}


def dataset_sliders() -> dict[str, Slider]:
    """Return the objects of the MIT push dataset by the names that its files use.

    Returns
    -------
    dict of str to Slider
        The eleven objects.

    Notes
    -----
    Mass and inertia of `butter`, the butterfly, are those of its outline in the plate of rect1.

    Examples
    --------
    >>> from cyclemap.evidence import dataset_sliders
    >>> len(dataset_sliders()), dataset_sliders()["butter"].outline.is_convex
    (11, False)
    """
    quarter = np.array(_QUARTER) * 1e-3
    # Counter-clockwise from its end at -y.
    right = np.vstack([quarter[::-1] * (1.0, -1.0), quarter[1:]])
    outline = Polygon(tuple(map(tuple, np.vstack([right, -right[1:-1]]).tolist())))
    mass = _PLATE_DENSITY * outline.area
    butter = Slider(outline, mass, (0.0, 0.0), inertia=_BUTTER_INERTIA, name="butter")
    return {**{name: Slider.mit(name) for name in MIT_SHAPE_NAMES}, "butter": butter}


@dataclass(frozen=True, eq=False)
class ReplayedPushes:
    """Pushes replayed.

    Attributes
    ----------
    table : pandas.DataFrame
        A row a push. `surface`, `object`, `speed` (m/s), `acceleration`, `side`, `fraction`,
        `angle`, `repetition`: by the file's name. `error` (m), `turn_error` (rad, predicted
        minus measured): at the end; `isotropic_error`, `isotropic_turn_error`: of isotropic
        friction under even pressure; `rms_error`, `rms_turn_error`: along the rod's path.
        `measured_motion`, `predicted_motion`, `shift` (m), `measured_turn`, `predicted_turn`
        (rad), `start_gap`, `straightness` (m), `strokes`, `touched`, `left`, `touch_agrees`,
        `leaving_agrees`: as in `Replay`.
    replays : tuple of Replay
        The replays, in the order of the table.
    not_replayed : tuple of UnreadableFile
        The files left out, each with the reason.

    Examples
    --------
    >>> import tempfile
    >>> from cyclemap import CollectionLoop, replay_pushes, simulate_collection
    >>> loop = CollectionLoop.mit("plywood", accuracy=1e-6)
    >>> with tempfile.TemporaryDirectory() as place:
    ...     made = simulate_collection(loop, f"{place}/made", 2)
    ...     replayed = replay_pushes(made.folder, loop)
    >>> replayed.not_replayed, replayed.by("object")["count"].tolist()
    ((), [2])
    """

    table: pandas.DataFrame
    replays: tuple[Replay, ...]
    not_replayed: tuple[UnreadableFile, ...]

    @property
    def mean_errors(self) -> tuple[float, float]:
        """Mean distance (m) and turn (rad) by which the replays are off at the end; NaN where there
        is none.
        """
        return float(self.table["error"].mean()), float(self.table["turn_error"].abs().mean())

    def by(self, *columns: str) -> pandas.DataFrame:
        """Return the errors gathered by columns of the table.

        Parameters
        ----------
        *columns : str
            Names of columns.

        Returns
        -------
        pandas.DataFrame
            A row a group, in order of the columns. `count`; `mean_error`, `median_error` (m)
            and `mean_turn_error`, `median_turn_error` (rad, without sign) at the end;
            `mean_motion` (m), `mean_turn` (rad, without sign) as measured; `relative_error`,
            `relative_turn_error`: mean error over mean motion; `mean_rms_error` (m);
            `isotropic_mean_error`, `isotropic_mean_turn_error`: what isotropic friction misses;
            `touch_agrees`, `leaving_agrees`: shares of the pushes.
        """
        for column in columns:
            if column not in self.table.columns:
                raise InvalidInput(
                    f"no column {column!r} to gather by: know {', '.join(self.table.columns)}"
                )
        turns = ["turn_error", "measured_turn", "isotropic_turn_error"]
        groups = self.table.assign(**self.table[turns].abs()).groupby([*columns], dropna=False)
        gathered = groups.agg(**_GATHERED).reset_index()
        for name, motion in (("error", "mean_motion"), ("turn_error", "mean_turn")):
            share = gathered[f"mean_{name}"] / gathered[motion]
            gathered.insert(gathered.columns.get_loc("mean_rms_error"), f"relative_{name}", share)
        return gathered


def replay_pushes(
    path: str | Path,
    loop: CollectionLoop,
    *,
    select: Selection | None = None,
    progress: Progress | None = None,
) -> ReplayedPushes:
    """Replay every push of a file, a folder or a tree along its own tip path; see `replay_push`.

    Parameters
    ----------
    path : str or Path
        A file, a folder or a tree.
    loop : CollectionLoop
        Its material tells the surface, how plates rest on it, the floor's shape in sessions
        that were seen, and how the frames of each plate's data are shifted; a shape that varies
        with the place is about the dataset's target. Its rod pushes. Its object is known by its
        name, beside those of the dataset, `butter` among them.
    select : mapping, optional
        Values of surface, object, speed, side, fraction, angle (SI, rad) to keep.
    progress : callable, optional
        Called with the fraction done.

    Returns
    -------
    ReplayedPushes
        A row a push, and what was left out.

    Raises
    ------
    InvalidInput
        Where there is no push data at `path`, or none that is selected.

    Notes
    -----
    The layout is that of the MIT dataset, or CSV with a row a push: poses before and after
    (`x0,y0,th0,x1,y1,th1`, m and rad) and the rod's places (`tip_x0,tip_y0,tip_x1,tip_y1`), which
    went straight from one to the other.

    Each push is replayed on isotropic friction, all flat, too, with the same rod, no frame shifted:
    what is known of surface and plates is worth what it gains on that.

    A push that cannot be replayed - its object unknown, the rod over 5 mm inside it at the start, a
    contact outside the model, a table of end poses without a tip path, a robot more than 5 mm from
    where it was sent, a file that cannot be read - is listed in `not_replayed` with the reason.

    Examples
    --------
    >>> import tempfile
    >>> from cyclemap import CollectionLoop, replay_pushes, simulate_collection
    >>> loop = CollectionLoop.mit("plywood", accuracy=1e-6)
    >>> with tempfile.TemporaryDirectory() as place:
    ...     made = simulate_collection(loop, f"{place}/made", 2)
    ...     table = replay_pushes(made.folder, loop).table
    >>> (table["error"] < 0.2 * table["isotropic_error"]).tolist()
    [True, True]
    """
    import pandas

    chosen = dict(select or {})
    selection = RowSelection((str(chosen["object"]),) if "object" in chosen else (), chosen)
    pushes, left = select_pushes(Path(path), selection, True, part_of(progress, 0, _PARTS))
    if not len(pushes.table) and left:
        reasons = ", ".join(f"{count} {why}" for why, count in left.items())
        raise InvalidInput(f"{path}: nothing is selected: {reasons}")
    replayer = _Replayer(loop)
    names = pushes.table["object"]
    # Pushes of an object without a name are replayed as the loop's own.
    of_known = names.isin([*replayer.sliders]) | names.isna()
    check_pushes(replace(pushes, table=pushes.table[of_known]), loop)
    left_out = [*pushes.unreadable]
    left_out += [UnreadableFile(Path(file), _A_SCAN) for file in pushes.scans["path"].unique()]
    rows: list[Row] = []
    replays: list[Replay] = []
    done = 0
    for name, own in pushes.table.groupby("path", sort=False):
        file = Path(str(name))
        if own[[*RODS]].isna().all(axis=None):
            left_out.append(UnreadableFile(file, f"{_NO_TIPS}: no {', '.join(RODS)}"))
            continue
        for push in own.sort_values("line", kind="stable").to_dict("records"):
            try:
                row, replay = replayer.replayed(push)
            except CycleMapError as error:
                left_out.append(UnreadableFile(file, str(error)))
            else:
                rows.append(row)
                replays.append(replay)
            done += 1
            part_of(progress, 1.0 + (_PARTS - 1.0) * done / len(pushes.table), _PARTS)(0.0)
    part_of(progress, 0, 1)(1.0)
    left_out.sort(key=lambda entry: entry.path)
    table = pandas.DataFrame(rows, columns=list(REPLAY_COLUMNS))
    return ReplayedPushes(table, tuple(replays), tuple(left_out))


class _Replayer:
    """Replays the pushes of known objects; the loop of each session is made once."""

    def __init__(self, loop: CollectionLoop) -> None:
        self.loop = replace(loop, accuracy=ACCURACY)
        own = file_stem(loop.slider.name)
        known = dataset_sliders()
        # A table of one's own object need not name it.
        self.of_tables = None if own in known else own
        self.sliders = {**known, own: loop.slider}
        self.models: dict[str, tuple[QuasiStaticModel, QuasiStaticModel]] = {}

    def replayed(self, push: Row) -> tuple[Row, Replay]:
        """Return the row of a push, a row of `PushTable.table`, and its replay; raises
        CycleMapError where there is none.
        """
        material = self.loop.material
        name = push["object"]
        if not isinstance(name, str) and is_csv(push["path"]):
            name = self.of_tables
            if name is None:
                raise InvalidInput(
                    "no column says which object was pushed: add one, object, or give the "
                    "collection file of your own"
                )
        if not isinstance(name, str):
            raise InvalidInput(
                "its name does not say which object was pushed: it is not of the MIT layout"
            )
        if name not in self.sliders:
            raise InvalidInput(
                f"object {name!r} has no outline: neither the material file nor the data's "
                "collection.toml has it"
            )
        session = session_name(name, push["speed"])
        if session not in self.models:
            model = loop_of_session(self.loop, self.sliders[name], session).model
            self.models[session] = model, model.isotropic
        model, plain = self.models[session]
        record = _record(push, (0.0, 0.0) if material.field is None else DATASET_TARGET)
        replay = replay_push(record, model, frame_shift(material, name))
        beside = replay_push(record, plain)
        row = {column: push[column] for column in (*_FACTS, "path")} | replay.summary()
        row["object"] = name
        row["isotropic_error"] = float(beside.error[-1])
        row["isotropic_turn_error"] = float(beside.turn_error[-1])
        return row, replay


def _record(push: Row, origin: Place) -> PushRecord:
    """The recording of a push, with its world's origin at a place, m; of a row of a CSV table its
    poses before and after, between which the rod went straight.
    """
    if math.isnan(push["line"]):
        record = as_ours(read_push_file(push["path"]), convention_of(push["path"]))
        assert isinstance(record, PushRecord)
        series = record.object_pose, record.tip_pose, record.ft_wrench
    else:
        if push["tip_error"] > LARGEST_TIP_ERROR:
            raise InvalidInput(
                f"line {push['line']:.0f}: the robot was {1e3 * push['tip_error']:.3g} mm off its "
                "way"
            )
        before, after = ([push[name] for name in names] for names in (ENDS[:3], ENDS[3:]))
        tips = np.reshape([push[name] for name in RODS], (2, 2))
        times = np.array([[0.0], [1.0]])
        series = (
            np.hstack([times, [before, after]]),
            np.hstack([times, tips, np.zeros((2, 1))]),
            np.zeros((1, 4)),
        )
    poses, tip, wrench = series
    shift = np.array([0.0, *origin, 0.0])
    return PushRecord(poses - shift, tip - shift, wrench)
