"""Panels: functions on intervals of the line as Legendre polynomials, panel by panel, with their antiderivatives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from cyclemap.arrays import Array, Mask, Whole

ORDER = 24  # polynomials on each panel
_SLOPE_INSET = 1e-5  # how near a bent panel's end, in t, slopes are read
_EXTRA = 20  # further degrees that hold an antiderivative on a bent panel to rounding


@dataclass(frozen=True, eq=False)
class _Reference:
    """Tables on t in [-1, 1]; a pair has its entry for straight panels first, for bent ones second."""

    nodes: Array
    to_coefficients: Array
    antiderivative: Array  # (2, degrees, ORDER): of P_j dθ/dt per half-width, zero at t = -1
    gram: Array  # (2, ORDER, ORDER): ∫ P_i P_j dθ/dt per half-width
    slope_product: Array  # (ORDER, ORDER): ∫ P_i' P_j dt


@cache
def _reference() -> _Reference:
    nodes = np.asarray(legendre.leggauss(ORDER)[0], dtype=np.float64)
    degrees = np.arange(ORDER)
    # The inverse is good to rounding; with Gauss weights in its place 1e-14 would be lost.
    to_coefficients = np.asarray(np.linalg.inv(legendre.legvander(nodes, ORDER - 1)), dtype=np.float64)
    fine, fine_weights = legendre.leggauss(3 * ORDER)
    waves = legendre.legvander(fine, ORDER + _EXTRA - 1)
    stretches = np.stack([np.ones_like(fine), 0.5 * np.pi * np.cos(0.5 * np.pi * fine)])
    weighted = np.einsum("qi,sq,qj->sij", waves * fine_weights[:, None], stretches, waves[:, :ORDER])
    series = weighted * (np.arange(ORDER + _EXTRA) + 0.5)[:, None]
    antiderivative = np.stack([legendre.legint(part, lbnd=-1.0, axis=0) for part in series])
    # ∫ P_i' P_j dt is 2 where i - j is odd and positive.
    ahead = np.subtract.outer(degrees, degrees)
    slope_product = np.where((ahead > 0) & (ahead % 2 == 1), 2.0, 0.0)
    return _Reference(nodes, to_coefficients, antiderivative, weighted[:, :ORDER], slope_product)


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

    def halved(self) -> Panels:
        """Every panel cut in two at its middle."""
        middle = 0.5 * (self.start + self.end)
        start, end = np.stack([self.start, middle], axis=1), np.stack([middle, self.end], axis=1)
        return Panels(start.ravel(), end.ravel(), np.repeat(self.bent, 2))

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

    # -- integrals -----------------------------------------------------------------------------------------

    @cached_property
    def mass(self) -> Array:
        """(size,): the integral of every basis function."""
        per_half = _reference().gram[self.bent.astype(np.int64), 0]
        return np.asarray(self.half[:, None] * per_half).ravel()

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

    def derivative(self, primitive: Any) -> Any:
        """Coefficients of the derivative, in the weak sense, of a function of period one turn of panels.

        Its integrals against every P_k(t) of every panel are exact; where the derivative is infinite (at the end of
        a bent panel) or a point mass (where the function jumps) no other meaning is left.
        """
        tables, blocks = _reference(), np.asarray(primitive).reshape(self.count, ORDER)
        at_end = np.sum(blocks, axis=1)
        signs = (-1.0) ** np.arange(ORDER)
        moments = at_end[:, None] - np.roll(at_end, 1)[:, None] * signs - blocks @ tables.slope_product.T
        gram = tables.gram[self.bent.astype(np.int64)] * self.half[:, None, None]
        return np.linalg.solve(gram, moments[:, :, None]).reshape(self.size)

    def rule(self, cuts: Array, points: int) -> tuple[Array, Array]:
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
