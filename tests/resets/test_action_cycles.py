"""Sampled cycles are the loop's own, and what they cost is what their courses show."""

import math

import numpy as np
import pytest

import cyclemap as cm
from cyclemap.resets import CycleAction, ResetStrategy, legs, map_turns, sample_turns, strategy_maps
from cyclemap.resets.action_cycles import contact_lengths, room_needed, seconds

LOOP = cm.CollectionLoop.mit()
ACTIONS = (CycleAction(push=cm.SidePush(2, 0.85)), *legs(0.1, 3)[1:2], CycleAction(turn=0.7))


def test_sampled_turns_are_those_of_single_cycles_on_every_material() -> None:
    materials = [cm.load_material(name) for name in ("plywood", "abs")]
    found = sample_turns(LOOP, ACTIONS, materials, 5)
    for m, material in enumerate(materials):
        for a, action in enumerate(ACTIONS):
            loop = action.on(cm.CollectionLoop.mit(material))
            runs = [loop.cycle(theta) for theta in 2.0 * math.pi * np.arange(5) / 5]
            turns = [run.theta_next - run.theta + action.turn for run in runs]
            assert found.turn[m, a] == pytest.approx(turns, abs=2e-4)
            drag = np.mean([run.drag_length for run in runs])
            assert found.drag_length[m, a] == pytest.approx(drag, abs=1e-5)


@pytest.mark.slow
def test_the_spline_between_samples_comes_nearer_with_more_of_them() -> None:
    """By more than four times, second order, from 36 to 72 samples of a map with kinks."""
    fine, *rough = (sample_turns(LOOP, ACTIONS[:1], [LOOP.material], n) for n in (360, 36, 72))
    errors = [np.abs(turns.refined(360) - fine.turn).max() for turns in rough]
    assert 4.0 * errors[1] < errors[0] < 0.05


def test_cycle_maps_are_the_sampled_turns() -> None:
    turns = map_turns(strategy_maps(LOOP, ResetStrategy(ACTIONS)), 36)
    sampled = sample_turns(LOOP, ACTIONS, [LOOP.material], 36).turn[0]
    assert turns == pytest.approx(sampled, abs=3e-4)


def test_contact_is_as_long_as_the_rod_pushes() -> None:
    """A push aslant off the middle loses the object soon; one at the middle keeps it to the end."""
    pushes = [CycleAction(push=cm.SidePush(0, 0.7)), CycleAction(push=cm.SidePush(0, 0.15, 0.35))]
    own, slanted = contact_lengths(LOOP, pushes)
    travels = [LOOP.cycle(theta).push.travel for theta in 2.0 * math.pi * np.arange(12) / 12]
    assert own == pytest.approx(min(travels), abs=1e-5)
    assert slanted < 0.08 < 0.12 < own < 0.15
    # 20 mm/s in contact, 10 s for all else, 10 s more for a gripper.
    told = seconds(np.array([0.2, 0.3, 0.2]), np.array([0.0, 0.0, 0.5]))
    assert told.tolist() == [20.0, 25.0, 25.0]


def test_the_room_holds_rod_and_object_all_along() -> None:
    room = room_needed(LOOP, CycleAction())
    for theta in 2.0 * math.pi * np.arange(4) / 4:
        course = LOOP.cycle(theta).trajectory.push
        assert np.hypot(*course.pusher.T).max() + LOOP.pusher.radius <= room + 1e-9
    far = room_needed(LOOP, legs(0.3, 4)[0])
    assert far >= 0.3 + LOOP.pusher.radius
