"""Actions are computed once for all strategies that use them, and come out as they do by themselves."""

import math

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import UniformNoise, WrappedNormal
from cyclemap.maps.mixtures.independent_sum import IndependentSum
from cyclemap.mechanics import SidePush
from cyclemap.resets.design.action_cache import ActionCache, even_turn
from cyclemap.resets.strategies.action_cost import strategy_cost
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.drag_strategies import GripperTurn, RingPlace, StraightReset
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, DrawnPushes, side_pushes
from cyclemap.resets.strategies.schedules import GoldenAngle, LatinBlocks
from cyclemap.resets.strategies.spread import Spread

NOISE = WrappedNormal(0.1)
PUSHES = side_pushes(SidePush(), (0, 2))


@pytest.fixture(scope="module")
def cache() -> ActionCache:
    return ActionCache(CollectionLoop.mit(), NOISE, tolerance=1e-2, orientations=3)


def test_strategies_share_the_maps_of_the_actions_they_have_in_common(cache) -> None:
    straight = cache.kernel(StraightReset()).maps
    assert cache.computed == 1
    drawn = cache.kernel(DrawnPushes(PUSHES, weights=(1.0, 3.0)))
    assert cache.computed == 2 and drawn.maps[0] is straight[0]
    assert drawn.weights.tolist() == [0.25, 0.75]
    turns = cache.kernel(AlternatingPushes(PUSHES))
    assert cache.computed == 2 and turns.maps == drawn.maps and turns.alternates
    fine = cache.finer(1e-3)
    assert fine.computed == 0 and fine.cost(StraightReset()) == cache.cost(StraightReset())


def test_a_ring_at_another_place_shares_no_map_with_the_loops_own(cache) -> None:
    before = cache.computed
    moved = cache.kernel(RingPlace((0.0, 0.02)))
    assert cache.computed == before + 1
    assert moved.maps[0] is not cache.kernel(StraightReset()).maps[0]


def test_a_map_that_was_computed_elsewhere_is_used(cache) -> None:
    given, push = cache.kernel(StraightReset()).maps[0], SidePush(side=1)
    cache.put(cache.loop, CycleAction(push=push), given)
    assert cache.kernel(DrawnPushes((push,))).maps == (given,)


def test_costs_are_those_of_strategy_cost(cache) -> None:
    strategy = DrawnPushes(PUSHES, weights=(1.0, 3.0))
    mine, whole = cache.cost(strategy), strategy_cost(cache.loop, strategy, orientations=3)
    for name in ("mean_drag_length", "longest_drag", "mean_seconds", "rod_reach", "object_reach"):
        assert getattr(mine, name) == pytest.approx(getattr(whole, name), rel=1e-12), name


def test_a_gripper_that_turns_by_anything_leaves_the_even_law_after_one_push(cache) -> None:
    found = cache.kernel(GripperTurn()).numbers(within=3, near=0.01)
    assert found.tv < 1e-12 and found.reach == 1.0
    assert cache.cost(GripperTurn()).mean_seconds == pytest.approx(cache.cost(StraightReset()).mean_seconds + 10.0)


@pytest.mark.parametrize(
    ("strategy", "law"),
    [
        (GripperTurn(Spread.within(0.0, 0.4)), UniformNoise(0.4)),
        (GripperTurn(), UniformNoise(math.pi)),
        (GripperTurn(0.4), None),
        (GripperTurn(Spread(0.0, 0.4)), None),
        (GripperTurn(schedule=GoldenAngle()), None),
        (GripperTurn(schedule=LatinBlocks(4, jitter=False)), None),
        (StraightReset(), None),
    ],
)
def test_only_an_even_turn_about_none_that_is_drawn_independently_is_noise(strategy, law, cache) -> None:
    assert even_turn(strategy) == law
    if law is not None:
        noise = cache.kernel(strategy).noise
        assert isinstance(noise, IndependentSum) and noise.parts == (NOISE, law)


def test_a_turn_that_is_noise_is_the_limit_of_many_fixed_turns(cache) -> None:
    """Two routes: the turn as noise, and as the mixture of the law's nodes, each map raised by its turn."""
    turn = GripperTurn(Spread(-0.9, 0.9 + 1e-9))
    assert even_turn(turn) is None
    nodes = cache.kernel(turn, nodes=48).numbers(within=5, near=0.5)
    noise = cache.kernel(GripperTurn(Spread.within(0.0, 0.9))).numbers(within=5, near=0.5)
    assert nodes.tv == pytest.approx(noise.tv, abs=1e-3)
    assert np.abs(nodes.law.moments[1:4] - noise.law.moments[1:4]).max() < 1e-3


@pytest.mark.parametrize("noise", [None, 0.02, UniformNoise(0.1)])
def test_noise_that_leaves_no_smooth_law_is_refused(noise) -> None:
    with pytest.raises(InvalidInput, match="give a smooth law"):
        ActionCache(CollectionLoop.mit(), noise)
