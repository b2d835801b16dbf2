"""Mean, spread and percentage of pushes, against the published table's own arithmetic and made values."""

import numpy as np
import pytest
from made_sets import made_set, noisy_set

from cyclemap.errors import InvalidInput
from cyclemap.evidence.tables.push_sets import motion_statistics, push_statistics

# Ma & Rodriguez (2018), Table II, plywood: σ of Δθ (°), Δx, Δy (mm) and their percentages, with the means they imply.
PUBLISHED = [(69.1, 4.74, 6.86), (36.6, 2.84, 7.75), (94.3, 8.57, 9.09)]


@pytest.mark.parametrize(("mean", "sigma", "percent"), PUBLISHED)
def test_values_of_published_mean_and_spread_give_the_published_percentage(mean, sigma, percent) -> None:
    value = np.random.default_rng(0).standard_normal(2000)
    value = mean + sigma * (value - value.mean()) / value.std(ddof=1)
    row = motion_statistics(value)
    assert (row.mean, row.std) == (pytest.approx(mean), pytest.approx(sigma))
    assert row.percent == pytest.approx(percent, abs=0.015)


def test_a_constant_moves_the_mean_alone_and_a_factor_moves_both() -> None:
    value = np.random.default_rng(1).standard_normal(50)
    one, moved, larger = motion_statistics(value), motion_statistics(value + 3.0), motion_statistics(-2.0 * value)
    assert (moved.mean, moved.std) == (pytest.approx(one.mean + 3.0), pytest.approx(one.std))
    assert (larger.mean, larger.std) == (pytest.approx(-2.0 * one.mean), pytest.approx(2.0 * one.std))
    assert larger.percent == pytest.approx(one.percent)


def test_unknown_values_are_passed_over_and_counted_out() -> None:
    row = motion_statistics([1.0, np.nan, 3.0])
    assert (row.count, row.mean) == (2, 2.0)
    with pytest.raises(InvalidInput, match="1 known values have no spread"):
        motion_statistics([np.nan, 1.0])


def test_the_standard_error_covers_the_true_mean_as_often_as_it_should() -> None:
    found = [push_statistics(noisy_set(seed, 100)).dx for seed in range(200)]
    inside = [abs(row.mean - 0.04) < 1.96 * row.mean_error for row in found if row is not None]
    assert len(inside) == 200
    assert 0.9 <= np.mean(inside) <= 0.99


def test_a_set_with_too_few_pushes_says_so_in_its_row() -> None:
    row = push_statistics(made_set([0.0, 1.0, 2.0], [1.0, np.nan, np.nan]))
    assert (row.dtheta, row.dx, row.dy) == (None, None, None)
    assert row.problem == "too few pushes with a known end for a spread: 1 of 5"
    assert push_statistics(noisy_set(0, 20)).problem is None
