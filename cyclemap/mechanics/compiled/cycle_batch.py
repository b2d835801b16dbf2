"""Whole cycles of many loops, each from many orientations, in one call of compiled code; slopes of their maps too."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from cyclemap.errors import CycleMapError
from cyclemap.mechanics.compiled.stroke_library import StrokeKind
from cyclemap.mechanics.compiled.stroke_runner import (
    CYCLE_RESULTS,
    LOOP_COLUMNS,
    StrokeRunner,
    piece_table,
    stroke_runner,
)
from cyclemap.mechanics.contact_curve import RingPiece
from cyclemap.mechanics.pressure_family import rim_share, warp
from cyclemap.mechanics.protocol import DragBack, Pose, SidePush

if TYPE_CHECKING:
    from cyclemap.mechanics.quasi_static import QuasiStaticModel

Array = NDArray[np.float64]

# The target, in every loop's frame.
_TARGET = (0.0, 0.0)


class PushAndReset(Protocol):
    """What is done over and over: a push of a model from the ring's target, and the drag back to it."""

    @property
    def model(self) -> "QuasiStaticModel":
        """The object on its surface, with the rod."""

    @property
    def push(self) -> SidePush:
        """The push."""

    @property
    def reset(self) -> DragBack:
        """The way back."""


@dataclass(frozen=True, eq=False)
class CycleBatch:
    """Cycles in the shape (k, n): k loops, each from n orientations; SI units and radians, as in `Cycles`.

    done : bool, where the compiled code ran them; the rest is nan, and left to Python.
    by_theta : d theta_next / d theta, nan unless it was asked for.
    """

    done: NDArray[np.bool_]
    left: NDArray[np.bool_]
    push_turn: Array
    push_displacement: Array
    drag_turn: Array
    drag_length: Array
    theta_next: Array
    by_theta: Array


def cycle_batch(loops: Sequence[PushAndReset], theta: Array, slopes: bool) -> CycleBatch:
    """Run cycles of k loops from orientations theta (k, n), rad, on all cores.

    Not done are cycles of loops whose parts do not fit, whose kind has no compiled code or not enough to run for one,
    and single cycles that compiled code declines.
    """
    table = np.full((*theta.shape, CYCLE_RESULTS), np.nan)
    table[..., :2] = 0.0
    for kind, members in _by_kind(loops).items():
        numbers = list(members)
        runner = stroke_runner(kind, len(numbers) * theta.shape[1]) if theta.shape[1] else None
        if runner is not None:
            table[numbers] = _run(runner, list(members.values()), theta[numbers], slopes)
    done, left, turn, dx, dy, back, length, following, slope = np.ascontiguousarray(np.moveaxis(table, -1, 0))
    moved = np.stack([dx, dy], axis=-1)
    return CycleBatch(done == 1.0, left == 1.0, turn, moved, back, length, following, slope)


def expect_cycles(model: "QuasiStaticModel", count: int) -> bool:
    """Prepare for `count` cycles: compile what they need if that is worth its while; whether it is there."""
    return model.stroke_kind is not None and stroke_runner(model.stroke_kind, count) is not None


@dataclass(frozen=True, eq=False)
class _PackedLoop:
    """A loop as C reads it: its pieces with its ring behind them (p, columns), way-points with the target (g, 2), and
    the columns of its row that tell neither's place."""

    kind: StrokeKind
    pieces: Array
    goals: tuple[tuple[float, float], ...]
    numbers: tuple[float, ...]


def _by_kind(loops: Sequence[PushAndReset]) -> dict[StrokeKind, dict[int, _PackedLoop]]:
    """The loops that compiled code can run, by their numbers."""
    found: dict[StrokeKind, dict[int, _PackedLoop]] = {}
    for number, loop in enumerate(loops):
        try:
            packed = _packed(loop)
        except CycleMapError:
            # Parts that do not fit each other: whoever runs its cycles one by one is told.
            continue
        if packed is not None:
            found.setdefault(packed.kind, {})[number] = packed
    return found


def _packed(loop: PushAndReset) -> _PackedLoop | None:
    """The loop as C reads it; None where only Python can run it."""
    model, law = loop.model, loop.model.friction
    kind, unit = model.stroke_kind, model.unit
    if kind is None or not model.one_spin(loop.reset.pin_friction_radius):
        return None
    start, direction, _, length = model.start(Pose(), loop.push)
    hitch = model.slider.hitch
    goals = tuple((x / unit, y / unit) for x, y in (*loop.reset.way_points, _TARGET))
    friction = (law.mu_a, law.mu_b, law.m0, law.n0, law.phi, rim_share(model.pressure), *warp(model.pressure))
    motion = (start.piece, start.coordinate, direction, length)
    accuracy = (unit, model.step_tolerance, loop.reset.pin_friction_radius / unit)
    # The rod's direction is each cycle's own.
    rod = (0.0, model.radius, model.pusher.friction)
    ring = RingPiece((hitch[0] / unit, hitch[1] / unit))
    return _PackedLoop(kind, piece_table((*model.pieces, ring)), goals, (*motion, *accuracy, *rod, *friction))


def _run(runner: StrokeRunner, loops: list[_PackedLoop], theta: Array, slopes: bool) -> Array:
    """Results (k, n, CYCLE_RESULTS) of loops of one kind."""
    rows, piece, goal = np.empty((len(loops), LOOP_COLUMNS)), 0, 0
    for row, loop in zip(rows, loops, strict=True):
        row[:] = (piece, len(loop.pieces) - 1, goal, len(loop.goals), *loop.numbers)
        piece, goal = piece + len(loop.pieces), goal + len(loop.goals)
    pieces = np.concatenate([loop.pieces for loop in loops])
    goals = np.array([point for loop in loops for point in loop.goals])
    number = np.repeat(np.arange(float(len(loops))), theta.shape[1])
    cycles = np.stack([number, theta.ravel()], axis=-1)
    return runner.run_cycles(rows, pieces, goals, cycles, slopes).reshape(*theta.shape, -1)
