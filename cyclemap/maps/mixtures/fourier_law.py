"""A law on the circle as its trigonometric moments: what cycles and independent turns do to it, and its distances."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from cyclemap.checks import finite_array, non_negative_number, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.mixtures.law_distances import (
    cumulative_on_grid,
    density_on_grid,
    total_variation_on_grid,
    wasserstein_on_grid,
)
from cyclemap.maps.noise.noise_law import Noise

_FINENESS = 32  # grid points a mode in distances
_LEAST_GRID = 1024
_ENTRIES = 2_000_000
_REFINED = 256  # points of the grid about which a maximum is sought once more
_SPLIT = 64


@dataclass(frozen=True, eq=False)
class FourierLaw:
    """The law with moments c_m = E e^{imθ}, m = 0, ..., M: density (1 + 2 Re Σ c_m e^{-imθ})/2π.

    moments : shape (M + 1,), complex, the first 1. error_bound : on the density, per radian, anywhere; inf where
    nothing is known. Raises InvalidInput where the first moment is not 1 or another exceeds 1.

    >>> tilted = FourierLaw(np.array([1.0, 0.5]))
    >>> round(float(tilted.density(0.0)) * 2 * np.pi, 12), round(float(FourierLaw.uniform().density(1.0)), 6)
    (2.0, 0.159155)
    """

    moments: Any
    error_bound: float = 0.0

    def __post_init__(self) -> None:
        moments = np.array(self.moments, dtype=np.complex128)
        if moments.ndim != 1 or moments.size == 0 or not np.all(np.isfinite(moments)):
            raise InvalidInput(f"moments has shape {moments.shape}: give finite E e^{{imθ}} for m = 0, 1, ...")
        if abs(moments[0] - 1.0) > 1e-9 or float(np.max(np.abs(moments))) > 1.0 + 1e-6:
            raise InvalidInput(f"moments begins with {moments[:2]}: the first is 1 and none exceeds 1 in modulus")
        moments.setflags(write=False)
        object.__setattr__(self, "moments", moments)
        bound = self.error_bound
        object.__setattr__(self, "error_bound", bound if bound == np.inf else non_negative_number("error_bound", bound))

    @classmethod
    def uniform(cls) -> FourierLaw:
        """The uniform law."""
        return cls(np.ones(1, dtype=np.complex128))

    @classmethod
    def from_density(cls, density: Callable[[Array], Array], modes: int = 512) -> FourierLaw:
        """The law with a density per radian, a vectorised callable of period 2π, scaled to mass 1.

        By the trapezoidal rule on 8·modes points; ``error_bound`` is the largest misfit of the modes on twice as
        many points: all that is cut off, where the density is smooth.
        """
        count = 8 * whole_number("modes", modes, least=1)
        grid = TWO_PI * np.arange(count) / count
        values = finite_array("the density's values", density(grid))
        if values.shape != grid.shape:
            raise InvalidInput(f"the density gave shape {values.shape} for {grid.shape}: it must be vectorised")
        total = float(np.mean(values)) * TWO_PI
        if not 0.99 < total < 1.01:
            raise InvalidInput(f"the density integrates to {total:g} over the circle, not 1: give it per radian")
        moments = np.conj(np.fft.rfft(values)[: modes + 1]) / np.sum(values)
        there = np.append(grid, grid + 0.5 * grid[1])
        return cls(moments, float(np.max(np.abs(cls(moments).density(there) - density(there) / total))))

    @property
    def modes(self) -> int:
        """M."""
        return int(self.moments.size - 1)

    def density(self, theta: Any) -> Array:
        """Density per radian at ``theta``, radians, any shape."""
        angles = finite_array("theta", theta)
        flat, orders = angles.ravel(), np.arange(self.modes + 1)
        factors = np.conj(self.moments) * np.where(orders == 0, 1.0, 2.0) / TWO_PI
        step = max(1, _ENTRIES // orders.size)
        parts = [
            np.real(np.exp(1j * np.multiply.outer(flat[at : at + step], orders)) @ factors)
            for at in range(0, flat.size, step)
        ]
        return np.concatenate(parts).reshape(angles.shape) if parts else np.zeros(angles.shape)

    def turned_by(self, noise: Noise) -> FourierLaw:
        """The law of θ + ξ, ξ an independent random turn: moments multiply. Any noise, uniform too.

        >>> from cyclemap.maps.noise.noise_law import UniformNoise
        >>> bool(abs(FourierLaw(np.array([1.0, 0.9])).turned_by(UniformNoise(np.pi)).moments[1]) < 1e-15)
        True
        """
        if not isinstance(noise, Noise):
            raise InvalidInput(f"the noise is {noise!r}: give the law of the turn, for example UniformNoise(0.5)")
        return FourierLaw(self.moments * noise.coefficients(np.arange(self.modes + 1)), self.error_bound)

    # -- distances -----------------------------------------------------------------------------------------

    def total_variation(self, other: FourierLaw | None = None) -> Estimate:
        """½ ∫ |p - q| dθ from another law, None for uniform, in [0, 1]; the bound counts both laws' and the grid's."""
        difference, bound = self._less(other)
        found, grid = total_variation_on_grid(density_on_grid(difference, _grid_size(difference.size)))
        return Estimate(min(1.0, float(found)), min(1.0, float(grid) + np.pi * bound))

    def wasserstein(self, other: FourierLaw | None = None) -> Estimate:
        """W1 on the circle, radians, in [0, π/2] from uniform and [0, π] from another law; bound as above.

        A density off by e everywhere moves W1 by at most π²·e: π times its mass, which is half of 2π·e.
        """
        difference, bound = self._less(other)
        found, grid = wasserstein_on_grid(cumulative_on_grid(difference, _grid_size(difference.size)))
        return Estimate(float(found), min(np.pi, float(grid) + np.pi**2 * bound))

    def peak_to_mean(self) -> Estimate:
        """Largest density over 1/2π, ≥ 1, with Bernstein's bound on what lies between the points it is sought on.

        >>> round(FourierLaw(np.array([1.0, 0.5])).peak_to_mean(), 9)
        2.0
        """
        count = _grid_size(self.moments.size)
        values = TWO_PI * density_on_grid(self.moments, count)
        top = float(np.max(values))
        # Near its maximum a density falls by at most ½ M² max|p - mean| d²; the grid is never further than π/count.
        between = 0.51 * (self.modes * np.pi / count) ** 2 * max(top - 1.0, 1.0 - float(np.min(values)))
        near = np.flatnonzero(values >= top - between)
        if near.size <= _REFINED:
            offsets = TWO_PI / count * np.linspace(-0.5, 0.5, _SPLIT + 1)
            finer = np.add.outer(TWO_PI * near / count, offsets)
            top, between = max(top, TWO_PI * float(np.max(self.density(finer)))), between / _SPLIT**2
        return Estimate(max(1.0, top), between + TWO_PI * self.error_bound)

    def _less(self, other: FourierLaw | None) -> tuple[npt.NDArray[np.complex128], float]:
        minus = FourierLaw.uniform() if other is None else other
        if not isinstance(minus, FourierLaw):
            raise InvalidInput(f"the other law is {other!r}: give a FourierLaw, or None for uniform")
        difference = np.zeros(max(self.moments.size, minus.moments.size), dtype=np.complex128)
        difference[: self.moments.size] += self.moments
        difference[: minus.moments.size] -= minus.moments
        difference[0] = 0.0
        return difference, self.error_bound + minus.error_bound


def _grid_size(moments: int) -> int:
    return max(_LEAST_GRID, 1 << int(np.ceil(np.log2(_FINENESS * moments))))
