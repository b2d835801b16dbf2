"""The transfer operator: its matrix, known laws, diffusion, and error bounds that hold."""

import numpy as np
import pytest
from scipy.special import jv

from cyclemap.maps import (
    CircleMap,
    UniformNoise,
    VonMises,
    WrappedCauchy,
    WrappedNormal,
    fixed_points,
    sample_staircases,
    transfer_operator,
)
from cyclemap.maps.operator import fourier_basis as module
from cyclemap.maps.operator.fourier_basis import FourierDiscretisation
from tests.maps.known_maps import DOUBLING, TWIN_WELLS

TWO_PI = 2 * np.pi
GRID = np.linspace(0, TWO_PI, 400, endpoint=False)
STICKY = CircleMap.arnold(0.1, 0.9)


def test_the_matrix_of_the_sine_map_is_made_of_bessel_functions():
    omega, strength, sigma = 0.23, 1.7, 0.4
    m = np.arange(-25, 26)
    rows = np.exp(-0.5 * (m * sigma) ** 2 - 2j * np.pi * m * omega)
    values = np.linalg.eigvals(rows[:, None] * jv(m[:, None] - m, m[:, None] * strength))
    sizes = np.sort(np.abs(values))[::-1][:9]
    law = transfer_operator(CircleMap.arnold(omega, strength), WrappedNormal(sigma))
    found = law.eigenvalues(9)
    np.testing.assert_allclose(np.sort(np.abs(found))[::-1], sizes, rtol=0.0, atol=1e-12)
    assert np.abs(found[:, None] - values).min(axis=1).max() < 1e-12


def waves(theta, modes):
    """1, cos mθ, sin mθ, rows."""
    phases = np.arange(1, modes + 1)[:, None] * theta
    return np.concatenate([np.ones((1, theta.size)), np.cos(phases), np.sin(phases)])


@pytest.mark.parametrize(("name", "modes"), [("smooth", 1), ("sampled", 5), ("sampled", 200)])
def test_entries_are_the_sums_over_the_nodes(name, modes) -> None:
    """What the fast transforms give is off by rounding alone, also with hardly any modes."""
    bent = np.linspace(0.0, TWO_PI, 40)[:-1]
    sampled = CircleMap.from_samples(bent, bent + 0.4 + 0.2 * np.abs(np.sin(bent)))
    circle_map = {"smooth": CircleMap.arnold(0.3, 0.9), "sampled": sampled}[name]
    basis = transfer_operator(circle_map, WrappedNormal(0.05), modes=modes).discretisation
    theta, weight = basis.rule
    before = waves(theta.astype(np.longdouble), modes) * weight
    after = waves(circle_map(theta).astype(np.longdouble), modes)
    order = np.concatenate([np.arange(modes + 1), np.arange(1, modes + 1)])
    share = np.append(0.5, np.ones(2 * modes)) / np.pi
    plain = np.exp(-0.5 * (0.05 * order) ** 2)[:, None] * share * (after @ before.T)
    plain[0] = np.eye(1, basis.size)[0]
    np.testing.assert_allclose(basis.matrix, plain.astype(float), rtol=0.0, atol=3e-15)


def test_moebius_with_cauchy_noise_is_exactly_solvable():
    a, omega, r = 0.5, 0.3, 0.9
    law = transfer_operator(CircleMap.moebius(a, omega), WrappedCauchy(r))
    z = 0.2550616828143848456 - 0.2049307699033403712j
    exact = (1 - abs(z) ** 2) / (TWO_PI * np.abs(np.exp(1j * GRID) - z) ** 2)
    error = np.max(np.abs(law.density(GRID) - exact))
    assert error < 1e-14 and error <= law.error_bound < 1e-11
    for n in range(1, 6):
        assert abs(law.moment(n) - z**n) < 1e-14
        assert abs(law.moment(-n) - np.conj(z) ** n) < 1e-14
    assert abs(law.rotation_number - 0.2627872013171239726) < 1e-14


def test_rotations_and_doublings_have_a_uniform_law_without_peaks():
    noise = WrappedNormal(0.3)
    law = transfer_operator(CircleMap.rigid(0.17), noise)
    for one in (law, transfer_operator(DOUBLING, noise)):
        np.testing.assert_allclose(one.density(GRID), 0.5 / np.pi, rtol=1e-12)
    assert law.tv_from_uniform == law.peaks().size == 0
    assert abs(law.rotation_number - 0.17) < 1e-15
    assert abs(law.mixing_cycles - 2 / 0.09) < 1e-9


def test_expectations_have_two_routes():
    """E cos θ is the real part of the first moment, E 1 = 1, and E F' = 1 - K E cos θ."""
    law = transfer_operator(STICKY, WrappedNormal(0.2))
    cosine = law.expectation(np.cos)
    assert abs(cosine - law.moment(1).real) <= cosine.error_bound + law.moment_error(1) < 1e-13
    assert abs(law.expectation(np.ones_like) - 1.0) < 1e-14
    assert abs(law.expectation(STICKY.derivative) - (1 - 0.9 * law.moment(1).real)) < 1e-14


@pytest.mark.parametrize("noise", [WrappedNormal(2.0), VonMises(8.0)], ids=repr)
def test_what_the_nodes_miss_of_a_sharp_function_is_in_the_bound(noise):
    """A Lorentzian of 0.11 rad on nodes that are meant for smoother ones, against 20,000."""
    law, fine = transfer_operator(STICKY, noise), TWO_PI * np.arange(20_000) / 20_000
    for place in (0.5, 2.0, 4.0):

        def sharp(x, place=place):
            return 1.0 / (1.006 - np.cos(x - place))

        found = law.expectation(sharp)
        exact = TWO_PI * np.mean(law.density(fine) * sharp(fine))
        assert abs(found - exact) <= found.error_bound + 1e-12
        assert 1e-12 < found.error_bound < 0.05


@pytest.mark.parametrize("angle", np.linspace(0.0, 3.0, 5))
def test_two_wells_have_equal_shares_within_the_bound_however_badly_noise_decides_them(angle):
    """By symmetry, which rounding breaks: what it breaks is magnified a billion times."""
    wells = CircleMap(
        lambda x: x - 0.4 * np.sin(2 * (x - angle)), lambda x: 1 - 0.8 * np.cos(2 * (x - angle))
    )
    law = transfer_operator(wells, WrappedNormal(0.2))
    uneven = 0.5 * np.max(np.abs(law.density(GRID) - law.density(GRID + np.pi)))
    assert uneven <= law.error_bound < 1e-5


def test_peaks_stand_at_the_stable_points_when_noise_is_small():
    for sigma, allowed in ((0.05, 2e-3), (0.02, 3e-4)):
        (peak,) = transfer_operator(STICKY, WrappedNormal(sigma)).peaks()
        assert abs(peak - fixed_points(STICKY)[0].points[0]) < allowed
    sticky = transfer_operator(CircleMap.arnold(0.0, 0.5), UniformNoise(1.0))
    (peak,) = sticky.peaks()
    assert abs(np.angle(np.exp(1j * peak))) < 0.01
    assert sticky.density(peak) >= np.max(sticky.density(GRID)) - 1e-4
    peaks = transfer_operator(TWIN_WELLS, WrappedNormal(0.2)).peaks()
    np.testing.assert_allclose(np.sort(np.mod(peaks + 0.5, TWO_PI)), [0.5, np.pi + 0.5], atol=1e-9)


def test_total_variation_is_half_the_integral_of_the_difference():
    law = transfer_operator(STICKY, WrappedNormal(0.3))
    fine = TWO_PI * (np.arange(20_000) + 0.5) / 20_000
    plain = 0.5 * np.mean(np.abs(law.density(fine) - 0.5 / np.pi)) * TWO_PI
    assert abs(law.tv_from_uniform - plain) < 1e-7


def kinked(x):
    t = np.mod(x, TWO_PI)
    return x - t + np.where(t < 2.0, 0.4 + 1.6 * t, 3.6 + (TWO_PI - 3.2) / (TWO_PI - 2) * (t - 2))


def kinked_slope(x):
    return np.where(np.mod(x, TWO_PI) < 2.0, 1.6, (TWO_PI - 3.2) / (TWO_PI - 2))


def jumping(x):
    t = np.mod(x, TWO_PI)
    return x + 0.5 + np.where((t >= 2) & (t < 5), 1.0 + 1.5 * np.sin(t), 0.1 * np.sin(t))


KNOTS = np.linspace(0, TWO_PI, 90, endpoint=False)
CASES = [
    (STICKY, WrappedNormal(0.5)),
    (CircleMap.arnold(0.3, 3.0), WrappedNormal(0.1)),
    (CircleMap(kinked, kinked_slope, [0.0, 2.0]), VonMises(10.0)),
    (CircleMap(jumping, breaks=[2.0, 5.0]), WrappedNormal(0.03)),
    (CircleMap.from_samples(KNOTS, KNOTS + 0.6 - 0.9 * np.sin(KNOTS)), WrappedCauchy(0.7)),
]


@pytest.mark.slow
@pytest.mark.parametrize(("circle_map", "noise"), CASES)
def test_the_law_is_a_density_that_one_cycle_leaves_unchanged_with_bounds_near_rounding(
    circle_map, noise
):
    law = transfer_operator(circle_map, noise)
    assert law.is_certain and law.error_bound < 1e-11
    assert max(law.moment_error(n) for n in (1, 2, 3)) < 1e-12
    assert law.rotation_number.error_bound < 1e-13
    nodes, weights = np.polynomial.legendre.leggauss(12)
    knots = np.union1d(np.linspace(0, TWO_PI, 811), circle_map.breaks)
    x = (knots[:-1, None] + np.diff(knots)[:, None] * 0.5 * (1 + nodes)).ravel()
    w = (0.5 * np.diff(knots)[:, None] * weights).ravel()
    density = law.density(x)
    assert abs(np.dot(w, density) - 1) < 1e-11
    after = noise.density(GRID[:, None] - circle_map(x)) @ (w * density)
    np.testing.assert_allclose(after, law.density(GRID), rtol=0, atol=law.error_bound + 1e-10)
    assert np.min(density) > -law.error_bound


def assert_tight(found, truth, bound):
    """The bound holds, and is at most a hundred times an error above rounding."""
    error = float(np.max(np.abs(np.asarray(found) - truth)))
    assert error <= bound + 1e-14 and (error <= 1e-10 or bound <= 100 * error)
    return error > 1e-10


@pytest.mark.slow
@pytest.mark.parametrize(("circle_map", "noise"), CASES)
def test_bounds_of_truncated_operators_hold_and_are_tight(circle_map, noise):
    """With a third and with 60 % of the modes, against all of them."""
    full = transfer_operator(circle_map, noise)
    decided = 0
    for share in (0.35, 0.6):
        few = transfer_operator(circle_map, noise, modes=int(share * full.modes))
        decided += assert_tight(few.density(GRID), full.density(GRID), few.error_bound)
        assert_tight(few.moment(2), full.moment(2), few.moment_error(2))
        assert_tight(few.rotation_number, full.rotation_number, few.rotation_number.error_bound)
        assert abs(few.spectral_gap - full.spectral_gap) <= few.spectral_gap.error_bound + 1e-14
        assert few.tv_from_uniform.holds(full.tv_from_uniform)
        assert few.mixing_cycles.holds(full.mixing_cycles)
    assert decided >= 1


def test_a_law_that_noise_cannot_decide_says_so():
    """Two wells that noise of 0.06 rad connects once in 1e30 cycles: any mixture is stationary."""
    law = transfer_operator(TWIN_WELLS, WrappedNormal(0.06))
    assert not law.is_certain and law.error_bound > 0.1
    assert transfer_operator(TWIN_WELLS, WrappedNormal(0.3)).is_certain


def test_many_blocks_give_what_one_gives(monkeypatch) -> None:
    def answers() -> tuple[int, list[np.ndarray]]:
        basis = FourierDiscretisation(STICKY, WrappedNormal(0.2), 40)
        law = np.random.default_rng(1).standard_normal(basis.size)
        return len(list(basis._before)), [basis.matrix, basis.cycle(law), basis.expected_slope(law)]

    _, whole = answers()
    monkeypatch.setattr(module, "_ENTRIES", 1)
    blocks, parts = answers()
    assert blocks > 1
    for one, other in zip(whole, parts, strict=True):
        assert other == pytest.approx(one, abs=1e-12 * np.abs(one).max())


@pytest.mark.slow
@pytest.mark.parametrize("turns", [0.0, 0.3])
def test_a_rotation_diffuses_by_its_noise_alone(turns):
    """And under Cauchy kicks, which have no variance, without bound."""
    for noise in (WrappedNormal(0.4), WrappedNormal(2.0)):
        found = transfer_operator(CircleMap.rigid(turns), noise).diffusion
        assert abs(found - 0.5 * noise.variance) <= found.error_bound < 1e-11
    assert transfer_operator(CircleMap.rigid(turns), WrappedCauchy(0.5)).diffusion == np.inf


LEAPING = CircleMap(
    lambda x: x + np.where(np.mod(x, TWO_PI) < 3.0, 1.0, -0.8), np.ones_like, [0.0, 3.0]
)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("circle_map", "sigma"),
    [(CircleMap.arnold(0.3, 0.9), 0.4), (CircleMap.arnold(0.3, 3.0), 0.8), (LEAPING, 0.8)],
)
def test_monte_carlo_spreads_as_fast(circle_map, sigma):
    """By half the growth of the variance over the second half of many paths."""
    noise = WrappedNormal(sigma)
    found = transfer_operator(circle_map, noise).diffusion
    paths = sample_staircases(circle_map, noise, 280, np.linspace(0, TWO_PI, 10_000), seed=7)
    climbs = paths[:, [160, 280]] - paths[:, [40]]
    middle, end = ((climbs - climbs.mean(axis=0)) ** 2).T
    growth = (end - middle) / 240
    error = growth.std() / np.sqrt(growth.size)
    assert error < 0.07 * max(growth.mean(), 2e-3)
    assert abs(growth.mean() - found) < 5 * error and found.error_bound < 1e-10


def test_two_equal_wells_make_a_walk_of_half_turns():
    """Hops of ±π at rate Γ give D = π²Γ/2 and an eigenvalue 1 - 2Γ, so D = (π²/4)·gap."""
    law = transfer_operator(TWIN_WELLS, WrappedNormal(0.3))
    assert law.spectral_gap < 1e-3
    assert law.diffusion == pytest.approx(0.25 * np.pi**2 * law.spectral_gap, rel=1e-2)


def test_bounds_of_the_diffusion_hold_with_few_modes():
    circle_map, noise = CircleMap.arnold(0.3, 3.0), WrappedNormal(0.3)
    truth = transfer_operator(circle_map, noise).diffusion
    for modes in (8, 11, 14):
        few = transfer_operator(circle_map, noise, modes=modes).diffusion
        assert abs(few - truth) <= few.error_bound + truth.error_bound
        assert few.error_bound <= 100 * abs(few - truth)
