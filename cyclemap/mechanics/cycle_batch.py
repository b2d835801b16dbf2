"""Whole cycles of many loops in one call of the engine, and derivatives of cycles, pushes and drags."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.errors import CycleMapError
from cyclemap.mechanics.engine import strokes as engine
from cyclemap.mechanics.engine.strokes import PARAMETERS, Ran, Strokes
from cyclemap.mechanics.footprint import PatchFootprint
from cyclemap.mechanics.outline import Ellipse
from cyclemap.mechanics.protocol import DragBack, Pose, SidePush
from cyclemap.mechanics.quasi_static import QuasiStaticModel, refusal, run_strokes
from cyclemap.mechanics.trajectory import DragResult, PushResult
from cyclemap.suggestions import unknown_name

# What a cycle gives, and what a stroke from a given pose along a given path can be differentiated by.
CYCLE_OUTPUTS = ("push_turn", "push_dx", "push_dy", "drag_turn", "drag_length", "theta_next")
_OWN = ("theta", "pusher_radius", "fraction", "angle", "distance")
_HITCH = PARAMETERS.index("hitch_x")
STROKE_PARAMETERS = tuple(name for name in PARAMETERS if name not in _OWN)
_FRICTION = ("mu_a", "mu_b", "m0", "n0")
# Ends of pushes that are kept of one model: maps take hundreds of samples, those with jumps thousands.
_MOST_KEPT = 20_000
_LENGTHS = ("pusher_radius", "distance", "hitch_x", "hitch_y", "pin_friction_radius")


class PushAndReset(Protocol):
    """What is done over and over: a push of a model from the ring's target, and the drag back to it."""

    @property
    def model(self) -> QuasiStaticModel:
        """The object on its surface, with the rod."""

    @property
    def push(self) -> SidePush:
        """The push."""

    @property
    def reset(self) -> DragBack:
        """The way back."""


@dataclass(frozen=True, eq=False)
class CycleBatch:
    """Cycles in the shape (k, n): k loops, each from n orientations; SI units and radians.

    push_turn, drag_turn, theta_next (lift), drag_length : (k, n). push_displacement : (k, n, 2). left : (k, n), bool.
    jacobian : (k, n, 6, p), derivatives of CYCLE_OUTPUTS by the first p of PARAMETERS.
    """

    push_turn: Array
    push_displacement: Array
    drag_turn: Array
    drag_length: Array
    theta_next: Array
    left: NDArray[np.bool_]
    jacobian: Array


def run_batch(loops: Sequence[PushAndReset], theta: Array, derivatives: int = 0) -> CycleBatch:
    """Run cycles of k loops from orientations theta (k, n), rad, on all cores; results do not depend on how many.

    Raises what the first cycle that fails ends with, telling which loop and orientation.
    """
    strokes = [_told(number, loop) for number, loop in enumerate(loops)]
    number = np.repeat(np.arange(len(loops)), theta.shape[1])
    unit = np.array([loop.model.unit for loop in loops])[number]
    lever = np.array([loop.model.slider.hitch for loop in loops]).reshape(-1, 2)[number]
    start = theta.ravel()
    (c, s), ring = _turned(start, lever)
    # Before the push the ring is at the origin.
    varied = np.zeros((start.size, 3, derivatives))
    if derivatives:
        varied[:, 0, 0], varied[:, 1, 0], varied[:, 2, 0] = ring[:, 1] / unit, -ring[:, 0] / unit, 1.0
    if derivatives > _HITCH:
        varied[:, 0, _HITCH], varied[:, 0, _HITCH + 1], varied[:, 1, _HITCH], varied[:, 1, _HITCH + 1] = -c, s, -s, -c
    ran = engine.run(strokes, number, np.column_stack([-ring / unit[:, None], start]), varied)
    _check(ran, strokes, start, number)
    shift = unit[:, None] * ran.pushed[:, :2] + ring
    moved = np.column_stack([c * shift[:, 0] + s * shift[:, 1], c * shift[:, 1] - s * shift[:, 0]])
    turned, end = ran.pushed[:, 2], ran.ended[:, 2]
    jacobian = np.zeros((theta.size, len(CYCLE_OUTPUTS), derivatives))
    if derivatives:
        scales = np.array([_units(loop.model, PARAMETERS[:derivatives]) for loop in loops])[number]
        by = ran.derivatives * scales[:, None]
        by[:, [0, 1, 3, 4, 6]] *= unit[:, None, None]
        from_start = varied * scales[:, None]
        from_start[:, :2] *= unit[:, None, None]
        by_theta = from_start[:, 2]
        by_x, by_y = by[:, 0] - from_start[:, 0], by[:, 1] - from_start[:, 1]
        jacobian[:, 0] = by[:, 2] - by_theta
        jacobian[:, 1] = c[:, None] * by_x + s[:, None] * by_y + moved[:, 1, None] * by_theta
        jacobian[:, 2] = c[:, None] * by_y - s[:, None] * by_x - moved[:, 0, None] * by_theta
        jacobian[:, 3], jacobian[:, 4], jacobian[:, 5] = by[:, 5] - by[:, 2], by[:, 6], by[:, 5]
    shape = theta.shape
    return CycleBatch(
        (turned - start).reshape(shape),
        moved.reshape(*shape, 2),
        (end - turned).reshape(shape),
        (unit * ran.way).reshape(shape),
        end.reshape(shape).copy(),
        ran.left.reshape(shape),
        jacobian.reshape(*shape, *jacobian.shape[1:]),
    )


class CycleSlopes:
    """theta_next (rad, lift) and its slope, at any orientations, of one loop: pushes first, then drags from their ends.

    The numbers are those of `run_batch` to the bit. What pushes come to is kept, since the ring has no part in it:
    loops that differ in nothing but the ring's place and the way back, as points of a phase diagram, share it.
    """

    def __init__(self, loop: PushAndReset) -> None:
        model, reset = loop.model, loop.reset
        ringless = replace(model, slider=replace(model.slider, hitch=model.slider.centre_of_mass))
        self._pushes = _kept_pushes(ringless, loop.push)
        self._lever = np.array([model.slider.hitch])
        self._unit = model.unit
        self._drag = model.cycle_strokes(loop.push, reset)
        self._drag = replace(self._drag, length=0.0)

    def __call__(self, theta: Array) -> tuple[Array, Array]:
        """Return both (n,) at orientations (n,), rad. Raises what the first cycle that fails ends with."""
        pushed, by = self._pushes.ends(theta)
        _, ring = _turned(theta, self._lever)
        pushed[:, :2] += -ring / self._unit
        by[:, 0] += ring[:, 1] / self._unit
        by[:, 1] += -ring[:, 0] / self._unit
        ran = engine.run([self._drag], np.zeros(theta.size, int), pushed, by[:, :, None])
        _check(ran, [self._drag], theta)
        return ran.ended[:, 2], ran.derivatives[:, 5, 0]


class _KeptPushes:
    """Pushes of a model from the origin: by orientation, the pose that they end in and its derivatives by it."""

    def __init__(self, model: QuasiStaticModel, push: SidePush) -> None:
        self._strokes = replace(model.push_strokes(Pose(), push), with_object=True)
        self._ends: dict[float, Array] = {}

    def ends(self, theta: Array) -> tuple[Array, Array]:
        """Poses (n, 3) and derivatives (n, 3), extents and rad."""
        new = np.array([angle for angle in theta.tolist() if angle not in self._ends])
        if new.size:
            varied = np.zeros((new.size, 3, 1))
            varied[:, 2] = 1.0
            poses = np.column_stack([np.zeros((new.size, 2)), new])
            ran = engine.run([self._strokes], np.zeros(new.size, int), poses, varied)
            _check(ran, [self._strokes], new)
            if len(self._ends) > _MOST_KEPT:
                self._ends = {angle: self._ends[angle] for angle in theta.tolist() if angle in self._ends}
            ends = np.column_stack([ran.pushed, ran.derivatives[:, :3, 0]])
            self._ends.update(zip(new.tolist(), ends, strict=True))
        found = np.array([self._ends[angle] for angle in theta.tolist()])
        return found[:, :3], found[:, 3:]


@lru_cache(maxsize=128)
def _kept_pushes(model: QuasiStaticModel, push: SidePush) -> _KeptPushes:
    return _KeptPushes(model, push)


def _turned(theta: Array, lever: Array) -> tuple[tuple[Array, Array], Array]:
    """Cosines and sines of orientations (n,), and levers (n, 2) in the world's axes; as `Pose` rounds them."""
    c, s = (np.array([of(angle) for angle in theta.tolist()]) for of in (math.cos, math.sin))
    return (c, s), np.column_stack([c * lever[:, 0] - s * lever[:, 1], s * lever[:, 0] + c * lever[:, 1]])


def _check(ran: Ran, strokes: Sequence[Strokes], theta: Array, number: NDArray[np.intp] | None = None) -> None:
    """Raise what the first task that failed ended with, telling its orientation and, of several, its loop."""
    failed = np.flatnonzero(ran.status <= 0)
    if failed.size:
        index = int(failed[0])
        loop = 0 if number is None else int(number[index])
        error, which = refusal(int(ran.status[index]), strokes[loop]), f"loop {loop} from " if len(strokes) > 1 else ""
        raise type(error)(f"{which}theta = {float(theta[index])!r} rad: {error}")


def _told(number: int, loop: PushAndReset) -> Strokes:
    try:
        return loop.model.cycle_strokes(loop.push, loop.reset)
    except CycleMapError as error:
        raise type(error)(f"loop {number}: {error}") from error


def push_jacobian(model: QuasiStaticModel, push: PushResult, names: tuple[str, ...] = STROKE_PARAMETERS) -> Array:
    """Return d (x, y, theta) / d names, (3, k), of a push's end (m, rad), its start and the rod's path being fixed.

    By what belongs to the ring alone it is zero; by shares of the pressure that the footprint cannot have it is nan.
    Mostly good to a hundred times the accuracy of the run, except on trajectories that touch a discontinuity. Raises
    InvalidInput for an unknown name.

    >>> from cyclemap.mechanics import EllipseFriction, Pose, Slider
    >>> model = QuasiStaticModel(Slider.mit("rect1"), EllipseFriction.isotropic(0.25))
    >>> push = model.push(Pose(), SidePush(distance=0.05))
    >>> push_jacobian(model, push, ("pusher_friction", "hitch_x")).round(4)
    array([[ 0.0188,  0.    ],
           [ 0.0044,  0.    ],
           [-0.3548,  0.    ]])
    """
    found: Array = stroke_jacobians(model, [push], names)[0]
    return found


def drag_jacobian(model: QuasiStaticModel, drag: DragResult, names: tuple[str, ...] = STROKE_PARAMETERS) -> Array:
    """Return d (x, y, theta) / d names, (3, k), of a drag's end (m, rad), its start and its way-points being fixed.

    The ring's own start moves with the hitch. By the friction of a ring that has none it is the one-sided derivative.
    A way-point at which the ring already was counts for nothing. Otherwise as `push_jacobian`.
    """
    found: Array = stroke_jacobians(model, [drag], names)[0]
    return found


def stroke_jacobians(
    model: QuasiStaticModel, strokes: Sequence[PushResult | DragResult], names: tuple[str, ...] = STROKE_PARAMETERS
) -> Array:
    """Return `push_jacobian` or `drag_jacobian` (n, 3, k) of many strokes of one model, on all cores."""
    for name in names:
        if name not in STROKE_PARAMETERS:
            raise unknown_name("parameter", name, STROKE_PARAMETERS)
    courses = []
    for stroke in strokes:
        # What ran was a whole cycle, or from its own pose: here the stroke alone, from where it started.
        own = replace(stroke.course.strokes, with_object=False)
        if isinstance(stroke, PushResult):
            own = replace(own, goals=(), direction=own.direction + _turned_by(stroke))
        else:
            own = replace(own, length=0.0)
        courses.append(model.course(own, stroke.start))
    by = run_strokes(courses, len(PARAMETERS)).derivatives * _units(model, PARAMETERS)
    pushed = np.array([isinstance(stroke, PushResult) for stroke in strokes])
    outputs: Array = np.where(pushed[:, None, None], by[:, 0:3], by[:, 3:6])
    outputs[:, :2] *= model.unit
    return np.asarray(outputs[:, :, [PARAMETERS.index(name) for name in names]])


def _turned_by(push: PushResult) -> float:
    return push.start.theta if push.course.strokes.with_object else 0.0


def derivative_units(model: QuasiStaticModel, names: tuple[str, ...]) -> Array:
    """Return what derivatives by the engine's parameters `names` are to be multiplied by, (k,), to be those by SI."""
    factors = ((1.0 / model.unit, _LENGTHS), (1.0 / model.scale, _FRICTION))
    return np.array([next((factor for factor, members in factors if name in members), 1.0) for name in names])


def _units(model: QuasiStaticModel, names: tuple[str, ...]) -> Array:
    """The same; nan for shares that there cannot be."""
    footprint, units = model.pressure, derivative_units(model, names)
    for index, name in enumerate(names):
        if name.endswith("_share"):
            has = isinstance(footprint, PatchFootprint) and (
                footprint.has_frame if name != "corner_share" else not isinstance(footprint.outline, Ellipse)
            )
            units[index] = 1.0 if has else math.nan
    return units
