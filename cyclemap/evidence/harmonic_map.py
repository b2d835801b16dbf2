"""A cycle map through measured pairs: the turn as a Fourier series of θ0, and the scatter about it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.theta0_pairs import Theta0Pairs
from cyclemap.maps import CircleMap

Array = NDArray[np.float64]
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
        angle = np.multiply.outer(theta, np.arange(self.cosine.size))
        return np.asarray(theta + np.cos(angle) @ self.cosine + np.sin(angle) @ self.sine)

    def _slope(self, theta: Array) -> Array:
        order = np.arange(self.cosine.size)
        angle = np.multiply.outer(theta, order)
        return np.asarray(1.0 + np.cos(angle) @ (order * self.sine) - np.sin(angle) @ (order * self.cosine))


def harmonic_map(pairs: Theta0Pairs, harmonics: int = HARMONICS) -> HarmonicMap:
    """Fit `harmonics` harmonics of θ0 to the measured turns, all pairs alike.

    Raises InvalidInput where the pairs do not fix the coefficients.

    >>> theta = np.linspace(0.0, 6.0, 40)
    >>> fitted = harmonic_map(Theta0Pairs(theta, theta + 0.2 + 0.1 * np.cos(2 * theta)), harmonics=2)
    >>> (fitted.cosine.round(9) + 0.0).tolist(), round(fitted.sigma, 9)
    ([0.2, 0.0, 0.1], 0.0)
    """
    unknowns = 2 * whole_number("harmonics", harmonics, least=0) + 1
    if pairs.theta.size <= unknowns:
        raise InvalidInput(f"{pairs.theta.size} pairs cannot fix {unknowns} coefficients; use fewer harmonics")
    angle = np.multiply.outer(pairs.theta, np.arange(harmonics + 1))
    design = np.hstack([np.cos(angle), np.sin(angle[:, 1:])])
    coefficients, _, rank, _ = np.linalg.lstsq(design, pairs.turn, rcond=None)
    if rank < unknowns:
        raise InvalidInput(f"the measured directions fix {rank} of {unknowns} coefficients; use fewer harmonics")
    residual = pairs.turn - design @ coefficients
    scatter = float(np.sqrt(residual @ residual / (pairs.theta.size - unknowns)))
    cosine, sine = coefficients[: harmonics + 1], np.append(0.0, coefficients[harmonics + 1 :])
    return HarmonicMap(read_only(cosine), read_only(sine), scatter, pairs.theta.size)
