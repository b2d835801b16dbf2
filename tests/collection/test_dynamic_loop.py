"""The dynamic loop: cycles as the quasi-static loop's, the difference that inertia makes, and its
isotropic twin; batches, which end at the map's stable point.
"""

import math
import pickle
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from refusals import refused

from cyclemap.collection import (
    BatchExperiment,
    BatchRun,
    CollectionLoop,
    DynamicLoop,
    batch_experiment,
    compare_dynamics,
    isotropic_twin,
)
from cyclemap.collection.dynamic_loop import REST, on_points, run_batches
from cyclemap.mechanics import (
    DragBack,
    EllipseFriction,
    Material,
    PatchFootprint,
    Slider,
    corner_footprint,
)
from cyclemap.progress import unheard
from cyclemap.protocol import loop_from_settings

# Four orientations: on plywood the push ends by distance at 60 and 150 degrees, the rod leaves at 0
# and 270.
THETA = np.radians([0.0, 60.0, 150.0, 270.0])


@cache
def compared():
    return compare_dynamics(DynamicLoop(CollectionLoop.mit()), THETA)


@pytest.mark.slow
def test_at_20_mm_a_second_inertia_changes_a_cycle_by_less_than_a_fifth_of_a_degree():
    found = compared()
    push, drag = (np.abs(np.degrees(found.difference(name))) for name in ("push_turn", "drag_turn"))
    assert push.shape == drag.shape == (4,)
    assert 0.01 < push.max() < 0.035 and 0.05 < drag.max() < 0.18
    place = np.hypot(*found.difference("push_displacement").T)
    assert 5e-5 < place.max() < 2.2e-4
    np.testing.assert_array_equal(found.dynamic.left, found.quasi_static.left)


def test_a_cycle_adds_up_is_the_one_of_many_and_knows_whole_turns_by_the_lift_alone():
    loop = DynamicLoop(CollectionLoop.mit())
    cycle, many = loop.cycle(THETA[1], samples=1), compared().dynamic
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
    "parts": loop_from_settings({"inner_share": 0.3, "corner_share": 0.15}),
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
    refused(compared().difference, "foo", told="'foo': choose one of push_turn")


@cache
def still() -> BatchExperiment:
    """Quasi-static, on the exact footprint, short."""
    return batch_experiment(replace(CollectionLoop.mit(), accuracy=1e-6), batches=3, cycles=4)


def test_quasi_static_batches_end_at_the_stable_point_of_the_grids_map():
    """An independent solver puts it at 61.45 degrees with multiplier 0.891."""
    loop = replace(on_points(CollectionLoop.mit()), accuracy=1e-6)
    run = run_batches(loop, np.radians([55.0, 65.0]), 36, unheard)
    (direction,) = run.directions()
    assert math.degrees(direction) == pytest.approx(61.45, abs=0.03)
    steps = np.diff(run.theta[0])
    assert steps[30] / steps[29] == pytest.approx(0.891, abs=2e-3)
    settled = run.settled_after()
    assert settled.shape == (2,) and np.all((settled > 8) & (settled < 20))
    off = np.abs(run.theta - run.theta[:, -1:])
    for row, count in zip(off, settled, strict=True):
        assert row[count - 1] > math.radians(1.0) and np.all(row[count:] <= math.radians(1.0))


@pytest.mark.slow
def test_dynamic_batches_begun_on_both_sides_of_the_stable_point_close_in_on_it():
    """Inertia's -0.15 degrees a cycle shift it by that over 1 - 0.89: to 60.05 degrees."""
    run = run_batches(DynamicLoop(CollectionLoop.mit()), np.radians([58.5, 61.5]), 5, unheard)
    low, high = np.degrees(run.theta)
    assert np.all(np.diff(low) > 0.0) and np.all(np.diff(high) < 0.0)
    shrinks = np.diff(high - low) / (high - low)[:-1]
    np.testing.assert_allclose(1.0 + shrinks, 0.89, atol=0.01)
    # Where both lines of differences, taken as geometric, meet.
    ends = [row[-1] + (row[-1] - row[-2]) * 0.89 / 0.11 for row in (low, high)]
    np.testing.assert_allclose(ends, 60.06, atol=0.05)


def test_isotropic_batches_turn_on_for_ever_and_follow_one_path_in_the_objects_frame():
    run = still().isotropic
    assert run.directions() == ()
    turns = np.diff(run.theta)
    np.testing.assert_allclose(turns, turns[0, 0], atol=1e-9)
    assert run.spread < 1e-9
    assert still().anisotropic.spread > 0.01
    assert run.object_path.shape == (3, 4, 21, 2)


def test_paths_start_at_the_hitchs_lever_and_end_where_the_push_does():
    """In the robot's frame the ring starts at the target, so that the centre starts 15 mm from it.

    Isotropic paths are one in the object's frame, up to the integrator's error.
    """
    loop = DynamicLoop(CollectionLoop.mit(Material("even", EllipseFriction.isotropic(0.25))))
    run = run_batches(loop, np.array([0.5, 1.3, 2.9]), 2, unheard)
    assert run.spread < 3e-6 and np.ptp(np.diff(run.theta)) < 2e-5
    cycle = loop.cycle(0.5, samples=20)
    assert np.hypot(*run.path[0, 0, 0]) == pytest.approx(0.015, abs=1e-9)
    np.testing.assert_allclose(run.object_path[0, 0, -1], cycle.push_displacement, atol=1e-9)
    assert run.theta[0, 1] == cycle.theta_next


@pytest.mark.parametrize("shift", [0.0, 6.0])
def test_directions_join_ends_across_the_turn_and_part_those_that_differ(shift):
    ends = np.radians([359.8, 0.1, 719.9, 180.0]) + shift
    theta = np.stack([ends - 1e-5, ends], axis=1)
    run = BatchRun(theta, np.zeros((4, 1, 3, 2)))
    first, second = sorted((np.array(run.directions()) - shift + 0.5) % (2 * math.pi) - 0.5)
    assert math.degrees(first) == pytest.approx(-0.067, abs=1e-3) and second == pytest.approx(
        math.pi
    )
    moving = BatchRun(np.stack([ends - 0.01, ends], axis=1), run.path)
    assert moving.directions() == ()


def made(*rows: list[float] | np.ndarray) -> BatchRun:
    theta = np.array(rows)
    return BatchRun(theta, np.zeros((len(theta), theta.shape[1] - 1, 3, 2)))


def test_a_bottleneck_without_a_fixed_point_is_no_direction_anywhere_on_its_way():
    """theta + epsilon + min(theta^2, 0.01) turns least at 0, by epsilon: for long by less than 0.1
    degrees a cycle.
    """
    slow = 0
    for epsilon_deg in (0.01, 0.03, 0.06):
        theta = [-0.1]
        for end in range(300):
            theta.append(theta[-1] + math.radians(epsilon_deg) + min(theta[-1] ** 2, 0.01))
            run = made(theta)
            slow += run.last_step[0] < math.radians(0.1)
            assert end < 2 or run.directions() == ()
    assert slow > 200


def test_geometric_steps_count_once_what_they_leave_is_small_and_it_is_what_they_leave():
    for rate in (0.5, 0.95, -0.9):
        theta = 1.0 + 0.3 * rate ** np.arange(300)
        left = np.array([made(theta[: end + 1]).left[0] for end in range(2, 60)])
        distance = np.abs(theta[2:60] - 1.0)
        # Steps of alternating sign are taken as of one, to be on the safe side.
        moving = np.abs(np.diff(theta)[1:59]) > REST
        assert moving.sum() > 10 and np.all(left[~moving] == 0.0)
        if rate > 0.0:
            np.testing.assert_allclose(left[moving], distance[moving], rtol=1e-6)
        assert np.all(left[moving] >= 0.999 * distance[moving])
        assert made(theta[:6]).directions() == () and made(theta).directions() == pytest.approx(
            (1.0,), abs=1e-3
        )


def test_rest_counts_even_where_steps_at_the_level_of_the_errors_grow():
    assert made([0.5, 1.0, 1.0, 1.0]).directions() == (1.0,)
    assert made([1.0, 1.0 + 1e-6, 1.0 + 1e-5]).directions() == pytest.approx((1.0,), abs=2e-5)
    # One cycle of a step above that tells nothing of where it leads.
    assert made([1.0, 1.001]).directions() == () and made([1.0, 1.001]).left[0] == math.inf


def test_batches_that_cannot_be_are_refused_and_progress_reaches_one_in_even_steps():
    loop, told = CollectionLoop.mit(), []
    refused(batch_experiment, loop, batches=0, told="batches")
    refused(batch_experiment, loop, cycles=0, told="cycles")
    for size in ({"batches": 2, "cycles": 10**13}, {"batches": 10**13, "cycles": 1}):
        refused(batch_experiment, loop, told="run fewer batches or cycles", **size)
    refused(batch_experiment, "plywood", told=r"CollectionLoop\.mit.*not 'plywood'")
    batch_experiment(replace(on_points(loop), accuracy=1e-4), 2, 2, told.append)
    assert told == pytest.approx(np.arange(1, 9) / 8)
