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
from cyclemap.mechanics.engine.schema import PARAMETERS
from cyclemap.mechanics.engine.strokes import Ran, Strokes, pressure_tables
from cyclemap.mechanics.quasi_static import QuasiStaticModel, refusal
from cyclemap.mechanics.slider import DragBack, Pose, SidePush

# What a cycle gives.
CYCLE_OUTPUTS = ("push_turn", "push_dx", "push_dy", "drag_turn", "drag_length", "theta_next")
_HITCH = PARAMETERS.index("hitch_x")
_FRICTION = ("mu_a", "mu_b", "m0", "n0")
# Ends of pushes that are kept of one model: maps take hundreds of samples, those with jumps
# thousands.
_MOST_KEPT = 20_000
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

    push_turn, drag_turn, theta_next (lift), drag_length : (k, n). push_displacement : (k, n, 2).
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

    Raises what the first cycle that fails ends with, telling which loop and orientation.
    """
    strokes = []
    for place, loop in enumerate(loops):
        try:
            strokes.append(loop.model.cycle_strokes(loop.push, loop.reset))
        except CycleMapError as error:
            raise type(error)(f"loop {place}: {error}") from error
    number = np.repeat(np.arange(len(loops)), theta.shape[1])
    unit = np.array([loop.model.unit for loop in loops])[number]
    lever = np.array([loop.model.slider.hitch for loop in loops]).reshape(-1, 2)[number]
    start = theta.ravel()
    (c, s), ring = _turned(start, lever)
    # Before the push the ring is at the origin.
    varied = np.zeros((start.size, 3, derivatives))
    if derivatives:
        varied[:, 0, 0], varied[:, 1, 0], varied[:, 2, 0] = (
            ring[:, 1] / unit,
            -ring[:, 0] / unit,
            1.0,
        )
    if derivatives > _HITCH:
        (
            varied[:, 0, _HITCH],
            varied[:, 0, _HITCH + 1],
            varied[:, 1, _HITCH],
            varied[:, 1, _HITCH + 1],
        ) = -c, s, -s, -c
    ran = engine.run(strokes, number, np.column_stack([-ring / unit[:, None], start]), varied)
    _check(ran, strokes, start, number)
    shift = unit[:, None] * ran.pushed[:, :2] + ring
    moved = np.column_stack([c * shift[:, 0] + s * shift[:, 1], c * shift[:, 1] - s * shift[:, 0]])
    turned, end = ran.pushed[:, 2], ran.ended[:, 2]
    jacobian = np.zeros((theta.size, len(CYCLE_OUTPUTS), derivatives))
    if derivatives:
        scales = np.array(
            [derivative_units(loop.model, PARAMETERS[:derivatives]) for loop in loops]
        )[number]
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
        body = (model.slider.outline, model.slider.centre_of_mass, model.footprint)
        self._ends = _kept_ends(body, model.friction, model.pusher, model.accuracy, loop.push)

    def __call__(self, theta: Array) -> tuple[Array, Array]:
        """Return both (n,) at orientations (n,), rad. Raises what the first cycle that fails ends
        with.
        """
        ends: dict[float, Array | None] = {angle: self._ends.get(angle) for angle in theta.tolist()}
        new = np.array([angle for angle, end in ends.items() if end is None])
        if new.size:
            # Pushed from the origin, by orientation alone: x, y and theta at the end, then their
            # slopes.
            poses = np.outer(new, (0.0, 0.0, 1.0))
            varied = np.broadcast_to(np.array([[0.0], [0.0], [1.0]]), (new.size, 3, 1))
            ran = engine.run([self._push], np.zeros(new.size, int), poses, varied)
            _check(ran, [self._push], new)
            found = dict(
                zip(
                    new.tolist(),
                    np.column_stack([ran.pushed, ran.derivatives[:, :3, 0]]),
                    strict=True,
                )
            )
            if len(self._ends) > _MOST_KEPT:
                self._ends.clear()
            self._ends.update(found)
            ends.update(found)
        pushed = np.array([ends[angle] for angle in theta.tolist()])
        _, ring = _turned(theta, self._lever)
        pushed[:, :2] += -ring / self._unit
        pushed[:, 3] += ring[:, 1] / self._unit
        pushed[:, 4] += -ring[:, 0] / self._unit
        ran = engine.run(
            [self._drag], np.zeros(theta.size, int), pushed[:, :3], pushed[:, 3:, None]
        )
        _check(ran, [self._drag], theta)
        return ran.ended[:, 2], ran.derivatives[:, 5, 0]


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
    return (c, s), np.column_stack(
        [c * lever[:, 0] - s * lever[:, 1], s * lever[:, 0] + c * lever[:, 1]]
    )


def _check(
    ran: Ran, strokes: Sequence[Strokes], theta: Array, number: NDArray[np.intp] | None = None
) -> None:
    """Raise what the first task that failed ended with, telling its orientation and, of several,
    its loop.
    """
    failed = np.flatnonzero(ran.status <= 0)
    if failed.size:
        index = int(failed[0])
        loop = 0 if number is None else int(number[index])
        error, which = (
            refusal(int(ran.status[index]), strokes[loop]),
            f"loop {loop} from " if len(strokes) > 1 else "",
        )
        raise type(error)(f"{which}theta = {float(theta[index])!r} rad: {error}")


def derivative_units(model: QuasiStaticModel, names: Sequence[str]) -> Array:
    """Return factors (k,) from derivatives by the engine's `names` to those by SI; nan for shares
    there cannot be.
    """
    factors = dict.fromkeys(names, 1.0) | dict.fromkeys(_LENGTHS, 1.0 / model.unit)
    factors |= dict.fromkeys(_FRICTION, 1.0 / model.scale)
    rows = np.diff(pressure_tables(model.pressure).record["first_row"])
    for part, count in zip(PARTS, rows.tolist(), strict=True):
        if part.share is not None and count == 0:
            factors[part.share] = math.nan
    return np.array([factors[name] for name in names])
