"""Fig. 6: densities and histograms are laws, peaks lie where the caption says, recorded θ0 are drawn where there."""

import numpy as np
import pytest
from drawn_words import assert_words_apart
from figure_cases import NOWHERE, RECORDED_ABS, SMALL, labels, recorded_folder

from cyclemap.figures.measured_folder import NO_DATA, MeasuredFolder
from cyclemap.figures.theta0_histograms import PEAK_WORDS, UNIFORM, caption, compute, draw, share_near
from cyclemap.views.fit_page import CIRCLE


@pytest.fixture(scope="module")
def result():
    return compute(NOWHERE, SMALL)


def test_densities_and_histograms_have_area_one(result) -> None:
    assert len(result) == 4
    for one in result:
        assert np.trapezoid(one.density, CIRCLE) == pytest.approx(1.0, abs=5e-3)
        assert np.sum(one.simulated.density * np.diff(one.simulated.edges)) == pytest.approx(1.0)


def test_each_highest_peak_lies_within_17_degrees_of_the_papers_high_one(result) -> None:
    for one in result[:3]:
        words = PEAK_WORDS[one.run.surface]
        high = one.run.published.directions[words.index("high" if "high" in words else "only")]
        assert np.cos(one.peaks[0] - high) > np.cos(np.deg2rad(17.0)), one.run.surface
        assert one.density.max() > 5 * UNIFORM


def test_pu_has_no_sharp_peak_and_the_paper_none(result) -> None:
    pu = result[3]
    assert pu.run.published.directions == () and PEAK_WORDS["pu"] == ()
    assert pu.density.max() < 3.5 * UNIFORM and pu.density.min() > 0.1 * UNIFORM


def test_measured_plywood_lingers_where_the_paper_saw_it(measured_data) -> None:
    found = compute(MeasuredFolder(measured_data), SMALL)
    plywood = found[0]
    assert plywood.theta0.size == 2000 and found[1].theta0 is None
    assert share_near(plywood.theta0, plywood.run.published.directions) > 0.8
    told = caption(found)
    assert "of the 2000 recorded ones, whose highest bin is 95° to 100°" in told
    assert f"{plywood.apart:.2f} apart in total variation" in told and 0.0 < plywood.apart < 1.0
    assert told.endswith(f"Recorded θ0 on abs, delrin and pu: {NO_DATA}.")


def test_a_recorded_set_gives_its_theta0(tmp_path_factory) -> None:
    found = compute(recorded_folder(tmp_path_factory), SMALL)
    assert found[1].theta0.size == RECORDED_ABS
    figure = draw(found)
    assert labels(figure) == [("θ0, orientation before the push (°)", "probability per degree")] * 4
    assert_words_apart(figure)
    assert "measured" in [text.get_text() for text in figure.axes[1].get_legend().get_texts()]
