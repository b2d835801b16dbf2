"""Bias and mixing of a drawn cycle from its images of even angles, and their derivatives by images and weights."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cyclemap.maps import Noise
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.mixtures.law_distances import density_on_grid, total_variation_on_grid
from cyclemap.maps.mixtures.law_evolution import complex_moments
from cyclemap.maps.operator.fourier_discretisation import waves

_STARTS = 96  # of the angles, at least, that the worst start is sought among: all where there are fewer
_GRID = 2048  # angles on which a density is compared with the uniform one


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """A score, and how it moves with one cycle's matrix and with the laws one cycle after the angles.

    value : the score. matrix : (n, n), its derivative by the matrix. first : (n,), its derivative by the law one cycle
    after the angle number `start`; None where it does not ask for any.
    """

    value: float
    matrix: Array
    first: Array | None = None
    start: int = 0


@dataclass(frozen=True, eq=False)
class DrawnCycle:
    """theta' = F_i(theta) + noise, map i with weight w_i, on `modes` Fourier modes.

    images : (k, points), F_i(2 pi j/points), rad. weights : (k,). With kappa_m the noise's coefficients the moments
    c_m = E exp(i m theta) go, in one cycle, to kappa_m sum_i w_i (1/2pi) int exp(i m F_i) p dtheta, here by the
    trapezoidal rule: the derivative of every score is that of the number given, to rounding.
    """

    images: Array
    weights: Array
    noise: Noise
    modes: int

    @cached_property
    def kappa(self) -> Array:
        """(n,): the noise's coefficient of each of 1, cos m theta, sin m theta, n = 2 modes + 1."""
        return self.noise.coefficients(self.orders)

    @cached_property
    def orders(self) -> Array:
        """(n,): the order of each wave."""
        rising = np.arange(1.0, self.modes + 1.0)
        return np.concatenate([[0.0], rising, rising])

    @cached_property
    def _before(self) -> Array:
        """(n, points): the waves of the angles, times what makes a sum over the angles the integral against a law."""
        points = self.images.shape[1]
        scale = np.where(self.orders == 0.0, 1.0, 2.0) / points
        return np.asarray(waves(TWO_PI * np.arange(points) / points, self.modes) * scale[:, None])

    @cached_property
    def after_angles(self) -> Array:
        """(n, points): coefficients of the laws one cycle after the angles."""
        total = sum(w * waves(row, self.modes) for w, row in zip(self.weights.tolist(), self.images, strict=True))
        return np.asarray(self.kappa[:, None] * total)

    @cached_property
    def matrix(self) -> Array:
        """(n, n): one cycle of the coefficients (1, E cos m theta, E sin m theta); its first row keeps the mass."""
        found = self.after_angles @ self._before.T
        found[0] = np.eye(len(found))[0]
        return found

    @cached_property
    def stationary(self) -> Array:
        """(n,): coefficients of the stationary law, the first 1."""
        inner = np.eye(len(self.matrix) - 1) - self.matrix[1:, 1:]
        return np.concatenate([[1.0], np.linalg.solve(inner, self.matrix[1:, 0])])

    # -- the scores ----------------------------------------------------------------------------------------

    def total_variation(self) -> Sensitivity:
        """Total variation of the stationary law from uniform."""
        value, by_law = variation_from_uniform(self.stationary)
        return self._of_stationary(value, by_law)

    def deviation(self) -> Sensitivity:
        """Half the root mean square deviation of the stationary density from uniform, over its mean.

        sqrt(sum over m of |c_m|^2 / 2), m from 1: at least the total variation, and smooth wherever it is not zero.
        """
        rest = self.stationary[1:]
        value = math.sqrt(0.5 * float(rest @ rest))
        by_law = np.concatenate([[0.0], 0.5 * rest / max(value, 1e-300)])
        return self._of_stationary(value, by_law)

    def second_eigenvalue(self) -> Sensitivity:
        """Modulus of the second eigenvalue; where two are as large, the derivative is that of one of them."""
        inner = self.matrix[1:, 1:]
        values, right = np.linalg.eig(inner)
        chosen = int(np.argmax(np.abs(values)))
        value, x = values[chosen], right[:, chosen]
        # One step of inverse iteration beside an eigenvalue known to rounding gives its left vector.
        shift = value + 1e-10 * (1.0 + abs(value))
        y = np.linalg.solve(inner.T - shift * np.eye(len(inner)), np.conj(x))
        y = np.linalg.solve(inner.T - shift * np.eye(len(inner)), y / np.linalg.norm(y))
        by_matrix = np.zeros_like(self.matrix)
        if abs(value) > 0.0:
            by_matrix[1:, 1:] = np.real(np.conj(value) / abs(value) * np.outer(y, x) / (y @ x))
        return Sensitivity(float(abs(value)), by_matrix)

    def reach(self, cycles: int) -> Sensitivity:
        """The largest total variation from uniform after so many cycles, over even starting angles."""
        step = max(1, self.images.shape[1] // _STARTS)
        laws = np.linalg.matrix_power(self.matrix, cycles - 1) @ self.after_angles[:, ::step]
        found, _ = total_variation_on_grid(density_on_grid(complex_moments(_less_uniform(laws)).T, _GRID))
        start = step * int(np.argmax(found))
        course = [self.after_angles[:, start]]
        for _ in range(cycles - 1):
            course.append(self.matrix @ course[-1])
        value, dual = variation_from_uniform(course[-1])
        by_matrix = np.zeros_like(self.matrix)
        for law in reversed(course[:-1]):
            by_matrix += np.outer(dual, law)
            dual = self.matrix.T @ dual
        return Sensitivity(value, by_matrix, dual, start)

    def _of_stationary(self, value: float, by_law: Array) -> Sensitivity:
        """(I - A) dc = dA c on all but the mass: the bordered solve, transposed."""
        dual = np.zeros(len(self.matrix))
        dual[1:] = np.linalg.solve((np.eye(len(dual) - 1) - self.matrix[1:, 1:]).T, by_law[1:])
        return Sensitivity(value, np.outer(dual, self.stationary))

    # -- derivatives ---------------------------------------------------------------------------------------

    def by_images(self, score: Sensitivity) -> tuple[Array, Array]:
        """Return the derivatives of a score by every image (k, points), per radian, and by the weights (k,).

        The weights are varied freely: their sum is held by whoever varies them.
        """
        carried = (self.kappa[:, None] * score.matrix) @ self._before
        carried[0] = 0.0  # the mass is kept whatever the images
        if score.first is not None:
            carried[:, score.start] += self.kappa * score.first
        by_image, by_weight = np.empty_like(self.images), np.empty(len(self.weights))
        for index, row in enumerate(self.images):
            after = waves(row, self.modes)
            cosines, sines = after[1 : self.modes + 1], after[self.modes + 1 :]
            slopes = np.concatenate([np.zeros_like(after[:1]), -sines, cosines])
            by_image[index] = self.weights[index] * np.einsum("mj,mj->j", self.orders[:, None] * slopes, carried)
            by_weight[index] = np.sum(after * carried)
        return by_image, by_weight


def variation_from_uniform(law: Array) -> tuple[float, Array]:
    """Return the total variation from uniform of a law's coefficients (n,), and its derivative by them (n,).

    On an even grid with the cells cut where the density crosses the mean, as `total_variation_on_grid`.

    >>> value, by_law = variation_from_uniform(np.array([1.0, 0.5, 0.0]))
    >>> round(value, 5), round(float(by_law[1]), 5)
    (0.31831, 0.63662)
    """
    modes = len(law) // 2
    values = density_on_grid(complex_moments(_less_uniform(law)), _GRID)
    by_value = _by_values(values)
    spectrum = np.fft.rfft(by_value)[: modes + 1] / math.pi
    by_law = np.concatenate([spectrum.real, -spectrum.imag[1:]])
    by_law[0] = 0.0
    return float(total_variation_on_grid(values)[0]), by_law


def _less_uniform(law: Array) -> Array:
    left = np.array(law)
    left[0] = 0.0
    return left


def _by_values(values: Array) -> Array:
    """The derivative of `total_variation_on_grid` by the values."""
    near, ahead = np.abs(values), np.abs(np.roll(values, -1))
    opposite = values * np.roll(values, -1) < 0.0
    total = np.where(opposite, near + ahead, 1.0)
    cut = (near**2 + ahead**2) / total
    low = np.where(opposite, (2.0 * near - cut) / total, 1.0)
    high = np.where(opposite, (2.0 * ahead - cut) / total, 1.0)
    return np.asarray(0.5 * math.pi / values.size * np.sign(values) * (low + np.roll(high, 1)))
