"""Outlines of sliders in their own frame: simple polygons and ellipses, and the mean over the area inside."""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
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
    def array(self) -> Array:
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
        sides, others = (list(zip(one.array, np.roll(one.array, -1, axis=0), strict=True)) for one in (self, other))
        apart = not any(_segments_meet(*side, *another) for side in sides for another in others)
        return apart and bool(self.contains(other.array).all())

    def points(self, count: int) -> Array:
        """Return the closed outline as a polyline (k + 1, 2), m; a polygon needs no more than its corners."""
        return np.vstack([self.array, self.array[:1]])

    def contains(self, points: Array) -> NDArray[np.bool_]:
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

    def points(self, count: int) -> Array:
        """Return the closed outline as a polyline (count + 1, 2), m."""
        angle = np.linspace(0.0, 2.0 * np.pi, count + 1)
        return np.stack([self.semi_x * np.cos(angle), self.semi_y * np.sin(angle)], axis=-1)

    def contains(self, points: Array) -> NDArray[np.bool_]:
        """Whether points (..., 2) lie inside."""
        return np.asarray(np.hypot(points[..., 0] / self.semi_x, points[..., 1] / self.semi_y) < 1.0)

    def distance(self, point: tuple[float, float]) -> float:
        """Return the distance (m) of a point from the outline."""
        from scipy.optimize import brentq

        (x, y), a, b = point, self.semi_x, self.semi_y

        def slope(angle: float) -> float:
            c, s = math.cos(angle), math.sin(angle)
            return float((a * c - x) * -a * s + (b * s - y) * b * c)

        def distance(angle: float) -> float:
            return math.hypot(a * math.cos(angle) - x, b * math.sin(angle) - y)

        # The nearest place lies in the point's own quadrant, where the slope changes sign once.
        low = math.floor(math.atan2(y, x) / (math.pi / 2.0)) * math.pi / 2.0
        high = low + math.pi / 2.0
        if slope(low) * slope(high) < 0.0:
            return distance(float(brentq(slope, low, high, xtol=1e-15, rtol=1e-14)))
        return min(distance(low), distance(high))


Outline = Polygon | Ellipse


def area_quadrature(outline: Outline, order: int = 6) -> tuple[Array, Array]:
    """Return points (k, 2) and weights (k,) of the mean over an outline, exact up to degree 2 order - 2."""
    if isinstance(outline, Ellipse):
        # Gauss in the squared radius, equal angles around.
        count = 2 * order + 4
        node, weight = np.polynomial.legendre.leggauss(order + 2)
        radius, angle = np.meshgrid(
            np.sqrt((node + 1.0) / 2.0), np.arange(count) * 2.0 * math.pi / count, indexing="ij"
        )
        places = np.stack([outline.semi_x * radius * np.cos(angle), outline.semi_y * radius * np.sin(angle)], axis=-1)
        return places.reshape(-1, 2), np.repeat(weight / 2.0 / count, count)
    # Collapsed Gauss rules on the signed fan of triangles from vertex 0 (two weights may differ in sign).
    node, weight = np.polynomial.legendre.leggauss(order)
    s, t = np.meshgrid((node + 1.0) / 2.0, (node + 1.0) / 2.0, indexing="ij")
    share = np.outer(weight, weight) / 4.0 * s
    apex, points, weights = outline.array[0], [], []
    for a, b in zip(outline.array[1:-1], outline.array[2:], strict=True):
        e, f = a - apex, b - apex
        points.append(apex + s[..., None] * e + (s * t)[..., None] * (f - e))
        weights.append(share * (e[0] * f[1] - e[1] * f[0]) / outline.area)
    return np.concatenate([p.reshape(-1, 2) for p in points]), np.concatenate([w.ravel() for w in weights])


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _signed_area(points: Array) -> float:
    shifted = points - points[0]
    return float(0.5 * _cross(shifted, np.roll(shifted, -1, axis=0)).sum())


def _refuse_crossing(points: Array) -> None:
    size = float(np.ptp(points, axis=0).max())
    after = np.roll(points, -1, axis=0)
    edge = after - points
    short = np.flatnonzero(np.hypot(*edge.T) <= 1e-9 * size)
    if size == 0.0 or short.size:
        raise InvalidInput(f"polygon vertices {short.tolist()} coincide with the next one: leave one of each out")
    if np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[-1] <= 1e-9 * size:
        raise InvalidInput("the polygon has no area: its vertices lie on a line")
    k = len(points)
    for i, j in combinations(range(k), 2):
        if (j - i) % k in (1, k - 1):
            # Neighbours share a corner: they may not run back along each other.
            first, second = (edge[i], edge[j]) if j == i + 1 else (edge[j], edge[i])
            meet = _cross(first, second) == 0.0 and first @ second < 0.0
        else:
            meet = _segments_meet(points[i], after[i], points[j], after[j])
        if meet:
            raise InvalidInput(f"the polygon's sides {i} and {j} cross or touch: order the vertices around it")


def _segments_meet(a: Array, b: Array, c: Array, d: Array) -> bool:
    """Whether the segments a-b and c-d have a point in common."""
    sides = [_cross(b - a, c - a), _cross(b - a, d - a), _cross(d - c, a - c), _cross(d - c, b - c)]
    if sides[0] * sides[1] < 0.0 and sides[2] * sides[3] < 0.0:
        return True
    boxed = np.all(np.minimum(a, b) <= np.maximum(c, d)) and np.all(np.minimum(c, d) <= np.maximum(a, b))
    return bool(boxed and sides[0] * sides[1] <= 0.0 and sides[2] * sides[3] <= 0.0)
