"""One recorded push, run again by the simulator along the tip's own path."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cyclemap.arrays import Array, Place, along_way
from cyclemap.checks import finite_array
from cyclemap.errors import InvalidInput, RodMissesObject, UnsupportedContact
from cyclemap.evidence.pushes.contact_forces import CONTACT_SLACK
from cyclemap.evidence.pushes.recordings import PushRecord
from cyclemap.mechanics import Pose, QuasiStaticModel, WorldPush
from cyclemap.mechanics.outline import nearest_on_polyline

# Recorded tips of straight strokes wander by up to 0.15 mm: a bend is more than twice that.
BEND = 0.3e-3
# A tip that goes less far than this does not push.
_SHORTEST_PATH = 1e-3
# More than this is no offset of a calibration: the record and the outline do not fit each other.
_LARGEST_SHIFT = 5e-3
# Curved outlines are cut into pieces of a thousandth of their size: gaps are exact to 0.1
# micrometre.
_PIECES = 3600
# What is left between rod and object after a shift, and how well gaps of touching rods are known,
# m.
_CLEARANCE = 1e-7
_ROUNDING = 1e-7
_MOST_SHIFTS = 10
# Between its samples a predicted pose is taken to be straight: half a millimetre leaves under a
# micrometre.
_SAMPLE_SPACING = 0.5e-3
# An object that has moved this far (m, at its rim) moves; recorded poses at rest tremble by less.
_MOVED = 0.5e-3
# What is told of a replay as it is.
TOLD = (
    "start_gap",
    "straightness",
    "strokes",
    "touched",
    "left",
    "touch_agrees",
    "leaving_agrees",
)


def tip_path(tip_pose: Array) -> tuple[Array, Array, float]:
    """Return the chain of straight strokes that stays within 0.3 mm of a recorded tip.

    tip_pose : (m, 3 or more): time (s), x (m), y (m), and what else is recorded. The corners (k,
        2), m, are recorded places, chosen by halving at the farthest place (Ramer 1972; Douglas &
        Peucker 1973). With them come the travel (m,) along the chain at the recorded times, which
        never falls, and the largest distance of a place from the chord between the first and the
        last, m.

    Raises InvalidInput where the tip moves less than 1 mm.
    """
    place = finite_array("tip pose", tip_pose, ndim=2)[:, 1:3]
    kept = {0, len(place) - 1}
    spans = [(0, len(place) - 1)]
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
    if travel[-1] < _SHORTEST_PATH:
        raise InvalidInput(f"the tip moves {1e3 * travel[-1]:.2g} mm: it pushes nothing")
    return place[corners], travel, float(_from_chord(place).max())


def _from_chord(place: Array) -> Array:
    """Distance of each place from the segment between the first and the last."""
    return np.asarray(np.hypot(*(place - nearest_on_polyline(place, place[[0, -1]])[0]).T))


def rod_gap(model: QuasiStaticModel, pose: Pose, place: Array) -> tuple[float, Array]:
    """Return the gap (m) between a rod at `place` (m, world frame) and the object, and the outward
    normal (2,) there.

    The gap is negative where the rod reaches into the object; the normal is in the world frame.
    """
    outline = model.slider.outline
    rod = np.array(pose.to_object(*place.tolist()))
    corners = outline.points(_PIECES)
    (nearest,), (edge,) = nearest_on_polyline(rod[np.newaxis], corners)
    offset = rod - nearest
    distance = float(np.hypot(*offset))
    sign = -1.0 if outline.contains(rod) else 1.0
    outward = sign * offset
    if distance < 1e-12:
        # On the outline itself the edge's own normal points out.
        along = corners[edge + 1] - corners[edge]
        outward = np.array([along[1], -along[0]])
    outward = outward / np.hypot(*outward)
    gap = sign * distance - model.pusher.radius
    return gap, np.array(Pose(theta=pose.theta).to_world(*outward))


def clearing_shift(model: QuasiStaticModel, pose: Pose, place: Array) -> Array:
    """Return the least shift (2,), m, world frame, that takes a rod at `place` out of the object;
    zero outside.

    Along the outward normal, until rod and object are 0.1 micrometre apart. Raises InvalidInput
    where 5 mm are not enough: that is no offset between two calibrations.
    """
    shift = np.zeros(2)
    for _ in range(_MOST_SHIFTS):
        gap, normal = rod_gap(model, pose, place + shift)
        if gap >= 0.5 * _CLEARANCE:
            return shift
        shift = shift + (_CLEARANCE - gap) * normal
        if np.hypot(*shift) > _LARGEST_SHIFT:
            break
    depth = 1e3 * np.hypot(*shift)
    most = 1e3 * _LARGEST_SHIFT
    raise InvalidInput(
        f"the rod starts {depth:.3g} mm inside the object, more than the {most:.0f} mm that a "
        "calibration may be off: check the object's outline and the rod's radius"
    )


def push_along(
    model: QuasiStaticModel, pose: Pose, corners: Array
) -> tuple[Array, Array, bool, bool]:
    """Push the object from `pose` with a rod that goes straight from corner to corner, (k, 2), m,
    world frame.

    Returns travels (n,), m along the chain, that never fall, the poses (n, 3) there (m, rad),
    whether the rod ever pushed, and whether it had lost the object by the end. Each stroke is a
    push of its own that starts where the last one ended, in contact or not: quasi-static motion has
    no memory. A rod that loses the object may find it again on a later stroke. Raises
    UnsupportedContact where the rod touches two sides at once or enters the object,
    ConvergenceError where the contact cannot be solved.
    """
    travels = [np.zeros(1)]
    poses = [np.array([[pose.x, pose.y, pose.theta]])]
    done = 0.0
    touched = False
    left = False
    for corner, way in zip(corners, np.diff(corners, axis=0), strict=False):
        x, y = corner.tolist()
        length = math.hypot(*way)
        if length == 0.0:
            continue
        if rod_gap(model, pose, corner)[0] < -_ROUNDING:
            raise UnsupportedContact(
                f"the rod would enter the object at ({x:.4f}, {y:.4f}) m from behind"
            )
        stroke = WorldPush((x, y), math.atan2(way[1], way[0]), length)
        left = touched
        with suppress(RodMissesObject):
            push = model.push(pose, stroke, _SAMPLE_SPACING)
            # Strokes of the engine begin where the rod touches.
            at = done + length - model.unit * push.course.strokes.length
            travels += [np.array([at]), at + push.trajectory.path]
            poses += [poses[-1][-1:], push.trajectory.pose]
            pose = push.end
            touched = True
            left = push.ended == "left"
        done += length
        travels.append(np.array([done]))
        poses.append(poses[-1][-1:])
    return np.maximum.accumulate(np.concatenate(travels)), np.concatenate(poses), touched, left


@dataclass(frozen=True, eq=False)
class Replay:
    """A recorded push beside its prediction, at the times of the recorded poses.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Of the recorded poses, s.
    measured, predicted : ndarray, shape (n, 3)
        x, y (m) and theta (rad, counted along the series).
    travel : ndarray, shape (n,)
        The rod's way along its path, m.
    tip : ndarray, shape (n, 2)
        Its place, m.
    shift : ndarray, shape (2,)
        By which the recorded path was moved, m: the offset that was given, and what takes the
        rod out of the object at the start.
    outline : ndarray, shape (k, 2)
        The object's, closed, m.
    start_gap : float
        Between rod and object at the start with the offset alone, m; negative: they overlap.
    straightness : float
        How far the path leaves its chord, m.
    strokes : int
        How many straight pushes stand for it.
    touched, left : bool
        Whether the predicted rod touches the object, and has lost it by the end.
    touch_agrees : bool
        Whether both objects start to move, by 0.5 mm at the rim, within 3 mm of rod travel, or
        neither does.
    leaving_agrees : bool
        Whether the rod ends over 3 mm from both objects, or from neither.

    Examples
    --------
    >>> from cyclemap import EllipseFriction, QuasiStaticModel, Slider
    >>> from cyclemap.evidence import PushRecord, replay_push
    >>> model = QuasiStaticModel(Slider.mit("rect1"), EllipseFriction.isotropic(0.25))
    >>> still = [[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]
    >>> tip = [[0.0, 0.07, 0.0, 0.0], [1.0, 0.04, 0.0, 0.0]]
    >>> replay = replay_push(PushRecord(still, tip, still), model)
    >>> replay.touched, replay.strokes, round(float(replay.error[-1]), 5)
    (True, 1, 0.00975)
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
        return self.predicted[:, 2] - self.measured[:, 2]

    def summary(self) -> dict[str, float]:
        """Numbers of the whole push, as `ReplayedPushes.table` tells them: m, rad, counts and
        whether.
        """
        weight = np.diff(self.travel)
        numbers = dict[str, float]()
        for name, error in (("error", self.error), ("turn_error", self.turn_error)):
            # The root mean square along the rod's way, by the trapezium rule.
            middle = 0.5 * (error[1:] ** 2 + error[:-1] ** 2)
            square = np.average(middle, weights=weight) if weight.any() else math.nan
            numbers |= {name: float(error[-1]), f"rms_{name}": math.sqrt(square)}
        for name, poses in (("measured", self.measured), ("predicted", self.predicted)):
            x, y, turn = (poses[-1] - poses[0]).tolist()
            numbers |= {f"{name}_motion": math.hypot(x, y), f"{name}_turn": turn}
        numbers["shift"] = math.hypot(*self.shift.tolist())
        return numbers | {name: getattr(self, name) for name in TOLD}


def replay_push(record: PushRecord, model: QuasiStaticModel, offset: Place = (0.0, 0.0)) -> Replay:
    """Push the model's slider from a record's first pose along the record's tip path.

    Parameters
    ----------
    record : PushRecord
        The recording.
    model : QuasiStaticModel
        Slider, surface and rod.
    offset : tuple[float, float], default (0.0, 0.0)
        What is added to the path, (x, y), m.

    Returns
    -------
    Replay
        The recorded push beside its prediction.

    Raises
    ------
    InvalidInput
        For a rod that overlaps the object by more than 5 mm, or a tip that does not move.
    UnsupportedContact, ConvergenceError
        As `QuasiStaticModel.push` does.

    Notes
    -----
    The path is a chain of straight strokes within 0.3 mm of the recorded places; a straight one
    is a single push. The model is quasi-static: the tip's times say where the rod is, its speed
    changes nothing. A rod that overlaps the object at the start by up to 5 mm is an offset
    between two calibrations: the path is then shifted along the outward normal until they
    touch. `offset` (m) is added to the path before. A rod that never touches predicts no
    motion.

    Examples
    --------
    >>> from cyclemap import EllipseFriction, QuasiStaticModel, Slider
    >>> from cyclemap.evidence import PushRecord, replay_push
    >>> model = QuasiStaticModel(Slider.mit("rect1"), EllipseFriction.isotropic(0.25))
    >>> still = [[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]
    >>> tip = [[0.0, 0.07, 0.0, 0.0], [1.0, 0.04, 0.0, 0.0]]
    >>> replay = replay_push(PushRecord(still, tip, still), model)
    >>> round(1e3 * replay.summary()["predicted_motion"], 3)
    9.75
    """
    corners, way, straightness = tip_path(record.tip_pose)
    start = Pose(*record.start)
    first = corners[0] + offset
    shift = clearing_shift(model, start, first) + offset
    at, poses, touched, left = push_along(model, start, corners + shift)
    measured = np.column_stack([record.object_pose[:, 1:3], record.object_angle])
    travel = np.interp(record.object_pose[:, 0], record.tip_pose[:, 0], way)
    bends = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    predicted = along_way(travel, at, poses)
    tip = along_way(travel, bends, corners) + shift
    onsets = []
    apart = []
    for course in (measured, predicted):
        # Travel at which the object begins to move; NaN: never.
        off = course - course[0]
        far = np.hypot(*off[:, :2].T) + model.unit * np.abs(off[:, 2]) > _MOVED
        onsets.append(float(travel[far.argmax()]) if far.any() else math.nan)
        apart.append(rod_gap(model, Pose(*course[-1].tolist()), tip[-1])[0] > CONTACT_SLACK)
    return Replay(
        time=record.object_pose[:, 0],
        measured=measured,
        predicted=predicted,
        travel=travel,
        tip=tip,
        shift=shift,
        outline=model.slider.outline_points(),
        start_gap=rod_gap(model, start, first)[0],
        straightness=straightness,
        strokes=len(corners) - 1,
        touched=touched,
        left=left,
        touch_agrees=bool(np.isnan(onsets).all()) or abs(onsets[0] - onsets[1]) <= CONTACT_SLACK,
        leaving_agrees=apart[0] == apart[1],
    )
