"""What an action costs: lengths and times from first principles, reach against finer courses and the geometry."""

import math

import numpy as np
import pytest

from cyclemap.collection.cycle_scene import placed
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import EllipseFriction, Material, SidePush, Slider
from cyclemap.resets.strategies.action_cost import CycleCost, Pace, action_cost, strategy_cost
from cyclemap.resets.strategies.combined import combine
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.drag_strategies import GripperTurn, StraightReset, TrailingLeg
from cyclemap.resets.strategies.shared_strokes import run_action

LOOP = CollectionLoop.mit("plywood", accuracy=1e-6)
EVEN = CollectionLoop.mit(Material("even", EllipseFriction.isotropic(0.25)), accuracy=1e-6)


@pytest.mark.parametrize("shape", ["rect3", "tri3", "hex", "ellip3"])
def test_the_object_reaches_no_further_than_stated_but_for_a_fifth_of_a_millimetre(shape):
    """Against courses with ten times as many samples."""
    loop = CollectionLoop.mit("plywood", slider=Slider.mit(shape), accuracy=1e-6)
    action = CycleAction(((0.04, 0.02),), SidePush(0, 0.6, 0.0, 0.1))
    cost, true = action_cost(loop, action, 0.9), 0.0
    for stroke in run_action(loop, action, 0.9, 0.0004):
        places = placed(stroke.trajectory.pose.T[:, :, None], loop.slider.outline_points(1000))
        true = max(true, float(np.hypot(places[..., 0], places[..., 1]).max()))
    assert cost.object_reach <= true + 1e-6 and true - cost.object_reach < 2e-4
    assert cost.reach == max(cost.object_reach, cost.rod_reach)


def test_the_rod_reaches_the_end_of_its_push_and_every_way_point():
    far = action_cost(LOOP, CycleAction(((0.0, 0.4),)), 0.0)
    assert abs(far.rod_reach - (0.4 + LOOP.pusher.radius)) < 1e-12
    # MIT's push from theta 0: the rod's centre starts at (-18, 49.75) mm less the ring's place and goes 150 mm down.
    x, y = (-0.018 - LOOP.slider.hitch[0], 0.045 + LOOP.pusher.radius - LOOP.slider.hitch[1])
    near = action_cost(LOOP, CycleAction(), 0.0)
    assert abs(near.rod_reach - math.hypot(x, y - 0.15) - LOOP.pusher.radius) < 1e-9


def test_time_is_travel_over_speed_and_the_handling():
    pace = Pace(0.05, 3.0, 7.0)
    action = CycleAction(((0.05, 0.0),), turn=0.1)
    cost = action_cost(LOOP, action, 1.0, pace)
    assert abs(cost.seconds - ((0.15 + cost.drag_length) / 0.05 + 10.0)) < 1e-12
    assert pace.seconds(0.5, CycleAction()) == 13.0
    assert action_cost(LOOP, CycleAction(((0.05, 0.0),)), 1.0).drag_length == cost.drag_length


def test_on_an_even_surface_the_straight_reset_costs_the_same_from_everywhere():
    costs = [action_cost(EVEN, CycleAction(), theta) for theta in (0.0, 1.0, 4.0)]
    table = np.array([(c.drag_length, c.seconds, c.rod_reach, c.object_reach) for c in costs])
    assert np.ptp(table, axis=0).max() < 1e-5
    whole = strategy_cost(EVEN, StraightReset(), orientations=2)
    assert abs(whole.mean_drag_length - 0.09791241) < 1e-6 and abs(whole.longest_drag - whole.mean_drag_length) < 1e-6


def test_the_cost_of_a_strategy_is_the_mean_and_the_largest_over_law_and_orientations():
    strategy = combine(TrailingLeg(0.05), GripperTurn(0.2))
    cost = strategy_cost(LOOP, strategy, orientations=3, nodes=4)
    law, starts = strategy.law(4), 2.0 * math.pi * np.arange(3) / 3
    singles = [action_cost(LOOP, action, start) for action in law.actions for start in starts]
    assert len(singles) == 12 and all(isinstance(one, CycleCost) for one in singles)
    assert abs(cost.mean_drag_length - np.mean([one.drag_length for one in singles])) < 1e-12
    assert abs(cost.mean_seconds - np.mean([one.seconds for one in singles])) < 1e-9
    assert cost.longest_drag == max(one.drag_length for one in singles)
    assert cost.reach == max(one.reach for one in singles)
    # Two legs are longer than one, and shorter than both of their sides together.
    straight = strategy_cost(LOOP, StraightReset(), orientations=3).mean_drag_length
    assert straight < cost.mean_drag_length < straight + 0.1


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: Pace(0.0), "speed must be positive"),
        (lambda: Pace(handling=-1.0), "handling time must not be negative"),
        (lambda: action_cost(LOOP, CycleAction(), math.nan), "theta must be a finite number"),
        (lambda: strategy_cost(LOOP, StraightReset(), orientations=0), "orientations must be at least 1"),
        (lambda: strategy_cost(LOOP, "leg"), "no reset strategy"),
    ],
)
def test_bad_values_are_refused(call, match):
    with pytest.raises(InvalidInput, match=match):
        call()
