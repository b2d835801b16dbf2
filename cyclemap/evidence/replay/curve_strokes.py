"""Pushing an object with a curved outline: short pushes, each of a chord where the rod touches it."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import read_only
from cyclemap.evidence.replay.chain_run import ChainRun
from cyclemap.evidence.replay.cut_curve import CutCurve
from cyclemap.mechanics import DragBack, Ellipse, Pose, QuasiStaticModel, SidePush
from cyclemap.mechanics.contact_curve import ContactCurve, SidePiece
from cyclemap.mechanics.engine.strokes import piece_table
from cyclemap.mechanics.quasi_static import run_strokes
from cyclemap.mechanics.trajectory import Course

# Rod travel (m) over which the outline is taken to be straight.
STEP = 2e-3
# Gaps under this (m) are contact; a rod that moves away is looked for again after the second.
_CONTACT, _APART = 1e-7, 1e-5
# A rod whose direction has less than this of the normal in it does not near the object.
_NEARING = 1e-6
# The chord is a side as long as it need be, in units of the footprint.
_ENDLESS = 1e3


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
        self._put_on_curve(end)
        self.touched, self.apart = True, bool(ran.left[0])
        return max(travel, _APART if self.apart else _CONTACT)

    def _chord(self, rod_at: Array, foot: Array, ahead: float) -> SidePiece:
        """The side that a rod at `rod_at` touches, with the curve's normal `ahead` (m) of the foot."""
        _, _, here = self.curve.nearest(foot)
        _, _, (x, y) = self.curve.nearest(foot + ahead * np.array([-here[1], here[0]]))
        touch = (rod_at - self.model.pusher.radius * np.array([x, y])) / self.model.unit
        begin, along = (float(touch[0]), float(touch[1])), (-float(y), float(x))
        return SidePiece(0, begin, along, math.atan2(y, x), -_ENDLESS, _ENDLESS)

    def _put_on_curve(self, rod: Array) -> None:
        """Shift the object so that the rod touches its curve instead of its tangent."""
        gap, _, normal = self.gap(rod)
        x, y = (gap * np.array(Pose(theta=self.pose.theta).to_world(*normal.tolist()))).tolist()
        self.pose = Pose(self.pose.x + x, self.pose.y + y, self.pose.theta)


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
