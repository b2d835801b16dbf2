"""What the next pushes will bring, of all that is believed of the floor: lock-in, where, and how
much of the circle; and what a log of pushes tells of that.

By a log the turn of a cycle is a sample's plus a deviation that is the same for all of them: a
smooth random function on the circle that changes from push to push as a random walk does (Kalman
1960; Rasmussen & Williams 2006, ch. 4). Each push of the log tells of it by one number, and of the
samples by how likely that was.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import (
    TWO_PI,
    Array,
    Mask,
    even_angles,
    evenly_spread,
    nodes_around,
    shorter_way,
)
from cyclemap.checks import finite_array, finite_number, positive_number, require_room, whole_number
from cyclemap.collection.loop import CollectionLoop, require_loop
from cyclemap.collection.loop_surfaces import on_material
from cyclemap.collection.uncertain_directions import clusters
from cyclemap.errors import InvalidInput
from cyclemap.mechanics.cycle_batch import run_batch
from cyclemap.progress import Progress
from cyclemap.written import ANGLE, DIRECTION, UNWRITTEN

# A run has locked in where so many successive pushes stay within this (rad) of each other.
REST_CYCLES = 50
REST_WIDTH = math.radians(30.0)
# Orientations that are told apart.
ORIENTATIONS = 36
# Samples of what is believed, runs on them in all, and angles between which a map is taken as
# straight: off by .1 degrees.
_SAMPLES = 40
_RUNS = 320
_NODES = 96
_ACCURACY = 1e-5
LEVEL = 0.9
# Standard deviation (rad) of a model's turn from that of its loop, and the angle (rad) over which
# it changes: what maps predicted from pushes miss of the plywood staircase.
DEVIATION = math.radians(6.0)
WIDTH = 0.7
# Of a log no more pushes are read than these, the last ones.
MOST_PUSHES = 2000
# What is tried of a cycle's noise, in shares of what is believed, and of the change in a push, rad.
# A share of two or of a half is one standard deviation of what is believed of the noise itself, so
# that a short log leaves it as it is.
_NOISES = (1.0, 0.25, 0.5, 2.0, 4.0)
_CHANGES = tuple(math.radians(change) for change in (0.03, 0.1, 0.3))
# How likely a push is that no map explains, and how many standard deviations off it must be.
_JUMP = 1e-3
_JUMPED = 5.0


@dataclass(frozen=True)
class LikelyDirection:
    """A direction about which runs lock in.

    Attributes
    ----------
    theta : float
        The direction, rad.
    share : float
        Of the runs.
    within : float
        Of it 90 % of these rest, rad.
    """

    theta: float = field(metadata=DIRECTION)
    share: float
    within: float = field(metadata=ANGLE)


@dataclass(frozen=True)
class SeenOrientations:
    """How many of 36 orientations will have been seen: the median and a 90 % interval."""

    median: float
    lower: float
    upper: float


@dataclass(frozen=True)
class LockForecast:
    """What a number of pushes will bring, over samples of what is believed and runs with the noise
    of a cycle.

    Attributes
    ----------
    cycles : int
        The pushes.
    chance : float
        That 50 successive ones of them stay within 30 degrees.
    directions : tuple of LikelyDirection
        About which, the likeliest first.
    orientations : SeenOrientations
        How many of 36 orientations will have been seen.
    samples : int
        How many samples of what is believed.
    """

    cycles: int
    chance: float = field(metadata={"name": "chance_of_lock_in"})
    directions: tuple[LikelyDirection, ...]
    orientations: SeenOrientations = field(metadata={"name": "orientations_of_36"})
    samples: int = field(metadata=UNWRITTEN)


def sampled_turns(loop: CollectionLoop, progress: Progress | None = None) -> Array:
    """Return the turns of a cycle, rad, from 96 angles all around on each of 40 samples of a
    posterior: (samples, 96).

    They are nearly all of a forecast's work, and serve for forecasts from any orientation. A
    surface that wears is taken as it is now.
    progress : called with the fraction done.

    Raises InvalidInput for a material without samples.
    """
    posterior = require_loop(loop).material.posterior
    if posterior is None:
        raise InvalidInput(
            f"{loop.material.name} has no samples of what is believed of it: identify it from data"
        )
    chosen = evenly_spread(len(posterior), _SAMPLES)
    stated = replace(loop, accuracy=max(loop.accuracy, _ACCURACY))
    theta = even_angles(_NODES)
    turns = np.empty((len(chosen), _NODES))
    for row, index in enumerate(chosen):
        sample = on_material(stated, loop.material.sample(index))
        turns[row] = run_batch([sample], theta[None]).theta_next[0] - theta
        if progress is not None:
            progress((row + 1) / len(chosen))
    return turns


def forecast_from_turns(
    turns: Array,
    sigma: float | Array,
    cycles: int,
    start: float = 0.0,
    seed: int = 0,
    *,
    change: Array | None = None,
) -> LockForecast:
    """Return what the next `cycles` pushes will bring.

    Parameters
    ----------
    turns : ndarray, (samples, 96)
        Turns of a cycle, rad, of `sampled_turns` or `turns_after_log`.
    sigma, cycles, start, seed, change
        As `sampled_paths` takes them.

    Returns
    -------
    LockForecast

    Raises
    ------
    InvalidInput
        For fewer than 50 pushes, and for numbers that make no sense.
    """
    paths = sampled_paths(turns, sigma, cycles, start, seed, change=change)
    resting, where = _rests(paths)
    seen = _orientations(paths)
    centres = clusters(where)
    away = np.abs(shorter_way(where[:, None] - centres))
    directions = []
    for index, centre in enumerate(centres.tolist()):
        own = away[np.argmin(away, axis=1) == index, index]
        within = float(np.quantile(own, LEVEL))
        directions.append(LikelyDirection(centre, own.size / len(resting), within))
    directions.sort(key=lambda direction: -direction.share)
    ends = np.quantile(seen, (0.5, 0.5 - LEVEL / 2.0, 0.5 + LEVEL / 2.0)).tolist()
    return LockForecast(
        cycles, float(resting.mean()), tuple(directions), SeenOrientations(*ends), len(turns)
    )


def sampled_paths(
    turns: Array,
    sigma: float | Array,
    cycles: int,
    start: float = 0.0,
    seed: int = 0,
    *,
    change: Array | None = None,
) -> Array:
    """Return the orientations of runs on samples of a map, unwrapped.

    Parameters
    ----------
    turns : ndarray, (samples, 96)
        Turns of a cycle, rad, from angles evenly all around, taken as straight between them.
    sigma : float or ndarray, (samples,)
        Standard deviation of a cycle's noise, rad; of all samples, or of each.
    cycles : int
        Pushes of a run, at least 50.
    start : float
        The first orientation, rad.
    seed : int
        Of the noise.
    change : ndarray, (samples, 96), optional
        By how much the turns will have changed at the end, rad, evenly on the way.

    Returns
    -------
    ndarray, (cycles + 1, runs)
        rad; at least 320 runs, the same number on every sample.

    Raises
    ------
    InvalidInput
        For fewer than 50 pushes, more than memory holds, and numbers that make no sense.
    """
    turns = _samples_of(turns)
    ahead = np.zeros_like(turns) if change is None else finite_array("change", change)
    if ahead.shape != turns.shape:
        raise InvalidInput(f"change must have the shape of turns, {turns.shape}, not {ahead.shape}")
    count = whole_number("cycles of a forecast", cycles, least=REST_CYCLES)
    runs = max(_RUNS, len(turns))
    require_room("angles of a forecast", 2.0 * count * runs, "forecast fewer pushes")
    rng = np.random.default_rng(whole_number("seed", seed, least=0))
    each = -(-runs // len(turns))
    scatter = np.repeat(_noise_of_each(sigma, len(turns)), each)
    now = np.repeat(turns, each, axis=0)
    later = now + np.repeat(ahead, each, axis=0)
    run = np.arange(len(now))
    paths = np.empty((count + 1, len(now)))
    paths[0] = finite_number("start", start)
    for cycle in range(count):
        before, after, share = nodes_around(paths[cycle], turns.shape[1])
        done = cycle / count
        left = (1.0 - done) * now[run, before] + done * later[run, before]
        right = (1.0 - done) * now[run, after] + done * later[run, after]
        turn = (1.0 - share) * left + share * right
        paths[cycle + 1] = paths[cycle] + turn + scatter * rng.standard_normal(len(run))
    return paths


def _rests(paths: Array) -> tuple[Mask, Array]:
    """Whether each run rests, (c,), and about where those that do are in all of their first rest,
    rad: they come there from one side.
    """
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    low, high = (
        extreme(paths, REST_CYCLES, axis=0) for extreme in (minimum_filter1d, maximum_filter1d)
    )
    half = REST_CYCLES // 2
    resting = (high - low)[half : len(paths) - half + 1] < REST_WIDTH
    rests = resting.any(axis=0)
    places = []
    for run in np.flatnonzero(rests):
        first = int(np.argmax(resting[:, run]))
        moves_on = np.flatnonzero(~resting[first:, run])
        last = first + (int(moves_on[0]) if moves_on.size else len(resting) - first) - 1
        places.append(float(np.median(paths[first : last + REST_CYCLES, run])))
    return rests, np.mod(np.array(places), TWO_PI)


def _orientations(paths: Array) -> Array:
    """How many of the orientations each run has seen, (c,)."""
    arcs = np.floor(np.mod(paths, TWO_PI) * (ORIENTATIONS / TWO_PI)).astype(int) % ORIENTATIONS
    changes = np.diff(np.sort(arcs, axis=0), axis=0) > 0
    return np.asarray(1.0 + changes.sum(axis=0))


# -- what a log tells


@dataclass(frozen=True, eq=False)
class LoggedTurns:
    """Draws of a loop's map as the log leaves it, and of what becomes of it.

    Attributes
    ----------
    turns : ndarray, (draws, nodes)
        Turns of a cycle after the last push, rad, from angles evenly all around.
    change : ndarray, (draws, nodes)
        By how much these will have changed after the pushes ahead, rad.
    sigma : ndarray, (draws,)
        Standard deviation of a cycle's noise, rad, as likely as the log leaves it.
    """

    turns: Array
    change: Array
    sigma: Array


def turns_after_log(
    turns: Array,
    path: Sequence[float],
    sigma: float,
    ahead: int,
    draws: int = 320,
    seed: int = 0,
) -> LoggedTurns:
    """Return draws of the map of a loop that has made the pushes of a log.

    Parameters
    ----------
    turns : array_like, (samples, nodes)
        Turns of a cycle on samples of what is believed, rad, of `sampled_turns`.
    path : sequence of float
        Orientations before successive pushes, rad, whole turns as they may be.
    sigma : float
        Standard deviation of a cycle's noise, rad, as it is believed; a quarter to four times it
        is tried, twice or half of it believed to be one standard deviation off.
    ahead : int
        Pushes over which the map goes on changing.
    draws : int
        How many, at least 1.
    seed : int
        Of the draws.

    Returns
    -------
    LoggedTurns

    Raises
    ------
    InvalidInput
        For more draws than memory holds, and numbers that make no sense.

    Notes
    -----
    Of nodes h apart and a deviation of standard deviation s over a width w, taking maps as straight
    between nodes errs by about s h^2 / (8 w^2): a hundredth of a degree. A push that is more than
    five standard deviations from all samples counts as a jump, and tells nothing of the map.

    References
    ----------
    R. E. Kalman, A new approach to linear filtering and prediction problems, 1960.
    C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine Learning, 2006.

    Examples
    --------
    A loop that is believed to turn by a degree a push, and turned by three:

    >>> believed = np.full((1, 96), math.radians(1.0))
    >>> logged = turns_after_log(believed, np.radians(3.0 * np.arange(300)), 0.01, 50)
    >>> round(math.degrees(logged.turns.mean()), 1)
    3.0
    """
    believed = _samples_of(turns)
    angles = finite_array("path", path, ndim=1)[-MOST_PUSHES:]
    scatter = positive_number("sigma", sigma)
    steps = whole_number("pushes ahead", ahead, least=1)
    count = whole_number("draws", draws, least=1)
    rng = np.random.default_rng(whole_number("seed", seed, least=0))
    nodes = believed.shape[1]
    require_room("turns of the draws", nodes * max(nodes, count), "ask for fewer draws or nodes")
    theta = even_angles(nodes)
    alike = np.exp(-2.0 * (np.sin(0.5 * (theta[:, None] - theta)) / WIDTH) ** 2)
    tried = [
        _filtered(believed, angles, alike, scatter * share, change)
        for share in _NOISES
        for change in _CHANGES
    ]
    # A few pushes leave the noise open, and with the likeliest alone they would tell too much.
    likely = [state.evidence - 0.5 * math.log2(state.sigma / scatter) ** 2 for state in tried]
    drawn = rng.choice(len(tried), count, p=_shares(np.array(likely)))
    change = np.array([state.change for state in tried])[drawn, None] * math.sqrt(steps)
    walk = rng.multivariate_normal(np.zeros(nodes), alike, count, "ignore", method="eigh")
    after = np.empty((count, nodes))
    for index in np.unique(drawn).tolist():
        state = tried[index]
        rows = np.flatnonzero(drawn == index)
        sample = rng.choice(len(believed), rows.size, p=_shares(state.likelihood))
        off = rng.multivariate_normal(
            np.zeros(nodes), state.covariance, rows.size, "ignore", method="eigh"
        )
        after[rows] = state.turns[sample] + off
    return LoggedTurns(after, change * walk, np.array([state.sigma for state in tried])[drawn])


def _shares(likelihood: Array) -> Array:
    """How likely each is beside the others, from logarithms."""
    weight = np.exp(likelihood - likelihood.max())
    return np.asarray(weight / weight.sum())


def _noise_of_each(sigma: float | Array, samples: int) -> Array:
    """The noise of each sample, (samples,), where one is given for all or for each."""
    if np.ndim(sigma) == 0:
        return np.full(samples, positive_number("sigma", sigma))
    each = finite_array("sigma", sigma, ndim=1)
    if each.size != samples or not (each > 0.0).all():
        raise InvalidInput(
            f"sigma must be positive, one number or one of each of {samples} samples"
        )
    return each


def _samples_of(turns: ArrayLike) -> Array:
    """Turns as an array (samples, nodes), or InvalidInput."""
    array = finite_array("turns", turns)
    if array.ndim != 2 or array.shape[0] < 1 or array.shape[1] < 2:
        raise InvalidInput(
            f"turns must be (samples, nodes), one sample or more, not of shape {array.shape}"
        )
    return array


@dataclass(frozen=True, eq=False)
class _State:
    """Turns (samples, nodes) after a log, their covariance (nodes, nodes), how likely each sample
    made it (logarithms), by a noise and a change.
    """

    turns: Array
    covariance: Array
    likelihood: Array
    sigma: float
    change: float

    @property
    def evidence(self) -> float:
        """Logarithm of how likely the log was on average over the samples."""
        top = float(self.likelihood.max())
        return top + math.log(float(np.exp(self.likelihood - top).mean()))


def _filtered(turns: Array, path: Array, alike: Array, sigma: float, change: float) -> _State:
    """Kalman's filter: predict the next push, and correct by what it misses."""
    covariance = DEVIATION**2 * alike
    walk = change**2 * alike
    likelihood = np.zeros(len(turns))
    turns = turns.copy()
    pushes = zip(*nodes_around(path[:-1], turns.shape[1]), shorter_way(np.diff(path)), strict=True)
    for before, after, share, turn in pushes:
        covariance = covariance + walk
        row = (1.0 - share) * covariance[before] + share * covariance[after]
        variance = float((1.0 - share) * row[before] + share * row[after]) + sigma**2
        missed = shorter_way(turn - (1.0 - share) * turns[:, before] - share * turns[:, after])
        if float(np.abs(missed).min()) > _JUMPED * math.sqrt(variance):
            likelihood += math.log(_JUMP / TWO_PI)
            continue
        likelihood -= 0.5 * (missed**2 / variance + math.log(TWO_PI * variance))
        gain = row / variance
        turns += np.outer(missed, gain)
        covariance = covariance - np.outer(gain, row)
    return _State(turns, covariance, likelihood, sigma, change)
