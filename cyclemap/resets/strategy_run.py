"""What comes of a strategy: collections by the full mechanics or from known turns, and how uniform
they are.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, Whole, nodes_around
from cyclemap.checks import (
    finite_array,
    finite_number,
    non_negative_number,
    read_only,
    require_room,
    whole_number,
)
from cyclemap.collection.loop import CollectionLoop, require_loop, run_cycles
from cyclemap.collection.loop_surfaces import worn_loop
from cyclemap.errors import InvalidInput
from cyclemap.evidence.laws.turn_bins import bin_shares
from cyclemap.progress import Progress, part_of
from cyclemap.protocol.strategy import ResetStrategy, require_strategy
from cyclemap.resets.action_cycles import checked_turns
from cyclemap.resets.coverage import Crowding

BINS = 36
_MOST_PUSHES = 2**53  # whole numbers that floats tell apart
# The noise's stream of random numbers, beside that of what is drawn, which starts from the seed
# itself.
_NOISE_STREAM = 1 << 20


@dataclass(frozen=True, eq=False)
class StrategyRun:
    """Collections of n cycles each, run by the full mechanics.

    Attributes
    ----------
    theta : ndarray, shape (runs, n + 1)
        Orientations, rad, not wrapped, the start first.
    action : ndarray of int, shape (runs, n)
        Number of the strategy's action.

    Examples
    --------
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.resets import ResetStrategy, run_strategy
    >>> loop = CollectionLoop.mit(accuracy=1e-6)
    >>> run = run_strategy(loop, ResetStrategy.pushes(loop.push, (0, 1)), 4, seed=1)
    >>> run.theta.shape, run.action.tolist()
    ((1, 5), [[1, 1, 0, 1]])
    """

    theta: Array
    action: Whole


def run_strategy(
    loop: CollectionLoop,
    strategy: ResetStrategy,
    cycles: int,
    *,
    runs: int = 1,
    start: float | Array = 0.0,
    sigma: float = 0.0,
    seed: int = 0,
    progress: Progress | None = None,
) -> StrategyRun:
    """Run collections by the full mechanics, some 0.3 ms a cycle.

    Parameters
    ----------
    loop : CollectionLoop
        The loop; a surface that wears does so.
    strategy : ResetStrategy
        What is done in each cycle.
    cycles : int
        Cycles of a collection.
    runs : int, default 1
        How many collections.
    start : float or array_like, shape (runs,), default 0.0
        Orientation before the first push, of all runs or one each, rad.
    sigma : float, default 0.0
        Noise of a cycle, rad.
    seed : int, default 0
        The first run does what `strategy.run(cycles, seed)` says, so that a robot can be given
        the very same.
    progress : callable or None, optional
        Called with the fraction done.

    Returns
    -------
    StrategyRun
        Orientations and actions of every cycle.

    Raises
    ------
    InvalidInput
        For a bad value, and what a cycle raises that leads out of the mechanics.

    Examples
    --------
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.resets import ResetStrategy, run_strategy
    >>> loop = CollectionLoop.mit(accuracy=1e-6)
    >>> run = run_strategy(loop, ResetStrategy.pushes(loop.push, (0,)), 2)
    >>> bool(abs(run.theta[0, 1] - loop.cycle(0.0).theta_next) < 1e-9)
    True
    """
    require_loop(loop)
    require_strategy(strategy)
    many, count = _checked_runs(runs, cycles, sigma, seed)
    chosen = drawn_actions(strategy, count, many, seed)
    kicks = noise_of_runs(sigma, count, many, seed)
    turns = np.array([action.turn for action in strategy.actions])
    theta = np.empty((many, count + 1))
    theta[:, 0] = start if isinstance(start, np.ndarray) else finite_number("start", start)
    today = strategy.loops(loop)
    for cycle in range(count):
        if loop.material.wear is not None:
            today = strategy.loops(worn_loop(loop, cycle))
        doing = chosen[:, cycle]
        ran = run_cycles([today[action] for action in doing.tolist()], theta[:, cycle, None])
        theta[:, cycle + 1] = ran.theta_next[:, 0] + turns[doing] + kicks[:, cycle]
        part_of(progress, cycle, count)(1.0)
    return StrategyRun(read_only(theta), chosen)


def drawn_actions(strategy: ResetStrategy, cycles: int, runs: int, seed: int) -> Whole:
    """Return the number of the action of each cycle, (runs, cycles), each run drawn by itself."""
    seeds: list[int | np.random.SeedSequence] = [seed]
    seeds += [np.random.SeedSequence(seed, spawn_key=(run,)) for run in range(1, runs)]
    return np.array([strategy.drawn(cycles, stream) for stream in seeds])


def noise_of_runs(sigma: float, cycles: int, runs: int, seed: int) -> Array:
    """Return normal noise (runs, cycles), rad."""
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_NOISE_STREAM,)))
    return sigma * random.standard_normal((runs, cycles))


def sampled_orientations(
    turn: ArrayLike,
    strategy: ResetStrategy,
    cycles: int,
    runs: int,
    sigma: float,
    seed: int = 0,
    start: float | None = None,
) -> Array:
    """Return the orientations of collections, from the turns of their actions.

    Parameters
    ----------
    turn : array_like, shape (actions, n)
        Turns at n equal steps of theta, rad; between the steps they are interpolated linearly.
    strategy : ResetStrategy
        Which action comes when.
    cycles : int
        Cycles of a collection.
    runs : int
        How many collections.
    sigma : float
        Noise of a cycle, rad.
    seed : int, default 0
        Of actions, starts and noise.
    start : float or None, optional
        Orientation before the first push, rad; None: drawn evenly, one a run.

    Returns
    -------
    ndarray, shape (runs, cycles)
        theta0 of every cycle, rad, on the lift.

    Examples
    --------
    >>> import math
    >>> import numpy as np
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.resets import ResetStrategy, sampled_orientations
    >>> quarter = np.full((1, 8), math.pi / 2.0)
    >>> strategy = ResetStrategy.pushes(CollectionLoop.mit().push, (0,))
    >>> theta = sampled_orientations(quarter, strategy, 3, runs=1, sigma=0.0, start=0.0)
    >>> np.degrees(theta).round(6).tolist()
    [[0.0, 90.0, 180.0]]
    """
    turns = checked_turns(turn, len(require_strategy(strategy).actions))
    shape = _checked_runs(runs, cycles, sigma, seed)
    chosen = drawn_actions(strategy, cycles, runs, seed)
    return _followed(turns, shape, sigma, seed, start, lambda cycle, theta, ends: chosen[:, cycle])


def steered_orientations(
    turn: ArrayLike, cycles: int, runs: int, sigma: float, seed: int = 0
) -> Array:
    """Return the orientations of collections whose every cycle is the action that leads to where
    least was recorded so far.

    Parameters
    ----------
    turn : array_like, shape (actions, n)
        Turns at n equal steps of theta, rad.
    cycles : int
        Cycles of a collection.
    runs : int
        How many collections.
    sigma : float
        Noise of a cycle, rad.
    seed : int, default 0
        Of starts and noise.

    Returns
    -------
    ndarray, shape (runs, cycles)
        theta0 of every cycle, rad.

    Notes
    -----
    That is `next_action` with exact maps; the noise of the cycle is not known beforehand.

    Examples
    --------
    >>> import math
    >>> import numpy as np
    >>> from cyclemap.resets import steered_orientations
    >>> turns = np.full((2, 360), math.pi / 2.0)
    >>> turns[1] = math.pi
    >>> theta = steered_orientations(turns, 4, runs=1, sigma=0.0)
    >>> sorted((np.degrees(theta - theta[0, 0]).round()[0] % 360).tolist())
    [0.0, 90.0, 180.0, 270.0]
    """
    turns = checked_turns(turn)
    shape = _checked_runs(runs, cycles, sigma, seed)
    crowding = Crowding(runs)

    def least(cycle: int, theta: Array, ends: Array) -> Whole:
        crowding.add(theta)
        return np.asarray(np.argmin(crowding.at(ends), axis=0))

    return _followed(turns, shape, sigma, seed, None, least)


def _checked_runs(runs: int, cycles: int, sigma: float, seed: int) -> tuple[int, int]:
    """How many runs of how many cycles; InvalidInput for numbers that make none."""
    count = whole_number("cycles", cycles, least=1)
    many = whole_number("runs", runs, least=1)
    require_room("the orientations", many * count, "give fewer cycles or runs")
    non_negative_number("sigma", sigma)
    whole_number("seed", seed, least=0)
    return many, count


def _followed(
    turn: Array,
    shape: tuple[int, int],
    sigma: float,
    seed: int,
    start: float | None,
    choose: Callable[[int, Array, Array], Whole],
) -> Array:
    runs, cycles = shape
    kicks = noise_of_runs(sigma, cycles, runs, seed)
    rows = np.arange(runs)
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_NOISE_STREAM, 1)))
    theta = np.empty((runs, cycles))
    now = (
        random.uniform(0.0, TWO_PI, runs)
        if start is None
        else np.full(runs, finite_number("start", start))
    )
    for cycle in range(cycles):
        theta[:, cycle] = now
        before, after, share = nodes_around(now, turn.shape[1])
        ends = now + turn[:, before] + share * (turn[:, after] - turn[:, before])
        now = ends[choose(cycle, now, ends), rows] + kicks[:, cycle]
    return theta


def histogram_shares(theta: ArrayLike) -> Array:
    """Return histograms of orientations, in 36 equal bins from 0.

    Parameters
    ----------
    theta : array_like, shape (runs, n)
        Orientations, rad.

    Returns
    -------
    ndarray, shape (runs, 36)
        Shares, which sum to one.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.resets import histogram_shares
    >>> histogram_shares(np.radians([[5.0, 6.0, 15.0, -5.0]]))[0, [0, 1, 35]].tolist()
    [0.5, 0.25, 0.25]
    """
    angles = finite_array("theta", theta)
    if angles.ndim == 0 or angles.shape[-1] == 0:
        raise InvalidInput(f"theta has shape {angles.shape}: give one orientation or more a run")
    return bin_shares(angles, BINS)


def histogram_distances(shares: ArrayLike) -> Array:
    """Return the total variation between histograms and the uniform one.

    Parameters
    ----------
    shares : array_like, shape (runs, bins)
        Shares of a histogram, which sum to one.

    Returns
    -------
    ndarray, shape (runs,)
        In [0, 1].

    Examples
    --------
    >>> import math
    >>> import numpy as np
    >>> from cyclemap.resets import histogram_distances, histogram_shares
    >>> even, locked = np.arange(36) * math.radians(10.0) + 0.1, np.zeros(36)
    >>> histogram_distances(histogram_shares(np.array([even, locked]))).round(4).tolist()
    [0.0, 0.9722]
    """
    parts = finite_array("shares", shares)
    if parts.ndim == 0 or parts.shape[-1] == 0:
        raise InvalidInput(f"shares has shape {parts.shape}: give one bin or more a run")
    return np.asarray(0.5 * np.abs(parts - 1.0 / parts.shape[-1]).sum(axis=-1))


def independent_distance(pushes: int) -> float:
    """Return the mean histogram distance of independent uniform orientations: de Moivre's mean
    deviation.

    Parameters
    ----------
    pushes : int
        How many orientations, at most 2⁵³.

    Returns
    -------
    float
        Total variation, of 36 bins.

    Examples
    --------
    >>> from cyclemap.resets import independent_distance
    >>> round(independent_distance(500), 4)
    0.1053
    """
    from scipy.stats import binom

    count = whole_number("pushes", pushes, least=1)
    require_room("the pushes", count, "give fewer", _MOST_PUSHES)
    chance = 1.0 / BINS
    # E|K - np| = 2 (1 - p) m P(K = m), m = floor(np) + 1.
    most = math.floor(count * chance) + 1
    deviation = 2.0 * (1.0 - chance) * most * float(binom.pmf(most, count, chance))
    return 0.5 * BINS * deviation / count
