"""One strategy while the surface wears: its transfer operator at some cycles, blended in between."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import read_only, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.wearing_loop import worn_loop
from cyclemap.errors import InvalidInput
from cyclemap.maps import Noise
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.law_evolution import complex_moments
from cyclemap.maps.mixtures.mixture_operator import mixture_operator
from cyclemap.maps.operator.fourier_discretisation import needed_modes
from cyclemap.mechanics import Material
from cyclemap.resets.robust.material_score import EVEN, QuickGrid, SampledCycles, independent_law, sample_cycles
from cyclemap.resets.strategies.strategy import ResetStrategy

Array = NDArray[np.float64]


def wear_path(material: Material, cycles: int, count: int, first: int = 0) -> tuple[Material, ...]:
    """Return the material as it is after `count` even numbers of cycles from `first` to `cycles`, each unchanging.

    Raises InvalidInput where it does not wear.

    >>> from cyclemap.mechanics import load_material
    >>> [one.name for one in wear_path(load_material("plywood-measured"), 2000, 3)][1:]
    ['plywood-measured after 1000 cycles', 'plywood-measured after 2000 cycles']
    """
    if material.wear is None:
        raise InvalidInput(f"{material.name} does not wear: its file has no table [worn]")
    places = np.linspace(first, whole_number("cycles", cycles, least=first), whole_number("count", count, least=1))
    return tuple(
        replace(material, name=f"{material.name} after {n:g} cycles", friction=material.friction_after(n), wear=None)
        for n in places.tolist()
    )


@dataclass(frozen=True, eq=False)
class WearStage:
    """A strategy from cycle `first` up to cycle `last`, which is no longer part of it.

    knots : (k,), cycles from `first` to `last`. matrices : (k, n, n), the operator of one cycle on Fourier
    coefficients (1, E cos mθ, E sin mθ) on the surface as it is there; in between they are blended linearly, which is a
    mixture of the two maps.
    """

    first: int
    last: int
    strategy: ResetStrategy
    knots: Array
    matrices: Array

    def __post_init__(self) -> None:
        for name in ("knots", "matrices"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def modes(self) -> int:
        """Fourier modes kept."""
        return int(self.matrices.shape[-1] // 2)

    def matrix(self, cycle: float) -> Array:
        """The operator (n, n) at a cycle."""
        before, after, share = self._between(cycle)
        return np.asarray((1.0 - share) * self.matrices[before] + share * self.matrices[after])

    def carried(self, law: Array, cycle: float) -> Array:
        """The coefficients of the law one cycle later, (n,) or (n, m)."""
        before, after, share = self._between(cycle)
        return np.asarray((1.0 - share) * (self.matrices[before] @ law) + share * (self.matrices[after] @ law))

    def frozen_law(self, cycle: float) -> FourierLaw:
        """The stationary law that the surface would have if it stopped wearing at a cycle."""
        return stationary_law(self.matrix(cycle))

    @property
    def blend_error(self) -> float:
        """Largest total variation between frozen laws at every second knot and those blended from its neighbours.

        With all knots the blend is about four times nearer. Zero where there are fewer than three knots.
        """
        pairs = [
            (stationary_law(self.matrices[k]), stationary_law(0.5 * (self.matrices[k - 1] + self.matrices[k + 1])))
            for k in range(1, len(self.knots) - 1, 2)
        ]
        return max((float(one.total_variation(other)) for one, other in pairs), default=0.0)

    def _between(self, cycle: float) -> tuple[int, int, float]:
        """The knots on both sides of a cycle, by number, and how far it lies from the one to the other, 0 to 1."""
        after = int(np.clip(np.searchsorted(self.knots, cycle, side="left"), 1, len(self.knots) - 1))
        width = float(self.knots[after] - self.knots[after - 1])
        share = 0.0 if width == 0.0 else (cycle - float(self.knots[after - 1])) / width
        return after - 1, after, min(max(share, 0.0), 1.0)


def wear_stage(
    loop: CollectionLoop, strategy: ResetStrategy, first: int, last: int, knots: int, noise: Noise, grid: QuickGrid
) -> WearStage:
    """Return a strategy between two cycles of a surface that wears, its operator computed at `knots` even cycles.

    With the grid's modes where all the laws are even enough for them, else with all that the noise lets through.
    """
    law, places = independent_law(strategy, grid.nodes), np.linspace(first, last, knots)
    cycles = [_cycles(worn_loop(loop, place), strategy, grid) for place in places.tolist()]

    def matrices(modes: int) -> Array:
        return np.array([mixture_operator(one.maps, law.weights, noise, modes).discretisation.matrix for one in cycles])

    found, most = matrices(grid.modes), needed_modes(noise)
    if grid.modes < most and max(_bias(matrix) for matrix in found) > EVEN:
        found = matrices(most)
    return WearStage(first, last, strategy, places, found)


def stationary_law(matrix: Array) -> FourierLaw:
    """The stationary law of an operator (n, n) on Fourier coefficients: (I - L) c = 0 with c_0 = 1.

    >>> stationary_law(np.diag([1.0, 0.5, 0.5])).moments.round(12).tolist()
    [(1+0j), 0j]
    """
    rest = np.linalg.solve(np.eye(len(matrix) - 1) - matrix[1:, 1:], matrix[1:, 0])
    return FourierLaw(complex_moments(np.concatenate([[1.0], rest])))


def _bias(matrix: Array) -> float:
    try:
        return float(stationary_law(matrix).total_variation())
    except InvalidInput:  # so few modes that the law is none
        return 1.0


def _cycles(loop: CollectionLoop, strategy: ResetStrategy, grid: QuickGrid) -> SampledCycles:
    prepared = strategy.prepared(loop)
    return sample_cycles(prepared, strategy.law(grid.nodes).actions, grid)
