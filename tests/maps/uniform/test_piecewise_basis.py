"""Panels: interpolation, antiderivatives, weak derivatives and quadrature agree with closed forms."""

import numpy as np
import pytest

from cyclemap.maps.operator.panels import ORDER, Panels

TWO_PI = 2 * np.pi
MIXED = Panels(np.array([0.0, 1.0, 1.5, 2.0]), np.array([1.0, 1.5, 2.0, 3.0]), np.array([False, True, True, False]))
GAPPED = Panels(np.array([0.0, 2.0]), np.array([1.0, 2.5]), np.array([False, False]))


def with_roots(x):
    """Smooth outside [1, 2], with a square root on the right of 1 and a power 3/2 on the left of 2."""
    inside = (x >= 1) & (x < 2)
    return np.cos(x) + inside * (np.sqrt(np.abs(x - 1)) + np.abs(2 - x) ** 1.5)


def primitive_with_roots(x):
    y = np.clip(x, 1.0, 2.0)
    return np.sin(x) + (y - 1) ** 1.5 / 1.5 - ((2 - y) ** 2.5 - 1) / 2.5


def test_bent_panels_interpolate_half_integer_powers_at_their_ends():
    law = MIXED.coefficients(with_roots(MIXED.nodes))
    x = np.linspace(0.0, 3.0, 2_000, endpoint=False)
    np.testing.assert_allclose(MIXED.evaluate(x) @ law, with_roots(x), rtol=0, atol=2e-14)
    np.testing.assert_allclose(MIXED.value(law, x), MIXED.evaluate(x) @ law, rtol=0, atol=1e-14)
    straight = Panels(MIXED.start, MIXED.end, np.zeros(4, dtype=bool))
    poor = straight.evaluate(x) @ straight.coefficients(with_roots(straight.nodes))
    assert np.max(np.abs(poor - with_roots(x))) > 1e-3


def test_antiderivatives_are_exact_on_both_kinds_of_panels():
    law = MIXED.coefficients(with_roots(MIXED.nodes))
    x = np.array([0.0, 1e-9, 0.3, 1.0, 1.0 + 1e-8, 1.2, 1.5, 1.999, 2.0, 2.7, 3.0])
    np.testing.assert_allclose(MIXED.integral(law, x), primitive_with_roots(x), rtol=0, atol=2e-14)
    rows = np.array([0, 1, 1, 0, 2, 2, 0, 1, 2, 0, 1])
    weights = np.linspace(-2.0, 3.0, 11)
    expected = np.bincount(rows, weights * primitive_with_roots(x))
    np.testing.assert_allclose(MIXED.integral_matrix(x, weights, rows, 3) @ law, expected, rtol=0, atol=1e-13)
    assert abs(MIXED.mass @ law - primitive_with_roots(3.0)) < 1e-14


def test_an_integral_stands_still_in_a_gap():
    law = GAPPED.coefficients(np.ones(GAPPED.size))
    x = np.array([-1.0, 0.5, 1.0, 1.7, 2.0, 2.25, 2.5, 9.0])
    np.testing.assert_allclose(GAPPED.integral(law, x), [0, 0.5, 1, 1, 1, 1.25, 1.5, 1.5], rtol=0, atol=1e-15)


def test_nodes_and_coordinates_are_inverse_to_each_other():
    panel, t = MIXED.locate(MIXED.nodes)
    np.testing.assert_array_equal(panel, np.repeat(np.arange(4), ORDER))
    np.testing.assert_allclose(np.sort(t[:ORDER]), np.polynomial.legendre.leggauss(ORDER)[0], atol=1e-14)
    np.testing.assert_allclose(t.reshape(4, ORDER) - t[:ORDER], 0.0, atol=1e-12)


def test_slopes_are_the_derivatives_of_smooth_functions():
    x = np.linspace(0.0, 3.0, 101)
    law = MIXED.coefficients(np.sin(2 * MIXED.nodes))
    np.testing.assert_allclose(MIXED.slope(x) @ law, 2 * np.cos(2 * x), rtol=0, atol=1e-6)
    away = np.abs(x - 1.5) > 1e-9
    np.testing.assert_allclose((MIXED.slope(x) @ law)[away], 2 * np.cos(2 * x[away]), rtol=0, atol=1e-9)


def test_the_weak_derivative_is_exact_for_smooth_periodic_functions_and_for_integrals_of_rough_ones():
    wave = TWO_PI / 3
    law = MIXED.derivative(MIXED.coefficients(np.sin(wave * MIXED.nodes)))
    x = np.linspace(0.05, 2.95, 60)
    np.testing.assert_allclose(MIXED.evaluate(x) @ law, wave * np.cos(wave * x), rtol=0, atol=1e-9)

    def root(theta):
        return np.where((theta > 1) & (theta < 1.5), np.sqrt(np.abs(theta - 1) * np.abs(1.5 - theta)), 0.0)

    rough = MIXED.derivative(MIXED.coefficients(root(MIXED.nodes)))
    nodes, weights = MIXED.rule(np.zeros(0), 40)
    # ∫ g cos θ = ∫ root sin θ, though g is infinite at both ends of its panel.
    exact = np.sum(weights * root(nodes) * np.sin(nodes))
    assert abs(np.sum(weights * (MIXED.evaluate(nodes) @ rough) * np.cos(nodes)) - exact) < 1e-13
    assert abs(MIXED.mass @ rough) < 1e-15


@pytest.mark.parametrize("cuts", [np.zeros(0), np.array([0.3, 1.2, 1.9, 2.0])])
def test_the_rule_integrates_products_with_kinked_functions(cuts):
    nodes, weights = MIXED.rule(cuts, 32)
    assert nodes.size == 32 * (4 + np.sum((cuts > 0) & (cuts < 2)))
    kinks = sum(np.abs(nodes - c) for c in cuts)
    exact = sum((c**2 + (3 - c) ** 2) / 2 for c in cuts)
    assert abs(np.sum(weights * kinks) - exact) < 1e-13
    assert abs(np.sum(weights * with_roots(nodes)) - primitive_with_roots(3.0)) < 1e-13
