"""The ellipsoid's drag: every residual is zero in symbols, and the code's own maps and minimisers
agree.
"""

import math

import numpy as np
import pytest
import sympy as sp

from cyclemap.maps import CircleMap
from cyclemap.mechanics import Ellipse, EllipseFriction, Pose, QuasiStaticModel, Slider
from theory import moebius_drag as theory

Z, R, C, ELL, PSI = theory.POINT, theory.LEVER, theory.SPIN_RADIUS, theory.LENGTH, theory.HEADING
A, B = sp.symbols("a b", positive=True)


def test_the_spin_makes_the_dissipation_stationary_and_it_is_its_only_minimum():
    squared, spin = theory.squared_dissipation(), theory.spin_of_least_dissipation()
    assert sp.simplify(sp.diff(squared, theory.SPIN).subs(theory.SPIN, spin)) == 0
    assert sp.simplify(sp.diff(squared, theory.SPIN, 2) - 2 * (R**2 + C**2)) == 0
    assert sp.simplify(spin + theory.rate() * sp.sin(PSI)) == 0


def test_the_half_angle_solution_satisfies_the_equation_of_motion_and_the_start():
    """d tan(ψ/2)/dℓ = (1 + tan²(ψ/2))/2 · dψ/dℓ, with sin ψ = 2 tan/(1 + tan²)."""
    tangent = theory.half_angle_tangent()
    sine = 2 * tangent / (1 + tangent**2)
    assert sp.simplify(sp.diff(tangent, ELL) - (1 + tangent**2) / 2 * (-theory.rate() * sine)) == 0
    assert sp.simplify(tangent.subs(ELL, 0) - sp.tan(PSI / 2)) == 0


def test_the_moebius_map_is_the_half_angle_solution():
    """With t = tan(ψ/2), z = (1 + it)/(1 - it);
    the leg multiplies t by e^{-κℓ} = (1 - a)/(1 + a)."""
    t = sp.Symbol("t", real=True)
    image = theory.leg_of_the_lever(A).subs(Z, (1 + sp.I * t) / (1 - sp.I * t))
    shrunk = t * (1 - A) / (1 + A)
    assert sp.simplify(image - (1 + sp.I * shrunk) / (1 - sp.I * shrunk)) == 0
    x = sp.Symbol("x", positive=True)
    half = sp.tanh(x / 2)
    assert sp.simplify(((1 - half) / (1 + half)).rewrite(sp.exp) - sp.exp(-x)) == 0


@pytest.mark.slow
def test_legs_add_and_turned_legs_multiply_their_matrices():
    legs = theory.leg_of_the_lever(B).subs(Z, theory.leg_of_the_lever(A))
    assert sp.simplify(legs - theory.leg_of_the_lever(theory.strength_of_two(A, B))) == 0
    x, y = sp.symbols("x y", positive=True)
    added = theory.strength_of_two(sp.tanh(x / 2), sp.tanh(y / 2)) - sp.tanh((x + y) / 2)
    assert sp.simplify(added.rewrite(sp.exp)) == 0
    u, v = sp.symbols("u v", real=True)
    one, two = theory.turned_leg(A, u), theory.turned_leg(B, v)
    m = theory.matrix_of_leg(B, v) * theory.matrix_of_leg(A, u)
    assert sp.simplify(two.subs(Z, one) - (m[0, 0] * Z + m[0, 1]) / (m[1, 0] * Z + m[1, 1])) == 0


def test_a_bent_path_is_one_moebius_map_with_the_strength_of_the_product():
    """The slope of a Möbius map runs from (1 - a)/(1 + a) to its inverse; the legs are the code's
    maps, turned.
    """
    legs = ((0.4, 0.3), (0.7, 2.0), (0.2, -1.1))
    start = np.linspace(-np.pi, np.pi, 200_001)
    matrix, lever, slope = sp.eye(2), start, 1.0
    for a, direction in legs:
        leg = CircleMap.moebius(a, 0.0)
        trail = lever - direction - np.pi
        slope = slope * leg.derivative(trail)
        lever = leg(trail) + direction + np.pi
        matrix = theory.matrix_of_leg(a, direction) * matrix
    whole = abs(complex(theory.strength_of_path(matrix)))
    assert abs(slope.max() / ((1.0 + whole) / (1.0 - whole)) - 1.0) < 1e-7
    assert abs(slope.min() / ((1.0 - whole) / (1.0 + whole)) - 1.0) < 1e-7
    mapped = sp.lambdify(Z, (matrix[0, 0] * Z + matrix[0, 1]) / (matrix[1, 0] * Z + matrix[1, 1]))
    assert np.abs(mapped(np.exp(1j * start)) - np.exp(1j * lever)).max() < 1e-12


def test_the_trails_map_is_the_codes_moebius_map():
    image = sp.lambdify((Z, A), theory.leg_of_the_trail(A))
    rng = np.random.default_rng(1)
    angle, strength = rng.uniform(-np.pi, np.pi, 50), rng.uniform(0.0, 0.99, 50)
    for chi, a in zip(angle, strength, strict=True):
        assert abs(image(np.exp(1j * chi), a) - np.exp(1j * CircleMap.moebius(a, 0.0)(chi))) < 1e-14


@pytest.mark.parametrize(
    ("outline", "second_moment"),
    [(Ellipse(0.05, 0.05), 0.05**2 / 4), (Slider.mit("rect1").outline, 0.09**2 / 12)],
)
def test_a_disc_and_a_square_turn_less_than_their_ellipsoid_by_up_to_twelve_degrees(
    outline, second_moment
):
    """c² is the pressure's second moment, so that short headings agree: no exact footprint is an
    ellipsoid.
    """
    slider = Slider(outline)
    model = QuasiStaticModel(slider, EllipseFriction.isotropic(0.25))
    after = sp.lambdify((PSI, R, C, ELL), theory.heading_after())
    lever, base = math.hypot(*slider.hitch), math.atan2(slider.hitch[1], slider.hitch[0])
    lag = []
    for psi in (0.01, 0.5, 1.5, 2.5):
        pose = Pose(0.0, 0.0, psi - base)
        x, y = pose.to_world(*model.slider.hitch)
        end = model.drag(pose, ((x + 0.1, y),)).end.theta + base
        lag.append(math.degrees(end - after(psi, lever, math.sqrt(second_moment), 0.1)))
    assert abs(lag[0]) < 1e-5
    assert all(0.04 < one < 12.0 for one in lag[1:])
    assert max(lag) > 9.0
