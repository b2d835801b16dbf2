"""Scatter that depends on the angle: its log-variance as a short Fourier series, by maximum likelihood."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.checks import whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.laws.linear_fit import LinearFit, fit_linear, weighted_least_squares
from cyclemap.evidence.laws.order_choice import cycle_folds, nested_errors, simplest_good
from cyclemap.evidence.laws.periodic_basis import fourier_columns

MAX_NOISE_HARMONICS = 3
TOLERANCE = 1e-12
MAX_ROUNDS = 500
# Residuals this small beside the values are rounding: there is no scatter to describe.
ROUNDING = 1e-12
# e to this is far beyond any ratio of variances, and its square is still a number.
_LARGEST_EXPONENT = 300.0


def fit_with_scatter(
    theta: Array,
    design: Array,
    value: Array,
    noise_harmonics: int | None = 0,
    robust: bool = False,
    correlated: bool = False,
    seed: int = 0,
) -> tuple[LinearFit, Array]:
    """The fit of value (n,) ≈ design (n, p) @ coefficients, and the log-variance (2q + 1,) of its scatter in θ.

    noise_harmonics : q; 0 for constant scatter (see ``fit_linear`` for the rest), None chooses up to 3.

    >>> fit, log_variance = fit_with_scatter(np.zeros(4), np.ones((4, 1)), np.array([-1.0, 1.0, -1.0, 1.0]))
    >>> np.exp(log_variance).round(9).tolist()
    [1.333333333]
    """
    if (robust or correlated) and noise_harmonics != 0:
        raise InvalidInput(f"noise_harmonics is {noise_harmonics}; robust and correlated fits need noise_harmonics=0")
    fit = fit_linear(design, value, robust=robust, correlated=correlated)
    order = _noise_order(noise_harmonics, theta, design, value, fit, seed)
    if order == 0:
        # No scatter at all has no logarithm: the smallest positive number stands for it.
        return fit, np.array([2.0 * np.log(max(fit.sigma, np.finfo(float).tiny))])
    coefficients, inverse, gamma = fit_mean_and_noise(design, value, fourier_columns(theta, order))
    residuals = value - design @ coefficients
    sigma = float(np.sqrt(residuals @ residuals / (value.size - coefficients.size)))
    return LinearFit(coefficients, inverse, residuals, sigma), gamma


def scatter_weights(theta: Array, log_variance: Array) -> Array:
    """The weights 1/variance at θ (n,), scaled to a mean of 1.

    >>> scatter_weights(np.array([0.0, np.pi]), np.array([5.0])).tolist()
    [1.0, 1.0]
    """
    level = -(fourier_columns(theta, log_variance.size // 2) @ log_variance)
    weight = np.exp(level - np.max(level))
    return np.asarray(weight / np.mean(weight))


def fit_log_variance(columns: Array, squares: Array) -> Array:
    """The coefficients γ (q,) of log variance = columns @ γ that make normal residuals, squares (n,), likeliest.

    Harvey's model (1976). Minus the log-likelihood ½Σ(g + r²e^{-g}) is convex in γ: Newton's method with halved steps
    finds its one minimum, until the decrease it foresees is below 1e-12 a value. Raises ConvergenceError where the
    residuals vanish along a part of the circle, since the likelihood then has no bound.

    >>> fit_log_variance(np.ones((3, 1)), np.array([1.0, 2.0, 3.0])).round(9).tolist()
    [0.693147181]
    """
    gamma = np.zeros(columns.shape[1])
    gamma[0] = np.log(np.mean(squares))
    for _ in range(MAX_ROUNDS):
        ratio = squares * np.exp(-(columns @ gamma))
        slope = columns.T @ (1.0 - ratio)
        curvature = columns.T @ (columns * ratio[:, np.newaxis])
        step = np.asarray(np.linalg.lstsq(curvature, -slope, rcond=None)[0], dtype=np.float64)
        decrease = float(-slope @ step) / squares.size
        if decrease < TOLERANCE:
            return gamma
        gamma = gamma + _halved(columns, squares, gamma, step, decrease) * step
    raise ConvergenceError(f"the likelihood of the scatter still gains {decrease:.3g}: use fewer noise harmonics")


def _halved(columns: Array, squares: Array, gamma: Array, step: Array, decrease: float) -> float:
    """The share 1, ½, ¼, ... of the step whose gain is a fair part of what its slope promises (Armijo's rule)."""
    start, share = _loss(columns @ gamma, squares), 1.0
    while not start - (loss := _loss(columns @ (gamma + share * step), squares)) >= 1e-4 * share * decrease:
        if share < 1e-6 and np.isfinite(loss):
            break
        if share < 1e-12:
            raise ConvergenceError("the scatter vanishes along a part of the circle: use fewer noise harmonics")
        share *= 0.5
    return share


def _loss(level: Array, squares: Array) -> float:
    """Mean of g + r²e^{-g}, twice minus the log-likelihood a value; inf where it overflows."""
    return float(np.mean(level + squares * np.exp(-level))) if np.min(level) > -600.0 else np.inf


def fit_mean_and_noise(design: Array, value: Array, columns: Array) -> tuple[Array, Array, Array]:
    """Mean and log-variance together by iteratively reweighted least squares: (coefficients, (XᵀWX)⁻¹, γ).

    Each round fits the mean with weights 1/variance and then the log-variance to its residuals, until the weights no
    longer change: the maximum of the normal likelihood. The variance is then raised by n/(n - p).
    """
    weight, change = np.ones(value.size), np.inf
    for _ in range(MAX_ROUNDS):
        coefficients, _ = weighted_least_squares(design, value, weight)
        gamma = fit_log_variance(columns, (value - design @ coefficients) ** 2)
        renewed = np.exp(-(columns @ gamma))
        change, weight = float(np.max(np.abs(renewed / weight - 1.0))), renewed
        if change < 1e-8:
            break
    else:
        raise ConvergenceError(f"mean and scatter still change by {change:.3g}: use fewer noise harmonics")
    gamma[0] += np.log(value.size / (value.size - design.shape[1]))
    return (*weighted_least_squares(design, value, np.exp(-(columns @ gamma))), gamma)


def choose_noise_harmonics(theta: Array, design: Array, value: Array, fold: NDArray[np.int64]) -> int:
    """The order of the log-variance that gives values left out the largest likelihood, by the one-standard-error rule.

    The residuals are those of prediction: each from the law fitted without its own fold. 0 is constant scatter.
    """
    squares = nested_errors(design, value, np.array([design.shape[1]]), fold)[:, 0]
    if not np.isfinite(squares).all():
        raise InvalidInput(
            "the law cannot be fitted with a fold left out; give more pairs, or noise_harmonics yourself"
        )
    orders = np.arange(MAX_NOISE_HARMONICS + 1)
    losses = np.empty((value.size, orders.size))
    for order in orders.tolist():
        losses[:, order] = _held_out_losses(fourier_columns(theta, order), squares, fold)
    return simplest_good(losses, 2 * orders + 1, fold)[0]


def _noise_order(given: int | None, theta: Array, design: Array, value: Array, fit: LinearFit, seed: int) -> int:
    exact = fit.sigma <= ROUNDING * float(np.max(np.abs(value)))
    if given is None:
        return 0 if exact else choose_noise_harmonics(theta, design, value, cycle_folds(value.size, seed))
    order = whole_number("noise_harmonics", given, least=0)
    if order and exact:
        raise InvalidInput(f"noise_harmonics is {order} but the values lie exactly on a smooth curve; use 0")
    return order


def _held_out_losses(columns: Array, squares: Array, fold: NDArray[np.int64]) -> Array:
    """Minus the log-likelihood (n,) of each residual, up to a constant, under the scatter fitted without its fold."""
    losses = np.empty(squares.size)
    for one in range(int(fold.max()) + 1):
        out = fold == one
        level = columns[out] @ fit_log_variance(columns[~out], squares[~out])
        # A law that leaves no scatter at all where something was left out is lost by any measure.
        losses[out] = 0.5 * (level + squares[out] * np.exp(np.minimum(-level, _LARGEST_EXPONENT)))
    return losses
