"""Distances between a sample of orientations and a law on the circle, or a second sample."""

from __future__ import annotations

from typing import Any

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.evidence.orientations.circular_law import CircularLaw, law_or_sample, orientations
from cyclemap.evidence.orientations.pooled_samples import bin_index, pooled_samples

DEFAULT_BINS = 36

_BLOCK = 1 << 20  # entries of a table worked on at a time
_HALVINGS = 34  # the integral is flat in the median: its error is of second order in what is left of the bracket


def circular_wasserstein(sample: Any, law: Any) -> Array:
    """Wasserstein distance of order 1 on the circle, radians, in [0, π].

    W1 = ∫ |F - G - median(F - G)| dθ, F and G the distribution functions from any origin, the median over the
    uniform measure (Rabin, Delon & Gousseau 2011).

    Parameters
    ----------
    sample : shape (..., n), radians, any turn; each row is a sample of its own.
    law : a density per radian (vectorised callable), a ``CircularLaw``, or a second sample of shape (m,); with
        that ``sample`` must be (n,).

    Returns shape (...), a number for one sample. Between two samples it is exact to rounding. Against a law, G is
    taken as linear between the table's knots and the sample's angles: an error of at most h²/8 times the total
    variation of the density, h = 2π/cells; about 1e-6 rad for a density with one peak of height 1.
    Raises InvalidInput for an empty sample, numbers that are not finite and a density that is none.

    >>> round(float(circular_wasserstein([0.1, 0.1], [6.2])), 6)
    0.183185
    """
    given = law_or_sample(law)
    if not isinstance(given, CircularLaw):
        pooled = pooled_samples(sample, given)
        return pooled.wasserstein(pooled.first)[()]
    angles = orientations("the sample", sample)
    rows = angles.reshape(-1, angles.shape[-1])
    block = max(1, _BLOCK // (rows.shape[1] + given.cells))
    found = [_wasserstein_rows(rows[at : at + block], given) for at in range(0, len(rows), block)]
    return np.concatenate(found).reshape(angles.shape[:-1])[()]


def _wasserstein_rows(rows: Array, law: CircularLaw) -> Array:
    high, low, width = _difference_segments(rows, law)
    level = _median_level(high, low, width)[:, None]
    above, below = high - level, low - level
    span = np.where(high > low, high - low, 1.0)
    crossing = (above > 0.0) & (below < 0.0)
    mean = np.where(crossing, (above**2 + below**2) / (2.0 * span), 0.5 * np.abs(above + below))
    return np.asarray(np.sum(width * mean, axis=1))


def _difference_segments(rows: Array, law: CircularLaw) -> tuple[Array, Array, Array]:
    """F - G, which falls on each segment between samples and knots: its first and last values, and the width."""
    count, size = rows.shape
    knots = np.broadcast_to(law.knots[:-1], (count, law.cells))
    masses = np.broadcast_to(law.masses[:-1], (count, law.cells))
    angles = np.concatenate([rows, knots], axis=1)
    order = np.argsort(angles, axis=1)
    angles = np.take_along_axis(angles, order, axis=1)
    reached = np.take_along_axis(np.concatenate([law.cumulative(rows), masses], axis=1), order, axis=1)
    steps = np.cumsum(order < size, axis=1) / size
    ahead = np.concatenate([reached[:, 1:], np.ones((count, 1))], axis=1)
    return steps - reached, steps - ahead, np.diff(angles, axis=1, append=TWO_PI)


def _median_level(high: Array, low: Array, width: Array) -> Array:
    """The level that F - G lies below on half of the circle, by bisection, one a row."""
    span = high - low
    rate = np.where(span > 0.0, 1.0 / np.where(span > 0.0, span, 1.0), 1e300)
    bottom, top = np.min(low, axis=1), np.max(high, axis=1)
    for _ in range(_HALVINGS):
        middle = 0.5 * (bottom + top)
        share = np.clip((middle[:, None] - low) * rate, 0.0, 1.0)
        under = np.einsum("ij,ij->i", share, width) < np.pi
        bottom, top = np.where(under, middle, bottom), np.where(under, top, middle)
    return np.asarray(0.5 * (bottom + top))


def total_variation(sample: Any, law: Any, bins: int = DEFAULT_BINS) -> Array:
    """Total variation distance ½ Σ |share of the sample - probability| over equal bins of [0, 2π), in [0, 1].

    sample, law : as for ``circular_wasserstein``. Returns shape (...).

    Binning biases it both ways: bins hide what differs inside them, so that it is at most the distance of the laws
    themselves; and n independent orientations from the law itself lie Σ √(P(1 - P)/(2πn)) away on average, about
    √(bins/(2πn)), more where they are autocorrelated. It depends on the origin, since the bins do; a rotation of
    sample and law together by whole bins changes nothing.

    >>> float(total_variation([0.5, 1.0, 2.0, 3.0], lambda theta: np.full_like(theta, 0.5 / np.pi), bins=2))
    0.5
    """
    given = law_or_sample(law)
    if not isinstance(given, CircularLaw):
        pooled = pooled_samples(sample, given)
        return pooled.total_variation(pooled.first, bins)[()]
    angles = orientations("the sample", sample)
    rows = bin_index(angles, bins).reshape(-1, angles.shape[-1])
    flat = rows + bins * np.arange(len(rows))[:, None]
    shares = np.bincount(flat.ravel(), minlength=len(rows) * bins).reshape(-1, bins) / rows.shape[1]
    found = 0.5 * np.sum(np.abs(shares - given.bin_probabilities(bins)), axis=1)
    return np.asarray(found).reshape(angles.shape[:-1])[()]
