"""Measured orientations against a predicted noisy cycle map: distances, p-values, modes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cyclemap.arrays import TWO_PI, Array, shorter_way
from cyclemap.checks import positive_number, read_only
from cyclemap.errors import InvalidInput
from cyclemap.evidence.orientations.circular_distance import DEFAULT_BINS, orientations
from cyclemap.evidence.orientations.collection_null import Refit, chain_p_values, checked_path, orientation_statistics
from cyclemap.evidence.orientations.goodness_of_fit import PValue
from cyclemap.maps import CircleMap, Noise, TransferOperator, transfer_operator
from cyclemap.maps.operator.transfer_operator import peaks_of

DEFAULT_BANDWIDTH = 0.1  # rad, about 6 degrees

_LEAST_RISE = 0.1 / TWO_PI  # a tenth of the uniform density
_REACH = 8.5  # bandwidth times harmonics, beyond which the kernel's coefficients are below 1e-15
_NARROWEST = 0.002
_EIGENVALUES = 25  # 1 and the 24 slowest


def kernel_modes(theta: Any, bandwidth: float = DEFAULT_BANDWIDTH) -> Array:
    """Angles in [0, 2π) of the maxima of a wrapped normal kernel estimate of the density, sorted, shape (k,).

    theta : shape (n,), radians, any turn. bandwidth : radians, the kernel's standard deviation, 0.002 to π.
    The estimate is a finite Fourier series, exactly: p = 1/2π + (1/π) Σ e^(-h²k²/2) Re(c_k* e^(ikθ)), c_k the mean of
    e^(ikθ). Maxima that rise less than a tenth of the uniform density above the dips beside them are left out.

    >>> kernel_modes([1.0, 1.0, 4.0]).round(6).tolist()
    [1.0, 4.0]
    """
    angles = orientations("theta", theta, single=True)
    width = positive_number("bandwidth", bandwidth)
    if not _NARROWEST <= width <= np.pi:
        raise InvalidInput(f"bandwidth is {width:g} rad: give one between {_NARROWEST} and π")
    order = np.arange(1, int(np.ceil(_REACH / width)) + 1)
    moments = np.array([np.mean(np.exp(1j * k * angles)) for k in order])
    weights = np.exp(-0.5 * np.square(width * order)) * moments.conj() / np.pi

    def slope(at: Array) -> Array:
        return np.real(np.exp(1j * np.multiply.outer(at, order)) @ (1j * order * weights))

    count = 1 << int(np.ceil(np.log2(8 * order.size)))
    grid = TWO_PI * np.arange(count) / count
    values = 1.0 / TWO_PI + np.real(np.exp(1j * np.multiply.outer(grid, order)) @ weights)
    return peaks_of(slope, grid, values, _LEAST_RISE)


def nearest_modes(targets: Array, modes: Array) -> Array:
    """Of each target angle the nearest of ``modes`` round the circle, shape of ``targets``; nan without modes."""
    if modes.size == 0:
        return np.full(np.shape(targets), np.nan)
    apart = np.abs(shorter_way(modes - np.asarray(targets)[..., None]))
    return np.asarray(modes[np.argmin(apart, axis=-1)])


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
        peak_offsets=read_only(shorter_way(nearest - peaks)),
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
