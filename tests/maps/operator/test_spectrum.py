"""Eigenvalues of transfer operators with bounds, and the nearly invariant sets that they tell."""

import numpy as np
import pytest

from cyclemap.maps import (
    CircleMap,
    UniformNoise,
    WrappedCauchy,
    WrappedNormal,
    conjugate,
    fixed_points,
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
    m = np.array([1, 2, 3])
    sizes = noise.coefficients(m)
    np.testing.assert_allclose(np.abs(found.values[1:]), np.repeat(sizes, 2), atol=1e-14)
    turned = sizes * np.exp(2j * np.pi * m * [1, 1, -1] * omega)
    np.testing.assert_allclose(found.values[1::2], turned, atol=1e-13)
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
    """The three leading values with half the modes are as near the truth, and not much nearer."""
    circle_map = CircleMap.arnold(0.3, 3.0)
    for noise in (WrappedNormal(0.3), WrappedNormal(0.15), WrappedCauchy(0.7)):
        full = transfer_operator(circle_map, noise)
        truth = full.eigenvalues(12)
        few = transfer_operator(circle_map, noise, modes=full.modes // 2).spectrum(4)
        for value, bound in zip(few.values[1:], few.error_bounds[1:], strict=True):
            error = np.min(np.abs(truth - value))
            assert error <= bound <= 100 * error + 1e-11


@pytest.mark.slow
@pytest.mark.parametrize(("degree", "noise"), [(2, WrappedNormal(0.3)), (3, WrappedCauchy(0.6))])
def test_the_gap_of_a_multiplication_is_one_within_bounds_that_say_something(degree, noise):
    """θ → kθ divides frequencies by k, so that every eigenvalue but the first is 0."""
    law = transfer_operator(CircleMap.blaschke([0.0] * degree), noise)
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


@pytest.mark.parametrize("turns", [0.0, 0.17, 0.5])
def test_double_eigenvalues_of_large_operators_are_found_twice_with_biorthogonal_vectors(turns):
    """A rotation commutes with its adjoint: were a left vector beside both copies, conditions would
    be far above 1, as they are where an iteration finds two vectors of a plane.
    """
    noise = WrappedNormal(0.04)
    law = transfer_operator(CircleMap.rigid(turns), noise)
    assert law.discretisation.size > 320
    for count in (9, 10):  # the latter ends between two copies
        found = law.spectrum(count)
        np.testing.assert_allclose(found.left.T @ found.right, np.eye(count), atol=1e-9)
        np.testing.assert_allclose(found.condition, 1.0, atol=0.5)
        known = noise.coefficients((np.arange(count) + 1) // 2)
        np.testing.assert_allclose(np.abs(law.eigenvalues(count)), known, atol=1e-13)
        assert np.all(np.abs(np.abs(found.values) - known) <= found.error_bounds + 1e-14)
        assert np.all(found.error_bounds < 1e-13)


def test_slow_mixing_between_wells_is_the_rate_of_escape():
    """For two equal wells 1 - λ₂ = 2/T, T the mean time to the other's bottom (Kramers 1940)."""
    noise = WrappedNormal(0.28)
    law = transfer_operator(TWIN_WELLS, noise)
    hop = mean_passage_time(TWIN_WELLS, noise, 0.0, (0.5 - np.pi, np.pi - 0.5))
    assert law.spectral_gap == pytest.approx(2.0 / hop, rel=1e-3)
    assert 1e-6 < law.spectral_gap < 1e-4


@pytest.mark.parametrize("halfwidth", [0.126, 2.0, 7.5])
def test_eigenvalues_under_uniform_noise_are_the_coefficients_of_a_rotation_within_their_bounds(
    halfwidth,
):
    """A rotation by Ω has the eigenvalues e^{2πimΩ} sin(mh)/(mh), whatever the cells."""
    found = transfer_operator(CircleMap.rigid(0.3), UniformNoise(halfwidth)).spectrum(5)
    sizes = np.sort(np.abs(np.sinc(np.arange(1.0, 40.0) * halfwidth / np.pi)))[::-1]
    off = np.abs(np.abs(found.values[1:]) - np.repeat(sizes[:2], 2))
    assert np.all(off <= found.error_bounds[1:] + 1e-12) and np.all(found.error_bounds < 1e-3)


@pytest.mark.slow
def test_the_gap_under_uniform_noise_has_a_bound_that_holds_against_fourier_modes():
    """Fourier modes, whose coefficients fall as 1/m, come near the gap of the cells."""
    sine, noise = CircleMap.arnold(0.3, 0.5), UniformNoise(1.0)
    found = transfer_operator(sine, noise)
    modes, grid = np.arange(-200, 201), TWO_PI * np.arange(1_024) / 1_024
    waves = np.exp(1j * np.multiply.outer(modes, grid))
    images = np.exp(-1j * np.multiply.outer(modes, sine(grid)))
    matrix = noise.coefficients(modes)[:, None] * (images @ waves.T) / grid.size
    second = np.sort(np.abs(np.linalg.eigvals(matrix)))[-2]
    assert found.spectral_gap.holds(1.0 - second) and found.spectral_gap.error_bound < 1e-3


def test_an_eigenvalue_without_a_bound_takes_nothing_from_what_the_others_tell():
    """With too few modes only λ₂ has a bound: |λ₂| is no less than that tells, and at most 1."""
    circle_map, noise = CircleMap.arnold(0.1, 0.9), WrappedNormal(0.1)
    truth = transfer_operator(circle_map, noise)
    few = transfer_operator(circle_map, noise, modes=30)
    found = few.spectrum(5)
    assert np.isfinite(found.error_bounds[1]) and np.isinf(found.error_bounds[2])
    gap = few.spectral_gap
    assert gap.holds(float(truth.spectral_gap))
    assert gap.error_bound <= 1.0 - np.abs(found.values[1])


def wells(deep, tilt, phase=0.0, count=2):
    """A map with ``count`` stable points, their depths told apart by ``tilt``."""
    return CircleMap(
        lambda x: x - deep * np.sin(count * x) + tilt * np.sin(x + phase),
        lambda x: 1 - deep * count * np.cos(count * x) + tilt * np.cos(x + phase),
    )


def assert_near(one, other):
    assert abs(one - other) <= one.error_bound + other.error_bound


@pytest.mark.parametrize(("deep", "tilt", "sigma"), [(0.3, 0.05, 0.2), (0.35, 0.03, 0.25)])
def test_stays_are_passages_to_the_other_stable_point(deep, tilt, sigma):
    """But for the little longer that the other's bottom takes; as many go one way as the other."""
    two_wells, noise = wells(deep, tilt), WrappedNormal(sigma)
    held = transfer_operator(two_wells, noise).metastable_sets()
    stable = [orbit.points[0] for orbit in fixed_points(two_wells) if orbit.stable]
    assert len(held) == 2 and held[0].share > held[1].share
    for one, other in (held, held[::-1]):
        start = min(stable, key=lambda theta: abs(np.sin((theta - one.peak) / 2)))
        goal = min(stable, key=lambda theta: abs(np.sin((theta - other.peak) / 2)))
        passage = mean_passage_time(two_wells, noise, start, (goal + 0.1, goal + TWO_PI - 0.1))
        assert 0.998 * passage < 1 / one.leaving < passage
    doubt = sum(one.share.error_bound for one in held)
    assert abs(sum(one.share for one in held) - 1.0) <= doubt
    flows = [one.share * one.leaving for one in held]
    assert flows[0] == pytest.approx(flows[1], rel=2e-3)


def test_equal_wells_hold_equal_shares_on_arcs_that_are_images_of_each_other():
    for count in (2, 3):
        law = transfer_operator(wells(0.25, 0.0, count=count), WrappedNormal(0.25))
        held = law.metastable_sets()
        assert len(held) == count
        for one in held:
            assert one.share.holds(1 / count) and one.share.error_bound < 1e-9
            assert one.leaving.error_bound < 1e-8 * one.leaving
            assert_near(one.leaving, held[0].leaving)
            np.testing.assert_allclose(np.diff(one.arcs), TWO_PI / count, atol=1e-8)
            assert np.sin(count * one.peak / 2) == pytest.approx(0.0, abs=0.05)


def test_sets_turn_with_the_map():
    two_wells, noise = wells(0.3, 0.05), WrappedNormal(0.3)
    plain = transfer_operator(two_wells, noise).metastable_sets()
    turned = transfer_operator(conjugate(two_wells, 1.0), noise).metastable_sets()
    assert len(plain) == 2
    for one, other in zip(plain, turned, strict=True):
        assert abs(one.share - other.share) < 1e-9
        assert_near(one.leaving, other.leaving)
        assert np.max(np.abs(np.exp(1j * (one.arcs + 1.0)) - np.exp(1j * other.arcs))) < 1e-8


def test_where_noise_soon_connects_everything_nothing_is_held():
    for circle_map, sigma in (
        (CircleMap.arnold(0.1, 0.9), 0.3),
        (CircleMap.arnold(0.15, 0.9), 0.1),
        (wells(0.3, 0.0), 1.5),
        (CircleMap.rigid(0.0), 0.02),
    ):
        assert transfer_operator(circle_map, WrappedNormal(sigma)).metastable_sets() == ()


def test_bounds_hold_on_random_wells_with_few_modes_and_with_maps_that_are_off():
    """A set at the edge of what counts as held is left out."""
    rng, off, judged, compared = np.random.default_rng(5), 1e-5, 0, 0
    for _ in range(10):
        deep, tilt, phase = rng.uniform([0.25, 0.0, 0.0], [0.4, 0.1, TWO_PI])
        count, sigma = rng.integers(2, 4), rng.uniform(0.25, 0.4)
        noise = WrappedNormal(sigma) if rng.uniform() < 0.8 else WrappedCauchy(0.85)
        circle_map, waves = wells(deep, tilt, phase, count), rng.integers(0, 4)
        full = transfer_operator(circle_map, noise)
        claimed = CircleMap(circle_map, circle_map.derivative, max_error=off)
        moved = CircleMap(
            lambda x, m=circle_map, w=waves: m(x) + off * np.cos(w * x), circle_map.derivative
        )
        truth = [one.leaving for one in full.metastable_sets()]
        few = transfer_operator(circle_map, noise, modes=max(8, full.modes // 3)).metastable_sets()
        beside = transfer_operator(moved, noise).metastable_sets()
        bounds = transfer_operator(claimed, noise).metastable_sets()
        for one in few:
            nearest = min(truth, key=lambda leaving, one=one: abs(leaving - one.leaving))
            assert_near(one.leaving, nearest)
            judged += 1
        if len(bounds) != len(beside):
            continue
        for one, other in zip(bounds, beside, strict=True):
            assert abs(one.leaving - other.leaving) <= 1.01 * one.leaving.error_bound
            compared += 1
    assert judged >= 12 and compared >= 12


def test_with_too_few_modes_for_an_eigenvalue_the_chance_of_leaving_has_no_bound():
    """Where the slow eigenvalues' bounds are infinite, so are those of all states, not nan."""
    three_wells = wells(0.342, 0.002, 1.18, 3)
    few = transfer_operator(three_wells, WrappedNormal(0.28), modes=8)
    held = few.metastable_sets()
    assert len(held) == 3
    assert [state.leaving.error_bound for state in held] == [np.inf] * 3
