"""Schedules as CSV: the same actions come back, the robot's columns agree with the mechanics,
damage is refused.
"""

import csv
import math

import numpy as np
import pytest
from refusals import refused

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import DataFileError
from cyclemap.mechanics import SidePush
from cyclemap.protocol import read_schedule, write_schedule
from cyclemap.resets import CycleAction, ResetStrategy, run_strategy

LOOP = CollectionLoop.mit(accuracy=1e-6)
LEGS = ((0.02, 0.05), (0.0, 0.05)), ((0.03, -0.04), (0.05, 0.0))
MIXED = ResetStrategy(
    (
        CycleAction(LEGS[0], SidePush(0, distance=0.02), 0.3),
        CycleAction(LEGS[1], SidePush(2, distance=0.02), -1.1),
    )
)


@pytest.fixture
def schedule(tmp_path):
    path = tmp_path / "schedule.csv"
    write_schedule(path, LOOP, MIXED, 6, seed=3)
    return path


@pytest.fixture
def unsealed(schedule):
    """The schedule without its checksum: what is damaged is then found by what it says."""
    schedule.write_text(schedule.read_text().split("\n", 1)[1])
    return schedule


def test_a_change_of_any_digit_is_noticed_by_the_checksum(schedule) -> None:
    text = schedule.read_text()
    places = [at for at in range(text.index("cycle,side"), len(text)) if text[at].isdigit()][::15]
    assert len(places) > 5
    for at in places:
        schedule.write_text(text[:at] + str((int(text[at]) + 1) % 10) + text[at + 1 :])
        refused(read_schedule, schedule, told="not as it was written", kind=DataFileError)


def test_the_actions_come_back_exactly_with_push_and_way_points_filled_in(
    schedule, tmp_path
) -> None:
    assert read_schedule(schedule) == tuple(action.filled(LOOP) for action in MIXED.run(6, 3))
    actions = (CycleAction(turn=math.pi / 7.0), CycleAction(()))
    ring = ResetStrategy(actions, hitch=(0.01, 1.0 / 300.0))
    write_schedule(tmp_path / "ring.csv", LOOP, ring, 25, seed=7)
    filled = tuple(action.filled(ring.prepared(LOOP)) for action in ring.run(25, 7))
    assert read_schedule(tmp_path / "ring.csv") == filled


def test_a_run_by_the_file_is_the_run_that_was_written(schedule) -> None:
    """The robot's schedule, run by the mechanics, gives the orientations of the strategy with that
    seed.
    """
    told = run_strategy(LOOP, MIXED, 6, sigma=0.02, seed=3)
    follower = ResetStrategy(read_schedule(schedule), order="in turn")
    assert np.array_equal(told.theta, run_strategy(LOOP, follower, 6, sigma=0.02, seed=3).theta)
    assert len(set(told.action[0].tolist())) == 2
    text = schedule.read_text()
    for fact in ("strategy: 2 actions, random", "seed: 3", "cycles: 6", "needs: gripper"):
        assert f"# {fact}\n" in text
    assert "its ring at (-10.6066" in text


def test_the_robots_columns_are_where_the_mechanics_puts_rod_and_ring(schedule) -> None:
    """Rod start and direction against a run push; way-points plus legs end at the target."""
    lines = [line for line in schedule.read_text().splitlines() if not line.startswith("#")]
    rows = [{name: float(cell) for name, cell in row.items()} for row in csv.DictReader(lines)]
    assert len(rows) == 6
    for row, action in zip(rows, read_schedule(schedule), strict=True):
        pose = LOOP.start_pose(0.4)
        rod = LOOP.model.push(pose, action.push).trajectory.pusher
        place = (1e-3 * row["rod_x_mm"], 1e-3 * row["rod_y_mm"])
        assert pose.to_object(*rod[0]) == pytest.approx(place, abs=1e-11)
        way = complex(*(rod[-1] - rod[0])) * np.exp(-0.4j)
        assert complex(row["push_dx"], row["push_dy"]) == pytest.approx(way / abs(way))
        place = complex(row["way_point_1_x_mm"], row["way_point_1_y_mm"])
        for leg in (1, 2):
            bearing = math.radians(row[f"leg_{leg}_direction_deg"])
            place += row[f"leg_{leg}_mm"] * np.exp(1j * bearing)
        assert place == pytest.approx(0.0, abs=1e-8)
        assert row["leg_2_mm"] == pytest.approx(50.0)


def test_a_damaged_field_is_refused_with_its_line(unsealed) -> None:
    """A way-point moved by a hundredth of a micrometre, too: beside it stand direction and length
    of the leg.
    """
    lines = unsealed.read_text().splitlines()
    at = next(number for number, line in enumerate(lines) if line.startswith("2,"))
    header = next(line for line in lines if line.startswith("cycle,")).split(",")
    moved = float(lines[at].split(",")[header.index("way_point_1_x_mm")]) + 1e-5
    for column, value, said in (
        ("angle_deg", "x", "angle_deg is 'x'; it must be a finite number"),
        ("push_mm", "inf", "push_mm is 'inf'"),
        ("push_mm", "-3", "push distance must be positive"),
        ("side", "1.5", "side is '1.5'; it must be a whole number"),
        ("side", "9" * 5000, "it must be a whole number"),
        ("rod_x_mm", "", "rod_x_mm is ''"),
        ("fraction", "1e999999999999999999999", "it must be a finite number"),
        ("push_mm", "1e999998", "push_mm is '1e999998'; it must be a finite number"),
        ("cycle", "7", "cycle is '7' where 2 should follow"),
        ("leg_2_direction_deg", "0.5", "leg_2 does not run from way_point_2"),
        ("way_point_1_x_mm", "", "way_point_1_x_mm is ''"),
        ("way_point_1_x_mm", repr(moved), "leg_1 does not run from way_point_1"),
        ("gripper_turn_deg", "nan", "gripper_turn_deg is 'nan'"),
    ):
        fields = lines[at].split(",")
        fields[header.index(column)] = value
        unsealed.write_text("\n".join([*lines[:at], ",".join(fields), *lines[at + 1 :]]) + "\n")
        told = f"schedule.csv, line {at + 1}.*{said}"
        refused(read_schedule, unsealed, told=told, kind=DataFileError)


def test_a_file_cut_anywhere_is_refused(unsealed) -> None:
    """Proper beginnings of the file: none is read as a shorter schedule."""
    text = unsealed.read_text()
    cuts = range(text.index("cycle,side"), len(text), 7)
    for cut in cuts:
        unsealed.write_text(text[:cut])
        refused(read_schedule, unsealed, told=r"schedule\.csv", kind=DataFileError)
    assert len(cuts) > 100


def test_a_file_that_lacks_something_is_refused(unsealed) -> None:
    text = unsealed.read_text()
    lines = text.splitlines()
    for changed, said in (
        (text.replace("# cycles: 6\n", ""), "'# cycles: N' is missing"),
        (text.replace("cycles: 6", f"cycles: {'9' * 5000}"), "'# cycles: N' is missing or damaged"),
        (text.replace("push_mm,", "push,"), "push_mm is missing"),
        (text.replace("way_point_1_x_mm,", "way_point_1_x_m,"), "unknown column 'way_point_1_x_m'"),
        ("\n".join(lines[:-1]) + "\n", "5 cycles of the 6 that the comments promise"),
        ("\n".join([*lines[:-1], "6,0"]) + "\n", "2 of .* fields"),
    ):
        unsealed.write_text(changed)
        refused(read_schedule, unsealed, told=said, kind=DataFileError)
