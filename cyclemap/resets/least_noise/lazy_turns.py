"""The lazy extra turn: with probability q a uniformly random one, else none; its stationary law for every q at once."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cyclemap.maps.algebra.map_algebra import inverse
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.mixtures.law_distances import total_variation_on_grid
from cyclemap.maps.noise.noise_law import Noise
from cyclemap.maps.operator.discretisation import Discretisation
from cyclemap.maps.operator.operator_bounds import refined
from cyclemap.maps.operator.transfer_operator import transfer_operator

_CELLS = 4_096
_GRID = 4_096
_FORGOTTEN = 1e-9  # weight of the cycles beyond the last that is kept
_SAFETY = 2.0


@dataclass(frozen=True, eq=False)
class LazyTurns:
    """θ' = F(θ) + η, then with probability q a uniformly random orientation instead.

    The stationary law p = q u + (1 - q) L p is q Σ (1 - q)^k L^k u: the law after as many cycles as pass between two
    random turns. So TV(p, u) = (1 - q) TV(Lp, u) ≤ 1 - q, and, since L does not stretch TV, it is at most
    (1 - q)/q TV(Lu, u). It falls as q grows at least from q = ½ on: p_q' - u = (I - τR)(p_q - u) for q < q', with
    τ = (q' - q)/((1 - q) q') and R a transition operator that stays put with probability q' or more.
    Without own noise F must be invertible (InvalidInput otherwise, when first asked): L^k u then is exact.
    """

    circle_map: CircleMap
    own_noise: Noise | None
    _ends: list[Array] = field(default_factory=list, repr=False)

    def total_variation(self, q: float) -> Estimate:
        """TV(p, u). Own bound: the finer basis or grid (measured), and the cycles left out (proved)."""
        if q >= 1.0:
            return Estimate(0.0, 0.0)
        return self._with_noise(self.own_noise, q) if self.own_noise is not None else self._without_noise(q)

    def _without_noise(self, q: float) -> Estimate:
        last = int(np.ceil(np.log(_FORGOTTEN) / np.log1p(-q)))
        ends = self._pulled_back(last)
        weights = q * (1.0 - q) ** np.arange(last + 1)
        masses = np.abs(np.diff(np.tensordot(weights, ends[: last + 1], axes=1))) / TWO_PI
        rest = 1.0 - float(np.sum(weights))
        off = masses + (rest - 1.0) / masses.size
        fine = 0.5 * float(np.sum(np.abs(off)))
        coarse = 0.5 * float(np.sum(np.abs(off[::2] + off[1::2])))
        return Estimate(fine, _SAFETY * (fine - coarse) + rest + 1e-13)

    def _pulled_back(self, last: int) -> Array:
        """(last + 1 or more, cells + 1): F^-k of the cells' ends, lifted; the mass between is that of L^k u."""
        if not self._ends:
            self._ends.append(np.linspace(0.0, TWO_PI, _CELLS + 1))
        if len(self._ends) <= last:
            back = inverse(self.circle_map)
            while len(self._ends) <= last:
                before = self._ends[-1][:-1]
                images = back(before)
                self._ends.append(np.append(images, images[0] + TWO_PI * back.degree ** len(self._ends)))
        return np.asarray(self._ends)

    def _with_noise(self, own_noise: Noise, q: float) -> Estimate:
        basis = transfer_operator(self.circle_map, own_noise).discretisation
        found, bound = _solved(basis, q)
        finer = refined(basis)
        if finer is not None:
            bound += _SAFETY * abs(_solved(finer, q)[0] - found)
        return Estimate(found, bound + 1e-13)


def _solved(basis: Discretisation, q: float) -> tuple[float, float]:
    law = np.linalg.solve(np.eye(basis.size) - (1.0 - q) * basis.matrix, q * basis.uniform)
    grid = TWO_PI * np.arange(_GRID) / _GRID
    found, bound = total_variation_on_grid(basis.evaluate(grid) @ law - 1.0 / TWO_PI)
    return float(found), float(bound)
