"""Tables as laboratories keep them: each read as the pushes that it holds, or refused with the
sentence that helps.
"""

import json
import math
import os
import zipfile
from itertools import pairwise

import numpy as np
import pytest
from foreign_tables import canonical, truth
from refusals import refused

from cyclemap.errors import DataFileError, DoubtfulInput
from cyclemap.evidence import load_pushes
from cyclemap.evidence.pushes.theta0_pairs import read_theta0_pairs
from cyclemap.evidence.tables import own_files
from cyclemap.evidence.tables.data_kinds import FileKind, file_kind
from cyclemap.evidence.tables.own_tables import read_own_table

pandas = pytest.importorskip("pandas")

# Orientations before twelve pushes, degrees, not wrapped, and the turn of each push.
THETA_DEG = 12.0 + 27.3 * np.arange(12)
WRAPPED = (THETA_DEG % 360.0).tolist()
TURN_DEG = 65.0 + np.cos(np.radians(THETA_DEG))


def orientations(tmp_path, path, columns=None, units=()):
    """What every command reads of the table: orientations before successive pushes, degrees."""
    target = tmp_path / "read.csv"
    target.write_text(read_own_table(path, columns, units).csv_text())
    return np.degrees(read_theta0_pairs(target).theta)


def wrapped(degrees):
    return (np.asarray(degrees) + 180.0) % 360.0 - 180.0


@pytest.mark.parametrize(
    ("text", "guessed"),
    [
        (
            "Nr;Winkel vorher [°]\n"
            + "".join(f"{n};{x:.4f}\n" for n, x in enumerate(WRAPPED)).replace(".", ","),
            False,
        ),
        ("yaw\n" + "".join(f"{math.radians(x):.8f}\n" for x in WRAPPED), True),
        # The search for a unit takes a step a bracket, not one for every pair of them.
        ("yaw_deg," + "[" * 10_000 + "\n" + "".join(f"{x},1\n" for x in WRAPPED), False),
    ],
    ids=["semicolons and decimal commas", "radians by their size", "ten thousand brackets"],
)
def test_columns_and_units_are_told_by_name_or_size_and_a_guess_is_said(
    tmp_path, text, guessed
) -> None:
    path = tmp_path / "messung.csv"
    path.write_text(text)
    assert file_kind(path) is FileKind.OTHER
    assert any("in rad, guessed" in line for line in read_own_table(path).words) == guessed
    assert wrapped(orientations(tmp_path, path)) == pytest.approx(wrapped(THETA_DEG[:-1]), abs=1e-4)


@pytest.mark.parametrize(
    "lines",
    [
        ["Orientation [deg]", *(f"{x:.4f}".replace(".", ",") for x in WRAPPED)],
        ["yaw (radians)", *(f"{math.radians(x) + 8.0 * math.pi:.6f}" for x in THETA_DEG)],
        ["yaw_deg,mark,", *(f"{x},1," for x in WRAPPED)],
        ["yaw_deg,mark", *(f"{x},1," for x in WRAPPED)],
        ["t,trial,yaw_deg", *(f"{9.3 * n:.2f},{n},{x}" for n, x in enumerate(WRAPPED))],
        ["t,yaw_deg", *(f"{9.3 * n:.2f},{x}" for n, x in enumerate(WRAPPED))],
        [
            "time,yaw_deg",
            *(f"2026-11-20T10:{n // 6:02}:{n % 6}0,{x}" for n, x in enumerate(WRAPPED)),
        ],
    ],
    ids=[
        "decimal commas alone",
        "radians by name",
        "trailing commas",
        "trailing commas below",
        "a row a trial",
        "a row a push",
        "dates",
    ],
)
def test_a_row_a_push_is_read_as_it_stands(tmp_path, lines) -> None:
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines) + "\n")
    assert wrapped(orientations(tmp_path, path)) == pytest.approx(wrapped(THETA_DEG[:-1]), abs=1e-4)


def test_all_angles_and_all_places_are_guessed_in_one_unit(tmp_path) -> None:
    """Orientations after a push go on past a turn, and one end of a table in millimetres may lie
    near its origin.
    """
    path = tmp_path / "poses.csv"
    ends = np.radians(np.array(WRAPPED) + 100.0)
    starts = zip(np.radians(WRAPPED), ends, strict=True)
    path.write_text(
        "x0,y0,yaw0,x1,y1,yaw1\n" + "".join(f"0.1,1.5,{a},40,-70,{b}\n" for a, b in starts)
    )
    found = read_own_table(path).columns
    assert ends.max() > 7.0 and found["theta1"] == pytest.approx(ends)
    assert found["x0"] == pytest.approx(1e-4) and found["y1"] == pytest.approx(-0.07)


@pytest.mark.parametrize(("spread", "random"), [(math.pi, True), (0.3, False)])
def test_orientations_set_at_random_are_told_from_those_that_a_reset_makes(
    tmp_path, spread, random
) -> None:
    path, starts = (
        tmp_path / "poses.csv",
        1.0 + np.random.default_rng(3).uniform(-spread, spread, 100),
    )
    path.write_text(
        "x0,y0,yaw0,x1,y1,yaw1\n" + "".join(f"0,0,{a},0.04,-0.07,{a + 1.3}\n" for a in starts)
    )
    found = read_own_table(path, units=["rad", "m"])
    assert any("no cycle among them" in line for line in found.words) == random
    (tmp_path / "read.csv").write_text(found.csv_text())
    assert load_pushes(tmp_path / "read.csv").table["theta_next"].isna()[:-1].all() == random


def test_a_spreadsheet_is_read_and_one_cut_short_or_packed_too_tightly_is_refused(tmp_path) -> None:
    pytest.importorskip("openpyxl")
    path = tmp_path / "log.xlsx"
    frame = pandas.DataFrame(
        {"Push": range(12), "Start angle (deg)": WRAPPED, "Remark": ["ok"] * 12}
    )
    frame.to_excel(path, index=False)
    assert wrapped(orientations(tmp_path, path)) == pytest.approx(wrapped(THETA_DEG[:-1]), abs=1e-9)
    whole = path.read_bytes()
    for content in (whole[:-40], whole[:600] + whole[640:]):
        path.write_bytes(content)
        refused(read_own_table, path, told="not a spreadsheet that can be read", kind=DataFileError)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as parts:
        parts.writestr("xl/worksheets/sheet1.xml", b" " * 100_000_000)
    assert path.stat().st_size < 200_000
    refused(read_own_table, path, told="holds 100 MB of numbers", kind=DataFileError)


def test_parquet_of_more_numbers_than_fit_is_refused_before_it_is_unpacked(tmp_path) -> None:
    pytest.importorskip("pyarrow")
    path = tmp_path / "still.parquet"
    pandas.DataFrame({"yaw": np.zeros(10_000_000)}).to_parquet(path)
    assert path.stat().st_size < 200_000
    refused(read_own_table, path, told="holds 80 MB", kind=DataFileError)


def test_columns_of_any_name_as_told(tmp_path) -> None:
    path = tmp_path / "pairs.csv"
    rows = pairwise(THETA_DEG)
    path.write_text("alpha,beta\n" + "".join(f"{a},{b}\n" for a, b in rows))
    told = {"theta0": "alpha", "theta_next": "beta"}
    assert wrapped(orientations(tmp_path, path, told, ["deg"])) == pytest.approx(
        wrapped(THETA_DEG[:-1])
    )
    assert not read_own_table(path, told, ["deg"]).guessed


def test_poses_in_millimetres_and_degrees_become_pushes(tmp_path) -> None:
    path = tmp_path / "poses.csv"
    x1 = 40.0 * np.cos(np.radians(THETA_DEG))
    rows = zip(THETA_DEG, x1, THETA_DEG + TURN_DEG, strict=True)
    header = "x_before_mm,y_before_mm,yaw_before_deg,x_after_mm,y_after_mm,yaw_after_deg\n"
    path.write_text(header + "".join(f"0,0,{a},{x},-70,{b}\n" for a, x, b in rows))
    target = tmp_path / "read.csv"
    target.write_text(read_own_table(path).csv_text())
    table = load_pushes(target).table
    assert np.degrees(table["dtheta"].to_numpy()) == pytest.approx(TURN_DEG)
    assert table["x1"].to_numpy() == pytest.approx(1e-3 * x1)
    assert table["y1"].unique() == pytest.approx([-0.07])


def test_missing_rows_make_no_pair_across_them_and_are_told(tmp_path) -> None:
    path = tmp_path / "gaps.csv"
    rows = [(n, x) for n, x in enumerate(THETA_DEG) if n not in (4, 5)]
    path.write_text("push,theta0_degrees\n" + "".join(f"{n},{x}\n" for n, x in rows) + "12,\n")
    found = read_own_table(path, {"theta0": "theta0_degrees"}, ["deg"])
    assert len(found.columns["theta0"]) == 8
    assert np.degrees(found.columns["theta_next"] - found.columns["theta0"]) == pytest.approx(27.3)
    assert any(
        "no pair across gaps in the numbers of the pushes: 1" in line for line in found.words
    )
    assert "left out for want of an orientation: 1 of 11 rows" in found.words


def stream(rate=30.0):
    """Two cycles of a tracked object: rest, push, rest, drag back, and again; t, x, y, theta
    (degrees).
    """
    t, x, theta = [], [], []
    marks = [(0.0, 10.0), (40.0, 75.0), (0.0, 22.0), (41.0, 86.0), (0.0, 35.0)]
    for (x0, a0), (x1, a1) in pairwise(marks):
        moving, still = np.linspace(0.0, 1.0, int(2 * rate)), np.ones(int(1.5 * rate))
        share = (
            np.concatenate([moving, still]) if t else np.concatenate([0.0 * still, moving, still])
        )
        x += (x0 + (x1 - x0) * share).tolist()
        theta += (a0 + (a1 - a0) * share).tolist()
        t = (np.arange(len(x)) / rate).tolist()
    return np.array(t), 1e-3 * np.array(x), np.array(theta)


def test_a_stream_of_poses_is_cut_at_its_rests_into_pushes_and_drags(tmp_path) -> None:
    t, x, theta = stream()
    path = tmp_path / "tracker.csv"
    half, still = np.radians(theta) / 2.0, 0.0 * x
    turn = {"qx": still, "qy": still, "qz": np.sin(half), "qw": np.cos(half)}
    frame = pandas.DataFrame({"timestamp": t, "x": x, "y": still, **turn})
    frame.to_csv(path, index=False)
    found = read_own_table(path)
    assert any("4 motions" in line for line in found.words)
    for unit, first in (("ms", 0), ("ns", 1_700_000_000_000_000_000)):
        counts = first + np.round(t * {"ms": 1e3, "ns": 1e9}[unit]).astype(np.int64)
        frame.assign(timestamp=counts).to_csv(tmp_path / "counts.csv", index=False)
        again = read_own_table(tmp_path / "counts.csv", units=["ms"] if unit == "ms" else [])
        assert again.columns["theta0"] == pytest.approx(found.columns["theta0"], abs=1e-6)
    assert np.degrees(found.columns["theta0"]) == pytest.approx([10.0, 22.0], abs=0.2)
    turned = np.degrees(found.columns["theta1"] - found.columns["theta0"])
    assert turned == pytest.approx([65.0, 64.0], abs=0.4)
    assert found.columns["x1"] == pytest.approx([0.040, 0.041], abs=5e-4)


def test_a_lerobot_data_set_has_a_push_an_episode(tmp_path) -> None:
    pytest.importorskip("pyarrow")
    home = tmp_path / "pusht"
    (home / "meta").mkdir(parents=True)
    (home / "data" / "chunk-000").mkdir(parents=True)
    names = ["block_x", "block_y", "block_angle"]
    (home / "meta" / "info.json").write_text(
        json.dumps({"features": {"observation.state": {"names": names}}})
    )
    rows = []
    for episode, (start, turn) in enumerate(zip(THETA_DEG, TURN_DEG, strict=True)):
        for share in (0.0, 0.5, 1.0):
            state = [0.1 * share, 0.02, math.radians(start + turn * share)]
            rows.append(
                {
                    "observation.state": state,
                    "episode_index": episode,
                    "frame_index": int(2 * share),
                }
            )
    pandas.DataFrame(rows).to_parquet(home / "data" / "chunk-000" / "file-000.parquet")
    columns = {"x": "block_x", "y": "block_y", "theta": "block_angle"}
    found = read_own_table(home, columns, ["rad", "m"])
    assert file_kind(home) is FileKind.OTHER and any(
        "12 pushes, one an episode" in line for line in found.words
    )
    assert np.degrees(found.columns["theta0"]) == pytest.approx(THETA_DEG)
    assert np.degrees(found.columns["theta1"] - found.columns["theta0"]) == pytest.approx(TURN_DEG)


def bag(path, kind, topics=("/box", "/tip"), message="geometry_msgs/msg/PoseStamped", far=0.0):
    """A recording of `stream` under each topic: ROS 1, ROS 2 as SQLite or MCAP; far : m along x."""
    pytest.importorskip("rosbags")
    from rosbags import rosbag1, rosbag2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if kind == "ros1" else Stores.LATEST)
    if kind == "ros1":
        writer = rosbag1.Writer(path)
    else:
        plugin = rosbag2.StoragePlugin.MCAP if kind == "mcap" else rosbag2.StoragePlugin.SQLITE3
        writer = rosbag2.Writer(path, version=9, storage_plugin=plugin)
    kinds, written = store.types, store.serialize_ros1 if kind == "ros1" else store.serialize_cdr
    time, head = kinds["builtin_interfaces/msg/Time"], kinds["std_msgs/msg/Header"]
    count = {"seq": 0} if kind == "ros1" else {}
    with writer:
        joined = [writer.add_connection(name, message, typestore=store) for name in topics]
        for seconds, place, angle in zip(*stream(), strict=True):
            header = head(
                stamp=time(int(seconds), int(seconds % 1 * 1e9)), frame_id="world", **count
            )
            if message == "geometry_msgs/msg/PoseStamped":
                half = math.radians(angle) / 2.0
                turn = kinds["geometry_msgs/msg/Quaternion"](
                    0.0, 0.0, math.sin(half), math.cos(half)
                )
                pose = kinds["geometry_msgs/msg/Pose"](
                    kinds["geometry_msgs/msg/Point"](far + place, 0.0, 0.0), turn
                )
                told = kinds[message](header, pose)
            else:
                told = kinds[message](header, place, 0.0)
            for one in joined:
                writer.write(one, int(1e9 * seconds) + 1, written(told, message))


@pytest.mark.parametrize("kind", ["ros1", "sqlite", "mcap"])
def test_a_bag_of_any_kind_is_read_by_the_topic_of_the_objects_pose(tmp_path, kind) -> None:
    path = tmp_path / ("run.bag" if kind == "ros1" else "run")
    bag(path, kind)
    assert file_kind(path) is FileKind.OTHER
    refused(
        read_own_table,
        path,
        told=r"--columns pose=TOPIC; with poses: /box, /tip",
        kind=DataFileError,
    )
    for place in (path, *path.glob("*.mcap")):
        found = read_own_table(place, {"pose": "/box"})
        assert file_kind(place) is FileKind.OTHER
        assert np.degrees(found.columns["theta0"]) == pytest.approx([10.0, 22.0], abs=0.2)
        assert found.columns["x1"] == pytest.approx([0.040, 0.041], abs=5e-4)


def test_places_of_a_bag_are_metres_however_far_and_it_may_not_be_endless(
    tmp_path, monkeypatch
) -> None:
    bag(tmp_path / "run", "sqlite", ["/box"], far=12.0)
    assert read_own_table(tmp_path / "run").columns["x1"] == pytest.approx(
        [12.040, 12.041], abs=5e-4
    )
    monkeypatch.setattr(own_files, "_LARGEST_DECODED", 8 * 700)
    refused(read_own_table, tmp_path / "run", told="MB of numbers.*split it", kind=DataFileError)


@pytest.mark.parametrize("kind", ["ros1", "sqlite", "mcap"])
def test_a_bag_without_poses_or_cut_off_is_refused_with_what_gets_one_on(tmp_path, kind) -> None:
    warm, path = (
        tmp_path / (f"{name}.bag" if kind == "ros1" else name) for name in ("warm", "run")
    )
    bag(warm, kind, ["/heat"], "sensor_msgs/msg/Temperature")
    told = r"give the topic of the object's pose, .*; with poses: none among /heat"
    refused(read_own_table, warm, told=told, kind=DataFileError)
    bag(path, kind)
    (content,) = [path] if kind == "ros1" else [*path.glob("*.db3"), *path.glob("*.mcap")]
    content.write_bytes(content.read_bytes()[: content.stat().st_size // 2])
    told = r"not a ROS bag that can be read .* one that was not closed is mended by"
    refused(read_own_table, path, {"pose": "/box"}, told=told, kind=DataFileError)


def test_an_mcap_file_of_another_house_is_refused_with_what_to_write_instead(tmp_path) -> None:
    bag(tmp_path / "run", "mcap")
    (file,) = (tmp_path / "run").glob("*.mcap")
    # The profile stands first in the file, behind its magic, the record's kind and two lengths.
    content = file.read_bytes()
    assert content[21:25] == b"ros2"
    file.write_bytes(content[:21] + b"json" + content[25:])
    told = "only MCAP of ROS 2 is; write what this one holds as a table of t,x,y,qx"
    refused(read_own_table, file, {"pose": "/box"}, told=told, kind=DataFileError)


@pytest.mark.parametrize(
    ("name", "content", "told", "message"),
    [
        (
            "ab.csv",
            "alpha,beta\n1,2\n3,4\n",
            {},
            "say which, --columns theta0=NAME; it has alpha, beta",
        ),
        (
            "after.csv",
            "yaw,yaw_after\n1,2\n3,4\n",
            {},
            r"or before the next one\? Say --columns theta1=yaw_after",
        ),
        ("speed.csv", "yaw\n1\n2\n3\n", {"speed": "yaw"}, "--columns speed="),
        ("empty.csv", "yaw\n", {}, "1 lines; a header and rows are wanted"),
        (
            "words.csv",
            "yaw,remark\nlots,none\nsome,few\n",
            {},
            "no column of numbers among yaw, remark",
        ),
        ("two.csv", "yaw_before,angle_start\n1,2\n3,4\n", {}, "may both be theta0: say which"),
        ("short.csv", "yaw\n12\n", {}, "1 pushes|0 pushes"),
        (
            "turned.csv",
            "qx,qy,qz\n0,0,1\n0,0,1\n",
            {},
            "of a quaternion all of qx, qy, qz, qw are wanted",
        ),
        ("told.csv", "yaw\n1\n2\n", {"theta0": "yaww"}, "no column yaww for theta0; it has yaw"),
        ("wide.csv", "yaw,mark\n1,2,3\n4,5,6\n", {}, "3 fields below 2 names: 1,2,3"),
        (
            "when.csv",
            "t,yaw\n0,1\n33,2\n66,3\n",
            {},
            "do several rows follow one push, .* --units s or ms",
        ),
        ("back.csv", "t,yaw\n3,1\n3,2\n3,3\n", {}, "its times do not rise"),
        ("fake.xlsx", "yaw\n1\n2\n", {}, "not a spreadsheet that can be read"),
        ("fake.parquet", "yaw\n1\n2\n", {}, "not parquet that can be read"),
    ],
)
def test_what_cannot_be_read_is_refused_with_what_is_wanted(
    tmp_path, name, content, told, message
) -> None:
    path = tmp_path / name
    path.write_text(content)
    refused(read_own_table, path, told, told=message)


@pytest.mark.parametrize("suffix", [".xlsx", ".parquet", ".mcap"])
def test_a_pipe_is_refused_and_not_waited_for_and_so_is_an_unknown_unit(tmp_path, suffix) -> None:
    os.mkfifo(tmp_path / f"pipe{suffix}")
    refused(
        read_own_table, tmp_path / f"pipe{suffix}", told="is a pipe or a device", kind=DataFileError
    )
    refused(read_own_table, tmp_path / f"pipe{suffix}", units=["furlongs"], told="--units furlongs")


def test_rows_out_of_order_are_put_in_order_by_their_numbers_or_times_and_that_is_said(
    tmp_path,
) -> None:
    order = np.random.default_rng(2).permutation(12)
    columns = {"push": np.arange(12), "time": 9.3 * np.arange(12)}
    for name, numbers in columns.items():
        path = tmp_path / f"{name}.csv"
        path.write_text(
            f"{name},yaw_deg\n" + "".join(f"{numbers[n]},{WRAPPED[n]}\n" for n in order)
        )
        assert any("put in the order of their" in line for line in read_own_table(path).words)
        assert wrapped(orientations(tmp_path, path)) == pytest.approx(
            wrapped(THETA_DEG[:-1]), abs=1e-4
        )
    path.write_text("push,yaw_deg\n" + "".join(f"{n // 2},{x}\n" for n, x in enumerate(WRAPPED)))
    assert any(
        "there twice: rows are taken in their own order" in line
        for line in read_own_table(path).words
    )


def test_columns_that_say_nothing_are_listed_and_names_of_surface_and_object_kept(tmp_path) -> None:
    path = tmp_path / "log.csv"
    header = "px,py,shape,x0_in,y0_in,theta0_turns,x1_in,y1_in,theta1_turns\n"
    rows = (f"0,1,hex,10,2,{a / 360.0},12,2,{(a + 65.0) / 360.0}\n" for a in THETA_DEG)
    path.write_text(header + "".join(rows))
    found = read_own_table(path)
    assert "not read: px, py" in found.words and set(found.columns["object"]) == {"hex"}
    assert found.columns["x1"] == pytest.approx(12 * 0.0254)
    assert np.degrees(found.columns["theta1"]) == pytest.approx(THETA_DEG + 65.0)


@pytest.mark.parametrize("suffix", [".jsonl", ".ndjson", ".json"])
def test_rows_of_json_are_read_and_a_push_of_the_mit_layout_is_none(tmp_path, suffix) -> None:
    path = tmp_path / f"log{suffix}"
    path.write_text(
        "".join(
            json.dumps({"rep": n, "object": {"yaw_deg": x}}) + "\n" for n, x in enumerate(WRAPPED)
        )
    )
    assert file_kind(path) is FileKind.OTHER
    told = {"theta0": "object_yaw_deg"}
    assert wrapped(orientations(tmp_path, path, told)) == pytest.approx(
        wrapped(THETA_DEG[:-1]), abs=1e-4
    )
    push = tmp_path / "push.json"
    push.write_text(json.dumps({"object_pose": [], "tip_pose": [], "ft_wrench": []}))
    assert file_kind(push) is FileKind.RECORDS
    path.write_text('{"yaw_deg": 1}\n[1, 2]\n')
    refused(read_own_table, path, told="a row is an object")


def test_what_may_be_turns_or_radians_and_a_stream_taken_for_pushes_is_refused(tmp_path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("yaw\n" + "".join(f"{x / 360.0}\n" for x in WRAPPED))
    refused(read_own_table, path, told="are these turns, or radians")
    assert wrapped(orientations(tmp_path, path, units=["turns"])) == pytest.approx(
        wrapped(THETA_DEG[:-1]), abs=1e-4
    )
    t, x, theta = stream()
    pandas.DataFrame({"stamp": t, "x": x, "alpha_deg": theta}).to_csv(path, index=False)
    refused(read_own_table, path, told="--columns theta=NAME")
    refused(
        read_own_table,
        path,
        {"theta0": "alpha_deg"},
        told="say --columns theta=alpha_deg in place of theta0",
    )


def test_numbers_that_go_on_from_run_to_run_make_no_pair_across_runs(tmp_path) -> None:
    rows = [("a", 0, 10), ("a", 1, 20), ("a", 2, 35), ("b", 3, 200), ("b", 4, 210), ("b", 5, 225)]
    lines = [f"{run},{number},{angle}" for run, number, angle in rows]
    (tmp_path / "runs.csv").write_text("\n".join(["run,push_nr,orientation_deg", *lines, ""]))
    pairs = np.degrees(read_own_table(tmp_path / "runs.csv").rows[["theta0", "theta_next"]])
    whole = pairs.dropna().to_numpy().round(6).tolist()
    assert whole == [[10.0, 20.0], [20.0, 35.0], [200.0, 210.0], [210.0, 225.0]]


@pytest.mark.parametrize("tilt", ["roll", "ry", "rot_x"])
def test_a_turn_about_z_beside_a_tilt_is_refused_and_beside_none_is_read(tmp_path, tilt) -> None:
    upright = "yaw" if tilt == "roll" else "rz"
    for degrees, name in ((2, "flat.csv"), (180, "tilted.csv")):
        lines = [f"{angle},{degrees}" for angle in (10, 100, 190, 250)]
        (tmp_path / name).write_text("\n".join([f"{upright}_deg,{tilt}_deg", *lines, ""]))
    read = read_own_table(tmp_path / "flat.csv").rows["theta0"]
    assert np.degrees(read).round(6).tolist() == [10.0, 100.0, 190.0, 250.0]
    message = f"{tilt}_deg reaches 180 degrees, so that {upright}_deg is not the turn"
    refused(read_own_table, tmp_path / "tilted.csv", told=message, kind=DataFileError)


def test_bytes_of_another_program_are_no_table(tmp_path) -> None:
    np.savez(tmp_path / "pushes.npz", theta0=np.arange(20.0))
    refused(read_own_table, tmp_path / "pushes.npz", told="holds bytes, not text: save its numbers")


@pytest.mark.parametrize("numbered", [True, False])
def test_rows_that_are_there_again_count_once(tmp_path, numbered) -> None:
    """By our names and by names of one's own, with numbers that then are whole, or without."""
    lines = canonical(truth(4).start, truth(4).end).splitlines()
    rows = [f"{number},{line}" if numbered else line for number, line in enumerate(lines[1:41])]
    header = f"rep,{lines[0]}" if numbered else lines[0]
    for name, head in (("ours.csv", header), ("own.csv", header.replace("x0", "before_x"))):
        file = tmp_path / name
        file.write_text("\n".join([head, *rows[:30], *rows[25:]]) + "\n")
        own = read_own_table(file)
        assert len(own.rows) == 40
        told = "5 of 45 rows are there again, all readings the same, and count once: the first, "
        assert f"{told}row 31, is row 26" in own.words
        if name == "ours.csv":
            with pytest.warns(DoubtfulInput, match=f"{told}line 32, is line 27"):
                pushes = load_pushes(file).table
            assert len(pushes) == 40 and pushes["theta_next"].count() == 39 * numbered


def test_coarse_readings_of_an_object_at_rest_are_no_rows_that_are_there_again(tmp_path) -> None:
    """Nor are a hand's three pushes alike in a table without numbers."""
    lines = canonical(truth(4).start, truth(4).end).splitlines()
    for rows in ([lines[1]] * 4 + lines[1:30], [*lines[1:4], *lines[1:4], *[lines[5]] * 2] * 2):
        file = tmp_path / "coarse.csv"
        file.write_text("\n".join([lines[0], *rows]) + "\n")
        assert len(load_pushes(file).table) == len(rows)
        assert len(read_own_table(file).rows) == len(rows)
