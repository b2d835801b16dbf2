"""The textbook circle maps by formula: each function gives a lift, its derivative and its form for one float."""

from __future__ import annotations

from cmath import phase
from math import atan2, cos, sin
from typing import Any

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import finite_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.lifts.lift_checks import Lift, Scalar

Forms = tuple[Lift, Lift, Scalar]


def rigid_rotation(turns: float) -> Forms:
    """θ → θ + 2π·turns.

    >>> round(rigid_rotation(0.25)[2](0.0), 6)
    1.570796
    """
    shift = TWO_PI * finite_number("turns", turns)
    return lambda x: x + shift, np.ones_like, lambda x: x + shift


def sine_map(omega: float, K: float) -> Forms:
    """θ → θ + 2πΩ - K sin θ (Arnold 1965).

    >>> sine_map(0.0, 0.5)[2](0.0)
    0.0
    """
    shift, strength = TWO_PI * finite_number("omega", omega), finite_number("K", K)
    return (
        lambda x: x + shift - strength * np.sin(x),
        lambda x: 1.0 - strength * np.cos(x),
        lambda x: x + shift - strength * sin(x),
    )


def moebius_transformation(a: float, omega: float) -> Forms:
    """z → e^{2πiΩ}(z - a)/(1 - a z) with 0 ≤ a < 1 on the unit circle.

    >>> round(float(moebius_transformation(0.5, 0.0)[1](np.zeros(1))[0]), 12)
    3.0
    """
    shift, r = TWO_PI * finite_number("omega", omega), finite_number("a", a)
    if not 0.0 <= r < 1.0:
        raise InvalidInput(f"a is {r:g}: a Möbius map of the circle needs 0 <= a < 1; blaschke takes any |a| < 1")
    # As in _product, without its loop: this map is the one that orbits are followed for.
    double, gap, top = 2.0 * r, 1.0 - r, (1.0 - r) * (1.0 + r)
    return (
        lambda x: x + shift + 2.0 * np.arctan2(double * (s := np.sin(0.5 * x)) * np.cos(0.5 * x), gap + double * s * s),
        lambda x: top / (gap * gap + 2.0 * double * np.sin(0.5 * x) ** 2),
        lambda x: x + shift + 2.0 * atan2(double * (s := sin(0.5 * x)) * cos(0.5 * x), gap + double * s * s),
    )


def blaschke_zeros(zeros: Any) -> tuple[complex, ...]:
    """The zeros of a finite Blaschke product, checked: one or more complex numbers with |a| < 1.

    >>> blaschke_zeros([0.5, 0.2j])
    ((0.5+0j), 0.2j)
    """
    try:
        given = np.asarray(zeros, dtype=np.complex128)
    except (TypeError, ValueError) as cause:
        raise InvalidInput(f"zeros must hold complex numbers only, not {zeros!r}") from cause
    if given.ndim != 1 or given.size == 0:
        raise InvalidInput(f"zeros has shape {given.shape}: give a list of one complex number or more")
    outside = ~(np.abs(given) < 1.0)
    if np.any(outside):
        entry = int(np.argmax(outside))
        raise InvalidInput(f"zeros[{entry}] is {given[entry]:g}: every zero must lie inside the unit circle, |a| < 1")
    return tuple(complex(a) for a in given)


def blaschke_product(zeros: tuple[complex, ...], omega: float) -> Forms:
    """z → e^{2πiΩ} Π (z - a)/(1 - conj(a) z): each factor turns z by a further -2 arg(1 - conj(a) z).

    That argument stays inside (-π/2, π/2), so the lift is kθ plus a smooth periodic part; its derivative is the
    sum of the Poisson kernels of the zeros.

    >>> float(blaschke_product((0j, 0j), 0.0)[0](np.array(1.25)))
    2.5
    """
    shift = TWO_PI * finite_number("omega", omega)
    # A zero at the origin is a factor z: it only adds θ.
    return _product(len(zeros), shift, [(abs(a), phase(a)) for a in zeros if a != 0.0])


def _product(degree: int, shift: float, zeros: list[tuple[float, float]]) -> Forms:
    """Of zeros given by radius and angle; half angles keep all digits where a zero is close to the circle."""
    k, plain = float(degree), float(degree - len(zeros))
    # 1 - r cos φ = (1 - r) + 2r sin²(φ/2), and r sin φ = 2r sin(φ/2) cos(φ/2).
    rows = [(0.5 * angle, 2.0 * r, 1.0 - r, (1.0 - r) * (1.0 + r)) for r, angle in zeros]

    def lift(x: Array) -> Array:
        value = k * x + shift
        for half, double, gap, _ in rows:
            s = np.sin(0.5 * x - half)
            value = value + 2.0 * np.arctan2(double * s * np.cos(0.5 * x - half), gap + double * s * s)
        return value

    def derivative(x: Array) -> Array:
        slope = np.full_like(x, plain)
        for half, double, gap, top in rows:
            s = np.sin(0.5 * x - half)
            slope = slope + top / (gap * gap + 2.0 * double * s * s)
        return slope

    def scalar(x: float) -> float:
        value = k * x + shift
        for half, double, gap, _ in rows:
            s = sin(0.5 * x - half)
            value += 2.0 * atan2(double * s * cos(0.5 * x - half), gap + double * s * s)
        return value

    return lift, derivative, scalar
