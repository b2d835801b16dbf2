"""Ulam's method: densities without noise by closed forms, under uniform noise by Fourier sums."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import (
    CircleMap,
    UniformNoise,
    WrappedNormal,
    lyapunov_exponent,
    transfer_operator,
)
from tests.maps.known_maps import DOUBLING, TWO_PI, logistic

Z = np.linspace(0.0, TWO_PI, 2_000, endpoint=False)


def blaschke(a):
    """z → z (z - a)/(1 - a z): its stationary density is the Poisson kernel of its fixed point in
    the disc, here 0.
    """
    return CircleMap.blaschke([0.0, a])


def beta(slope):
    """x → βx mod 1 as a lift with jumps down at the discontinuities, degree 0."""

    def lift(theta):
        turns = np.mod(theta, TWO_PI) / TWO_PI
        return TWO_PI * np.mod(slope * turns, 1.0)

    return CircleMap(
        lift,
        lambda theta: np.full_like(theta, slope),
        [0.0, *(TWO_PI * np.arange(1, np.ceil(slope)) / slope)],
        degree=0,
    )


def test_maps_that_keep_the_uniform_density_are_told_to_keep_it():
    for circle_map in (DOUBLING, blaschke(0.3)):
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
    orders = np.log2(np.array([errors, bounds])[:, :-1] / np.array([errors, bounds])[:, 1:])
    assert np.all(orders[0] > 1.6) and np.all(np.abs(orders[1] - 2.0) < 0.3)
    assert errors[-1] <= bounds[-1]


def test_bounds_hold_on_random_maps_under_uniform_noise():
    """Moments, rotation and density against sums in Fourier modes, of sine maps, half of them
    folded.
    """
    rng, unfolded = np.random.default_rng(11), 0
    for _ in range(6):
        omega, K, K2, h = (
            rng.uniform(0, 1),
            rng.uniform(0.2, 1.8),
            rng.uniform(-0.3, 0.3),
            rng.uniform(0.6, 3.0),
        )
        circle_map = CircleMap(
            lambda x, o=omega, k=K, c=K2: x + TWO_PI * o - k * np.sin(x) + c * np.cos(2 * x),
            lambda x, k=K, c=K2: 1 - k * np.cos(x) - 2 * c * np.sin(2 * x),
        )
        law = transfer_operator(circle_map, UniformNoise(h))
        moments = fourier_moments(circle_map, h, 200)
        for order in (1, 2, 5):
            assert abs(law.moment(order) - moments[order]) <= law.moment_error(order) + 1e-6
        density = (
            1 + 2 * (np.exp(-1j * np.multiply.outer(Z, np.arange(1, 201))) @ moments[1:]).real
        ) / TWO_PI
        if np.min(circle_map.derivative(Z)) > 0.1:  # else the sum over waves falls too slowly
            unfolded += 1
            assert np.max(np.abs(law.density(Z) - density)) <= law.error_bound + 1e-4
        winding = float(np.mean(density * circle_map.turn(Z)))
        assert abs(law.rotation_number - winding) <= law.rotation_number.error_bound + 1e-5
    assert unfolded >= 1


def fourier_moments(circle_map, h, modes):
    """E e^{imθ}, m = 0..modes, by E e^{imθ'} = κ_m Σ_k c_{mk} E e^{ikθ},
    c by the trapezoidal rule."""
    theta = TWO_PI * np.arange(8 * modes) / (8 * modes)
    orders = np.arange(-modes, modes + 1)
    images = np.exp(1j * np.multiply.outer(orders, circle_map(theta)))
    matrix = (
        np.sinc(orders * h / np.pi)[:, None]
        * (images @ np.exp(-1j * np.multiply.outer(theta, orders)))
        / theta.size
    )
    system = np.eye(orders.size) - matrix
    system[modes] = np.eye(orders.size)[modes]
    return np.linalg.solve(system, np.eye(orders.size)[modes])[modes:]


def test_what_the_map_may_be_off_is_in_the_bounds():
    sine = CircleMap.arnold(0.1, 0.9)
    claimed = CircleMap(sine, sine.derivative, max_error=0.01)
    moved = CircleMap(lambda x: sine(x) + 0.01 * np.cos(x), sine.derivative)
    given, true = (transfer_operator(a_map, UniformNoise(1.0)) for a_map in (claimed, moved))
    assert abs(given.moment(1) - true.moment(1)) <= given.moment_error(1)
    assert abs(given.rotation_number - true.rotation_number) <= given.rotation_number.error_bound


def test_without_noise_nothing_is_said_of_maps_beside_one_that_expands():
    """A doubling off by as little as you like has a fixed point that gathers all paths, so that E
    cos θ is 1 instead of 0.
    """
    law = transfer_operator(
        CircleMap(DOUBLING, DOUBLING.derivative, degree=2, max_error=1e-5), None
    )
    cosine = law.expectation(np.cos)
    assert abs(cosine - 1.0) <= cosine.error_bound and abs(law.moment(1) - 1) <= law.moment_error(1)
    assert law.tv_from_uniform.error_bound >= 1.0 and np.isinf(law.error_bound)


def test_maps_that_do_not_expand_are_refused_without_noise():
    for circle_map in (
        CircleMap.arnold(0.1, 0.9),
        CircleMap.arnold(0.3, 3.0),
        logistic(4.0),
        CircleMap.rigid(0.3),
    ):
        with pytest.raises(InvalidInput, match="expands"):
            transfer_operator(circle_map, None)
    with pytest.raises(InvalidInput, match="the noise is None"):
        transfer_operator(DOUBLING, None).eigenvalues(2)
    with pytest.raises(InvalidInput, match="leave it out"):
        transfer_operator(DOUBLING, UniformNoise(1.0), modes=30)


def test_densities_have_the_shape_of_the_angles():
    law = transfer_operator(CircleMap.arnold(0.1, 0.9), UniformNoise(0.3))
    for shape in ((0,), (2, 0, 3), (1, 2), ()):
        assert law.density(np.zeros(shape)).shape == shape
