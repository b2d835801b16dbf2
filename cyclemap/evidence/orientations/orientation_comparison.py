"""Measured orientations against a predicted noisy cycle map, everything in one value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import read_only
from cyclemap.evidence.orientations.chain_null import Refit, chain_p_values, checked_path, orientation_statistics
from cyclemap.evidence.orientations.circular_distance import DEFAULT_BINS
from cyclemap.evidence.orientations.orientation_modes import (
    DEFAULT_BANDWIDTH,
    angle_between,
    kernel_modes,
    nearest_modes,
)
from cyclemap.evidence.orientations.p_value import PValue
from cyclemap.maps import CircleMap, Noise, TransferOperator, transfer_operator

_EIGENVALUES = 25  # 1 and the 24 slowest


@dataclass(frozen=True, eq=False)
class OrientationComparison:
    """How a path of orientations agrees with the stationary law of a noisy map.

    count : orientations. effective_count : independent ones that would fix the least known mode of the law as well,
        at most ``count``: see the function of that name.
    wasserstein, total_variation, kuiper, watson : the distances (``.statistic``; W1 in radians) with p-values under
        the simulated chain.
    predicted_peaks : (k,) rad in [0, 2π), maxima of the stationary density. nearest_modes : (k,) rad, the measured
        mode nearest to each, nan where there is none. peak_offsets : (k,) rad in [-π, π), measured less predicted.
    measured_modes : (m,) rad in [0, 2π), all maxima of the kernel estimate.
    refitted : whether the parameters were fitted again on every simulated path.
    """

    count: int
    effective_count: float
    wasserstein: PValue
    total_variation: PValue
    kuiper: PValue
    watson: PValue
    predicted_peaks: Array
    nearest_modes: Array
    peak_offsets: Array
    measured_modes: Array
    refitted: bool


def compare_orientations(
    theta: Any,
    circle_map: CircleMap,
    noise: Noise,
    *,
    bins: int = DEFAULT_BINS,
    bandwidth: float = DEFAULT_BANDWIDTH,
    runs: int = 200,
    seed: int = 0,
    refit: Refit | None = None,
) -> OrientationComparison:
    """Set a measured path of orientations (n,), radians, in order, against a map and its noise.

    bins : of the total variation. bandwidth : radians, of the kernel estimate whose maxima are the measured modes.
    runs, seed, refit, errors : as for ``chain_p_value``; all four p-values rest on the same simulated paths.

    The test is of the stationary law and the chain together: a path shorter than the map takes to mix is compared
    with simulated paths that are as short.

    >>> from cyclemap.maps import WrappedNormal, sample_staircase
    >>> model = CircleMap.arnold(0.05, 0.6), WrappedNormal(0.2)
    >>> found = compare_orientations(sample_staircase(*model, 300).theta, *model, runs=99)
    >>> found.count, found.predicted_peaks.size, found.watson.value > 0.05, bool(abs(found.peak_offsets[0]) < 0.2)
    (301, 1, True, True)
    """
    path = checked_path(theta)
    operator = transfer_operator(circle_map, noise)
    modes = kernel_modes(path, bandwidth)
    options: dict[str, Any] = {"runs": runs, "seed": seed, "refit": refit, "operator": operator}
    tested = chain_p_values(path, circle_map, noise, orientation_statistics(bins), **options)
    peaks = operator.peaks()
    nearest = nearest_modes(peaks, modes)
    return OrientationComparison(
        count=path.size,
        effective_count=effective_count(path.size, operator),
        predicted_peaks=read_only(peaks),
        nearest_modes=read_only(nearest),
        peak_offsets=read_only(angle_between(peaks, nearest)),
        measured_modes=read_only(modes),
        refitted=refit is not None,
        **tested,
    )


def effective_count(count: int, operator: TransferOperator) -> float:
    """Independent orientations that would tell as much as ``count`` of the chain, about its least known mode.

    n / max (1 - |λ|²)/|1 - λ|² over the operator's 24 leading eigenvalues but 1. That quotient, Re (1 + λ)/(1 - λ), is
    the integrated autocorrelation time of the eigenfunction of λ: as n → ∞ the variance of its mean over a stationary
    path is that of as many independent values (Sokal 1997). Other functions may be known better or worse.

    >>> from cyclemap.maps import WrappedCauchy
    >>> round(effective_count(300, transfer_operator(CircleMap.rigid(0.0), WrappedCauchy(0.5))), 9)
    100.0
    """
    values = operator.eigenvalues(_EIGENVALUES)[1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        times = (1.0 - np.abs(values) ** 2) / np.abs(1.0 - values) ** 2
    # A mode without memory, λ = 0, takes 1, and there always is one further down; λ = 1 again never settles.
    return count / float(np.max(np.nan_to_num(times, nan=np.inf), initial=1.0))
