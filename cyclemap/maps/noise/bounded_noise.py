"""Noises that live on an interval: uniform on [-h, h], and von Mises."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import finite_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.noise.noise import folded, reduced


@dataclass(frozen=True)
class UniformNoise:
    """Noise uniform on [-h, h] on the real line, h = ``halfwidth`` radians, any h > 0: κ_m = sin(mh)/(mh).

    Wrapped round the circle it overlaps itself where h > π. Its density jumps, so it has no slope, and no
    derivative in h, as a function: ``slope``, ``rate``, ``line_slope`` and ``line_rate`` raise InvalidInput;
    probabilities and coefficients have their rates. The sum of |κ_m| diverges: ``tail`` is inf.
    Raises InvalidInput unless the halfwidth is above zero.

    >>> round(float(UniformNoise(0.5).exceedance(0.25)), 12)
    0.25
    """

    halfwidth: float

    def __post_init__(self) -> None:
        width = finite_number("halfwidth", self.halfwidth)
        if width <= 0.0:
            raise InvalidInput(f"halfwidth is {width:g}: noise needs a width above zero; leave the noise out for none")
        object.__setattr__(self, "halfwidth", width)

    @property
    def variance(self) -> float:
        """h²/3."""
        return self.halfwidth**2 / 3.0

    def coefficients(self, m: Any) -> Array:
        """κ_m = sin(mh)/(mh)."""
        return np.asarray(np.sinc(np.asarray(m, dtype=np.float64) * (self.halfwidth / np.pi)))

    def coefficient_rates(self, m: Any) -> Array:
        """dκ_m/dh = -m j₁(mh), j₁ the spherical Bessel function."""
        from scipy.special import spherical_jn  # slow to import, and seldom asked for

        order = np.abs(np.asarray(m, dtype=np.float64))
        return np.asarray(-order * spherical_jn(1, order * self.halfwidth))

    def tail(self, m: int) -> float:
        """Infinite: |κ_k| falls like 1/k, and its sum diverges."""
        return float("inf")

    def density(self, x: Any) -> Array:
        """Density on the circle, per radian: the number of x + 2πk in [-h, h), over 2h."""
        angle = reduced(x)
        images = np.ceil((self.halfwidth - angle) / TWO_PI) - np.ceil((-self.halfwidth - angle) / TWO_PI)
        return np.asarray(images / (2.0 * self.halfwidth))

    def line_density(self, x: Any) -> Array:
        """1/2h on [-h, h), else 0, per radian."""
        distance = np.asarray(x, dtype=np.float64)
        inside = (distance >= -self.halfwidth) & (distance < self.halfwidth)
        return np.asarray(inside / (2.0 * self.halfwidth))

    def slope(self, x: Any) -> Array:
        """Refused: InvalidInput."""
        self._no_function("slope")

    def rate(self, x: Any) -> Array:
        """Refused: InvalidInput."""
        self._no_function("rate")

    line_slope, line_rate = slope, rate

    def _no_function(self, what: str) -> NoReturn:
        raise InvalidInput(
            f"uniform noise has no density {what}: its density jumps at ±{self.halfwidth:g}; "
            "use exceedance, arc_probability and their rates"
        )

    def exceedance(self, x: Any) -> Array:
        """P(ξ > x) = (h - x)/2h, cut to [0, 1]."""
        above = self.halfwidth - np.asarray(x, dtype=np.float64)
        return np.asarray(np.clip(above / (2.0 * self.halfwidth), 0.0, 1.0))

    def exceedance_rate(self, x: Any) -> Array:
        """d/dh P(ξ > x) = x/2h² inside [-h, h], else 0."""
        distance = np.asarray(x, dtype=np.float64)
        return np.asarray(np.where(np.abs(distance) < self.halfwidth, distance, 0.0) / (2.0 * self.halfwidth**2))

    def arc_probability(self, low: Any, high: Any) -> Array:
        """P(ξ mod 2π in the arc from low to high): the length of the arc's images in [-h, h], over 2h."""
        total = 0.0
        for start, end in self._images(low, high):
            total = total + np.maximum(np.minimum(end, self.halfwidth) - np.maximum(start, -self.halfwidth), 0.0)
        return np.asarray(total / (2.0 * self.halfwidth))

    def arc_probability_rate(self, low: Any, high: Any) -> Array:
        """d/dh of ``arc_probability``: from the ends ±h that lie in the arc's images (its ends left out)."""
        edges: Any = 0.0
        for start, end in self._images(low, high):
            edges = edges + sum((start < edge) & (edge < end) for edge in (-self.halfwidth, self.halfwidth))
        return np.asarray((0.5 * edges - self.arc_probability(low, high)) / self.halfwidth)

    def _images(self, low: Any, high: Any) -> list[tuple[Array, Array]]:
        """The arc and its shifts by whole turns that may meet [-h, h]."""
        given = np.asarray(low, dtype=np.float64)
        start = reduced(given)
        end = start + (high - given)
        reach = int(np.ceil(self.halfwidth / TWO_PI)) + 1
        return [(start + TWO_PI * k, end + TWO_PI * k) for k in range(-reach, reach + 1)]

    def sample(self, rng: np.random.Generator, size: int | tuple[int, ...]) -> Array:
        """Uniform draws, radians, not wrapped."""
        return np.asarray(rng.uniform(-self.halfwidth, self.halfwidth, size))


_CONCENTRATED = 1e8  # beyond it the coefficients come from their expansion in 1/κ
_SPAN = 45.0  # integrals stop where the density has fallen by exp(-45)
_NODES, _WEIGHTS = (0.5 * part for part in np.polynomial.legendre.leggauss(64))
_NODES = _NODES + 0.5


@dataclass(frozen=True)
class VonMises:
    """Von Mises noise, density exp(κ cos x)/(2π I₀(κ)) on [-π, π], κ = ``kappa`` > 0: κ_m = I_m(κ)/I₀(κ).

    On the real line it is zero outside [-π, π] (its step there, exp(-κ)/(2π I₀), is left out of ``line_slope``).
    Near normal of variance 1/κ where κ is large, near uniform where it is small. Integrals of the density
    are Gauss-Legendre sums of positive terms, good to about 1e-13 relative, however far in the tail.
    Raises InvalidInput unless kappa is finite and above zero (an infinite one is no noise).
    (Mardia & Jupp 2000, sec. 3.5.4.)

    >>> round(float(VonMises(2.0).coefficients(1)), 12)
    0.697774657964
    """

    kappa: float

    def __post_init__(self) -> None:
        concentration = finite_number("kappa", self.kappa)
        if concentration <= 0.0:
            raise InvalidInput(f"kappa is {concentration:g}: the concentration must be above zero (0 is all round)")
        object.__setattr__(self, "kappa", concentration)

    @property
    def variance(self) -> float:
        """∫ x² density dx over [-π, π]."""
        return 2.0 * float(self._half_integral(0.0, np.pi, np.square))

    # -- Fourier coefficients ------------------------------------------------------------------------------

    def coefficients(self, m: Any) -> Array:
        """κ_m = I_m(κ)/I₀(κ); beyond κ = 1e8 from Debye's expansion, exp(-(m²/2κ)(1 + 1/2κ) + m⁴/24κ³)."""
        from scipy.special import i0e, ive  # slow to import for those who ask for another noise

        order = np.abs(np.asarray(m, dtype=np.float64))
        if self.kappa <= _CONCENTRATED:
            return np.asarray(ive(order, self.kappa) / i0e(self.kappa))
        share = np.minimum(order, self.kappa) ** 2 / self.kappa
        return np.asarray(np.exp(-0.5 * share * (1.0 + 0.5 / self.kappa) + share**2 / (24.0 * self.kappa)))

    def coefficient_rates(self, m: Any) -> Array:
        """dκ_m/dκ = -2 E[(cos ξ - A) sin²(mξ/2)], A = E cos ξ: by the trapezoidal rule, good to 1e-15/κ."""
        order = np.abs(np.asarray(m, dtype=np.float64))
        last = 8
        while self.tail(last) > 1e-22:
            last = int(1.2 * last) + 1
        kept = np.minimum(order, last)
        half_turn = last + 2  # steps in half a turn: waves that fold back have orders beyond ``last``
        step = np.pi / half_turn
        count = min(half_turn, int(np.ceil(2.0 * self._falls_to(0.0) / step)))
        x = step * np.arange(1, count + 1)
        mass = step * self.density(x) * np.where(np.arange(1, count + 1) < half_turn, 2.0, 1.0)
        pull = self._one_minus_mean - 2.0 * np.sin(0.5 * x) ** 2
        rates = -2.0 * np.sin(0.5 * np.multiply.outer(kept, x)) ** 2 @ (mass * pull)
        return np.asarray(np.where(order > last, 0.0, rates))

    def tail(self, m: int) -> float:
        """A bound on the sum over k > m of κ_k: the ratios κ_{k+1}/κ_k fall (Amos 1974), so a geometric sum."""
        middle = m + 0.5
        ratio_gap = np.hypot(self.kappa, middle) + middle - self.kappa
        return float(self.coefficients(m) * self.kappa / ratio_gap)

    # -- densities -----------------------------------------------------------------------------------------

    def density(self, x: Any) -> Array:
        """Density on the circle, per radian."""
        from scipy.special import i0e

        half = np.sin(0.5 * np.asarray(x, dtype=np.float64))
        return np.asarray(np.exp(-2.0 * self.kappa * half**2) / (TWO_PI * i0e(self.kappa)))

    def slope(self, x: Any) -> Array:
        """d/dx of ``density``: -κ sin x times it."""
        return np.asarray(-self.kappa * np.sin(x) * self.density(x))

    def rate(self, x: Any) -> Array:
        """d/dκ of ``density``: cos x - A times it, A = I₁(κ)/I₀(κ)."""
        return self._pull(np.asarray(x, dtype=np.float64)) * self.density(x)

    def line_density(self, x: Any) -> Array:
        """The density on [-π, π], else 0, per radian."""
        return np.asarray(np.where(np.abs(x) <= np.pi, self.density(np.clip(x, -np.pi, np.pi)), 0.0))

    def line_slope(self, x: Any) -> Array:
        """d/dx of ``line_density`` inside (-π, π), else 0."""
        return np.asarray(np.where(np.abs(x) <= np.pi, self.slope(x), 0.0))

    def line_rate(self, x: Any) -> Array:
        """d/dκ of ``line_density``."""
        return np.asarray(np.where(np.abs(x) <= np.pi, self.rate(x), 0.0))

    def _pull(self, x: Array) -> Array:
        return np.asarray(self._one_minus_mean - 2.0 * np.sin(0.5 * x) ** 2)

    @property
    def _one_minus_mean(self) -> float:
        """1 - I₁(κ)/I₀(κ), without the difference."""
        return 4.0 * float(self._half_integral(0.0, np.pi, lambda x: np.sin(0.5 * x) ** 2))

    # -- probabilities -------------------------------------------------------------------------------------

    def exceedance(self, x: Any) -> Array:
        """P(ξ > x)."""
        at = np.clip(np.asarray(x, dtype=np.float64), -np.pi, np.pi)
        tail = self._half_integral(np.abs(at), np.pi)
        return np.asarray(np.where(at < 0.0, 0.5 + self._half_integral(0.0, np.abs(at)), tail))

    def exceedance_rate(self, x: Any) -> Array:
        """d/dκ P(ξ > x), odd in x."""
        at = np.clip(np.asarray(x, dtype=np.float64), -np.pi, np.pi)
        return np.asarray(np.sign(at) * self._half_integral(np.abs(at), np.pi, self._pull))

    def arc_probability(self, low: Any, high: Any) -> Array:
        """P(ξ mod 2π in the arc from low to high): up to three positive parts of [0, π]."""
        return self._arc_integral(low, high, np.ones_like)

    def arc_probability_rate(self, low: Any, high: Any) -> Array:
        """d/dκ of ``arc_probability``."""
        return self._arc_integral(low, high, self._pull)

    def _arc_integral(self, low: Any, high: Any, factor: Callable[[Array], Array]) -> Array:
        near, beyond = folded(low, high)
        parts = self._half_integral(np.maximum(near, 0.0), np.minimum(beyond, np.pi), factor)
        parts = parts + self._half_integral(0.0, np.minimum(np.maximum(-near, 0.0), np.pi), factor)
        return np.asarray(parts + self._half_integral(np.minimum(TWO_PI - beyond, np.pi), np.pi, factor))

    def _half_integral(self, low: Any, high: Any, factor: Callable[[Array], Array] = np.ones_like) -> Array:
        """∫ factor(x) density(x) dx from low to high, 0 <= low <= high <= π, any shapes that go together."""
        start, end = np.broadcast_arrays(np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64))
        length = np.minimum(end - start, self._falls_to(start))
        total = np.zeros(start.shape)
        for node, weight in zip(_NODES, _WEIGHTS, strict=True):
            step = length * node
            fall = 2.0 * self.kappa * np.sin(0.5 * step) * np.sin(start + 0.5 * step)
            total += weight * factor(start + step) * np.exp(-fall)
        return np.asarray(total * length * self.density(start))

    def _falls_to(self, start: Any) -> Array:
        """How far beyond ``start`` the density has fallen by exp(-45); far enough where it never does."""
        squared = np.sin(0.5 * np.asarray(start, dtype=np.float64)) ** 2 + 0.5 * _SPAN / self.kappa
        return np.asarray(np.where(squared < 1.0, 2.0 * np.arcsin(np.sqrt(np.minimum(squared, 1.0))) - start, np.pi))

    def sample(self, rng: np.random.Generator, size: int | tuple[int, ...]) -> Array:
        """Von Mises draws in [-π, π], radians (Best & Fisher 1979)."""
        return np.asarray(rng.vonmises(0.0, self.kappa, size))
