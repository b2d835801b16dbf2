"""What a log tells of a loop's map, joined with what is believed of its floor.

The turn of a cycle is a sample's plus a deviation that is the same for all of them: a smooth random
function on the circle that changes from push to push as a random walk does (Kalman 1960;
Rasmussen & Williams 2006, ch. 4). Each push of the log tells of it by one number, and of the
samples by how likely that was.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import TWO_PI, Array, nodes_around, shorter_way
from cyclemap.checks import finite_array, positive_number, whole_number
from cyclemap.errors import InvalidInput

# Standard deviation (rad) of a model's turn from that of its loop, and the angle (rad) over which
# it changes: what maps predicted from pushes miss of the plywood staircase.
DEVIATION = math.radians(6.0)
WIDTH = 0.7
# Of a log no more pushes are read than these, the last ones.
MOST_PUSHES = 2000
# What is tried of a cycle's noise, in shares of what is believed, and of the change in a push, rad.
_NOISES = (1.0, 2.0, 4.0)
_CHANGES = tuple(math.radians(change) for change in (0.03, 0.1, 0.3))
# How likely a push is that no map explains, and how many standard deviations off it must be.
_JUMP = 1e-3
_JUMPED = 5.0


@dataclass(frozen=True, eq=False)
class LoggedTurns:
    """Draws of a loop's map as the log leaves it, and of what becomes of it.

    Attributes
    ----------
    turns : ndarray, (draws, nodes)
        Turns of a cycle after the last push, rad, from angles evenly all around.
    change : ndarray, (draws, nodes)
        By how much these will have changed after the pushes ahead, rad.
    sigma : float
        Standard deviation of a cycle's noise, rad: of those tried the one by which the log was
        likeliest.
    """

    turns: Array
    change: Array
    sigma: float


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
        Standard deviation of a cycle's noise, rad, as it is believed; up to four times it is
        tried.
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
        For numbers that make no sense.

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
    believed = finite_array("turns", turns)
    if believed.ndim != 2 or believed.shape[1] < 2:
        raise InvalidInput(f"turns must be (samples, nodes), not of shape {believed.shape}")
    angles = finite_array("path", path)[-MOST_PUSHES:]
    scatter = positive_number("sigma", sigma)
    steps = whole_number("pushes ahead", ahead, least=1)
    count = whole_number("draws", draws, least=1)
    rng = np.random.default_rng(whole_number("seed", seed, least=0))
    nodes = believed.shape[1]
    theta = TWO_PI * np.arange(nodes) / nodes
    alike = np.exp(-2.0 * (np.sin(0.5 * (theta[:, None] - theta)) / WIDTH) ** 2)
    tried = [
        _filtered(believed, angles, alike, scatter * share, change)
        for share in _NOISES
        for change in _CHANGES
    ]
    likeliest = max(tried, key=lambda state: state.evidence)
    weight = np.exp(likeliest.likelihood - likeliest.likelihood.max())
    sample = rng.choice(len(believed), count, p=weight / weight.sum())
    root = _root(likeliest.covariance)
    root_alike = _root(alike)
    off = rng.standard_normal((count, nodes)) @ root.T
    walk = likeliest.change * math.sqrt(steps)
    change = walk * rng.standard_normal((count, nodes)) @ root_alike.T
    return LoggedTurns(likeliest.turns[sample] + off, change, likeliest.sigma)


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


def _root(covariance: Array) -> Array:
    """A matrix whose square is the covariance, rounding's negative variances taken as none."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
