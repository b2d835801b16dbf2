"""How many harmonics: cross-validation over blocks of successive cycles, and the one-standard-error rule."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.checks import read_only, whole_number
from cyclemap.errors import InvalidInput

FOLDS = 10
BLOCKS_A_FOLD = 5
SMALLEST_BLOCK = 8


@dataclass(frozen=True, eq=False)
class OrderScores:
    """How well laws of several orders predict values left out.

    orders : (k,) harmonics. rmse : (k,) root of the mean squared error of prediction, in the unit of the values.
    excess_error : (k,) standard error of the difference of mean squared errors from the best order's, over the folds.
    chosen : the simplest order whose mean squared error exceeds the least by no more than that standard error.
    """

    orders: NDArray[np.int64]
    rmse: Array
    excess_error: Array
    chosen: int


def cycle_folds(count: int, seed: int, folds: int = FOLDS) -> NDArray[np.int64]:
    """The fold (0 ... folds - 1) of each of ``count`` values in order of recording: shape (count,).

    Neighbours in time stand at nearly the same angle and share their errors, so they are left out together (Roberts
    et al. 2017): the record is cut into blocks of successive values, five a fold where it is long enough, and the
    blocks dealt to the folds at random, from ``seed``.

    Raises InvalidInput for fewer than two values a fold.

    >>> np.bincount(cycle_folds(100, seed=0)).tolist()
    [10, 10, 10, 10, 10, 10, 10, 10, 10, 10]
    """
    if count < 2 * folds:
        raise InvalidInput(f"{count} pairs are too few to choose an order by {folds} folds; give the order yourself")
    whole_number("seed", seed, least=0)
    blocks = folds * max(1, min(BLOCKS_A_FOLD, count // (SMALLEST_BLOCK * folds)))
    dealt = np.random.default_rng(seed).permutation(np.arange(blocks) % folds)
    return np.asarray(dealt[np.arange(count) * blocks // count], dtype=np.int64)


def nested_errors(design: Array, value: Array, sizes: NDArray[np.int64], fold: NDArray[np.int64]) -> Array:
    """Squared errors of prediction (n, k) when the first sizes[j] columns are fitted without the value's own fold.

    One QR factorisation a fold serves all sizes. inf where the rest of the values does not fix the coefficients.
    """
    errors = np.full((value.size, sizes.size), np.inf)
    for one in range(int(fold.max()) + 1):
        out = fold == one
        q, r = np.linalg.qr(design[~out])
        projected = q.T @ value[~out]
        for j, size in enumerate(sizes.tolist()):
            if size < q.shape[0] and np.linalg.matrix_rank(r[:size, :size], rtol=1e-9) == size:
                coefficients = np.linalg.solve(r[:size, :size], projected[:size])
                errors[out, j] = (value[out] - design[out, :size] @ coefficients) ** 2
    return errors


def simplest_good(errors: Array, sizes: NDArray[np.int64], fold: NDArray[np.int64]) -> tuple[int, Array, Array]:
    """The one-standard-error rule (Breiman et al. 1984) with paired differences: (index, mean, error (k,)).

    errors : (n, k) of each value under each candidate; sizes : (k,) coefficients of each. The candidate with
    fewest coefficients is taken whose mean error exceeds the least by no more than the standard error, over the folds,
    of that very difference: folds that are hard for all candidates alike do not blur the comparison.
    """
    folds = int(fold.max()) + 1
    mean = np.mean(errors, axis=0)
    if not np.isfinite(mean).any():
        raise InvalidInput("no order can be fitted with a fold left out; give more pairs, or the order yourself")
    best = int(np.argmin(mean))
    finite = np.where(np.isfinite(errors), errors, 0.0)
    excess = np.array([np.mean((finite - finite[:, [best]])[fold == one], axis=0) for one in range(folds)])
    spread = np.std(excess, axis=0, ddof=1) / np.sqrt(folds)
    # Errors of rounding size differ by chance: there the floor decides for the simpler.
    floor = 1e-26 * np.max(np.abs(mean[np.isfinite(mean)]))
    good = np.flatnonzero(mean - mean[best] <= spread + floor)
    good = good[np.isfinite(mean[good])]
    return int(good[np.argmin(sizes[good])]), mean, np.where(np.isfinite(mean), spread, np.inf)


def choose_harmonics(design: Array, value: Array, fold: NDArray[np.int64]) -> OrderScores:
    """Score the orders 0, 1, ... that ``design`` (columns of ``fourier_columns``) holds, and choose."""
    sizes = np.arange(1, design.shape[1] + 1, 2)
    errors = nested_errors(design, value, sizes, fold)
    chosen, mean, spread = simplest_good(errors, sizes, fold)
    orders = np.arange(sizes.size)
    return OrderScores(orders, read_only(np.sqrt(mean)), read_only(spread), chosen)
