"""Pushes drawn with weights on one loop: bias and speed of their law as functions of the weights, with gradients."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cyclemap.checks import finite_array, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.operator.fourier_discretisation import waves

ValueAndGradient = tuple[float, Array]

_GRID = 256  # even angles at which densities are compared, at least four a mode
_STARTS = 32  # even starting angles that are compared


@dataclass(frozen=True, eq=False)
class PushMixture:
    """L = Σ w_i L_i for weights w (P,), of the operators `matrices` (P, n, n) on n = 2·modes + 1 Fourier coefficients.

    The first row of each keeps the mass: (1, 0, ..., 0). Weights need not add up to one for the formulas to hold, so
    that every entry of a gradient is a partial derivative of its own.

    Distances are taken on an even grid of 256 points or more and smoothed, ½ mean √(d² + ε²) for ½ mean |d|: an upper
    bound, by at most ε/2. d is the density over 1/2π, less one.

    >>> from cyclemap.maps import CircleMap, WrappedNormal
    >>> from cyclemap.resets.drawn_pushes.push_library import PushLibrary
    >>> turns = [[CircleMap.rigid(0.1), CircleMap.rigid(0.4)]]
    >>> mixture = PushMixture(PushLibrary.of_maps(turns, WrappedNormal(0.1), [[0.1, 0.1]], modes=8).matrices[0])
    >>> value, gradient = mixture.bias(np.array([0.5, 0.5]))
    >>> value < 1e-15, gradient.shape
    (True, (2,))
    """

    matrices: Array

    def __post_init__(self) -> None:
        given = finite_array("matrices", self.matrices, ndim=3)
        if not given.shape[0] or given.shape[1] != given.shape[2] or given.shape[1] % 2 == 0:
            raise InvalidInput(f"matrices must be (pushes, n, n), n odd, not {given.shape}")
        object.__setattr__(self, "matrices", given)

    @property
    def modes(self) -> int:
        """Fourier modes kept."""
        return int(self.matrices.shape[1] // 2)

    def cut(self, modes: int) -> PushMixture:
        """The same on fewer modes, or this one where it has no more."""
        if self.modes <= modes:
            return self
        kept = np.concatenate([np.arange(modes + 1), self.modes + 1 + np.arange(modes)])
        return PushMixture(self.matrices[:, kept[:, None], kept])

    def matrix(self, weights: Array) -> Array:
        """L, (n, n); its first row keeps the mass whatever the weights add up to."""
        flat = self.matrices.reshape(len(self.matrices), -1)
        found = (weights @ flat).reshape(self.matrices.shape[1:])
        found[0] = _first(len(found))
        return np.asarray(found)

    def stationary(self, weights: Array) -> Array:
        """The stationary law's coefficients (n,), (1, E cos mθ, E sin mθ): (I - L) c = 0 with c_0 = 1."""
        return np.asarray(np.linalg.solve(_bordered(self.matrix(weights)), _first(self.matrices.shape[1])))

    def bias(self, weights: Array, smoothing: float = 0.0) -> ValueAndGradient:
        """Total variation of the stationary law from uniform, smoothed, and its gradient (P,) by the adjoint.

        The derivative of a stationary law: the bordered system, transposed (Golub & Meyer 1986).
        """
        system = _bordered(self.matrix(weights))
        law = np.linalg.solve(system, _first(len(system)))
        value, slope = _smooth_variation(self._on_grid @ law[1:], smoothing)
        adjoint = np.linalg.solve(system.T, np.append(0.0, slope @ self._on_grid))
        adjoint[0] = 0.0
        return float(value), np.asarray((self.matrices @ law) @ adjoint)

    def bias_after(
        self, weights: Array, cycles: int, smoothing: float = 0.0, sharpness: float = np.inf
    ) -> ValueAndGradient:
        """The same of the law after `cycles` pushes from the worst of 32 even starts, and its gradient.

        sharpness : the largest is taken as log Σ exp(sharpness·x)/sharpness, an upper bound by at most
        log(32)/sharpness; inf takes the largest itself, whose gradient is that of one worst start (Danskin 1967).
        The derivative of Lⁿ goes backwards through its repeated squaring.
        """
        powers = _powers(self.matrix(weights), whole_number("cycles", cycles, least=1))
        chosen = [power for j, power in enumerate(powers) if cycles >> j & 1]
        laws = [self._from_starts]
        for power in chosen:
            laws.append(power @ laws[-1])
        values, slopes = _smooth_variation((self._on_grid @ laws[-1][1:]).T, smoothing)
        value, shares = _soft_largest(values, sharpness)
        ahead = np.zeros_like(laws[-1])
        ahead[1:] = ((shares[:, None] * slopes) @ self._on_grid).T
        by_power: list[Array] = []
        for power, before in zip(reversed(chosen), reversed(laws[:-1]), strict=True):
            by_power.append(ahead @ before.T)
            ahead = power.T @ ahead
        by_matrix = _through_squaring(powers, cycles, by_power)
        by_matrix[0] = 0.0
        return value, np.asarray(self.matrices.reshape(len(self.matrices), -1) @ by_matrix.ravel())

    def second_eigenvalue(self, weights: Array) -> float:
        """|λ₂|: the rate at which the start is forgotten, a push."""
        inner = self.matrix(weights)[1:, 1:]
        return float(np.max(np.abs(np.linalg.eigvals(inner))))

    # -- inside --------------------------------------------------------------------------------------------

    @cached_property
    def _on_grid(self) -> Array:
        """(grid, n - 1): from coefficients to the density over 1/2π, less one."""
        count = max(_GRID, 4 * self.modes)
        return np.asarray(2.0 * waves(TWO_PI * np.arange(count) / count, self.modes)[1:].T)

    @cached_property
    def _from_starts(self) -> Array:
        """(n, starts): the coefficients of certainty about each start."""
        return waves(TWO_PI * np.arange(_STARTS) / _STARTS, self.modes)


def _first(size: int) -> Array:
    unit = np.zeros(size)
    unit[0] = 1.0
    return unit


def _bordered(matrix: Array) -> Array:
    """I - L with the first row, which is zero, replaced by that of the mass."""
    system = np.eye(len(matrix)) - matrix
    system[0] = _first(len(matrix))
    return system


def _smooth_variation(deviation: Array, smoothing: float) -> tuple[Array, Array]:
    """½ mean √(d² + ε²) over the last axis, and its gradient; ε = 0: ½ mean |d| and the signs."""
    size = np.sqrt(deviation**2 + smoothing**2)
    slope = np.divide(deviation, size, out=np.zeros_like(deviation), where=size > 0.0)
    return 0.5 * np.mean(size, axis=-1), 0.5 * slope / deviation.shape[-1]


def _soft_largest(values: Array, sharpness: float) -> tuple[float, Array]:
    """The (soft) largest of the values and its derivatives by them, which sum to one."""
    top = int(np.argmax(values))
    if not np.isfinite(sharpness):
        return float(values[top]), np.asarray(np.arange(values.size) == top, dtype=np.float64)
    shares = np.exp(sharpness * (values - values[top]))
    return float(values[top] + np.log(shares.sum()) / sharpness), shares / shares.sum()


def _powers(matrix: Array, cycles: int) -> list[Array]:
    """L, L², L⁴, ... as far as `cycles` needs them."""
    powers = [matrix]
    for _ in range(cycles.bit_length() - 1):
        powers.append(powers[-1] @ powers[-1])
    return powers


def _through_squaring(powers: list[Array], cycles: int, by_power: list[Array]) -> Array:
    """The derivative by L, from those by the powers that were used, the highest first."""
    left, total = list(by_power), np.zeros_like(powers[0])
    for j in reversed(range(len(powers))):
        if j + 1 < len(powers):
            total = total @ powers[j].T + powers[j].T @ total
        if cycles >> j & 1:
            total = total + left.pop(0)
    return total
