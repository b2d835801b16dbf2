"""Measured (θ0, next θ0) pairs summed up: arcs covered, medians by bin, histogram, distance from a map."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import finite_array, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs

# Measured orientations further apart than this leave a gap: laws of cycles may do anything within 20 degrees.
GAP = float(np.radians(20.0))
# What lies this near an end of an arc is taken with it.
_EDGE = float(np.radians(1.0))
DEFAULT_BINS = 72


def covered_arcs(measured: ArrayLike) -> tuple[tuple[float, float], ...]:
    """The arcs from the first to the last of orientations (n,), n ≥ 1, rad, that lie no further apart than ``GAP``.

    Each is (from, to), from in [0, 2π), to no less; in order of from. The whole circle is (0, 2π).

    >>> [(round(low, 9), round(high, 9)) for low, high in covered_arcs([6.1, 6.3, 0.2, 3.0])]
    [(3.0, 3.0), (6.1, 6.483185307)]
    """
    places = np.sort(np.mod(finite_array("measured", measured, ndim=1), TWO_PI))
    gaps = np.append(np.diff(places), places[0] + TWO_PI - places[-1])
    ends = np.flatnonzero(gaps > GAP)
    if not ends.size:
        return ((0.0, TWO_PI),)
    begins = np.roll((ends + 1) % places.size, 1)
    arcs = ((float(places[b]), float(places[e])) for b, e in zip(begins, ends, strict=True))
    return tuple(sorted((low, high if high >= low else high + TWO_PI) for low, high in arcs))


def is_covered(measured: ArrayLike, theta: ArrayLike) -> NDArray[np.bool_]:
    """Whether each of ``theta`` (...), rad, lies within 1 degree of a covered arc of ``measured`` (n,), n ≥ 1, rad."""
    angles = finite_array("theta", theta)
    inside = [np.mod(angles - low + _EDGE, TWO_PI) <= high - low + 2 * _EDGE for low, high in covered_arcs(measured)]
    return np.asarray(np.any(inside, axis=0))


@dataclass(frozen=True, eq=False)
class TurnBins:
    """The median turn in equal bins of θ0; only bins that hold at least three pairs are listed.

    centre : (k,) rad in [0, 2π). median : (k,) rad. count : (k,) pairs.
    """

    centre: Array
    median: Array
    count: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class AngleHistogram:
    """How often each direction was recorded. edges : (k + 1,) rad over [0, 2π]. density : (k,) per rad."""

    edges: Array
    density: Array


@dataclass(frozen=True)
class MapAgreement:
    """How far measured turns lie from a map's: root mean squares over pairs and over bin medians (rad)."""

    pairs: int
    rms: float
    bins: int
    bin_rms: float


def turn_bins(pairs: Theta0Pairs, bins: int = DEFAULT_BINS) -> TurnBins:
    """Median turn of the pairs in `bins` equal bins of θ0 over [0, 2π)."""
    index = bin_index(pairs.theta, bins)
    count = np.bincount(index, minlength=bins)
    filled = np.flatnonzero(count >= 3)
    median = np.array([np.median(pairs.turn[index == k]) for k in filled])
    return TurnBins((filled + 0.5) * TWO_PI / bins, median, count[filled])


def angle_histogram(theta: Array, bins: int = DEFAULT_BINS) -> AngleHistogram:
    """Probability density (per rad) of the directions `theta` (n,) rad in `bins` equal bins over [0, 2π).

    >>> angle_histogram(np.array([0.1, 0.2, 3.3, 6.2]), bins=2).density * np.pi
    array([0.5, 0.5])
    """
    if theta.size == 0:
        raise InvalidInput("no direction to make a histogram of; give at least one")
    count = np.bincount(bin_index(theta, bins), minlength=bins)
    return AngleHistogram(np.linspace(0.0, TWO_PI, bins + 1), count * (bins / TWO_PI) / theta.size)


def bin_index(theta: Array, bins: int) -> NDArray[np.int64]:
    """Which of ``bins`` equal bins over [0, 2π) each angle (rad, any turn) lies in; InvalidInput for fewer than one."""
    count = whole_number("bins", bins, least=1)
    if count > 1_000_000:
        raise InvalidInput(f"bins is {bins}: more than a million bins hold no counts; use fewer")
    # An angle a hair below 0 wraps to exactly 2π and would fall past the last bin.
    return np.minimum((np.mod(theta, TWO_PI) * (count / TWO_PI)).astype(np.int64), count - 1)


@dataclass(frozen=True, eq=False)
class MeasuredOverlay:
    """Measured pairs with their medians by direction, their histogram, and their distance from a map.

    The distance of the medians counts each bin once: rarely visited directions weigh as much as crowded ones.
    """

    pairs: Theta0Pairs
    bins: TurnBins
    histogram: AngleHistogram
    agreement: MapAgreement


def measured_overlay(pairs: Theta0Pairs, turn: Callable[[Array], Array]) -> MeasuredOverlay:
    """Summarise `pairs` against the map that turns θ (rad) by `turn(θ)` (rad)."""
    bins = turn_bins(pairs)
    off, bin_off = pairs.turn - turn(pairs.theta), bins.median - turn(bins.centre)
    rms, bin_rms = (float(np.sqrt(np.mean(one**2))) if one.size else np.nan for one in (off, bin_off))
    agreement = MapAgreement(pairs.theta.size, rms, bins.centre.size, bin_rms)
    return MeasuredOverlay(pairs, bins, angle_histogram(pairs.theta), agreement)
