"""Outlines of sliders in their own frame: simple polygons and ellipses, and the mean over the area
inside.
"""

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.arrays import TWO_PI, Array, widest_gap
from cyclemap.checks import finite_array, point, positive_number, read_only
from cyclemap.errors import InvalidInput

# No object is smaller or larger than this, m: squares of its area soon leave the numbers there are.
_SMALLEST, _LARGEST = 1e-50, 1e50


@dataclass(frozen=True)
class Polygon:
    """A simple polygon, convex or not.

    Parameters
    ----------
    vertices : array_like, shape (k, 2)
        At least three corners, m, counter-clockwise: side i begins at vertex i.

    Attributes
    ----------
    array : ndarray, shape (k, 2)
        The vertices, m.
    area : float
        Of the inside, m^2.
    centroid : tuple[float, float]
        Centre of the area, (x, y), m.
    extent : float
        Largest distance of a vertex from the centroid, m.
    sides : int
        How many sides it has.
    is_convex : bool
        Whether it is convex.

    Raises
    ------
    InvalidInput
        For fewer than three vertices, repeated vertices, zero area, crossing sides, a size of no
        object, or vertices that run clockwise: turned round, their sides would bear other numbers.

    Examples
    --------
    >>> from cyclemap import Polygon
    >>> Polygon([(0, 0), (2, 0), (2, 1), (0, 1)]).area
    2.0
    """

    vertices: tuple[tuple[float, float], ...]
    array: Array = field(init=False, repr=False, compare=False)
    area: float = field(init=False, repr=False, compare=False)
    centroid: tuple[float, float] = field(init=False, repr=False, compare=False)
    extent: float = field(init=False, repr=False, compare=False)
    sides: int = field(init=False, repr=False, compare=False)
    is_convex: bool = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        points = np.array(finite_array("polygon vertices", self.vertices, last=2))
        if points.ndim != 2 or len(points) < 3:
            raise InvalidInput(
                f"a polygon needs at least three vertices (k, 2), not shape {points.shape}"
            )
        _require_size(float(np.ptp(points, axis=0).max()))
        _refuse_crossing(points)
        p, edge = points - points[0], np.roll(points, -1, axis=0) - points
        q = np.roll(p, -1, axis=0)
        area = float(0.5 * _cross(p, q).sum())
        if area < 0.0:
            raise InvalidInput(
                "the polygon's vertices run clockwise: list them counter-clockwise, and count its "
                "sides in that order"
            )
        x, y = ((p + q) * _cross(p, q)[:, None]).sum(axis=0) / (6.0 * area) + points[0]
        vars(self).update(
            vertices=tuple(map(tuple, points.tolist())),
            array=read_only(points),
            area=area,
            centroid=(float(x), float(y)),
            extent=float(np.hypot(*(points - (x, y)).T).max()),
            sides=len(points),
            is_convex=bool(np.all(_cross(edge, np.roll(edge, -1, axis=0)) >= 0.0)),
        )

    def scaled(self, factor: float, about: tuple[float, float] = (0.0, 0.0)) -> "Polygon":
        """Return the polygon with every coordinate, seen from a place, times `factor`."""
        return Polygon(
            tuple(map(tuple, (np.array(about) + factor * (self.array - about)).tolist()))
        )

    def bears(self, place: tuple[float, float]) -> bool:
        """Whether a load at a place rests on the polygon: whether it is inside the convex hull.

        >>> from cyclemap import Polygon
        >>> Polygon([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]).bears((1.2, 1.2))
        True
        """
        x, y = (self.array - place).T
        # From inside the hull the vertices are seen all around, without a gap of half a turn.
        return widest_gap(np.arctan2(y, x)) < np.pi

    def encloses(self, other: "Polygon") -> bool:
        """Whether another polygon lies inside, touching no side."""
        crosses = _sides_meet(self.array, other.array).any()
        return not crosses and bool(self.contains(other.array).all())

    def points(self, count: int) -> Array:
        """Return the closed outline as a polyline (k + 1, 2), m; a polygon needs no more than its
        corners.
        """
        return np.vstack([self.array, self.array[:1]])

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether points (..., 2) lie inside (even-odd rule)."""
        points = finite_array("points", points, last=2)
        a, b = self.array, np.roll(self.array, -1, axis=0)
        x, y = points[..., 0, None], points[..., 1, None]
        straddles = (a[:, 1] > y) != (b[:, 1] > y)
        rise = np.where(b[:, 1] == a[:, 1], 1.0, b[:, 1] - a[:, 1])
        return np.asarray(
            (straddles & (x < a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / rise)).sum(-1) % 2
            == 1
        )


@dataclass(frozen=True)
class Ellipse:
    """An ellipse about the frame's origin; a disc when both semi-axes agree.

    Parameters
    ----------
    semi_x : float
        Semi-axis along x, m, positive.
    semi_y : float
        Semi-axis along y, m, positive.

    Attributes
    ----------
    area : float
        Of the inside, m^2.
    extent : float
        The longer semi-axis, m.
    centroid : tuple[float, float]
        (0, 0), the frame's origin.
    sides : int
        1: the whole outline is side 0.
    is_convex : bool
        True.

    Raises
    ------
    InvalidInput
        For a semi-axis that is not positive, or as long as no object is.

    Examples
    --------
    >>> import math
    >>> from cyclemap import Ellipse
    >>> round(Ellipse(1.0, 2.0).area / math.pi, 12)
    2.0
    """

    semi_x: float
    semi_y: float
    area: float = field(init=False, repr=False, compare=False)
    extent: float = field(init=False, repr=False, compare=False)
    centroid: ClassVar[tuple[float, float]] = (0.0, 0.0)
    sides: ClassVar[int] = 1
    is_convex: ClassVar[bool] = True

    def __post_init__(self) -> None:
        a, b = (
            positive_number(f"ellipse {name}", getattr(self, name)) for name in ("semi_x", "semi_y")
        )
        for length in (a, b):
            _require_size(length)
        vars(self).update(area=math.pi * a * b, extent=max(a, b))

    def scaled(self, factor: float) -> "Ellipse":
        """Return the ellipse with both semi-axes times `factor`."""
        return Ellipse(factor * self.semi_x, factor * self.semi_y)

    def points(self, count: int) -> Array:
        """Return the closed outline as a polyline (count + 1, 2), m."""
        angle = np.linspace(0.0, TWO_PI, count + 1)
        return np.stack([self.semi_x * np.cos(angle), self.semi_y * np.sin(angle)], axis=-1)

    def bears(self, place: tuple[float, float]) -> bool:
        """Whether a load at a place rests on the ellipse: whether it is inside."""
        return bool(self.contains(place))

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether points (..., 2) lie inside."""
        points = finite_array("points", points, last=2)
        return np.asarray(
            np.hypot(points[..., 0] / self.semi_x, points[..., 1] / self.semi_y) < 1.0
        )


Outline = Polygon | Ellipse


def area_quadrature(outline: Polygon, order: int = 6) -> tuple[Array, Array]:
    """Return points (k, 2) and weights (k,) of the mean over an outline, exact up to degree 2 order
    - 2.
    """
    # Collapsed Gauss rules on the signed fan of triangles from vertex 0 (two weights may differ in
    # sign).
    node, weight = np.polynomial.legendre.leggauss(order)
    node, weight = (node + 1.0) / 2.0, weight / 2.0
    s, t = np.meshgrid(node, node, indexing="ij")
    share = np.outer(weight, weight) * s
    apex, points, weights = outline.array[0], [], []
    for a, b in zip(outline.array[1:-1], outline.array[2:], strict=True):
        e, f = a - apex, b - apex
        points.append(apex + s[..., None] * e + (s * t)[..., None] * (f - e))
        weights.append(share * (e[0] * f[1] - e[1] * f[0]) / outline.area)
    return np.concatenate([p.reshape(-1, 2) for p in points]), np.concatenate(
        [w.ravel() for w in weights]
    )


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def resting_centre(outline: Outline, centre: tuple[float, float] | None) -> tuple[float, float]:
    """Return an object's centre of mass, None: its outline's centroid; InvalidInput where the
    object would tip.
    """
    place = outline.centroid if centre is None else point("centre of mass", centre)
    if not outline.bears(place):
        raise InvalidInput(
            f"the centre of mass {place} m lies outside the outline's convex hull: the object "
            "would tip; give one inside"
        )
    return place


def _require_size(length: float) -> None:
    """Raise InvalidInput for a length (m) that no object has; that of points in one place is told
    elsewhere.
    """
    if length != 0.0 and not _SMALLEST <= length <= _LARGEST:
        raise InvalidInput(f"an outline of {length:.3g} m is that of no object: give it in metres")


def _refuse_crossing(points: Array) -> None:
    size = float(np.ptp(points, axis=0).max())
    edge = np.roll(points, -1, axis=0) - points
    short = np.flatnonzero(np.hypot(*edge.T) <= 1e-9 * size)
    if size == 0.0 or short.size:
        raise InvalidInput(
            f"polygon vertices {short.tolist()} coincide with the next one: leave one of each out"
        )
    if np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[-1] <= 1e-9 * size:
        raise InvalidInput("the polygon has no area: its vertices lie on a line")
    meet = np.triu(_sides_meet(points, points), 1)
    # Neighbours share a corner: they may not run back along each other.
    side, following = np.arange(len(points)), np.roll(edge, -1, axis=0)
    other = (side + 1) % len(points)
    back = (_cross(edge, following) == 0.0) & ((edge * following).sum(axis=1) < 0.0)
    meet[np.minimum(side, other), np.maximum(side, other)] = back
    for i, j in np.argwhere(meet)[:1].tolist():
        raise InvalidInput(
            f"the polygon's sides {i} and {j} cross or touch: order the vertices around it"
        )


def _sides_meet(first: Array, second: Array) -> NDArray[np.bool_]:
    """Whether sides of polygons, of vertices (k, 2) and (m, 2), have a point in common, (k, m)."""
    a, b = first[:, None], np.roll(first, -1, axis=0)[:, None]
    c, d = second, np.roll(second, -1, axis=0)
    across_ab = _cross(b - a, c - a) * _cross(b - a, d - a)
    across_cd = _cross(d - c, a - c) * _cross(d - c, b - c)
    boxed = np.all(
        (np.minimum(a, b) <= np.maximum(c, d)) & (np.minimum(c, d) <= np.maximum(a, b)), axis=-1
    )
    cross = (across_ab < 0.0) & (across_cd < 0.0)
    touch = boxed & (across_ab <= 0.0) & (across_cd <= 0.0)
    return np.asarray(cross | touch)


def nearest_on_polyline(points: Array, polyline: Array) -> tuple[Array, NDArray[np.intp]]:
    """Return the nearest point (n, 2) of a polyline (k, 2) to each of the points (n, 2), and the
    edge (n,) it is on.
    """
    first = polyline[:-1]
    edge = np.diff(polyline, axis=0)
    # An edge without length is a point.
    squares = np.maximum(np.sum(edge * edge, axis=-1), np.finfo(float).tiny)
    share = np.sum((points[:, None] - first) * edge, axis=-1) / squares
    on_edge = first + np.clip(share, 0.0, 1.0)[..., None] * edge
    nearest = np.argmin(np.sum((points[:, None] - on_edge) ** 2, axis=-1), axis=1)
    return on_edge[np.arange(len(points)), nearest], nearest
