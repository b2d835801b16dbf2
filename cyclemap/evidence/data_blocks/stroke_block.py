"""Blocks of data whose prediction is the mechanics of strokes: push end points, drag-backs, and
whole cycles.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, whole_number
from cyclemap.collection import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.data_block import DataBlock, Function, Labels, Values
from cyclemap.evidence.identification.surface_parameters import (
    FIELD,
    FIELD_REACH,
    FLOOR_NAMES,
    FRICTION_NAMES,
    PLATE_NAMES,
    SURFACE,
    Parameter,
    SurfaceParameters,
    field_factors,
    floor_field,
)
from cyclemap.evidence.pushes.measured_strokes import ROD_OFF, MeasuredDrag, MeasuredPush, Place
from cyclemap.mechanics import (
    FoundWith,
    Material,
    Pose,
    Pusher,
    QuasiStaticModel,
    Slider,
)
from cyclemap.mechanics.cycle_batch import CYCLE_OUTPUTS, CycleBatch, derivative_units, run_batch
from cyclemap.mechanics.engine.schema import PARAMETERS, SHAPES
from cyclemap.mechanics.engine.strokes import Strokes
from cyclemap.mechanics.first_touch import first_touches
from cyclemap.mechanics.foundation import FloorField
from cyclemap.mechanics.plate_footprint import mean_pressure
from cyclemap.mechanics.quasi_static import run_strokes

Rows = tuple[Array, Array]
StrokeRows = tuple[Array, Array, NDArray[np.bool_]]

# Radians (extents) asked of a stroke: measured pushes come out within 1e-3 mm and .003 degrees of
# exact ones.
ACCURACY = 1e-3
# A few strokes of many may have no answer where the rod grazes a tip: these count as if the object
# stayed.
_FAILING = 0.05
# A rod that starts further inside the object than this, m, is in another frame: measured poses
# overlap by tenths of mm.
_DEEPEST = 0.04

TIP_OFFSET = (
    Parameter(
        "tip_offset_x",
        "shift of the robot's frame against the camera's, along x",
        "m",
        -0.01,
        0.01,
        0.0,
        1e-3,
    ),
    Parameter(
        "tip_offset_y",
        "shift of the robot's frame against the camera's, along y",
        "m",
        -0.01,
        0.01,
        0.0,
        1e-3,
    ),
)
# What wears of a surface comes first.
WORN = (*SURFACE.names[1:5], *FLOOR_NAMES)
PUSH_UNKNOWNS = (*WORN, *PLATE_NAMES, "pusher_friction")
DRAG_UNKNOWNS = (*WORN, *PLATE_NAMES, "pin_friction_radius")
CYCLE_UNKNOWNS = (*PUSH_UNKNOWNS, "pin_friction_radius")
# What the engine calls the shapes.
_ENGINE_NAMES = dict(zip((*FLOOR_NAMES, *PLATE_NAMES), SHAPES, strict=True))
# Cycles are computed at this many angles and interpolated between by a Fourier series.
NODES = 48
CYCLE_ACCURACY = 1e-6


def push_end_block(
    pushes: Sequence[MeasuredPush],
    slider: Slider,
    target: Place | None = None,
    first_set: int | None = None,
) -> DataBlock:
    """Return the block of where pushes ended: place (m) and orientation (rad), grouped by contact.

    Returns
    -------
    DataBlock
        The block of where pushes ended: place (m) and orientation (rad), grouped by contact.

    Notes
    -----
    Its own unknowns are `tip_offset_x`, `tip_offset_y`: what to add to the robot's places to
    have them in the frame of the object's poses. Where rods were set by marks on the object,
    each is off its mark by itself, and so much of what it did is its own: `rod_off_x[push 7]`
    of the seventh; first_set is then the number of the first. With a target (m, where resets
    end), also how the floor's shape varies with the place about it.
    """
    names = (*FRICTION_NAMES, *FLOOR_NAMES, *PLATE_NAMES, "pusher_friction")
    shifts = TIP_OFFSET if first_set is None else rods_set(first_set, len(pushes))
    # Which of the shifts moves a push's rod, along x and y.
    owner = np.arange(len(pushes)) if first_set is not None else np.zeros(len(pushes), dtype=int)
    own_shifts = 2 * owner[:, None] + (0, 1)

    def misfit(chosen: Labels, values: Values) -> StrokeRows:
        surface = SurfaceParameters.from_values(values)
        shift = np.array([values[shifted.name] for shifted in shifts])
        columns = own_shifts[chosen]
        model = surface_model(surface, slider, field=floor_field(values))
        strokes = [pushes[index] for index in chosen.tolist()]
        ends, by, stayed = predicted_push_ends(model, strokes, shift[columns], names, target)
        by_shifts = np.zeros((chosen.size, 3, shift.size))
        np.put_along_axis(by_shifts, columns[:, None], by[..., -2:], axis=-1)
        by_surface = surface.chain(by[..., : len(names)], names, PUSH_UNKNOWNS)
        jacobian = np.concatenate([by_surface, by[..., len(names) : -2], by_shifts], axis=-1)
        measured = [(push.end.x, push.end.y, push.end.theta) for push in strokes]
        return ends - measured, jacobian, stayed

    kinds = ("push place (m)", "push place (m)", "push turn (rad)")
    own = (*(() if target is None else FIELD), *shifts)
    parameters = (*PUSH_UNKNOWNS, *(one.name for one in own))
    return _stroke_block("push ends", parameters, pushes, misfit, kinds, own)


def rods_set(first: int, count: int) -> tuple[Parameter, ...]:
    """Return what is unknown of rods that were set by marks, from push number ``first`` on: how far
    each was off, x and y in turn.
    """
    return tuple(
        Parameter(
            f"{ROD_OFF}{axis}[push {number}]",
            f"how far the rod of push {number} was set off its mark, along {axis}",
            *("m", -0.02, 0.02, 0.0, 1e-3),
        )
        for number in range(first, first + count)
        for axis in "xy"
    )


def drag_turn_block(
    drags: Sequence[MeasuredDrag], slider: Slider, target: Place | None = None
) -> DataBlock:
    """Return the block of how far drags turned the object (rad), each ring going straight to where
    it ended.

    Parameters
    ----------
    target : Place, optional
        As of `push_end_block`.

    Returns
    -------
    DataBlock
        The block of how far drags turned the object (rad), each ring going straight to where it
        ended.
    """
    names = (*FRICTION_NAMES, *FLOOR_NAMES, *PLATE_NAMES, "pin_friction_radius")

    def misfit(chosen: Labels, values: Values) -> StrokeRows:
        strokes = [drags[index] for index in chosen.tolist()]
        surface = SurfaceParameters.from_values(values)
        model = surface_model(surface, slider, field=floor_field(values))
        courses, places = [], []
        x0, y0 = target or (0.0, 0.0)
        for drag in strokes:
            begin = Pose(drag.start.x - x0, drag.start.y - y0, drag.start.theta)
            x, y = drag.end.to_world(*slider.hitch)
            goal = (x - x0, y - y0)
            courses.append(
                model.course(model.drag_strokes((goal,), surface.pin_friction_radius), begin)
            )
            way = np.array(goal) - begin.to_world(*slider.hitch)
            places.append(begin.to_world(*slider.outline.centroid) + 0.5 * way)
        ran = run_strokes(courses, len(PARAMETERS), _FAILING)
        done = ran.status > 0
        slopes = np.where(done[:, None, None], ran.derivatives[:, 5:6], 0.0)
        by = _by_names(model, names, slopes)
        measured = np.array([drag.end.theta for drag in strokes])
        parts = [surface.chain(by, names, DRAG_UNKNOWNS)]
        parts += (
            []
            if target is None
            else [_by_field(_by_names(model, FLOOR_NAMES, slopes), np.array(places))]
        )
        turned = np.where(done, ran.ended[:, 2], [drag.start.theta for drag in strokes])
        return (turned - measured)[:, None], np.concatenate(parts, axis=-1), ~done

    own = () if target is None else FIELD
    parameters = (*DRAG_UNKNOWNS, *(one.name for one in own))
    return _stroke_block("drag-backs", parameters, drags, misfit, ("drag turn (rad)",), own)


def _by_field(by_floor: Array, places: Array) -> Array:
    """Derivatives (n, m, 9) by the floor's heights, of those (n, m, 3) by its shape at places (n,
    2), m from target.
    """
    reaching = FloorField(((0.0,) * 5,) * 3, FIELD_REACH)
    terms = np.array([reaching.terms_at((x, y)) for x, y in places.tolist()])
    by_heights: Array = np.einsum("nms,stk,nt->nmk", by_floor, field_factors(), terms)
    return by_heights


def _stroke_block(
    name: str,
    parameters: tuple[str, ...],
    strokes: Sequence[Any],
    misfit: Callable[[Labels, Values], StrokeRows],
    row_kinds: tuple[str, ...],
    own_parameters: tuple[Parameter, ...] = (),
) -> DataBlock:
    """The block of strokes with a few rows each, of these kinds; strokes of one contact are a
    group.

    misfit : indices of strokes (s,), values -> residuals (s, m), derivatives (s, m, k), which were
        taken to stay (s,).
    """
    if not strokes:
        raise InvalidInput(f"block {name!r} has no strokes: give some")
    rows = len(row_kinds)

    def part(chosen: Labels) -> Function:
        indices = chosen[::rows] // rows

        def function(values: Values) -> Rows:
            residual, jacobian, _ = misfit(indices, values)
            return residual.ravel(), jacobian.reshape(residual.size, len(parameters))

        return function

    groups = np.repeat([stroke.contact for stroke in strokes], rows)
    motions = np.array(
        [(stroke.start.theta, stroke.end.theta - stroke.start.theta) for stroke in strokes]
    )
    kinds = np.tile(row_kinds, len(strokes))
    whole = part(np.arange(groups.size))

    def stayed(values: Values) -> int:
        return int(np.sum(misfit(np.arange(len(strokes)), values)[2]))

    return DataBlock(
        name, parameters, whole, groups, kinds, own_parameters, part, motions, stayed=stayed
    )


def surface_model(
    surface: SurfaceParameters,
    slider: Slider,
    accuracy: float = ACCURACY,
    field: FloorField | None = None,
) -> QuasiStaticModel:
    """Return the model of a slider on a surface, of the shapes that the surface says; field : of
    the floor, kPa.
    """
    rod = Pusher(friction=surface.pusher_friction)
    return QuasiStaticModel(
        slider, surface.to_friction(), rod, surface.footprint(slider, field), accuracy
    )


def predicted_push_ends(
    model: QuasiStaticModel,
    pushes: Sequence[MeasuredPush],
    shift: ArrayLike = (0.0, 0.0),
    names: tuple[str, ...] = (),
    target: Place | None = None,
) -> StrokeRows:
    """Return poses (n, 3), m and rad, after pushes whose rod paths are shifted (m; all alike, or
    (n, 2)), derivatives, and what stayed (n,).

    Derivatives (n, 3, k + 2) are by `names` of the mechanics, with a target by the floor's heights,
    and by both components of the shift. An object that the rod does not touch stays, and so does
    one of the few (a twentieth at most) whose push has no answer.
    target : m, from which a floor's shape that varies with the place is told.
    """
    origin, heights = np.array(target or (0.0, 0.0)), 0 if target is None else len(FIELD)
    ends = np.array([(push.start.x, push.start.y, push.start.theta) for push in pushes])
    by, theta = np.zeros((len(pushes), 3, len(names) + heights + 2)), ends[:, 2]
    c, s = np.cos(theta), np.sin(theta)
    direction, length = np.array([(push.direction, push.length) for push in pushes]).T
    x, y = (np.array([push.tip_start for push in pushes]) + shift - ends[:, :2]).T
    starts = np.column_stack([c * x + s * y, c * y - s * x]) / model.unit
    travel, piece, coordinate = first_touches(
        model.curve.pieces, model.radius, starts, direction - theta
    )
    for number in np.flatnonzero(travel * model.unit < -_DEEPEST)[:1].tolist():
        at, pose = pushes[number].tip_start, pushes[number].start
        raise InvalidInput(
            f"the rod at {at} m lies deep inside the object at {pose}: check the frames"
        )
    way = length / model.unit - travel
    touched = np.flatnonzero(way > 0.0)
    stayed = np.full(len(pushes), True)
    if not touched.size:
        return ends, by, stayed
    # A push that goes along with the object is differentiated by where it starts and how far it
    # goes, too.
    still = replace(model.drag_strokes((), 0.0), by_fraction=1.0, with_object=True)
    strokes = [
        replace(still, start_piece=int(index), start_coordinate=at, direction=toward, length=far)
        for index, at, toward, far in np.column_stack([piece, coordinate, direction - theta, way])[
            touched
        ].tolist()
    ]
    both = list(zip(strokes, theta[touched].tolist(), strict=True))
    places = (ends[touched, :2] - origin).tolist()
    begins = [Pose(x, y, angle) for (x, y), (_, angle) in zip(places, both, strict=True)]
    courses = [model.course(one, begin) for (one, _), begin in zip(both, begins, strict=True)]
    ran = run_strokes(courses, len(PARAMETERS), _FAILING)
    done = ran.status > 0
    moved = np.column_stack([model.unit * ran.pushed[:, :2] + origin, ran.pushed[:, 2]])
    ends[touched[done]], stayed[touched[done]] = moved[done], False
    units = np.array((model.unit, model.unit, 1.0))
    slopes = np.where(done[:, None, None], ran.derivatives[:, :3], 0.0) * units[:, None]
    by[touched, :, : len(names)] = _by_names(model, names, slopes)
    if heights:
        # A quarter of the way ahead, as the engine takes it.
        ahead = 0.25 * model.unit * way[touched, None]
        along = ahead * np.column_stack([np.cos(direction), np.sin(direction)])[touched]
        middles = [begin.to_world(*model.slider.outline.centroid) for begin in begins]
        by[touched, :, len(names) : -2] = _by_field(
            _by_names(model, FLOOR_NAMES, slopes), middles + along
        )
    starting = np.array([_by_shift(model, *one) for one in both])
    by[touched, :, -2:] = (
        slopes[..., [PARAMETERS.index(name) for name in ("fraction", "angle", "distance")]]
        @ starting
    )
    return ends, by, stayed


def _by_shift(model: QuasiStaticModel, strokes: Strokes, theta: float) -> Array:
    """Derivatives of a side push's start, angle and length (extents, rad) by a shift of the rod's
    path (m), (3, 2).
    """
    piece, coordinate = model.curve.pieces[strokes.start_piece], strokes.start_coordinate
    contact, speed = piece.contact(coordinate, model.radius)
    c, s = math.cos(contact.normal + theta), math.sin(contact.normal + theta)
    normal, tangent = np.array((c, s)), np.array((-s, c))
    toward = np.array((math.cos(strokes.direction + theta), math.sin(strokes.direction + theta)))
    longer = normal / (normal @ toward)
    along = (tangent - (tangent @ toward) * longer) / speed
    # The rod keeps its direction where the normal turns.
    return np.array((along, -contact.turning * along, longer)) / model.unit


def _by_names(model: QuasiStaticModel, names: tuple[str, ...], by_engine: Array) -> Array:
    """Columns (..., k) by `names`, SI units and shapes in kPa, of derivatives by all of the
    engine's parameters.
    """
    called = [_ENGINE_NAMES.get(name, name) for name in names]
    per_kpa = [
        1.0 / mean_pressure(model.slider) if name in _ENGINE_NAMES else 1.0 for name in names
    ]
    columns = by_engine[..., [PARAMETERS.index(name) for name in called]]
    return np.asarray(columns * derivative_units(model, called) * per_kpa)


def interpolation(theta: ArrayLike, count: int) -> Array:
    """Return the matrix (n, count) from values at 2 pi k / count to the Fourier series through them
    at theta (n,), rad.

    >>> nodes = 2 * np.pi * np.arange(5) / 5
    >>> bool(np.allclose(interpolation([0.3], 5) @ np.cos(2 * nodes), np.cos(0.6)))
    True
    """
    off = (
        finite_array("theta", theta, ndim=1)[:, np.newaxis] - 2.0 * np.pi * np.arange(count) / count
    )
    orders = np.arange(1, (count - 1) // 2 + 1, dtype=float)
    return np.asarray((1.0 + 2.0 * np.cos(off[..., np.newaxis] * orders).sum(axis=-1)) / count)


def cycle_pair_block(
    loop: CollectionLoop,
    theta: ArrayLike,
    turn: ArrayLike,
    groups: Labels,
    share: ArrayLike | None = None,
    nodes: int = NODES,
) -> DataBlock:
    """Return the block of measured turns of whole cycles, rad, set against the cycle map of a loop.

    Parameters
    ----------
    loop : CollectionLoop
        Who is pushed where, and how it is brought back; surface, rod, shapes and ring are the
        unknowns'.
    theta, turn : array_like
        (n,) rad, orientation before a push and how far the cycle turned the object.
    groups : Labels
        (n,) labels.
    share : array_like, optional
        (n,) or None: how worn the surface was, 0 fresh to 1 at the end of the data; the turn is then
        blended linearly between the two, its ends having an ellipse and a floor each, the worn
        one's `worn_...`.
    nodes : int, optional
        Angles at which cycles are computed; between them a trigonometric polynomial, so the map
        must be smooth.

    Returns
    -------
    DataBlock
        The block of measured turns of whole cycles, rad, set against the cycle map of a loop.

    Raises
    ------
    InvalidInput
        Where shapes differ or nothing is given.
    """
    angles, measured = finite_array("theta", theta, ndim=1), finite_array("turn", turn, ndim=1)
    if angles.size == 0 or measured.shape != angles.shape:
        told = f"{angles.size} orientations and {measured.size} turns"
        raise InvalidInput(f"{told}: give one turn for each, one at least")
    count, gone, worn = (
        whole_number("nodes", nodes, least=9),
        np.zeros(angles.size),
        list[Parameter](),
    )
    if share is not None:
        gone = finite_array("share of wear", share, ndim=1)
        if gone.shape != angles.shape or gone.min() < 0.0 or gone.max() > 1.0:
            raise InvalidInput("the share of wear must be a number from 0 to 1 for each cycle")
        fresh, late = (SURFACE[name] for name in WORN), "at the end of the data"
        worn = [
            replace(x, name=f"worn_{x.name}", description=f"{x.description}, {late}") for x in fresh
        ]
    count += count % 2 - 1
    places = 2.0 * np.pi * np.arange(count) / count
    between, parameters = (
        interpolation(angles, count),
        (*CYCLE_UNKNOWNS, *(one.name for one in worn)),
    )

    def at_nodes(values: Values, late: bool) -> Rows:
        """Turns at the nodes on the fresh or the worn surface, and their derivatives by
        CYCLE_UNKNOWNS.
        """
        own = {**values, **{name: values[f"worn_{name}"] for name in WORN}} if late else values
        runs, by_unknowns = cycles_by_unknowns(SurfaceParameters.from_values(own), loop, places)
        return runs.theta_next[0] - places, by_unknowns[:, CYCLE_OUTPUTS.index("theta_next")]

    def function(values: Values) -> Rows:
        predicted, by_fresh = (between @ part for part in at_nodes(values, False))
        jacobian = np.hstack([by_fresh, np.zeros((angles.size, len(worn)))])
        if worn:
            turn_worn, by_worn = (between @ part for part in at_nodes(values, True))
            predicted = predicted + gone * (turn_worn - predicted)
            kept, changing, by_share = len(CYCLE_UNKNOWNS), len(WORN), gone[:, np.newaxis]
            jacobian *= 1.0 - by_share
            jacobian[:, changing:kept] += by_share * by_worn[:, changing:]
            jacobian[:, kept:] = by_share * by_worn[:, :changing]
        return predicted - measured, jacobian

    def curve(values: Values, around: Array, late: bool) -> Array:
        return interpolation(around, count) @ at_nodes(values, late)[0]

    motions = np.column_stack([angles, measured])
    kinds = np.repeat("cycle turn (rad)", angles.size)
    return DataBlock(
        "cycles", parameters, function, groups, kinds, tuple(worn), motions=motions, curve=curve
    )


def cycles_by_unknowns(
    surface: SurfaceParameters, loop: CollectionLoop, theta: Array
) -> tuple[CycleBatch, Array]:
    """Run cycles of the loop on an identified surface from theta (n,), rad; with d CYCLE_OUTPUTS /
    d CYCLE_UNKNOWNS.

    The batch has the shape (1, n), the derivatives (n, 6, k).
    """
    names = (*FRICTION_NAMES, *FLOOR_NAMES, *PLATE_NAMES, "pusher_friction", "pin_friction_radius")
    runs = run_batch((loop_on(surface, loop),), theta[None], len(PARAMETERS))
    per_kpa = 1.0 / mean_pressure(loop.slider)
    units = [per_kpa if name in _ENGINE_NAMES else 1.0 for name in names]
    columns = [PARAMETERS.index(_ENGINE_NAMES.get(name, name)) for name in names]
    return runs, surface.chain(runs.jacobian[0][:, :, columns] * units, names, CYCLE_UNKNOWNS)


def loop_on(surface: SurfaceParameters, loop: CollectionLoop) -> CollectionLoop:
    """Return the loop on an identified surface, with the rod, shapes and ring that were identified
    along with it.
    """
    found = FoundWith(surface.pusher_friction, surface.pin_friction_radius)
    material = Material("identified", surface.to_friction(), found_with=found)
    changed = replace(loop, accuracy=CYCLE_ACCURACY).with_material(material)
    return replace(changed, footprint=surface.footprint(loop.slider))
