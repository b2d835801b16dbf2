"""The monitor raises its alarm early where data lock in, as seldom as promised where they do not,
and starts anew.
"""

import math

import numpy as np
import pytest
from refusals import refused

from cyclemap.evidence import read_theta0_pairs
from cyclemap.maps import CircleMap, WrappedNormal, fixed_points, sample_staircases
from cyclemap.resets.bias_evidence import ArcEvidence, RestEvidence, RestRule, VisitEvidence
from cyclemap.resets.bias_monitor import BiasMonitor, watch

NOISE = math.radians(1.1)


def apart(a, b) -> float:
    return abs((a - b + math.pi) % (2 * math.pi) - math.pi)


def test_on_measured_plywood_the_alarm_comes_within_twenty_pushes_of_the_first_long_rest(
    measured_data,
) -> None:
    """Push 0 is no reset start; the first rest begins at push 2 near 81 degrees and creeps to 100
    in 470 pushes.
    """
    path = read_theta0_pairs(measured_data / "plywood_rect1_theta0_2000.csv").path
    reports = watch(path[:700].tolist())
    alarm = reports[-1].alarm
    assert (alarm.push, alarm.kind, alarm.began) == (16, "rest", 2)
    assert reports[15].alarm is None
    assert apart(alarm.directions[0], math.radians(84.4)) < math.radians(2.0)
    late = reports[400]
    assert late.rest.directions[0] == pytest.approx(path[400], abs=math.radians(1.0))
    assert late.coverage.covered < 0.11 and late.coverage.effective_pushes < 4.0
    assert late.recent_worth < 0.02 and late.useful_pushes == 0
    assert apart(late.advice.direction, math.radians(270.0)) < math.radians(10.0)
    assert max(reports[640].visit_evidence, 0.0) > reports[640].threshold


@pytest.mark.slow
@pytest.mark.parametrize(
    ("turn_deg", "noise_deg"),
    # Wide noise leaves independent uniform orientations.
    [(0.0, 720.0), (8.0, 1.1), (3.0, 1.1), (2.0, 1.1), (120.0, 5.0), (180.0, 5.0), (0.0, 4.5)],
)
def test_unbiased_collections_raise_alarms_no_more_often_than_promised(turn_deg, noise_deg) -> None:
    """12 collections at a rate of one fifth: 2.4 at most on average, and three deviations more."""
    turns = turn_deg + noise_deg * np.random.default_rng(17).standard_normal((12, 400))
    alarms = 0
    for seed, path in enumerate(np.cumsum(np.radians(turns), axis=1).tolist()):
        evidence = RestEvidence(RestRule()), VisitEvidence(seed=seed)
        highest = -math.inf
        for theta in path:
            for test in evidence:
                test.add(theta)
                highest = max(highest, test.log_evidence)
        alarms += highest >= math.log(2.0 / 0.2)
    assert alarms <= 6


def test_the_monitor_joins_both_kinds_of_evidence_and_halves_the_rate_between_them() -> None:
    kinds, monitor = (RestEvidence(RestRule()), VisitEvidence(), ArcEvidence()), BiasMonitor(0.05)
    rest, visits, arcs = kinds
    raised = []
    for push, theta in enumerate(np.random.default_rng(8).vonmises(1.0, 3.0, 150).tolist()):
        report = monitor.update(theta)
        for kind in kinds:
            kind.add(theta)
        gathered = np.logaddexp(visits.log_evidence, arcs.log_evidence) - math.log(2.0)
        assert report.rest_evidence == rest.log_evidence / math.log(10.0)
        assert report.visit_evidence == gathered / math.log(10.0)
        if max(rest.log_evidence, gathered) >= math.log(2.0 / 0.05):
            raised.append(push)
    assert report.threshold == pytest.approx(math.log10(40.0))
    alarm = report.alarm
    assert (alarm.push, alarm.kind, alarm.began) == (raised[0], "visits", None)
    assert apart(report.alarm.directions[0], 1.0) < math.radians(25.0)


@pytest.mark.slow
def test_locked_collections_are_told_within_60_pushes_with_their_direction() -> None:
    """A stable point with multiplier 0.9 and 1.1 degrees of noise."""
    locked = CircleMap.arnold(0.02, 0.25)
    (stable,) = [orbit for orbit in fixed_points(locked) if orbit.stable]
    starts = np.random.default_rng(4).uniform(0, 2 * np.pi, 12)
    delays, errors = [], []
    for path in sample_staircases(locked, WrappedNormal(NOISE), 60, starts, seed=4):
        alarm = watch(path.tolist())[-1].alarm
        assert alarm.kind == "rest"
        delays.append(alarm.push)
        errors.append(apart(alarm.directions[0], stable.points[0]))
    assert len(delays) == 12 and np.median(delays) <= 35
    assert np.median(errors) < math.radians(4.0) and max(errors) < math.radians(15.0)


def test_after_a_change_of_the_reset_the_evidence_starts_anew_and_the_coverage_stays() -> None:
    """A rest is reported once it has lasted twice the window, eight pushes."""
    monitor = BiasMonitor()
    reports = watch([1.0] * 40, monitor)
    first = reports[-1]
    assert [report.rest is not None for report in reports].index(True) == 7
    assert first.alarm.push == 14 and first.advice.change_reset
    monitor.reset_changed()
    fresh = monitor.report
    assert (fresh.alarm, fresh.rest, fresh.push) == (None, None, 39)
    assert fresh.rest_evidence == pytest.approx(0.0, abs=1e-12)
    assert fresh.coverage == first.coverage and not fresh.advice.change_reset
    assert monitor.path == ()
    again = watch([3.0] * 40, monitor)[-1]
    assert (again.alarm.push, again.alarm.began) == (54, 40)
    assert again.coverage.covered == pytest.approx(2 * first.coverage.covered)


def test_a_number_that_is_none_is_refused_and_leaves_the_monitor_as_it_was() -> None:
    monitor = BiasMonitor()
    before = monitor.update(1.0)
    for wrong in (math.nan, math.inf, "1.0", None):
        refused(monitor.update, wrong, told="theta must be a finite number")
    lost = r"theta .*1e[+]\d+ rad is over 1e[+]09: its fraction of a turn is lost"
    for far in (1e300, -1.0001e9):
        refused(monitor.update, far, told=lost)
    assert monitor.report == before and monitor.update(-1e9).push == before.push + 1
    for rate in (0.0, 1.0, -0.1, math.nan):
        refused(BiasMonitor, rate, told="alarm_rate must")
