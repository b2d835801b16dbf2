"""Laws on the circle, distances, Kuiper's and Watson's statistics, p-values, modes: closed forms
and invariances.
"""

import numpy as np
import pytest
from refusals import refused
from scipy.optimize import linear_sum_assignment
from scipy.stats import vonmises

from cyclemap.evidence import kernel_modes
from cyclemap.evidence.laws.circular_distance import (
    CircularLaw,
    PValue,
    circular_wasserstein,
    kuiper_statistic,
    monte_carlo_p_value,
    orientations,
    total_variation,
    watson_statistic,
)

TURN = 2 * np.pi
DISTANCES = (circular_wasserstein, total_variation)
STATISTICS = (kuiper_statistic, watson_statistic)
MEASURES = pytest.mark.parametrize("measure", DISTANCES + STATISTICS)


def cardioid(tilt: float, centre: float = 0.0, cells: int = 2048, order: int = 1) -> CircularLaw:
    return CircularLaw(lambda theta: (1.0 + tilt * np.cos(order * (theta - centre))) / TURN, cells)


uniform = cardioid(0.0)


def evenly(count: int, size: int, seed: int):
    return np.random.default_rng(seed).uniform(0.0, TURN, (count, size))


def test_the_distribution_function_is_that_of_the_von_mises_law() -> None:
    law = CircularLaw(lambda theta: vonmises.pdf(theta, 20.0, loc=2.0))
    angles = np.linspace(0.0, 6.28, 777)
    truth = vonmises.cdf(angles, 20.0, loc=2.0) - vonmises.cdf(0.0, 20.0, loc=2.0)
    assert np.abs(law.cumulative(angles) - truth).max() < 1e-10


def test_the_error_falls_with_the_fourth_power_of_the_cell() -> None:
    angles = np.linspace(0.0, 6.28, 7777)
    truth = angles / TURN + 0.8 * np.sin(3 * angles) / (3 * TURN)
    counts = [16, 32, 64, 128]
    laws = [cardioid(0.8, cells=count, order=3) for count in counts]
    errors = [np.abs(law.cumulative(angles) - truth).max() for law in laws]
    assert -np.polyfit(np.log(counts), np.log(errors), 1)[0] > 3.7


def test_beside_jumps_the_distribution_function_never_falls_and_is_off_by_at_most_a_cell() -> None:
    law = CircularLaw(lambda theta: np.where((theta >= 1.0) & (theta < 3.0), 0.5, 0.0))
    angles = np.linspace(0.0, TURN * (1 - 1e-12), 50_001)
    reached = law.cumulative(angles)
    assert np.diff(reached).min() >= -1e-14
    assert reached[[0, -1]] == pytest.approx([0.0, 1.0], abs=1e-12)
    assert np.abs(reached - np.clip(0.5 * (angles - 1.0), 0.0, 1.0)).max() < TURN / law.cells


def test_between_equal_samples_it_is_the_cheapest_assignment() -> None:
    for first, second in zip(evenly(10, 12, 1), 0.4 * evenly(10, 12, 2), strict=True):
        gap = np.mod(np.subtract.outer(first, second), TURN)
        cost = np.minimum(gap, TURN - gap)
        least = cost[linear_sum_assignment(cost)].mean()
        assert circular_wasserstein(first, second) == pytest.approx(least, abs=1e-13)


def test_a_point_is_as_far_from_a_law_as_the_mean_distance_to_it() -> None:
    """All mass moves to the one point: E|θ - θ0| = π/2 - (2/π) tilt cos(θ0 - centre), to the stated
    h²/8·TV(p).
    """
    for centre in (0.0, 1.0, 2.5):
        truth = np.pi / 2 - 2.0 / np.pi * 0.8 * np.cos(0.4 - centre)
        for cells in (64, 2048):
            bound = (TURN / cells) ** 2 / 8 * (4 * 0.8 / TURN)
            found = circular_wasserstein([0.4], cardioid(0.8, centre, cells))
            assert found == pytest.approx(truth, abs=bound)


def test_against_a_law_it_is_what_a_fine_sample_of_the_law_gives() -> None:
    law, grid = cardioid(0.9, 2.0), np.linspace(0.0, TURN * (1 - 1e-12), 200_001)
    fine = np.interp((np.arange(20_000) + 0.5) / 20_000, law.cumulative(grid), grid)
    for sample in 0.5 * evenly(2, 40, 3):
        truth = float(circular_wasserstein(sample, fine))
        assert circular_wasserstein(sample, law) == pytest.approx(truth, abs=1e-3)


@MEASURES
def test_rotating_both_by_whole_bins_changes_nothing(measure) -> None:
    sample, turn = evenly(1, 30, 3)[0] ** 1.3, 5 * TURN / 36
    plain, turned = (measure(sample + by, cardioid(0.8, 1.0 + by)) for by in (0.0, turn))
    assert turned == pytest.approx(float(plain), abs=1e-6)
    if measure in DISTANCES:
        plain, turned = (measure(sample + by, evenly(1, 20, 5)[0] + by) for by in (0.0, turn))
        assert turned == pytest.approx(float(plain), abs=1e-12)


def test_whole_turns_and_reflection_change_nothing() -> None:
    assert orientations("the sample", [-1e-20]).tolist() == [0.0]
    turned = cardioid(1.0).cumulative([1.0 + 3 * TURN, 1.0 - TURN])
    assert np.allclose(turned, cardioid(1.0).cumulative(1.0), atol=1e-14)
    first, second = 0.3 * evenly(2, 30, 6)
    plain = pytest.approx(float(circular_wasserstein(first, second)), abs=1e-12)
    assert circular_wasserstein(first + TURN * np.arange(30), second - 4 * TURN) == plain
    assert circular_wasserstein(-first, -second) == plain


@MEASURES
def test_rows_are_measured_each_for_itself(measure) -> None:
    rows = evenly(6, 20, 6)
    together = measure(rows.reshape(2, 3, 20), cardioid(0.5))
    assert together.shape == (2, 3)
    assert together[1, 2] == pytest.approx(float(measure(rows[5], cardioid(0.5))), abs=1e-14)


def test_total_variation_of_hand_made_samples() -> None:
    assert total_variation([0.1] * 5, uniform, bins=10) == pytest.approx(0.9)
    for second, share in (([0.2, 4.0], 0.5), ([2.1, 0.2], 0.0)):
        assert total_variation([0.1, 2.0], second, bins=4) == pytest.approx(share)


def test_watson_is_its_integral() -> None:
    """U² = n ∫ (F - G - mean)² dG, with dG by the midpoint rule."""
    sample, grid = evenly(1, 15, 1)[0], (np.arange(400_000) + 0.5) / 400_000
    excess = np.searchsorted(np.sort(sample / TURN), grid) / 15 - grid
    assert watson_statistic(sample, uniform) == pytest.approx(15 * np.var(excess), abs=1e-4)


def test_kuiper_is_the_arc_that_differs_most() -> None:
    sample = np.sort(evenly(1, 15, 2)[0]) / TURN
    # From each orientation to each other one, or round to itself, with and without its ends.
    steps = np.arange(15)[:, np.newaxis] + np.arange(15)
    arcs = np.mod(sample[steps % 15] - sample[:, np.newaxis], 1.0)
    inside = np.arange(1, 16) / 15
    most = max((inside - arcs).max(), (arcs - inside + 2 / 15)[:, 1:].max())
    assert kuiper_statistic(sample * TURN, uniform) == pytest.approx(most, abs=1e-12)


@pytest.mark.parametrize("statistic", STATISTICS)
def test_a_change_of_variable_changes_nothing(statistic) -> None:
    law, sample = cardioid(0.9, 1.0), evenly(1, 40, 4)[0]
    straight = statistic(TURN * law.cumulative(sample), uniform)
    assert statistic(sample, law) == pytest.approx(float(straight), abs=1e-12)


def test_a_p_value_counts_the_observed_value_and_those_equal_but_for_rounding() -> None:
    found = monte_carlo_p_value(2.5, np.arange(101.0))
    assert (found.value, found.runs, found.statistic) == (99 / 102, 101, 2.5)
    assert found.null_quantiles.tolist() == pytest.approx([100 * level for level in PValue.LEVELS])
    assert monte_carlo_p_value(9.0, np.arange(9)).value == 0.1
    assert monte_carlo_p_value(0.3, [0.1 + 0.2, 0.3, 0.3 - 1e-16]).value == 1.0


def test_its_standard_error_is_that_of_repeated_simulation() -> None:
    random = np.random.default_rng(2)
    repeated = [monte_carlo_p_value(1.0, random.normal(size=200)) for _ in range(600)]
    spread = np.std([found.value for found in repeated])
    assert np.mean([found.standard_error for found in repeated]) == pytest.approx(spread, rel=0.1)
    assert monte_carlo_p_value(99.0, random.normal(size=200)).standard_error > 0.0


def even_density(theta):
    return np.full_like(theta, 1.0 / TURN)


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: CircularLaw(lambda theta: even_density(theta) * TURN / 360.0), "0.0174533 over"),
        (lambda: CircularLaw(lambda theta: even_density(theta) * 1.02), "integrates to 1.02"),
        (lambda: cardioid(1.5), "must not be negative"),
        (lambda: CircularLaw(lambda theta: np.where(theta > 3.0, np.nan, 0.1)), "must be finite"),
        (lambda: CircularLaw(lambda theta: np.array(1.0 / TURN)), "must be vectorised"),
        (lambda: CircularLaw(0.3), "vectorised callable"),
        (lambda: cardioid(0.5, cells=4), "cells must be at least 8"),
        (lambda: total_variation([1.0], [1.0, 2.0], bins=0), "bins"),
        (lambda: kernel_modes([0.0, 1.0], 0.001), r"bandwidth is 0\.001"),
        (lambda: monte_carlo_p_value(1.0, []), "no simulated values"),
        (lambda: monte_carlo_p_value(np.nan, [1.0]), "observed must be a finite number"),
        (lambda: monte_carlo_p_value(1.0, [1.0, np.inf]), "simulated must be finite"),
    ],
)
def test_what_is_no_density_no_bandwidth_and_no_simulation_is_refused(call, match) -> None:
    refused(call, told=match)


@MEASURES
def test_bad_samples_are_refused(measure) -> None:
    one_sample = [
        ([], uniform, "at least one orientation"),
        ([1.0, np.nan], uniform, "entry 1 is nan"),
        (["north"], uniform, "numbers only"),
    ]
    two_samples = [
        ([1.0], [], "second sample has shape"),
        ([1.0], [[1.0, 2.0]], "must have 1 axes"),
        ([[1.0], [2.0]], [1.0], "must have 1 axes"),
        ([1.0], [np.inf], "must be finite"),
    ]
    for sample, law, match in one_sample + two_samples * (measure in DISTANCES):
        refused(measure, sample, law, told=match)
    for bins in (0, -1, 2.5, 10**7):
        refused(total_variation, [1.0], uniform, bins=bins, told="bins")


def test_modes_are_those_of_the_kernel_sum_and_a_uniform_sample_has_none() -> None:
    """The Fourier series against the sum of wrapped normal kernels, maximised on a fine grid."""
    random = np.random.default_rng(1)
    sample = np.concatenate([random.normal(1.0, 0.2, 60), random.normal(3.5, 0.3, 40)])
    grid = np.linspace(0.0, TURN, 20_001)
    off = grid[:, np.newaxis] - sample
    kernels = sum(np.exp(-0.5 * ((off + turn) / 0.25) ** 2) for turn in (-TURN, 0.0, TURN))
    values = np.sum(kernels, axis=1)
    tops = grid[1:-1][(values[1:-1] > values[:-2]) & (values[1:-1] > values[2:])]
    assert kernel_modes(sample, 0.25) == pytest.approx(tops, abs=TURN / 20_000) and tops.size == 2
    assert kernel_modes(TURN * np.arange(100) / 100).size == 0
