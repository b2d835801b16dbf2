"""What comes of a strategy: collections by the full mechanics or from known turns, and how uniform
they are.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import finite_number, non_negative_number, read_only, whole_number
from cyclemap.collection.loop import CollectionLoop, run_cycles
from cyclemap.collection.wearing_loop import worn_loop
from cyclemap.protocol.strategy import ResetStrategy
from cyclemap.resets.monitor.coverage import Crowding

BINS = 36
# The noise's stream of random numbers, beside that of what is drawn, which starts from the seed
# itself.
_NOISE_STREAM = 1 << 20


@dataclass(frozen=True, eq=False)
class StrategyRun:
    """Collections of n cycles each, run by the full mechanics.

    Attributes
    ----------
    theta : ndarray
        (runs, n + 1), rad, not wrapped, the start first.
    action : ndarray
        (runs, n), number of the strategy's action.
    """

    theta: Array
    action: NDArray[np.int64]


def run_strategy(
    loop: CollectionLoop,
    strategy: ResetStrategy,
    cycles: int,
    *,
    runs: int = 1,
    start: float | Array = 0.0,
    sigma: float = 0.0,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> StrategyRun:
    """Run `runs` collections of `cycles` cycles each by the full mechanics, some 0.3 ms a cycle.

    Parameters
    ----------
    start : float or ndarray, optional
        rad, of all runs or one each.
    sigma : float, optional
        Noise of a cycle, rad. The first run does what `strategy.run(cycles, seed)` says, so
        that a robot can be given the very same. A surface that wears does so.

    Returns
    -------
    StrategyRun

    Raises
    ------
    InvalidInput
        For a bad value, and what a cycle raises that leads out of the mechanics.

    Examples
    --------
    >>> loop = CollectionLoop.mit(accuracy=1e-6)
    >>> run = run_strategy(loop, ResetStrategy.pushes(loop.push, (0,)), 2)
    >>> bool(abs(run.theta[0, 1] - loop.cycle(0.0).theta_next) < 1e-9)
    True
    """
    count, many = whole_number("cycles", cycles, least=1), whole_number("runs", runs, least=1)
    chosen = drawn_actions(strategy, count, many, seed)
    kicks = noise_of_runs(non_negative_number("sigma", sigma), count, many, seed)
    turns, report = (
        np.array([action.turn for action in strategy.actions]),
        progress or (lambda fraction: None),
    )
    theta = np.empty((many, count + 1))
    theta[:, 0] = start if isinstance(start, np.ndarray) else finite_number("start", start)
    today = strategy.loops(loop)
    for number in range(count):
        if loop.material.wear is not None:
            today = strategy.loops(worn_loop(loop, number))
        doing = chosen[:, number]
        ran = run_cycles([today[action] for action in doing.tolist()], theta[:, number, None])
        theta[:, number + 1] = ran.theta_next[:, 0] + turns[doing] + kicks[:, number]
        report((number + 1) / count)
    return StrategyRun(read_only(theta), chosen)


def drawn_actions(strategy: ResetStrategy, cycles: int, runs: int, seed: int) -> NDArray[np.int64]:
    """Return the number of the action of each cycle, (runs, cycles), each run drawn by itself."""
    seeds: list[int | np.random.SeedSequence] = [seed]
    seeds += [np.random.SeedSequence(seed, spawn_key=(run,)) for run in range(1, runs)]
    return np.array([strategy.drawn(cycles, one) for one in seeds])


def noise_of_runs(sigma: float, cycles: int, runs: int, seed: int) -> Array:
    """Return normal noise (runs, cycles), rad."""
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_NOISE_STREAM,)))
    return sigma * random.standard_normal((runs, cycles))


def sampled_orientations(
    turn: Array,
    strategy: ResetStrategy,
    cycles: int,
    runs: int,
    sigma: float,
    seed: int = 0,
    start: float | None = None,
) -> Array:
    """Return theta0 (runs, cycles) of collections whose actions turn by `turn` (actions, n) rad at
    n equal steps.

    Parameters
    ----------
    start : float, optional
        rad; None: drawn evenly, one a run. On the lift.

    Returns
    -------
    ndarray

    Notes
    -----
    Between the steps turns are interpolated linearly.
    """
    chosen = drawn_actions(strategy, cycles, runs, seed)
    return _followed(
        turn, chosen.shape, sigma, seed, start, lambda number, theta, ends: chosen[:, number]
    )


def steered_orientations(turn: Array, cycles: int, runs: int, sigma: float, seed: int = 0) -> Array:
    """Return theta0 (runs, cycles) where each cycle is the action that leads to where least was
    recorded so far.

    Returns
    -------
    ndarray
        Theta0 (runs, cycles) where each cycle is the action that leads to where least was
        recorded so far.

    Notes
    -----
    That is `next_action` with exact maps; the noise of the cycle is not known beforehand.
    """
    crowding = Crowding(runs)

    def least(number: int, theta: Array, ends: Array) -> NDArray[np.int64]:
        crowding.add(theta)
        return np.asarray(np.argmin(crowding.at(ends), axis=0))

    return _followed(turn, (runs, cycles), sigma, seed, None, least)


def _followed(
    turn: Array,
    shape: tuple[int, ...],
    sigma: float,
    seed: int,
    start: float | None,
    choose: Callable[[int, Array, Array], NDArray[np.int64]],
) -> Array:
    runs, cycles = shape
    kicks, rows = noise_of_runs(sigma, cycles, runs, seed), np.arange(runs)
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_NOISE_STREAM, 1)))
    theta = np.empty((runs, cycles))
    now = (
        random.uniform(0.0, TWO_PI, runs)
        if start is None
        else np.full(runs, finite_number("start", start))
    )
    around = np.concatenate([turn, turn[:, :1]], axis=1)
    for number in range(cycles):
        theta[:, number] = now
        place = (now % TWO_PI) * (turn.shape[1] / TWO_PI)
        below = np.minimum(place.astype(int), turn.shape[1] - 1)
        ends = now + around[:, below] + (place - below) * (around[:, below + 1] - around[:, below])
        now = ends[choose(number, now, ends), rows] + kicks[:, number]
    return theta


def histogram_shares(theta: Array) -> Array:
    """Return the shares (runs, 36) of orientations (runs, n), rad, in equal bins from 0.

    Returns
    -------
    ndarray
        The shares (runs, 36) of orientations (runs, n), rad, in equal bins from 0.
    """
    cells = np.minimum((np.mod(theta, TWO_PI) * (BINS / TWO_PI)).astype(np.int64), BINS - 1)
    counts = np.bincount(
        (cells + BINS * np.arange(len(cells))[:, None]).ravel(), minlength=BINS * len(cells)
    )
    return np.asarray(counts.reshape(len(cells), BINS) / theta.shape[-1])


def histogram_distances(shares: Array) -> Array:
    """Return the total variation (runs,) between histograms with shares (runs, bins) and the
    uniform one.

    Returns
    -------
    ndarray
        The total variation (runs,) between histograms with shares (runs, bins) and the uniform
        one.

    Examples
    --------
    >>> even, locked = np.arange(36) * math.radians(10.0) + 0.1, np.zeros(36)
    >>> histogram_distances(histogram_shares(np.array([even, locked]))).round(4).tolist()
    [0.0, 0.9722]
    """
    return np.asarray(0.5 * np.abs(shares - 1.0 / shares.shape[-1]).sum(axis=-1))


def independent_distance(pushes: int) -> float:
    """Return the mean histogram distance of that many independent uniform orientations: de Moivre's
    mean deviation.

    Returns
    -------
    float

    Examples
    --------
    >>> round(independent_distance(500), 4)
    0.1053
    """
    from scipy.stats import binom

    count, chance = whole_number("pushes", pushes, least=1), 1.0 / BINS
    # E|K - np| = 2 (1 - p) m P(K = m), m = floor(np) + 1.
    most = math.floor(count * chance) + 1
    deviation = 2.0 * (1.0 - chance) * most * float(binom.pmf(most, count, chance))
    return 0.5 * BINS * deviation / count
