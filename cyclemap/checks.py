"""Checks shared by every room: a value is returned as a float, or refused by name."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.errors import InvalidInput


def finite_number(name: str, value: object) -> float:
    """Return `value` as a float, or raise InvalidInput if it is not one finite number.

    >>> finite_number("radius", "0.5")
    Traceback (most recent call last):
    ...
    cyclemap.errors.InvalidInput: radius must be a finite number, not '0.5'
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise InvalidInput(f"{name} must be a finite number, not {value!r}")
    if not math.isfinite(value):
        raise InvalidInput(f"{name} must be a finite number, not {value!r}")
    return float(value)


def positive_number(name: str, value: object) -> float:
    """Return `value` as a float above zero, or raise InvalidInput."""
    number = finite_number(name, value)
    if number <= 0.0:
        raise InvalidInput(f"{name} must be positive, not {value!r}")
    return number


def non_negative_number(name: str, value: object) -> float:
    """Return `value` as a float of zero or more, or raise InvalidInput."""
    number = finite_number(name, value)
    if number < 0.0:
        raise InvalidInput(f"{name} must not be negative, not {value!r}")
    return number


def point(name: str, value: ArrayLike) -> tuple[float, float]:
    """Return `value` as a pair of finite floats, or raise InvalidInput."""
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError) as cause:
        raise InvalidInput(f"{name} must be two finite numbers, not {value!r}") from cause
    if array.shape != (2,) or not np.all(np.isfinite(array)):
        raise InvalidInput(f"{name} must be two finite numbers, not {value!r}")
    return float(array[0]), float(array[1])


def finite_array(name: str, value: ArrayLike, last: int | None = None) -> NDArray[np.float64]:
    """Return `value` as a finite float array (last axis of length `last`, if given), or raise InvalidInput."""
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError) as cause:
        raise InvalidInput(f"{name} must hold numbers only: {cause}") from cause
    if last is not None and array.shape[-1:] != (last,):
        raise InvalidInput(f"{name} must have shape (..., {last}), not {array.shape}")
    if not np.all(np.isfinite(array)):
        raise InvalidInput(f"{name} holds a value that is not finite")
    return array
