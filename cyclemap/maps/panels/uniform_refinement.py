"""Panels for uniform noise: fine enough, and ending where laws are not smooth."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.panels.panel_basis import ORDER, Panels
from cyclemap.maps.panels.uniform_singularities import Singularities

SHORTEST = 1e-7  # radians: panels are not cut below this
_APART = 1e-9  # radians: two ends nearer than this are one
_BENT = 2  # generations of square roots that bend their panels; smoother ones gain nothing by it
_CUT_AT = (5, 3)  # generations of singular points at which panels are cut, in even and odd passes
_FOCUS = 0.1  # panels rough by less than this share of the roughest wait: its error may be all there is to theirs
_PASSES = 48
_TAIL = 2  # last coefficients of a panel that must be small
_SLOPE_TOLERANCE = 1e-11


def panels_between(ends: Array, root: Array, within: Callable[[Array], npt.NDArray[np.bool_]] | None = None) -> Panels:
    """The panels between neighbouring ``ends`` whose middles are ``within``, bent where an end is in ``root``."""
    sharp = np.zeros(ends.size, dtype=bool)
    if root.size:
        sharp = np.min(np.abs(ends[:, None] - root), axis=1) < _APART
        sharp |= (ends > TWO_PI - _APART) & bool(np.any(root < _APART))
    keep = np.full(ends.size - 1, True) if within is None else within(0.5 * (ends[1:] + ends[:-1]))
    return Panels(ends[:-1][keep], ends[1:][keep], (sharp[:-1] | sharp[1:])[keep])


def with_ends(ends: Array, more: Array) -> Array:
    """``ends`` and those of ``more`` that are between them and not (nearly) among them, sorted."""
    within = np.unique(more[(more > ends[0] + _APART) & (more < ends[-1] - _APART)])
    within = within[np.diff(within, prepend=-np.inf) > _APART]
    above = np.searchsorted(ends, within)
    apart = np.minimum(ends[above] - within, within - ends[above - 1]) > _APART
    return np.union1d(ends, within[apart])


def tails(panels: Panels, functions: Array) -> Array:
    """(panels, m): the last coefficients of each column of ``functions`` (n, m), beside its largest one (or 0.1)."""
    blocks = np.abs(functions).reshape(panels.count, ORDER, -1)
    scale = np.maximum(np.max(blocks, axis=(0, 1)), 0.1)
    return np.asarray(np.sum(blocks[:, -_TAIL:], axis=1) / scale)


def refined(
    ends: Array,
    singular: Singularities,
    assembled: Callable[[Panels], Array],
    tolerance: Array,
    most: int,
    within: Callable[[Array], npt.NDArray[np.bool_]] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Panels:
    """Panels cut until each function in ``assembled(panels)`` (n, m) is resolved to its ``tolerance`` (m,).

    The first function comes first: others are looked at when it is resolved. Ends at ``most`` panels.
    ``within`` tells of angles whether they belong to the domain; panels outside it are left out. ``progress`` is
    called before each pass with the share of ``most`` that there is.
    """
    root = singular.theta[singular.root & (singular.generation < _BENT)]
    panels = panels_between(ends, root, within)
    for step in range(_PASSES):
        if progress is not None:
            progress(min(1.0, panels.count / most))
        excess = tails(panels, assembled(panels)) / tolerance
        unresolved = np.flatnonzero(np.max(excess, axis=0) > 1.0)
        if unresolved.size == 0 or panels.count >= most:
            break
        rough = _roughest(panels, excess[:, unresolved[0]], most)
        cuts = _cut_points(panels, rough, singular, _CUT_AT[step % 2])
        if cuts.size == 0:
            break
        ends = with_ends(ends, cuts)
        panels = panels_between(ends, root, within)
    return panels


def _roughest(panels: Panels, excess: Array, most: int) -> npt.NDArray[np.bool_]:
    """The panels to cut now: near the roughest, long enough, and no more than there is room for."""
    long = panels.end - panels.start >= SHORTEST
    worth = np.where(long, excess, 0.0)
    last = np.sort(worth)[::-1][: most - panels.count][-1]
    return np.asarray(long & (excess >= max(1.0, _FOCUS * float(np.max(worth)), float(last))))


def _cut_points(panels: Panels, rough: npt.NDArray[np.bool_], singular: Singularities, below: int) -> Array:
    """Where to cut the rough panels: at the roughest singular point inside, of generations ``below``, else halfway."""
    known = singular.generation < below
    theta, generation = singular.theta[known], singular.generation[known]
    cuts = []
    for start, end in zip(panels.start[rough], panels.end[rough], strict=True):
        margin = max(_APART, 1e-3 * (end - start))
        low, high = np.searchsorted(theta, [start + margin, end - margin])
        inside = theta[low + int(np.argmin(generation[low:high]))] if high > low else 0.5 * (start + end)
        cuts.append(float(inside))
    return np.array(cuts)


def resolving_cuts(circle_map: CircleMap, panels: Panels) -> Array:
    """Angles, sorted, at which to cut the panels so that F' is smooth between them: its samples, and halvings."""
    knots = circle_map.pieces.knots if circle_map.pieces is not None else np.zeros(0)
    cuts = with_ends(np.append(panels.start, panels.end[-1]), knots)
    for _ in range(20):
        trial = Panels(cuts[:-1], cuts[1:], np.zeros(cuts.size - 1, dtype=bool))
        slope = trial.coefficients(circle_map.derivative(trial.nodes))
        rough = (tails(trial, slope[:, None])[:, 0] > _SLOPE_TOLERANCE) & (trial.end - trial.start > SHORTEST)
        if not np.any(rough):
            break
        cuts = np.union1d(cuts, 0.5 * (trial.start + trial.end)[rough])
    return cuts
