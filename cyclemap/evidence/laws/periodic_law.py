"""A periodic law fitted to measured values: a Fourier series of the angle, with its scatter, bands
and uncertainty.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array, widest_gap
from cyclemap.checks import finite_array, read_only, whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.laws.linear_fit import (
    FOLDS,
    LinearFit,
    cycle_folds,
    fit_linear,
    fourier_columns,
    nested_errors,
    simplest_good,
    student_quantile,
    weighted_fit,
)

MAX_HARMONICS = 12
_MAX_NOISE_HARMONICS = 3
_TOLERANCE = 1e-12
_MAX_ROUNDS = 500
# Residuals this small beside the values are rounding: there is no scatter to describe.
_ROUNDING = 1e-12
# e to this is far beyond any ratio of variances, and its square is still a number.
_LARGEST_EXPONENT = 300.0


def fit_with_scatter(
    theta: Array, design: Array, value: Array, noise_harmonics: int | None, seed: int
) -> tuple[LinearFit, Array]:
    """The fit of value (n,) ≈ design (n, p) @ coefficients, and the log-variance (2q + 1,) of its
    scatter in θ.
    """
    order = noise_harmonics
    if order is not None:
        order = whole_number("noise_harmonics", order, least=0)
    fit = fit_linear(design, value)
    if fit.sigma <= _ROUNDING * float(np.max(np.abs(value))):
        if order:
            raise InvalidInput(
                f"noise_harmonics is {order} but the values lie exactly on a smooth curve; use 0"
            )
        order = 0
    elif order is None:
        order = _noise_harmonics(theta, design, value, seed)
    if order == 0:
        # No scatter at all has no logarithm: the smallest positive number stands for it.
        return fit, np.array([2.0 * np.log(max(fit.sigma, np.finfo(float).tiny))])
    # Reweighted least squares: the mean with weights 1/variance, the log-variance of its residuals,
    # and so on to the maximum of the normal likelihood; the variance is then raised by n/(n - p).
    columns = fourier_columns(theta, order)
    weight = np.ones(value.size)
    change = np.inf
    for _ in range(_MAX_ROUNDS):
        gamma = fit_log_variance(columns, weighted_fit(design, value, weight).residuals ** 2)
        renewed = np.exp(-(columns @ gamma))
        change = float(np.max(np.abs(renewed / weight - 1.0)))
        weight = renewed
        if change < 1e-8:
            break
    else:
        raise ConvergenceError(
            f"mean and scatter still change by {change:.3g}: use fewer noise harmonics"
        )
    gamma[0] += np.log(value.size / (value.size - design.shape[1]))
    return weighted_fit(design, value, np.exp(-(columns @ gamma))), gamma


def scatter_weights(theta: Array, log_variance: Array) -> Array:
    """The weights 1/variance at θ (n,), scaled to a mean of 1."""
    level = -(fourier_columns(theta, log_variance.size // 2) @ log_variance)
    weight = np.exp(level - np.max(level))
    return np.asarray(weight / np.mean(weight))


def fit_log_variance(columns: Array, squares: Array) -> Array:
    """The coefficients γ (q,) of log variance = columns @ γ that make normal residuals, squares
    (n,), likeliest.

    Harvey's model (1976). Minus the log-likelihood ½Σ(g + r²e^{-g}) is convex in γ: Newton's method
    with halved steps finds its one minimum, until the decrease it foresees is below 1e-12 a value.
    Raises ConvergenceError where the residuals vanish along a part of the circle, since the
    likelihood then has no bound.
    """

    def loss(gamma: Array) -> float:
        """Mean of g + r²e^{-g}, twice minus the log-likelihood a value; inf where it overflows."""
        level = columns @ gamma
        return (
            float(np.mean(level + squares * np.exp(-level))) if np.min(level) > -600.0 else np.inf
        )

    gamma = np.zeros(columns.shape[1])
    gamma[0] = np.log(np.mean(squares))
    for _ in range(_MAX_ROUNDS):
        ratio = squares * np.exp(-(columns @ gamma))
        slope = columns.T @ (1.0 - ratio)
        curvature = columns.T @ (columns * ratio[:, np.newaxis])
        step = np.asarray(np.linalg.lstsq(curvature, -slope, rcond=None)[0], dtype=np.float64)
        decrease = float(-slope @ step) / squares.size
        if decrease < _TOLERANCE:
            return gamma
        # The share 1, ½, ¼, ... of the step whose gain is a fair part of what its slope promises
        # (Armijo's rule).
        start = loss(gamma)
        share = 1.0
        while not start - (ahead := loss(gamma + share * step)) >= 1e-4 * share * decrease:
            if share < 1e-6 and np.isfinite(ahead):
                break
            if share < 1e-12:
                raise ConvergenceError(
                    "the scatter vanishes along a part of the circle: use fewer noise harmonics"
                )
            share *= 0.5
        gamma = gamma + share * step
    raise ConvergenceError(
        f"the likelihood of the scatter still gains {decrease:.3g}: use fewer noise harmonics"
    )


def _noise_harmonics(theta: Array, design: Array, value: Array, seed: int) -> int:
    """The order of the log-variance that gives values left out the largest likelihood, by the
    one-standard-error rule.

    The residuals are those of prediction: each from the law fitted without its own fold. 0 is
    constant scatter.
    """
    fold = cycle_folds(theta, seed)
    squares = nested_errors(design, value, np.array([design.shape[1]]), fold)[:, 0]
    judged = fold >= 0
    if not np.isfinite(squares[judged]).all():
        raise InvalidInput(
            "the law cannot be fitted with a fold left out; give more pairs, or noise_harmonics "
            "yourself"
        )
    # In a gap wider than half a wave of it a series may do anything.
    orders = np.arange(min(_MAX_NOISE_HARMONICS, int(np.pi / widest_gap(theta))) + 1)
    losses = np.zeros((value.size, orders.size))
    for order in orders.tolist():
        columns = fourier_columns(theta, order)
        for index in range(FOLDS):
            out = fold == index
            rest = judged & ~out
            level = columns[out] @ fit_log_variance(columns[rest], squares[rest])
            # A law that leaves no scatter at all where something was left out is lost by any
            # measure.
            losses[out, order] = 0.5 * (
                level + squares[out] * np.exp(np.minimum(-level, _LARGEST_EXPONENT))
            )
    return simplest_good(losses, 2 * orders + 1, fold)[0]


@dataclass(frozen=True, eq=False)
class PeriodicLaw:
    """The law y(θ) = c_0 + Σ_k c_k cos kθ + s_k sin kθ, in the unit of the values it was fitted to.

    Parameters
    ----------
    coefficients : array_like, shape (2K + 1,)
        In the order c_0, c_1, s_1, c_2, s_2, ...
    covariance : array_like, shape (2K + 1, 2K + 1)
        Of the coefficients.
    log_variance : array_like, shape (2q + 1,)
        The log of the scatter's variance, a series in the same order; (1,) for constant
        scatter.
    sigma : float
        Root mean square scatter of one value about the law, degrees of freedom counted.
    count : int
        How many values were fitted.
    rmse : float
        Root mean square of the residuals.
    mean : float
        Mean of the values fitted.
    total_std : float
        Standard deviation of the values fitted.
    lag_correlation : float
        Of each residual with the next in order of recording, 0 where all are rounding; far from 0,
        the covariance, that of independent residuals, is too small.
    rmse_by_order : ndarray, shape (orders,), or None
        Root mean square error in values left out, by order, inf where it cannot be fitted; None
        where the order was given.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import fit_periodic_law
    >>> theta = np.linspace(0.0, 6.0, 40)
    >>> law = fit_periodic_law(theta, 2.0 + np.cos(theta), harmonics=1)
    >>> law.harmonics, round(float(law.slope(np.pi / 2.0)), 9), law.count
    (1, -1.0, 40)
    """

    coefficients: Array
    covariance: Array
    log_variance: Array
    sigma: float = field(metadata={"name": "scatter"})
    count: int
    rmse: float
    mean: float
    total_std: float
    lag_correlation: float
    rmse_by_order: Array | None = None

    def __post_init__(self) -> None:
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
        """The RMSE in per cent of the mean value (Ma & Rodriguez 2018, Tables II and III); inf for
        a mean of 0.
        """
        return 100.0 * self.rmse / abs(self.mean) if self.mean != 0.0 else float("inf")

    def __call__(self, theta: ArrayLike) -> Array:
        """The law at θ (radians, any shape)."""
        return fourier_columns(theta, self.harmonics) @ self.coefficients

    def slope(self, theta: ArrayLike) -> Array:
        """dy/dθ, per radian."""
        order = np.arange(self.harmonics + 1)
        multiples = np.multiply.outer(np.asarray(theta, dtype=np.float64), order)
        return np.cos(multiples) @ (order * self.sine) - np.sin(multiples) @ (order * self.cosine)

    def standard_error(self, theta: ArrayLike) -> Array:
        """The standard error of the law itself at θ: scatter not included."""
        columns = fourier_columns(theta, self.harmonics)
        variance = np.einsum("...i,ij,...j->...", columns, self.covariance, columns)
        return np.asarray(np.sqrt(np.maximum(variance, 0.0)))

    def noise(self, theta: ArrayLike) -> Array:
        """The standard deviation of one value about the law at θ."""
        columns = fourier_columns(theta, self.log_variance.size // 2)
        return np.exp(0.5 * (columns @ self.log_variance))

    def half_bands(self, theta: ArrayLike) -> tuple[Array, Array]:
        """How far Student's bands of 95 %, one angle at a time, reach to either side of the law.

        Parameters
        ----------
        theta : array_like
            Angles θ, rad, any shape.

        Returns
        -------
        mean : ndarray
            That of the mean, t·se.
        value : ndarray
            That of one new value, t·√(se² + noise²).

        Notes
        -----
        Exact for independent normal scatter of constant size about a law of the fitted order, else
        close for many values; errors of the order are not in them.
        """
        quantile = student_quantile(0.95, self.count - self.coefficients.size)
        error = self.standard_error(theta)
        return quantile * error, quantile * np.hypot(error, self.noise(theta))


def fit_periodic_law(
    theta: ArrayLike,
    value: ArrayLike,
    *,
    harmonics: int | None = None,
    max_harmonics: int = MAX_HARMONICS,
    noise_harmonics: int | None = 0,
    seed: int = 0,
) -> PeriodicLaw:
    """Fit a Fourier series in θ to values measured at ``theta``, in least squares.

    Parameters
    ----------
    theta : array_like, shape (n,)
        Angles, rad, in order of recording where the order is to be chosen.
    value : array_like, shape (n,)
        Values, any unit.
    harmonics : int or None, optional
        The order; None chooses it from 0 to ``max_harmonics`` by ten-fold cross-validation
        whose folds are made of blocks of successive cycles, dealt by ``seed``, with the
        one-standard-error rule on paired differences.
    max_harmonics : int, optional
        The largest order that is tried.
    noise_harmonics : int or None, default 0
        The order of the log-variance of the scatter in θ; 0 takes it constant, None chooses
        from 0 to 3 by cross-validated likelihood, as many as have half a wave in the widest gap
        between angles. Where it is not 0 the law is the one of
        maximum likelihood, and its order is chosen twice: with equal weights, then with the
        weights 1/variance (of mean 1) of that first law.
    seed : int, default 0
        Deals the blocks.

    Returns
    -------
    PeriodicLaw
        The law, its covariance and its scatter.

    Raises
    ------
    InvalidInput
        For lists of different lengths, values that are not finite, and too few values for the
        order.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import fit_periodic_law
    >>> theta = np.linspace(0.0, 6.0, 40)
    >>> law = fit_periodic_law(theta, 2.0 + np.cos(theta), harmonics=1)
    >>> law.coefficients.round(9).tolist()[:2], round(float(law(np.pi)), 9)
    ([2.0, 1.0], 1.0)
    """
    angles, values = paired_arrays("value", theta, value)
    orders = candidate_orders("harmonics", harmonics, max_harmonics)
    fit, log_variance, _, _, errors = fit_series(
        angles,
        values,
        np.ones((values.size, 1)),
        orders=orders,
        degrees=[0],
        noise_harmonics=noise_harmonics,
        seed=seed,
    )
    return law_of(fit, log_variance, values, None if errors is None else read_only(errors[0]))


def candidate_orders(name: str, given: int | None, most: int) -> list[int]:
    """The order that is given, or all up to ``most``."""
    if given is not None:
        return [whole_number(name, given, least=0)]
    return list(range(whole_number(f"max_{name}", most, least=0) + 1))


def series_columns(angles: Array, polynomials: Array, harmonics: int) -> Array:
    """Each Fourier column times each of the polynomials (n, m), these innermost: orders are nested
    for one degree.
    """
    columns = fourier_columns(angles, harmonics)
    return (columns[:, :, np.newaxis] * polynomials[:, np.newaxis, :]).reshape(angles.size, -1)


def fit_series(
    angles: Array,
    values: Array,
    polynomials: Array,
    *,
    orders: list[int],
    degrees: list[int],
    noise_harmonics: int | None,
    seed: int,
) -> tuple[LinearFit, Array, int, int, Array | None]:
    """Fit a Fourier series whose coefficients are sums of polynomials (n, m): fit, log-variance,
    order, degree, errors.

    Order and degree are the one-standard-error choice from the candidates, which begin with 0 where
    there are several; the errors (degrees, orders) are the root mean squares in values left out,
    None without a choice. With scatter that depends on θ the choice is made again, with the weights
    of the first.
    """
    weight = np.ones(values.size)
    errors = None
    order = orders[0]
    degree = degrees[0]
    choice = len(orders) > 1 or len(degrees) > 1
    for _ in range(2 if choice and noise_harmonics != 0 else 1):
        if choice:
            # Each degree with all orders, which are nested, by what is left out of the folds.
            fold = cycle_folds(angles, seed)
            squares = []
            sizes = [(2 * np.array(orders) + 1) * (candidate + 1) for candidate in degrees]
            for candidate, size in zip(degrees, sizes, strict=True):
                design = series_columns(angles, polynomials[:, : candidate + 1], max(orders))
                squares.append(nested_errors(design, values, size, fold, weight))
            chosen, mean = simplest_good(np.hstack(squares), np.concatenate(sizes), fold)
            errors = np.sqrt(mean).reshape(len(degrees), len(orders))
            order = orders[chosen % len(orders)]
            degree = degrees[chosen // len(orders)]
        design = series_columns(angles, polynomials[:, : degree + 1], order)
        fit, log_variance = fit_with_scatter(angles, design, values, noise_harmonics, seed)
        weight = scatter_weights(angles, log_variance)
    return fit, log_variance, order, degree, errors


def law_of(
    fit: LinearFit, log_variance: Array, values: Array, rmse_by_order: Array | None
) -> PeriodicLaw:
    """The law of a fit to ``values`` (n,) whose coefficients are those of ``fourier_columns``."""
    off = fit.residuals
    power = float(off @ off)
    # Residuals of rounding size follow each other by how sums are rounded, not by the data.
    rounding = 1e-26 * float(values @ values)
    return PeriodicLaw(
        fit.coefficients,
        fit.covariance,
        log_variance,
        fit.sigma,
        values.size,
        rmse=float(np.sqrt(np.mean(off**2))),
        mean=float(np.mean(values)),
        total_std=float(np.std(values, ddof=1)),
        lag_correlation=float(off[1:] @ off[:-1]) / power if power > rounding else 0.0,
        rmse_by_order=rmse_by_order,
    )


def paired_arrays(name: str, theta: ArrayLike, value: ArrayLike) -> tuple[Array, Array]:
    """``theta`` and ``value`` as finite arrays (n,), n ≥ 1; InvalidInput otherwise."""
    angles = finite_array("theta", theta, ndim=1)
    values = finite_array(name, value, ndim=1)
    if angles.shape != values.shape or angles.size == 0:
        raise InvalidInput(
            f"theta and {name} have {angles.size} and {values.size} entries; give equally many, "
            "one or more"
        )
    return angles, values
