"""Support points that carry the pressure of a patch, where a simulation needs points: weighted grids and a rim."""

import math

import numpy as np

from cyclemap.arrays import Array
from cyclemap.errors import InvalidInput
from cyclemap.mechanics.footprint import INNER, Footprint, PatchFootprint, PointFootprint, grid_footprint, side_arms
from cyclemap.mechanics.outline import Ellipse

# Loads up to this share of an even one count as none: rounding may leave them below zero.
_ROUNDING = 1e-9


def pressure_points(footprint: Footprint, count: int) -> PointFootprint:
    """Return support points that carry the load of a footprint: points as they are, a patch on `count` x `count`.

    The even part becomes the paper's grid (`grid_footprint`), weighted where it leans; the inner part that grid scaled
    to the inner outline; the rim about 4 `count` points along the outline, and the corners themselves. Then all are
    weighted with 1 + c . x so that the centre of pressure is the patch's to rounding.

    Raises InvalidInput where the weights that put the centre of pressure right would be negative: steep leans on
    coarse grids.

    >>> even, rimmed = PatchFootprint(Ellipse(1.0, 1.0)), PatchFootprint(Ellipse(1.0, 1.0), rim_share=0.5)
    >>> len(pressure_points(even, 8).positions), len(pressure_points(rimmed, 8).positions)
    (52, 84)
    """
    if isinstance(footprint, PointFootprint):
        return footprint
    even = grid_footprint(footprint.outline, count)
    if footprint.even_share == 1.0 and footprint.gradient == (0.0, 0.0):
        return even
    grid, centroid = even.quadrature[0], np.array(footprint.outline.centroid)
    lean = (grid - centroid) @ np.array(footprint.gradient)
    points, loads = [grid], [(footprint.even_share + lean) / len(grid)]
    if footprint.inner_share:
        points.append(centroid + INNER * (grid - centroid))
        loads.append(np.full(len(grid), footprint.inner_share / len(grid)))
    if footprint.rim_share:
        around, shares = _rim_points(footprint, 4 * count)
        points.append(around)
        loads.append(footprint.rim_share * shares)
    if footprint.corner_share and not isinstance(footprint.outline, Ellipse):
        points.append(footprint.outline.array)
        loads.append(np.full(footprint.outline.sides, footprint.corner_share / footprint.outline.sides))
    return _about(footprint.centre, np.concatenate(points), np.concatenate(loads))


def _rim_points(footprint: PatchFootprint, count: int) -> tuple[Array, Array]:
    """Points (k, 2), m, along the outline, and the shares (k,) of the rim's load that belong to them."""
    outline = footprint.outline
    if isinstance(outline, Ellipse):
        angle = 2.0 * math.pi * (np.arange(count) + 0.5) / count
        around = np.stack([outline.semi_x * np.cos(angle), outline.semi_y * np.sin(angle)], axis=-1)
        return around, np.full(count, 1.0 / count)
    start, arms = outline.array, side_arms(outline)
    end = np.roll(start, -1, axis=0)
    length = np.hypot(*(end - start).T)
    points, shares = [], []
    for a, b, share, number in zip(start, end, arms / arms.sum(), np.rint(count * length / length.sum()), strict=True):
        pieces = max(int(number), 1)
        points.append(a + ((np.arange(pieces) + 0.5) / pieces)[:, None] * (b - a))
        shares.append(np.full(pieces, share / pieces))
    return np.concatenate(points), np.concatenate(shares)


def _about(centre: tuple[float, float], points: Array, loads: Array) -> PointFootprint:
    """Return the points with their loads weighted so that the centre of pressure is `centre`."""
    loads = np.where(np.abs(loads) < _ROUNDING / len(loads), 0.0, loads)
    mean = loads @ points / loads.sum()
    lever = points - mean
    lean = np.linalg.solve((loads[:, None] * lever).T @ lever / loads.sum(), np.subtract(centre, mean))
    weights = loads * (1.0 + lever @ lean)
    if weights.min() < 0.0:
        raise InvalidInput(
            f"this footprint's pressure cannot be carried by support points (least load {weights.min():.3g}): set the "
            "footprint to points, such as grid:8 or a CSV file"
        )
    return PointFootprint(tuple(map(tuple, points.tolist())), tuple(weights.tolist()))
