"""The set-up and two cycles, batches on both kinds of friction, inertia: what their captions claim."""

import math

import numpy as np
import pytest
from figure_cases import exhibited

from cyclemap.arrays import placed
from cyclemap.figures.cycles import experiment_caption, inertia_caption

setup = exhibited("setup-and-cycle")
experiment = exhibited("anisotropic-against-isotropic")
study = exhibited("dynamic-against-quasi-static")


def test_the_second_cycle_starts_from_the_pose_in_which_the_first_one_ends(setup) -> None:
    first, second = setup.cycles
    assert second.theta == first.theta_next == first.theta + first.push_turn + first.drag_turn
    ends = first.trajectory.drag.pose[-1], second.trajectory.push.pose[0]
    assert np.allclose(*ends, atol=1e-9)


def test_the_ring_is_at_the_target_before_and_after_each_cycle_and_the_centre_is_elsewhere(
    setup,
) -> None:
    hitch = np.array(setup.loop.slider.hitch)
    for cycle in setup.cycles:
        first, last = cycle.trajectory.push.pose[0], cycle.trajectory.drag.pose[-1]
        assert np.allclose([placed(first, hitch), placed(last, hitch)], 0.0, atol=1e-12)
        assert np.hypot(*last[:2]) == pytest.approx(0.015, abs=1e-9)


def test_both_pushes_are_the_same_in_the_objects_frame_before_the_push(setup) -> None:
    """Where the rod first touches, turned back by θ0 about the centre, is the contact of the
    protocol.
    """
    places = []
    for cycle in setup.cycles:
        course = cycle.trajectory.push
        x, y = course.pusher[0] - course.pose[0, :2]
        c, s = math.cos(cycle.theta), math.sin(cycle.theta)
        places.append((c * x + s * y, -s * x + c * y))
    assert np.allclose(places, [(-0.018, 0.04975)] * 2, atol=1e-9)
    assert np.allclose(setup.contact, (-0.018, 0.045), atol=1e-15)


@pytest.mark.slow
def test_anisotropic_batches_draw_together_and_isotropic_paths_are_one(experiment) -> None:
    together, apart = (
        np.abs(np.exp(1j * run.theta).mean(axis=0))
        for run in (experiment.anisotropic, experiment.isotropic)
    )
    # |mean of unit vectors| is 0 for evenly spread directions and 1 for equal ones.
    assert together[0] < 1e-9 and together[-1] > 0.3 and apart.max() < 1e-4
    assert experiment.isotropic.spread < 5e-6 < 0.01 < experiment.anisotropic.spread
    text = experiment_caption(experiment)
    assert "all 15 paths are one" in text and "the 15 paths spread by up to" in text
    assert "dynamic simulation at 20 mm/s; 15 cycles: 3 batches of 5" in text


@pytest.mark.slow
def test_inertia_enters_as_the_speed_squared_and_the_caption_tells_the_largest_differences(
    study,
) -> None:
    assert study.differences.shape == (2, 3)
    assert study.orders == pytest.approx((2.0, 2.0), abs=0.05)
    caption = inertia_caption(study)
    for comparison in (study.material, study.isotropic):
        drag = math.degrees(np.abs(comparison.difference("drag_turn")).max())
        assert 0.05 < drag < 0.2
        assert f"{drag:.2f}° in the drag" in caption
    left = math.degrees(study.differences[:, 0].max())
    assert f"At 10 mm/s {left:.3f}° are left" in caption
