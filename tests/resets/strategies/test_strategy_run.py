"""Runs of a strategy by the full mechanics: the recursion they claim, and the seed's part in it."""

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.wearing_loop import worn_loop
from cyclemap.errors import InvalidInput
from cyclemap.maps import WrappedNormal
from cyclemap.mechanics import SidePush
from cyclemap.resets.strategies.combined import combine
from cyclemap.resets.strategies.drag_strategies import GripperTurn, RingPlace, StraightReset, TrailingLeg
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, DrawnPushes, side_pushes
from cyclemap.resets.strategies.schedules import GoldenAngle
from cyclemap.resets.strategies.strategy_maps import strategy_maps
from cyclemap.resets.strategies.strategy_run import run_strategy

LOOP = CollectionLoop.mit("plywood", accuracy=1e-6)
ALL_AT_ONCE = combine(
    RingPlace((0.0, 0.012)), DrawnPushes(side_pushes(SidePush(), (0, 2))), TrailingLeg(0.04), GripperTurn(0.2)
)


def test_a_run_follows_the_loops_that_its_actions_make():
    run = run_strategy(LOOP, ALL_AT_ONCE, 6, start=0.3, noise=WrappedNormal(0.05), seed=2)
    assert run.actions == ALL_AT_ONCE.actions(6, 2) and run.cycles == 6 and run.theta[0] == 0.3
    prepared, kicks = ALL_AT_ONCE.prepared(LOOP), []
    for n, action in enumerate(run.actions):
        cycle = action.on(prepared).cycle(run.theta[n])
        kicks.append(run.theta[n + 1] - cycle.theta_next - 0.2)
        found = run.push_turn[n], run.drag_turn[n], run.drag_length[n], run.gripper_turn[n]
        assert found == (cycle.push_turn, cycle.drag_turn, cycle.drag_length, 0.2)
        assert run.left[n] == (cycle.ended == "left")
    assert 0.005 < np.std(kicks) < 0.15 and len({action.push.side for action in run.actions}) == 2


def test_the_same_seed_gives_the_same_run_and_no_noise_none():
    one, two, other = (run_strategy(LOOP, TrailingLeg(0.04), 3, seed=seed) for seed in (1, 1, 2))
    assert np.array_equal(one.theta, two.theta) and not np.array_equal(one.theta, other.theta)
    assert np.allclose(np.diff(one.theta), one.push_turn + one.drag_turn, atol=1e-12)
    with pytest.raises(ValueError, match="read-only"):
        one.theta[0] = 1.0


def test_noise_is_drawn_beside_the_schedule():
    """With and without noise the robot does the same; and the noise is that of the seed whatever the strategy."""
    noise = WrappedNormal(0.05)
    still, shaken = (run_strategy(LOOP, TrailingLeg(0.04), 2, noise=law, seed=5) for law in (None, noise))
    straight = run_strategy(LOOP, StraightReset(), 2, noise=noise, seed=5)
    assert still.actions == shaken.actions
    first = [run.theta[1] - run.theta[0] - run.push_turn[0] - run.drag_turn[0] for run in (still, shaken, straight)]
    assert abs(first[0]) < 1e-12 < abs(first[1]) and abs(first[1] - first[2]) < 1e-12


def test_the_maps_go_the_way_of_the_full_mechanics():
    """Ten alternating cycles through the two maps of the law, against the run: errors of the maps add up to little."""
    strategy = combine(AlternatingPushes(side_pushes(SidePush(distance=0.05), (0, 1))), TrailingLeg(0.05, 1.0))
    maps, run = strategy_maps(LOOP, strategy, tolerance=1e-3).maps, run_strategy(LOOP, strategy, 10)
    theta = 0.0
    for n in range(10):
        theta = float(maps[n % 2](theta))
    assert len(maps) == 2 and abs(theta - run.theta[-1]) < 5e-3


def test_a_surface_that_wears_does_so():
    loop = CollectionLoop.mit("plywood-measured", accuracy=1e-6)
    run = run_strategy(loop, TrailingLeg(0.03, schedule=GoldenAngle()), 3)
    worn = run.actions[2].on(worn_loop(loop, 2)).cycle(run.theta[2])
    fresh = run.actions[2].on(loop).cycle(run.theta[2])
    assert worn.push_turn == run.push_turn[2] != fresh.push_turn


def test_bad_input_is_refused_and_a_failing_cycle_named():
    with pytest.raises(InvalidInput, match="cycles must be at least 1"):
        run_strategy(LOOP, StraightReset(), 0)
    with pytest.raises(InvalidInput, match="seed must be at least 0"):
        run_strategy(LOOP, StraightReset(), 1, seed=-1)
    with pytest.raises(InvalidInput, match=r"noise is 0\.1"):
        run_strategy(LOOP, StraightReset(), 1, noise=0.1)
    with pytest.raises(InvalidInput, match="cycle 1, from theta0 = "):
        run_strategy(LOOP, AlternatingPushes(side_pushes(SidePush(), (0, 9))), 2)
