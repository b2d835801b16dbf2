"""Tables as laboratories keep them: each read as the pushes that it holds, or refused with the
sentence that helps.
"""

import json
import math
import os
import zipfile

import numpy as np
import pytest
from foreign_tables import canonical, truth
from made_tables import (
    AFTER,
    BEFORE,
    NUMBERS,
    PUSHES,
    THETA,
    frame,
    plain,
    quaternions,
    saved,
    stream,
)
from refusals import refused

from cyclemap.errors import DataFileError, DoubtfulInput
from cyclemap.evidence import load_pushes
from cyclemap.evidence.pushes.theta0_pairs import read_theta0_pairs
from cyclemap.evidence.tables import own_files
from cyclemap.evidence.tables.data_kinds import FileKind, file_kind
from cyclemap.evidence.tables.own_tables import read_own_table

pandas = pytest.importorskip("pandas")

DEGREES = np.degrees(THETA)


def rows(header, form, order=NUMBERS):
    """A line for each orientation: of its number n, in degrees x, in radians r."""
    lines = [form.format(n=n, x=DEGREES[n], r=THETA[n]) for n in order]
    return "\n".join([header, *lines]) + "\n"


def with_commas(text):
    return text.replace(".", ",")


SHUFFLED = np.random.default_rng(2).permutation(PUSHES)
ORIENTATIONS = {
    "decimal commas alone": with_commas(rows("Orientation [deg]", "{x:.4f}")),
    "semicolons and decimal commas": with_commas(rows("Nr;Winkel vorher [°]", "{n};{x:.4f}")),
    "radians by their size": rows("yaw", "{r:.8f}"),
    "radians by name": rows("yaw (radians)", "{r:.8f}"),
    "trailing commas": rows("yaw_deg,mark,", "{x},1,"),
    "trailing commas below": rows("yaw_deg,mark", "{x},1,"),
    # The search for a unit takes a step a bracket, not one for every pair of them.
    "ten thousand brackets": rows("yaw_deg," + "[" * 10_000, "{x},1"),
    "a row a trial": rows("t,trial,yaw_deg", "{n}9.30,{n},{x}"),
    "a row a push": rows("t,yaw_deg", "{n}9.30,{x}"),
    "dates": rows("time,yaw_deg", "2026-11-20T10:{n:02}:30,{x}"),
    "out of order, numbered": rows("push,yaw_deg", "{n},{x}", SHUFFLED),
    "out of order, timed": rows("time,yaw_deg", "{n}9.30,{x}", SHUFFLED),
}


def orientations(path, *told):
    """What every command reads of the table: orientations before successive pushes."""
    text = read_own_table(path, *told).csv_text()
    return np.exp(1j * read_theta0_pairs(saved(path.parent, text, "read.csv")).theta)


def is_held(found):
    return np.allclose(found, np.exp(1j * THETA[:-1]), atol=1e-5)


@pytest.mark.parametrize("name", ORIENTATIONS)
def test_orientations_are_read_as_they_stand_and_what_was_guessed_or_sorted_is_said(
    tmp_path, name
) -> None:
    path = saved(tmp_path, ORIENTATIONS[name])
    assert file_kind(path) is FileKind.OTHER and is_held(orientations(path))
    words = " ".join(read_own_table(path).words)
    assert ("in rad, guessed" in words) == (name == "radians by their size")
    assert ("put in the order of their" in words) == name.startswith("out of order")


def test_columns_and_units_of_any_name_are_taken_as_told(tmp_path) -> None:
    pairs = pandas.DataFrame({"alpha": DEGREES[:-1], "beta": DEGREES[1:]})
    told = {"theta0": "alpha", "theta_next": "beta"}, ["deg"]
    path = saved(tmp_path, pairs)
    assert is_held(orientations(path, *told)) and not read_own_table(path, *told).guessed
    turns = saved(tmp_path, pandas.DataFrame({"yaw": DEGREES / 360.0}))
    refused(read_own_table, turns, told="are these turns, or radians")
    assert is_held(orientations(turns, None, ["turns"]))


@pytest.mark.parametrize("suffix", [".jsonl", ".ndjson", ".json"])
def test_rows_of_json_are_read_and_a_push_of_the_mit_layout_is_none(tmp_path, suffix) -> None:
    lines = [json.dumps({"rep": n, "object": {"yaw_deg": DEGREES[n]}}) for n in NUMBERS.tolist()]
    path = saved(tmp_path, "\n".join(lines), f"log{suffix}")
    assert file_kind(path) is FileKind.OTHER
    assert is_held(orientations(path, {"theta0": "object_yaw_deg"}))
    push = json.dumps({"object_pose": [], "tip_pose": [], "ft_wrench": []})
    assert file_kind(saved(tmp_path, push, "push.json")) is FileKind.RECORDS
    path.write_text('{"yaw_deg": 1}\n[1, 2]\n')
    refused(read_own_table, path, told="a row is an object")


def test_a_spreadsheet_is_read_and_one_cut_short_or_packed_too_tightly_is_refused(tmp_path) -> None:
    pytest.importorskip("openpyxl")
    path = tmp_path / "log.xlsx"
    columns = {"Push": NUMBERS, "Start angle (deg)": DEGREES, "Remark": ["ok"] * PUSHES}
    pandas.DataFrame(columns).to_excel(path, index=False)
    assert is_held(orientations(path))
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


def test_all_angles_and_all_places_are_guessed_in_one_unit(tmp_path) -> None:
    """Orientations after a push go on past a turn, and one end of a table in millimetres may lie
    near its origin.
    """
    table = frame("x0,y0,yaw0,x1,y1,yaw1").assign(x0=0.1, y0=1.5, x1=40, y1=-70)
    table["yaw1"] += 1.0
    found = read_own_table(saved(tmp_path, table)).columns
    assert table["yaw1"].max() > 7.0 and found["theta1"] == pytest.approx(table["yaw1"])
    assert found["x0"] == pytest.approx(1e-4) and found["y1"] == pytest.approx(-0.07)


@pytest.mark.parametrize(("spread", "random"), [(math.pi, True), (0.3, False)])
def test_orientations_set_at_random_are_told_from_those_that_a_reset_makes(
    tmp_path, spread, random
) -> None:
    starts = 1.0 + np.random.default_rng(3).uniform(-spread, spread, 100)
    poses = {"x0": 0, "y0": 0, "yaw0": starts, "x1": 0.04, "y1": -0.07, "yaw1": starts + 1.3}
    found = read_own_table(saved(tmp_path, pandas.DataFrame(poses)), units=["rad", "m"])
    assert any("no cycle among them" in line for line in found.words) == random
    again = load_pushes(saved(tmp_path, found.csv_text(), "read.csv")).table
    assert again["theta_next"].isna()[:-1].all() == random


def test_a_lerobot_data_set_has_a_push_an_episode(tmp_path) -> None:
    pytest.importorskip("pyarrow")
    (tmp_path / "meta").mkdir()
    (tmp_path / "data" / "chunk-000").mkdir(parents=True)
    names = {"names": ["block_x", "block_y", "block_angle"]}
    (tmp_path / "meta" / "info.json").write_text(
        json.dumps({"features": {"observation.state": names}})
    )
    shares = np.tile([0.0, 0.5, 1.0], PUSHES)[:, None]
    states = (1.0 - shares) * BEFORE.repeat(3, axis=0) + shares * AFTER.repeat(3, axis=0)
    table = {"episode_index": NUMBERS.repeat(3), "frame_index": np.tile([0, 1, 2], PUSHES)}
    pandas.DataFrame({"observation.state": [*states], **table}).to_parquet(
        tmp_path / "data" / "chunk-000" / "file-000.parquet"
    )
    columns = {"x": "block_x", "y": "block_y", "theta": "block_angle"}
    found = read_own_table(tmp_path, columns, ["rad", "m"])
    assert file_kind(tmp_path) is FileKind.OTHER
    assert any("24 pushes, one an episode" in line for line in found.words)
    assert found.columns["theta0"] == pytest.approx(THETA)
    assert found.columns["theta1"] == pytest.approx(AFTER[:, 2])


STAMPED = "geometry_msgs/msg/PoseStamped"


def bag(path, kind, topics=("/box", "/tip"), message=STAMPED, far=0.0):
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
    point, turn = kinds["geometry_msgs/msg/Point"], kinds["geometry_msgs/msg/Quaternion"]
    pose, count = kinds["geometry_msgs/msg/Pose"], {"seq": 0} if kind == "ros1" else {}
    with writer:
        joined = [writer.add_connection(name, message, typestore=store) for name in topics]
        for seconds, (x, y, angle) in zip(*stream(), strict=True):
            stamp = time(int(seconds), int(seconds % 1 * 1e9))
            told = (0.0, 0.0)
            if message == STAMPED:
                about = turn(0.0, 0.0, math.sin(0.5 * angle), math.cos(0.5 * angle))
                told = (pose(point(far + x, y, 0.0), about),)
            content = kinds[message](head(stamp=stamp, frame_id="world", **count), *told)
            for one in joined:
                writer.write(one, int(1e9 * seconds) + 1, written(content, message))


def has_the_pushes_of_the_stream(columns, far=0.0):
    """As exactly as mean poses of rests tell them."""
    turned, places = np.exp(1j * columns["theta0"]), columns["x1"] - far + 1j * columns["y1"]
    pushed = (0.46 + 0.15j) - 0.015 * np.exp(1j * (THETA[:12] + 1.0))
    is_turned = np.allclose(turned, np.exp(1j * THETA[:12]), atol=4e-3)
    return is_turned and np.allclose(places, pushed, atol=5e-4)


@pytest.mark.parametrize("kind", ["ros1", "sqlite", "mcap"])
def test_a_bag_of_any_kind_is_read_by_the_topic_of_the_objects_pose(tmp_path, kind) -> None:
    path = tmp_path / ("run.bag" if kind == "ros1" else "run")
    bag(path, kind)
    told = r"--columns pose=TOPIC; with poses: /box, /tip"
    refused(read_own_table, path, told=told, kind=DataFileError)
    for place in (path, *path.glob("*.mcap")):
        assert file_kind(place) is FileKind.OTHER
        assert has_the_pushes_of_the_stream(read_own_table(place, {"pose": "/box"}).columns)


def test_places_of_a_bag_are_metres_however_far_and_it_may_not_be_endless(
    tmp_path, monkeypatch
) -> None:
    bag(tmp_path / "run", "sqlite", ["/box"], far=12.0)
    assert has_the_pushes_of_the_stream(read_own_table(tmp_path / "run").columns, 12.0)
    monkeypatch.setattr(own_files, "_LARGEST_DECODED", 8 * 700)
    refused(read_own_table, tmp_path / "run", told="MB of numbers.*split it", kind=DataFileError)


@pytest.mark.parametrize("kind", ["ros1", "sqlite", "mcap"])
def test_a_bag_without_poses_or_cut_off_is_refused_with_what_gets_one_on(tmp_path, kind) -> None:
    suffix = ".bag" if kind == "ros1" else ""
    warm, path = tmp_path / f"warm{suffix}", tmp_path / f"run{suffix}"
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
    ("name", "content", "message"),
    [
        ("ab.csv", "alpha,beta\n1,2\n3,4\n", "--columns theta0=NAME; it has alpha, beta"),
        ("after.csv", "yaw,yaw_after\n1,2\n3,4\n", r"next one\? Say --columns theta1=yaw_after"),
        ("empty.csv", "yaw\n", "1 lines; a header and rows are wanted"),
        (
            "words.csv",
            "yaw,remark\nlots,none\nsome,few\n",
            "no column of numbers among yaw, remark",
        ),
        ("two.csv", "yaw_before,angle_start\n1,2\n3,4\n", "may both be theta0: say which"),
        ("short.csv", "yaw\n12\n", "1 pushes|0 pushes"),
        ("turned.csv", "qx,qy,qz\n0,0,1\n0,0,1\n", "of a quaternion all of qx, qy, qz, qw are wan"),
        ("wide.csv", "yaw,mark\n1,2,3\n4,5,6\n", "3 fields below 2 names: 1,2,3"),
        (
            "when.csv",
            "t,yaw\n0,1\n33,2\n66,3\n",
            "do several rows follow one push, .* --units s or",
        ),
        ("back.csv", "t,yaw\n3,1\n3,2\n3,3\n", "its times do not rise"),
        ("fake.xlsx", "yaw\n1\n2\n", "not a spreadsheet that can be read"),
        ("fake.parquet", "yaw\n1\n2\n", "not parquet that can be read"),
        ("rows.json", '{"columns": ["theta0_deg"], "data": [1, 2, 3]}', "0 rows"),
        ("keys.json", '{"theta0_deg": {"\u00b2": 1, "1": 2}}', "0 rows"),
        ("ways.json", 2 * '{"a": {"b": 1}, "a_b": 2}\n', "two values of a row are named a_b"),
        ("twins.json", '[{"yaw": 1, " yaw": 2}, {"yaw": 3}]', "two columns are named yaw"),
        ("more.json", '{"columns": ["yaw"], "data": [[1, 2], [3, 4]]}', "more numbers than the 1"),
        ("same.json", '{"columns": ["yaw", "yaw"], "data": [[1, 2], [3, 4]]}', "names tell apart"),
        ("below.csv", "1,2\n3,4\ntheta0_deg,b\n", "no names above its numbers"),
        ("10000.csv", "yaw_deg" + 9999 * ",b" + 999 * "\n1,1", "999 rows below 10000 names"),
        ("pushes.npz", b"PK\x03\x04\x14\x00\x00\x00", "holds bytes, not text: save its numbers"),
    ],
)
def test_what_cannot_be_read_is_refused_with_what_is_wanted(
    tmp_path, name, content, message
) -> None:
    refused(read_own_table, saved(tmp_path, content, name), told=message)


@pytest.mark.parametrize(
    ("columns", "told", "words"),
    [
        ({"yaw": 0.4 * NUMBERS}, {}, "radians, or degrees"),
        (
            {"yaw": 4.0 + np.random.default_rng(1).standard_normal(PUSHES)},
            {},
            "radians, or degrees",
        ),
        ({"yaw": 0.5 + 1.6 * np.cos(NUMBERS**2)}, {}, "radians, or degrees"),
        ({"yaw_deg": THETA, "surface": ["felt", "tin"] * 12}, {}, "surfaces, felt, tin: split"),
        ({"x0_px": NUMBERS, "y0_px": 0, "x1_px": 1, "y1_px": 2, "yaw_deg": 3}, {}, "its pixels by"),
        ({"yaw_deg": np.degrees(3.0 * THETA) % 180.0}, {}, "jump back by half a turn"),
        ({"push": 10 * NUMBERS, "yaw_deg": THETA}, {}, "their numbers do not go up by 1"),
        ({"t": np.repeat(NUMBERS, 2), "yaw_deg": 3.0}, {}, "keep the rows of the object alone"),
        (quaternions(BEFORE, "q{}", upright="x"), {}, "turn about neither z nor y"),
        ({"yaw": NUMBERS}, {"speed": "yaw"}, "--columns speed="),
        ({"yaw": NUMBERS}, {"theta0": "yaww"}, "no column yaww for theta0; it has yaw"),
        ({"yaw_deg": NUMBERS, "surface": "tin"}, {"theta0": "surface"}, "surface holds texts"),
    ],
)
def test_what_two_readings_are_possible_of_is_asked_for(tmp_path, columns, told, words) -> None:
    refused(read_own_table, saved(tmp_path, pandas.DataFrame(columns)), told, told=words)


@pytest.mark.parametrize("suffix", [".xlsx", ".parquet", ".mcap"])
def test_a_pipe_is_refused_and_not_waited_for_and_so_is_an_unknown_unit(tmp_path, suffix) -> None:
    path = tmp_path / f"pipe{suffix}"
    os.mkfifo(path)
    refused(read_own_table, path, told="is a pipe or a device", kind=DataFileError)
    refused(read_own_table, path, units=["furlongs"], told="--units furlongs")


@pytest.mark.parametrize("tilt", ["roll", "ry", "rot_x"])
def test_a_turn_about_z_beside_a_tilt_is_refused_and_beside_none_is_read(tmp_path, tilt) -> None:
    upright = "yaw" if tilt == "roll" else "rz"
    table = pandas.DataFrame({f"{upright}_deg": DEGREES, f"{tilt}_deg": 2})
    found = read_own_table(saved(tmp_path, table)).columns["theta0"]
    assert found == pytest.approx(THETA)
    message = f"{tilt}_deg reaches 180 degrees, so that {upright}_deg is not the turn"
    tilted = saved(tmp_path, table.assign(**{f"{tilt}_deg": 180}))
    refused(read_own_table, tilted, told=message, kind=DataFileError)


def test_columns_that_say_nothing_are_listed_and_names_there_twice_told_apart(tmp_path) -> None:
    header = "yaw_deg,surface,px,a,a,a.1,offset_mm"
    path = saved(tmp_path, rows(header, "{x},tin,0,1,2,3,4"))
    assert "not read: px, a, a.1, a.1.1, offset_mm" in read_own_table(path).words
    ours = frame("x0,y0,theta0,x1,y1,theta1")
    assert file_kind(saved(tmp_path, ours)) is not FileKind.OTHER
    own = saved(tmp_path, ours.assign(offset_mm=3.0))
    assert "not read: offset_mm" in read_own_table(own).words
    renamed = ours.rename(columns=lambda name: f"{name}_{'deg' if 'theta' in name else 'mm'}")
    assert file_kind(saved(tmp_path, renamed)) is FileKind.OTHER


@pytest.mark.parametrize(("name", "ends"), [("push", 1), ("episode", 1), ("episode", 2)])
def test_missing_rows_make_no_pair_across_them_and_are_told(tmp_path, name, ends) -> None:
    x, y, theta = np.stack([BEFORE, AFTER], axis=1)[:, :ends].reshape(-1, 3).T
    table = pandas.DataFrame({name: NUMBERS.repeat(ends), "x_m": x, "y_m": y, "yaw_rad": theta})
    own = read_own_table(saved(tmp_path, table[~table[name].isin([7, 8])]))
    assert "no pair across gaps in the numbers of the pushes: 1" in own.words
    turns = own.columns["theta_next"] - own.columns["theta0"]
    assert np.nanmax(turns) < 0.26


def test_runs_in_one_table_are_not_joined_however_they_are_numbered(tmp_path) -> None:
    """From nought in each, or on from one to the next; one orientation of each is not known."""
    for first in (0, PUSHES):
        numbers = np.concatenate([NUMBERS, first + NUMBERS])
        degrees = np.degrees(np.concatenate([THETA, THETA + 0.1])) % 360.0
        degrees[[7, PUSHES + 7]] = -999.0, np.nan
        columns = {"run": np.repeat(["a", "b"], PUSHES), "push": numbers, "yaw_deg": degrees}
        table = pandas.DataFrame(columns).sample(frac=1.0, random_state=0)
        own = read_own_table(saved(tmp_path, table))
        # Of 46 pairs within the runs four have one that is not known.
        assert len(own.columns["theta0"]) == 42
        assert "left out for want of an orientation: 2 of 48 rows" in own.words
        turns = (own.columns["theta_next"] - own.columns["theta0"]) % (2.0 * math.pi)
        assert turns == pytest.approx(0.21 * np.ones(42), abs=0.041)
    twice = saved(tmp_path, pandas.DataFrame({"push": NUMBERS // 2, "yaw_deg": DEGREES}))
    said = "there twice: rows are taken in their own order"
    assert any(said in line for line in read_own_table(twice).words)


def test_a_push_that_is_missing_in_one_run_is_not_followed_by_that_of_another(tmp_path) -> None:
    runs = [plain().assign(run=run, push=NUMBERS) for run in "ab"]
    own = read_own_table(saved(tmp_path, pandas.concat([runs[0].drop(index=7), runs[1]])))
    table = load_pushes(saved(tmp_path, own.csv_text(), "read.csv")).table
    assert len(table) == 47 and table["repetition"].is_unique
    # The last of each run, and the one before the missing one.
    assert table["theta_next"].isna().sum() == 3


@pytest.mark.parametrize("numbered", [True, False])
def test_rows_that_are_there_again_count_once(tmp_path, numbered) -> None:
    """By our names and by names of one's own, with numbers that then are whole, or without."""
    lines = canonical(truth(4).start, truth(4).end).splitlines()
    made = [f"{number},{line}" if numbered else line for number, line in enumerate(lines[1:41])]
    header = f"rep,{lines[0]}" if numbered else lines[0]
    for name, head in (("ours.csv", header), ("own.csv", header.replace("x0", "before_x"))):
        file = saved(tmp_path, "\n".join([head, *made[:30], *made[25:]]) + "\n", name)
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
    for made in ([lines[1]] * 4 + lines[1:30], [*lines[1:4], *lines[1:4], *[lines[5]] * 2] * 2):
        file = saved(tmp_path, "\n".join([lines[0], *made]) + "\n")
        assert len(load_pushes(file).table) == len(made)
        assert len(read_own_table(file).rows) == len(made)
