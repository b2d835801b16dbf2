"""Checks of what callers pass in: each returns the clean value or raises InvalidInput that names it."""

from __future__ import annotations

from numbers import Integral
from typing import Any

import numpy as np
import numpy.typing as npt

from cyclemap.errors import InvalidInput

Array = npt.NDArray[np.float64]
TWO_PI = 2.0 * np.pi
_ROUNDING = 1e-13  # radians beyond an arc's end that still count as its end


def finite_float(value: Any, name: str) -> float:
    """``value`` as a finite float."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise InvalidInput(f"{name} is {value!r}: give one real number") from None
    if not np.isfinite(number):
        raise InvalidInput(f"{name} is {number}: give a finite number")
    return number


def positive_float(value: Any, name: str) -> float:
    """``value`` as a finite float above zero."""
    number = finite_float(value, name)
    if number <= 0.0:
        raise InvalidInput(f"{name} is {number:g}: it must be above zero")
    return number


def whole_number(value: Any, name: str, least: int | None = None) -> int:
    """``value`` as an int, at least ``least``."""
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise InvalidInput(f"{name} is {value!r}: give a whole number")
    if least is not None and value < least:
        raise InvalidInput(f"{name} is {value}: it must be at least {least}")
    return int(value)


def finite_array(value: Any, name: str, ndim: int | None = None) -> Array:
    """``value`` as a float array without NaN or infinity, of ``ndim`` axes where that is given."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidInput(f"{name} is not an array of real numbers") from None
    if ndim is not None and array.ndim != ndim:
        raise InvalidInput(f"{name} has shape {array.shape}: give {ndim} axis" + "es" * (ndim > 1))
    if not np.all(np.isfinite(array)):
        where = int(np.flatnonzero(~np.isfinite(array.ravel()))[0])
        raise InvalidInput(f"{name} holds {array.ravel()[where]} at entry {where}: give finite numbers")
    return array


def arc_ends(arc: Any, name: str, whole: bool = False) -> tuple[float, float]:
    """An arc (start, end), counter-clockwise, as floats with start < end; length in (0, 2π), or (0, 2π]."""
    ends = finite_array(arc, name)
    if ends.shape != (2,):
        raise InvalidInput(f"{name} is {arc!r}: give a pair (start, end) in radians")
    start, end = float(ends[0]), float(ends[1])
    if -TWO_PI < end - start < 0.0:
        end += TWO_PI
    length = end - start
    if not (0.0 < length < TWO_PI or (whole and length <= TWO_PI * (1 + 1e-15) and length > 0.0)):
        raise InvalidInput(f"{name} is ({ends[0]:g}, {ends[1]:g}): its length must lie between 0 and 2π radians")
    return start, end


def into_arc(theta: float, arc: tuple[float, float]) -> float | None:
    """The representative of ``theta`` (mod 2π) inside the closed arc, or None."""
    inside = arc[0] + float(np.mod(theta - arc[0], TWO_PI))
    if inside - TWO_PI > arc[0] - _ROUNDING:
        return arc[0]
    return min(inside, arc[1]) if inside <= arc[1] + _ROUNDING else None


def read_only(array: Array) -> Array:
    """A copy of ``array`` that refuses writing."""
    copy = np.array(array, dtype=np.float64)
    copy.setflags(write=False)
    return copy
