"""Ulam's method: densities without noise by closed forms, under uniform noise by Fourier sums."""

import numpy as np
import pytest
from refusals import refused

from cyclemap.maps import (
    CircleMap,
    UniformNoise,
    WrappedNormal,
    lyapunov_exponent,
    transfer_operator,
)
from tests.maps.known_maps import DOUBLING, TWO_PI, logistic

Z = np.linspace(0.0, TWO_PI, 2_000, endpoint=False)


def beta(slope):
    """x → βx mod 1 as a lift with jumps down at the discontinuities, degree 0."""

    def lift(theta):
        turns = np.mod(theta, TWO_PI) / TWO_PI
        return TWO_PI * np.mod(slope * turns, 1.0)

    jumps = TWO_PI * np.arange(np.ceil(slope)) / slope
    return CircleMap(lift, lambda theta: np.full_like(theta, slope), jumps, degree=0)


def test_maps_that_keep_the_uniform_density_are_told_to_keep_it():
    """The Blaschke product's density is the Poisson kernel of its fixed point in the disc, 0."""
    for circle_map in (DOUBLING, CircleMap.blaschke([0.0, 0.3])):
        law = transfer_operator(circle_map, None)
        assert law.tv_from_uniform <= law.tv_from_uniform.error_bound < 0.02
        assert abs(law.moment(1)) <= law.moment_error(1)


def test_the_golden_beta_map_has_parrys_density():
    """Two steps whose heights are as 1 to β - 1, with the jump at 1/β (Parry 1960)."""
    golden = 0.5 * (1.0 + 5.0**0.5)
    law = transfer_operator(beta(golden), None)
    low, high = law.density(np.array([1.0, 5.0]))
    assert low / high == pytest.approx(golden, abs=0.02)
    share = law.expectation(lambda theta: (theta < TWO_PI / golden).astype(float))
    exact = golden / (golden + 1.0 / golden)
    assert share.holds(exact) and share == pytest.approx(exact, abs=0.005)
    assert law.expectation(lambda theta: np.full_like(theta, np.log(golden))).holds(np.log(golden))


def test_the_density_without_noise_is_the_limit_of_little_noise_and_its_exponent_that_of_an_orbit():
    bent = CircleMap(lambda x: 2 * x + 0.3 * np.sin(x), lambda x: 2 + 0.3 * np.cos(x), degree=2)
    law, noisy = transfer_operator(bent, None), transfer_operator(bent, WrappedNormal(0.02))
    for order in (1, 2, 3):
        assert abs(law.moment(order) - noisy.moment(order)) <= law.moment_error(order) < 0.006
        assert abs(law.moment(order) - noisy.moment(order)) < 1e-4
    exponent = law.expectation(lambda theta: np.log(2 + 0.3 * np.cos(theta)))
    orbit = lyapunov_exponent(bent, start=0.3)
    assert abs(exponent - orbit) <= exponent.error_bound + orbit.error_bound
    assert exponent.error_bound < 0.002


def test_halving_the_cells_quarters_the_error_under_uniform_noise_and_halves_the_bound_without():
    sine, errors, bounds = CircleMap.arnold(0.1, 0.9), [], []
    law = transfer_operator(sine, UniformNoise(1.0)).law
    fine = law.refined().expectation(np.cos)
    for count in (64, 128, 256):
        coarse = type(law)(type(law.basis)(sine, UniformNoise(1.0), count))
        errors.append(abs(coarse.expectation(np.cos) - fine))
        bounds.append(coarse.expectation(np.cos).error_bound)
    orders = -np.diff(np.log2([errors, bounds]))
    assert np.all(orders[0] > 1.6) and np.all(np.abs(orders[1] - 2.0) < 0.3)
    assert errors[-1] <= bounds[-1]


def test_densities_under_uniform_noise_are_sums_of_fourier_modes_within_their_bound():
    """E e^{imθ'} = κ_m Σ_k c_{mk} E e^{ikθ} solved, c by the trapezoidal rule."""
    orders, theta = np.arange(-200, 201), TWO_PI * np.arange(1600) / 1600
    constant = np.eye(401)[200]
    for omega, K, h in ((0.1, 0.6, 1.0), (0.4, 0.3, 2.2)):
        sine = CircleMap.arnold(omega, K)
        images = np.exp(1j * np.multiply.outer(orders, sine(theta)))
        sums = images @ np.exp(-1j * np.multiply.outer(theta, orders)) / theta.size
        system = np.eye(401) - np.sinc(orders * h / np.pi)[:, None] * sums
        system[200] = constant
        moments = np.linalg.solve(system, constant)
        density = (np.exp(-1j * np.multiply.outer(Z, orders)) @ moments).real / TWO_PI
        law = transfer_operator(sine, UniformNoise(h))
        assert np.max(np.abs(law.density(Z) - density)) <= law.error_bound + 1e-4
        assert law.error_bound < 0.1
        winding = float(np.mean(density * sine.turn(Z)))
        assert abs(law.rotation_number - winding) <= law.rotation_number.error_bound + 1e-5


def test_the_density_about_the_image_of_a_jump_is_told_within_its_bound():
    """Most of the circle is sent to 0, and the density is flat with a jump at h; what lies between
    0.2 and h is sent on by a gentle line: a flat density seen through the window of the noise.

    A cell that holds the jump gives no mean an error, and the density one, where its image meets
    the window's end.
    """
    h, stays = 0.5, 1 / 1.3

    def on_line(theta):
        angle = np.mod(theta, TWO_PI)
        return (angle >= 0.2) & (angle < 1.2)

    def lift(theta):
        return np.where(on_line(theta), 0.1 * (np.mod(theta, TWO_PI) - 0.2) - 1.0, 0.0)

    kept = CircleMap(lift, lambda theta: 0.1 * on_line(theta), [0.2, 1.2], degree=0)
    law = transfer_operator(kept, UniformNoise(h))
    theta = np.linspace(-1.6, 0.6, 2_001) + 1e-5
    before, beyond = (np.clip((theta + side * h + 1.0) / 0.1, 0.0, 0.3) for side in (-1, 1))
    density = stays * ((np.abs(theta) < h) + (beyond - before) / (2 * h)) / (2 * h)
    off = np.max(np.abs(law.density(theta) - density))
    assert 0.001 < off <= law.error_bound


def test_what_the_map_may_be_off_is_in_the_bounds():
    sine = CircleMap.arnold(0.1, 0.9)
    claimed = CircleMap(sine, sine.derivative, max_error=0.01)
    moved = CircleMap(lambda x: sine(x) + 0.01 * np.cos(x), sine.derivative)
    given, true = (transfer_operator(a_map, UniformNoise(1.0)) for a_map in (claimed, moved))
    assert abs(given.moment(1) - true.moment(1)) <= given.moment_error(1)
    assert abs(given.rotation_number - true.rotation_number) <= given.rotation_number.error_bound


def test_without_noise_nothing_is_said_of_maps_beside_one_that_expands():
    """A doubling off by as little as you like has a fixed point that gathers all paths."""
    claimed = CircleMap(DOUBLING, DOUBLING.derivative, degree=2, max_error=1e-5)
    law = transfer_operator(claimed, None)
    cosine = law.expectation(np.cos)
    assert abs(cosine - 1.0) <= cosine.error_bound and abs(law.moment(1) - 1) <= law.moment_error(1)
    assert law.tv_from_uniform.error_bound >= 1.0 and np.isinf(law.error_bound)


def test_maps_that_do_not_expand_are_refused_without_noise():
    for circle_map in (CircleMap.arnold(0.3, 3.0), logistic(4.0), CircleMap.rigid(0.3)):
        refused(transfer_operator, circle_map, None, told="expands")
    refused(transfer_operator(DOUBLING, None).eigenvalues, 2, told="the noise is None")
    refused(transfer_operator, DOUBLING, UniformNoise(1.0), modes=30, told="leave it out")


def test_densities_have_the_shape_of_the_angles():
    law = transfer_operator(CircleMap.rigid(0.1), UniformNoise(0.3))
    for shape in ((0,), (2, 0, 3), (1, 2), ()):
        assert law.density(np.zeros(shape)).shape == shape
