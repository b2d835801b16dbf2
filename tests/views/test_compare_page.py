"""The comparison page draws what was measured and predicted,
and its sentences carry the answers."""

import re
from dataclasses import replace

import numpy as np
import pytest
from drawn_words import assert_words_apart

from cyclemap.collection.portrait_curves import turn_curve
from cyclemap.evidence import Comparison, Theta0Pairs, compare
from cyclemap.evidence.comparison.push_agreement import PushAgreement
from cyclemap.maps import CircleMap, WrappedNormal, sample_staircase
from cyclemap.views import compare_page as sentences
from cyclemap.views.compare_page import compare_page, residual_page, verdicts

SINE, NOISE = CircleMap.arnold(0.11, 0.6), WrappedNormal(0.1)
FACTS = {"surface": "plywood", "object": "rect1"}
FACTS |= {"speed": 0.02, "side": 0.0, "fraction": 0.7, "angle": 0.0}
CYCLES, PUSHES = ["Cycle map", "Directions", "Staircase"], ["Δθ", "Δx", "Δy"]
NO_CYCLES = {"cycle": None, "orientations": None, "directions": None, "staircase": None}


def made_pushes() -> PushAgreement:
    rng = np.random.default_rng(1)
    theta = rng.uniform(0.0, 6.0, 50)
    predicted = np.column_stack(
        [1.2 + 0.1 * np.sin(theta), 0.04 + 0 * theta, -0.08 + 0.01 * np.cos(theta)]
    )
    measured = predicted + 0.001 * rng.standard_normal((50, 3))
    return PushAgreement(FACTS, 0.15, theta, measured, predicted, measured)


@pytest.fixture(scope="module")
def found() -> Comparison:
    path = sample_staircase(SINE, NOISE, 120, 0.5, seed=1).theta
    plain = compare(SINE, Theta0Pairs(path[:-1], path[1:], path), noise=NOISE, runs=19)
    return replace(plain, pushes=(made_pushes(),))


@pytest.mark.parametrize(
    ("shown", "titles"),
    [
        ({}, CYCLES + PUSHES),
        ({"pushes": ()}, CYCLES),
        ({"pushes": (made_pushes(),) * 4, **NO_CYCLES}, PUSHES),
        ({"orientations": None, "staircase": None}, CYCLES + PUSHES),
    ],
)
def test_a_page_has_a_panel_for_what_is_there_and_its_words_lie_apart(found, shown, titles) -> None:
    page = compare_page("sine", replace(found, **shown), turn_curve(SINE))
    assert [axes.get_title(loc="left").split(":")[0] for axes in page.axes] == titles
    assert_words_apart(page)


def test_the_sentences_count_the_answers_and_name_what_was_left_out(found) -> None:
    answers = [verdict.agrees for verdict in verdicts(found)]
    agreed = [verdict.question for verdict in verdicts(found) if verdict.agrees]
    assert {"cycle map", "histogram of directions"} <= {*agreed}
    kept, asked = answers.count(True), len(answers) - answers.count(None)
    said = f"sine agrees with the data in {kept} of {asked} questions"
    assert sentences.headline("sine", found) == said
    assert sentences.data_sentence(found) == "Compared: 50 pushes with end poses and 120 cycles."
    left = replace(found, data=replace(found.data, left_out={"jump": 3}, unreadable=2))
    assert sentences.data_sentence(left).endswith("; left out: 3 (jump), 2 unreadable files.")
    assert "Agree: mean turn of a push of rect1 on plywood" in sentences.summary_sentence(found)


def test_pushes_of_another_object_among_them_are_told_though_all_means_agree(found) -> None:
    """A third of the pushes go the other way, one behind the other: correlated as they are, the error
    of the mean covers them. A few in a hundred are as on any robot.
    """
    own = made_pushes()
    for count, answer in ((20, False), (4, None)):
        measured = own.measured.copy()
        measured[-count:, 1:] *= -1.0
        mixed = replace(found, pushes=(replace(own, measured=measured),), **NO_CYCLES)
        told = {verdict.question: verdict for verdict in verdicts(mixed)}["ends of pushes"]
        assert told.agrees is answer
        assert ("20 of 50 end further" in told.words) == (answer is False)
    assert sentences.headline("sine", mixed).startswith("sine agrees with the data in")


def test_what_is_left_is_drawn_and_the_explanation_that_leaves_least_comes_first(found) -> None:
    assert len(residual_page(found).axes) == 4
    assert residual_page(replace(found, cycle=None, pushes=())) is None
    of_pushes, of_cycles = sentences.explanation_sentences("sine", found)
    left = "Of 50 pushes there is left on average: 0.0 mm and 0.0° by isotropic friction"
    assert of_pushes.startswith(left)
    told = [float(word) for word in re.findall(r"([\d.]+)° by", of_cycles)]
    assert told == sorted(told)
    assert "by sine, " in of_cycles
    assert "by one turn for all orientations; the best smooth map" in of_cycles


def test_what_weakens_a_p_value_is_told(found) -> None:
    assert sentences.trust_sentences(found) == []
    cycle = replace(found.cycle, lag_correlation=0.4)
    correlated = replace(found, cycle=cycle, uncertified=("why",))
    certified, noise = sentences.trust_sentences(correlated)
    assert certified == "Not certified: why."
    assert "correlation 0.40" in noise
