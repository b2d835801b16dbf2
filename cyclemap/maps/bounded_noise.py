"""Noises that live on an interval: uniform on [-h, h], and von Mises."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array
from cyclemap.errors import InvalidInput
from cyclemap.maps.noise import Size, checked_width, folded, reals, reduced


@dataclass(frozen=True)
class UniformNoise:
    """Noise uniform on [-h, h] on the real line: κ_m = sin(mh)/(mh).

    Parameters
    ----------
    halfwidth : float
        h, radians, above zero; wrapped round the circle the noise overlaps itself where h > π.

    Raises
    ------
    InvalidInput
        Unless the halfwidth is above zero.

    Notes
    -----
    Its density jumps: ``slope`` raises InvalidInput. The sum of |κ_m| diverges: ``tail`` is inf.

    Examples
    --------
    >>> from cyclemap import UniformNoise
    >>> round(float(UniformNoise(0.5).exceedance(0.25)), 12)
    0.25
    """

    halfwidth: float
    sigma = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "halfwidth", checked_width("halfwidth", self.halfwidth))

    @property
    def variance(self) -> float:
        """h²/3, radians²."""
        return self.halfwidth**2 / 3.0

    @property
    def jump(self) -> float:
        """h, where the density jumps to nothing, radians."""
        return self.halfwidth

    def coefficients(self, m: ArrayLike) -> Array:
        """κ_m = sin(mh)/(mh)."""
        return np.asarray(np.sinc(reals(m) * (self.halfwidth / np.pi)))

    def tail(self, m: int) -> float:
        """Infinite: |κ_k| falls like 1/k, and its sum diverges."""
        return float("inf")

    def density(self, x: ArrayLike, lifted: bool = False) -> Array:
        """The number of x + 2πk in [-h, h), over 2h, per radian; on the line 1/2h on [-h, h), else
        0.
        """
        if lifted:
            distance = reals(x)
            return ((distance >= -self.halfwidth) & (distance < self.halfwidth)) / (
                2.0 * self.halfwidth
            )
        angle = reduced(x)
        images = np.ceil((self.halfwidth - angle) / TWO_PI) - np.ceil(
            (-self.halfwidth - angle) / TWO_PI
        )
        return images / (2.0 * self.halfwidth)

    def slope(self, x: ArrayLike, lifted: bool = False) -> Array:
        """Refused: InvalidInput."""
        raise InvalidInput(
            f"uniform noise has no density slope: its density jumps at ±{self.halfwidth:g}"
        )

    def exceedance(self, x: ArrayLike) -> Array:
        """P(ξ > x) = (h - x)/2h, cut to [0, 1]."""
        above = self.halfwidth - reals(x)
        return np.clip(above / (2.0 * self.halfwidth), 0.0, 1.0)

    def arc_probability(self, low: Array | float, high: Array | float) -> Array:
        """P(ξ mod 2π in the arc from low to high): the length of the arc's images in [-h, h], over
        2h.
        """
        share, window, centre = wrapped_window(self.halfwidth)
        length = high - reals(low)
        start = reduced(low - centre)
        inside = np.zeros_like(start)
        for turn in (0.0, TWO_PI):
            ahead = np.minimum(start + length - turn, window) - np.maximum(start - turn, -window)
            inside = inside + np.maximum(ahead, 0.0)
        return share * length / TWO_PI + inside / (2.0 * self.halfwidth)

    def sample(self, rng: np.random.Generator, size: Size) -> Array:
        """Uniform draws, radians, not wrapped."""
        return rng.uniform(-self.halfwidth, self.halfwidth, size)


def wrapped_window(halfwidth: float) -> tuple[float, float, float]:
    """(share, w, c) of noise uniform on [-h, h] on the circle: even all round to that share, else
    uniform on [c - w, c + w], w < π.
    """
    laps = np.floor(halfwidth / np.pi)
    share = float(np.pi * laps / halfwidth) if laps else 0.0
    return share, float(halfwidth - np.pi * laps), float(np.pi * np.mod(laps, 2.0))


_CONCENTRATED = 1e8  # beyond it the coefficients come from their expansion in 1/κ
_SPAN = 45.0  # integrals stop where the density has fallen by exp(-45)
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(64)  # on [-1, 1]


@dataclass(frozen=True)
class VonMises:
    """Von Mises noise, density exp(κ cos x)/(2π I₀(κ)) on [-π, π]: κ_m = I_m(κ)/I₀(κ).

    Parameters
    ----------
    kappa : float
        The concentration κ, finite and above zero. Near normal of variance 1/κ where it is
        large, near uniform where it is small.

    Raises
    ------
    InvalidInput
        Unless kappa is finite and above zero (an infinite one is no noise).

    Notes
    -----
    On the real line it is zero outside [-π, π] (its step there, exp(-κ)/(2π I₀), is left out of
    ``slope``). Integrals of the density are Gauss-Legendre sums of positive terms, good to about
    1e-13 relative, however far in the tail.

    References
    ----------
    Mardia, K. V. & Jupp, P. E. (2000), Directional statistics, section 3.5.4.

    Examples
    --------
    >>> from cyclemap import VonMises
    >>> round(float(VonMises(2.0).coefficients(1)), 12)
    0.697774657964
    """

    kappa: float
    jump = 0.0
    sigma = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "kappa", checked_width("kappa", self.kappa))

    @property
    def variance(self) -> float:
        """∫ x² density dx over [-π, π]."""
        return 2.0 * float(self._half_integral(0.0, np.pi, np.square))

    def coefficients(self, m: ArrayLike) -> Array:
        """κ_m = I_m(κ)/I₀(κ); beyond κ = 1e8 from Debye's expansion, exp(-(m²/2κ)(1 + 1/2κ) +
        m⁴/24κ³).
        """
        from scipy.special import i0e, ive  # slow to import for those who ask for another noise

        order = np.abs(reals(m))
        if self.kappa <= _CONCENTRATED:
            return np.asarray(ive(order, self.kappa) / i0e(self.kappa))
        share = np.minimum(order, self.kappa) ** 2 / self.kappa
        return np.asarray(
            np.exp(-0.5 * share * (1.0 + 0.5 / self.kappa) + share**2 / (24.0 * self.kappa))
        )

    def tail(self, m: int) -> float:
        """A bound on the sum over k > m of κ_k: the ratios κ_{k+1}/κ_k fall (Amos 1974), so a
        geometric sum.
        """
        middle = m + 0.5
        ratio_gap = middle + middle**2 / (np.hypot(self.kappa, middle) + self.kappa)
        return float(self.coefficients(m) * self.kappa / ratio_gap)

    def density(self, x: ArrayLike, lifted: bool = False) -> Array:
        """Density per radian; on the line 0 outside [-π, π]."""
        from scipy.special import i0e

        within = np.clip(x, -np.pi, np.pi) if lifted else reals(x)  # x may be infinite then
        half = np.sin(0.5 * within)
        density = np.exp(-2.0 * self.kappa * half**2) / (TWO_PI * i0e(self.kappa))
        return np.where(np.abs(x) <= np.pi, density, 0.0) if lifted else density

    def slope(self, x: ArrayLike, lifted: bool = False) -> Array:
        """d/dx of ``density``: -κ sin x times it."""
        return -self.kappa * np.sin(x) * self.density(x, lifted)

    def exceedance(self, x: ArrayLike) -> Array:
        """P(ξ > x)."""
        at = np.clip(reals(x), -np.pi, np.pi)
        tail = self._half_integral(np.abs(at), np.pi)
        return np.where(at < 0.0, 1.0 - tail, tail)

    def arc_probability(self, low: Array | float, high: Array | float) -> Array:
        """P(ξ mod 2π in the arc from low to high): up to three positive parts of [0, π]."""
        near, beyond = folded(low, high)
        ahead = self._half_integral(np.maximum(near, 0.0), np.minimum(beyond, np.pi))
        behind = self._half_integral(0.0, np.clip(-near, 0.0, np.pi))
        around = self._half_integral(np.minimum(TWO_PI - beyond, np.pi), np.pi)
        return np.asarray(ahead + behind + around)

    def _half_integral(
        self,
        low: Array | float,
        high: Array | float,
        factor: Callable[[Array], Array] = np.ones_like,
    ) -> Array:
        """∫ factor(x) density(x) dx from low to high, 0 <= low <= high <= π, any shapes that go
        together.
        """
        start, end = np.broadcast_arrays(reals(low), reals(high))
        # No further than where the density has fallen by exp(-45), if it does.
        squared = np.sin(0.5 * start) ** 2 + 0.5 * _SPAN / self.kappa
        falls = np.where(
            squared < 1.0, 2.0 * np.arcsin(np.sqrt(np.minimum(squared, 1.0))) - start, np.pi
        )
        length = np.minimum(end - start, falls)
        step = length[..., None] * (0.5 + 0.5 * _NODES)
        angle = start[..., None] + step
        fall = 2.0 * self.kappa * np.sin(0.5 * step) * np.sin(angle - 0.5 * step)
        total = (factor(angle) * np.exp(-fall)) @ (0.5 * _WEIGHTS)
        return np.asarray(total * length * self.density(start))

    def sample(self, rng: np.random.Generator, size: Size) -> Array:
        """Von Mises draws in [-π, π], radians (Best & Fisher 1979)."""
        return rng.vonmises(0.0, self.kappa, size)
