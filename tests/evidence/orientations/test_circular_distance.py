"""Laws on the circle and distances from them: closed forms, brute force, axioms and invariances."""

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment
from scipy.stats import vonmises

from cyclemap.errors import InvalidInput
from cyclemap.evidence.orientations.circular_distance import (
    CircularLaw,
    circular_wasserstein,
    orientations,
    total_variation,
)

TURN = 2 * np.pi


def uniform(theta):
    return np.full_like(theta, 1.0 / TURN)


def box(theta):
    """All mass between 1 and 3."""
    return np.where((theta >= 1.0) & (theta < 3.0), 0.5, 0.0)


def test_the_distribution_function_is_that_of_the_von_mises_law() -> None:
    law, angles = CircularLaw(lambda theta: vonmises.pdf(theta, 20.0, loc=2.0)), np.linspace(0.0, 6.28, 777)
    truth = vonmises.cdf(angles, 20.0, loc=2.0) - vonmises.cdf(0.0, 20.0, loc=2.0)
    assert np.abs(law.cumulative(angles) - truth).max() < 1e-10


def test_the_error_falls_with_the_fourth_power_of_the_cell() -> None:
    angles = np.linspace(0.0, 6.28, 7777)
    truth = angles / TURN + 0.8 * np.sin(3 * angles) / (3 * TURN)
    counts = np.array([16, 32, 64, 128])
    errors = []
    for count in counts:
        law = CircularLaw(lambda theta: (1.0 + 0.8 * np.cos(3 * theta)) / TURN, cells=int(count))
        errors.append(np.abs(law.cumulative(angles) - truth).max())
    assert -np.polyfit(np.log(counts), np.log(errors), 1)[0] > 3.7


def test_beside_jumps_the_distribution_function_never_falls_and_is_off_by_no_more_than_a_cell() -> None:
    law, angles = CircularLaw(box), np.linspace(0.0, TURN * (1 - 1e-12), 50_001)
    reached = law.cumulative(angles)
    assert np.diff(reached).min() >= -1e-14
    assert reached[[0, -1]] == pytest.approx([0.0, 1.0], abs=1e-12)
    assert np.abs(reached - np.clip(0.5 * (angles - 1.0), 0.0, 1.0)).max() < TURN / law.cells


def test_bins_share_out_the_whole_law() -> None:
    shares = CircularLaw(lambda theta: (1.0 + np.cos(theta)) / TURN).bin_probabilities(4)
    quarter, wave = 0.25, 1.0 / TURN
    assert np.allclose(shares, [quarter + wave, quarter - wave, quarter - wave, quarter + wave], atol=1e-12)


@pytest.mark.parametrize(
    ("density", "match"),
    [
        (lambda theta: np.full_like(theta, 1.0 / 360.0), "integrates to 0.0174533 over the circle, not 1"),
        (lambda theta: uniform(theta) * 1.02, "integrates to 1.02"),
        (lambda theta: (1.0 + 1.5 * np.cos(theta)) / TURN, "must not be negative"),
        (lambda theta: np.where(theta > 3.0, np.nan, 0.1), "must be finite"),
        (lambda theta: np.array(1.0 / TURN), "must be vectorised"),
        (0.3, "vectorised callable"),
    ],
)
def test_what_is_no_density_is_refused(density, match) -> None:
    with pytest.raises(InvalidInput, match=match):
        CircularLaw(density)
    with pytest.raises(InvalidInput, match="cells must be at least 8"):
        CircularLaw(uniform, cells=4)


def cardioid(tilt: float, centre: float = 0.0):
    return lambda theta: (1.0 + tilt * np.cos(theta - centre)) / TURN


def apart(first, second):
    gap = np.mod(np.subtract.outer(first, second), TURN)
    return np.minimum(gap, TURN - gap)


def samples(count: int, seed: int, size: int = 12):
    random = np.random.default_rng(seed)
    return [random.normal(random.uniform(0, TURN), random.uniform(0.1, 3.0), size) for _ in range(count)]


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, np.pi, 4.0, 6.0, -1.0, 20.0])
def test_a_point_is_as_far_from_its_rotation_as_the_angle_the_shorter_way(angle) -> None:
    shorter = min(np.mod(angle, TURN), TURN - np.mod(angle, TURN))
    assert circular_wasserstein([0.7], [0.7 + angle]) == pytest.approx(shorter, abs=1e-14)


def test_between_equal_samples_it_is_the_cheapest_assignment() -> None:
    for first, second in zip(samples(30, 1), samples(30, 2), strict=True):
        cost = apart(first, second)
        rows, columns = linear_sum_assignment(cost)
        assert circular_wasserstein(first, second) == pytest.approx(cost[rows, columns].mean(), abs=1e-13)


def test_equally_spaced_points_are_half_a_step_over_two_from_uniform() -> None:
    for count in (1, 2, 3, 10, 101):
        spaced = 0.3 + TURN * np.arange(count) / count
        assert circular_wasserstein(spaced, uniform) == pytest.approx(np.pi / (2 * count), abs=1e-9)


def test_a_point_is_as_far_from_a_law_as_the_mean_distance_to_it() -> None:
    """All mass moves to the one point: E|θ - θ0| = π/2 - (2/π) tilt cos(θ0 - centre), to the stated h²/8·TV(p)."""
    for centre in (0.0, 1.0, 2.5):
        truth = np.pi / 2 - 2.0 / np.pi * 0.8 * np.cos(0.4 - centre)
        for cells in (64, 2048):
            bound = (TURN / cells) ** 2 / 8 * (4 * 0.8 / TURN)
            found = circular_wasserstein([0.4], CircularLaw(cardioid(0.8, centre), cells))
            assert found == pytest.approx(truth, abs=bound)


def test_against_a_law_it_is_what_a_fine_sample_of_the_law_gives() -> None:
    law, grid = CircularLaw(cardioid(0.9, 2.0)), np.linspace(0.0, TURN * (1 - 1e-12), 200_001)
    fine = np.interp((np.arange(20_000) + 0.5) / 20_000, law.cumulative(grid), grid)
    for sample in samples(5, 3, 40):
        assert circular_wasserstein(sample, law) == pytest.approx(float(circular_wasserstein(sample, fine)), abs=1e-3)


def test_it_is_a_metric_on_discrete_laws() -> None:
    drawn = samples(14, 4)
    table = np.array([[circular_wasserstein(a, b) for b in drawn] for a in drawn])
    assert np.allclose(table, table.T, atol=1e-14)
    assert np.allclose(np.diag(table), 0.0, atol=1e-15)
    assert table[~np.eye(14, dtype=bool)].min() > 0.01
    assert (table[:, None, :] <= table[:, :, None] + table[None, :, :] + 1e-13).all()
    assert table.max() <= np.pi


@pytest.mark.parametrize("turn", [0.1, 1.7, np.pi, 5.0])
def test_rotating_both_changes_nothing(turn) -> None:
    first, second = samples(2, 5, 30)
    turned = circular_wasserstein(first + turn, second + turn)
    assert turned == pytest.approx(float(circular_wasserstein(first, second)), abs=1e-13)
    against = circular_wasserstein(first + turn, cardioid(0.9, 1.0 + turn))
    assert against == pytest.approx(float(circular_wasserstein(first, cardioid(0.9, 1.0))), abs=1e-6)


def test_whole_turns_and_reflection_change_nothing() -> None:
    assert orientations("the sample", [-1e-20]).tolist() == [0.0]
    law = CircularLaw(cardioid(1.0))
    assert np.allclose(law.cumulative([1.0, 1.0 + 3 * TURN, 1.0 - TURN]), law.cumulative(1.0), atol=1e-14)
    first, second = samples(2, 6, 30)
    plain = float(circular_wasserstein(first, second))
    assert circular_wasserstein(first + TURN * np.arange(30), second - 4 * TURN) == pytest.approx(plain, abs=1e-12)
    assert circular_wasserstein(-first, -second) == pytest.approx(plain, abs=1e-13)


def test_rows_are_measured_each_for_itself() -> None:
    rows = np.array(samples(6, 7, 20)).reshape(2, 3, 20)
    together = circular_wasserstein(rows, cardioid(0.5))
    assert together.shape == (2, 3)
    assert together[1, 2] == pytest.approx(float(circular_wasserstein(rows[1, 2], cardioid(0.5))), abs=1e-14)
    assert total_variation(rows, uniform).shape == (2, 3)


def test_total_variation_of_hand_made_samples() -> None:
    assert total_variation([0.1] * 5, uniform, bins=10) == pytest.approx(0.9)
    assert total_variation([0.1, 2.0], [0.2, 4.0], bins=4) == pytest.approx(0.5)
    assert total_variation([0.1, 2.0], [2.1, 0.2], bins=4) == 0.0
    assert total_variation([1.0], [4.0], bins=1) == 0.0


def test_wasserstein_is_at_most_pi_times_total_variation_where_bins_hide_nothing() -> None:
    random = np.random.default_rng(8)
    centres = TURN * (np.arange(12) + 0.5) / 12
    for _ in range(50):
        first, second = random.choice(centres, 9), random.choice(centres, 14)
        bound = np.pi * total_variation(first, second, bins=12)
        assert circular_wasserstein(first, second) <= bound + 1e-12
        assert bound <= 6 * circular_wasserstein(first, second) + 1e-12  # and mass moves a bin, TURN/12, at least


def test_sampling_raises_total_variation_as_stated() -> None:
    drawn = np.random.default_rng(9).uniform(0.0, TURN, (400, 500))
    stated = 36 * np.sqrt((1 / 36) * (35 / 36) / (TURN * 500))
    found = total_variation(drawn, uniform, bins=36)
    assert found.mean() == pytest.approx(stated, abs=4 * found.std() / 20 + 0.02 * stated)


def test_turning_both_by_whole_bins_leaves_total_variation() -> None:
    sample = samples(1, 10, 200)[0]
    plain = float(total_variation(sample, cardioid(0.7, 1.0)))
    turned = total_variation(sample + 5 * TURN / 36, cardioid(0.7, 1.0 + 5 * TURN / 36))
    assert turned == pytest.approx(plain, abs=1e-9)


@pytest.mark.parametrize("measure", [circular_wasserstein, total_variation])
@pytest.mark.parametrize(
    ("sample", "law", "match"),
    [
        ([], uniform, "at least one orientation"),
        ([1.0, np.nan], uniform, "entry 1 is nan"),
        ([1.0], [], "the second sample has shape"),
        ([1.0], [[1.0, 2.0]], "must have 1 axes"),
        ([[1.0], [2.0]], [1.0], "must have 1 axes"),
        ([1.0], [np.inf], "must be finite"),
        ([1.0], lambda theta: uniform(theta) / 2, "integrates to 0.5"),
        (["north"], uniform, "numbers only"),
    ],
)
def test_bad_input_is_refused(measure, sample, law, match) -> None:
    with pytest.raises(InvalidInput, match=match):
        measure(sample, law)


@pytest.mark.parametrize("bins", [0, -1, 2.5, 10**7])
def test_bins_must_be_a_sensible_number(bins) -> None:
    for law in (uniform, [1.0, 2.0]):
        with pytest.raises(InvalidInput, match="bins"):
            total_variation([1.0], law, bins=bins)
