"""Fig. 7: the law's histogram is compared with the turns it was fitted to, and it is said which turns these are."""

import numpy as np
import pytest
from drawn_words import assert_words_apart
from figure_cases import NOWHERE, RECORDED_ABS, SMALL, labels, recorded_folder

from cyclemap.figures.measured_folder import NO_DATA, MeasuredFolder
from cyclemap.figures.turn_histograms import caption, compute, draw

RUNS = 20
NAMES = ["plywood", "abs", "delrin", "pu"]


@pytest.fixture(scope="module")
def result():
    return compute(NOWHERE, SMALL, RUNS)


def test_histograms_count_every_simulated_push_and_so_does_the_law(result) -> None:
    assert [panel.surface for panel in result.panels] == NAMES == list(result.absent)
    for panel in result.panels:
        assert not panel.recorded and not panel.whole_cycle
        assert panel.histogram.count == SMALL.pushes
        assert np.sum(panel.histogram.predicted) == pytest.approx(SMALL.pushes)


def test_the_law_with_its_scatter_is_nearer_than_alone(result) -> None:
    for panel in result.panels:
        found = panel.histogram
        assert found.total_variation < found.law_alone_total_variation, panel.surface


def test_simulated_turns_are_named_so_and_axes_have_units(result) -> None:
    figure = draw(result)
    assert labels(figure) == [("turn of the push, Δθ (°)", "pushes")] * 4
    for axes in figure.axes:
        assert axes.get_legend().get_texts()[0].get_text() == "simulated"
    assert_words_apart(figure)


@pytest.mark.slow
def test_of_measured_plywood_only_whole_cycles_are_at_hand_and_it_says_so(measured_data) -> None:
    found = compute(MeasuredFolder(measured_data), SMALL, RUNS)
    cycle = found.panels[-1]
    assert [panel.whole_cycle for panel in found.panels] == [False] * 4 + [True]
    assert cycle.recorded and cycle.surface == "plywood" and cycle.histogram.count == 1996
    told = caption(found)
    assert "Of 1996 whole cycles recorded (push and drag together, since only θ0 is at hand, not Δθ) on plywood" in told
    assert told.endswith(f"Recorded pushes on plywood, abs, delrin and pu: {NO_DATA}.")
    figure = draw(found)
    assert figure.axes[-1].get_xlabel() == "turn of the whole cycle, push and drag (°)"
    assert_words_apart(figure)


def test_recorded_pushes_take_the_place_of_simulated_ones(tmp_path_factory) -> None:
    found = compute(recorded_folder(tmp_path_factory), SMALL, RUNS)
    panel = found.panels[1]
    assert (panel.surface, panel.recorded, panel.histogram.count) == ("abs", True, RECORDED_ABS)
    assert f"Of {RECORDED_ABS} pushes recorded on abs" in caption(found)
    assert draw(found).axes[1].get_legend().get_texts()[0].get_text() == "measured"
