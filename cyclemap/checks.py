"""Checks shared by every room: a value is returned as a float, or refused by name."""

import math
import reprlib
from numbers import Integral
from types import NoneType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.errors import InvalidInput

Values = TypeVar("Values", bound=NDArray[Any])

# Numbers that any one step may hold at once: 2 GB is the most that a command may take, and a step
# has copies of it.
MOST_NUMBERS = 2**25


def require_room(what: str, numbers: float, mend: str, most: float = MOST_NUMBERS) -> None:
    """Raise InvalidInput where `what` comes to more `numbers` (or steps) than `most`; `mend` says
    what to do.

    Every size that follows from a user's input is put through this before anything of that size is
    made.

    >>> require_room("the map's nodes", 6e8, "give more data")
    Traceback (most recent call last):
    ...
    cyclemap.errors.InvalidInput: the map's nodes: 6e+08, of at most 3.36e+07; give more data
    """
    if not numbers <= most:
        # Whole numbers may be beyond all floats.
        given = f"{numbers:.3g}" if numbers < 1e300 else "above 1e300"
        raise InvalidInput(f"{what}: {given}, of at most {most:.3g}; {mend}")


def require_kind(name: str, value: object, *kinds: type) -> None:
    """Raise InvalidInput where `value` is of none of these kinds.

    >>> require_kind("wear", 5, dict, type(None))
    Traceback (most recent call last):
    ...
    cyclemap.errors.InvalidInput: wear must be a dict or None, not 5
    """
    if not isinstance(value, kinds):
        known = " or ".join(map(_with_article, kinds))
        shown = " ".join(reprlib.repr(value).split())
        raise InvalidInput(f"{name} must be {known}, not {shown}")


def _with_article(kind: type) -> str:
    if kind is NoneType:
        return "None"
    article = "an" if kind.__name__[0] in "AEIOU" else "a"
    return f"{article} {kind.__name__}"


def finite_number(name: str, value: object) -> float:
    """Return `value` as a float, or raise InvalidInput if it is not one finite number.

    >>> finite_number("radius", "0.5")
    Traceback (most recent call last):
    ...
    cyclemap.errors.InvalidInput: radius must be a finite number, not '0.5'
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise InvalidInput(f"{name} must be a finite number, not {value!r}")
    try:
        checked = float(value)
    except OverflowError as cause:
        raise InvalidInput(f"{name} must be a finite number, not so large a whole one") from cause
    if not math.isfinite(checked):
        raise InvalidInput(f"{name} must be a finite number, not {value!r}")
    return checked


def positive_number(name: str, value: object) -> float:
    """Return `value` as a float above zero, or raise InvalidInput."""
    checked = finite_number(name, value)
    if checked <= 0.0:
        raise InvalidInput(f"{name} must be positive, not {value!r}")
    return checked


def non_negative_number(name: str, value: object) -> float:
    """Return `value` as a float of zero or more, or raise InvalidInput."""
    checked = finite_number(name, value)
    if checked < 0.0:
        raise InvalidInput(f"{name} must not be negative, not {value!r}")
    return checked


def point(name: str, value: ArrayLike) -> tuple[float, float]:
    """Return `value` as a pair of finite floats, or raise InvalidInput."""
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError) as cause:
        raise InvalidInput(f"{name} must be two finite numbers, not {value!r}") from cause
    if array.shape != (2,) or not np.all(np.isfinite(array)):
        raise InvalidInput(f"{name} must be two finite numbers, not {value!r}")
    return float(array[0]), float(array[1])


def whole_number(name: str, value: object, least: int | None = None) -> int:
    """Return `value` as an int, at least `least` if that is given, or raise InvalidInput."""
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise InvalidInput(f"{name} must be a whole number, not {value!r}")
    if least is not None and value < least:
        raise InvalidInput(f"{name} must be at least {least}, not {value!r}")
    return int(value)


# Kinds of arrays that numpy reads as numbers though they are none: text, bytes, dates, spans.
_NO_NUMBERS = "SUMm"


def float_array(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """Return `value` as a float array, or raise InvalidInput where it does not hold numbers."""
    try:
        given = np.asarray(value)
        if given.dtype.kind in _NO_NUMBERS:
            raise TypeError(f"it holds {given.dtype.name}")
        return np.asarray(given, dtype=float)
    except (TypeError, ValueError, OverflowError) as cause:
        raise InvalidInput(f"{name} must hold numbers only: {cause}") from cause


def finite_array(
    name: str, value: ArrayLike, last: int | None = None, ndim: int | None = None
) -> NDArray[np.float64]:
    """Return `value` as a finite float array, or raise InvalidInput.

    `last`: length of its last axis; `ndim`: number of its axes.
    """
    array = float_array(name, value)
    if last is not None and array.shape[-1:] != (last,):
        raise InvalidInput(f"{name} must have shape (..., {last}), not {array.shape}")
    if ndim is not None and array.ndim != ndim:
        raise InvalidInput(f"{name} must have {ndim} axes, not shape {array.shape}")
    if not np.all(np.isfinite(array)):
        entry = int(np.flatnonzero(~np.isfinite(array))[0])
        raise InvalidInput(f"{name} must be finite, but entry {entry} is {array.ravel()[entry]}")
    return array


def unwritable(array: Values) -> Values:
    """Return the same array, of numbers of any kind, which refuses writing from now on."""
    array.setflags(write=False)
    return array


def read_only(array: ArrayLike) -> NDArray[np.float64]:
    """Return a copy of an array that refuses writing."""
    copy = np.array(array, dtype=float)
    copy.setflags(write=False)
    return copy
