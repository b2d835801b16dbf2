"""Blocks of data whose prediction is the mechanics of single strokes: push end points and drag-backs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.data_block import Kinds, Labels, Values, set_fields
from cyclemap.evidence.identification.surface_parameters import (
    FRICTION_NAMES,
    SHARE_NAMES,
    SURFACE,
    Parameter,
    SurfaceParameters,
    possible_names,
    share_names,
)
from cyclemap.evidence.pushes.measured_strokes import MeasuredDrag, MeasuredPush
from cyclemap.mechanics import PatchFootprint, Pose, Pusher, QuasiStaticModel, Slider
from cyclemap.mechanics.cycle_batch import derivative_units
from cyclemap.mechanics.engine.strokes import PARAMETERS, Strokes
from cyclemap.mechanics.first_touch import first_touches
from cyclemap.mechanics.quasi_static import run_strokes

Rows = tuple[Array, Array]

# Radians (extents): a tenth of what a camera sees.
ACCURACY = 1e-4
# A rod that starts further inside the object than this, m, is in another frame: measured poses overlap by tenths of mm.
_DEEPEST = 0.04

TIP_OFFSET = (
    Parameter("tip_offset_x", "shift of the robot's frame against the camera's, along x", "m", -0.01, 0.01, 0.0, 1e-3),
    Parameter("tip_offset_y", "shift of the robot's frame against the camera's, along y", "m", -0.01, 0.01, 0.0, 1e-3),
)
PUSH_UNKNOWNS = (*SURFACE.names[1:5], "pusher_friction", *SHARE_NAMES)
DRAG_UNKNOWNS = (*SURFACE.names[1:5], *SHARE_NAMES, "pin_friction_radius")

Misfit = Callable[[Sequence[Any], SurfaceParameters, Values], Rows]


@dataclass(frozen=True, eq=False)
class StrokeBlock:
    """Measured strokes set against the quasi-static model of one slider.

    parameters : names in order. strokes : n, what was measured. misfit : (strokes, surface, values) -> residuals (n, m)
    and derivatives (n, m, k). row_kinds (m,) : kind of noise of each row of a stroke. own_parameters : unknowns that
    belong to these data alone. Strokes of one contact are a group.
    """

    name: str
    parameters: tuple[str, ...]
    strokes: tuple[Any, ...]
    misfit: Misfit
    row_kinds: tuple[str, ...]
    own_parameters: tuple[Parameter, ...] = ()
    groups: Labels = field(init=False)
    kinds: Kinds = field(init=False)

    def __post_init__(self) -> None:
        if not self.strokes:
            raise InvalidInput(f"block {self.name!r} has no strokes: give some")
        labels = np.array([stroke.contact for stroke in self.strokes], dtype=np.int64)
        kinds = np.tile(np.array(self.row_kinds, dtype=np.str_), len(self.strokes))
        set_fields(self, groups=np.repeat(labels, len(self.row_kinds)), kinds=kinds)

    def residuals(self, values: Values) -> Rows:
        """Return predicted minus measured values and their derivatives, a few rows a stroke, in order."""
        residual, jacobian = self.misfit(self.strokes, SurfaceParameters.from_values(values), values)
        return residual.ravel(), jacobian.reshape(residual.size, len(self.parameters))

    def subset(self, keep_groups: ArrayLike) -> StrokeBlock:
        """Return the block with the strokes of some groups only."""
        keep = {*np.asarray(keep_groups).tolist()}
        return replace(self, strokes=tuple(stroke for stroke in self.strokes if stroke.contact in keep))


def push_end_block(pushes: Sequence[MeasuredPush], slider: Slider) -> StrokeBlock:
    """Return the block of where pushes ended: place (m) and orientation (rad), grouped by contact.

    Its own unknowns are `tip_offset_x`, `tip_offset_y`: what to add to the robot's places to have them in the frame of
    the object's poses.
    """
    shared = possible_names(PUSH_UNKNOWNS, slider.outline)
    names = (*FRICTION_NAMES, "pusher_friction", *share_names(slider.outline))

    def misfit(strokes: Sequence[MeasuredPush], surface: SurfaceParameters, values: Values) -> Rows:
        shift = (values["tip_offset_x"], values["tip_offset_y"])
        ends, by = predicted_push_ends(surface_model(surface, slider), strokes, shift, names)
        jacobian = np.concatenate([surface.chain(by[..., :-2], names, shared), by[..., -2:]], axis=-1)
        return ends - np.array([_vector(push.end) for push in strokes]), jacobian

    kinds = ("push place (m)", "push place (m)", "push turn (rad)")
    parameters = (*shared, *(one.name for one in TIP_OFFSET))
    return StrokeBlock("push ends", parameters, tuple(pushes), misfit, kinds, TIP_OFFSET)


def drag_turn_block(drags: Sequence[MeasuredDrag], slider: Slider) -> StrokeBlock:
    """Return the block of how far drags turned the object (rad), each ring going straight to where it ended."""
    parameters = possible_names(DRAG_UNKNOWNS, slider.outline)
    names = (*FRICTION_NAMES, *share_names(slider.outline), "pin_friction_radius")

    def misfit(strokes: Sequence[MeasuredDrag], surface: SurfaceParameters, values: Values) -> Rows:
        model, courses = surface_model(surface, slider), []
        for drag in strokes:
            goal = (drag.end.to_world(*slider.hitch),)
            courses.append(model.course(model.drag_strokes(goal, surface.pin_friction_radius), drag.start))
        ran = run_strokes(courses, len(PARAMETERS))
        by = ran.derivatives[:, 5:6][..., _columns(names)] * derivative_units(model, names)
        measured = np.array([drag.end.theta for drag in strokes])
        return (ran.ended[:, 2] - measured)[:, None], surface.chain(by, names, parameters)

    return StrokeBlock("drag-backs", parameters, tuple(drags), misfit, ("drag turn (rad)",))


def surface_model(surface: SurfaceParameters, slider: Slider, accuracy: float = ACCURACY) -> QuasiStaticModel:
    """Return the model of a slider on a surface, the shares of its weight as the surface says."""
    footprint = PatchFootprint(slider.outline, **surface.shares, centre=slider.centre_of_mass)
    return QuasiStaticModel(
        slider, surface.to_friction(), Pusher(friction=surface.pusher_friction), footprint, accuracy
    )


def predicted_push_ends(
    model: QuasiStaticModel,
    pushes: Sequence[MeasuredPush],
    shift: tuple[float, float] = (0.0, 0.0),
    names: tuple[str, ...] = (),
) -> Rows:
    """Return poses (n, 3), m and rad, after pushes whose rod paths are shifted (m), and derivatives (n, 3, k + 2).

    These are by `names` of the mechanics and by both components of the shift. An object that the rod does not touch
    stays.
    """
    ends, by = np.array([_vector(push.start) for push in pushes]), np.zeros((len(pushes), 3, len(names) + 2))
    theta = ends[:, 2]
    c, s = np.cos(theta), np.sin(theta)
    direction, length = np.array([(push.direction, push.length) for push in pushes]).T
    x, y = (np.array([push.tip_start for push in pushes]) + shift - ends[:, :2]).T
    starts = np.column_stack([c * x + s * y, c * y - s * x]) / model.unit
    travel, piece, coordinate = first_touches(model.pieces, model.radius, starts, direction - theta)
    for number in np.flatnonzero(travel * model.unit < -_DEEPEST)[:1].tolist():
        at, pose = pushes[number].tip_start, pushes[number].start
        raise InvalidInput(f"the rod at {at} m lies deep inside the object at {pose}: check the frames")
    way = length / model.unit - travel
    touched = np.flatnonzero(way > 0.0)
    if not touched.size:
        return ends, by
    # A push that goes along with the object is differentiated by where it starts and how far it goes, too.
    still = replace(model.drag_strokes((), 0.0), by_fraction=1.0, with_object=True)
    strokes = [
        replace(still, start_piece=index, start_coordinate=at, direction=toward, length=far)
        for index, at, toward, far in zip(
            piece[touched].tolist(),
            coordinate[touched].tolist(),
            (direction - theta)[touched].tolist(),
            way[touched].tolist(),
            strict=True,
        )
    ]
    angles = theta[touched].tolist()
    courses = [model.course(one, Pose(theta=angle)) for one, angle in zip(strokes, angles, strict=True)]
    ran = run_strokes(courses, len(PARAMETERS))
    ends[touched, :2] += model.unit * ran.pushed[:, :2]
    ends[touched, 2] = ran.pushed[:, 2]
    found = ran.derivatives[:, :3] * np.array((model.unit, model.unit, 1.0))[:, None]
    by[touched, :, :-2] = found[..., _columns(names)] * derivative_units(model, names)
    starting = [_by_shift(model, one, angle) for one, angle in zip(strokes, angles, strict=True)]
    by[touched, :, -2:] = found[..., _columns(("fraction", "angle", "distance"))] @ np.array(starting)
    return ends, by


def _by_shift(model: QuasiStaticModel, strokes: Strokes, theta: float) -> Array:
    """Derivatives of a side push's start, angle and length (extents, rad) by a shift of the rod's path (m), (3, 2)."""
    piece, coordinate = model.pieces[strokes.start_piece], strokes.start_coordinate
    contact, speed = piece.contact(coordinate, model.radius)
    c, s = math.cos(contact.normal + theta), math.sin(contact.normal + theta)
    normal, tangent = np.array((c, s)), np.array((-s, c))
    toward = np.array((math.cos(strokes.direction + theta), math.sin(strokes.direction + theta)))
    longer = normal / (normal @ toward)
    along = (tangent - (tangent @ toward) * longer) / speed
    # The rod keeps its direction where the normal turns.
    return np.array((along, -contact.turning * along, longer)) / model.unit


def _columns(names: tuple[str, ...]) -> list[int]:
    return [PARAMETERS.index(name) for name in names]


def _vector(pose: Pose) -> Array:
    return np.array((pose.x, pose.y, pose.theta))
