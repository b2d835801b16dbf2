"""The Fourier series through values at equal distances around the circle."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import finite_array


def interpolation(theta: ArrayLike, count: int) -> Array:
    """Return the matrix (n, count) from values at 2 pi k / count to the Fourier series through them at theta (n,), rad.

    >>> nodes = 2 * np.pi * np.arange(5) / 5
    >>> bool(np.allclose(interpolation([0.3], 5) @ np.cos(2 * nodes), np.cos(0.6)))
    True
    """
    off, orders = _distances(theta, count)
    return np.asarray((1.0 + 2.0 * np.cos(off * orders).sum(axis=-1)) / count)


def interpolation_slope(theta: ArrayLike, count: int) -> Array:
    """Return the matrix (n, count) from values at 2 pi k / count to the slope of the series, per rad, at theta (n,)."""
    off, orders = _distances(theta, count)
    return np.asarray(-2.0 * (orders * np.sin(off * orders)).sum(axis=-1) / count)


def _distances(theta: ArrayLike, count: int) -> tuple[Array, Array]:
    """Angle of each theta from each node, (n, count, 1), and the orders (count - 1) / 2 of the series."""
    places = 2.0 * np.pi * np.arange(count) / count
    off = finite_array("theta", theta, ndim=1)[:, np.newaxis] - places
    return off[..., np.newaxis], np.arange(1, (count - 1) // 2 + 1, dtype=float)
