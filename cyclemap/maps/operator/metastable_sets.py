"""Metastable sets: the arcs of the circle that a noisy map seldom leaves, for reversible chains and all others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg import eigh

from cyclemap.checks import finite_array, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise_law import Noise
from cyclemap.maps.operator.arc_partition import best_cuts, leaving_chances
from cyclemap.maps.operator.stationary_flow import StationaryFlow
from cyclemap.maps.operator.transfer_operator import transfer_operator
from cyclemap.maps.passages.nystrom import KilledChain, killed_chain

MOST_SETS = 12
_CELLS = 180
_SLOW = 5.0  # cycles: a relaxation that is faster makes no set
_SEPARATION = 5.0  # ratio of successive relaxation times; pure diffusion on a circle has 4
_STRETCH = 1.3  # bandwidth of the second solution over that of the first
_REAL = 1e-4  # |arg λ| below which an eigenvalue counts as positive


@dataclass(frozen=True, eq=False)
class MetastableSets:
    """Made by ``metastable_sets``; k sets, the arcs between successive cuts.

    arcs : (k, 2), radians, sorted by start in [0, 2π), end > start. weights : (k,), stationary probabilities.
    transitions : (k, k), P(next in b | now in a) under the stationary law, rows sum to 1.
    leaving : (k,), 1 - staying, to full relative accuracy. relative_error : of weights and off-diagonal transitions,
    the largest difference from a solution on other nodes, times three (measured).
    staying_limit : no k sets whatever can have a larger sum of staying probabilities; see ``metastable_sets``.
    eigenvalues : complex, the operator's leading ones, by which the count was chosen.
    metastable : whether the spectrum shows this many sets; False with k = 1 says that there are none.
    """

    arcs: Array
    weights: Array
    transitions: Array
    leaving: Array
    relative_error: float
    staying_limit: float
    eigenvalues: npt.NDArray[np.complex128]
    metastable: bool

    @property
    def staying(self) -> Array:
        """(k,): P(next in the set | now in it) under the stationary law."""
        return np.asarray(1.0 - self.leaving)

    @property
    def residence_cycles(self) -> Array:
        """(k,): stationary mean number of cycles in a row spent in each set, 1/(1 - staying); inf for the circle."""
        with np.errstate(divide="ignore"):
            return np.asarray(1.0 / self.leaving)

    def index(self, theta: Any) -> npt.NDArray[np.int64]:
        """Which set each angle ``theta`` (radians, any turn, any shape) is in: 0, ..., k - 1."""
        angles = np.mod(finite_array("theta", theta) - self.arcs[0, 0], TWO_PI)
        return np.asarray(np.searchsorted(self.arcs[1:, 0] - self.arcs[0, 0], angles, side="right"), dtype=np.int64)


def metastable_sets(
    circle_map: CircleMap, noise: Noise, count: int | None = None, *, cells: int = _CELLS
) -> MetastableSets:
    """The division of the circle into arcs with the largest sum of staying probabilities.

    Σ_A P(θ' in A | θ in A) under the stationary law (Froyland & Dellnitz 2003; Huisinga & Schmidt 2006), over all
    divisions into k arcs: the global optimum on ``cells`` equal cells, by dynamic programming over the exact
    flow, refined to cuts anywhere by descent. Reversibility is not needed. The stationary law is eliminated without
    subtraction, so that sets left once in 1e100 cycles keep their digits.

    count : k, from 1 to 12; None takes it from the eigenvalues λ_2, λ_3, ... of the operator: where the relaxation
        times -1/ln|λ| fall by the largest factor, if it is 5 or more, the λ before it are positive and their times
        exceed 5 cycles; else k = 1, no metastability. λ near -1, or near other roots of 1, belong to sets that the path
        visits in turn: cyclic, and not found here.

    ``staying_limit`` is the sum of the k largest eigenvalues of the additive reversibilisation (K + K*)/2, K* the chain
    run backward: staying probabilities of K and of (K + K*)/2 agree, and for the latter it is a bound over all
    partitions (Huisinga & Schmidt 2006; Froyland 2005); so it holds for every chain.

    Raises InvalidInput for a count outside 1 to 12, too few cells, narrow noise, and ``UniformNoise``.

    >>> from cyclemap.maps.noise.noise_law import WrappedNormal
    >>> wells = CircleMap(lambda x: x - 0.4 * np.sin(2 * x), lambda x: 1 - 0.8 * np.cos(2 * x))
    >>> found = metastable_sets(wells, WrappedNormal(0.3))
    >>> np.round(found.arcs / np.pi, 6).tolist(), np.round(found.weights, 6).tolist()
    ([[0.5, 1.5], [1.5, 2.5]], [0.5, 0.5])
    """
    grid = whole_number("cells", cells, least=4 * MOST_SETS)
    chain, other = (_whole_chain(circle_map, noise, stretch) for stretch in (1.0, _STRETCH))
    eigenvalues = transfer_operator(circle_map, noise).eigenvalues(MOST_SETS + 1)
    shown = _count(eigenvalues)
    wanted = shown if count is None else whole_number("count", count, least=1)
    if wanted > MOST_SETS:
        raise InvalidInput(f"count is {wanted}: ask for at most {MOST_SETS} sets")
    flow, again = StationaryFlow.of(chain), StationaryFlow.of(other)
    cuts = np.zeros(1)
    if wanted > 1:
        cuts = flow.refined(best_cuts(leaving_chances(flow.between_cells(grid)), wanted) * TWO_PI / grid, TWO_PI / grid)
    return _described(flow, again, cuts, eigenvalues, wanted > 1 and wanted == shown)


def _described(
    flow: StationaryFlow,
    again: StationaryFlow,
    cuts: Array,
    eigenvalues: npt.NDArray[np.complex128],
    metastable: bool,
) -> MetastableSets:
    weights, moves = flow.between_arcs(cuts)
    off = ~np.eye(cuts.size, dtype=bool)
    found, check = (np.append(w, m[off]) for w, m in ((weights, moves), again.between_arcs(cuts)))
    leaving = np.sum(moves, axis=1, where=off)
    transitions = np.where(off, moves, np.diag(1.0 - leaving))
    return MetastableSets(
        read_only(np.stack([cuts, np.append(cuts[1:], cuts[0] + TWO_PI)], axis=1)),
        read_only(weights),
        read_only(transitions),
        read_only(leaving),
        3.0 * float(np.max(np.abs(found - check) / np.maximum(found, np.finfo(float).tiny))),
        _staying_limit(flow, cuts.size),
        eigenvalues,
        metastable,
    )


def _whole_chain(circle_map: CircleMap, noise: Noise, stretch: float) -> KilledChain:
    return killed_chain(circle_map, noise, ((0.0, TWO_PI),), (), False, every_sample=True, stretch=stretch)


def _count(eigenvalues: npt.NDArray[np.complex128]) -> int:
    """Number of sets that the spectrum shows; 1 for none."""
    modulus = np.clip(np.abs(eigenvalues), 1e-300, 1.0 - 1e-16)
    times = -1.0 / np.log(modulus)
    positive = np.cumprod(np.abs(np.angle(eigenvalues)) < _REAL).astype(bool)
    ratio = np.where(positive & (times > _SLOW), times / np.append(times[1:], np.inf), 0.0)
    ratio[0] = 0.0
    best = int(np.argmax(ratio))
    return best + 1 if ratio[best] >= _SEPARATION else 1


def _staying_limit(flow: StationaryFlow, count: int) -> float:
    """Sum of the largest eigenvalues of (K + K*)/2, symmetric in the stationary scalar product."""
    chain, mass = flow.chain, flow.mass
    used = np.flatnonzero(mass > 0.0)
    root = np.sqrt(mass[used])
    half = root[:, None] * chain.transitions(chain.images)[np.ix_(used, used)] / root
    last = used.size - 1
    values = eigh(0.5 * (half + half.T), eigvals_only=True, subset_by_index=(last - count + 1, last))
    return float(np.sum(values))
