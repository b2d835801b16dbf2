"""The numerical experiment: batches end at the map's stable point; in the object's frame isotropic
paths are one.
"""

import math
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
)
from cyclemap.collection.batch_experiment import REST, run_batches
from cyclemap.collection.dynamic_loop import on_points
from cyclemap.mechanics import EllipseFriction, Material


@cache
def still() -> BatchExperiment:
    """Quasi-static, on the exact footprint, short."""
    return batch_experiment(replace(CollectionLoop.mit(), accuracy=1e-6), batches=3, cycles=4)


def test_quasi_static_batches_end_at_the_stable_point_of_the_grids_map():
    """An independent solver puts it at 61.45 degrees with multiplier 0.891."""
    loop = replace(on_points(CollectionLoop.mit()), accuracy=1e-6)
    run = run_batches(loop, np.radians([55.0, 65.0]), cycles=36)
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
    run = run_batches(DynamicLoop(CollectionLoop.mit()), np.radians([58.5, 61.5]), cycles=5)
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
    run = run_batches(loop, [0.5, 1.3, 2.9], cycles=2)
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
    refused(run_batches, loop, [0.0], cycles=0, told="cycles")
    for size in ({"batches": 2, "cycles": 10**13}, {"batches": 10**13, "cycles": 1}):
        refused(batch_experiment, loop, told="run fewer batches or cycles", **size)
    refused(run_batches, loop, [0.0], cycles=10**13, told="run fewer batches or cycles")
    for run in (batch_experiment, lambda loop: run_batches(loop, [0.0])):
        refused(run, "plywood", told=r"CollectionLoop\.mit.*not 'plywood'")
    refused(run_batches, loop, [], told="at least one orientation")
    batch_experiment(replace(on_points(loop), accuracy=1e-4), 2, 2, told.append)
    assert told == pytest.approx(np.arange(1, 9) / 8)
