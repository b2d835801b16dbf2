"""The operators of a strategy's cycles: of the mixture that it draws from, and of its actions one by one."""

from __future__ import annotations

from typing import Any

import numpy as np

from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, Noise, UniformNoise, transfer_operator
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.independent_sum import IndependentSum
from cyclemap.maps.mixtures.law_evolution import CycleOperator
from cyclemap.maps.mixtures.mixture_operator import mixture_operator
from cyclemap.maps.operator.fourier_discretisation import needed_modes
from cyclemap.resets.strategies.combined import Combined
from cyclemap.resets.strategies.drag_strategies import GripperTurn
from cyclemap.resets.strategies.spread import Spread
from cyclemap.resets.strategies.strategy_maps import StrategyMaps

QUICK_MODES, FINER_MODES = 64, 192
_LAST, _SMALL = 4, 1e-4


def kept_modes(noise: Noise, modes: int | None, bounded: bool, finer: bool = False) -> int | None:
    """How many Fourier modes to keep: ``modes``; else None, all, where ``bounded``; else 64, or three times as many.

    >>> from cyclemap.maps import WrappedNormal
    >>> kept_modes(WrappedNormal(0.05), None, False), kept_modes(WrappedNormal(0.5), None, False)
    (64, 19)
    """
    if modes is not None or bounded:
        return modes
    return min(FINER_MODES if finer else QUICK_MODES, needed_modes(noise))


def is_quickly_resolved(law: FourierLaw) -> bool:
    """Whether the last modes kept are small enough for a quick look: below 1e-4."""
    return bool(np.max(np.abs(law.moments[-_LAST:])) < _SMALL)


def independent_operator(maps: StrategyMaps, noise: Noise, modes: int | None = None) -> CycleOperator:
    """The operator of a cycle whose action is drawn anew each time: the mean over the law.

    A gripper's turn that is drawn from an interval is an independent noise, uniform on it, and is taken as such, not
    as the law's few nodes; actions that then have the same map are one.
    """
    drawn, fixed = _gripper_turn(maps)
    if drawn:
        noise = IndependentSum((noise, *(UniformNoise(0.5 * (turn.high - turn.low)) for turn in drawn)))
    merged: dict[CircleMap, float] = {}
    for one, weight in zip(maps.without_turn if drawn else maps.maps, maps.weights.tolist(), strict=True):
        merged[one] = merged.get(one, 0.0) + weight
    parts = tuple(_raised(one, fixed) for one in merged)
    if len(parts) == 1:
        return transfer_operator(parts[0], noise, modes=modes)
    return mixture_operator(parts, list(merged.values()), noise, modes)


def action_operators(maps: StrategyMaps, noise: Noise, modes: int | None = None) -> tuple[CycleOperator, ...]:
    """The operator of each action of the law, in its order."""
    return tuple(transfer_operator(one, noise, modes=modes) for one in maps.maps)


def _gripper_turn(maps: StrategyMaps) -> tuple[list[Spread], float]:
    """The intervals that gripper turns are drawn from, and the sum of the fixed turns and of their middles (rad)."""
    strategy: Any = maps.strategy
    parts = strategy.parts if isinstance(strategy, Combined) else (strategy,)
    turns = [part.turn for part in parts if type(part) is GripperTurn and part.schedule.sectors is None]
    drawn = [turn for turn in turns if isinstance(turn, Spread)]
    others = [part for part in parts if type(part) is not GripperTurn or part.schedule.sectors is not None]
    if not drawn or any(action.turn for part in others for action in part.law(1).actions):
        return [], 0.0
    return drawn, sum(0.5 * (turn.low + turn.high) if isinstance(turn, Spread) else turn for turn in turns)


def _raised(one: CircleMap, turn: float) -> CircleMap:
    """The map followed by a fixed turn (rad)."""
    if turn == 0.0:
        return one
    if one.pieces is None:
        raise InvalidInput("the map of an action is not made of samples: make the maps with strategy_maps")
    return CircleMap.from_pieces(one.pieces.shifted(0.0, turn), one.breaks, one.samples, one.max_error)
