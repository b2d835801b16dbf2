"""The cones' formula of a contact that is pressed: proved, and equal to the code's friction."""

import math

import numpy as np
import pytest
import sympy as sp

from cyclemap.mechanics import (
    EllipseFriction,
    LimitSurface,
    Polygon,
    PressedFootprint,
    SurfaceShape,
)
from theory import pressed_contact as theory

X, Y = theory.W_X, theory.W_Y
SPEED = theory.speed()
HESSIAN = [sp.diff(SPEED, *pair) for pair in ((X, X), (X, Y), (Y, Y))]
TERMS = [SPEED, sp.diff(SPEED, X), sp.diff(SPEED, Y), *HESSIAN]
# In x and y alike: of two that differ by their names one.
PRESSURES = [sp.Integer(1), X, X**2, X * Y]


@pytest.mark.slow
@pytest.mark.parametrize("pressure", PRESSURES)
def test_a_cone_holds_a_power_of_its_length(pressure):
    for term in TERMS:
        assert theory.cone_residual(pressure, term) == 0


def test_cones_of_dissipation_force_and_hessian_have_the_codes_shares():
    found = [[theory.cone_share(degree, power) for power in range(3)] for degree in (1, 0, -1)]
    assert found == [[sp.Rational(1, k + j) for j in range(3)] for k in (3, 2, 1)]


@pytest.mark.parametrize("degree", [1, -1, -3])
def test_what_a_straight_side_adds_is_in_closed_form(degree):
    for power in range(3 if degree == 1 else 4):
        assert theory.side_residual(power, degree) == 0


def test_along_an_arc_the_swept_area_is_a_quadratic_over_a_square():
    first, middle, last = (sp.symbols(f"{name}_x {name}_y", real=True) for name in "acb")
    assert theory.swept_residual(first, middle, last) == 0


def test_the_rim_moves_without_a_load():
    assert theory.moving_rim_residual() == 0


def test_the_codes_dissipation_is_the_cones_sum_over_a_disc_that_is_pressed():
    """A dome that rests in the middle: p = 2/(pi a^2) (1 - r^2/a^2), whose rim is four quarter
    arcs.
    """
    square = Polygon(((0.045, 0.045), (-0.045, 0.045), (-0.045, -0.045), (0.045, -0.045)))
    footprint = PressedFootprint(square, SurfaceShape(-20.0))
    # Its volume is the load: the mean pressure times the square's area.
    radius = (2.0 * 0.09**2 / (math.pi * 20.0 / 0.05**2)) ** 0.25
    vx, vy, omega = 0.02, 0.01, 1.5
    place = sp.lambdify((theory.S, theory.WEIGHT), list(theory.arc_place((1, 0), (1, 1), (0, 1))))
    swept = sp.lambdify((theory.S, theory.WEIGHT), theory.swept_area((1, 0), (1, 1), (0, 1)))
    node, weight = np.polynomial.legendre.leggauss(40)
    share = (1 + node) / 2
    centre, total = np.array((-vy, vx))[:, None] / omega, 0.0
    for quarter in range(4):
        c, s = math.cos(quarter * math.pi / 2), math.sin(quarter * math.pi / 2)
        x, y = place(share, math.sqrt(0.5))
        rim = radius * np.array((c * x - s * y, s * x + c * y))
        # Cones from the centre of rotation, along which P and |w| are powers. On a circle r x dr is
        # r^2 dphi, and dr = z x r dphi.
        area = swept(share, math.sqrt(0.5)) * (radius**2 - np.sum(centre * rim, axis=0))
        lever = rim - centre
        level = 1 - np.sum(centre**2) / radius**2
        slope = -2 * np.sum(centre * lever, axis=0) / radius**2
        bend = -np.sum(lever**2, axis=0) / radius**2
        speed = omega * np.hypot(*lever)
        total += np.sum(weight / 2 * area * speed * (level / 3 + slope / 4 + bend / 5))
    expected = 2.0 / (math.pi * radius**2) * total
    surface = LimitSurface(footprint, EllipseFriction(1.0, 1.0))
    assert float(surface.dissipation((vx, vy, omega))) == pytest.approx(expected, rel=1e-10)
