"""The published numbers: they agree with each other and with the geometry of the push."""

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.evidence.published_statistics import PUBLISHED, published_statistics
from cyclemap.mechanics import Pusher, SidePush, Slider

# Table III: percentages beside the RMSE of dtheta, dx, dy.
PERCENT = {
    "plywood": (2.99, 2.46, 3.66),
    "abs": (4.00, 3.88, 4.75),
    "delrin": (1.63, 2.07, 3.08),
    "pu": (1.64, 1.49, 1.86),
}


def rod_in_object(published, signs, exchanged) -> np.ndarray:
    """Where the rod's centre ends in the object's frame (2,), if the mean motion had these signs of dx, dy and turn."""
    turn, dx, dy = (abs(value) * sign for value, sign in zip(published.mean, signs, strict=True))
    moved = (dy, dx) if exchanged else (dx, dy)
    c, s = math.cos(turn), math.sin(turn)
    side = 0.5 * 0.09
    start = np.array([side - SidePush().fraction * 2 * side, side + Pusher().radius])
    end = start - (0.0, SidePush().distance) - np.array(moved)
    return np.array([[c, s], [-s, c]]) @ end


def test_means_follow_from_either_table_within_four_percent():
    assert len(PUBLISHED) == 4
    for name, published in PUBLISHED.items():
        other = 100.0 * np.array(published.rmse) / np.array(PERCENT[name])
        assert other == pytest.approx(np.abs(published.mean), rel=0.04)


@pytest.mark.parametrize("material", ["plywood", "pu"])
def test_only_dx_forward_dy_backward_and_a_positive_turn_leave_the_rod_on_the_pushed_side(material):
    """Both pushes end in contact, so of sixteen readings of the signs and axes one alone can be right."""
    assert Slider.mit("rect1").outline.extent == pytest.approx(0.045 * math.sqrt(2), rel=0.01)
    fitting = []
    for signs in product((1, -1), repeat=3):
        for exchanged in (False, True):
            x, y = rod_in_object(published_statistics(material), (signs[1], signs[2], signs[0]), exchanged)
            if abs(x) <= 0.045 and abs(y - 0.04975) < 0.002:
                fitting.append((signs, exchanged))
    assert len(fitting) == 1
    published = published_statistics(material)
    x, y = rod_in_object(published, np.sign(published.mean), False)
    assert abs(x) <= 0.045 and abs(y - 0.04975) < 0.002


def test_the_run_on_abs_starts_where_its_small_peak_is():
    assert math.degrees(published_statistics("abs").start) == pytest.approx(-150.0)
    assert published_statistics("delrin").start is None


def test_impossible_statistics_and_unknown_materials_are_refused():
    with pytest.raises(InvalidInput, match="steel"):
        published_statistics("steel")
    with pytest.raises(InvalidInput, match="cannot exceed"):
        replace(published_statistics("pu"), rmse=(1.0, 0.0, 0.0))
    with pytest.raises(InvalidInput, match="second"):
        replace(published_statistics("delrin"), first_share=0.1)
    with pytest.raises(InvalidInput, match="name a direction"):
        replace(published_statistics("delrin"), directions=())
