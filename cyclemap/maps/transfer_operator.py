"""The transfer operator of a noisy circle map, θ' = F(θ) + ξ, in Fourier modes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg import lapack, lu_factor, lu_solve
from scipy.optimize.elementwise import find_root
from scipy.sparse.linalg import eigs

from cyclemap.checks import finite_array, whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.circle_map import CircleMap
from cyclemap.maps.noise import Noise
from cyclemap.maps.passage import hitting_probability, mean_passage_time
from cyclemap.maps.quadrature import circle_rule

MAX_MODES = 1_500
_NEGLIGIBLE = 1e-17  # noise coefficients beyond the last mode add up to less
_DENSE = 320  # below this many real modes all eigenvalues are computed at once
_BLOCK = 4_096  # quadrature nodes handled at a time


def transfer_operator(circle_map: CircleMap, noise: Noise) -> TransferOperator:
    """The transfer (Perron-Frobenius) operator of θ' = F(θ) + ξ: it carries the law of θ one cycle on.

    With c_m = E e^{-imθ} the law after a cycle is c'_m = κ_m Σ_k c_k ∫ e^{-imF(θ) + ikθ} dθ/2π, κ_m the
    noise's coefficients (a Galerkin method that is exact but for truncation, since noise makes every law
    analytic or smooth; Poltergeist's and Galatolo, Monge & Nisoli's (2020) setting). Number of modes: so
    many that the rest of the κ_m sum to less than 1e-17. The integrals are taken branch by branch, so
    jumps and kinks cost nothing.

    Raises InvalidInput when the noise is missing or so narrow that more than 1500 modes would be needed (for
    ``WrappedNormal`` below about 0.0064 rad), ConvergenceError when the map is too steep for it.

    >>> from cyclemap.maps.noise import WrappedNormal
    >>> turning = transfer_operator(CircleMap.rigid(0.3), WrappedNormal(0.5))
    >>> round(turning.rotation_number, 12), round(float(turning.density(1.0)) * 2 * np.pi, 12)
    (0.3, 1.0)
    """
    if not isinstance(circle_map, CircleMap):
        raise InvalidInput(f"the map is {circle_map!r}: give a CircleMap")
    if not isinstance(noise, Noise):
        raise InvalidInput(f"the noise is {noise!r}: a stationary density needs some, for example WrappedNormal(0.02)")
    modes = 1
    while noise.tail(modes) > _NEGLIGIBLE and modes <= MAX_MODES:
        modes = int(np.ceil(1.05 * modes + 1))
    if modes > MAX_MODES:
        raise InvalidInput(f"{noise!r} needs more than {MAX_MODES} Fourier modes: raise its width")
    return TransferOperator(circle_map, noise, modes)


@dataclass(frozen=True, eq=False)
class TransferOperator:
    """Made by ``transfer_operator``; everything is computed when first asked for, and kept.

    map, noise : what it is the operator of; modes : Fourier modes kept on each side.
    """

    map: CircleMap
    noise: Noise
    modes: int

    # -- the stationary law --------------------------------------------------------------------------------

    def density(self, theta: Any) -> Array:
        """The stationary density per radian at ``theta`` (radians, any shape); see ``error_bound``."""
        angles = finite_array("theta", theta)
        flat = angles.ravel()
        values = np.empty_like(flat)
        for at in range(0, flat.size, _BLOCK):
            waves = self._waves(flat[at : at + _BLOCK])
            values[at : at + _BLOCK] = (0.5 + waves @ self._law) / np.pi
        return values.reshape(angles.shape)

    def moment(self, n: int) -> complex:
        """E e^{inθ} of the stationary law; off by at most 2π·``error_bound``. 0 beyond the modes kept."""
        order = whole_number("n", n)
        if order == 0:
            return 1.0 + 0.0j
        if abs(order) > self.modes:
            return 0.0j
        return complex(self._law[abs(order) - 1], np.sign(order) * self._law[self.modes + abs(order) - 1])

    @cached_property
    def rotation_number(self) -> float:
        """Mean winding in turns a cycle: E[F(θ) - θ]/2π under the stationary law."""
        if self.map.degree != 1:
            raise InvalidInput(f"the map has degree {self.map.degree}: its mean winding is not defined")
        theta, weight = self._rule
        return float(np.dot(weight * self.density(theta), self.map.turn(theta)) / TWO_PI)

    @cached_property
    def error_bound(self) -> float:
        """Bound on the error of the stationary density, per radian, anywhere on the circle.

        ‖(I - L)⁻¹‖₁ times the residual of the computed law. The residual's truncation part is proved (it
        follows from the noise's coefficients beyond the last mode, for any map); its quadrature and
        rounding parts are measured with twice as many nodes, and the norm is LAPACK's condition estimate
        times 3: an estimate, not a proof, in those two places. Errors of the map itself (``max_error``)
        are not included.
        """
        theta, weight = circle_rule(self.map, self.modes, finer=2)
        image = self._moments(theta, weight * self.density(theta))
        residual = float(np.sum(np.abs(image - self._law)))
        truncation = 2.0 * self.noise.tail(self.modes) * (1.0 + 2.0 * float(np.sum(self._kappa)))
        rounding = 4.0 * np.finfo(float).eps * float(np.sqrt(self.modes))
        return 3.0 * self._inverse_norm * (residual + truncation + rounding) / np.pi

    @cached_property
    def is_certain(self) -> bool:
        """Whether the law is known to a tenth of the uniform density, or better.

        It is not where the map has several basins that the noise hardly ever connects: the weights of their parts
        then are beyond double precision, and the law is any mixture of them.
        """
        return bool(self.error_bound <= 0.1 / TWO_PI)

    @cached_property
    def tv_from_uniform(self) -> float:
        """Total variation distance of the law from uniform, ½ ∫ |density - 1/2π| dθ, in [0, 1]."""
        grid, values = self._grid
        excess = values - 0.5 / np.pi
        if np.max(np.abs(excess)) <= 4.0 * self.error_bound:
            return 0.0
        crossing = grid[(excess < 0.0) != (np.roll(excess, -1) < 0.0)]
        bracket = crossing, crossing + grid[1]
        crossing = find_root(lambda x: self.density(x) - 0.5 / np.pi, bracket).x
        mass = np.diff(self._excess_mass(np.append(crossing, crossing[0] + TWO_PI)))
        return float(0.5 * np.sum(np.abs(mass)))

    def peaks(self) -> Array:
        """Angles in [0, 2π) of the local maxima of the stationary density, sorted; none where it is uniform.

        Maxima that rise above their neighbouring minima by less than the error bound are not told apart.
        """
        grid, values = self._grid
        tops = _prominent(values, 4.0 * self.error_bound)
        step, at = grid[1], grid[tops]
        inside = self._slope(at - step) * self._slope(at + step) < 0.0
        if np.any(inside):
            at[inside] = find_root(self._slope, (at[inside] - step, at[inside] + step)).x
        at = np.mod(at, TWO_PI)
        # A tiny negative angle rounds up to a whole turn.
        return np.sort(np.where(at >= TWO_PI, 0.0, at))

    # -- the spectrum --------------------------------------------------------------------------------------

    def eigenvalues(self, k: int) -> npt.NDArray[np.complex128]:
        """The k eigenvalues of largest modulus, in falling order; the first is 1.

        Fewer are returned only when the operator has fewer modes. Small operators are solved whole, large
        ones by Arnoldi iteration (ARPACK), whose residuals are checked; ConvergenceError when they fail.
        """
        count = whole_number("k", k, least=1)
        if 2 * self.modes <= _DENSE or count + 4 >= self.modes:
            found = np.asarray(self._all_eigenvalues)
        else:
            found = self._leading_eigenvalues(max(count, 8))
        ordered = found[np.lexsort((-found.imag, -np.round(np.abs(found), 13)))]
        return np.concatenate([[1.0 + 0.0j], ordered])[:count]

    @cached_property
    def spectral_gap(self) -> float:
        """1 - |λ₂|, λ₂ the eigenvalue of second largest modulus."""
        return max(0.0, 1.0 - float(np.abs(self.eigenvalues(2)[1])))

    @cached_property
    def mixing_cycles(self) -> float:
        """-1/ln|λ₂|: cycles in which the slowest departure from the law falls by e; ∞ if |λ₂| = 1."""
        second = 1.0 - self.spectral_gap
        if second <= 0.0:
            return 0.0
        return float("inf") if second >= 1.0 else float(-1.0 / np.log(second))

    # -- passages ------------------------------------------------------------------------------------------

    def mean_passage_time(self, start: float, arc: tuple[float, float], *, lifted: bool = False) -> float:
        """Mean number of cycles until the path from ``start`` is first outside ``arc``; see ``passage``."""
        return mean_passage_time(self.map, self.noise, start, arc, lifted=lifted)

    def hitting_probability(self, start: float, arc_a: tuple[float, float], arc_b: tuple[float, float]) -> float:
        """Probability that the path from ``start`` reaches ``arc_a`` before ``arc_b``; see ``passage``."""
        return hitting_probability(self.map, self.noise, start, arc_a, arc_b)

    # -- inside --------------------------------------------------------------------------------------------
    # Real form: the vector (E cos mθ, m = 1..M; E sin mθ, m = 1..M), without the constant mode.

    @cached_property
    def _kappa(self) -> Array:
        return np.tile(self.noise.coefficients(np.arange(1, self.modes + 1)), 2)

    @cached_property
    def _rule(self) -> tuple[Array, Array]:
        return circle_rule(self.map, self.modes)

    @cached_property
    def _matrix(self) -> Array:
        """One cycle's action on departures from uniform: κ_m (1/π) ∫ (cos, sin)(mF) (cos, sin)(kθ) dθ."""
        theta, weight = self._rule
        size = 2 * self.modes
        matrix = np.zeros((size, size))
        for at in range(0, theta.size, _BLOCK):
            part = slice(at, at + _BLOCK)
            after, before = self._waves(self.map(theta[part])), self._waves(theta[part])
            matrix += after.T @ (before * weight[part, None])
        matrix *= (self._kappa / np.pi)[:, None]
        return matrix

    @cached_property
    def _factors(self) -> tuple[Array, npt.NDArray[np.int32]]:
        lu, pivots = lu_factor(np.eye(2 * self.modes) - self._matrix)
        return lu, pivots

    @cached_property
    def _law(self) -> Array:
        theta, weight = self._rule
        source = self._moments(theta, weight / TWO_PI)
        law = np.asarray(lu_solve(self._factors, source))
        if not np.all(np.isfinite(law)):
            raise ConvergenceError("the stationary law is not unique to rounding: raise the noise")
        return law

    @cached_property
    def _inverse_norm(self) -> float:
        size = float(np.max(np.sum(np.abs(np.eye(2 * self.modes) - self._matrix), axis=0)))
        reciprocal, _ = lapack.dgecon(self._factors[0], size, norm="1")
        return float("inf") if reciprocal <= 0.0 else float(1.0 / (reciprocal * size))

    def _moments(self, theta: Array, mass: Array) -> Array:
        """Moments after one cycle of point masses at ``theta``."""
        total = np.zeros(2 * self.modes)
        for at in range(0, theta.size, _BLOCK):
            part = slice(at, at + _BLOCK)
            total += mass[part] @ self._waves(self.map(theta[part]))
        return self._kappa * total

    def _waves(self, theta: Array) -> Array:
        phase = np.multiply.outer(theta, np.arange(1.0, self.modes + 1.0))
        return np.concatenate([np.cos(phase), np.sin(phase)], axis=-1)

    def _slope(self, theta: Array) -> Array:
        """Derivative of the density."""
        order = np.arange(1.0, self.modes + 1.0)
        cosine, sine = np.split(self._law, 2)
        shape = theta.shape
        return np.asarray(self._waves(theta.ravel()) @ np.concatenate([order * sine, -order * cosine]) / np.pi).reshape(
            shape
        )

    def _excess_mass(self, theta: Array) -> Array:
        """∫ of density - 1/2π from 0 to theta, up to a constant."""
        order = np.arange(1.0, self.modes + 1.0)
        cosine, sine = np.split(self._law, 2)
        return np.asarray(self._waves(theta) @ np.concatenate([-sine / order, cosine / order]) / np.pi)

    @cached_property
    def _grid(self) -> tuple[Array, Array]:
        """A uniform grid of at least 16 points a mode, and the density there."""
        count = 1 << int(np.ceil(np.log2(16 * self.modes)))
        cosine, sine = np.split(self._law, 2)
        spectrum = np.zeros(count // 2 + 1, dtype=np.complex128)
        spectrum[0], spectrum[1 : self.modes + 1] = 1.0, cosine - 1j * sine
        return TWO_PI * np.arange(count) / count, np.fft.irfft(spectrum, count) * count / TWO_PI

    @cached_property
    def _all_eigenvalues(self) -> npt.NDArray[np.complex128]:
        return np.asarray(np.linalg.eigvals(self._matrix), dtype=np.complex128)

    def _leading_eigenvalues(self, count: int) -> npt.NDArray[np.complex128]:
        begin = np.random.default_rng(1).standard_normal(2 * self.modes)
        basis = min(2 * self.modes, max(4 * count, 48))
        values, vectors = eigs(self._matrix, count, v0=begin, ncv=basis, tol=1e-13, maxiter=2_000)
        residual = np.linalg.norm(self._matrix @ vectors - vectors * values, axis=0)
        if float(np.max(residual)) > 1e-8:
            raise ConvergenceError(f"eigenvalues left a residual of {np.max(residual):.2g}: raise the noise")
        return np.asarray(values, dtype=np.complex128)


def _prominent(values: Array, margin: float) -> npt.NDArray[np.int64]:
    """Indices of local maxima on a periodic grid that rise by ``margin`` above the dips beside them."""
    before, after = np.roll(values, 1), np.roll(values, -1)
    tops = np.flatnonzero((values > before) & (values >= after) & (values > margin))
    while tops.size:
        spans = zip(tops, np.append(tops[1:], tops[0] + values.size), strict=True)
        lows = np.array([np.min(np.take(values, range(a, b + 1), mode="wrap")) for a, b in spans])
        height = values[tops] - np.maximum(lows, np.roll(lows, 1))
        least = int(np.argmin(height))
        if height[least] > margin:
            break
        tops = np.delete(tops, least)
    return tops
