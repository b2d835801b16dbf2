"""Symmetric noise added to the angle after each cycle: what every noise offers; normal, Cauchy,
uniform and von Mises noise.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import finite_number
from cyclemap.errors import InvalidInput

Size = int | tuple[int, ...]  # of an array of draws


@runtime_checkable
class Noise(Protocol):
    """What the rest of the room asks of a noise ξ: symmetric about 0, with a density on the real
    line.

    Notes
    -----
    A further law is one more class with these methods.

    Examples
    --------
    >>> from cyclemap import CircleMap, VonMises, WrappedNormal, transfer_operator
    >>> noises = WrappedNormal(0.5), VonMises(4.0)
    >>> laws = [transfer_operator(CircleMap.rigid(0.3), noise) for noise in noises]
    >>> [round(law.rotation_number, 9) for law in laws]
    [0.3, 0.3]
    """

    @property
    def variance(self) -> float:
        """Variance of one draw on the real line, radians²; inf where there is none."""

    @property
    def sigma(self) -> float | None:
        """The standard deviation of a normal law, radians; None of any other."""

    @property
    def jump(self) -> float:
        """h where the density is even on [-h, h] and jumps to nothing there, radians; 0 where it is
        smooth.
        """

    def coefficients(self, m: ArrayLike) -> Array:
        """κ_m = E e^{imξ}, real by symmetry; any shape. Those of whole m count; between them they
        fall alike, since nodes are counted by where they are negligible.
        """

    def tail(self, m: int) -> float:
        """A bound on the sum of |κ_k| over k > m; inf where the sum diverges."""

    def density(self, x: ArrayLike, lifted: bool = False) -> Array:
        """Density per radian: on the circle, period 2π; ``lifted``, on the real line."""

    def slope(self, x: ArrayLike, lifted: bool = False) -> Array:
        """d/dx of ``density``, per radian²."""

    def exceedance(self, x: ArrayLike) -> Array:
        """P(ξ > x) on the real line, to full relative accuracy in the tail."""

    def arc_probability(self, low: Array | float, high: Array | float) -> Array:
        """P(ξ mod 2π in the arc from low to high), low < high < low + 2π; small values keep their
        digits.
        """

    def sample(self, rng: np.random.Generator, size: Size) -> Array:
        """Independent draws on the real line, radians."""


def require_noise(noise: object) -> None:
    """Raise InvalidInput where it is none."""
    if not isinstance(noise, Noise):
        raise InvalidInput(f"the noise is {noise!r}: give one, for example WrappedNormal(0.02)")


def checked_width(name: str, value: float) -> float:
    """A noise's width or concentration, or InvalidInput where it is none, or squares leave the
    floats.
    """
    width = finite_number(name, value)
    if not 1e-100 <= width <= 1e100:
        raise InvalidInput(
            f"{name} is {width:g}: it must be above zero, from 1e-100 to 1e100; leave the noise "
            "out for none"
        )
    return width


_WIDE = 2.5  # radians: a wider law is summed in Fourier modes, not over its images
_ORDERS = np.arange(1.0, 9.0)  # the Fourier modes that a wide law has
_CONCENTRATED = 1e8  # beyond it the coefficients come from their expansion in 1/κ
_SPAN = 45.0  # integrals stop where the density has fallen by exp(-45)
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(64)  # on [-1, 1]
# SciPy's is slow to import, and needed for few values
_erfc = np.vectorize(math.erfc, otypes=[np.float64])


@dataclass(frozen=True)
class WrappedNormal:
    """Normal noise, wrapped round the circle: κ_m = exp(-m²σ²/2).

    Parameters
    ----------
    sigma : float
        Standard deviation σ, radians, above zero.

    Attributes
    ----------
    jump : float
        0: the density is smooth.

    Raises
    ------
    InvalidInput
        Unless sigma is above zero (a noiseless map needs no noise object).

    References
    ----------
    Mardia, K. V. & Jupp, P. E. (2000), Directional statistics, section 3.5.7.

    Examples
    --------
    >>> from cyclemap import WrappedNormal
    >>> round(float(WrappedNormal(0.5).coefficients(2)), 12)
    0.606530659713
    """

    sigma: float
    jump = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "sigma", checked_width("sigma", self.sigma))

    @property
    def variance(self) -> float:
        """σ², radians²."""
        return self.sigma**2

    def coefficients(self, m: ArrayLike) -> Array:
        """κ_m = exp(-m²σ²/2)."""
        order = reals(m)
        return np.exp(-0.5 * (order * self.sigma) ** 2)

    def tail(self, m: int) -> float:
        """Sum over k > m of κ_k, bounded by the integral of exp(-x²σ²/2) from m."""
        return float(np.sqrt(0.5 * np.pi) / self.sigma * math.erfc(m * self.sigma / math.sqrt(2.0)))

    def density(self, x: ArrayLike, lifted: bool = False) -> Array:
        """The normal density, per radian, or the sum over its images on the circle;
        rounding only."""
        if not lifted and self.sigma >= _WIDE:
            return (1.0 + 2.0 * self._waves(np.cos, x, np.ones_like(_ORDERS))) / TWO_PI
        if not lifted:
            return self._summed(self.density, x)
        # In place: kernels between thousands of nodes are large, and fresh memory is slower than
        # the arithmetic.
        density = np.array(x, dtype=np.float64)
        density /= self.sigma
        density *= density
        density *= -0.5
        np.exp(density, out=density)
        density /= self.sigma * np.sqrt(TWO_PI)
        return density

    def slope(self, x: ArrayLike, lifted: bool = False) -> Array:
        """d/dx of ``density``: on the line -x/σ² times it."""
        if not lifted and self.sigma >= _WIDE:
            return self._waves(np.sin, x, -_ORDERS) / np.pi
        if not lifted:
            return self._summed(self.slope, x)
        distance = reals(x)
        return np.asarray(-distance / self.sigma**2 * self.density(distance, True))

    def exceedance(self, x: ArrayLike) -> Array:
        """P(ξ > x)."""
        scaled = reals(x) / (self.sigma * math.sqrt(2.0))
        return np.asarray(0.5 * _erfc(scaled))

    def arc_probability(self, low: Array | float, high: Array | float) -> Array:
        """P(ξ mod 2π in the arc from low to high), without cancellation where it is small."""
        if self.sigma >= _WIDE:
            half = 0.5 * (reals(high) - low)
            chords = np.sin(np.multiply.outer(half, _ORDERS)) / _ORDERS
            return (half + 2.0 * self._waves(np.cos, low + half, chords)) / np.pi
        near, beyond = folded(low, high)
        total = np.asarray(self.exceedance(near) - self.exceedance(beyond))
        for turn in range(1, 2 + int(np.ceil(9.0 * self.sigma / TWO_PI))):
            shift = TWO_PI * turn
            total += self.exceedance(shift + near) - self.exceedance(shift + beyond)
            total += self.exceedance(shift - beyond) - self.exceedance(shift - near)
        return total

    def sample(self, rng: np.random.Generator, size: Size) -> Array:
        """Normal draws, radians, not wrapped."""
        return rng.normal(0.0, self.sigma, size)

    def _waves(self, wave: np.ufunc, x: ArrayLike, weights: Array) -> Array:
        """The sum over k of κ_k weights_k wave(kx)."""
        waves = wave(np.multiply.outer(reduced(x), _ORDERS))
        return np.asarray((weights * waves) @ self.coefficients(_ORDERS))

    def _summed(self, function: Callable[[Array, bool], Array], x: ArrayLike) -> Array:
        """The sum over all x + 2πk near enough to count."""
        reach = int(np.ceil((TWO_PI + 9.0 * self.sigma) / TWO_PI))
        turns = TWO_PI * np.arange(-reach, reach + 1)
        return np.asarray(sum(function(reduced(x) + turn, True) for turn in turns.tolist()))


def reals(x: ArrayLike) -> Array:
    """The same numbers as an array of floats."""
    return np.asarray(x, dtype=np.float64)


def reduced(x: ArrayLike) -> Array:
    """The same angle in [-π, π]; small angles keep all their digits."""
    angle = reals(x)
    return angle - TWO_PI * np.round(angle / TWO_PI)


def folded(low: Array | float, high: Array | float) -> tuple[Array, Array]:
    """The same arc seen from 0, mirrored so that its middle lies in [0, π]: its nearer and its
    farther end.
    """
    half = 0.5 * (reals(high) - low)
    far = np.abs(reduced(low + half))
    return far - half, far + half


@dataclass(frozen=True)
class WrappedCauchy:
    """Cauchy noise wrapped round the circle: κ_m = r^|m|.

    Parameters
    ----------
    r : float
        Mean resultant length, in (0, 1); its scale on the line is s = -ln r radians.

    Attributes
    ----------
    jump : float
        0: the density is smooth.

    Raises
    ------
    InvalidInput
        Unless 0 < r < 1.

    Notes
    -----
    Möbius maps send wrapped Cauchy laws to wrapped Cauchy laws (McCullagh 1996), which makes them
    the exact check of a transfer operator.

    References
    ----------
    - Mardia, K. V. & Jupp, P. E. (2000), Directional statistics, section 3.5.7.
    - McCullagh, P. (1996), Möbius transformation and Cauchy parameter estimation, Annals of
      Statistics 24.

    Examples
    --------
    >>> from cyclemap import WrappedCauchy
    >>> float(WrappedCauchy(0.5).coefficients(-3))
    0.125
    """

    r: float
    jump = 0.0
    sigma = None

    def __post_init__(self) -> None:
        length = finite_number("r", self.r)
        if not 0.0 < length < 1.0:
            raise InvalidInput(
                f"r is {length:g}: the resultant length must lie between 0 and 1 (1 is no noise)"
            )
        object.__setattr__(self, "r", length)

    @property
    def variance(self) -> float:
        """Infinite: a Cauchy law has none."""
        return float("inf")

    @property
    def _scale(self) -> float:
        return float(-np.log(self.r))

    def coefficients(self, m: ArrayLike) -> Array:
        """κ_m = r^|m|."""
        return self.r ** np.abs(reals(m))

    def tail(self, m: int) -> float:
        """Sum over k > m of κ_k, exactly."""
        return float(self.r ** (m + 1) / (1.0 - self.r))

    def density(self, x: ArrayLike, lifted: bool = False) -> Array:
        """The Cauchy density, per radian; on the circle (1 - r²)/(2π|1 - r e^{ix}|²)."""
        gap = reals(x)
        if lifted:
            return np.asarray(1.0 / (np.pi * self._scale * (1.0 + (gap / self._scale) ** 2)))
        distance = (1.0 - self.r) ** 2 + 4.0 * self.r * np.sin(0.5 * gap) ** 2
        return np.asarray((1.0 - self.r**2) / (TWO_PI * distance))

    def slope(self, x: ArrayLike, lifted: bool = False) -> Array:
        """d/dx of ``density``."""
        gap = reals(x)
        square = self.density(gap, lifted) ** 2
        if lifted:
            return np.asarray(-2.0 * np.pi / self._scale * gap * square)
        return np.asarray(-2.0 * TWO_PI * self.r / (1.0 - self.r**2) * np.sin(gap) * square)

    def exceedance(self, x: ArrayLike) -> Array:
        """P(ξ > x)."""
        return np.asarray(np.arctan2(self._scale, reals(x)) / np.pi)

    def arc_probability(self, low: Array | float, high: Array | float) -> Array:
        """P(ξ mod 2π in the arc from low to high): an angle seen from the plane, small ones keep
        their digits.
        """
        a = 0.5 * reals(low)
        b = 0.5 * reals(high)
        # 2 arctan(tan(ξ/2)·stretch) is uniform
        stretch = (1.0 + self.r) / (1.0 - self.r)
        along = np.cos(a) * np.cos(b) + stretch**2 * np.sin(a) * np.sin(b)
        return np.arctan2(stretch * np.sin(b - a), along) / np.pi

    def sample(self, rng: np.random.Generator, size: Size) -> Array:
        """Cauchy draws, radians, not wrapped: now and then many turns long."""
        return self._scale * rng.standard_cauchy(size)


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
