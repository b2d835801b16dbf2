"""Blocks of data whose prediction is the mechanics of single strokes: push end points and drag-backs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.errors import InvalidInput, RodInsideObject, RodMissesObject
from cyclemap.evidence.data_blocks.measured_strokes import MeasuredDrag, MeasuredPush
from cyclemap.evidence.identification.data_block import Kinds, Labels, Values, kept_rows
from cyclemap.evidence.identification.parameter_space import Parameter
from cyclemap.evidence.identification.surface_parameters import (
    FRICTION_NAMES,
    HITCH_NAMES,
    SurfaceParameters,
    share_names,
)
from cyclemap.mechanics import PatchFootprint, Pose, QuasiStaticModel, Slider, WorldPush
from cyclemap.mechanics.cycle_batch import derivative_units
from cyclemap.mechanics.engine.strokes import PARAMETERS, Strokes
from cyclemap.mechanics.quasi_static import run_strokes

Array = NDArray[np.float64]
Rows = tuple[Array, Array]

# Radians (extents): far below what any camera sees.
ACCURACY = 1e-5
# How far back along its path a rod is looked for outside the object, m: measured poses overlap by tenths of a mm.
_BACK = (0.0, 0.002, 0.005, 0.01, 0.02, 0.04)

TIP_OFFSET = (
    Parameter("tip_offset_x", "shift of the robot's frame against the camera's, along x", "m", -0.01, 0.01, 0.0, 1e-3),
    Parameter("tip_offset_y", "shift of the robot's frame against the camera's, along y", "m", -0.01, 0.01, 0.0, 1e-3),
)
_SHAPE = ("ellipticity_x", "ellipticity_y", "offset_x", "offset_y")
_SHARES = ("rim_share", "corner_share", "inner_share")
PUSH_UNKNOWNS = (*_SHAPE, "pusher_friction", *_SHARES)
DRAG_UNKNOWNS = (*_SHAPE, *_SHARES, "hitch_scale", "hitch_turn", "pin_friction_radius")

Misfit = Callable[["StrokeBlock", QuasiStaticModel, SurfaceParameters, Values], Rows]


@dataclass(frozen=True, eq=False)
class StrokeBlock:
    """Measured strokes set against the quasi-static model of one slider.

    parameters : names in order. strokes : what was measured. misfit : (block, model, surface, values) -> residuals
    (n, m) and derivatives (n, m, k) of all strokes. row_kinds (m,) : kind of noise of each row of a stroke.
    labels (n,) : group of each stroke. own_parameters : unknowns that belong to these data alone.
    """

    name: str
    parameters: tuple[str, ...]
    strokes: tuple[Any, ...]
    misfit: Misfit
    row_kinds: tuple[str, ...]
    labels: Labels
    slider: Slider
    own_parameters: tuple[Parameter, ...] = ()

    def __post_init__(self) -> None:
        if not self.strokes:
            raise InvalidInput(f"block {self.name!r} has no strokes: give some")

    @property
    def groups(self) -> Labels:
        """Group of each row."""
        return np.repeat(self.labels, len(self.row_kinds))

    @property
    def kinds(self) -> Kinds:
        """Kind of noise of each row."""
        return np.tile(np.array(self.row_kinds, dtype=np.str_), len(self.strokes))

    def residuals(self, values: Values) -> Rows:
        """Return predicted minus measured values and their derivatives, a few rows a stroke, in order."""
        surface = SurfaceParameters.from_values(values)
        residual, jacobian = self.misfit(self, surface_model(surface, self.slider), surface, values)
        return residual.ravel(), jacobian.reshape(residual.size, len(self.parameters))

    def subset(self, keep_groups: ArrayLike) -> StrokeBlock:
        """Return the block with the strokes of some groups only."""
        keep = kept_rows(self.labels, keep_groups)
        strokes = tuple(stroke for stroke, kept in zip(self.strokes, keep, strict=True) if kept)
        return replace(self, strokes=strokes, labels=self.labels[keep])


def push_end_block(pushes: Sequence[MeasuredPush], slider: Slider, name: str = "push ends") -> StrokeBlock:
    """Return the block of where pushes ended: place (m) and orientation (rad), grouped by contact.

    Its own unknowns are `tip_offset_x`, `tip_offset_y`: what to add to the robot's places to have them in the frame of
    the object's poses.
    """
    parameters = (*_possible(PUSH_UNKNOWNS, slider), *(parameter.name for parameter in TIP_OFFSET))
    kinds = ("push place (m)", "push place (m)", "push turn (rad)")
    labels = np.array([push.contact for push in pushes], dtype=np.int64)
    return StrokeBlock(name, parameters, tuple(pushes), _push_misfit, kinds, labels, slider, TIP_OFFSET)


def drag_turn_block(drags: Sequence[MeasuredDrag], slider: Slider, name: str = "drag-backs") -> StrokeBlock:
    """Return the block of how far drags turned the object (rad), each ring going straight to where it ended."""
    labels = np.array([drag.contact for drag in drags], dtype=np.int64)
    parameters = _possible(DRAG_UNKNOWNS, slider)
    return StrokeBlock(name, parameters, tuple(drags), _drag_misfit, ("drag turn (rad)",), labels, slider)


def _possible(names: tuple[str, ...], slider: Slider) -> tuple[str, ...]:
    """The names without shares of the weight that the slider cannot have."""
    shares = share_names(slider.outline)
    return tuple(name for name in names if name not in _SHARES or name in shares)


def surface_model(surface: SurfaceParameters, slider: Slider, accuracy: float = ACCURACY) -> QuasiStaticModel:
    """Return the model of a slider on a surface, its hitch and the shares of its weight as the surface says."""
    effective = replace(slider, hitch=surface.hitch(slider.hitch))
    footprint = PatchFootprint(slider.outline, **surface.shares, centre=slider.centre_of_mass)
    return QuasiStaticModel(effective, surface.to_friction(), surface.pusher(), footprint, accuracy)


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
    courses, starts, touched = [], [], []
    for number, push in enumerate(pushes):
        strokes = _touching(model, push, shift)
        if strokes is not None:
            # A push that goes along with the object is differentiated by where it starts and how far it goes, too.
            own = replace(strokes, from_target=True, by_fraction=1.0, direction=strokes.direction - push.start.theta)
            courses.append(model.course(own, Pose(theta=push.start.theta)))
            starts.append(_by_shift(model, strokes, push.start.theta))
            touched.append(number)
    if not touched:
        return ends, by
    ran = run_strokes(courses, len(PARAMETERS))
    ring = np.array([model.ring_place(Pose(theta=pushes[number].start.theta)) for number in touched])
    ends[touched, :2] += model.unit * ran.pushed[:, :2] + ring
    ends[touched, 2] = ran.pushed[:, 2]
    found = ran.derivatives[:, :3] * np.array((model.unit, model.unit, 1.0))[:, None]
    by[touched, :, :-2] = found[..., _columns(names)] * derivative_units(model, names)
    by[touched, :, -2:] = found[..., _columns(("fraction", "angle", "distance"))] @ np.array(starts)
    return ends, by


def _touching(model: QuasiStaticModel, push: MeasuredPush, shift: tuple[float, float]) -> Strokes | None:
    """What the engine is asked for; None where the rod does not touch."""
    c, s = math.cos(push.direction), math.sin(push.direction)
    for back in _BACK:
        start = (push.tip_start[0] + shift[0] - back * c, push.tip_start[1] + shift[1] - back * s)
        try:
            return model.push_strokes(push.start, WorldPush(start, push.direction, push.length + back))
        except RodInsideObject:
            continue
        except RodMissesObject:
            return None
    raise InvalidInput(f"the rod at {push.tip_start} m lies deep inside the object at {push.start}: check the frames")


def _by_shift(model: QuasiStaticModel, strokes: Strokes, theta: float) -> Array:
    """Derivatives of a side push's start, angle and length (extents, rad) by a shift of the rod's path (m), (3, 2)."""
    piece, coordinate = model.pieces[strokes.start_piece], strokes.start_coordinate
    contact, speed = piece.contact(coordinate, model.radius)
    c, s = math.cos(contact.normal + theta), math.sin(contact.normal + theta)
    normal, tangent = np.array((c, s)), np.array((-s, c))
    toward = np.array((math.cos(strokes.direction), math.sin(strokes.direction)))
    longer = normal / (normal @ toward)
    along = (tangent - (tangent @ toward) * longer) / speed
    # The rod keeps its direction where the normal turns.
    return np.array((along, -piece.normal_slope(coordinate) * along, longer)) / model.unit


def _push_misfit(block: StrokeBlock, model: QuasiStaticModel, surface: SurfaceParameters, values: Values) -> Rows:
    shared, own = block.parameters[:-2], block.parameters[-2:]
    names = (*FRICTION_NAMES, "pusher_friction", *share_names(block.slider.outline))
    ends, by = predicted_push_ends(model, block.strokes, (values[own[0]], values[own[1]]), names)
    jacobian = np.concatenate([surface.chain(by[..., :-2], names, shared), by[..., -2:]], axis=-1)
    return ends - np.array([_vector(push.end) for push in block.strokes]), jacobian


def _drag_misfit(block: StrokeBlock, model: QuasiStaticModel, surface: SurfaceParameters, values: Values) -> Rows:
    # Where the effective hitch is not the real one, the rod still went to where the real one is at the end.
    goals = [(drag.end.to_world(*block.slider.hitch),) for drag in block.strokes]
    courses = [
        model.course(model.drag_strokes(goal, surface.pin_friction_radius), drag.start)
        for goal, drag in zip(goals, block.strokes, strict=True)
    ]
    ran = run_strokes(courses, len(PARAMETERS))
    names = (*FRICTION_NAMES, *share_names(block.slider.outline), *HITCH_NAMES, "pin_friction_radius")
    by = ran.derivatives[:, 5:6][..., _columns(names)] * derivative_units(model, names)
    measured = np.array([drag.end.theta for drag in block.strokes])
    return (ran.ended[:, 2] - measured)[:, None], surface.chain(by, names, block.parameters, block.slider.hitch)


def _columns(names: tuple[str, ...]) -> list[int]:
    return [PARAMETERS.index(name) for name in names]


def _vector(pose: Pose) -> Array:
    return np.array((pose.x, pose.y, pose.theta))
