"""Distances between laws on the circle from the values of their difference on an even grid."""

from __future__ import annotations

from typing import Any

import numpy as np

from cyclemap.maps.arcs import TWO_PI, Array

_SAFETY = 2.0  # halving the grid changes an integral by more than its error; doubled where it is not yet regular


def total_variation_on_grid(difference: Array) -> tuple[Array, Array]:
    """½ ∫ |p - q| dθ and a measured bound on its error, from p - q per radian at θ_j = 2πj/n, j < n, n even.

    difference : shape (..., n). Linear between grid points and cut where it changes sign: an error of O(n⁻³) a sign
    change for smooth densities, on top of the trapezoidal rule's. The bound is twice the change from half the grid.

    >>> grid = 2 * np.pi * np.arange(64) / 64
    >>> found, bound = total_variation_on_grid(np.cos(grid) / (2 * np.pi))
    >>> bool(abs(found - 1 / np.pi) <= bound < 0.003)
    True
    """
    return _with_half(_half_absolute, difference)


def wasserstein_on_grid(cumulative: Array) -> tuple[Array, Array]:
    """∫ |G - median G| dθ and a measured bound on its error: W1 on the circle, radians, for G the difference of the
    distribution functions at θ_j = 2πj/n (Rabin, Delon & Gousseau 2011); shape (..., n), n even, from any origin.

    >>> grid = 2 * np.pi * np.arange(64) / 64
    >>> found, bound = wasserstein_on_grid(np.sin(grid) / (2 * np.pi))
    >>> bool(abs(found - 2 / np.pi) <= bound < 0.01)
    True
    """
    return _with_half(_spread, cumulative)


def density_on_grid(moments: Any, count: int) -> Array:
    """Values per radian at θ_j = 2πj/count of the density with moments E e^{imθ}, m = 0, 1, ...: (..., count)."""
    return np.asarray(np.fft.irfft(np.conj(moments), count, axis=-1) * (count / TWO_PI))


def cumulative_on_grid(moments: Any, count: int) -> Array:
    """The integral of a difference of densities, up to a constant, from its moments (the first is 0): (..., count)."""
    orders = np.arange(np.shape(moments)[-1])
    integrated = np.conj(moments) / (1j * np.maximum(orders, 1))
    integrated[..., 0] = 0.0
    return np.asarray(np.fft.irfft(integrated, count, axis=-1) * (count / TWO_PI))


def _with_half(measure: Any, values: Array) -> tuple[Array, Array]:
    found = measure(values)
    return found, _SAFETY * np.abs(found - measure(values[..., ::2]))


def _half_absolute(values: Array) -> Array:
    near = np.abs(values)
    ahead = np.roll(near, -1, axis=-1)
    total = near + ahead
    opposite = values * np.roll(values, -1, axis=-1) < 0.0
    cut = np.divide(near**2 + ahead**2, total, out=np.zeros_like(total), where=opposite)
    return np.asarray(0.5 * np.pi / values.shape[-1] * np.sum(np.where(opposite, cut, total), axis=-1))


def _spread(values: Array) -> Array:
    level = np.median(values, axis=-1, keepdims=True)
    return np.asarray(TWO_PI * np.mean(np.abs(values - level), axis=-1))
