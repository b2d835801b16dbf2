"""Fig. 6: densities and histograms are laws, peaks lie where the caption says, recorded θ0 are drawn where there."""

import numpy as np
import pytest
from drawn_words import assert_words_apart
from figure_cases import NOWHERE, RECORDED_ABS, SMALL, labels, recorded_folder

from cyclemap.figures.measured_folder import NO_DATA, MeasuredFolder
from cyclemap.figures.theta0_histograms import NEAR, PEAK_WORDS, UNIFORM, caption, compute, draw, share_near
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


@pytest.mark.slow
def test_the_caption_tells_peaks_and_shares(result) -> None:
    told = caption(result)
    for one in result[:3]:
        for peak in one.peaks:
            assert f"{np.degrees(peak):.0f}°" in told
        apart = np.abs(np.angle(np.exp(1j * np.subtract.outer(one.run.pushes.theta, one.run.published.directions))))
        share = np.mean(np.min(apart, axis=1) <= NEAR)
        assert f"{share:.0%} of the simulated pushes start within 30°" in told
    assert "100° high and 280° small" in told and "210° small and 150° high" in told and "80° only" in told


def test_the_papers_peaks_are_marked_where_they_are(result) -> None:
    figure = draw(result)
    for axes, places in zip(figure.axes, ([100, 280], [150, 210], [80], []), strict=True):
        lines = [line.get_xdata()[0] for line in axes.lines if len(line.get_xdata()) == 2 and line.get_ls() == "--"]
        assert sorted(lines) == pytest.approx(places)
    assert figure.axes[3].texts[0].get_text() == "paper: no stable direction"


@pytest.mark.slow
def test_without_data_the_caption_says_so(result) -> None:
    note = f"Recorded θ0 on plywood, abs, delrin and pu: {NO_DATA}."
    assert caption(result).endswith(note)
    assert draw(result).texts == []


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
