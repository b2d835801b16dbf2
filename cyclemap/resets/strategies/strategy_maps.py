"""The cycle maps of a strategy: one for each action of its law, with its weight; computed once where they are alike."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import finite_array, positive_number
from cyclemap.collection.adaptive_map import sample_circle_map
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, conjugate
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.shared_strokes import SharedStrokes
from cyclemap.resets.strategies.strategy import DEFAULT_NODES, ActionLaw, ResetStrategy

Array = NDArray[np.float64]

# Radians: accuracy of the maps, unless more is asked for.
DEFAULT_TOLERANCE = 1e-4
_TWO_PI = 2.0 * math.pi
# Metres: way-points that agree this closely are the same.
_SAME_PLACE = 1e-12


@dataclass(frozen=True, eq=False)
class _ComputedMap:
    """A map without the gripper's turn, and the drag's lengths (m) where it was sampled, over one turn."""

    map: CircleMap
    theta: Array
    length: Array

    def turned(self, turn: float) -> CircleMap:
        """The map of the action turned by `turn` (rad) on a surface that this leaves as it is."""
        return self.map if turn == 0.0 else conjugate(self.map, turn)


@dataclass(frozen=True, eq=False)
class StrategyMaps:
    """The cycle maps of a strategy on a loop.

    loop : prepared. law : actions and weights. maps : the lift theta -> theta_next of each action, with the gripper's
    turn, in the law's order. without_turn : the same without it, one object where actions differ in it alone.
    computed : how many maps were computed. strategy, nodes : whose law it is, with how many nodes.
    """

    strategy: ResetStrategy
    nodes: int
    loop: CollectionLoop
    law: ActionLaw
    maps: tuple[CircleMap, ...]
    without_turn: tuple[CircleMap, ...]
    computed: int
    _sources: tuple[tuple[_ComputedMap, float], ...]

    @property
    def weights(self) -> Array:
        """Of each map, (k,); they sum to one."""
        return self.law.weights

    @property
    def max_error(self) -> float:
        """The largest error (rad) that a map claims."""
        return max(one.max_error for one in self.maps)

    def drag_lengths(self, theta: ArrayLike) -> Array:
        """Return the length (m) of each action's drag, (k, ...), at orientations (...).

        Straight between the maps' samples: good to about 0.1 mm.
        """
        at = finite_array("theta", theta)
        return np.array([np.interp(at - turn, one.theta, one.length, period=_TWO_PI) for one, turn in self._sources])

    def mean_drag_length(self, theta: ArrayLike) -> Array:
        """Return the mean over the law of the drag's length (m), (...), at orientations (...)."""
        return np.asarray(np.tensordot(self.weights, self.drag_lengths(theta), axes=1))


def strategy_maps(
    loop: CollectionLoop,
    strategy: ResetStrategy,
    *,
    nodes: int = DEFAULT_NODES,
    tolerance: float = DEFAULT_TOLERANCE,
    progress: Callable[[float], None] | None = None,
) -> StrategyMaps:
    """Return the cycle maps of the strategy's law on the loop, each within `tolerance` (rad) wherever it does not jump.

    nodes : of the law, for a full turn. K equal directions are exact for the harmonics of the bias below K.
    progress : called with the fraction done. A surface that wears is taken as it is when fresh (see `worn_loop`).

    Actions that differ in their drags alone share their pushes. Actions that are the same but for a turn which leaves
    the surface as it is share their map: any turn on an isotropic surface, half a turn on a centred one; the map of a
    turned action is f_a(theta) = a + f(theta - a).

    Raises InvalidInput for a bad strategy or value, and what a cycle raises that leads out of the mechanics.

    >>> from cyclemap.mechanics import EllipseFriction, Material
    >>> from cyclemap.resets.strategies.drag_strategies import TrailingLeg
    >>> even = CollectionLoop.mit(Material("even", EllipseFriction.isotropic(0.25)))
    >>> made = strategy_maps(even, TrailingLeg(0.05), nodes=16, tolerance=1e-2)
    >>> len(made.maps), made.computed
    (16, 1)
    """
    law, prepared = checked_strategy(strategy).law(nodes), strategy.prepared(loop)
    sample_error = min(max(0.1 * positive_number("tolerance", tolerance), 1e-10), 1e-6)
    strokes = SharedStrokes(replace(prepared, accuracy=sample_error))
    keys = [_alike(action.filled(prepared), prepared) for action in law.actions]
    distinct = dict.fromkeys(key for key, _ in keys)
    done: dict[CycleAction, _ComputedMap] = {}
    report = progress or (lambda fraction: None)
    for number, key in enumerate(distinct):
        done[key] = _computed(strokes, key, tolerance, _part(report, number, len(distinct)))
    sources = tuple((done[key], turn) for key, turn in keys)
    placed = {key: done[key[0]].turned(key[1]) for key in keys}
    still = tuple(placed[key] for key in keys)
    maps = tuple(_lifted(one, action.turn) for one, action in zip(still, law.actions, strict=True))
    return StrategyMaps(strategy, nodes, prepared, law, maps, still, len(done), sources)


def _part(report: Callable[[float], None], number: int, count: int) -> Callable[[float], None]:
    """Progress of the number-th of `count` maps, as that of them all."""
    return lambda fraction: report((number + fraction) / count)


def checked_strategy(strategy: ResetStrategy) -> ResetStrategy:
    """Return the strategy, or raise InvalidInput for what is not one."""
    if not isinstance(strategy, ResetStrategy):
        raise InvalidInput(f"{strategy!r} is no reset strategy: it needs name, needs, prepared, actions and law")
    return strategy


def _alike(action: CycleAction, loop: CollectionLoop) -> tuple[CycleAction, float]:
    """The action that stands for all that are alike but for a turn, and the turn (rad) that leads from it to this."""
    friction, direction = loop.material.friction, action.leg_direction
    turn = 0.0
    if friction.m0 == friction.n0 == 0.0 and direction is not None:
        turn = direction if friction.mu_a == friction.mu_b else math.pi * math.floor((direction + 1e-9) / math.pi)
    standing = replace(action.turned(-turn), turn=0.0)
    places = np.round(np.array(standing.way_points) / _SAME_PLACE) * _SAME_PLACE + 0.0
    return replace(standing, way_points=tuple(map(tuple, places.tolist()))), turn


def _computed(
    strokes: SharedStrokes, action: CycleAction, tolerance: float, progress: Callable[[float], None]
) -> _ComputedMap:
    lengths: dict[float, float] = {}

    def sample(theta: float) -> tuple[float, float]:
        end, slope, lengths[theta] = strokes.sample(action, theta)
        return end, slope

    def value(theta: float) -> float:
        return strokes.sample(action, theta)[0]

    made = sample_circle_map(sample, value, 0.9 * tolerance, progress, strokes.loop.accuracy)
    places = np.array(sorted(lengths))
    return _ComputedMap(made, places, np.array([lengths[place] for place in places.tolist()]))


def _lifted(one: CircleMap, up: float) -> CircleMap:
    """The map raised by the gripper's turn `up` (rad)."""
    if up == 0.0:
        return one
    assert one.pieces is not None
    return CircleMap.from_pieces(one.pieces.shifted(0.0, up), one.breaks, one.samples, one.max_error)
