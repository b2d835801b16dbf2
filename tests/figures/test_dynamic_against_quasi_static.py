"""What the caption of dynamic-against-quasi-static claims: small differences that fall with the speed squared."""

import math
from functools import cache

import numpy as np
import pytest

from cyclemap.figures import dynamic_against_quasi_static
from cyclemap.figures.catalogue import MeasuredFolder
from cyclemap.figures.dynamic_against_quasi_static import InertiaStudy


@cache
def small() -> InertiaStudy:
    return dynamic_against_quasi_static.compute(MeasuredFolder(), orientations=3, speeds=(0.01, 0.02, 0.04), fewer=1)


@pytest.mark.slow
def test_the_difference_falls_with_the_speed_squared_on_both_laws() -> None:
    assert small().differences.shape == (2, 3)
    assert small().orders == pytest.approx((2.0, 2.0), abs=0.05)
    # The mean of the two slopes between neighbours is the fitted one, for evenly spaced logarithms.
    slopes = np.diff(np.log2(small().differences), axis=1)
    assert small().orders == pytest.approx(slopes.mean(axis=1), abs=1e-9)


@pytest.mark.slow
def test_the_caption_tells_the_largest_differences_of_the_result() -> None:
    caption = dynamic_against_quasi_static.caption(small())
    for comparison in (small().material, small().isotropic):
        drag = math.degrees(np.abs(comparison.difference("drag_turn")).max())
        assert 0.05 < drag < 0.2
        assert f"{drag:.2f}° in the drag" in caption
    left = math.degrees(small().differences[:, 0].max())
    assert f"At 10 mm/s {left:.3f}° are left" in caption


def test_the_figure_shows_both_differences_and_their_fall() -> None:
    figure = dynamic_against_quasi_static.draw(small())
    turns, places, fall = figure.axes
    assert turns.get_ylabel() == "dynamic − quasi-static (°)" and places.get_ylabel() == "dynamic − quasi-static (mm)"
    assert (fall.get_xscale(), fall.get_yscale()) == ("log", "log")
    assert [text.get_text() for text in fall.get_legend().get_texts()] == ["plywood", "isotropic", "speed squared"]
