"""Cauchy noise on the circle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cyclemap.checks import finite_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array


@dataclass(frozen=True)
class WrappedCauchy:
    """Cauchy noise wrapped round the circle, mean resultant length ``r`` in (0, 1): κ_m = r^|m|.

    Its scale on the line is s = -ln r radians. (Mardia & Jupp 2000, sec. 3.5.7.) Möbius maps send wrapped
    Cauchy laws to wrapped Cauchy laws (McCullagh 1996), which makes them the exact check of a transfer
    operator. Raises InvalidInput unless 0 < r < 1.

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
    def variance(self) -> float:
        """Infinite: a Cauchy law has none."""
        return float("inf")

    @property
    def _scale(self) -> float:
        return float(-np.log(self.r))

    def coefficients(self, m: Any) -> Array:
        """κ_m = r^|m|."""
        return np.asarray(self.r ** np.abs(np.asarray(m, dtype=np.float64)))

    def coefficient_rates(self, m: Any) -> Array:
        """dκ_m/dr = |m| r^(|m| - 1)."""
        order = np.abs(np.asarray(m, dtype=np.float64))
        return np.asarray(order * self.r ** (order - 1.0))

    def tail(self, m: int) -> float:
        """Sum over k > m of κ_k, exactly."""
        return float(self.r ** (m + 1) / (1.0 - self.r))

    def density(self, x: Any) -> Array:
        """Density on the circle, per radian."""
        return np.asarray((1.0 - self.r**2) / (TWO_PI * self._distance(x)))

    def slope(self, x: Any) -> Array:
        """d/dx of ``density``."""
        push = 2.0 * self.r * np.sin(np.asarray(x, dtype=np.float64))
        return np.asarray(-(1.0 - self.r**2) * push / (TWO_PI * self._distance(x) ** 2))

    def rate(self, x: Any) -> Array:
        """d/dr of ``density``."""
        half = np.sin(0.5 * np.asarray(x, dtype=np.float64)) ** 2
        excess = (1.0 - self.r) ** 2 - 2.0 * (1.0 + self.r**2) * half
        return np.asarray(excess / (np.pi * self._distance(x) ** 2))

    def _distance(self, x: Any) -> Array:
        """|1 - r e^{ix}|²."""
        half = np.sin(0.5 * np.asarray(x, dtype=np.float64))
        return np.asarray((1.0 - self.r) ** 2 + 4.0 * self.r * half**2)

    def line_density(self, x: Any) -> Array:
        """The Cauchy density, per radian."""
        scaled = np.asarray(x, dtype=np.float64) / self._scale
        return np.asarray(1.0 / (np.pi * self._scale * (1.0 + scaled**2)))

    def line_slope(self, x: Any) -> Array:
        """d/dx of ``line_density``."""
        scaled = np.asarray(x, dtype=np.float64) / self._scale
        return np.asarray(-2.0 * scaled / (np.pi * self._scale**2 * (1.0 + scaled**2) ** 2))

    def line_rate(self, x: Any) -> Array:
        """d/dr of ``line_density``: -1/r times its derivative in the scale."""
        scaled = np.asarray(x, dtype=np.float64) / self._scale
        return np.asarray((1.0 - scaled**2) / (self.r * np.pi * self._scale**2 * (1.0 + scaled**2) ** 2))

    def exceedance(self, x: Any) -> Array:
        """P(ξ > x)."""
        return np.asarray(np.arctan2(self._scale, np.asarray(x, dtype=np.float64)) / np.pi)

    def exceedance_rate(self, x: Any) -> Array:
        """d/dr P(ξ > x)."""
        distance = np.asarray(x, dtype=np.float64)
        return np.asarray(-distance / (self.r * np.pi * (distance**2 + self._scale**2)))

    def arc_probability(self, low: Any, high: Any) -> Array:
        """P(ξ mod 2π in the arc from low to high): an angle seen from the plane, small ones keep their digits."""
        chord, cosines, sines, stretch = self._seen(low, high)
        return np.asarray(np.arctan2(stretch * chord, cosines + stretch**2 * sines) / np.pi)

    def arc_probability_rate(self, low: Any, high: Any) -> Array:
        """d/dr of ``arc_probability``."""
        chord, cosines, sines, stretch = self._seen(low, high)
        across, along = stretch * chord, cosines + stretch**2 * sines
        turning = chord * (cosines - stretch**2 * sines) / (across**2 + along**2)
        return np.asarray(turning * 2.0 / ((1.0 - self.r) ** 2 * np.pi))

    def _seen(self, low: Any, high: Any) -> tuple[Array, Array, Array, float]:
        """With k = (1 + r)/(1 - r) the law of 2 arctan(tan(ξ/2)·k) is uniform: what arctan's difference needs."""
        a, b = 0.5 * np.asarray(low, dtype=np.float64), 0.5 * np.asarray(high, dtype=np.float64)
        stretch = (1.0 + self.r) / (1.0 - self.r)
        return np.sin(b - a), np.cos(a) * np.cos(b), np.sin(a) * np.sin(b), stretch

    def sample(self, rng: np.random.Generator, size: int | tuple[int, ...]) -> Array:
        """Cauchy draws, radians, not wrapped: now and then many turns long."""
        return np.asarray(self._scale * rng.standard_cauchy(size))
