"""Quadrature over the area inside an outline."""

import math

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.outline import Ellipse, Outline, Polygon

# Gauss points a direction where the centre of rotation is far: exact to rounding there (tests/mechanics).
FAR_ORDER = 6


def area_quadrature(outline: Outline, order: int = FAR_ORDER) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return points (k, 2) and weights (k,) of the mean over an outline, exact up to degree 2 order - 2."""
    return _ellipse_quadrature(outline, order) if isinstance(outline, Ellipse) else _polygon_quadrature(outline, order)


def _polygon_quadrature(polygon: Polygon, order: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Collapsed Gauss rules on the signed fan of triangles from vertex 0 (two weights may differ in sign)."""
    node, weight = np.polynomial.legendre.leggauss(order)
    s, t = np.meshgrid((node + 1.0) / 2.0, (node + 1.0) / 2.0, indexing="ij")
    share = np.outer(weight, weight) / 4.0 * s
    apex, points, weights = polygon.array[0], [], []
    for a, b in zip(polygon.array[1:-1], polygon.array[2:], strict=True):
        e, f = a - apex, b - apex
        points.append(apex + s[..., None] * e + (s * t)[..., None] * (f - e))
        weights.append(share * (e[0] * f[1] - e[1] * f[0]) / polygon.area)
    return np.concatenate([p.reshape(-1, 2) for p in points]), np.concatenate([w.ravel() for w in weights])


def _ellipse_quadrature(ellipse: Ellipse, order: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Gauss rule in the squared radius, equal angles around."""
    count = 2 * order + 4
    node, weight = np.polynomial.legendre.leggauss(order + 2)
    radius, angle = np.meshgrid(np.sqrt((node + 1.0) / 2.0), np.arange(count) * 2.0 * math.pi / count, indexing="ij")
    points = np.stack([ellipse.semi_x * radius * np.cos(angle), ellipse.semi_y * radius * np.sin(angle)], axis=-1)
    weights = np.repeat(weight / 2.0 / count, count)
    return points.reshape(-1, 2), weights
