"""Passage through a bottleneck: the flow's integral, its next order, the soluble map; counted
iterates confirm them.
"""

import math

import numpy as np
import pytest
import sympy as sp

from cyclemap.maps import CircleMap, rotation_number, slow_passages
from theory import passage_time as theory

EPS, A, X, REACH, ETA = theory.GAP, theory.CURVATURE, theory.PLACE, theory.REACH, theory.ORDER


def test_the_flows_time_is_the_integral_of_one_over_the_move():
    assert sp.simplify(sp.diff(theory.flow_time(), X) - 1 / theory.move()) == 0
    assert theory.flow_time().subs(X, 0) == 0
    assert sp.simplify(2 * sp.limit(theory.flow_time(), X, sp.oo) - theory.passage_time()) == 0


def test_the_end_correction_is_the_expansion_of_the_finite_passage():
    """By the identity arctan y = π/2 - arctan(1/y), whose derivative and value at 1 agree."""
    y = sp.Symbol("y", positive=True)
    assert sp.simplify(sp.diff(sp.atan(y) + sp.atan(1 / y), y)) == 0
    assert sp.simplify((sp.atan(y) + sp.atan(1 / y)).subs(y, 1) - sp.pi / 2) == 0
    small = sp.Symbol("delta", positive=True)
    inside = -2 * sp.atan(small / REACH / sp.sqrt(A)) / (sp.sqrt(A) * small)
    series = sp.series(inside, small, 0, 4).removeO()
    assert sp.simplify(series - theory.end_correction().subs(EPS, small**2)) == 0


def test_the_interpolating_flow_gives_back_the_map_to_fourth_order():
    """With every move multiplied by η the displacement over one cycle differs from it by η⁴ or
    less.
    """
    move = ETA * sp.Function("g")(X)
    back = sp.expand((theory.time_one_map(theory.interpolating_flow(move)) - move).doit())
    assert [sp.simplify(back.coeff(ETA, k)) for k in range(4)] == [0, 0, 0, 0]
    assert back.coeff(ETA, 4) != 0


def test_the_counting_time_is_the_integral_of_one_over_the_interpolating_flow():
    """1/v = 1/g + g'/2g - g'²/12g - g''/12 + ..., and that is the derivative of the counting
    time."""
    g, slope, bend = theory.move(), sp.diff(theory.move(), X), sp.diff(theory.move(), X, 2)
    inverse = 1 / g + slope / (2 * g) - slope**2 / (12 * g) - bend / 12
    assert sp.simplify(sp.diff(theory.counting_time(), X) - inverse) == 0
    any_move = ETA * sp.Function("g")(X)
    general = (
        1 / any_move
        + sp.diff(any_move, X) / (2 * any_move)
        - sp.diff(any_move, X) ** 2 / (12 * any_move)
        - sp.diff(any_move, X, 2) / 12
    )
    product = sp.expand((theory.interpolating_flow(any_move) * general - 1).doit())
    assert [sp.simplify(product.coeff(ETA, k)) for k in range(3)] == [0, 0, 0]


def test_the_counted_passage_has_the_stated_form():
    wanted = 2 * (1 + A * EPS / 3) * theory.flow_time().subs(X, REACH) - A * REACH
    assert sp.simplify(theory.counted_passage() - wanted) == 0


def test_the_soluble_map_advances_its_angle_by_a_constant():
    """tan(φ + δ) with tan δ = √(aε), x = √(ε/a) tan φ: the addition theorem of the tangent."""
    before, step = X * sp.sqrt(A / EPS), sp.sqrt(A * EPS)
    after = theory.soluble_map() * sp.sqrt(A / EPS)
    assert sp.simplify(after - (before + step) / (1 - before * step)) == 0
    assert theory.soluble_angle() == sp.atan(before)
    assert theory.soluble_passage() == sp.pi / sp.atan(step)


def test_the_soluble_map_is_the_bottleneck_to_leading_order_and_its_count_expands_as_stated():
    scaled = theory.soluble_map().subs({X: ETA * X, EPS: ETA**2 * EPS}) - ETA * X
    assert sp.expand(sp.series(scaled, ETA, 0, 3).removeO() - ETA**2 * theory.move()) == 0
    small = sp.Symbol("delta", positive=True)
    count = sp.series(sp.pi / sp.atan(small), small, 0, 3).removeO()
    assert sp.simplify(count - sp.pi / small * (1 + small**2 / 3)) == 0


@pytest.mark.slow
def test_the_interpolating_flow_of_the_soluble_map_is_its_exact_one_to_fourth_order():
    """Its flow is known: (arctan √(aε)/√(aε)) (ε + a x²). Here x counts as η, ε as η², a move as
    η².
    """
    move = (theory.soluble_map() - X).together()
    exact = sp.atan(sp.sqrt(A * EPS)) / sp.sqrt(A * EPS) * theory.move()
    difference = theory.interpolating_flow(move) - exact
    scaled = difference.subs({X: ETA * X, EPS: ETA**2 * EPS}, simultaneous=True)
    assert sp.simplify(sp.series(scaled, ETA, 0, 5).removeO()) == 0


def test_counted_iterates_of_the_parabola_agree_with_the_counting_time_to_order_one_in_the_gap():
    """Between orbit points the count is whole, and the time's differences must be it."""
    time = sp.lambdify((X, EPS, A), theory.counting_time())
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
    wanted = float(theory.passage_time().subs({EPS: found.gap, A: found.curvature}))
    assert abs(found.passage_cycles / wanted - 1.0) < 1e-12
    assert abs(found.curvature / (strength / 2.0) - 1.0) < 1e-7


def test_residence_in_the_ghost_is_what_one_turn_of_the_code_takes():
    """1/ρ of the sine map less π/√(aε) stays bounded while both grow a hundredfold."""
    rest, passages = [], []
    for gap in (1e-2, 1e-4, 1e-6):
        circle_map = CircleMap.arnold((0.9 + gap) / (2.0 * math.pi), 0.9)
        passages.append(float(theory.passage_time().subs({EPS: gap, A: 0.45})))
        rest.append(1.0 / rotation_number(circle_map).value - passages[-1])
    assert passages[-1] / passages[0] > 99.0
    assert max(np.abs(rest)) < 3.0
    assert abs(rest[-1] - rest[-2]) < abs(rest[1] - rest[0])
