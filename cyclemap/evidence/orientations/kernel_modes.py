"""Modes of measured orientations."""

from __future__ import annotations

from typing import Any

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import positive_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.orientations.circular_distance import orientations
from cyclemap.maps.operator.transfer_operator import peaks_of

DEFAULT_BANDWIDTH = 0.1  # rad, about 6 degrees

_LEAST_RISE = 0.1 / TWO_PI  # a tenth of the uniform density
_REACH = 8.5  # bandwidth times harmonics, beyond which the kernel's coefficients are below 1e-15
_NARROWEST = 0.002


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
