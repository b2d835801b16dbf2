"""Noise that is uniform on an interval."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import finite_number
from cyclemap.errors import InvalidInput


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
        given = np.asarray(x, dtype=np.float64)
        angle = given - TWO_PI * np.round(given / TWO_PI)
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

    def line_slope(self, x: Any) -> Array:
        """Refused: InvalidInput."""
        self._no_function("slope")

    def line_rate(self, x: Any) -> Array:
        """Refused: InvalidInput."""
        self._no_function("rate")

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
        start = given - TWO_PI * np.round(given / TWO_PI)
        end = start + (high - given)
        reach = int(np.ceil(self.halfwidth / TWO_PI)) + 1
        return [(start + TWO_PI * k, end + TWO_PI * k) for k in range(-reach, reach + 1)]

    def sample(self, rng: np.random.Generator, size: int | tuple[int, ...]) -> Array:
        """Uniform draws, radians, not wrapped."""
        return np.asarray(rng.uniform(-self.halfwidth, self.halfwidth, size))
