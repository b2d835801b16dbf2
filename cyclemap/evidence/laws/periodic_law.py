"""A periodic law fitted to measured values: a Fourier series of the angle, with its scatter and its uncertainty."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.laws.law_bands import LawBand, law_band
from cyclemap.evidence.laws.linear_fit import LinearFit, huber_weights, lag_correlation
from cyclemap.evidence.laws.order_choice import OrderScores, choose_harmonics, cycle_folds
from cyclemap.evidence.laws.periodic_basis import fourier_columns, fourier_slopes
from cyclemap.evidence.laws.periodic_noise import fit_with_scatter, scatter_weights

MAX_HARMONICS = 12


@dataclass(frozen=True, eq=False)
class PeriodicLaw:
    """The law y(θ) = c_0 + Σ_k c_k cos kθ + s_k sin kθ, in the unit of the values it was fitted to.

    coefficients : (2K + 1,) in the order c_0, c_1, s_1, c_2, s_2, ... covariance : (2K + 1, 2K + 1) of these.
    log_variance : (2q + 1,) the log of the scatter's variance, a series in the same order; (1,) for constant scatter.
    sigma : root mean square scatter of one value about the law, degrees of freedom counted.
    count : values fitted. rmse : root mean square residual. mean, total_std : of the values themselves.
    lag_correlation : correlation of each residual with the next in order of recording; far from 0, the covariance of
        independent residuals is too small, and ``correlated=True`` should be asked for.
    scores : the cross-validation, by order; None where the order was given.
    """

    coefficients: Array
    covariance: Array
    log_variance: Array
    sigma: float
    count: int
    rmse: float
    mean: float
    total_std: float
    lag_correlation: float
    scores: OrderScores | None = None

    def __post_init__(self) -> None:
        size = finite_array("coefficients", self.coefficients, ndim=1).size
        if size % 2 == 0 or np.shape(self.covariance) != (size, size) or np.size(self.log_variance) % 2 == 0:
            shapes = f"{np.shape(self.coefficients)}, {np.shape(self.covariance)}, {np.shape(self.log_variance)}"
            raise InvalidInput(
                f"coefficients, covariance, log_variance have shapes {shapes}, not (p,), (p, p), (q,), odd"
            )
        for name in ("coefficients", "covariance", "log_variance"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def harmonics(self) -> int:
        """How many harmonics the law has."""
        return self.coefficients.size // 2

    @property
    def cosine(self) -> Array:
        """c_0, c_1, ...: shape (harmonics + 1,)."""
        return np.append(self.coefficients[0], self.coefficients[1::2])

    @property
    def sine(self) -> Array:
        """s_0 = 0, s_1, ...: shape (harmonics + 1,)."""
        return np.append(0.0, self.coefficients[2::2])

    @property
    def percent(self) -> float:
        """The RMSE in per cent of the mean value (Ma & Rodriguez 2018, Tables II and III); inf for a mean of 0."""
        return 100.0 * self.rmse / abs(self.mean) if self.mean != 0.0 else float("inf")

    @property
    def total_percent(self) -> float:
        """The standard deviation of the values in per cent of their mean; inf for a mean of 0."""
        return 100.0 * self.total_std / abs(self.mean) if self.mean != 0.0 else float("inf")

    def __call__(self, theta: Any) -> Array:
        """The law at θ (radians, any shape)."""
        return np.asarray(fourier_columns(theta, self.harmonics) @ self.coefficients)

    def slope(self, theta: Any) -> Array:
        """dy/dθ, per radian."""
        return np.asarray(fourier_slopes(theta, self.harmonics) @ self.coefficients)

    def standard_error(self, theta: Any) -> Array:
        """The standard error of the law itself at θ: scatter not included."""
        columns = fourier_columns(theta, self.harmonics)
        return np.asarray(np.sqrt(np.maximum(np.einsum("...i,ij,...j->...", columns, self.covariance, columns), 0.0)))

    def noise(self, theta: Any) -> Array:
        """The standard deviation of one value about the law at θ."""
        columns = fourier_columns(theta, self.log_variance.size // 2)
        return np.asarray(np.exp(0.5 * (columns @ self.log_variance)))

    def band(self, theta: Any, level: float = 0.95) -> LawBand:
        """The bands of the mean and of one new value at θ; see ``LawBand``. Errors of the order are not in them."""
        angles = finite_array("theta", theta)
        free = self.count - self.coefficients.size
        return law_band(angles, level, self(angles), self.standard_error(angles), self.noise(angles), free)


def fit_periodic_law(
    theta: ArrayLike,
    value: ArrayLike,
    *,
    harmonics: int | None = None,
    max_harmonics: int = MAX_HARMONICS,
    noise_harmonics: int | None = 0,
    robust: bool = False,
    correlated: bool = False,
    seed: int = 0,
) -> PeriodicLaw:
    """Fit a Fourier series in θ to values measured at ``theta``, in least squares.

    theta, value : (n,), radians and any unit, in order of recording where the order is to be chosen.
    harmonics : the order; None chooses it from 0 to ``max_harmonics`` by ten-fold cross-validation whose folds are made
        of blocks of successive cycles, dealt by ``seed``, with the one-standard-error rule on paired differences.
    noise_harmonics : the order of the log-variance of the scatter in θ; 0 takes it constant, None chooses from 0 to 3
        by cross-validated likelihood. Where it is not 0 the law is the one of maximum likelihood, and its order is
        chosen twice: with equal weights, then with the weights 1/variance (of mean 1) of that first law.
    robust : Huber's weights, for data with outliers; the order is chosen with the weights of the largest order. It goes
        with constant scatter only, which is then that of the values that are no outliers.
    correlated : a covariance that allows for residuals correlated with their neighbours in order of recording (Newey &
        West 1987, with 1.3√n lags); it goes with constant scatter only. A fixed order does not depend on the order of
        the values otherwise.

    Raises InvalidInput for lists of different lengths, values that are not finite, and too few values for the order.

    >>> theta = np.linspace(0.0, 6.0, 40)
    >>> law = fit_periodic_law(theta, 2.0 + np.cos(theta), harmonics=1)
    >>> law.coefficients.round(9).tolist()[:2], round(float(law(np.pi)), 9)
    ([2.0, 1.0], 1.0)
    """
    angles, values = paired_arrays("value", theta, value)
    most = whole_number("max_harmonics", max_harmonics, least=0)
    if harmonics is not None:
        design = fourier_columns(angles, whole_number("harmonics", harmonics, least=0))
        fit, log_variance = fit_with_scatter(angles, design, values, noise_harmonics, robust, correlated, seed)
        return law_of(fit, log_variance, values, None)
    weight = np.ones(values.size)
    for _ in range(1 if noise_harmonics == 0 else 2):
        scores = _scores(angles, values, most, robust, weight, seed)
        design = fourier_columns(angles, scores.chosen)
        fit, log_variance = fit_with_scatter(angles, design, values, noise_harmonics, robust, correlated, seed)
        weight = scatter_weights(angles, log_variance)
    return law_of(fit, log_variance, values, scores)


def law_of(fit: LinearFit, log_variance: Array, values: Array, scores: OrderScores | None) -> PeriodicLaw:
    """The law of a fit to ``values`` (n,) whose coefficients are those of ``fourier_columns``."""
    return PeriodicLaw(
        coefficients=fit.coefficients,
        covariance=fit.covariance,
        log_variance=log_variance,
        sigma=fit.sigma,
        count=values.size,
        rmse=float(np.sqrt(np.mean(fit.residuals**2))),
        mean=float(np.mean(values)),
        total_std=float(np.std(values, ddof=1)) if values.size > 1 else 0.0,
        lag_correlation=lag_correlation(fit.residuals),
        scores=scores,
    )


def paired_arrays(name: str, theta: ArrayLike, value: ArrayLike) -> tuple[Array, Array]:
    """``theta`` and ``value`` as finite arrays (n,), n ≥ 1; InvalidInput otherwise."""
    angles, values = finite_array("theta", theta, ndim=1), finite_array(name, value, ndim=1)
    if angles.shape != values.shape or angles.size == 0:
        raise InvalidInput(
            f"theta and {name} have {angles.size} and {values.size} entries; give equally many, one or more"
        )
    return angles, values


def _scores(angles: Array, values: Array, most: int, robust: bool, weight: Array, seed: int) -> OrderScores:
    fold = cycle_folds(values.size, seed)
    columns = fourier_columns(angles, min(most, (values.size - int(np.bincount(fold).max()) - 2) // 2))
    root = np.sqrt(huber_weights(columns, values) if robust else weight)
    return choose_harmonics(columns * root[:, np.newaxis], values * root, fold)
