"""Evidence of rests, of blocks of visits and of arcs: fair games where resets have no bias, telling
ones where data lock in.
"""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from cyclemap.collection import CollectionLoop
from cyclemap.maps import WrappedNormal, sample_staircases
from cyclemap.resets.bias_evidence import (
    CHECKS,
    KERNEL,
    ArcEvidence,
    RestEvidence,
    RestRule,
    VisitEvidence,
    VisitLaw,
    arc_likelihoods,
    settling,
)

RATE = 0.01
SINGLE = RestRule(math.radians(12.0), window=6, longest_period=1)
WIDE = RestRule(math.radians(12.0), window=6)
WIDTH = SINGLE.half_width


def fed(evidence, path):
    """The evidence after a path, and the logarithm that it told after each orientation."""
    course = []
    for theta in np.asarray(path, dtype=float).tolist():
        evidence.add(theta)
        course.append(evidence.log_evidence)
    return evidence, np.array(course)


def rest_course(path, rule=WIDE) -> np.ndarray:
    return fed(RestEvidence(rule), path)[1]


def arc_value(path, seed=0) -> float:
    return math.exp(fed(ArcEvidence(seed), path)[0].log_evidence)


RANDOM = np.random.default_rng(4)


@pytest.mark.parametrize(
    ("made", "path", "within"),
    [
        (ArcEvidence, RANDOM.uniform(0.0, 2.6, 25), 1e-6),
        (VisitEvidence, RANDOM.vonmises(1.0, 0.8, 300), 1e-6),
        (lambda: RestEvidence(WIDE), np.cumsum(0.035 * RANDOM.standard_normal(80)), 1e-9),
    ],
)
def test_evidence_knows_neither_the_origin_nor_whole_turns_and_repeats(made, path, within) -> None:
    plain = fed(made(), path)[1]
    assert plain[-1] > 0.3
    for same in (path, path + 0.7, path + 2 * np.pi * RANDOM.integers(-2, 3, path.size)):
        np.testing.assert_allclose(fed(made(), same)[1], plain, rtol=0, atol=within)


def test_the_mean_wealth_of_a_rest_is_one_at_a_chance_of_one_half_and_less_at_a_smaller_one() -> (
    None
):
    """Each push lies on the mean of the window (hit) or just beyond its half width (miss)."""
    outcomes = list(itertools.product([True, False], repeat=8))
    wealths = []
    for hits in outcomes:
        path = [0.02 * math.sin(k) for k in range(SINGLE.window)]
        for number, hit in enumerate(hits):
            mean = float(np.angle(np.exp(1j * np.array(path[-SINGLE.window :])).sum()))
            path.append(mean if hit else mean + (-1) ** number * (WIDTH + 0.01))
        wealths.append(math.exp(rest_course(path, SINGLE)[-1]))
    assert len(wealths) == 256 and max(wealths) > 5.0
    assert np.mean(wealths) == pytest.approx(1.0, abs=1e-12)
    assert np.dot([0.3 ** sum(hits) * 0.7 ** (8 - sum(hits)) for hits in outcomes], wealths) < 0.9


@pytest.mark.parametrize("count", [0, 1, 40])
def test_the_wealth_of_a_standstill_is_the_sum_over_starts_and_rates(count) -> None:
    rates = [0.75, 0.9, 0.98]
    started = [
        (2 * rate) ** (count - start + 1) / (start * (start + 1))
        for rate in rates
        for start in range(1, count + 1)
    ]
    found = rest_course(np.full(SINGLE.window + count, 2.0), SINGLE)[-1]
    assert math.exp(found) == pytest.approx(sum(started) / 3 + 1 / (count + 1), rel=1e-12)


@pytest.mark.parametrize("period", [1, 2, 3, 4, 5])
def test_rests_of_up_to_four_directions_are_found_with_their_directions(period) -> None:
    places = np.radians([20.0, 140.0, 250.0, 310.0, 80.0])[:period]
    scatter = np.radians(np.random.default_rng(period).standard_normal(100))
    evidence, _ = fed(RestEvidence(WIDE), np.resize(places, 100) + scatter)
    rest = evidence.rest
    if period == 5:
        assert rest is None and evidence.log_evidence < 0.1
        return
    assert evidence.log_evidence > 20.0
    assert len(rest.directions) == period and rest.began < period
    for directions in (rest.directions, rest.towards):
        assert np.sort(directions) == pytest.approx(np.sort(places), abs=np.radians(2.0))


def test_a_steady_climb_is_a_rest_exactly_where_it_is_slower_than_the_rule_says() -> None:
    climb = 2.0 * WIDTH / (WIDE.window + 1) * np.arange(150)
    slow, fast = (rest_course(share * climb)[-1] for share in (0.98, 1.02))
    assert slow > 50.0 and fast <= 1e-12


@pytest.mark.parametrize("pull", [0.15, 0.3, 0.6])
def test_a_path_without_noise_tells_its_limit_whatever_its_pull(pull) -> None:
    path = [4.0 * math.pi + 2.0 * (1.0 - pull) ** step for step in range(8)]
    assert settling(path, 0.05)[1] == pytest.approx(4.0 * math.pi, abs=0.1)


def test_a_settling_path_tells_its_limit_before_it_is_there() -> None:
    random, told = np.random.default_rng(2), []
    for _ in range(200):
        path = [-0.4]
        for _ in range(20):
            path.append(0.9 * path[-1] + math.radians(1.1) * random.standard_normal())
        told.append(settling(path[1:], WIDTH / 2))
    present, limit = np.transpose(told)
    assert np.median(np.abs(limit)) < math.radians(4.0)
    assert abs(np.mean(limit)) < 0.5 * abs(np.mean(present))


@pytest.mark.parametrize(("turn_deg", "noise_deg"), [(0.0, 20.0), (8.0, 8.0), (0.0, 200.0)])
def test_the_mean_wealth_of_blocks_is_one_for_turns_of_any_law(turn_deg, noise_deg) -> None:
    """250 collections of six short blocks; within four standard errors."""
    turns = turn_deg + noise_deg * np.random.default_rng(5).standard_normal((250, 37))
    wealth = []
    for seed, path in enumerate(np.cumsum(np.radians(turns), axis=1)):
        evidence = VisitEvidence(block=6, orders=9, seed=seed)
        wealth.append(math.exp(fed(evidence, path)[0].log_evidence))
    assert np.std(wealth) > 0.05
    assert np.mean(wealth) == pytest.approx(1.0, abs=4 * np.std(wealth) / math.sqrt(250))


@pytest.mark.parametrize("turn_deg", [0.0, 8.0, 120.0])
def test_equal_turns_tell_nothing_for_all_their_orders_are_one(turn_deg) -> None:
    path = np.radians(turn_deg) * np.arange(200)
    assert fed(VisitEvidence(), path)[0].log_evidence == pytest.approx(0.0, abs=1e-9)
    assert arc_value(path) == 0.0


def test_biased_directions_and_a_slow_zone_give_evidence_and_their_direction() -> None:
    random, slow = np.random.default_rng(2), [0.0]
    for _ in range(900):
        turn = 9.0 - 4.0 * np.cos(slow[-1]) + 1.1 * random.standard_normal()
        slow.append(slow[-1] + np.radians(turn))
    for centre, path in ((0.0, slow[1:]), (3.0, random.vonmises(3.0, 0.8, 800))):
        found, _ = fed(VisitEvidence(), path)
        assert found.log_evidence > 10.0
        assert abs((found.peak() - centre + np.pi) % (2 * np.pi) - np.pi) < np.radians(25.0)
        assert fed(VisitEvidence(seed=1), path)[0].log_evidence != found.log_evidence


def test_evidence_of_visits_changes_where_a_block_is_full_and_not_before() -> None:
    """The first block teaches the law; the others are betted on when their last push has come."""
    path = np.random.default_rng(6).vonmises(1.0, 2.0, 101)
    _, course = fed(VisitEvidence(block=20), path)
    assert (np.flatnonzero(np.diff(course)) + 1).tolist() == [40, 60, 80, 100]


def test_the_law_of_visits_is_the_kernel_estimate_mixed_with_the_uniform_law() -> None:
    visits = np.array([0.3, 0.4, 2.0, 6.2])
    law = VisitLaw()
    law.add(visits)
    theta = np.arange(3600) * (2 * np.pi / 3600)
    learned = 2 * np.pi * WrappedNormal(KERNEL).density(np.subtract.outer(theta, visits)).sum(1)
    assert law.ratio(theta) == pytest.approx(0.1 + 0.9 * (24 + learned) / (24 + 4), abs=1e-5)
    law.add(visits[:1], kept=0.5)
    assert law.visits == 3.0


def alarmed_at(path, seed=0) -> float:
    """The push at which these kinds of evidence raise an alarm; inf where they do not."""
    kinds = RestEvidence(RestRule()), VisitEvidence(seed=seed), ArcEvidence(seed)
    for push, theta in enumerate(path.tolist()):
        for kind in kinds:
            kind.add(theta)
        rest, blocks, arcs = (kind.log_evidence for kind in kinds)
        if max(rest, np.logaddexp(blocks, arcs) - math.log(2.0)) >= math.log(2.0 / RATE):
            return push
    return math.inf


@pytest.mark.slow
def test_half_a_circle_is_told_within_thirty_pushes_in_the_median() -> None:
    random = np.random.default_rng(12)
    paths = random.uniform(0.0, 2.0 * np.pi, (9, 1)) + random.uniform(0.0, np.pi, (9, 45))
    pushes = [alarmed_at(path, number) for number, path in enumerate(paths)]
    assert np.median(pushes) <= 30 and np.quantile(pushes, 0.9) <= 40


@pytest.mark.slow
def test_two_hundred_unbiased_climbs_raise_two_alarms_at_most() -> None:
    """Steady turns of 1.5 to 40 degrees with 1.1 to 8 degrees of noise, either way round."""
    random, alarms = np.random.default_rng(7), 0
    for number in range(200):
        turn, noise = np.exp(random.uniform(np.log([1.5, 1.1]), np.log([40.0, 8.0])))
        turns = random.choice([-1.0, 1.0]) * turn + noise * random.standard_normal(60)
        path = random.uniform(0.0, 2.0 * np.pi) + np.cumsum(np.radians(turns))
        alarms += math.isfinite(alarmed_at(path, number))
    assert alarms <= 2


@pytest.mark.slow
def test_slow_climbs_with_the_mechanics_turns_are_no_arcs() -> None:
    """Pu turns the square by 4 to 16 degrees a cycle: in 48 pushes it goes round."""
    loop, noise = CollectionLoop.mit("pu"), WrappedNormal(math.radians(1.1))
    starts = np.random.default_rng(9).uniform(0.0, 2.0 * np.pi, 40)
    paths = sample_staircases(loop.circle_map(tolerance=1e-3), noise, CHECKS[-1], starts, seed=9)
    assert max(arc_value(path, number) for number, path in enumerate(paths)) < 2.0 / RATE


@pytest.mark.slow
def test_the_mean_evidence_of_an_arc_is_one_at_most_for_turns_of_any_law() -> None:
    """Where turns are wide the first look promises something once in some dozens."""
    turns = np.radians(25.0 * np.random.default_rng(5).standard_normal((144, 49)))
    found = [arc_value(np.cumsum(path), number) for number, path in enumerate(turns)]
    assert np.std(found) > 0.1 and np.mean(found) < 1.0 + 4.0 * np.std(found) / 12.0
    assert np.mean(np.array(found) > 20.0) <= 0.05 + 3.0 * math.sqrt(0.05 / 144)


def test_no_path_tells_more_than_one_order_among_twenty_thousand_can() -> None:
    """At every look the recorded order counts for N + 1 at most, and the looks share one weight."""
    path = np.random.default_rng(6).uniform(0.0, 2.0, CHECKS[-1] + 1)
    assert 5_000.0 < arc_value(path) <= 20_000.0


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 1000), st.floats(0.5, 30.0), st.floats(0.0, 3.0))
def test_a_climb_that_never_turns_back_tells_nothing_whatever_its_turns_depend_on(
    seed, mean_deg, pull
) -> None:
    """Where no turn leaps over the 120 degrees that the widest arc leaves out."""
    random, path = np.random.default_rng(seed), [0.0]
    for _ in range(49):
        swing = np.exp(pull * np.cos(path[-1]) + random.standard_normal())
        path.append(path[-1] + min(np.radians(mean_deg) * swing, np.radians(119.0)))
    assert arc_value(path) == 0.0


@pytest.mark.parametrize("shift", [0.0, 3e-4, 1e-3])
def test_the_likelihood_over_all_second_pushes_has_the_mean_of_chance(shift) -> None:
    places = np.arange(36) * (2 * np.pi / 36) + shift
    assert arc_likelihoods(places[:, None]).mean() == pytest.approx(1.0)


def test_more_visits_on_an_arc_are_more_likely() -> None:
    even = np.linspace(0.0, 1.0, 24, endpoint=False)
    spans = np.radians([60.0, 120.0, 180.0, 240.0, 360.0])
    likely = arc_likelihoods(np.outer(spans, even))
    assert np.all(np.diff(likely) < 0.0) and likely[-1] < 1.0
