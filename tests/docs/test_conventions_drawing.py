"""The drawing of the conventions names what the page explains, and no text runs into another or off the picture."""

import importlib.util
import itertools
from pathlib import Path

import numpy as np
import pytest

from cyclemap.views.style import picture_style

MODULE = Path(__file__).parents[2] / "docs" / "_figures" / "conventions.py"


@pytest.fixture(scope="module")
def conventions():
    spec = importlib.util.spec_from_file_location("conventions", MODULE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def drawing(conventions):
    with picture_style():
        figure = conventions.draw()
        figure.canvas.draw()
    return figure


def written(figure) -> list:
    """Every text that shows."""
    return [text for axes in figure.axes for text in [*axes.texts, axes._left_title] if text.get_text()]


def text_box(figure, text):
    """The box of a text's own letters: an annotation's includes its arrow."""
    from matplotlib.text import Text

    return Text.get_window_extent(text, figure.canvas.get_renderer())


def test_frames_angles_sides_and_displacements_are_named(drawing):
    words = " ".join(text.get_text() for text in written(drawing))
    named = [
        r"\theta_0",
        r"\Delta\theta",
        r"\Delta x",
        r"\Delta y",
        "side 0",
        "side 3",
        "fraction 0.7",
        "ring",
        r"\phi",
    ]
    assert [name for name in named if name not in words] == []


def test_no_text_leaves_the_picture_or_covers_another(drawing):
    boxes = {text.get_text(): text_box(drawing, text) for text in written(drawing)}
    assert len(boxes) >= 18
    for name, box in boxes.items():
        assert drawing.bbox.x0 <= box.x0 and box.x1 <= drawing.bbox.x1, name
        assert drawing.bbox.y0 <= box.y0 and box.y1 <= drawing.bbox.y1, name
    covered = [(a, b) for (a, one), (b, two) in itertools.combinations(boxes.items(), 2) if one.overlaps(two)]
    assert covered == []


def test_the_drawn_turn_is_counter_clockwise_and_the_push_moves_the_object_down(conventions):
    """What the signs on the page say of a push on side 0."""
    import cyclemap as cm

    cycle = cm.CollectionLoop.mit(material="plywood").cycle(conventions.THETA0)
    assert cycle.push_turn > 0 > cycle.drag_turn
    assert cycle.push_displacement[0] > 0 > cycle.push_displacement[1]
    assert np.abs(cycle.push.end.theta - cycle.theta - cycle.push_turn) < 1e-12
