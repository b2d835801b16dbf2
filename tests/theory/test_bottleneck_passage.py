"""Passage through a bottleneck, without noise and under it: in symbols, and by counted iterates and
mean passage times of the code.
"""

import math

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad

from cyclemap.maps import (
    CircleMap,
    WrappedNormal,
    mean_passage_time,
    rotation_number,
    slow_passages,
)
from theory import noisy_passage as noisy, passage_time as flow

EPS, A, X, REACH, ETA = flow.GAP, flow.CURVATURE, flow.PLACE, flow.REACH, flow.ORDER


def test_the_flows_time_is_the_integral_of_one_over_the_move():
    assert sp.simplify(sp.diff(flow.flow_time(), X) - 1 / flow.move()) == 0
    assert flow.flow_time().subs(X, 0) == 0
    assert sp.simplify(2 * sp.limit(flow.flow_time(), X, sp.oo) - flow.passage_time()) == 0


def test_the_end_correction_is_the_expansion_of_the_finite_passage():
    """By the identity arctan y = π/2 - arctan(1/y), whose derivative and value at 1 agree."""
    y = sp.Symbol("y", positive=True)
    assert sp.simplify(sp.diff(sp.atan(y) + sp.atan(1 / y), y)) == 0
    assert sp.simplify((sp.atan(y) + sp.atan(1 / y)).subs(y, 1) - sp.pi / 2) == 0
    small = sp.Symbol("delta", positive=True)
    inside = -2 * sp.atan(small / REACH / sp.sqrt(A)) / (sp.sqrt(A) * small)
    series = sp.series(inside, small, 0, 4).removeO()
    assert sp.simplify(series - flow.end_correction().subs(EPS, small**2)) == 0


def test_the_interpolating_flow_gives_back_the_map_to_fourth_order():
    """With every move multiplied by η the displacement over one cycle differs from it by η⁴ or
    less.
    """
    move = ETA * sp.Function("g")(X)
    back = sp.expand((flow.time_one_map(flow.interpolating_flow(move)) - move).doit())
    assert [sp.simplify(back.coeff(ETA, k)) for k in range(4)] == [0, 0, 0, 0]
    assert back.coeff(ETA, 4) != 0


def test_the_counting_time_is_the_integral_of_one_over_the_interpolating_flow():
    """1/v = 1/g + g'/2g - g'²/12g - g''/12 + ..., and that is the derivative of the counting
    time."""
    g, slope, bend = flow.move(), sp.diff(flow.move(), X), sp.diff(flow.move(), X, 2)
    inverse = 1 / g + slope / (2 * g) - slope**2 / (12 * g) - bend / 12
    assert sp.simplify(sp.diff(flow.counting_time(), X) - inverse) == 0
    any_move = ETA * sp.Function("g")(X)
    general = (
        1 / any_move
        + sp.diff(any_move, X) / (2 * any_move)
        - sp.diff(any_move, X) ** 2 / (12 * any_move)
        - sp.diff(any_move, X, 2) / 12
    )
    product = sp.expand((flow.interpolating_flow(any_move) * general - 1).doit())
    assert [sp.simplify(product.coeff(ETA, k)) for k in range(3)] == [0, 0, 0]


def test_the_counted_passage_has_the_stated_form():
    wanted = 2 * (1 + A * EPS / 3) * flow.flow_time().subs(X, REACH) - A * REACH
    assert sp.simplify(flow.counted_passage() - wanted) == 0


def test_the_soluble_map_advances_its_angle_by_a_constant():
    """tan(φ + δ) with tan δ = √(aε), x = √(ε/a) tan φ: the addition theorem of the tangent."""
    before, step = X * sp.sqrt(A / EPS), sp.sqrt(A * EPS)
    after = flow.soluble_map() * sp.sqrt(A / EPS)
    assert sp.simplify(after - (before + step) / (1 - before * step)) == 0
    assert flow.soluble_angle() == sp.atan(before)
    assert flow.soluble_passage() == sp.pi / sp.atan(step)


def test_the_soluble_map_is_the_bottleneck_to_leading_order_and_its_count_expands_as_stated():
    scaled = flow.soluble_map().subs({X: ETA * X, EPS: ETA**2 * EPS}) - ETA * X
    assert sp.expand(sp.series(scaled, ETA, 0, 3).removeO() - ETA**2 * flow.move()) == 0
    small = sp.Symbol("delta", positive=True)
    count = sp.series(sp.pi / sp.atan(small), small, 0, 3).removeO()
    assert sp.simplify(count - sp.pi / small * (1 + small**2 / 3)) == 0


@pytest.mark.slow
def test_the_interpolating_flow_of_the_soluble_map_is_its_exact_one_to_fourth_order():
    """Its flow is known: (arctan √(aε)/√(aε)) (ε + a x²). Here x counts as η, ε as η², a move as
    η².
    """
    move = (flow.soluble_map() - X).together()
    exact = sp.atan(sp.sqrt(A * EPS)) / sp.sqrt(A * EPS) * flow.move()
    difference = flow.interpolating_flow(move) - exact
    scaled = difference.subs({X: ETA * X, EPS: ETA**2 * EPS}, simultaneous=True)
    assert sp.simplify(sp.series(scaled, ETA, 0, 5).removeO()) == 0


def test_counted_iterates_of_the_parabola_agree_with_the_counting_time_to_order_one_in_the_gap():
    """Between orbit points the count is whole, and the time's differences must be it."""
    time = sp.lambdify((X, EPS, A), flow.counting_time())
    errors, gaps = [], np.array((1e-2, 1e-3, 1e-4))
    for gap in gaps:
        reach = 3.0 * math.sqrt(gap / 0.5)
        x, count = -reach, 0
        while x < reach:
            x, count = x + gap + 0.5 * x * x, count + 1
        errors.append(abs(time(x, gap, 0.5) - time(-reach, gap, 0.5) - count))
    assert max(errors) < 1e-2
    orders = np.diff(np.log(errors)) / np.diff(np.log(gaps))
    assert orders.min() > 0.8


@pytest.mark.parametrize("gap", [1e-3, 1e-5])
def test_the_codes_slow_passage_is_the_theorys(gap):
    strength = 0.9
    (found,) = slow_passages(CircleMap.arnold((strength + gap) / (2.0 * math.pi), strength))
    wanted = float(flow.passage_time().subs({EPS: found.gap, A: found.curvature}))
    assert abs(found.passage_cycles / wanted - 1.0) < 1e-12
    assert abs(found.curvature / (strength / 2.0) - 1.0) < 1e-7


def test_residence_in_the_ghost_is_what_one_turn_of_the_code_takes():
    """1/ρ of the sine map less π/√(aε) stays bounded while both grow a hundredfold."""
    rest, passages = [], []
    for gap in (1e-2, 1e-4, 1e-6):
        circle_map = CircleMap.arnold((0.9 + gap) / (2.0 * math.pi), 0.9)
        passages.append(float(flow.passage_time().subs({EPS: gap, A: 0.45})))
        rest.append(1.0 / rotation_number(circle_map).value - passages[-1])
    assert passages[-1] / passages[0] > 99.0
    assert max(np.abs(rest)) < 3.0
    assert abs(rest[-1] - rest[-2]) < abs(rest[1] - rest[0])


BEND, D, OPENING, U = noisy.CURVATURE, noisy.DIFFUSION, noisy.GAP, noisy.SEPARATION


def test_the_integral_over_the_middle_is_the_gaussian_that_the_integrand_holds():
    middle = sp.integrate(sp.exp(-BEND * noisy.MIDDLE**2 * U / D), (noisy.MIDDLE, -sp.oo, sp.oo))
    rest = noisy.exponent().subs(noisy.MIDDLE, 0)
    assert sp.simplify(noisy.exponent() - rest + BEND * noisy.MIDDLE**2 * U / D) == 0
    assert sp.simplify(middle * sp.exp(rest) / D - noisy.integrand()) == 0


def test_the_integral_at_tangency_is_the_gamma_function():
    power = sp.Symbol("t", positive=True)
    # With t = a u³/(12 D) the integral becomes Euler's.
    place = sp.cbrt(12 * D * power / BEND)
    substituted = noisy.integrand().subs(OPENING, 0).subs(U, place) * sp.diff(place, power)
    euler = power ** sp.Rational(-5, 6) * sp.exp(-power)
    gamma = sp.gamma(sp.Rational(1, 6))
    assert sp.simplify(substituted / euler * gamma - noisy.passage_at_tangency()) == 0
    assert sp.simplify(sp.integrate(euler, (power, 0, sp.oo)) - gamma) == 0


def integral_of(gap, curvature, diffusion):
    """The passage's double integral, by its separations' roots."""
    value = sp.lambdify((U, OPENING, BEND, D), noisy.integrand())

    def by_root(root):
        return root * value(root * root, gap, curvature, diffusion)

    return 2.0 * quad(by_root, 0.0, 3.0, epsabs=0.0, limit=300)[0]


def test_the_well_takes_kramers_time():
    depth = sp.Symbol("e", positive=True)
    barrier = 4 * depth ** sp.Rational(3, 2) / (3 * D * sp.sqrt(BEND))
    wanted = sp.pi / sp.sqrt(BEND * depth) * sp.exp(barrier)
    assert sp.simplify(noisy.kramers_time() / wanted - 1) == 0
    ratios = []
    for noise in (0.1, 0.05):
        kramers = float(noisy.kramers_time().subs({depth: 1, BEND: 1, D: noise}))
        ratios.append(integral_of(-1.0, 1.0, noise) / kramers)
    # The next order is linear in D.
    assert 1.6 < (ratios[0] - 1.0) / (ratios[1] - 1.0) < 2.6


@pytest.mark.slow
def test_the_codes_mean_passage_times_exceed_the_integral_by_a_bounded_time_only():
    """The sine map's whole turn, gap in the noise's own unit (aD²)^(1/3): below, at and above
    tangency.
    """
    middle, strength = math.pi / 2, 0.4
    arc = (middle - math.pi, middle + math.pi)
    for unit in (-1.0, 0.0, 1.0):
        rest, integral = [], []
        for sigma in (0.08, 0.04):
            diffusion = sigma**2 / 2.0
            gap = unit * (strength / 2.0 * diffusion**2) ** (1.0 / 3.0)
            circle_map = CircleMap.arnold((strength + gap) / (2.0 * math.pi), strength)
            noise = WrappedNormal(sigma)
            found = mean_passage_time(circle_map, noise, arc[0] + 0.6, arc, lifted=True)
            integral.append(integral_of(gap, strength / 2.0, diffusion))
            rest.append(float(found) - integral[-1])
        assert integral[1] > 1.5 * integral[0] > 50.0
        assert max(np.abs(rest)) < 2.0
