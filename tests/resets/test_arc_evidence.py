"""Arcs of the circle that a collection keeps to: told within thirty pushes, and never of a climb,
however slow.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from cyclemap.collection import CollectionLoop
from cyclemap.maps import WrappedNormal, sample_staircases
from cyclemap.resets import BiasMonitor, watch
from cyclemap.resets.bias_evidence import (
    CHECKS,
    ArcEvidence,
    RestEvidence,
    RestRule,
    VisitEvidence,
    arc_likelihoods,
)

RATE = 0.01


def evidence_of(path, seed=0) -> float:
    evidence = ArcEvidence(seed)
    for theta in np.asarray(path).tolist():
        evidence.add(theta)
    return math.exp(evidence.log_evidence)


def first_alarm(path, seed=0) -> float:
    """At which push the monitor's kinds of evidence raise an alarm, coverage left out; inf where
    they do not.
    """
    rest, blocks, arcs = RestEvidence(RestRule()), VisitEvidence(seed=seed), ArcEvidence(seed)
    for push, theta in enumerate(np.asarray(path).tolist()):
        for one in (rest, blocks, arcs):
            one.add(theta)
        visits = np.logaddexp(blocks.log_evidence, arcs.log_evidence) - math.log(2.0)
        if max(rest.log_evidence, visits) >= math.log(2.0 / RATE):
            return push
    return math.inf


@pytest.mark.slow
def test_half_a_circle_is_told_within_thirty_pushes_in_the_median() -> None:
    random, pushes = np.random.default_rng(12), []
    for number in range(40):
        start = random.uniform(0.0, 2.0 * np.pi)
        pushes.append(first_alarm(start + random.uniform(0.0, np.pi, 60), number))
    assert len(pushes) == 40 and np.median(pushes) <= 30 and np.quantile(pushes, 0.9) <= 40


def test_the_monitor_tells_half_a_circle_and_where_it_lies() -> None:
    path = 1.0 + np.random.default_rng(3).uniform(0.0, np.pi, 60)
    alarm = watch(path.tolist(), BiasMonitor(RATE))[-1].alarm
    assert alarm is not None and alarm.push <= 34 and alarm.kind == "visits"
    assert 1.0 < alarm.directions[0] < 1.0 + np.pi


def unbiased_climb(random, pushes):
    """Steady turns of 1.5 to 40 degrees with 1.1 to 8 degrees of noise, from anywhere, either way
    round.
    """
    turn, noise = np.radians(np.exp(random.uniform(np.log([1.5, 1.1]), np.log([40.0, 8.0]))))
    way = random.choice([-1.0, 1.0])
    return random.uniform(0.0, 2.0 * np.pi) + np.cumsum(
        way * turn + noise * random.standard_normal(pushes)
    )


@pytest.mark.slow
def test_five_hundred_unbiased_climbs_raise_five_alarms_at_most() -> None:
    random, alarms = np.random.default_rng(7), 0
    for number in range(500):
        alarms += math.isfinite(first_alarm(unbiased_climb(random, 100), number))
    assert alarms <= 5


@pytest.mark.slow
@pytest.mark.parametrize("material", ["isotropic", "pu"])
def test_slow_climbs_with_the_mechanics_turns_are_no_arcs(material) -> None:
    """Pu turns the square by 4 to 16 degrees a cycle: in 48 pushes it goes round, more slowly here
    than there.
    """
    loop, noise = CollectionLoop.mit(material), WrappedNormal(math.radians(1.1))
    starts = np.random.default_rng(9).uniform(0.0, 2.0 * np.pi, 100)
    paths = sample_staircases(loop.circle_map(tolerance=1e-3), noise, CHECKS[-1], starts, seed=9)
    evidence = [evidence_of(path, number) for number, path in enumerate(paths)]
    assert len(evidence) == 100 and max(evidence) < 2.0 / RATE


@pytest.mark.slow
def test_the_mean_evidence_is_one_at_most_for_turns_of_any_law() -> None:
    """Where turns are wide the first look promises something once in some dozens; within four
    standard errors.
    """
    random = np.random.default_rng(5)
    found = []
    for number in range(400):
        found.append(evidence_of(np.cumsum(np.radians(25.0 * random.standard_normal(49))), number))
    assert np.std(found) > 0.1 and np.mean(found) < 1.0 + 4.0 * np.std(found) / 20.0
    assert np.mean(np.array(found) > 20.0) <= 0.05 + 3.0 * math.sqrt(0.05 / 400)


@pytest.mark.slow
def test_evidence_knows_neither_the_origin_nor_whole_turns_nor_the_way_of_looking() -> None:
    random = np.random.default_rng(4)
    path = random.uniform(0.0, 2.6, 25)
    plain = evidence_of(path)
    assert plain > 1.0 and evidence_of(path) == plain
    assert evidence_of(path + 0.7) == pytest.approx(plain, rel=1e-6)
    assert evidence_of(path + 2 * np.pi * random.integers(-2, 3, 25)) == pytest.approx(
        plain, rel=1e-6
    )


def test_no_path_tells_more_than_one_order_among_twenty_thousand_can() -> None:
    """At every look the recorded order counts for N + 1 at most, and the looks share one weight."""
    path = np.random.default_rng(6).uniform(0.0, 2.0, CHECKS[-1] + 1)
    assert 5_000.0 < evidence_of(path) <= 20_000.0


@pytest.mark.parametrize("turn_deg", [0.0, 3.0, 8.0, 120.0])
def test_equal_turns_tell_nothing_for_all_their_orders_are_one(turn_deg) -> None:
    assert evidence_of(np.radians(turn_deg) * np.arange(60)) == 0.0


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 1000), st.floats(0.5, 30.0), st.floats(0.0, 3.0))
def test_a_climb_that_never_turns_back_tells_nothing_whatever_its_turns_depend_on(
    seed, mean_deg, pull
) -> None:
    """Turns that swing with θ0 and in any order: all orders lie between the same ends, where no
    turn leaps over the 120 degrees that the widest arc leaves out.
    """
    random, path = np.random.default_rng(seed), [0.0]
    for _ in range(49):
        swing = np.exp(pull * np.cos(path[-1]) + random.standard_normal())
        path.append(path[-1] + min(np.radians(mean_deg) * swing, np.radians(119.0)))
    assert evidence_of(path) == 0.0


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 1000))
def test_the_likelihood_over_all_second_pushes_has_the_mean_of_chance(seed) -> None:
    """A density over the uniform one: its mean over even places of the second visit is that of the
    first alone, 1.
    """
    places = np.arange(36) * (2 * np.pi / 36) + 1e-3 * seed / 1000
    assert arc_likelihoods(places[:, None]).mean() == pytest.approx(1.0)


def test_more_visits_on_an_arc_are_more_likely() -> None:
    even = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    spans = [np.radians(size) for size in (60.0, 120.0, 180.0, 240.0, 360.0)]
    likely = [float(arc_likelihoods((even * span / (2 * np.pi))[None, :])[0]) for span in spans]
    assert np.all(np.diff(likely) < 0.0) and likely[-1] < 1.0
