"""The transfer operator of a random map: its stationary law, its spectrum and its mean winding."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.mixtures.mixture_discretisation import MixtureDiscretisation, mixture_discretisation
from cyclemap.maps.mixtures.random_map import RandomMap
from cyclemap.maps.noise.noise_law import Noise
from cyclemap.maps.operator.expectation import expected
from cyclemap.maps.operator.operator_bounds import law_error
from cyclemap.maps.operator.spectrum import Spectrum
from cyclemap.maps.operator.transfer_operator import TransferOperator


def mixture_operator(maps: Any, weights: Any, noise: Noise, modes: int | None = None) -> MixtureOperator:
    """The transfer operator of θ' = F_i(θ) + ξ, map i drawn anew in each cycle with probability w_i.

    It is the weighted mean of the maps' operators, L = Σ w_i L_i, on Fourier modes (see ``transfer_operator``).

    maps : one CircleMap or more, of one degree. weights : probabilities, one a map; None for equal ones.
    noise : any but ``UniformNoise`` alone; ``IndependentSum`` adds an extra random turn of any law.
    modes : keep this many Fourier modes instead of as many as the noise lets through.
    Raises InvalidInput for anything else.

    >>> from cyclemap.maps.lifts.circle_map import CircleMap
    >>> from cyclemap.maps.noise.noise_law import WrappedNormal
    >>> law = mixture_operator([CircleMap.rigid(0.1), CircleMap.rigid(0.3)], [0.25, 0.75], WrappedNormal(0.5))
    >>> round(law.rotation_number, 12), round(law.tv_from_uniform, 12)
    (0.25, 0.0)
    """
    random_map = RandomMap(maps, weights, noise)
    return MixtureOperator(random_map, mixture_discretisation(random_map, modes))


@dataclass(frozen=True, eq=False)
class MixtureOperator:
    """Made by ``mixture_operator``: answers what a ``TransferOperator`` does, but for what belongs to one map only.

    random_map : whose operator it is. discretisation : the basis on which it is a matrix.
    The bounds are those of ``TransferOperator``; to first order they let every map be off by the largest of the
    maps' ``max_error``, except in the spectrum.
    """

    random_map: RandomMap
    discretisation: MixtureDiscretisation

    @property
    def noise(self) -> Noise:
        """The noise of the cycle."""
        return self.random_map.noise

    @property
    def modes(self) -> int:
        """Fourier modes kept."""
        return self.discretisation.modes

    @cached_property
    def _operator(self) -> TransferOperator:
        """The machinery of one map, which sees the mixture through its discretisation only."""
        return TransferOperator(self.discretisation.map, self.noise, self.discretisation)

    # -- the stationary law --------------------------------------------------------------------------------

    def density(self, theta: Any) -> Array:
        """The stationary density per radian at ``theta`` (radians, any shape); see ``error_bound``."""
        return self._operator.density(theta)

    @property
    def error_bound(self) -> float:
        """Bound on the error of the stationary density, per radian, anywhere on the circle."""
        return self._operator.error_bound

    @property
    def is_certain(self) -> bool:
        """Whether the law is known to a tenth of the uniform density, or better."""
        return self._operator.is_certain

    def moment(self, n: int) -> complex:
        """E e^{inθ} of the stationary law; 0 beyond the modes kept. See ``moment_error``."""
        return self._operator.moment(n)

    def moment_error(self, n: int) -> float:
        """Bound on |error| of ``moment(n)``."""
        return self._operator.moment_error(n)

    def expectation(self, function: Callable[[Array], Array]) -> Estimate:
        """E function(θ) under the stationary law, for a function that is as smooth as the mean of the maps."""
        return self._operator.expectation(function)

    @cached_property
    def rotation_number(self) -> Estimate:
        """Mean winding in turns a cycle, Σ w_i E[F_i(θ) - θ]/2π; needs maps of degree 1, else InvalidInput."""
        if self.random_map.mean_map.degree != 1:
            degree = self.random_map.mean_map.degree
            raise InvalidInput(f"the maps have degree {degree}: their mean winding is not defined")
        system = self._operator._system
        error = law_error(system, self._operator._law)
        fine = self.discretisation.refined()
        found = bound = 0.0
        for (weight, part), (_, finer) in zip(self.discretisation.parts, fine.parts, strict=True):
            rules = part.rule(), finer.rule()
            mean = expected(error, part.map.turn, rules, 1.0)
            found, bound = found + weight * mean, bound + weight * mean.error_bound
        return Estimate(found / TWO_PI, bound / TWO_PI)

    @property
    def tv_from_uniform(self) -> Estimate:
        """Total variation distance of the law from uniform, ½ ∫ |density - 1/2π| dθ, in [0, 1]."""
        return self._operator.tv_from_uniform

    def peaks(self) -> Array:
        """Angles in [0, 2π) of the local maxima of the stationary density, sorted; none where it is uniform."""
        return self._operator.peaks()

    # -- the spectrum --------------------------------------------------------------------------------------

    def eigenvalues(self, k: int) -> npt.NDArray[np.complex128]:
        """The k eigenvalues of largest modulus, in falling order; the first is 1."""
        return self._operator.eigenvalues(k)

    def spectrum(self, k: int) -> Spectrum:
        """The same with error bounds, condition numbers and vectors; see ``Spectrum``."""
        return self._operator.spectrum(k)

    @property
    def spectral_gap(self) -> Estimate:
        """1 - |λ₂|, λ₂ the eigenvalue of second largest modulus."""
        return self._operator.spectral_gap

    @property
    def mixing_cycles(self) -> Estimate:
        """-1/ln|λ₂|: cycles in which the slowest departure from the law falls by e; ∞ if |λ₂| = 1."""
        return self._operator.mixing_cycles
