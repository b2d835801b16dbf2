"""Symmetric noise added to the angle after each cycle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from scipy.special import erfc, log_ndtr

from cyclemap.checks import finite_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array

_TERMS = 8  # wrapped images each side that are summed directly


@runtime_checkable
class Noise(Protocol):
    """What the rest of the room asks of a noise ξ: symmetric about 0, with a density on the real line.

    A further law is one more class with these methods.
    """

    def coefficients(self, m: Any) -> Array:
        """κ_m = E e^{imξ}, real by symmetry; any whole m, any shape."""

    def tail(self, m: int) -> float:
        """A bound on the sum of |κ_k| over k > m."""

    def density(self, x: Any) -> Array:
        """Density on the circle, per radian, period 2π."""

    def line_density(self, x: Any) -> Array:
        """Density on the real line, per radian."""

    def exceedance(self, x: Any) -> Array:
        """P(ξ > x) on the real line, to full relative accuracy in the tail."""

    def arc_probability(self, low: Any, high: Any) -> Array:
        """P(ξ mod 2π in the arc from low to high), low < high < low + 2π; small values keep their digits."""

    def sample(self, rng: np.random.Generator, size: int | tuple[int, ...]) -> Array:
        """Independent draws on the real line, radians."""


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

    def coefficients(self, m: Any) -> Array:
        """κ_m = exp(-m²σ²/2)."""
        order = np.asarray(m, dtype=np.float64)
        return np.asarray(np.exp(-0.5 * (order * self.sigma) ** 2))

    def tail(self, m: int) -> float:
        """Sum over k > m of κ_k, bounded by the integral of exp(-x²σ²/2) from m."""
        return float(np.sqrt(0.5 * np.pi) / self.sigma * erfc(m * self.sigma / np.sqrt(2.0)))

    def density(self, x: Any) -> Array:
        """Density on the circle, per radian; rounding only."""
        angle = np.mod(np.asarray(x, dtype=np.float64) + np.pi, TWO_PI) - np.pi
        if self.sigma < 2.5:
            reach = int(np.ceil((np.pi + 9.0 * self.sigma) / TWO_PI))
            shifts = TWO_PI * np.arange(-reach, reach + 1)
            return np.asarray(sum(self.line_density(angle + shift) for shift in shifts))
        orders = np.arange(1, _TERMS + 1)
        waves = np.cos(np.multiply.outer(angle, orders)) @ self.coefficients(orders)
        return np.asarray((1.0 + 2.0 * waves) / TWO_PI)

    def line_density(self, x: Any) -> Array:
        """The normal density, per radian."""
        scaled = np.asarray(x, dtype=np.float64) / self.sigma
        return np.asarray(np.exp(-0.5 * scaled**2) / (self.sigma * np.sqrt(TWO_PI)))

    def exceedance(self, x: Any) -> Array:
        """P(ξ > x)."""
        return np.asarray(np.exp(log_ndtr(-np.asarray(x, dtype=np.float64) / self.sigma)))

    def arc_probability(self, low: Any, high: Any) -> Array:
        """P(ξ mod 2π in the arc from low to high), without cancellation where it is small."""
        half = 0.5 * (np.asarray(high, dtype=np.float64) - low)
        far = np.abs(np.mod(low + half + np.pi, TWO_PI) - np.pi)
        near, beyond = far - half, far + half
        above = self.exceedance(beyond)
        total = np.where(near < 0.0, 1.0 - self.exceedance(-near) - above, self.exceedance(near) - above)
        for turn in range(1, 2 + int(np.ceil(9.0 * self.sigma / TWO_PI))):
            shift = TWO_PI * turn
            total += self.exceedance(shift + near) - self.exceedance(shift + beyond)
            total += self.exceedance(shift - beyond) - self.exceedance(shift - near)
        return np.asarray(total)

    def sample(self, rng: np.random.Generator, size: int | tuple[int, ...]) -> Array:
        """Normal draws, radians, not wrapped."""
        return np.asarray(rng.normal(0.0, self.sigma, size))


@dataclass(frozen=True)
class WrappedCauchy:
    """Cauchy noise wrapped round the circle, mean resultant length ``r`` in (0, 1): κ_m = r^|m|.

    Its scale on the line is -ln r radians. (Mardia & Jupp 2000, sec. 3.5.7.) Möbius maps send wrapped
    Cauchy laws to wrapped Cauchy laws (McCullagh 1996), which makes them the exact check of a transfer
    operator.

    >>> float(WrappedCauchy(0.5).coefficients(-3))
    0.125
    """

    r: float

    def __post_init__(self) -> None:
        length = finite_number("r", self.r)
        if not 0.0 < length < 1.0:
            raise InvalidInput(f"r is {length:g}: the resultant length must lie between 0 and 1 (1 is no noise)")
        object.__setattr__(self, "r", length)

    @property
    def _scale(self) -> float:
        return float(-np.log(self.r))

    def coefficients(self, m: Any) -> Array:
        """κ_m = r^|m|."""
        return np.asarray(self.r ** np.abs(np.asarray(m, dtype=np.float64)))

    def tail(self, m: int) -> float:
        """Sum over k > m of κ_k, exactly."""
        return float(self.r ** (m + 1) / (1.0 - self.r))

    def density(self, x: Any) -> Array:
        """Density on the circle, per radian."""
        half = np.sin(0.5 * np.asarray(x, dtype=np.float64))
        return np.asarray((1.0 - self.r**2) / (TWO_PI * ((1.0 - self.r) ** 2 + 4.0 * self.r * half**2)))

    def line_density(self, x: Any) -> Array:
        """The Cauchy density, per radian."""
        scaled = np.asarray(x, dtype=np.float64) / self._scale
        return np.asarray(1.0 / (np.pi * self._scale * (1.0 + scaled**2)))

    def exceedance(self, x: Any) -> Array:
        """P(ξ > x)."""
        return np.asarray(np.arctan2(self._scale, np.asarray(x, dtype=np.float64)) / np.pi)

    def arc_probability(self, low: Any, high: Any) -> Array:
        """P(ξ mod 2π in the arc from low to high), from Σ r^k sin(kx)/k = arg(1/(1 - r e^{ix}))."""
        return self._primitive(high) - self._primitive(low)

    def _primitive(self, x: Any) -> Array:
        angle = np.asarray(x, dtype=np.float64)
        waves = np.arctan2(self.r * np.sin(angle), 1.0 - self.r * np.cos(angle))
        return np.asarray((0.5 * angle + waves) / np.pi)

    def sample(self, rng: np.random.Generator, size: int | tuple[int, ...]) -> Array:
        """Cauchy draws, radians, not wrapped: now and then many turns long."""
        return np.asarray(self._scale * rng.standard_cauchy(size))
