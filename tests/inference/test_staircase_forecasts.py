"""Forecasts of the measured staircase, and what an ideal forecast would score."""

import math

import numpy as np
import pytest

from tests.inference import staircase_forecasts as study


def test_the_log_joined_with_the_floor_tells_more_than_either_alone(measured_data) -> None:
    """Of where the next 250 pushes are, on average over four places of the plywood staircase."""
    path = study.staircase()
    told = {name: [] for name in ("log and floor", "floor alone", "as in the last")}
    for begin in study.BEGIN:
        for name, scores in study.forecasts(begin, path).items():
            told[name].append(scores.orientation)
    best = np.mean(told.pop("log and floor"))
    assert all(best > np.mean(others) + 0.3 for others in told.values())


def test_a_uniform_forecast_scores_nothing_and_a_sure_one_all_there_is() -> None:
    rng = np.random.default_rng(0)
    truth = np.full(study.AHEAD + 1, 1.0)
    spread = rng.uniform(0.0, 2.0 * np.pi, (study.AHEAD + 1, 4000))
    assert study.scored(spread, truth).orientation == pytest.approx(0.0, abs=0.02)
    sure = study.scored(np.full((study.AHEAD + 1, 50), 1.0), truth).orientation
    assert sure == pytest.approx(math.log(0.99 * study.ARCS + 0.01))
