"""Poisson's equation (I - L) x = f: the stationary distribution of a noisy map, its errors, and how
paths spread.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol, Self

import numpy as np

from cyclemap.arrays import Array, even_angles
from cyclemap.checks import finite_array
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import INTEGRAL, MATRIX, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap, require_degree_one
from cyclemap.maps.lifts.scan import bracketed_root
from cyclemap.maps.noise import Noise
from cyclemap.maps.operator.fourier_basis import (
    Complex,
    FourierDiscretisation,
    ShiftedDiscretisation,
    sizes_on_grid,
)
from cyclemap.maps.quadrature import Rule

Function = Callable[[Array], Array]

_POINTS_A_MODE = 16  # on which the largest error of a density is sought: 2 % are left
_MISSED = 1.03  # times a bound on two θ a mode: what may be missed between them
_TRUSTED = (
    0.25  # of a diffusion constant: a change up to there is told by its first order and worst
)
_COLUMNS = 64  # questions about the density whose answers are made at a time
_POINTS = 8  # grid points a basis function
_NOT_UNIQUE = "the stationary law is not unique to rounding: raise the noise"


class Discretisation(Protocol):
    """A basis φ_0, ..., φ_{n-1} of functions on the circle, and one cycle θ' = F(θ) + ξ as a matrix
    on it.

    Laws are coefficients c of densities p(θ) = Σ_j c_j φ_j(θ), per radian.
    """

    @property
    def map(self) -> CircleMap:
        """F."""

    @property
    def noise(self) -> Noise | None:
        """ξ; None for none."""

    @property
    def size(self) -> int:
        """n."""

    @property
    def left_out(self) -> float:
        """A bound on what one cycle makes of functions beyond the basis;
        inf where there is none."""

    @property
    def mass(self) -> Array:
        """(n,): the integral of every basis function."""

    @property
    def uniform(self) -> Array:
        """(n,): the density 1/2π."""

    @property
    def matrix(self) -> Array:
        """(n, n): the coefficients after one cycle from those before."""

    @property
    def rule(self) -> Rule:
        """Nodes and weights over one turn for integrals of a law."""

    def moments(self, order: int) -> Complex:
        """(n,), complex: ∫ e^{i·order·θ} φ_j dθ."""

    def cycle(self, law: Array) -> Array:
        """(n,): coefficients after one cycle of those of ``law``; or columns of several."""

    def coupling(self, left: Array | Complex, right: Array | Complex) -> Array:
        """(k, k): how much wᵀLv changes when F is off by its ``max_error``, at most; w a column of
        ``left``, v one of ``right``.
        """

    @property
    def moved(self) -> float:
        """A bound on the norm of what L changes by then; inf where there is none."""

    def refined(self) -> Self:
        """A finer basis, for errors."""


@dataclass(frozen=True, eq=False)
class StationaryLaw:
    """The density p̃ with L p̃ = p̃ on a basis, and Poisson's equation about it.

    (I - L) x = f, f without mass, is made regular as (I - L + u·massᵀ) x = f, u the uniform law:
    its solution has no mass, and f = u gives p̃.
    """

    basis: Discretisation

    @cached_property
    def _inverse(self) -> Array:
        """The inverse of I - L + u·massᵀ; ConvergenceError where there is none to rounding.

        Every question asks for more solutions, and NumPy alone has it: SciPy's factors take longer
        to import.
        """
        matrix = np.eye(self.basis.size) - self.basis.matrix
        matrix += np.multiply.outer(self.basis.uniform, self.basis.mass)
        try:
            return np.asarray(np.linalg.inv(matrix), dtype=np.float64)
        except np.linalg.LinAlgError as error:
            raise ConvergenceError(_NOT_UNIQUE) from error

    @cached_property
    def _growth(self) -> float:
        """‖·‖₁ of that inverse: how much a residual may grow in a solution."""
        return float(np.max(np.sum(np.abs(self._inverse), axis=0)))

    @cached_property
    def coefficients(self) -> Array:
        """(n,): those of p̃; ConvergenceError where it is not unique to rounding."""
        return self._solve(self.basis.uniform)

    def _solve(self, right: Array) -> Array:
        solution = self._inverse @ right
        if not np.all(np.isfinite(solution)):
            raise ConvergenceError(_NOT_UNIQUE)
        return solution

    def dual(self, moments: Array) -> Array:
        """w_j = ∫ z φ_j of the z with z - Pz = h - E h (Poisson's equation), from ``moments`` ∫ h
        φ_j.

        P = L* is the backward operator, (Pz)(θ) = E z(F(θ) + ξ); z's mean over the circle is 0.
        Columns of several h, shape (n, k), too.
        """
        centred = moments - np.multiply.outer(self.basis.mass, moments.T @ self.coefficients)
        return self._inverse.T @ centred

    @cached_property
    def grid(self) -> tuple[Array, Array]:
        """A uniform grid of at least eight points a basis function, and the density there."""
        count = 1 << int(np.ceil(np.log2(_POINTS * self.basis.size)))
        grid = even_angles(count)
        return grid, self.density(grid)

    def density(self, theta: Array) -> Array:
        """The density per radian at angles, shape (m,)."""
        raise NotImplementedError

    def diffusion(self) -> Estimate:
        """Refused, where there is no way to compute it: InvalidInput."""
        raise InvalidInput(
            f"the noise is {self.basis.noise!r}: a diffusion constant is computed for "
            "WrappedNormal; else sample_staircases tells how paths spread"
        )

    def diffusion_moved(self) -> float:
        """How much a diffusion constant changes by the map's ``max_error``; there is none here."""
        return 0.0

    def refined(self) -> Self:
        """The same on a finer basis."""
        return replace(self, basis=self.basis.refined())


@dataclass(frozen=True, eq=False)
class FourierLaw(StationaryLaw):
    """The stationary law in Fourier modes, and how far it is from the true one."""

    basis: FourierDiscretisation

    @property
    def smooth_basis(self) -> FourierDiscretisation:
        """The basis, for what needs a smooth density."""
        return self.basis

    def density(self, theta: Array) -> Array:
        """The density per radian at angles, shape (m,)."""
        return self.basis.density(theta, self.coefficients)

    @cached_property
    def masses(self) -> Array:
        """What the nodes of the basis's rule have of it: weights times the density there."""
        return self.basis.rule[1] * self.basis.on_nodes(self.coefficients)

    def slope(self, theta: Array) -> Array:
        """Its derivative."""
        return self.basis.slope(theta, self.coefficients)

    @cached_property
    def error(self) -> tuple[FourierDiscretisation, Array, float, float]:
        """(basis, correction, left, remainder): p - p̃ is the correction on that basis, give or
        take what it leaves.

        In coefficients at most ``left``, summed, and per radian at most ``remainder`` when solved
        for. The residual Lp̃ - p̃ is taken with every mode that the noise lets through on twice as
        many nodes, and the equation for the error is solved with it once more (a two-level step,
        Atkinson & Brakhage 1960); ``remainder`` is the norm of (I - L)⁻¹ times what that leaves,
        the noise's tail and a rounding allowance. Proved: that the error is (I - L)⁻¹ times the
        residual, and the tail. Measured: quadrature, rounding, and the norms of the inverse.
        """
        basis = self.basis
        law = self.coefficients
        fine = basis.refined()
        kept = fine.places(basis)
        padded = np.zeros(fine.size)
        padded[kept] = law
        density = fine.on_nodes(padded)
        defect = fine.carried(density) - padded
        once = fine.cycle(defect)
        resolved = np.zeros(fine.size)
        resolved[kept] = self._solve(once[kept])
        correction = defect + once + fine.cycle(resolved)
        left = float(np.sum(np.abs(fine.cycle(correction) - correction + defect)))
        # And Σ over m > modes of |E e^{imθ}| after one cycle (proved), with an allowance for
        # rounding.
        beyond = fine.noise.tail(fine.modes) + MATRIX * float(np.linalg.norm(fine.kappa))
        left += beyond * float(np.dot(fine.rule[1], np.abs(density)))
        growth = 1.0 + self._growth
        return fine, correction, left, growth * left / np.pi

    @property
    def density_error(self) -> float:
        """Bound on sup|p - p̃|, per radian, the map's ``max_error`` included."""
        return self._own_error + float(np.max(self._density_moved))

    @cached_property
    def _own_error(self) -> float:
        """Bound on sup|p - p̃| for this map."""
        basis, correction, _, remainder = self.error
        return float(np.max(sizes_on_grid(basis.scale * correction, _POINTS_A_MODE))) + remainder

    def _dual_bound(self, moments: Array) -> float:
        """|∫ z r| ≤ max|∫ z φ_j| ‖r‖₁, z the solution of Poisson's equation for h; doubled for z's
        higher modes.
        """
        return 2.0 * float(np.max(np.abs(self.dual(moments)), initial=1.0)) * self.error[2]

    def moment_error(self, order: int) -> float:
        """Bound on |∫ e^{i·order·θ} (p - p̃) dθ|, the map's ``max_error`` included."""
        basis, correction, _, _ = self.error
        row = self.basis.moments(order)
        error = abs(complex(basis.moments(order) @ correction)) + INTEGRAL
        parts = np.stack([row.real, row.imag], axis=1)
        error += float(np.hypot(self._dual_bound(row.real), self._dual_bound(row.imag)))
        return error + float(np.hypot(*self._moved(parts)))

    def _moved(self, moments: Array, direct: float = 0.0) -> Array:
        """(k,): bounds on the change of E h when F is off by up to ``max_error`` ε, of several h
        with ``moments`` ∫ h φ_j, (n, k), whose ∂h/∂F is ``direct``.

        With z of Poisson's equation for h, and g(y) = E z(y + ξ), the change is exactly the mean
        of direct·δ + g(F + δ) - g(F) under the law of F + δ. That is at most ε E|s| + ½ε² sup|g''|,
        s = direct + g'(F), and the mean of |s| under the other law at most ε sup|g₁'| more than
        under this one, g₁ made of |s| as g is of h.
        """
        basis = self.basis
        epsilon = basis.map.max_error
        if epsilon == 0.0:
            return np.zeros(moments.shape[1])
        theta, weight = basis.rule
        dual = self.dual(moments)
        slopes = np.abs(direct + basis.expected_slope(dual))
        again = self.dual(basis.integrals(theta, weight[:, None] * slopes))
        bend = 0.5 * basis.slopes_on_grid(dual, 2).max(axis=0)
        other = basis.slopes_on_grid(again, 1).max(axis=0)
        return np.asarray(epsilon * (np.abs(self.masses) @ slopes + epsilon * (bend + other)))

    @cached_property
    def _density_moved(self) -> Array:
        """Bounds on the change of the density, per radian, when F is off by up to ``max_error`` ε,
        on an even grid of two θ a mode.

        As in ``_moved`` with h all at θ, but for the other law p': ∫|p' - p| is at most ε m, m the
        mean under p' of the most that a is within ε of F, a(y) = ∫ |g_θ'(y)| dθ, and so m <= E a(F)
        + ½ε m sup a + ε sup b, b(y) = ∫ |g_θ''(y)| dθ.
        """
        basis = self.basis
        epsilon = basis.map.max_error
        if epsilon == 0.0:
            return np.zeros(1)
        where = even_angles(2 * basis.modes)
        mass: Array = np.abs(self.masses)
        held = mass > INTEGRAL * np.max(mass)  # the law is not known elsewhere, and next to nothing
        at = basis.rule[0][held]
        moved, steepest, bend = [], [], []
        across, bent = np.zeros(1), np.zeros(1)
        for block in np.array_split(where, 1 + where.size // _COLUMNS):
            dual = self.dual(basis.evaluate(block))
            moved.append(mass[held] @ np.abs(basis.expected_slope(dual, at)))
            slopes = basis.slopes_on_grid(dual, 1)
            across = across + slopes.sum(axis=1) * where[1]
            steepest.append(slopes.max(axis=0))
            bends = basis.slopes_on_grid(dual, 2)
            bent = bent + bends.sum(axis=1) * where[1]
            bend.append(bends.max(axis=0))
        first = np.concatenate(moved)
        highest = float(np.max(across))
        held_back = 1.0 - 0.5 * epsilon * highest
        mean = float(np.sum(first)) * where[1] + epsilon * float(np.max(bent))
        carried = min(highest, mean / held_back) if held_back > 0.0 else highest
        second = 0.5 * (np.concatenate(bend) + carried * np.concatenate(steepest))
        return np.asarray(epsilon * (_MISSED * first + epsilon * second))

    def expectation(
        self,
        function: Function,
        rules: tuple[Rule, Rule] | None = None,
        direct: float = 0.0,
    ) -> Estimate:
        """E h under p̃ on the finer of two rules (default: the bases' own); their difference is in
        the bound.

        direct : ∂h/∂F where h depends on F, for the part of the bound that the map's ``max_error``
            makes.
        """
        basis = self.basis
        law = self.coefficients
        (fine, correction, _, _) = self.error
        sums = []
        rounding = 0.0
        for theta, weight in rules or (basis.rule, fine.rule):
            values = checked_values(function, theta)
            mass = weight * basis.density(theta, law)
            sums.append(float(np.dot(mass, values)))
            rounding = INTEGRAL * float(np.dot(np.abs(mass), np.abs(values)))
        rough, value = sums
        bound = abs(value - rough) + rounding
        bound += abs(float(np.dot(weight * values, fine.density(theta, correction))))
        moments = basis.integrals(theta, weight * values)
        bound += self._dual_bound(moments)
        return Estimate(value, bound + float(self._moved(moments[:, None], direct)[0]))

    def distance_from_uniform(self) -> Estimate:
        """½∫|p - 1/2π|, cut where the density crosses the uniform one; 0 where it cannot be told
        from it.
        """
        grid, values = self.grid
        known = np.pi * (self._own_error + float(np.mean(self._density_moved))) + INTEGRAL
        excess = values - 0.5 / np.pi
        farthest = float(np.max(np.abs(excess)))
        if farthest <= 4.0 * self.density_error:
            return Estimate(0.0, min(1.0, known + np.pi * farthest))
        crossing = grid[(excess < 0.0) != (np.roll(excess, -1) < 0.0)]
        crossings = np.sort(
            bracketed_root(lambda x, _: self.density(x) - 0.5 / np.pi, crossing, crossing + grid[1])
        )
        below = self.basis.mass_before(crossings, self.coefficients)
        total = float(np.sum(np.abs(np.diff(below, append=below[:1]))))
        return Estimate(0.5 * total, min(1.0, known))

    def diffusion(self) -> Estimate:
        """D = lim Var(θ_n)/2n, radians² a cycle, of the lifted path θ' = F(θ) + ξ; its bound is of
        rounding alone.

        With z - Pz = u - E u, u = F(θ) - θ the turn (Poisson's equation), z(θ') - Pz(θ) + ξ is a
        martingale difference that adds up to the path but for what stays bounded, so D is half its
        mean square (Gordin & Lifsic 1978): 2D = E (u - Eu)² + 2 E (u - Eu) Pz + 2 E ξ z(θ') + E ξ².
        The third term is there because the kick ξ moves θ' too; for normal noise it is 2σ² E z'(θ')
        (Stein's identity). inf where ξ has no variance.

        Raises InvalidInput unless the degree is 1, and for other noise that has a variance.
        """
        basis = self.basis
        require_degree_one(basis.map, "a diffusion constant")
        if np.isinf(basis.noise.variance):
            return Estimate(float("inf"), 0.0)
        if basis.noise.sigma is None:
            return super().diffusion()
        value, _ = self._spread
        # Rounding is what the norm of (I - L)⁻¹ magnifies.
        return Estimate(value, INTEGRAL * (1.0 + self._growth) * (1.0 + abs(value)))

    def diffusion_moved(self) -> float:
        """How much D may change when F is off by up to ``max_error`` ε; 0 where D is infinite.

        To first order, and how far from that maps change D that are off by ±ε with the signs of
        ∂D/∂F: measured. inf where that is more than a quarter of D, for these tell nothing then.
        """
        basis = self.basis
        epsilon = basis.map.max_error
        if epsilon == 0.0 or np.isinf(basis.noise.variance):
            return 0.0
        value, response = self._spread
        rate = float(np.sum(np.abs(response)))
        beyond = []
        for shift in (-epsilon, epsilon):
            by = shift * np.sign(response)
            other = ShiftedDiscretisation(basis.map, basis.noise, basis.modes, basis.finer, by)
            beyond.append(abs(FourierLaw(other)._spread[0] - value - shift * rate))
        moved = epsilon * rate + max(beyond)
        return moved if moved <= _TRUSTED * value else float("inf")

    @cached_property
    def _spread(self) -> tuple[float, Array]:
        """D, and how fast it changes with F at each node of the basis's rule.

        1 + s²D + ... is the largest eigenvalue of the operator whose steps u + ξ, less their mean,
        are weighted by exp(s·step): its left function is 1 + s·z + s²·z₂ + ..., its law p + s·p₁ +
        ..., z₂ of Poisson's equation for what a step from θ adds to D, p₁ = (I - L)⁻¹ of the mean
        step into an angle. So ∂D/∂F(θ) = p₁ (1 + E z'(θ')) + p E [(u + ξ)(1 + z'(θ')) + z(θ') +
        z₂'(θ')].
        """
        basis = self.basis
        theta, weight = basis.rule
        variance = basis.noise.variance
        law = self.coefficients
        mass = self.masses
        turn = basis.images - theta
        turn = turn - np.dot(mass, turn)
        dual = self.dual(basis.integrals(theta, weight * turn))
        later = basis.expected(dual)  # Pz, but for a constant
        later = later - np.dot(mass, later)
        slope = 1.0 + basis.expected_slope(dual)
        added = turn * (0.5 * turn + later) + variance * (slope - 0.5)
        second = self.dual(basis.integrals(theta, weight * added))
        into = basis.carried(turn * basis.on_nodes(law)) - variance * basis.derived(law)
        tilted = weight * basis.on_nodes(self._solve(into))
        bent = variance * basis.expected_slope(basis.derived(dual))
        steps = turn * slope + bent + later + basis.expected_slope(second)
        return float(np.dot(mass, added)), tilted * slope + mass * steps


def checked_values(function: Function, theta: Array) -> Array:
    """h at the angles, or InvalidInput."""
    if not callable(function):
        raise InvalidInput(f"function is {function!r}: give a callable of an array of angles")
    values = finite_array("the function's values", function(theta))
    if values.shape != theta.shape:
        raise InvalidInput(
            f"function turns shape {theta.shape} into {values.shape}: it must act entry by entry"
        )
    return values
