"""Least squares with what a law needs of it: weights, outliers, correlated residuals, the covariance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array
from cyclemap.errors import ConvergenceError, InvalidInput

# Huber's constant: 95 % of the efficiency of least squares where the residuals are normal.
HUBER = 1.345
# Median absolute deviation of a normal law, in standard deviations.
NORMAL_MAD = 0.6744897501960817
MAX_ROUNDS = 200


@dataclass(frozen=True, eq=False)
class LinearFit:
    """Coefficients (p,), their covariance (p, p), the residuals (n,) and the scatter of one value."""

    coefficients: Array
    covariance: Array
    residuals: Array
    sigma: float


def fit_linear(design: Array, value: Array, *, robust: bool = False, correlated: bool = False) -> LinearFit:
    """Fit value ≈ design @ coefficients, design (n, p) with rows in order of recording.

    Ordinary least squares, with the covariance sigma²(XᵀX)⁻¹, unless one of these is asked for:
    robust : Huber's weights (Huber 1964), the scatter from the median absolute residual, the covariance Huber's (1981,
        ch. 7).
    correlated : the covariance of Newey and West (1987), which holds for residuals correlated with their neighbours in
        the order of the rows; over 1.3√n lags (Lazarus et al. 2018). In short records it is a little small.

    Raises InvalidInput where the values do not fix the coefficients.

    >>> fit_linear(np.ones((4, 1)), np.array([1.0, 2.0, 3.0, 4.0])).coefficients.round(12).tolist()
    [2.5]
    """
    weight = huber_weights(design, value) if robust else np.ones(value.size)
    coefficients, inverse = weighted_least_squares(design, value, weight)
    residuals = value - design @ coefficients
    free = value.size - coefficients.size
    sigma = _robust_scale(residuals, free) if robust else float(np.sqrt(residuals @ residuals / free))
    if robust:
        inverse = np.asarray(np.linalg.inv(design.T @ design), dtype=np.float64)
    pull = weight * residuals
    linear = np.mean(np.abs(residuals) <= HUBER * sigma) if robust and sigma > 0.0 else 1.0
    if correlated:
        covariance = inverse @ _long_run(design * pull[:, np.newaxis]) @ inverse * (value.size / free) / linear**2
    else:
        covariance = inverse * (pull @ pull / free) / linear**2
    return LinearFit(coefficients, covariance, residuals, sigma)


def weighted_least_squares(design: Array, value: Array, weight: Array) -> tuple[Array, Array]:
    """The coefficients (p,) that make Σ weight · residual² least, and (XᵀWX)⁻¹ (p, p)."""
    unknowns = design.shape[1]
    if value.size <= unknowns:
        raise InvalidInput(f"{value.size} pairs cannot fix {unknowns} coefficients; use fewer harmonics")
    root = np.sqrt(weight)
    q, r = np.linalg.qr(design * root[:, np.newaxis])
    rank = int(np.linalg.matrix_rank(r, rtol=1e-11))
    if rank < unknowns:
        raise InvalidInput(f"the measured directions fix {rank} of {unknowns} coefficients; use fewer harmonics")
    inverse_root = np.linalg.inv(r)
    return inverse_root @ (q.T @ (root * value)), inverse_root @ inverse_root.T


def huber_weights(design: Array, value: Array) -> Array:
    """The weights (n,) in (0, 1] of Huber's estimate: 1 within 1.345 standard deviations, falling as 1/|residual|.

    >>> weights = huber_weights(np.ones((6, 1)), np.array([-1.0, -0.5, 0.0, 0.5, 1.0, 30.0]))
    >>> weights[:5].tolist(), bool(weights[5] < 0.1)
    ([1.0, 1.0, 1.0, 1.0, 1.0], True)
    """
    weight, free, scale = np.ones(value.size), value.size - design.shape[1], float(np.max(np.abs(value), initial=0.0))
    for _ in range(MAX_ROUNDS):
        coefficients, _ = weighted_least_squares(design, value, weight)
        residuals = value - design @ coefficients
        limit = HUBER * _robust_scale(residuals, free)
        # Residuals of rounding size have no scale to speak of: nothing is an outlier then.
        renewed = np.minimum(1.0, limit / np.maximum(np.abs(residuals), 1e-300)) if limit > 1e-13 * scale else weight
        change = float(np.max(np.abs(renewed - weight)))
        weight = renewed
        if change < 1e-6:
            return weight
    raise ConvergenceError(
        f"the robust weights still change by {change:.3g} after {MAX_ROUNDS} rounds: use robust=False"
    )


def lag_correlation(residuals: Array) -> float:
    """The correlation of each residual with the next, in order of recording; 0 for residuals that are all 0.

    >>> lag_correlation(np.array([1.0, 1.0, -1.0, -1.0]))
    0.25
    """
    power = float(residuals @ residuals)
    return float(residuals[1:] @ residuals[:-1]) / power if power > 0.0 else 0.0


def _robust_scale(residuals: Array, free: int) -> float:
    return float(np.median(np.abs(residuals)) / NORMAL_MAD * np.sqrt(residuals.size / free))


def _long_run(moments: Array) -> Array:
    """Σ of the moments' covariances over lags with Bartlett's weights: never negative (Newey & West 1987)."""
    count = moments.shape[0]
    lags = min(count - 1, int(np.ceil(1.3 * np.sqrt(count))))
    total = moments.T @ moments
    for lag in range(1, lags + 1):
        shared = moments[lag:].T @ moments[:-lag]
        total += (1.0 - lag / (lags + 1.0)) * (shared + shared.T)
    return np.asarray(total)
