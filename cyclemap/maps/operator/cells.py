"""Masses on small cells (Ulam 1960): for noise whose density jumps, and without noise for maps that
expand.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import EPS, INTEGRAL, LIFT, Estimate
from cyclemap.maps.lifts.branches import branches, preimages_on
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.map_algebra import nth_iterate
from cyclemap.maps.lifts.scan import ranks
from cyclemap.maps.noise import Noise, wrapped_window
from cyclemap.maps.operator.fourier_basis import Complex, FourierDiscretisation
from cyclemap.maps.operator.poisson_equation import Function, StationaryLaw, checked_values
from cyclemap.maps.quadrature import Rule, gauss_rule

_POINT = 1e-7  # radians: images shorter than this are points
_APART = 1e-9  # radians: a break nearer to an edge of a cell is that edge
_CHORD = 1.25  # times the distance from its chord that three points of a cell show of F
_NONE = 1e-11  # chances that may be rounding


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells of angles, the images on which F runs straight from end to end, and ξ uniform on
    [-h, h], or 0.

    Parameters
    ----------
    halfwidth : h, radians. start, end : (n,), radians, of the cells.
    images : (2, n), radians, lifted: F at the start and the end of every cell, from inside.
    bend : radians, how far F, with its ``max_error``, may lie from straight.
    """

    halfwidth: float
    start: Array
    end: Array
    images: Array
    bend: float

    @property
    def width(self) -> Array:
        """(n,): the cells' lengths."""
        return self.end - self.start

    @cached_property
    def low(self) -> Array:
        """(n,): the lower ends of the images."""
        return np.asarray(self.images.min(axis=0))

    @cached_property
    def high(self) -> Array:
        """(n,): the upper ends."""
        return np.asarray(self.images.max(axis=0))

    @property
    def rounding(self) -> float:
        """What the chances of one cell, added up, may be off by rounding."""
        shortest = max(float(np.min(self.high - self.low)), _POINT)
        return 64.0 * EPS * (TWO_PI + self.halfwidth) / shortest + _NONE * self.start.size

    def moved(self, shift: float) -> Cells:
        """The same for F + ``shift``."""
        return replace(self, images=self.images + shift)

    def between(self, start: Array, end: Array, lifted: bool = False) -> Array:
        """(n, m): the chance of being in each arc from start to end a cycle later, mod 2π, or
        ``lifted`` on the real line, where an arc may be infinite.
        """
        if lifted:
            reach = self.low.min() - self.halfwidth, self.high.max() + self.halfwidth
            ends = np.clip(np.stack([start, end]), *reach)
            before, after = _chance_below(self.low, self.high, self.halfwidth, ends)
            chances = after - before
        else:
            chances = self._between_turned(start, end)
        return np.where(chances > _NONE, chances, 0.0)

    def _between_turned(self, start: Array, end: Array) -> Array:
        share, window, centre = wrapped_window(self.halfwidth)
        shift = TWO_PI * np.floor(self.low / TWO_PI) - centre
        low = self.low - shift
        high = self.high - shift
        begin = np.mod(start, TWO_PI)
        laps, rest = np.divmod(end - start, TWO_PI)
        most = int(np.ceil((np.max(high) + window) / TWO_PI))
        total = laps + share * rest / TWO_PI
        for turn in TWO_PI * np.arange(-2, most + 1):
            ends = np.stack([begin, begin + rest]) + turn
            before, after = _chance_below(low, high, window, ends)
            total = total + (1.0 - share) * (after - before)
        return total


def cells_of(
    circle_map: CircleMap, halfwidth: float, arcs: Sequence[tuple[float, float]], count: int
) -> Cells:
    """``count`` even cells of some arcs, eight at least of each, cut at F's breaks."""
    whole = sum(high - low for low, high in arcs)
    edges = [
        _edges(circle_map.breaks, low, high, max(8, round(count * (high - low) / whole)))
        for low, high in arcs
    ]
    start = np.concatenate([ends[:-1] for ends in edges])
    end = np.concatenate([ends[1:] for ends in edges])
    images = np.stack([circle_map.right(start), circle_map.left(end)])
    share = np.array([[0.25], [0.5], [0.75]])
    chord = images[0] + share * (images[1] - images[0])
    off = float(np.max(np.abs(circle_map(start + share * (end - start)) - chord)))
    return Cells(halfwidth, start, end, images, _CHORD * off + _POINT + circle_map.max_error)


def _edges(breaks: Array, start: float, end: float, count: int) -> Array:
    """The ends of ``count`` even cells, and the breaks between."""
    even = np.linspace(start, end, count + 1)
    turns = TWO_PI * np.arange(np.floor(start / TWO_PI), np.ceil(end / TWO_PI) + 1.0)
    marks = np.add.outer(turns, breaks).ravel()
    after = np.searchsorted(even, marks).clip(1, count)
    apart = np.minimum(np.abs(even[after] - marks), np.abs(even[after - 1] - marks)) > _APART
    return np.union1d(even, marks[apart & (marks > start) & (marks < end)])


def _chance_below(low: Array, high: Array, halfwidth: float, lines: Array) -> Array:
    """(..., n, m): P(x + ξ < line) for x uniform on [low, high], shape (n,), ξ uniform on [-h, h],
    and lines (..., m).
    """
    length = (high - low)[:, None]
    over = lines[..., None, :] - low[:, None]
    under = lines[..., None, :] - high[:, None]
    middle = 0.5 * (over + under)
    if halfwidth == 0.0:
        rising = np.maximum(over, 0.0) - np.maximum(under, 0.0)
        point = (middle > 0.0).astype(np.float64)
    else:
        inner, outer = (np.clip(side, -halfwidth, halfwidth) + halfwidth for side in (over, under))
        rising = (inner - outer) * (inner + outer) / (4.0 * halfwidth)
        rising += np.maximum(over - halfwidth, 0.0) - np.maximum(under - halfwidth, 0.0)
        point = np.clip((middle + halfwidth) / (2.0 * halfwidth), 0.0, 1.0)
    chance = np.where(length > _POINT, rising / np.maximum(length, _POINT), point)
    return np.where(under >= halfwidth, 1.0, chance)


NOISELESS_CELLS = 1_024
CELLS = 512  # under noise, where errors fall with their square
_OUTER = 1.3  # times what three Gauss nodes of a cell show a function to vary
_ITERATES = 4  # up to which a power of the map is looked at for expansion
_SAMPLES = 40_000
_SAMPLED = 1.02  # times the steepest that samples show of 1/F'


@dataclass(frozen=True, eq=False)
class CellDiscretisation:
    """The masses of ``count`` cells of the circle, and one cycle as the chances of going from cell
    to cell.

    map, noise : whose cycle it is; None is no noise.
    """

    map: CircleMap
    noise: Noise | None
    count: int

    left_out = np.inf  # no bound on what a cycle makes of functions that vary within the cells
    moved = np.inf

    @cached_property
    def cells(self) -> Cells:
        """The cells of the circle."""
        halfwidth = 0.0 if self.noise is None else self.noise.jump
        return cells_of(self.map, halfwidth, [(0.0, TWO_PI)], self.count)

    @property
    def size(self) -> int:
        """The number of cells."""
        return self.cells.start.size

    @cached_property
    def mass(self) -> Array:
        """(n,): 1 for each cell."""
        return np.ones(self.size)

    @cached_property
    def uniform(self) -> Array:
        """(n,): the uniform density's masses."""
        return self.cells.width / TWO_PI

    @cached_property
    def matrix(self) -> Array:
        """(n, n): the masses after one cycle from those before."""
        cells = self.cells
        chances = self._shares() if self.noise is None else cells.between(cells.start, cells.end)
        return np.ascontiguousarray((chances / chances.sum(axis=1)[:, None]).T)

    def _shares(self) -> Array:
        """(n, n): the length of each cell that the map alone sends to each, cut where F meets an
        edge.
        """
        edges = self.cells.start
        levels, _ = preimages_on(branches(self.map), edges, self.map.degree)
        points = np.unique(np.concatenate([edges, [TWO_PI], levels, self.map.breaks]))
        middle = 0.5 * (points[1:] + points[:-1])
        before, after = (
            np.searchsorted(edges, angle, side="right") - 1
            for angle in (middle, np.mod(self.map(middle), TWO_PI))
        )
        shares = np.zeros((self.size, self.size))
        np.add.at(shares, (before, after), np.diff(points))
        return shares

    @cached_property
    def rule(self) -> Rule:
        """Three Gauss nodes in each cell, and their weights."""
        return gauss_rule(self.cells.start, self.cells.width, 3)

    def moments(self, order: int) -> Complex:
        """(n,), complex: the mean of e^{i·order·θ} in every cell."""
        turned = np.exp(0.5j * order * (self.cells.start + self.cells.end))
        return np.asarray(turned * np.sinc(0.5 * order * self.cells.width / np.pi))

    def cycle(self, law: Array) -> Array:
        """(n,): the masses after one cycle; or columns of several."""
        return self.matrix @ law

    def coupling(self, left: Array | Complex, right: Array | Complex) -> Array:
        """(k, k): how much wᵀLv changes when F is off by its ``max_error`` ε, at most: ε max|w|
        ‖v‖₁ / h.

        The mean of w over the window of the noise changes by what leaves at one end and comes in
        at the other.
        """
        largest = np.max(np.abs(left), axis=0)
        share = self.map.max_error / self.cells.halfwidth
        return np.asarray(share * np.multiply.outer(largest, np.sum(np.abs(right), axis=0)))

    def refined(self) -> CellDiscretisation:
        """The same with twice as many cells."""
        return replace(self, count=2 * self.count)


def cell_law(circle_map: CircleMap, noise: Noise | None) -> CellLaw:
    """The law of a map under noise whose density jumps, or without noise; then InvalidInput unless
    the map expands.
    """
    law = CellLaw(
        CellDiscretisation(circle_map, noise, NOISELESS_CELLS if noise is None else CELLS)
    )
    if not np.isfinite(law.variation):
        raise InvalidInput(
            f"the noise is None, and no power of the map up to {_ITERATES} expands (slopes above "
            "1, with breaks or folds above 2): add noise, for example WrappedNormal(0.02)"
        )
    return law


@dataclass(frozen=True, eq=False)
class CellLaw(StationaryLaw):
    """The stationary law on cells, with bounds (after Galatolo & Nisoli 2014, and Galatolo, Monge &
    Nisoli 2020).

    Let p be the law, Πp its means on the cells (of width w), p̃ the computed one, G the norm of
    (I - L̃)⁻¹ on masses. Then ‖Πp - p̃‖₁ <= G (‖ΠL(p - Πp)‖₁ + ‖Π(L - L̃)p‖₁), ``mass_error``.
    Under noise uniform on [-h, h] these are at most max(w·|image of a cell|) V/4h and ``bend``/h, V
    = 1/h; without noise (w/2) V and, for the preimages of edges, on which the cells are cut, 2 sup
    p times F's rounding over inf |F'|, V the variation that an inequality of Lasota & Yorke gives,
    but 2 where the map has a ``max_error``. All that is proved; measured are G, ``bend`` and,
    without noise, sup|(1/F')'| and inf|F'|.
    """

    basis: CellDiscretisation

    @property
    def smooth_basis(self) -> FourierDiscretisation:
        """Refused: InvalidInput."""
        raise InvalidInput(
            f"the noise is {self.basis.noise!r}: this needs one with a smooth density, as "
            "WrappedNormal has"
        )

    @cached_property
    def variation(self) -> float:
        """V, a bound on the variation of p."""
        halfwidth = self.basis.cells.halfwidth
        return 1.0 / halfwidth if halfwidth > 0.0 else variation_of_expanding(self.basis.map)

    @cached_property
    def mass_error(self) -> float:
        """A bound on the sum over the cells of the errors of their masses."""
        cells = self.basis.cells
        image = cells.high - cells.low
        if self.basis.noise is None and self.basis.map.max_error > 0.0:
            # A map within it may gather all paths in a point, however steep this one is.
            return 2.0
        if self.basis.noise is not None:
            left = 0.25 * float(np.max(cells.width * image)) * self.variation
            left = (left + cells.bend) / cells.halfwidth
        else:
            slowest = float(np.min(image / cells.width))
            crossed = float(np.sum(image / np.min(cells.width) + 1.0))
            off = LIFT * (TWO_PI + float(np.max(np.abs(cells.images))))
            left = 2.0 * (1.0 / TWO_PI + self.variation) * off * crossed / slowest + self._within
        return min(2.0, self._growth * (left + cells.rounding))

    @cached_property
    def _within(self) -> float:
        """A bound on ∫|p - Πp|."""
        return 0.5 * float(np.max(self.basis.cells.width)) * self.variation

    def density(self, theta: Array) -> Array:
        """The density after one more cycle, at angles, shape (m,); without noise the mean of the
        cell.
        """
        cells = self.basis.cells
        angle = np.mod(theta, TWO_PI)
        if self.basis.noise is None:
            cell = np.searchsorted(cells.start, angle, side="right") - 1
            return np.asarray((self.coefficients / cells.width)[cell])
        still = replace(cells, halfwidth=0.0)
        blocks = [
            self.coefficients @ still.between(block - cells.halfwidth, block + cells.halfwidth)
            for block in np.array_split(angle, 1 + angle.size // 1_000)
        ]
        return np.concatenate(blocks) / (2.0 * cells.halfwidth)

    def slope(self, theta: Array) -> Array:
        """The density's differences over a cell's length."""
        step = TWO_PI / self.basis.size
        return (self.density(theta + 0.5 * step) - self.density(theta - 0.5 * step)) / step

    @cached_property
    def density_error(self) -> float:
        """Bound on the density's error, per radian: cells whose image may lie across an end of the
        window.

        inf without noise: p may jump then.
        """
        if self.basis.noise is None:
            return float("inf")
        cells = self.basis.cells
        low = cells.low - cells.bend
        high = cells.high + cells.bend
        times = (
            np.floor((high[:, None] - low) / TWO_PI) - np.ceil((low[:, None] - low) / TWO_PI) + 1.0
        )
        return (float(np.max(self.coefficients @ times)) + self.mass_error) / cells.halfwidth

    def moment_error(self, order: int) -> float:
        """Bound on |∫ e^{i·order·θ} (p - p̃) dθ|."""
        varies = min(2.0, abs(order) * float(np.max(self.basis.cells.width)))
        return self.mass_error + 0.5 * varies * self._within + INTEGRAL

    def expectation(
        self,
        function: Function,
        rules: tuple[Rule, Rule] | None = None,
        direct: float = 0.0,
    ) -> Estimate:
        """E h by the cells' masses and the means of h; on ``rules``, for singular h, by the
        density.

        Bounds: the error of the masses times half of what h varies; ½∫|p - Πp| times the most that
        it does in a cell.
        """
        if rules is not None:
            means = [checked_values(function, theta) for theta, _ in rules]
            rough, value = (
                float(weight * self.density(theta) @ h)
                for (theta, weight), h in zip(rules, means, strict=True)
            )
            away = float(rules[1][1] @ np.abs(means[1] - np.median(means[1])))
            return Estimate(
                value, abs(value - rough) + (self.density_error * away if away > 0.0 else 0.0)
            )
        theta, weight = self.basis.rule
        values = checked_values(function, theta).reshape(-1, 3)
        mean = np.sum(values * weight.reshape(-1, 3), axis=1) / self.basis.cells.width
        varies = _OUTER * float(np.max(np.ptp(values, axis=1)))
        bound = 0.5 * (float(np.ptp(values)) * self.mass_error + varies * self._within)
        # What is left of the map's error where h depends on F itself.
        bound += direct * self.basis.map.max_error + INTEGRAL * float(np.max(np.abs(values)))
        return Estimate(float(self.coefficients @ mean), bound)

    def distance_from_uniform(self) -> Estimate:
        """½∫|p - 1/2π|: of the masses exactly."""
        distance = 0.5 * float(np.sum(np.abs(self.coefficients - self.basis.uniform)))
        return Estimate(distance, 0.5 * (self.mass_error + self._within))


def variation_of_expanding(circle_map: CircleMap) -> float:
    """V with Var p <= V for every stationary density of a map some power of which expands; else
    inf.

    Var(Lf) <= λ Var f + B ‖f‖₁ (Lasota & Yorke 1973): without breaks and folds λ = sup 1/|F'|, B =
    sup|(1/F')'|; with them λ is twice that, and B has 2 sup(1/|F'|) over the shortest branch
    besides. Then V = B/(1 - λ), the least of the first powers of F.
    """
    best = np.inf
    for power in range(1, _ITERATES + 1):
        iterate = nth_iterate(circle_map, power)
        is_broken = iterate.breaks.size > 0
        starts = np.sort(iterate.breaks) if is_broken else np.zeros(1)
        lengths = np.diff(starts, append=starts[0] + TWO_PI)
        counts = np.maximum(64, (_SAMPLES / TWO_PI * lengths).astype(np.int64))
        branch = np.repeat(np.arange(starts.size), counts)
        step = (lengths / counts)[branch]
        with np.errstate(divide="ignore"):
            contraction = 1.0 / iterate.derivative(starts[branch] + step * (ranks(counts) + 0.5))
        before = contraction[:-1]
        after = contraction[1:]
        inside = np.diff(branch) == 0
        if np.any(inside & (before * after < 0.0)):
            continue
        bent = _SAMPLED * float(np.max((np.abs(after - before) / step[1:])[inside]))
        inverse = float(np.max(np.abs(contraction))) + bent * TWO_PI / _SAMPLES
        rate = 2.0 * inverse if is_broken else inverse
        shortest = float(np.min(lengths)) if is_broken else np.inf
        if rate < 1.0:
            best = min(best, (bent + 2.0 * inverse / shortest) / (1.0 - rate))
    return best
