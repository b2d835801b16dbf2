"""The set-up is drawn to scale, and the second cycle starts where the first one ends."""

import math

import numpy as np
import pytest

from cyclemap.arrays import placed

NAME = "setup-and-cycle"


def test_the_second_cycle_starts_from_the_pose_in_which_the_first_one_ends(result) -> None:
    first, second = result.cycles
    assert second.theta == first.theta_next == first.theta + first.push_turn + first.drag_turn
    ends = first.trajectory.drag.pose[-1], second.trajectory.push.pose[0]
    assert np.allclose(*ends, atol=1e-9)


def test_the_ring_is_at_the_target_before_and_after_each_cycle_and_the_centre_is_elsewhere(
    result,
) -> None:
    hitch = np.array(result.loop.slider.hitch)
    for cycle in result.cycles:
        first, last = cycle.trajectory.push.pose[0], cycle.trajectory.drag.pose[-1]
        assert np.allclose([placed(first, hitch), placed(last, hitch)], 0.0, atol=1e-12)
        assert np.hypot(*last[:2]) == pytest.approx(0.015, abs=1e-9)
    starts = [cycle.trajectory.push.pose[0, :2] for cycle in result.cycles]
    turned = result.cycles[1].theta - result.cycles[0].theta
    assert np.hypot(*(starts[1] - starts[0])) == pytest.approx(
        2 * 0.015 * math.sin(turned / 2), abs=1e-9
    )


def test_both_pushes_are_the_same_in_the_objects_frame_before_the_push(result) -> None:
    """Where the rod first touches, turned back by θ0 about the centre, is the contact of the
    protocol.
    """
    places = []
    for cycle in result.cycles:
        course = cycle.trajectory.push
        x, y = course.pusher[0] - course.pose[0, :2]
        c, s = math.cos(cycle.theta), math.sin(cycle.theta)
        places.append((c * x + s * y, -s * x + c * y))
    assert np.allclose(places, [(-0.018, 0.04975)] * 2, atol=1e-9)
    assert np.allclose(result.contact, (-0.018, 0.045), atol=1e-15)
