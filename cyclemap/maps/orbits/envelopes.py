"""Monotone envelopes of a degree-1 lift: the nearest nondecreasing maps above and below (water
levels).
"""

from __future__ import annotations

from functools import lru_cache, partial
from math import ceil

import numpy as np

from cyclemap.arrays import TWO_PI, Array, stretches
from cyclemap.errors import ConvergenceError
from cyclemap.maps.lifts.branches import cell_limits
from cyclemap.maps.lifts.circle_map import CircleMap, require_degree_one, require_map
from cyclemap.maps.lifts.lift_checks import SIDE_STEP
from cyclemap.maps.lifts.piecewise_lifts import GivenBranch, Piece, on_base_turn
from cyclemap.maps.lifts.scan import GRAIN, INSET, bracketed_root, monotone_cells

SLACK = 1e-12  # radians: a smaller descent is rounding
_GRID = np.linspace(0.0, TWO_PI, ceil(TWO_PI / GRAIN) + 1)


def is_nondecreasing(circle_map: CircleMap) -> bool:
    """Whether a lift falls nowhere, by more than rounding: 1e-12 radians from any angle to a later
    one.

    Parameters
    ----------
    circle_map : CircleMap
        The map.

    Returns
    -------
    bool
        True where it does not fall.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, is_nondecreasing
    >>> is_nondecreasing(CircleMap.arnold(0.2, 0.9)), is_nondecreasing(CircleMap.arnold(0.2, 1.1))
    (True, False)
    """
    return largest_descent(circle_map) <= SLACK


def largest_descent(circle_map: CircleMap) -> float:
    """The largest F(x) - F(y) over x < y, radians; 0 for a nondecreasing lift.

    Folds as wide as a tenth of a milliradian are found, narrower ones may be missed (see
    ``GRAIN``).
    """
    require_map(circle_map)
    pieces = circle_map.pieces
    if circle_map.breaks.size == 0 and pieces is not None and pieces.surely_rises():
        return 0.0
    smooth = circle_map.breaks.size == 0 and pieces is None
    try:
        value = _skeleton(circle_map)[1]
    except ConvergenceError:
        if not smooth or np.max(-np.diff(circle_map(_GRID))) > 2.0 * circle_map.max_error:
            raise
        return 0.0  # too rough for cells, and rising all the same
    twice = np.concatenate([value, value + TWO_PI * circle_map.degree])
    descent = float(np.max(np.maximum.accumulate(twice) - twice))
    # A nondecreasing lift lies within max_error of one that falls by twice that.
    return 0.0 if smooth and descent <= 2.0 * circle_map.max_error else descent


def upper_envelope(circle_map: CircleMap) -> CircleMap:
    """The upper monotone envelope F⁺(x) = sup of F over (-∞, x].

    Parameters
    ----------
    circle_map : CircleMap
        A map F of degree 1.

    Returns
    -------
    CircleMap
        Nondecreasing, at or above F.

    Notes
    -----
    Folds and downward jumps become plateaus, whose ends are the breaks of the result.
    (Chenciner, Gambaudo & Tresser 1984; Alsedà, Llibre & Misiurewicz, Combinatorial Dynamics
    and Entropy in Dimension One, ch. 3.) Levels and ends are found to a few rounding units of
    the angle, so its ``max_error`` is that of F plus 6e-15·max|F'|.

    References
    ----------
    - Chenciner, A., Gambaudo, J.-M. & Tresser, C. (1984), Une remarque sur la structure des
      endomorphismes de degré 1 du cercle, Comptes Rendus 299.
    - Alsedà, L., Llibre, J. & Misiurewicz, M., Combinatorial dynamics and entropy in dimension one,
      chapter 3.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, upper_envelope
    >>> raised = upper_envelope(CircleMap.arnold(0.0, 3.0))
    >>> bool(raised(0.0) > CircleMap.arnold(0.0, 3.0)(0.0))
    True
    """
    return _envelope(circle_map, 1)


def lower_envelope(circle_map: CircleMap) -> CircleMap:
    """The lower monotone envelope F⁻(x) = inf of F over [x, ∞).

    Parameters
    ----------
    circle_map : CircleMap
        A map F of degree 1.

    Returns
    -------
    CircleMap
        Nondecreasing, at or below F; see ``upper_envelope``.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, lower_envelope
    >>> lowered = lower_envelope(CircleMap.arnold(0.0, 3.0))
    >>> bool(lowered(0.0) <= CircleMap.arnold(0.0, 3.0)(0.0))
    True
    """
    return _envelope(circle_map, -1)


def _envelope(circle_map: CircleMap, mirror: int) -> CircleMap:
    """The upper envelope, or with ``mirror`` -1 the lower one: F, and on each plateau its level."""
    require_map(circle_map)
    require_degree_one(circle_map, "rotation")
    theta, value, steepest = _skeleton(circle_map)
    # x → -F(-x) swaps infimum from the right with supremum from the left
    nodes, values = (mirror * column[::mirror] for column in (theta, value))
    plateaus = _plateaus(circle_map, nodes, values, mirror)
    start, end, level = (mirror * column[::mirror] for column in plateaus)
    if mirror < 0:
        start, end = end, start
    if start.size == 0:
        return circle_map
    pieces = []
    following = np.append(start[1:], start[0] + TWO_PI)
    for first, last, height, after in zip(start, end, level, following, strict=True):
        flat = GivenBranch(partial(np.full_like, fill_value=height), np.zeros_like, first, last)
        pieces += [Piece(first, last, flat), Piece(last, after, circle_map)]
    breaks = np.concatenate([start, end, circle_map.breaks])
    error = circle_map.max_error + SIDE_STEP * steepest
    return CircleMap(on_base_turn(pieces, 1), None, breaks, max_error=error)


@lru_cache(maxsize=2)  # both envelopes and the descent of one map ask for it
def _skeleton(circle_map: CircleMap) -> tuple[Array, Array, float]:
    """Points (θ, F) in order over [0, 2π], F monotone between neighbours, a jump one θ twice; the
    largest |F'|.
    """
    cells = monotone_cells(circle_map, 1, 0.0)
    theta = np.stack([cells.start, cells.end], axis=1).ravel()
    value = np.stack(cell_limits(circle_map, cells), axis=1).ravel()
    if cells.cut[0]:
        theta = np.append(theta, TWO_PI)
        value = np.append(value, value[0] + cells.climb)
    return theta, value, float(np.max(np.abs([cells.slope_start, cells.slope_end])))


def _plateaus(
    circle_map: CircleMap, nodes: Array, values: Array, mirror: int
) -> tuple[Array, Array, Array]:
    """Starts (one turn of them), ends and levels of the intervals where the running maximum exceeds
    F.
    """
    laps = TWO_PI * np.array([[-1.0], [0.0], [1.0]])
    theta = (nodes + laps).ravel()
    value = (values + laps).ravel()
    highest = np.maximum.accumulate(value)
    under = value < highest - SLACK
    runs = [run for run in stretches(under) if run[0] > 0 and run[1] < under.size]
    first, after = np.reshape(runs, (-1, 2)).astype(np.int64).T
    first = first - 1
    begins = theta[first]
    keep = (begins >= nodes[0]) & (begins < nodes[0] + TWO_PI)
    first, after, level = first[keep], after[keep], highest[first[keep]]
    # F climbs back to each level in the cell that ends at node ``after``, or at its upward jump.
    low = theta[after - 1] + INSET
    high = theta[after] - INSET

    def residual(x: Array, wanted: Array) -> Array:
        return mirror * circle_map(mirror * x) - wanted

    met = bracketed_root(lambda x, index: residual(x, level[index]), low, high)
    end = np.where((high > low) & (residual(high, level) > 0.0), met, theta[after])
    return theta[first], end, level
