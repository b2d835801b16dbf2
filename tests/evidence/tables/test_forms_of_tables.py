"""The same pushes as many houses write them: each form is read as what happened, or refused with the
words that get on.
"""

import json
import math
from collections.abc import Callable
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from made_tables import (
    AFTER,
    BEFORE,
    NUMBERS,
    PLAIN,
    PUSHES,
    SCALED,
    THETA,
    frame,
    plain,
    quaternions,
    saved,
    stream,
)
from refusals import refused

from cyclemap.evidence.tables.data_kinds import FileKind, file_kind
from cyclemap.evidence.tables.own_tables import read_own_table

pandas = pytest.importorskip("pandas")


def lines(header=PLAIN, units="", sign=",", comment=""):
    """As text, below lines of a comment and above a row of units."""
    head, *rows = plain().to_csv(index=False, float_format="%.9f").splitlines()
    assert head == PLAIN
    above = [header, units] if units else [header]
    return comment + "\n".join([*above, *rows]).replace(",", sign) + "\n"


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
    path = saved(tmp_path, FORMS[name](), name)
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
    path = saved(tmp_path, lines(SHORT, sign=";").encode(encoding))
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


def clocked(**clock):
    """Poses below their times."""
    poses = pandas.DataFrame(stream()[1], columns=["x_m", "y_m", "yaw_rad"])
    return pandas.DataFrame(clock).join(poses)


def in_seconds_and_nanoseconds():
    """As ROS stamps its messages."""
    t, poses = stream()
    columns = {"header.stamp.secs": 1_700_000_000 + t.astype(int)}
    columns["header.stamp.nsecs"] = np.round(1e9 * (t % 1.0)).astype(int)
    columns |= {f"pose.position.{axis}": poses[:, k] for k, axis in enumerate("xy")}
    return pandas.DataFrame(columns | quaternions(poses, "pose.orientation.{}"))


TIMES = stream()[0]
MIDNIGHT = datetime(2026, 11, 27, 23, 59, 30, tzinfo=UTC)
MOMENTS = [MIDNIGHT + timedelta(seconds=seconds) for seconds in TIMES.tolist()]
STREAMS = {
    "motion capture": motion_capture(),
    "moments": clocked(datetime=[moment.isoformat(" ") for moment in MOMENTS]),
    "seconds and nanoseconds": in_seconds_and_nanoseconds(),
    "nanoseconds": clocked(timestamp=1_700_000_000_000_000_000 + np.int64(1e9 * TIMES)),
    "ms": clocked(timestamp=np.int64(1e3 * TIMES)),
}


def comes_apart(own):
    """Into the twelve pushes that were made."""
    columns = own.columns
    turns, begun = columns["theta1"] - columns["theta0"], np.exp(1j * columns["theta0"])
    is_made = np.allclose(begun, np.exp(1j * THETA[:12]), atol=4e-3)
    return is_made and np.allclose(turns, 1.0, atol=2e-3)


@pytest.mark.parametrize("name", STREAMS)
def test_a_stream_comes_apart_whatever_its_clock_and_its_upright_axis(tmp_path, name) -> None:
    path = saved(tmp_path, STREAMS[name])
    own = read_own_table(path, units=["ms", "m", "rad"] if name == "ms" else [])
    assert comes_apart(own) and any("24 motions" in line for line in own.words)


def test_parquet_keeps_texts_and_moments_and_passes_over_lists_of_unlike_lengths(tmp_path) -> None:
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
    clocked(timestamp=pandas.to_datetime(MOMENTS)).to_parquet(path)
    assert comes_apart(read_own_table(path))


X, Y, YAW = stream()[1].T


@pytest.mark.parametrize(
    ("columns", "names", "told"),
    [
        ({"x_m": X, "y_m": Y, "yaw_rad": YAW}, {}, "no column tells their times: add one in sec"),
        ({"t_s": TIMES, "yaw_rad": YAW}, {}, "which motions push cannot be told of an angle alone"),
        ({"stamp": TIMES, "x": X, "alpha": YAW}, {}, "--columns theta=NAME"),
        (
            {"stamp": TIMES, "x": X, "alpha": YAW},
            {"theta0": "alpha"},
            "say --columns theta=alpha in place of theta0",
        ),
    ],
)
def test_rows_that_follow_a_moving_object_without_what_tells_pushes_are_refused(
    tmp_path, columns, names, told
) -> None:
    refused(read_own_table, saved(tmp_path, pandas.DataFrame(columns)), names, told=told)


def test_episodes_of_an_angle_alone_have_no_places(tmp_path) -> None:
    """Places of nought would be those of an object that no push moves."""
    angles = np.stack([THETA, THETA + 1.0], axis=1).ravel()
    table = pandas.DataFrame({"episode": np.repeat(NUMBERS, 2), "yaw_deg": np.degrees(angles)})
    columns = read_own_table(saved(tmp_path, table)).columns
    assert not {"x0", "y0", "x1", "y1"} & {*columns}
    assert columns["theta0"] == pytest.approx(THETA)


def test_pushes_without_a_place_are_told_and_texts_are_said_to_be_read(tmp_path) -> None:
    table = plain().assign(shape=7, success=["maybe", *["yes"] * (PUSHES - 1)])
    table.loc[3, "x_after_mm"] = np.nan
    own = read_own_table(saved(tmp_path, table))
    assert f"left out for want of a pose: 1 of {PUSHES} rows" in own.words
    assert "shape read as object" in own.words and set(own.columns["object"]) == {"7"}
    own = read_own_table(saved(tmp_path, table.assign(success=NUMBERS)))
    assert "what is read as good is neither yes nor no, and leaves no row out" in own.words


def test_what_stands_for_no_number_tells_no_unit(tmp_path) -> None:
    table = frame("x0,y0,yaw0,x1,y1,yaw1")
    table.loc[[2, 5], "yaw1"] = -999.0
    columns = read_own_table(saved(tmp_path, table)).columns
    assert columns["theta0"] == pytest.approx(np.delete(THETA, [2, 5]))


def test_names_of_the_mit_dataset_are_known_beside_others(tmp_path) -> None:
    """Its t is an angle, and no time by which rows could be put in order."""
    facts = {"i": 2.0, "s": 0.25, "t": 0.3 * np.cos(NUMBERS), "v_mm_s": 20.0, "tip_err_mm": 0.5}
    table = frame("x0,y0,th0,x1,y1,th1").assign(note=1.0, **facts)
    columns = read_own_table(saved(tmp_path, table)).columns
    assert columns["theta0"] == pytest.approx(THETA)
    assert columns["angle"] == pytest.approx(facts["t"]) and set(columns["side"]) == {2.0}
    assert columns["speed"] == pytest.approx(0.02) and columns["tip_error"] == pytest.approx(5e-4)


@pytest.mark.parametrize(
    ("name", "units"), [("slant_deg", ()), ("slant", ("mm", "deg")), ("slant", ())]
)
def test_the_angle_of_pushes_is_told_in_degrees(tmp_path, name, units) -> None:
    path = saved(tmp_path, plain().assign(**{name: 10.0}))
    own = read_own_table(path, {"angle": name}, units)
    assert own.columns["angle"] == pytest.approx(math.radians(10.0) * np.ones(PUSHES))


WIDE = frame("x0_mm,y0_mm,theta0_deg,x1_mm,y1_mm,theta1_deg", SCALED)
THOUSANDS = {
    "two signs": WIDE.assign(x0_mm=[f"1,000,{n}" for n in 100 + NUMBERS]),
    "in some rows": WIDE.assign(x0_mm=[f"{n:,}" for n in (1000 + 17.5 * NUMBERS).tolist()]),
    "points": WIDE.round(6)
    .map(lambda number: f"{number}".replace(".", ","))
    .assign(x0_mm=[*["1.050", "950,5"], *["1.012,5"] * (PUSHES - 2)])
    .to_csv(index=False, sep=";"),
}


@pytest.mark.parametrize(
    ("name", "x"),
    [
        ("two signs", 1000.1 + 1e-3 * NUMBERS),
        ("in some rows", 1.0 + 0.0175 * NUMBERS),
        ("points", np.array([1.05, 0.9505, *[1.0125] * (PUSHES - 2)])),
    ],
)
def test_signs_of_thousands_are_told_by_the_column(tmp_path, name, x) -> None:
    assert read_own_table(saved(tmp_path, THOUSANDS[name])).columns["x0"] == pytest.approx(x)


def test_commas_that_may_be_decimal_or_part_thousands_are_asked_about(tmp_path) -> None:
    path = saved(tmp_path, WIDE.assign(x0_mm=[f"{n:,}" for n in (960 + 10 * NUMBERS).tolist()]))
    refused(read_own_table, path, told="is 1,000 of x0_mm more than a thousand, or a decimal")
