"""Noise laws: coefficients, densities, tails and samples agree with one another."""

import numpy as np
import pytest

from cyclemap.maps import (
    CircleMap,
    Noise,
    UniformNoise,
    VonMises,
    WrappedCauchy,
    WrappedNormal,
    mean_passage_time,
    transfer_operator,
)
from tests.maps.known_maps import TWO_PI, agree
from tests.refusals import refused

SMOOTH = [
    *(WrappedNormal(0.02), WrappedNormal(2.0), WrappedNormal(3.0), WrappedCauchy(0.7)),
    *(VonMises(0.3), VonMises(6.0), VonMises(2500.0)),
]
UNIFORM = [UniformNoise(0.04), UniformNoise(1.3), UniformNoise(2.2), UniformNoise(6.8)]
LAWS = SMOOTH + UNIFORM
ARCS = [(-0.3, 0.4), (1.0, 1.05), (-4.0, 2.0), (7.0, 9.0), (-0.01, 6.0), (2.5, 3.9), (3.0, 3.2)]


@pytest.mark.parametrize("law", LAWS, ids=repr)
@pytest.mark.parametrize("lifted", [False, True])
def test_densities_leave_their_argument_alone_and_are_the_callers_own(law, lifted):
    x = np.linspace(-3.0, 3.0, 7)
    kept = x.copy()
    first, again = law.density(x, lifted), law.density(x, lifted)
    assert np.array_equal(x, kept) and first.flags.writeable
    assert not np.shares_memory(first, again) and not np.shares_memory(first, x)
    assert np.shape(law.density(0.5, lifted)) == ()


@pytest.mark.parametrize("law", SMOOTH, ids=repr)
def test_coefficients_and_arcs_are_the_integrals_of_the_density(law):
    assert isinstance(law, Noise)
    count = 4096
    x = TWO_PI * np.arange(count) / count
    spectrum = np.fft.fft(law.density(x)) * TWO_PI / count
    m = np.arange(-40, 40)
    agree(spectrum[m].real, law.coefficients(m), 1e-12)
    nodes, weights = np.polynomial.legendre.leggauss(400)
    for low, high in ARCS:
        edges, half = np.linspace(low, high, 41), 0.5 * (high - low) / 40
        exact = half * float(np.sum(law.density(edges[:-1, None] + half * (1 + nodes)) * weights))
        assert abs(law.arc_probability(low, high) - exact) < 1e-13


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_the_tail_bounds_the_rest_of_the_coefficients(law):
    for m in (1, 3, 10, 40):
        rest = float(np.sum(law.coefficients(np.arange(m + 1, m + 4000))))
        assert rest <= law.tail(m) * (1 + 1e-12)
        assert np.isinf(law.tail(m)) == (law in UNIFORM)


@pytest.mark.parametrize("law", SMOOTH, ids=repr)
def test_slopes_are_the_derivatives_of_the_densities_and_are_odd(law):
    x = np.array([-3.0, -0.4, -0.02, 0.0, 0.03, 0.7, 2.9])
    steps = np.arange(-3.0, 4.0) * 1e-4 * min(1.0, np.sqrt(law.variance))
    weights = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60
    for lifted in (False, True):
        slope = law.slope(x, lifted)
        found = law.density(x[:, None] + steps, lifted) @ weights / steps[-3]
        agree(slope, found, 1e-9 * np.max(np.abs(slope)))
        np.testing.assert_allclose(law.slope(-x, lifted), -slope, rtol=1e-13, atol=1e-17)


@pytest.mark.slow
@pytest.mark.parametrize("law", UNIFORM, ids=repr)
def test_uniform_noise_overlaps_itself_exactly(law):
    """Lengths of overlaps counted on a fine grid of the line; coefficients by integration."""
    draws = law.halfwidth * ((np.arange(200_000) + 0.5) / 100_000 - 1)
    for low, high in ARCS:
        inside = np.mean(np.mod(draws - low, TWO_PI) < high - low)
        assert abs(law.arc_probability(low, high) - inside) < 2e-5
    m = np.arange(-4, 10)
    agree(law.coefficients(m), [np.mean(np.cos(k * draws)) for k in m], 1e-8)
    around = np.linspace(-np.pi, np.pi, 100_000, endpoint=False)
    assert law.density(around).mean() == pytest.approx(1 / TWO_PI, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "x", "exceedance"),
    [
        (WrappedNormal(0.05), 1.0, 2.7536241186061556951e-89),
        (VonMises(0.3), 3.0, 0.016341442468895095371),
        (VonMises(4.0), 3.0, 0.000037013525833152174052),
        (VonMises(900.0), 0.5, 3.9128230242364113966e-50),
    ],
)
def test_tails_agree_with_quadrature_in_sixty_digits(law, x, exceedance):
    assert abs(law.exceedance(x) / exceedance - 1) < 1e-12
    assert abs(law.exceedance(-x) / (1 - exceedance) - 1) < 1e-14
    # The arc from x round to -x on the other side is both tails.
    assert abs(law.arc_probability(x, TWO_PI - x) / (2 * exceedance) - 1) < 1e-12


@pytest.mark.parametrize(
    ("kappa", "order", "coefficient", "variance"),
    [
        (0.3, 5, 6.2113501718317589707e-7, 2.7073614819734041064),
        (900.0, 5, 0.9861995333212632598, 0.0011117291394254942303),
        (1e6, 40, 0.99920031951510975142, 1.0000005000005416675e-6),
    ],
)
def test_von_mises_coefficients_agree_with_bessel_functions_in_fifty_digits(
    kappa, order, coefficient, variance
):
    assert abs(VonMises(kappa).coefficients(order) / coefficient - 1) < 1e-14
    assert abs(VonMises(kappa).variance / variance - 1) < 1e-12


def test_concentrated_von_mises_noise_becomes_normal_without_a_seam():
    m = np.array([0.0, 3.0, 2e3, 1e4, 3e4])
    below, above = VonMises(1e8), VonMises(np.nextafter(1e8, 2e8))
    np.testing.assert_allclose(above.coefficients(m), below.coefficients(m), rtol=1e-11)
    for kappa in (1e10, 1e14):
        law, normal = VonMises(kappa), WrappedNormal(kappa**-0.5)
        x = np.array([0.0, 1.0, 4.0]) * normal.sigma
        np.testing.assert_allclose(law.density(x), normal.density(x), rtol=30 / kappa + 1e-14)
        np.testing.assert_allclose(law.exceedance(x), normal.exceedance(x), rtol=30 / kappa + 1e-13)


@pytest.mark.parametrize("law", [WrappedNormal(2.6), WrappedNormal(9.0), UniformNoise(40.0)])
def test_arcs_under_wide_noise_are_what_all_their_images_hold(law):
    low = np.linspace(-9.0, 9.0, 37)
    for length in (1e-9, 0.3, 3.0, 6.2):
        images = low[:, None] + TWO_PI * np.arange(-30, 31)
        held = law.exceedance(images) - law.exceedance(images + length)
        off = np.abs(law.arc_probability(low, low + length) - held.sum(axis=1))
        assert np.max(off) < 1e-14 * (1 + np.max(images) / law.variance**0.5)


@pytest.mark.parametrize("law", [WrappedNormal(1e9), UniformNoise(1e9), VonMises(1e-9)])
def test_the_widest_noise_makes_every_angle_alike_in_no_time(law):
    """Chances by the arc's length alone, and a passage that is left with the same chance each
    cycle.
    """
    map_there = CircleMap.arnold(0.1, 0.9)
    assert abs(law.arc_probability(0.5, 2.0) - 1.5 / TWO_PI) < 1e-8
    operator = transfer_operator(map_there, law)
    assert np.max(np.abs(operator.density(np.linspace(0.0, 6.0, 7)) - 1.0 / TWO_PI)) < 1e-8
    time = mean_passage_time(map_there, law, 1.0, (0.5, 2.0))
    assert abs(time - 1.0 / (1.0 - 1.5 / TWO_PI)) < 1e-7


@pytest.mark.parametrize("kind", [WrappedNormal, UniformNoise, VonMises])
def test_widths_whose_squares_leave_the_floats_are_refused(kind):
    for width in (0.0, -1.0, 1e-200, 1e200):
        refused(kind, width, told="from 1e-100 to 1e100")


def test_cauchy_arcs_far_from_a_narrow_law_keep_their_digits():
    """P = (s/2π)(cot(low/2) - cot(high/2)) to first order in s = 1 - r,
    with an error of order s²."""
    s = 1e-9
    law, expected = WrappedCauchy(1 - s), s / TWO_PI * (1 / np.tan(0.5) - 1 / np.tan(0.55))
    assert abs(law.arc_probability(1.0, 1.1) / expected - 1) < 1e-7
    assert abs(law.arc_probability(1.0, 1.1) / law.arc_probability(-1.1, -1.0) - 1) < 1e-14


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_samples_follow_the_law_and_its_line_density_is_minus_the_slope_of_the_exceedance(law):
    draws = law.sample(np.random.default_rng(5), 200_000)
    found = [np.mean(np.cos(m * draws)) for m in (1, 2, 3)]
    agree(found, law.coefficients(np.arange(1, 4)), 5 / np.sqrt(200_000))
    assert abs(np.mean(draws > 0.1) - law.exceedance(0.1)) < 5 / np.sqrt(200_000)
    if isinstance(law, WrappedCauchy):
        assert law.variance == np.inf
    else:
        assert abs(np.mean(draws**2) / law.variance - 1) < 5 * np.sqrt(2 / 200_000)
    x, step = np.array([-0.05, 0.01, 0.3]), 1e-6
    slope = (law.exceedance(x - step) - law.exceedance(x + step)) / (2 * step)
    np.testing.assert_allclose(slope, law.density(x, lifted=True), rtol=1e-6, atol=1e-8)
