"""Arrays of numbers, and angles on the circle:
the types and the constant that every room shares."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
TWO_PI = 2.0 * np.pi


def shorter_way(angle: Any) -> Array:
    """The same angles, radians, any shape, taken the shorter way round: in [-π, π).

    >>> round(float(shorter_way(1.75 * np.pi)) / np.pi, 12)
    -0.25
    """
    return np.asarray(np.mod(np.asarray(angle) + np.pi, TWO_PI) - np.pi)
