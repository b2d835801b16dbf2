"""Blaschke products and the other textbook maps: against complex arithmetic, and as a group."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap

TWO_PI = 2 * np.pi
GRID = np.linspace(-15.0, 15.0, 3001)


def random_zeros(seed, count, reach=0.95):
    rng = np.random.default_rng(seed)
    return rng.uniform(0, reach, count) * np.exp(1j * rng.uniform(0, TWO_PI, count))


@pytest.mark.parametrize("seed", range(12))
def test_a_blaschke_product_is_the_product_of_its_factors_and_its_slope_the_sum_of_poisson_kernels(seed):
    zeros, omega = random_zeros(seed, seed % 5 + 1), 0.1 * seed
    made = CircleMap.blaschke(zeros, omega)
    z = np.exp(1j * GRID)
    product = np.exp(2j * np.pi * omega) * np.prod([(z - a) / (1 - np.conj(a) * z) for a in zeros], axis=0)
    np.testing.assert_allclose(np.exp(1j * made(GRID)), product, rtol=0, atol=3e-13)
    kernels = np.sum([(1 - abs(a) ** 2) / np.abs(z - a) ** 2 for a in zeros], axis=0)
    np.testing.assert_allclose(made.derivative(GRID), kernels, rtol=3e-13)
    np.testing.assert_allclose(made(GRID + TWO_PI) - made(GRID), TWO_PI * zeros.size, rtol=1e-12)
    assert made.degree == zeros.size
    one = made.scalar()
    np.testing.assert_allclose([one(x) for x in GRID[::50]], made(GRID[::50]), rtol=0, atol=3e-14)


def test_one_real_zero_is_the_moebius_map_and_zeros_at_the_origin_multiply_the_angle_exactly():
    for a, omega in [(0.0, 0.3), (0.5, 0.1), (0.95, 0.77)]:
        two = CircleMap.blaschke([a], omega), CircleMap.moebius(a, omega)
        np.testing.assert_allclose(two[0](GRID), two[1](GRID), rtol=0, atol=4e-15)
        np.testing.assert_allclose(two[0].derivative(GRID), two[1].derivative(GRID), rtol=1e-13)
    assert np.array_equal(CircleMap.blaschke([0, 0])(GRID), 2 * GRID)
    assert np.array_equal(CircleMap.blaschke([0, 0, 0j]).derivative(GRID), np.full(GRID.size, 3.0))


def test_a_zero_close_to_the_circle_costs_no_digits():
    """Against tan(F/2) = (1 + a)/(1 - a)·tan(θ/2), which is exact for Ω = 0."""
    a = 1 - 2.0**-30
    made, x = CircleMap.moebius(a, 0.0), np.array([1e-12, 1e-10, 1e-9, 3e-9, 1e-6, 0.1, 2.0])
    np.testing.assert_allclose(made(x), 2 * np.arctan((1 + a) / (1 - a) * np.tan(x / 2)), rtol=4e-15)
    assert made.derivative(0.0) == (1 + a) / (1 - a)


def test_a_blaschke_product_with_a_zero_at_the_origin_keeps_the_uniform_law():
    """B(0) = 0 makes the mean of exp(i k F) over the circle vanish for every k (mean value property)."""
    made = CircleMap.blaschke([0, 0.6, 0.3 - 0.5j])
    x = TWO_PI * np.arange(4096) / 4096
    means = [np.mean(np.exp(1j * k * made(x))) for k in range(1, 6)]
    np.testing.assert_allclose(means, 0.0, atol=1e-13)


@pytest.mark.parametrize(
    ("zeros", "message"),
    [
        ([], "shape \\(0,\\)"),
        ([1.0], "zeros\\[0\\] is 1"),
        ([0.1, 0.8 + 0.7j], "zeros\\[1\\] is 0.8\\+0.7j"),
        ([0.1, np.nan], "zeros\\[1\\] is nan"),
        (0.5, "shape \\(\\)"),
        (["a"], "complex numbers only"),
    ],
)
def test_what_is_no_list_of_zeros_inside_the_circle_is_refused_by_name(zeros, message):
    with pytest.raises(InvalidInput, match=message):
        CircleMap.blaschke(zeros)


def test_a_moebius_parameter_outside_its_range_is_refused_and_the_way_out_named():
    with pytest.raises(InvalidInput, match=r"a is -0.5.*blaschke"):
        CircleMap.moebius(-0.5, 0.0)
