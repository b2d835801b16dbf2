"""Cycles on an even grid: their derivatives are those of the mechanics, and the grid knows what it does not resolve."""

import math

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import DragBack, SidePush
from cyclemap.resets.parameters.parameter_samples import (
    CycleSampler,
    CycleSamples,
    even_orientations,
    trigonometric_interpolation,
)
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.drag_strategies import RingPlace

LOOP = CollectionLoop.mit(accuracy=1e-10)
QUICK = CollectionLoop.mit(accuracy=1e-6)
PUSH = SidePush(1, 0.6, 0.1, 0.06)
POINTS = ((0.05, 0.03), (0.04, -0.02))
MOVING = ("fraction", "angle", "distance", "hitch_x", "hitch_y", "way_1_x", "way_2_y")
SAMPLES = 8


def _moved(name, by):
    """Loop and action with one number changed."""
    push = {part: getattr(PUSH, part) + by * (part == name) for part in ("fraction", "angle", "distance")}
    hitch = np.array(LOOP.slider.hitch) + by * np.array([name == "hitch_x", name == "hitch_y"])
    points = np.array(POINTS) + by * np.array([[name == f"way_{k}_{axis}" for axis in "xy"] for k in (1, 2)])
    loop = RingPlace(tuple(hitch)).prepared(LOOP)
    return CycleAction(tuple(map(tuple, points)), SidePush(1, **push)).on(loop)


@pytest.fixture(scope="module")
def sampled():
    return CycleSampler(SAMPLES).sampled(LOOP, CycleAction(POINTS, PUSH), MOVING)


@pytest.mark.parametrize("name", [*MOVING, "way_1_y", "way_2_x"])
def test_tangents_are_finite_differences_of_recomputed_cycles(sampled, name):
    """By push, ring and way-points: to 2e-5 of the largest, in orientation and in the drag's length."""
    step, theta = 1e-5, even_orientations(SAMPLES)[[1, 4]]
    below, above = _moved(name, -step).cycles(theta), _moved(name, step).cycles(theta)
    column = sampled.names.index(name)
    for found, low, high in (
        (sampled.turn_by, below.theta_next, above.theta_next),
        (sampled.length_by, below.drag_length, above.drag_length),
    ):
        slope = (high - low) / (2.0 * step)
        assert np.abs(found[[1, 4], column] - slope).max() < 2e-5 * max(1.0, np.abs(slope).max())


def test_samples_are_the_loops_own_cycles_and_slopes(sampled):
    loop = CycleAction(POINTS, PUSH).on(LOOP)
    theta = even_orientations(SAMPLES)
    cycles = loop.cycles(theta)
    assert np.abs(theta + sampled.turn - cycles.theta_next).max() < 1e-12
    assert np.abs(sampled.length - cycles.drag_length).max() < 1e-15
    assert sampled.names[0] == "theta" and sampled.turn_by.shape == (SAMPLES, 10)


def test_without_way_points_tangents_are_the_loops_sensitivity():
    """The other implementation: `CollectionLoop.sensitivity`, of the whole cycle at once, with friction in the ring."""
    loop = CollectionLoop.mit("abs", push=PUSH, reset=DragBack(pin_friction_radius=0.001))
    sampler = CycleSampler(SAMPLES)
    found = sampler.sampled(loop, CycleAction().filled(loop), MOVING)
    assert found.names == ("theta", "fraction", "angle", "distance", "hitch_x", "hitch_y")
    for index, theta in enumerate(even_orientations(SAMPLES).tolist()):
        known = loop.sensitivity(theta, found.names)
        by_theta = known.jacobian[-1] - np.eye(len(found.names))[0]
        assert np.abs(found.turn_by[index] - by_theta).max() < 1e-10
        assert np.abs(found.length_by[index] - known.jacobian[-2]).max() < 1e-12
    assert sampler.cycles == SAMPLES


def test_actions_that_share_a_push_share_its_run_and_nothing_is_run_twice():
    sampler = CycleSampler(SAMPLES)
    for points in ((), POINTS, POINTS[:1], POINTS):
        sampler.sampled(QUICK, CycleAction(points, PUSH), ("way_1_x",))
    assert sampler.cycles == 3 * SAMPLES and len(sampler._pushes) == SAMPLES


def test_loops_that_differ_in_more_than_the_ring_are_told_apart():
    """The same action with the same ring on another material is another cycle, whatever was run before."""
    sampler, other = CycleSampler(SAMPLES), CollectionLoop.mit("abs", accuracy=1e-6)
    before, after = (sampler.sampled(loop, CycleAction((), PUSH), ()) for loop in (QUICK, other))
    own = CycleAction((), PUSH).on(other).next_theta(even_orientations(SAMPLES)) - even_orientations(SAMPLES)
    assert np.abs(after.turn - own).max() < 1e-12 and np.abs(after.turn - before.turn).max() > 1e-3


def test_a_way_point_where_the_ring_already_is_has_no_derivative():
    """The leg has no length, and which way it would grow is not said: nan, which gradients tell from a number."""
    theta = float(even_orientations(SAMPLES)[2])
    push = QUICK.model.push(QUICK.start_pose(theta), PUSH)
    there = QUICK.model.ring_place(push.end)
    found = CycleSampler(SAMPLES).sampled(QUICK, CycleAction((there,), PUSH), ("way_1_x", "fraction"))
    assert np.isnan(found.turn_by[2, 2:]).all() and np.isfinite(found.turn_by[2, :2]).all()
    assert np.isfinite(np.delete(found.turn_by, 2, axis=0)).all()


@pytest.mark.parametrize("count", [15, 16])
def test_the_interpolant_of_a_trigonometric_polynomial_is_itself(count):
    theta, fine = even_orientations(count), 2.0 * math.pi * np.arange(37) / 37
    for order in range(count // 2):
        wave = np.cos(order * theta - 0.3)
        assert np.abs(trigonometric_interpolation(count, 37) @ wave - np.cos(order * fine - 0.3)).max() < 1e-13


def _by_hand(turn, slope):
    return CycleSamples(("theta",), turn, np.ones_like(turn), slope[:, None], np.zeros((turn.size, 1)))


def test_the_interpolation_error_bounds_the_true_one_where_smooth_and_shows_a_jump():
    """Of turn = a sin 3 theta the cubics are off by a (3 h)^4/384 at most; a jump by 1 rad leaves more than 0.05."""
    theta = even_orientations(48)
    smooth = _by_hand(0.2 * np.sin(3.0 * theta), 0.6 * np.cos(3.0 * theta))
    step = 2.0 * math.pi / 48
    assert 0.5 < smooth.interpolation_error / (0.2 * (3.0 * step) ** 4 / 384.0) <= 1.0 + 1e-6
    jump = _by_hand(np.where(theta < 2.0, 0.0, 1.0) - theta / (2.0 * math.pi), np.full(48, -1.0 / (2.0 * math.pi)))
    assert jump.interpolation_error > 0.05


def test_too_few_orientations_are_refused():
    with pytest.raises(InvalidInput, match="samples must be at least 8"):
        even_orientations(7)
