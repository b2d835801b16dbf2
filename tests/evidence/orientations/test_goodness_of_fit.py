"""Kuiper's and Watson's statistics by hand and by quadrature; Monte Carlo p-values."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.evidence.orientations.circular_distance import (
    CircularLaw,
    PValue,
    kuiper_statistic,
    monte_carlo_p_value,
    watson_statistic,
)

TURN = 2 * np.pi
STATISTICS = (kuiper_statistic, watson_statistic)


def uniform(theta):
    return np.full_like(theta, 1.0 / TURN)


def cardioid(tilt: float, centre: float):
    return lambda theta: (1.0 + tilt * np.cos(theta - centre)) / TURN


def drawn(count: int, size: int, seed: int):
    return np.random.default_rng(seed).uniform(0.0, TURN, (count, size))


def test_equally_spaced_points_give_the_least_values_and_points_at_one_place_the_greatest() -> None:
    for count in (1, 2, 7, 50):
        spaced = 0.2 + TURN * np.arange(count) / count
        assert kuiper_statistic(spaced, uniform) == pytest.approx(1.0 / count, abs=1e-12)
        assert watson_statistic(spaced, uniform) == pytest.approx(1.0 / (12 * count), abs=1e-12)
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


@pytest.mark.parametrize("statistic", STATISTICS)
@pytest.mark.parametrize("turn", [0.1, 2.0, np.pi, 5.5])
def test_rotating_the_circle_or_its_origin_changes_nothing(statistic, turn) -> None:
    sample = drawn(1, 30, 3)[0] ** 1.3
    plain = float(statistic(sample, cardioid(0.8, 1.0)))
    assert statistic(sample + turn, cardioid(0.8, 1.0 + turn)) == pytest.approx(plain, abs=1e-9)


@pytest.mark.parametrize("statistic", STATISTICS)
def test_a_change_of_variable_changes_nothing(statistic) -> None:
    """Both depend on G(θ) alone."""
    law, sample = CircularLaw(cardioid(0.9, 1.0)), drawn(1, 40, 4)[0]
    straight = statistic(TURN * law.cumulative(sample), uniform)
    assert statistic(sample, law) == pytest.approx(float(straight), abs=1e-12)
    # Rows are measured each for itself.
    rows = drawn(6, 20, 6)
    together = statistic(rows.reshape(2, 3, 20), uniform)
    assert together.shape == (2, 3)
    assert together[1, 0] == pytest.approx(float(statistic(rows[3], uniform)), abs=1e-15)


def test_it_counts_the_observed_value_and_those_equal_but_for_rounding_among_the_simulated() -> None:
    found = monte_carlo_p_value(2.5, np.arange(101.0))
    assert (found.value, found.runs, found.statistic) == (99 / 102, 101, 2.5)
    assert found.null_quantiles.tolist() == pytest.approx([100 * level for level in PValue.LEVELS])
    assert monte_carlo_p_value(9.0, np.arange(9)).value == 0.1
    assert monte_carlo_p_value(0.3, [0.1 + 0.2, 0.3, 0.3 - 1e-16]).value == 1.0


def test_it_is_valid_for_few_runs() -> None:
    """Exchangeable values: P(p ≤ k/(runs + 1)) = k/(runs + 1) exactly."""
    drawn = np.random.default_rng(1).normal(size=(4000, 20))
    values = np.array([monte_carlo_p_value(row[0], row[1:]).value for row in drawn])
    for k in (1, 2, 10):
        assert np.mean(values <= k / 20 + 1e-12) == pytest.approx(k / 20, abs=4 * np.sqrt(k / 20 * (1 - k / 20) / 4000))


def test_its_standard_error_is_that_of_repeated_simulation() -> None:
    random = np.random.default_rng(2)
    repeated = [monte_carlo_p_value(1.0, random.normal(size=200)) for _ in range(1500)]
    spread = np.std([found.value for found in repeated])
    assert np.mean([found.standard_error for found in repeated]) == pytest.approx(spread, rel=0.1)
    assert monte_carlo_p_value(99.0, random.normal(size=200)).standard_error > 0.0


@pytest.mark.parametrize(
    ("call", "match"),
    [
        *((lambda one=one: one([], uniform), "at least one orientation") for one in STATISTICS),
        *((lambda one=one: one([np.nan], uniform), "entry 0 is nan") for one in STATISTICS),
        *((lambda one=one: one([1.0], lambda theta: 2 * uniform(theta)), "integrates to") for one in STATISTICS),
        (lambda: monte_carlo_p_value(1.0, []), "no simulated values"),
        (lambda: monte_carlo_p_value(np.nan, [1.0]), "observed must be a finite number"),
        (lambda: monte_carlo_p_value(1.0, [1.0, np.inf]), "simulated must be finite"),
    ],
)
def test_bad_input_is_refused(call, match) -> None:
    with pytest.raises(InvalidInput, match=match):
        call()
