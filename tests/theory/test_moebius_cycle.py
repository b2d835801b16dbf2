"""The ellipsoid's drag and the cycle made of it are Möbius maps: residuals are zero in symbols, and
the code's maps and minimisers agree; a leg in a random direction leaves no bias.
"""

import math

import numpy as np
import pytest
import sympy as sp

from cyclemap.maps import CircleMap, fixed_points, rotation_number, slow_passages
from cyclemap.mechanics import Ellipse, EllipseFriction, Pose, QuasiStaticModel, Slider
from theory import moebius_drag as drag, moebius_lock_in as lock, random_leg
from theory.moebius_drag import strength

Z, R, C, ELL, PSI = drag.POINT, drag.LEVER, drag.SPIN_RADIUS, drag.LENGTH, drag.HEADING
A, B = sp.symbols("a b", positive=True)


def test_the_spin_makes_the_dissipation_stationary_and_it_is_its_only_minimum():
    squared, spin = drag.squared_dissipation(), drag.spin_of_least_dissipation()
    assert sp.simplify(sp.diff(squared, drag.SPIN).subs(drag.SPIN, spin)) == 0
    assert sp.simplify(sp.diff(squared, drag.SPIN, 2) - 2 * (R**2 + C**2)) == 0
    assert sp.simplify(spin + drag.rate() * sp.sin(PSI)) == 0


def test_the_half_angle_solution_satisfies_the_equation_of_motion_and_the_start():
    """d tan(ψ/2)/dℓ = (1 + tan²(ψ/2))/2 · dψ/dℓ, with sin ψ = 2 tan/(1 + tan²)."""
    tangent = drag.half_angle_tangent()
    sine = 2 * tangent / (1 + tangent**2)
    assert sp.simplify(sp.diff(tangent, ELL) - (1 + tangent**2) / 2 * (-drag.rate() * sine)) == 0
    assert sp.simplify(tangent.subs(ELL, 0) - sp.tan(PSI / 2)) == 0


def test_the_moebius_map_is_the_half_angle_solution():
    """With t = tan(ψ/2), z = (1 + it)/(1 - it);
    the leg multiplies t by e^{-κℓ} = (1 - a)/(1 + a)."""
    t = sp.Symbol("t", real=True)
    image = drag.leg_of_the_lever(A).subs(Z, (1 + sp.I * t) / (1 - sp.I * t))
    shrunk = t * (1 - A) / (1 + A)
    assert sp.simplify(image - (1 + sp.I * shrunk) / (1 - sp.I * shrunk)) == 0
    x = sp.Symbol("x", positive=True)
    half = sp.tanh(x / 2)
    assert sp.simplify(((1 - half) / (1 + half)).rewrite(sp.exp) - sp.exp(-x)) == 0


@pytest.mark.slow
def test_legs_add_and_turned_legs_multiply_their_matrices():
    legs = drag.leg_of_the_lever(B).subs(Z, drag.leg_of_the_lever(A))
    assert sp.simplify(legs - drag.leg_of_the_lever(drag.strength_of_two(A, B))) == 0
    x, y = sp.symbols("x y", positive=True)
    added = drag.strength_of_two(sp.tanh(x / 2), sp.tanh(y / 2)) - sp.tanh((x + y) / 2)
    assert sp.simplify(added.rewrite(sp.exp)) == 0
    u, v = sp.symbols("u v", real=True)
    one, two = drag.turned_leg(A, u), drag.turned_leg(B, v)
    m = drag.matrix_of_leg(B, v) * drag.matrix_of_leg(A, u)
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
        matrix = drag.matrix_of_leg(a, direction) * matrix
    whole = abs(complex(drag.strength_of_path(matrix)))
    assert abs(slope.max() / ((1.0 + whole) / (1.0 - whole)) - 1.0) < 1e-7
    assert abs(slope.min() / ((1.0 - whole) / (1.0 + whole)) - 1.0) < 1e-7
    mapped = sp.lambdify(Z, (matrix[0, 0] * Z + matrix[0, 1]) / (matrix[1, 0] * Z + matrix[1, 1]))
    assert np.abs(mapped(np.exp(1j * start)) - np.exp(1j * lever)).max() < 1e-12


def test_the_trails_map_is_the_codes_moebius_map():
    image = sp.lambdify((Z, A), drag.leg_of_the_trail(A))
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
    after = sp.lambdify((PSI, R, C, ELL), drag.heading_after())
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


STRENGTH, OMEGA, CHI, ETA = lock.STRENGTH, lock.TURNS, lock.ANGLE, lock.EXCESS


def test_the_matrix_is_that_of_the_map_and_its_eigenvalues_give_the_rotation():
    m = lock.cycle_matrix()
    mapped = (m[0, 0] * Z + m[0, 1]) / (m[1, 0] * Z + m[1, 1])
    assert sp.simplify(mapped - lock.cycle_map()) == 0
    assert sp.simplify(m.det() - 1) == 0
    half, root = lock.half_trace(), sp.Symbol("x")
    characteristic = m.charpoly(root).as_expr()
    assert sp.simplify(characteristic - (root**2 - 2 * half * root + 1)) == 0
    rho = lock.rotation_number()
    for sign in (1, -1):
        eigenvalue = sp.cos(sp.pi * rho) + sign * sp.I * sp.sqrt(1 - sp.cos(sp.pi * rho) ** 2)
        assert sp.simplify(sp.expand(eigenvalue**2 - 2 * half * eigenvalue + 1)) == 0


def test_the_lock_in_condition_is_that_of_real_eigenvalues():
    condition = (lock.half_trace() ** 2 - 1) * (1 - STRENGTH**2) - lock.lock_in_margin()
    assert sp.simplify(condition) == 0
    assert sp.simplify(lock.lock_in_margin().subs(OMEGA, lock.lock_in_edge())) == 0


def test_the_fixed_points_are_fixed_and_their_multipliers_inverse():
    cycle, sine = lock.cycle_map(), sp.Symbol("x", real=True)
    cosine = sp.sqrt(1 - sine**2)
    half = {sp.sin(sp.pi * OMEGA): sine, sp.cos(sp.pi * OMEGA): cosine}
    wanted = lock.stable_multiplier().subs(half)
    for point, multiplier in zip(lock.fixed_points(), (wanted, 1 / wanted), strict=True):
        turned = {sp.exp(sp.I * sp.pi * OMEGA): cosine + sp.I * sine}
        at = point.subs(half).subs(turned)
        moved = cycle.subs(sp.exp(2 * sp.I * sp.pi * OMEGA), (cosine + sp.I * sine) ** 2)
        assert sp.simplify(sp.expand(sp.numer(sp.together(moved.subs(Z, at) - at)))) == 0
        slope = (sp.diff(moved, Z)).subs(Z, at)
        assert sp.simplify(sp.expand(sp.numer(sp.together(slope - multiplier)))) == 0


def test_the_slope_is_the_derivative_of_the_angle():
    """dχ'/dχ = z/f · df/dz on the circle."""
    z = Z
    logarithmic = sp.simplify(z * sp.diff(lock.cycle_map(), z) / lock.cycle_map())
    kernel = lock.slope().subs(sp.cos(CHI), (z + 1 / z) / 2)
    assert sp.simplify(logarithmic - kernel) == 0


def test_the_least_move_has_the_stated_place_gap_and_curvature():
    place, gap, curvature = lock.least_move()
    assert sp.simplify(lock.slope().subs(CHI, place) - 1) == 0
    assert sp.simplify(sp.diff(lock.slope(), CHI).subs(CHI, place) / 2 - curvature) == 0
    # The move is 2πΩ + 2 atan(a sin χ/(1 - a cos χ)), whose arctangent at the place is that of
    # -a/√(1 - a²).
    tangent = (STRENGTH * sp.sin(CHI) / (1 - STRENGTH * sp.cos(CHI))).subs(CHI, place)
    assert sp.simplify(tangent + sp.tan(sp.asin(STRENGTH))) == 0
    assert sp.simplify(gap - (2 * sp.pi * OMEGA - 2 * sp.asin(STRENGTH))) == 0
    move = 2 * sp.atan(STRENGTH * sp.sin(CHI) / (1 - STRENGTH * sp.cos(CHI)))
    assert sp.simplify(sp.diff(move, CHI) + 1 - lock.slope()) == 0


def test_the_square_root_law_is_the_expansion_of_the_closed_form():
    beyond = sp.expand_trig(lock.half_trace().subs(OMEGA, lock.lock_in_edge() + ETA).expand())
    assert sp.simplify(sp.expand(beyond.expand(trig=True)) - lock.cosine_beyond_the_edge()) == 0
    # cos πρ = 1 - (πρ)²/2 + ..., so ρ² = 2(1 - cos πρ)/π² to leading order in η.
    squared = 2 * (1 - lock.cosine_beyond_the_edge()) / sp.pi**2
    rest = sp.series(squared - lock.square_root_law(), ETA, 0, 2)
    assert sp.simplify(rest.removeO()) == 0


def test_near_the_edge_a_turn_is_the_passage_through_the_bottleneck():
    """1/ρ² and (π²/(Aε)) / ... : the square-root law and π/√(Aε) are the same statement."""
    _, gap, curvature = lock.least_move()
    cycles_squared = sp.pi**2 / (curvature * gap.subs(OMEGA, lock.lock_in_edge() + ETA))
    assert sp.simplify(cycles_squared * lock.square_root_law() - 1) == 0


@pytest.mark.slow
def test_the_code_finds_the_closed_forms():
    rho = sp.lambdify((STRENGTH, OMEGA), lock.rotation_number())
    multiplier = sp.lambdify((STRENGTH, OMEGA), lock.stable_multiplier())
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
    place, gap, curvature = (sp.lambdify((STRENGTH, OMEGA), value) for value in lock.least_move())
    for a in (0.2, 0.5, 0.8):
        turns = np.arcsin(a) / np.pi + 1e-5
        (found,) = slow_passages(CircleMap.moebius(a, turns))
        assert abs(found.theta - place(a, turns) % (2 * np.pi)) < 1e-9
        assert abs(found.gap - gap(a, turns)) < 1e-14
        assert abs(found.curvature / curvature(a, turns) - 1) < 1e-7


def test_the_turn_does_not_know_the_orientation():
    turn = random_leg.turn_by_heading(sp.Function("g"))
    assert not turn.has(random_leg.START, random_leg.DIRECTION)


@pytest.mark.slow
def test_the_memory_is_the_stated_residue():
    a, z = random_leg.STRENGTH, random_leg.POINT
    for order in range(1, 5):
        ratio = ((z + a) / (z * (1 + a * z))) ** order / z
        assert sp.simplify(sp.residue(ratio, z, 0) - random_leg.memory(order)) == 0
        assert sp.simplify(random_leg.memory(order).subs(a, 0) - 1) == 0
        assert random_leg.memory(order).subs(a, 1) == 0


def test_the_first_memory_is_the_stated_function_of_the_length():
    residual = random_leg.memory(1).subs(random_leg.STRENGTH, strength()) - random_leg.correlation()
    assert sp.simplify(residual.rewrite(sp.exp)) == 0


def test_one_leg_gives_even_headings_the_powers_of_its_strength_as_moments():
    x = np.linspace(0.0, 2.0 * np.pi, 4096, endpoint=False)
    for a in (0.1, 0.5, 0.9):
        heading = CircleMap.moebius(a, 0.0)(x) - np.pi
        for order in range(1, 6):
            wanted = float(random_leg.moment_from_uniform(order).subs(random_leg.STRENGTH, a))
            assert abs(np.mean(np.exp(1j * order * heading)) - wanted) < 1e-13


def moments_left(strength, rotation, directions, order=64):
    """Stationary moments E e^{inθ}, n = -order..order, of a Möbius leg in one of K directions at
    random.
    """
    grid = np.arange(8 * order) * 2.0 * np.pi / (8 * order)
    numbers = np.arange(-order, order + 1)
    matrix = np.zeros((numbers.size, numbers.size), dtype=complex)
    for angle in np.arange(directions) * 2.0 * np.pi / directions:
        image = CircleMap.moebius(strength, 0.0)(grid - angle) + angle + rotation
        waves = np.fft.fft(np.exp(1j * numbers[:, None] * image), axis=1) / grid.size
        matrix += waves[:, numbers] / directions
    centre = order
    rest = numbers != 0
    moments = np.ones(numbers.size, dtype=complex)
    system = np.eye(2 * order) - matrix[np.ix_(rest, rest)]
    moments[rest] = np.linalg.solve(system, matrix[rest, centre])
    return dict(zip(numbers.tolist(), moments, strict=True))


def test_k_directions_leave_only_every_kth_harmonic_of_the_bias():
    """One fixed direction leaves a bias a; two leave no first harmonic; three no first and no
    second.
    """
    for directions in (1, 2, 3, 4):
        moments = moments_left(0.3, 1.0, directions)
        for n in range(1, 7):
            share = random_leg.surviving_share(n, directions)
            assert share == (1 if n % directions == 0 else 0)
            if share == 0:
                assert abs(moments[n]) < 1e-12
        assert abs(moments[directions]) > 1e-5
    assert abs(moments_left(0.3, 1.0, 1)[1]) > 0.1
