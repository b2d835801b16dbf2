"""Arcs of the circle."""

from __future__ import annotations

from typing import Any

import numpy as np

from cyclemap.arrays import TWO_PI
from cyclemap.checks import finite_array, finite_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import ANGLE

Arc = tuple[float, float]


def arc_ends(arc: Any, name: str, whole: bool = False) -> tuple[float, float]:
    """An arc (start, end), counter-clockwise, as floats with start < end; length in (0, 2π), or (0, 2π]."""
    ends = finite_array(name, arc)
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
    if inside - TWO_PI > arc[0] - ANGLE:
        return arc[0]
    return min(inside, arc[1]) if inside <= arc[1] + ANGLE else None


def required_inside(start: float, ends: Arc) -> float:
    """``start``, moved by whole turns into the arc, or InvalidInput."""
    inside = into_arc(finite_number("start", start), ends)
    if inside is None:
        raise InvalidInput(f"start is {start:g}, outside the arc ({ends[0]:g}, {ends[1]:g}): start inside it")
    return inside


def arcs_between(a: Arc, b: Arc) -> tuple[Arc, ...]:
    """The arcs between two disjoint arcs (those of positive length), or InvalidInput."""
    begin = a[1] + float(np.mod(b[0] - a[1], TWO_PI))
    finish = begin + (b[1] - b[0])
    if begin > a[0] + TWO_PI or finish > a[0] + TWO_PI + 1e-14:
        raise InvalidInput(f"arc_a {a} and arc_b {b} overlap: give disjoint arcs")
    rest = [(a[1], begin), (finish, a[0] + TWO_PI)]
    return tuple(ends for ends in rest if ends[1] - ends[0] > 1e-14)
