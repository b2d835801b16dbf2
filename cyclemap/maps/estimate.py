"""Numbers that carry a bound on their own error, and what double precision leaves: each allowance
once.
"""

from __future__ import annotations

import math

import numpy as np

from cyclemap.errors import InvalidInput

EPS = float(np.finfo(float).eps)
"""2⁻⁵², the spacing of floats at 1: twice the relative error of one operation."""

LIFT = 4.0 * EPS
"""Of 2π + |F|: one value of a lift, or of 1 + |F'| one of its derivative; a sine, two products and
two sums."""

STENCIL = 12.0 * EPS
"""Of the values that a five-point difference adds up: three ``LIFT``, the sum of its weights' sizes
being 1.5 to 10."""

MEAN = 2.0 * EPS
"""Of the largest value: a mean by numpy's pairwise sum, and the rounding of its weights."""

INTEGRAL = 16.0 * EPS
"""Of Σ |weight·value|: an integral by a rule of some thousand nodes, each value rounded a few
times."""

MATRIX = 4.0 * EPS
"""Of a matrix's norm: what an eigenvalue solver or a product of matrices adds to it (backward
error)."""

SOLUTION = 16.0 * EPS
"""Of a value interpolated from a solved system: its sum, and the last digit of the float that it is
given as."""

ELIMINATION = 1e-13
"""Relative: elimination without subtraction of some thousand states (O'Cinneide 1993 proves n³ EPS;
seen: 1e-14)."""

LOG_PASSAGE = 2e-14
"""Of ln T, relative: a hundred ``EPS``, for logarithms added up along the ways out."""

ANGLE = 1e-13
"""Radians: an angle after whole turns are taken off and a root is solved, a hundred spacings of
floats at 2π."""

SAME_ANGLE = 1e-14
"""Radians: angles nearer than this, some ten spacings of floats at 2π, are one that was reached in
two ways."""

STAIRCASE = 1e-9
"""Of a window of angles from a file: ten printed digits."""


class Estimate(float):
    """A number and a bound on its error: everywhere a float, with ``error_bound``, ``lower`` and
    ``upper``.

    Parameters
    ----------
    value : float
        The number.
    error_bound : float
        How far off it may be, 0 or more; inf says that nothing is known.

    Raises
    ------
    InvalidInput
        For a bound that is negative or nan.

    Notes
    -----
    Arithmetic gives plain floats. What the bound covers, and which part of it is proved, is said
    where the number is made.

    Examples
    --------
    >>> from cyclemap.maps import Estimate
    >>> half = Estimate(0.4999, 0.001)
    >>> half.lower <= 0.5 <= half.upper, half * 2
    (True, 0.9998)
    """

    __slots__ = ("error_bound",)
    error_bound: float

    def __new__(cls, value: float, error_bound: float) -> Estimate:  # noqa: D102
        if not error_bound >= 0.0:
            raise InvalidInput(
                f"error_bound is {error_bound!r}: a bound on an error is zero or more"
            )
        made = super().__new__(cls, value)
        object.__setattr__(made, "error_bound", float(error_bound))
        return made

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"cannot set {name!r}: an Estimate never changes")

    def __reduce__(self) -> tuple[type[Estimate], tuple[float, float]]:
        return Estimate, (float(self), self.error_bound)

    @property
    def lower(self) -> float:
        """The least that the truth can be, rounded outward."""
        return (
            math.nextafter(float(self) - self.error_bound, -math.inf)
            if self.error_bound
            else float(self)
        )

    @property
    def upper(self) -> float:
        """The most that the truth can be, rounded outward."""
        return (
            math.nextafter(float(self) + self.error_bound, math.inf)
            if self.error_bound
            else float(self)
        )

    def holds(self, truth: float) -> bool:
        """Whether ``truth`` lies between ``lower`` and ``upper``."""
        return self.lower <= truth <= self.upper
