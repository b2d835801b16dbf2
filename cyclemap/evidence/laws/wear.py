"""Wear: a periodic law whose coefficients are polynomials of the cycle number."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, finite_number, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.laws.linear_fit import LinearFit, cycle_folds, fourier_columns, nested_errors, simplest_good
from cyclemap.evidence.laws.periodic_law import (
    MAX_HARMONICS,
    PeriodicLaw,
    fit_with_scatter,
    law_of,
    paired_arrays,
    scatter_weights,
)

MAX_WEAR_DEGREE = 4


@dataclass(frozen=True, eq=False)
class WornLaw:
    """A periodic law that wears: its coefficients are Σ_j P_j(s) coefficients[j], s the cycle scaled to [-1, 1].

    coefficients : (degree + 1, 2K + 1), row j with Legendre's polynomial P_j; rows ordered as in ``PeriodicLaw``.
    first, last : the cycles s = -1 and s = 1; outside them the law stays as it is at the nearer one.
    whole : the law at mid-run, with the count, RMSE and scatter of the whole fit. The scatter does not wear.
    covariance : of the coefficients, shape (degree + 1, 2K + 1, degree + 1, 2K + 1).
    rmse_by_order : (degrees, orders) the cross-validated RMSE of each degree (rows) and order (columns); inf where it
        cannot be fitted, None where both were given.
    """

    coefficients: Array
    first: float
    last: float
    whole: PeriodicLaw
    covariance: Array
    rmse_by_order: Array | None = None

    @property
    def degree(self) -> int:
        """The degree of the polynomials; 0 for a law that does not wear."""
        return int(self.coefficients.shape[0]) - 1

    @property
    def harmonics(self) -> int:
        """How many harmonics the law has at each cycle."""
        return int(self.coefficients.shape[1]) // 2

    @property
    def sigma(self) -> float:
        """The scatter of one value about the law of its own cycle, degrees of freedom counted."""
        return self.whole.sigma

    @property
    def rmse(self) -> float:
        """Root mean square of the residuals about the law of each value's own cycle."""
        return self.whole.rmse

    def turns(self, theta: Array, cycle: Array) -> Array:
        """The law (n,) at the angles ``theta`` (n,), rad, each in its own ``cycle`` (n,)."""
        polynomials = _polynomials(cycle, self.first, self.last, self.degree)
        return np.asarray(_worn_columns(theta, polynomials, self.harmonics) @ self.coefficients.T.ravel())

    def at(self, cycle: float) -> PeriodicLaw:
        """The law of one cycle (any real number), with the covariance of that cycle's coefficients."""
        now = _polynomials(np.array([finite_number("cycle", cycle)]), self.first, self.last, self.degree)[0]
        covariance = np.einsum("i,iajb,j->ab", now, self.covariance, now)
        return replace(self.whole, coefficients=now @ self.coefficients, covariance=covariance)


def fit_worn_law(
    theta: ArrayLike,
    value: ArrayLike,
    cycle: ArrayLike,
    *,
    harmonics: int | None = None,
    max_harmonics: int = MAX_HARMONICS,
    degree: int | None = None,
    max_degree: int = MAX_WEAR_DEGREE,
    noise_harmonics: int | None = 0,
    seed: int = 0,
) -> WornLaw:
    """Fit a Fourier series in θ whose coefficients are polynomials of the cycle number, in least squares.

    theta, value, cycle : (n,), radians, any unit, and numbers of the cycles; the rows in order of recording.
    harmonics, degree : the two orders; what is None is chosen, both together, as in ``fit_periodic_law``: by blocks of
        successive cycles left out, the fewest coefficients within one standard error of the best.
    noise_harmonics, seed : as in ``fit_periodic_law``.

    Raises InvalidInput as there, and where all cycles are the same.

    >>> n = np.arange(400.0)
    >>> worn = fit_worn_law(2.4 * n, (1.0 + n / 100) * np.cos(2.4 * n), n, harmonics=1, degree=1)
    >>> worn.at(100.0).coefficients.round(9).tolist()[1]
    2.0
    """
    angles, values = paired_arrays("value", theta, value)
    cycles = finite_array("cycle", cycle, ndim=1)
    if cycles.size != values.size:
        raise InvalidInput(f"cycle has {cycles.size} entries for {values.size} pairs; give one a pair")
    if np.ptp(cycles) == 0.0:
        raise InvalidInput(f"every cycle is {cycles[0]:g}; wear needs cycles that differ")
    first, last = float(cycles.min()), float(cycles.max())
    orders = (_candidates("harmonics", harmonics, max_harmonics), _candidates("degree", degree, max_degree))
    polynomials = _polynomials(cycles, first, last, max(orders[1]))
    weight = np.ones(values.size)
    for _ in range(1 if noise_harmonics == 0 else 2):
        table, order, power = _chosen(angles, values, polynomials, orders, weight, seed)
        design = _worn_columns(angles, polynomials[:, : power + 1], order)
        fit, log_variance = fit_with_scatter(angles, design, values, noise_harmonics, seed)
        weight = scatter_weights(angles, log_variance)
    shape = (2 * order + 1, power + 1)
    coefficients = read_only(fit.coefficients.reshape(shape).T)
    covariance = read_only(fit.covariance.reshape(shape + shape).transpose(1, 0, 3, 2))
    plain = LinearFit(coefficients[0], covariance[0, :, 0, :], fit.residuals, fit.sigma)
    whole = law_of(plain, log_variance, values, None)
    middle = WornLaw(coefficients, first, last, whole, covariance).at(0.5 * (first + last))
    return WornLaw(coefficients, first, last, middle, covariance, table)


def _candidates(name: str, given: int | None, most: int) -> list[int]:
    if given is not None:
        return [whole_number(name, given, least=0)]
    return list(range(whole_number(f"max_{name}", most, least=0) + 1))


def _polynomials(cycles: Array, first: float, last: float, degree: int) -> Array:
    """Legendre's polynomials (n, degree + 1) of the cycles, held at the ends of [first, last]."""
    scaled = np.clip((2.0 * cycles - first - last) / (last - first), -1.0, 1.0)
    return np.asarray(np.polynomial.legendre.legvander(scaled, degree))


def _worn_columns(angles: Array, polynomials: Array, harmonics: int) -> Array:
    """Each Fourier column times each polynomial, the polynomials innermost: orders are nested for one degree."""
    columns = fourier_columns(angles, harmonics)
    return (columns[:, :, np.newaxis] * polynomials[:, np.newaxis, :]).reshape(angles.size, -1)


def _chosen(
    angles: Array, values: Array, polynomials: Array, orders: tuple[list[int], list[int]], weight: Array, seed: int
) -> tuple[Array | None, int, int]:
    """The table of cross-validated RMSE (None where nothing is open), the order and the degree."""
    waves, powers = orders
    if len(waves) == len(powers) == 1:
        return None, waves[0], powers[0]
    fold, errors, sizes = cycle_folds(values.size, seed), [], []
    for power in powers:
        sizes.append((2 * np.array(waves) + 1) * (power + 1))
        design = _worn_columns(angles, polynomials[:, : power + 1], max(waves))
        errors.append(nested_errors(design, values, sizes[-1], fold, weight))
    chosen, mean = simplest_good(np.hstack(errors), np.concatenate(sizes), fold)
    table = read_only(np.sqrt(mean).reshape(len(powers), len(waves)))
    return table, waves[chosen % len(waves)], powers[chosen // len(waves)]
