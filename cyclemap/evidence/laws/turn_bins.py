"""Sums of measured pairs and orientations: arcs covered, medians by bin, histogram, distance from a
map.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, Mask, Whole
from cyclemap.checks import finite_array, require_room, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs
from cyclemap.written import ANGLE

# Measured orientations further apart than this leave a gap: laws of cycles may do anything within
# 20 degrees.
GAP = float(np.radians(20.0))
# What lies this near an end of an arc is taken with it.
_EDGE = float(np.radians(1.0))
DEFAULT_BINS, _MOST_BINS = 72, 1_000_000


def covered_arcs(measured: ArrayLike) -> tuple[tuple[float, float], ...]:
    """The arcs from the first to the last of orientations (n,), n ≥ 1, rad, that lie no further
    apart than ``GAP``.

    Each is (from, to), from in [0, 2π), to no less; in order of from. The whole circle is (0, 2π).

    >>> [(round(low, 9), round(high, 9)) for low, high in covered_arcs([6.1, 6.3, 0.2, 3.0])]
    [(3.0, 3.0), (6.1, 6.483185307)]
    """
    places = np.sort(np.mod(finite_array("measured", measured, ndim=1), TWO_PI))
    ends = np.flatnonzero(np.diff(places, append=places[0] + TWO_PI) > GAP)
    if not ends.size:
        return ((0.0, TWO_PI),)
    low = places[(np.roll(ends, 1) + 1) % places.size]
    high = places[ends]
    high = np.where(high >= low, high, high + TWO_PI)
    return tuple(sorted(zip(low.tolist(), high.tolist(), strict=True)))


def is_covered(measured: ArrayLike, theta: ArrayLike) -> Mask:
    """Whether each of ``theta`` (...), rad, lies within 1 degree of a covered arc of ``measured``
    (n,), n ≥ 1, rad.
    """
    angles = finite_array("theta", theta)
    inside = [
        np.mod(angles - low + _EDGE, TWO_PI) <= high - low + 2 * _EDGE
        for low, high in covered_arcs(measured)
    ]
    return np.asarray(np.any(inside, axis=0))


@dataclass(frozen=True, eq=False)
class TurnBins:
    """Median turns in equal bins of θ0 that hold three pairs or more.

    Attributes
    ----------
    centre : ndarray, shape (k,)
        Centres of the bins, rad in [0, 2π).
    median : ndarray, shape (k,)
        Median turns, rad.
    count : ndarray of int, shape (k,)
        How many pairs each holds.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import Theta0Pairs, turn_bins
    >>> theta = np.linspace(0.0, 6.2, 12)
    >>> turn_bins(Theta0Pairs(theta, theta + 0.3), bins=3).count.tolist()
    [4, 4, 4]
    """

    centre: Array
    median: Array
    count: Whole


@dataclass(frozen=True, eq=False)
class AngleHistogram:
    """How often each direction was recorded.

    Attributes
    ----------
    edges : ndarray, shape (k + 1,)
        Ends of the bins, rad over [0, 2π].
    density : ndarray, shape (k,)
        Per rad.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import angle_histogram
    >>> histogram = angle_histogram(np.array([0.1, 0.2, 3.3, 6.2]), bins=2)
    >>> round(float(np.sum(histogram.density * np.diff(histogram.edges))), 9)
    1.0
    """

    edges: Array
    density: Array


@dataclass(frozen=True)
class MapAgreement:
    """How far measured turns lie from a map's.

    Attributes
    ----------
    pairs : int
        How many pairs.
    rms : float
        Root mean square over the pairs, rad.
    bins : int
        How many bins of θ0.
    bin_rms : float
        Root mean square over the bins' medians, rad.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import Theta0Pairs, measured_overlay
    >>> theta = np.linspace(0.0, 6.2, 12)
    >>> agreement = measured_overlay(Theta0Pairs(theta, theta + 0.3), lambda theta: 0.2).agreement
    >>> agreement.pairs, round(agreement.rms, 6)
    (12, 0.1)
    """

    pairs: int
    rms: float = field(metadata=ANGLE)
    bins: int
    bin_rms: float = field(metadata=ANGLE)


def root_mean_square(values: Array) -> float:
    """The root mean square of values (n,); NaN without any."""
    return float(np.sqrt(np.mean(values**2))) if values.size else math.nan


def turn_bins(pairs: Theta0Pairs, bins: int = DEFAULT_BINS) -> TurnBins:
    """Return the median turn of pairs in equal bins of θ0 over [0, 2π).

    Parameters
    ----------
    pairs : Theta0Pairs
        Measured steps of the cycle map.
    bins : int, optional
        How many bins.

    Returns
    -------
    TurnBins
        Those that hold three pairs or more.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import Theta0Pairs, turn_bins
    >>> theta = np.linspace(0.0, 6.2, 12)
    >>> turn_bins(Theta0Pairs(theta, theta + 0.3), bins=3).median.round(6).tolist()
    [0.3, 0.3, 0.3]
    """
    index = bin_index(pairs.theta, bins)
    count = np.bincount(index, minlength=bins)
    filled = np.flatnonzero(count >= 3)
    median = np.array([np.median(pairs.turn[index == k]) for k in filled])
    return TurnBins((filled + 0.5) * TWO_PI / bins, median, count[filled])


def angle_histogram(theta: Array, bins: int = DEFAULT_BINS) -> AngleHistogram:
    """Return the probability density of directions in equal bins over [0, 2π).

    Parameters
    ----------
    theta : ndarray, shape (n,)
        Directions, rad, any turn.
    bins : int, optional
        How many bins.

    Returns
    -------
    AngleHistogram
        Ends of the bins, and density per rad.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import angle_histogram
    >>> angle_histogram(np.array([0.1, 0.2, 3.3, 6.2]), bins=2).density * np.pi
    array([0.5, 0.5])
    """
    if theta.size == 0:
        raise InvalidInput("no direction to make a histogram of; give at least one")
    density = bin_shares(theta, bins) * (bins / TWO_PI)
    return AngleHistogram(np.linspace(0.0, TWO_PI, bins + 1), density)


def bin_shares(theta: Array, bins: int) -> Array:
    """The shares (..., bins) of angles (..., n), rad, any turn, in equal bins over [0, 2π)."""
    cells = bin_index(theta, bins)
    counts = np.apply_along_axis(np.bincount, -1, cells, minlength=bins)
    return np.asarray(counts / cells.shape[-1])


def bin_index(theta: Array, bins: int) -> Whole:
    """Which of ``bins`` equal bins over [0, 2π) each angle (rad, any turn) lies in; InvalidInput
    for fewer than one.
    """
    count = whole_number("bins", bins, least=1)
    require_room("bins", count, "so many hold no counts: use fewer", _MOST_BINS)
    # An angle a hair below 0 wraps to exactly 2π and would fall past the last bin.
    return np.minimum((np.mod(theta, TWO_PI) * (count / TWO_PI)).astype(np.int64), count - 1)


@dataclass(frozen=True, eq=False)
class MeasuredOverlay:
    """Measured pairs over a map.

    Attributes
    ----------
    pairs : Theta0Pairs
        The measured steps.
    bins : TurnBins
        Their medians by direction.
    histogram : AngleHistogram
        How often each direction was recorded.
    agreement : MapAgreement
        Their distance from the map.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import Theta0Pairs, measured_overlay
    >>> theta = np.linspace(0.0, 6.2, 12)
    >>> overlay = measured_overlay(Theta0Pairs(theta, theta + 0.3), lambda theta: 0.3)
    >>> round(overlay.agreement.rms, 9), overlay.pairs.theta.size
    (0.0, 12)
    """

    pairs: Theta0Pairs
    bins: TurnBins
    histogram: AngleHistogram
    agreement: MapAgreement


def measured_overlay(pairs: Theta0Pairs, turn: Callable[[Array], Array]) -> MeasuredOverlay:
    """Summarise measured pairs against a map.

    Parameters
    ----------
    pairs : Theta0Pairs
        Measured steps of the cycle map.
    turn : callable
        θ (n,) rad -> what the map turns it by, (n,) rad.

    Returns
    -------
    MeasuredOverlay
        Medians, histogram, and distance from the map.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import Theta0Pairs, measured_overlay
    >>> theta = np.linspace(0.0, 6.2, 12)
    >>> pairs = Theta0Pairs(theta, theta + 0.3 + 0.1 * np.sin(theta))
    >>> round(measured_overlay(pairs, lambda theta: 0.3 + 0.1 * np.sin(theta)).agreement.rms, 9)
    0.0
    """
    bins = turn_bins(pairs)
    rms = root_mean_square(pairs.turn - turn(pairs.theta))
    bin_rms = root_mean_square(bins.median - turn(bins.centre))
    agreement = MapAgreement(pairs.theta.size, rms, bins.centre.size, bin_rms)
    return MeasuredOverlay(pairs, bins, angle_histogram(pairs.theta), agreement)
