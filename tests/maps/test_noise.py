"""Noise laws: coefficients, densities, tails and samples agree with one another."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import Noise, WrappedCauchy, WrappedNormal

TWO_PI = 2 * np.pi
LAWS = [WrappedNormal(0.02), WrappedNormal(0.4), WrappedNormal(2.0), WrappedNormal(3.0), WrappedCauchy(0.7)]


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_coefficients_are_the_fourier_coefficients_of_the_density(law):
    assert isinstance(law, Noise)
    count = 4096
    x = TWO_PI * np.arange(count) / count
    spectrum = np.fft.fft(law.density(x)) * TWO_PI / count
    np.testing.assert_allclose(spectrum[:40], law.coefficients(np.arange(40)), rtol=0, atol=1e-12)
    np.testing.assert_allclose(law.coefficients(-np.arange(5)), law.coefficients(np.arange(5)))


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_the_tail_bounds_the_rest_of_the_coefficients(law):
    for m in (1, 3, 10, 40):
        rest = float(np.sum(law.coefficients(np.arange(m + 1, m + 4000))))
        assert rest <= law.tail(m) * (1 + 1e-12)


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_arc_probability_is_the_integral_of_the_density(law):
    nodes, weights = np.polynomial.legendre.leggauss(400)
    checked = 0
    for low, high in ((-0.3, 0.4), (1.0, 1.05), (-4.0, 2.0), (7.0, 9.0), (-0.01, 6.0)):
        half = 0.5 * (high - low)
        edges = np.linspace(low, high, 41)
        parts = edges[:-1, None] + half / 40 * (1 + nodes)
        exact = float(np.sum(law.density(parts) * weights) * half / 40)
        assert abs(law.arc_probability(low, high) - exact) < 1e-13
        checked += 1
    assert checked == 5


def test_small_arc_probabilities_keep_their_digits():
    law = WrappedNormal(0.05)
    # P(ξ > 1) for σ = 0.05 is erfc(20/√2)/2 = 2.7536241186061556951e-89; the arc's far end adds nothing.
    assert abs(law.arc_probability(1.0, 3.0) / 2.7536241186061556951e-89 - 1) < 1e-12
    assert abs(law.exceedance(1.0) / 2.7536241186061556951e-89 - 1) < 1e-12


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_samples_follow_the_law(law):
    draws = law.sample(np.random.default_rng(5), 200_000)
    found = [np.mean(np.cos(m * draws)) for m in (1, 2, 3)]
    np.testing.assert_allclose(found, law.coefficients(np.arange(1, 4)), rtol=0, atol=5 / np.sqrt(200_000))
    assert abs(np.mean(draws > 0.1) - law.exceedance(0.1)) < 5 / np.sqrt(200_000)


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_line_density_is_minus_the_slope_of_the_exceedance(law):
    x, step = np.array([-0.05, 0.01, 0.3]), 1e-6
    slope = (law.exceedance(x - step) - law.exceedance(x + step)) / (2 * step)
    np.testing.assert_allclose(slope, law.line_density(x), rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf, "wide"])
def test_noise_of_no_width_is_refused(bad):
    with pytest.raises(InvalidInput):
        WrappedNormal(bad)


@pytest.mark.parametrize("bad", [0.0, 1.0, 1.5, np.nan])
def test_resultants_outside_zero_to_one_are_refused(bad):
    with pytest.raises(InvalidInput):
        WrappedCauchy(bad)
