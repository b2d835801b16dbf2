"""Nodes and weights on an arc, or the circle, for integrands h(F(θ)) p(θ) of limited bandwidth.

``bandwidth`` is the M beyond which the Fourier coefficients of h and p are negligible. Where F' = s
the product then carries frequencies up to M·√(1 + s²) (Gaussian coefficients; heavier ones need
less), which sets the nodes' density.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

from cyclemap.arrays import TWO_PI, Array, Mask, Whole, even_angles
from cyclemap.checks import read_only
from cyclemap.errors import ConvergenceError
from cyclemap.maps.estimate import LIFT
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.lift_checks import SNAP
from cyclemap.maps.lifts.scan import ranks

Rule = tuple[Array, Array]  # nodes and their weights

MAX_NODES = 400_000
_PANELS = 8  # panels a turn at least, where the map is given by formulas
_SHORTEST = 1e-12  # radians: panels are not cut below this
_PASSES = 64
_POINTS = (
    16  # nodes a panel at least, where the map is given by formulas: as many as show what F is like
)
_LEAST = 10  # nodes a panel there: enough for F times waves of θ that hardly turn on it
_TAIL = 3  # last coefficients of a panel that must be small
_RESOLVED = 1e-12  # radians: F's own last coefficients, rounding apart
# half a wave's last two: falling fast, as those of plain waves, their square is rounding
_HALF_RESOLVED = 1.2e-5
_LOG_RESOLVED = 1e-11  # of a panel's part of the integral of ln|F'|
_PROBES = 3**10  # angles a turn at which panels are tried: odd, so that few waves hide
_GOLDEN = 0.6180339887498949  # share of a step between the nodes of a rule and those of a finer one
_FLOOR = 1e-300
_DIRECTIONS = ((1.0, 0.0), (0.8, 0.6), (0.8, -0.6))  # shares of F's waves and of θ's
_STEEPNESS = np.append(np.append(1e-9, np.arange(1.0, 16.0) / 16.0), 1.0 - 1e-9)


def arc_rule(
    circle_map: CircleMap,
    start: float,
    end: float,
    bandwidth: float,
    finer: int = 1,
    every_sample: bool = True,
) -> Rule:
    """Gauss-Legendre panels on [start, end]: none crosses a break, F is resolved on each, each
    order fits its phase.

    With ``every_sample`` none crosses a sample of a sampled map either, where F'' jumps; without,
    far fewer nodes. Raises ConvergenceError where more than 400,000 nodes are needed.
    """
    edges = _edges(circle_map, start, end, every_sample)
    if circle_map.pieces is not None:
        return _on_panels(circle_map, edges, bandwidth, finer)
    resolved = _resolved_edges(circle_map, edges)
    return _on_panels(circle_map, resolved, bandwidth, finer, _LEAST)


def _resolved_edges(circle_map: CircleMap, edges: Array, logarithm: bool = False) -> Array:
    """``edges`` and more between them, until F is a polynomial of degree below 16 on each panel.

    logarithm : ln|F'| too, but for what is lost in a panel's length. First where nodes see it, then
        at angles between them no further apart than a ten-thousandth of a radian.
    """
    for _ in range(_PASSES):
        if (edges.size - 1) * _POINTS > MAX_NODES:
            raise too_many_nodes((edges.size - 1) * _POINTS)
        rough = _is_rough(circle_map, edges, logarithm)
        if not np.any(rough):
            break
        edges = np.union1d(edges, 0.5 * (edges[:-1] + edges[1:])[rough])
    return edges


def _is_rough(circle_map: CircleMap, edges: Array, logarithm: bool) -> Mask:
    """Which panels' nodes show more of F than polynomials of their degree hold; where none do, on
    which F departs from its polynomial between them.
    """
    left = edges[:-1]
    width = np.diff(edges)
    x, _ = gauss_rule(left, width, _POINTS)
    to_coefficients = _to_coefficients(_POINTS)
    here = circle_map(x).reshape(-1, _POINTS)
    coefficients = here @ to_coefficients
    tail = np.sum(np.abs(coefficients[:, -_TAIL:]), axis=1)
    rough = tail > _RESOLVED + 4.0 * LIFT * (TWO_PI + np.max(np.abs(here), axis=1))
    if logarithm:
        log = np.log(np.maximum(np.abs(circle_map.derivative(x)), _FLOOR)).reshape(-1, _POINTS)
        rough |= np.sum(np.abs(log @ to_coefficients[:, -_TAIL:]), axis=1) * width > _LOG_RESOLVED
    rough &= width > _SHORTEST
    if np.any(rough) or circle_map.pieces is not None:
        return np.asarray(rough)
    count = np.ceil(width * (_PROBES / TWO_PI)).astype(np.int64)
    owner = np.repeat(np.arange(width.size), count)
    share = (ranks(count) + _GOLDEN) / count[owner]
    image = circle_map(left[owner] + share * width[owner])
    expected = np.einsum(
        "ij,ij->i", legendre.legvander(2.0 * share - 1.0, _POINTS - 1), coefficients[owner]
    )
    off = np.abs(image - expected) > 16.0 * (_RESOLVED + 4.0 * LIFT * (TWO_PI + np.abs(image)))
    return (np.bincount(owner, off, width.size) > 0) & (width > _SHORTEST)


def too_many_nodes(count: int) -> ConvergenceError:
    """What is said where a rule would need more nodes than are allowed."""
    return ConvergenceError(
        f"the map needs {count} quadrature nodes, more than {MAX_NODES}: it is too steep, or has "
        "too fine a structure, for so small a noise; raise the noise or smooth the map"
    )


def _on_panels(
    circle_map: CircleMap, edges: Array, bandwidth: float, finer: int, least: int = 3
) -> Rule:
    """Gauss-Legendre nodes on the panels between ``edges``, each cut and its order set to fit its
    phase.
    """
    for _ in range(_PASSES):
        left, width, order = _fitted(circle_map, edges, bandwidth, least)
        if circle_map.pieces is not None:  # within cubics the phase tells all
            break
        rough = _has_rough_waves(circle_map, left, width, order, bandwidth) & (width > _SHORTEST)
        if not np.any(rough):
            break
        edges = np.sort(np.concatenate([left, (left + 0.5 * width)[rough], edges[-1:]]))
    order = finer * order
    if int(order.sum()) > MAX_NODES:
        raise too_many_nodes(int(order.sum()))
    nodes = []
    weights = []
    for points in np.unique(order):
        use = order == points
        x, w = gauss_rule(left[use], width[use], int(points))
        nodes.append(x)
        weights.append(w)
    theta = np.concatenate(nodes)
    place = np.argsort(theta, kind="stable")
    return theta[place], np.concatenate(weights)[place]


def _fitted(
    circle_map: CircleMap, edges: Array, bandwidth: float, least: int
) -> tuple[Array, Array, Whole]:
    """Panels cut until their phase, of waves of θ and of F together, is at most 60, and the order
    that it asks for.
    """
    left = edges[:-1]
    width = np.diff(edges)
    inner = left[:, None] + width[:, None] * _STEEPNESS
    steepest = np.max(np.abs(circle_map.derivative(inner)), axis=1)
    phase = 0.5 * bandwidth * np.hypot(1.0, steepest) * width
    if not np.sum(phase) < 60.0 * MAX_NODES:
        raise too_many_nodes(int(min(np.sum(phase), 1e18)))
    parts = np.maximum(1, np.ceil(phase / 60.0)).astype(np.int64)
    narrow = np.repeat(width / parts, parts)
    phase = np.repeat(phase / parts, parts)
    order = np.maximum(least, np.ceil(0.5 * (phase + 8.0 * np.cbrt(phase) + 6.0)).astype(np.int64))
    return np.repeat(left, parts) + ranks(parts) * narrow, narrow, order


def _has_rough_waves(
    circle_map: CircleMap, left: Array, width: Array, order: Whole, bandwidth: float
) -> Mask:
    """Which panels have too few nodes for half a wave of F, or of F and θ, whose square is a whole
    one.
    """
    rough = np.zeros(left.size, dtype=bool)
    for points in np.unique(order).tolist():
        use = np.flatnonzero(order == points)
        x, _ = gauss_rule(left[use], width[use], points)
        image = circle_map(x)
        last = _to_coefficients(points)[:, -2:]
        for share, other in _DIRECTIONS:
            wave = np.exp(0.5j * bandwidth * (share * image + other * x)).reshape(-1, points)
            rough[use] |= np.max(np.abs(wave @ last), axis=1) > _HALF_RESOLVED
    return rough


def _edges(circle_map: CircleMap, start: float, end: float, every_sample: bool) -> Array:
    """Panel edges: the ends, every break between them, and the samples there or a plain grid."""
    marks = even_angles(_PANELS)
    if circle_map.pieces is not None and every_sample:
        marks = circle_map.pieces.knots[:-1]
    marks = np.union1d(marks, circle_map.breaks)
    lap = np.floor(start / TWO_PI)
    around = np.concatenate([marks + TWO_PI * (lap + k) for k in (0, 1, 2)])
    around = around[(around > start + SNAP) & (around < end - SNAP)]
    return np.concatenate([[start], around, [end]])


def graded_rule(circle_map: CircleMap, bandwidth: float, finer: int = 1) -> Rule:
    """Nodes and weights over one turn on panels that shrink towards each (near) zero of F'.

    For integrands with a logarithm of |F'|, singular where F' = 0, times a density of that
    bandwidth.
    """
    edges = _resolved_edges(circle_map, _edges(circle_map, 0.0, TWO_PI, True), logarithm=True)
    return _on_panels(circle_map, edges, bandwidth, finer, _POINTS)


def gauss_rule(left: Array, width: Array, points: int) -> Rule:
    """Gauss-Legendre nodes and weights, ``points`` of them on each panel [left, left + width],
    panel by panel.
    """
    x, w = _gauss(points)
    return (left[:, None] + width[:, None] * (0.5 + 0.5 * x)).ravel(), (
        0.5 * width[:, None] * w
    ).ravel()


@lru_cache(maxsize=256)
def _to_coefficients(points: int) -> Array:
    """Values at the nodes of a panel, as rows, times this are their Legendre coefficients."""
    return read_only(np.linalg.inv(legendre.legvander(_gauss(points)[0], points - 1)).T)


@lru_cache(maxsize=256)
def _gauss(points: int) -> Rule:
    x, w = np.polynomial.legendre.leggauss(points)
    return read_only(x), read_only(w)
