"""Eigenvalues of a transfer operator, and its linear response: how laws and eigenvalues move with a parameter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from cyclemap.arrays import TWO_PI, Array, Whole
from cyclemap.checks import finite_array, whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import EPS, MATRIX, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.operator.fourier_basis import Discretisation, FourierDiscretisation
from cyclemap.maps.operator.poisson_equation import BorderedSystem, density_at, density_grid

Complex = npt.NDArray[np.complex128]

_DENSE = 320  # below this many unknowns all eigenvalues are computed at once
_TOO_SMALL = 1e-6  # left vectors are not smoothed where that divides by less
_SAME = 1e-9  # eigenvalues nearer to each other, both well conditioned, are one that is there twice
_WELL_CONDITIONED = 1e3
_TRUSTED = 1.0 / 16.0  # of the distance to the next: a bound to first order up to there leaves out no second order
_SQUARINGS = 8


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Leading eigenvalues of a transfer operator, in falling order of modulus; the first is 1, exactly.

    values : (k,), complex. error_bounds : (k,), bounds on |error| to first order in the residuals of both
        vectors; inf where that is more than a sixteenth of the distance to the next eigenvalue found, so that the
        first order tells nothing, or where the basis cannot tell. That none was overlooked is not proved.
    condition : (k,), ‖w‖‖v‖/|wᵀv| ≥ 1, v and w the right and left vectors: how much faster than a change of the
        operator the eigenvalue moves; large near a defective one (Wilkinson 1965).
    right, left : (n, k), the vectors' coefficients, wᵀv = 1.
    """

    values: Complex
    error_bounds: Array
    condition: Array
    right: Complex = field(repr=False)
    left: Complex = field(repr=False)


def leading_values(basis: Discretisation, count: int) -> Complex:
    """The eigenvalues of largest modulus, 1 first, without vectors; fewer where the basis has fewer."""
    deflated = _deflated(basis)
    if basis.size <= _DENSE or 2 * count + 10 >= basis.size:
        found = np.asarray(np.linalg.eigvals(deflated), dtype=np.complex128)
    else:
        found = _arnoldi(deflated, max(count, 8))[0]
    return np.concatenate([[1.0 + 0.0j], found[_falling(found)]])[:count]


def leading_spectrum(basis: Discretisation, finer: Discretisation | None, law: Array, count: int) -> Spectrum:
    """The leading ``count`` eigenvalues on a basis, their vectors, and error bounds by a finer basis."""
    values, right, left = _two_sided(_deflated(basis), count - 1, basis.size <= _DENSE)
    values = np.concatenate([[1.0 + 0.0j], values])
    # A left vector of the deflated matrix is one of L but for its share of the first, which is the mass.
    left = left - np.multiply.outer(basis.mass, law @ left)
    right = np.column_stack([law, right])
    left = np.column_stack([basis.mass, left])
    overlap = np.abs(np.sum(left * right, axis=0))
    with np.errstate(divide="ignore", invalid="ignore"):
        left = left / np.sum(left * right, axis=0)
        condition = np.linalg.norm(left, axis=0) * np.linalg.norm(right, axis=0)
    condition = np.where(overlap > 0.0, condition, np.inf)
    with np.errstate(all="ignore"):
        rounding = MATRIX * condition * float(np.linalg.norm(basis.matrix))
        bounds = np.nan_to_num(_error_bounds(basis, finer, values, right, left) + rounding, nan=np.inf, posinf=np.inf)
    # How far from each eigenvalue the nearest different one lies, 1 at most.
    apart, good = np.abs(values[:, None] - values), condition <= _WELL_CONDITIONED
    apart[(apart <= _SAME) & (good[:, None] & good | np.eye(values.size, dtype=bool))] = 1.0
    bounds[bounds > _TRUSTED * np.min(apart, axis=1, initial=1.0)] = np.inf
    bounds[0] = 0.0
    return Spectrum(values[:count], bounds[:count], condition[:count], right[:, :count], left[:, :count])


def second_modulus(spectrum: Spectrum, basis: Discretisation) -> Estimate:
    """|λ₂|, with the bounds of every eigenvalue that could be the second largest.

    Where one of those is not known, as near a defective eigenvalue, no more than 0 ≤ |λ₂| ≤ ‖L₀ⁿ‖^(1/n), every n, L₀
    the operator without its first eigenvalue.
    """
    moduli, bounds = np.abs(spectrum.values[1:]), spectrum.error_bounds[1:]
    if moduli.size == 0:
        return Estimate(0.0, 0.0)
    close = moduli + bounds >= moduli[0] - bounds[0]
    highest = float(np.max(np.where(close, moduli + bounds, 0.0)))
    if np.isfinite(highest):
        return Estimate(float(moduli[0]), max(highest - float(moduli[0]), float(bounds[0])))
    largest = _root_of_powers(basis)
    value = min(float(moduli[0]), largest)
    return Estimate(value, max(value, largest - value))


def _root_of_powers(basis: Discretisation) -> float:
    """The least ‖L₀ⁿ‖^(1/n), n = 1, 2, 4, ..., with what the matrix and its products may be off."""
    power = _deflated(basis)
    size = float(np.linalg.norm(power))
    off = MATRIX * 4.0 * (1.0 + size)
    if isinstance(basis, FourierDiscretisation):
        off += basis.noise.tail(basis.modes) * (1.0 + size)
    least, n = 1.0, 1
    for _ in range(_SQUARINGS):
        least = min(least, (size + off) ** (1.0 / n))
        off = 2.0 * size * off + off * off + MATRIX * np.sqrt(basis.size) * size * size
        power, n = power @ power, 2 * n
        size = float(np.linalg.norm(power))
    return least


def mixing_time(second: Estimate) -> Estimate:
    """-1/ln|λ₂|, cycles, with the bound that follows from that of |λ₂|; inf where |λ₂| may be 1."""

    def cycles(modulus: float) -> float:
        if modulus <= 0.0:
            return 0.0
        return float("inf") if modulus >= 1.0 else float(-1.0 / np.log(modulus))

    low, found, high = (cycles(part) for part in (second.lower, float(second), second.upper))
    return Estimate(found, max(high - found, found - low) if np.isfinite(high) else float("inf"))


def _deflated(basis: Discretisation) -> Array:
    """L - u·massᵀ: the eigenvalue 1 moved to 0, all others left where they are."""
    return np.asarray(basis.matrix - np.multiply.outer(basis.uniform, basis.mass))


def _falling(values: Complex) -> Whole:
    """Order by falling modulus, of a pair the one above the real line first."""
    return np.lexsort((-values.imag, -np.round(np.abs(values), 13)))


def _two_sided(matrix: Array, count: int, dense: bool) -> tuple[Complex, Complex, Complex]:
    """The ``count`` leading eigenvalues (a few more where they are at hand), right and left vectors."""
    if dense or 2 * count + 10 >= matrix.shape[0]:
        from scipy.linalg import eig

        found = eig(matrix, left=True)
        values, left, right = (np.asarray(part, dtype=np.complex128) for part in found)
        left = left.conj()
    else:
        values, right = _arnoldi(matrix, max(count, 8))
        others, left = _arnoldi(matrix.T, max(count, 8))
        left = left[:, [int(np.argmin(np.abs(others - value))) for value in values]]
    order = _falling(values)[: max(count, 8)]
    values, right, left = values[order], right[:, order], left[:, order]
    # Balancing leaves errors where the noise's coefficients are tiny: one more cycle takes them away.
    kept = np.abs(values) > _TOO_SMALL
    left[:, kept] = matrix.T @ left[:, kept] / values[kept]
    return values, right, left


def _arnoldi(matrix: Array, count: int) -> tuple[Complex, Complex]:
    """ARPACK's leading eigenvalues and vectors, residuals checked."""
    from scipy.sparse.linalg import eigs

    begin = np.random.default_rng(1).standard_normal(matrix.shape[0])
    basis = min(matrix.shape[0], max(4 * count, 48))
    values, vectors = eigs(matrix, count, v0=begin, ncv=basis, tol=1e-13, maxiter=2_000)
    residual = float(np.max(np.linalg.norm(matrix @ vectors - vectors * values, axis=0)))
    if residual > 1e-8:
        raise ConvergenceError(f"eigenvalues left a residual of {residual:.2g}: raise the noise")
    return np.asarray(values, dtype=np.complex128), np.asarray(vectors, dtype=np.complex128)


def _error_bounds(
    basis: Discretisation, finer: Discretisation | None, values: Complex, right: Complex, left: Complex
) -> Array:
    """How far the finer basis moves every eigenvalue, to first order where it has no further functions."""
    if finer is None:
        return np.full(values.size, np.inf)
    if isinstance(finer, FourierDiscretisation) and finer.size == basis.size:
        # Real columns: with complex ones all waves would be made complex first.
        carried = finer.cycle(np.ascontiguousarray(right).view(np.float64))
        carried = np.ascontiguousarray(carried).view(np.complex128)
        return np.asarray(np.abs(np.sum(left * carried, axis=0) - values))
    from scipy.optimize import linear_sum_assignment

    # One to one, or to 0: the nearest finer value may be another's.
    others = np.append(leading_values(finer, max(2 * values.size, 8)), np.zeros(values.size))
    gaps = np.abs(values[:, None] - others)
    return np.asarray(gaps[linear_sum_assignment(gaps)])


Function = Callable[[Array], Array]

_SEPARATE = 1e-9  # moduli nearer than this are the same: which one is second is not decided


@dataclass(frozen=True, eq=False)
class Perturbation:
    """What moves: F by ``tangent`` (radians a unit) and its breaks by ``break_shifts``; without one, the noise."""

    tangent: Function | None = None
    break_shifts: Array | None = None

    def applied(self, basis: Discretisation, law: Any) -> Any:
        """Coefficients of d(Lp), the law p held."""
        if self.tangent is None:
            return basis.noise_response(law)
        shifts = np.zeros(basis.map.breaks.size) if self.break_shifts is None else self.break_shifts
        return basis.map_response(law, self.tangent, shifts)


def map_perturbation(circle_map: CircleMap, theta: Array, tangent: Function, break_shifts: Any) -> Perturbation:
    """A checked perturbation of the map: the tangent is tried at ``theta``, one shift is asked for every break."""
    if not callable(tangent) or finite_array("tangent's values", tangent(theta)).shape != theta.shape:
        raise InvalidInput(f"tangent is {tangent!r}: give a callable that acts entry by entry on angles")
    shifts = None if break_shifts is None else finite_array("break_shifts", break_shifts, circle_map.breaks.size, 1)
    return Perturbation(tangent, shifts)


@dataclass(frozen=True, eq=False)
class ResponseLevel:
    """The response on one basis: ``rate``, the coefficients of dp."""

    system: BorderedSystem
    law: Array
    spectrum: Spectrum
    perturbation: Perturbation

    @cached_property
    def rate(self) -> Array:
        """(n,): dc = (I - L)⁻¹ dL c (Hanggi & Thomas 1982; Galatolo & Giulietti 2019)."""
        return self.system.solve(self.perturbation.applied(self.system.basis, self.law))

    def of_integral(self, values: Array, theta: Array, weight: Array) -> float:
        """∫ h dp for the h with these ``values`` at ``theta``."""
        return float(np.dot(weight * values, density_at(self.system.basis, theta, self.rate)))

    @cached_property
    def second(self) -> complex:
        """dλ₂ = wᵀ dL v / wᵀv."""
        right, left = self.spectrum.right[:, 1], self.spectrum.left[:, 1]
        return complex(left @ self.perturbation.applied(self.system.basis, right))

    def mean_turn(self) -> float:
        """d E(F - θ), radians."""
        basis, moving = self.system.basis, self.perturbation
        theta, weight = basis.rule()
        change = self.of_integral(basis.map.turn(theta), theta, weight)
        if moving.tangent is None:
            return change
        breaks = basis.map.breaks
        if moving.break_shifts is not None and breaks.size:
            # What moving breaks hand over: shift·p·(left - right).
            jumps = basis.map.left(breaks) - basis.map.right(breaks)
            change += float(np.sum(moving.break_shifts * (basis.evaluate(breaks) @ self.law) * jumps))
        return change + float(np.dot(weight * moving.tangent(theta), density_at(basis, theta, self.law)))


@dataclass(frozen=True, eq=False)
class Response:
    """The derivative of a law, and of what is read off it, with respect to one parameter; made by a TransferOperator.

    Every number is an ``Estimate``. Its error is measured, not proved: the distance from the same computed with every
    mode that the noise lets through on twice as many nodes, and rounding as the norm of (I - L)⁻¹ magnifies it.
    """

    level: ResponseLevel
    finer: ResponseLevel

    def density(self, theta: Any) -> Array:
        """The derivative of the stationary density, per radian a unit, at ``theta`` (radians, any shape)."""
        angles = finite_array("theta", theta)
        return density_at(self.level.system.basis, angles.ravel(), self.level.rate).reshape(angles.shape)

    @cached_property
    def density_error(self) -> float:
        """Measured error of ``density``, per radian a unit, anywhere on the circle."""
        basis = self.finer.system.basis
        grid, values = density_grid(lambda at: density_at(basis, at, self.finer.rate), basis.size)
        # Between the grid's points, eight a function, a trigonometric polynomial rises by 2 % at most.
        return 1.02 * float(np.max(np.abs(values - self.density(grid)))) + self._rounding / np.pi

    def moment(self, n: int) -> complex:
        """d E e^{inθ}; see ``moment_error``."""
        return complex(self.level.system.basis.moments(whole_number("n", n)) @ self.level.rate)

    def moment_error(self, n: int) -> float:
        """Measured error of ``moment``."""
        finer = complex(self.finer.system.basis.moments(whole_number("n", n)) @ self.finer.rate)
        return abs(finer - self.moment(n)) + self._rounding

    def expectation(self, function: Function) -> Estimate:
        """d E h(θ) = ∫ h dp, for a vectorised h as smooth as F."""

        def change(level: ResponseLevel) -> float:
            theta, weight = level.system.basis.rule()
            return level.of_integral(finite_array("function's values", function(theta)), theta, weight)

        return self._measured(change, function)

    @cached_property
    def rotation_number(self) -> Estimate:
        """The derivative of the mean winding, turns a cycle a unit; InvalidInput unless the degree is 1."""
        circle_map = self.level.system.basis.map
        if circle_map.degree != 1:
            raise InvalidInput(f"the map has degree {circle_map.degree}: its mean winding is not defined")
        return self._measured(lambda level: level.mean_turn() / TWO_PI, lambda theta: circle_map.turn(theta) / TWO_PI)

    # -- the second eigenvalue -----------------------------------------------------------------------------

    @cached_property
    def gap_is_smooth(self) -> bool:
        """Whether λ₂ is simple and no eigenvalue but its conjugate has its modulus, so that |λ₂| has a derivative."""
        values, bounds = self.level.spectrum.values, self.level.spectrum.error_bounds
        if values.size < 2 or abs(values[1]) <= bounds[1] or not np.isfinite(bounds[1]):
            return False
        others = np.delete(values, [0, 1])
        others = others[np.abs(others - np.conj(values[1])) > _SEPARATE + bounds[1]] if values[1].imag else others
        return bool(np.all(np.abs(others) < abs(values[1]) - _SEPARATE - bounds[1]))

    @cached_property
    def second_modulus(self) -> Estimate:
        """d|λ₂| = Re(λ̄₂ dλ₂)/|λ₂|, by first-order perturbation; nan unless ``gap_is_smooth``."""
        if not self.gap_is_smooth:
            return Estimate(float("nan"), float("inf"))
        found = _modulus_change(self.level)
        condition = float(self.level.spectrum.condition[1])
        size = abs(self.level.second) + float(np.max(np.abs(self.level.rate)))
        return Estimate(found, abs(_modulus_change(self.finer) - found) + 64.0 * EPS * condition**2 * size)

    @cached_property
    def spectral_gap(self) -> Estimate:
        """d(1 - |λ₂|); nan unless ``gap_is_smooth``."""
        return Estimate(-self.second_modulus, self.second_modulus.error_bound)

    # -- inside --------------------------------------------------------------------------------------------

    @cached_property
    def _rounding(self) -> float:
        """What rounding may move one moment's derivative by."""
        size = float(np.max(np.abs(self.level.rate))) + 1.0
        return 8.0 * EPS * (1.0 + self.level.system.inverse_norm) * size

    def _measured(self, number: Callable[[ResponseLevel], float], weighed: Function) -> Estimate:
        found = number(self.level)
        theta, weight = self.level.system.basis.rule()
        values = np.abs(weighed(theta))
        size = float(np.dot(weight, np.where(np.isfinite(values), values, 0.0))) / TWO_PI
        return Estimate(found, abs(number(self.finer) - found) + self._rounding * (1.0 + size))


def _modulus_change(level: ResponseLevel) -> float:
    value = complex(level.spectrum.values[1])
    return float((np.conj(value) * level.second).real / abs(value))
