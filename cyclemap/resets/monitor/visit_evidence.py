"""Evidence that visits gather: that θ0 comes where it has been more than a reset without bias would bring it."""

from __future__ import annotations

import copy
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import positive_number, whole_number

Array = NDArray[np.float64]

BLOCK = 48  # pushes that are shuffled together
ORDERS = 199  # other orders of a block that it is compared with
_MEMORY = 20.0  # blocks: older visits are forgotten, for surfaces wear
_PRIOR = 24.0  # pushes that the uniform law counts for
_FLOOR = 0.1  # share of the uniform law that is never given up
_POWERS = np.array([0.25, 1.0])  # how boldly the law learned is believed, in equal shares
_PEAK_KERNEL = math.radians(25.0)


class VisitLaw:
    """The law of the visits so far: a Gaussian kernel estimate as a Fourier series, mixed with the uniform law."""

    def __init__(self, kernel: float) -> None:
        """``kernel`` : rad, the kernel's standard deviation."""
        width = positive_number("kernel", kernel)
        # The first harmonic left out weighs exp(-12.5), under 4e-6.
        self._weights = np.exp(-0.5 * (width * np.arange(1, math.ceil(5.0 / width) + 1)) ** 2)
        self._moments = np.zeros(self._weights.size, dtype=np.complex128)
        self._visits = 0.0

    @property
    def visits(self) -> float:
        """How many visits are remembered, old ones counted less."""
        return self._visits

    def add(self, theta: Array, kept: float = 1.0) -> None:
        """Take visits ``theta`` (n,) rad, after forgetting all but the share ``kept`` of the older ones."""
        order = np.arange(1, self._moments.size + 1)
        self._moments = kept * self._moments + np.exp(-1j * np.multiply.outer(order, theta)).sum(axis=1)
        self._visits = kept * self._visits + theta.size

    def ratio(self, theta: Any) -> Array:
        """The density at ``theta`` (rad, any shape) over that of the uniform law; at least about 0.1."""
        series = _fourier_sum(self._weights * self._moments, theta)
        learned = (_PRIOR + self._visits + 2.0 * series) / (_PRIOR + self._visits)
        return np.asarray(_FLOOR + (1.0 - _FLOOR) * np.maximum(learned, 0.0), dtype=np.float64)

    def peak(self) -> float:
        """Where the density is highest, rad in [0, 2π), under a kernel of 25° at least: narrower ones follow chance."""
        order = np.arange(1, self._moments.size + 1)
        grid = np.arange(720) * (math.pi / 360.0)
        smoothed = np.minimum(self._weights, np.exp(-0.5 * (_PEAK_KERNEL * order) ** 2)) * self._moments
        return float(grid[int(np.argmax(_fourier_sum(smoothed, grid)))])


def _fourier_sum(coefficients: NDArray[np.complex128], theta: Any) -> Array:
    """The real part of Σ c_j exp(ijθ), j from 1, by Horner's rule."""
    point = np.exp(1j * np.asarray(theta, dtype=np.float64))
    series = np.zeros_like(point)
    for coefficient in coefficients[::-1]:
        series = (series + coefficient) * point
    return np.asarray(series.real, dtype=np.float64)


class VisitEvidence:
    """Blocks of pushes, each set against its own turns in other orders.

    Where a reset has no bias, how far one cycle turns the object does not depend on where it stood: the turns of a
    block can be exchanged, and each order of them is as likely as the recorded one. A block's e-value is the likelihood
    of its visits under the law learned from the blocks before it, over the mean of that likelihood over the recorded
    order and ``orders`` random ones. Its mean is 1 for any law of the turns, known or not, narrow or wide, constant or
    worn from block to block. The product over blocks, stakes spread over the block at which the gathering begins (1/s(s
    + 1) on the s-th) and over two powers of the likelihood, is a martingale that starts at 1, and P(it ever exceeds c)
    ≤ 1/c (Ville 1939). Shuffling within blocks as an e-value: compare Grünwald, de Heide & Koolen 2024; e-values: Vovk
    & Wang 2021.
    """

    def __init__(self, kernel: float, block: int = BLOCK, orders: int = ORDERS, seed: int = 0) -> None:
        self._block, self._orders = whole_number("block", block, least=2), whole_number("orders", orders, least=1)
        self._random = np.random.default_rng(whole_number("seed", seed, least=0))
        self.law = VisitLaw(kernel)
        self._waiting: list[float] = []
        self._blocks = 0
        self._log_stakes = np.full(_POWERS.size, -np.inf)

    @property
    def log_evidence(self) -> float:
        """Natural logarithm of the wealth; it changes where a block is full."""
        staked = float(np.logaddexp.reduce(self._log_stakes)) - math.log(_POWERS.size)
        return float(np.logaddexp(staked, -math.log1p(self._blocks)))

    def add(self, theta: float) -> None:
        """Take the next θ0 (rad, any number of turns)."""
        self._waiting.append(theta)
        if len(self._waiting) > self._block:
            path = np.array(self._waiting)
            if self.law.visits > 0.0:
                self._bet(path)
            self.law.add(path[1:], kept=math.exp(-1.0 / _MEMORY))
            # The last visit of a block is where the next one starts.
            self._waiting = self._waiting[-1:]

    def peak(self) -> float:
        """The direction most visited, rad in [0, 2π); the block under way counts too."""
        law = copy.copy(self.law)
        law.add(np.array(self._waiting[1:] if self.law.visits > 0.0 else self._waiting))
        return law.peak()

    def _bet(self, path: Array) -> None:
        self._blocks += 1
        new = -math.log(self._blocks * (self._blocks + 1))
        likelihoods = np.log(self.law.ratio(self._orders_of(path))).sum(axis=1)
        raised = np.multiply.outer(_POWERS, likelihoods)
        log_mean = np.logaddexp.reduce(raised, axis=1) - math.log(raised.shape[1])
        self._log_stakes = np.logaddexp(self._log_stakes, new) + raised[:, 0] - log_mean

    def _orders_of(self, path: Array) -> Array:
        """Shape (orders + 1, block): the visits of a block, the recorded order first."""
        turns = np.tile(np.diff(path), (self._orders + 1, 1))
        turns[1:] = self._random.permuted(turns[1:], axis=1)
        return np.asarray(path[0] + np.cumsum(turns, axis=1), dtype=np.float64)
