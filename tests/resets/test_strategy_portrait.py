"""Portraits and staircases of strategies: laws that are known, and two routes to the mean turn and the path."""

import math

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import WrappedNormal, sample_staircase
from cyclemap.mechanics import EllipseFriction, Material, SidePush
from cyclemap.mechanics.material import Wear
from cyclemap.resets.protocol.fixed_loop import fixed_action, fixed_loop, overruled_settings, why_not_fixed
from cyclemap.resets.protocol.scheduled_actions import ScheduledActions
from cyclemap.resets.strategies.combined import combine
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.drag_strategies import GripperTurn, RingPlace, ScatteredAim, StraightReset, TrailingLeg
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, DrawnPushes, VariedPush
from cyclemap.resets.strategies.schedules import GoldenAngle
from cyclemap.resets.strategies.spread import Spread
from cyclemap.resets.strategies.strategy_run import noise_of_run, run_strategy
from cyclemap.resets.strategy_portrait import strategy_portrait
from cyclemap.resets.strategy_portrait_curves import strategy_curves
from cyclemap.resets.strategy_staircase import law_nodes, samples_from_maps, strategy_staircase

EVEN = Material("even", EllipseFriction.isotropic(0.25))
LOOP = CollectionLoop.mit(EVEN, accuracy=1e-6)
PUSHES = (SidePush(0, distance=0.05), SidePush(2, distance=0.03))


def test_pushes_on_an_isotropic_surface_are_rigid_turns_and_the_portrait_says_so() -> None:
    """Each action turns by the same angle from every orientation; the mean turn is their mean; the law is uniform."""
    found = strategy_portrait(LOOP, DrawnPushes(PUSHES, weights=(1.0, 3.0)), sigma=0.3, cycles=50)
    turns = [CycleAction(push=push).on(LOOP).cycle(0.0).theta_next for push in PUSHES]
    for end in ("minimum", "maximum"):
        assert [getattr(one, end) for one in found.turns] == pytest.approx(turns, abs=1e-5)
    mean = (turns[0] + 3.0 * turns[1]) / 4.0 / (2.0 * math.pi)
    assert abs(found.mean_turn - mean) <= found.mean_turn.error_bound + 1e-9
    assert found.mean_turn_certified and found.law_certified
    assert float(found.scores.total_variation) == pytest.approx(0.0, abs=1e-9)
    assert found.highest_peaks == ()
    # The slowest harmonic of two rigid turns with noise: |w1 e^{i t1} + w2 e^{i t2}| e^{-s^2/2}.
    left = abs(0.25 * np.exp(1j * turns[0]) + 0.75 * np.exp(1j * turns[1])) * math.exp(-0.045)
    assert float(found.memory_cycles) == pytest.approx(-1.0 / math.log(left), rel=1e-4)


def test_the_mean_turn_of_alternating_pushes_is_simulated_within_its_bound() -> None:
    """Rigid turns in turn: half their sum a cycle, exactly; no certificate is claimed."""
    found = strategy_portrait(LOOP, AlternatingPushes(PUSHES), sigma=0.3, cycles=50)
    turns = [CycleAction(push=push).on(LOOP).cycle(0.0).theta_next for push in PUSHES]
    off = abs(found.mean_turn - sum(turns) / 2.0 / (2.0 * math.pi))
    assert off <= 2.0 * found.mean_turn.error_bound
    assert 0.0 < found.mean_turn.error_bound < 0.01
    assert not found.mean_turn_certified and not found.law_certified


def test_the_curves_hold_every_action_push_and_drag_once() -> None:
    strategy = combine(DrawnPushes(PUSHES), TrailingLeg(0.05, Spread(0.0, 1.0)), GripperTurn(0.2))
    found = strategy_portrait(LOOP, strategy, sigma=0.5, cycles=20, tolerance=1e-2)
    curves = strategy_curves(found)
    assert len(curves.turns) == len(found.maps.maps) == 16
    assert [push.weight for push in curves.pushes] == pytest.approx([0.5, 0.5])
    assert len(curves.drags) == 8 and sum(weight for _, weight in curves.drags) == pytest.approx(1.0)
    assert curves.gripper.tolist() == [0.2]
    at = np.array([0.0, 1.0])
    mean = sum(weight * one.turn(at) for one, weight in zip(found.maps.maps, found.maps.weights, strict=True))
    theta, drawn = curves.mean
    assert np.interp(at, theta, drawn) == pytest.approx(mean, abs=1e-4)
    assert curves.density.mean() == pytest.approx(1.0 / (2.0 * math.pi), rel=1e-2)
    assert 0.0 < found.interpolation < 0.1


def test_a_drawn_strategy_of_listed_pushes_lies_between_no_actions() -> None:
    assert strategy_portrait(LOOP, DrawnPushes(PUSHES), sigma=0.5, cycles=10, tolerance=1e-2).interpolation == 0.0


def test_a_short_run_is_made_by_the_mechanics_and_a_long_one_from_maps_and_both_agree() -> None:
    strategy, noise = DrawnPushes(PUSHES, GoldenAngle()), WrappedNormal(0.02)
    short = strategy_staircase(LOOP, strategy, sigma=0.02, cycles=30, seed=3)
    long = strategy_staircase(LOOP, strategy, sigma=0.02, cycles=200, seed=3)
    assert short.maps is None and long.maps is not None
    told = run_strategy(LOOP, strategy, 30, noise=noise, seed=3)
    assert np.array_equal(short.run.theta, told.theta)
    again = run_strategy(LOOP, strategy, 200, noise=noise, seed=3)
    assert long.run.theta == pytest.approx(again.theta, abs=0.02)


def test_a_surface_that_wears_is_run_by_the_mechanics() -> None:
    worn = Material("worn", EVEN.friction, wear=Wear(EllipseFriction.isotropic(0.3), 100.0))
    assert not samples_from_maps(CollectionLoop.mit(worn), DrawnPushes(PUSHES), 10_000)
    assert samples_from_maps(LOOP, DrawnPushes(PUSHES), 10_000)


def test_a_strategy_that_does_nothing_new_gives_the_staircase_of_the_loop() -> None:
    found = strategy_staircase(LOOP, StraightReset(), sigma=0.02, cycles=150, start=1.0)
    loop = sample_staircase(LOOP.circle_map(1e-4), None, 150, 1.0)
    assert found.run.start == loop.theta[0] == 1.0
    # On an even surface every cycle turns alike, so that the paths differ by the noise alone.
    noise = noise_of_run(WrappedNormal(0.02), 150, 0)
    assert np.diff(found.run.theta) == pytest.approx(np.diff(loop.theta) + noise, abs=1e-3)


def test_a_law_takes_as_many_nodes_as_are_manageable_and_no_more() -> None:
    leg = TrailingLeg(Spread(0.03, 0.05))
    assert law_nodes(leg, most=256) == 32 and len(leg.law(32).actions) == 256
    assert law_nodes(leg, most=255) == 24
    with pytest.raises(InvalidInput, match=r"more than 10 cycle maps: use cyclemap staircase or simulate"):
        law_nodes(leg, most=10)
    wide = combine(leg, ScatteredAim(0.02), GripperTurn(), VariedPush(PUSHES[0], Spread(0.5, 0.7), Spread(-0.1, 0.1)))
    with pytest.raises(InvalidInput, match="more than 256 cycle maps"):
        law_nodes(wide)


FIXED = [StraightReset(), RingPlace((0.0, 0.02)), TrailingLeg(0.05, 1.0), AlternatingPushes(PUSHES[:1])]
MOVING = [TrailingLeg(0.05), AlternatingPushes(PUSHES), GripperTurn(0.3), combine(StraightReset(), GripperTurn())]


@pytest.mark.parametrize("strategy", FIXED, ids=lambda strategy: strategy.name)
def test_the_loop_of_a_fixed_strategy_does_what_the_strategy_does(strategy) -> None:
    loop = fixed_loop(LOOP, strategy)
    assert loop is not None
    assert loop.cycle(0.3).theta_next == pytest.approx(run_strategy(LOOP, strategy, 1, start=0.3).theta[1], abs=1e-12)


@pytest.mark.parametrize("strategy", MOVING, ids=lambda strategy: strategy.name)
def test_a_strategy_whose_cycles_differ_or_that_needs_a_gripper_has_no_loop(strategy) -> None:
    assert fixed_loop(LOOP, strategy) is None
    expected = "gripper" if fixed_action(strategy) is not None else "does not do the same in every cycle"
    assert expected in why_not_fixed(strategy)


def test_what_a_strategy_sets_in_every_cycle_is_known() -> None:
    both = combine(RingPlace((0.0, 0.02)), DrawnPushes(PUSHES))
    assert overruled_settings(LOOP, both) == ("side", "fraction", "angle_deg", "push_mm", "hitch_x_mm", "hitch_y_mm")
    assert overruled_settings(LOOP, GripperTurn()) == ()
    mixed = ScheduledActions((CycleAction(()), CycleAction()))
    assert overruled_settings(LOOP, mixed) == ()
