"""Contacts that are pressed: the cones' formula is proved and equal to the code's friction; and what
shapes of plate and floor do to the map under isotropic friction.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

import cyclemap as cm
from cyclemap.mechanics import (
    EllipseFriction,
    LimitSurface,
    Material,
    Polygon,
    PressedFootprint,
    SurfaceShape,
)
from cyclemap.mechanics.cycle_batch import run_batch
from theory import pressed_contact as contact, pressed_symmetry as symmetry

X, Y = contact.W_X, contact.W_Y
SPEED = contact.speed()
HESSIAN = [sp.diff(SPEED, *pair) for pair in ((X, X), (X, Y), (Y, Y))]
TERMS = [SPEED, sp.diff(SPEED, X), sp.diff(SPEED, Y), *HESSIAN]
# In x and y alike: of two that differ by their names one.
PRESSURES = [sp.Integer(1), X, X**2, X * Y]


@pytest.mark.slow
@pytest.mark.parametrize("pressure", PRESSURES)
def test_a_cone_holds_a_power_of_its_length(pressure):
    for term in TERMS:
        assert contact.cone_residual(pressure, term) == 0


def test_cones_of_dissipation_force_and_hessian_have_the_codes_shares():
    found = [[contact.cone_share(degree, power) for power in range(3)] for degree in (1, 0, -1)]
    assert found == [[sp.Rational(1, k + j) for j in range(3)] for k in (3, 2, 1)]


@pytest.mark.parametrize("degree", [1, -1, -3])
def test_what_a_straight_side_adds_is_in_closed_form(degree):
    for power in range(3 if degree == 1 else 4):
        assert contact.side_residual(power, degree) == 0


def test_along_an_arc_the_swept_area_is_a_quadratic_over_a_square():
    first, middle, last = (sp.symbols(f"{name}_x {name}_y", real=True) for name in "acb")
    assert contact.swept_residual(first, middle, last) == 0


def test_the_rim_moves_without_a_load():
    assert contact.moving_rim_residual() == 0


def test_the_codes_dissipation_is_the_cones_sum_over_a_disc_that_is_pressed():
    """A dome that rests in the middle: p = 2/(pi a^2) (1 - r^2/a^2), whose rim is four quarter
    arcs.
    """
    square = Polygon(((0.045, 0.045), (-0.045, 0.045), (-0.045, -0.045), (0.045, -0.045)))
    footprint = PressedFootprint(square, SurfaceShape(-20.0))
    # Its volume is the load: the mean pressure times the square's area.
    radius = (2.0 * 0.09**2 / (math.pi * 20.0 / 0.05**2)) ** 0.25
    vx, vy, omega = 0.02, 0.01, 1.5
    place = sp.lambdify(
        (contact.S, contact.WEIGHT), list(contact.arc_place((1, 0), (1, 1), (0, 1)))
    )
    swept = sp.lambdify((contact.S, contact.WEIGHT), contact.swept_area((1, 0), (1, 1), (0, 1)))
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


LOOP = cm.CollectionLoop.mit(material="isotropic", accuracy=1e-9)
THETA = np.arange(16) * 2.0 * math.pi / 16


def harmonics(loop):
    """Size of each harmonic of the turn of a cycle, rad."""
    turn = run_batch((loop,), THETA[None]).theta_next[0] - THETA
    return np.abs(np.fft.rfft(turn)) / len(turn)


def on_floor(bow, loop=LOOP):
    floor = SurfaceShape(0.0, bow, 0.3)
    return replace(loop, footprint=PressedFootprint(loop.slider.outline, floor=floor))


def test_the_floor_turns_against_the_plate_by_its_bow_alone():
    assert symmetry.turned_bow_residual() == 0
    assert symmetry.half_turn_residual() == 0
    assert symmetry.turned_floor_residual() == 0
    assert not symmetry.shapes_without_bow().has(symmetry.THETA)


def test_a_bow_adds_the_second_harmonic_and_the_offset_the_first():
    responses = sp.symbols("u v", real=True)
    assert set(symmetry.first_order_harmonics(*responses)) == {2}
    assert set(symmetry.offset_harmonics(*responses)) == {1}


def test_three_supports_bear_what_balance_asks_for():
    loads = symmetry.loads_of_three_supports()
    assert not any(symbol.name.startswith("q") for symbol in loads.free_symbols)
    shapes = {
        symbol
        for symbol in symmetry.level_of_three_supports().free_symbols
        if symbol.name.startswith("q")
    }
    assert len(shapes) == 3


def test_the_codes_map_has_a_second_harmonic_that_grows_with_the_bow_and_a_fourth_with_its_square():
    # Bows that leave all of the plate in contact.
    small, twice = harmonics(on_floor(0.04)), harmonics(on_floor(0.08))
    assert np.all(small[1::2] < 1e-8) and np.all(twice[1::2] < 1e-8)
    assert abs(twice[2] / small[2] - 2.0) < 0.002
    assert abs(twice[4] / small[4] - 4.0) < 0.01


def test_an_offset_adds_a_first_harmonic_in_its_own_proportion_whatever_the_bow():
    first = []
    for share in (1.0, 2.0):
        law = EllipseFriction.isotropic(LOOP.material.friction.mu_a)
        law = replace(law, m0=0.002 * share, n0=0.001 * share)
        offset = replace(LOOP, material=Material("offset", law))
        found = harmonics(on_floor(0.04, offset))
        first.append(found[1])
        assert abs(found[1] / harmonics(offset)[1] - 1.0) < 0.02
        # What it adds to the others goes with its square.
        assert abs(found[2] / harmonics(on_floor(0.04))[2] - 1.0) < 0.06 * share**2
        assert found[3] < 0.01 * share**2 * found[2]
    assert abs(first[1] / first[0] - 2.0) < 0.01
