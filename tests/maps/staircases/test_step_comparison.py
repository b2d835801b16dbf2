"""Found steps against predicted ones: estimates with censoring, calibrated p-values, and the
measured plywood run.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from cyclemap.maps import (
    CircleMap,
    StaircaseSummary,
    WrappedNormal,
    compare_steps,
    find_steps,
    predict_staircase,
    sample_staircases,
)
from cyclemap.maps.staircases.step_comparison import kaplan_meier_mean

pytestmark = pytest.mark.slow

TWO_PI = 2 * np.pi
RUNS = 200


def comparisons(circle_map, noise, cycles):
    """200 seeded runs from the stationary law, each compared with the prediction."""
    summary = predict_staircase(circle_map, noise)
    settled = sample_staircases(
        circle_map, noise, 400, np.linspace(0, TWO_PI, RUNS, endpoint=False), seed=8
    )[:, -1]
    paths = sample_staircases(circle_map, noise, cycles, settled, seed=9)
    return summary, [
        compare_steps(find_steps(path, zones=summary.zones), summary) for path in paths
    ]


@pytest.fixture(scope="module")
def ghost():
    return comparisons(CircleMap.arnold(0.15, 0.9), WrappedNormal(0.05), 600)


@pytest.fixture(scope="module")
def well():
    return comparisons(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.45), 3_000)


def assert_uniform(p_values):
    found = np.array(p_values, dtype=float)
    assert found.size == RUNS
    assert np.all((found >= 0.0) & (found <= 1.0))
    assert 0.04 <= np.mean(found < 0.1) <= 0.18
    assert 0.35 <= np.mean(found < 0.5) <= 0.65


def test_p_values_of_visits_and_pace_are_uniform_when_the_prediction_holds(ghost, well):
    for _, found in (ghost, well):
        assert_uniform([one.visits[0].mean_p_value for one in found])
        assert_uniform([one.pace_p_value for one in found])


def test_measured_means_over_many_runs_are_the_predicted_ones(ghost, well):
    for summary, found in (ghost, well):
        zone = summary.zones[0]
        means = np.array([one.visits[0].mean for one in found])
        errors = np.array([one.visits[0].standard_error for one in found])
        exits = np.array([one.visits[0].exits for one in found])
        # Weighted by exits the maximum-likelihood means are unbiased to an exit's worth a run.
        pooled = np.sum(means * exits) / np.sum(exits)
        assert abs(
            pooled / zone.visit_cycles - 1
        ) < 4 * zone.visit_spread / zone.visit_cycles / np.sqrt(exits.sum())
        assert 0.8 < np.median(errors) / np.median(zone.visit_spread / np.sqrt(exits)) < 1.2
        net = np.array([one.net_steps for one in found])
        assert abs(net.mean() - found[0].expected_steps) < 4 * net.std() / np.sqrt(RUNS)
        assert 0.7 < np.median([one.net_error for one in found]) / net.std() < 1.3


def test_the_climb_of_regular_steps_is_as_unsure_as_the_places_of_its_ends_on_them():
    """Five steps of fifty cycles each, as predicted: what scatters is where on a step a run begins
    and ends.
    """
    regular, scatter = TWO_PI * np.floor(np.arange(251) / 50.0), 0.3
    expected = StaircaseSummary(TWO_PI / 50.0, 50.0, TWO_PI, ())
    found = [
        compare_steps(find_steps(regular + scatter * rng.standard_normal(251)), expected)
        for rng in map(np.random.default_rng, range(RUNS))
    ]
    net, error = (
        np.array([getattr(one, name) for one in found]) for name in ("net_steps", "net_error")
    )
    assert abs(net.mean() - 5.0) < 4 * net.std() / np.sqrt(RUNS)
    assert net.std() == pytest.approx(np.sqrt(2.0) * scatter / TWO_PI, rel=0.2)
    assert 0.9 < np.median(error) / net.std() < 1.3


def test_a_ghosts_spread_is_the_predicted_one_and_far_from_exponential(ghost):
    zone = ghost[0].zones[0]
    spreads = np.array([one.visits[0].spread for one in ghost[1]])
    assert abs(spreads.mean() / zone.visit_spread - 1) < 0.05
    assert zone.visit_spread < 0.3 * zone.visit_cycles


def test_a_wrong_prediction_is_told_by_its_p_values():
    noise, right = WrappedNormal(0.05), CircleMap.arnold(0.15, 0.9)
    path = sample_staircases(right, noise, 3_000, [0.0], seed=1)[0]
    summary = predict_staircase(right, noise)
    (zone,) = summary.zones
    wrong = replace(
        summary, mean_turn=1.1 * summary.mean_turn, zones=(replace(zone, visit_cycles=16.0),)
    )
    found = compare_steps(find_steps(path, zones=wrong.zones), wrong)
    assert found.visits[0].mean_p_value < 1e-4
    assert found.pace_p_value < 1e-4


def test_the_kaplan_meier_mean_of_the_textbook_remission_times():
    """6-MP arm of Freireich et al. (1963): S falls to .8571 at 6, .8067 at 7, .4482 at 23 weeks."""
    weeks = np.array([6, 6, 6, 6, 7, 9, 10, 10, 11, 13, 16, 17, 19, 20, 22, 23, 25, 32, 32, 34, 35])
    ended = [1, 1, 1, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0]
    mean, error = kaplan_meier_mean(weeks, np.logical_not(ended))
    drops = [
        (0, 1.0),
        (6, 0.857143),
        (7, 0.806723),
        (10, 0.752941),
        (13, 0.690196),
        (16, 0.627451),
        (22, 0.537815),
    ]
    drops += [(23, 0.448179), (35, 0.0)]
    area = sum(height * (later - week) for (week, height), (later, _) in pairwise(drops))
    assert abs(mean - area) < 1e-4
    assert abs(error - 2.828) < 0.01


def test_what_cannot_be_compared_is_none():
    summary = predict_staircase(CircleMap.arnold(0.1, 0.9), WrappedNormal(0.4))
    still = compare_steps(find_steps(np.full(100, summary.zones[0].centre)), summary)
    assert (still.steps, still.mean_length, still.net_error, still.pace_p_value) == (0, *[None] * 3)
    assert still.visits == ()
    zoned = compare_steps(
        find_steps(np.full(100, summary.zones[0].centre), zones=summary.zones), summary
    )
    assert (zoned.visits[0].exits, zoned.visits[0].mean) == (0, None)
    assert zoned.visits[0].mean_p_value == pytest.approx(
        np.exp(-100 / zoned.visits[0].predicted), rel=0.1
    )
    turning = predict_staircase(CircleMap.rigid(0.1), WrappedNormal(0.1))
    none = compare_steps(find_steps(0.2 * np.pi * np.arange(50)), turning)
    assert (none.predicted_length, none.net_steps, none.expected_steps) == (None,) * 3
    assert kaplan_meier_mean(np.array([3.0]), np.array([True])) == (None, None)
    assert kaplan_meier_mean(np.zeros(0), np.zeros(0, dtype=bool)) == (None, None)
