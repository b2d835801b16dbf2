"""Noise laws: coefficients, densities, tails and samples agree with one another."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import Noise, UniformNoise, VonMises, WrappedCauchy, WrappedNormal

TWO_PI = 2 * np.pi
SMOOTH = [
    WrappedNormal(0.02),
    WrappedNormal(0.4),
    WrappedNormal(2.0),
    WrappedNormal(3.0),
    WrappedCauchy(0.7),
    VonMises(0.3),
    VonMises(6.0),
    VonMises(2500.0),
]
UNIFORM = [UniformNoise(0.04), UniformNoise(1.3), UniformNoise(2.2), UniformNoise(6.8)]
LAWS = SMOOTH + UNIFORM
PARAMETER = {WrappedNormal: "sigma", WrappedCauchy: "r", VonMises: "kappa", UniformNoise: "halfwidth"}
ARCS = [(-0.3, 0.4), (1.0, 1.05), (-4.0, 2.0), (7.0, 9.0), (-0.01, 6.0), (2.5, 3.9), (3.0, 3.2)]


def parameter_slope(law, function):
    """d/d(parameter) of function(law) by differences of sixth order."""
    kind, at = type(law), getattr(law, PARAMETER[type(law)])
    step = 4e-3 * at * (1 - at if kind is WrappedCauchy else 1)
    weights = {1: 0.75, 2: -0.15, 3: 1 / 60}
    return sum(w * (function(kind(at + k * step)) - function(kind(at - k * step))) for k, w in weights.items()) / step


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_densities_leave_their_argument_alone_and_are_the_callers_own(law):
    """Kernels are worked on in place: what a law is asked at stays as it was, and nothing that it returns is shared."""
    x = np.linspace(-3.0, 3.0, 7)
    kept = x.copy()
    for density in (law.density, law.line_density):
        first = density(x)
        again = density(x)
        assert np.array_equal(x, kept) and first.flags.writeable and not np.shares_memory(first, again)
        assert not np.shares_memory(first, x) and np.shape(density(0.5)) == ()


@pytest.mark.parametrize("law", SMOOTH, ids=repr)
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


@pytest.mark.parametrize("law", SMOOTH, ids=repr)
def test_arc_probability_is_the_integral_of_the_density(law):
    nodes, weights = np.polynomial.legendre.leggauss(400)
    checked = 0
    for low, high in ARCS:
        half = 0.5 * (high - low)
        edges = np.linspace(low, high, 41)
        parts = edges[:-1, None] + half / 40 * (1 + nodes)
        exact = float(np.sum(law.density(parts) * weights) * half / 40)
        assert abs(law.arc_probability(low, high) - exact) < 1e-13
        checked += 1
    assert checked == len(ARCS)


@pytest.mark.parametrize("law", SMOOTH, ids=repr)
def test_every_rate_is_the_derivative_in_the_laws_own_parameter(law):
    x = np.array([-3.0, -0.4, -0.02, 0.0, 0.03, 0.7, 2.9, 4.0])
    low, high = np.array(ARCS).T
    m = np.arange(-3, 30)
    for rate, value in (
        (law.rate(x), lambda other: other.density(x)),
        (law.line_rate(x), lambda other: other.line_density(x)),
        (law.exceedance_rate(x), lambda other: other.exceedance(x)),
        (law.coefficient_rates(m), lambda other: other.coefficients(m)),
        (law.arc_probability_rate(low, high), lambda other: other.arc_probability(low, high)),
    ):
        scale = np.max(np.abs(rate)) + 1e-6 / getattr(law, PARAMETER[type(law)])
        np.testing.assert_allclose(rate, parameter_slope(law, value), rtol=0, atol=2e-9 * scale)


@pytest.mark.parametrize("law", SMOOTH, ids=repr)
def test_slopes_are_the_derivatives_of_the_densities_and_are_odd(law):
    x = np.array([-3.0, -0.4, -0.02, 0.0, 0.03, 0.7, 2.9])
    step = 1e-4 * min(1.0, np.sqrt(law.variance))
    weights = {1: 0.75, 2: -0.15, 3: 1 / 60}
    for slope, density in ((law.slope, law.density), (law.line_slope, law.line_density)):
        found = sum(w * (density(x + k * step) - density(x - k * step)) for k, w in weights.items()) / step
        np.testing.assert_allclose(slope(x), found, rtol=0, atol=1e-9 * np.max(np.abs(slope(x))))
        np.testing.assert_allclose(slope(-x), -slope(x), rtol=1e-13, atol=1e-17)


@pytest.mark.slow
@pytest.mark.parametrize("law", UNIFORM, ids=repr)
def test_uniform_noise_overlaps_itself_exactly(law):
    """Lengths of overlaps counted on a fine grid of the line; rates by differences; coefficients by integration."""
    draws = law.halfwidth * ((np.arange(400_000) + 0.5) / 200_000 - 1)
    checked = 0
    for low, high in ARCS:
        inside = np.mean(np.mod(draws - low, TWO_PI) < high - low)
        assert abs(law.arc_probability(low, high) - inside) < 2e-5
        moved = parameter_slope(law, lambda other, arc=(low, high): other.arc_probability(*arc))
        assert abs(law.arc_probability_rate(low, high) - moved) < 1e-9 / law.halfwidth
        checked += 1
    assert checked == len(ARCS)
    m = np.arange(-4, 10)
    np.testing.assert_allclose(law.coefficients(m), [np.mean(np.cos(k * draws)) for k in m], rtol=0, atol=1e-8)
    moved = parameter_slope(law, lambda other: other.coefficients(m))
    np.testing.assert_allclose(law.coefficient_rates(m), moved, rtol=0, atol=1e-6 / law.halfwidth)
    x = np.array([-1.7, -0.03, 0.0, 0.5, 2.5])
    moved = parameter_slope(law, lambda other: other.exceedance(x))
    np.testing.assert_allclose(law.exceedance_rate(x), moved, rtol=0, atol=1e-10 / law.halfwidth)
    assert law.density(np.linspace(-np.pi, np.pi, 100_000, endpoint=False)).mean() == pytest.approx(
        1 / TWO_PI, rel=1e-3
    )


def test_uniform_noise_has_no_density_slope_and_no_summable_coefficients():
    law = UniformNoise(0.5)
    assert law.tail(10**6) == np.inf
    for refused in (law.slope, law.rate, law.line_slope, law.line_rate):
        with pytest.raises(InvalidInput, match=r"uniform noise has no density (slope|rate)"):
            refused(0.1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kappa", "x", "exceedance", "rate"),
    [
        (0.3, 3.0, 0.016341442468895095371, -0.018710897518544491322),
        (4.0, 0.5, 0.1705115359940144912, -0.033090231197291240966),
        (4.0, 3.0, 0.000037013525833152174052, -0.000068850665101639854383),
        (900.0, 0.05, 0.066854452278199893766, -0.00010799416137350697103),
        (900.0, 0.5, 3.9128230242364113966e-50, -4.8115293652080407514e-51),
    ],
)
def test_von_mises_tails_agree_with_quadrature_in_sixty_digits(kappa, x, exceedance, rate):
    law = VonMises(kappa)
    assert abs(law.exceedance(x) / exceedance - 1) < 1e-13
    assert abs(law.exceedance(-x) / (1 - exceedance) - 1) < 1e-14
    assert abs(law.exceedance_rate(x) / rate - 1) < 1e-12
    assert abs(law.exceedance_rate(-x) / rate + 1) < 1e-12
    # The arc from x round to -x on the other side is both tails.
    assert abs(law.arc_probability(x, TWO_PI - x) / (2 * exceedance) - 1) < 1e-13
    assert abs(law.arc_probability_rate(x - TWO_PI, -x) / (2 * rate) - 1) < 1e-12


def test_von_mises_coefficients_agree_with_bessel_functions_in_fifty_digits():
    known = {
        0.3: (6.2113501718317589707e-7, 0.000010275632780601966879, 2.7073614819734041064),
        4.0: (0.044658277171854079983, 0.03092654111037077958, 0.29822837767374475455),
        900.0: (0.9861995333212632598, 0.000015235951395282971549, 0.0011117291394254942303),
        1e6: (0.99998750007187477188, 1.2499856250684373501e-11, 1.0000005000005416675e-6),
    }
    for kappa, (coefficient, rate, variance) in known.items():
        law = VonMises(kappa)
        assert abs(law.coefficients(5) / coefficient - 1) < 1e-14
        assert abs(law.coefficient_rates(5) - rate) < 1e-15 / kappa
        assert abs(law.variance / variance - 1) < 1e-12
    assert abs(VonMises(1e6).coefficients(40) / 0.99920031951510975142 - 1) < 1e-14


def test_concentrated_von_mises_noise_becomes_normal_without_a_seam():
    m = np.array([0.0, 3.0, 2e3, 1e4, 3e4])
    below, above = VonMises(1e8), VonMises(np.nextafter(1e8, 2e8))
    np.testing.assert_allclose(above.coefficients(m), below.coefficients(m), rtol=1e-11)
    for kappa in (1e10, 1e14):
        law, normal = VonMises(kappa), WrappedNormal(kappa**-0.5)
        x = np.array([0.0, 1.0, 4.0]) * normal.sigma
        np.testing.assert_allclose(law.density(x), normal.density(x), rtol=30 / kappa + 1e-14)
        np.testing.assert_allclose(law.exceedance(x), normal.exceedance(x), rtol=30 / kappa + 1e-13)
        np.testing.assert_allclose(law.coefficient_rates(m), 0.5 * m**2 / kappa**2 * law.coefficients(m), rtol=1e-6)


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


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_variance_is_that_of_a_draw_on_the_line(law):
    assert isinstance(law, Noise)
    draws = law.sample(np.random.default_rng(3), 200_000)
    if isinstance(law, WrappedCauchy):
        assert law.variance == np.inf
    else:
        assert abs(np.mean(draws**2) / law.variance - 1) < 5 * np.sqrt(2 / 200_000)


def test_cauchy_arcs_far_from_a_narrow_law_keep_their_digits():
    """P = (s/2π)(cot(low/2) - cot(high/2)) to first order in s = 1 - r, with an error of order s²."""
    s = 1e-9
    law, expected = WrappedCauchy(1 - s), s / TWO_PI * (1 / np.tan(0.5) - 1 / np.tan(0.55))
    assert abs(law.arc_probability(1.0, 1.1) / expected - 1) < 1e-7
    assert abs(law.arc_probability(1.0, 1.1) / law.arc_probability(-1.1, -1.0) - 1) < 1e-14
    assert abs(-law.arc_probability_rate(1.0, 1.1) * s / law.arc_probability(1.0, 1.1) - 1) < 1e-7


@pytest.mark.parametrize("law", [WrappedNormal, VonMises, UniformNoise])
@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf, "wide"])
def test_noise_of_no_width_is_refused(law, bad):
    with pytest.raises(InvalidInput, match=PARAMETER[law]):
        law(bad)


@pytest.mark.parametrize("bad", [0.0, 1.0, 1.5, np.nan])
def test_resultants_outside_zero_to_one_are_refused(bad):
    with pytest.raises(InvalidInput, match="r "):
        WrappedCauchy(bad)
