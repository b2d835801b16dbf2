"""A collection with a strategy, run cycle by cycle by the full mechanics."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import finite_number, read_only, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.wearing_loop import worn_loop
from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.maps import Noise
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.shared_strokes import run_action
from cyclemap.resets.strategies.strategy import ResetStrategy
from cyclemap.resets.strategies.strategy_maps import checked_strategy

Array = NDArray[np.float64]

# The noise's stream of random numbers, beside the schedule's, which is drawn from the seed itself.
_NOISE_STREAM = 1 << 20


@dataclass(frozen=True, eq=False)
class StrategyRun:
    """n cycles of a strategy: theta_{k+1} = theta_k + push_turn_k + drag_turn_k + gripper_turn_k + noise_k.

    theta : (n + 1,), rad, not wrapped, the start first: theta0 of every push, and what the last cycle leaves.
    push_turn, drag_turn, gripper_turn : (n,), rad. drag_length : (n,), m. left : (n,), bool, where the rod lost the
    object before the push's distance was done. actions : what the robot did. seed : of the schedule and the noise.
    """

    theta: Array
    push_turn: Array
    drag_turn: Array
    gripper_turn: Array
    drag_length: Array
    left: NDArray[np.bool_]
    actions: tuple[CycleAction, ...]
    seed: int

    @property
    def cycles(self) -> int:
        """Number of cycles."""
        return len(self.actions)


def run_strategy(
    loop: CollectionLoop,
    strategy: ResetStrategy,
    cycles: int,
    *,
    start: float = 0.0,
    noise: Noise | None = None,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> StrategyRun:
    """Run `cycles` cycles of the strategy on the loop by the full mechanics, 4 to 10 ms each.

    start : orientation before the first push, rad. noise : added after each cycle. The actions are those of
    `strategy.actions(cycles, seed)`, so that a robot can be given the very same. A surface that wears does so.

    Raises InvalidInput for a bad value, and, naming the cycle, what a cycle raises that leads out of the mechanics.

    >>> from cyclemap.resets.strategies.drag_strategies import StraightReset
    >>> loop = CollectionLoop.mit(accuracy=1e-6)
    >>> run = run_strategy(loop, StraightReset(), 2)
    >>> bool(abs(run.theta[1] - loop.cycle(0.0).theta_next) < 1e-12)
    True
    """
    count, seed = whole_number("cycles", cycles, least=1), whole_number("seed", seed, least=0)
    actions = checked_strategy(strategy).actions(count, seed)
    prepared, report = strategy.prepared(loop), progress or (lambda fraction: None)
    kicks = noise_of_run(noise, count, seed).tolist()
    theta, rows = [finite_number("start", start)], []
    for number, action in enumerate(actions):
        today = worn_loop(prepared, number)
        row = _one_cycle(today, action, theta[-1], number)
        rows.append(row)
        theta.append(theta[-1] + row[0] + row[1] + action.turn + kicks[number])
        report((number + 1) / count)
    push_turn, drag_turn, drag_length, left = (read_only(column) for column in np.array(rows).T)
    turns = read_only([action.turn for action in actions])
    return StrategyRun(read_only(theta), push_turn, drag_turn, turns, drag_length, left > 0.0, actions, seed)


def noise_of_run(noise: Noise | None, count: int, seed: int) -> Array:
    """Return the noise (count,), rad, of a run with this seed; zeros where there is none."""
    if noise is None:
        return np.zeros(count)
    if not isinstance(noise, Noise):
        raise InvalidInput(f"noise is {noise!r}: give a law such as WrappedNormal(0.02), or None")
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_NOISE_STREAM,)))
    return np.asarray(noise.sample(rng, count))


def _one_cycle(loop: CollectionLoop, action: CycleAction, theta: float, number: int) -> tuple[float, ...]:
    """Turn of the push and of the drag (rad), length of the drag (m), whether the rod left the object."""
    try:
        push, drag = run_action(loop, action, theta)
    except CycleMapError as error:
        raise type(error)(f"cycle {number}, from theta0 = {math.degrees(theta):.3f} degrees: {error}") from error
    return push.turn, drag.turn, drag.length, float(push.ended == "left")
