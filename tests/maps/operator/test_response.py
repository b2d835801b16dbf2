"""Linear response: against differences of whole computations, and a law whose derivatives are known."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, VonMises, WrappedCauchy, WrappedNormal, transfer_operator

TWO_PI = 2 * np.pi
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


def test_what_makes_no_sense_is_refused():
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
