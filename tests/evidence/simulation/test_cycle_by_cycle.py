"""A simulated collection whose pushes, way-points and gripper turns change from cycle to cycle."""

import math
from dataclasses import replace

import pytest
from refusals import refused

from cyclemap.collection.loop import CollectionLoop
from cyclemap.evidence.pushes.push_table import load_pushes
from cyclemap.evidence.recorded_push import RecordingNoise
from cyclemap.evidence.simulated_collection import simulate_collection
from cyclemap.mechanics import DragBack, Pusher, SidePush, load_material

LOOP = CollectionLoop.mit(accuracy=1e-6, push=SidePush(distance=0.01))
LOOPS = (
    LOOP,
    replace(LOOP, push=SidePush(2, 0.4, 0.1, 0.02)),
    replace(LOOP, push=SidePush(1, distance=0.015), reset=DragBack(((0.02, 0.0),))),
)
TURNS = (0.0, 0.5, -1.0)
STILL = RecordingNoise(turn=0.0)


def test_each_cycle_is_that_of_its_loop_with_the_grippers_turn_after_it(tmp_path) -> None:
    made = simulate_collection(
        LOOP, tmp_path / "made", 3, noise=STILL, suffix=".json", cycle_loops=LOOPS, gripper_turns=TURNS
    )
    theta = [0.0]
    for loop, turn in zip(LOOPS, TURNS, strict=True):
        theta.append(loop.cycle(theta[-1]).theta_next + turn)
    told = [float(line.split()[1]) for line in (tmp_path / "made" / "true_theta0.txt").read_text().splitlines()]
    # The recorded run takes shorter steps than the cycles here.
    assert told == pytest.approx(theta, abs=1e-5)
    assert made.theta_last == told[2]
    table = load_pushes(made.folder).table.sort_values("repetition")
    assert table["side"].tolist() == [0.0, 2.0, 1.0]
    turns = [loop.cycle(start).push_turn for loop, start in zip(LOOPS, theta, strict=False)]
    assert table["dtheta"].to_numpy() == pytest.approx(turns, abs=1e-4)


def test_the_surface_wears_under_changing_pushes_too(tmp_path) -> None:
    worn = {"wear_to": load_material("abs"), "noise": STILL, "suffix": ".json"}
    made = simulate_collection(LOOP, tmp_path / "made", 3, cycle_loops=LOOPS, **worn)
    fresh = simulate_collection(LOOP, tmp_path / "fresh", 3, cycle_loops=LOOPS, noise=STILL, suffix=".json")
    assert abs(made.theta_last - fresh.theta_last) > 1e-4


def test_a_collection_is_gone_on_with_only_by_the_same_cycles(tmp_path) -> None:
    folder, given = tmp_path / "made", {"noise": STILL, "suffix": ".json"}
    simulate_collection(LOOP, folder, 3, cycle_loops=LOOPS, **given)
    again = simulate_collection(LOOP, folder, 3, cycle_loops=LOOPS, **given)
    assert (again.written, again.resumed) == (0, 3)
    for other in ({"cycle_loops": LOOPS[::-1]}, {"cycle_loops": LOOPS, "gripper_turns": TURNS}, {}):
        refused(simulate_collection, LOOP, folder, 3, told="asked for otherwise: cycle_by_cycle", **other, **given)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"cycle_loops": LOOPS[:2]}, "cycle_loops has 2 entries for 3 cycles"),
        ({"gripper_turns": (0.1,)}, "gripper_turns has 1 entries for 3 cycles"),
        ({"gripper_turns": (0.1, math.nan, 0.2)}, "gripper turn must be a finite number"),
        (
            {"cycle_loops": (LOOP, replace(LOOP, pusher=Pusher(0.01)), LOOP)},
            "loop of cycle 1 differs in more than push",
        ),
    ],
)
def test_cycles_that_do_not_fit_are_refused(tmp_path, given, said) -> None:
    refused(simulate_collection, LOOP, tmp_path / "made", 3, told=said, **given)
    assert not (tmp_path / "made").exists()
