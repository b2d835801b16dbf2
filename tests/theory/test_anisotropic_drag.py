"""An ellipsoid with axes fixed in the world: the equation of motion, its quadrature and rate; it is
not Möbius.
"""

import pytest
import sympy as sp

from theory import anisotropic_drag as theory
from theory.turned_surface import spelled_out

W, GAMMA, THETA, PSI = theory.PULL, theory.PULL_ANGLE, theory.LEVER_ANGLE, theory.HEADING


@pytest.mark.slow
def test_the_spin_of_least_dissipation_is_the_one_in_terms_of_the_pull():
    pull = {
        sp.cos(theory.TOWARDS): W * sp.cos(GAMMA) / theory.P,
        sp.sin(theory.TOWARDS): W * sp.sin(GAMMA) / theory.Q,
    }
    found = theory.spin_of_least_dissipation()
    stationary = sp.diff(theory.squared_dissipation(), theory.SPIN).subs(theory.SPIN, found)
    assert spelled_out(sp.numer(sp.together(stationary))) == 0
    assert spelled_out(sp.numer(sp.together(found.subs(pull) - theory.spin()))) == 0
    bend = sp.diff(theory.squared_dissipation(), theory.SPIN, 2)
    assert spelled_out(bend - 2 * theory.inertia()) == 0


def test_the_ring_leads_along_the_pull_and_the_rate_is_the_fields_slope_there():
    slope = sp.diff(theory.spin(), THETA)
    for at, sign in ((GAMMA, 1), (GAMMA + sp.pi, -1)):
        assert sp.simplify(theory.spin().subs(THETA, at)) == 0
        assert sp.simplify(slope.subs(THETA, at) - sign * theory.trailing_rate()) == 0


def test_the_elapsed_length_is_the_integral_of_one_over_the_spin():
    logarithm = sp.log(sp.tan(PSI / 2))
    assert sp.simplify(sp.diff(logarithm, PSI) * sp.sin(PSI) - 1) == 0
    named = sp.Function("log_tan")(PSI)
    length = theory.elapsed_length().subs(logarithm, named)
    slope = sp.diff(length, PSI).subs(sp.diff(named, PSI), 1 / sp.sin(PSI))
    # 1/spin is -inertia/(r w sin ψ); both sides times that denominator.
    residual = slope * theory.LEVER * W * sp.sin(PSI) + theory.inertia().subs(THETA, PSI + GAMMA)
    assert not residual.has(named)
    assert spelled_out(sp.expand(residual)) == 0


def test_equal_axes_give_back_the_half_angle_solution():
    equal = theory.elapsed_length().subs(theory.Q, theory.P)
    kappa = theory.LEVER * W / (theory.SPIN_TERM + theory.LEVER**2 * theory.P)
    assert sp.simplify(equal + sp.log(sp.tan(PSI / 2)) / kappa) == 0


def test_a_moebius_flow_would_need_a_third_harmonic_that_the_spin_does_not_have():
    _, cosine, sine = sp.symbols("alpha beta delta", real=True)
    third = theory.LEVER**2 * (theory.Q - theory.P) * (cosine - sp.I * sine) / 8
    assert sp.simplify(theory.moebius_field_times_inertia(3) - third) == 0
    free = {cosine: 0, sine: 0}
    assert theory.moebius_field_times_inertia(1).subs(free) == 0
    pull = theory.LEVER * W * sp.sin(THETA - GAMMA)
    assert sp.simplify(theory.spin() * theory.inertia() + pull) == 0
