"""One cycle's action: what it changes, how it turns with the surface, how two go together."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import DragBack, SidePush
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.shared_strokes import SharedStrokes, run_action

LOOP = CollectionLoop.mit("plywood", accuracy=1e-6)
ACTIONS = (
    CycleAction(),
    CycleAction(((0.05, 0.02),)),
    CycleAction(((0.05, 0.0), (-0.03, 0.04)), SidePush(1, 0.4, 0.2, 0.1)),
)


@pytest.mark.parametrize("action", ACTIONS)
def test_an_action_runs_as_the_loop_that_it_makes(action):
    """On the shared model of the loop, and with shared pushes, the same numbers as a loop made anew."""
    acted, strokes = action.on(LOOP), SharedStrokes(LOOP)
    for theta in (0.3, 4.0):
        push, drag = run_action(LOOP, action, theta)
        wanted = acted.sensitivity(theta, ("theta",))
        assert drag.end.theta == wanted.theta_next and push.turn == acted.cycle(theta).push_turn
        end, slope, length = strokes.sample(action, theta)
        assert end == wanted.theta_next and abs(slope - wanted.by_theta) < 1e-12
        assert length == acted.cycle(theta).drag_length


def test_actions_that_differ_in_their_drags_share_their_pushes():
    strokes = SharedStrokes(LOOP)
    for angle in (0.0, 1.0, 2.0):
        strokes.sample(ACTIONS[1].turned(angle), 0.5)
    assert len(strokes.pushed) == 1
    strokes.sample(ACTIONS[2], 0.5)
    assert len(strokes.pushed) == 2


def test_an_action_turned_with_its_surface_does_the_same_turned():
    """f of the turned action on the turned surface is alpha + f(theta - alpha)."""
    action, theta = ACTIONS[2], 0.4
    before = run_action(LOOP, action, theta)[1].end.theta
    for alpha in (0.7, 2.0, -1.3):
        material = replace(LOOP.material, friction=LOOP.material.friction.turned(alpha))
        after = run_action(replace(LOOP, material=material), action.turned(alpha), theta + alpha)[1].end.theta
        assert abs(after - alpha - before) < 1e-6


def test_what_is_none_stays_as_the_loop_has_it():
    loop = replace(LOOP, reset=DragBack(((0.01, 0.02),), 0.001), push=SidePush(2))
    assert CycleAction().on(loop) == loop
    straight = CycleAction(()).on(loop)
    assert straight.reset == DragBack((), 0.001) and straight.push == SidePush(2)
    assert CycleAction().filled(loop) == CycleAction(((0.01, 0.02),), SidePush(2))


def test_two_actions_go_one_after_the_other():
    first, second = CycleAction(((0.1, 0.0),), turn=0.25), CycleAction(((0.0, 0.1),), SidePush(1), 0.5)
    both = first.then(second)
    assert both == CycleAction(((0.1, 0.0), (0.0, 0.1)), SidePush(1), 0.75)
    assert CycleAction(turn=1.0).then(CycleAction()).way_points is None
    assert CycleAction(()).then(first).way_points == first.way_points
    with pytest.raises(InvalidInput, match="two pushes for one cycle"):
        second.then(second)


def test_the_last_way_point_gives_the_direction_of_the_leg():
    assert CycleAction(((1.0, 0.0), (0.0, -2.0))).leg_direction == -math.pi / 2
    assert CycleAction().leg_direction is None and CycleAction(((1.0, 0.0), (0.0, 0.0))).leg_direction is None
    np.testing.assert_allclose(CycleAction(((1.0, 0.0),)).turned(2.0).leg_direction, 2.0)


@pytest.mark.parametrize(
    ("bad", "match"),
    [
        ({"way_points": ((math.nan, 0.0),)}, "way-point must be two finite numbers"),
        ({"way_points": ((0.1, 0.2, 0.3),)}, "way-point must be two finite numbers"),
        ({"push": "side 0"}, "must be a SidePush or None"),
        ({"turn": math.inf}, "gripper turn must be a finite number"),
    ],
)
def test_bad_values_are_refused(bad, match):
    with pytest.raises(InvalidInput, match=match):
        CycleAction(**bad)
