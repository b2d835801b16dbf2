"""Poisson's equation (I - L) x = f: the stationary distribution of a noisy map, its errors, and how paths spread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg import lapack, lu_factor, lu_solve

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import finite_array
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import INTEGRAL, Estimate
from cyclemap.maps.noise.noise import WrappedNormal
from cyclemap.maps.operator.fourier_basis import Discretisation, FourierDiscretisation, waves

_POINTS = 8  # grid points a basis function
_NORM_SAFETY = 3.0  # LAPACK's estimate of a norm is seldom more than this below it
_ENTRIES = 400_000  # nodes times basis functions handled at a time: few enough for the processor's cache
_GRID_FACTOR = 16  # points a mode on which the largest value of a density is sought


@dataclass(frozen=True, eq=False)
class BorderedSystem:
    """The equation (I - L) x = f for f without mass, made regular as (I - L + u·massᵀ) x = f, u the uniform law.

    Its solution has no mass; with f = u it is the stationary law. ``lu`` and ``pivots`` factor it.
    """

    basis: Discretisation

    @cached_property
    def matrix(self) -> Array:
        """(n, n): I - L + u·massᵀ."""
        matrix = np.eye(self.basis.size) - self.basis.matrix
        matrix += np.multiply.outer(self.basis.uniform, self.basis.mass)
        return matrix

    @cached_property
    def _factors(self) -> tuple[Array, npt.NDArray[np.int32]]:
        lu, pivots = lu_factor(self.matrix)
        return lu, pivots

    def solve(self, right: Array) -> Array:
        """x of (I - L + u·massᵀ) x = right; ConvergenceError where that is singular to rounding."""
        found = np.asarray(lu_solve(self._factors, right))
        if not np.all(np.isfinite(found)):
            raise ConvergenceError("the stationary law is not unique to rounding: raise the noise")
        return found

    def dual(self, moments: Array, law: Array) -> Array:
        """w_j = ∫ z φ_j of the z with z - Pz = h - E h (Poisson's equation), from ``moments`` ∫ h φ_j.

        P = L* is the backward operator, (Pz)(θ) = E z(F(θ) + ξ); z's mean over the circle is 0. Columns of several
        h, shape (n, k), too.
        """
        centred = moments - np.multiply.outer(self.basis.mass, moments.T @ law)
        return np.asarray(lu_solve(self._factors, centred, trans=1))

    @cached_property
    def inverse_norm(self) -> float:
        """LAPACK's estimate of ‖(I - L + u·massᵀ)⁻¹‖₁ on coefficients."""
        size = float(np.max(np.sum(np.abs(self.matrix), axis=0)))
        reciprocal, _ = lapack.dgecon(self._factors[0], size, norm="1")
        return float("inf") if reciprocal <= 0.0 else float(1.0 / (reciprocal * size))

    @cached_property
    def largest_growth(self) -> float:
        """Measured bound on sup|x| over sup|f|, (I - L) x = f: a norm of the inverse between values on the nodes."""
        theta, weight = self.basis.rule
        values = self.basis.evaluate(theta)
        project = np.linalg.solve((values.T * weight) @ values, values.T * weight)
        within = values @ (self.solve(np.asarray(project)) - project)
        return 1.0 + float(np.max(np.sum(np.abs(within), axis=1)))


@dataclass(frozen=True, eq=False)
class SolutionError:
    """How far a computed law is from the true one, p: the law is p̃, Lp̃ - p̃ its residual.

    p - p̃ is the density with coefficients ``correction`` on ``basis``, give or take (I - L)⁻¹ of what that leaves
    over: in coefficients at most ``left``, summed, and per radian at most ``remainder`` when solved for.
    """

    system: BorderedSystem
    law: Array
    basis: Discretisation
    correction: Array
    left: float
    remainder: float

    @cached_property
    def largest(self) -> float:
        """Bound on sup|p - p̃|, per radian."""
        return _largest_density(self.basis, self.correction) + self.remainder

    def of_integral(self, values: Array, theta: Array, weight: Array) -> float:
        """Bound on |∫ h (p - p̃) dθ| for the h with these ``values`` at ``theta``."""
        first = abs(float(np.dot(weight * values, density_at(self.basis, theta, self.correction))))
        if not isinstance(self.basis, FourierDiscretisation):
            return first + self.remainder * float(np.dot(weight, np.abs(values - np.median(values))))
        return first + self._dual_bound(moments_against(self.system.basis, theta, weight * values))

    def of_moment(self, order: int) -> float:
        """Bound on |∫ e^{i·order·θ} (p - p̃) dθ|."""
        first = abs(complex(self.basis.moments(order) @ self.correction))
        if not isinstance(self.basis, FourierDiscretisation):
            return first + TWO_PI * self.remainder
        row = self.system.basis.moments(order)
        return first + float(np.hypot(self._dual_bound(row.real), self._dual_bound(row.imag)))

    def _dual_bound(self, moments: Array) -> float:
        """|∫ z r| ≤ max|∫ z φ_j| ‖r‖₁, z the solution of Poisson's equation for h; doubled for z's higher modes."""
        return 2.0 * float(np.max(np.abs(self.system.dual(moments, self.law)), initial=1.0)) * self.left


def law_error(system: BorderedSystem, law: Array) -> SolutionError:
    """The error of the stationary law: ``law`` solves L p = p on the system's basis.

    Fourier: the residual Lp - p is taken with every mode that the noise lets through on twice as many nodes, and
    the equation for the error is solved with it once more (a two-level step, Atkinson & Brakhage 1960);
    ``remainder`` is the norm of (I - L)⁻¹ times what that leaves, the noise's tail and a rounding allowance.
    Other bases: no correction, the basis's own ``residual`` times ``largest_growth``. Proved: that the error is
    (I - L)⁻¹ times the residual, and the tail. Measured: quadrature, rounding, and the norms of the inverse.
    """
    basis = system.basis
    if not isinstance(basis, FourierDiscretisation):
        left = basis.residual(law)
        return SolutionError(system, law, basis, np.zeros(basis.size), left, system.largest_growth * left)
    fine = basis.refined()
    density = fine.on_nodes(fine.padded(law, basis))
    defect = fine.carried(density) - fine.padded(law, basis)
    once = fine.cycle(defect)
    resolved = fine.padded(system.solve(fine.cut(once, basis)), basis)
    correction = defect + once + fine.cycle(resolved)
    left = float(np.sum(np.abs(fine.cycle(correction) - correction + defect))) + fine.left_out(density)
    growth = 1.0 + _NORM_SAFETY * system.inverse_norm
    return SolutionError(system, law, fine, correction, left, growth * left / np.pi)


def map_error_of_integral(system: BorderedSystem, law: Array, moments: Array, direct: Any = 0.0) -> float:
    """First-order bound on the change of E h, ``moments`` = ∫ h φ_j, when F is off by up to ``max_error``.

    ε E|direct + (Pz)'|, where z solves Poisson's equation for h, (Pz)' is the derivative of E z(F + ξ) in F, and
    ``direct`` ∂h/∂F at the nodes of the basis's rule where h depends on F. For bases other than Fourier |(Pz)'|
    is replaced by its bound, the spread of z times the noise's largest density (unimodal noise).
    """
    basis, epsilon = system.basis, system.basis.map.max_error
    if epsilon == 0.0:
        return 0.0
    theta, weight = basis.rule
    dual = system.dual(moments, law)
    if isinstance(basis, FourierDiscretisation):
        return epsilon * float(
            np.dot(weight * np.abs(basis.on_nodes(law)), np.abs(direct + basis.expected_slope(dual)))
        )
    values = basis.evaluate(theta)
    spread = float(np.ptp(values @ np.linalg.solve((values.T * weight) @ values, dual)))
    return epsilon * (float(np.max(np.abs(direct))) + spread * float(basis.noise.density(0.0)))


def map_error_of_moment(system: BorderedSystem, law: Array, order: int) -> float:
    """The same for |E e^{i·order·θ}|."""
    row = system.basis.moments(order)
    real, imaginary = (map_error_of_integral(system, law, part) for part in (row.real, row.imag))
    return float(np.hypot(real, imaginary))


def map_error_of_density(system: BorderedSystem, law: Array) -> Array:
    """First-order bounds on the change of the density, per radian, when F is off by up to ``max_error``.

    ε ∫ |∂p(θ)/∂F(x)| p(x) dx on an even grid of one θ a mode; 0 on bases other than Fourier (with uniform noise the
    law has steps that move with the map, so that no such bound exists).
    """
    basis, epsilon = system.basis, system.basis.map.max_error
    if epsilon == 0.0 or not isinstance(basis, FourierDiscretisation):
        return np.zeros(1)
    where = TWO_PI * np.arange(basis.modes) / basis.modes
    theta, weight = basis.rule
    mass = weight * np.abs(basis.on_nodes(law))
    held = mass > INTEGRAL * np.max(mass)  # the law is not known elsewhere, and next to nothing
    slopes = np.abs(basis.expected_slope(system.dual(basis.evaluate(where).T, law), at=theta[held]))
    return np.asarray(epsilon * (mass[held] @ slopes))


def moments_against(basis: Discretisation, theta: Array, mass: Array) -> Array:
    """(n,): Σ mass φ_j(θ), in blocks."""
    step = max(64, _ENTRIES // basis.size)
    parts = [mass[at : at + step] @ basis.evaluate(theta[at : at + step]) for at in range(0, theta.size, step)]
    return np.asarray(np.sum(parts, axis=0))


def density_at(basis: Discretisation, theta: Array, coefficients: Array) -> Array:
    """The density at many angles, in blocks."""
    step = max(64, _ENTRIES // basis.size)
    parts = [basis.evaluate(theta[at : at + step]) @ coefficients for at in range(0, theta.size, step)]
    return np.concatenate(parts) if parts else np.zeros(0)


def density_grid(density: Callable[[Array], Array], size: int) -> tuple[Array, Array]:
    """A uniform grid of at least eight points a basis function, and the density there."""
    count = 1 << int(np.ceil(np.log2(_POINTS * size)))
    grid = TWO_PI * np.arange(count) / count
    return grid, density(grid)


def _largest_density(basis: Discretisation, coefficients: Array) -> float:
    """sup|p| of a trigonometric polynomial, from a grid so fine that Bernstein's inequality leaves 2 %."""
    if not np.any(coefficients):
        return 0.0
    assert isinstance(basis, FourierDiscretisation)
    count = _GRID_FACTOR * basis.modes
    spectrum = np.zeros(count // 2 + 1, dtype=np.complex128)
    spectrum[0] = coefficients[0]
    spectrum[1 : basis.modes + 1] = coefficients[1 : basis.modes + 1] - 1j * coefficients[basis.modes + 1 :]
    return 1.02 * float(np.max(np.abs(np.fft.irfft(spectrum, count)))) * count / TWO_PI


Rule = tuple[Array, Array]


def expected(
    error: SolutionError, function: Callable[[Array], Array], rules: tuple[Rule, Rule], direct: float
) -> Estimate:
    """E h under the law whose error is ``error``, on the finer of two rules; their difference is in the bound.

    direct : ∂h/∂F where h depends on F, for the part of the bound that the map's ``max_error`` makes.
    """
    (coarse, coarse_weight), (theta, weight) = rules
    basis, law = error.system.basis, error.law
    values = _values(function, theta)
    mass = weight * density_at(basis, theta, law)
    found = float(np.dot(mass, values))
    rough = float(np.dot(coarse_weight * _values(function, coarse), density_at(basis, coarse, law)))
    bound = abs(found - rough) + INTEGRAL * float(np.dot(np.abs(mass), np.abs(values)))
    bound += error.of_integral(values, theta, weight)
    if basis.map.max_error > 0.0:
        moments = moments_against(basis, theta, weight * values)
        bound += map_error_of_integral(error.system, law, moments, direct)
    return Estimate(found, bound)


def _values(function: Callable[[Array], Array], theta: Array) -> Array:
    if not callable(function):
        raise InvalidInput(f"function is {function!r}: give a callable of an array of angles")
    values = finite_array("the function's values", function(theta))
    if values.shape != theta.shape:
        raise InvalidInput(f"function turns shape {theta.shape} into {values.shape}: it must act entry by entry")
    return values


def diffusion_constant(system: BorderedSystem, law: Array) -> float:
    """D = lim Var(θ_n)/2n, radians² a cycle, of the lifted path θ' = F(θ) + ξ under its stationary law.

    With z - Pz = u - E u, u = F(θ) - θ the turn (Poisson's equation), z(θ') - Pz(θ) + ξ is a martingale difference
    that adds up to the path but for what stays bounded, so D is half its mean square (Gordin & Lifsic 1978):
    2D = E (u - Eu)² + 2 E (u - Eu) Pz + 2 E ξ z(θ') + E ξ². The third term is there because the kick ξ moves θ' too;
    for normal noise it is 2σ² E z'(θ') (Stein's identity). inf where ξ has no variance.

    Raises InvalidInput unless the degree is 1, and for other noise that has a variance.
    """
    basis = system.basis
    if basis.map.degree != 1:
        raise InvalidInput(f"the map has degree {basis.map.degree}: a diffusion constant needs degree 1")
    if np.isinf(basis.noise.variance):
        return float("inf")
    if not isinstance(basis.noise, WrappedNormal) or not isinstance(basis, FourierDiscretisation):
        raise InvalidInput(
            f"the noise is {basis.noise!r}: a diffusion constant is computed for WrappedNormal; else sample_staircases "
            "tells how paths spread"
        )
    theta, weight = basis.rule
    turn, mass = basis.map.turn(theta), weight * basis.on_nodes(law)
    turn = turn - np.dot(mass, turn)
    dual = system.dual(moments_against(basis, theta, weight * turn), law)
    later = (basis.kappa * dual) @ waves(basis.map(theta), basis.modes)  # Pz, but for a constant
    correlated = float(np.dot(mass, turn * (turn + 2.0 * (later - np.dot(mass, later)))))
    kicked = float(np.dot(mass, basis.expected_slope(dual)))
    return 0.5 * correlated + basis.noise.variance * (0.5 + kicked)
