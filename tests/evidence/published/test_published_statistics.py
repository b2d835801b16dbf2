"""What is published adds up, and the distribution of a run is that of its noisy cycles."""

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.evidence.published_statistics import PUBLISHED, published_statistics, run_law
from cyclemap.maps import CircleMap, WrappedNormal, transfer_operator
from cyclemap.mechanics import Pusher, SidePush, Slider

# Table III: percentages beside the RMSE of dtheta, dx, dy.
PERCENT = {
    "plywood": (2.99, 2.46, 3.66),
    "abs": (4.00, 3.88, 4.75),
    "delrin": (1.63, 2.07, 3.08),
    "pu": (1.64, 1.49, 1.86),
}


def rod_in_object(published, signs, exchanged) -> np.ndarray:
    """Where the rod's centre ends in the object's frame (2,), if the mean motion had these signs of dx, dy and turn."""
    turn, dx, dy = (abs(value) * sign for value, sign in zip(published.mean, signs, strict=True))
    moved = (dy, dx) if exchanged else (dx, dy)
    c, s = math.cos(turn), math.sin(turn)
    side = 0.5 * 0.09
    start = np.array([side - SidePush().fraction * 2 * side, side + Pusher().radius])
    end = start - (0.0, SidePush().distance) - np.array(moved)
    return np.array([[c, s], [-s, c]]) @ end


def test_means_follow_from_either_table_within_four_percent():
    assert len(PUBLISHED) == 4
    for name, published in PUBLISHED.items():
        other = 100.0 * np.array(published.rmse) / np.array(PERCENT[name])
        assert other == pytest.approx(np.abs(published.mean), rel=0.04)


@pytest.mark.parametrize("material", ["plywood", "pu"])
def test_only_dx_forward_dy_backward_and_a_positive_turn_leave_the_rod_on_the_pushed_side(material):
    """Both pushes end in contact, so of sixteen readings of the signs and axes one alone can be right."""
    assert Slider.mit("rect1").outline.extent == pytest.approx(0.045 * math.sqrt(2), rel=0.01)
    fitting = []
    for signs in product((1, -1), repeat=3):
        for exchanged in (False, True):
            x, y = rod_in_object(published_statistics(material), (signs[1], signs[2], signs[0]), exchanged)
            if abs(x) <= 0.045 and abs(y - 0.04975) < 0.002:
                fitting.append((signs, exchanged))
    assert len(fitting) == 1
    published = published_statistics(material)
    x, y = rod_in_object(published, np.sign(published.mean), False)
    assert abs(x) <= 0.045 and abs(y - 0.04975) < 0.002


def test_the_run_on_abs_starts_where_its_small_peak_is():
    assert math.degrees(published_statistics("abs").start) == pytest.approx(-150.0)
    assert published_statistics("delrin").start is None


def test_impossible_statistics_and_unknown_materials_are_refused():
    with pytest.raises(InvalidInput, match="steel"):
        published_statistics("steel")
    with pytest.raises(InvalidInput, match="cannot exceed"):
        replace(published_statistics("pu"), rmse=(1.0, 0.0, 0.0))
    with pytest.raises(InvalidInput, match="second"):
        replace(published_statistics("delrin"), first_share=0.1)
    with pytest.raises(InvalidInput, match="name a direction"):
        replace(published_statistics("delrin"), directions=())


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
