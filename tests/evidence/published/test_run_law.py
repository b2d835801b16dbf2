"""The law of a run's orientations against the stationary law, against matrix powers, and by what must hold."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.evidence.published_statistics import run_law
from cyclemap.maps import CircleMap, WrappedNormal, transfer_operator

COUNT = 720
THETA = 2 * np.pi * np.arange(COUNT) / COUNT
SIGMA = 0.05


def test_where_the_map_mixes_the_law_of_a_long_run_is_the_stationary_law_of_the_transfer_operator():
    lift = CircleMap.arnold(0.03, 0.4)
    operator = transfer_operator(lift, WrappedNormal(SIGMA))
    found = run_law(lift.turn(THETA), SIGMA, 20_000)
    assert found * COUNT / (2 * np.pi) == pytest.approx(operator.density(THETA), rel=2e-3, abs=1e-3)


def test_the_law_of_a_short_run_is_the_mean_histogram_of_sampled_runs():
    lift, cycles = CircleMap.arnold(0.03, 0.4), 20
    found = run_law(lift.turn(THETA), SIGMA, cycles, start=1.0)
    assert found.sum() == pytest.approx(1.0)
    rng = np.random.default_rng(0)
    theta, moments = 1.0 + np.deg2rad(10.0) * rng.standard_normal(40_000), []
    for _ in range(cycles):
        moments.append(np.exp(1j * theta).mean())
        theta = theta + lift.turn(theta) + SIGMA * rng.standard_normal(theta.size)
    assert found @ np.exp(1j * THETA) == pytest.approx(np.mean(moments), abs=0.01)


def test_between_two_stable_directions_that_noise_hardly_connects_the_start_decides():
    turn = -0.3 * np.sin(2 * THETA)
    near_zero = np.cos(THETA) > 0
    assert run_law(turn, SIGMA, 500, start=0.0)[near_zero].sum() > 0.999
    assert run_law(turn, SIGMA, 500, start=np.pi)[near_zero].sum() < 0.001
    assert run_law(turn, SIGMA, 500)[near_zero].sum() == pytest.approx(0.5, abs=0.01)


def test_turning_the_map_turns_the_law():
    turn, places = 0.1 + 0.2 * np.cos(THETA) + 0.1 * np.sin(2 * THETA), 90
    turned = run_law(np.roll(turn, places), SIGMA, 100)
    assert turned == pytest.approx(np.roll(run_law(turn, SIGMA, 100), places), abs=1e-12)


def test_noise_too_fine_for_the_angles_is_refused():
    with pytest.raises(InvalidInput, match="take more angles"):
        run_law(np.zeros(100), 0.01, 10)
    with pytest.raises(InvalidInput, match="cycles"):
        run_law(np.zeros(100), 0.2, 0)
