"""Whole cycles of many loops in one call of the engine, and their derivatives."""

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.errors import CycleMapError
from cyclemap.mechanics.engine import strokes as engine
from cyclemap.mechanics.engine.parts import PARTS
from cyclemap.mechanics.engine.schema import OUTPUT, PARAMETERS, SHAPES
from cyclemap.mechanics.engine.strokes import Ran, Strokes, pressure_tables
from cyclemap.mechanics.foundation import PressedFootprint
from cyclemap.mechanics.quasi_static import QuasiStaticModel, refusal
from cyclemap.mechanics.slider import DragBack, Pose, SidePush

# What a cycle gives.
CYCLE_OUTPUTS = ("push_turn", "push_dx", "push_dy", "drag_turn", "drag_length", "theta_next")
_FRICTION = ("mu_a", "mu_b", "m0", "n0")
# Ends of pushes that are kept of one model: maps take hundreds of samples, those with jumps
# thousands.
_MOST_KEPT = 20_000
# Radius, in extents, of the rod whose derivatives by it stand for those of a point, and the share
# by which one of twice that may differ: where they are no limit, they go as a root.
_THIN, _NO_LIMIT = 4e-6, 1e-2
_LENGTHS = ("pusher_radius", "distance", "hitch_x", "hitch_y", "pin_friction_radius")


class PushAndReset(Protocol):
    """What is done over and over: a push of a model from the ring's target, and the drag back to
    it.
    """

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

    push_turn, drag_turn, theta_next (lift), drag_length : (k, n).
    push_displacement : (k, n, 2).
    left : (k, n), bool.
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
    """Run cycles of k loops from orientations theta (k, n), rad, on all cores; results do not
    depend on how many.

    Raises what the first cycle that fails ends with, telling its orientation and, of
    several, its loop.
    """
    strokes = []
    for place, loop in enumerate(loops):
        try:
            strokes.append(loop.model.cycle_strokes(loop.push, loop.reset))
        except CycleMapError as error:
            which = f"loop {place}: " if len(loops) > 1 else ""
            raise type(error)(f"{which}{error}") from error
    owner = np.repeat(np.arange(len(loops)), theta.shape[1])
    unit = np.array([loop.model.unit for loop in loops])[owner]
    lever = np.array([loop.model.slider.hitch for loop in loops]).reshape(-1, 2)[owner]
    start = theta.ravel()
    (c, s), ring = _turned(start, lever)
    varied = _start_varies(c, s, ring, unit, derivatives)
    poses = np.column_stack([-ring / unit[:, None], start])
    ran = engine.run(strokes, owner, poses, varied)
    _check(ran, strokes, start, owner)
    if derivatives > PARAMETERS.index("pusher_radius"):
        _thicken_points(ran, loops, owner, poses, varied)
    (x, y), (ring_x, ring_y) = ran.pushed[:, :2].T, ring.T
    x, y = unit * x + ring_x, unit * y + ring_y
    moved = np.column_stack([c * x + s * y, c * y - s * x])
    turned, end = ran.pushed[:, 2], ran.ended[:, 2]
    jacobian = np.zeros((theta.size, len(CYCLE_OUTPUTS), derivatives))
    if derivatives:
        names = PARAMETERS[:derivatives]
        scales = np.array([derivative_units(loop.model, names) for loop in loops])[owner]
        jacobian = _jacobian(ran, varied, moved, (c, s), scales, unit[:, None])
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


def _start_varies(c: Array, s: Array, ring: Array, unit: Array | float, derivatives: int) -> Array:
    """Derivatives (n, 3, k) of poses, extents, at which pushes start, the ring at the origin.

    c, s : cosines and sines of the orientations.
    ring : (n, 2), its lever in the world's axes, m.
    unit : extents, m.
    """
    varied = np.zeros((len(ring), 3, derivatives))
    x, y, theta = np.moveaxis(varied, 1, 0)
    ring_x, ring_y = ring.T
    if derivatives:
        first = PARAMETERS.index("theta")
        x[:, first], y[:, first], theta[:, first] = ring_y / unit, -ring_x / unit, 1.0
    if derivatives > PARAMETERS.index("hitch_y"):
        by_x, by_y = PARAMETERS.index("hitch_x"), PARAMETERS.index("hitch_y")
        x[:, by_x], x[:, by_y], y[:, by_x], y[:, by_y] = -c, s, -s, -c
    return varied


def _thicken_points(
    ran: Ran, loops: Sequence[PushAndReset], owner: NDArray[np.intp], poses: Array, varied: Array
) -> None:
    """Fill in, where it is nan, the derivative by the radius of a rod that is a point.

    It is that of thin rods in their limit, from two of them. They go around a corner, and turn in
    a concave one, where a point has neither an arc nor a torque. It stays nan where the rods do not
    come to where the point does, or where the derivative has no limit: a rod that starts at a
    corner.
    """
    column = PARAMETERS.index("pusher_radius")
    lacking = np.flatnonzero(np.isnan(ran.derivatives[:, :, column]).any(axis=1))
    if not lacking.size:
        return
    used, which = np.unique(owner[lacking], return_inverse=True)
    pairs = []
    for radius in (_THIN, 2.0 * _THIN):
        strokes = []
        for loop in (loops[index] for index in used.tolist()):
            model = loop.model
            pusher = replace(model.pusher, radius=radius * model.unit)
            thin = replace(model, pusher=pusher, accuracy=1e-11)
            strokes.append(thin.cycle_strokes(loop.push, loop.reset))
        pairs.append(engine.run(strokes, which, poses[lacking], varied[lacking]))
    thin, twice = pairs
    by, by_twice = thin.derivatives[:, :, column], twice.derivatives[:, :, column]
    most = 1.0 + np.abs(by).max(axis=1)
    is_limit = np.abs(by_twice - by).max(axis=1) < _NO_LIMIT * most
    jump = np.abs(thin.ended - ran.ended[lacking]).max(axis=1)
    is_limit &= jump < 1e3 * _THIN * most
    ran.derivatives[lacking[is_limit], :, column] = (2.0 * by - by_twice)[is_limit]


def _jacobian(
    ran: Ran, varied: Array, moved: Array, facing: tuple[Array, Array], scales: Array, unit: Array
) -> Array:
    """Derivatives (n, 6, k) of CYCLE_OUTPUTS; `moved`: the displacement in the first frame."""
    by = OUTPUT.columns_of(ran.derivatives * scales[:, None])
    x, y, theta = np.moveaxis(varied * scales[:, None], 1, 0)
    pushed_x, pushed_y, pushed = np.moveaxis(by.pushed, 1, 0)
    _, _, ended = np.moveaxis(by.ended, 1, 0)
    by_x, by_y = unit * pushed_x - unit * x, unit * pushed_y - unit * y
    c, s = (each[:, None] for each in facing)
    dx, dy = (each[:, None] for each in moved.T)
    rows = {
        "push_turn": pushed - theta,
        "push_dx": c * by_x + s * by_y + dy * theta,
        "push_dy": c * by_y - s * by_x - dx * theta,
        "drag_turn": ended - pushed,
        "drag_length": unit * by.way,
        "theta_next": ended,
    }
    return np.stack([rows[name] for name in CYCLE_OUTPUTS], axis=1)


class CycleSlopes:
    """theta_next (rad, lift) and its slope, at any orientations, of one loop: pushes first, then
    drags from their ends.

    The numbers are those of `run_batch` to the bit. What pushes come to is kept, since the ring has
    no part in it: loops that differ in nothing but the ring's place and the way back, as points of
    a phase diagram, share it.
    """

    def __init__(self, loop: PushAndReset) -> None:
        model = loop.model
        self._lever, self._unit = np.array([model.slider.hitch]), model.unit
        self._push = replace(model.push_strokes(Pose(), loop.push), with_object=True)
        self._drag = replace(model.cycle_strokes(loop.push, loop.reset), length=0.0)
        pressure = model.pressure
        # Where the floor's shape varies with the place, a push depends on where it begins, too.
        self._has_place = isinstance(pressure, PressedFootprint) and pressure.field is not None
        body = (model.slider.outline, model.slider.centre_of_mass, model.footprint)
        place = model.slider.hitch if self._has_place else None
        self._ends = _kept_ends(
            body, model.friction, model.pusher, model.accuracy, loop.push, place
        )

    def __call__(self, theta: Array) -> tuple[Array, Array]:
        """Return both (n,) at orientations (n,), rad. Raises what the first cycle that fails ends
        with.
        """
        ends: dict[float, Array | None] = {angle: self._ends.get(angle) for angle in theta.tolist()}
        new = np.array([angle for angle, end in ends.items() if end is None])
        if new.size:
            # Pushed from the origin, by orientation alone: x, y and theta at the end, then their
            # slopes.
            poses, varied = np.outer(new, (0.0, 0.0, 1.0)), np.zeros((new.size, 3, 1))
            varied[:, 2] = 1.0
            if self._has_place:
                (c, s), before = _turned(new, self._lever)
                poses[:, :2] = -before / self._unit
                varied = _start_varies(c, s, before, self._unit, 1)
            ran = engine.run([self._push], np.zeros(new.size, int), poses, varied)
            _check(ran, [self._push], new)
            slopes = OUTPUT.columns_of(ran.derivatives).pushed[..., 0]
            fresh = dict(zip(new.tolist(), np.hstack([ran.pushed, slopes]), strict=True))
            if len(self._ends) > _MOST_KEPT:
                self._ends.clear()
            self._ends.update(fresh)
            ends.update(fresh)
        kept = np.array([ends[angle] for angle in theta.tolist()])
        pose, slopes = kept[:, :3], kept[:, 3:]
        if not self._has_place:
            (c, s), ring = _turned(theta, self._lever)
            pose[:, :2] += -ring / self._unit
            slopes[:, :2] += _start_varies(c, s, ring, self._unit, 1)[:, :2, 0]
        ran = engine.run([self._drag], np.zeros(theta.size, int), pose, slopes[..., None])
        _check(ran, [self._drag], theta)
        ended = OUTPUT.columns_of(ran.derivatives).ended
        return ran.ended[:, 2], ended[:, 2, 0]


@lru_cache(maxsize=128)
def _kept_ends(*given: Hashable) -> dict[float, Array]:
    """By orientation, what pushes from the origin come to, as far as it is known yet.

    `given`: all that they depend on.
    """
    return {}


def _turned(theta: Array, lever: Array) -> tuple[tuple[Array, Array], Array]:
    """Cosines and sines of orientations (n,), and levers (n, 2) in the world's axes; as `Pose`
    rounds them.
    """
    c, s = (np.array([of(angle) for angle in theta.tolist()]) for of in (math.cos, math.sin))
    x, y = lever.T
    return (c, s), np.column_stack([c * x - s * y, s * x + c * y])


def _check(
    ran: Ran, strokes: Sequence[Strokes], theta: Array, owner: NDArray[np.intp] | None = None
) -> None:
    """Raise what the first task that failed ended with, telling its orientation and, of several,
    its loop.
    """
    failed = np.flatnonzero(ran.status <= 0)
    if failed.size:
        index = int(failed[0])
        loop = 0 if owner is None else int(owner[index])
        error = refusal(int(ran.status[index]), strokes[loop])
        which = f"loop {loop} from " if len(strokes) > 1 else ""
        raise type(error)(f"{which}theta = {float(theta[index])!r} rad: {error}")


def derivative_units(model: QuasiStaticModel, names: Sequence[str]) -> Array:
    """Return factors (k,) from derivatives by the engine's `names` to those by SI, and by shapes in
    mean pressures; nan for shares and shapes that there cannot be.
    """
    factors = dict.fromkeys(names, 1.0) | dict.fromkeys(_LENGTHS, 1.0 / model.unit)
    factors |= dict.fromkeys(_FRICTION, 1.0 / model.scale)
    if any(part.share in factors for part in PARTS):
        rows = np.diff(pressure_tables(model.pressure).record["first_row"])
        for part, count in zip(PARTS, rows.tolist(), strict=True):
            if part.share is not None and count == 0:
                factors[part.share] = math.nan
    pressure = model.pressure
    bend = pressure.bend_unit if isinstance(pressure, PressedFootprint) else math.nan
    factors |= dict.fromkeys(SHAPES, bend)
    return np.array([factors[name] for name in names])
