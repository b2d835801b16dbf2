"""What is read off a density on the circle: its peaks, and its distance from the uniform one."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.orbits.bracketing import bracketed_root
from cyclemap.maps.quadrature import arc_rule

Density = Callable[[Array], Array]

_POINTS = 8  # grid points a basis function


def density_grid(density: Density, size: int) -> tuple[Array, Array]:
    """A uniform grid of at least eight points a basis function, and the density there."""
    count = 1 << int(np.ceil(np.log2(_POINTS * size)))
    grid = TWO_PI * np.arange(count) / count
    return grid, density(grid)


def peaks_of(slope: Density, grid: Array, values: Array, margin: float) -> Array:
    """Angles in [0, 2π) of the maxima that rise by ``margin`` above the minima beside them, sorted."""
    tops = _prominent(values, margin)
    step, at = grid[1], grid[tops]
    inside = slope(at - step) * slope(at + step) < 0.0
    if np.any(inside):
        at[inside] = bracketed_root(lambda x, _: slope(x), at[inside] - step, at[inside] + step)
    at = np.mod(at, TWO_PI)
    # A tiny negative angle rounds up to a whole turn.
    return np.sort(np.where(at >= TWO_PI, 0.0, at))


def _prominent(values: Array, margin: float) -> npt.NDArray[np.int64]:
    """Indices of local maxima on a periodic grid that rise by ``margin`` above the dips beside them."""
    before, after = np.roll(values, 1), np.roll(values, -1)
    tops = np.flatnonzero((values > before) & (values >= after) & (values > margin))
    while tops.size:
        spans = zip(tops, np.append(tops[1:], tops[0] + values.size), strict=True)
        lows = np.array([np.min(np.take(values, range(a, b + 1), mode="wrap")) for a, b in spans])
        height = values[tops] - np.maximum(lows, np.roll(lows, 1))
        least = int(np.argmin(height))
        if height[least] > margin:
            break
        tops = np.delete(tops, least)
    return tops


def distance_from_uniform(density: Density, circle_map: CircleMap, grid: Array, values: Array, size: int) -> float:
    """½ ∫ |p - 1/2π| dθ, cut where the density crosses the uniform one; ``values`` its values on ``grid``."""
    excess = values - 0.5 / np.pi
    crossing = grid[(excess < 0.0) != (np.roll(excess, -1) < 0.0)]
    if crossing.size == 0:
        return 0.0
    found = np.sort(bracketed_root(lambda x, _: density(x) - 0.5 / np.pi, crossing, crossing + grid[1]))
    ends = np.append(found, found[0] + TWO_PI)
    rules = [arc_rule(circle_map, a, b, size, every_sample=False) for a, b in pairwise(ends.tolist()) if b > a]
    parts = [abs(float(np.dot(weight, density(theta) - 0.5 / np.pi))) for theta, weight in rules]
    return 0.5 * float(np.sum(parts))
