"""Where densities under uniform noise are not smooth, and panels that are fine enough and end there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Mask, Whole
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.orbits.scan import Cells, bracketed_root, crossings, monotone_cells
from cyclemap.maps.uniform.piecewise_basis import ORDER, Panels


@dataclass(frozen=True, eq=False)
class LevelSteps:
    """The step functions n(θ; z) = ⌊(F(θ) - z)/2π⌋ on [0, 2π), one a level.

    row, theta, height : every step inside: its level's index, its angle, and by how much n rises there.
    first, last : (levels,): n just after 0 and just before 2π.
    """

    row: Whole
    theta: Array
    height: Whole
    first: Whole
    last: Whole


def level_steps(circle_map: CircleMap, cells: Cells, levels: Array) -> LevelSteps:
    """The steps for each of ``levels``, shape (m,), radians; ``cells`` are the map's own monotone cells (period 1).

    Roots of F = z + 2πw are bracketed by their cell and solved to rounding; a jump of F gives its step at the break.
    """
    low = np.floor((cells.g_start - levels[:, None]) / TWO_PI).astype(np.int64)
    high = np.floor((cells.g_end - levels[:, None]) / TWO_PI).astype(np.int64)
    rows, theta, height = _crossed(circle_map, cells, levels, low, high)
    jumped = low[:, 1:] - high[:, :-1]
    jump_row, cell = np.nonzero(jumped)
    return LevelSteps(
        np.append(rows, jump_row),
        np.append(theta, cells.start[cell + 1]),
        np.append(height, jumped[jump_row, cell]),
        low[:, 0],
        high[:, -1],
    )


def _crossed(circle_map: CircleMap, cells: Cells, levels: Array, low: Whole, high: Whole) -> tuple[Whole, Array, Whole]:
    """Row, angle and height (±1) of every crossing inside a cell."""
    row, cell = np.nonzero(low != high)
    rise = (high - low)[row, cell]
    count = np.abs(rise)
    owner = np.repeat(np.arange(row.size), count)
    rank = np.arange(owner.size) - np.repeat(np.cumsum(count) - count, count)
    row, cell, sign = row[owner], cell[owner], np.sign(rise)[owner]
    target = levels[row] + TWO_PI * (np.minimum(low[row, cell], high[row, cell]) + 1 + rank)
    start, end = cells.inner()
    return row, roots_in(circle_map, start[cell], end[cell], target), sign


def roots_in(circle_map: CircleMap, start: Array, end: Array, target: Array) -> Array:
    """The root of F = target in each [start, end], where F is monotone; an end where rounding hides it."""
    if target.size == 0:
        return np.zeros(0)

    def residual(theta: Array, wanted: Array) -> Array:
        return circle_map(theta) - wanted

    at_start, at_end = residual(start, target), residual(end, target)
    theta = np.where(np.abs(at_start) <= np.abs(at_end), start, end)
    bracketed = at_start * at_end < 0.0
    if np.any(bracketed):
        wanted = target[bracketed]
        theta[bracketed] = bracketed_root(lambda x, i: residual(x, wanted[i]), start[bracketed], end[bracketed])
    return theta


_SAME = 1e-9  # radians: singular points nearer than this are one
_GENERATIONS = 8
_MOST = 1_500
_TURN_CELLS = 128


@dataclass(frozen=True, eq=False)
class Singularities:
    """Angles in [0, 2π), sorted; ``generation`` 0 is the roughest; ``root`` marks half-integer powers."""

    theta: Array
    generation: Whole
    root: Mask

    def upto(self, generation: int) -> Singularities:
        """Those of this generation and rougher ones."""
        keep = self.generation <= generation
        return Singularities(self.theta[keep], self.generation[keep], self.root[keep])


def law_singularities(circle_map: CircleMap, cells: Cells, halfwidth: float) -> Singularities:
    """The points F(break±) ± h and (critical value) ± h, and F(those) ± h, each image one power smoother.

    A break makes the density kink (or jump, where F is flat beside it), a critical value gives it a square root.
    """
    values, root = _sources(circle_map, cells)
    ends = _trap_ends(circle_map, halfwidth)
    values, root = np.append(values, circle_map(ends)), np.append(root, np.zeros(ends.size, dtype=bool))
    theta, generation, roots = np.zeros(0), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=bool)
    for step in range(_GENERATIONS):
        latest = np.mod(np.concatenate([values - halfwidth, values + halfwidth]), TWO_PI)
        theta = np.append(theta, latest)
        generation = np.append(generation, np.full(latest.size, step))
        roots = np.append(roots, np.tile(root, 2))
        theta, generation, roots = _merged(theta, generation, roots)
        now = generation == step
        if theta.size > _MOST or not np.any(now):
            break
        values, root = circle_map(theta[now]), roots[now]
    return Singularities(theta, generation, roots)


def _sources(circle_map: CircleMap, cells: Cells) -> tuple[Array, Mask]:
    """One-sided values at the breaks, and the values at the smooth extrema of F (True)."""
    at_breaks = np.concatenate([circle_map.left(circle_map.breaks), circle_map.right(circle_map.breaks)])
    rising = np.sign(cells.g_end - cells.g_start)
    turning = (rising * np.roll(rising, 1) < 0.0) & ~cells.cut
    extrema = cells.g_start[turning]
    values = np.append(at_breaks, extrema)
    return values, np.arange(values.size) >= at_breaks.size


def _trap_ends(circle_map: CircleMap, halfwidth: float) -> Array:
    """The fixed points of F ± h: where the support of a law trapped in an arc ends, smooth but not analytic."""
    turning = monotone_cells(circle_map, 1, 1.0, _TURN_CELLS)
    found = [crossings(circle_map, turning, level)[0] for level in (-halfwidth, halfwidth)]
    return np.concatenate(found)


def _merged(theta: Array, generation: Whole, root: Mask) -> tuple[Array, Whole, Mask]:
    """Sorted, with points that are the same joined into the roughest of them."""
    order = np.argsort(theta, kind="stable")
    theta, generation, root = theta[order], generation[order], root[order]
    group = np.cumsum(np.diff(theta, prepend=theta[:1]) > _SAME)
    leader = np.lexsort((~root, generation, group))
    leader = leader[np.diff(group[leader], prepend=-1) > 0]
    return theta[leader], generation[leader], root[leader]


SHORTEST = 1e-7  # radians: panels are not cut below this
_APART = 1e-9  # radians: two ends nearer than this are one
_BENT = 2  # generations of square roots that bend their panels; smoother ones gain nothing by it
_CUT_AT = (5, 3)  # generations of singular points at which panels are cut, in even and odd passes
_FOCUS = 0.1  # panels rough by less than this share of the roughest wait: its error may be all there is to theirs
_PASSES = 48
_TAIL = 2  # last coefficients of a panel that must be small
_SLOPE_TOLERANCE = 1e-11


def panels_between(ends: Array, root: Array, within: Callable[[Array], Mask] | None = None) -> Panels:
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
    within: Callable[[Array], Mask] | None = None,
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


def _roughest(panels: Panels, excess: Array, most: int) -> Mask:
    """The panels to cut now: near the roughest, long enough, and no more than there is room for."""
    long = panels.end - panels.start >= SHORTEST
    worth = np.where(long, excess, 0.0)
    last = np.sort(worth)[::-1][: most - panels.count][-1]
    return np.asarray(long & (excess >= max(1.0, _FOCUS * float(np.max(worth)), float(last))))


def _cut_points(panels: Panels, rough: Mask, singular: Singularities, below: int) -> Array:
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
