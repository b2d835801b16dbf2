"""Long collections with a strategy, sampled from its maps: a hundred thousand pushes in seconds."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import finite_number, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps import Noise, Staircase
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.shared_strokes import run_action
from cyclemap.resets.strategies.strategy import DEFAULT_NODES, Seed
from cyclemap.resets.strategies.strategy_maps import StrategyMaps
from cyclemap.resets.strategies.strategy_run import noise_of_run

Array = NDArray[np.float64]
Scalar = Callable[[float], float]

_CHUNK = 4096  # cycles whose weights are held at a time


@runtime_checkable
class Interpolated(Protocol):
    """A strategy whose actions lie between those of its law: every `DrawnStrategy`, and combinations of them."""

    def draws(self, cycles: int, seed: Seed = 0) -> Array:
        """Return what a run draws, (cycles, dimensions)."""

    def interpolation(self, shares: Array, nodes: int = DEFAULT_NODES) -> Array:
        """Return the weights (n, k) of the law's actions in the interpolant at drawn points (n, dimensions)."""

    def actions(self, cycles: int, seed: Seed = 0) -> tuple[CycleAction, ...]:
        """Return the actions of the run."""


def sample_strategy(
    maps: StrategyMaps, cycles: int, *, start: float = 0.0, noise: Noise | None = None, seed: int = 0
) -> Staircase:
    """Return the orientations (rad, not wrapped) of a run, each cycle by the map of its own action, interpolated.

    The same schedule and noise as `run_strategy` with this seed, so that both paths agree until the errors of the maps
    and of the interpolation between them (`interpolation_error`) have grown. start : rad. Some 2 us a cycle and node.

    Raises InvalidInput where the strategy is not one that can be interpolated, or a value is bad. Wear is left out.

    >>> from cyclemap.collection.loop import CollectionLoop
    >>> from cyclemap.resets.strategies.drag_strategies import GripperTurn
    >>> from cyclemap.resets.strategies.strategy_maps import strategy_maps
    >>> maps = strategy_maps(CollectionLoop.mit(), GripperTurn(), tolerance=1e-2)
    >>> sample_strategy(maps, 1000, seed=1).cycles
    1000
    """
    strategy, count = _interpolated(maps), whole_number("cycles", cycles, least=1)
    number = whole_number("seed", seed, least=0)
    lift = noise_of_run(noise, count, number) + _gripper_turns(maps, strategy, count, number)
    path = np.empty(count + 1)
    path[0] = finite_number("start", start)
    shares = strategy.draws(count, number)
    for at in range(0, count, _CHUNK):
        chosen, scalars = _rows(maps, strategy.interpolation(shares[at : at + _CHUNK], maps.nodes))
        theta = float(path[at])
        for n, (columns, weights) in enumerate(chosen, at):
            theta = sum(w * scalars[k](theta) for k, w in zip(columns, weights, strict=True)) + float(lift[n])
            path[n + 1] = theta
    return Staircase(read_only(path), number, float(path[0]))


def interpolation_error(maps: StrategyMaps, samples: int = 30, seed: int = 0) -> float:
    """Return the largest error (rad) of the interpolated maps at `samples` drawn actions and orientations.

    Against the full mechanics: that of the maps themselves is in it. A measure of what more nodes would mend.
    """
    strategy, count = _interpolated(maps), whole_number("samples", samples, least=1)
    number = whole_number("seed", seed, least=0)
    thetas = np.random.default_rng(np.random.SeedSequence(number, spawn_key=(1,))).uniform(0.0, 2.0 * np.pi, count)
    chosen, scalars = _rows(maps, strategy.interpolation(strategy.draws(count, number), maps.nodes))
    worst = 0.0
    for action, theta, (columns, weights) in zip(strategy.actions(count, number), thetas.tolist(), chosen, strict=True):
        found = sum(w * scalars[k](theta) for k, w in zip(columns, weights, strict=True))
        worst = max(worst, abs(found - run_action(maps.loop, action, theta)[1].end.theta))
    return worst


def _interpolated(maps: StrategyMaps) -> Interpolated:
    if not isinstance(maps.strategy, Interpolated):
        raise InvalidInput(
            f"{maps.strategy.name} does not say what it draws: derive it from DrawnStrategy, or use run_strategy"
        )
    return maps.strategy


def _gripper_turns(maps: StrategyMaps, strategy: Interpolated, count: int, seed: int) -> Array:
    if not any(action.turn for action in maps.law.actions):
        return np.zeros(count)
    return np.array([action.turn for action in strategy.actions(count, seed)])


def _rows(maps: StrategyMaps, weights: Array) -> tuple[Iterator[tuple[list[int], list[float]]], list[Scalar]]:
    """For each cycle the numbers of the maps that count and their weights; and the maps, each once, as scalars."""
    distinct = list(dict.fromkeys(maps.without_turn))
    place = {one: k for k, one in enumerate(distinct)}
    together = np.zeros((len(maps.law.actions), len(distinct)))
    together[np.arange(len(together)), [place[one] for one in maps.without_turn]] = 1.0
    merged = weights @ together
    rows = ((np.flatnonzero(row).tolist(), row[row != 0.0].tolist()) for row in merged)
    return rows, [one.scalar() for one in distinct]
