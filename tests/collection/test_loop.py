"""The collection loop: a cycle is a push and a drag; by theta its derivative is the map's slope."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import SidePush, WorldPush

MIT = CollectionLoop.mit()


@pytest.mark.parametrize("theta", [-2.5, -0.6, 0.3, 2.2, 4.0, 17.1])
def test_the_multiplier_is_the_slope_of_the_cycle_map(theta):
    loop = replace(MIT, accuracy=1e-11)
    found, step = loop.sensitivity(theta), 2e-5
    near, far = (loop.cycle(theta + k * step).theta_next - loop.cycle(theta - k * step).theta_next for k in (1, 2))
    assert abs(found.by_theta - (8.0 * near - far) / (12.0 * step)) < 1e-6
    assert found.by_theta == found.by("theta") == found.by("theta", "theta_next")
    assert abs(found.theta_next - loop.cycle(theta).theta_next) < 1e-14


def test_a_sensitivity_of_an_unknown_name_is_refused():
    with pytest.raises(InvalidInput, match="no derivative of 'theta_next' by 'mass'"):
        MIT.sensitivity(0.0).by("mass")


def test_a_cycle_starts_and_ends_with_its_ring_at_the_target():
    for theta in (-2.0, 0.0, 9.1):
        cycle = MIT.cycle(theta)
        for pose in (cycle.push.start, cycle.drag.end):
            assert np.allclose(MIT.model.ring_place(pose), 0.0, atol=1e-16)
        assert cycle.push.start.theta == theta
        assert cycle.theta_next == cycle.drag.end.theta
        assert abs(theta + cycle.push_turn + cycle.drag_turn - cycle.theta_next) < 1e-14


def test_the_lift_commutes_with_full_turns():
    for theta in (-1.0, 0.5, 2.0):
        assert abs(MIT.cycle(theta + 6 * math.pi).theta_next - MIT.cycle(theta).theta_next - 6 * math.pi) < 1e-8


def test_the_drawn_trajectory_is_the_cycles_own_only_finer():
    cycle = MIT.cycle(1.0)
    drawn = cycle.trajectory
    assert len(drawn.push.path) > 60
    assert len(drawn.drag.path) > 20
    assert abs(drawn.push.pose[-1, 2] - cycle.push.end.theta) < 1e-7
    assert abs(drawn.drag.pose[-1, 2] - cycle.theta_next) < 1e-6
    assert np.allclose(drawn.drag.pusher[-1], 0.0, atol=1e-15)


def test_values_that_fit_no_loop_are_refused():
    for theta in (float("nan"), "1", None, True):
        with pytest.raises(InvalidInput, match="theta"):
            MIT.cycle(theta)
    with pytest.raises(InvalidInput, match="sides 0 to 3"):
        replace(MIT, push=SidePush(side=7)).cycle(0.0)
    with pytest.raises(InvalidInput, match="did you mean 'plywood'"):
        CollectionLoop.mit("plywod")
    with pytest.raises(InvalidInput, match="finite"):
        MIT.next_theta([0.0, float("inf")])
    with pytest.raises(InvalidInput):
        WorldPush((0.0, 0.0), 0.0, -1.0)
