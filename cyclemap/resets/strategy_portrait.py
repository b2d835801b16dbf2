"""The portrait of a collection whose cycles differ: the map of each action, the law of the orientations, one run."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import positive_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_CYCLES, DEFAULT_SIGMA, TurnStatistics, turn_statistics
from cyclemap.maps import Staircase, WrappedNormal
from cyclemap.maps.arcs import TWO_PI
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.operator.spectrum import mixing_time
from cyclemap.resets.scores.strategy_scores import StrategyScores, strategy_scores
from cyclemap.resets.strategies.schedules import INDEPENDENT
from cyclemap.resets.strategies.strategy import ResetStrategy
from cyclemap.resets.strategies.strategy_maps import StrategyMaps, strategy_maps
from cyclemap.resets.strategies.strategy_sampling import interpolation_error, sample_strategy
from cyclemap.resets.strategy_staircase import law_nodes

Array = NDArray[np.float64]

# Radians: what it takes for the law of the orientations to be certified.
PORTRAIT_TOLERANCE = 1e-5
PUSHES = 50
# Runs from which the mean turn of a schedule is measured, and their length.
_RUNS, _RUN_CYCLES = 10, 400
_MAPS_SHARE = 0.7
# Drawn actions that the interpolation between maps is tried at.
TRIED_BETWEEN = 30
# Actions looked at for one that is not among those of the law.
_TRIED = 16


@dataclass(frozen=True, eq=False)
class StrategyPortrait:
    """What a collection with a strategy does, cycle after cycle.

    maps : the cycle map of each action of the law, with its weight. turns : the statistics of each map's turn, a
    gripper's included. noise : added to every cycle. scores : of the law of the orientations: its distance from
    uniform, its spectral gap, how fast a start is forgotten. mean_turn : turns a cycle, in the long run; its bound
    is proved where `mean_turn_certified`, and else twice the standard error of simulated runs.
    interpolation : the largest error (rad) found where an action lies between those of the law; 0 where none does.
    staircase : one noisy run.
    """

    maps: StrategyMaps
    turns: tuple[TurnStatistics, ...]
    noise: WrappedNormal
    scores: StrategyScores
    mean_turn: Estimate
    interpolation: float
    staircase: Staircase

    @property
    def mean_turn_certified(self) -> bool:
        """Whether the bound of the mean turn is proved."""
        return self.scores.independent is not None

    @property
    def law_certified(self) -> bool:
        """Whether the distance from uniform is known to 0.005 within bounds: only where cycles are independent.

        Of the law of the actions in `maps.law`: where `interpolation` is not 0, they stand for those between them.
        """
        return self.scores.independent is not None and self.scores.evenness.certified

    @property
    def highest_peaks(self) -> tuple[float, ...]:
        """The peaks (rad) at which the law is above uniform by more than its error, the highest first."""
        peaks = np.asarray(self.scores.peaks, dtype=float)
        above = self.scores.law.density(peaks) - 1.0 / TWO_PI
        bound = self.scores.law.error_bound
        order = np.argsort(-above)
        return tuple(peaks[order][above[order] > (bound if math.isfinite(bound) else 0.0)].tolist())

    @property
    def memory_cycles(self) -> Estimate | None:
        """-1/ln|λ₂|: cycles in which the slowest departure from the law falls by e; None where there is no gap."""
        gap = self.scores.spectral_gap
        return None if gap is None else mixing_time(Estimate(1.0 - gap, gap.error_bound))


def strategy_portrait(
    loop: CollectionLoop,
    strategy: ResetStrategy,
    *,
    sigma: float = DEFAULT_SIGMA,
    cycles: int = DEFAULT_CYCLES,
    start: float = 0.0,
    seed: int = 0,
    tolerance: float = PORTRAIT_TOLERANCE,
    progress: Callable[[float], None] | None = None,
) -> StrategyPortrait:
    """Compute the portrait of a collection with `strategy` on `loop`.

    sigma : standard deviation (rad) of the noise of one cycle. cycles, start (rad), seed : of the run; its schedule is
    that of `seed`. tolerance : of the cycle maps (rad). progress : called with the fraction done.

    Raises InvalidInput for values that make no sense, or a law of too many actions (see `law_nodes`).

    >>> from cyclemap.resets.strategies.drag_strategies import GripperTurn
    >>> found = strategy_portrait(CollectionLoop.mit(), GripperTurn(), cycles=50, tolerance=1e-2)
    >>> len(found.maps.maps), found.maps.computed, round(float(found.scores.total_variation), 9)
    (32, 1, 0.0)
    """
    noise, report = WrappedNormal(positive_number("sigma", sigma)), progress or (lambda fraction: None)
    nodes = law_nodes(strategy)
    maps = strategy_maps(
        loop, strategy, nodes=nodes, tolerance=tolerance, progress=lambda done: report(_MAPS_SHARE * done)
    )
    run = sample_strategy(maps, cycles, start=start, noise=noise, seed=seed)
    scores = strategy_scores(maps, noise, bounded=maps.law.kind == INDEPENDENT, pushes=PUSHES, seed=seed)
    between = not set(strategy.actions(_TRIED, seed)) <= set(maps.law.actions)
    result = StrategyPortrait(
        maps=maps,
        turns=tuple(turn_statistics(one) for one in maps.maps),
        noise=noise,
        scores=scores,
        mean_turn=_mean_turn(maps, noise, scores, seed),
        interpolation=interpolation_error(maps, TRIED_BETWEEN, seed) if between else 0.0,
        staircase=run,
    )
    report(1.0)
    return result


def _mean_turn(maps: StrategyMaps, noise: WrappedNormal, scores: StrategyScores, seed: int) -> Estimate:
    """Turns a cycle in the long run."""
    if scores.independent is not None:
        return scores.independent.operator.rotation_number
    runs = np.array(
        [
            sample_strategy(maps, _RUN_CYCLES, start=TWO_PI * n / _RUNS, noise=noise, seed=seed + n).mean_turn
            for n in range(_RUNS)
        ]
    )
    error = float(runs.std(ddof=1)) / math.sqrt(_RUNS)
    return Estimate(float(runs.mean()) / TWO_PI, 2.0 * error / TWO_PI)
