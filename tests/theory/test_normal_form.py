"""The normal form follows from symmetry alone, and the code's fingerprint has it."""

import math
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from cyclemap.collection import Anisotropy, Fingerprint, Prediction, TurnResponse
from cyclemap.collection.fingerprint_prediction import first_order_lock_in
from cyclemap.mechanics import EllipseFriction
from theory import normal_form as theory
from theory.plane_rotation import rotation

VALUES = {theory.MU_A: 0.3, theory.MU_B: 0.2, theory.M0: 0.04, theory.N0: -0.03, theory.PHI: 0.7}


def zero(expression) -> bool:
    return sp.simplify(sp.expand_trig(sp.expand(expression))) == 0


def made_prediction(
    turn: float, offset: float, ellipticity: float, gradient, psi: float, phi: float
) -> Prediction:
    nothing = TurnResponse(0.0, np.zeros(4), np.zeros((4, 4)))
    fingerprint = Fingerprint(replace(nothing, turn=turn, gradient=gradient), nothing, 0.0, 0.0)
    return Prediction(fingerprint, Anisotropy(offset, psi, ellipticity, phi))


@pytest.mark.slow
def test_turning_the_surface_turns_the_offset_once_and_the_ellipticity_twice() -> None:
    turned = {theory.PHI: theory.PHI + theory.ALPHA}
    offset, ellipticity = theory.offset_vector(), theory.ellipticity_vector()
    shape = theory.shape_logarithm()
    once, twice = rotation(theory.ALPHA), rotation(2 * theory.ALPHA)
    residuals = [
        *(offset.subs(turned) - once * offset),
        *(ellipticity.subs(turned) - twice * ellipticity),
        *(shape.subs(turned) - once * shape * once.T),
    ]
    assert len(residuals) == 8 and all(zero(residual) for residual in residuals)


def test_the_codes_anisotropy_is_the_theorys_offset_and_ellipticity() -> None:
    """At a random ellipse, seen from the surface's own axes."""
    expected = [*theory.offset_vector().subs(VALUES), *theory.ellipticity_vector().subs(VALUES)]
    seen = Anisotropy.of(EllipseFriction(0.3, 0.2, 0.04, -0.03, 0.7)).seen_from(0.0)
    assert seen == pytest.approx([float(value) for value in expected], abs=1e-15)


def test_first_order_is_one_harmonic_each_so_that_five_numbers_suffice() -> None:
    """A constant, a pure first harmonic and a pure second one: 1 + 2 + 2 real coefficients."""
    assert theory.harmonics(1, 0) == {1: 2} and theory.harmonics(0, 1) == {2: 2}
    assert 1 + sum(theory.harmonics(1, 0).values()) + sum(theory.harmonics(0, 1).values()) == 5


def test_second_order_has_harmonics_0_2_then_1_3_then_0_4_with_ten_numbers() -> None:
    content = [theory.harmonics(*degrees) for degrees in ((2, 0), (1, 1), (0, 2))]
    assert content == [{0: 1, 2: 2}, {1: 2, 3: 2}, {0: 1, 4: 2}]
    assert sum(sum(part.values()) for part in content) == 10


@pytest.mark.slow
@pytest.mark.parametrize("order", [1, 2])
def test_the_response_is_equivariant_and_holds_one_harmonic(order) -> None:
    """R(θ + α) T(α) = R(θ) for every α, and R'' = -order² R."""
    response = theory.response(order)
    turned = response.subs(theory.THETA, theory.THETA + theory.ALPHA)
    turned *= rotation(order * theory.ALPHA)
    oscillates = response.diff(theory.THETA, 2) + order**2 * response
    assert all(zero(entry) for entry in [*(turned - response), *oscillates])


def test_dissipation_is_homogeneous_so_that_the_scale_of_friction_drops_out_of_the_motion() -> None:
    """By Euler's identity."""
    law = theory.dissipation(sp.Matrix(sp.symbols("v_x v_y", real=True)))
    scales = (theory.MU_A, theory.MU_B, theory.M0, theory.N0)
    assert sp.simplify(sum(one * sp.diff(law, one) for one in scales) - law) == 0


def test_other_measures_of_the_ellipse_differ_at_third_order_only() -> None:
    v = sp.Symbol("v")
    ratios = [sp.series(ratio, v, 0, 4).removeO() for ratio in theory.ellipticity_ratios()]
    assert len(ratios) == 3
    for ratio in ratios:
        assert ratio.subs(v, 0) == 1 and ratio.coeff(v, 1) == 0 and ratio.coeff(v, 2) != 0


def test_the_offset_alone_has_its_fixed_points_in_closed_form() -> None:
    """Symbolically, and against the fixed points that are found of the map."""
    x, y = sp.symbols("X Y", nonnegative=True)
    psi, delta_1 = sp.symbols("psi delta_1", real=True)
    turn = theory.first_order_turn().subs(y, 0)
    for angle, multiplier in theory.offset_fixed_points():
        place = {theory.THETA: angle.subs(sp.Symbol("X", positive=True), x) + psi + delta_1}
        assert sp.simplify(turn.subs(place)) == 0
        slope = 1 + sp.diff(turn, theory.THETA).subs(place)
        for numbers in ({theory.OMEGA: 0.1, x: 0.3}, {theory.OMEGA: -0.2, x: 0.25}):
            known = multiplier.subs(sp.Symbol("X", positive=True), x)
            assert float((slope - known).subs(numbers)) == pytest.approx(0.0, abs=1e-14)
    prediction = made_prediction(0.1, 0.15, 0.0, [2.0, 0.0, 0.0, 0.0], psi=0.4, phi=0.0)
    found = {direction.stable: direction for direction in prediction.directions}
    assert len(found) == 2
    numbers = {theory.OMEGA: 0.1, sp.Symbol("X", positive=True): 0.3}
    for stable, pair in zip((True, False), theory.offset_fixed_points(), strict=True):
        angle, multiplier = (float(value.subs(numbers)) for value in pair)
        assert found[stable].theta == pytest.approx((angle + 0.4) % (2 * math.pi), abs=1e-9)
        assert found[stable].orbit.multiplier == pytest.approx(multiplier, abs=1e-9)


@pytest.mark.slow
def test_the_saddle_node_curve_solves_both_equations_and_is_the_lock_in_that_the_code_finds() -> (
    None
):
    s, chi = sp.symbols("s chi", real=True)
    x, y = theory.lock_in_curve()
    turn = theory.OMEGA + x * sp.cos(s) + y * sp.cos(2 * s - chi)
    slope = x * sp.sin(s) + 2 * y * sp.sin(2 * s - chi)
    assert sp.simplify(turn) == 0 and sp.simplify(slope) == 0
    curve = sp.lambdify((s, chi, theory.OMEGA), (x, y))
    found = 0
    for angle, shift in zip(np.linspace(2.0, 4.2, 12), np.linspace(0.3, 5.9, 12), strict=True):
        along, across = curve(angle, shift, 0.1)
        over = 0.1 + along * np.cos(ANGLES) + across * np.cos(2 * ANGLES - shift)
        if min(along, across) < 0.0 or over.min() < -1e-6:
            continue
        # Ellipse amplitude 1 with δ₂ = 0, offset amplitude 1 with δ₁ = 0 and ψ = 0: χ = 2φ.
        ways = {"gradient": [1.0, 0.0, 1.0, 0.0], "psi": 0.0, "phi": 0.5 * shift}
        prediction = made_prediction(0.1, along, across, **ways)
        lock_in = first_order_lock_in(prediction.fingerprint.cycle, prediction.anisotropy)
        assert lock_in.scale == pytest.approx(1.0, abs=1e-12)
        assert lock_in.theta == pytest.approx(angle, abs=1e-6)
        found += 1
    assert found >= 3


ANGLES = np.linspace(0.0, 2.0 * math.pi, 2001)
