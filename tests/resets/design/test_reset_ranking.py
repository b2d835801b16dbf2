"""The order of strategies, and what can be had of each demand, against brute force over made-up scores."""

import math

import numpy as np
import pytest

from cyclemap.maps.estimate import Estimate
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.resets.design.reset_candidates import ResetCandidate
from cyclemap.resets.design.reset_demands import DEMANDS, ResetDemands
from cyclemap.resets.design.reset_numbers import ResetNumbers
from cyclemap.resets.design.reset_ranking import ScoredReset, outlooks, ranked
from cyclemap.resets.strategies.action_cost import StrategyCost
from cyclemap.resets.strategies.drag_strategies import GripperTurn, StraightReset

OWN_DRAG = 0.1
DEMANDS_MADE = ResetDemands(0.05, 0.05, 50, drag_ratio=1.5, reach=0.2, seconds=25.0, contact=0.06)


def scored(
    name: str, tv: float, after: float, drag: float, reach: float, seconds: float, contact=0.08, gripper=False
) -> ScoredReset:
    numbers = ResetNumbers(
        FourierLaw(np.ones(1)), Estimate(tv, math.inf), Estimate(after, math.inf), 3.0, 1.0, 50, 0.1, False
    )
    cost = StrategyCost(drag, 2 * drag, seconds, 0.5 * reach, reach)
    candidate = ResetCandidate(name, GripperTurn() if gripper else StraightReset())
    return ScoredReset.of(candidate, numbers, cost, DEMANDS_MADE, OWN_DRAG, contact)


@pytest.fixture(scope="module")
def many() -> list[ScoredReset]:
    rng = np.random.default_rng(3)
    rows = rng.uniform([0.01, 0.02, 0.05, 0.15, 20.0, 0.055], [0.09, 0.18, 0.25, 0.25, 30.0, 0.15], size=(60, 6))
    return [scored(str(i), *row.tolist(), gripper=bool(i % 4 == 0)) for i, row in enumerate(rows)]


def test_what_meets_all_comes_first_by_drag_then_what_misses_by_how_far_then_what_the_robot_cannot_do(many) -> None:
    order = ranked(
        [*many, scored("good", 0.03, 0.04, 0.12, 0.19, 24.0), scored("better", 0.04, 0.04, 0.11, 0.19, 24.0)]
    )
    able, others = order[: -len(many) // 4], order[-len(many) // 4 :]
    assert [one.lacking for one in others] == [("gripper",)] * 15 and not any(one.lacking for one in able)
    met = [one for one in able if one.meets]
    missed = able[len(met) :]
    assert [one.name for one in met if one.name in ("good", "better")] == ["better", "good"]
    assert tuple(met) == able[: len(met)]
    assert [one.cost.mean_drag_length for one in met] == sorted(one.cost.mean_drag_length for one in met)
    far = [sum(abs(math.log(miss.value / miss.limit)) for miss in one.misses) for one in missed]
    assert len(missed) > 20 and far == sorted(far) and far[0] > 0.0


def test_of_two_with_the_same_drag_the_faster_comes_first() -> None:
    slow, fast = (scored(name, 0.01, 0.01, 0.1, 0.1, s) for name, s in (("slow", 24.0), ("fast", 20.0)))
    assert [one.name for one in ranked([slow, fast])] == ["fast", "slow"]


def test_outlooks_are_the_least_of_all_that_the_robot_can_do_and_of_those_that_meet_all_else(many) -> None:
    found = outlooks(many, DEMANDS_MADE, OWN_DRAG)
    able = [one for one in many if not one.lacking]
    assert [one.demand for one in found] == list(DEMANDS)
    for one in found:
        best = max if one.demand == "contact" else min
        assert one.least == best(each.value(one.demand) for each in able) == one.least_by.value(one.demand)
        others = [each.value(one.demand) for each in able if {miss.demand for miss in each.misses} <= {one.demand}]
        assert one.least_with_others == (best(others) if others else None)
    assert any(one.least_with_others is not None for one in found)


def test_a_demand_binds_alone_only_where_all_others_can_be_met_together_without_it() -> None:
    rows = [scored("biased", 0.2, 0.09, 0.12, 0.19, 24.0), scored("long", 0.04, 0.04, 0.9, 0.3, 24.0)]
    found = {one.demand: one for one in outlooks(rows, DEMANDS_MADE, OWN_DRAG)}
    assert found["tv"].binds_alone and not found["tv"].out_of_reach
    assert not found["drag"].binds_alone and found["drag"].least_with_others is None
    hopeless = outlooks([rows[0]], DEMANDS_MADE, OWN_DRAG)
    assert [one.demand for one in hopeless if one.out_of_reach] == ["tv"]


def test_where_the_robot_can_do_nothing_there_is_no_outlook() -> None:
    assert outlooks([scored("turn", 0.2, 0.2, 0.1, 0.1, 20.0, gripper=True)], DEMANDS_MADE, OWN_DRAG) == ()
