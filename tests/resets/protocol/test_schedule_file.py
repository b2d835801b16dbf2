"""Schedules as CSV: the same actions come back, the robot's columns agree with the mechanics, damage is refused."""

import csv
import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from strategies_of_all_kinds import EVERY_KIND, any_strategy

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.maps import WrappedNormal
from cyclemap.mechanics import SidePush, Slider
from cyclemap.resets.protocol.schedule_file import read_schedule, rod_start, write_schedule
from cyclemap.resets.protocol.scheduled_actions import ScheduledActions
from cyclemap.resets.strategies.combined import combine
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.drag_strategies import GripperTurn, TrailingLeg
from cyclemap.resets.strategies.push_strategies import DrawnPushes, side_pushes
from cyclemap.resets.strategies.strategy import PERIODIC
from cyclemap.resets.strategies.strategy_maps import strategy_maps
from cyclemap.resets.strategies.strategy_run import run_strategy
from cyclemap.resets.strategies.strategy_sampling import sample_strategy

LOOP = CollectionLoop.mit(accuracy=1e-6)
PUSHES = side_pushes(SidePush(distance=0.02), (0, 2))
MIXED = combine(TrailingLeg(0.05, side_step=0.02), DrawnPushes(PUSHES), GripperTurn())


@pytest.fixture
def schedule(tmp_path):
    path = tmp_path / "schedule.csv"
    write_schedule(path, LOOP, MIXED, 6, seed=3)
    return path


@pytest.mark.parametrize("strategy", EVERY_KIND, ids=lambda strategy: strategy.name)
def test_the_actions_come_back_exactly_with_push_and_way_points_filled_in(strategy, tmp_path) -> None:
    path = tmp_path / "schedule.csv"
    write_schedule(path, LOOP, strategy, 25, seed=7)
    prepared = strategy.prepared(LOOP)
    assert read_schedule(path) == tuple(action.filled(prepared) for action in strategy.actions(25, 7))


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(strategy=any_strategy)
def test_any_strategy_comes_back_exactly_through_csv(strategy, tmp_path) -> None:
    path = tmp_path / "schedule.csv"
    # Five sides or more are left: a hexagon has all that are drawn.
    loop = CollectionLoop.mit(slider=Slider.mit("hex"))
    write_schedule(path, loop, strategy, 4, seed=1)
    assert read_schedule(path) == tuple(action.filled(loop) for action in strategy.actions(4, 1))


def test_a_run_by_the_file_is_the_run_that_was_written(schedule) -> None:
    """The robot's schedule, run by the mechanics, gives the orientations of the strategy with that seed."""
    noise = WrappedNormal(0.02)
    told = run_strategy(LOOP, MIXED, 6, noise=noise, seed=3)
    followed = run_strategy(LOOP, ScheduledActions(read_schedule(schedule)), 6, noise=noise, seed=3)
    assert np.array_equal(told.theta, followed.theta)
    assert len(set(told.gripper_turn.tolist())) == 6


def rows_of(path) -> list[dict[str, str]]:
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return list(csv.DictReader(lines))


def test_the_robots_columns_are_where_the_mechanics_puts_rod_and_ring(schedule) -> None:
    """Rod start and direction against a run push; way-points plus legs end at the target."""
    rows = rows_of(schedule)
    assert len(rows) == 6
    for row, action in zip(rows, read_schedule(schedule), strict=True):
        pushed = LOOP.model.push(LOOP.start_pose(0.4), action.push)
        start, direction = pushed.trajectory.pusher[0], np.diff(pushed.trajectory.pusher[[0, -1]], axis=0)[0]
        at = LOOP.start_pose(0.4).to_object(*start)
        assert [float(row["rod_x_mm"]), float(row["rod_y_mm"])] == pytest.approx([1e3 * part for part in at], abs=1e-8)
        turned = math.atan2(direction[1], direction[0]) - 0.4
        assert [float(row["push_dx"]), float(row["push_dy"])] == pytest.approx([math.cos(turned), math.sin(turned)])
        place = np.array([float(row["way_point_1_x_mm"]), float(row["way_point_1_y_mm"])])
        for leg in (1, 2):
            bearing = math.radians(float(row[f"leg_{leg}_direction_deg"]))
            place = place + float(row[f"leg_{leg}_mm"]) * np.array([math.cos(bearing), math.sin(bearing)])
        assert place == pytest.approx([0.0, 0.0], abs=1e-8)
        assert float(row["leg_2_mm"]) == pytest.approx(50.0)


@pytest.mark.parametrize("shape", ["rect1", "tri2", "ellip2"])
def test_the_rod_starts_in_contact_whatever_the_outline(shape) -> None:
    loop = CollectionLoop.mit(slider=Slider.mit(shape))
    (x, y), (dx, dy) = rod_start(loop, SidePush(angle=0.2))
    pushed = loop.model.push(loop.start_pose(0.0), SidePush(angle=0.2, distance=0.01))
    start, end = (np.array(loop.start_pose(0.0).to_object(*pushed.trajectory.pusher[k])) for k in (0, -1))
    assert start == pytest.approx([x, y], abs=1e-12)
    assert (end - start) / np.hypot(*(end - start)) == pytest.approx([dx, dy], abs=1e-9)


def test_the_comments_tell_strategy_seed_and_ring(schedule) -> None:
    text = schedule.read_text()
    for fact in (
        "# strategy: trailing leg + drawn pushes + gripper turn",
        "# seed: 3",
        "# cycles: 6",
        "# needs: gripper",
    ):
        assert fact in text.splitlines()
    assert "its ring at (-10.6066" in text


def damaged(path, change) -> None:
    path.write_text(change(path.read_text()))


def line_of(text: str, cycle: int) -> int:
    return next(n for n, line in enumerate(text.splitlines(), 1) if line.startswith(f"{cycle},"))


def replace_field(text: str, cycle: int, column: str, value: str) -> str:
    lines = text.splitlines()
    header = next(line for line in lines if line.startswith("cycle,")).split(",")
    at = line_of(text, cycle) - 1
    fields = lines[at].split(",")
    fields[header.index(column)] = value
    return "\n".join([*lines[:at], ",".join(fields), *lines[at + 1 :]]) + "\n"


@pytest.mark.parametrize(
    ("column", "value", "said"),
    [
        ("angle_deg", "x", "angle_deg is 'x'; it must be a finite number"),
        ("push_mm", "inf", "push_mm is 'inf'"),
        ("push_mm", "-3", "push distance must be positive"),
        ("side", "1.5", "side is '1.5'; it must be a whole number"),
        ("side", "9" * 5000, "it must be a whole number"),
        ("rod_x_mm", "", "rod_x_mm is ''"),
        ("fraction", "1e999999999999999999999", "it must be a finite number"),
        ("cycle", "7", "cycle is '7' where 2 should follow"),
        ("leg_2_direction_deg", "0.5", "leg_2 does not run from way_point_2"),
        ("way_point_1_x_mm", "", "way_point_1_x_mm is ''"),
        ("gripper_turn_deg", "nan", "gripper_turn_deg is 'nan'"),
    ],
)
def test_a_damaged_field_is_refused_with_its_line(schedule, column, value, said) -> None:
    text = schedule.read_text()
    schedule.write_text(replace_field(text, 2, column, value))
    with pytest.raises(DataFileError, match=said) as refusal:
        read_schedule(schedule)
    assert f"schedule.csv, line {line_of(text, 2)}" in str(refusal.value)


def test_a_way_point_moved_by_a_hundredth_of_a_micrometre_is_noticed(schedule) -> None:
    """Beside it stand direction and length of the leg, to a picometre."""
    text = schedule.read_text()
    header = next(line for line in text.splitlines() if line.startswith("cycle,")).split(",")
    told = float(text.splitlines()[line_of(text, 2) - 1].split(",")[header.index("way_point_1_x_mm")])
    schedule.write_text(replace_field(text, 2, "way_point_1_x_mm", repr(told + 1e-5)))
    with pytest.raises(DataFileError, match="leg_1 does not run from way_point_1"):
        read_schedule(schedule)


def test_a_way_point_whose_column_is_damaged_is_not_left_out_in_silence(schedule) -> None:
    schedule.write_text(schedule.read_text().replace("way_point_1_x_mm,", "way_point_1_x_m,"))
    with pytest.raises(DataFileError, match="unknown column 'way_point_1_x_m': did you mean 'way_point_1_x_mm'"):
        read_schedule(schedule)


@pytest.mark.parametrize("column", ["fraction", "push_mm"])
@pytest.mark.parametrize("value", ["1e9999999", "1e999998"])
def test_a_number_beyond_all_doubles_is_refused(schedule, column, value) -> None:
    schedule.write_text(replace_field(schedule.read_text(), 2, column, value))
    with pytest.raises(DataFileError, match=f"{column} is '{value}'; it must be a finite number"):
        read_schedule(schedule)


def test_a_promise_of_more_cycles_than_can_be_counted_is_refused(schedule) -> None:
    schedule.write_text(schedule.read_text().replace("# cycles: 6", f"# cycles: {'9' * 5000}"))
    with pytest.raises(DataFileError, match="'# cycles: N' is missing or damaged"):
        read_schedule(schedule)


def test_a_file_cut_anywhere_is_refused(schedule) -> None:
    """Every proper beginning of the file, at every character: none is read as a shorter schedule."""
    text = schedule.read_text()
    body = text.index("cycle,side")
    cuts = range(body, len(text), 7)
    for cut in cuts:
        schedule.write_text(text[:cut])
        with pytest.raises(DataFileError, match=r"schedule\.csv"):
            read_schedule(schedule)
    assert len(cuts) > 100


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda text: text.replace("# cycles: 6\n", ""), "'# cycles: N' is missing"),
        (lambda text: text.replace("push_mm,", "push,"), "push_mm is missing"),
        (lambda text: "\n".join(text.splitlines()[:-1]) + "\n", "5 cycles of the 6 that the comments promise"),
        (lambda text: "\n".join([*text.splitlines()[:-1], "6,0"]) + "\n", "2 of .* fields"),
    ],
)
def test_a_file_that_lacks_something_is_refused(schedule, change, said) -> None:
    schedule.write_text(change(schedule.read_text()))
    with pytest.raises(DataFileError, match=said):
        read_schedule(schedule)


def test_an_absent_file_and_a_folder_are_refused(tmp_path) -> None:
    with pytest.raises(DataFileError, match=r"none\.csv: there is no such file"):
        read_schedule(tmp_path / "none.csv")
    with pytest.raises(DataFileError, match="cannot be read"):
        read_schedule(tmp_path)


ACTIONS = tuple(CycleAction((), push, turn) for push, turn in zip((*PUSHES, PUSHES[0]), (0.1, 0.2, 0.1), strict=True))


def test_a_schedule_ends_or_begins_anew() -> None:
    once, again = ScheduledActions(ACTIONS), ScheduledActions(ACTIONS, repeats=True)
    assert once.actions(3, seed=1) == once.actions(3, seed=2) == ACTIONS
    assert again.actions(7) == (*ACTIONS, *ACTIONS, ACTIONS[0])
    with pytest.raises(InvalidInput, match="4 cycles are more than the 3 of the schedule"):
        once.actions(4)
    assert once.needs == ("gripper",)


def test_the_law_of_a_schedule_is_how_often_each_action_comes() -> None:
    once, again = ScheduledActions(ACTIONS).law(), ScheduledActions(ACTIONS, repeats=True).law()
    assert once.actions == ACTIONS[:2]
    assert once.weights == pytest.approx([2.0 / 3.0, 1.0 / 3.0])
    assert (again.actions, again.kind) == (ACTIONS, PERIODIC)
    assert ScheduledActions(ACTIONS[:1], repeats=True).law().kind == "independent"


@pytest.mark.parametrize("repeats", [True, False])
def test_sampling_a_schedule_from_its_maps_follows_the_mechanics(repeats) -> None:
    """Two routes to one path: the maps of the law, chosen cycle by cycle, and the full mechanics."""
    strategy, cycles = ScheduledActions(ACTIONS, repeats), 7 if repeats else 3
    maps = strategy_maps(LOOP, strategy, tolerance=1e-4)
    sampled = sample_strategy(maps, cycles, seed=2)
    run = run_strategy(LOOP, strategy, cycles, seed=2)
    assert sampled.theta == pytest.approx(run.theta, abs=2e-3)
    assert maps.computed == 2


def test_what_is_no_schedule_is_refused() -> None:
    with pytest.raises(InvalidInput, match="one CycleAction or more"):
        ScheduledActions(())
    with pytest.raises(InvalidInput, match="repeats must be True or False"):
        ScheduledActions(ACTIONS, repeats=1)
