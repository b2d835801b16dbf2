"""Outlines of sliders in their own frame: simple polygons and ellipses."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import finite_array, positive_number
from cyclemap.errors import InvalidInput


@dataclass(frozen=True)
class Polygon:
    """A simple polygon, convex or not; its vertices (k, 2) in m, counter-clockwise: side i begins at vertex i.

    Raises InvalidInput for fewer than three vertices, repeated vertices, zero area, crossing sides, or vertices that
    run clockwise: turned round, their sides would bear other numbers.

    >>> Polygon([(0, 0), (2, 0), (2, 1), (0, 1)]).area
    2.0
    """

    vertices: tuple[tuple[float, float], ...]

    def __post_init__(self) -> None:
        points = finite_array("polygon vertices", self.vertices, last=2)
        if points.ndim != 2 or len(points) < 3:
            raise InvalidInput(f"a polygon needs at least three vertices (k, 2), not shape {points.shape}")
        _refuse_crossing(points)
        if _signed_area(points) < 0.0:
            raise InvalidInput(
                "the polygon's vertices run clockwise: list them counter-clockwise, and count its sides in that order"
            )
        object.__setattr__(self, "vertices", tuple(map(tuple, points.tolist())))

    @cached_property
    def array(self) -> NDArray[np.float64]:
        """The vertices as an array (k, 2), m."""
        return np.array(self.vertices)

    @cached_property
    def area(self) -> float:
        """Area, m^2."""
        return _signed_area(self.array)

    @cached_property
    def centroid(self) -> tuple[float, float]:
        """Centre of area, m."""
        origin = self.array[0]
        p = self.array - origin
        q = np.roll(p, -1, axis=0)
        x, y = ((p + q) * _cross(p, q)[:, None]).sum(axis=0) / (6.0 * self.area) + origin
        return float(x), float(y)

    @cached_property
    def is_convex(self) -> bool:
        """Whether every corner turns left."""
        edge = np.roll(self.array, -1, axis=0) - self.array
        return bool(np.all(_cross(edge, np.roll(edge, -1, axis=0)) >= 0.0))

    @property
    def sides(self) -> int:
        """Number of sides; side i runs from vertex i to vertex i + 1."""
        return len(self.vertices)

    @cached_property
    def extent(self) -> float:
        """Largest distance of the outline from its centroid, m."""
        return float(np.hypot(*(self.array - self.centroid).T).max())

    def scaled(self, factor: float) -> "Polygon":
        """Return the polygon with every coordinate times `factor`."""
        return Polygon(tuple(map(tuple, (factor * self.array).tolist())))

    def shrunk(self, factor: float) -> "Polygon":
        """Return the polygon scaled about its centroid."""
        centre = np.array(self.centroid)
        return Polygon(tuple(map(tuple, (centre + factor * (self.array - centre)).tolist())))

    def encloses(self, other: "Polygon") -> bool:
        """Whether another polygon lies inside, touching no side."""
        sides, others = _sides(self.array), _sides(other.array)
        apart = not any(_segments_meet(*side, *another) for side in sides for another in others)
        return apart and bool(self.contains(other.array).all())

    def points(self, count: int) -> NDArray[np.float64]:
        """Return the closed outline as a polyline (k + 1, 2), m; a polygon needs no more than its corners."""
        return np.vstack([self.array, self.array[:1]])

    def contains(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether points (..., 2) lie inside (even-odd rule)."""
        a, b = self.array, np.roll(self.array, -1, axis=0)
        x, y = points[..., 0, None], points[..., 1, None]
        straddles = (a[:, 1] > y) != (b[:, 1] > y)
        rise = np.where(b[:, 1] == a[:, 1], 1.0, b[:, 1] - a[:, 1])
        return np.asarray((straddles & (x < a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / rise)).sum(-1) % 2 == 1)

    def distance(self, point: tuple[float, float]) -> float:
        """Return the distance (m) of a point from the outline."""
        a = self.array
        edge = np.roll(a, -1, axis=0) - a
        offset = np.asarray(point) - a
        t = np.clip((offset * edge).sum(1) / (edge * edge).sum(1), 0.0, 1.0)
        return float(np.hypot(*(offset - t[:, None] * edge).T).min())


@dataclass(frozen=True)
class Ellipse:
    """An ellipse about the frame's origin, semi-axes along x and y, m; a disc when they agree.

    >>> round(Ellipse(1.0, 2.0).area / math.pi, 12)
    2.0
    """

    semi_x: float
    semi_y: float

    def __post_init__(self) -> None:
        positive_number("ellipse semi_x", self.semi_x)
        positive_number("ellipse semi_y", self.semi_y)

    @property
    def area(self) -> float:
        """Area, m^2."""
        return math.pi * self.semi_x * self.semi_y

    @property
    def centroid(self) -> tuple[float, float]:
        """Centre of area, m."""
        return 0.0, 0.0

    @property
    def is_convex(self) -> bool:
        """An ellipse always is."""
        return True

    @property
    def sides(self) -> int:
        """Number of sides: the whole outline is side 0."""
        return 1

    @property
    def extent(self) -> float:
        """Largest distance of the outline from its centroid, m."""
        return max(self.semi_x, self.semi_y)

    def scaled(self, factor: float) -> "Ellipse":
        """Return the ellipse with both semi-axes times `factor`."""
        return Ellipse(factor * self.semi_x, factor * self.semi_y)

    def shrunk(self, factor: float) -> "Ellipse":
        """Return the ellipse scaled about its centroid."""
        return self.scaled(factor)

    def points(self, count: int) -> NDArray[np.float64]:
        """Return the closed outline as a polyline (count + 1, 2), m."""
        angle = np.linspace(0.0, 2.0 * np.pi, count + 1)
        return np.stack([self.semi_x * np.cos(angle), self.semi_y * np.sin(angle)], axis=-1)

    def contains(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether points (..., 2) lie inside."""
        return np.asarray(np.hypot(points[..., 0] / self.semi_x, points[..., 1] / self.semi_y) < 1.0)


Outline = Polygon | Ellipse


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _signed_area(points: NDArray[np.float64]) -> float:
    shifted = points - points[0]
    return float(0.5 * _cross(shifted, np.roll(shifted, -1, axis=0)).sum())


def _refuse_crossing(points: NDArray[np.float64]) -> None:
    size = float(np.ptp(points, axis=0).max())
    edge = np.roll(points, -1, axis=0) - points
    short = np.flatnonzero(np.hypot(*edge.T) <= 1e-9 * size)
    if size == 0.0 or short.size:
        raise InvalidInput(f"polygon vertices {short.tolist()} coincide with the next one: leave one of each out")
    across = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[-1]
    if across <= 1e-9 * size:
        raise InvalidInput("the polygon has no area: its vertices lie on a line")
    for i in range(len(points)):
        for j in range(i + 1, len(points)):
            if _sides_touch(points, i, j):
                raise InvalidInput(f"the polygon's sides {i} and {j} cross or touch: order the vertices around it")


def _sides_touch(points: NDArray[np.float64], i: int, j: int) -> bool:
    """Whether two sides meet anywhere but in the corner that neighbours share."""
    k = len(points)
    a, b, c, d = points[i], points[(i + 1) % k], points[j], points[(j + 1) % k]
    if (i + 1) % k == j:
        return bool(_cross(b - a, d - c) == 0.0 and np.dot(b - a, d - c) < 0.0)
    if (j + 1) % k == i:
        return bool(_cross(d - c, b - a) == 0.0 and np.dot(d - c, b - a) < 0.0)
    return _segments_meet(a, b, c, d)


def _sides(points: NDArray[np.float64]) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    return list(zip(points, np.roll(points, -1, axis=0), strict=True))


def _segments_meet(
    a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64], d: NDArray[np.float64]
) -> bool:
    """Whether the segments a-b and c-d have a point in common."""
    sides = [_cross(b - a, c - a), _cross(b - a, d - a), _cross(d - c, a - c), _cross(d - c, b - c)]
    if sides[0] * sides[1] < 0.0 and sides[2] * sides[3] < 0.0:
        return True
    boxed = np.all(np.minimum(a, b) <= np.maximum(c, d)) and np.all(np.minimum(c, d) <= np.maximum(a, b))
    return bool(boxed and sides[0] * sides[1] <= 0.0 and sides[2] * sides[3] <= 0.0)
