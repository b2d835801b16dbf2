"""Metastable sets: the arcs of the circle that a noisy map seldom leaves, for reversible chains and all others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from cyclemap.arrays import TWO_PI, Array, Whole
from cyclemap.checks import finite_array, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise import Noise
from cyclemap.maps.operator.transfer_operator import transfer_operator
from cyclemap.maps.passages.killed_chain import KilledChain, eliminated, killed_chain
from cyclemap.maps.quadrature import arc_rule


def leaving_chances(flow: Array) -> Array:
    """P(outside after a cycle | inside now) of every arc: shape (n, n), at [i, l - 1] for cells i, ..., i + l - 1.

    flow : (n, n), the stationary probability of being in cell i now and in cell j next, all >= 0. The last column, the
    whole circle, is 0. Nothing is subtracted, so small chances keep their digits.
    """
    size = flow.shape[0]
    chances = np.zeros((size, size))
    weight = flow.sum(axis=1)
    inside = np.arange(size)[:, None] <= np.arange(size - 1)
    for start in range(size):
        turned = np.roll(flow, (-start, -start), axis=(0, 1))
        beyond = np.cumsum(turned[:, :0:-1], axis=1)[:, ::-1]
        mass = np.cumsum(np.roll(weight, -start))[:-1]
        chances[start, :-1] = np.sum(beyond, axis=0, where=inside) / np.maximum(mass, np.finfo(float).tiny)
    return chances


def best_cuts(cost: Array, count: int) -> Whole:
    """First cells of the ``count`` arcs that divide the circle at least total cost, in rising order.

    cost : (n, n), of the arc of l cells from cell i at [i, l - 1]. The minimum over all choices is found: for each
    first cut, shortest paths of ``count`` arcs around the circle (Bellman 1957), O(count·n³) together.
    """
    size = cost.shape[0]
    behind, ahead = np.meshgrid(np.arange(size), np.arange(1, size + 1), indexing="ij")
    length = ahead - behind - 1
    least, best = np.inf, np.zeros(count, dtype=np.int64)
    for start in range(size):
        steps = np.where(length >= 0, cost[(start + behind) % size, np.maximum(length, 0)], np.inf)
        total, cuts = _shortest(steps, count)
        if total < least:
            least, best = total, (start + cuts) % size
    return np.sort(best)


def _shortest(steps: Array, count: int) -> tuple[float, Whole]:
    """The cheapest way from 0 to n in ``count`` steps; steps[l, j - 1] is the cost from l to j. Its points but n."""
    reached, came = steps[0], []
    for _ in range(count - 1):
        through = reached[:-1, None] + steps[1:]
        origin = np.argmin(through, axis=0)
        reached = through[origin, np.arange(origin.size)]
        came.append(origin + 1)
    at, cuts = steps.shape[0], []
    for origins in reversed(came):
        at = int(origins[at - 1])
        cuts.append(at)
    return float(reached[-1]), np.array([0, *reversed(cuts)], dtype=np.int64)


_FINER = 1.5  # bandwidth of flow times density over that of the chain's nodes


@dataclass(frozen=True, eq=False)
class StationaryFlow:
    """A chain on the whole circle and its stationary ``mass`` on the nodes, (n,), sum 1."""

    chain: KilledChain
    mass: Array

    @classmethod
    def of(cls, chain: KilledChain) -> StationaryFlow:
        """The flow of a chain that has no exits (Grassmann, Taksar & Heyman 1985: each entry keeps its digits)."""
        moves = chain.transitions(chain.images)
        return cls(chain, eliminated(moves, np.zeros(chain.theta.size)).stationary())

    def density(self, theta: Array) -> Array:
        """Stationary density per radian at ``theta``, shape (m,): ∫ p(x) g(θ - F(x)) dx."""
        return np.asarray(self.chain.noise.density(theta[:, None] - self.chain.images) @ self.mass)

    def between_cells(self, count: int) -> Array:
        """(count, count): probability of being in cell i now and in cell j next, cells of equal width from 0 on."""
        edges = np.linspace(0.0, TWO_PI, count + 1)
        ends = np.union1d(edges, self.chain.map.breaks)
        x, w = np.polynomial.legendre.leggauss(4)
        width = np.diff(ends)
        theta = (ends[:-1, None] + width[:, None] * (0.5 + 0.5 * x)).ravel()
        mass = self.density(theta) * (0.5 * width[:, None] * w).ravel()
        owner = np.searchsorted(edges, theta) - 1
        flow = np.zeros((count, count))
        images = self.chain.map(theta)[:, None]
        np.add.at(
            flow, owner, mass[:, None] * self.chain.noise.arc_probability(edges[:-1] - images, edges[1:] - images)
        )
        return flow

    def between_arcs(self, cuts: Array) -> tuple[Array, Array]:
        """Weights (k,) of the arcs between successive cuts, and P(next in b | now in a), (k, k)."""
        ends = np.append(cuts, cuts[0] + TWO_PI)
        weights, moves = np.empty(cuts.size), np.empty((cuts.size, cuts.size))
        for a in range(cuts.size):
            images, mass = self._on_arc(ends[a], ends[a + 1])
            weights[a] = mass.sum()
            for b in range(cuts.size):
                moves[a, b] = mass @ self._arrival(images, ends[b], ends[b + 1]) / weights[a]
        return weights / weights.sum(), moves

    def refined(self, cuts: Array, reach: float) -> Array:
        """Cuts within ``reach`` of the given ones with the least sum of chances of leaving, rising from [0, 2π).

        Each keeps less than half of its distance to the next, so that no arc vanishes.
        """
        from scipy.optimize import minimize

        scale = self._leaving(cuts)[0]
        ahead = np.minimum(1.0, 0.45 * np.diff(np.append(cuts, cuts[0] + TWO_PI)) / reach)

        def objective(shift: Array) -> tuple[float, Array]:
            total, slope = self._leaving(cuts + reach * shift)
            return total / scale, slope * reach / scale

        found = minimize(
            objective,
            np.zeros(cuts.size),
            jac=True,
            method="L-BFGS-B",
            bounds=list(zip(-np.roll(ahead, 1), ahead, strict=True)),
            options={"ftol": 1e-15, "gtol": 1e-10},
        )
        return np.sort(np.mod(cuts + reach * found.x, TWO_PI))

    def _leaving(self, cuts: Array) -> tuple[float, Array]:
        """Σ P(outside next | inside now) over the arcs between the cuts, and its slope by each cut."""
        total, slope = 0.0, np.zeros(cuts.size)
        ends = np.append(cuts, cuts[0] + TWO_PI)
        for a in range(cuts.size):
            images, mass = self._on_arc(ends[a], ends[a + 1])
            weight = mass.sum()
            chance = mass @ self._arrival(images, ends[a + 1], ends[a] + TWO_PI) / weight
            total += chance
            for end, sign in ((a, -1.0), (a + 1, 1.0)):
                here = self._end_slope(ends[end], ends[a], ends[a + 1], images, mass, chance)
                slope[end % cuts.size] += sign * here / weight
        return float(total), slope

    def _end_slope(self, at: float, start: float, end: float, images: Array, mass: Array, chance: float) -> float:
        """Weight times how fast a chance of leaving grows as the arc's end at ``at`` moves outward."""
        point = np.array([at])
        gone = self._arrival(self.chain.map(point), end, start + TWO_PI)[0]
        return float(self.density(point)[0] * (gone - chance) - mass @ self.chain.noise.density(at - images))

    def _on_arc(self, start: float, end: float) -> tuple[Array, Array]:
        theta, weight = arc_rule(self.chain.map, start, end, _FINER * self.chain.bandwidth)
        return self.chain.map(theta), weight * self.density(theta)

    def _arrival(self, images: Array, start: float, end: float) -> Array:
        if end - start >= TWO_PI:
            return np.ones_like(images)
        return self.chain.noise.arc_probability(start - images, end - images)


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
    eigenvalues : complex, the operator's leading ones, by which the count was chosen.
    metastable : whether the spectrum shows this many sets; False with k = 1 says that there are none.
    """

    arcs: Array
    weights: Array
    transitions: Array
    leaving: Array
    relative_error: float
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

    def index(self, theta: Any) -> Whole:
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

    Raises InvalidInput for a count outside 1 to 12, too few cells, narrow noise, and ``UniformNoise``.

    >>> from cyclemap.maps.noise.noise import WrappedNormal
    >>> wells = CircleMap(lambda x: x - 0.4 * np.sin(2 * x), lambda x: 1 - 0.8 * np.cos(2 * x))
    >>> found = metastable_sets(wells, WrappedNormal(0.3))
    >>> np.round(found.arcs / np.pi, 6).tolist(), np.round(found.weights, 6).tolist()
    ([[0.5, 1.5], [1.5, 2.5]], [0.5, 0.5])
    """
    grid = whole_number("cells", cells, least=4 * MOST_SETS)
    chain, other = (
        killed_chain(circle_map, noise, ((0.0, TWO_PI),), (), False, every_sample=True, stretch=stretch)
        for stretch in (1.0, _STRETCH)
    )
    eigenvalues = transfer_operator(circle_map, noise).eigenvalues(MOST_SETS + 1)
    shown = _count(eigenvalues)
    wanted = shown if count is None else whole_number("count", count, least=1)
    if wanted > MOST_SETS:
        raise InvalidInput(f"count is {wanted}: ask for at most {MOST_SETS} sets")
    flow, again = StationaryFlow.of(chain), StationaryFlow.of(other)
    cuts = np.zeros(1)
    if wanted > 1:
        cuts = flow.refined(best_cuts(leaving_chances(flow.between_cells(grid)), wanted) * TWO_PI / grid, TWO_PI / grid)
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
        eigenvalues,
        wanted > 1 and wanted == shown,
    )


def _count(eigenvalues: npt.NDArray[np.complex128]) -> int:
    """Number of sets that the spectrum shows; 1 for none."""
    modulus = np.clip(np.abs(eigenvalues), 1e-300, 1.0 - 1e-16)
    times = -1.0 / np.log(modulus)
    positive = np.cumprod(np.abs(np.angle(eigenvalues)) < _REAL).astype(bool)
    ratio = np.where(positive & (times > _SLOW), times / np.append(times[1:], np.inf), 0.0)
    ratio[0] = 0.0
    best = int(np.argmax(ratio))
    return best + 1 if ratio[best] >= _SEPARATION else 1
