"""Pushing along a chain of straight strokes: the contact goes on from one to the next, on curves along chords."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import read_only
from cyclemap.errors import InvalidInput, UnsupportedContact
from cyclemap.evidence.pushes.contact_forces import nearest_on_polyline
from cyclemap.mechanics import DragBack, Ellipse, Pose, QuasiStaticModel, SidePush, WorldPush
from cyclemap.mechanics.contact_curve import ContactCurve, SidePiece
from cyclemap.mechanics.engine.strokes import piece_table
from cyclemap.mechanics.first_touch import first_touches
from cyclemap.mechanics.outline import Outline, Polygon
from cyclemap.mechanics.quasi_static import run_strokes
from cyclemap.mechanics.trajectory import Course

# More than this is no offset of a calibration: the record and the outline do not fit each other.
LARGEST_SHIFT = 5e-3
# Curved outlines are cut into pieces of a thousandth of their size: gaps are exact to 0.1 micrometre.
_PIECES = 3600
# What is left between rod and object after a shift.
_CLEARANCE = 1e-7
_MOST_SHIFTS = 10
# Between its samples a predicted pose is taken to be straight: half a millimetre leaves under a micrometre.
SAMPLE_SPACING = 0.5e-3
# Gaps of touching rods are known to this, m.
_ROUNDING = 1e-7
# A polygon none of whose corners turns by more than this (rad) is a curve cut up: those of objects turn by far more.
LARGEST_BEND = math.radians(20.0)
# Pieces that each side is cut into; what the curve bends within one is no error, for its normal is interpolated.
_FINER = 8
# Rod travel (m) over which the outline is taken to be straight.
STEP = 2e-3
# Gaps under this (m) are contact; a rod that moves away is looked for again after the second.
_CONTACT, _APART = 1e-7, 1e-5
# A rod whose direction has less than this of the normal in it does not near the object.
_NEARING = 1e-6
# The chord is a side as long as it need be, in units of the footprint.
_ENDLESS = 1e3


@dataclass(frozen=True, eq=False)
class ChainRun:
    """The object's poses along a chain of strokes.

    travel : (n,) m along the chain, never falling. pose : (n, 3) x, y (m), theta (rad). touched : whether the rod
    ever pushed. left : whether the rod had lost the object by the end of the chain.
    """

    travel: Array
    pose: Array
    touched: bool
    left: bool

    def pose_at(self, travel: Array) -> Array:
        """Return the poses (..., 3) at travels (...), m."""
        return np.stack([np.interp(travel, self.travel, self.pose[:, column]) for column in range(3)], axis=-1)


def rod_gap(model: QuasiStaticModel, pose: Pose, place: tuple[float, float]) -> tuple[float, Array]:
    """Return the gap (m) between a rod at `place` (m, world frame) and the object, and the outward normal (2,) there.

    The gap is negative where the rod reaches into the object; the normal is in the world frame.
    """
    outline = model.slider.outline
    rod = np.array(pose.to_object(*place))
    corners = outline.points(_PIECES)
    (place_on,), (edge,) = nearest_on_polyline(rod[np.newaxis], corners)
    offset = rod - place_on
    distance = float(np.hypot(*offset))
    inside = bool(outline.contains(rod))
    outward = -offset if inside else offset
    if distance < 1e-12:
        # On the outline itself the edge's own normal points out.
        along = corners[edge + 1] - corners[edge]
        outward = np.array([along[1], -along[0]])
    outward = outward / np.hypot(*outward)
    gap = (-distance if inside else distance) - model.pusher.radius
    return gap, np.array(Pose(theta=pose.theta).to_world(*outward))


def clearing_shift(model: QuasiStaticModel, pose: Pose, place: tuple[float, float]) -> Array:
    """Return the least shift (2,), m, world frame, that takes a rod at `place` out of the object; zero outside.

    Along the outward normal, until rod and object are 0.1 micrometre apart. Raises InvalidInput where 5 mm are not
    enough: that is no offset between two calibrations.
    """
    shift = np.zeros(2)
    for _ in range(_MOST_SHIFTS):
        gap, normal = rod_gap(model, pose, (place[0] + float(shift[0]), place[1] + float(shift[1])))
        if gap >= 0.5 * _CLEARANCE:
            return shift
        shift = shift + (_CLEARANCE - gap) * normal
        if np.hypot(*shift) > LARGEST_SHIFT:
            break
    raise InvalidInput(
        f"the rod starts {1e3 * np.hypot(*shift):.3g} mm inside the object, more than the {1e3 * LARGEST_SHIFT:.0f} mm "
        "that a calibration may be off: check the object's outline and the rod's radius"
    )


def push_along(model: QuasiStaticModel, pose: Pose, corners: Array) -> ChainRun:
    """Push the object from `pose` with a rod that goes straight from corner to corner, (k, 2), m, world frame.

    Each stroke is a push of its own that starts where the last one ended, in contact or not: quasi-static motion has
    no memory. A rod that loses the object may find it again on a later stroke. Raises UnsupportedContact where the
    rod touches two sides at once or enters the object, ConvergenceError where the contact cannot be solved.
    """
    travels, poses = [np.zeros(1)], [np.array([[pose.x, pose.y, pose.theta]])]
    done, touched, left = 0.0, False, False
    for start, end in pairwise(corners):
        length = math.hypot(*(end - start))
        if length == 0.0:
            continue
        place, direction = (float(start[0]), float(start[1])), math.atan2(*(end - start)[::-1].tolist())
        if rod_gap(model, pose, place)[0] < -_ROUNDING:
            raise UnsupportedContact(
                f"the rod would enter the object at ({place[0]:.4f}, {place[1]:.4f}) m from behind"
            )
        rod = np.array(pose.to_object(*place)) / model.unit
        touch = first_touches(model.curve.pieces, model.radius, rod[None], np.array([direction - pose.theta]))[0]
        left = touched
        if touch[0] * model.unit < length:
            push = model.push(pose, WorldPush(place, direction, length), SAMPLE_SPACING)
            course, at = push.trajectory, done + max(float(touch[0]), 0.0) * model.unit
            travels += [np.array([at]), at + course.path]
            poses += [poses[-1][-1:], course.pose]
            pose, touched, left = push.end, True, push.ended == "left"
        done += length
        travels.append(np.array([done]))
        poses.append(poses[-1][-1:])
    travel = np.maximum.accumulate(np.concatenate(travels))
    return ChainRun(read_only(travel), read_only(np.concatenate(poses)), touched, left)


@dataclass(frozen=True, eq=False)
class CutCurve:
    """A smooth closed curve, finely sampled: places (n, 2), m, counter-clockwise, and the outward normals (n, 2) there.

    The last place is the first again.
    """

    place: Array
    normal: Array

    def nearest(self, rod: Array) -> tuple[float, Array, Array]:
        """Return the signed distance (m) of a place (2,) from the curve, its foot on it, and the normal at the foot.

        The distance is negative inside.
        """
        first, edge = self.place[:-1], np.diff(self.place, axis=0)
        share = np.clip(((rod - first) * edge).sum(1) / (edge * edge).sum(1), 0.0, 1.0)
        index = int(((rod - first - share[:, None] * edge) ** 2).sum(1).argmin())
        foot = first[index] + share[index] * edge[index]
        mixed = (1.0 - share[index]) * self.normal[index] + share[index] * self.normal[index + 1]
        normal = mixed / np.hypot(*mixed)
        return float((rod - foot) @ normal), foot, normal


def is_cut_curve(outline: Outline) -> bool:
    """Whether an outline is a polygon that stands for a smooth curve: no corner of it turns by more than 20 degrees."""
    if not isinstance(outline, Polygon):
        return False
    edge = np.roll(outline.array, -1, axis=0) - outline.array
    heading = np.arctan2(edge[:, 1], edge[:, 0])
    turn = np.remainder(np.diff(heading, append=heading[:1]) + np.pi, 2.0 * np.pi) - np.pi
    return bool(np.abs(turn).max() <= LARGEST_BEND)


@cache
def cut_curve(outline: Polygon) -> CutCurve:
    """Return the periodic cubic spline through a polygon's vertices, by the length of its sides."""
    from scipy.interpolate import CubicSpline

    corners = outline.points(0)
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    spline = CubicSpline(length, corners, bc_type="periodic")
    at = np.interp(np.arange(_FINER * outline.sides + 1) / _FINER, np.arange(outline.sides + 1), length)
    tangent = spline(at, 1)
    normal = np.column_stack([tangent[:, 1], -tangent[:, 0]]) / np.hypot(*tangent.T)[:, None]
    return CutCurve(spline(at), normal)


class _Course:
    """The object's pose as the rod goes along, and its record."""

    def __init__(self, model: QuasiStaticModel, curve: CutCurve, pose: Pose) -> None:
        self.model, self.curve, self.pose = model, curve, pose
        # Each stroke brings a contact curve of its own.
        plain = replace(model.slider, outline=Ellipse(model.unit, model.unit))
        self.still = replace(model, slider=plain, footprint=model.pressure).cycle_strokes(SidePush(), DragBack())
        self.still = replace(self.still, start_piece=0, start_coordinate=0.0, goals=(), with_object=False)
        self.travels, self.poses, self.slid = [0.0], [pose], 0.0
        self.touched, self.apart = False, True

    def note(self, travel: float) -> None:
        self.travels.append(travel)
        self.poses.append(self.pose)

    def gap(self, place: Array) -> tuple[float, Array, Array]:
        """Gap (m) of a rod at a place in the world; the foot and the normal there, in the object's frame."""
        distance, foot, normal = self.curve.nearest(np.array(self.pose.to_object(*place.tolist())))
        return distance - self.model.pusher.radius, foot, normal

    def go(self, start: Array, direction: float, length: float, done: float) -> None:
        """Move the rod straight over `length` (m) from `start`, `done` (m) into the chain."""
        toward, at = np.array([math.cos(direction), math.sin(direction)]), 0.0
        while at < length:
            gap, foot, normal = self.gap(start + at * toward)
            nearing = -float(np.array(Pose(theta=self.pose.theta).to_world(*normal.tolist())) @ toward)
            if gap <= _CONTACT and nearing > _NEARING:
                self.note(done + at)
                at += self._push(start + at * toward, direction, min(STEP, length - at), foot)
            else:
                at += max(gap, _CONTACT if nearing > 0.0 else _APART)
                self.apart, self.slid = True, 0.0
            self.note(done + min(at, length))

    def _push(self, place: Array, direction: float, length: float, foot: Array) -> float:
        """Push a chord of the curve at `foot`; return the travel (m) until the stroke ends or the rod is left."""
        model, unit, rod_at = self.model, self.model.unit, np.array(self.pose.to_object(*place.tolist()))
        side = self._chord(rod_at, foot, 0.5 * self.slid)
        # About to leave, the rod may already move away from the chord: the tangent it still nears.
        if math.cos(side.normal + self.pose.theta - direction) > -_NEARING:
            side = self._chord(rod_at, foot, 0.0)
        table = piece_table(
            ContactCurve(model.radius, (side,), (0,), (0,), ("smooth",)),
            (model.slider.hitch[0] / unit, model.slider.hitch[1] / unit),
        )
        strokes = replace(self.still, pieces=table, direction=direction, length=length / unit)
        at = (self.pose.x / unit, self.pose.y / unit, self.pose.theta)
        ran = run_strokes([Course(strokes, at, unit, model.weight, model.scale, math.inf)])
        x, y, theta = ran.pushed[0].tolist()
        travel, self.pose = unit * float(ran.travel[0]), Pose(unit * x, unit * y, theta)
        end = place + travel * np.array([math.cos(direction), math.sin(direction)])
        self.slid = float((np.array(self.pose.to_object(*end.tolist())) - rod_at) @ side.direction)
        # The object is shifted so that the rod touches its curve instead of its tangent.
        gap, _, normal = self.gap(end)
        x, y = (gap * np.array(Pose(theta=self.pose.theta).to_world(*normal.tolist()))).tolist()
        self.pose = Pose(self.pose.x + x, self.pose.y + y, self.pose.theta)
        self.touched, self.apart = True, bool(ran.left[0])
        return max(travel, _APART if self.apart else _CONTACT)

    def _chord(self, rod_at: Array, foot: Array, ahead: float) -> SidePiece:
        """The side that a rod at `rod_at` touches, with the curve's normal `ahead` (m) of the foot."""
        _, _, here = self.curve.nearest(foot)
        _, _, (x, y) = self.curve.nearest(foot + ahead * np.array([-here[1], here[0]]))
        touch = (rod_at - self.model.pusher.radius * np.array([x, y])) / self.model.unit
        begin, along = (float(touch[0]), float(touch[1])), (-float(y), float(x))
        return SidePiece(0, begin, along, math.atan2(y, x), -_ENDLESS, _ENDLESS)


def push_curve_along(model: QuasiStaticModel, curve: CutCurve, pose: Pose, corners: Array) -> ChainRun:
    """Push an object with the outline `curve` from `pose`; the rod goes straight from corner to corner, (k, 2), m.

    Every 2 mm of rod travel the outline is replaced by a straight side that touches the rod, so that concave stretches
    hold no corners; its normal is that of the curve half as far on as the last stroke slid, and the pose is set back to
    the curve afterwards. An ellipse of 45 by 60 mm ends within 0.05 mm and 0.05 degrees of its exact contact (tests).
    Raises ConvergenceError where the contact cannot be solved.
    """
    course, done = _Course(model, curve, pose), 0.0
    for start, end in pairwise(corners):
        length = math.hypot(*(end - start))
        course.go(start, math.atan2(*(end - start)[::-1].tolist()), length, done)
        done += length
    table = np.array([[p.x, p.y, p.theta] for p in course.poses])
    travel = np.maximum.accumulate(course.travels)
    return ChainRun(read_only(travel), read_only(table), course.touched, course.touched and course.apart)
