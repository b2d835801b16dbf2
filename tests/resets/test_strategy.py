"""Strategies: what is drawn, in which order, and what is refused."""

import math
import pickle

import numpy as np
import pytest
from refusals import refused

import cyclemap as cm
from cyclemap.protocol.strategy import one_loop, overruled_settings
from cyclemap.resets import CycleAction, ResetStrategy, gripper_turns, legs

LOOP = cm.CollectionLoop.mit()
PUSHES = tuple(CycleAction(push=cm.SidePush(side)) for side in (0, 1, 2))


def test_random_actions_come_as_often_as_their_shares_say_and_know_nothing_of_each_other() -> None:
    """Counts and pairs of 30,000 draws within four standard deviations."""
    drawn = ResetStrategy(PUSHES, (1.0, 2.0, 5.0)).drawn(30_000, seed=3)
    expected = np.array([1.0, 2.0, 5.0]) / 8.0
    pairs = np.bincount(3 * drawn[:-1] + drawn[1:], minlength=9).reshape(3, 3) / drawn.size
    for found, chance in ((pairs.sum(axis=1), expected), (pairs, np.outer(expected, expected))):
        assert np.all(np.abs(found - chance) < 4 * np.sqrt(chance / drawn.size))


def test_shuffled_blocks_hold_every_action_as_often_as_its_share_says() -> None:
    strategy = ResetStrategy(PUSHES, (1.0, 2.0, 3.0), "shuffled")
    drawn = strategy.drawn(600, seed=1).reshape(-1, 6)
    assert np.all(np.sort(drawn, axis=1) == [0, 1, 1, 2, 2, 2])
    assert len({tuple(row) for row in drawn.tolist()}) > 30
    assert ResetStrategy(PUSHES, order="shuffled", block=9).drawn(9).tolist().count(2) == 3
    assert ResetStrategy(PUSHES, order="in turn").drawn(7, seed=5).tolist() == [0, 1, 2, 0, 1, 2, 0]


@pytest.mark.parametrize("order", ["random", "shuffled"])
def test_the_same_seed_draws_the_same_and_a_longer_run_begins_alike(order) -> None:
    strategy = ResetStrategy(PUSHES, order=order)
    assert strategy.run(50, seed=2) == strategy.run(50, seed=2) != strategy.run(50, seed=3)
    if order == "random":
        assert strategy.run(80, seed=2)[:50] == strategy.run(50, seed=2)


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"actions": ()}, "one CycleAction or more"),
        ({"actions": (3,)}, "one CycleAction or more"),
        ({"order": "sobol"}, "order is 'sobol'"),
        ({"weights": (1.0,)}, "3 actions need as many weights, not 1"),
        ({"weights": (1.0, 0.0, 1.0)}, "weight of an action must be positive"),
        ({"weights": (1.0, 2.0, 1.0), "order": "in turn"}, "list one twice"),
        ({"block": 6}, "belongs to the order 'shuffled'"),
        ({"order": "shuffled", "block": 7}, "no block of 7 pushes gives shares"),
        ({"order": "shuffled", "block": 1_000_000_000}, "a block of 1000000000 pushes is larger"),
        ({"order": "shuffled", "weights": (math.pi, 1.0, 1.0)}, "no block of 10000"),
        # An action that comes in no block.
        ({"order": "shuffled", "weights": (1.0, 1.0, 1e-12)}, "no block of 10000 pushes"),
        ({"actions": PUSHES * 4000}, "12000 actions are more than 10000"),
        ({"hitch": (math.nan, 0.0)}, "hitch must be two finite numbers"),
    ],
)
def test_what_is_no_strategy_is_refused_by_name(fields, said) -> None:
    refused(ResetStrategy, **{"actions": PUSHES, **fields}, told=said)


def test_more_draws_than_there_is_room_for_are_refused() -> None:
    refused(ResetStrategy(PUSHES).drawn, 10**12, told="more than 10000000: ask for fewer at a time")


def test_equal_weights_are_no_weights_and_strategies_are_values() -> None:
    assert ResetStrategy(PUSHES, (2.0, 2.0, 2.0)) == ResetStrategy(PUSHES)
    weighed = ResetStrategy(PUSHES, (1.0, 2.0, 3.0))
    assert pickle.loads(pickle.dumps(weighed)) == weighed
    assert ResetStrategy(PUSHES, (1e308, 1e308, 5e307)).shares == pytest.approx([0.4, 0.4, 0.2])


def test_a_strategy_that_does_the_same_in_every_cycle_is_a_loop_and_others_are_not() -> None:
    leg = ResetStrategy(legs(0.05, 4)[1:2], hitch=(0.01, 0.02))
    made = one_loop(LOOP, leg)
    assert made is not None and made.slider.hitch == (0.01, 0.02)
    assert made.reset.way_points[0] == pytest.approx((0.0, 0.05), abs=1e-15)
    assert one_loop(LOOP, ResetStrategy(PUSHES)) is None
    assert one_loop(LOOP, ResetStrategy(gripper_turns(4)[1:2])) is None
    assert leg.needs == ("ring",) and ResetStrategy(gripper_turns(4)).needs == ("gripper",)
    assert overruled_settings(leg) == ("way_points_mm", "hitch_x_mm", "hitch_y_mm")
    assert overruled_settings(ResetStrategy(PUSHES)) == ("side", "fraction", "angle_deg", "push_mm")
