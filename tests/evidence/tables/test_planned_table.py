"""A table of planned pushes comes back as it was filled in, by corners or by poses, in CSV or
Excel.
"""

import io
import math
from collections.abc import Mapping
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


def told(pose: Pose, state: str, by: str) -> dict[str, float]:
    """What the table says of a pose, to a hundredth of a millimetre."""
    values = [1e3 * pose.x, 1e3 * pose.y, math.degrees(pose.theta) % 360.0]
    names = pose_columns(state)
    if by == "corners":
        values = [1e3 * part for mark in marks_of(PLATE) for part in pose.to_world(*mark)]
        names = mark_columns(state)
    return dict(zip(names, np.round(values, 3).tolist(), strict=True))


def filled(folder: Path, by: str = "corners", excel: bool = False) -> Path:
    """The table of PUSHES with STATES filled in."""
    header, rows = empty_table(LOOP, list[SetPush](PUSHES), READ, by)
    frame = pd.DataFrame(rows, columns=header)
    for number, poses in enumerate(STATES):
        for state, pose in zip("012", poses, strict=True):
            for name, value in told(pose, state, by).items():
                frame.loc[number, name] = value
    path = folder / f"plan.{'xlsx' if excel else 'csv'}"
    path.write_bytes(table_bytes(header, frame.to_numpy(dtype=object).tolist(), excel))
    return path


def altered(
    folder: Path, cells: Mapping[str, object], row: object = 1, by: str = "corners"
) -> Path:
    """The same with other values in columns of one row, from 0, or of all."""
    path = filled(folder, by)
    frame = pd.read_csv(path)
    frame.loc[row, [*cells]] = [*cells.values()]
    frame.to_csv(path, index=False)
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
    table = as_read(filled(tmp_path, by, excel))
    assert len(table) == len(PUSHES) and (table["error_mm"] == 2.0).all()
    assert (table["frames_agree"] == 1).all()
    states = (("x0", "y0", "theta0"), ("x1", "y1", "theta1"), ("x0n", "y0n", "theta_next"))
    for row, poses, planned in zip(table.to_dict("records"), STATES, PUSHES, strict=True):
        for names, pose in zip(states, poses, strict=True):
            x, y, theta = (row[name] for name in names)
            assert (x, y) == pytest.approx((pose.x, pose.y), abs=5e-6)
            assert math.remainder(theta - pose.theta, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-4)
        rod = [row[name] for name in ("tip_x0", "tip_y0", "tip_x1", "tip_y1")]
        first, last = planned.rod(PLATE, LOOP.pusher.radius)
        assert rod == pytest.approx([*first, *last], abs=2e-5)


NOT_PUSHED = dict.fromkeys(mark_columns("1"), math.nan)


def test_rows_may_stay_empty_and_drags_may_be_left_out(tmp_path: Path) -> None:
    assert len(as_read(altered(tmp_path, NOT_PUSHED))) == len(PUSHES) - 1
    undragged = altered(tmp_path, dict.fromkeys(mark_columns("2"), math.nan), slice(None))
    assert "x0n" not in as_read(undragged).columns


def test_commas_of_a_spreadsheet_are_read(tmp_path: Path) -> None:
    path = filled(tmp_path)
    before = as_read(path)
    pd.read_csv(path).to_csv(path, index=False, sep=";", decimal=",")
    assert np.allclose(as_read(path).drop(columns="object"), before.drop(columns="object"))


def test_a_pose_beside_marks_that_agree_with_it_is_taken(tmp_path: Path) -> None:
    end = STATES[3][1]
    table = as_read(altered(tmp_path, told(end, "1", "pose"), 3))
    assert table.loc[3, "x1"] == pytest.approx(end.x, abs=1e-6)


_PLACE_OF_B = told(STATES[2][1], "1", "corners")
# A turn by 30 degrees moves a mark that is 50 mm and more from the middle by 26 mm and more.
_TURNED = replace(STATES[3][1], theta=STATES[3][1].theta + math.radians(30.0))


@pytest.mark.parametrize(
    ("cells", "row", "words"),
    [
        ({"push_mm": math.nan}, 1, "push 2: push_mm is no number"),
        ({"push_mm": -80.0}, 1, "push 2: push_mm is -80"),
        ({"way_y": math.inf}, 1, "push 2: way_y is no number"),
        ({"mark_b_x_mm": math.nan}, 1, "push 2: mark_b_x_mm is no number"),
        ({"error_mm": -1.0}, 1, "push 2: error_mm is -1: give 0 or more, or nothing"),
        ({"error_deg": math.inf}, 1, "push 2: error_deg is inf"),
        ({"a_x1_mm": math.nan}, 2, "push 3: after the push a_x1_mm is no number"),
        (
            {f"a_{axis}1_mm": _PLACE_OF_B[f"b_{axis}1_mm"] for axis in "xy"},
            2,
            "push 3: after the push marks a and b are .* mm apart",
        ),
        (
            told(_TURNED, "1", "pose"),
            3,
            "push 4: after the push marks and pose contradict .* mm",
        ),
        (NOT_PUSHED, slice(None), "no push is filled in"),
    ],
)
def test_what_was_misread_or_lost_is_refused_with_push_and_column(
    tmp_path: Path, cells: Mapping[str, object], row: object, words: str
) -> None:
    refused(filled_text, altered(tmp_path, cells, row), told=words, kind=DataFileError)


def test_a_table_without_the_way_of_its_rods_is_no_plan(tmp_path: Path) -> None:
    path = filled(tmp_path)
    pd.read_csv(path).drop(columns="way_x").to_csv(path, index=False)
    assert file_kind(path) is not FileKind.PLANNED


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
    pd.read_csv(path).eval("set_theta_deg = set_theta_deg + 180.0").to_csv(path, index=False)
    assert len(as_read(path)) == len(PUSHES)


@pytest.mark.parametrize(("copies", "rows"), [(1, 6), (2, 5)])
def test_a_push_that_is_read_twice_is_refused(tmp_path: Path, copies: int, rows: int) -> None:
    path = filled(tmp_path)
    frame = pd.read_csv(path)
    pd.concat([frame, frame[1:2]])[:rows].to_csv(path, index=False)
    paths = [tmp_path / f"read{number}.csv" for number in range(copies)]
    for copy in paths:
        copy.write_text(filled_text(path)[0])
    again = "the push of .* again, all readings the same"
    refused(collected_blocks, paths, LOOP, told=again, kind=DataFileError)


def test_a_robot_that_tells_its_rod_is_believed_and_its_frame_may_be_shifted(
    tmp_path: Path,
) -> None:
    rod = {"rod_x0_mm": 10.0, "rod_y0_mm": 20.0, "rod_x1_mm": 30.0, "rod_y1_mm": 45.0}
    path = altered(tmp_path, rod, slice(None), "pose")
    table = as_read(path)
    assert np.allclose(table[["tip_x0", "tip_y1"]], (0.01, 0.045))
    assert "frames_agree" not in table.columns
    # A row that was added by hand needs nothing that was planned.
    frame = pd.read_csv(path)
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
