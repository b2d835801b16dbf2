"""How many independent orientations the pushes of a collection are worth, for means of the first harmonics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cyclemap.checks import whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.arcs import Array
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.mixtures.law_evolution import CycleOperator, fourier_basis
from cyclemap.maps.operator.fourier_discretisation import FourierDiscretisation, waves
from cyclemap.maps.operator.operator_bounds import BorderedSystem

_ROUNDING = 1e-14


@dataclass(frozen=True, eq=False)
class EffectiveSize:
    """Independent draws from the stationary law that one push is worth; above 1 where pushes repel each other.

    pushes : of the collection that this holds for exactly; None in the limit of long ones.

    harmonics : the orders k looked at. each : for every k, that of the worst mean among a cos kθ + b sin kθ.
    worst : that of the worst mean among all their combinations together.
    Bounds are measured, against the same on a finer basis; a map's ``max_error`` is not in them.
    """

    harmonics: tuple[int, ...]
    pushes: int | None
    each: tuple[Estimate, ...]
    worst: Estimate

    def of(self, pushes: int) -> Estimate:
        """Independent orientations that ``pushes`` of the chain are worth for the worst mean."""
        count = whole_number("pushes", pushes, least=1)
        return Estimate(count * self.worst, count * self.worst.error_bound)


def effective_size(
    operator: CycleOperator, harmonics: Sequence[int] = (1, 2), pushes: int | None = None, bounded: bool = True
) -> EffectiveSize:
    """The effective sample size a push, from the sum of all autocorrelations, exactly.

    For h with E h = 0 under the stationary law, n·Var(mean of h over n pushes) = 2 E h z - E h² - (2/n) E h Py, with
    z - Pz = h (Poisson's equation) and y - Py = z - Pⁿz; the last term falls like 1/n (Gordin & Lifsic 1978, Sokal
    1997). An independent sample has E h². The worst combination solves a generalised eigenvalue problem of the two
    covariance matrices.

    operator : on Fourier modes. harmonics : different orders, at least 1 and at most the modes kept.
    pushes : n, of a collection with a stationary start; None for the limit of long ones.
    bounded : False leaves out the finer basis; the bounds then are inf.
    Raises InvalidInput for others, ConvergenceError where too few modes leave a law without variances.

    >>> from cyclemap.maps import CircleMap, WrappedCauchy, transfer_operator
    >>> worth = effective_size(transfer_operator(CircleMap.rigid(0.0), WrappedCauchy(0.5)))
    >>> round(worth.of(300), 9), round(worth.each[1], 9)
    (100.0, 0.6)
    """
    basis = fourier_basis(operator)
    orders = tuple(whole_number("harmonics", k, least=1) for k in harmonics)
    if not orders or len(set(orders)) < len(orders) or max(orders) > basis.modes:
        raise InvalidInput(f"harmonics is {list(harmonics)}: give different orders from 1 to {basis.modes}")
    found, bounds = _shares(*_covariances(basis, orders, pushes)), np.full(len(orders) + 1, np.inf)
    if bounded:
        bounds = np.abs(found - _shares(*_covariances(basis.refined(), orders, pushes)))
        bounds += _ROUNDING * (1.0 + np.abs(found))
    estimates = [Estimate(value, bound) for value, bound in zip(found.tolist(), bounds.tolist(), strict=True)]
    return EffectiveSize(orders, pushes, tuple(estimates[:-1]), estimates[-1])


def mean_covariance(operator: CycleOperator, order: int, pushes: int | None = None) -> tuple[Array, Array]:
    """n·Cov of the means of cos kθ and sin kθ over n pushes, and Cov for one push, each (2, 2); k = ``order``.

    pushes : n; None for the limit of long collections. See ``effective_size``.
    """
    return _covariances(fourier_basis(operator), (whole_number("order", order, least=1),), pushes)


def _covariances(basis: FourierDiscretisation, orders: tuple[int, ...], pushes: int | None) -> tuple[Array, Array]:
    """For cos k_1θ, sin k_1θ, cos k_2θ, ...: the covariance of means times n, and of one push."""
    system = BorderedSystem(basis)
    law = system.solve(basis.uniform)
    theta, weight = basis.rule()
    mass = weight * basis.on_nodes(law)
    rows = waves(theta, max(orders))
    places = np.array([[k, max(orders) + k] for k in orders]).ravel()
    centred = rows[places] - (rows[places] @ mass / mass.sum())[:, None]
    moments = np.array([part for k in orders for part in _real_rows(basis, k)]).T
    dual = system.dual(moments, law)
    later = basis.expected_after(dual).T
    if pushes is not None:
        count = whole_number("pushes", pushes, least=1)
        begun = system.dual(dual - np.linalg.matrix_power(basis.matrix.T, count) @ dual, law)
        later = later - basis.expected_after(begun).T / count
    together = (centred * mass) @ (centred + later).T
    single = (centred * mass) @ centred.T
    return together + together.T - single, single


def _real_rows(basis: FourierDiscretisation, order: int) -> tuple[Any, Any]:
    row = basis.moments(order)
    return row.real, row.imag


def _shares(means: Array, single: Array) -> Array:
    """The worst share of every pair of rows, then of all rows together."""
    from scipy.linalg import eigh

    if not np.all(np.linalg.eigvalsh(single) > 0.0):
        raise ConvergenceError(
            "the stationary law is too inaccurate for variances: keep more modes, or raise the noise"
        )
    pairs = [slice(at, at + 2) for at in range(0, len(single), 2)]
    times = [eigh(means[part, part], single[part, part], eigvals_only=True)[-1] for part in (*pairs, slice(None))]
    return np.array([1.0 / time if time > 0.0 else np.inf for time in times])
