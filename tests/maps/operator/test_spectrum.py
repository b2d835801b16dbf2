"""Eigenvalues of transfer operators, and linear response."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, UniformNoise, VonMises, WrappedCauchy, WrappedNormal, transfer_operator

TWO_PI = 2 * np.pi
Z_STAR = 0.2550616828143848456 - 0.2049307699033403712j


def test_moebius_with_cauchy_noise_has_powers_of_its_multiplier_and_their_conjugates():
    """With g = rB, B the Möbius map of the disc, the eigenvalues are g'(z*)^n and their conjugates."""
    a, omega, r = 0.5, 0.3, 0.9
    multiplier = r * np.exp(2j * np.pi * omega) * (1 - a * a) / (1 - a * Z_STAR) ** 2
    known = np.array([multiplier**n for n in range(1, 5)])
    found = transfer_operator(CircleMap.moebius(a, omega), WrappedCauchy(r)).spectrum(9)
    assert found.values.size == 9 and found.values[0] == 1.0 and found.error_bounds[0] == 0.0
    for value, bound in zip(found.values[1:], found.error_bounds[1:], strict=True):
        error = min(np.min(np.abs(value - known)), np.min(np.abs(value - np.conj(known))))
        assert error <= bound < 1e-10
    assert found.error_bounds[1] < 1e-12


def test_a_rotation_has_the_noises_coefficients_turned():
    omega, noise = 0.17, WrappedNormal(0.3)
    found = transfer_operator(CircleMap.rigid(omega), noise).spectrum(7)
    m = np.array([1, 1, 2, 2, 3, 3])
    np.testing.assert_allclose(np.abs(found.values[1:]), noise.coefficients(m), atol=1e-14)
    np.testing.assert_allclose(
        found.values[1::2], noise.coefficients(m[::2]) * np.exp(2j * np.pi * np.array([1, 2, -3]) * omega), atol=1e-13
    )
    np.testing.assert_allclose(found.condition, 1.0, rtol=1e-10)
    assert np.all(found.error_bounds < 1e-13)


def test_vectors_belong_to_their_values_and_are_biorthogonal():
    law = transfer_operator(CircleMap.arnold(0.3, 3.0), WrappedNormal(0.3))
    found, matrix = law.spectrum(5), law.discretisation.matrix
    np.testing.assert_allclose(matrix @ found.right, found.right * found.values, atol=1e-13)
    np.testing.assert_allclose(matrix.T @ found.left, found.left * found.values, atol=1e-13)
    np.testing.assert_allclose(found.left.T @ found.right, np.eye(5), atol=1e-11)
    assert np.all(found.condition >= 1.0 - 1e-12)
    np.testing.assert_array_equal(np.round(found.values, 12), np.round(law.eigenvalues(5), 12))


def test_bounds_hold_with_few_modes():
    """The three leading values with half the modes are as near the truth as their bounds say, and not much nearer."""
    circle_map, checked = CircleMap.arnold(0.3, 3.0), 0
    for noise in (WrappedNormal(0.3), WrappedNormal(0.15), WrappedCauchy(0.7)):
        full = transfer_operator(circle_map, noise)
        truth = full.eigenvalues(12)
        few = transfer_operator(circle_map, noise, modes=full.modes // 2).spectrum(4)
        for value, bound in zip(few.values[1:], few.error_bounds[1:], strict=True):
            error = np.min(np.abs(truth - value))
            assert error <= bound <= 100 * error + 1e-11
            checked += 1
    assert checked == 9


def test_a_nilpotent_operator_admits_that_its_values_are_not_to_be_trusted():
    """The doubling map halves frequencies: all eigenvalues but 1 are 0, and defective; rounding moves them far."""
    found = transfer_operator(CircleMap(lambda x: 2 * x, degree=2), WrappedNormal(0.3)).spectrum(4)
    assert np.all(np.abs(found.values[1:]) <= found.error_bounds[1:])
    assert np.min(found.condition[1:]) > 1e4


NOISES = [UniformNoise(0.3), WrappedNormal(0.3), WrappedCauchy(0.6)]


@pytest.mark.slow
@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("degree", [2, 3, 4])
def test_the_gap_of_a_multiplication_is_one_within_bounds_that_say_something(degree, noise):
    """θ → kθ divides frequencies by k, so that every eigenvalue but the first is 0."""
    slope = float(degree)
    law = transfer_operator(CircleMap(lambda x: slope * x, lambda x: slope + 0 * x, degree=degree), noise)
    assert law.spectral_gap.holds(1.0) and law.spectral_gap.error_bound < 0.1
    assert law.mixing_cycles.holds(0.0) and law.mixing_cycles.error_bound < 0.5
    assert np.all(np.abs(law.spectrum(4).values[1:]) <= law.spectrum(4).error_bounds[1:])


def test_the_gap_of_a_rotation_is_sharp_where_its_eigenvalues_are_double():
    for omega in (0.0, 0.5):
        gap = transfer_operator(CircleMap.rigid(omega), WrappedNormal(0.3)).spectral_gap
        assert gap.holds(1 - np.exp(-0.045)) and gap.error_bound < 1e-13


def test_large_operators_are_solved_by_arnoldi_to_the_same_values():
    law = transfer_operator(CircleMap.arnold(0.3, 3.0), WrappedNormal(0.04))
    assert law.discretisation.size > 320
    whole = np.sort(np.abs(np.linalg.eigvals(law.discretisation.matrix)))[::-1][:4]
    found = law.spectrum(4)
    np.testing.assert_allclose(np.abs(found.values), whole, atol=1e-10)
    assert np.all(found.error_bounds < 1e-9)


def test_the_gap_and_the_mixing_time_are_one_number():
    law = transfer_operator(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.2))
    assert abs(np.exp(-1 / law.mixing_cycles) - (1 - law.spectral_gap)) < 1e-14
    assert law.mixing_cycles.error_bound < 1e-9
    assert law.spectral_gap.error_bound < 1e-11


def test_slow_mixing_between_wells_is_the_rate_of_escape():
    """For two equal wells 1 - λ₂ = 2/T, T the mean time from one well to the bottom of the other (Kramers 1940)."""
    twin = CircleMap(lambda x: x - 0.4 * np.sin(2 * x), lambda x: 1 - 0.8 * np.cos(2 * x))
    law = transfer_operator(twin, WrappedNormal(0.28))
    hop = law.mean_passage_time(0.0, (0.5 - np.pi, np.pi - 0.5))
    assert law.spectral_gap == pytest.approx(2.0 / hop, rel=1e-3)
    assert 1e-6 < law.spectral_gap < 1e-4


def test_what_makes_no_sense_is_refused():
    law = transfer_operator(CircleMap.rigid(0.1), WrappedNormal(0.5))
    for count in (0, -1, 1.5, None):
        with pytest.raises(InvalidInput, match="k must"):
            law.spectrum(count)


@pytest.mark.parametrize("halfwidth", [0.5, 2.0])
def test_eigenvalues_under_uniform_noise_are_the_coefficients_of_a_rotation_within_their_bounds(halfwidth):
    """A rotation by Ω has the eigenvalues e^{2πimΩ} sin(mh)/(mh), whatever the panels."""
    found = transfer_operator(CircleMap.rigid(0.3), UniformNoise(halfwidth)).spectrum(5)
    order = np.array([1.0, 2.0])
    moduli = np.sort(np.repeat(np.abs(np.sin(order * halfwidth) / (order * halfwidth)), 2))[::-1]
    assert np.all(np.isfinite(found.error_bounds)) and np.all(found.error_bounds < 1e-7)
    assert np.all(np.abs(np.abs(found.values[1:]) - moduli) <= found.error_bounds[1:] + 1e-12)


@pytest.mark.slow
def test_gap_and_response_under_uniform_noise_have_bounds_that_hold_against_fourier_modes():
    """Fourier modes, whose coefficients fall as 1/m, come near the panels' gap as their number grows."""
    sine, noise = CircleMap.arnold(0.3, 0.5), UniformNoise(1.0)
    found = transfer_operator(sine, noise)
    modes = np.arange(-300, 301)
    grid = TWO_PI * np.arange(2_048) / 2_048
    waves = np.exp(1j * np.multiply.outer(modes, grid))
    matrix = noise.coefficients(modes)[:, None] * (np.exp(-1j * np.multiply.outer(modes, sine(grid))) @ waves.T) / 2_048
    second = np.sort(np.abs(np.linalg.eigvals(matrix)))[-2]
    assert abs(found.spectral_gap - (1.0 - second)) < found.spectral_gap.error_bound + 1e-9
    assert found.spectral_gap.error_bound < 1e-9
    moved = transfer_operator(CircleMap.arnold(0.3 + 1e-4 / TWO_PI, 0.5), noise).rotation_number
    back = transfer_operator(CircleMap.arnold(0.3 - 1e-4 / TWO_PI, 0.5), noise).rotation_number
    response = found.map_response(np.ones_like).rotation_number
    assert response.error_bound < 1e-9
    assert abs(response - (moved - back) / 2e-4) < 1e-7


GRID = np.linspace(0, TWO_PI, 300, endpoint=False)
NOISE = WrappedNormal(0.4)


def central(function, step=1e-3):
    """The derivative at 0 by differences of fourth order."""
    near, far = function(step) - function(-step), function(2 * step) - function(-2 * step)
    return (8 * near - far) / (12 * step)


def moving(p):
    """Two branches whose shapes and both of whose ends, jumps of F, depend on p."""
    first, last = 2.0 + 0.7 * p, 5.0 - p

    def inside(x):
        return (np.mod(x, TWO_PI) >= first) & (np.mod(x, TWO_PI) < last)

    def lift(x):
        return x + 0.5 + np.where(inside(x), 1.0 + 0.3 * np.sin(x) + p * np.cos(x), 0.1 * np.sin(x) - 0.2)

    def slope(x):
        return 1 + np.where(inside(x), 0.3 * np.cos(x) - p * np.sin(x), 0.1 * np.cos(x))

    return CircleMap(lift, slope, [first, last])


def inner(x):
    return (np.mod(x, TWO_PI) >= 2.0) & (np.mod(x, TWO_PI) < 5.0)


def sine_families():
    for omega, strength in ((0.1, 0.9), (0.3, 3.0)):
        law = transfer_operator(CircleMap.arnold(omega, strength), NOISE)
        yield (
            lambda p, o=omega, k=strength: (CircleMap.arnold(o + p / TWO_PI, k), NOISE),
            law.map_response(np.ones_like),
        )
        yield (
            lambda p, o=omega, k=strength: (CircleMap.arnold(o, k + p), NOISE),
            law.map_response(lambda x: -np.sin(x)),
        )
        yield lambda p, o=omega, k=strength: (CircleMap.arnold(o, k), WrappedNormal(0.4 + p)), law.noise_response()


def other_families():
    moebius = CircleMap.moebius(0.5, 0.3)
    yield lambda p: (moebius, VonMises(6.0 + p)), transfer_operator(moebius, VonMises(6.0)).noise_response()
    yield lambda p: (moebius, WrappedCauchy(0.6 + p)), transfer_operator(moebius, WrappedCauchy(0.6)).noise_response()
    law = transfer_operator(moving(0.0), NOISE)
    yield lambda p: (moving(p), NOISE), law.map_response(lambda x: np.where(inner(x), np.cos(x), 0.0), [0.7, -1.0])


CASES = [*sine_families(), *other_families()]


@pytest.mark.parametrize("case", range(len(CASES)))
def test_responses_are_the_derivatives_of_whole_computations(case):
    family, response = CASES[case]

    def of(number):
        return central(lambda p: number(transfer_operator(*family(p))))

    difference = of(lambda law: law.density(GRID))
    assert np.max(np.abs(difference)) > 1e-3
    np.testing.assert_allclose(response.density(GRID), difference, atol=1e-7)
    assert response.density_error < 1e-12
    assert abs(response.moment(2) - of(lambda law: law.moment(2))) < 5e-8
    assert response.moment_error(2) < 1e-12
    for name in ("rotation_number", "spectral_gap"):
        found = getattr(response, name)
        assert abs(found - of(lambda law, name=name: float(getattr(law, name)))) < 3e-7
        assert found.error_bound < 1e-11
    assert response.second_modulus == -response.spectral_gap


@pytest.mark.slow
def test_moebius_with_cauchy_noise_has_closed_derivatives():
    """z* = rB(z*) moves by dz* = B/(1 - rB') with r, and the mean of e^{inθ} by n z*^{n-1} dz*."""
    a, omega, r, z = 0.5, 0.3, 0.9, 0.2550616828143848456 - 0.2049307699033403712j
    turned = np.exp(2j * np.pi * omega)
    image, slope = turned * (z - a) / (1 - a * z), turned * (1 - a * a) / (1 - a * z) ** 2
    law = transfer_operator(CircleMap.moebius(a, omega), WrappedCauchy(r))
    to_noise, to_map = law.noise_response(), law.map_response(np.ones_like)
    for response, motion in ((to_noise, image / (1 - r * slope)), (to_map, 1j * r * image / (1 - r * slope))):
        for n in (1, 2, 3):
            error = abs(response.moment(n) - n * z ** (n - 1) * motion)
            assert error <= response.moment_error(n) < 1e-11
            assert error < 1e-12


def test_the_law_keeps_its_mass_and_a_turned_map_turns_the_law():
    """∫ dp = 0; and for F(θ - s) + s the law is p(θ - s): the response to s is -p'."""
    circle_map = CircleMap.arnold(0.2, 0.8)
    law = transfer_operator(circle_map, NOISE)
    response = law.map_response(lambda x: 1 - circle_map.derivative(x))
    assert abs(response.expectation(np.ones_like)) < 1e-14
    step = 1e-3
    slope = (8 * (law.density(GRID + step) - law.density(GRID - step))) / (12 * step)
    slope -= (law.density(GRID + 2 * step) - law.density(GRID - 2 * step)) / (12 * step)
    np.testing.assert_allclose(response.density(GRID), -slope, atol=1e-10)
    assert abs(response.spectral_gap) <= response.spectral_gap.error_bound < 1e-11
    assert abs(response.rotation_number) < 1e-14


def test_errors_of_truncated_responses_hold():
    circle_map, checked = CircleMap.arnold(0.3, 3.0), 0
    full = transfer_operator(circle_map, NOISE)
    for modes in (6, 9, 12):
        few, all_modes = (law.map_response(np.sin) for law in (transfer_operator(circle_map, NOISE, modes=modes), full))
        error = np.max(np.abs(few.density(GRID) - all_modes.density(GRID)))
        assert error <= few.density_error <= 3 * error
        assert few.rotation_number.holds(all_modes.rotation_number)
        assert few.spectral_gap.holds(all_modes.spectral_gap)
        assert abs(few.moment(1) - all_modes.moment(1)) <= few.moment_error(1)
        checked += error > 1e-9
    assert checked == 3


def test_a_double_second_eigenvalue_has_no_derivative_and_says_so():
    """Noise alone has λ = κ₁ twice; a rotation tells the pair apart as conjugates, and |λ₂| = κ₁ then has one."""
    still = transfer_operator(CircleMap.rigid(0.0), NOISE).noise_response()
    assert not still.gap_is_smooth
    assert np.isnan(still.spectral_gap) and still.spectral_gap.error_bound == np.inf
    turning = transfer_operator(CircleMap.rigid(0.2), NOISE).noise_response()
    assert turning.gap_is_smooth
    assert abs(turning.spectral_gap - 0.4 * np.exp(-0.08)) < 1e-13


def test_responses_that_make_no_sense_are_refused():
    law = transfer_operator(moving(0.0), NOISE)
    with pytest.raises(InvalidInput, match="tangent"):
        law.map_response(1.0)
    with pytest.raises(InvalidInput, match="tangent"):
        law.map_response(lambda x: 1.0)
    with pytest.raises(InvalidInput, match="finite"):
        law.map_response(lambda x: np.full_like(x, np.nan))
    with pytest.raises(InvalidInput, match="break_shifts"):
        law.map_response(np.ones_like, [1.0])
    doubling = transfer_operator(CircleMap(lambda x: 2 * x, degree=2), NOISE)
    with pytest.raises(InvalidInput, match="degree"):
        _ = doubling.noise_response().rotation_number
