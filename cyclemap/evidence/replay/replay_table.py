"""Every recorded push of a collection replayed, a row each, and the errors gathered by object or by
speed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.evidence.motion_check import check_pushes
from cyclemap.evidence.pushes.columns import column_value
from cyclemap.evidence.pushes.conventions import convention_of
from cyclemap.evidence.pushes.measured_strokes import (
    FACTS,
    LARGEST_TIP_ERROR,
    PUSH_END_COLUMNS,
    RowSelection,
    push_ends,
    select_pushes,
    session_name,
    tip_error,
)
from cyclemap.evidence.pushes.mit_names import PushFacts, push_facts
from cyclemap.evidence.pushes.push_files import PushRecord, read_push_file
from cyclemap.evidence.pushes.push_table import CSV_SUFFIX, UnreadableFile
from cyclemap.evidence.replay.replay_push import Replay, replay_push
from cyclemap.mechanics import (
    EllipseFriction,
    FrameShift,
    Material,
    PlatePressure,
    Pusher,
    QuasiStaticModel,
    Slider,
    SurfaceShape,
)
from cyclemap.mechanics.foundation import FLAT, FloorField
from cyclemap.mechanics.material import FloorSession
from cyclemap.mechanics.outline import Polygon
from cyclemap.mechanics.plate_footprint import plate_footprint
from cyclemap.mechanics.slider import MIT_SHAPE_NAMES
from cyclemap.text_files import read_csv_table

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
_Models = tuple[QuasiStaticModel, QuasiStaticModel]
_FACTS = ("surface", "object", "speed", "acceleration", "side", "fraction", "angle", "repetition")
# Reading the folder is this share of the work.
_READING = 0.1
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
    "start_gap",
    "straightness",
    "strokes",
    "touched",
    "left",
    "touch_agrees",
    "leaving_agrees",
    "path",
)


def dataset_sliders() -> dict[str, Slider]:
    """Return the objects of the MIT push dataset by the names that its files use.

    Returns
    -------
    dict[str, Slider]
        The objects of the MIT push dataset by the names that its files use.

    Notes
    -----
    Mass and inertia of `butter`, the butterfly, are those of its outline in the plate of rect1.

    Examples
    --------
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
    """Pushes replayed, a row each, and the files left out, each with the reason; replays in the
    order of the table.

    Attributes
    ----------
    table : pandas.DataFrame
        `surface`, `object`, `speed` (m/s), `acceleration`, `side`, `fraction`, `angle`,
        `repetition`: by the file's name. `error` (m), `turn_error` (rad, predicted minus
        measured): at the end; `isotropic_error`, `isotropic_turn_error`: of isotropic friction
        under even pressure; `rms_error`, `rms_turn_error`: along the rod's path.
        `measured_motion`, `predicted_motion`, `shift` (m), `measured_turn`, `predicted_turn`
        (rad), `start_gap`, `straightness` (m), `strokes`, `touched`, `left`, `touch_agrees`,
        `leaving_agrees`: as in `Replay`.
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
        """Return the errors gathered by columns of the table, a row a group, in order of the
        columns.

        `count`; `mean_error`, `median_error` (m) and `mean_turn_error`, `median_turn_error` (rad,
        without sign) at the end; `mean_motion` (m), `mean_turn` (rad, without sign) as measured;
        `relative_error`, `relative_turn_error`: mean error over mean motion; `mean_rms_error` (m);
        `isotropic_mean_error`, `isotropic_mean_turn_error`: what isotropic friction misses;
        `touch_agrees`, `leaving_agrees`: shares of the pushes.
        """
        for column in columns:
            if column not in self.table.columns:
                raise InvalidInput(
                    f"no column {column!r} to gather by: know {', '.join(self.table.columns)}"
                )
        turns = ("turn_error", "measured_turn", "isotropic_turn_error")
        groups = self.table.assign(**self.table[[*turns]].abs()).groupby(
            list(columns), dropna=False
        )
        mean, median = groups.mean(numeric_only=True), groups.median(numeric_only=True)
        found = {
            "count": groups.size(),
            "mean_error": mean["error"],
            "median_error": median["error"],
            "mean_turn_error": mean["turn_error"],
            "median_turn_error": median["turn_error"],
            "mean_motion": mean["measured_motion"],
            "mean_turn": mean["measured_turn"],
            "relative_error": mean["error"] / mean["measured_motion"],
            "relative_turn_error": mean["turn_error"] / mean["measured_turn"],
            "mean_rms_error": mean["rms_error"],
            "touch_agrees": mean["touch_agrees"],
            "leaving_agrees": mean["leaving_agrees"],
            "isotropic_mean_error": mean["isotropic_error"],
            "isotropic_mean_turn_error": mean["isotropic_turn_error"],
        }
        return self.table.__class__(found).reset_index()


def replay_pushes(
    path: str | Path,
    friction: EllipseFriction,
    *,
    pusher: Pusher = DATASET_PUSHER,
    sliders: Mapping[str, Slider] | None = None,
    plates: Sequence[PlatePressure] = (),
    frames: Sequence[FrameShift] = (),
    floor: SurfaceShape = FLAT,
    sessions: Sequence[FloorSession] = (),
    field: FloorField | None = None,
    select: Mapping[str, str | float] | None = None,
    progress: Callable[[float], None] | None = None,
) -> ReplayedPushes:
    """Replay every push of a file, a folder or a tree along its own tip path; see `replay_push`.

    Parameters
    ----------
    friction : EllipseFriction
        Of the surface; of an isotropic one the coefficient changes no motion.
    sliders : mapping, optional
        The objects by the names in the files; None: those of the dataset, `butter` among them.
    plates : sequence of PlatePressure, optional
        How objects rest on the surface, by the same names; the others are flat, or as built in
        where the floor has a shape.
    floor : SurfaceShape, optional
        Its shape, kPa at 50 mm;
    sessions : sequence of FloorSession, optional
        Its shapes in sessions that were seen, taken for pushes of their plate and speed.
    field : FloorField, optional
        How the floor's shape varies with the place about the dataset's target, kPa.
    frames : sequence of FrameShift, optional
        How the frames of each plate's data are shifted.
    select : mapping, optional
        Values of surface, object, speed, side, fraction, angle (SI, rad) to keep. Each push is
        replayed on isotropic friction, all flat, too, with the same rod, no frame shifted: what
        is known of surface and plates is worth what it gains on that.
    progress : callable, optional
        Called with the fraction done.

    Returns
    -------
    ReplayedPushes

    Raises
    ------
    InvalidInput
        Where there is no push data at `path`, or none that is selected.

    Notes
    -----
    The layout is that of the MIT dataset, or CSV with a row a push: poses before and after
    (`x0,y0,th0,x1,y1,th1`, m and rad) and the rod's places (`tip_x0,tip_y0,tip_x1,tip_y1`),
    which went straight from one to the other.

    A push that cannot be replayed - its object unknown, the rod over 5 mm inside it at the
    start, a contact outside the model, a table of end poses without a tip path, a robot more
    than 5 mm from where it was sent, a file that cannot be read - is listed in `not_replayed`
    with the reason.
    """
    import pandas

    report, chosen = progress or (lambda fraction: None), dict(select or {})
    selection = RowSelection((str(chosen["object"]),) if "object" in chosen else (), chosen)
    found, left = select_pushes(
        Path(path), selection, True, lambda fraction: report(_READING * fraction)
    )
    for name, slider in (sliders or {}).items():
        own = found.table[found.table["object"] == name]
        check_pushes(
            replace(found, table=own),
            CollectionLoop.mit("isotropic", slider=slider, footprint=None),
        )
    objects = dataset_sliders() if sliders is None else sliders
    surface, models = (
        Material("floor", friction, plates=tuple(plates), floor=floor, field=field),
        dict[str, _Models](),
    )
    shapes = {one.name: one.shape for one in sessions}
    shifts = {one.plate: (one.x, one.y) for one in frames}
    rows: list[dict[str, Any]] = []
    replays: list[Replay] = []
    left_out = list(found.unreadable)
    left_out += [
        UnreadableFile(Path(file), "a friction scan, not a push")
        for file in found.scans["path"].unique()
    ]
    files, total, done = found.table["path"].unique(), max(len(found.table), 1), 0
    if not len(files) and left:
        raise InvalidInput(
            f"{path}: nothing is selected: "
            f"{', '.join(f'{count} {why}' for why, count in left.items())}"
        )
    for file in map(Path, files):
        try:
            for facts, record in _recorded(file, selection, left_out):
                done += 1
                try:
                    if facts.object is None:
                        raise InvalidInput(
                            "its name does not say which object was pushed: it is not of the MIT "
                            "layout"
                        )
                    if facts.object not in objects:
                        told = f"object {facts.object!r} has no outline"
                        raise InvalidInput(
                            f"{told}: neither the material file nor the data's collection.toml "
                            "has it"
                        )
                    session = session_name(facts.object, facts.speed)
                    if session not in models:
                        found_there = replace(surface, floor=shapes.get(session, floor))
                        models[session] = _models(objects[facts.object], found_there, pusher)
                    (model, plain), offset = models[session], shifts.get(facts.object, (0.0, 0.0))
                    record = record if field is None else _seen_from(record, DATASET_TARGET)
                    replay = replay_push(record, model, offset)
                    isotropic = (
                        replay if plain is model and not any(offset) else replay_push(record, plain)
                    )
                except CycleMapError as error:
                    left_out.append(UnreadableFile(file, str(error)))
                else:
                    replays.append(replay)
                    plainly = {
                        f"isotropic_{key}": isotropic.summary()[key]
                        for key in ("error", "turn_error")
                    }
                    known = {key: getattr(facts, key) for key in _FACTS}
                    rows.append({**known, **replay.summary(), **plainly, "path": str(file)})
                report(_READING + (1.0 - _READING) * min(done / total, 1.0))
        except CycleMapError as error:
            left_out.append(UnreadableFile(file, str(error)))
    report(1.0)
    left_out.sort(key=lambda entry: entry.path)
    return ReplayedPushes(
        pandas.DataFrame(rows, columns=list(REPLAY_COLUMNS)), tuple(replays), tuple(left_out)
    )


def _models(slider: Slider, surface: Material, pusher: Pusher) -> _Models:
    """The models of an object: on the surface, and on isotropic friction, all flat."""
    friction, footprint = surface.friction, plate_footprint(surface, slider)
    model = QuasiStaticModel(slider, friction, pusher, footprint, accuracy=ACCURACY)
    is_plain = (
        footprint is None and friction.mu_a == friction.mu_b and friction.m0 == friction.n0 == 0.0
    )
    return model, model if is_plain else model.isotropic


def _seen_from(record: PushRecord, place: tuple[float, float]) -> PushRecord:
    """The same push with its world's origin at a place, m."""
    shift = np.array([0.0, *place, 0.0])
    return PushRecord(record.object_pose - shift, record.tip_pose - shift, record.ft_wrench)


def _recorded(
    path: Path, selection: RowSelection, left_out: list[UnreadableFile]
) -> Iterator[tuple[PushFacts, PushRecord]]:
    """The pushes of a file with what is known of each: one of a file of the MIT layout, many of a
    CSV table.
    """
    if path.suffix.lower() != CSV_SUFFIX:
        record = convention_of(path).record(read_push_file(path))
        if not isinstance(record, PushRecord):
            raise InvalidInput("a friction scan, not a push")
        yield push_facts(path) or PushFacts(), record
        return
    table = convention_of(path).table(read_csv_table(path))
    if missing := [name for name in PUSH_END_COLUMNS if name not in table.header]:
        raise InvalidInput(
            f"a table of poses before and after has no tip path to replay: no {', '.join(missing)}"
        )
    for row in table.rows:
        facts = {name: column_value(table, row, name) for name in FACTS}
        if selection.refusal(facts):
            continue
        start, end, tip_start, tip_end = push_ends(table, row)
        if (astray := tip_error(table, row)) > LARGEST_TIP_ERROR:
            left_out.append(
                UnreadableFile(
                    path, f"line {row.line}: the robot was {1e3 * astray:.3g} mm off its way"
                )
            )
            continue
        poses = [[0.0, start.x, start.y, start.theta], [1.0, end.x, end.y, end.theta]]
        tips = [[0.0, *tip_start, 0.0], [1.0, *tip_end, 0.0]]
        yield PushFacts(**facts), PushRecord(poses, tips, [[0.0, 0.0, 0.0, 0.0]])  # type: ignore[arg-type]
