"""Cycles that alternate by a fixed rule, or come in shuffled blocks: products of transfer operators."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np
import numpy.typing as npt

from cyclemap.checks import whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.law_evolution import (
    CycleOperator,
    complex_moments,
    fourier_basis,
    images_law,
    is_resolved,
    real_coefficients,
)
from cyclemap.maps.mixtures.start_ensemble import enough_starts
from cyclemap.maps.mixtures.start_grid import StartGrid, start_grid
from cyclemap.maps.mixtures.worst_start import WorstStart, farthest_start, worst_starts
from cyclemap.maps.operator.fourier_discretisation import FourierDiscretisation

_SHUFFLED = 8  # operators of a shuffled block: 2⁸ products


@dataclass(frozen=True, eq=False)
class PeriodicSchedule:
    """Cycles by the operators 1, 2, ..., k, again and again, or by all of them in a new random order in every block.

    operators : two or more transfer or mixture operators on Fourier modes. shuffled : False follows their order,
        a periodic schedule; True draws a permutation for every block of k cycles (a Latin block), at most 8.
    Laws are those of the orientation before each cycle, which is what a collection records.
    Raises InvalidInput for anything else.

    >>> from cyclemap.maps.lifts.circle_map import CircleMap
    >>> from cyclemap.maps.noise.noise_law import WrappedNormal
    >>> from cyclemap.maps.operator.transfer_operator import transfer_operator
    >>> turns = [transfer_operator(CircleMap.rigid(t), WrappedNormal(0.5)) for t in (0.1, 0.3)]
    >>> round(float(PeriodicSchedule(turns).spectral_gap), 9), round(float(1 - np.exp(-0.125)), 9)
    (0.117503097, 0.117503097)
    """

    operators: Sequence[CycleOperator]
    shuffled: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.operators, (tuple, list)) or len(self.operators) < 2:
            raise InvalidInput(f"operators is {self.operators!r}: give two or more, in the order of the cycles")
        object.__setattr__(self, "operators", tuple(self.operators))
        for operator in self.operators:
            fourier_basis(operator)
        if self.shuffled and len(self.operators) > _SHUFFLED:
            raise InvalidInput(f"a shuffled block of {len(self.operators)} cycles: at most {_SHUFFLED} can be followed")

    @property
    def period(self) -> int:
        """k, cycles a block."""
        return len(self.operators)

    @cached_property
    def matrix(self) -> Array:
        """(n, n): one block, on the Fourier coefficients of the operator with most modes."""
        return self._stages[-1]

    def laws(self) -> tuple[FourierLaw, ...]:
        """The stationary law before each of the k cycles of a block.

        Bounds: what each cycle leaves out of these laws on doubled modes and nodes, and the maps' ``max_error``, times
        the norm of (I - block)⁻¹ on coefficients; inf where modes that the noise lets through were cut off.
        """
        return tuple(FourierLaw(complex_moments(law), self._bound) for law in self._laws)

    def recorded_law(self) -> FourierLaw:
        """The law of an orientation drawn at random from a long collection: the mean of ``laws``."""
        laws = self.laws()
        return FourierLaw(np.mean([law.moments for law in laws], axis=0), max(law.error_bound for law in laws))

    def law_after(self, start: FourierLaw, cycles: int) -> FourierLaw:
        """The law after any number of cycles from a given law, its error bound not known (inf)."""
        count = whole_number("cycles", cycles, least=0)
        coefficients = _on_basis(start, self._modes)
        blocks, rest = divmod(count, self.period)
        coefficients = np.linalg.matrix_power(self.matrix, blocks) @ coefficients
        return FourierLaw(
            complex_moments(self._stages[rest - 1] @ coefficients if rest else coefficients), float("inf")
        )

    def worst(self, cycles: int, target: FourierLaw | None = None, starts: int | None = None) -> WorstStart:
        """Largest distances from ``target``, None for uniform, over all starts, after 1, ..., ``cycles`` cycles.

        The start is that of a block. Bounds as for ``StartEnsemble``.
        """
        count = whole_number("cycles", cycles, least=1)
        number = max(enough_starts(basis) for basis in self._bases) if starts is None else starts
        aim = FourierLaw.uniform() if target is None else target
        breaks = np.unique(np.concatenate([basis.map.breaks for basis in self._bases]))
        grid = start_grid(whole_number("starts", number, least=8), breaks)
        columns = self._first_block(grid)
        rows: list[tuple[float, ...]] = []
        while len(rows) < count:
            blocks = len(rows) // self.period + 1
            left = TWO_PI * blocks * self._left_a_block if np.isfinite(self._left_a_block) else float("inf")
            part = columns[: count - len(rows)]
            rows += [farthest_start(complex_moments(laws), grid, aim, left) for laws in part]
            columns = [stage @ columns[-1] for stage in self._stages]
        return worst_starts(rows)

    def eigenvalues(self, k: int) -> npt.NDArray[np.complex128]:
        """The k eigenvalues of a block of largest modulus, in falling order; the first is 1."""
        values = np.linalg.eigvals(self.matrix)
        return np.asarray(values[np.argsort(-np.abs(values), kind="stable")][: whole_number("k", k, least=1)])

    @cached_property
    def spectral_gap(self) -> Estimate:
        """1 - |λ₂|^(1/k), a cycle; the bound is not known: inf."""
        second = float(np.abs(self.eigenvalues(2)[1]))
        return Estimate(max(0.0, 1.0 - second ** (1.0 / self.period)), float("inf"))

    # -- inside --------------------------------------------------------------------------------------------

    @cached_property
    def _modes(self) -> int:
        return max(fourier_basis(operator).modes for operator in self.operators)

    @cached_property
    def _bases(self) -> tuple[FourierDiscretisation, ...]:
        """Those of the operators, on as many modes as the finest has."""
        found = (fourier_basis(operator) for operator in self.operators)
        return tuple(basis if basis.modes == self._modes else replace(basis, modes=self._modes) for basis in found)

    @cached_property
    def _stages(self) -> tuple[Array, ...]:
        """The matrices of the first 1, ..., k cycles of a block; shuffled: the mean over all orders."""
        matrices = [np.asarray(basis.matrix) for basis in self._bases]
        return _carried(matrices, matrices, self.shuffled)

    def _first_block(self, grid: StartGrid) -> list[Array]:
        """Coefficients of the laws 1, ..., k cycles after each of the starts: (n, starts) each."""
        matrices = [np.asarray(basis.matrix) for basis in self._bases]
        firsts = [images_law(basis, grid.angles, grid.from_left) for basis in self._bases]
        return list(_carried(matrices, firsts, self.shuffled))

    @cached_property
    def _bordered(self) -> Array:
        unit = np.zeros(self.matrix.shape[0])
        unit[0] = 1.0
        return np.asarray(np.eye(unit.size) - self.matrix + np.multiply.outer(unit, unit))

    @cached_property
    def _laws(self) -> tuple[Array, ...]:
        """Coefficients of the laws before each cycle of a block."""
        law = np.linalg.solve(self._bordered, _on_basis(FourierLaw.uniform(), self._modes))
        if not np.all(np.isfinite(law)):
            raise ConvergenceError("the stationary law is not unique to rounding: raise the noise")
        return (law, *(stage @ law for stage in self._stages[:-1]))

    @cached_property
    def _bound(self) -> float:
        if not np.isfinite(self._left_a_block):
            return float("inf")
        growth = float(np.linalg.norm(np.linalg.inv(self._bordered), 1))
        later = max(1.0, *(float(np.linalg.norm(stage, 1)) for stage in self._stages))
        return float(np.sqrt(2.0) * self._left_a_block * growth * later)

    @cached_property
    def _left_a_block(self) -> float:
        """Bound per radian on what the cycles of a block leave out of the stationary laws; inf where modes were cut."""
        if not all(is_resolved(basis) for basis in self._bases):
            return float("inf")
        if self.shuffled:
            return float(np.sum([np.mean([_left_out(basis, law) for basis in self._bases]) for law in self._laws]))
        return float(sum(_left_out(basis, law) for basis, law in zip(self._bases, self._laws, strict=True)))


def _left_out(basis: FourierDiscretisation, law: Array) -> float:
    """Bound per radian on what one cycle adds to the error of a law: quadrature, rounding, the map's error."""
    fine = basis.refined()
    density = fine.on_nodes(fine.padded(law, basis))
    missed = fine.carried(density) - fine.padded(basis.cycle(law), basis)
    moved = basis.map.max_error * float(np.sum(basis.kappa * basis.order))
    return fine.largest(missed) + (fine.left_out(density) + moved) / np.pi


def _carried(matrices: list[Array], firsts: list[Array], shuffled: bool) -> tuple[Array, ...]:
    """What 1, ..., k cycles make of a start, given what each cycle alone makes of it, ``firsts``."""
    if shuffled:
        return _mean_products(matrices, firsts)
    stages = [firsts[0]]
    for matrix in matrices[1:]:
        stages.append(matrix @ stages[-1])
    return tuple(stages)


def _mean_products(matrices: list[Array], firsts: list[Array]) -> tuple[Array, ...]:
    """For j = 1, ..., k: the mean over all orders of j different matrices, the first of them applied in ``firsts``."""
    count = len(matrices)
    known = {frozenset((i,)): first for i, first in enumerate(firsts)}
    stages = [np.mean(firsts, axis=0)]
    for size in range(2, count + 1):
        found: dict[frozenset[int], Array] = {}
        for chosen in combinations(range(count), size):
            kept = frozenset(chosen)
            found[kept] = np.sum([matrices[i] @ known[kept - {i}] for i in chosen], axis=0) / size
        known = found
        stages.append(np.mean(list(found.values()), axis=0))
    return tuple(stages)


def _on_basis(law: FourierLaw, modes: int) -> Array:
    return real_coefficients(law.moments, modes)
