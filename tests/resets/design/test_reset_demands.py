"""What is demanded of a reset: what counts as missed, by how much, and what the robot must be able to do."""

import math

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.resets.design.reset_demands import DEMANDS, ResetDemands
from cyclemap.resets.design.reset_numbers import ResetNumbers
from cyclemap.resets.strategies.action_cost import StrategyCost


def numbers(tv: float, after: float, error: float = math.inf) -> ResetNumbers:
    law = FourierLaw(np.ones(1))
    return ResetNumbers(law, Estimate(tv, error), Estimate(after, error), 3.0, 50.0, 50, 0.1, math.isfinite(error))


COST = StrategyCost(0.15, 0.2, 25.0, 0.12, 0.18)


def test_each_demand_is_missed_where_its_value_is_above_its_limit_and_by_the_logarithm_of_their_ratio() -> None:
    demands = ResetDemands(0.05, 0.05, 50, drag_ratio=1.2, reach=0.17, seconds=24.0, contact=0.075)
    misses = demands.misses(numbers(0.06, 0.2), COST, own_drag=0.1, contact=0.05)
    assert [miss.demand for miss in misses] == list(DEMANDS)
    ratios = [0.06 / 0.05, 0.2 / 0.1, 0.15 / 0.12, 0.18 / 0.17, 25.0 / 24.0, 0.075 / 0.05]
    assert [miss.excess for miss in misses] == pytest.approx(np.log(ratios))


def test_what_lies_at_its_limit_is_met_and_what_is_not_asked_for_is_not_missed() -> None:
    assert ResetDemands(drag_ratio=1.5).misses(numbers(0.05, 0.1), COST, own_drag=0.1) == ()
    long = ResetDemands(drag_ratio=1.5, contact=0.075)
    assert long.misses(numbers(0.05, 0.1), COST, own_drag=0.1, contact=0.075) == ()
    assert [miss.demand for miss in long.misses(numbers(0.05, 0.1), COST, 0.1, contact=0.0)] == ["contact"]
    assert set(ResetDemands().limits(0.1)) == {"tv", "tv_after", "drag"}


def test_scores_are_certain_only_with_their_whole_error_within_the_limits() -> None:
    demands = ResetDemands(0.05, 0.05)
    assert demands.are_certain(numbers(0.045, 0.09, 0.004))
    assert not demands.are_certain(numbers(0.045, 0.09, 0.006))
    assert not demands.are_certain(numbers(0.001, 0.001))


@pytest.mark.parametrize(
    ("abilities", "lacking"),
    [
        ((), ("gripper", "ring at another place", "magnet")),
        (("ring",), ("gripper", "magnet")),
        (("gripper", "ring at another place"), ("magnet",)),
        (("gripper", "ring", "magnet"), ()),
        ("magnet", ("gripper", "ring at another place")),
    ],
)
def test_what_the_robot_can_do_is_named_shortly_or_as_strategies_name_it(abilities, lacking) -> None:
    needs = ("gripper", "ring at another place", "magnet")
    assert ResetDemands(abilities=abilities).lacking(needs) == lacking


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"allow_tv": 0.0}, "allow_tv is 0"),
        ({"allow_tv": 1.0}, "allow_tv is 1"),
        ({"extra_tv": math.nan}, "extra_tv must be a finite number"),
        ({"within": 0}, "within must be at least 1"),
        ({"drag_ratio": -1.0}, "drag_ratio must be positive"),
        ({"reach": 0.0}, "reach must be positive"),
        ({"contact": 0.0}, "contact must be positive"),
        ({"seconds": "9"}, "seconds must be a finite number"),
        ({"abilities": ("",)}, "abilities are names"),
    ],
)
def test_bad_demands_are_refused_by_name(changes, words) -> None:
    with pytest.raises(InvalidInput, match=words):
        ResetDemands(**changes)
