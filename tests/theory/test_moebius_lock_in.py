"""A Möbius cycle: rotation number, lock-in, multiplier and square-root law in symbols, and by the
code's own route.
"""

import numpy as np
import pytest
import sympy as sp

from cyclemap.maps import CircleMap, fixed_points, rotation_number, slow_passages
from theory import moebius_lock_in as theory
from theory.moebius_drag import POINT

A, OMEGA, CHI, ETA = theory.STRENGTH, theory.TURNS, theory.ANGLE, theory.EXCESS


def test_the_matrix_is_that_of_the_map_and_its_eigenvalues_give_the_rotation():
    m = theory.cycle_matrix()
    mapped = (m[0, 0] * POINT + m[0, 1]) / (m[1, 0] * POINT + m[1, 1])
    assert sp.simplify(mapped - theory.cycle_map()) == 0
    assert sp.simplify(m.det() - 1) == 0
    half, root = theory.half_trace(), sp.Symbol("x")
    characteristic = m.charpoly(root).as_expr()
    assert sp.simplify(characteristic - (root**2 - 2 * half * root + 1)) == 0
    rho = theory.rotation_number()
    for sign in (1, -1):
        eigenvalue = sp.cos(sp.pi * rho) + sign * sp.I * sp.sqrt(1 - sp.cos(sp.pi * rho) ** 2)
        assert sp.simplify(sp.expand(eigenvalue**2 - 2 * half * eigenvalue + 1)) == 0


def test_the_lock_in_condition_is_that_of_real_eigenvalues():
    condition = (theory.half_trace() ** 2 - 1) * (1 - A**2) - theory.lock_in_margin()
    assert sp.simplify(condition) == 0
    assert sp.simplify(theory.lock_in_margin().subs(OMEGA, theory.lock_in_edge())) == 0


def test_the_fixed_points_are_fixed_and_their_multipliers_inverse():
    cycle, sine = theory.cycle_map(), sp.Symbol("x", real=True)
    cosine = sp.sqrt(1 - sine**2)
    half = {sp.sin(sp.pi * OMEGA): sine, sp.cos(sp.pi * OMEGA): cosine}
    wanted = theory.stable_multiplier().subs(half)
    for point, multiplier in zip(theory.fixed_points(), (wanted, 1 / wanted), strict=True):
        turned = {sp.exp(sp.I * sp.pi * OMEGA): cosine + sp.I * sine}
        at = point.subs(half).subs(turned)
        moved = cycle.subs(sp.exp(2 * sp.I * sp.pi * OMEGA), (cosine + sp.I * sine) ** 2)
        assert sp.simplify(sp.expand(sp.numer(sp.together(moved.subs(POINT, at) - at)))) == 0
        slope = (sp.diff(moved, POINT)).subs(POINT, at)
        assert sp.simplify(sp.expand(sp.numer(sp.together(slope - multiplier)))) == 0


def test_the_slope_is_the_derivative_of_the_angle():
    """dχ'/dχ = z/f · df/dz on the circle."""
    z = POINT
    logarithmic = sp.simplify(z * sp.diff(theory.cycle_map(), z) / theory.cycle_map())
    kernel = theory.slope().subs(sp.cos(CHI), (z + 1 / z) / 2)
    assert sp.simplify(logarithmic - kernel) == 0


def test_the_least_move_has_the_stated_place_gap_and_curvature():
    place, gap, curvature = theory.least_move()
    assert sp.simplify(theory.slope().subs(CHI, place) - 1) == 0
    assert sp.simplify(sp.diff(theory.slope(), CHI).subs(CHI, place) / 2 - curvature) == 0
    # The move is 2πΩ + 2 atan(a sin χ/(1 - a cos χ)), whose arctangent at the place is that of
    # -a/√(1 - a²).
    tangent = (A * sp.sin(CHI) / (1 - A * sp.cos(CHI))).subs(CHI, place)
    assert sp.simplify(tangent + sp.tan(sp.asin(A))) == 0
    assert sp.simplify(gap - (2 * sp.pi * OMEGA - 2 * sp.asin(A))) == 0
    move = 2 * sp.atan(A * sp.sin(CHI) / (1 - A * sp.cos(CHI)))
    assert sp.simplify(sp.diff(move, CHI) + 1 - theory.slope()) == 0


def test_the_square_root_law_is_the_expansion_of_the_closed_form():
    beyond = sp.expand_trig(theory.half_trace().subs(OMEGA, theory.lock_in_edge() + ETA).expand())
    assert sp.simplify(sp.expand(beyond.expand(trig=True)) - theory.cosine_beyond_the_edge()) == 0
    # cos πρ = 1 - (πρ)²/2 + ..., so ρ² = 2(1 - cos πρ)/π² to leading order in η.
    squared = 2 * (1 - theory.cosine_beyond_the_edge()) / sp.pi**2
    rest = sp.series(squared - theory.square_root_law(), ETA, 0, 2)
    assert sp.simplify(rest.removeO()) == 0


def test_near_the_edge_a_turn_is_the_passage_through_the_bottleneck():
    """1/ρ² and (π²/(Aε)) / ... : the square-root law and π/√(Aε) are the same statement."""
    _, gap, curvature = theory.least_move()
    cycles_squared = sp.pi**2 / (curvature * gap.subs(OMEGA, theory.lock_in_edge() + ETA))
    assert sp.simplify(cycles_squared * theory.square_root_law() - 1) == 0


@pytest.mark.slow
def test_the_code_finds_the_closed_forms():
    rho = sp.lambdify((A, OMEGA), theory.rotation_number())
    multiplier = sp.lambdify((A, OMEGA), theory.stable_multiplier())
    locked = turning = 0
    for a, turns in np.random.default_rng(3).uniform((0.1, 0.02), (0.95, 0.48), (8, 2)):
        circle_map = CircleMap.moebius(a, turns)
        found = rotation_number(circle_map)
        if abs(np.sin(np.pi * turns)) <= a:
            assert found.locked == 0
            (stable,) = (orbit for orbit in fixed_points(circle_map) if orbit.stable)
            assert abs(stable.multiplier - multiplier(a, turns)) < 1e-12
            locked += 1
        else:
            assert abs(found.value - rho(a, turns)) < 1e-10
            turning += 1
    assert min(locked, turning) >= 2


def test_the_codes_bottleneck_is_the_least_move():
    place, gap, curvature = (sp.lambdify((A, OMEGA), value) for value in theory.least_move())
    for a in (0.2, 0.5, 0.8):
        turns = np.arcsin(a) / np.pi + 1e-5
        (found,) = slow_passages(CircleMap.moebius(a, turns))
        assert abs(found.theta - place(a, turns) % (2 * np.pi)) < 1e-9
        assert abs(found.gap - gap(a, turns)) < 1e-14
        assert abs(found.curvature / curvature(a, turns) - 1) < 1e-7
