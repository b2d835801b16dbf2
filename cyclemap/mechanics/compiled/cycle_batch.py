"""Whole cycles from many orientations in compiled code: pushes from the ring's target, drags back, and the slope."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.compiled.recorded_strokes import stroke_row
from cyclemap.mechanics.compiled.stroke_runner import piece_table, stroke_runner
from cyclemap.mechanics.contact_curve import Piece, RingPiece
from cyclemap.mechanics.motion import Rod
from cyclemap.mechanics.protocol import DragBack, Pose, SidePush
from cyclemap.mechanics.push_run import PushStart

if TYPE_CHECKING:
    from cyclemap.mechanics.quasi_static import QuasiStaticModel

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CycleBatch:
    """Cycles from n orientations; SI units and radians, as in `CollectionLoop.cycles`.

    done : (n,) bool, where the compiled code ran them; the rest is nan, and left to Python.
    by_theta : (n,) d theta_next / d theta, nan unless it was asked for.
    """

    done: NDArray[np.bool_]
    push_turn: Array
    push_displacement: Array
    drag_turn: Array
    drag_length: Array
    theta_next: Array
    left: NDArray[np.bool_]
    by_theta: Array


@dataclass
class _Objects:
    """n objects on their way: place (n, 2) in m and orientation (n,), and how these vary (m, rad)."""

    place: Array
    theta: Array
    by_place: Array
    by_theta: Array
    done: NDArray[np.bool_]


def cycle_batch(
    model: "QuasiStaticModel", push: SidePush, reset: DragBack, theta: Array, slopes: bool
) -> CycleBatch | None:
    """Run cycles from orientations theta (n,), rad; None where no compiled code is to be had, or worth its while."""
    if theta.size == 0 or not expect_cycles(model, theta.size):
        return None
    hitch = _turned(theta, np.array(model.slider.hitch))
    objects = _Objects(-hitch, theta, -_quarter(hitch), np.ones_like(theta), np.ones(theta.shape, bool))
    with np.errstate(invalid="ignore"):
        pushed, left = _push(model, push, objects, slopes)
        back, length = _drag(model, reset, pushed, slopes)
    moved = _turned(-theta, pushed.place - objects.place)
    slope = back.by_theta if slopes else np.full(theta.shape, math.nan)
    columns = (pushed.theta - theta, moved, back.theta - pushed.theta, length, back.theta, slope)
    for column in columns:
        column[~back.done] = math.nan
    turn, moved, back_turn, length, following, slope = columns
    return CycleBatch(back.done, turn, moved, back_turn, length, following, left & back.done, slope)


def expect_cycles(model: "QuasiStaticModel", count: int) -> bool:
    """Prepare for `count` cycles: compile what they need if that is worth its while; whether it is there."""
    return model.stroke_kind is not None and stroke_runner(model.stroke_kind, count) is not None


def _push(
    model: "QuasiStaticModel", push: SidePush, objects: _Objects, slopes: bool
) -> tuple[_Objects, NDArray[np.bool_]]:
    """Push every object; returns them afterwards, and whether the rod left."""
    start, direction, _, length = model.start(Pose(), push)
    row = stroke_row(model.solver, Rod(model.radius, model.pusher.friction, direction), start, length)
    row[4:7] = 1.0, 0.0, 1.0
    strokes = np.tile(row, (objects.theta.size, 1))
    strokes[:, 2], strokes[:, 7] = objects.theta, objects.theta + direction
    end = _run(model, model.pieces, strokes, slopes)
    left, travel, toward = end[:, 5] == 1.0, end[:, 4], _toward(strokes[:, 7])
    by_travel = np.where(left, _later_leaving(model, end), 0.0)
    by_state = end[:, 6:8] + end[:, 8:10] * by_travel[:, None]
    before = _rod_centre(model, np.full(len(end), start.piece), objects.theta, np.full(len(end), start.coordinate))
    after = _rod_centre(model, end[:, 3], end[:, 1], end[:, 2])
    unit = model.unit
    place = objects.place + unit * (before.place + travel[:, None] * toward - after.place)
    by_rod = toward * by_travel[:, None] + _quarter(toward) * travel[:, None]
    by_after = _quarter(after.place) * by_state[:, :1] + after.by_coordinate * by_state[:, 1:]
    by_place = objects.by_place + unit * (_quarter(before.place) + by_rod - by_after)
    return _Objects(place, end[:, 1], by_place, by_state[:, 0], end[:, 0] == 1.0), left


def _later_leaving(model: "QuasiStaticModel", end: Array) -> Array:
    """Variation of the travel at which a rod leaves, as `stroke_variation` tells."""
    turning = np.array([model.pieces[int(k)].normal_slope(c) for k, c in zip(end[:, 3], end[:, 2], strict=True)])
    varied, slope = end[:, 6] + turning * end[:, 7] - 1.0, end[:, 8] + turning * end[:, 9]
    return np.asarray(-varied / np.where(slope == 0.0, math.nan, slope))


@dataclass(frozen=True, eq=False)
class _RodCentre:
    """The rod's centre seen from the object's origin, in the world's axes (n, 2), units; and by the coordinate."""

    place: Array
    by_coordinate: Array


def _rod_centre(model: "QuasiStaticModel", piece: Array, theta: Array, coordinate: Array) -> _RodCentre:
    contacts = [model.pieces[int(k)].contact(c, model.radius) for k, c in zip(piece, coordinate.tolist(), strict=True)]
    centre = np.array([contact.rod_centre(model.radius) for contact, _ in contacts])
    normal = np.array([contact.normal for contact, _ in contacts])
    metric = np.array([metric for _, metric in contacts])
    return _RodCentre(_turned(theta, centre), metric[:, None] * _quarter(_toward(theta + normal)))


def _drag(model: "QuasiStaticModel", reset: DragBack, objects: _Objects, slopes: bool) -> tuple[_Objects, Array]:
    """Drag every object through the way-points; returns them afterwards, and the length of the ring's path."""
    hitch, unit = np.array(model.slider.hitch), model.unit
    piece = RingPiece((hitch[0] / unit, hitch[1] / unit))
    theta, by_theta, done = objects.theta, objects.by_theta, objects.done
    lever = _turned(theta, hitch)
    ring, by_ring = objects.place + lever, objects.by_place + _quarter(lever) * by_theta[:, None]
    length = np.zeros_like(theta)
    for goal in (*reset.way_points, (0.0, 0.0)):
        way = np.array(goal) - ring
        travel = np.hypot(way[:, 0], way[:, 1])
        toward = way / travel[:, None]
        by_length, by_direction = -(toward * by_ring).sum(axis=1), -(_quarter(toward) * by_ring).sum(axis=1) / travel
        row = stroke_row(model.solver, Rod(0.0, reset.pin_friction_radius / unit, 0.0), PushStart(0, 0.0, 0.0), 0.0)
        strokes = np.tile(row, (theta.size, 1))
        strokes[:, 2], strokes[:, 3], strokes[:, 4], strokes[:, 6] = theta, travel / unit, by_theta, by_direction
        strokes[:, 7] = np.arctan2(way[:, 1], way[:, 0])
        end = _run(model, (piece,), strokes, slopes)
        # A leg without length, and a ring that holds, are left to Python.
        done = done & (end[:, 0] == 1.0) & (travel > 1e-12 * unit)
        theta, by_theta = end[:, 1], end[:, 6] + end[:, 8] * by_length / unit
        length, ring, by_ring = length + travel, np.broadcast_to(goal, ring.shape), np.zeros_like(by_ring)
    return _Objects(ring - _turned(theta, hitch), theta, by_ring, by_theta, done), length


def _run(model: "QuasiStaticModel", pieces: tuple[Piece, ...], strokes: Array, slopes: bool) -> Array:
    """Results of strokes, nan where they are left to Python."""
    runner = None if model.stroke_kind is None else stroke_runner(model.stroke_kind, 0)
    assert runner is not None
    results = runner.run(piece_table(pieces), strokes, model.step_tolerance, math.inf, slopes)
    declined = results[:, 0] != 1.0
    results[declined] = math.nan
    results[declined, 3] = 0.0
    return results


def _toward(angle: Array) -> Array:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _quarter(vectors: Array) -> Array:
    """Return z x each of the vectors (n, 2)."""
    return np.stack([-vectors[:, 1], vectors[:, 0]], axis=-1)


def _turned(angle: Array, vectors: Array) -> Array:
    """Return vectors (2,) or (n, 2) turned by angles (n,)."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)
