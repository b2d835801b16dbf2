"""Pushes of files, folders and CSV tables become one table,
and what is wrong with a file is told."""

import os
from itertools import product
from pathlib import Path

import numpy as np
import pandas
import pytest
from made_pushes import PUSH_NAME, SCAN_NAME, made_push, made_scan, turned, write
from refusals import refused

from cyclemap.errors import DoubtfulInput
from cyclemap.evidence.pushes.push_table import PUSH_COLUMNS, SCAN_COLUMNS, load_pushes
from cyclemap.evidence.pushes.theta0_pairs import read_theta0_pairs
from cyclemap.text_files import read_csv_table

POSES = "x0,y0,theta0,x1,y1,theta1"


def csv(folder: Path, text: str) -> Path:
    path = folder / "pushes.csv"
    path.write_text(text)
    return path


def table_of(folder: Path, text: str) -> pandas.DataFrame:
    return load_pushes(csv(folder, text)).table


def test_poses_give_the_motion_in_the_initial_frame_and_the_shorter_turn(tmp_path) -> None:
    x1, y1 = turned(3.0, [0.03, -0.09]).tolist()
    text = f"shape,v_mm_s,{POSES.replace('theta', 'th')}\nhex,20,0,0,3.0,{x1},{y1},-2.8\n"
    row = table_of(tmp_path, text).iloc[0]
    assert (row.object, row.speed) == ("hex", 0.02)
    assert row[["dx", "dy", "dtheta"]].tolist() == pytest.approx([0.03, -0.09, 2 * np.pi - 5.8])
    assert row.theta1 == pytest.approx(2 * np.pi - 2.8)
    assert np.isnan(row.theta_next) and row[["surface", "side"]].isna().all()


def test_all_orientations_of_a_row_may_be_in_degrees(tmp_path) -> None:
    header = "x0,y0,theta0_deg,x1,y1,theta1_deg,theta_next_deg"
    table = table_of(tmp_path, f"{header}\n0,0,90,0,0.1,120,20\n0,0,20,0,0.1,90,395\n")
    assert np.degrees(table["theta_next"].to_numpy()) == pytest.approx([20.0, 35.0])
    assert np.degrees(table["dtheta"].to_numpy()) == pytest.approx([30.0, 70.0])
    assert table.loc[0, ["dx", "dy"]].tolist() == pytest.approx([0.1, 0.0])


def test_a_table_written_to_csv_is_read_back_as_it_was(tmp_path) -> None:
    repeated(tmp_path / "h5", {number: 0.4 * number for number in range(3)}, turn=8.0)
    table = load_pushes(tmp_path / "h5").table
    table.to_csv(tmp_path / "pushes.csv", index=False)
    again = load_pushes(tmp_path / "pushes.csv").table
    kept = [name for name in table.columns if name not in ("path", "samples", "line")]
    assert len(again) == 3 and again["dtheta"].min() > 7.9
    for name in kept[2:]:
        true = table[name].to_numpy()
        assert again[name].to_numpy() == pytest.approx(true, abs=1e-12, nan_ok=True)
    assert again[kept[:2]].equals(table[kept[:2]])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (f"{POSES}\n0,0,0,0,0,left\n", "line 2: theta1 is 'left'"),
        (f"{POSES}\n0,0,0,0,0,0\n0,0,nan,0,0,0\n", "line 3: theta0 is 'nan'"),
        (f"{POSES}\n0,0,0,,0,0\n", "x1 is ''; it must be a number, and 1 of 1 rows lack one"),
        (f"{POSES}\n350,0,0,0,0,0\n", "x0 is 350; it must be a number within 100 (SI units"),
        (f"speed,{POSES}\nfast,0,0,0,0,0,0\n", "line 2: speed is 'fast'"),
        (f"{POSES}\n0,0,0\n", "line 2: 3 of 6 fields"),
        ("when,what\n1,2\n", "line 1: the header is when,what"),
        ("", "the file is empty"),
    ],
)
def test_a_bad_table_is_refused_by_line_and_reported(tmp_path, text, said) -> None:
    path = csv(tmp_path, text)
    loaded = load_pushes(tmp_path)
    assert tuple(loaded.table.columns) == PUSH_COLUMNS and loaded.table.empty and loaded.scans.empty
    (bad,) = loaded.unreadable
    assert bad.path == path and said in bad.reason and str(tmp_path) not in bad.reason


def test_measured_plywood_gives_the_pairs_of_its_staircase_in_order(measured_data: Path) -> None:
    path = measured_data / "plywood_rect1_theta0_2000.csv"
    table, pairs = load_pushes(path).table, read_theta0_pairs(path)
    assert len(table) == 1996
    assert np.array_equal(table["theta0"], pairs.theta)
    assert np.array_equal(table["theta_next"], pairs.theta_next)
    assert {*range(2000)} - {*table["repetition"]} == {0, 1252, 1391, 1999}
    assert table["dtheta"].isna().all()


@pytest.mark.slow
def test_the_tree_of_measured_data_loads_whole_and_names_the_table_that_holds_no_pushes(
    measured_data: Path,
) -> None:
    loaded = load_pushes(measured_data)
    assert [entry.path.name for entry in loaded.unreadable] == ["mit_rect1_wrench_twist_v10.csv"]
    assert len(loaded.table) == 91 + 3492 + 1908 + 4718 + 217 + 1119 + 1996
    ends = loaded.table[loaded.table["path"].str.endswith("endpoints_v10.csv")]
    assert len(ends) == 3492 and {*ends["object"]} == {"ellip1", "hex", "rect1", "rect2"}
    assert ends["speed"].unique() == pytest.approx([0.01])
    # Pushes of 50 mm: none moves an object farther than the rod goes, give or take the measurement.
    assert np.hypot(ends["dx"], ends["dy"]).max() < 0.055


def test_measured_drag_backs_turn_the_object_as_their_own_column_says(measured_data: Path) -> None:
    path = measured_data / "mit_rect1_dragback_v10.csv"
    raw, loaded = read_csv_table(path), load_pushes(path).table
    said = sorted(raw.number(row, "dth_deg") for row in raw.rows)
    found = np.sort(np.rad2deg(loaded["theta_next"] - loaded["theta1"]))
    assert len(said) == 217 and found == pytest.approx(np.array(said), abs=2e-3)


def repeated(folder: Path, starts: dict[int, float], turn: float = 1.2) -> None:
    for number, start in starts.items():
        push = made_push(start=(0.35, -0.03, start), turn=turn)
        write(folder / f"{PUSH_NAME}_rep={number:04d}.h5", push)


def test_a_row_holds_the_facts_of_the_name_and_the_motion_of_the_series(tmp_path) -> None:
    push = made_push((0.3, 0.1, 3.0), (0.03, -0.09), 1.2, 0.12, 50)
    path = write(tmp_path / f"{PUSH_NAME}_rep=0007.h5", push)
    loaded = load_pushes(path)
    assert tuple(loaded.table.columns) == PUSH_COLUMNS
    assert tuple(loaded.scans.columns) == SCAN_COLUMNS
    assert (len(loaded.table), len(loaded.scans), loaded.unreadable) == (1, 0, ())
    row = loaded.table.iloc[0]
    assert (row.surface, row.object, row.path, row.samples) == ("plywood", "rect1", str(path), 50)
    facts = ["acceleration", "speed", "side", "fraction", "angle", "repetition"]
    assert row[facts].tolist() == [0.0, 0.02, 0.0, 0.7, 0.0, 7.0]
    assert row[["x0", "y0", "theta0", "theta1"]].tolist() == pytest.approx([0.3, 0.1, 3.0, 4.2])
    motion = row[["dx", "dy", "dtheta", "force_ratio"]].tolist()
    assert motion == pytest.approx([0.03, -0.09, 1.2, 0.12])
    place = np.array([0.3, 0.1]) + turned(3.0, [0.03, -0.09])
    assert [row.x1, row.y1] == pytest.approx(place)
    assert np.isnan(row.theta_next)


def test_a_scan_is_a_row_of_its_own_with_its_direction_and_forces(tmp_path) -> None:
    direction = np.deg2rad(210.0)  # the name's 30 degrees are where the stroke comes from
    path = write(tmp_path / f"{SCAN_NAME}.h5", made_scan(direction, along=2.0, across=0.3))
    loaded = load_pushes(path)
    assert loaded.table.empty and len(loaded.scans) == 1
    row = loaded.scans.iloc[0]
    assert (row.surface, row.object, row.path, row.samples) == ("plywood", "rect1", str(path), 60)
    facts = ["direction", "force_along", "force_across", "ratio"]
    assert row[facts].tolist() == pytest.approx([direction, 2.0, 0.3, 0.15])


def test_the_next_start_is_that_of_the_next_repetition_on_the_lift(tmp_path) -> None:
    # Each cycle turns the object by 0.5: the starts climb past half a turn, where recorded angles
    # wrap.
    repeated(tmp_path, {number: 2.0 + 0.5 * number for number in range(6)})
    table = load_pushes(tmp_path).table
    assert table["repetition"].tolist() == [0, 1, 2, 3, 4, 5]
    turns = (table["theta_next"] - table["theta0"]).to_numpy()
    assert turns[:5] == pytest.approx(0.5) and np.isnan(turns[5])
    assert table["theta0"].max() <= np.pi < table["theta_next"].max()


def test_no_successor_is_found_across_a_gap_another_set_or_folder_or_a_file_that_cannot_be_read(
    tmp_path,
) -> None:
    repeated(tmp_path / "plywood", {0: 0.0, 2: 0.1})
    repeated(tmp_path / "other", {1: 0.2, 3: 0.3})
    write(tmp_path / "plywood" / f"{PUSH_NAME.replace('v=20', 'v=50')}_rep=0001.h5", made_push())
    table = load_pushes(tmp_path).table
    assert len(table) == 5 and table["theta_next"].isna().all()
    repeated(tmp_path / "cut", dict.fromkeys(range(4), 0.3))
    (tmp_path / "cut" / f"{PUSH_NAME}_rep=0002.h5").write_bytes(b"cut")
    loaded = load_pushes(tmp_path / "cut")
    assert loaded.table["theta_next"].notna().tolist() == [True, False, False]
    assert len(loaded.unreadable) == 1


def test_rows_come_in_one_order_whatever_the_order_of_the_files(tmp_path) -> None:
    for place, (s, o, v) in enumerate(product("ba", "dc", (9, 10))):
        name = f"motion_surface={s}_shape={o}_a=0_v={v}_i=0.000_s=0.700_t=0.000.json"
        write(tmp_path / str(8 - place) / name, made_push())
    table = load_pushes(tmp_path).table
    order = list(zip(table["surface"], table["object"], table["speed"], strict=True))
    assert len(order) == 8 and order == sorted(order)


def test_a_file_of_unknown_name_or_object_has_all_but_what_that_tells(tmp_path) -> None:
    row = load_pushes(write(tmp_path / "tuesday.json", made_push())).table.iloc[0]
    assert row[["dx", "dy", "dtheta"]].tolist() == pytest.approx([0.03, -0.09, 1.2])
    unknown = ["surface", "object", "speed", "side", "angle", "repetition", "force_ratio"]
    assert row[unknown].isna().all()
    path = write(tmp_path / f"{PUSH_NAME.replace('rect1', 'butter')}.h5", made_push())
    row = load_pushes(path).table.iloc[0]
    assert row.object == "butter" and row.dtheta == pytest.approx(1.2) and np.isnan(row.force_ratio)


def test_bad_files_and_closed_folders_are_named_with_their_reasons_and_the_rest_is_kept(
    tmp_path, monkeypatch
) -> None:
    good, scandir = write(tmp_path / "set" / f"{PUSH_NAME}_rep=0000.h5", made_push()), os.scandir
    (tmp_path / "a-cut.h5").write_bytes(good.read_bytes()[:-1000])
    (tmp_path / "b-empty.json").touch()
    (tmp_path / "closed").mkdir()
    (tmp_path / "notes.md").write_text("passed over")

    def forbidding(place):
        if Path(place).name == "closed":
            raise PermissionError(13, "Permission denied", str(place))
        return scandir(place)

    monkeypatch.setattr(os, "scandir", forbidding)
    seen: list[float] = []
    loaded = load_pushes(tmp_path, progress=seen.append)
    assert len(seen) == 3 and seen == sorted(seen) and seen[-1] == 1.0
    assert loaded.table["path"].tolist() == [str(good)]
    reasons = {entry.path.name: entry.reason for entry in loaded.unreadable}
    said = {
        "a-cut.h5": "cut short or damaged",
        "b-empty.json": "empty",
        "closed": "entered (Permission denied)",
    }
    assert reasons.keys() == said.keys()
    assert all(words in reasons[name] for name, words in said.items())
    assert not any(str(tmp_path) in reason for reason in reasons.values())


def test_a_place_without_push_files_is_refused_by_name(tmp_path) -> None:
    (tmp_path / "notes.txt").write_text("nothing pushed yet")
    refused(load_pushes, tmp_path, told=f"{tmp_path}: the folder holds no push data")
    refused(load_pushes, tmp_path / "none", told="there is nothing there")


def test_rows_without_a_pose_are_left_out_and_told_and_other_empty_fields_do_no_harm(
    tmp_path,
) -> None:
    rows = [f"0,0,{0.1 * n},0.03,-0.07,{0.1 * n + 1.2},{'' if n == 4 else 0.7}" for n in range(20)]
    rows[7], rows[11] = "nan,nan,nan,0.03,-0.07,1.2,0.7", "0,0,0.1,,,,0.7"
    told = "2 of 20 rows left out for want of a pose, the first in line 9"
    with pytest.warns(DoubtfulInput, match=told):
        table = table_of(tmp_path, "\n".join([f"{POSES},fraction", *rows, ""]))
    assert len(table) == 18 and np.isnan(table["fraction"][table["line"] == 6.0]).all()


def test_places_in_millimetres_under_our_names_are_not_taken_for_metres(tmp_path) -> None:
    path = csv(tmp_path, f"{POSES}\n" + "".join(f"50,10,0.{n},80,-60,1.{n}\n" for n in range(10)))
    (bad,) = load_pushes(path).unreadable
    assert "moves the object by 76.16 m: are its places in millimetres? Say so" in bad.reason


def test_degrees_under_our_names_are_not_taken_for_radians_and_lifts_of_radians_are_no_degrees(
    tmp_path,
) -> None:
    """Places in metres, angles in degrees, of pushes from anywhere or one after the other; lifts
    that climb through three turns by pushes of 74 degrees and drags of -66.
    """
    anywhere = np.random.default_rng(4).uniform(0.0, 360.0, 12)
    after = 27.0 * np.arange(12.0)
    for begin in (anywhere, after):
        rows = "".join(f"0.3,0,{angle},0.33,0.01,{angle + 24.5}\n" for angle in begin)
        (bad,) = load_pushes(csv(tmp_path, f"{POSES}\n{rows}")).unreadable
        assert "are these degrees? Say so, --units deg" in bad.reason
        read = table_of(tmp_path, f"x0,y0,theta0_deg,x1,y1,theta1_deg\n{rows}")
        assert np.allclose(read["dtheta"], np.radians(24.5))
    lifted = "".join(f"0.3,0,{0.14 * n},0.33,0.01,{0.14 * n + 1.3}\n" for n in range(135))
    assert np.allclose(table_of(tmp_path, f"{POSES}\n{lifted}")["dtheta"], 1.3)


def test_folders_in_different_conventions_are_not_read_as_one(tmp_path) -> None:
    """Ends of pushes would be in one sense, and what is read of the records again in the other."""
    for folder in ("ours", "theirs"):
        write(tmp_path / folder / f"{PUSH_NAME}.json", made_push())
    (tmp_path / "theirs" / "collection.toml").write_text('[data]\nangles = "clockwise"\n')
    refused(load_pushes, tmp_path, told="read each of them alone")
    assert len(load_pushes(tmp_path, angles="clockwise").table) == 2
    assert len(load_pushes(tmp_path / "theirs").table) == 1
