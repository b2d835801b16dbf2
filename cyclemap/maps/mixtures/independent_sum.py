"""The sum of independent noises: an extra random turn on top of a cycle's own noise."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NoReturn

import numpy as np

from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.noise.noise_law import Noise
from cyclemap.maps.operator.fourier_discretisation import needed_modes

_ENTRIES = 2_000_000  # angles times modes handled at a time


@dataclass(frozen=True, eq=False)
class IndependentSum:
    """ξ = ξ_1 + ... + ξ_k, independent and symmetric: κ_m is the product of theirs; for Fourier bases.

    parts : one noise or more, of which at least one has a summable tail (any but ``UniformNoise``).
    Densities and probabilities of arcs are Fourier sums: their accuracy is absolute, about 1e-15, not relative.
    What a Fourier basis does not ask for, on the real line or by one parameter, raises InvalidInput.
    Raises InvalidInput where no part is a noise, or where all are so rough or narrow that 2000 modes do not do.

    >>> from cyclemap.maps.noise.noise_law import UniformNoise, WrappedNormal
    >>> spread = IndependentSum((WrappedNormal(0.1), UniformNoise(np.pi)))
    >>> bool(np.max(np.abs(spread.coefficients([1, 2]))) < 1e-16), round(float(spread.density(1.0)) * 2 * np.pi, 12)
    (True, 1.0)
    """

    parts: tuple[Noise, ...]

    def __post_init__(self) -> None:
        parts = tuple(self.parts) if isinstance(self.parts, (tuple, list)) else ()
        if not parts or not all(isinstance(part, Noise) for part in parts):
            raise InvalidInput(f"parts is {self.parts!r}: give one noise or more")
        object.__setattr__(self, "parts", parts)
        needed_modes(self)

    @property
    def variance(self) -> float:
        """The sum of the variances, radians²."""
        return float(sum(part.variance for part in self.parts))

    def coefficients(self, m: Any) -> Array:
        """κ_m, the product of the parts'."""
        return np.asarray(np.prod([part.coefficients(m) for part in self.parts], axis=0))

    def tail(self, m: int) -> float:
        """A bound on the sum of |κ_k| over k > m: the least of the parts', since no other coefficient exceeds 1."""
        return min(part.tail(m) for part in self.parts)

    def density(self, x: Any) -> Array:
        """Density on the circle, per radian."""
        return self._series(x, np.cos, np.append(0.5, self._waves[1]) / np.pi)

    def slope(self, x: Any) -> Array:
        """d/dx of ``density``, per radian²."""
        return -self._series(x, np.sin, np.append(0.0, self._waves[0] * self._waves[1]) / np.pi)

    def arc_probability(self, low: Any, high: Any) -> Array:
        """P(ξ mod 2π in the arc from low to high), low < high < low + 2π; absolute accuracy."""
        factors = np.append(0.0, self._waves[1] / self._waves[0]) / np.pi
        length = (np.asarray(high, dtype=np.float64) - low) / TWO_PI
        found = length + self._series(high, np.sin, factors) - self._series(low, np.sin, factors)
        return np.asarray(np.clip(found, 0.0, 1.0))

    def sample(self, rng: np.random.Generator, size: int | tuple[int, ...]) -> Array:
        """Independent draws on the real line, radians."""
        return np.asarray(sum(part.sample(rng, size) for part in self.parts))

    @cached_property
    def _waves(self) -> tuple[Array, Array]:
        orders = np.arange(1.0, needed_modes(self) + 1.0)
        return orders, self.coefficients(orders)

    def _series(self, x: Any, wave: Any, factors: Array) -> Array:
        """Σ factors_m wave(mx), m from 0, any shape of x."""
        angles = np.mod(np.asarray(x, dtype=np.float64), TWO_PI)
        flat, orders = angles.ravel(), np.arange(float(factors.size))
        step = max(1, _ENTRIES // factors.size)
        sums = [wave(np.multiply.outer(flat[at : at + step], orders)) @ factors for at in range(0, flat.size, step)]
        return np.concatenate(sums).reshape(angles.shape) if sums else np.zeros(angles.shape)

    # -- refused -------------------------------------------------------------------------------------------

    def coefficient_rates(self, m: Any) -> Array:
        """Refused: InvalidInput; a sum has no one parameter."""
        self._refuse("one parameter to differentiate by")

    def rate(self, x: Any) -> Array:
        """Refused: InvalidInput."""
        self._refuse("one parameter to differentiate by")

    def line_density(self, x: Any) -> Array:
        """Refused: InvalidInput."""
        self._refuse("density on the real line")

    def line_slope(self, x: Any) -> Array:
        """Refused: InvalidInput."""
        self._refuse("density on the real line")

    def line_rate(self, x: Any) -> Array:
        """Refused: InvalidInput."""
        self._refuse("density on the real line")

    def exceedance(self, x: Any) -> Array:
        """Refused: InvalidInput."""
        self._refuse("law on the real line")

    def exceedance_rate(self, x: Any) -> Array:
        """Refused: InvalidInput."""
        self._refuse("law on the real line")

    def arc_probability_rate(self, low: Any, high: Any) -> Array:
        """Refused: InvalidInput."""
        self._refuse("one parameter to differentiate by")

    def _refuse(self, what: str) -> NoReturn:
        raise InvalidInput(f"a sum of noises offers no {what} here: only its law on the circle; ask its parts")
