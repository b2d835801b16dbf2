"""The distribution of the orientations that a strategy leaves: in the long run, and after n pushes
from any start.

An orientation's probability density p(theta)/2 pi is kept as its Fourier coefficients p_m = E
exp(-i m theta), m = 1 to M. A cycle theta -> theta + t(theta) + noise takes them to p'_m = kappa_m
sum_k T_mk p_k with T_mk the k-th coefficient of exp(-i m (theta + t)) and kappa_m that of the
noise: an affine map of (Re p, Im p), for p_0 = 1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, even_angles
from cyclemap.checks import positive_number, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.protocol.strategy import (
    IN_TURN,
    RANDOM,
    SHUFFLED,
    ResetStrategy,
    require_strategy,
)
from cyclemap.resets.action_cycles import checked_turns

# Orientations at which densities are compared with uniform, and starts of which the worst is taken.
DENSITY_SAMPLES = 360
STARTS = 72
# The same for the distances that are told.
_FINE_SAMPLES = 3 * DENSITY_SAMPLES
_MODES = (24, 48, 96, 192)
_SAME = 5e-4
# A block of a shuffled order may pass through so many different sets of actions.
_MOST_SETS = 2_000


def affine_kernels(turn: Array, modes: int, sigma: float) -> Array:
    """Return the affine maps (..., 2M + 1, 2M + 1) of cycles that turn by `turn` (..., n) rad at n
    equal steps.

    modes : M, below n/2.
    sigma : standard deviation of the noise added to a cycle, rad. They act on (Re p, Im p, 1), so
        that one after another is their product.

    >>> rigid = affine_kernels(np.full(8, 0.5), 1, 0.0)   # a rotation by half a radian
    >>> (rigid.round(4) + 0.0).tolist()
    [[0.8776, 0.4794, 0.0], [-0.4794, 0.8776, 0.0], [0.0, 0.0, 1.0]]
    """
    count = turn.shape[-1]
    orders = np.arange(1, modes + 1)
    end = even_angles(count) + turn
    waves = (
        np.exp(-1j * orders[:, None] * end[..., None, :])
        * np.exp(-0.5 * (orders * sigma) ** 2)[:, None]
    )
    rows = np.fft.ifft(waves, axis=-1)  # ... the k-th entry multiplies p_k
    up = rows[..., 1 : modes + 1]
    down = rows[..., : -modes - 1 : -1]
    total = up + down
    difference = up - down
    upper = np.concatenate([total.real, -difference.imag, rows[..., :1].real], axis=-1)
    lower = np.concatenate([total.imag, difference.real, rows[..., :1].imag], axis=-1)
    last = np.zeros_like(upper[..., :1, :])
    last[..., -1] = 1.0
    return np.concatenate([upper, lower, last], axis=-2)


def long_run(kernel: Array) -> Array:
    """Return the fixed point (..., 2M) of an affine map that forgets its start."""
    step = np.eye(kernel.shape[-1] - 1) - kernel[..., :-1, :-1]
    return np.asarray(np.linalg.solve(step, kernel[..., :-1, -1:])[..., 0])


def total_variation(coefficients: Array, samples: int) -> Array:
    """Return the total variation (...) from uniform of densities with Fourier coefficients (...,
    2M).
    """
    return np.asarray(
        0.5 * np.abs(coefficients @ _waves(coefficients.shape[-1] // 2, samples)).mean(axis=-1)
    )


def farthest(kernel: Array, starts: int, samples: int) -> Array:
    """Return the largest total variation (...) from uniform that an affine map leaves of any known
    start.
    """
    worst = total_variation(_ends(kernel, starts), samples).max(axis=-1)
    return np.asarray(np.minimum(worst, 1.0))


def _ends(kernel: Array, starts: int) -> Array:
    """The coefficients (..., starts, 2M) that an affine map leaves of known starts."""
    known = 0.5 * _waves(kernel.shape[-1] // 2, starts)
    return np.swapaxes(kernel[..., :-1, :-1] @ known + kernel[..., :-1, -1:], -1, -2)


@lru_cache(maxsize=16)
def _waves(modes: int, samples: int) -> Array:
    """The matrix (2M, samples) from coefficients to 2 pi times the density, less one, at equal
    steps.
    """
    angle = np.arange(1, modes + 1)[:, None] * even_angles(samples)
    return 2.0 * np.concatenate([np.cos(angle), -np.sin(angle)])


@dataclass(frozen=True, eq=False)
class OrientationLaw:
    """How the orientations of a strategy are distributed.

    Attributes
    ----------
    total_variation : float
        Distance from uniform in the long run, over all places of a period or block, in [0, 1].
    after : float
        The largest distance left of any start after `pushes` pushes.
    pushes : int
        After how many.
    modes : int
        How many of Fourier.
    error : float
        How far both may be off for their number, from half as many, and for the places at which
        densities are looked at, from a third as many: an estimate; nan where that was not looked
        at.
    density : ndarray, shape (360,)
        Per rad, at whole degrees.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.resets import CycleAction, ResetStrategy, orientation_law
    >>> still = orientation_law(np.zeros((1, 256)), ResetStrategy((CycleAction(),)), 0.5, pushes=10)
    >>> round(still.after, 2), still.density.shape
    (0.18, (360,))
    """

    total_variation: float
    after: float
    pushes: int
    modes: int
    error: float
    density: Array

    @property
    def peaks(self) -> Array:
        """Directions (rad) at which the density is highest thereabouts, and above the uniform
        one.
        """
        before = np.roll(self.density, 1)
        after = np.roll(self.density, -1)
        highest = (self.density > before) & (self.density >= after)
        return np.radians(np.flatnonzero(highest & (self.density > 1.0 / TWO_PI)))


def orientation_law(
    turn: ArrayLike,
    strategy: ResetStrategy,
    sigma: float,
    pushes: int = 50,
    modes: int | None = None,
) -> OrientationLaw:
    """Return the law of the orientations of a strategy, from the turns of its actions.

    Parameters
    ----------
    turn : array_like, shape (actions, n)
        Turns at n equal steps of theta, rad.
    strategy : ResetStrategy
        The actions' shares and order.
    sigma : float
        Noise of a cycle, rad, above zero.
    pushes : int, default 50
        After how many pushes it is asked what is left of the worst start.
    modes : int or None, optional
        Of Fourier, below n/2; None: doubled until both distances change by less than 5e-4, up
        to 192 or a quarter of n; what is left is the law's `error`.

    Returns
    -------
    OrientationLaw
        Distances from uniform, and the density in the long run.

    Raises
    ------
    InvalidInput
        For what is no turn, strategy or number of modes, fewer than 49 turns an action, and a
        shuffled order with too many different sets of actions on the way through a block.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.resets import CycleAction, ResetStrategy, orientation_law
    >>> even = orientation_law(np.full((1, 256), 2.4), ResetStrategy((CycleAction(),)), 0.5)
    >>> round(even.total_variation, 9), even.after < 0.01
    (0.0, True)
    """
    positive_number("sigma", sigma)
    count = whole_number("pushes", pushes, least=1)
    turn = checked_turns(turn, len(require_strategy(strategy).actions))
    least = _MODES[0] if modes is None else whole_number("modes", modes, least=1)
    if turn.shape[-1] <= 2 * least:
        raise InvalidInput(
            f"turn has {turn.shape[-1]} steps, too few for {least} modes: give {2 * least + 1} or "
            "more"
        )
    sizes = (
        [size for size in _MODES if size <= max(turn.shape[-1] // 4, _MODES[0])]
        if modes is None
        else [modes]
    )
    distances = np.full(2, math.nan)
    error = math.nan
    for size in sizes:
        steps = _steps(affine_kernels(turn, size, sigma), strategy)
        start = long_run(steps[-1])
        law = np.mean([step[:-1, :-1] @ start + step[:-1, -1] for step in steps], axis=0)
        whole, rest = divmod(count, len(steps))
        end = np.linalg.matrix_power(steps[-1], whole)
        ended = steps[rest - 1] @ end if rest else end
        ends = _ends(ended, STARTS)
        before = distances
        # Not cut at 1, which two sums of too few waves may both exceed.
        rough, distances = (
            np.array([total_variation(law, samples), total_variation(ends, samples).max()])
            for samples in (DENSITY_SAMPLES, _FINE_SAMPLES)
        )
        error = float(np.max(np.abs(distances - before) + np.abs(distances - rough)))
        if error <= _SAME:
            break
    density = (1.0 + law @ _waves(size, DENSITY_SAMPLES)) / TWO_PI
    overall, after = np.minimum(distances, 1.0).tolist()
    return OrientationLaw(overall, after, count, size, error, density)


def slowest_factor(turn: Array, strategy: ResetStrategy, sigma: float) -> float:
    """Return |lambda|, by which the slowest departure from the long run falls a push, with 96
    Fourier modes.

    >>> from cyclemap.protocol.strategy import CycleAction
    >>> round(slowest_factor(np.full((1, 256), 2.4), ResetStrategy((CycleAction(),)), 0.5), 4)
    0.8825
    """
    steps = _steps(affine_kernels(turn, min(96, turn.shape[-1] // 4), sigma), strategy)
    return float(np.abs(np.linalg.eigvals(steps[-1][:-1, :-1])).max() ** (1.0 / len(steps)))


def _steps(kernels: Array, strategy: ResetStrategy) -> list[Array]:
    """The affine maps from the start of a period to after each of its pushes, averaged over what is
    drawn.
    """
    if strategy.order == RANDOM:
        return [np.tensordot(strategy.shares, kernels, axes=1)]
    if strategy.order == IN_TURN:
        done = [kernels[0]]
        for kernel in kernels[1:]:
            done.append(kernel @ done[-1])
        return done
    assert strategy.order == SHUFFLED
    return _shuffled(kernels, strategy.counts)


def _shuffled(kernels: Array, counts: Sequence[int]) -> list[Array]:
    """Averages over all orders of a block: after j pushes a set of actions is done, each order of
    it alike.
    """
    sets = math.prod(count + 1 for count in counts)
    if sets > _MOST_SETS:
        raise InvalidInput(
            f"a block of {sum(counts)} pushes passes through {sets} sets of actions: use smaller "
            "blocks"
        )
    done = {(0,) * len(counts): (1.0, np.eye(kernels.shape[-1]))}
    steps = []
    for left in range(sum(counts), 0, -1):
        following: dict[tuple[int, ...], tuple[float, Array]] = {}
        for so_far, (chance, kernel) in done.items():
            for index, most in enumerate(counts):
                if so_far[index] == most:
                    continue
                key = (*so_far[:index], so_far[index] + 1, *so_far[index + 1 :])
                share = chance * (most - so_far[index]) / left
                before, summed = following.get(key, (0.0, np.zeros_like(kernel)))
                following[key] = (before + share, summed + share * (kernels[index] @ kernel))
        done = {key: (chance, summed / chance) for key, (chance, summed) in following.items()}
        steps.append(np.sum([chance * kernel for chance, kernel in done.values()], axis=0))
    return steps
