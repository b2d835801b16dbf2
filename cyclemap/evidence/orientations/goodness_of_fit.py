"""Kuiper's and Watson's statistics of orientations, Monte Carlo p-values, and those of independent samples."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, finite_number, non_negative_number, positive_number, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.orientations.circular_distance import (
    DEFAULT_BINS,
    CircularLaw,
    Labels,
    PooledSamples,
    law_or_sample,
    orientations,
    pooled_samples,
)

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

    >>> monte_carlo_p_value(3.0, [1.0, 2.0, 3.0, 4.0]).value
    0.6
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


_TERMS = np.arange(1.0, 101.0)
_CERTAIN = 0.1  # below it the tail is 1 to all digits: 1 - e^(-490)
_BLOCK = 1 << 21  # labels permuted at a time

_TWO_SAMPLE: dict[str, Callable[[PooledSamples, Labels], Array]] = {
    "wasserstein": PooledSamples.wasserstein,
    "total_variation": lambda pooled, labels: pooled.total_variation(labels, DEFAULT_BINS),
    "kuiper": PooledSamples.kuiper,
    "watson": PooledSamples.watson,
}


def kuiper_statistic(sample: Any, law: Any) -> Array:
    """Kuiper's V = max(F - G) + max(G - F), in (0, 1] against a law, [0, 1] against a sample (Kuiper 1960).

    sample : shape (..., n), radians, any turn. law : a density per radian, a ``CircularLaw`` or a second sample (m,).
    Returns shape (...). Unlike Kolmogorov's distance it does not depend on the origin of the angles.
    Raises InvalidInput for an empty sample, numbers that are not finite and a density that is none.

    >>> round(float(kuiper_statistic([0.0, np.pi], lambda theta: np.full_like(theta, 0.5 / np.pi))), 12)
    0.5
    """
    given = law_or_sample(law)
    if not isinstance(given, CircularLaw):
        pooled = pooled_samples(sample, given)
        return pooled.kuiper(pooled.first)[()]
    reached = np.sort(given.cumulative(orientations("the sample", sample)), axis=-1)
    rank = np.arange(reached.shape[-1] + 1) / reached.shape[-1]
    over, under = np.max(rank[1:] - reached, axis=-1), np.max(reached - rank[:-1], axis=-1)
    return np.asarray(over + under)[()]


def watson_statistic(sample: Any, law: Any) -> Array:
    """Watson's U² = n ∫ (F - G - mean)² dG; nm/N² Σ (d - mean d)² between two samples (Watson 1961, 1962).

    sample, law, errors : as for ``kuiper_statistic``. Returns shape (...), at least 1/(12n) against a law. It does
    not depend on the origin of the angles.

    >>> round(float(watson_statistic([0.0, np.pi], lambda theta: np.full_like(theta, 0.5 / np.pi))) * 24, 12)
    1.0
    """
    given = law_or_sample(law)
    if not isinstance(given, CircularLaw):
        pooled = pooled_samples(sample, given)
        return pooled.watson(pooled.first)[()]
    reached = np.sort(given.cumulative(orientations("the sample", sample)), axis=-1)
    size = reached.shape[-1]
    excess = reached - (2.0 * np.arange(size) + 1.0) / (2.0 * size)
    return np.asarray(size * np.var(excess, axis=-1) + 1.0 / (12.0 * size))[()]


def kuiper_tail(v_star: float) -> float:
    """P(V* > v) of Kuiper's statistic √n·V as n → ∞: 2 Σ (4j²v² - 1) e^(-2j²v²), to rounding (Kuiper 1960).

    >>> round(kuiper_tail(1.74725994585), 10), round(kuiper_tail(2.00091811932), 10)
    (0.05, 0.01)
    """
    value = non_negative_number("v_star", v_star)
    if value < _CERTAIN:
        return 1.0
    square = np.square(_TERMS * value)
    return float(np.clip(2.0 * np.sum((4.0 * square - 1.0) * np.exp(-2.0 * square)), 0.0, 1.0))


def watson_tail(u_squared: float) -> float:
    """P(U² > u) as n → ∞: 2 Σ (-1)^(k-1) e^(-2k²π²u), which is Kolmogorov's law at π√u (Watson 1961).

    >>> round(watson_tail(0.18688), 5)
    0.05
    """
    from scipy.special import kolmogorov

    return float(kolmogorov(np.pi * np.sqrt(non_negative_number("u_squared", u_squared))))


def kuiper_critical_value(level: float) -> float:
    """The v with P(V* > v) = ``level``, level in (0, 1)."""
    return _critical(kuiper_tail, level, 10.0)


def watson_critical_value(level: float) -> float:
    """The u with P(U² > u) = ``level``, level in (0, 1).

    >>> round(watson_critical_value(0.01), 5)
    0.26842
    """
    return _critical(watson_tail, level, 5.0)


def _critical(tail: Callable[[float], float], level: float, most: float) -> float:
    from scipy.optimize import brentq

    share = finite_number("level", level)
    if not 1e-40 <= share < 1.0:
        raise InvalidInput(f"level is {level!r}: give the probability of exceeding it, between 0 and 1")
    return float(brentq(lambda value: tail(value) - share, 0.0, most, xtol=1e-14, rtol=1e-14))


def kuiper_p_value(statistic: float, count: int) -> float:
    """P-value of V for ``count`` INDEPENDENT orientations and a law given in full, nothing in it fitted.

    The asymptotic law at V* = V(√n + 0.155 + 0.24/√n) (Stephens 1970). For n ≥ 8 values up to 0.1 are measured to lie
    within 0.004 of the truth, those near 0.5 up to 0.02 above it. Orientations of a collection are not independent:
    use ``chain_p_value`` for them.
    """
    root = float(np.sqrt(whole_number("count", count, least=1)))
    return kuiper_tail(positive_number("statistic", statistic) * (root + 0.155 + 0.24 / root))


def watson_p_value(statistic: float, count: int) -> float:
    """P-value of U² for ``count`` INDEPENDENT orientations and a law given in full, nothing in it fitted.

    The asymptotic law at U* = (U² - 0.1/n + 0.1/n²)(1 + 0.8/n) (Stephens 1970). For n ≥ 8 values up to 0.1 are measured
    to lie within 0.002 of the truth, those near 0.5 up to 0.03 above it, less as n grows. Orientations of a collection
    are not independent: use ``chain_p_value`` for them.
    """
    size = whole_number("count", count, least=1)
    modified = (positive_number("statistic", statistic) - 0.1 / size + 0.1 / size**2) * (1.0 + 0.8 / size)
    return watson_tail(max(0.0, modified))


def permutation_p_value(
    first: Any, second: Any, statistic: str = "watson", *, runs: int = 999, seed: int = 0
) -> PValue:
    """P-value that two INDEPENDENT samples come from one law, by permuting which angle is whose.

    first, second : (n,) and (m,), radians, any turn. statistic : "wasserstein", "total_variation" (36 bins),
    "kuiper" or "watson". Exact for any sizes and ties: P(p ≤ a) ≤ a. The same seed gives the same value.

    >>> permutation_p_value([0.1, 0.2, 0.3, 0.4, 0.5], [3.1, 3.2, 3.3, 3.4, 3.5], runs=199).value < 0.05
    True
    """
    if statistic not in _TWO_SAMPLE:
        raise InvalidInput(f"statistic is {statistic!r}: it must be one of {', '.join(_TWO_SAMPLE)}")
    measure, pooled = _TWO_SAMPLE[statistic], pooled_samples(first, second)
    left = whole_number("runs", runs, least=1)
    rng = np.random.default_rng(whole_number("seed", seed, least=0))
    block, found = max(1, _BLOCK // pooled.first.size), []
    while left > 0:
        labels = rng.permuted(np.tile(pooled.first, (min(block, left), 1)), axis=1)
        found.append(measure(pooled, labels))
        left -= len(labels)
    return monte_carlo_p_value(float(measure(pooled, pooled.first)), np.concatenate(found))
