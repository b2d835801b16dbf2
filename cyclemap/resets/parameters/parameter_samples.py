"""Cycles on an even grid of orientations, with their derivatives by everything that an action is made of."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from cyclemap.checks import read_only, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.mechanics import DragResult, PushResult, SidePush
from cyclemap.mechanics.stroke_variation import turned, unit_rows, vary_drag, vary_push
from cyclemap.resets.parameters.parameter_space import NUMBERS, way_point_names, without_action
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.shared_strokes import run_drag
from cyclemap.resets.strategies.spread import Spread

Rows = dict[str, Array]

# What a push can vary with, besides the orientation: all but the gripper's turn.
_PUSH_NUMBERS = NUMBERS[1:]
_KEPT = 50_000  # pushes and grids that are kept before the memory is emptied


def even_orientations(samples: int) -> Array:
    """Return the orientations (n,), rad, on which cycles are sampled: the middles of equal parts of a turn."""
    return Spread.full_turn().nodes(whole_number("samples", samples, least=8))[0]


@lru_cache(maxsize=16)
def trigonometric_interpolation(samples: int, points: int) -> Array:
    """Return the matrix (points, n) from values on `even_orientations` to those at 2 pi j/points of the interpolant.

    >>> wave = np.cos(3.0 * even_orientations(16))
    >>> bool(abs(trigonometric_interpolation(16, 5)[1] @ wave - np.cos(6.0 * np.pi / 5.0)) < 1e-14)
    True
    """
    return read_only(Spread.full_turn().interpolation(np.arange(points) / points, samples))


@dataclass(frozen=True, eq=False)
class CycleSamples:
    """Cycles of one action from n even orientations, without the gripper's turn.

    turn : (n,), theta_next - theta, rad. length : (n,), of the drag, m. turn_by, length_by : (n, r), their
    derivatives by the numbers of `names`; the first is theta. nan where the mechanics has no derivative.
    """

    names: tuple[str, ...]
    turn: Array
    length: Array
    turn_by: Array
    length_by: Array

    @property
    def interpolation_error(self) -> float:
        """How far (rad) the trigonometric interpolant of the turn may be off, anywhere.

        The largest difference, half-way between samples, from the cubics that use the slopes: two interpolants of
        different kinds, which agree only where the samples resolve the map. A jump leaves a tenth of its height.
        """
        count = self.turn.size
        step, ahead, slope = TWO_PI / count, np.roll(self.turn, -1), self.turn_by[:, 0]
        cubic = 0.5 * (self.turn + ahead) + step / 8.0 * (slope - np.roll(slope, -1))
        middles = trigonometric_interpolation(count, count) @ self.turn
        return float(np.abs(np.roll(middles, -1) - cubic).max())


@dataclass(frozen=True, eq=False)
class _Pushed:
    """A push, and the variations of the orientation (r,) and of the ring's place (2, r) at its end."""

    push: PushResult
    theta: Array
    ring: Array


@dataclass(eq=False)
class CycleSampler:
    """Samples cycles of actions on loops from `samples` even orientations, and keeps what it has done.

    cycles : how many were run.

    A push depends on orientation and ring alone, so that actions which differ in their drags share it.
    """

    samples: int = 64
    cycles: int = 0
    _loops: dict[CollectionLoop, CollectionLoop] = field(default_factory=dict)
    _pushes: dict[tuple[object, ...], _Pushed] = field(default_factory=dict)
    _done: dict[tuple[object, ...], CycleSamples] = field(default_factory=dict)

    def sampled(self, loop: CollectionLoop, action: CycleAction, moving: tuple[str, ...]) -> CycleSamples:
        """Return the samples of a filled action on a prepared loop; `moving`: what to differentiate by.

        `moving` may hold names that this action has not: they are left out.
        """
        assert action.way_points is not None
        plain, standing = without_action(loop), replace(action, turn=0.0)
        key = (plain, standing, moving)
        if key not in self._done:
            self._forget_some()
            ways = way_point_names(len(action.way_points)) if any(name.startswith("way") for name in moving) else ()
            names = ("theta", *(name for name in _PUSH_NUMBERS if name in moving))
            model = self._loops.setdefault(plain, plain)  # the same each time, since it builds its model once
            rows = [self._cycle(model, standing, names, ways, theta) for theta in even_orientations(self.samples)]
            turn, length, turn_by, length_by = (np.array(column) for column in zip(*rows, strict=True))
            self._done[key] = CycleSamples((*names, *ways), turn, length, turn_by, length_by)
        return self._done[key]

    def _forget_some(self) -> None:
        if len(self._pushes) > _KEPT or len(self._done) > _KEPT // self.samples or len(self._loops) > 64:
            for memory in (self._pushes, self._done, self._loops):
                memory.clear()

    def _cycle(
        self, loop: CollectionLoop, action: CycleAction, names: tuple[str, ...], ways: tuple[str, ...], theta: float
    ) -> tuple[float, float, Array, Array]:
        assert action.push is not None
        self.cycles += 1
        before = self._pushed(loop, action.push, names, float(theta))
        drag = run_drag(loop, action, before.push)
        turn_by, length_by = _vary_drag_and_way_points(loop, drag, before, names, len(ways))
        turn_by[0] -= 1.0
        return drag.end.theta - theta, drag.length, turn_by, length_by

    def _pushed(self, loop: CollectionLoop, push: SidePush, names: tuple[str, ...], theta: float) -> _Pushed:
        key = (loop, push, names, theta)
        if key not in self._pushes:
            self._pushes[key] = _new_push(loop, push, names, theta)
        return self._pushes[key]


def _new_push(loop: CollectionLoop, push: SidePush, names: tuple[str, ...], theta: float) -> _Pushed:
    model = loop.model
    made = model.push(loop.start_pose(theta), push)
    one = unit_rows(model, names)
    varied = vary_push(model, made, one)
    hitch, by_hitch = np.array(model.slider.hitch), np.stack([one["hitch_x"], one["hitch_y"]])
    # Before the push the ring is at the target: the object's origin moves as -R(theta) hitch does.
    start = turned(made.start.theta, hitch, one["theta"], by_hitch)
    ring = model.unit * varied[1:3] - start + turned(made.end.theta, hitch, varied[0], by_hitch)
    return _Pushed(made, varied[0], ring)


def _vary_drag_and_way_points(
    loop: CollectionLoop, drag: DragResult, before: _Pushed, names: tuple[str, ...], ways: int
) -> tuple[Array, Array]:
    """Variations of the last orientation and of the drag's length by the names and by the way-points' coordinates.

    Friction does not know where it is, so that a leg whose end moves is one whose start moves the other way.
    """
    width = len(names) + ways
    one = {name: _padded(row, ways) for name, row in unit_rows(loop.model, names).items()}
    theta, start, length = _padded(before.theta, ways), _padded(before.ring, ways), np.zeros(width)
    if ways and len(drag.legs) != ways // 2 + 1:  # the ring already was at a way-point
        theta, by_length = vary_drag(loop.model, drag, theta, start, one)
        theta[len(names) :] = by_length[len(names) :] = np.nan
        return theta, by_length
    for number, leg in enumerate(drag.legs):
        end = np.zeros((2, width))
        if len(names) + 2 * number < width:
            end[:, len(names) + 2 * number : len(names) + 2 * number + 2] = np.eye(2)
        theta, by_length = vary_drag(loop.model, replace(drag, legs=(leg,)), theta, start - end, one)
        length, start = length + by_length, end
    return theta, length


def _padded(rows: Array, count: int) -> Array:
    return np.concatenate([rows, np.zeros((*rows.shape[:-1], count))], axis=-1)
