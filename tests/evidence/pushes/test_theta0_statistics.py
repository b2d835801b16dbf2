"""Summaries of measured pairs, checked on pairs whose answers are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from refusals import refused

from cyclemap.evidence import Theta0Pairs, angle_histogram, measured_overlay, turn_bins

TURN = 2 * np.pi


def turn(theta):
    return 0.1 + 0.05 * np.sin(2 * theta) - 0.02 * np.cos(theta)


def noisy_pairs(sigma: float, count: int = 20_000) -> Theta0Pairs:
    random = np.random.default_rng(7)
    theta = random.uniform(-TURN, 3 * TURN, count)
    return Theta0Pairs(theta, theta + turn(theta) + sigma * random.standard_normal(count))


def test_bin_medians_follow_the_map_and_shrug_off_outliers() -> None:
    pairs = noisy_pairs(1e-4)
    spoiled = pairs.theta_next.copy()
    spoiled[::10] += 3.0
    bins = turn_bins(Theta0Pairs(pairs.theta, spoiled))
    assert bins.centre.size == 72
    # A tenth of outliers shifts a median within the spread of the turn over its bin: slope 0.12, 5 degrees.
    assert np.abs(bins.median - turn(bins.centre)).max() < 0.12 * np.deg2rad(2.5)


def test_bins_with_few_pairs_are_left_out() -> None:
    theta = np.deg2rad([1.0, 2.0, 3.0, 100.0, 101.0])
    bins = turn_bins(Theta0Pairs(theta, theta + 0.1), bins=36)
    assert np.rad2deg(bins.centre).round(9).tolist() == [5.0]
    assert bins.count.tolist() == [3]


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=50), st.integers(1, 100))
def test_histogram_is_a_density_for_any_angles(theta, bins) -> None:
    histogram = angle_histogram(np.array(theta), bins)
    assert (histogram.density >= 0).all()
    assert np.sum(histogram.density * np.diff(histogram.edges)) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(("angle", "bin_index"), [(0.0, 0), (-1e-20, 7), (TURN - 1e-12, 7), (np.pi, 4), (-0.1, 7)])
def test_histogram_counts_an_angle_in_its_own_bin(angle, bin_index) -> None:
    assert np.flatnonzero(angle_histogram(np.array([angle]), 8).density).tolist() == [bin_index]


def test_empty_histogram_and_no_bins_are_refused() -> None:
    refused(angle_histogram, np.array([]), told="at least one")
    refused(angle_histogram, np.array([1.0]), 0, told="bins must be at least 1")


def test_an_overlay_measures_a_constant_offset_exactly() -> None:
    pairs = noisy_pairs(0.0)
    overlay = measured_overlay(pairs, lambda theta: turn(theta) - 0.03)
    assert (overlay.agreement.pairs, overlay.agreement.bins) == (20_000, 72)
    assert overlay.agreement.rms == pytest.approx(0.03, abs=1e-12)
    assert overlay.agreement.bin_rms == pytest.approx(0.03, abs=1e-3)
    assert np.array_equal(overlay.bins.median, turn_bins(pairs).median)
    assert np.array_equal(overlay.histogram.density, angle_histogram(pairs.theta).density)
