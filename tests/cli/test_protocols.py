"""--set, protocol files and strategies: what is understood, what is refused, which of two wins,
what follows.
"""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from refusals import refused as refuse

from cyclemap.collection import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import DataFileError
from cyclemap.evidence import load_pushes
from cyclemap.mechanics import SidePush
from cyclemap.protocol import read_protocol, read_schedule, write_protocol, write_schedule
from cyclemap.protocol.chosen_loop import chosen_loop
from cyclemap.resets import (
    CycleAction,
    ResetStrategy,
    legs,
    map_turns,
    orientation_law,
    run_strategy,
    strategy_maps,
)

LOOP = CollectionLoop.mit(push=SidePush(distance=0.01))
PUSHES = (SidePush(0, 0.7, 0.0, 0.01), SidePush(2, 0.7, 0.0, 0.02))
RANDOM = ResetStrategy(tuple(CycleAction(push=push, turn=0.3) for push in PUSHES), (1.0, 3.0))
DRAWN = ResetStrategy(tuple(CycleAction(push=push) for push in PUSHES))
IN_TURN = replace(DRAWN, order="in turn")
RING = ResetStrategy((CycleAction(),), hitch=(0.0, 0.02))
FIXED = ResetStrategy((CycleAction(((0.02, 0.01),)),), hitch=(0.0, 0.02))
LEG = ResetStrategy(legs(0.05, 4))
GRIPPER = ResetStrategy((CycleAction(turn=0.2),))
PLYWOOD = "plywood --protocol protocol.toml"
BAD_PROTOCOLS = [
    ("[push\n", "not TOML"),
    ("[push]\nside = true\n", ", line 2: side is True; it must be a number, text"),
    ("[push]\n[push.deep]\nside = 1\n", ", line 2: deep is {'side': 1}; it must be a number"),
    ("[push]\nside = 1\nmu_a = 'rough'\n", ", line 3: mu_a must be a finite number, not 'rough'"),
    (
        "[[strategy.actions]]\nside = 0\n[push]\nsdie = 1\n",
        ", line 4: unknown setting 'sdie': did you mean 'si",
    ),
    ("[a]\nside = 1\n[b]\nside = 2\n", ", line 4: side is given twice"),
]


@pytest.mark.parametrize(("text", "said"), BAD_PROTOCOLS)
def test_bad_protocol_is_refused_by_file_and_line(protocol_file, text, said) -> None:
    path = protocol_file(text)
    told = f"{re.escape(str(path))}.*{re.escape(said)}"
    refuse(read_protocol, path, told=told, kind=DataFileError)


def test_set_wins_over_protocol_over_material_over_mit(protocol_file) -> None:
    """The tables of a protocol file are headings only; noise is read in degrees."""
    path = protocol_file("[push]\nmu_a = 0.3\nmu_b = 0.28\npusher_mu = 0.2\n")
    chosen = chosen_loop("plywood", path, ("mu_a=0.1", "mu_a = 0.31", "noise_deg=2.5"))
    loop, friction = chosen.loop, chosen.loop.material.friction
    assert (friction.mu_a, friction.mu_b, friction.m0) == (0.31, 0.28, 0.0325)
    assert (loop.pusher.friction, loop.pusher.radius) == (0.2, 0.00475)
    assert chosen.sigma == pytest.approx(math.radians(2.5))


@pytest.fixture
def protocol(here):
    """Write the protocol of a strategy into an empty current folder."""

    def write(strategy) -> Path:
        write_protocol("protocol.toml", LOOP, strategy)
        return Path("protocol.toml")

    return write


def test_cycle_runs_each_action_from_each_start_and_tells_its_share(
    protocol, report_of, said
) -> None:
    protocol(RANDOM)
    found = report_of(f"cycle {PLYWOOD} --theta0-deg 0,90")["cycles"]
    assert len(found) == 4
    for number, row in enumerate(found):
        action, start = RANDOM.actions[number // 2], (0.0, 90.0)[number % 2]
        cycle = action.on(LOOP).cycle(math.radians(start))
        assert row["theta0_deg"] == start
        assert row["theta1_deg"] == pytest.approx(math.degrees(cycle.theta_next + 0.3))
        told, side = row["action"], action.push.side
        assert told["weight"] == pytest.approx((0.25, 0.75)[number // 2])
        assert (told["side"], told["gripper_turn_deg"]) == (side, math.degrees(0.3))
        pushed = f"push {10 * (1 + number // 2)} mm on side {side} at 0.7, gripper 17.2°"
        assert told["name"] == pushed
    assert f"{pushed}: 0.75 of the cycles on plywood" in said(f"cycle {PLYWOOD}").out


def test_cycle_without_a_strategy_has_no_action(protocol, report_of) -> None:
    protocol(None)
    found = report_of(f"cycle {PLYWOOD} --theta0-deg 30")
    assert found == report_of("cycle plywood --set push_mm=10 --theta0-deg 30")
    assert "action" not in found["cycles"][0]


@pytest.mark.slow
def test_a_portrait_tells_the_distribution_of_its_mixture(protocol, report_of) -> None:
    protocol(RANDOM)
    report = report_of(f"portrait {PLYWOOD} --cycles 300 --set noise_deg=6")
    keys = "strategy map fixed_points fixed_points_reason rotation_number stationary staircase"
    assert " ".join(report) == keys
    turns = map_turns(strategy_maps(LOOP, RANDOM))
    law = orientation_law(turns, RANDOM, math.radians(6.0))
    assert [row["action"]["weight"] for row in report["map"]] == pytest.approx([0.25, 0.75])
    mean_turns = np.degrees(turns.mean(axis=1)).tolist()
    assert [row["mean_turn_deg"] for row in report["map"]] == pytest.approx(mean_turns)
    stationary = report["stationary"]
    assert stationary["tv_from_uniform"] == pytest.approx(law.total_variation, abs=1e-9)
    memory = -1.0 / math.log1p(-stationary["spectral_gap"])
    assert stationary["mixing_cycles"] == pytest.approx(memory)
    assert (report["fixed_points"], report["rotation_number"]["locked"]) == ([], None)
    climbed = report["staircase"]["run"]["climb_deg"] / 360.0 / 300.0
    assert climbed == pytest.approx(report["rotation_number"]["value"])


@pytest.mark.slow
@pytest.mark.parametrize("command", ["portrait", "staircase"])
def test_measured_directions_stand_beside_a_strategy(
    protocol, report_of, theta0_file, command
) -> None:
    turns = 0.2 + 0.02 * np.random.default_rng(1).standard_normal(150)
    theta0_file(Path("measured.csv"), np.cumsum(turns))
    protocol(RANDOM)
    report = report_of(f"{command} {PLYWOOD} --data measured.csv --set noise_deg=20")
    ran = report["run"] if command == "staircase" else report["staircase"]["run"]
    assert ran["cycles"] == 149 and report["data"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "strategy"),
    [
        ("dynamics isotropic --theta0-deg 10 --speed-mm-s 500", FIXED),
        # Isotropic friction and a ring elsewhere turn the object rigidly, which is quick.
        ("portrait isotropic --cycles 20 --set noise_deg=20", RING),
        ("staircase isotropic --cycles 100 --set noise_deg=20", RING),
    ],
)
def test_a_strategy_that_does_the_same_in_every_cycle_is_part_of_the_loop(
    protocol, report_of, line, strategy
) -> None:
    given = "--set hitch_x_mm=0 --set hitch_y_mm=20 --set push_mm=10"
    if strategy is FIXED:
        given += " --set way_points_mm=[[20,10]]"
    assert report_of(f"{line} --protocol {protocol(strategy)}") == report_of(f"{line} {given}")


@pytest.mark.parametrize(
    "strategy", [FIXED, ResetStrategy(legs(0.05, 4)[1:2]), ResetStrategy(DRAWN.actions[1:])]
)
def test_every_command_about_one_loop_gets_the_loop_with_the_strategy_in_it(
    protocol, strategy
) -> None:
    chosen = chosen_loop("plywood", protocol(strategy), ("noise_deg=3",))
    (action,) = strategy.actions
    assert chosen.loop == action.on(strategy.prepared(LOOP)) != LOOP
    assert chosen.sigma == pytest.approx(math.radians(3.0))


@pytest.mark.parametrize(
    ("line", "strategy"),
    [
        ("fingerprint plywood", RANDOM),
        ("dynamics plywood", LEG),
        ("experiment plywood", IN_TURN),
        ("compare plywood --data measured.csv", GRIPPER),
        ("identify measured.csv", RANDOM),
    ],
)
def test_a_command_about_one_loop_refuses_a_strategy_and_says_which_take_it(
    protocol, refused, theta0_file, line, strategy
) -> None:
    theta0_file(Path("measured.csv"), 0.12 * np.arange(60))
    why = "turns the object by a gripper" if strategy is GRIPPER else "differs from cycle to cycle"
    takes = "give the file to cyclemap cycle, portrait, staircase or simulate"
    words = f"{why}, and this command is about one loop: {takes}"
    refused(f"{line} --protocol {protocol(strategy)}", words)


@pytest.mark.parametrize(
    ("strategy", "pair"),
    [
        (RANDOM, "side=1"),
        (FIXED, "hitch_x_mm=3"),
        (FIXED, "way_points_mm=[[1,2]]"),
        (LEG, "way_points_mm=[[1,2]]"),
    ],
)
def test_a_setting_that_the_strategy_overrules_is_refused(
    protocol, refused, strategy, pair
) -> None:
    key = pair.partition("=")[0]
    line = f"cycle plywood --protocol {protocol(strategy)} --set {pair}"
    refused(line, f"--set {key}: the strategy of ")


def test_a_materials_strategy_holds_beside_a_protocol_that_has_none(
    protocol, report_of, tmp_path
) -> None:
    """A protocol that says one setting takes nothing away from the file that is the material."""
    own = protocol(RANDOM)
    # By hand: the checksum of what was written holds no more.
    _, text = own.read_text().split("\n", 1)
    own.write_text(f"{text}[friction]\nmu_a = 0.25\nmu_b = 0.2\n")
    (tmp_path / "plain.toml").write_text("[push]\npush_mm = 140\n")
    alone, beside = (
        [row["action"] for row in report_of(f"cycle {own} --theta0-deg 10 {more}")["cycles"]]
        for more in ("", "--protocol plain.toml")
    )
    assert alone == beside and len(alone) > 1


def test_a_setting_beside_the_strategy_is_taken(protocol, report_of) -> None:
    protocol(LEG)
    found = report_of(f"cycle {PLYWOOD} --set push_mm=20 --theta0-deg 0")
    assert {row["action"]["push_mm"] for row in found["cycles"]} == {20.0}


def test_the_staircase_is_that_of_the_mechanics_with_the_same_seed(protocol, report_of) -> None:
    protocol(DRAWN)
    report = report_of(f"staircase {PLYWOOD} --cycles 40 --seed 4")
    told = run_strategy(LOOP, DRAWN, 40, sigma=DEFAULT_SIGMA, seed=4)
    climb = math.degrees(told.theta[0, -1] - told.theta[0, 0])
    assert report["run"]["climb_deg"] == pytest.approx(climb, abs=1e-6)
    assert report["prediction"]["zones"] == []
    assert Path("out/staircase_plywood.png").read_bytes().startswith(b"\x89PNG")


def test_simulate_follows_the_schedule_of_its_seed_cycle_by_cycle(protocol, report_of) -> None:
    """Without noise the recorded θ0 are those of `run_strategy`, the sides those of a robot's
    schedule.
    """
    protocol(RANDOM)
    line = f"simulate {PLYWOOD} --cycles 5 --seed 2 --noise-deg 0 --format json --out made"
    assert (report_of(line)["written"], report_of(line)["resumed"]) == (5, 5)
    told = run_strategy(LOOP, RANDOM, 5, seed=2)
    table = load_pushes("made").table.sort_values("repetition")
    assert np.cos(table["theta0"].to_numpy()) == pytest.approx(np.cos(told.theta[0, :5]), abs=1e-4)
    write_schedule("schedule.csv", LOOP, RANDOM, 5, seed=2)
    assert table["side"].tolist() == [action.push.side for action in read_schedule("schedule.csv")]
    assert len(set(table["side"])) == 2
