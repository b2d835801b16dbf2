"""The predicted staircase of a loop: steps, residences beyond every float, and one run of it."""

import math

import numpy as np
import pytest

from cyclemap.collection import staircase_forecast
from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap


def test_residences_that_a_float_can_hold_are_told_alike_by_their_logarithm(loop_of) -> None:
    found = staircase_forecast(loop_of(CircleMap.arnold(0.1, 0.9)), sigma=0.4, cycles=500)
    (zone,) = found.prediction.zones
    assert zone.kind == "stable"
    assert found.log10_residences[0] == pytest.approx(math.log10(zone.residence_cycles), abs=1e-12)


@pytest.mark.slow
def test_long_residences_grow_as_one_over_the_noise_squared(loop_of) -> None:
    """Freidlin and Wentzell: σ² ln T tends to a constant of the map, however long T."""
    stuck = loop_of(CircleMap.arnold(0.1, 0.9))
    wide, narrow = (staircase_forecast(stuck, sigma=sigma, cycles=10) for sigma in (0.056, 0.028))
    assert narrow.prediction.mean_residence_cycles == math.inf
    assert narrow.log10_residences[0] > 300.0
    assert narrow.log10_residences[0] / wide.log10_residences[0] == pytest.approx(4.0, rel=0.03)


@pytest.mark.slow
def test_zones_that_make_whole_turns_have_the_residence_of_those_that_make_none(loop_of) -> None:
    """A whole turn more a cycle moves no direction: residences depend on the map of the circle alone."""
    still, turning = (
        staircase_forecast(loop_of(CircleMap.arnold(omega, 0.9)), sigma=0.028, cycles=10) for omega in (0.1, 1.1)
    )
    assert turning.prediction.zones[0].winding == 1
    assert turning.log10_residences[0] == pytest.approx(float(still.log10_residences[0]), rel=1e-9)


def test_the_steps_of_a_run_past_a_ghost_are_whole_turns_of_the_predicted_length(loop_of) -> None:
    found = staircase_forecast(loop_of(CircleMap.arnold(0.0955, 0.6)), sigma=0.03, cycles=20_000, seed=3)
    assert found.prediction.step == pytest.approx(2 * np.pi)
    assert found.steps.count > 50
    assert np.median(found.steps.heights) == pytest.approx(2 * np.pi, abs=0.05)
    assert abs(found.comparison.net_steps - found.comparison.expected_steps) < 4 * found.comparison.net_error


@pytest.mark.slow
def test_plywood_of_the_paper_climbs_in_whole_turns_but_hardly_ever(real_loop) -> None:
    found = staircase_forecast(real_loop, cycles=200)
    assert math.degrees(found.prediction.step) == pytest.approx(360.0)
    assert found.log10_residences[0] == pytest.approx(683.81, abs=0.1)
    assert found.log10_residences[0].error_bound < 1e-6
    assert found.steps.count == 0


def test_a_run_without_noise_is_refused(loop_of) -> None:
    with pytest.raises(InvalidInput, match="sigma"):
        staircase_forecast(loop_of(CircleMap.arnold(0.1, 0.9)), sigma=0.0)
