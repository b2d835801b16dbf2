"""Forgetting length, bias and multiplier of a leg: zero residuals, and iterates of the code's Möbius maps."""

import math

import numpy as np
import pytest
import sympy as sp

from cyclemap.maps import CircleMap
from theory import trailing_leg as theory
from theory.moebius_drag import (
    HEADING,
    LENGTH,
    LEVER,
    POINT,
    SPIN_RADIUS,
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
    """The density is the slope of the inverse leg over 2π, and the mean of e^{iψ} is a, as a residue too."""
    backwards = theory.slope((1 + A) / (1 - A)) / (2 * sp.pi)
    cosine = sp.Symbol("C", real=True)
    whole = {sp.cos(HEADING / 2) ** 2: (1 + cosine) / 2, sp.sin(HEADING / 2) ** 2: (1 - cosine) / 2}
    density = theory.density_from_uniform(A).subs(sp.cos(HEADING), cosine)
    assert sp.simplify(backwards.subs(whole) - density) == 0
    assert theory.mean_from_uniform(A) == A
    assert sp.residue(leg_of_the_lever(A) / POINT, POINT, 0) == A


def test_headings_spread_evenly_end_as_the_density_says():
    """10^5 headings through the code's Möbius map, half a turn apart from the lever's."""
    numbers = {LEVER: 0.015, SPIN_RADIUS: 0.026, LENGTH: 0.1}
    a = float(strength().subs(numbers))
    trail = np.linspace(-np.pi, np.pi, 100_000, endpoint=False)
    heading = CircleMap.moebius(a, 0.0)(trail) - np.pi
    assert abs(np.mean(np.exp(1j * heading)) - a) < 1e-12
    for tolerance in (0.2, 1.0, 2.5):
        share = np.mean(np.abs((heading + np.pi) % (2 * np.pi) - np.pi) < tolerance)
        assert abs(share - float(theory.share_within().subs({**numbers, theory.TOLERANCE: tolerance}))) < 3e-5


def test_the_forgetting_length_is_where_the_codes_map_gets_there():
    for delta, epsilon in np.random.default_rng(1).uniform(0.01, 1.0, (10, 2)):
        numbers = {LEVER: 0.015, SPIN_RADIUS: 0.026, theory.EXCLUDED: delta, theory.TOLERANCE: epsilon}
        length = float(theory.forgetting_length().subs(numbers))
        a = float(strength().subs({**numbers, LENGTH: length}))
        end = float(CircleMap.moebius(a, 0.0)(delta))
        assert abs(end - (math.pi - epsilon)) < 1e-9
