"""Evenness, worth of pushes and coverage: closed forms, formulas for independent draws, and a second route to each."""

import numpy as np
import pytest
from scipy.stats import kstwobign

from cyclemap.errors import InvalidInput
from cyclemap.evidence.orientations.circular_distance import circular_wasserstein, total_variation
from cyclemap.evidence.orientations.circular_law import CircularLaw
from cyclemap.maps import (
    CircleMap,
    UniformNoise,
    WrappedCauchy,
    WrappedNormal,
    survival_probabilities,
    transfer_operator,
)
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.law_evolution import stationary_fourier_law
from cyclemap.maps.mixtures.mixture_operator import mixture_operator
from cyclemap.maps.mixtures.periodic_schedule import PeriodicSchedule
from cyclemap.resets.scores.coverage_measures import (
    GOLDEN_ANGLE,
    coverage_measures,
    independent_full_cover,
    independent_kuiper,
    independent_largest_gap,
    independent_sector_share,
    rotation_angles,
)
from cyclemap.resets.scores.effective_size import effective_size, mean_covariance
from cyclemap.resets.scores.evenness import evenness
from cyclemap.resets.scores.sampled_evenness import sampled_evenness
from cyclemap.resets.scores.sector_visits import sector_visits, sector_visits_from
from cyclemap.resets.scores.simulated_coverage import (
    SampledMean,
    chain_sampler,
    schedule_sampler,
    simulated_coverage,
)

TWO_PI = 2 * np.pi
STICKY = transfer_operator(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.2))
MIXED = mixture_operator([CircleMap.arnold(0.1, 0.9), CircleMap.arnold(0.3, 3.0)], [0.7, 0.3], WrappedNormal(0.2))
FORGETFUL = transfer_operator(CircleMap.moebius(0.4, 0.1), WrappedNormal(6.0))


def independent(runs, pushes, seed):
    return np.random.default_rng(seed).uniform(0, TWO_PI, (runs, pushes))


# -- evenness --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("operator", [STICKY, MIXED], ids=["map", "mixture"])
def test_distances_from_uniform_agree_with_the_operators_and_with_the_samples_own(operator):
    """TV by the operator's quadrature; W1 by the distance of 20,000 quantiles of the law from uniform."""
    law = stationary_fourier_law(operator)
    found = evenness(law)
    assert abs(found.total_variation - operator.tv_from_uniform) <= found.total_variation.error_bound + 1e-12
    grid = np.linspace(0, TWO_PI, 1 << 14)
    below = CircularLaw(operator.density).cumulative(grid[:-1])
    quantiles = np.interp((np.arange(20_000) + 0.5) / 20_000, np.append(below, 1.0), grid)
    second = circular_wasserstein(quantiles, lambda theta: np.full_like(theta, 0.5 / np.pi))
    assert abs(found.wasserstein - second) < 5e-4
    assert abs(found.peak_to_mean - TWO_PI * np.max(operator.density(grid))) < 1e-5
    assert found.certified


def test_a_target_given_as_density_or_as_law_gives_one_score_and_the_law_itself_none():
    law, wished = stationary_fourier_law(STICKY), WrappedCauchy(0.4)
    by_law = evenness(law, FourierLaw.from_density(wished.density, 200))
    by_density = evenness(law, wished.density)
    assert abs(by_law.total_variation - by_density.total_variation) < 1e-5
    assert abs(by_law.wasserstein - by_density.wasserstein) < 1e-5
    assert evenness(law, law).total_variation == 0.0
    assert evenness(law, STICKY.density).total_variation < 1e-9
    assert evenness(law, STICKY.density).wasserstein < 1e-9


def test_a_target_that_jumps_is_held_against_exactly():
    """Uniform law against half a circle: TV is 1/2 and W1 is π/4; the bounds hold."""
    found = evenness(FourierLaw.uniform(), lambda theta: np.where(np.mod(theta, TWO_PI) < np.pi, 1 / np.pi, 0.0))
    assert abs(found.total_variation - 0.5) <= found.total_variation.error_bound + 2e-4
    assert abs(found.wasserstein - np.pi / 4) <= found.wasserstein.error_bound + 2e-3


# -- worth of pushes -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("turn", [0.0, 0.15, 0.5])
def test_the_worth_of_a_noisy_rotations_pushes_is_known(turn):
    """A mean of harmonic k has Σ autocorrelations Re (1 + λ)/(1 - λ), λ = κ_k e^{ikα}: pushes that turn repel."""
    noise = WrappedNormal(0.4)
    worth = effective_size(transfer_operator(CircleMap.rigid(turn), noise), (1, 2, 3))
    for k, share in zip((1, 2, 3), worth.each, strict=True):
        value = noise.coefficients(k) * np.exp(1j * k * TWO_PI * turn)
        exact = 1.0 / ((1.0 + value) / (1.0 - value)).real
        assert abs(share - exact) <= share.error_bound + 1e-12
    assert abs(worth.worst - min(worth.each)) < 1e-12
    assert worth.of(200) == 200 * worth.worst


def test_pushes_that_forget_at_once_are_worth_one_each():
    assert abs(effective_size(FORGETFUL).worst - 1.0) < 1e-7


@pytest.mark.parametrize("operator", [STICKY, MIXED], ids=["map", "mixture"])
def test_the_covariance_of_means_is_the_sum_of_autocovariances_term_by_term(operator):
    """Second route: P^t cos kθ by powers of the transposed matrix on an even grid of the stationary law."""
    basis, order = operator.discretisation, 2
    means, single = mean_covariance(operator, order)
    theta = TWO_PI * np.arange(4096) / 4096
    mass = operator.density(theta) * theta[1]
    rows = np.stack([np.cos(order * theta), np.sin(order * theta)])
    centred = rows - (rows @ mass)[:, None]
    weighted = basis.evaluate(theta)
    product = np.linalg.lstsq(weighted, (centred * operator.density(theta)).T, rcond=None)[0]
    total, dual = centred * mass @ centred.T, np.stack([basis.moments(order).real, basis.moments(order).imag], axis=1)
    np.testing.assert_allclose(total, single, atol=1e-12)
    few = total
    for t in range(1, 600):
        dual = basis.backward(dual)
        later = product.T @ dual
        total = total + later + later.T
        few = few + max(0.0, 1.0 - t / 25) * (later + later.T)
    np.testing.assert_allclose(total, means, atol=1e-9)
    np.testing.assert_allclose(few, mean_covariance(operator, order, 25)[0], atol=1e-9)
    np.testing.assert_allclose(mean_covariance(operator, order, 1)[0], single, atol=1e-9)


def test_worst_of_all_combinations_is_no_better_than_the_worst_harmonic():
    worth = effective_size(MIXED, (1, 2, 3, 4))
    assert worth.worst <= min(worth.each) + 1e-12
    assert effective_size(MIXED, (1, 2)).worst >= worth.worst - 1e-12


# -- coverage --------------------------------------------------------------------------------------------------


def test_golden_angle_leaves_gaps_of_three_lengths_and_covers_better_than_chance():
    """Three-gap theorem (Sós 1958): after a Fibonacci number of pushes two lengths, none above 2.62 of the mean."""
    lengths = set()
    for n in (5, 21, 34, 50, 100):
        theta = np.sort(np.mod(rotation_angles(n, start=0.3), TWO_PI))
        gaps = np.diff(np.append(theta, theta[0] + TWO_PI))
        kinds = np.unique(np.round(gaps, 9)).size
        lengths.add(kinds)
        found = coverage_measures(rotation_angles(n, start=0.3))
        assert abs(found.largest_gap - gaps.max()) < 1e-12
        assert found.largest_gap < 2.62 * TWO_PI / n < independent_largest_gap(n) or n == 5
        assert found.kuiper < independent_kuiper(n)
    assert lengths == {2, 3}
    assert abs(GOLDEN_ANGLE / TWO_PI - (1 - (np.sqrt(5) - 1) / 2)) < 1e-15


def test_measures_do_not_depend_on_order_turns_or_rotation():
    theta = independent(6, 25, 3)
    found = coverage_measures(theta, 12)
    other = coverage_measures(theta[:, ::-1] + TWO_PI * np.arange(25) + TWO_PI / 12, 12)
    np.testing.assert_allclose(found.largest_gap, other.largest_gap, atol=1e-12)
    np.testing.assert_allclose(found.kuiper, other.kuiper, atol=1e-12)
    np.testing.assert_array_equal(found.sector_share, other.sector_share)
    table = CircularLaw(lambda angle: np.full_like(angle, 0.5 / np.pi))
    np.testing.assert_allclose(coverage_measures(theta, 12, table).kuiper, found.kuiper, atol=1e-12)
    by_hand = [np.unique(np.floor(row / TWO_PI * 12)).size / 12 for row in theta]
    np.testing.assert_allclose(found.sector_share, by_hand)


@pytest.mark.parametrize("count", [1, 2, 10, 50])
def test_simulated_independent_pushes_have_the_formulas_means(count):
    found = simulated_coverage(independent, count, sectors=8, runs=4000, seed=count)
    if count > 1:
        assert found.largest_gap.agrees(independent_largest_gap(count))
        assert found.sector_share.agrees(independent_sector_share(count, 8))
    else:
        assert abs(found.largest_gap.mean - TWO_PI) < 1e-14 and found.sector_share.mean == 1 / 8
    if count >= 10:
        allowed = 4 * found.kuiper.standard_error + 0.01 * independent_kuiper(count)
        assert abs(found.kuiper.mean - independent_kuiper(count)) < allowed


def test_the_mean_range_of_a_bridge_is_twice_its_mean_maximum():
    """√(π/2), the limit of √n·E V, is 2·E max of a Brownian bridge, and 1.44 times Kolmogorov's mean √(π/2)·ln 2."""
    assert abs(independent_kuiper(10**12) * 1e6 - np.sqrt(np.pi / 2)) < 1e-6
    assert abs(kstwobign.mean() / np.log(2) - np.sqrt(np.pi / 2)) < 1e-6


def test_full_cover_is_the_sum_of_the_chances_of_being_short_of_it():
    """Coupons: E T = Σ_n P(T > n), P(T > n) by inclusion and exclusion."""
    k = 6
    n = np.arange(400)[:, None]
    binomial = np.array([6, 15, 20, 15, 6, 1])
    j = np.arange(1, k + 1)
    short = np.sum(-((-1.0) ** j) * binomial * (1 - j / k) ** n, axis=1)
    assert abs(np.sum(short) - independent_full_cover(k)) < 1e-9


# -- sectors of a chain ----------------------------------------------------------------------------------------


def test_a_chain_without_memory_visits_sectors_like_independent_draws():
    visits = sector_visits(FORGETFUL, 30, 7)
    exact = [independent_sector_share(n, 7) for n in range(1, 31)]
    np.testing.assert_allclose(visits.stationary, exact, atol=1e-8)
    np.testing.assert_allclose(visits.worst, exact, atol=1e-8)


@pytest.mark.parametrize("operator", [STICKY, MIXED], ids=["map", "mixture"])
def test_sector_visits_agree_with_simulation_from_every_kind_of_start(operator):
    visits = sector_visits(operator, 40, 9)
    assert np.all(visits.error_bound < 1e-6)
    for start, expected in (("stationary", visits.stationary), ("uniform", visits.uniform), (2.5, None)):
        expected = sector_visits_from(operator, 2.5, 40, 9) if expected is None else expected
        for pushes in (1, 2, 10, 40):
            found = simulated_coverage(chain_sampler(operator, start), pushes, sectors=9, runs=2000, seed=7)
            assert found.sector_share.agrees(expected[pushes - 1]) or pushes == 1
    assert np.all(visits.worst <= np.minimum(visits.stationary, visits.uniform) + 1e-12)
    at_worst = sector_visits_from(operator, float(visits.worst_start[39]), 40, 9)
    assert abs(at_worst[39] - visits.worst[39]) < 1e-9


@pytest.mark.parametrize("shuffled", [False, True])
def test_sampled_schedules_follow_the_laws_of_the_schedule(shuffled):
    """Moments of 6000 collections before each cycle of a late block, alternating and in random order."""
    other = transfer_operator(CircleMap.arnold(0.3, 3.0), WrappedNormal(0.3))
    schedule = PeriodicSchedule([STICKY, other, MIXED], shuffled)
    paths = schedule_sampler(schedule)(6000, 36, 4)
    for j, law in enumerate(schedule.laws()):
        for order in (1, 2):
            values = np.exp(1j * order * paths[:, 33 + j])
            assert abs(np.mean(values) - law.moments[order]) < 4 * np.std(values) / np.sqrt(6000)
    assert np.all(schedule_sampler(schedule, 2.0)(5, 3, 0)[:, 0] == 2.0)


def test_sector_visits_agree_with_the_survival_of_the_arc_without_the_sector():
    """Second route, other code: no visit of a sector in n pushes is the path not leaving the arc that is left."""
    start, sectors, pushes = 2.5, 5, 12
    width, avoided = TWO_PI / sectors, np.zeros(pushes)
    for s in range(sectors):
        if int(start / width) != s:
            arc = ((s + 1) * width, (s + sectors) * width)
            avoided += survival_probabilities(STICKY.map, STICKY.noise, start, arc, pushes - 1)
    np.testing.assert_allclose(sector_visits_from(STICKY, start, pushes, sectors), 1 - avoided / sectors, atol=1e-11)


@pytest.mark.parametrize("operator", [STICKY, MIXED], ids=["map", "mixture"])
def test_sampled_evenness_holds_the_predicted_one_within_its_sampling_error(operator):
    """Binned TV and W1 of 100 collections against uniform, and against the law itself, which leaves only noise."""
    predicted, law = evenness(stationary_fourier_law(operator)), CircularLaw(operator.density)
    binned = 0.5 * np.sum(np.abs(law.bin_probabilities(36) - 1 / 36))
    found = sampled_evenness(chain_sampler(operator), 150, runs=100)
    assert abs(found.total_variation - binned) <= found.total_variation.error_bound < 0.1
    assert abs(found.wasserstein - predicted.wasserstein) <= found.wasserstein.error_bound < 0.2
    assert (found.pushes, found.runs) == (15_000, 100)
    own = sampled_evenness(chain_sampler(operator), 150, target=law, skipped=30)
    assert own.total_variation < 1.5 * own.total_variation.error_bound
    assert own.wasserstein < 1.5 * own.wasserstein.error_bound
    theta = chain_sampler(operator)(100, 150, 0).ravel()
    assert abs(found.wasserstein - circular_wasserstein(theta, lambda angle: np.full_like(angle, 0.5 / np.pi))) < 3e-3
    assert abs(found.total_variation - total_variation(theta, lambda angle: np.full_like(angle, 0.5 / np.pi))) < 1e-12


def test_bad_input_is_refused():
    with pytest.raises(InvalidInput, match="give a FourierLaw"):
        evenness(STICKY)
    with pytest.raises(InvalidInput, match="different orders from 1"):
        effective_size(STICKY, (1, 1))
    with pytest.raises(InvalidInput, match="start is 'worst'"):
        chain_sampler(STICKY, "worst")
    with pytest.raises(InvalidInput, match="one row a collection"):
        simulated_coverage(lambda runs, pushes, seed: np.zeros(3), 5)
    with pytest.raises(InvalidInput, match="leave at least one"):
        sampled_evenness(independent, 5, skipped=5)
    with pytest.raises(InvalidInput, match="at least 2"):
        sector_visits(STICKY, 5, 1)
    with pytest.raises(InvalidInput, match="narrow smooth noise"):
        effective_size(transfer_operator(CircleMap.rigid(0.1), UniformNoise(0.4)))
    assert SampledMean.of(np.array([1.0, 3.0])).standard_error == 1.0
