"""Expected share of equal sectors that a collection has visited, push by push, from the chain that avoids each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.checks import finite_number, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.mixtures.law_evolution import CycleOperator, basis_parts, fourier_basis, images_law
from cyclemap.maps.operator.fourier_discretisation import FourierDiscretisation
from cyclemap.maps.quadrature import arc_rule
from cyclemap.resets.scores.coverage_measures import DEFAULT_SECTORS

_MOST_NODES = 6_000
_STEEPNESS = 512  # angles at which slopes are compared


@dataclass(frozen=True, eq=False)
class SectorVisits:
    """Mean share of ``sectors`` equal sectors, from angle 0 on, visited in the first n pushes; n = 1, ..., pushes.

    stationary : (pushes,), from a start of the stationary law. uniform : from a uniform start. worst : from the
    worst start. worst_start : (pushes,), that start, radians, among the nodes. error_bound : (pushes,), measured: by
    how much the probabilities of one push, summed on the nodes, miss 1, and the modes cut off, times the pushes, and
    the stationary law's own error; the map's ``max_error`` is in the latter only.
    """

    sectors: int
    stationary: Array
    uniform: Array
    worst: Array
    worst_start: Array
    error_bound: Array


def sector_visits(
    operator: CycleOperator, pushes: int, sectors: int = DEFAULT_SECTORS, bounded: bool = True
) -> SectorVisits:
    """The expected share of sectors visited, exactly: no simulation.

    The chance u_n(θ) that none of the n pushes after θ falls in sector s obeys u_{n+1}(θ) = Σ_i w_i ∫ g(y - F_i(θ))
    1[y not in s] u_n(y) dy (the taboo kernel: Chung 1967), solved by Nyström's method on panels that end at the
    sectors' ends and the maps' breaks, for all sectors together. The first push counts as a visit.

    bounded : False leaves out the stationary law's bound; all bounds then are 1.
    Raises InvalidInput where the noise is so narrow that more than 6000 nodes would be needed.

    >>> from cyclemap.maps import CircleMap, WrappedNormal, transfer_operator
    >>> visits = sector_visits(transfer_operator(CircleMap.rigid(0.1), WrappedNormal(4.0)), 3, 2)
    >>> visits.stationary.round(3).tolist()
    [0.5, 0.75, 0.875]
    """
    count, number = whole_number("pushes", pushes, least=1), whole_number("sectors", sectors, least=2)
    basis = fourier_basis(operator)
    theta, weight = _nodes(basis, number)
    moves, outside = _transitions(basis, theta, theta, weight), _outside(theta, number)
    missed = float(np.max(np.abs(moves.sum(axis=1) - 1.0))) + 2.0 * basis.noise.tail(basis.modes)
    laws = np.stack([weight * operator.density(theta), weight / TWO_PI])
    settled = TWO_PI * operator.error_bound if bounded else float("inf")
    avoided, rows = outside, []
    for n in range(count):
        share = 1.0 - np.mean(avoided, axis=1)
        worst = int(np.argmin(share))
        error = missed * n + settled + 1e-13
        rows.append((*(laws @ share), share[worst], theta[worst], min(1.0, error)))
        avoided = outside * (moves @ avoided) if n + 1 < count else avoided
    return SectorVisits(number, *(read_only(part) for part in zip(*rows, strict=True)))


def sector_visits_from(operator: CycleOperator, start: float, pushes: int, sectors: int = DEFAULT_SECTORS) -> Array:
    """The same from the start ``start``, radians, which is the first push: (pushes,).

    >>> from cyclemap.maps import CircleMap, WrappedNormal, transfer_operator
    >>> sector_visits_from(transfer_operator(CircleMap.rigid(0.0), WrappedNormal(0.1)), 1.0, 1, 4).tolist()
    [0.25]
    """
    count, number = whole_number("pushes", pushes, least=1), whole_number("sectors", sectors, least=2)
    basis, begin = fourier_basis(operator), np.array([finite_number("start", start)])
    theta, weight = _nodes(basis, number)
    moves, first = _transitions(basis, theta, theta, weight), _transitions(basis, begin, theta, weight)
    outside, apart = _outside(theta, number), _outside(begin, number)
    avoided, found = outside, [1.0 - float(np.mean(apart))]
    for _ in range(count - 1):
        found.append(1.0 - float(np.mean(apart * (first @ avoided))))
        avoided = outside * (moves @ avoided)
    return read_only(found)


def _nodes(basis: FourierDiscretisation, sectors: int) -> tuple[Array, Array]:
    """Nodes and weights over one turn, fine enough for the steepest of the maps; panels end where sectors do."""
    grid = TWO_PI * np.arange(_STEEPNESS) / _STEEPNESS
    slopes = [np.hypot(1.0, np.max(np.abs(part.map.derivative(grid)))) for _, part in basis_parts(basis)]
    mean = np.hypot(1.0, np.max(np.abs(basis.map.derivative(grid))))
    cuts = TWO_PI * np.arange(1, sectors) / sectors
    bandwidth = basis.modes * float(max(slopes) / mean)
    theta, weight = arc_rule(basis.map, 0.0, TWO_PI, bandwidth, every_sample=False, cuts=cuts)
    if theta.size > _MOST_NODES:
        raise InvalidInput(f"the visits need {theta.size} nodes, more than {_MOST_NODES}: raise the noise")
    return theta, weight


def _outside(theta: Array, sectors: int) -> Array:
    """(nodes, sectors): 1 where the node is not in the sector, else 0."""
    owner = np.minimum((np.mod(theta, TWO_PI) * (sectors / TWO_PI)).astype(np.int64), sectors - 1)
    return np.asarray((owner[:, None] != np.arange(sectors)).astype(np.float64))


def _transitions(basis: FourierDiscretisation, start: Array, theta: Array, weight: Array) -> Array:
    """(starts, nodes): the probability that a push at a start is followed by one near a node."""
    laws = images_law(basis, start)
    return np.asarray((basis.evaluate(theta) @ laws).T * weight)
