"""The Fourier columns that every periodic law is a sum of."""

from __future__ import annotations

from typing import Any

import numpy as np

from cyclemap.arrays import Array


def fourier_columns(theta: Any, harmonics: int) -> Array:
    """The columns 1, cos θ, sin θ, cos 2θ, sin 2θ, ...: shape (..., 2·harmonics + 1) for θ (...) in radians.

    The first 2k + 1 columns are those of k harmonics, so laws of different orders are nested.

    >>> fourier_columns(0.0, 2).tolist()
    [1.0, 1.0, 0.0, 1.0, 0.0]
    """
    return _columns(theta, harmonics, lambda angle, _: np.cos(angle), lambda angle, _: np.sin(angle), 1.0)


def fourier_slopes(theta: Any, harmonics: int) -> Array:
    """The derivatives of ``fourier_columns`` by θ, of the same shape.

    >>> fourier_slopes(0.0, 2).tolist()
    [0.0, -0.0, 1.0, -0.0, 2.0]
    """
    return _columns(theta, harmonics, lambda angle, k: -k * np.sin(angle), lambda angle, k: k * np.cos(angle), 0.0)


def _columns(theta: Any, harmonics: int, even: Any, odd: Any, constant: float) -> Array:
    angles = np.asarray(theta, dtype=np.float64)
    order = np.arange(1, harmonics + 1)
    multiples = np.multiply.outer(angles, order)
    made = np.empty((*angles.shape, 2 * harmonics + 1))
    made[..., 0] = constant
    made[..., 1::2] = even(multiples, order)
    made[..., 2::2] = odd(multiples, order)
    return made
