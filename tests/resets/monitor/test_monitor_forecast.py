"""The forecast of a watched collection against what its true map goes on to do."""

import math
from copy import deepcopy

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap, WrappedNormal, sample_staircase, sample_staircases
from cyclemap.resets.monitor.bias_monitor import BiasMonitor, watch
from cyclemap.resets.monitor.coverage import CoverageRule
from cyclemap.resets.monitor.forecast import forecast
from cyclemap.resets.monitor.watched_collection import WatchedCollection

SIGMA = math.radians(1.5)
# A ghost: the climb slows down to 0.6 degrees a push at a quarter turn.
GHOST = CircleMap.arnold(0.03, 0.178)


@pytest.fixture(scope="module")
def ghost():
    """A monitor after 700 pushes of the ghost, under way in a rest, with narrow pushes to be covered."""
    monitor = BiasMonitor(coverage_rule=CoverageRule(reach=math.radians(0.6)))
    path = sample_staircase(GHOST, WrappedNormal(SIGMA), 900, start=0.5, seed=2).theta.tolist()
    reports = watch(path[:700], monitor)
    while reports[-1].rest is None:
        reports = watch([path[len(monitor.path)]], monitor)
    return monitor, forecast(monitor, ahead=300)


def test_the_fitted_map_and_its_noise_are_the_true_ones(ghost) -> None:
    _, found = ghost
    theta = np.linspace(0.0, 2 * np.pi, 90)
    assert found.fitted.sigma == pytest.approx(SIGMA, rel=0.1)
    assert np.abs(found.fitted.map(theta) - GHOST(theta)).max() < math.radians(1.5)


def test_worth_and_the_end_of_the_rest_are_those_of_the_true_map(ghost) -> None:
    monitor, found = ghost
    runs = sample_staircases(GHOST, WrappedNormal(SIGMA), 300, np.full(100, monitor.path[-1]), seed=9)[:, 1:]
    worth = np.mean([monitor.coverage.worth_of(run) for run in runs]) / 300
    assert found.worth == pytest.approx(worth, rel=0.15)
    assert 0.0 < found.worth < 0.9
    centre = monitor.report.rest.directions[0]
    away = np.abs((runs - centre + np.pi) % (2 * np.pi) - np.pi) > math.radians(12.0)
    left = np.median(away.argmax(axis=1) + 1)
    assert found.pushes_to_leave == pytest.approx(left, rel=0.35, abs=2)


def test_the_next_tenth_of_the_circle_is_covered_when_it_says(ghost) -> None:
    monitor, found = ghost
    covered = monitor.report.coverage.covered
    assert found.cover_target == pytest.approx(min(covered + 0.1, 1.0))
    took = []
    for seed in range(5):
        coverage = deepcopy(monitor.coverage)
        runs = sample_staircase(GHOST, WrappedNormal(SIGMA), 900, start=monitor.path[-1], seed=seed).theta[1:]
        count = 0
        while coverage.state().covered < found.cover_target:
            coverage.add(runs[count])
            count += 1
        took.append(count)
    assert found.pushes_to_cover == pytest.approx(np.median(took), rel=0.5, abs=5)


def test_there_is_no_forecast_from_few_pushes_across_a_wide_gap_or_where_no_map_shows() -> None:
    random = np.random.default_rng(0)
    few, gappy, enough, scattered = BiasMonitor(), BiasMonitor(), BiasMonitor(), BiasMonitor()
    even = np.mod(np.cumsum(np.radians(8.0 + 3.0 * random.standard_normal(150))), 2 * np.pi)
    watch(even[:100].tolist(), few)
    watch(random.uniform(0, 2 * np.pi, 150).tolist(), scattered)
    watch((even * 320 / 360).tolist(), gappy)
    watch(even.tolist(), enough)
    assert forecast(few) is None
    assert forecast(gappy) is None
    assert forecast(scattered) is None
    found = forecast(enough, ahead=90)
    assert found is not None
    assert found.pushes_to_leave is None
    assert found.worth == pytest.approx(1.0, abs=0.15)
    with pytest.raises(InvalidInput, match="ahead must be at least 1"):
        forecast(enough, ahead=0)


def test_the_course_holds_what_was_reported() -> None:
    watched = WatchedCollection(0.05)
    with pytest.raises(InvalidInput, match="no push was fed"):
        watched.course()
    reports = [watched.add(theta) for theta in (7.0, 7.1, 7.0, -0.5)]
    course = watched.course()
    assert course.pushes == watched.pushes == 4
    assert course.theta == pytest.approx(np.mod([7.0, 7.1, 7.0, -0.5], 2 * np.pi))
    assert course.rest_evidence.tolist() == [report.rest_evidence for report in reports]
    assert course.effective_pushes.tolist() == [report.coverage.effective_pushes for report in reports]
    assert course.report == reports[-1]
    assert np.sum(course.histogram.density * np.diff(course.histogram.edges)) == pytest.approx(1.0)
