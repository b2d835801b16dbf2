"""Kuiper's and Watson's statistics of orientations, and Monte Carlo p-values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, finite_number, read_only
from cyclemap.errors import InvalidInput
from cyclemap.evidence.orientations.circular_distance import CircularLaw, orientations

_TIE = 1e-12  # values that differ by rounding alone count as equal, which makes p larger


@dataclass(frozen=True, eq=False)
class PValue:
    """A Monte Carlo p-value and what it rests on.

    value : (1 + number of simulated statistics that reach the observed one)/(runs + 1), in (0, 1] (Davison &
        Hinkley 1997): under the null P(value ≤ a) ≤ a for any a and any number of runs.
    runs : simulated statistics. statistic : the observed one.
    null_quantiles : the simulated ones at the levels ``LEVELS``.
    standard_error : of ``value`` by the finite number of runs: the posterior standard deviation of the true p
        after a uniform prior, which is never 0.
    """

    LEVELS: ClassVar[tuple[float, ...]] = (0.05, 0.25, 0.5, 0.75, 0.9, 0.95, 0.99)

    value: float
    runs: int
    statistic: float
    null_quantiles: Array
    standard_error: float


def monte_carlo_p_value(observed: float, simulated: Any) -> PValue:
    """The upper-tail p-value of ``observed`` among ``simulated`` (runs,) values under the null.

    Raises InvalidInput without simulated values or where a number is not finite.
    """
    null = finite_array("simulated", simulated, ndim=1)
    mark = finite_number("observed", observed)
    if null.size == 0:
        raise InvalidInput("there are no simulated values: run at least one")
    reached = int(np.sum(null >= mark - _TIE * max(1.0, abs(mark))))
    more, fewer, total = reached + 1, null.size - reached + 1, null.size + 2
    error = float(np.sqrt(more * fewer / (total**2 * (total + 1))))
    quantiles = read_only(np.quantile(null, PValue.LEVELS))
    return PValue((1 + reached) / (null.size + 1), null.size, mark, quantiles, error)


def kuiper_statistic(sample: Any, law: Any) -> Array:
    """Kuiper's V = max(F - G) + max(G - F), in (0, 1] (Kuiper 1960).

    sample : shape (..., n), radians, any turn. law : a density per radian (vectorised callable), or a ``CircularLaw``.
    Returns shape (...). Unlike Kolmogorov's distance it does not depend on the origin of the angles.
    Raises InvalidInput for an empty sample, numbers that are not finite and a density that is none.

    >>> round(float(kuiper_statistic([0.0, np.pi], lambda theta: np.full_like(theta, 0.5 / np.pi))), 12)
    0.5
    """
    given = law if isinstance(law, CircularLaw) else CircularLaw(law)
    reached = np.sort(given.cumulative(orientations("the sample", sample)), axis=-1)
    rank = np.arange(reached.shape[-1] + 1) / reached.shape[-1]
    over, under = np.max(rank[1:] - reached, axis=-1), np.max(reached - rank[:-1], axis=-1)
    return np.asarray(over + under)[()]


def watson_statistic(sample: Any, law: Any) -> Array:
    """Watson's U² = n ∫ (F - G - mean)² dG (Watson 1961), at least 1/(12n).

    sample, law, errors : as for ``kuiper_statistic``. Returns shape (...). It does not depend on the origin either.

    >>> round(float(watson_statistic([0.0, np.pi], lambda theta: np.full_like(theta, 0.5 / np.pi))) * 24, 12)
    1.0
    """
    given = law if isinstance(law, CircularLaw) else CircularLaw(law)
    reached = np.sort(given.cumulative(orientations("the sample", sample)), axis=-1)
    size = reached.shape[-1]
    excess = reached - (2.0 * np.arange(size) + 1.0) / (2.0 * size)
    return np.asarray(size * np.var(excess, axis=-1) + 1.0 / (12.0 * size))[()]
