"""Eigenvalues of transfer operators and the bounds on their errors."""

import numpy as np
import pytest

from cyclemap.maps import (
    CircleMap,
    UniformNoise,
    WrappedCauchy,
    WrappedNormal,
    mean_passage_time,
    transfer_operator,
)
from tests.maps.known_maps import TWIN_WELLS

TWO_PI = 2 * np.pi
Z_STAR = 0.2550616828143848456 - 0.2049307699033403712j


def test_moebius_with_cauchy_noise_has_powers_of_its_multiplier_and_their_conjugates():
    """With g = rB, B the Möbius map of the disc, the eigenvalues are g'(z*)^n and their
    conjugates."""
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
    for turns in (omega, 0.0, 0.5):  # at the latter two all values are double
        law = transfer_operator(CircleMap.rigid(turns), noise)
        assert law.spectral_gap.holds(1 - np.exp(-0.045)) and law.spectral_gap.error_bound < 1e-13
    found = transfer_operator(CircleMap.rigid(omega), noise).spectrum(7)
    m = np.array([1, 1, 2, 2, 3, 3])
    np.testing.assert_allclose(np.abs(found.values[1:]), noise.coefficients(m), atol=1e-14)
    np.testing.assert_allclose(
        found.values[1::2],
        noise.coefficients(m[::2]) * np.exp(2j * np.pi * np.array([1, 2, -3]) * omega),
        atol=1e-13,
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
    """The three leading values with half the modes are as near the truth as their bounds say, and
    not much nearer.
    """
    circle_map = CircleMap.arnold(0.3, 3.0)
    for noise in (WrappedNormal(0.3), WrappedNormal(0.15), WrappedCauchy(0.7)):
        full = transfer_operator(circle_map, noise)
        truth = full.eigenvalues(12)
        few = transfer_operator(circle_map, noise, modes=full.modes // 2).spectrum(4)
        for value, bound in zip(few.values[1:], few.error_bounds[1:], strict=True):
            error = np.min(np.abs(truth - value))
            assert error <= bound <= 100 * error + 1e-11


NOISES = [WrappedNormal(0.3), WrappedCauchy(0.6)]


@pytest.mark.slow
@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("degree", [2, 3, 4])
def test_the_gap_of_a_multiplication_is_one_within_bounds_that_say_something(degree, noise):
    """θ → kθ divides frequencies by k, so that every eigenvalue but the first is 0."""
    slope = float(degree)
    law = transfer_operator(
        CircleMap(lambda x: slope * x, lambda x: slope + 0 * x, degree=degree), noise
    )
    assert law.spectral_gap.holds(1.0) and law.spectral_gap.error_bound < 0.1
    assert law.mixing_cycles.holds(0.0) and law.mixing_cycles.error_bound < 0.5
    found = law.spectrum(4)
    assert np.all(np.abs(found.values[1:]) <= found.error_bounds[1:])
    assert np.min(found.condition[1:]) > 1e4  # the values are defective, and say so


def test_large_operators_are_solved_by_arnoldi_to_the_same_values():
    law = transfer_operator(CircleMap.arnold(0.3, 3.0), WrappedNormal(0.04))
    assert law.discretisation.size > 320
    whole = np.sort(np.abs(np.linalg.eigvals(law.discretisation.matrix)))[::-1][:4]
    found = law.spectrum(4)
    np.testing.assert_allclose(np.abs(found.values), whole, atol=1e-10)
    np.testing.assert_allclose(np.abs(law.eigenvalues(4)), whole, atol=1e-10)
    assert np.all(found.error_bounds < 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("turns", [0.0, 0.17, 0.5])
def test_large_operators_have_every_eigenvalue_as_often_as_it_is_there(turns):
    """Those of a rotation are the noise's coefficients, in pairs that turn; by 0 and ½ they are
    equal.
    """
    noise = WrappedNormal(0.04)
    law = transfer_operator(CircleMap.rigid(turns), noise)
    assert law.discretisation.size > 320
    known = noise.coefficients(np.repeat(np.arange(1, 5), 2))
    np.testing.assert_allclose(np.abs(law.eigenvalues(9)[1:]), known, atol=1e-13)


@pytest.mark.parametrize("turns", [0.0, 0.5])
def test_vectors_of_double_eigenvalues_of_large_operators_are_biorthogonal(turns):
    """A rotation commutes with its adjoint: were a left vector beside both copies, conditions would
    be far above 1.

    Of two copies an iteration finds any two vectors of their plane, hardly ever at right angles:
    that is in them, too.
    """
    noise = WrappedNormal(0.04)
    law = transfer_operator(CircleMap.rigid(turns), noise)
    assert law.discretisation.size > 320
    for count in (9, 10):  # the latter ends between two copies
        found = law.spectrum(count)
        np.testing.assert_allclose(found.left.T @ found.right, np.eye(count), atol=1e-9)
        np.testing.assert_allclose(found.condition, 1.0, atol=0.5)
        known = noise.coefficients((np.arange(count) + 1) // 2)
        assert np.all(np.abs(np.abs(found.values) - known) <= found.error_bounds + 1e-14)
        assert np.all(found.error_bounds < 1e-13)


def test_slow_mixing_between_wells_is_the_rate_of_escape():
    """For two equal wells 1 - λ₂ = 2/T, T the mean time from one well to the bottom of the other
    (Kramers 1940).
    """
    noise = WrappedNormal(0.28)
    law = transfer_operator(TWIN_WELLS, noise)
    hop = mean_passage_time(TWIN_WELLS, noise, 0.0, (0.5 - np.pi, np.pi - 0.5))
    assert law.spectral_gap == pytest.approx(2.0 / hop, rel=1e-3)
    assert 1e-6 < law.spectral_gap < 1e-4


@pytest.mark.parametrize("halfwidth", [0.126, 0.5, 2.0, 7.5])
def test_eigenvalues_under_uniform_noise_are_the_coefficients_of_a_rotation_within_their_bounds(
    halfwidth,
):
    """A rotation by Ω has the eigenvalues e^{2πimΩ} sin(mh)/(mh), whatever the cells."""
    found = transfer_operator(CircleMap.rigid(0.3), UniformNoise(halfwidth)).spectrum(5)
    order = np.arange(1.0, 40.0)
    moduli = np.sort(np.repeat(np.abs(np.sin(order * halfwidth) / (order * halfwidth)), 2))[::-1][
        :4
    ]
    assert np.all(np.isfinite(found.error_bounds)) and np.all(found.error_bounds < 1e-3)
    assert np.all(np.abs(np.abs(found.values[1:]) - moduli) <= found.error_bounds[1:] + 1e-12)


@pytest.mark.slow
def test_the_gap_under_uniform_noise_has_a_bound_that_holds_against_fourier_modes():
    """Fourier modes, whose coefficients fall as 1/m, come near the gap of the cells."""
    sine, noise = CircleMap.arnold(0.3, 0.5), UniformNoise(1.0)
    found = transfer_operator(sine, noise)
    modes = np.arange(-300, 301)
    grid = TWO_PI * np.arange(2_048) / 2_048
    waves = np.exp(1j * np.multiply.outer(modes, grid))
    matrix = (
        noise.coefficients(modes)[:, None]
        * (np.exp(-1j * np.multiply.outer(modes, sine(grid))) @ waves.T)
        / 2_048
    )
    second = np.sort(np.abs(np.linalg.eigvals(matrix)))[-2]
    assert abs(found.spectral_gap - (1.0 - second)) < found.spectral_gap.error_bound + 1e-9
    assert found.spectral_gap.error_bound < 1e-3


def test_an_eigenvalue_without_a_bound_takes_nothing_from_what_the_others_tell():
    """With too few modes only λ₂ has a bound: |λ₂| is no less than that tells, and at most 1."""
    circle_map, noise = CircleMap.arnold(0.1, 0.9), WrappedNormal(0.1)
    truth, few = (
        transfer_operator(circle_map, noise),
        transfer_operator(circle_map, noise, modes=30),
    )
    found = few.spectrum(5)
    assert np.isfinite(found.error_bounds[1]) and np.isinf(found.error_bounds[2])
    gap = few.spectral_gap
    assert gap.holds(float(truth.spectral_gap))
    assert gap.error_bound <= 1.0 - np.abs(found.values[1])
