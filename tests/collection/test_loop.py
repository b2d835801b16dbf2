"""The collection loop: its cycles, one by one and many, their derivatives, and where their map
comes to rest.
"""

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from refusals import refused
from scipy.optimize import brentq

from cyclemap.collection import CollectionLoop, Cycles, run_cycles
from cyclemap.mechanics import Pusher, SidePush, Slider, WorldPush, grid_footprint

MIT = CollectionLoop.mit()


def test_a_cycle_starts_and_ends_with_its_ring_at_the_target():
    """Its turns add, and whole turns of the start change nothing but the lift."""
    for theta in (-2.0, 0.0, 9.1):
        cycle = MIT.cycle(theta)
        for pose in (cycle.push.start, cycle.drag.end):
            assert np.allclose(pose.to_world(*MIT.model.slider.hitch), 0.0, atol=1e-16)
        assert cycle.push.start.theta == theta
        assert cycle.theta_next == cycle.drag.end.theta
        assert abs(theta + cycle.push_turn + cycle.drag_turn - cycle.theta_next) < 1e-14
        assert (
            abs(MIT.cycle(theta + 6 * math.pi).theta_next - cycle.theta_next - 6 * math.pi) < 1e-8
        )


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
        refused(MIT.cycle, theta, told="theta")
    refused(MIT.sensitivity(0.0).by, "mass", told="no derivative of 'theta_next' by 'mass'")
    refused(MIT.sensitivity, 0.0, ("theta", "mu_c"), told="unknown parameter 'mu_c'")
    refused(replace(MIT, push=SidePush(side=7)).cycle, 0.0, told="sides 0 to 3")
    refused(CollectionLoop.mit, "plywod", told="did you mean 'plywood'")
    for name in ("slider", "material", "pusher", "push", "reset", "footprint"):
        refused(replace, MIT, told=f"{name} must be a .*, not 5", **{name: 5})
    refused(CollectionLoop.mit, "plywood", push=5, told="push must be a SidePush, not 5")
    refused(CollectionLoop.mit, "plywood", slider=5, told="slider must be a Slider, not 5")
    refused(MIT.with_material, 5, told="material must be a Material, not 5")
    for names in (5, "theta"):
        refused(MIT.sensitivity, 0.0, names, told="parameters must be a tuple or a list, not")
    refused(MIT.sensitivity, 0.0, (5,), told="unknown parameter 5")
    cycles = MIT.cycles([[0.0, 1.0]])
    refused(cycles.to_dataset, "a", "a", told="'a', 'a'. must differ: give each axis its own")
    refused(cycles.to_dataset, "a", 5, told="name of an axis must be a str, not 5")
    refused(MIT.next_theta, [0.0, float("inf")], told="finite")
    refused(WorldPush, (0.0, 0.0), 0.0, -1.0)


def plywood(ring_mm=15.0, grid=None):
    """MIT's loop on plywood with the ring at a distance from the centre,
    towards the same corner."""
    lever = ring_mm * 1e-3 / math.sqrt(2.0)
    slider = Slider.mit("rect1", hitch=(-lever, lever))
    footprint = grid_footprint(slider.outline, grid) if grid else None
    return CollectionLoop.mit(slider=slider, footprint=footprint)


def turn_deg(loop, theta_deg):
    return math.degrees(loop.cycle(math.radians(theta_deg)).theta_next) - theta_deg


@pytest.mark.parametrize(
    ("ring_mm", "stable_deg", "unstable_deg", "within_deg"),
    [(15.0, 61.45, 200.2, 0.05), (13.0, 97.5, 193.4, 0.1), (10.0, 151.0, 172.0, 0.6)],
)
def test_fixed_points_of_the_8x8_grid(ring_mm, stable_deg, unstable_deg, within_deg):
    """On the paper's grid the fixed points lie where the independent solver found them."""
    loop = replace(plywood(ring_mm, grid=8), accuracy=1e-6)
    for expected in (stable_deg, unstable_deg):
        found = brentq(
            lambda theta: turn_deg(loop, theta), expected - 3.0, expected + 3.0, xtol=1e-4
        )
        assert found == pytest.approx(expected, abs=within_deg)


def test_stated_error_of_the_plywood_map_holds():
    """At 40 random orientations the map is within its stated error of single, finer cycles."""
    loop = plywood()
    circle = loop.circle_map(tolerance=1e-6)
    theta = np.random.default_rng(11).uniform(0.0, 2.0 * np.pi, 40)
    error = np.abs(circle(theta) - replace(loop, accuracy=1e-10).next_theta(theta))
    assert error.max() <= circle.max_error <= 1e-6


THETA = np.array([-4.0, 0.5, 2.0, 7.0])


def same(one: Cycles, other: Cycles) -> None:
    for field in fields(Cycles):
        np.testing.assert_allclose(
            getattr(one, field.name), getattr(other, field.name), rtol=0.0, atol=1e-11
        )


def taken(cycles: Cycles, *index) -> Cycles:
    return Cycles(*(getattr(cycles, field.name)[index] for field in fields(Cycles)))


def test_orientations_are_each_loops_own_or_everyones():
    loops, order = (
        [MIT, CollectionLoop.mit("delrin", pusher=Pusher(0.0), accuracy=1e-7)],
        [3, 0, 2, 1],
    )
    common = run_cycles(loops, THETA)
    assert common.push_displacement.shape == (2, 4, 2) and common.left.dtype == bool
    for number, loop in enumerate(loops):
        same(taken(common, number), loop.cycles(THETA))
        one = loop.cycle(THETA[1])
        assert (common.theta_next[number, 1], common.left[number, 1]) == (
            one.theta_next,
            one.ended == "left",
        )
    same(run_cycles(loops, np.stack([THETA, THETA])), common)
    crossed = run_cycles(loops, np.stack([THETA, THETA[order]]))
    same(taken(crossed, 0), taken(common, 0))
    same(taken(crossed, 1), taken(common, 1, order))


def test_nothing_to_run_is_no_cycles():
    assert MIT.cycles([]).theta_next.shape == (0,) and MIT.next_theta(0.5).shape == ()
    assert run_cycles([], THETA).theta.shape == (0, 4)
    assert run_cycles([MIT], np.zeros(0)).push_displacement.shape == (1, 0, 2)


def test_what_is_no_batch_is_refused():
    """A cycle's refusal is told as that of the cycle, with the number of its loop."""
    for loops, theta, told in (
        ([MIT, "plywood"], [0.0], "must be a CollectionLoop, such as .*, not 'plywood'"),
        (MIT, [0.0], "loops must be a sequence, such as .*, not Collection"),
        (iter([MIT]), [0.0], "loops must be a sequence"),
        (5, [0.0], "loops must be a sequence, such as .*, not 5"),
        ([MIT], 0.0, r"shape \(n,\) for all loops or \(1, n\), one row a loop, not \(\)"),
        ([MIT, MIT], np.zeros((3, 2)), r"or \(2, n\), one row a loop, not \(3, 2\)"),
        ([MIT], [math.nan], "theta must be finite"),
    ):
        refused(run_cycles, loops, theta, told=told)
    side, rough = replace(MIT, push=SidePush(side=9)), replace(MIT, accuracy=1.0)
    for loop, told in ((side, "side 9 does not exist"), (rough, "accuracy 1.0 is out of reach")):
        refused(loop.cycle, 2.0, told=told)
        refused(run_cycles, [MIT, loop], [2.0, 3.0], told=f"loop 1: .*{told}")
