"""The law of the orientations of a run of so many noisy cycles: their histogram, averaged over runs."""

from __future__ import annotations

from typing import Any

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, positive_number, whole_number
from cyclemap.errors import InvalidInput

# A run that starts in a named direction starts within this standard deviation of it (rad): it is read off a histogram.
START_SPREAD = float(np.deg2rad(10.0))
# Standard deviations of noise beyond which it counts as zero.
_REACH = 7.0
# Every so many cycles it is seen whether the law has settled: whether no share changes any more by the second number.
_CHECKED, _STILL = 50, 1e-14


def run_law(turn: Array, sigma: float, cycles: int, start: float | None = None) -> Array:
    """Return the mean share (n,) of a run's cycles that begin at each angle 2 pi k / n.

    turn (n,) : rad, of a noiseless cycle from each of the angles. sigma : rad, standard deviation of a cycle's noise
    (normal), at least 1.2 spacings of the angles. cycles : in the run. start : rad; None where it is not known, and
    taken as equally likely anywhere.

    The law of the k-th cycle is L^k applied to that of the first, L the transfer operator of the noisy map; the mean
    over k < cycles is returned. Where the map mixes within far fewer cycles it is the stationary law. Where noise
    hardly ever frees an orbit from a stable direction, the stationary law hangs on how often that happens in millions
    of cycles; this one only on what happens in a run. Accurate to the trapezoidal rule: to 1e-4 or better where the
    noise, seen through the map's slope, spans a spacing.

    >>> run_law(np.full(8, 0.3), 1.0, 50).round(12).tolist()
    [0.125, 0.125, 0.125, 0.125, 0.125, 0.125, 0.125, 0.125]
    """
    turns = finite_array("turn", turn, ndim=1)
    step, matrix = _first_law(turns.size, start), _noisy_map(turns, positive_number("sigma", sigma))
    total = np.zeros(turns.size)
    for done in range(1, whole_number("cycles", cycles, least=1) + 1):
        total += step
        ahead = matrix @ step
        if done % _CHECKED == 0 and np.max(np.abs(ahead - step)) < _STILL:
            total += (cycles - done) * ahead
            break
        step = ahead
    return np.asarray(total / total.sum())


def _noisy_map(turn: Array, sigma: float) -> Any:
    """The transfer operator (n, n), sparse: column k is the law of what comes after angle k."""
    from scipy.sparse import csr_array

    count, spacing = turn.size, 2.0 * np.pi / turn.size
    if sigma < 1.2 * spacing:
        raise InvalidInput(f"noise of {sigma:.3g} rad is finer than 1.2 spacings of {count} angles: take more angles")
    half = min(int(np.ceil(_REACH * sigma / spacing)) + 1, count // 2)
    place = np.arange(count) + turn / spacing
    nearest = np.rint(place).astype(np.int64)
    offsets = np.arange(-half, half + count % 2 if half == count // 2 else half + 1)
    weight = np.exp(-0.5 * ((nearest - place)[:, np.newaxis] + offsets) ** 2 * (spacing / sigma) ** 2)
    weight /= weight.sum(axis=1, keepdims=True)
    rows = (nearest[:, np.newaxis] + offsets) % count
    columns = np.broadcast_to(np.arange(count)[:, np.newaxis], rows.shape)
    return csr_array((weight.ravel(), (rows.ravel(), columns.ravel())), shape=(count, count))


def _first_law(count: int, start: float | None) -> Array:
    if start is None:
        return np.full(count, 1.0 / count)
    off = 2.0 * np.pi * np.arange(count) / count - start
    off = (off + np.pi) % (2.0 * np.pi) - np.pi
    law = np.exp(-0.5 * (off / START_SPREAD) ** 2)
    return np.asarray(law / law.sum())
