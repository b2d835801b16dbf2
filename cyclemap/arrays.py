"""Arrays of numbers, and angles on the circle:
the types and the constant that every room shares."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
# A point of the plane, m.
Place = tuple[float, float]
TWO_PI = 2.0 * np.pi


def shorter_way(angle: npt.ArrayLike) -> Array:
    """The same angles, radians, any shape, taken the shorter way round: in [-π, π).

    >>> round(float(shorter_way(1.75 * np.pi)) / np.pi, 12)
    -0.25
    """
    return np.asarray(np.mod(np.asarray(angle) + np.pi, TWO_PI) - np.pi)


def even_angles(count: int) -> Array:
    """Return so many angles, radians, evenly spread over the circle from 0.

    >>> (even_angles(4) / np.pi).tolist()
    [0.0, 0.5, 1.0, 1.5]
    """
    return np.asarray(TWO_PI * np.arange(count) / count)


def nodes_around(theta: Array, count: int) -> tuple[Whole, Whole, Array]:
    """Return the nodes before and after angles, radians, any shape, of so many that are evenly
    spread over the circle from 0, and the share of the way from the one to the other.

    >>> nodes_around(np.array([0.25, 3.75]) * np.pi, 4)
    (array([0, 3]), array([1, 0]), array([0.5, 0.5]))
    """
    place = np.mod(theta, TWO_PI) * (count / TWO_PI)
    before = np.minimum(place.astype(int), count - 1)
    return before, (before + 1) % count, place - before


def stretches(mask: Mask) -> list[tuple[int, int]]:
    """Return where each stretch begins in which a mask holds, and the place behind its end.

    >>> stretches(np.array([True, True, False, True]))
    [(0, 2), (3, 4)]
    """
    edges = np.flatnonzero(np.diff(mask.astype(np.int8), prepend=0, append=0))
    return [(first, end) for first, end in edges.reshape(-1, 2).tolist()]


def widest_gap(angles: Array) -> float:
    """Return the widest gap, rad, that angles (n,), n ≥ 1, rad, leave on the circle.

    >>> round(widest_gap(np.array([0.0, 1.0, 7.0])), 6)
    5.283185
    """
    places = np.sort(np.mod(angles, TWO_PI))
    return float(np.diff(places, append=places[0] + TWO_PI).max())


def evenly_spread(count: int, most: int) -> list[int]:
    """Return at most so many of the places 0, ..., count - 1, evenly spread.

    >>> evenly_spread(7, 3), evenly_spread(2, 3), evenly_spread(0, 3)
    ([0, 3, 6], [0, 1], [])
    """
    places: list[int] = np.linspace(0, count - 1, min(most, count)).round().astype(int).tolist()
    return places


def along_way(places: float | Array, way: Array, values: Array) -> Array:
    """Return the values (..., k) at places (...) of a way (n,), linear between the rows (n, k) that
    are known.

    >>> along_way(0.25, np.array([0.0, 1.0]), np.array([[0.0, 2.0], [4.0, 2.0]])).tolist()
    [1.0, 2.0]
    """
    return np.stack([np.interp(places, way, column) for column in values.T], axis=-1)


def turned(points: Array, angle: float | Array) -> Array:
    """Return points (..., 2) turned about the origin by an angle (...), rad.

    >>> turned(np.array([2.0, 0.0]), np.pi / 2).round(9).tolist()
    [0.0, 2.0]
    """
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y = points[..., 0], points[..., 1]
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)


def placed(pose: Array, points: Array) -> Array:
    """Return `points` (..., 2) of the object's frame, in the world, for the pose (x, y, θ)."""
    return np.stack([pose[0], pose[1]], axis=-1) + turned(points, pose[2])
