"""The site's drawings name what their pages explain, and their words lie apart."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from drawn_words import assert_words_apart, words_of_figure

import cyclemap as cm
from cyclemap.evidence.tables.planned_table import mark_columns
from cyclemap.views.panels.style import picture_style

FOLDER = Path(__file__).parents[2] / "docs" / "_figures"


def loaded(name: str):
    """A module of drawings, which the site loads by name as well."""
    spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def conventions():
    return loaded("conventions")


def test_frames_angles_sides_and_displacements_are_named(conventions):
    with picture_style():
        drawing = conventions.draw()
    assert_words_apart(drawing)
    words = " ".join(text.get_text() for text in words_of_figure(drawing))
    named = [r"\theta_0", r"\Delta\theta", r"\Delta x", r"\Delta y", r"\phi"]
    named += ["side 0", "side 3", "fraction 0.7", "ring"]
    assert [name for name in named if name not in words] == []


def test_the_drawn_turn_is_counter_clockwise_and_the_push_moves_the_object_down(conventions):
    cycle = cm.CollectionLoop.mit(material="plywood").cycle(conventions.THETA0)
    assert cycle.push_turn > 0 > cycle.drag_turn
    assert cycle.push_displacement[0] > 0 > cycle.push_displacement[1]
    assert np.abs(cycle.push.end.theta - cycle.theta - cycle.push_turn) < 1e-12


def test_the_drawing_of_what_is_measured_names_every_column_of_the_table():
    with picture_style():
        drawing = loaded("measuring").draw()
    assert_words_apart(drawing)
    words = [text.get_text() for text in words_of_figure(drawing)]
    assert {name for state in "012" for name in mark_columns(state)} <= {*words}
