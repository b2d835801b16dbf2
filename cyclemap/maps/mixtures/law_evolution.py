"""The law of the orientation after n cycles from any start, and the operators that can carry it there."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from cyclemap.checks import finite_number, whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.mixture_discretisation import MixtureDiscretisation
from cyclemap.maps.mixtures.mixture_operator import MixtureOperator
from cyclemap.maps.noise.noise_law import Noise
from cyclemap.maps.operator.fourier_discretisation import FourierDiscretisation, needed_modes, waves
from cyclemap.maps.operator.transfer_operator import TransferOperator
from cyclemap.maps.rounding import EPS

CycleOperator = TransferOperator | MixtureOperator
Parts = tuple[tuple[float, FourierDiscretisation], ...]

_EXCESS = 1e-6  # above 1, of a modulus: more than rounding leaves


def fourier_basis(operator: Any) -> FourierDiscretisation:
    """The Fourier basis of a transfer or mixture operator; InvalidInput for others, and for uniform noise alone."""
    if not isinstance(operator, TransferOperator | MixtureOperator):
        raise InvalidInput(f"the operator is {operator!r}: make it with transfer_operator or mixture_operator")
    if not isinstance(operator.discretisation, FourierDiscretisation):
        raise InvalidInput(
            f"the noise is {operator.noise!r}: laws are followed in Fourier modes, which it does not damp; "
            "add a narrow smooth noise, IndependentSum((WrappedNormal(0.01), UniformNoise(...)))"
        )
    return operator.discretisation


def basis_parts(basis: FourierDiscretisation) -> Parts:
    """(weight, discretisation) of every map of a mixture; of the one map, with weight 1."""
    return basis.parts if isinstance(basis, MixtureDiscretisation) else ((1.0, basis),)


def is_resolved(basis: FourierDiscretisation) -> bool:
    """Whether the basis keeps every mode that the noise lets through, so that nothing is cut off."""
    return basis.modes >= needed_modes(basis.noise)


def complex_moments(coefficients: Any) -> npt.NDArray[np.complex128]:
    """E e^{imθ}, m = 0..M, from real Fourier coefficients (1, E cos mθ, E sin mθ): (2M + 1, ...) to (M + 1, ...)."""
    modes = len(coefficients) // 2
    found = np.array(coefficients[: modes + 1], dtype=np.complex128)
    found[1:] += 1j * coefficients[modes + 1 :]
    return found


def real_coefficients(moments: npt.NDArray[np.complex128], modes: int) -> Array:
    """The inverse of ``complex_moments`` for one law, cut or filled with zeros to ``modes``: (2·modes + 1,)."""
    kept = np.zeros(modes + 1, dtype=np.complex128)
    count = min(modes + 1, moments.size)
    kept[:count] = moments[:count]
    return np.concatenate([kept.real, kept[1:].imag])


def stationary_fourier_law(operator: CycleOperator, bounded: bool = True) -> FourierLaw:
    """The stationary law of an operator, with its error bound; inf, in a fraction of the time, unless ``bounded``.

    Raises ConvergenceError where so few modes are kept that the law is none.

    >>> from cyclemap.maps.lifts.circle_map import CircleMap
    >>> from cyclemap.maps.noise.noise_law import WrappedCauchy
    >>> from cyclemap.maps.operator.transfer_operator import transfer_operator
    >>> law = stationary_fourier_law(transfer_operator(CircleMap.moebius(0.5, 0.0), WrappedCauchy(0.5)))
    >>> bool(abs(law.moments[2] - law.moments[1] ** 2) < 1e-14)
    True
    """
    basis = fourier_basis(operator)
    moments = np.array([operator.moment(n) for n in range(basis.modes + 1)])
    largest = float(np.max(np.abs(moments)))
    if largest > 1.0 + _EXCESS:
        raise ConvergenceError(f"a moment of the stationary law came out as {largest:.4g}, above 1: keep more modes")
    return FourierLaw(moments / moments[0], operator.error_bound if bounded else float("inf"))


def images_law(basis: FourierDiscretisation, theta: Array, from_left: Any = False) -> Array:
    """Coefficients of the laws one cycle after the angles ``theta`` (m,): (n, m).

    from_left : (m,), where the limit from below counts, which differs at the maps' jumps.
    """
    total = np.zeros((basis.size, theta.size))
    for weight, part in basis_parts(basis):
        image = np.where(from_left, part.map.left(theta), part.map(theta)) if np.any(from_left) else part.map(theta)
        total += weight * waves(image, basis.modes)
    return np.asarray(basis.kappa[:, None] * total)


def law_after(operator: CycleOperator, start: float | FourierLaw, cycles: int) -> FourierLaw:
    """The law of θ_n, n = ``cycles``, for θ_0 = ``start`` (radians, n ≥ 1) or θ_0 with a given law (n ≥ 0).

    By n applications of the operator. The bound adds up what every cycle leaves out: L never lengthens an error in
    L1, so that E_n ≤ E_{n-1} + ‖Lp̃ - p̃'‖₁ + 2εg, g the noise's largest density and ε the map's ``max_error``; the
    last cycle turns L1 into a bound per radian. Defects are measured with all modes and twice as many nodes.

    >>> from cyclemap.maps.lifts.circle_map import CircleMap
    >>> from cyclemap.maps.noise.noise_law import WrappedNormal
    >>> from cyclemap.maps.operator.transfer_operator import transfer_operator
    >>> spun = law_after(transfer_operator(CircleMap.rigid(0.25), WrappedNormal(0.5)), 0.0, 2)
    >>> bool(abs(spun.moments[1] + np.exp(-0.25)) < 1e-14), spun.error_bound < 1e-12
    (True, True)
    """
    basis = fourier_basis(operator)
    if isinstance(start, FourierLaw):
        count = whole_number("cycles", cycles, least=0)
        law, bound, absolute = real_coefficients(start.moments, basis.modes), start.error_bound, 0.0
        cut = 2.0 * float(np.sum(np.abs(start.moments[basis.modes + 1 :])))
        bound, absolute = bound + cut / TWO_PI, TWO_PI * bound + cut
    else:
        count = whole_number("cycles", cycles, least=1) - 1
        law = images_law(basis, np.array([finite_number("start", start)]))[:, 0]
        first = _first_errors(basis)
        bound, absolute = first, TWO_PI * first
    fine, largest, steepest = basis.refined(), largest_density(basis.noise), largest_slope(basis.noise)
    error = basis.map.max_error
    for _ in range(count):
        law, left = _cycled(basis, fine, law)
        bound = largest * absolute + left + error * steepest
        absolute = absolute + TWO_PI * left + 2.0 * error * largest
    return FourierLaw(complex_moments(law), bound)


def largest_density(noise: Noise) -> float:
    """A bound on a noise's largest density, per radian, from its coefficients: (1 + 2 Σ |κ_m|)/2π."""
    return _sum_of_modes(noise, 0) / np.pi + 0.5 / np.pi


def largest_slope(noise: Noise) -> float:
    """The same for its slope, per radian²: Σ m |κ_m|/π."""
    return _sum_of_modes(noise, 1) / np.pi


def _sum_of_modes(noise: Noise, power: int) -> float:
    orders = np.arange(1.0, needed_modes(noise) + 1.0)
    return float(np.sum(orders**power * np.abs(noise.coefficients(orders))))


def _first_errors(basis: FourierDiscretisation) -> float:
    """Bound per radian on the law one cycle after an angle: the modes cut off, the map's error and rounding."""
    rounding = 8.0 * EPS * float(np.sum(np.abs(basis.kappa) * (1.0 + basis.order)))
    return (basis.noise.tail(basis.modes) + rounding) / np.pi + basis.map.max_error * largest_slope(basis.noise)


def _cycled(basis: FourierDiscretisation, fine: FourierDiscretisation, law: Array) -> tuple[Array, float]:
    """The law one cycle on, and a bound per radian on what the basis left out."""
    after = basis.matrix @ law
    density = fine.on_nodes(fine.padded(law, basis))
    defect = fine.carried(density) - fine.padded(after, basis)
    return after, fine.largest(defect) + fine.left_out(density) / np.pi
