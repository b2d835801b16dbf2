"""What a notebook shows: one small picture and a caption for each of the values that people look
at.
"""

import math
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

import cyclemap as cm

LOOP = cm.CollectionLoop.mit("plywood")


def shown(value) -> ElementTree.Element:
    """The figure, which is well-formed, draws inside its frame, and is small."""
    text = value._repr_html_()
    figure = ElementTree.fromstring(text)
    assert len(text) < 20_000
    height = float(figure[0].get("height"))
    lines = [line.get("points").split() for line in figure.iter("polyline")]
    places = [tuple(map(float, place.split(","))) for line in lines for place in line]
    places += [(float(mark.get("cx")), float(mark.get("cy"))) for mark in figure.iter("circle")]
    assert all(0 <= x <= 320 and 0 <= y <= height for x, y in places)
    return figure


def test_a_map_is_drawn_piece_by_piece() -> None:
    jump = cm.CircleMap(
        lambda theta: theta + 0.3 * (np.mod(theta, 2 * np.pi) < 1.0), breaks=(0.0, 1.0)
    )
    assert len(list(shown(jump).iter("polyline"))) == 3
    assert len(list(shown(cm.CircleMap.arnold(0.1, 0.9)).iter("polyline"))) == 2


def test_an_orbit_has_a_mark_for_each_point_filled_where_it_is_stable() -> None:
    for orbit in cm.periodic_orbits(cm.CircleMap.arnold(0.5, 0.9), 2):
        marks = [mark.get("fill") for mark in shown(orbit).iter("circle")]
        assert len(marks) == 2 and {fill != "none" for fill in marks} == {orbit.stable}


def test_a_loop_tells_object_surface_and_push() -> None:
    """In true proportions: the square of 90 mm is as wide as high."""
    named = cm.protocol.loop_from_settings({"object_name": "a<b"}, LOOP)
    assert "a<b on plywood, pushed 150 mm" in shown(named).findtext("figcaption")
    outline = next(shown(LOOP).iter("polyline")).get("points").split()
    x, y = np.array([place.split(",") for place in outline], dtype=float).T
    assert np.ptp(x) == pytest.approx(np.ptp(y), abs=0.2) and np.ptp(x) > 50


def test_a_cycle_tells_its_turns() -> None:
    assert "push +73.7° (blue), drag back -63.7°" in shown(LOOP.cycle(0.0)).findtext("figcaption")


def test_a_cycle_that_leaves_the_ring_where_it_is_has_no_way_back_to_draw() -> None:
    """The rod leaves at once; of a drag without length there is no trajectory."""
    cycle = cm.CollectionLoop.mit(push=cm.SidePush(fraction=0.0, angle=1.5707963)).cycle(0.0)
    assert cycle.drag_length == 0.0
    assert len(list(shown(cycle).iter("polyline"))) == 4


@pytest.mark.slow
def test_a_portrait_marks_its_fixed_points() -> None:
    found = cm.portrait(LOOP, tolerance=1e-4, cycles=50)
    assert len(list(shown(found).iter("circle"))) == len(found.fixed_points) == 2


def test_cycles_are_the_same_numbers_as_rows_and_over_named_axes() -> None:
    runs = cm.run_cycles([LOOP, cm.CollectionLoop.mit("delrin")], [0.0, 1.0, 2.0])
    data, frame = runs.to_dataset("loop", "start"), runs.to_frame()
    assert dict(data.sizes) == {"loop": 2, "start": 3} and len(frame) == 6
    assert np.array_equal(frame.push_dy, runs.push_displacement[..., 1].ravel())
    assert np.array_equal(data.theta_next, runs.theta_next)
    assert math.isclose(np.degrees(frame.push_turn[0]), 73.653, abs_tol=1e-3)
    with pytest.raises(cm.InvalidInput, match="give one for each"):
        runs.to_dataset("loop")
