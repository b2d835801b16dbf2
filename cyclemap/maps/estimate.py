"""Estimate: a float that carries a bound on its own error."""

from __future__ import annotations

import math
from typing import Any

from cyclemap.errors import InvalidInput


class Estimate(float):
    """A number and a bound on its error: everywhere a float, with ``error_bound``, ``lower`` and ``upper``.

    Arithmetic gives plain floats. What the bound covers, and which part of it is proved, is said where the
    number is made; inf says that nothing is known.

    Raises InvalidInput for a bound that is negative or nan.

    >>> half = Estimate(0.4999, 0.001)
    >>> half.lower <= 0.5 <= half.upper, half * 2
    (True, 0.9998)
    """

    __slots__ = ("error_bound",)
    error_bound: float

    def __new__(cls, value: float, error_bound: float) -> Estimate:  # noqa: D102
        if not error_bound >= 0.0:
            raise InvalidInput(f"error_bound is {error_bound!r}: a bound on an error is zero or more")
        made = super().__new__(cls, value)
        object.__setattr__(made, "error_bound", float(error_bound))
        return made

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"cannot set {name!r}: an Estimate never changes")

    def __reduce__(self) -> tuple[type[Estimate], tuple[float, float]]:
        return Estimate, (float(self), self.error_bound)

    @property
    def lower(self) -> float:
        """The least that the truth can be, rounded outward."""
        return math.nextafter(float(self) - self.error_bound, -math.inf) if self.error_bound else float(self)

    @property
    def upper(self) -> float:
        """The most that the truth can be, rounded outward."""
        return math.nextafter(float(self) + self.error_bound, math.inf) if self.error_bound else float(self)

    def holds(self, truth: float) -> bool:
        """Whether ``truth`` lies between ``lower`` and ``upper``."""
        return self.lower <= truth <= self.upper
