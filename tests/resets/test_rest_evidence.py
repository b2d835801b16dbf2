"""The bet on a rest is fair at a chance of one half, finds rests of every period, and leaves climbs
alone.
"""

import itertools
import math

import numpy as np
import pytest

from cyclemap.resets.bias_evidence import RestEvidence, RestRule, settling

SINGLE = RestRule(math.radians(12.0), window=6, longest_period=1)
WIDE = RestRule(math.radians(12.0), window=6)
WIDTH = SINGLE.half_width


def rest_evidence_of(path, rule=WIDE) -> np.ndarray:
    """The natural logarithm of the evidence after each orientation."""
    evidence, course = RestEvidence(rule), []
    for angle in np.asarray(path, dtype=float).tolist():
        evidence.add(angle)
        course.append(evidence.log_evidence)
    return np.array(course)


def path_of(hits) -> list[float]:
    """A lingering start, then each push on the mean of the window (hit) or just beyond its half
    width (miss).
    """
    path = [0.02 * math.sin(k) for k in range(SINGLE.window)]
    for number, hit in enumerate(hits):
        mean = float(np.angle(np.exp(1j * np.array(path[-SINGLE.window :])).sum()))
        path.append(mean if hit else mean + (-1) ** number * (WIDTH + 0.01))
    return path


def wealth(hits) -> float:
    return math.exp(rest_evidence_of(path_of(hits), SINGLE)[-1])


def test_the_mean_wealth_is_one_at_a_chance_of_one_half_and_less_at_a_smaller_one() -> None:
    outcomes = list(itertools.product([True, False], repeat=8))
    wealths = [wealth(hits) for hits in outcomes]
    assert len(wealths) == 256 and max(wealths) > 5.0
    assert np.mean(wealths) == pytest.approx(1.0, abs=1e-12)
    chances = [0.3 ** sum(hits) * 0.7 ** (8 - sum(hits)) for hits in outcomes]
    assert np.dot(chances, wealths) < 0.9


@pytest.mark.parametrize("count", [0, 1, 5, 40])
def test_the_wealth_of_a_standstill_is_the_sum_over_starts_and_rates(count) -> None:
    rates = [0.75, 0.9, 0.98]
    started = [
        (2 * rate) ** (count - start + 1) / (start * (start + 1))
        for rate in rates
        for start in range(1, count + 1)
    ]
    expected = sum(started) / len(rates) + 1 / (count + 1)
    found = rest_evidence_of(np.full(SINGLE.window + count, 2.0), SINGLE)[-1]
    assert math.exp(found) == pytest.approx(expected, rel=1e-12)


def test_evidence_knows_neither_the_origin_nor_whole_turns() -> None:
    random = np.random.default_rng(3)
    path = np.cumsum(np.radians(2.0 * random.standard_normal(80)))
    plain = rest_evidence_of(path)
    assert plain[-1] > 3.0
    for same in (path + 1.234, path + 2 * np.pi * random.integers(-3, 4, 80), -path):
        assert rest_evidence_of(same) == pytest.approx(plain, abs=1e-9)


@pytest.mark.parametrize("period", [1, 2, 3, 4, 5])
def test_rests_of_up_to_four_directions_are_found_with_their_directions(period) -> None:
    places = np.radians([20.0, 140.0, 250.0, 310.0, 80.0])[:period]
    random = np.random.default_rng(period)
    evidence = RestEvidence(WIDE)
    for number in range(100):
        evidence.add(float(places[number % period] + np.radians(random.standard_normal())))
    if period == 5:
        assert evidence.rest is None
        assert evidence.log_evidence < 0.1
        return
    assert evidence.log_evidence > 20.0
    rest = evidence.rest
    assert len(rest.directions) == period
    assert rest.began < period
    assert np.sort(rest.directions) == pytest.approx(np.sort(places), abs=np.radians(2.0))
    assert np.sort(rest.towards) == pytest.approx(np.sort(places), abs=np.radians(2.0))


def test_a_steady_climb_is_a_rest_exactly_where_it_is_slower_than_the_rule_says() -> None:
    climb = 2.0 * WIDTH / (WIDE.window + 1) * np.arange(150)
    slow, fast = (rest_evidence_of(share * climb)[-1] for share in (0.98, 1.02))
    assert slow > 50.0
    assert fast <= 1e-12


@pytest.mark.parametrize("turn_deg", [5.0, 8.0, 24.0, 137.5, 77.3])
def test_steady_climbs_with_noise_leave_no_evidence(turn_deg) -> None:
    random = np.random.default_rng(7)
    path = np.cumsum(np.radians(turn_deg + 1.1 * random.standard_normal(400)))
    assert rest_evidence_of(path).max() < 1.0


@pytest.mark.parametrize("pull", [0.15, 0.3, 0.6])
def test_a_path_without_noise_tells_its_limit_whatever_its_pull(pull) -> None:
    """After eight pushes, in whichever turn they are counted."""
    path = [4.0 * math.pi + 2.0 * (1.0 - pull) ** step for step in range(8)]
    assert settling(path, 0.05)[1] == pytest.approx(4.0 * math.pi, abs=0.1)


def test_a_settling_path_tells_its_limit_before_it_is_there() -> None:
    random = np.random.default_rng(2)
    errors, lags = [], []
    for _ in range(200):
        path = [-0.4]
        for _ in range(20):
            path.append(0.9 * path[-1] + math.radians(1.1) * random.standard_normal())
        present, limit = settling(path[1:], WIDTH / 2)
        errors.append(limit)
        lags.append(present)
    assert np.median(np.abs(errors)) < math.radians(4.0)
    assert abs(np.mean(errors)) < 0.5 * abs(np.mean(lags))
