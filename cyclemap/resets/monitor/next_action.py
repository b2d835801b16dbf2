"""Which action of a strategy to take next, given where the object stands and what has been recorded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.checks import finite_number
from cyclemap.maps.arcs import TWO_PI
from cyclemap.resets.monitor.coverage import Coverage
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.strategy_maps import StrategyMaps


@dataclass(frozen=True)
class NextAction:
    """An action chosen for what the push after it will tell.

    number : of the action in the strategy's law, from 0. action : what the robot does. lands : rad in [0, 2 pi), where
    the map takes the orientation. crowding : of the recorded directions there, as a share of the mean over the circle:
    0 where nothing is near, 1 on evenly covered ground. alternatives : the same for every action of the law.
    """

    number: int
    action: CycleAction
    lands: float
    crowding: float
    alternatives: tuple[float, ...]


def next_action(maps: StrategyMaps, coverage: Coverage, theta: float) -> NextAction:
    """Return the action of the strategy that takes orientation `theta` (rad) to where least is recorded.

    maps : of the strategy's law on the loop as it is believed to be. coverage : of the collection so far, `theta` fed
    to it. The noise of a cycle is left out: it blurs all landings alike.

    Chosen so in every cycle, it is the greedy step of kernel herding towards the uniform law (Chen, Welling & Smola
    2010), among the places that the actions reach; how even that becomes is not bounded. The action then
    depends on the orientation: record it with each push, for data that are even in orientation need not be even in
    action.

    Before anything is recorded every place is alike, and the first action is chosen.

    >>> from cyclemap.collection.loop import CollectionLoop
    >>> from cyclemap.resets.strategies.push_strategies import DrawnPushes, side_pushes
    >>> from cyclemap.resets.strategies.strategy_maps import strategy_maps
    >>> loop = CollectionLoop.mit()
    >>> maps = strategy_maps(loop, DrawnPushes(side_pushes(loop.push, (0, 1))), tolerance=1e-2)
    >>> covered = Coverage()
    >>> for recorded in np.arange(1.5, 3.0, 0.1).tolist() + [1.0]:
    ...     covered.add(recorded)
    >>> chosen = next_action(maps, covered, 1.0)
    >>> chosen.action.push.side, round(chosen.lands, 1)
    (0, 1.0)
    """
    place = finite_number("theta", theta)
    lands = np.array([float(one(place)) for one in maps.maps]) % TWO_PI
    crowding = coverage.crowding(lands)
    best = int(np.argmin(crowding))
    return NextAction(
        best, maps.law.actions[best], float(lands[best]), float(crowding[best]), tuple(float(c) for c in crowding)
    )
