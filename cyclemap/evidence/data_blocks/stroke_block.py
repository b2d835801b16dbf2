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
from cyclemap.evidence.data_blocks.underside import warp_jacobian, warp_of
from cyclemap.evidence.identification.data_block import Kinds, Labels, Values, kept_rows
from cyclemap.evidence.identification.parameter_space import Parameter
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters
from cyclemap.mechanics import PatchFootprint, Pose, QuasiStaticModel, Slider, WorldPush
from cyclemap.mechanics.stroke_variation import drag_jacobian, push_jacobian

Array = NDArray[np.float64]
Rows = tuple[Array, Array]

# Radians (extents): far below what any camera sees, and differences of 0.2 mm still have three digits.
ACCURACY = 1e-5
_DIFFERENCE = 2e-4
# How far back along its path a rod is looked for outside the object, m: measured poses overlap by tenths of a mm.
_BACK = (0.0, 0.002, 0.005, 0.01, 0.02, 0.04)

TIP_OFFSET = (
    Parameter("tip_offset_x", "shift of the robot's frame against the camera's, along x", "m", -0.01, 0.01, 0.0, 1e-3),
    Parameter("tip_offset_y", "shift of the robot's frame against the camera's, along y", "m", -0.01, 0.01, 0.0, 1e-3),
)
_SHAPE = ("ellipticity_x", "ellipticity_y", "offset_x", "offset_y")
_SADDLE = ("saddle_a", "saddle_b")
_WARP = ("warp_a", "warp_b")
PUSH_UNKNOWNS = (*_SHAPE, "pusher_friction", "rim_share", *_SADDLE)
DRAG_UNKNOWNS = (*_SHAPE, "rim_share", "hitch_scale", "hitch_turn", "pin_friction_radius", *_SADDLE)
_FRICTION = ("mu_a", "mu_b", "m0", "n0", "phi")

Misfit = Callable[["StrokeBlock", QuasiStaticModel, SurfaceParameters, Any, Values], Rows]


@dataclass(frozen=True, eq=False)
class StrokeBlock:
    """Measured strokes set against the quasi-static model of one slider.

    parameters : names in order. strokes : what was measured. misfit : (block, model, surface, stroke, values) ->
    residuals (m,) and derivatives (m, k) of one stroke. row_kinds (m,) : kind of noise of each of its rows.
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
        model = surface_model(surface, self.slider)
        rows = [self.misfit(self, model, surface, stroke, values) for stroke in self.strokes]
        return np.concatenate([row[0] for row in rows]), np.concatenate([row[1] for row in rows])

    def subset(self, keep_groups: ArrayLike) -> StrokeBlock:
        """Return the block with the strokes of some groups only."""
        keep = kept_rows(self.labels, keep_groups)
        strokes = tuple(stroke for stroke, kept in zip(self.strokes, keep, strict=True) if kept)
        return replace(self, strokes=strokes, labels=self.labels[keep])


def push_end_block(
    pushes: Sequence[MeasuredPush], slider: Slider, name: str = "push ends", warped: bool = False
) -> StrokeBlock:
    """Return the block of where pushes ended: place (m) and orientation (rad), grouped by contact.

    warped : whether the saddle of the pressure is an unknown; it doubles the time. Its own unknowns are `tip_offset_x`,
    `tip_offset_y`: what to add to the robot's places to have them in the frame of the object's poses.
    """
    shared = PUSH_UNKNOWNS if warped else tuple(name for name in PUSH_UNKNOWNS if name not in _SADDLE)
    parameters = (*shared, *(parameter.name for parameter in TIP_OFFSET))
    kinds = ("push place (m)", "push place (m)", "push turn (rad)")
    labels = np.array([push.contact for push in pushes], dtype=np.int64)
    return StrokeBlock(name, parameters, tuple(pushes), _push_misfit, kinds, labels, slider, TIP_OFFSET)


def drag_turn_block(
    drags: Sequence[MeasuredDrag], slider: Slider, name: str = "drag-backs", warped: bool = False
) -> StrokeBlock:
    """Return the block of how far drags turned the object (rad), each ring going straight to where it ended.

    warped : as of `push_end_block`.
    """
    shared = DRAG_UNKNOWNS if warped else tuple(name for name in DRAG_UNKNOWNS if name not in _SADDLE)
    labels = np.array([drag.contact for drag in drags], dtype=np.int64)
    return StrokeBlock(name, shared, tuple(drags), _drag_misfit, ("drag turn (rad)",), labels, slider)


def surface_model(surface: SurfaceParameters, slider: Slider, accuracy: float = ACCURACY) -> QuasiStaticModel:
    """Return the model of a slider on a surface, its hitch and its weight on the rim as the surface says."""
    effective = replace(slider, hitch=surface.hitch(slider.hitch))
    assert slider.centre_of_mass is not None
    warp = warp_of(surface, slider)
    footprint = PatchFootprint.under(slider.outline, slider.centre_of_mass, surface.rim_share, warp)
    return QuasiStaticModel(effective, surface.to_friction(), surface.pusher(), footprint, accuracy)


def predicted_push_end(
    model: QuasiStaticModel, push: MeasuredPush, shift: tuple[float, float] = (0.0, 0.0)
) -> tuple[Pose, Any]:
    """Return the pose after a push whose rod path is shifted (m), and the run; none where the rod does not touch."""
    c, s = math.cos(push.direction), math.sin(push.direction)
    for back in _BACK:
        start = (push.tip_start[0] + shift[0] - back * c, push.tip_start[1] + shift[1] - back * s)
        try:
            run = model.push(push.start, WorldPush(start, push.direction, push.length + back))
        except RodInsideObject:
            continue
        except RodMissesObject:
            return push.start, None
        return run.end, run
    raise InvalidInput(f"the rod at {push.tip_start} m lies deep inside the object at {push.start}: check the frames")


def _push_misfit(
    block: StrokeBlock, model: QuasiStaticModel, surface: SurfaceParameters, push: MeasuredPush, values: Values
) -> Rows:
    shared, own = block.parameters[:-2], block.parameters[-2:]
    shift = (values[own[0]], values[own[1]])
    end, run = predicted_push_end(model, push, shift)
    jacobian = np.zeros((3, len(block.parameters)))
    if run is not None:
        names = (*_FRICTION, "pusher_friction", "rim_share", *_warp_names(block))
        jacobian[:, :-2] = _chained(block, surface, push_jacobian(model, run, names), names, shared)
        for column, step in ((-2, (_DIFFERENCE, 0.0)), (-1, (0.0, _DIFFERENCE))):
            moved, _ = predicted_push_end(model, push, (shift[0] + step[0], shift[1] + step[1]))
            jacobian[:, column] = (_vector(moved) - _vector(end)) / _DIFFERENCE
    return _vector(end) - _vector(push.end), jacobian


def _drag_misfit(
    block: StrokeBlock, model: QuasiStaticModel, surface: SurfaceParameters, drag: MeasuredDrag, values: Values
) -> Rows:
    # Where the effective hitch is not the real one, the rod still went to where the real one is at the end.
    goal = drag.end.to_world(*block.slider.hitch)
    run = model.drag(drag.start, (goal,), pin_friction_radius=surface.pin_friction_radius)
    names = (*_FRICTION, "rim_share", "hitch_x", "hitch_y", "pin_friction_radius", *_warp_names(block))
    jacobian = _chained(block, surface, drag_jacobian(model, run, names)[2:], names, block.parameters)
    return np.array([run.end.theta - drag.end.theta]), jacobian


def _warp_names(block: StrokeBlock) -> tuple[str, ...]:
    return _WARP if "saddle_b" in block.parameters else ()


def _chained(
    block: StrokeBlock, surface: SurfaceParameters, jacobian: Array, names: tuple[str, ...], wanted: tuple[str, ...]
) -> Array:
    """Turn derivatives by the mechanics' parameters into those by the unknowns `wanted`."""
    if "warp_a" in names:
        # By the unknowns of the underside first: they go by the same names in what follows.
        by_underside = jacobian[:, -2:] @ warp_jacobian(surface, block.slider)
        jacobian = np.hstack([jacobian[:, :-2], by_underside])
        names = (*names[:-2], "rim_share", *_SADDLE)
    return surface.chain(jacobian, names, wanted, hitch=block.slider.hitch)


def _vector(pose: Pose) -> Array:
    return np.array((pose.x, pose.y, pose.theta))
