"""Forgetting length, bias and multiplier of a leg: zero residuals, and iterates of the code's
Möbius maps.
"""

import pytest
import sympy as sp

from theory import trailing_leg as theory
from theory.moebius_drag import (
    HEADING,
    LENGTH,
    POINT,
    half_angle_tangent,
    heading_after,
    leg_of_the_lever,
    strength,
)

A = sp.Symbol("a", positive=True)


def test_the_multiplier_is_the_slope_at_the_trailing_heading():
    m = theory.multiplier()
    assert sp.simplify(theory.slope(m).subs(HEADING, 0) - m) == 0
    assert sp.simplify(theory.slope(m).subs(HEADING, sp.pi) - 1 / m) == 0
    assert sp.simplify((m - (1 - strength()) / (1 + strength())).rewrite(sp.exp)) == 0


@pytest.mark.slow
def test_the_slope_is_the_derivative_of_the_closed_form():
    assert sp.simplify(sp.diff(heading_after(), HEADING) - theory.slope(theory.multiplier())) == 0


def test_after_the_forgetting_length_the_last_allowed_heading_is_at_the_tolerance():
    start = sp.pi - theory.EXCLUDED
    reached = half_angle_tangent().subs(LENGTH, theory.forgetting_length()).subs(HEADING, start)
    residual = reached - sp.tan(theory.TOLERANCE / 2)
    assert sp.simplify(residual.rewrite(sp.tan)) == 0


def test_the_share_within_is_that_of_the_headings_which_end_on_the_tolerance():
    edge = sp.pi * theory.share_within()
    reached = half_angle_tangent().subs(HEADING, edge)
    assert sp.simplify(reached - sp.tan(theory.TOLERANCE / 2)) == 0


def test_a_uniform_heading_becomes_wrapped_cauchy():
    """The density is the slope of the inverse leg over 2π, and the mean of e^{iψ} is a, as a
    residue too.
    """
    backwards = theory.slope((1 + A) / (1 - A)) / (2 * sp.pi)
    cosine = sp.Symbol("C", real=True)
    whole = {sp.cos(HEADING / 2) ** 2: (1 + cosine) / 2, sp.sin(HEADING / 2) ** 2: (1 - cosine) / 2}
    density = theory.density_from_uniform(A).subs(sp.cos(HEADING), cosine)
    assert sp.simplify(backwards.subs(whole) - density) == 0
    assert theory.mean_from_uniform(A) == A
    assert sp.residue(leg_of_the_lever(A) / POINT, POINT, 0) == A
