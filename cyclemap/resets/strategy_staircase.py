"""The staircase that a collection climbs with a strategy: one noisy run of it, and the dwells found in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from cyclemap.checks import positive_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_CYCLES, DEFAULT_SIGMA
from cyclemap.errors import InvalidInput
from cyclemap.maps import Staircase, Steps, WrappedNormal, find_steps
from cyclemap.resets.strategies.strategy import DEFAULT_NODES, ResetStrategy
from cyclemap.resets.strategies.strategy_maps import StrategyMaps, strategy_maps
from cyclemap.resets.strategies.strategy_run import run_strategy
from cyclemap.resets.strategies.strategy_sampling import Interpolated, sample_strategy

# Radians: accuracy of the maps that a run is sampled from, far below the noise of a cycle.
SAMPLED_TOLERANCE = 1e-4
# Laws with more actions than this are run by the mechanics instead, cycle by cycle.
MOST_MAPS = 256
# Computing a map takes as long as running so many cycles.
_CYCLES_A_MAP = 100
_FEWER_NODES = (DEFAULT_NODES, 24, 16, 12, 8)


@dataclass(frozen=True, eq=False)
class StrategyStaircase:
    """One run of a collection with a strategy.

    loop : prepared by the strategy. noise : added to every cycle. run : the path. steps : the dwells and steps found
    in it. maps : the cycle maps that it was sampled from; None where the full mechanics ran it.
    """

    loop: CollectionLoop
    strategy: ResetStrategy
    noise: WrappedNormal
    run: Staircase
    steps: Steps
    maps: StrategyMaps | None


def strategy_staircase(
    loop: CollectionLoop,
    strategy: ResetStrategy,
    *,
    sigma: float = DEFAULT_SIGMA,
    cycles: int = DEFAULT_CYCLES,
    start: float = 0.0,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> StrategyStaircase:
    """Run `cycles` cycles of the strategy, whose schedule is that of `seed`, and find the dwells of the path.

    sigma : standard deviation (rad) of the noise of one cycle. start : rad. progress : called with the fraction done.

    The run is sampled from the cycle maps of the strategy's law, or made by the full mechanics (4 to 10 ms a cycle)
    where that is quicker, or where the surface wears, which the maps leave out.

    >>> from cyclemap.resets.strategies.drag_strategies import GripperTurn
    >>> found = strategy_staircase(CollectionLoop.mit(), GripperTurn(), cycles=20)
    >>> found.run.cycles, found.steps.count
    (20, 0)
    """
    noise, report = WrappedNormal(positive_number("sigma", sigma)), progress or (lambda fraction: None)
    if samples_from_maps(loop, strategy, cycles):
        nodes = law_nodes(strategy)
        maps = strategy_maps(loop, strategy, nodes=nodes, tolerance=SAMPLED_TOLERANCE, progress=report)
        run = sample_strategy(maps, cycles, start=start, noise=noise, seed=seed)
        return StrategyStaircase(maps.loop, strategy, noise, run, find_steps(run.theta), maps)
    ran = run_strategy(loop, strategy, cycles, start=start, noise=noise, seed=seed, progress=report)
    run = Staircase(ran.theta, seed, float(ran.theta[0]))
    return StrategyStaircase(strategy.prepared(loop), strategy, noise, run, find_steps(run.theta), None)


def samples_from_maps(loop: CollectionLoop, strategy: ResetStrategy, cycles: int) -> bool:
    """Whether a run of so many cycles is sampled from the strategy's cycle maps."""
    if loop.material.wear is not None or not isinstance(strategy, Interpolated):
        return False
    try:
        return _CYCLES_A_MAP * len(strategy.law(law_nodes(strategy)).actions) <= cycles
    except InvalidInput:
        return False


def law_nodes(strategy: ResetStrategy, most: int = MOST_MAPS) -> int:
    """Return how many nodes of a full turn give a law of at most `most` actions, as many as usual if possible.

    Raises InvalidInput where even 8 nodes give more.

    >>> from cyclemap.resets.strategies.drag_strategies import TrailingLeg
    >>> law_nodes(TrailingLeg(0.05)), law_nodes(TrailingLeg(0.05), most=20)
    (32, 16)
    """
    sizes = []
    for nodes in _FEWER_NODES:
        try:
            sizes.append(len(strategy.law(nodes).actions))
        except InvalidInput:
            continue
        if sizes[-1] <= most:
            return nodes
    told = f"{min(sizes)} actions" if sizes else "too many actions"
    raise InvalidInput(
        f"the strategy ({strategy.name}) draws so much that its law has {told}, more than {most} cycle maps: use "
        "cyclemap staircase or simulate, which run it cycle by cycle, or draw fewer numbers"
    )
