"""The dynamic loop: cycles as the quasi-static loop's, the difference that inertia makes, and its
isotropic twin.
"""

import math
import pickle
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from refusals import refused

from cyclemap.collection import CollectionLoop, DynamicLoop, compare_dynamics, isotropic_twin
from cyclemap.collection.dynamic_loop import on_points
from cyclemap.mechanics import DragBack, PatchFootprint, Slider, corner_footprint
from cyclemap.protocol import loop_from_settings

# Four orientations: on plywood the push ends by distance at 60 and 150 degrees, the rod leaves at 0
# and 270.
THETA = np.radians([0.0, 60.0, 150.0, 270.0])


@cache
def compared(isotropic: bool):
    loop = CollectionLoop.mit()
    return compare_dynamics(DynamicLoop(isotropic_twin(loop) if isotropic else loop), THETA)


@pytest.mark.slow
@pytest.mark.parametrize("isotropic", [False, True])
def test_at_20_mm_a_second_inertia_changes_a_cycle_by_less_than_a_fifth_of_a_degree(isotropic):
    found = compared(isotropic)
    push, drag = (np.abs(np.degrees(found.difference(name))) for name in ("push_turn", "drag_turn"))
    assert push.shape == drag.shape == (4,)
    assert 0.01 < push.max() < 0.035 and 0.05 < drag.max() < 0.18
    place = np.hypot(*found.difference("push_displacement").T)
    assert 5e-5 < place.max() < 2.2e-4
    np.testing.assert_array_equal(found.dynamic.left, found.quasi_static.left)


def test_a_cycle_adds_up_is_the_one_of_many_and_knows_whole_turns_by_the_lift_alone():
    loop = DynamicLoop(CollectionLoop.mit())
    cycle, many = loop.cycle(THETA[1], samples=1), compared(False).dynamic
    assert cycle.theta_next == pytest.approx(
        cycle.theta + cycle.push_turn + cycle.drag_turn, abs=1e-12
    )
    assert (cycle.push_turn, cycle.theta_next) == (many.push_turn[1], many.theta_next[1])
    np.testing.assert_array_equal(cycle.push_displacement, many.push_displacement[1])
    assert cycle.drag_length == many.drag_length[1]
    assert cycle.trajectory.push.pose[-1] == pytest.approx(cycle.trajectory.drag.pose[0], abs=1e-12)
    # Up to the integrator's error: it turns a difference in rounding into other steps.
    again = loop.cycle(cycle.theta + 4.0 * math.pi)
    assert again.theta_next - cycle.theta_next == pytest.approx(4.0 * math.pi, abs=5e-5)
    # A loop that has run can be sent to another process.
    assert pickle.loads(pickle.dumps(loop)) == loop


def test_it_stands_on_the_loops_own_points_and_else_on_the_papers_grid():
    """The isotropic twin has the area of the limit ellipse and no offset."""
    loop = CollectionLoop.mit()
    corners = corner_footprint(loop.slider.outline)
    assert DynamicLoop(replace(loop, footprint=corners)).model.points == corners
    assert len(DynamicLoop(loop).model.points.positions) == 64
    assert on_points(replace(loop, footprint=corners)).footprint == corners
    law, twin = loop.material.friction, isotropic_twin(loop).material.friction
    assert twin.mu_a == twin.mu_b and twin.mu_a**2 == pytest.approx(law.mu_a * law.mu_b)
    assert (twin.m0, twin.n0) == (0.0, 0.0)


LEANING = Slider(
    CollectionLoop.mit().slider.outline,
    mass=1.0,
    centre_of_mass=(0.006, -0.004),
    hitch=CollectionLoop.mit().slider.hitch,
)
PRESSED = {
    "rim share": loop_from_settings({"rim_share": 0.5}),
    "parts": loop_from_settings({"inner_share": 0.3, "corner_share": 0.15}),
    "pu": CollectionLoop.mit("pu"),
    "centre of mass": CollectionLoop.mit(slider=LEANING),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", PRESSED)
def test_both_routes_stand_on_points_that_carry_the_patchs_pressure(name):
    """The quasi-static cycle on them is the patch's about as nearly as the even grid's is the even
    patch's, 0.25°.
    """
    loop = PRESSED[name]
    found = compare_dynamics(DynamicLoop(loop), THETA)
    assert np.abs(np.degrees(found.difference("theta_next"))).max() < 0.2
    patch = loop.cycles(THETA)
    off = np.degrees(found.quasi_static.theta_next - patch.theta_next)
    assert 0.0 < np.abs(off).max() < 0.3
    even = on_points(replace(loop, footprint=PatchFootprint(loop.slider.outline)))
    assert len(even.footprint.positions) == 64
    dropped = np.degrees(even.cycles(THETA).theta_next - patch.theta_next)
    assert np.abs(dropped).max() > 3.0 * np.abs(off).max()
    assert on_points(loop).footprint.centre == pytest.approx(loop.model.pressure.centre, abs=1e-12)


def test_way_points_and_pin_friction_of_the_reset_are_followed():
    loop = CollectionLoop.mit(reset=DragBack(((0.0, 0.05),), 0.002))
    found = compare_dynamics(DynamicLoop(loop), [0.4])
    straight = compare_dynamics(DynamicLoop(CollectionLoop.mit()), [0.4])
    assert abs(found.difference("drag_turn")[0]) < math.radians(0.25)
    assert found.dynamic.drag_length[0] > straight.dynamic.drag_length[0] + 0.01


def test_what_it_cannot_run_is_refused_by_name():
    loop = CollectionLoop.mit()
    refused(DynamicLoop(loop).cycle, math.nan, told="theta")
    refused(DynamicLoop(loop).cycle, 0.0, samples=10**12, told="keep fewer samples")
    refused(DynamicLoop, loop, speed=-0.02, told="speed must be positive")
    for name in ("speed", "stiffness", "regularisation", "tolerance"):
        refused(DynamicLoop, loop, told=name, **{name: 0.0})
    refused(DynamicLoop, loop, tolerance=1.0, told="1e-10 to 1e-3")
    for make in (DynamicLoop, on_points, isotropic_twin):
        refused(make, "plywood", told=r"CollectionLoop\.mit.*not 'plywood'")
    refused(compare_dynamics, loop, [0.0], told=r"DynamicLoop\(loop\).*not a CollectionLoop")
    refused(compared(False).difference, "foo", told="'foo': choose one of push_turn")
