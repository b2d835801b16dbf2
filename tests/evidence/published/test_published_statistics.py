"""What is published adds up, and the distribution of a run is that of its noisy cycles."""

import math
from itertools import product

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.evidence.published_statistics import PUBLISHED, published_statistics, run_law
from cyclemap.maps import CircleMap, WrappedNormal, transfer_operator
from cyclemap.mechanics import Pusher, SidePush

THETA = 2 * np.pi * np.arange(720) / 720
SIGMA = 0.05


def test_means_follow_from_either_table_within_four_percent():
    assert len(PUBLISHED) == 4
    for published in PUBLISHED.values():
        other = 100.0 * np.array(published.rmse) / published.rmse_percent
        assert other == pytest.approx(np.abs(published.mean), rel=0.04)
        assert np.all(np.array(published.rmse) <= published.std)


def keeps_the_rod_on_its_side(turn: float, moved: np.ndarray) -> bool:
    """Whether a push after which the object moved and turned so ends with the rod's centre on the pushed side."""
    c, s = math.cos(turn), math.sin(turn)
    end = np.array([0.045 - 0.09 * SidePush().fraction, 0.045 + Pusher().radius - SidePush().distance]) - moved
    x, y = np.array([[c, s], [-s, c]]) @ end
    return abs(x) <= 0.045 and abs(y - 0.04975) < 0.002


@pytest.mark.parametrize("material", ["plywood", "pu"])
def test_only_dx_forward_dy_backward_and_a_positive_turn_leave_the_rod_on_the_pushed_side(material):
    """Both pushes end in contact, so of sixteen readings of the signs and axes one alone can be right: the stored."""
    mean = published_statistics(material).mean
    turn, *sizes = np.abs(mean)
    readings = [
        (sign * turn, np.array(signs) * order)
        for sign, *signs in product((1, -1), repeat=3)
        for order in (sizes, sizes[::-1])
    ]
    fitting = [(turn, *moved) for turn, moved in readings if keeps_the_rod_on_its_side(turn, moved)]
    assert fitting == [pytest.approx(mean)]


def test_where_the_map_mixes_the_law_of_a_long_run_is_the_stationary_law_of_the_transfer_operator():
    lift = CircleMap.arnold(0.03, 0.4)
    operator = transfer_operator(lift, WrappedNormal(SIGMA))
    found = run_law(lift.turn(THETA), SIGMA, 20_000)
    assert found * THETA.size / (2 * np.pi) == pytest.approx(operator.density(THETA), rel=2e-3, abs=1e-3)


def test_between_two_stable_directions_that_noise_hardly_connects_the_start_decides():
    turn, near_zero = -0.3 * np.sin(2 * THETA), np.cos(THETA) > 0
    for start, share in ((0.0, 1.0), (np.pi, 0.0), (None, 0.5)):
        assert run_law(turn, SIGMA, 500, start)[near_zero].sum() == pytest.approx(
            share, abs=0.01 if start is None else 1e-3
        )


def test_turning_the_map_turns_the_law():
    turn, places = 0.1 + 0.2 * np.cos(THETA) + 0.1 * np.sin(2 * THETA), 90
    turned = run_law(np.roll(turn, places), SIGMA, 100)
    assert turned == pytest.approx(np.roll(run_law(turn, SIGMA, 100), places), abs=1e-12)


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (lambda: published_statistics("steel"), "steel"),
        (lambda: run_law(np.zeros(100), 0.01, 10), "take more angles"),
        (lambda: run_law(np.zeros(100), 0.2, 0), "cycles"),
    ],
)
def test_what_cannot_be_is_refused(asked, words):
    with pytest.raises(InvalidInput, match=words):
        asked()
