"""Numbers as JSON takes them: finite or null, angles in degrees."""

import math
from collections.abc import Iterable

import numpy as np


def number(value: float | None) -> float | None:
    """Return the value, None where there is none or it is not finite.

    >>> number(1.5), number(math.inf), number(None)
    (1.5, None, None)
    """
    return float(value) if value is not None and math.isfinite(value) else None


def numbers(values: Iterable[float]) -> list[float | None]:
    """Return each value as `number` does."""
    return [number(value) for value in values]


def degrees(radians: float | None) -> float | None:
    """Return an angle in degrees."""
    return None if radians is None else number(math.degrees(radians))


def direction_deg(radians: float) -> float:
    """Return a direction in degrees in [0, 360); a hair below zero must not round to 360."""
    return float(np.degrees(radians) % 360.0) % 360.0
