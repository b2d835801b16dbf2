"""`cyclemap compare` from outside: its JSON, its picture, its words, and damaged data of every kind."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from cyclemap.cli.main import run
from cyclemap.collection import CollectionLoop
from cyclemap.maps import CircleMap, WrappedNormal, sample_staircase

KEYS = [
    "prediction",
    "data",
    "pushes",
    "ends_off",
    "cycle",
    "orientations",
    "directions",
    "staircase",
    "verdicts",
    "uncertified",
]
POSES = "rep,surface,shape,i,s,t,push_mm,x0,y0,theta0,x1,y1,theta1\n"


@pytest.fixture
def here(tmp_path, monkeypatch) -> Path:
    """An empty current folder; few simulated collections for what takes longest; a loop whose map is at hand."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("cyclemap.evidence.comparison.compare.MOST_DETAILED", 19)
    given = CircleMap.arnold(0.11, 0.6)
    monkeypatch.setattr(CollectionLoop, "circle_map", lambda self, tolerance=1e-6, progress=None: given)
    return tmp_path


def orientation_file(folder: Path, cycles: int = 120) -> Path:
    path = sample_staircase(CircleMap.arnold(0.11, 0.6), WrappedNormal(0.1), cycles, seed=1).theta
    file = folder / "measured.csv"
    file.write_text("theta0_deg\n" + "".join(f"{math.degrees(theta) % 360:.4f}\n" for theta in path))
    return file


def pose_file(folder: Path) -> Path:
    loop, lines = CollectionLoop.mit("plywood"), [POSES]
    for number, theta in enumerate(np.linspace(0.1, 6.0, 5)):
        push = loop.model.push(loop.start_pose(float(theta)), loop.push)
        (dx, dy), c, s = push.displacement, np.cos(theta), np.sin(theta)
        end = f"{c * dx - s * dy},{s * dx + c * dy},{theta + push.turn}"
        lines.append(f"{number},plywood,rect1,0,0.7,0,150,0,0,{theta},{end}\n")
    file = folder / "poses.csv"
    file.write_text("".join(lines))
    return file


def strict_json(text: str) -> dict:
    return json.loads(text, parse_constant=lambda name: pytest.fail(f"JSON holds {name}"))


@pytest.mark.slow
def test_json_tells_everything_that_was_asked_and_nothing_else(here, capsys) -> None:
    data = orientation_file(here)
    told = ["--set", "noise_deg=5.7", "--first", "20", "--runs", "19", "--json", "-", "--out", "pictures"]
    assert run(["compare", "plywood", "--data", str(data), *told]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    report = strict_json(shown.out)
    assert list(report) == KEYS
    assert report["prediction"] == {
        "material": "plywood",
        "kind": "loop",
        "noise_deg": pytest.approx(5.7),
        "posterior_samples": 0,
        "refitted": False,
    }
    assert report["data"] == {"cycles": 100, "left_out": {"among the first": 20}, "unreadable_files": 0}
    assert report["pushes"] == []
    assert report["cycle"]["rms_deg"] == pytest.approx(math.degrees(0.1), rel=0.3)
    assert 0.05 <= report["orientations"]["watson"]["p_value"] <= 1.0
    histogram = report["orientations"]["histogram"]
    assert 5.0 * sum(histogram["measured_per_deg"]) == pytest.approx(1.0)
    assert 5.0 * sum(histogram["predicted_per_deg"]) == pytest.approx(1.0)
    assert len(report["directions"]["predicted"]) == 1
    assert report["staircase"]["turns"]["lower"] <= report["staircase"]["turns"]["upper"]
    assert all({"question", "agrees", "words"} == set(one) for one in report["verdicts"])
    written = {path.name: path.read_bytes() for path in (here / "pictures").iterdir()}
    assert set(written) == {"compare_plywood.png", "compare_plywood.json"}
    assert written["compare_plywood.png"].startswith(b"\x89PNG")
    assert written["compare_plywood.json"].decode() == shown.out


@pytest.mark.slow
def test_people_get_sentences_first_and_tables_second(here, capsys) -> None:
    assert run(["compare", "plywood", "--data", str(pose_file(here)), "--runs", "19", "--format", "svg"]) == 0
    shown = capsys.readouterr().out
    lines = shown.splitlines()
    assert lines[0].startswith("plywood agrees with the data in ")
    assert lines[1].startswith("Compared: 5 pushes with end poses and 4 cycles")
    sentence, table = shown.index("The mean Δx of rect1 on plywood agrees within its error"), shown.index("std %")
    assert sentence < table
    assert (here / "out" / "compare_plywood.svg").read_bytes().startswith(b"<?xml")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["plywod"], "plywood"),
        (["plywood", "--set", "noise_deg=0"], "noise_deg"),
        (["plywood", "--runs", "3"], "runs"),
        (["plywood", "--first", "1000"], "first is 1000"),
        (["plywood", "--first", "-1"], "first"),
        (["plywood", "--select", "surface=delrin"], "orientations alone and tell no surface"),
        ([], "material"),
    ],
)
def test_bad_use_is_one_line_and_exit_2(here, capsys, arguments, told) -> None:
    data = orientation_file(here)
    assert run(["compare", *arguments, "--data", str(data)]) == 2
    shown = capsys.readouterr()
    assert told in shown.err
    assert len(shown.err.splitlines()) == 1
    assert list(here.iterdir()) == [data]


@pytest.mark.slow
def test_what_the_data_do_not_hold_is_refused_and_a_length_can_be_said(here, capsys) -> None:
    data = pose_file(here)
    assert run(["compare", "plywood", "--data", str(data), "--select", "surface=delrin"]) == 2
    assert capsys.readouterr().err == "error: no such surface: delrin; the data have plywood\n"
    data.write_text(data.read_text().replace("0.7,0,150,", "0.7,0,,"))
    assert run(["compare", "plywood", "--data", str(data)]) == 2
    assert "do not tell how far the rod moved" in capsys.readouterr().err
    told = ["--set", "push_mm=150", "--runs", "19", "--json", "-"]
    assert run(["compare", "plywood", "--data", str(data), *told]) == 0
    report = strict_json(capsys.readouterr().out)
    assert report["pushes"][0]["push_mm"] == pytest.approx(150.0)
    assert report["pushes"][0]["dx_mm"]["rmse"] < 1e-3


def damaged(folder: Path) -> list[Path]:
    """Data paths that are none, cut short, of the wrong kind, or hold what no push can."""
    good = orientation_file(folder).read_text()
    poses = pose_file(folder).read_text()
    (folder / "empty").mkdir()
    (folder / "cut").mkdir()
    files = {
        "header.csv": "theta0_deg\n",
        "nothing.csv": "",
        "one.csv": "theta0_deg\n12.0\n",
        "word.csv": good.replace("\n", "\nhalf\n", 1),
        "nan.csv": good + "nan\n",
        "columns.csv": "a,b\n1,2\n",
        "pose_text.csv": poses.replace("rect1,0,0.7,0,150,0,0", "rect1,0,0.7,0,150,zero,0", 1),
        "pose_far.csv": poses.replace("rect1,0,0.7,0,150,0,0", "rect1,0,0.7,0,150,1e9,0", 1),
        "pose_short.csv": poses[:-20].rsplit(",", 2)[0],
        "other.csv": poses.replace("plywood", "abs"),
        "text.h5": "not HDF5",
        "data.txt": good,
        "cut/push.json": '{"object_pose": [[0, 0,',
        "list.json": "[1, 2, 3]",
    }
    for name, text in files.items():
        (folder / name).write_text(text)
    (folder / "bytes.csv").write_bytes(b"\xff\xfe\x00theta0_deg\n1\n")
    named = [folder / name for name in files if name != "cut/push.json"]
    return [*named, folder / "bytes.csv", folder / "empty", folder / "cut", folder / "missing.csv", folder / "missing"]


def test_damaged_data_are_one_line_and_no_traceback(here, capsys) -> None:
    paths = damaged(here)
    assert len(paths) == 18
    for path in paths:
        code = run(["compare", "plywood", "--data", str(path), "--runs", "19"])
        shown = capsys.readouterr()
        assert code in (1, 2), path
        assert shown.err.startswith("error: "), path
        assert len(shown.err.splitlines()) == 1, path
    assert not (here / "out").exists()


@pytest.mark.slow
def test_every_cut_of_a_file_is_read_or_refused_in_one_line(here, capsys) -> None:
    """A file cut anywhere in its header and first rows ends in an exit code and never in a traceback."""
    whole, codes = pose_file(here).read_bytes(), set()
    for length in range(0, 200, 9):
        (here / "cut.csv").write_bytes(whole[:length])
        codes.add(run(["compare", "plywood", "--data", "cut.csv", "--runs", "19", "--json", "-"]))
        shown = capsys.readouterr()
        assert len(shown.err.splitlines()) == (0 if shown.out else 1)
    assert codes == {0, 2}
