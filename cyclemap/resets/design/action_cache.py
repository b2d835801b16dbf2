"""Cycle maps and costs of actions, each computed once for all strategies of one loop that use it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cyclemap.checks import positive_number, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, Noise, UniformNoise
from cyclemap.maps.arcs import TWO_PI
from cyclemap.maps.mixtures.independent_sum import IndependentSum
from cyclemap.mechanics import SidePush
from cyclemap.resets.design.reset_numbers import ResetKernel, ResetNumbers
from cyclemap.resets.design.schedule_numbers import schedule_numbers
from cyclemap.resets.scores.simulated_coverage import Sampler, chain_sampler, schedule_sampler
from cyclemap.resets.scores.strategy_sampler import strategy_sampler
from cyclemap.resets.strategies.action_cost import CycleCost, Pace, StrategyCost, action_cost
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.drag_strategies import GripperTurn
from cyclemap.resets.strategies.schedules import INDEPENDENT
from cyclemap.resets.strategies.spread import Spread
from cyclemap.resets.strategies.strategy import PERIODIC, ActionLaw, DrawnStrategy, ResetStrategy
from cyclemap.resets.strategies.strategy_maps import StrategyMaps, strategy_maps

# Radians: enough to compare strategies by; certified bounds ask for finer maps (see `finer`).
MAP_TOLERANCE = 1e-3
_COST_ACCURACY = 1e-6


@dataclass
class ActionCache:
    """What is known of the actions on `loop`, with `noise` in every cycle; it grows as strategies are asked about.

    tolerance : of the maps, rad. orientations : even start orientations of the costs. pace : of the robot.

    >>> from cyclemap.maps import WrappedNormal
    >>> from cyclemap.resets.strategies.drag_strategies import StraightReset
    >>> cache = ActionCache(CollectionLoop.mit(), WrappedNormal(0.02), tolerance=1e-3)
    >>> cache.kernel(StraightReset()).numbers(within=5, near=0.1).tv > 0.9, cache.computed
    (True, 1)
    >>> cache.kernel(GripperTurn()).numbers(within=5, near=0.1).reach, cache.computed
    (1.0, 1)
    """

    loop: CollectionLoop
    noise: Noise
    tolerance: float = MAP_TOLERANCE
    orientations: int = 12
    pace: Pace | None = None
    _maps: dict[tuple[CollectionLoop, CycleAction], CircleMap] = field(default_factory=dict, repr=False)
    _costs: dict[tuple[CollectionLoop, CycleAction], CycleCosts] = field(default_factory=dict, repr=False)
    _contacts: dict[SidePush, float] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        if not isinstance(self.noise, Noise) or isinstance(self.noise, UniformNoise):
            raise InvalidInput(
                f"the noise of a cycle is {self.noise!r}: give a smooth law, such as WrappedNormal(0.02)"
            )
        positive_number("tolerance", self.tolerance)
        whole_number("orientations", self.orientations, least=1)

    @property
    def computed(self) -> int:
        """How many actions have a map."""
        return len(self._maps)

    def finer(self, tolerance: float) -> ActionCache:
        """Return an empty cache for finer maps of the same loop, which knows the costs."""
        return ActionCache(
            self.loop, self.noise, tolerance, self.orientations, self.pace, _costs=self._costs, _contacts=self._contacts
        )

    def put(self, prepared: CollectionLoop, action: CycleAction, made: CircleMap) -> None:
        """Keep a map that was computed elsewhere, for a loop as a strategy prepares it."""
        self._maps[prepared, action.filled(prepared)] = made

    def kernel(self, strategy: ResetStrategy, nodes: int = 12) -> ResetKernel:
        """Return what the strategy does to the orientation; maps that are missing are computed.

        nodes : of the law, for a full turn. A gripper that turns by an angle drawn evenly about none is noise: its law
        is taken exactly. Raises InvalidInput for a strategy without a kernel, and what a cycle raises.
        """
        drawn = even_turn(strategy)
        if drawn is not None:
            maps = self._of(strategy.prepared(self.loop), (CycleAction(),))
            return ResetKernel(maps, np.ones(1), INDEPENDENT, IndependentSum((self.noise, drawn)))
        law = strategy.law(nodes)
        maps = self._of(strategy.prepared(self.loop), law.actions)
        return ResetKernel(maps, law.weights, law.kind, self.noise)

    def maps(self, strategy: ResetStrategy, nodes: int = 12) -> StrategyMaps:
        """Return the maps of the strategy's law, as `strategy_maps` does, but for the lengths of its drags."""
        law, prepared = strategy.law(nodes), strategy.prepared(self.loop)
        still = tuple(replace(action, turn=0.0) for action in law.actions)
        found = self._of(prepared, law.actions), self._of(prepared, still)
        return StrategyMaps(strategy, nodes, prepared, law, *found, self.computed, ())

    def numbers(
        self, strategy: ResetStrategy, nodes: int, within: int, near: float, bounded: bool = False
    ) -> ResetNumbers:
        """Return the scores, whatever the schedule; only those of strategies with a kernel can have bounds."""
        if has_kernel(strategy):
            return self.kernel(strategy, nodes).numbers(within, near, bounded)
        return schedule_numbers(self.maps(strategy, nodes), self.noise, within, near)

    def sampler(self, strategy: ResetStrategy, nodes: int, start: float) -> Sampler:
        """Return a sampler of runs from orientation `start` (rad), by the strategy's maps."""
        if not has_kernel(strategy):
            return strategy_sampler(self.maps(strategy, nodes), self.noise, start)
        kernel = self.kernel(strategy, nodes)
        return (
            schedule_sampler(kernel.schedule(), start) if kernel.alternates else chain_sampler(kernel.operator(), start)
        )

    def contact(self, push: SidePush) -> float:
        """Return the shortest way (m) that the rod goes in contact in this push, over the orientations."""
        if push not in self._contacts:
            poses = map(self.loop.start_pose, self._starts)
            self._contacts[push] = min(self.loop.model.push(pose, push).travel for pose in poses)
        return self._contacts[push]

    def shortest_contact(self, strategy: ResetStrategy, nodes: int = 12) -> float:
        """Return the shortest `contact` (m) of all pushes of the strategy."""
        usual = strategy.prepared(self.loop).push
        return min(self.contact(push) for push in {action.push or usual for action in strategy.law(nodes).actions})

    def cost(self, strategy: ResetStrategy, nodes: int = 12) -> StrategyCost:
        """Return the cost of the strategy, as `strategy_cost` does, each action's cycles run once."""
        law, prepared = strategy.law(nodes), strategy.prepared(self.loop)
        if even_turn(strategy) is not None:
            law = ActionLaw(law.actions[:1], np.ones(1))
        found = [self._cost(prepared, action) for action in law.actions]
        mean = law.weights @ np.array([(one.drag_length, one.seconds) for one in found])
        return StrategyCost(
            float(mean[0]),
            max(one.longest_drag for one in found),
            float(mean[1]),
            max(one.rod_reach for one in found),
            max(one.object_reach for one in found),
        )

    @property
    def _starts(self) -> list[float]:
        """The even start orientations, rad."""
        return [float(start) for start in TWO_PI * np.arange(self.orientations) / self.orientations]

    def _of(self, prepared: CollectionLoop, actions: Sequence[CycleAction]) -> tuple[CircleMap, ...]:
        keys = [action.filled(prepared) for action in actions]
        missing = tuple(key for key in dict.fromkeys(keys) if (prepared, key) not in self._maps)
        if missing:
            made = strategy_maps(prepared, _Listed(missing), tolerance=self.tolerance)
            self._maps.update({(prepared, key): one for key, one in zip(missing, made.maps, strict=True)})
        return tuple(self._maps[prepared, key] for key in keys)

    def _cost(self, prepared: CollectionLoop, action: CycleAction) -> CycleCosts:
        key = prepared, action.filled(prepared)
        if key not in self._costs:
            rough = replace(prepared, accuracy=max(prepared.accuracy, _COST_ACCURACY))
            self._costs[key] = CycleCosts.of([action_cost(rough, key[1], start, self.pace) for start in self._starts])
        return self._costs[key]


@dataclass(frozen=True)
class CycleCosts:
    """Of one action over even orientations: mean drag (m), longest drag (m), mean seconds, largest reaches (m)."""

    drag_length: float
    longest_drag: float
    seconds: float
    rod_reach: float
    object_reach: float

    @classmethod
    def of(cls, cycles: Sequence[CycleCost]) -> CycleCosts:
        """Of the cycles from each of the orientations."""
        count = len(cycles)
        return cls(
            math.fsum(one.drag_length for one in cycles) / count,
            max(one.drag_length for one in cycles),
            math.fsum(one.seconds for one in cycles) / count,
            max(one.rod_reach for one in cycles),
            max(one.object_reach for one in cycles),
        )


def has_kernel(strategy: ResetStrategy) -> bool:
    """Whether its pushes are drawn anew or come in turn; else they know of each other in some other way.

    >>> has_kernel(GripperTurn())
    True
    """
    return strategy.law(1).kind in (INDEPENDENT, PERIODIC)


def even_turn(strategy: ResetStrategy) -> UniformNoise | None:
    """Return the law of the turn of a gripper that draws it independently and evenly about none; else None.

    >>> even_turn(GripperTurn(Spread.within(0.0, 0.5)))
    UniformNoise(halfwidth=0.5)
    """
    if not isinstance(strategy, GripperTurn) or not isinstance(strategy.turn, Spread):
        return None
    spread, drawn = strategy.turn, strategy.schedule.kind == INDEPENDENT and strategy.schedule.sectors is None
    centred = spread.closed or abs(spread.low + spread.high) < 1e-12
    half = min(math.pi, 0.5 * (spread.high - spread.low))
    return UniformNoise(half) if drawn and centred and spread.high - spread.low <= 2.0 * math.pi + 1e-12 else None


@dataclass(frozen=True)
class _Listed(DrawnStrategy):
    """Actions by a list: a law to have maps computed by, no strategy to be run."""

    listed: tuple[CycleAction, ...]

    def law(self, nodes: int = 0) -> ActionLaw:
        """The actions, alike in weight."""
        return ActionLaw(self.listed, np.full(len(self.listed), 1.0 / len(self.listed)))
