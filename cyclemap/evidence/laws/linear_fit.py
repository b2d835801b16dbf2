"""Least squares with what a law needs of it: Fourier columns, outliers, correlated residuals, the
order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import convolve1d

from cyclemap.arrays import Array, Whole
from cyclemap.checks import finite_number, whole_number
from cyclemap.errors import InvalidInput

FOLDS = 10
BLOCKS_A_FOLD = 5
SMALLEST_BLOCK = 8


def fourier_columns(theta: ArrayLike, harmonics: int) -> Array:
    """The columns 1, cos θ, sin θ, cos 2θ, sin 2θ, ...: shape (..., 2·harmonics + 1) for θ (...) in
    radians.

    The first 2k + 1 columns are those of k harmonics, so laws of different orders are nested.

    >>> fourier_columns(0.0, 2).tolist()
    [1.0, 1.0, 0.0, 1.0, 0.0]
    """
    angles = np.asarray(theta, dtype=np.float64)
    multiples = np.multiply.outer(angles, np.arange(1, harmonics + 1))
    columns = np.ones((*angles.shape, 2 * harmonics + 1))
    columns[..., 1::2] = np.cos(multiples)
    columns[..., 2::2] = np.sin(multiples)
    return columns


@dataclass(frozen=True, eq=False)
class LinearFit:
    """Coefficients (p,), their covariance (p, p), the residuals (n,) and the scatter of one
    value."""

    coefficients: Array
    covariance: Array
    residuals: Array
    sigma: float


def fit_linear(design: Array, value: Array, *, correlated: bool = False) -> LinearFit:
    """Fit value ≈ design @ coefficients in least squares, design (n, p) with rows in order of
    recording.

    The covariance is sigma²(XᵀX)⁻¹, or, if ``correlated``, that of Newey and West (1987), which
    holds for residuals correlated with their neighbours; over 1.3√n lags (Lazarus et al. 2018). In
    short records it is a little small.

    Raises InvalidInput where the values do not fix the coefficients.
    """
    fit = weighted_fit(design, value, np.ones(value.size))
    inverse = fit.covariance
    covariance = inverse * fit.sigma**2
    if correlated:
        # The covariances of the moments over lags, with Bartlett's weights: never negative.
        moments = design * fit.residuals[:, np.newaxis]
        count, unknowns = design.shape
        lags = window_lags(count)
        window = 1.0 - np.abs(np.arange(-lags, lags + 1)) / (lags + 1.0)
        total = moments.T @ convolve1d(moments, window, axis=0, mode="constant")
        covariance = inverse @ total @ inverse * (count / (count - unknowns))
    return replace(fit, covariance=covariance)


def window_lags(count: int) -> int:
    """Over how many lags so many values are taken to be correlated (Lazarus et al. 2018)."""
    return min(count - 1, math.ceil(1.3 * math.sqrt(count)))


def weighted_fit(design: Array, value: Array, weight: Array) -> LinearFit:
    """The fit that makes Σ weight · residual² least, its covariance (XᵀWX)⁻¹: that of values whose
    variances are 1/weight.
    """
    unknowns = design.shape[1]
    if value.size <= unknowns:
        raise InvalidInput(
            f"{value.size} pairs cannot fix {unknowns} coefficients; use fewer harmonics"
        )
    root = np.sqrt(weight)
    q, r = np.linalg.qr(design * root[:, np.newaxis])
    rank = int(np.linalg.matrix_rank(r, rtol=1e-11))
    if rank < unknowns:
        raise InvalidInput(
            f"the measured directions fix {rank} of {unknowns} coefficients; use fewer harmonics"
        )
    inverse_root = np.linalg.inv(r)
    coefficients = inverse_root @ (q.T @ (root * value))
    residuals = value - design @ coefficients
    sigma = float(np.sqrt(residuals @ residuals / (value.size - unknowns)))
    return LinearFit(coefficients, inverse_root @ inverse_root.T, residuals, sigma)


def student_quantile(level: float, freedom: float) -> float:
    """Return t such that a Student variable lies within -t and t with probability `level`."""
    from scipy.special import stdtrit

    probability = finite_number("level", level)
    if not 0.0 < probability < 1.0:
        raise InvalidInput(
            f"level is {level!r}; it must be a probability between 0 and 1, such as 0.95"
        )
    return float(stdtrit(freedom, 0.5 + 0.5 * probability))


def cycle_folds(theta: Array, seed: int) -> Whole:
    """The fold (0 to 9) of each of the angles (n,), rad, in order of recording; -1 of those that no
    fold leaves out.

    Neighbours in time stand at nearly the same angle and share their errors, so they are left out
    together (Roberts et al. 2017): the record is cut into blocks of successive values, five a fold
    where it is long enough, and the blocks dealt to the folds at random, from ``seed``.

    An angle that is far from all others, as where a loop that rests came from, can be predicted by
    no law without its own block: where even one harmonic, fitted to the rest, would be less certain
    there than one value is (its leverage is above 1), the value is never left out, as long as half
    of the folds keep some.

    Raises InvalidInput for fewer than two values a fold.
    """
    count = theta.size
    if count < 2 * FOLDS:
        raise InvalidInput(
            f"{count} pairs are too few to choose an order by {FOLDS} folds; give the order "
            "yourself"
        )
    whole_number("seed", seed, least=0)
    blocks = FOLDS * max(1, min(BLOCKS_A_FOLD, count // (SMALLEST_BLOCK * FOLDS)))
    dealt = np.random.default_rng(seed).permutation(np.arange(blocks) % FOLDS)
    fold = dealt[np.arange(count) * blocks // count]
    columns = fourier_columns(theta, 1)
    leverage = np.zeros(count)
    for index in range(FOLDS):
        out = fold == index
        _, r = np.linalg.qr(columns[~out])
        if np.linalg.matrix_rank(r, rtol=1e-9) == r.shape[0]:
            leverage[out] = np.sum(np.linalg.solve(r.T, columns[out].T) ** 2, axis=0)
    reached = leverage <= 1.0
    enough = np.unique(fold[reached]).size >= FOLDS // 2
    return np.where(reached, fold, -1) if enough else fold


def nested_errors(
    design: Array,
    value: Array,
    sizes: Whole,
    fold: Whole,
    weight: Array | float = 1.0,
) -> Array:
    """Squared errors of prediction (n, k) when the first sizes[j] columns are fitted without the
    value's own fold.

    Times ``weight`` (n,), by which they are fitted. One QR factorisation a fold serves all sizes.
    inf where the rest of the values does not fix the coefficients, and of values in no fold.
    """
    root = np.sqrt(np.broadcast_to(weight, value.shape))
    design = design * root[:, np.newaxis]
    value = value * root
    errors = np.full((value.size, sizes.size), np.inf)
    for index in range(FOLDS):
        out = fold == index
        q, r = np.linalg.qr(design[~out])
        projected = q.T @ value[~out]
        for j, size in enumerate(sizes.tolist()):
            if size < q.shape[0] and np.linalg.matrix_rank(r[:size, :size], rtol=1e-9) == size:
                coefficients = np.linalg.solve(r[:size, :size], projected[:size])
                errors[out, j] = (value[out] - design[out, :size] @ coefficients) ** 2
    return errors


def simplest_good(errors: Array, sizes: Whole, fold: Whole) -> tuple[int, Array]:
    """The one-standard-error rule (Breiman et al. 1984) with paired differences: (index, mean
    (k,)).

    errors : (n, k) of each value under each candidate, those in no fold passed over; sizes : (k,)
        coefficients of each. The
        candidate with fewest coefficients is taken whose mean error exceeds the least by no more
        than the standard error, over the folds, of that very difference: folds that are hard for
        all candidates alike do not blur the comparison.
    """
    errors = errors[fold >= 0]
    fold = fold[fold >= 0]
    mean = np.mean(errors, axis=0)
    if not np.isfinite(mean).any():
        raise InvalidInput(
            "no order can be fitted with a fold left out; give more pairs, or the order yourself"
        )
    best = int(np.argmin(mean))
    finite = np.where(np.isfinite(errors), errors, 0.0)
    excess = finite - finite[:, [best]]
    by_fold = np.array([np.mean(excess[fold == index], axis=0) for index in np.unique(fold)])
    spread = np.std(by_fold, axis=0, ddof=1) / np.sqrt(len(by_fold))
    # Errors of rounding size differ by chance: there the floor decides for the simpler.
    floor = 1e-26 * np.max(np.abs(mean[np.isfinite(mean)]))
    good = np.flatnonzero(mean - mean[best] <= spread + floor)
    good = good[np.isfinite(mean[good])]
    return int(good[np.argmin(sizes[good])]), mean
