"""Normal noise on the circle."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from cyclemap.checks import finite_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array

_WIDE = 2.5  # radians: a wider law is summed in Fourier modes, not over its images
_ORDERS = np.arange(1.0, 9.0)  # the Fourier modes that a wide law has


@dataclass(frozen=True)
class WrappedNormal:
    """Normal noise of standard deviation ``sigma`` radians, wrapped round the circle: κ_m = exp(-m²σ²/2).

    Raises InvalidInput unless sigma is above zero (a noiseless map needs no noise object).
    (Mardia & Jupp, Directional Statistics, 2000, sec. 3.5.7.)

    >>> round(float(WrappedNormal(0.5).coefficients(2)), 12)
    0.606530659713
    """

    sigma: float

    def __post_init__(self) -> None:
        width = finite_number("sigma", self.sigma)
        if width <= 0.0:
            raise InvalidInput(f"sigma is {width:g}: noise needs a width above zero; leave the noise out for none")
        object.__setattr__(self, "sigma", width)

    @property
    def variance(self) -> float:
        """σ²."""
        return self.sigma**2

    def coefficients(self, m: Any) -> Array:
        """κ_m = exp(-m²σ²/2)."""
        order = np.asarray(m, dtype=np.float64)
        return np.asarray(np.exp(-0.5 * (order * self.sigma) ** 2))

    def coefficient_rates(self, m: Any) -> Array:
        """dκ_m/dσ = -m²σ κ_m."""
        order = np.asarray(m, dtype=np.float64)
        return np.asarray(-(order**2) * self.sigma * self.coefficients(order))

    def tail(self, m: int) -> float:
        """Sum over k > m of κ_k, bounded by the integral of exp(-x²σ²/2) from m."""
        return float(np.sqrt(0.5 * np.pi) / self.sigma * math.erfc(m * self.sigma / math.sqrt(2.0)))

    def density(self, x: Any) -> Array:
        """Density on the circle, per radian; rounding only."""
        if self.sigma < _WIDE:
            return self._over_images(self.line_density, x)
        waves = np.cos(np.multiply.outer(_reduced(x), _ORDERS)) @ self.coefficients(_ORDERS)
        return np.asarray((1.0 + 2.0 * waves) / TWO_PI)

    def slope(self, x: Any) -> Array:
        """d/dx of ``density``."""
        if self.sigma < _WIDE:
            return self._over_images(self.line_slope, x)
        waves = np.sin(np.multiply.outer(_reduced(x), _ORDERS)) @ (_ORDERS * self.coefficients(_ORDERS))
        return np.asarray(-waves / np.pi)

    def rate(self, x: Any) -> Array:
        """d/dσ of ``density``."""
        if self.sigma < _WIDE:
            return self._over_images(self.line_rate, x)
        return np.asarray(np.cos(np.multiply.outer(_reduced(x), _ORDERS)) @ self.coefficient_rates(_ORDERS) / np.pi)

    def line_density(self, x: Any) -> Array:
        """The normal density, per radian."""
        # In place: kernels between thousands of nodes are large, and fresh memory is slower than the arithmetic.
        density = np.array(x, dtype=np.float64)
        density /= self.sigma
        density *= density
        density *= -0.5
        np.exp(density, out=density)
        density /= self.sigma * np.sqrt(TWO_PI)
        return density

    def line_slope(self, x: Any) -> Array:
        """d/dx of ``line_density``: -x/σ² times it."""
        distance = np.asarray(x, dtype=np.float64)
        return np.asarray(-distance / self.sigma**2 * self.line_density(distance))

    def line_rate(self, x: Any) -> Array:
        """d/dσ of ``line_density``: (x²/σ² - 1)/σ times it."""
        distance = np.asarray(x, dtype=np.float64)
        return np.asarray(((distance / self.sigma) ** 2 - 1.0) / self.sigma * self.line_density(distance))

    def exceedance(self, x: Any) -> Array:
        """P(ξ > x)."""
        from scipy.special import log_ndtr  # slow to import, and seldom asked for

        return np.asarray(np.exp(log_ndtr(-np.asarray(x, dtype=np.float64) / self.sigma)))

    def exceedance_rate(self, x: Any) -> Array:
        """d/dσ P(ξ > x) = x/σ times ``line_density``."""
        distance = np.asarray(x, dtype=np.float64)
        return np.asarray(distance / self.sigma * self.line_density(distance))

    def arc_probability(self, low: Any, high: Any) -> Array:
        """P(ξ mod 2π in the arc from low to high), without cancellation where it is small."""
        near, beyond = _folded(low, high)
        above = self.exceedance(beyond)
        total = np.where(near < 0.0, 1.0 - self.exceedance(-near) - above, self.exceedance(near) - above)
        for turn in range(1, 2 + int(np.ceil(9.0 * self.sigma / TWO_PI))):
            shift = TWO_PI * turn
            total += self.exceedance(shift + near) - self.exceedance(shift + beyond)
            total += self.exceedance(shift - beyond) - self.exceedance(shift - near)
        return np.asarray(total)

    def arc_probability_rate(self, low: Any, high: Any) -> Array:
        """d/dσ of ``arc_probability``."""
        near, beyond = _folded(low, high)
        if self.sigma < _WIDE:
            parts = [self._over_images(self.exceedance_rate, end, reduce=False) for end in (near, beyond)]
            return np.asarray(parts[0] - parts[1])
        share = self.coefficient_rates(_ORDERS) / (np.pi * _ORDERS)
        waves = np.sin(np.multiply.outer(beyond, _ORDERS)) - np.sin(np.multiply.outer(near, _ORDERS))
        return np.asarray(waves @ share)

    def sample(self, rng: np.random.Generator, size: int | tuple[int, ...]) -> Array:
        """Normal draws, radians, not wrapped."""
        return np.asarray(rng.normal(0.0, self.sigma, size))

    def _over_images(self, function: Callable[[Array], Array], x: Any, reduce: bool = True) -> Array:
        """The sum of ``function`` over all x + 2πk near enough to count; x within [-2π, 2π] unless reduced."""
        angle = _reduced(x) if reduce else np.asarray(x, dtype=np.float64)
        reach = int(np.ceil((TWO_PI + 9.0 * self.sigma) / TWO_PI))
        return np.asarray(sum(function(angle + TWO_PI * turn) for turn in range(-reach, reach + 1)))


def _reduced(x: Any) -> Array:
    """The same angle in [-π, π]; small angles keep all their digits."""
    angle = np.asarray(x, dtype=np.float64)
    return np.asarray(angle - TWO_PI * np.round(angle / TWO_PI))


def _folded(low: Any, high: Any) -> tuple[Array, Array]:
    """The same arc seen from 0, mirrored so that its middle lies in [0, π]: its nearer and its farther end."""
    half = 0.5 * (np.asarray(high, dtype=np.float64) - low)
    far = np.abs(_reduced(low + half))
    return far - half, far + half
