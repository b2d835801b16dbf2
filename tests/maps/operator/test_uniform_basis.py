"""Uniform noise: panels, and the transfer operator on them."""

import numpy as np
import pytest
from scipy.special import jv

from cyclemap.maps import CircleMap, UniformNoise, sample_staircases, transfer_operator
from cyclemap.maps.lifts.scan import monotone_cells
from cyclemap.maps.noise.panels import Panels, level_steps
from cyclemap.maps.operator.uniform_basis import uniform_discretisation
from tests.maps.known_maps import DROPPING, TWIN_WELLS

TWO_PI = 2 * np.pi
MIXED = Panels(np.array([0.0, 1.0, 1.5, 2.0]), np.array([1.0, 1.5, 2.0, 3.0]), np.array([False, True, True, False]))


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


@pytest.mark.parametrize("cuts", [np.zeros(0), np.array([0.3, 1.2, 1.9, 2.0])])
def test_the_rule_integrates_products_with_kinked_functions(cuts):
    nodes, weights = MIXED.cut_rule(cuts, 32)
    assert nodes.size == 32 * (4 + np.sum((cuts > 0) & (cuts < 2)))
    kinks = sum(np.abs(nodes - c) for c in cuts)
    exact = sum((c**2 + (3 - c) ** 2) / 2 for c in cuts)
    assert abs(np.sum(weights * kinks) - exact) < 1e-13
    assert abs(np.sum(weights * with_roots(nodes)) - primitive_with_roots(3.0)) < 1e-13


FOLDED = CircleMap.arnold(0.3, 3.0)


def contraction(x):
    """θ → (θ - 0.5)/2 + 1.2 + 0.2 sin θ on one turn from its jump at 0.5."""
    turn = TWO_PI * np.floor((x - 0.5) / TWO_PI)
    return turn + 0.5 * (x - 0.5 - turn) + 1.2 + 0.2 * np.sin(x)


CONTRACTION = CircleMap(contraction, lambda x: 0.5 + 0.2 * np.cos(x), [0.5])


def bordered(basis):
    return np.eye(basis.size) - basis.matrix + np.outer(basis.uniform, basis.mass)


def stationary(basis):
    return np.linalg.solve(bordered(basis), basis.uniform)


@pytest.mark.parametrize("h", [0.126, 0.9, 4.0, 7.5])
def test_a_rotation_keeps_the_uniform_law(h):
    law = transfer_operator(CircleMap.rigid(0.3), UniformNoise(h))
    np.testing.assert_allclose(law.density(np.linspace(-9, 9, 50)), 1 / TWO_PI, rtol=1e-12)
    assert abs(law.rotation_number - 0.3) <= law.rotation_number.error_bound + 1e-15 < 1e-11


def test_a_map_that_is_constant_on_two_arcs_has_a_law_of_two_boxes():
    """Values 1 on [0, 2.2) and 3 after it, h = 1.5: a chain of two states, whose law is p = w₁ box₁ + w₂ box₃."""
    cut, values, h = 2.2, (1.0, 3.0), 1.5

    def lift(x):
        turn = np.floor(x / TWO_PI)
        return TWO_PI * turn + np.where(x - TWO_PI * turn < cut, *values)

    basis = uniform_discretisation(CircleMap(lift, np.zeros_like, [0.0, cut]), UniformNoise(h))
    law = stationary(basis)
    low = [float(UniformNoise(h).arc_probability(0 - v, cut - v)) for v in values]
    weight = low[1] / (1 - low[0] + low[1])
    x = np.array([-0.3, 0.7, 1.4, 1.6, 2.4, 2.6, 4.4, 4.6, 5.5])
    exact = weight * UniformNoise(h).density(x - 1.0) + (1 - weight) * UniformNoise(h).density(x - 3.0)
    np.testing.assert_allclose(basis.evaluate(x) @ law, exact, rtol=0, atol=1e-14)
    assert basis.residual(law) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("h", [0.5, 0.126])
def test_a_smooth_map_agrees_with_three_hundred_fourier_modes(h):
    omega, K, m = 0.3, 0.5, np.arange(-300, 301)
    ring = UniformNoise(h).coefficients(m) * np.exp(-1j * m * omega * TWO_PI)
    matrix = ring[:, None] * jv(m[:, None] - m, m[:, None] * K)
    rest = m != 0
    waves = np.linalg.solve(np.eye(600) - matrix[np.ix_(rest, rest)], matrix[rest, 300])
    basis = uniform_discretisation(CircleMap.arnold(omega, K), UniformNoise(h))
    law = stationary(basis)
    found = np.array([basis.moments(k) @ law for k in range(1, 7)])
    np.testing.assert_allclose(found, np.conj(waves[300:306]), rtol=0, atol=1e-13)
    x = np.linspace(0, TWO_PI, 40)
    exact = (1 + (np.exp(1j * np.multiply.outer(x, m[rest])) @ waves).real) / TWO_PI
    assert np.max(np.abs(basis.evaluate(x) @ law - exact)) < 1e-12
    assert basis.residual(law) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize(("circle_map", "h"), [(FOLDED, 0.5), (DROPPING, 0.3), (CONTRACTION, 0.6)])
def test_monte_carlo_agrees_for_folds_and_jumps(circle_map, h):
    noise, count = UniformNoise(h), 60_000
    theta = np.mod(sample_staircases(circle_map, noise, 60, np.linspace(0, TWO_PI, count), seed=4)[:, -1], TWO_PI)
    basis = uniform_discretisation(circle_map, noise, max_panels=48)
    law = stationary(basis)
    edges = np.linspace(0, TWO_PI, 31)
    share = np.diff(basis.integral(law, edges))
    found = np.histogram(theta, edges)[0] / count
    assert np.max(np.abs(found - share) / np.sqrt(share / count + 1e-9)) < 4.5
    assert abs(basis.mass @ law - 1) < 1e-9


@pytest.mark.slow
def test_trapped_laws_and_their_bound_shrink_with_more_panels():
    """A law trapped in an arc: smooth, nowhere analytic; its error against many panels stays below the residual's."""
    circle_map, noise, x = CircleMap.arnold(0.1, 0.9), UniformNoise(0.126), np.linspace(0, TWO_PI, 500)
    coarse, fine = (uniform_discretisation(circle_map, noise, max_panels=k) for k in (24, 44))
    rough, law = stationary(coarse), stationary(fine)
    error = np.max(np.abs(coarse.evaluate(x) @ rough - fine.evaluate(x) @ law))
    inverse = np.max(np.abs(np.linalg.inv(bordered(fine))).sum(axis=0))
    assert fine.residual(law) < 1e-2 * coarse.residual(rough)
    assert error < inverse * (coarse.residual(rough) + fine.residual(law))
    outside = np.abs(np.angle(np.exp(1j * (x - 0.7728)))) > 1.0
    assert np.max(np.abs(fine.evaluate(x[outside]) @ law)) < 1e-6


def test_a_residual_tells_a_wrong_law():
    basis = uniform_discretisation(CircleMap.rigid(0.1), UniformNoise(0.5))
    nodes = basis.nodes
    wrong = basis.coefficients((1 + np.cos(nodes)) / TWO_PI)
    # L turns the wave and damps it by κ₁, so the residual's maximum is |1 - κ₁ e^{iω}|/2π.
    kappa = np.sin(0.5) / 0.5
    exact = abs(1 - kappa * np.exp(0.2j * np.pi)) / TWO_PI
    assert 1.99 * exact < basis.residual(wrong) < 2.01 * exact


def test_the_rule_and_the_moments_integrate_densities():
    basis = uniform_discretisation(DROPPING, UniformNoise(0.5), max_panels=24)
    theta, weight = basis.rule
    rows = basis.evaluate(theta)
    np.testing.assert_allclose(weight @ rows, basis.mass, rtol=0, atol=1e-13)
    np.testing.assert_allclose((weight * np.exp(40j * theta)) @ rows, basis.moments(40), rtol=0, atol=1e-12)
    law = stationary(basis)
    mean = weight @ (DROPPING.derivative(theta) * (rows @ law))
    fine = np.union1d(np.linspace(0, TWO_PI, 40_001), basis.start)
    middle = 0.5 * (fine[1:] + fine[:-1])
    values = np.concatenate([basis.evaluate(part) @ law for part in np.array_split(middle, 20)])
    assert abs(mean - np.sum(np.diff(fine) * DROPPING.derivative(middle) * values)) < 1e-8


def test_level_steps_count_the_crossings_of_every_level():
    cells = monotone_cells(FOLDED, 1, 0.0, 64)
    levels = np.linspace(-7.0, 9.0, 41)
    rows, theta, height, last = level_steps(FOLDED, cells, levels)
    grid = np.linspace(0, TWO_PI, 4_001)[:-1] + 1e-5
    checked = 0
    for row, level in enumerate(levels):
        mine = rows == row
        ahead = np.sum(height[mine][:, None] * (theta[mine][:, None] > grid), axis=0)
        np.testing.assert_array_equal(last[row] - ahead, np.floor((FOLDED(grid) - level) / TWO_PI))
        checked += int(mine.sum())
    assert checked > 41


@pytest.mark.slow
def test_two_arcs_that_the_noise_does_not_connect_still_give_an_operator():
    basis = uniform_discretisation(TWIN_WELLS, UniformNoise(0.2), max_panels=32)
    moduli = np.sort(np.abs(np.linalg.eigvals(basis.matrix)))[::-1]
    np.testing.assert_allclose(moduli[:2], 1.0, atol=1e-6)
    assert moduli[2] < 0.9
