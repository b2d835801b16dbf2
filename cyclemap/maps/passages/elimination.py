"""Elimination without subtraction of a chain that may leave its states: tiny chances of leaving keep their digits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.linalg import solve_triangular

from cyclemap.maps.arcs import Array

_BLOCK = 48  # unknowns eliminated together
_VISITS = 64  # cycles after which the states are ranked by how often they are visited


@dataclass(frozen=True, eq=False)
class Elimination:
    """I - q = (I - U)(D - L) on the states in ``order``; the most visited is first, and eliminated last.

    ``packed`` (n, n) holds -U above the diagonal, D on it and -L below it; U, L >= 0.
    """

    packed: Array
    out: Array
    order: npt.NDArray[np.int64]

    @property
    def leaves(self) -> bool:
        """Whether every state is left in the end, in floating point."""
        return bool(np.all(np.diag(self.packed) > 0.0))

    def solve(self, reward: Array) -> Array:
        """(I - q)⁻¹ reward: what is collected on average until the chain leaves; shape (n,) or (n, columns)."""
        after = _triangular(self.packed, reward[self.order], upper=True)
        return self._restored(_triangular(self.packed, after))

    def visits(self, mass: Array) -> Array:
        """mass (I - q)⁻¹: mean numbers of visits of a chain that starts with ``mass`` on the states."""
        after = _triangular(self.packed, mass[self.order], transposed=True)
        return self._restored(_triangular(self.packed, after, upper=True, transposed=True))

    def stationary(self) -> Array:
        """The stationary law of a chain that never leaves, sum 1, each entry to full relative accuracy."""
        first = np.zeros(self.order.size)
        first[0] = 1.0
        law = _triangular(self.packed, first, upper=True, transposed=True)
        return self._restored(law / law.sum())

    def expected(self, reward: Array) -> tuple[Array, float, Array]:
        """x = (I - q)⁻¹ reward; x at the most visited state; and its differences from that, with their own digits."""
        sources = np.stack([reward[self.order], self.out], axis=1)
        collected, gone = _triangular(self.packed, sources, upper=True).T
        if not self.leaves:
            return np.full(reward.size, np.inf), np.inf, np.full(reward.size, np.nan)
        values = _triangular(self.packed, collected)
        # Before the first visit to that state: what is collected, and the chance of leaving.
        before = _triangular(self.packed[1:, 1:], np.stack([collected[1:], gone[1:]], axis=1))
        change = before[:, 0] - values[0] * before[:, 1]
        return self._restored(values), float(values[0]), self._restored(np.append(0.0, change))

    def returns(self) -> Array:
        """The chance of visiting the most visited state before leaving; 1 for that state itself."""
        before = _triangular(self.packed[1:, 1:], -self.packed[1:, 0])
        return self._restored(np.append(1.0, before))

    def _restored(self, ordered: Array) -> Array:
        values = np.empty_like(ordered)
        values[self.order] = ordered
        return values


def eliminated(q: Array, out: Array) -> Elimination:
    """Grassmann-Taksar-Heyman elimination (1985), in blocks: without a difference, so small chances keep their digits.

    q : (n, n) chances of going from i to j (the diagonal is not used); out : (n,) of leaving. Every entry of what
    it solves has a small relative error whatever the sizes (O'Cinneide 1993).
    """
    order = _by_visits(q)
    work, left = q[np.ix_(order, order)], out[order]
    for high in range(left.size, 0, -_BLOCK):
        low = max(0, high - _BLOCK)
        _eliminate_block(work, left, low, high)
        work[:low, :low] += work[:low, low:high] @ work[low:high, :low]
    pivot = np.diag(work).copy()
    packed = np.negative(work, out=np.empty_like(work, order="F"))
    np.fill_diagonal(packed, pivot)
    return Elimination(packed, out[order], order)


def _eliminate_block(work: Array, left: Array, low: int, high: int) -> None:
    """Eliminate the states of a block among themselves, then towards those before it; all sums are of >= 0."""
    inside = slice(low, high)
    block, away = work[inside, inside], left[inside] + work[inside, :low].sum(axis=1)
    for k in range(high - low - 1, -1, -1):
        pivot = away[k] + np.sum(block[k, :k])
        share = block[:k, k] / pivot if pivot > 0.0 else np.zeros(k)
        block[k, k], block[:k, k] = pivot, share
        block[:k, :k] += np.multiply.outer(share, block[k, :k])
        away[:k] += share * away[k]
    pivots = np.diag(block)
    factors = np.diag(np.where(pivots > 0.0, pivots, np.inf)) - np.tril(block, -1) - np.triu(block, 1)
    left[inside] = _triangular(factors, left[inside], upper=True)
    work[inside, :low] = _triangular(factors, work[inside, :low], upper=True)
    work[:low, inside] = _triangular(factors, work[:low, inside].T, transposed=True).T
    left[:low] += work[:low, inside] @ left[inside]


def _by_visits(q: Array) -> npt.NDArray[np.int64]:
    """States in falling order of visits: each that is eliminated then has a fair chance to go to one that is not."""
    mass = np.full(q.shape[0], 1.0 / q.shape[0])
    for _ in range(_VISITS):
        mass = mass @ q
        mass /= max(mass.sum(), np.finfo(float).tiny)
    return np.argsort(-mass, kind="stable")


def _triangular(packed: Array, values: Array, *, upper: bool = False, transposed: bool = False) -> Array:
    """Solve with the unit upper factor, or with the lower one; nothing cancels when ``values`` >= 0."""
    if packed.shape[0] == 0:
        return values
    trans = "T" if transposed else "N"
    return np.asarray(
        solve_triangular(packed, values, trans=trans, lower=not upper, unit_diagonal=upper, check_finite=False)
    )
