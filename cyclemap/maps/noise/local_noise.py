"""Noise as robots have it: its size depends on where the angle is, and one cycle's kick resembles the last one's."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, finite_number
from cyclemap.errors import InvalidInput


@dataclass(frozen=True)
class LocalNoise:
    """Kicks ξ_n = σ(θ_n) z_n of sampled paths; z_n standard normal, with z_{n+1} = ρ z_n + √(1 - ρ²) ε_n.

    log_sigma : (2K + 1,) c_0, a_1, b_1, ...: log σ(θ) = c_0 + Σ a_k cos kθ + b_k sin kθ, σ in radians.
    correlation : ρ in [0, 1), of the kicks of successive cycles.

    It has no transfer operator: with a memory the angle alone is no state. `white` is what stands for it there.
    Raises InvalidInput for an even number of coefficients, or a correlation outside [0, 1).

    >>> LocalNoise((math.log(0.02), 0.5, 0.0), 0.7).sigma(math.pi / 2).round(12)
    np.float64(0.02)
    """

    log_sigma: tuple[float, ...]
    correlation: float = 0.0

    def __post_init__(self) -> None:
        coefficients = finite_array("log_sigma", self.log_sigma, ndim=1)
        if coefficients.size % 2 == 0:
            raise InvalidInput(f"log_sigma has {coefficients.size} coefficients: a constant and pairs of cos and sin")
        if not 0.0 <= finite_number("correlation", self.correlation) < 1.0:
            raise InvalidInput(f"the correlation of successive kicks is {self.correlation:g}: it must lie in [0, 1)")
        object.__setattr__(self, "log_sigma", tuple(coefficients.tolist()))

    def sigma(self, theta: Array | float) -> Array:
        """Return σ (...) at angles θ (...), radians."""
        c = np.array(self.log_sigma)
        order = np.arange(1, c.size // 2 + 1)
        angle = np.multiply.outer(theta, order)
        return np.asarray(np.exp(c[0] + np.cos(angle) @ c[1::2] + np.sin(angle) @ c[2::2]))

    def white(self, theta: float) -> float:
        """Return σ of the white noise that carries an angle about θ as far over many cycles, radians.

        The sum of n kicks has the variance n σ² (1 + ρ)/(1 - ρ), less a constant.
        """
        return float(self.sigma(theta)) * math.sqrt((1.0 + self.correlation) / (1.0 - self.correlation))

    def units(self, rng: np.random.Generator, shape: tuple[int, int], before: Array | None = None) -> Array:
        """Return z, shape (cycles, paths), of the next cycles; before : (paths,), that of the last one."""
        rho, fresh = self.correlation, rng.standard_normal(shape)
        z = np.empty_like(fresh)
        last = rng.standard_normal(shape[1]) if before is None else before
        for n in range(shape[0]):
            last = z[n] = rho * last + math.sqrt(1.0 - rho**2) * fresh[n]
        return z
