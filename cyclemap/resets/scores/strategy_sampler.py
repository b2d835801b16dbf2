"""Many collections of a strategy at once, sampled from its maps with the strategy's own schedule."""

from __future__ import annotations

from typing import Any

import numpy as np

from cyclemap.checks import finite_number
from cyclemap.errors import InvalidInput
from cyclemap.maps import Noise
from cyclemap.maps.arcs import Array
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.resets.scores.schedule_cells import gripper_turns
from cyclemap.resets.scores.simulated_coverage import Sampler, density_quantiles
from cyclemap.resets.strategies.strategy_maps import StrategyMaps
from cyclemap.resets.strategies.strategy_run import noise_of_run
from cyclemap.resets.strategies.strategy_sampling import Interpolated


def strategy_sampler(maps: StrategyMaps, noise: Noise, start: float | FourierLaw = 0.0) -> Sampler:
    """A sampler of collections whose first push, the schedule's first, is at ``start``, radians, or drawn from a law.

    Every collection is what ``sample_strategy`` gives with the seed ``run_seed(seed, run)`` and the same start.
    Raises InvalidInput for a strategy that does not say what it draws.

    >>> from cyclemap.collection.loop import CollectionLoop
    >>> from cyclemap.maps import WrappedNormal
    >>> from cyclemap.resets.strategies.drag_strategies import StraightReset
    >>> from cyclemap.resets.strategies.strategy_maps import strategy_maps
    >>> maps = strategy_maps(CollectionLoop.mit(), StraightReset(), tolerance=1e-2)
    >>> strategy_sampler(maps, WrappedNormal(0.05))(3, 5, 0).shape
    (3, 5)
    """
    strategy: Any = maps.strategy
    if not isinstance(strategy, Interpolated):
        raise InvalidInput(f"{maps.strategy.name} does not say what it draws: derive it from DrawnStrategy")
    begin = start if isinstance(start, FourierLaw) else finite_number("start", start)
    distinct = tuple(dict.fromkeys(maps.without_turn))
    together = np.eye(len(distinct))[[distinct.index(one) for one in maps.without_turn]]

    def sample(runs: int, pushes: int, seed: int) -> Array:
        rng = np.random.default_rng([seed, 3])
        paths = np.empty((runs, pushes))
        paths[:, 0] = law_starts(begin, runs, rng) if isinstance(begin, FourierLaw) else begin
        if pushes == 1:
            return paths
        seeds = [run_seed(seed, run) for run in range(runs)]
        shares = np.stack([strategy.draws(pushes - 1, own) for own in seeds], axis=1)
        turns = gripper_turns(strategy, shares.reshape(runs * (pushes - 1), shares.shape[2])).reshape(pushes - 1, runs)
        lifts = turns + np.stack([noise_of_run(noise, pushes - 1, own) for own in seeds], axis=1)
        for n in range(pushes - 1):
            rows = strategy.interpolation(shares[n], maps.nodes) @ together
            paths[:, n + 1] = _interpolated(distinct, rows, paths[:, n]) + lifts[n]
        return paths

    return sample


def run_seed(seed: int, run: int) -> int:
    """The seed of one of many collections."""
    return int(np.random.SeedSequence([seed, run]).generate_state(1)[0])


def law_starts(law: FourierLaw, count: int, rng: np.random.Generator) -> Array:
    """Angles (count,) in [0, 2π] of a law, from a table of 8192 cells."""
    return density_quantiles(law.density, rng.uniform(0.0, 1.0, count))


def _interpolated(maps: tuple[Any, ...], rows: Array, theta: Array) -> Array:
    """Σ_k rows_k F_k(θ), each map on the angles that it counts for only."""
    image = np.zeros_like(theta)
    for k, one in enumerate(maps):
        use = np.flatnonzero(rows[:, k])
        if use.size:
            image[use] += rows[use, k] * one(theta[use])
    return image
