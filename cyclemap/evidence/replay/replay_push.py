"""One recorded push, run again by the simulator along the tip's own path."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import finite_array
from cyclemap.errors import InvalidInput
from cyclemap.evidence.pushes.contact_forces import CONTACT_SLACK
from cyclemap.evidence.pushes.push_files import PushRecord
from cyclemap.evidence.replay.stroke_chain import clearing_shift, push_along, rod_gap
from cyclemap.mechanics import Pose, QuasiStaticModel

# Recorded tips of straight strokes wander by up to 0.15 mm: a bend is more than twice that.
BEND = 0.3e-3
# A tip that goes less far than this does not push.
SHORTEST_PATH = 1e-3
# An object that has moved this far (m, at its rim) moves; recorded poses at rest tremble by less.
_MOVED = 0.5e-3


@dataclass(frozen=True, eq=False)
class TipPath:
    """A path of straight strokes from corner to corner.

    corners : (k, 2) m, in the world frame. travel : (m,) m along the chain at the recorded times; it never falls.
    straightness : largest distance (m) of a recorded place from the chord between the first and the last.
    """

    corners: Array
    travel: Array
    straightness: float

    def place_at(self, travel: Array) -> Array:
        """Return the places (..., 2), m, at travels (...), m."""
        at = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(self.corners, axis=0).T))])
        return np.stack([np.interp(travel, at, self.corners[:, axis]) for axis in (0, 1)], axis=-1)


def tip_path(tip_pose: Array) -> TipPath:
    """Return the chain of straight strokes that stays within 0.3 mm of a recorded tip.

    tip_pose : (m, 3 or more): time (s), x (m), y (m), and what else is recorded. The corners are recorded places,
    chosen by halving at the farthest place (Ramer 1972; Douglas & Peucker 1973). Raises InvalidInput where the tip
    moves less than 1 mm.
    """
    place = finite_array("tip pose", tip_pose, ndim=2)[:, 1:3]
    kept, spans = {0, len(place) - 1}, [(0, len(place) - 1)]
    while spans:
        first, last = spans.pop()
        off = _from_chord(place[first : last + 1])
        farthest = int(off.argmax())
        if off[farthest] > BEND:
            kept.add(first + farthest)
            spans += [(first, first + farthest), (first + farthest, last)]
    corners = sorted(kept)
    # The travel at each recorded place is its projection on its stroke, never falling.
    travel = np.zeros(len(place))
    for first, last in pairwise(corners):
        chord = place[last] - place[first]
        length = float(np.hypot(*chord))
        if length > 0.0:
            along = (place[first : last + 1] - place[first]) @ (chord / length)
            travel[first : last + 1] = travel[first] + np.clip(along, 0.0, length)
    travel = np.maximum.accumulate(travel)
    if travel[-1] < SHORTEST_PATH:
        raise InvalidInput(f"the tip moves {1e3 * travel[-1]:.2g} mm: it pushes nothing")
    return TipPath(place[corners], travel, float(_from_chord(place).max()))


def _from_chord(place: Array) -> Array:
    """Distance of each place from the segment between the first and the last."""
    chord, offset = place[-1] - place[0], place - place[0]
    square = float(chord @ chord)
    share = np.clip(offset @ chord / square, 0.0, 1.0) if square > 0.0 else np.zeros(len(place))
    return np.asarray(np.hypot(*(offset - share[:, None] * chord).T))


@dataclass(frozen=True, eq=False)
class Replay:
    """A recorded push beside its prediction, at the times of the recorded poses.

    time : (n,) s. measured, predicted : (n, 3), x, y (m) and theta (rad, counted along the series).
    travel : (n,) m, the rod's way along its path. tip : (n, 2) m, its place. outline : (k, 2) m, the object's, closed.
    shift : (2,) m, by which the recorded path was moved: the offset that was given, and what takes the rod out of the
        object at the start. start_gap : m, between rod and object there with the offset alone; negative: they overlap.
    straightness : m, how far the path leaves its chord. strokes : how many straight pushes stand for it.
    touched, left : whether the predicted rod touches the object, and has lost it by the end.
    touch_agrees : whether both objects start to move, by 0.5 mm at the rim, within 3 mm of rod travel, or neither does.
    leaving_agrees : whether the rod ends over 3 mm from both objects, or from neither.
    """

    time: Array
    measured: Array
    predicted: Array
    travel: Array
    tip: Array
    shift: Array
    outline: Array
    start_gap: float
    straightness: float
    strokes: int
    touched: bool
    left: bool
    touch_agrees: bool
    leaving_agrees: bool

    @property
    def error(self) -> Array:
        """(n,) m, distance between the predicted and the measured place."""
        return np.asarray(np.hypot(*(self.predicted - self.measured)[:, :2].T))

    @property
    def turn_error(self) -> Array:
        """(n,) rad, predicted minus measured turn."""
        return np.asarray(self.predicted[:, 2] - self.measured[:, 2])

    def summary(self) -> dict[str, Any]:
        """Numbers of the whole push, as `ReplayedPushes.table` tells them: m, rad, counts and whether."""
        weight, found = np.diff(self.travel), dict[str, Any]()
        for name, error in (("error", self.error), ("turn_error", self.turn_error)):
            # The root mean square along the rod's way, by the trapezium rule.
            middle = 0.5 * (error[1:] ** 2 + error[:-1] ** 2)
            mean_square = float(weight @ middle) / float(weight.sum()) if weight.sum() > 0.0 else math.nan
            found |= {name: float(error[-1]), f"rms_{name}": math.sqrt(mean_square)}
        for name, poses in (("measured", self.measured), ("predicted", self.predicted)):
            x, y, turn = (poses[-1] - poses[0]).tolist()
            found |= {f"{name}_motion": math.hypot(x, y), f"{name}_turn": turn}
        told = ("start_gap", "straightness", "strokes", "touched", "left", "touch_agrees", "leaving_agrees")
        return {**found, "shift": math.hypot(*self.shift.tolist()), **{name: getattr(self, name) for name in told}}


def replay_push(record: PushRecord, model: QuasiStaticModel, offset: tuple[float, float] = (0.0, 0.0)) -> Replay:
    """Push the model's slider from the record's first pose along the record's tip path.

    The path is a chain of straight strokes within 0.3 mm of the recorded places; a straight one is a single push. The
    model is quasi-static: the tip's times say where the rod is, its speed changes nothing. A rod that overlaps the
    object at the start by up to 5 mm is an offset between two calibrations: the path is then shifted along the
    outward normal until they touch. `offset` (m) is added to the path before. A rod that never touches predicts no
    motion. Raises InvalidInput for a larger overlap or a tip that does not move; UnsupportedContact and
    ConvergenceError as `QuasiStaticModel.push` does.

    >>> from cyclemap.mechanics import EllipseFriction, Slider
    >>> model = QuasiStaticModel(Slider.mit("rect1"), EllipseFriction.isotropic(0.25))
    >>> still = [[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]
    >>> tip = [[0.0, 0.07, 0.0, 0.0], [1.0, 0.04, 0.0, 0.0]]
    >>> replay = replay_push(PushRecord(still, tip, still), model)
    >>> round(1e3 * replay.summary()["predicted_motion"], 3)
    9.75
    """
    path, start = tip_path(record.tip_pose), Pose(*record.start)
    first = (float(path.corners[0, 0]) + offset[0], float(path.corners[0, 1]) + offset[1])
    shift = clearing_shift(model, start, first) + offset
    run = push_along(model, start, path.corners + shift)
    measured = np.column_stack([record.object_pose[:, 1:3], record.object_angle])
    travel = np.interp(record.object_pose[:, 0], record.tip_pose[:, 0], path.travel)
    predicted, tip = run.pose_at(travel), path.place_at(travel) + shift
    onsets = []
    for poses in (measured, predicted):
        # Travel at which the object begins to move; NaN: never.
        off = poses - poses[0]
        far = np.hypot(*off[:, :2].T) + model.unit * np.abs(off[:, 2]) > _MOVED
        onsets.append(float(travel[far.argmax()]) if far.any() else math.nan)
    last = (float(tip[-1, 0]), float(tip[-1, 1]))
    apart = [rod_gap(model, Pose(*poses[-1].tolist()), last)[0] > CONTACT_SLACK for poses in (measured, predicted)]
    return Replay(
        record.object_pose[:, 0],
        measured,
        predicted,
        travel,
        tip,
        shift,
        model.slider.outline_points(),
        start_gap=rod_gap(model, start, first)[0],
        straightness=path.straightness,
        strokes=len(path.corners) - 1,
        touched=run.touched,
        left=run.left,
        touch_agrees=bool(np.isnan(onsets).all()) or abs(onsets[0] - onsets[1]) <= CONTACT_SLACK,
        leaving_agrees=apart[0] == apart[1],
    )
