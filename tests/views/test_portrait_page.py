"""The page: what it shows, that it says so with units, and that no words collide."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.text import Text

from cyclemap.errors import InvalidInput
from cyclemap.views import style
from cyclemap.views.style import render

CASES = [("locked", False), ("locked", True), ("rotating", True), ("jumping", False)]


def axes_titled(page, title):
    found = [axes for axes in page.axes if axes.get_title(loc="left").startswith(title)]
    assert len(found) == 1, f"no single panel titled {title!r}"
    return found[0]


def line_with(axes, x, y):
    """The lines of `axes` that run through exactly these points."""
    return [
        line
        for line in axes.lines
        if np.shape(line.get_xdata()) == np.shape(x)
        and np.allclose(line.get_xdata(), x)
        and np.allclose(line.get_ydata(), y)
    ]


@pytest.mark.slow
def test_every_panel_names_its_quantities_with_units(drawn) -> None:
    page = drawn("locked").page
    labels = {axes.get_title(loc="left").split()[0]: (axes.get_xlabel(), axes.get_ylabel()) for axes in page.axes}
    assert labels == {
        "Turn": ("θ0, orientation before the push (°)", "turn of one cycle, f(θ0) - θ0 (°)"),
        "Directions": ("θ0, orientation before the push (°)", "probability per degree"),
        "Cobweb": ("θ0 (°)", "next θ0 (°)"),
        "Staircase": ("cycle", "θ0, unwrapped (°)"),
        "Push": ("x (mm)", "y (mm)"),
        "Drag": ("x (mm)", "y (mm)"),
    }


@pytest.mark.slow
def test_titles_stand_where_matplotlib_would_put_them(drawn) -> None:
    """Their height is said, which saves a measuring of all tick labels; found by that measuring it is the same."""
    page = drawn("locked", True).page
    said, found = [], []
    for axes in page.axes:
        assert axes._autotitlepos is False
        said.append(axes.title.get_position())
        axes._autotitlepos = True
        axes._update_title_position(page.canvas.get_renderer())
        found.append(axes.title.get_position())
        axes._autotitlepos = False
    assert len(said) == 6 and said == found


@pytest.mark.slow
def test_turn_panel_draws_the_map_in_degrees_and_marks_its_fixed_points(drawn) -> None:
    result = drawn("locked")
    axes = axes_titled(result.page, "Turn")
    theta, turn = result.curves.turn.pieces[0]
    assert len(line_with(axes, np.rad2deg(theta), np.rad2deg(turn))) == 1
    faces = {}
    for line in axes.lines:
        if line.get_marker() == "o":
            faces[round(float(line.get_xdata()[0]), 6)] = line.get_markerfacecolor()
    expected = {round(float(np.rad2deg(o.points[0])), 6): o.stable for o in result.portrait.fixed_points}
    assert len(expected) == 2
    assert {place: face == style.PREDICTED for place, face in faces.items()} == expected


@pytest.mark.slow
def test_jump_is_a_gap_with_a_dotted_connector(drawn) -> None:
    result = drawn("jumping")
    axes = axes_titled(result.page, "Turn")
    dotted = [line for line in axes.lines if line.get_linestyle() == ":"]
    assert [line.get_xdata()[0] for line in dotted] == [pytest.approx(np.rad2deg(2.0))]
    solid = [line for line in axes.lines if line.get_linewidth() == 2.0]
    assert len(solid) == 2
    for line in solid:
        assert np.abs(np.diff(line.get_ydata())).max() < 1.0


@pytest.mark.slow
def test_density_panel_draws_probability_per_degree(drawn) -> None:
    result = drawn("rotating", True)
    axes = axes_titled(result.page, "Directions")
    line = next(line for line in axes.lines if line.get_label() == "predicted")
    assert np.trapezoid(line.get_ydata(), line.get_xdata()) == pytest.approx(1.0, abs=1e-5)
    measured = axes.patches[0].get_data()
    assert np.sum(measured.values * np.diff(measured.edges)) == pytest.approx(1.0)


@pytest.mark.slow
def test_staircase_panel_draws_both_runs(drawn) -> None:
    result = drawn("rotating", True)
    axes = axes_titled(result.page, "Staircase")
    lines = {line.get_label(): line.get_ydata() for line in axes.lines}
    assert np.allclose(lines["predicted"], np.rad2deg(result.portrait.staircase.theta))
    assert np.allclose(lines["measured"], np.rad2deg(result.measured.pairs.path))


def test_cycle_is_drawn_to_scale_in_millimetres(drawn) -> None:
    result = drawn("locked")
    for title, stroke in (("Push", result.curves.scene.push), ("Drag", result.curves.scene.drag)):
        axes = axes_titled(result.page, title)
        assert axes.get_aspect() == 1.0
        outlines = [patch.get_path().vertices for patch in axes.patches]
        assert any(o.shape == stroke.after.shape and np.allclose(o, 1000 * stroke.after) for o in outlines)
        assert len(line_with(axes, *(1000 * stroke.rod).T)) >= 1


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "data"), CASES)
def test_words_stay_on_the_page_and_do_not_overlap(drawn, kind, data) -> None:
    page = drawn(kind, data).page
    page.canvas.draw()
    boxes = [(text.get_text(), text.get_window_extent()) for text in words_on(page)]
    assert len(boxes) > 40
    for text, box in boxes:
        assert box.x0 >= 0 and box.y0 >= 0 and box.x1 <= page.bbox.x1 and box.y1 <= page.bbox.y1, text
    collisions = [(one, two) for (one, a), (two, b) in combinations(boxes, 2) if a.shrunk(0.96, 0.8).overlaps(b)]
    assert collisions == []


def words_on(page) -> list[Text]:
    words = list(page.texts)
    for axes in page.axes:
        words += [axes.title, axes._left_title, axes.xaxis.label, axes.yaxis.label, *axes.texts]
        words += axes.get_legend().get_texts() if axes.get_legend() else []
        for axis, (low, high), along in ((axes.xaxis, axes.get_xlim(), 0), (axes.yaxis, axes.get_ylim(), 1)):
            # Tick labels beyond the axis are made but not drawn.
            words += [label for label in axis.get_ticklabels() if low <= label.get_position()[along] <= high]
    return [text for text in words if text.get_text().strip()]


def test_predicted_and_measured_differ_in_a_grey_print() -> None:
    def lightness(color: str) -> float:
        return float(np.dot(to_rgb(color), (0.299, 0.587, 0.114)))

    assert lightness(style.MEASURED) - lightness(style.PREDICTED) > 0.3
    assert lightness(style.PREDICTED_FILL) - lightness(style.MEASURED) > 0.15


@pytest.mark.slow
@pytest.mark.parametrize(("picture_format", "start"), [("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")])
def test_each_format_is_what_it_says_and_comes_out_the_same_twice(drawn, picture_format, start) -> None:
    page = drawn("locked").page
    picture = render(page, picture_format)
    assert picture.startswith(start)
    assert render(page, picture_format) == picture


def test_png_has_the_size_of_a_talk_slide_and_is_small(drawn) -> None:
    picture = render(drawn("rotating", True).page)
    width, height = (int.from_bytes(picture[at : at + 4], "big") for at in (16, 20))
    assert width / height == pytest.approx(16 / 9, rel=0.01)
    assert width >= 1600
    assert len(picture) < 400_000


def test_unknown_format_is_refused(drawn) -> None:
    with pytest.raises(InvalidInput, match="'gif' is unknown; use one of png, pdf, svg"):
        render(drawn("locked").page, "gif")
