"""What the caption of anisotropic-against-isotropic claims: batches draw together, isotropic paths are one."""

from functools import cache

import numpy as np
import pytest

from cyclemap.collection import BatchExperiment
from cyclemap.figures import anisotropic_against_isotropic
from cyclemap.figures.catalogue import MeasuredFolder


@cache
def small() -> BatchExperiment:
    return anisotropic_against_isotropic.compute(MeasuredFolder(), batches=3, cycles=5)


@pytest.mark.slow
def test_anisotropic_batches_draw_together_and_isotropic_ones_keep_their_distance() -> None:
    """A third of a turn apart at first, the batches near the stable point close in: their distance falls."""
    unit = np.exp(1j * small().anisotropic.theta)
    # |mean of unit vectors| is 0 for evenly spread directions and 1 for equal ones.
    together = np.abs(unit.mean(axis=0))
    assert together[0] < 1e-9 and together[-1] > 0.3
    isotropic = np.abs(np.exp(1j * small().isotropic.theta).mean(axis=0))
    assert isotropic.max() < 1e-4


@pytest.mark.slow
def test_in_the_objects_frame_isotropic_paths_are_one_and_anisotropic_ones_spread() -> None:
    assert small().isotropic.spread < 5e-6
    assert small().anisotropic.spread > 0.01
    text = anisotropic_against_isotropic.caption(small())
    assert "all 15 paths are one" in text and "the 15 paths spread by up to" in text
    assert "dynamic simulation at 20 mm/s; 15 cycles: 3 batches of 5" in text


def test_the_figure_has_both_frames_of_both_laws_in_one_window_a_row() -> None:
    figure = anisotropic_against_isotropic.draw(small())
    assert [axes.get_title(loc="left") for axes in figure.axes] == [
        "Anisotropic, robot's frame",
        "Isotropic, robot's frame",
        "Anisotropic, object's frame",
        "Isotropic, object's frame",
    ]
    assert all(axes.get_xlabel().endswith("(mm)") and axes.get_ylabel().endswith("(mm)") for axes in figure.axes)
    for left, right in (figure.axes[:2], figure.axes[2:]):
        assert left.get_xlim() == right.get_xlim() and left.get_ylim() == right.get_ylim()
