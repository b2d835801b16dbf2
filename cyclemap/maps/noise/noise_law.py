"""Symmetric noise added to the angle after each cycle: what every law offers, and the laws there are."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import numpy as np

from cyclemap.maps.arcs import Array
from cyclemap.maps.noise.uniform_noise import UniformNoise
from cyclemap.maps.noise.von_mises import VonMises
from cyclemap.maps.noise.wrapped_cauchy import WrappedCauchy
from cyclemap.maps.noise.wrapped_normal import WrappedNormal

__all__ = ["Noise", "UniformNoise", "VonMises", "WrappedCauchy", "WrappedNormal"]


@runtime_checkable
class Noise(Protocol):
    """What the rest of the room asks of a noise ξ: symmetric about 0, with a density on the real line.

    A further law is one more class with these methods. Every law has one parameter of its own (``sigma``, ``r``,
    ``kappa``, ``halfwidth``); a "rate" is a derivative with respect to it.
    """

    @property
    def variance(self) -> float:
        """Variance of one draw on the real line, radians²; inf where there is none."""

    def coefficients(self, m: Any) -> Array:
        """κ_m = E e^{imξ}, real by symmetry; any whole m, any shape."""

    def coefficient_rates(self, m: Any) -> Array:
        """dκ_m/d(parameter)."""

    def tail(self, m: int) -> float:
        """A bound on the sum of |κ_k| over k > m; inf where the sum diverges."""

    def density(self, x: Any) -> Array:
        """Density on the circle, per radian, period 2π."""

    def slope(self, x: Any) -> Array:
        """d/dx of ``density``, per radian²."""

    def rate(self, x: Any) -> Array:
        """d/d(parameter) of ``density``."""

    def line_density(self, x: Any) -> Array:
        """Density on the real line, per radian."""

    def line_slope(self, x: Any) -> Array:
        """d/dx of ``line_density``, per radian²."""

    def line_rate(self, x: Any) -> Array:
        """d/d(parameter) of ``line_density``."""

    def exceedance(self, x: Any) -> Array:
        """P(ξ > x) on the real line, to full relative accuracy in the tail."""

    def exceedance_rate(self, x: Any) -> Array:
        """d/d(parameter) of ``exceedance``."""

    def arc_probability(self, low: Any, high: Any) -> Array:
        """P(ξ mod 2π in the arc from low to high), low < high < low + 2π; small values keep their digits."""

    def arc_probability_rate(self, low: Any, high: Any) -> Array:
        """d/d(parameter) of ``arc_probability``."""

    def sample(self, rng: np.random.Generator, size: int | tuple[int, ...]) -> Array:
        """Independent draws on the real line, radians."""
