"""The chosen reset run by the full mechanics: do its orientations spread as predicted, within sampling error?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cyclemap.checks import finite_number, whole_number
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.resets.design.action_cache import ActionCache
from cyclemap.resets.design.reset_candidates import ResetCandidate
from cyclemap.resets.scores.coverage_measures import coverage_measures
from cyclemap.resets.strategies.strategy_run import StrategyRun, run_strategy

BINS = 36
_LEVEL = 0.95
# p-value from which on a run disagrees; the runs that are compared must be able to reach it.
_DOUBT, _LEAST_RUNS = 0.01, 250


@dataclass(frozen=True)
class SampledStatistic:
    """One statistic of a run, and of as long runs of the predicted chain from the same start.

    value : of the run. mean : over the predicted runs. low, high : between which 95 % of those lie. p_value : share of
    predicted runs whose value is as large: to be more even than predicted, or nearer to the prediction, is no fault.
    """

    value: float
    mean: float
    low: float
    high: float
    p_value: float

    @property
    def agrees(self) -> bool:
        """Whether the run lies where 95 % of the predicted ones do."""
        return self.low <= self.value <= self.high

    @classmethod
    def of(cls, value: float, predicted: Array) -> SampledStatistic:
        """Set a value against those (runs,) of predicted runs."""
        low, high = np.quantile(predicted, [0.5 * (1.0 - _LEVEL), 0.5 * (1.0 + _LEVEL)])
        above = (1 + int(np.sum(predicted >= value))) / (1 + predicted.size)
        return cls(value, float(np.mean(predicted)), float(low), float(high), above)


@dataclass(frozen=True, eq=False)
class ResetTrial:
    """A run of a strategy by the full mechanics, beside its prediction.

    total_variation : of the histogram of theta0, in `bins` equal bins, from uniform. kuiper : Kuiper's distance from
    uniform. misfit : total variation of the histogram from the predicted law's. run : the cycles. bins, runs : of the
    comparison.
    """

    run: StrategyRun
    total_variation: SampledStatistic
    kuiper: SampledStatistic
    misfit: SampledStatistic
    bins: int
    runs: int

    @property
    def pushes(self) -> int:
        """Length of the run."""
        return self.run.cycles

    @property
    def agrees(self) -> bool:
        """Whether no statistic is so large that one in a hundred predicted runs or fewer has it as large."""
        return min(one.p_value for one in (self.total_variation, self.kuiper, self.misfit)) > _DOUBT


def reset_trial(
    cache: ActionCache,
    candidate: ResetCandidate,
    pushes: int,
    *,
    start: float = 0.0,
    seed: int = 0,
    runs: int = 400,
    progress: Callable[[float], None] | None = None,
) -> ResetTrial:
    """Run the strategy `pushes` times by the full mechanics from `start` (rad) and set it against its maps' chain.

    A surface that wears does so in the run, and is fresh in the prediction. The chain's runs are as long and from the
    same start, so that the histogram's own scatter, which pushes that depend on each other enlarge, is in what is
    expected. runs : of them, at least 250. About 10 ms a push.

    Raises InvalidInput for bad values, and what a cycle raises that leads out of the mechanics.
    """
    count, many = whole_number("pushes", pushes, least=1), whole_number("runs", runs, least=_LEAST_RUNS)
    begin, number = finite_number("start", start), whole_number("seed", seed, least=0)
    run = run_strategy(
        cache.loop, candidate.strategy, count, start=begin, noise=cache.noise, seed=number, progress=progress
    )
    expected = cache.sampler(candidate.strategy, candidate.nodes, begin)(many, count, number + 1)
    law = np.mean(_shares(expected), axis=0)
    found = _statistics(run.theta[None, :-1], law)
    likely = _statistics(expected, law)
    told = [SampledStatistic.of(float(one[0]), others) for one, others in zip(found, likely, strict=True)]
    return ResetTrial(run, told[0], told[1], told[2], BINS, many)


def _statistics(theta: Array, law: Array) -> tuple[Array, Array, Array]:
    """Total variation from uniform, Kuiper's distance from it, total variation from `law`: each (runs,)."""
    shares = _shares(theta)
    even = 0.5 * np.sum(np.abs(shares - 1.0 / BINS), axis=-1)
    apart = 0.5 * np.sum(np.abs(shares - law), axis=-1)
    return even, coverage_measures(theta).kuiper, apart


def _shares(theta: Array) -> Array:
    """(runs, bins): the share of each run's pushes in each bin."""
    place = np.minimum((np.mod(theta, TWO_PI) * (BINS / TWO_PI)).astype(np.int64), BINS - 1)
    flat = place + BINS * np.arange(len(theta))[:, None]
    return np.asarray(np.bincount(flat.ravel(), minlength=BINS * len(theta)).reshape(len(theta), BINS) / theta.shape[1])
