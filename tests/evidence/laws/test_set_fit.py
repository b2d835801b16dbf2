"""The laws of a set and its histogram: what they explain, and what chance alone makes."""

import numpy as np
import pytest
from made_sets import made_set, noisy_set, true_turn
from refusals import refused
from scipy.stats import wasserstein_distance

from cyclemap.evidence.laws.periodic_law import fit_periodic_law
from cyclemap.evidence.laws.push_sets import push_statistics
from cyclemap.evidence.laws.set_fit import motion_law, set_laws, turn_histogram

GRID = np.linspace(0.0, 2 * np.pi, 90)
# The paper's plywood: RMSE of the fitted law of Δθ (°), of Δx and Δy (mm): the noise put on the
# simulated pushes.
NOISE = np.deg2rad(2.07), 0.91e-3, 3.39e-3


def test_laws_of_simulated_plywood_leave_the_noise_and_the_two_tables_add_up(real_loop) -> None:
    """400 pushes on Table I's plywood, 100 orientations at random, each four times, with the
    paper's noise.
    """
    rng = np.random.default_rng(0)
    cycles = real_loop.cycles(rng.uniform(0.0, 2 * np.pi, 100))
    true = np.tile(np.column_stack([cycles.push_turn, cycles.push_displacement]), (4, 1))
    measured = true + np.array(NOISE) * rng.standard_normal((400, 3))
    pushes = made_set(np.tile(cycles.theta, 4), *measured.T)
    statistics, laws = push_statistics(pushes), set_laws(pushes)
    rows = statistics.dtheta, statistics.dx, statistics.dy
    for row, found, sigma, exact in zip(rows, laws, NOISE, true.T, strict=True):
        assert found.problem is None and found.law.rmse == pytest.approx(sigma, rel=0.1)
        assert found.cross_validated_rmse == pytest.approx(sigma, rel=0.12)
        # The law itself is nearer the mechanics than any one push.
        assert np.sqrt(np.mean((found.law(pushes.theta) - exact) ** 2)) < 0.3 * sigma
        whole = np.var(found.law(found.theta)) + found.law.rmse**2
        assert row.std**2 == pytest.approx(whole, rel=0.02)
        assert 100 * found.law.total_std / abs(found.law.mean) == pytest.approx(row.percent)
        assert 0.0 < found.explained < 1.0


def test_a_law_without_noise_explains_all_and_noise_without_a_law_nothing() -> None:
    rng = np.random.default_rng(6)
    theta = rng.uniform(0.0, 6.0, 120)
    found = motion_law("dtheta", theta, true_turn(theta))
    assert (found.law.harmonics, found.explained) == (2, pytest.approx(1.0))
    assert np.allclose(found.law(GRID), true_turn(GRID), atol=1e-12)
    found = motion_law("dy", rng.uniform(0.0, 6.0, 200), rng.standard_normal(200))
    assert found.law.harmonics == 0 and found.explained == pytest.approx(0.0, abs=0.05)


@pytest.mark.parametrize(
    ("theta", "told"),
    [
        ([0.0, 1.0], "too few pushes with a known end for a law: 2 of 20"),
        ([1.0] * 30, "fix 1 of 7 coefficients"),
    ],
)
def test_a_set_that_fixes_no_law_says_so_and_does_not_fail(theta, told) -> None:
    noise = np.random.default_rng(0).standard_normal(len(theta))
    laws = set_laws(made_set(theta, 1.0 + noise, noise, noise), harmonics=3)
    assert [law.law for law in laws] == [None] * 3 and told in laws[0].problem
    assert np.isnan(laws[0].cross_validated_rmse) and np.isnan(laws[0].explained)


def fitted(seed: int = 0, count: int = 300):
    pushes = noisy_set(seed, count)
    return pushes, fit_periodic_law(pushes.theta, pushes.dtheta, harmonics=2)


def test_predicted_counts_are_those_of_many_draws_of_theta0_projected_through_the_law() -> None:
    pushes, law = fitted()
    found = turn_histogram(pushes.theta, pushes.dtheta, law, runs=2)
    rng, draws = np.random.default_rng(1), 400_000
    theta = rng.choice(pushes.theta, draws)
    drawn = law(theta) + law.noise(theta) * rng.standard_normal(draws)
    inside = np.clip(drawn, found.edges[0], found.edges[-1])
    counts = np.histogram(inside, found.edges)[0] * 300 / draws
    assert np.max(np.abs(counts - found.predicted)) < 0.15
    assert np.sum(found.predicted) == pytest.approx(300.0)


def test_the_law_alone_puts_every_orientation_where_the_law_does() -> None:
    pushes, law = fitted()
    found = turn_histogram(pushes.theta, pushes.dtheta, law, runs=2)
    assert np.allclose(found.law_alone, np.histogram(law(pushes.theta), found.edges)[0])
    assert np.array_equal(found.measured, np.histogram(pushes.dtheta, found.edges)[0])
    assert found.count == 300
    share = 0.5 * np.sum(np.abs(found.measured - found.law_alone)) / 300
    assert found.law_alone_total_variation == pytest.approx(share)
    exact = wasserstein_distance(pushes.dtheta, law(pushes.theta))
    assert found.law_alone_distance == pytest.approx(exact, rel=0.02)


def test_a_constant_added_to_the_values_and_a_change_of_unit_change_no_share() -> None:
    pushes, law = fitted()
    moved = fit_periodic_law(pushes.theta, 5.0 + 57.0 * pushes.dtheta, harmonics=2)
    one = turn_histogram(pushes.theta, pushes.dtheta, law, runs=5)
    other = turn_histogram(pushes.theta, 5.0 + 57.0 * pushes.dtheta, moved, runs=5)
    assert other.total_variation == pytest.approx(one.total_variation, abs=1e-9)
    assert other.distance == pytest.approx(57.0 * one.distance, rel=1e-9)


def test_p_values_of_a_right_law_are_uniform_though_it_was_fitted_to_the_same_pushes() -> None:
    values = []
    for seed in range(60):
        pushes, law = fitted(seed, 120)
        found = turn_histogram(pushes.theta, pushes.dtheta, law, bins=20, runs=19, seed=seed)
        values.append(found.chance.value)
    for level in (0.1, 0.25, 0.5):
        share, error = np.mean(np.array(values) <= level), np.sqrt(level * (1.0 - level) / 60)
        assert abs(share - level) < 3.0 * error


def test_a_law_that_misses_two_lumps_is_told_from_chance() -> None:
    rng = np.random.default_rng(2)
    theta = rng.uniform(0.0, 2 * np.pi, 300)
    value = true_turn(theta) + 0.1 * rng.choice([-1.0, 1.0], 300) + 0.01 * rng.standard_normal(300)
    found = turn_histogram(theta, value, fit_periodic_law(theta, value, harmonics=2), runs=99)
    assert found.total_variation > found.chance_total_variation
    assert found.chance.value == pytest.approx(0.01)


def test_bad_input_is_refused_by_name() -> None:
    pushes, law = fitted()
    even, own = (np.arange(30.0), np.ones(30)), (pushes.theta, pushes.dtheta)
    refused(turn_histogram, *even, fit_periodic_law(*even, harmonics=0), told="all values are 1")
    refused(turn_histogram, *own, law, bins=1, told="bins must be at least 2")
    refused(turn_histogram, *own, law, runs=0, told="runs must be at least 1")
    refused(turn_histogram, pushes.theta[1:], pushes.dtheta, law, told="entries")
