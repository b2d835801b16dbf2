"""Turning the surface conjugates the cycle map: in symbols, and in the code's cycles, slopes and
fixed points.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from cyclemap.collection import CollectionLoop
from cyclemap.mechanics import DragBack, EllipseFriction, Material, load_material
from theory import turned_surface as theory

PLYWOOD = load_material("plywood").friction
STRONG = EllipseFriction(0.35, 0.18, 0.05, -0.03, 0.7)


def loop_on(law, way_points=()):
    return CollectionLoop.mit(
        material=Material("test", law), accuracy=1e-9, reset=DragBack(way_points)
    )


def test_the_support_function_is_the_codes():
    symbols = (theory.MU_A, theory.MU_B, theory.M0, theory.N0, theory.PHI, theory.THETA)
    symbols += (theory.VELOCITY_X, theory.VELOCITY_Y, theory.SPIN, theory.POINT_X, theory.POINT_Y)
    point = sp.lambdify(symbols, theory.dissipation_of_a_point(theory.THETA, theory.PHI))
    for theta, vx, vy, spin, x, y in np.random.default_rng(1).normal(size=(20, 6)):
        law = (STRONG.mu_a, STRONG.mu_b, STRONG.m0, STRONG.n0, STRONG.phi)
        code = STRONG.dissipation((vx - spin * y, vy + spin * x), frame=theta)
        assert abs(point(*law, theta, vx, vy, spin, x, y) - code) < 1e-14


@pytest.mark.parametrize("law", [PLYWOOD, STRONG], ids=["plywood", "strong"])
def test_the_codes_cycle_is_conjugate_with_and_without_turned_way_points(law):
    for theta, angle in np.random.default_rng(3).uniform(-3, 3, (3, 2)):
        c, s = math.cos(angle), math.sin(angle)
        for points in ((), ((0.1, 0.02), (-0.05, 0.1))):
            turned = tuple((c * x - s * y, s * x + c * y) for x, y in points)
            there = loop_on(law.turned(angle), turned).cycle(theta + angle).theta_next
            assert abs(there - angle - loop_on(law, points).cycle(theta).theta_next) < 1e-8


def test_iterates_of_the_turned_map_are_turned_iterates():
    f = sp.Function("f")
    wanted = theory.THETA
    for count in range(1, 5):
        wanted = f(wanted)
        assert theory.turned_iterate(count) - theory.TURN - wanted == 0
    slope = sp.diff(theory.turned_iterate(3), theory.THETA) - sp.diff(wanted.args[0], theory.THETA)
    assert slope == 0


def test_the_infinitesimal_identity_holds_in_the_codes_sensitivities():
    """∂f/∂θ + ∂f/∂φ = 1 at every orientation, to rounding, and so dθ*/dφ = (∂f/∂φ)/(1 - ∂f/∂θ) =
    1."""
    f = sp.Function("f")(theory.THETA, theory.PHI)
    derived = theory.infinitesimal_identity().doit()
    assert derived - (sp.diff(f, theory.THETA) + sp.diff(f, theory.PHI) - 1) == 0
    for law in (PLYWOOD, STRONG):
        loop = loop_on(law)
        for theta in np.random.default_rng(4).uniform(-3, 3, 4):
            found = loop.sensitivity(theta, ("theta", "phi"))
            assert abs(found.by("theta") + found.by("phi") - 1.0) < 1e-12
            assert abs(found.by("phi")) > 1e-3


def test_fixed_way_points_break_the_conjugacy():
    loop = replace(loop_on(PLYWOOD), reset=DragBack(((0.1, 0.02),)))
    other = replace(loop_on(PLYWOOD.turned(1.0)), reset=DragBack(((0.1, 0.02),)))
    assert abs(other.cycle(1.5).theta_next - 1.0 - loop.cycle(0.5).theta_next) > 0.01
