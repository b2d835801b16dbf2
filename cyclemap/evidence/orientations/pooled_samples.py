"""Two samples of orientations on one circle: the difference of their distribution functions, relabelled at will."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.orientations.circular_law import orientations

Labels = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class PooledSamples:
    """Two samples in one sorted list.

    angles : (k,) the distinct angles in [0, 2π), sorted. ties : (k,) how many of the pooled sample are at each.
    first : (n + m,) True where the sorted pooled angle is of the first sample. size : n, of the first sample.

    Everything asked of it takes ``labels`` (..., n + m): True for the n angles that count as the first sample, so
    that permutations go through together.
    """

    angles: Array
    ties: Array
    first: Labels
    size: int

    def differences(self, labels: Labels) -> Array:
        """F - G just after each distinct angle, shape (..., k); F of the labelled, G of the others."""
        last = np.cumsum(self.ties).astype(np.int64)
        labelled = np.cumsum(labels, axis=-1)[..., last - 1]
        return np.asarray(labelled / self.size - (last - labelled) / (self.first.size - self.size))

    def wasserstein(self, labels: Labels) -> Array:
        """∫ |F - G - median(F - G)| dθ, exactly (Rabin, Delon & Gousseau 2011), shape (...)."""
        gaps = np.diff(np.append(self.angles, self.angles[0] + TWO_PI))
        levels = self.differences(labels)
        order = np.argsort(levels, axis=-1)
        half = np.cumsum(gaps[order], axis=-1) >= np.pi
        at = np.take_along_axis(order, np.argmax(half, axis=-1)[..., None], axis=-1)
        return np.asarray(np.abs(levels - np.take_along_axis(levels, at, axis=-1)) @ gaps)

    def kuiper(self, labels: Labels) -> Array:
        """max(F - G) - min(F - G), shape (...)."""
        return np.asarray(np.ptp(self.differences(labels), axis=-1))

    def watson(self, labels: Labels) -> Array:
        """nm/N² Σ (d - mean d)² over the pooled sample, d = F - G (Watson 1962), shape (...)."""
        levels, total = self.differences(labels), self.first.size
        centred = levels - (levels @ self.ties)[..., None] / total
        return np.asarray(np.square(centred) @ self.ties * (self.size * (total - self.size) / total**2))

    def total_variation(self, labels: Labels, bins: int) -> Array:
        """½ Σ |share of the labelled - share of the others| over equal bins of [0, 2π), shape (...)."""
        place = bin_index(np.repeat(self.angles, self.ties.astype(np.int64)), bins)
        member = (place[:, None] == np.arange(bins)).astype(float)
        shares = labels / self.size - ~labels / (self.first.size - self.size)
        return np.asarray(0.5 * np.sum(np.abs(shares @ member), axis=-1))


def pooled_samples(first: Any, second: Any) -> PooledSamples:
    """Pool two samples (n,) and (m,) of orientations, radians, any turn.

    Raises InvalidInput where one is empty, not finite or not a list.

    >>> pooled = pooled_samples([0.0, 1.0], [1.0, 2.0])
    >>> pooled.differences(pooled.first).tolist()
    [0.5, 0.5, 0.0]
    """
    mine, other = orientations("the sample", first, single=True), orientations("the second sample", second, single=True)
    together = np.concatenate([mine, other])
    angles, ties = np.unique(together, return_counts=True)
    labels = np.argsort(together, kind="stable") < mine.size
    labels.setflags(write=False)
    return PooledSamples(read_only(angles), read_only(ties), labels, mine.size)


def bin_index(angles: Array, bins: int) -> NDArray[np.int64]:
    """Which of ``bins`` equal bins of [0, 2π) each angle in it lies in; InvalidInput for fewer than one bin."""
    count = whole_number("bins", bins, least=1)
    if count > 1_000_000:
        raise InvalidInput(f"bins is {bins}: more than a million bins hold no counts; use fewer")
    return np.minimum((angles * (count / TWO_PI)).astype(np.int64), count - 1)
