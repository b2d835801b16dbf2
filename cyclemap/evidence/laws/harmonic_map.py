"""A cycle map through measured pairs: the turn as a Fourier series of θ0, and the scatter about it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import read_only, whole_number
from cyclemap.evidence.laws.periodic_basis import fourier_columns, fourier_slopes
from cyclemap.evidence.laws.periodic_law import fit_periodic_law
from cyclemap.evidence.theta0.theta0_pairs import Theta0Pairs
from cyclemap.maps import CircleMap

HARMONICS = 6


@dataclass(frozen=True, eq=False)
class HarmonicMap:
    """The map θ → θ + c_0 + Σ_k c_k cos kθ + s_k sin kθ that fits measured pairs best, in least squares.

    cosine : (harmonics + 1,) rad, c_0 first. sine : (harmonics + 1,) rad, s_0 = 0. pairs : how many were fitted.
    sigma : rad, the scatter of one cycle about it; wear and outliers of the data are in it.
    """

    cosine: Array
    sine: Array
    sigma: float
    pairs: int

    @property
    def map(self) -> CircleMap:
        """The fitted map as a lift of degree 1."""
        return CircleMap(self._lift, self._slope)

    def _lift(self, theta: Array) -> Array:
        return np.asarray(theta + fourier_columns(theta, self.cosine.size - 1) @ self._coefficients)

    def _slope(self, theta: Array) -> Array:
        return np.asarray(1.0 + fourier_slopes(theta, self.cosine.size - 1) @ self._coefficients)

    @property
    def _coefficients(self) -> Array:
        return np.append(self.cosine[0], np.stack([self.cosine[1:], self.sine[1:]], axis=-1).ravel())


def harmonic_map(pairs: Theta0Pairs, harmonics: int = HARMONICS) -> HarmonicMap:
    """Fit `harmonics` harmonics of θ0 to the measured turns, all pairs alike.

    Raises InvalidInput where the pairs do not fix the coefficients.

    >>> theta = np.linspace(0.0, 6.0, 40)
    >>> fitted = harmonic_map(Theta0Pairs(theta, theta + 0.2 + 0.1 * np.cos(2 * theta)), harmonics=2)
    >>> (fitted.cosine.round(9) + 0.0).tolist(), round(fitted.sigma, 9)
    ([0.2, 0.0, 0.1], 0.0)
    """
    law = fit_periodic_law(pairs.theta, pairs.turn, harmonics=whole_number("harmonics", harmonics, least=0))
    return HarmonicMap(read_only(law.cosine), read_only(law.sine), law.sigma, law.count)
