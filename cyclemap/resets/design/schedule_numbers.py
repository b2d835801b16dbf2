"""The few scores that a reset is ranked by, for pushes that know of each other: in blocks, or by a fixed sequence."""

from __future__ import annotations

import math

from cyclemap.maps import Noise
from cyclemap.maps.estimate import Estimate
from cyclemap.resets.design.reset_numbers import ResetNumbers
from cyclemap.resets.scores.strategy_scores import strategy_scores
from cyclemap.resets.strategies.strategy_maps import StrategyMaps


def schedule_numbers(maps: StrategyMaps, noise: Noise, within: int, near: float) -> ResetNumbers:
    """Return the scores of a strategy of any schedule, without bounds; `near` : total variation that counts as reached.

    The law is the share of pushes in a long run; laws after n pushes are over noise and the schedule's own chance.
    Raises InvalidInput for a strategy that does not say what it draws, ConvergenceError for one that hardly mixes.

    >>> from cyclemap.collection.loop import CollectionLoop
    >>> from cyclemap.maps import WrappedNormal
    >>> from cyclemap.resets.strategies.drag_strategies import GripperTurn
    >>> from cyclemap.resets.strategies.strategy_maps import strategy_maps
    >>> maps = strategy_maps(CollectionLoop.mit(), GripperTurn(), tolerance=1e-2)
    >>> schedule_numbers(maps, WrappedNormal(0.3), within=5, near=0.1).reach
    1.0
    """
    scores = strategy_scores(maps, noise, pushes=within)
    reach = float(scores.within(near).cycles) if near < 1.0 else 1.0
    return ResetNumbers(
        law=scores.law,
        tv=Estimate(float(scores.total_variation), math.inf),
        tv_after=Estimate(float(scores.curve.total_variation[-1]), math.inf),
        reach=reach if reach <= within else math.inf,
        effective_per_100=float(scores.effective_size_per_100),
        within=within,
        near=near,
        bounded=False,
    )
