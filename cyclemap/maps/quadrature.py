"""Nodes and weights on the circle or an arc for integrands h(F(θ)) p(θ) of limited bandwidth.

``bandwidth`` is the M beyond which the Fourier coefficients of h and p are negligible. Where F' = s the
product then carries frequencies up to M·√(1 + s²) (Gaussian coefficients; heavier ones need less), which
sets the nodes' density.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import read_only
from cyclemap.errors import ConvergenceError
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.lift_checks import SNAP
from cyclemap.maps.lifts.scan import bracketed_root, monotone_cells

MAX_NODES = 400_000
_PANELS = 8  # panels a turn at least, where the map is given by formulas
_GRADES = 2.0 ** -np.arange(0.0, 46.0)  # panels halve towards a fold, where ln|F'| is singular
_GRADED_ORDER = 18  # enough for ln x on [h, 2h] to rounding
_FOLD_RESOLUTION = 512
_SMALL_SLOPE = 0.2  # of its mean: |F'| below that makes ln|F'| nearly singular
_PROBES = np.append(np.append(1e-9, np.arange(1.0, 16.0) / 16.0), 1.0 - 1e-9)


def circle_rule(circle_map: CircleMap, bandwidth: float, finer: int = 1) -> tuple[Array, Array]:
    """Nodes and weights over one turn; ``finer`` times as many nodes as needed.

    The trapezoidal rule for maps given by formulas without breaks (geometric convergence for analytic F:
    Trefethen & Weideman 2014), else ``arc_rule``.
    """
    if circle_map.breaks.size or circle_map.pieces is not None:
        return arc_rule(circle_map, 0.0, TWO_PI, bandwidth, finer)
    grid = TWO_PI * np.arange(1024) / 1024
    steepest = float(np.max(np.abs(circle_map.derivative(grid))))
    if steepest > 8.0:
        return arc_rule(circle_map, 0.0, TWO_PI, bandwidth, finer)
    count = finer * int(np.ceil(1.1 * bandwidth * np.hypot(1.0, steepest) + 48.0))
    return TWO_PI * np.arange(count) / count, np.full(count, TWO_PI / count)


def arc_rule(
    circle_map: CircleMap,
    start: float,
    end: float,
    bandwidth: float,
    finer: int = 1,
    every_sample: bool = True,
) -> tuple[Array, Array]:
    """Gauss-Legendre panels on [start, end]: none crosses a break, each order fits its phase.

    With ``every_sample`` none crosses a sample of a sampled map either, where F'' jumps; without, far
    fewer nodes.
    """
    return _on_panels(circle_map, _edges(circle_map, start, end, every_sample), bandwidth, finer)


def _on_panels(
    circle_map: CircleMap, edges: Array, bandwidth: float, finer: int, least: int = 3
) -> tuple[Array, Array]:
    """Gauss-Legendre nodes on the panels between ``edges``, each cut and its order set to fit its phase."""
    inner = edges[:-1, None] + np.diff(edges)[:, None] * _PROBES
    steepest = np.max(np.abs(circle_map.derivative(inner)), axis=1)
    phase = 0.5 * bandwidth * np.hypot(1.0, steepest) * np.diff(edges)
    parts = np.maximum(1, np.ceil(phase / 60.0)).astype(np.int64)
    # Of panels alone there may be more than fit into memory.
    if int(parts.sum()) > MAX_NODES:
        raise ConvergenceError(_too_many(int(parts.sum())))
    width = np.repeat(np.diff(edges) / parts, parts)
    left = np.repeat(edges[:-1], parts)
    left = left + (np.arange(width.size) - np.repeat(np.cumsum(parts) - parts, parts)) * width
    phase = np.repeat(phase / parts, parts)
    order = finer * np.maximum(least, np.ceil(0.5 * (phase + 8.0 * np.cbrt(phase) + 6.0)).astype(np.int64))
    if int(order.sum()) > MAX_NODES:
        raise ConvergenceError(_too_many(int(order.sum())))
    nodes, weights, place = [], [], []
    for points in np.unique(order):
        use = order == points
        x, w = gauss_rule(left[use], width[use], int(points))
        nodes.append(x)
        weights.append(w)
        place.append(np.repeat(np.flatnonzero(use), points))
    owner = np.argsort(np.concatenate(place), kind="stable")
    return np.concatenate(nodes)[owner], np.concatenate(weights)[owner]


def _too_many(count: int) -> str:
    told = f"the map needs {count} quadrature nodes, more than {MAX_NODES}"
    return f"{told}: it is too steep for so small a noise; raise the noise"


def _edges(circle_map: CircleMap, start: float, end: float, every_sample: bool) -> Array:
    """Panel edges: the ends, every break between them, and the samples there or a plain grid."""
    if circle_map.pieces is not None and every_sample:
        marks = np.union1d(circle_map.pieces.knots[:-1], circle_map.breaks)
    else:
        marks = np.union1d(TWO_PI * np.arange(_PANELS) / _PANELS, circle_map.breaks)
    lap = np.floor(start / TWO_PI)
    around = np.concatenate([marks + TWO_PI * (lap + k) for k in (0, 1, 2)])
    around = around[(around > start + SNAP) & (around < end - SNAP)]
    return np.concatenate([[start], around, [end]])


def graded_rule(circle_map: CircleMap, bandwidth: float, finer: int = 1) -> tuple[Array, Array]:
    """Nodes and weights over one turn on panels that shrink towards each (near) zero of F' from both sides.

    For integrands with a logarithm of |F'|, singular where F' = 0, times a density of that bandwidth.
    """
    centres = _near_critical(circle_map)
    if centres.size == 0:
        return arc_rule(circle_map, 0.0, TWO_PI, bandwidth, finer)
    # Panel ends about each centre, at distances that halve.
    ahead = np.append(centres[1:], centres[0] + TWO_PI)
    reach = 0.5 * np.minimum(ahead - centres, 1.0)[:, None] * _GRADES
    reach = np.column_stack([np.zeros(centres.size), reach])
    marks = np.union1d(centres[:, None] + reach, ahead[:, None] - reach)
    plain = _edges(circle_map, float(centres[0]), float(centres[0]) + TWO_PI, True)
    return _on_panels(circle_map, np.union1d(marks, plain), bandwidth, finer, _GRADED_ORDER)


def _near_critical(circle_map: CircleMap) -> Array:
    """Folds, and where |F'| comes near 0 without passing through it: at its small minima and beside breaks."""
    cells = monotone_cells(circle_map, 1, 0.0, _FOLD_RESOLUTION)
    after, before = np.abs(cells.slope_start), np.abs(np.roll(cells.slope_end, 1))
    small = np.minimum(after, before) < _SMALL_SLOPE * np.mean(after)
    low = small & ~cells.cut & (after <= np.roll(after, 1)) & (after <= np.roll(after, -1))
    low &= cells.slope_start != 0.0
    folds = np.unique(cells.start[(cells.slope_start == 0.0) & ~cells.cut])
    reach, h = TWO_PI / _FOLD_RESOLUTION, 1e-3

    def curvature(theta: Array) -> Array:
        slope = circle_map.derivative
        return 8.0 * (slope(theta + h) - slope(theta - h)) - (slope(theta + 2 * h) - slope(theta - 2 * h))

    # The minima of |F'| next to the low cells: roots of its difference of fourth order, else their starts.
    minima = cells.start[low]
    bracketed = curvature(minima - reach) * curvature(minima + reach) < 0.0
    if np.any(bracketed):
        near = minima[bracketed]
        minima[bracketed] = bracketed_root(lambda x, _: curvature(x), near - reach, near + reach)
    found = np.concatenate([folds, cells.start[small & cells.cut], minima])
    found = np.sort(np.mod(found, TWO_PI))
    return np.asarray(found[np.append(True, np.diff(found) > 1e-9)]) if found.size else found


def gauss_rule(left: Array, width: Array, points: int) -> tuple[Array, Array]:
    """Gauss-Legendre nodes and weights, ``points`` of them on each panel [left, left + width], panel by panel."""
    x, w = _gauss(points)
    return (left[:, None] + width[:, None] * (0.5 + 0.5 * x)).ravel(), (0.5 * width[:, None] * w).ravel()


@lru_cache(maxsize=256)
def _gauss(points: int) -> tuple[Array, Array]:
    x, w = np.polynomial.legendre.leggauss(points)
    return read_only(x), read_only(w)
