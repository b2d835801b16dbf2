"""Panels: piecewise polynomials on intervals that end where densities under uniform noise are not smooth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any, Self

import numpy as np
from numpy.polynomial import legendre

from cyclemap.arrays import TWO_PI, Array, Mask, Whole
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.scan import Cells, monotone_cells, preimages, solved

ORDER = 24  # polynomials on each panel
_SLOPE_INSET = 1e-5  # how near a bent panel's end, in t, slopes are read
_EXTRA = 20  # further degrees that hold an antiderivative on a bent panel to rounding


@dataclass(frozen=True, eq=False)
class _Reference:
    """Tables on t in [-1, 1]; a pair has its entry for straight panels first, for bent ones second."""

    nodes: Array
    to_coefficients: Array
    antiderivative: Array  # (2, degrees, ORDER): of P_j dθ/dt per half-width, zero at t = -1
    mass: Array  # (2, ORDER): ∫ P_j dθ/dt per half-width


@cache
def _reference() -> _Reference:
    nodes = np.asarray(legendre.leggauss(ORDER)[0], dtype=np.float64)
    # The inverse is good to rounding; with Gauss weights in its place 1e-14 would be lost.
    to_coefficients = np.asarray(np.linalg.inv(legendre.legvander(nodes, ORDER - 1)), dtype=np.float64)
    fine, fine_weights = legendre.leggauss(3 * ORDER)
    waves = legendre.legvander(fine, ORDER + _EXTRA - 1)
    stretches = np.stack([np.ones_like(fine), 0.5 * np.pi * np.cos(0.5 * np.pi * fine)])
    weighted = np.einsum("qi,sq,qj->sij", waves * fine_weights[:, None], stretches, waves[:, :ORDER])
    series = weighted * (np.arange(ORDER + _EXTRA) + 0.5)[:, None]
    antiderivative = np.stack([legendre.legint(part, lbnd=-1.0, axis=0) for part in series])
    return _Reference(nodes, to_coefficients, antiderivative, weighted[:, 0])


@dataclass(frozen=True, eq=False)
class Panels:
    """Intervals [start, end] in rising order, gaps allowed; on each ``ORDER`` Legendre polynomials of t in [-1, 1].

    On a straight panel θ runs linearly with t; on a bent one θ = middle + half·sin(πt/2), which makes half-integer
    powers of the distance to either end analytic in t. A function is its coefficients, shape (size,).
    """

    start: Array
    end: Array
    bent: Mask

    @property
    def count(self) -> int:
        """Number of panels."""
        return int(self.start.size)

    @property
    def size(self) -> int:
        """Number of basis functions."""
        return ORDER * self.count

    @property
    def half(self) -> Array:
        """Half the panels' lengths."""
        return 0.5 * (self.end - self.start)

    def refined(self) -> Self:
        """The same with every panel cut in two at its middle: what changes by it was not resolved."""
        middle = 0.5 * (self.start + self.end)
        start, end = np.stack([self.start, middle], axis=1), np.stack([middle, self.end], axis=1)
        return replace(self, start=start.ravel(), end=end.ravel(), bent=np.repeat(self.bent, 2))

    @cached_property
    def nodes(self) -> Array:
        """The Gauss-Legendre nodes in t of every panel, as angles, shape (size,)."""
        return self.points(_reference().nodes).ravel()

    def points(self, t: Array) -> Array:
        """(panels, m): the angles at t, shape (m,) or (panels, m); distances to the nearer end keep their digits."""
        near = 1.0 - np.abs(t)
        share = np.where(self.bent[:, None], 2.0 * np.sin(0.25 * np.pi * near) ** 2, near)
        offset = self.half[:, None] * share
        return np.asarray(np.where(t < 0.0, self.start[:, None] + offset, self.end[:, None] - offset))

    @property
    def test_points(self) -> Array:
        """Angles at which to look for what the nodes do not show: three times as many, denser at the panels' ends."""
        t = -np.cos(np.pi * (np.arange(3 * ORDER) + 0.5) / (3 * ORDER))
        return self.points(t).ravel()

    def coefficients(self, values: Any) -> Any:
        """Coefficients, shape (size, ...), of the function with these values at ``nodes``, shape (size, ...)."""
        given = np.asarray(values)
        blocks = given.reshape(self.count, ORDER, -1)
        return np.matmul(_reference().to_coefficients, blocks).reshape(given.shape)

    def locate(self, theta: Array) -> tuple[Whole, Array]:
        """The panel of each angle and t there; angles in a gap are at the end of the panel before it."""
        panel = np.clip(np.searchsorted(self.start, theta, side="right") - 1, 0, self.count - 1)
        low, high = theta - self.start[panel], self.end[panel] - theta
        share = np.clip(np.minimum(low, high) / self.half[panel], 0.0, 1.0)
        near = np.where(self.bent[panel], 4.0 / np.pi * np.arcsin(np.sqrt(0.5 * share)), share)
        return panel, np.where(low < high, near - 1.0, 1.0 - near)

    def evaluate(self, theta: Array) -> Array:
        """(m, size): every basis function at the angles, shape (m,); at a panel's end that of the panel after it."""
        panel, t = self.locate(theta)
        return self._scattered(panel, np.asarray(legendre.legvander(t, ORDER - 1), dtype=np.float64))

    def value(self, law: Any, theta: Array) -> Any:
        """The function with coefficients ``law`` at the angles: ``evaluate(theta) @ law`` without the matrix."""
        panel, t = self.locate(theta)
        blocks = np.asarray(law).reshape(self.count, ORDER)
        return np.einsum("ij,ij->i", legendre.legvander(t, ORDER - 1), blocks[panel])

    def slope(self, theta: Array) -> Array:
        """(m, size): the basis functions' derivatives in θ; beside the ends of bent panels read a little inside."""
        panel, t = self.locate(theta)
        bent = self.bent[panel]
        t = np.where(bent, np.clip(t, _SLOPE_INSET - 1.0, 1.0 - _SLOPE_INSET), t)
        stretch = self.half[panel] * np.where(bent, 0.5 * np.pi * np.cos(0.5 * np.pi * t), 1.0)
        slopes = legendre.legvander(t, ORDER - 2) @ legendre.legder(np.eye(ORDER), axis=0)
        return self._scattered(panel, slopes / stretch[:, None])

    def _scattered(self, panel: Whole, values: Any) -> Array:
        rows = np.zeros((panel.size, self.count, ORDER))
        rows[np.arange(panel.size), panel] = values
        return rows.reshape(panel.size, self.size)

    @cached_property
    def mass(self) -> Array:
        """(size,): the integral of every basis function."""
        return np.asarray(self.half[:, None] * _reference().mass[self.bent.astype(np.int64)]).ravel()

    def integral(self, law: Any, theta: Array) -> Any:
        """∫ of the function with coefficients ``law`` from the first panel's start to each angle."""
        panel, partial = self._partial(theta)
        blocks = np.asarray(law).reshape(self.count, ORDER)
        whole = np.sum(blocks * self.mass.reshape(self.count, ORDER), axis=1)
        before = np.concatenate([[0.0], np.cumsum(whole)[:-1]])
        return before[panel] + np.einsum("ij,ij->i", partial, blocks[panel])

    def integral_matrix(self, theta: Array, weight: Array, row: Whole, rows: int) -> Array:
        """(rows, size): row r is the sum of weight·∫ φ_j up to θ over the entries with ``row`` r."""
        panel, partial = self._partial(theta)
        matrix = np.zeros((rows, self.count, ORDER))
        np.add.at(matrix, (row, panel), weight[:, None] * partial)
        ending = np.zeros((rows, self.count))
        np.add.at(ending, (row, panel), weight)
        after = np.cumsum(ending[:, ::-1], axis=1)[:, ::-1] - ending
        matrix += after[:, :, None] * self.mass.reshape(self.count, ORDER)
        return matrix.reshape(rows, self.size)

    def _partial(self, theta: Array) -> tuple[Whole, Array]:
        """The panel of each angle and, shape (m, ORDER), the integrals of its functions from its start to there."""
        panel, t = self.locate(theta)
        tables = _reference().antiderivative
        waves = legendre.legvander(t, tables.shape[1] - 1)
        values = np.where(self.bent[panel, None], waves @ tables[1], waves @ tables[0])
        return panel, self.half[panel, None] * values

    def cut_rule(self, cuts: Array, points: int) -> tuple[Array, Array]:
        """Gauss-Legendre nodes and weights in t on every panel, cut also at the angles ``cuts``, sorted."""
        panel, t = self.locate(cuts)
        inside = np.abs(t) < 1.0 - 1e-13
        owner = np.concatenate([np.arange(self.count), panel[inside]])
        low = np.concatenate([np.full(self.count, -1.0), t[inside]])
        order = np.lexsort((low, owner))
        owner, low = owner[order], low[order]
        high = np.where(np.append(np.diff(owner) > 0, True), 1.0, np.append(low[1:], 1.0))
        nodes, weights = legendre.leggauss(points)
        half = 0.5 * (high - low)[:, None]
        at = low[:, None] + half * (1.0 + nodes)
        single = Panels(self.start[owner], self.end[owner], self.bent[owner])
        stretch = np.where(single.bent[:, None], 0.5 * np.pi * np.cos(0.5 * np.pi * at), 1.0)
        return single.points(at).ravel(), (half * weights * stretch * single.half[:, None]).ravel()


def level_steps(circle_map: CircleMap, cells: Cells, levels: Array) -> tuple[Whole, Array, Whole, Whole]:
    """The step functions n(θ; z) = ⌊(F(θ) - z)/2π⌋ on [0, 2π) for each z of ``levels``, shape (m,), radians.

    (row, θ, height) of every step: its level's index, its angle, and by how much n rises there; and n just before 2π,
    shape (m,). ``cells`` are the map's own monotone cells (period 1). Roots of F = z + 2πw are bracketed by their cell
    and solved to rounding; a jump of F gives its step at the break.
    """
    low = np.floor((cells.g_start - levels[:, None]) / TWO_PI).astype(np.int64)
    high = np.floor((cells.g_end - levels[:, None]) / TWO_PI).astype(np.int64)
    row, cell = np.nonzero(low != high)
    theta, _, pick = solved(circle_map, cells, cell, levels[row], low[row, cell], high[row, cell])
    rows, height = row[pick], np.sign(high - low)[row, cell][pick]
    jumped = low[:, 1:] - high[:, :-1]
    jump_row, cell = np.nonzero(jumped)
    theta, height = np.append(theta, cells.start[cell + 1]), np.append(height, jumped[jump_row, cell])
    return np.append(rows, jump_row), theta, height, high[:, -1]


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
    # One-sided values at the breaks, the smooth extrema of F, and the fixed points of F ± h: where the support of a law
    # trapped in an arc ends, smooth but not analytic.
    at_breaks = np.concatenate([circle_map.left(circle_map.breaks), circle_map.right(circle_map.breaks)])
    rising = np.sign(cells.g_end - cells.g_start)
    extrema = cells.g_start[(rising * np.roll(rising, 1) < 0.0) & ~cells.cut]
    turning = monotone_cells(circle_map, 1, 1.0, _TURN_CELLS)
    ends = preimages(circle_map, turning, np.array([-halfwidth, halfwidth]))
    values = np.concatenate([at_breaks, extrema, circle_map(ends)])
    root = np.repeat([False, True, False], [at_breaks.size, extrema.size, ends.size])
    theta, generation, roots = np.zeros(0), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=bool)
    for step in range(_GENERATIONS):
        latest = np.mod(np.concatenate([values - halfwidth, values + halfwidth]), TWO_PI)
        theta = np.append(theta, latest)
        generation = np.append(generation, np.full(latest.size, step))
        roots = np.append(roots, np.tile(root, 2))
        # Sorted, with points that are the same joined into the roughest of them.
        order = np.argsort(theta, kind="stable")
        theta, generation, roots = theta[order], generation[order], roots[order]
        group = np.cumsum(np.diff(theta, prepend=theta[:1]) > _SAME)
        leader = np.lexsort((~roots, generation, group))
        leader = leader[np.diff(group[leader], prepend=-1) > 0]
        theta, generation, roots = theta[leader], generation[leader], roots[leader]
        now = generation == step
        if theta.size > _MOST or not np.any(now):
            break
        values, root = circle_map(theta[now]), roots[now]
    return Singularities(theta, generation, roots)


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
) -> Panels:
    """Panels cut until each function in ``assembled(panels)`` (n, m) is resolved to its ``tolerance`` (m,).

    The first function comes first: others are looked at when it is resolved. Ends at ``most`` panels.
    ``within`` tells of angles whether they belong to the domain; panels outside it are left out.
    """
    root = singular.theta[singular.root & (singular.generation < _BENT)]
    panels = panels_between(ends, root, within)
    for step in range(_PASSES):
        excess = tails(panels, assembled(panels)) / tolerance
        unresolved = np.flatnonzero(np.max(excess, axis=0) > 1.0)
        if unresolved.size == 0 or panels.count >= most:
            break
        worst = excess[:, unresolved[0]]
        long = panels.end - panels.start >= SHORTEST
        worth = np.where(long, worst, 0.0)
        last = np.sort(worth)[::-1][: most - panels.count][-1]  # no more than there is room for
        rough = long & (worst >= max(1.0, _FOCUS * float(np.max(worth)), float(last)))
        # Cut at the roughest singular point inside, else halfway.
        known, cuts = singular.upto(_CUT_AT[step % 2] - 1), []
        for start, end in zip(panels.start[rough], panels.end[rough], strict=True):
            margin = max(_APART, 1e-3 * (end - start))
            a, b = np.searchsorted(known.theta, [start + margin, end - margin])
            cuts.append(known.theta[a + int(np.argmin(known.generation[a:b]))] if b > a else 0.5 * (start + end))
        if not cuts:
            break
        ends = with_ends(ends, np.array(cuts))
        panels = panels_between(ends, root, within)
    return panels


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
