"""Closed torques of square, rectangle, regular polygon and disc: proved, and the code's."""

import math

import numpy as np
import pytest
import sympy as sp
from scipy.special import ellipe

from cyclemap.mechanics import (
    Ellipse,
    EllipseFriction,
    LimitSurface,
    PatchFootprint,
    Polygon,
    corner_footprint,
)
from theory import square_torque as theory

SPIN = (0.0, 0.0, 3.0)


def torque(footprint, friction):
    return float(LimitSurface(footprint, friction).wrench(SPIN)[2])


def rectangle(a, b):
    return Polygon(((-a / 2, -b / 2), (a / 2, -b / 2), (a / 2, b / 2), (-a / 2, b / 2)))


def regular(count, radius):
    corner = radius * np.exp(2j * np.pi * np.arange(count) / count)
    return Polygon(tuple(zip(corner.real.tolist(), corner.imag.tolist(), strict=True)))


def test_the_codes_square_and_rectangles_have_the_derived_torque_to_rounding():
    rng = np.random.default_rng(0)
    of_rectangle = sp.lambdify((theory.MU, theory.A, theory.B), theory.rectangle_torque())
    for mu, a, b in rng.uniform((0.1, 0.02, 0.02), (0.6, 0.2, 0.2), (20, 3)):
        friction = EllipseFriction.isotropic(mu)
        square = float(theory.square_torque(sp.Float(mu), sp.Float(a)))
        for sides, derived in (((a, a), square), ((a, b), of_rectangle(mu, a, b))):
            found = torque(PatchFootprint(rectangle(*sides)), friction)
            assert abs(found / derived - 1.0) < 1e-13


def test_the_integrals_of_the_secant_start_at_zero():
    assert theory.secant_cubed_integral(sp.Integer(0)) == 0
    assert sp.asinh(sp.tan(0)) == 0


@pytest.mark.parametrize("count", [3, 4, 5, 6, 17])
def test_the_codes_regular_polygons_have_the_derived_torque(count):
    derived = float(theory.polygon_torque(count).subs({theory.MU: 0.3, theory.R: 0.06}))
    found = torque(PatchFootprint(regular(count, 0.06)), EllipseFriction.isotropic(0.3))
    assert abs(found / derived - 1.0) < 1e-13


@pytest.mark.slow
def test_regular_polygons_approach_the_disc_with_the_second_order_of_the_series():
    x, disc = sp.Symbol("x", positive=True), theory.disc_torque()
    assert sp.expand(theory.polygon_series() - disc * (1 - x**2 / 3)) == 0
    exact = torque(PatchFootprint(Ellipse(0.06, 0.06)), EllipseFriction.isotropic(0.3))
    assert abs(exact / (2.0 / 3.0 * 0.3 * 0.06) - 1.0) < 1e-13
    lacking = []
    for count in (12, 48):
        polygon = PatchFootprint(regular(count, 0.06))
        lacking.append(1.0 - torque(polygon, EllipseFriction.isotropic(0.3)) / exact)
    assert abs(lacking[1] / (math.pi**2 / (3 * 48**2)) - 1.0) < 0.01
    assert abs(lacking[0] / lacking[1] - 16.0) < 0.5


def test_weight_on_the_rim_and_on_the_corners_raises_the_torque_as_derived():
    """Weight nearer the rim resists turning more: patch < line of the rim (3/2) < corners."""
    friction, outline = EllipseFriction.isotropic(0.25), rectangle(0.09, 0.09)
    patch = torque(PatchFootprint(outline), friction)
    rim = torque(PatchFootprint(outline, rim_share=1.0), friction)
    assert abs(rim / (1.5 * patch) - 1.0) < 1e-12
    for corners in (corner_footprint(outline), PatchFootprint(outline, corner_share=1.0)):
        assert abs(torque(corners, friction) / (0.25 * 0.09 / math.sqrt(2.0)) - 1.0) < 1e-13
    assert 1.5 * patch < torque(corner_footprint(outline), friction)


def test_a_disc_under_an_ellipse_has_the_torque_of_the_complete_elliptic_integral():
    axes = sp.symbols("a b")
    known = [{"elliptic_e": ellipe}, "numpy"]
    derived = sp.lambdify((theory.R, *axes), theory.anisotropic_disc_torque(*axes), known)
    cases = np.random.default_rng(1).uniform((0.1, 0.1, 0.02), (0.6, 0.6, 0.2), (20, 3))
    for mu_a, mu_b, radius in cases:
        disc = PatchFootprint(Ellipse(radius, radius))
        found = torque(disc, EllipseFriction(mu_a, mu_b, phi=0.4))
        assert abs(found / derived(radius, mu_a, mu_b) - 1.0) < 1e-12
