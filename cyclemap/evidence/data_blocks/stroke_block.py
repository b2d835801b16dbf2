"""Blocks of data whose prediction is the mechanics of strokes: push end points, drag-backs, and whole cycles."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, whole_number
from cyclemap.collection import CollectionLoop
from cyclemap.collection.settings import with_material
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.data_block import Kinds, Labels, Values, checked_labels, set_fields
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
from cyclemap.mechanics import (
    FoundWith,
    Material,
    PatchFootprint,
    PlatePressure,
    Pose,
    Pusher,
    QuasiStaticModel,
    Slider,
)
from cyclemap.mechanics.cycle_batch import CYCLE_OUTPUTS, CycleBatch, derivative_units, run_batch
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
SHAPE = SURFACE.names[1:5]
CYCLE_UNKNOWNS = (*SHAPE, "pusher_friction", *SHARE_NAMES, "pin_friction_radius")
# Cycles are computed at this many angles and interpolated between by a Fourier series.
NODES = 48
CYCLE_ACCURACY = 1e-6


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
    travel, piece, coordinate = first_touches(model.curve.pieces, model.radius, starts, direction - theta)
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
    piece, coordinate = model.curve.pieces[strokes.start_piece], strokes.start_coordinate
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


def interpolation(theta: ArrayLike, count: int) -> Array:
    """Return the matrix (n, count) from values at 2 pi k / count to the Fourier series through them at theta (n,), rad.

    >>> nodes = 2 * np.pi * np.arange(5) / 5
    >>> bool(np.allclose(interpolation([0.3], 5) @ np.cos(2 * nodes), np.cos(0.6)))
    True
    """
    off = finite_array("theta", theta, ndim=1)[:, np.newaxis] - 2.0 * np.pi * np.arange(count) / count
    orders = np.arange(1, (count - 1) // 2 + 1, dtype=float)
    return np.asarray((1.0 + 2.0 * np.cos(off[..., np.newaxis] * orders).sum(axis=-1)) / count)


@dataclass(frozen=True, eq=False)
class CyclePairBlock:
    """Measured turns of whole cycles, rad, set against the cycle map of a loop.

    loop : who is pushed where, and how it is brought back; surface, pusher friction, rim share and ring are the
        unknowns'. theta, turn (n,) : rad, orientation before a push and how far the cycle turned the object.
    groups (n,) : labels of rows. share (n,) or None : how worn the surface was, 0 fresh to 1 at the end of the data;
        the turn is then blended linearly between the two, its ends having an ellipse each, the worn one's `worn_...`.
    nodes : angles at which cycles are computed; between them a trigonometric polynomial, so the map must be smooth.

    Raises InvalidInput where shapes differ or nothing is given.
    """

    name: str
    loop: CollectionLoop
    theta: Array
    turn: Array
    groups: Labels
    share: Array | None = None
    nodes: int = NODES
    parameters: tuple[str, ...] = field(init=False)
    own_parameters: tuple[Parameter, ...] = field(init=False)
    kinds: Kinds = field(init=False)

    def __post_init__(self) -> None:
        theta, turn = finite_array("theta", self.theta, ndim=1), finite_array("turn", self.turn, ndim=1)
        if theta.size == 0 or turn.shape != theta.shape:
            raise InvalidInput(f"{theta.size} orientations and {turn.size} turns: give one turn for each, one at least")
        whole_number("nodes", self.nodes, least=9)
        worn: list[Parameter] = []
        if self.share is not None:
            share = finite_array("share of wear", self.share, ndim=1)
            if share.shape != theta.shape or share.min() < 0.0 or share.max() > 1.0:
                raise InvalidInput("the share of wear must be a number from 0 to 1 for each cycle")
            set_fields(self, share=share)
            late = "at the end of the data"
            fresh = (SURFACE[name] for name in SHAPE)
            worn = [replace(x, name=f"worn_{x.name}", description=f"{x.description}, {late}") for x in fresh]
        asked = possible_names((*CYCLE_UNKNOWNS, *(one.name for one in worn)), self.loop.slider.outline)
        groups = checked_labels(self.name, self.groups, theta.size)
        set_fields(self, theta=theta, turn=turn, groups=groups, parameters=asked, own_parameters=tuple(worn))
        set_fields(self, kinds=np.repeat(np.array(["cycle turn (rad)"]), theta.size))

    def residuals(self, values: Values) -> Rows:
        """Return predicted minus measured turns, and their derivatives."""
        (turn, jacobian), names = self._predicted(values), (*CYCLE_UNKNOWNS, *(x.name for x in self.own_parameters))
        jacobian = np.hstack([jacobian, np.zeros((turn.size, len(self.own_parameters)))])
        if self.share is not None:
            turn_worn, by_worn = self._predicted({**values, **{name: values[f"worn_{name}"] for name in SHAPE}})
            share = self.share[:, np.newaxis]
            turn = turn + self.share * (turn_worn - turn)
            kept, shape = len(CYCLE_UNKNOWNS), len(SHAPE)
            jacobian *= 1.0 - share
            jacobian[:, shape:kept] += share * by_worn[:, shape:]
            jacobian[:, kept:] = share * by_worn[:, :shape]
        return turn - self.turn, jacobian[:, [names.index(name) for name in self.parameters]]

    def subset(self, keep_groups: ArrayLike) -> CyclePairBlock:
        """Return the block with the rows of some groups only."""
        keep = np.isin(self.groups, keep_groups)
        share = None if self.share is None else self.share[keep]
        return replace(self, theta=self.theta[keep], turn=self.turn[keep], groups=self.groups[keep], share=share)

    def _predicted(self, values: Mapping[str, float]) -> Rows:
        """Turns (n,) on one surface and their derivatives by CYCLE_UNKNOWNS, between an odd number of nodes."""
        theta = 2.0 * np.pi * np.arange(self._between.shape[1]) / self._between.shape[1]
        runs, by_unknowns = cycles_by_unknowns(SurfaceParameters.from_values(values), self.loop, theta)
        by_next = by_unknowns[:, CYCLE_OUTPUTS.index("theta_next")]
        return self._between @ (runs.theta_next[0] - theta), self._between @ by_next

    @cached_property
    def _between(self) -> Array:
        return interpolation(self.theta, self.nodes - 1 + self.nodes % 2)


def cycles_by_unknowns(surface: SurfaceParameters, loop: CollectionLoop, theta: Array) -> tuple[CycleBatch, Array]:
    """Run cycles of the loop on an identified surface from theta (n,), rad; with d CYCLE_OUTPUTS / d CYCLE_UNKNOWNS.

    The batch has the shape (1, n), the derivatives (n, 6, k).
    """
    names = (*FRICTION_NAMES, "pusher_friction", *share_names(loop.slider.outline), "pin_friction_radius")
    runs = run_batch((loop_on(surface, loop),), theta[None], len(PARAMETERS))
    by_mechanics = runs.jacobian[0][:, :, [PARAMETERS.index(name) for name in names]]
    return runs, surface.chain(by_mechanics, names, CYCLE_UNKNOWNS)


def loop_on(surface: SurfaceParameters, loop: CollectionLoop) -> CollectionLoop:
    """Return the loop on an identified surface, with the rod, rim and ring that were identified along with it."""
    shares = {name: share for name, share in surface.shares.items() if name in share_names(loop.slider.outline)}
    plate = PlatePressure(loop.slider.name, **shares)
    found = FoundWith(surface.pusher_friction, surface.pin_friction_radius)
    material = Material("identified", surface.to_friction(), found_with=found, plates=(plate,))
    return with_material(replace(loop, accuracy=CYCLE_ACCURACY), material)
