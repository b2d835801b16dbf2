"""A table of planned pushes comes back as it was filled in, by corners or by poses, in CSV or
Excel.
"""

import io
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from refusals import refused

import cyclemap as cm
from cyclemap.errors import DataFileError, DoubtfulInput
from cyclemap.evidence.identification.collected_blocks import collected_blocks
from cyclemap.evidence.measured_plan import empty_table
from cyclemap.evidence.plan_pushes import SetPush, candidate_pushes
from cyclemap.evidence.pushes.measured_strokes import push_noise, set_up_errors
from cyclemap.evidence.tables.data_kinds import FileKind, file_kind
from cyclemap.evidence.tables.planned_table import (
    filled_text,
    mark_columns,
    marks_of,
    pose_columns,
    table_bytes,
)
from cyclemap.mechanics import Pose, Slider

PLATE = replace(Slider.mit("tri1"), name="wedge")
LOOP = cm.CollectionLoop.mit("isotropic", slider=PLATE)
READ = (2e-3, math.radians(1.5))
PUSHES = candidate_pushes(LOOP, 5, math.radians(15.0), 0.15, 3)
STATES = [
    (one.start, Pose(0.03, -0.02, one.start.theta + 0.7), Pose(0.01, 0.04, one.start.theta - 0.3))
    for one in PUSHES
]


def filled(folder: Path, by: str = "corners", states: str = "012", excel: bool = False) -> Path:
    """The table of PUSHES with STATES filled in, to a hundredth of a millimetre."""
    header, rows = empty_table(LOOP, list[SetPush](PUSHES), READ, by)
    frame = pd.DataFrame(rows, columns=header)
    for number, poses in enumerate(STATES):
        for state, pose in zip("012", poses, strict=True):
            if state not in states:
                continue
            if by == "corners":
                told = [1e3 * part for mark in marks_of(PLATE) for part in pose.to_world(*mark)]
                names = mark_columns(state)
            else:
                told, names = (
                    [1e3 * pose.x, 1e3 * pose.y, math.degrees(pose.theta) % 360.0],
                    pose_columns(state),
                )
            for name, value in zip(names, told, strict=True):
                frame.loc[number, name] = round(value, 3)
    path = folder / f"plan.{'xlsx' if excel else 'csv'}"
    path.write_bytes(table_bytes(header, frame.to_numpy(dtype=object).tolist(), excel))
    return path


def as_read(path: Path) -> pd.DataFrame:
    assert file_kind(path) is FileKind.PLANNED
    return pd.read_csv(io.StringIO(filled_text(path)[0]))


@pytest.mark.parametrize(("by", "excel"), [("corners", False), ("pose", False), ("corners", True)])
def test_poses_and_rods_come_back_whichever_way_they_were_measured(
    tmp_path: Path, by: str, excel: bool
) -> None:
    if excel:
        pytest.importorskip("openpyxl")
    table = as_read(filled(tmp_path, by, excel=excel))
    assert (
        len(table) == len(PUSHES)
        and (table["error_mm"] == 2.0).all()
        and (table["frames_agree"] == 1).all()
    )
    for row, poses, planned in zip(table.to_dict("records"), STATES, PUSHES, strict=True):
        for names, pose in zip(
            (("x0", "y0", "theta0"), ("x1", "y1", "theta1"), ("x0n", "y0n", "theta_next")),
            poses,
            strict=True,
        ):
            x, y, theta = (row[name] for name in names)
            assert (x, y) == pytest.approx((pose.x, pose.y), abs=5e-6)
            assert math.remainder(theta - pose.theta, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-4)
        first, last = planned.rod(PLATE, LOOP.pusher.radius)
        assert [row[name] for name in ("tip_x0", "tip_y0", "tip_x1", "tip_y1")] == pytest.approx(
            [*first, *last], abs=2e-5
        )


def test_rows_may_stay_empty_and_drags_may_be_left_out(tmp_path: Path) -> None:
    path = filled(tmp_path, states="01")
    frame = pd.read_csv(path)
    frame.loc[1, list(mark_columns("1"))] = math.nan
    frame.to_csv(path, index=False)
    table = as_read(path)
    assert len(table) == len(PUSHES) - 1 and "x0n" not in table.columns
    frame.loc[:, list(mark_columns("1"))] = math.nan
    frame.to_csv(path, index=False)
    refused(filled_text, path, told="no push is filled in", kind=DataFileError)


def test_commas_of_a_spreadsheet_are_read(tmp_path: Path) -> None:
    path = filled(tmp_path)
    before = as_read(path)
    pd.read_csv(path).to_csv(path, index=False, sep=";", decimal=",")
    assert np.allclose(as_read(path).drop(columns="object"), before.drop(columns="object"))


def test_what_was_misread_is_refused_with_push_and_state(tmp_path: Path) -> None:
    path = filled(tmp_path)
    frame = pd.read_csv(path)
    frame.loc[2, ["a_x1_mm", "a_y1_mm"]] = frame.loc[2, ["b_x1_mm", "b_y1_mm"]].to_numpy()
    frame.to_csv(path, index=False)
    refused(
        filled_text,
        path,
        told="push 3: after the push marks a and b are .* mm apart",
        kind=DataFileError,
    )
    frame.loc[2, "a_x1_mm"] = math.nan
    frame.to_csv(path, index=False)
    refused(
        filled_text, path, told="push 3: after the push a_x1_mm is no number", kind=DataFileError
    )
    frame.drop(columns="way_x").to_csv(path, index=False)
    assert file_kind(path) is not FileKind.PLANNED


def test_a_pose_and_marks_that_contradict_each_other_are_refused_and_else_agree(
    tmp_path: Path,
) -> None:
    path = filled(tmp_path)
    frame = pd.read_csv(path)
    end = STATES[3][1]
    frame.loc[3, list(pose_columns("1"))] = (1e3 * end.x, 1e3 * end.y, math.degrees(end.theta))
    frame.to_csv(path, index=False)
    assert as_read(path).loc[3, "x1"] == pytest.approx(end.x, abs=1e-9)
    # A turn by 30 degrees moves a mark that is 50 mm and more from the middle by 26 mm and more.
    frame.loc[3, "theta1_deg"] += 30.0
    frame.to_csv(path, index=False)
    refused(
        filled_text,
        path,
        told="push 4: after the push marks and pose contradict .* mm",
        kind=DataFileError,
    )


def test_swapped_marks_are_warned_of_and_turned_objects_are_not(tmp_path: Path) -> None:
    path = filled(tmp_path)
    names = {
        f"{one}_{axis}{state}_mm": f"{other}_{axis}{state}_mm"
        for state in "012"
        for axis in "xy"
        for one, other in ("ab", "ba")
    }
    frame = pd.read_csv(path)
    frame.rename(columns=names).to_csv(path, index=False)
    with pytest.warns(
        DoubtfulInput,
        match="push 1: the object lay half a turn .* in 5 of 5 pushes: if marks a and b",
    ):
        filled_text(path)
    # A robot's frame may be turned against the room's: its poses are believed.
    path = filled(tmp_path, "pose")
    frame = pd.read_csv(path)
    frame["set_theta_deg"] += 180.0
    frame.to_csv(path, index=False)
    assert len(as_read(path)) == len(PUSHES)


@pytest.mark.parametrize(("copies", "rows"), [(1, 6), (2, 5)])
def test_a_push_that_is_read_twice_is_refused(tmp_path: Path, copies: int, rows: int) -> None:
    path = filled(tmp_path)
    frame = pd.read_csv(path)
    pd.concat([frame, frame[1:2]])[:rows].to_csv(path, index=False)
    paths = [tmp_path / f"read{number}.csv" for number in range(copies)]
    for copy in paths:
        copy.write_text(filled_text(path)[0])
    refused(
        collected_blocks,
        paths,
        LOOP,
        told="the push of .* again, all readings the same",
        kind=DataFileError,
    )


@pytest.mark.parametrize(
    ("column", "value", "words"),
    [
        ("push_mm", math.nan, "push 2: push_mm is no number"),
        ("push_mm", -80.0, "push 2: push_mm is -80"),
        ("way_y", math.inf, "push 2: way_y is no number"),
        ("mark_b_x_mm", math.nan, "push 2: mark_b_x_mm is no number"),
        ("error_mm", -1.0, "push 2: error_mm is -1: give 0 or more, or nothing"),
        ("error_deg", math.inf, "push 2: error_deg is inf"),
    ],
)
def test_what_was_planned_and_is_lost_is_refused_with_push_and_column(
    tmp_path: Path, column: str, value: float, words: str
) -> None:
    path = filled(tmp_path)
    frame = pd.read_csv(path)
    frame.loc[1, column] = value
    frame.to_csv(path, index=False)
    refused(filled_text, path, told=words, kind=DataFileError)


def test_a_robot_that_tells_its_rod_is_believed_and_its_frame_may_be_shifted(
    tmp_path: Path,
) -> None:
    path = filled(tmp_path, "pose")
    frame = pd.read_csv(path)
    frame[["rod_x0_mm", "rod_y0_mm", "rod_x1_mm", "rod_y1_mm"]] = (10.0, 20.0, 30.0, 45.0)
    frame.to_csv(path, index=False)
    table = as_read(path)
    assert (
        np.allclose(table[["tip_x0", "tip_y1"]], (0.01, 0.045))
        and "frames_agree" not in table.columns
    )
    # A row that was added by hand needs nothing that was planned.
    frame.loc[1, ["push_mm", "rod_x_mm", "way_x", "mark_a_x_mm"]] = math.nan
    frame.to_csv(path, index=False)
    assert len(as_read(path)) == len(PUSHES)


def test_identification_takes_the_errors_that_the_table_tells_and_frees_how_each_push_was_set_up(
    tmp_path: Path,
) -> None:
    path = tmp_path / "read.csv"
    path.write_text(filled_text(filled(tmp_path))[0])
    data = collected_blocks([path], LOOP)
    along, _, turned, dragged = push_noise(READ)
    sizes = {"push place (m)": along, "push turn (rad)": turned, "drag turn (rad)": dragged}
    assert data.noise == pytest.approx(sizes)
    shifts = [name for block in data.blocks for name in block.parameters if "_off" in name[:10]]
    assert shifts == [
        f"rod_off_{way}[push {number}]"
        for number in range(1, len(PUSHES) + 1)
        for way in ("x", "y", "turn")
    ]
    off, _, turned = set_up_errors(READ).tolist()
    beliefs = data.beliefs(["rod_off_y[push 2]", "rod_off_turn[push 5]", "pusher_friction"])
    assert beliefs == {
        "rod_off_y[push 2]": (0.0, off),
        "rod_off_turn[push 5]": (0.0, turned),
        "pusher_friction": (0.15, 0.05),
    }
    table = pd.read_csv(path).drop(columns=["error_mm", "error_deg", "frames_agree"])
    table.to_csv(tmp_path / "plain.csv", index=False)
    plain = collected_blocks([tmp_path / "plain.csv"], LOOP)
    assert plain.noise == {}
    assert {
        name for block in plain.blocks for name in block.parameters if name.startswith("tip_offset")
    }
