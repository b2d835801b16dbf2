"""The same pushes as many houses write them: each form is read as what happened, or refused with the
words that get on.
"""

import json
import math
from collections.abc import Callable
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from refusals import refused

from cyclemap.errors import InvalidInput
from cyclemap.evidence import load_pushes
from cyclemap.evidence.tables.data_kinds import FileKind, file_kind
from cyclemap.evidence.tables.own_tables import read_own_table

pandas = pytest.importorskip("pandas")

# Poses before and after pushes, m and rad.
PUSHES = 24
NUMBERS = np.arange(PUSHES)
THETA = 0.2 + 0.21 * NUMBERS + 0.02 * (-1.0) ** NUMBERS
BEFORE = np.column_stack([0.3 + 0.01 * np.cos(NUMBERS), 0.1 + 0.01 * np.sin(NUMBERS), THETA])
AFTER = BEFORE + np.column_stack(
    [0.04 + 0.002 * np.cos(THETA), 0.05 + 0.0 * THETA, 1.0 + 0 * THETA]
)
SCALED = (1e3, 1e3, math.degrees(1.0))


def frame(names, scale=(1.0, 1.0, 1.0)):
    """A row a push below six names of one's own."""
    return pandas.DataFrame(np.hstack([BEFORE * scale, AFTER * scale]), columns=names.split(","))


PLAIN = "x_before_mm,y_before_mm,yaw_before_deg,x_after_mm,y_after_mm,yaw_after_deg"


def plain():
    """Under plain names, in millimetres and degrees."""
    return frame(PLAIN, SCALED)


def lines(header=PLAIN, units="", sign=",", comment=""):
    """As text, below lines of a comment and above a row of units."""
    head, *rows = plain().to_csv(index=False, float_format="%.9f").splitlines()
    assert head == PLAIN
    above = [header, units] if units else [header]
    return comment + "\n".join([*above, *rows]).replace(",", sign) + "\n"


def quaternions(poses, name, parts="xyzw", upright="z"):
    """Quaternions about an upright axis, every third of the other sign."""
    sign = np.where(NUMBERS[: len(poses)] % 3 == 0, -1.0, 1.0)
    half = 0.5 * poses[:, 2]
    values = {"x": 0.0 * half, "y": 0.0 * half, "z": 0.0 * half, "w": sign * np.cos(half)}
    values[upright] = sign * np.sin(half)
    return {name.format(part): values[part] for part in parts}


def quaternions_of_ends():
    """A quaternion before each push, and one after it with w first."""
    places = {"start_x": BEFORE[:, 0], "start_y": BEFORE[:, 1]}
    places |= {"end_x": AFTER[:, 0], "end_y": AFTER[:, 1]}
    turned = quaternions(BEFORE, "start_q{}") | quaternions(AFTER, "end_q{}", "wxyz")
    return pandas.DataFrame(places | turned).to_csv(index=False)


def messages():
    """The fields of two messages of ROS in a row."""
    columns = {"header.stamp.secs": 1_700_000_000 + 20 * NUMBERS}
    for when, poses in (("before", BEFORE), ("after", AFTER)):
        columns |= {f"{when}.pose.position.{axis}": poses[:, k] for k, axis in enumerate("xy")}
        columns |= quaternions(poses, f"{when}.pose.orientation.{{}}")
    return pandas.DataFrame(columns).to_csv(index=False)


def rows_of_two():
    """A row before each push, and one after it."""
    rows = [
        [push, when, *poses[push]]
        for push in range(PUSHES)
        for when, poses in (("before", BEFORE), ("after", AFTER))
    ]
    names = ["push", "when", "x_m", "y_m", "yaw_rad"]
    return pandas.DataFrame(rows, columns=names).to_csv(index=False)


def with_a_failure(name, failed, done):
    """With a push that failed, which a column says."""
    lost = plain().iloc[[5]] + 300.0
    whole = pandas.concat([plain().iloc[:9], lost, plain().iloc[9:]])
    flags = [failed if row == 9 else done for row in range(PUSHES + 1)]
    return whole.assign(**{name: flags}).to_csv(index=False)


def units_in_fields():
    """Numbers with their units behind them."""
    table = frame("x0,y0,theta0,x1,y1,theta1", SCALED)
    for name in table:
        table[name] = table[name].map(("{:.9f}°" if "theta" in name else "{:.9f} mm").format)
    return table.to_csv(index=False)


def in_json(orient):
    """As pandas writes it."""
    return frame("x0,y0,theta0,x1,y1,theta1").to_json(orient=orient, double_precision=12)


SHORT = "x_vor [mm];y_vor [mm];Winkel_vor [°];x_nach [mm];y_nach [mm];Winkel_nach [°]"
FORMS: dict[str, Callable[[], str]] = {
    "quaternions.csv": quaternions_of_ends,
    "messages.csv": messages,
    "turns_about_z.csv": lambda: frame("x0,y0,rz0,x1,y1,rz1").to_csv(index=False),
    "row_of_units.csv": lambda: lines(
        "x0,y0,theta0,x1,y1,theta1", "[mm],[mm],[deg],[mm],[mm],[deg]"
    ),
    "fields_with_units.csv": units_in_fields,
    "comments.csv": lambda: lines(comment="% rig B\n% November\n") + "% end\n",
    "names_in_a_comment.csv": lambda: lines(comment="# "),
    "preamble.csv": lambda: lines(comment="Rig,B\nRate,120\n,,before,,,after\n"),
    "blanks.dat": lambda: lines(sign=" "),
    "german.csv": lambda: lines(SHORT, sign=";").replace(".", ","),
    "thousands.csv": lambda: (
        frame(PLAIN, SCALED)
        .map(lambda value: f"{value:,.9f}" if value < 1e3 else f'"{value:,.9f}"')
        .to_csv(index=False)
    ),
    "camel.csv": lambda: frame("xStart,yStart,yawStart,xEnd,yEnd,yawEnd").to_csv(index=False),
    "initial_final.csv": lambda: frame("xi,yi,thi,xf,yf,thf").to_csv(index=False),
    "records.json": lambda: in_json("records"),
    "columns.json": lambda: in_json("columns"),
    "split.json": lambda: in_json("split"),
    "under_a_key.json": lambda: json.dumps(
        {"rig": {"name": "B"}, "log": json.loads(in_json("records"))}
    ),
    "rows_of_two.csv": rows_of_two,
    "success.csv": lambda: with_a_failure("success", False, True),
    "failed.csv": lambda: with_a_failure("failed", 1, 0),
    "lengths.csv": lambda: plain().assign(push_mm=90.0).to_csv(index=False),
}


@pytest.mark.parametrize("name", FORMS)
def test_every_form_is_read_as_what_happened(tmp_path, name) -> None:
    path = tmp_path / name
    path.write_text(FORMS[name]())
    assert file_kind(path) is FileKind.OTHER
    columns = read_own_table(path).columns
    for end, poses in (("0", BEFORE), ("1", AFTER)):
        for column, true in zip(("x", "y", "theta"), poses.T, strict=True):
            off = columns[f"{column}{end}"] - true
            turns = 2.0 * math.pi if column == "theta" else 1.0
            assert off == pytest.approx(turns * np.round(off / turns), abs=1e-8)
    assert "repetition" not in columns or len(np.unique(columns["repetition"])) == PUSHES
    assert "length" not in columns or columns["length"] == pytest.approx(0.09)


@pytest.mark.parametrize("encoding", ["utf-16", "latin-1", "utf-8-sig"])
def test_the_text_may_be_in_the_encoding_of_another_system(tmp_path, encoding) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(lines(SHORT, sign=";").encode(encoding))
    assert read_own_table(path).columns["theta1"] == pytest.approx(AFTER[:, 2], abs=1e-8)


def test_the_sheet_that_has_the_pushes_is_read_and_one_of_two_is_asked_for(tmp_path) -> None:
    pytest.importorskip("openpyxl")
    path = tmp_path / "log.xlsx"
    notes = pandas.DataFrame({"key": ["rig", "date"], "value": ["B", "11-27"]})
    sheets = {"notes": notes, "monday": plain(), "tuesday": plain().iloc[:10]}
    for names in (["notes", "monday"], [*sheets]):
        with pandas.ExcelWriter(path) as book:
            for name in names:
                sheets[name].to_excel(book, sheet_name=name, index=False)
        if len(names) == 2:
            assert len(read_own_table(path).columns["x1"]) == PUSHES
    refused(read_own_table, path, told="monday, tuesday: say which, --columns sheet=monday")
    assert len(read_own_table(path, {"sheet": "tuesday"}).columns["x1"]) == 10


def stream(upright="z"):
    """Poses of an object that is pushed and dragged back by a ring at its centre, ten times a
    second.
    """
    poses, ring = [], np.array([0.015, 0.0])
    for theta, turn in zip(THETA[:12], np.diff(THETA[:13]), strict=True):
        home = np.array([0.4, 0.1, theta])
        pushed = home + np.array([0.06, 0.05, 1.0])
        later = home + np.array([0.0, 0.0, turn])
        for first, last in ((home, home), (home, pushed), (pushed, pushed), (pushed, later)):
            poses.append(first + np.linspace(0.0, 1.0, 20)[:, None] * (last - first))
    poses = np.concatenate([*poses, np.repeat(later[None], 20, axis=0)])
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    poses[:, 0] -= c * ring[0]
    poses[:, 1] -= s * ring[0]
    return 0.1 * np.arange(len(poses)), poses


def motion_capture():
    """As OptiTrack exports it: names below rows of headings, y up."""
    t, poses = stream()
    half = 0.5 * poses[:, 2]
    rows = [
        f"{n},{t[n]:.4f},0,{math.sin(half[n]):.9f},0,{math.cos(half[n]):.9f},"
        f"{1e3 * poses[n, 0]:.6f},20,{-1e3 * poses[n, 1]:.6f}"
        for n in range(len(t))
    ]
    above = ["Format,1.23,Length Units,Millimeters", ",Name" + 7 * ",box", ",ID" + 7 * ",1"]
    above += [",," + 4 * "Rotation," + "Position,Position,Position"]
    return "\n".join([*above, "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z", *rows]) + "\n"


def at_moments():
    """With dates and times of the day."""
    t, poses = stream()
    begin = datetime(2026, 11, 27, 23, 59, 30, tzinfo=UTC)
    moments = [(begin + timedelta(seconds=float(s))).isoformat(" ") for s in t]
    columns = {"datetime": moments, "x_m": poses[:, 0], "y_m": poses[:, 1], "yaw_rad": poses[:, 2]}
    return pandas.DataFrame(columns).to_csv(index=False)


def in_seconds_and_nanoseconds():
    """As ROS stamps its messages."""
    t, poses = stream()
    columns = {"header.stamp.secs": 1_700_000_000 + t.astype(int)}
    columns["header.stamp.nsecs"] = np.round(1e9 * (t % 1.0)).astype(int)
    columns |= {f"pose.position.{axis}": poses[:, k] for k, axis in enumerate("xy")}
    columns |= {"pose.orientation.x": 0.0, "pose.orientation.y": 0.0}
    columns |= {"pose.orientation.z": np.sin(0.5 * poses[:, 2])}
    columns |= {"pose.orientation.w": np.cos(0.5 * poses[:, 2])}
    return pandas.DataFrame(columns).to_csv(index=False)


@pytest.mark.parametrize("write", [motion_capture, at_moments, in_seconds_and_nanoseconds])
def test_a_stream_comes_apart_whatever_its_clock_and_its_upright_axis(tmp_path, write) -> None:
    path = tmp_path / "stream.csv"
    path.write_text(write())
    columns = read_own_table(path).columns
    turns = columns["theta1"] - columns["theta0"]
    assert turns == pytest.approx(np.ones(12), abs=2e-3)
    assert np.exp(1j * columns["theta0"]) == pytest.approx(np.exp(1j * THETA[:12]), abs=2e-3)


def test_rows_that_follow_a_moving_object_without_times_are_no_pushes(tmp_path) -> None:
    _, poses = stream()
    path = tmp_path / "stream.csv"
    pandas.DataFrame(poses, columns=["x_m", "y_m", "yaw_rad"]).to_csv(path, index=False)
    refused(read_own_table, path, told="no column tells their times: add one in seconds, t")


def test_pushes_are_not_told_from_drags_by_an_angle_alone(tmp_path) -> None:
    times, poses = stream()
    path = tmp_path / "stream.csv"
    pandas.DataFrame({"t_s": times, "yaw_rad": poses[:, 2]}).to_csv(path, index=False)
    refused(read_own_table, path, told="which motions push cannot be told of an angle alone")


def test_episodes_of_an_angle_alone_have_no_places(tmp_path) -> None:
    """Places of nought would be those of an object that no push moves."""
    path = tmp_path / "episodes.csv"
    angles = np.stack([THETA, THETA + 1.0], axis=1).ravel()
    rows = pandas.DataFrame({"episode": np.repeat(NUMBERS, 2), "yaw_deg": np.degrees(angles)})
    rows.to_csv(path, index=False)
    columns = read_own_table(path).columns
    assert not {"x0", "y0", "x1", "y1"} & {*columns}
    assert columns["theta0"] == pytest.approx(THETA)


@pytest.mark.parametrize(
    ("columns", "told"),
    [
        ({"yaw": 0.4 * NUMBERS}, "radians, or degrees"),
        ({"yaw": 4.0 + np.random.default_rng(1).standard_normal(PUSHES)}, "radians, or degrees"),
        ({"yaw_deg": THETA, "surface": ["felt", "tin"] * 12}, "several surfaces, felt, tin: split"),
        ({"x0_px": NUMBERS, "y0_px": 0, "x1_px": 1, "y1_px": 2, "yaw_deg": 3}, "its pixels by the"),
        ({"yaw": 0.5 + 1.6 * np.cos(NUMBERS**2)}, "radians, or degrees"),
        ({"yaw_deg": np.degrees(3.0 * THETA) % 180.0}, "jump back by half a turn"),
        ({"push": 10 * NUMBERS, "yaw_deg": THETA}, "their numbers do not go up by 1"),
        ({"t": np.repeat(NUMBERS, 2), "yaw_deg": 3.0}, "keep the rows of the object alone"),
        (quaternions(BEFORE, "q{}", upright="x"), "turn about neither z nor y"),
    ],
    ids=[
        "past a turn",
        "on one side",
        "two surfaces",
        "pixels",
        "near 0",
        "half turns",
        "tens",
        "two bodies",
        "lying",
    ],
)
def test_what_two_readings_are_possible_of_is_asked_for(tmp_path, columns, told) -> None:
    path = tmp_path / "log.csv"
    pandas.DataFrame(columns).to_csv(path, index=False)
    refused(read_own_table, path, told=told, kind=InvalidInput)


def test_runs_in_one_table_are_not_joined_and_what_is_no_number_is_left_out(tmp_path) -> None:
    path = tmp_path / "log.csv"
    runs = {"run": np.repeat(["a", "b"], PUSHES), "push": np.tile(NUMBERS, 2)}
    degrees = np.degrees(np.concatenate([THETA, THETA + 0.1])) % 360.0
    degrees[7] = -999.0
    table = pandas.DataFrame(runs | {"yaw_deg": degrees})
    table.sample(frac=1.0, random_state=0).to_csv(path, index=False)
    columns = read_own_table(path).columns
    # Of 46 pairs within the runs two have the lost one.
    assert len(columns["theta0"]) == 44
    turns = np.degrees(columns["theta_next"] - columns["theta0"]) % 360.0
    assert turns == pytest.approx(np.degrees(0.21) * np.ones(44), abs=np.degrees(0.041))


def test_a_push_that_is_missing_in_one_run_is_not_followed_by_that_of_another(tmp_path) -> None:
    path, again = tmp_path / "log.csv", tmp_path / "again.csv"
    runs = [plain().assign(run=run, push=NUMBERS) for run in "ab"]
    pandas.concat([runs[0].drop(index=7), runs[1]]).to_csv(path, index=False)
    again.write_text(read_own_table(path).csv_text())
    table = load_pushes(again).table
    assert len(table) == 47 and table["repetition"].is_unique
    # The last of each run, and the one before the missing one.
    assert table["theta_next"].isna().sum() == 3


def test_pushes_without_a_place_are_told_and_texts_are_said_to_be_read(tmp_path) -> None:
    path = tmp_path / "log.csv"
    table = plain().assign(shape=7, success=["maybe", *["yes"] * (PUSHES - 1)])
    table.loc[3, "x_after_mm"] = np.nan
    table.to_csv(path, index=False)
    own = read_own_table(path)
    assert f"left out for want of a pose: 1 of {PUSHES} rows" in own.words
    assert "shape read as object" in own.words and set(own.columns["object"]) == {"7"}
    table.assign(success=NUMBERS).to_csv(path, index=False)
    said = "what is read as good is neither yes nor no, and leaves no row out"
    assert said in read_own_table(path).words


def test_what_stands_for_no_number_tells_no_unit(tmp_path) -> None:
    path = tmp_path / "log.csv"
    table = frame("x0,y0,yaw0,x1,y1,yaw1")
    table.loc[[2, 5], "yaw1"] = -999.0
    table.to_csv(path, index=False)
    assert read_own_table(path).columns["theta0"] == pytest.approx(np.delete(THETA, [2, 5]))


def test_names_of_the_mit_dataset_are_known_beside_others(tmp_path) -> None:
    """Its t is an angle, and no time by which rows could be put in order."""
    path = tmp_path / "log.csv"
    facts = {"i": 2.0, "s": 0.25, "t": 0.3 * np.cos(NUMBERS), "v_mm_s": 20.0, "tip_err_mm": 0.5}
    frame("x0,y0,th0,x1,y1,th1").assign(note=1.0, **facts).to_csv(path, index=False)
    columns = read_own_table(path).columns
    assert columns["theta0"] == pytest.approx(THETA)
    assert columns["angle"] == pytest.approx(facts["t"]) and set(columns["side"]) == {2.0}
    assert columns["speed"] == pytest.approx(0.02) and columns["tip_error"] == pytest.approx(5e-4)


def test_columns_beside_our_own_are_not_passed_over(tmp_path) -> None:
    path = tmp_path / "log.csv"
    frame("x0,y0,theta0,x1,y1,theta1").assign(offset_mm=3.0).to_csv(path, index=False)
    assert "not read: offset_mm" in read_own_table(path).words
    for names in ("x0,y0,theta0,x1,y1,theta1", "x0_mm,y0_mm,theta0_deg,x1_mm,y1_mm,theta1_deg"):
        frame(names).to_csv(path, index=False)
        assert (file_kind(path) is FileKind.OTHER) == ("_mm" in names)


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("rows.json", '{"columns": ["theta0_deg"], "data": [1, 2, 3]}', "0 rows"),
        ("keys.json", '{"theta0_deg": {"\u00b2": 1, "1": 2}}', "0 rows"),
        ("ways.json", 2 * '{"a": {"b": 1}, "a_b": 2}\n', "two values of a row are named a_b"),
        ("twins.json", '[{"yaw": 1, " yaw": 2}, {"yaw": 3}]', "two columns are named yaw"),
        ("more.json", '{"columns": ["yaw"], "data": [[1, 2], [3, 4]]}', "more numbers than the 1"),
        ("same.json", '{"columns": ["yaw", "yaw"], "data": [[1, 2], [3, 4]]}', "names tell apart"),
        ("below.csv", "1,2\n3,4\ntheta0_deg,b\n", "no names above its numbers"),
        ("wide.csv", "yaw_deg" + 9999 * ",b" + 999 * "\n1,1", "999 rows below 10000 names"),
    ],
)
def test_what_is_no_table_is_refused_in_one_line(tmp_path, name, text, told) -> None:
    path = tmp_path / name
    path.write_text(text)
    refused(read_own_table, path, told=told)


def test_texts_are_no_numbers_and_names_there_twice_are_told_apart(tmp_path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("yaw_deg,surface,a,a,a.1\n10,tin,1,2,3\n20,tin,1,2,3\n40,tin,1,2,3\n")
    assert "not read: a, a.1, a.1.1" in read_own_table(path).words
    refused(read_own_table, path, {"theta0": "surface"}, told="surface holds texts")


@pytest.mark.parametrize("rows", [1, 2], ids=["a row a push", "two rows an episode"])
def test_no_pair_goes_across_an_episode_that_is_missing(tmp_path, rows) -> None:
    path = tmp_path / "log.csv"
    x, y, theta = np.stack([BEFORE, AFTER], axis=1)[:, :rows].reshape(-1, 3).T
    columns = {"episode": NUMBERS.repeat(rows), "x_m": x, "y_m": y, "yaw_rad": theta}
    table = pandas.DataFrame(columns)
    table[table["episode"] != 7].to_csv(path, index=False)
    own = read_own_table(path)
    assert "no pair across gaps in the numbers of the pushes: 1" in own.words
    turns = own.columns["theta_next"] - own.columns["theta0"]
    assert np.nanmax(turns) < 0.26


def test_parquet_keeps_texts_and_passes_over_lists_of_unlike_lengths(tmp_path) -> None:
    pytest.importorskip("pyarrow")
    path = tmp_path / "log.parquet"
    lists = [[1.0, 2.0], None, *[[3.0]] * (PUSHES - 2)]
    table = pandas.DataFrame({"yaw_deg": np.degrees(THETA), "lists": lists})
    table.to_parquet(path)
    assert np.allclose(read_own_table(path).columns["theta0"], THETA)
    table.assign(success=["no", *["yes"] * (PUSHES - 1)]).to_parquet(path)
    assert np.allclose(read_own_table(path).columns["theta0"], THETA[1:])
    table.assign(surface=["felt", "tin"] * 12).to_parquet(path)
    refused(read_own_table, path, told="several surfaces, felt, tin")


def test_a_column_of_moments_is_the_time_of_a_stream(tmp_path) -> None:
    pytest.importorskip("pyarrow")
    times, poses = stream()
    table = pandas.DataFrame(poses, columns=["x_m", "y_m", "yaw_rad"])
    moments = pandas.to_datetime(np.asarray(times) + 1.7e9, unit="s", utc=True)
    path = tmp_path / "log.parquet"
    table.assign(timestamp=moments).to_parquet(path)
    assert len(read_own_table(path).columns["theta0"]) == 12


@pytest.mark.parametrize(
    ("name", "units"), [("slant_deg", ()), ("slant", ("mm", "deg")), ("slant", ())]
)
def test_the_angle_of_pushes_is_told_in_degrees(tmp_path, name, units) -> None:
    path = tmp_path / "log.csv"
    plain().assign(**{name: 10.0}).to_csv(path, index=False)
    own = read_own_table(path, {"angle": name}, units)
    assert own.columns["angle"] == pytest.approx(math.radians(10.0) * np.ones(PUSHES))


def test_commas_that_may_be_decimal_or_part_thousands_are_asked_about(tmp_path) -> None:
    path = tmp_path / "log.csv"
    wide = frame("x0_mm,y0_mm,theta0_deg,x1_mm,y1_mm,theta1_deg", SCALED)
    wide.assign(x0_mm=[f"{960 + 10 * index:,}" for index in NUMBERS]).to_csv(path, index=False)
    refused(read_own_table, path, told="is 1,000 of x0_mm more than a thousand, or a decimal")
    wide.assign(x0_mm=[f"1,000,{100 + index}" for index in NUMBERS]).to_csv(path, index=False)
    assert read_own_table(path).columns["x0"] == pytest.approx(1000.1 + 1e-3 * NUMBERS)


def test_points_part_thousands_where_commas_are_decimal(tmp_path) -> None:
    path = tmp_path / "log.csv"
    wide = frame("x0_mm,y0_mm,theta0_deg,x1_mm,y1_mm,theta1_deg", SCALED).round(6).astype(str)
    wide = wide.map(lambda number: number.replace(".", ","))
    wide["x0_mm"] = [*["1.050", "950,5"], *["1.012,5"] * (PUSHES - 2)]
    wide.to_csv(path, index=False, sep=";")
    assert read_own_table(path).columns["x0"][:3] == pytest.approx([1.05, 0.9505, 1.0125])


def test_signs_of_thousands_are_told_by_the_column(tmp_path) -> None:
    path = tmp_path / "log.csv"
    wide = frame("x0_mm,y0_mm,theta0_deg,x1_mm,y1_mm,theta1_deg", SCALED)
    wide["x0_mm"] = [f"{1000 + 17.5 * index:,g}" for index in NUMBERS]
    wide.to_csv(path, index=False)
    x = read_own_table(path).columns["x0"]
    assert x == pytest.approx(1.0 + 0.0175 * NUMBERS)
