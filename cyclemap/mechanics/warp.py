"""Warp: the saddles of pressure that a slightly twisted underside puts on the frame of a footprint."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.area_quadrature import area_quadrature
from cyclemap.mechanics.outline import Outline


@dataclass(frozen=True, eq=False)
class Saddle:
    """A saddle of the lever x from the centroid: constant + slope . x + x^T bend x, `bend` (2, 2) being traceless.

    It is harmonic, so that it is least on the edges of any region.
    """

    constant: float
    slope: NDArray[np.float64]
    bend: NDArray[np.float64]

    def at(self, lever: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the values (...) at levers (..., 2), m."""
        return np.asarray(self.constant + lever @ self.slope + ((lever @ self.bend) * lever).sum(axis=-1))


def saddles(outline: Outline, inner: Outline) -> tuple[Saddle, Saddle]:
    """Return (x^2 - y^2)/R^2 and 2 x y/R^2, less their projections on 1, x, y over the frame between two outlines.

    R is the outline's extent, `inner` the outline scaled about its centroid. So neither has a load or a moment.
    """
    bends = (np.diag((1.0, -1.0)), np.array(((0.0, 1.0), (1.0, 0.0))))
    first, second = (_without_load(outline, inner, bend / outline.extent**2) for bend in bends)
    return first, second


def least_along(polyline: NDArray[np.float64], saddle: Saddle) -> float:
    """Return the least value of a saddle along a polyline of levers (k, 2): exact, a parabola on each side."""
    start, end = saddle.at(polyline[:-1]), saddle.at(polyline[1:])
    middle = saddle.at((polyline[:-1] + polyline[1:]) / 2.0)
    bend, slope = 2.0 * (start + end - 2.0 * middle), 4.0 * middle - 3.0 * start - end
    # Where the parabola opens downwards, or its foot is outside, one of the ends is the least.
    foot = np.clip(-slope / np.where(bend > 0.0, 2.0 * bend, np.inf), 0.0, 1.0)
    return float(np.min([start, end, start + foot * (slope + foot * bend)]))


def _without_load(outline: Outline, inner: Outline, bend: NDArray[np.float64]) -> Saddle:
    points, weights = area_quadrature(outline)
    inside, lighter = area_quadrature(inner)
    lever = np.concatenate([points, inside]) - outline.centroid
    frame = np.concatenate([weights, -lighter * inner.area / outline.area])
    size = outline.extent
    modes = np.column_stack([np.ones(len(lever)), lever / size])
    values = ((lever @ bend) * lever).sum(axis=1)
    constant, *slope = np.linalg.solve(modes.T @ (frame[:, None] * modes), modes.T @ (frame * values))
    return Saddle(-float(constant), -np.array(slope) / size, bend)
