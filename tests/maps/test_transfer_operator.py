"""Transfer operators: exact cases, known numbers, bounds that hold, Monte Carlo."""

import numpy as np
import pytest
from scipy.special import jv

from cyclemap.errors import InvalidInput
from cyclemap.maps import (
    CircleMap,
    WrappedCauchy,
    WrappedNormal,
    fixed_points,
    rotation_number,
    sample_staircase,
    transfer_operator,
)

TWO_PI = 2 * np.pi
GRID = np.linspace(0, TWO_PI, 400, endpoint=False)
STICKY = CircleMap.arnold(0.1, 0.9)


def jumping_map():
    """Three branches: two jumps (one upward, one downward) and a fold."""
    x = np.concatenate([np.linspace(0.5, 2.0, 30), np.linspace(2.0, 5.0, 60), np.linspace(5.0, 6.5, 30)])
    y = x + 0.3 + 0.2 * np.sin(2 * x)
    y[30:90] += 0.7 * np.cos(3 * x[30:90])
    slopes = 1 + 0.4 * np.cos(2 * x)
    slopes[30:90] -= 2.1 * np.sin(3 * x[30:90])
    return CircleMap.from_samples(x, y, slopes)


def test_known_moments_of_the_sine_map():
    law = transfer_operator(STICKY, WrappedNormal(0.05 * TWO_PI))
    assert abs(law.moment(1) - (0.62356060578345 + 0.69564930010307j)) < 1e-13
    assert abs(law.rotation_number - 3.5557770716e-4) < 1e-14
    law = transfer_operator(CircleMap.arnold(0.3, 3.0), WrappedNormal(0.1 * TWO_PI))
    assert abs(law.moment(1) - (0.18921693126040 + 0.38553752652743j)) < 1e-13
    assert abs(law.rotation_number - 0.11591939071721) < 1e-13


def test_the_matrix_of_the_sine_map_is_made_of_bessel_functions():
    omega, strength, sigma = 0.23, 1.7, 0.4
    m = np.arange(-25, 26)
    exact = (
        np.exp(-0.5 * (m * sigma) ** 2)[:, None]
        * np.exp(-2j * np.pi * m * omega)[:, None]
        * jv(m[:, None] - m[None, :], m[:, None] * strength)
    )
    values = np.linalg.eigvals(exact)
    values = values[np.argsort(-np.abs(values))][:9]
    found = transfer_operator(CircleMap.arnold(omega, strength), WrappedNormal(sigma)).eigenvalues(9)
    np.testing.assert_allclose(np.sort(np.abs(found)), np.sort(np.abs(values)), atol=1e-12)


def test_moebius_with_cauchy_noise_is_exactly_solvable():
    a, omega, r = 0.5, 0.3, 0.9
    law = transfer_operator(CircleMap.moebius(a, omega), WrappedCauchy(r))
    z = 0.2550616828143848456 - 0.2049307699033403712j
    exact = (1 - abs(z) ** 2) / (TWO_PI * np.abs(np.exp(1j * GRID) - z) ** 2)
    error = np.max(np.abs(law.density(GRID) - exact))
    assert error < 1e-14
    assert error <= law.error_bound < 1e-11
    for n in range(1, 6):
        assert abs(law.moment(n) - z**n) < 1e-14
        assert abs(law.moment(-n) - np.conj(z) ** n) < 1e-14
    slope = r * np.exp(2j * np.pi * omega) * (1 - a * a) / (1 - a * z) ** 2
    known = [1, slope, slope**2, slope**3]
    found = law.eigenvalues(7)
    np.testing.assert_allclose(np.abs(found[[0, 1, 3, 5]]), np.abs(known), atol=1e-11)
    np.testing.assert_allclose(np.sort_complex(found[1:3]), np.sort_complex([slope, np.conj(slope)]), atol=1e-11)
    assert abs(law.rotation_number - 0.2627872013171239726) < 1e-14


def test_a_rotation_has_uniform_law_and_the_noises_own_spectrum():
    noise = WrappedNormal(0.3)
    law = transfer_operator(CircleMap.rigid(0.17), noise)
    np.testing.assert_allclose(law.density(GRID), 0.5 / np.pi, rtol=1e-14)
    np.testing.assert_allclose(np.abs(law.eigenvalues(7))[1::2], noise.coefficients([1, 2, 3]), atol=1e-13)
    assert law.tv_from_uniform == 0.0
    assert law.peaks().size == 0
    assert abs(law.rotation_number - 0.17) < 1e-15
    assert abs(law.mixing_cycles - 2 / 0.09) < 1e-9
    assert abs(law.spectral_gap - (1 - np.exp(-0.045))) < 1e-13


@pytest.mark.parametrize("sigma", [0.5, 0.1, 0.03])
@pytest.mark.parametrize("circle_map", [STICKY, CircleMap.arnold(0.3, 3.0), jumping_map()], ids=repr)
def test_the_law_is_a_density_that_one_cycle_leaves_unchanged(circle_map, sigma):
    noise = WrappedNormal(sigma)
    law = transfer_operator(circle_map, noise)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    knots = np.linspace(0, TWO_PI, 801) if circle_map.pieces is None else circle_map.pieces.knots
    x = (knots[:-1, None] + np.diff(knots)[:, None] * 0.5 * (1 + nodes)).ravel()
    w = (0.5 * np.diff(knots)[:, None] * weights).ravel()
    density = law.density(x)
    assert abs(np.dot(w, density) - 1) < 1e-11
    after = noise.density(GRID[:, None] - circle_map(x)) @ (w * density)
    assert law.error_bound < 1e-8
    np.testing.assert_allclose(after, law.density(GRID), rtol=0, atol=law.error_bound + 1e-10)
    assert np.min(density) > -law.error_bound


def test_the_law_turns_with_the_map():
    angle = 0.9
    turned = CircleMap(lambda x: STICKY(x - angle) + angle, lambda x: STICKY.derivative(x - angle))
    one, other = (transfer_operator(m, WrappedNormal(0.2)) for m in (STICKY, turned))
    np.testing.assert_allclose(one.density(GRID), other.density(GRID + angle), atol=1e-12)
    assert abs(one.spectral_gap - other.spectral_gap) < 1e-11
    assert abs(one.tv_from_uniform - other.tv_from_uniform) < 1e-11


def test_monte_carlo_agrees_on_a_map_with_jumps_and_folds():
    circle_map, noise = jumping_map(), WrappedNormal(0.15)
    law = transfer_operator(circle_map, noise)
    path = sample_staircase(circle_map, noise, 400_000, seed=4)
    blocks = path.theta[1:].reshape(100, 4000)
    for n in (1, 2, 3):
        means = np.mean(np.exp(1j * n * blocks), axis=1)
        assert abs(np.mean(means) - law.moment(n)) < 5 * np.std(means) / 10
    turns = np.diff(path.theta).reshape(100, 4000).mean(axis=1)
    assert abs(turns.mean() - TWO_PI * law.rotation_number) < 5 * turns.std() / 10


def test_peaks_stand_at_the_stable_points_when_noise_is_small():
    for sigma, allowed in ((0.05, 2e-3), (0.02, 3e-4)):
        (peak,) = transfer_operator(STICKY, WrappedNormal(sigma)).peaks()
        assert abs(peak - fixed_points(STICKY)[0].points[0]) < allowed
    twin = CircleMap(lambda x: x - 0.4 * np.sin(2 * x), lambda x: 1 - 0.8 * np.cos(2 * x))
    peaks = transfer_operator(twin, WrappedNormal(0.2)).peaks()
    np.testing.assert_allclose(np.sort(np.mod(peaks + 0.5, TWO_PI)), [0.5, np.pi + 0.5], atol=1e-9)


def test_total_variation_is_half_the_integral_of_the_difference():
    law = transfer_operator(STICKY, WrappedNormal(0.3))
    fine = TWO_PI * (np.arange(200_000) + 0.5) / 200_000
    plain = 0.5 * np.mean(np.abs(law.density(fine) - 0.5 / np.pi)) * TWO_PI
    assert abs(law.tv_from_uniform - plain) < 1e-9


def test_small_noise_recovers_the_noiseless_rotation_number():
    sine = CircleMap.arnold(0.6, 0.5)
    truth = rotation_number(sine).value
    errors = [abs(transfer_operator(sine, WrappedNormal(sigma)).rotation_number - truth) for sigma in (0.2, 0.1, 0.05)]
    assert errors[2] < 2e-6
    assert errors[2] < 0.35 * errors[1] < 0.35 * errors[0]


def test_leading_eigenvalues_agree_with_the_whole_spectrum():
    law = transfer_operator(STICKY, WrappedNormal(0.04))
    assert 2 * law.modes > 400
    whole = np.linalg.eigvals(law._matrix)
    whole = np.sort(np.abs(whole))[::-1][:4]
    np.testing.assert_allclose(np.abs(law.eigenvalues(5))[1:], whole, atol=1e-10)


def test_what_cannot_be_computed_is_refused():
    for noise in (None, 0.1, "WrappedNormal"):
        with pytest.raises(InvalidInput, match="noise"):
            transfer_operator(STICKY, noise)
    with pytest.raises(InvalidInput, match="raise its width"):
        transfer_operator(STICKY, WrappedNormal(1e-3))
    with pytest.raises(InvalidInput):
        transfer_operator(lambda x: x, WrappedNormal(0.1))
    doubling = transfer_operator(CircleMap(lambda x: 2 * x, degree=2), WrappedNormal(0.2))
    np.testing.assert_allclose(doubling.density(GRID), 0.5 / np.pi, rtol=1e-12)
    with pytest.raises(InvalidInput, match="degree"):
        _ = doubling.rotation_number
    with pytest.raises(InvalidInput):
        doubling.density([np.nan])
    with pytest.raises(InvalidInput):
        doubling.eigenvalues(0)
    with pytest.raises(InvalidInput):
        doubling.moment(0.5)
