"""Pushes from CSV tables of poses and of θ0."""

import random
from pathlib import Path

import numpy as np
import pytest
from made_pushes import PUSH_NAME, made_push, turned, write

from cyclemap.errors import DataFileError
from cyclemap.evidence.pushes.push_table import load_pushes, read_push_csv
from cyclemap.evidence.pushes.theta0_pairs import read_theta0_pairs
from cyclemap.text_files import read_csv_table

POSES = "x0,y0,theta0,x1,y1,theta1"


def csv(folder: Path, text: str) -> Path:
    path = folder / "pushes.csv"
    path.write_text(text)
    return path


def test_poses_give_the_motion_in_the_initial_frame_and_the_shorter_turn(tmp_path) -> None:
    x1, y1 = turned(3.0, [0.03, -0.09]).tolist()
    text = f"shape,v_mm_s,{POSES.replace('theta', 'th')}\nhex,20,0,0,3.0,{x1},{y1},-2.8\n"
    row = load_pushes(csv(tmp_path, text)).table.iloc[0]
    assert (row.object, row.speed) == ("hex", 0.02)
    assert row[["dx", "dy", "dtheta"]].tolist() == pytest.approx([0.03, -0.09, 2 * np.pi - 5.8])
    assert row.theta1 == pytest.approx(2 * np.pi - 2.8)
    assert np.isnan(row.theta_next) and row[["surface", "side"]].isna().all()


def test_degrees_are_told_by_the_name_of_the_column(tmp_path) -> None:
    row = read_push_csv(csv(tmp_path, "x0,y0,theta0_deg,x1,y1,theta1_deg\n0,0,90,0,1,120\n"))[0]
    assert (row["dx"], row["dy"], row["dtheta"]) == pytest.approx((1.0, 0.0, np.pi / 6))


def test_a_table_written_to_csv_is_read_back_as_it_was(tmp_path) -> None:
    for number in range(3):
        write(tmp_path / "h5" / f"{PUSH_NAME}_rep={number:04d}.h5", made_push((0.3, 0.1, 0.4 * number), turn=8.0))
    table = load_pushes(tmp_path / "h5").table
    table.to_csv(tmp_path / "pushes.csv", index=False)
    again = load_pushes(tmp_path / "pushes.csv").table
    kept = [name for name in table.columns if name not in ("path", "samples")]
    assert len(again) == 3 and again["dtheta"].min() > 7.9
    for name in kept[2:]:
        assert again[name].to_numpy() == pytest.approx(table[name].to_numpy(), abs=1e-12, nan_ok=True)
    assert again[kept[:2]].equals(table[kept[:2]])


def test_the_next_start_in_a_table_of_poses_is_that_of_the_next_repetition(tmp_path) -> None:
    rows = "".join(f"{number},0,0,{0.5 * number},0,0,{0.5 * number + 1}\n" for number in (2, 0, 1, 5))
    table = load_pushes(csv(tmp_path, f"rep,{POSES}\n{rows}")).table
    assert table["repetition"].tolist() == [0, 1, 2, 5]
    assert (table["theta_next"] - table["theta0"]).tolist() == pytest.approx([0.5, 0.5, np.nan, np.nan], nan_ok=True)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (f"{POSES}\n0,0,0,0,0,left\n", "line 2: theta1 is 'left'"),
        (f"{POSES}\n0,0,0,0,0,0\n0,0,nan,0,0,0\n", "line 3: theta0 is 'nan'"),
        (f"{POSES}\n0,0,0,,0,0\n", "line 2: x1 is nan; it must be a number within 100"),
        (f"{POSES}\n350,0,0,0,0,0\n", "line 2: x0 is 350; it must be a number within 100 .SI units"),
        (f"speed,{POSES}\nfast,0,0,0,0,0,0\n", "line 2: speed is 'fast'"),
        (f"{POSES}\n0,0,0\n", "line 2: 3 of 6 fields"),
        ("when,what\n1,2\n", "line 1: the header is when,what"),
        ("", "the file is empty"),
    ],
)
def test_a_bad_table_is_refused_by_line_and_reported(tmp_path, text, said) -> None:
    path = csv(tmp_path, text)
    with pytest.raises(DataFileError, match=said):
        read_push_csv(path)
    loaded = load_pushes(tmp_path)
    assert loaded.table.empty and [entry.path for entry in loaded.unreadable] == [path]
    assert str(tmp_path) not in loaded.unreadable[0].reason


def test_measured_plywood_gives_the_pairs_of_its_staircase_in_order(measured_data: Path) -> None:
    path = measured_data / "plywood_rect1_theta0_2000.csv"
    table, pairs = load_pushes(path).table, read_theta0_pairs(path)
    assert len(table) == 1996
    assert np.array_equal(table["theta0"], pairs.theta) and np.array_equal(table["theta_next"], pairs.theta_next)
    assert set(range(2000)) - set(table["repetition"]) == {0, 1252, 1391, 1999}
    assert table["dtheta"].isna().all()


@pytest.mark.slow
def test_the_tree_of_measured_data_loads_whole_and_names_the_table_that_holds_no_pushes(measured_data: Path) -> None:
    loaded = load_pushes(measured_data)
    assert [entry.path.name for entry in loaded.unreadable] == ["mit_rect1_wrench_twist_v10.csv"]
    assert len(loaded.table) == 91 + 3492 + 1908 + 217 + 1119 + 1996
    ends = loaded.table[loaded.table["path"].str.endswith("endpoints_v10.csv")]
    assert len(ends) == 3492 and sorted(ends["object"].unique()) == ["ellip1", "hex", "rect1", "rect2"]
    assert ends["speed"].unique() == pytest.approx([0.01])
    # Pushes of 50 mm: none moves an object farther than the rod goes, give or take the measurement.
    assert np.hypot(ends["dx"], ends["dy"]).max() < 0.055


def test_measured_drag_backs_turn_the_object_as_their_own_column_says(measured_data: Path) -> None:
    path = measured_data / "mit_rect1_dragback_v10.csv"
    raw, loaded = read_csv_table(path), load_pushes(path).table
    said = sorted(raw.number(row, "dth_deg") for row in raw.rows)
    found = np.sort(np.rad2deg(loaded["theta_next"] - loaded["theta1"]))
    assert len(said) == 217 and found == pytest.approx(np.array(said), abs=2e-3)


@pytest.mark.slow
def test_damage_at_random_is_reported_or_loads_finite_poses(tmp_path) -> None:
    whole = f"rep,{POSES}\n" + "".join(f"{number},0.1,0.2,{number / 7:.4f},0.3,0.4,1.5\n" for number in range(8))
    outcome = {True: 0, False: 0}
    for seed in range(200):
        chance, damaged = random.Random(seed), bytearray(whole.encode())
        damaged[chance.randrange(len(damaged))] = chance.choice([*b'0e,"\n', chance.randrange(256)])
        path = tmp_path / "damaged.csv"
        path.write_bytes(damaged[: chance.choice([len(damaged), chance.randrange(len(damaged))])])
        loaded = load_pushes(path)
        assert loaded.table.empty == bool(loaded.unreadable)
        poses = loaded.table[["x0", "y0", "theta0", "x1", "y1", "theta1", "dx", "dy", "dtheta"]].to_numpy()
        assert np.isfinite(poses).all()
        outcome[loaded.table.empty] += 1
    assert min(outcome.values()) > 20
