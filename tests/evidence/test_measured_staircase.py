"""A measured staircase beside the map fitted to it: on made data whose law is known, and on the plywood's."""

from pathlib import Path

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.evidence import Theta0Pairs, measured_staircase, read_theta0_pairs
from cyclemap.maps import CircleMap, WrappedNormal, predict_staircase, sample_staircase

MAP, NOISE = CircleMap.arnold(0.11, 0.6), WrappedNormal(0.03)


def made(cycles: int = 4_000) -> Theta0Pairs:
    path = sample_staircase(MAP, NOISE, cycles, seed=2).theta
    return Theta0Pairs(path[:-1], path[1:], path)


@pytest.mark.slow
def test_the_law_behind_made_data_is_found_again() -> None:
    found, truth = measured_staircase(made()), predict_staircase(MAP, NOISE)
    assert found.fitted.sigma == pytest.approx(NOISE.sigma, rel=0.05)
    assert found.prediction.step == truth.step
    assert found.prediction.mean_residence_cycles == pytest.approx(truth.mean_residence_cycles, rel=0.1)
    assert found.comparison.visits[0].mean_p_value > 0.01
    assert abs(found.comparison.net_steps - found.comparison.expected_steps) < 4 * found.comparison.net_error


def test_the_pace_of_a_turn_is_that_of_the_whole_path() -> None:
    pairs = made()
    climbed = (pairs.path[-1] - pairs.path[0]) / (2 * np.pi)
    assert measured_staircase(pairs).cycles_a_turn == pytest.approx(4_000 / climbed)


@pytest.mark.slow
def test_measured_plywood_climbs_in_whole_turns_as_its_fitted_map_predicts(measured_data: Path) -> None:
    found = measured_staircase(read_theta0_pairs(measured_data / "plywood_rect1_theta0_2000.csv"))
    assert np.rad2deg(found.prediction.step) == pytest.approx(360.0)
    assert np.rad2deg(np.median(found.steps.heights)) == pytest.approx(360.0, abs=1.0)
    assert found.prediction.mean_residence_cycles == pytest.approx(82.0, abs=2.0)
    visit = found.comparison.visits[0]
    assert abs(visit.mean - visit.predicted) < 2 * visit.standard_error


def test_pairs_in_no_order_make_no_staircase() -> None:
    theta = np.linspace(0, 6, 50)
    with pytest.raises(InvalidInput, match="no known order"):
        measured_staircase(Theta0Pairs(theta, theta + 0.1))


def test_turns_without_scatter_are_no_measurement() -> None:
    path = np.arange(50) * 1.0
    with pytest.raises(InvalidInput, match="no measurement"):
        measured_staircase(Theta0Pairs(path[:-1], path[1:], path))
