"""Masses on small cells (Ulam 1960): for noise whose density jumps, and without noise for maps that
expand.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import INTEGRAL, LIFT, Estimate
from cyclemap.maps.lifts.branches import branches, preimages_on
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.map_algebra import nth_iterate
from cyclemap.maps.noise.noise import Noise
from cyclemap.maps.operator.fourier_basis import Complex, FourierDiscretisation
from cyclemap.maps.operator.poisson_equation import Rule, StationaryLaw, checked_values
from cyclemap.maps.passages.cell_passage import Cells, cells_between

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

    @property
    def halfwidth(self) -> float:
        """Of the noise, radians; 0 for none."""
        return 0.0 if self.noise is None else self.noise.jump

    @cached_property
    def cells(self) -> Cells:
        """The cells of the circle."""
        return cells_between(self.map, self.halfwidth, 0.0, TWO_PI, self.count)

    @property
    def size(self) -> int:
        """The number of cells."""
        return self.cells.width.size

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
        edges = self.cells.edges
        chances = (
            self._shares() if self.noise is None else self.cells.between(edges[:-1], edges[1:])
        )
        return np.ascontiguousarray((chances / chances.sum(axis=1)[:, None]).T)

    def _shares(self) -> Array:
        """(n, n): the length of each cell that the map alone sends to each, cut where F meets an
        edge.
        """
        edges = self.cells.edges
        levels, _ = preimages_on(branches(self.map), edges[:-1], self.map.degree)
        points = np.unique(np.concatenate([edges, levels, self.map.breaks]))
        middle = 0.5 * (points[1:] + points[:-1])
        image = np.mod(self.map(middle), TWO_PI)
        start, end = (
            np.searchsorted(edges[1:-1], angle, side="right") for angle in (middle, image)
        )
        shares = np.zeros((self.size, self.size))
        np.add.at(shares, (start, end), np.diff(points))
        return shares

    @cached_property
    def rule(self) -> tuple[Array, Array]:
        """Three Gauss nodes in each cell, and their weights."""
        nodes, weights = np.polynomial.legendre.leggauss(3)
        half = 0.5 * self.cells.width[:, None]
        return (self.cells.edges[:-1, None] + half * (1.0 + nodes)).ravel(), (
            half * weights
        ).ravel()

    def moments(self, order: int) -> Complex:
        """(n,), complex: the mean of e^{i·order·θ} in every cell."""
        width = self.cells.width
        edges = self.cells.edges
        turned = np.exp(0.5j * order * (edges[1:] + edges[:-1]))
        return np.asarray(turned * np.sinc(0.5 * order * width / np.pi))

    def cycle(self, law: Array) -> Array:
        """(n,): the masses after one cycle; or columns of several."""
        return self.matrix @ law

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
    (I - L̃)⁻¹ on masses. Then ‖Πp - p̃‖₁ <= G (‖ΠL(p - Πp)‖₁ + ‖Π(L - L̃)p‖₁), ``mass_error``. Under
    noise uniform on [-h, h] these are at most max(w·|image of a cell|) V/4h and ``bend``/h, V =
    1/h; without noise (w/2) V and, for the preimages of edges, on which the cells are cut, 2 sup p
    times what F may be off over inf |F'|, V the variation that an inequality of Lasota & Yorke
    gives. All that is proved; measured are G, ``bend`` and, without noise, sup|(1/F')'| and
    inf|F'|.
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
        basis = self.basis
        return 1.0 / basis.halfwidth if basis.halfwidth > 0.0 else variation_of_expanding(basis.map)

    @cached_property
    def mass_error(self) -> float:
        """A bound on the sum over the cells of the errors of their masses."""
        cells = self.basis.cells
        halfwidth = self.basis.halfwidth
        image = cells.high - cells.low
        if halfwidth > 0.0:
            left = (
                float(np.max(cells.width * image)) * self.variation / (4.0 * halfwidth)
                + cells.bend / halfwidth
            )
        else:
            slowest = float(np.min(image / cells.width))
            crossed = float(np.sum(image / np.min(cells.width) + 1.0))
            off = self.basis.map.max_error + LIFT * (TWO_PI + float(np.max(np.abs(cells.ends))))
            left = 0.5 * float(np.max(cells.width)) * self.variation
            left += 2.0 * (1.0 / TWO_PI + self.variation) * off * crossed / slowest
        return min(2.0, self._growth * (left + cells.rounding))

    @property
    def _within(self) -> float:
        """A bound on ∫|p - Πp|."""
        return 0.5 * float(np.max(self.basis.cells.width)) * self.variation

    def density(self, theta: Array) -> Array:
        """The density after one more cycle, at angles, shape (m,); without noise the mean of the
        cell.
        """
        cells = self.basis.cells
        halfwidth = self.basis.halfwidth
        if halfwidth == 0.0:
            cell = np.searchsorted(cells.edges, np.mod(theta, TWO_PI), side="right") - 1
            return (self.coefficients / cells.width)[np.minimum(cell, cells.width.size - 1)]
        angle = np.mod(theta, TWO_PI)
        still = replace(cells, halfwidth=0.0)
        blocks = [
            self.coefficients @ still.between(block - halfwidth, block + halfwidth)
            for block in np.array_split(angle, 1 + angle.size // 1_000)
        ]
        return np.concatenate(blocks) / (2.0 * halfwidth)

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
        cells = self.basis.cells
        halfwidth = self.basis.halfwidth
        if halfwidth == 0.0:
            return float("inf")
        low = cells.low - cells.bend
        high = cells.high + cells.bend
        most = 0.0
        for lines in np.array_split(low, 1 + low.size // 1_000):
            times = (
                np.floor((high[:, None] - lines) / TWO_PI)
                - np.ceil((low[:, None] - lines) / TWO_PI)
                + 1.0
            )
            most = max(most, float(np.max(self.coefficients @ times)))
        return (most + self.mass_error) / halfwidth

    @property
    def density_map_error(self) -> Array:
        """Nothing: ``bend`` holds what the map may be off."""
        return np.zeros(1)

    def moment_error(self, order: int) -> float:
        """Bound on |∫ e^{i·order·θ} (p - p̃) dθ|."""
        varies = min(2.0, abs(order) * float(np.max(self.basis.cells.width)))
        return self.mass_error + 0.5 * varies * self._within + INTEGRAL

    def map_error(self, moments: Array, direct: Array | float = 0.0) -> float:
        """What is left of ``max_error`` where h depends on F itself."""
        return self.basis.map.max_error * float(np.max(np.abs(direct)))

    def expectation(
        self,
        function: Callable[[Array], Array],
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
        bound = 0.5 * float(np.ptp(values)) * self.mass_error + INTEGRAL * float(
            np.max(np.abs(values))
        )
        bound += 0.5 * _OUTER * float(
            np.max(np.ptp(values, axis=1))
        ) * self._within + self.map_error(mean, direct)
        return Estimate(float(self.coefficients @ mean), bound)

    def distance_from_uniform(self) -> Estimate:
        """½∫|p - 1/2π|: of the masses exactly."""
        distance = 0.5 * float(np.sum(np.abs(self.coefficients - self.basis.uniform)))
        return Estimate(distance, 0.5 * (self.mass_error + self._within))

    def diffusion(self) -> Estimate:
        """Refused: InvalidInput."""
        raise InvalidInput(
            f"the noise is {self.basis.noise!r}: a diffusion constant is computed for "
            "WrappedNormal; else sample_staircases tells how paths spread"
        )


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
        starts = np.sort(iterate.breaks) if iterate.breaks.size else np.zeros(1)
        ends = np.append(starts[1:], starts[0] + TWO_PI)
        inverse = 0.0
        bent = 0.0
        for start, end in zip(starts, ends, strict=True):
            count = max(64, int(_SAMPLES * (end - start) / TWO_PI))
            theta = start + (end - start) * (np.arange(count) + 0.5) / count
            with np.errstate(divide="ignore"):
                contraction = 1.0 / iterate.derivative(theta)
            rate = np.abs(np.diff(contraction)) * count / (end - start)
            inverse = max(inverse, float(np.max(np.abs(contraction))))
            bent = max(bent, float(np.max(rate)))
            if np.any(contraction[1:] * contraction[:-1] < 0.0):
                inverse = np.inf
        inverse += _SAMPLED * bent * TWO_PI / _SAMPLES
        parts = 2.0 * inverse if iterate.breaks.size else inverse
        constant = _SAMPLED * bent
        if iterate.breaks.size:
            constant += 2.0 * inverse / float(np.min(ends - starts))
        if parts < 1.0:
            best = min(best, constant / (1.0 - parts))
    return best
