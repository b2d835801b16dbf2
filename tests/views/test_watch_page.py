"""The page and the sentences of a watched collection show the alarm, the threshold and the least
covered direction.
"""

import numpy as np
import pytest
from drawn_words import assert_words_apart

from cyclemap.resets import BiasMonitor, watch
from cyclemap.views import watch_page as sentences
from cyclemap.views.watch_page import watch_page


def course_of(theta):
    monitor = BiasMonitor(0.02)
    return monitor, watch(np.asarray(theta).tolist(), monitor)


@pytest.fixture(scope="module")
def locked():
    """Forty pushes at 60 degrees."""
    return course_of(np.radians(60.0 + np.random.default_rng(0).standard_normal(40)))


@pytest.fixture(scope="module")
def even():
    """Two hundred pushes of a noisy rotation."""
    turns = 8.0 + 2.0 * np.random.default_rng(1).standard_normal(200)
    return course_of(np.cumsum(np.radians(turns)))


@pytest.mark.parametrize("kind", ["locked", "even"])
def test_the_page_says_whether_it_locks_in_and_its_words_lie_apart(kind, request) -> None:
    monitor, reports = request.getfixturevalue(kind)
    page = watch_page(monitor, reports, "x.csv")
    locks = "locks in" if kind == "locked" else "no sign of locking in"
    assert page.texts[0].get_text() == f"x.csv: {locks}" and len(page.axes) == 4
    assert_words_apart(page)


def test_the_sentences_tell_alarm_coverage_and_advice(locked, even) -> None:
    told = " ".join(sentences.watch_sentences(locked[1][-1]))
    alarm = locked[1][-1].alarm
    assert f"ALARM at push {alarm.push}, counted from 0: θ0 rests near " in told
    assert f"{np.degrees(alarm.directions[0]):.1f}° since push 0." in told
    assert told.count("counted from 0") == 1
    assert "no push more there would tell much" in told
    assert "Change the reset: bring θ0 to" in told
    told = " ".join(sentences.watch_sentences(even[1][-1]))
    assert told.startswith("No alarm in 200 pushes: evidence 1")
    assert "of the 100 needed at an alarm rate of 0.02" in told
    assert "Carry on; least covered: " in told


def test_a_rest_without_an_alarm_says_how_its_pushes_are_counted() -> None:
    """Nine pushes on one spot are a rest, and too few for an alarm."""
    told = " ".join(sentences.watch_sentences(course_of(np.full(9, 0.5))[1][-1]))
    assert told.startswith("No alarm in 9 pushes")
    assert "It rests near 28.6° since push 0, counted from 0." in told


def test_rests_on_several_directions_and_gatherings_are_worded_apart() -> None:
    alternating = course_of(np.tile(np.radians([10.0, 100.0, 200.0]), 30))
    assert "θ0 goes round" in sentences.alarm_sentence(alternating[1][-1].alarm)
    gathered = course_of(np.random.default_rng(2).vonmises(1.0, 2.0, 300))
    assert "visits gather near" in sentences.alarm_sentence(gathered[1][-1].alarm)
