"""How much equal pushes differ: mean, spread and percentage of Δθ, Δx, Δy (Ma & Rodriguez 2018, Table II)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.checks import whole_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.tables.push_sets import PushSet

QUANTITIES = ("dtheta", "dx", "dy")
# Two values have a spread; nobody should quote that of fewer than this many.
FEWEST_FOR_SPREAD = 5


@dataclass(frozen=True)
class MotionStatistics:
    """Mean and standard deviation (n - 1 in its divisor) of one quantity: Δθ in rad, Δx or Δy in m.

    mean_error : standard error of the mean, std/√n, for pushes that are independent: those of a staircase are not.
    """

    count: int
    mean: float
    std: float

    @property
    def percent(self) -> float:
        """The standard deviation in per cent of the mean's size; inf for a mean of 0."""
        return 100.0 * self.std / abs(self.mean) if self.mean != 0.0 else float("inf")

    @property
    def mean_error(self) -> float:
        """The standard error of the mean."""
        return float(self.std / np.sqrt(self.count))


@dataclass(frozen=True)
class PushStatistics:
    """A row of the table: a set's name, its count, its statistics, and what is wrong with it, else None."""

    name: str
    count: int
    dtheta: MotionStatistics | None
    dx: MotionStatistics | None
    dy: MotionStatistics | None
    problem: str | None = None


def motion_statistics(value: ArrayLike) -> MotionStatistics:
    """The statistics of the values (n,) that are known: NaN is passed over.

    Raises InvalidInput for fewer than two known values.

    >>> row = motion_statistics([1.0, 2.0, 3.0, np.nan])
    >>> row.count, row.mean, row.std, row.percent
    (3, 2.0, 1.0, 50.0)
    """
    values = np.asarray(value, dtype=float).ravel()
    known = values[np.isfinite(values)]
    if known.size < 2:
        raise InvalidInput(f"{known.size} known values have no spread; give at least two")
    return MotionStatistics(known.size, float(np.mean(known)), float(np.std(known, ddof=1)))


def push_statistics(pushes: PushSet, fewest: int = FEWEST_FOR_SPREAD) -> PushStatistics:
    """The set's row of the table; with fewer than ``fewest`` pushes of known motion it has a problem and no numbers."""
    least = max(2, whole_number("fewest", fewest, least=0))
    known = int(np.sum(np.isfinite(pushes.dtheta)))
    if known < least:
        reason = f"too few pushes with a known end for a spread: {known} of {least}"
        return PushStatistics(pushes.name, pushes.count, None, None, None, reason)
    dtheta, dx, dy = (motion_statistics(getattr(pushes, quantity)) for quantity in QUANTITIES)
    return PushStatistics(pushes.name, pushes.count, dtheta, dx, dy)
