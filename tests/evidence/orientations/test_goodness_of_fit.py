"""Kuiper's and Watson's statistics by hand and by quadrature; their p-values under independence."""

from itertools import combinations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.stats import kstest

from cyclemap.errors import InvalidInput
from cyclemap.evidence.orientations.circular_distance import CircularLaw, pooled_samples, total_variation
from cyclemap.evidence.orientations.goodness_of_fit import (
    kuiper_critical_value,
    kuiper_p_value,
    kuiper_statistic,
    kuiper_tail,
    permutation_p_value,
    watson_critical_value,
    watson_p_value,
    watson_statistic,
    watson_tail,
)

TURN = 2 * np.pi
STATISTICS = (kuiper_statistic, watson_statistic)


def uniform(theta):
    return np.full_like(theta, 1.0 / TURN)


def cardioid(tilt: float, centre: float):
    return lambda theta: (1.0 + tilt * np.cos(theta - centre)) / TURN


def drawn(count: int, size: int, seed: int):
    return np.random.default_rng(seed).uniform(0.0, TURN, (count, size))


def test_equally_spaced_points_give_the_least_values() -> None:
    for count in (1, 2, 7, 50):
        spaced = 0.2 + TURN * np.arange(count) / count
        assert kuiper_statistic(spaced, uniform) == pytest.approx(1.0 / count, abs=1e-12)
        assert watson_statistic(spaced, uniform) == pytest.approx(1.0 / (12 * count), abs=1e-12)


def test_points_all_at_one_place_give_the_greatest() -> None:
    assert kuiper_statistic([1.0] * 9, uniform) == pytest.approx(1.0, abs=1e-12)
    assert watson_statistic([1.0] * 9, uniform) == pytest.approx(9 / 12, abs=1e-12)  # n Var(uniform)


def test_watson_is_its_integral() -> None:
    """U² = n ∫ (F - G - mean)² dG, with dG by the midpoint rule."""
    sample, grid = drawn(1, 15, 1)[0], (np.arange(400_000) + 0.5) / 400_000
    excess = np.searchsorted(np.sort(sample / TURN), grid) / 15 - grid
    assert watson_statistic(sample, uniform) == pytest.approx(15 * np.var(excess), abs=1e-4)


def test_kuiper_is_the_arc_that_differs_most() -> None:
    sample = np.sort(drawn(1, 15, 2)[0]) / TURN
    closed = [(j - i + 1) / 15 - (sample[j] - sample[i]) for i in range(15) for j in range(i, 15)]
    empty = [sample[j] - sample[i] - (j - i - 1) / 15 for i in range(15) for j in range(i + 1, 15)]
    around = [1.0 - (sample[j] - sample[i]) - (i + 14 - j) / 15 for i in range(15) for j in range(i, 15)]
    assert kuiper_statistic(sample * TURN, uniform) == pytest.approx(max(closed + empty + around), abs=1e-12)


def test_two_samples_by_hand() -> None:
    # Alternating: the difference runs 1/2, 0, 1/2, 0; one after the other: 1/2, 1, 1/2, 0.
    assert kuiper_statistic([0.0, 2.0], [1.0, 3.0]) == pytest.approx(0.5)
    assert watson_statistic([0.0, 2.0], [1.0, 3.0]) == pytest.approx(4 / 16 * 4 * 0.0625)
    assert kuiper_statistic([0.0, 1.0], [2.0, 3.0]) == pytest.approx(1.0)
    assert watson_statistic([0.0, 1.0], [2.0, 3.0]) == pytest.approx(4 / 16 * 0.5)


def test_a_sample_does_not_differ_from_itself_ties_and_all() -> None:
    sample = [0.5, 0.5, 2.0, 5.0]
    for statistic in STATISTICS:
        assert statistic(sample, sample[::-1]) == pytest.approx(0.0, abs=1e-15)
        assert statistic(sample, sample * 3) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("statistic", STATISTICS)
@pytest.mark.parametrize("turn", [0.1, 2.0, np.pi, 5.5])
def test_rotating_the_circle_or_its_origin_changes_nothing(statistic, turn) -> None:
    first, second = drawn(2, 30, 3) ** 1.3
    plain = float(statistic(first, second))
    assert statistic(first + turn, second + turn) == pytest.approx(plain, abs=1e-12)
    against = float(statistic(first, cardioid(0.8, 1.0)))
    assert statistic(first + turn, cardioid(0.8, 1.0 + turn)) == pytest.approx(against, abs=1e-9)


@pytest.mark.parametrize("statistic", STATISTICS)
def test_a_change_of_variable_changes_nothing(statistic) -> None:
    """Both depend on G(θ) alone."""
    law, sample = CircularLaw(cardioid(0.9, 1.0)), drawn(1, 40, 4)[0]
    straight = statistic(TURN * law.cumulative(sample), uniform)
    assert statistic(sample, law) == pytest.approx(float(straight), abs=1e-12)


def test_no_arc_differs_by_more_than_the_total_variation() -> None:
    random, centres = np.random.default_rng(5), TURN * (np.arange(12) + 0.5) / 12
    for _ in range(50):
        first, second = random.choice(centres, 9), random.choice(centres, 14)
        assert kuiper_statistic(first, second) <= total_variation(first, second, bins=12) + 1e-12


def test_rows_are_measured_each_for_itself() -> None:
    rows = drawn(6, 20, 6)
    for statistic in STATISTICS:
        together = statistic(rows.reshape(2, 3, 20), uniform)
        assert together.shape == (2, 3)
        assert together[1, 0] == pytest.approx(float(statistic(rows[3], uniform)), abs=1e-15)


def test_kuipers_constants() -> None:
    assert kuiper_critical_value(0.05) == pytest.approx(1.74725994585, abs=1e-11)
    assert kuiper_critical_value(0.01) == pytest.approx(2.00091811932, abs=1e-11)


def test_tails_fall_from_one_to_nothing() -> None:
    for tail, top in ((kuiper_tail, 6.0), (watson_tail, 3.0)):
        values = np.array([tail(x) for x in np.linspace(0.0, top, 601)])
        assert values[0] == 1.0
        assert (np.diff(values) <= 1e-14).all()
        assert 0.0 < values[-1] < 1e-20


def test_watsons_tail_is_its_series() -> None:
    k = np.arange(1, 60)
    for u in (0.05, 0.1, 0.2, 0.4):
        series = 2 * np.sum((-1.0) ** (k - 1) * np.exp(-2 * (k * np.pi) ** 2 * u))
        assert watson_tail(u) == pytest.approx(series, abs=1e-14)
    assert watson_tail(watson_critical_value(0.05)) == pytest.approx(0.05, abs=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("size", [8, 20, 100])
@pytest.mark.parametrize("level", [0.1, 0.05, 0.01])
def test_stephens_correction_holds_the_level_for_small_samples(size, level) -> None:
    """20,000 samples: the share of small p-values within four standard errors and 4 % of the level."""
    rows = drawn(20_000, size, 7)
    slack = 4 * np.sqrt(level * (1 - level) / 20_000) + 0.04 * level
    for statistic, p_value in ((kuiper_statistic, kuiper_p_value), (watson_statistic, watson_p_value)):
        values = np.sort(statistic(rows, uniform))
        found = np.mean(values >= _threshold(p_value, size, level))
        assert abs(found - level) < slack


def _threshold(p_value, size: int, level: float) -> float:
    return brentq(lambda value: p_value(value, size) - level, 1e-3, 3.0)


def test_p_values_are_uniform_for_independent_samples() -> None:
    law, grid = CircularLaw(cardioid(0.8, 2.0)), np.linspace(0.0, TURN * (1 - 1e-12), 20_001)
    rows = np.interp(np.random.default_rng(8).uniform(size=(400, 60)), law.cumulative(grid), grid)
    for statistic, p_value in ((kuiper_statistic, kuiper_p_value), (watson_statistic, watson_p_value)):
        values = [p_value(float(value), 60) for value in statistic(rows, law)]
        assert len(values) == 400
        assert kstest(values, "uniform").pvalue > 0.01


# Kuiper's and the total variation take few values: ties make their p-values larger.
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "least"), [("wasserstein", 0.06), ("total_variation", 0.02), ("kuiper", 0.02), ("watson", 0.06)]
)
def test_permutation_holds_its_level_and_finds_a_difference(name, least) -> None:
    random = np.random.default_rng(9)
    null = [permutation_p_value(*random.normal(1.0, 0.8, (2, 25)), name, runs=39, seed=k).value for k in range(300)]
    assert len(null) == 300
    assert least <= np.mean(np.array(null) <= 0.1) <= 0.14
    moved = permutation_p_value(random.normal(1.0, 0.8, 60), random.normal(2.0, 0.8, 60), name)
    assert moved.value <= 0.005


def test_permutation_agrees_with_all_relabellings() -> None:
    first, second = [0.1, 0.5, 0.9, 2.0], [1.5, 2.2, 3.0, 5.5]
    pooled = pooled_samples(first, second)
    every = np.zeros((70, 8), dtype=bool)
    for row, chosen in enumerate(combinations(range(8), 4)):
        every[row, list(chosen)] = True
    exact = np.mean(pooled.watson(every) >= pooled.watson(pooled.first) - 1e-12)
    found = permutation_p_value(first, second, "watson", runs=4000, seed=1)
    assert abs(found.value - exact) < 4 * found.standard_error


def test_the_same_seed_gives_the_same_value() -> None:
    first, second = drawn(2, 20, 10)
    values = {permutation_p_value(first, second, seed=seed, runs=99).value for seed in (4, 4)}
    assert len(values) == 1


def test_bad_input_is_refused() -> None:
    for statistic in STATISTICS:
        with pytest.raises(InvalidInput, match="at least one orientation"):
            statistic([], uniform)
        with pytest.raises(InvalidInput, match="entry 0 is nan"):
            statistic([np.nan], uniform)
        with pytest.raises(InvalidInput, match="integrates to"):
            statistic([1.0], lambda theta: 2 * uniform(theta))
    with pytest.raises(InvalidInput, match="runs must be at least 1"):
        permutation_p_value([1.0], [2.0], runs=0)
    with pytest.raises(InvalidInput, match="'rayleigh': it must be one of wasserstein"):
        permutation_p_value([1.0], [2.0], "rayleigh")
    with pytest.raises(InvalidInput, match="count must be at least 1"):
        kuiper_p_value(0.3, 0)
    with pytest.raises(InvalidInput, match="statistic must be positive"):
        watson_p_value(-1.0, 10)
    with pytest.raises(InvalidInput, match="between 0 and 1"):
        kuiper_critical_value(1.0)
