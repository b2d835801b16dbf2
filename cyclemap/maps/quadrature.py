"""Nodes and weights on the circle or an arc for integrands h(F(θ)) p(θ) of limited bandwidth.

``bandwidth`` is the M beyond which the Fourier coefficients of h and p are negligible. Where F' = s the
product then carries frequencies up to M·√(1 + s²) (Gaussian coefficients; heavier ones need less), which
sets the nodes' density.
"""

from __future__ import annotations

import numpy as np

from cyclemap.errors import ConvergenceError
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.circle_map import SNAP, CircleMap

MAX_NODES = 400_000
_PANELS = 8  # panels a turn at least, where the map is given by formulas
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
    edges = _edges(circle_map, start, end, every_sample)
    inner = edges[:-1, None] + np.diff(edges)[:, None] * _PROBES
    steepest = np.max(np.abs(circle_map.derivative(inner)), axis=1)
    phase = 0.5 * bandwidth * np.hypot(1.0, steepest) * np.diff(edges)
    parts = np.maximum(1, np.ceil(phase / 60.0)).astype(np.int64)
    left, width = _split(edges, parts)
    phase = np.repeat(phase / parts, parts)
    order = finer * np.ceil(0.5 * (phase + 8.0 * np.cbrt(phase) + 6.0)).astype(np.int64)
    if int(order.sum()) > MAX_NODES:
        raise ConvergenceError(
            f"the map needs {int(order.sum())} quadrature nodes, more than {MAX_NODES}: it is too steep "
            "for so small a noise; raise the noise"
        )
    return _gauss_panels(left, width, order)


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


def _split(edges: Array, parts: np.typing.NDArray[np.int64]) -> tuple[Array, Array]:
    width = np.repeat(np.diff(edges) / parts, parts)
    rank = np.arange(width.size) - np.repeat(np.cumsum(parts) - parts, parts)
    return np.repeat(edges[:-1], parts) + rank * width, width


def _gauss_panels(left: Array, width: Array, order: np.typing.NDArray[np.int64]) -> tuple[Array, Array]:
    nodes, weights, place = [], [], []
    for points in np.unique(order):
        use = order == points
        x, w = np.polynomial.legendre.leggauss(int(points))
        nodes.append((left[use, None] + width[use, None] * (0.5 + 0.5 * x)).ravel())
        weights.append((0.5 * width[use, None] * w).ravel())
        place.append(np.repeat(np.flatnonzero(use), points))
    owner = np.argsort(np.concatenate(place), kind="stable")
    return np.concatenate(nodes)[owner], np.concatenate(weights)[owner]
