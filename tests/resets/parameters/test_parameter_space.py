"""Families of strategies, and the derivatives of their laws: those of the strategy's own formulas."""

import math

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import SidePush
from cyclemap.resets.parameters.parameter_families import (
    drawn_push_family,
    fixed_leg_family,
    gripper_family,
    random_leg_family,
    ring_family,
    way_point_family,
)
from cyclemap.resets.parameters.parameter_space import NUMBERS, StrategyFamily, law_numbers, law_tangent
from cyclemap.resets.strategies.drag_strategies import RingPlace, StraightReset, TrailingLeg
from cyclemap.resets.strategies.push_strategies import AlternatingPushes

LOOP = CollectionLoop.mit()


def _row(tangent, action, name):
    return tangent.numbers[action][tangent.at.names[action].index(name)]


def test_a_legs_way_points_move_as_its_geometry_says():
    """Start = l (cos a, sin a), side place = start + s (-sin a, cos a), by length, direction and side step."""
    length, angle, aside = 0.08, 0.7, 0.03
    tangent = law_tangent(fixed_leg_family(), (length, angle, aside), LOOP)
    c, s = math.cos(angle), math.sin(angle)
    expected = {
        "way_1_x": (c, -length * s - aside * c, -s),
        "way_1_y": (s, length * c - aside * s, c),
        "way_2_x": (c, -length * s, 0.0),
        "way_2_y": (s, length * c, 0.0),
    }
    for name, slopes in expected.items():
        assert np.abs(_row(tangent, 0, name) - slopes).max() < 1e-9
    assert tangent.smooth.all() and set(tangent.moving) == set(expected)


def test_weights_move_as_shares_of_their_sum_do():
    """w_1 = 1/(1 + v), w_2 = v/(1 + v), and each push moves with its own fraction alone."""
    family = drawn_push_family((SidePush(1), SidePush(2)), weights=True)
    tangent = law_tangent(family, (0.3, 0.6, 3.0), LOOP)
    assert np.abs(tangent.weights[:, 2] - np.array([-1.0, 1.0]) / 16.0).max() < 1e-9
    assert not tangent.weights[:, :2].any() and tangent.moving == ("fraction",)
    assert np.abs(_row(tangent, 0, "fraction") - (1.0, 0.0, 0.0)).max() < 1e-9
    assert np.abs(_row(tangent, 1, "fraction") - (0.0, 1.0, 0.0)).max() < 1e-9


def test_a_ring_and_a_gripper_move_what_they_are_named_after():
    ring = law_tangent(ring_family(), (0.01, -0.02), LOOP)
    assert ring.moving == ("hitch_x", "hitch_y") and np.allclose(_row(ring, 0, "hitch_y"), (0.0, 1.0))
    turn = law_tangent(gripper_family(), (0.5,), LOOP, nodes=12)
    slopes = np.array([_row(turn, k, "turn")[0] for k in range(3)])
    # Gauss-Legendre nodes of three: the halfwidth times 0 and +-sqrt(3/5).
    assert np.abs(slopes - math.sqrt(0.6) * np.array([-1.0, 0.0, 1.0])).max() < 1e-9 and turn.moving == ("turn",)


def test_at_a_bound_the_derivative_is_one_sided():
    tangent = law_tangent(fixed_leg_family(lengths=(0.05, 0.1)), (0.1, 0.0, 0.02), LOOP)
    assert tangent.smooth.all() and abs(_row(tangent, 0, "way_2_x")[0] - 1.0) < 1e-9


def test_where_a_way_point_vanishes_the_law_has_no_derivative():
    """At a side step of zero the place aside is left out: two way-points become one."""
    family = StrategyFamily(
        "leg", ("l", "s"), (0.05, -0.1), (0.2, 0.1), lambda v: TrailingLeg(v[0], 0.0, side_step=v[1])
    )
    assert law_tangent(family, (0.1, 0.0), LOOP).smooth.tolist() == [True, False]
    assert law_tangent(family, (0.1, 0.01), LOOP).smooth.tolist() == [True, True]


def test_what_changes_the_loop_besides_its_ring_has_no_derivative():
    class Worn(RingPlace):
        def prepared(self, loop):
            return CollectionLoop.mit("abs" if self.hitch[0] > 0.0 else "pu")

    family = StrategyFamily("worn", ("x",), (-1.0,), (1.0,), lambda v: Worn((v[0], 0.0)))
    assert law_tangent(family, (0.0,), LOOP).smooth.tolist() == [False]


def test_numbers_of_a_law_are_those_of_its_actions():
    found = law_numbers(LOOP, AlternatingPushes((SidePush(0, 0.3), SidePush(2, 0.6, 0.1, 0.2))))
    assert found.names == (NUMBERS, NUMBERS)
    assert found.numbers[1].tolist() == [0.0, 0.6, 0.1, 0.2, *LOOP.slider.hitch]
    assert law_numbers(LOOP, StraightReset()).numbers[0].size == len(NUMBERS)


@pytest.mark.parametrize(
    "family",
    [
        ring_family(),
        way_point_family(),
        fixed_leg_family(),
        random_leg_family(),
        random_leg_family(side_steps=(0.01, 0.1)),
        gripper_family(),
        drawn_push_family((SidePush(1),), ("fraction", "angle", "distance")),
    ],
    ids=lambda family: family.title,
)
def test_every_ready_family_makes_a_strategy_all_over_its_range(family):
    """At both ends and in the middle, and shares of the range go to parameters and back."""
    shares = np.array([[0.0], [0.5], [1.0]]) * np.ones(len(family.names))
    made = [family.strategy(values) for values in family.from_unit(shares)]
    assert len(made) == 3 and len({type(one) for one in made}) == 1
    assert np.abs(family.to_unit(family.from_unit(shares)) - shares).max() < 1e-14


def test_ranges_of_a_drawn_push_can_be_narrowed():
    family = drawn_push_family((SidePush(1), SidePush(2)), ranges={"fraction": (0.25, 0.75)})
    assert [bounds.tolist() for bounds in family.bounds] == [[0.25, 0.25], [0.75, 0.75]]


def test_a_push_that_is_none_and_a_range_without_two_ends_are_refused():
    with pytest.raises(InvalidInput, match="pushes must be SidePush"):
        drawn_push_family((1,))
    for ends in ((0.9,), (0.1, 0.5, 0.9), (0.1, float("nan"))):
        with pytest.raises(InvalidInput, match="range of fraction"):
            drawn_push_family((SidePush(1),), ranges={"fraction": ends})


def test_bad_families_and_parameters_are_refused():
    def build(values):
        return StraightReset()

    with pytest.raises(InvalidInput, match="a name of its own"):
        StrategyFamily("twice", ("x", "x"), (0.0, 0.0), (1.0, 1.0), build)
    with pytest.raises(InvalidInput, match="the lower below the upper"):
        StrategyFamily("empty", ("x",), (1.0,), (1.0,), build)
    family = StrategyFamily("one", ("x",), (0.0,), (1.0,), build)
    with pytest.raises(InvalidInput, match="x is 2: one keeps it between 0 and 1"):
        family.strategy((2.0,))
    with pytest.raises(InvalidInput, match="has the 1 parameters"):
        family.strategy((0.2, 0.3))
    with pytest.raises(InvalidInput, match="is no reset strategy"):
        StrategyFamily("none", ("x",), (0.0,), (1.0,), lambda v: None).strategy((0.5,))
    with pytest.raises(InvalidInput, match="part of a push"):
        drawn_push_family((SidePush(1),), ("side",))
    with pytest.raises(InvalidInput, match="part of a push"):
        drawn_push_family((SidePush(1),), ranges={"side": (0.0, 1.0)})
    with pytest.raises(InvalidInput, match="needs a push or more"):
        drawn_push_family((), ("fraction",))
