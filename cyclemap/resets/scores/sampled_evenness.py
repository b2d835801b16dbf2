"""Evenness of simulated collections, with its sampling error: for resets that no transfer operator describes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cyclemap.checks import finite_array, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.orientations.circular_distance import DEFAULT_BINS
from cyclemap.evidence.orientations.circular_law import CircularLaw
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.mixtures.law_distances import wasserstein_on_grid
from cyclemap.resets.scores.simulated_coverage import Sampler

_CELLS = 40  # of the table of W1, a bin: a quarter of a degree for 36 bins
_DRAWS = 200  # bootstrap samples of the collections


@dataclass(frozen=True)
class SampledEvenness:
    """How far the orientations of simulated collections are from the target, all pushes pooled.

    total_variation : over ``bins`` equal bins, in [0, 1]; what differs inside a bin is not seen. wasserstein : W1 on
    the circle, radians. Their ``error_bound`` is what sampling may have added or taken away, at about 95 %: the
    distance of resampled collections from those at hand, its mean and two standard deviations. An even law
    comes out at a distance of about that bound, not at 0.
    pushes : orientations pooled. runs : independent collections.
    """

    total_variation: Estimate
    wasserstein: Estimate
    bins: int
    pushes: int
    runs: int


def sampled_evenness(
    sampler: Sampler,
    pushes: int,
    *,
    skipped: int = 0,
    target: CircularLaw | None = None,
    bins: int = DEFAULT_BINS,
    runs: int = 100,
    seed: int = 0,
) -> SampledEvenness:
    """The evenness of ``runs`` independent collections of ``pushes`` orientations, the first ``skipped`` left out.

    sampler : as for ``simulated_coverage``; a strategy with a golden-angle sequence, the full mechanics. target : None
    is uniform. Collections are resampled whole (block bootstrap), so that their autocorrelation counts.
    Raises InvalidInput where no push is left, or fewer than ten collections.

    >>> even = lambda runs, pushes, seed: np.random.default_rng(seed).uniform(0, TWO_PI, (runs, pushes))
    >>> found = sampled_evenness(even, 100)
    >>> bool(found.total_variation < 1.5 * found.total_variation.error_bound < 0.06)
    True
    """
    size = whole_number("runs", runs, least=10), whole_number("pushes", pushes, least=1)
    left, count = whole_number("skipped", skipped, least=0), whole_number("bins", bins, least=2)
    if left >= size[1]:
        raise InvalidInput(f"skipped is {left} of {size[1]} pushes: leave at least one")
    theta = finite_array("the sampler's orientations", sampler(*size, whole_number("seed", seed, least=0)))
    if theta.shape != size:
        raise InvalidInput(f"the sampler gave shape {theta.shape} for {size}: give one row a collection")
    shares = _shares(theta[:, left:], count * _CELLS)
    wished = np.full(count * _CELLS, 1.0 / (count * _CELLS))
    wished = wished if target is None else target.bin_probabilities(count * _CELLS)
    rng = np.random.default_rng([seed, 2])
    again = rng.multinomial(size[0], np.full(size[0], 1.0 / size[0]), _DRAWS) @ shares / size[0]
    pooled = np.mean(shares, axis=0)
    found = [_estimate(measure, pooled, again, wished, count) for measure in (_variation, _wasserstein)]
    return SampledEvenness(found[0], found[1], count, int(theta[:, left:].size), size[0])


def _estimate(measure: Any, pooled: Array, again: Array, wished: Array, bins: int) -> Estimate:
    apart = measure(again - pooled, bins)
    return Estimate(float(measure(pooled - wished, bins)), float(np.mean(apart) + 2.0 * np.std(apart)))


def _shares(theta: Array, cells: int) -> Array:
    """(runs, cells): the share of each collection's pushes in each of the cells."""
    place = np.minimum((np.mod(theta, TWO_PI) * (cells / TWO_PI)).astype(np.int64), cells - 1)
    flat = place + cells * np.arange(len(theta))[:, None]
    counts = np.bincount(flat.ravel(), minlength=cells * len(theta)).reshape(len(theta), cells)
    return np.asarray(counts / theta.shape[1])


def _variation(difference: Array, bins: int) -> Array:
    merged = np.sum(difference.reshape(*difference.shape[:-1], bins, -1), axis=-1)
    return np.asarray(0.5 * np.sum(np.abs(merged), axis=-1))


def _wasserstein(difference: Array, bins: int) -> Array:
    return wasserstein_on_grid(np.cumsum(difference, axis=-1))[0]
