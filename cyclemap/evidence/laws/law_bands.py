"""Bands about a fitted law: where its mean lies, and where one more value will."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import finite_number
from cyclemap.errors import InvalidInput


@dataclass(frozen=True, eq=False)
class LawBand:
    """Bands at the angles ``theta`` (rad), each holding with probability ``level`` at one angle at a time.

    centre : the fitted law there. mean_halfwidth : half the width of the band of the mean.
    halfwidth : half the width of the prediction band, in which one new value falls.
    All of the shape of ``theta``, in the unit of the values.
    """

    theta: Array
    level: float
    centre: Array
    mean_halfwidth: Array
    halfwidth: Array

    @property
    def mean_lower(self) -> Array:
        """Lower edge of the band of the mean."""
        return self.centre - self.mean_halfwidth

    @property
    def mean_upper(self) -> Array:
        """Upper edge of the band of the mean."""
        return self.centre + self.mean_halfwidth

    @property
    def lower(self) -> Array:
        """Lower edge of the prediction band."""
        return self.centre - self.halfwidth

    @property
    def upper(self) -> Array:
        """Upper edge of the prediction band."""
        return self.centre + self.halfwidth


def law_band(theta: Array, level: float, centre: Array, standard_error: Array, noise: Array, free: int) -> LawBand:
    """Student's bands with ``free`` degrees of freedom: centre ± t·se and centre ± t·√(se² + noise²).

    Exact for independent normal scatter of constant size about a law of the fitted order; else close for many values.

    Raises InvalidInput for a level outside (0, 1).

    >>> one = np.array([1.0])
    >>> band = law_band(np.array([0.0]), 0.95, one, 0.0 * one, one, free=10_000_000)
    >>> band.upper.round(4).tolist()
    [2.96]
    """
    from scipy.special import stdtrit

    probability = finite_number("level", level)
    if not 0.0 < probability < 1.0:
        raise InvalidInput(f"level is {level!r}; it must be a probability between 0 and 1, such as 0.95")
    quantile = float(stdtrit(free, 0.5 + 0.5 * probability))
    return LawBand(theta, probability, centre, quantile * standard_error, quantile * np.hypot(standard_error, noise))
