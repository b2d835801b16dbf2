"""Thirty tables as robots write them through the commands: right as they stand, or refused with
what mends them.
"""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from foreign_tables import Foreign, canonical, loop, thirty

from cyclemap.cli.main import run

pytest.importorskip("pandas")
_MEND = re.compile(r"give ((?:--(?:angles|frame|units) [\w.-]+ ?)+)")


@pytest.fixture(autouse=True)
def _no_pictures(monkeypatch) -> None:
    """Answers are asked for, of many tables; pictures are drawn elsewhere."""
    monkeypatch.setattr("cyclemap.views.panels.layout.render", lambda figure, form: b"")


def told(capsys, path: Path, name: str, *arguments: str) -> dict | None:
    """The report of a command, after what its refusals said to give; None where it was refused for
    good.
    """
    given: list[str] = []
    for _ in range(3):
        capsys.readouterr()
        code = run([name, *arguments, *given, "--out", str(path.parent / "out"), "--json", "-"])
        said = capsys.readouterr()
        if code == 0:
            return json.loads(said.out)
        assert code in (1, 2) and said.err.splitlines()[-1].startswith("error: ")
        mend = _MEND.search(said.err.splitlines()[-1])
        if mend is None:
            return None
        given += mend[1].split()
    raise AssertionError(f"refused three times: {said.err}")


def probe_is_right(report: dict, table: Foreign) -> bool:
    """Plywood's axes, longer along 150 degrees, or turned by a quarter with the world; no mirror
    image has that.
    """
    along = [abs((report["axis_deg"] - one + 90.0) % 180.0 - 90.0) for one in (150.0, 60.0)]
    return (
        abs(report["axis_ratio"]["value"] - 1.085) < 0.005 + 0.03 * table.noise_mm
        and min(along) < 10.0
    )


def audit_is_right(report: dict, table: Foreign) -> bool:
    """Pushes turn the object by 69 to 73 degrees, counter-clockwise."""
    reset = report["reset"]
    return report["pushes"] >= 69 and (reset is None or 68.0 < reset["push_turn_deg"] < 74.0)


def watch_is_right(report: dict, table: Foreign) -> bool:
    """Every orientation is there, and no lock-in is seen where there is none."""
    return report["pushes"] >= 69 and report["alarm"] is None


def compare_is_right(report: dict, table: Foreign) -> bool:
    """The true surface predicts pushes within their noise, or, the world turned by a quarter, as
    well as any turned.
    """
    off = report["ends_off"]
    limit = (
        0.5
        + 2.5 * table.noise_mm
        + (8.0 if table.convention in ("north east down", "swapped") else 0.0)
    )
    verdicts = [one["agrees"] for one in report["verdicts"]]
    return (off is None or off["mean_mm"] < limit) and (off is not None or np.mean(verdicts) >= 0.6)


def identify_is_right(report: dict, table: Foreign) -> bool:
    """Axes near those of plywood, 1.085 : 1."""
    ratio = next(one for one in report["derived"] if one["name"] == "axis_ratio")
    return ratio["lower"] - 0.02 < 1.085 < ratio["upper"] + 0.02 and ratio["upper"] < 1.3


COMMANDS = {
    "probe": (probe_is_right, ("--protocol", "{own}", "--data", "{data}")),
    "audit": (audit_is_right, ("{data}",)),
    "watch": (watch_is_right, ("{data}",)),
    "compare": (compare_is_right, ("{own}", "--data", "{data}", "--runs", "19")),
    "identify": (identify_is_right, ("{data}", "--starts", "1", "--folds", "0")),
}


def asked_of_tables() -> list[tuple[Foreign, str]]:
    """Tables and the commands that are asked of each, by turns, so that each is asked of all ten
    writers.
    """
    asked = []
    for index, table in enumerate(thirty()):
        turn = index + index // 10
        for place, name in enumerate(COMMANDS):
            every = 3 if name == "identify" else 2
            if (turn + place) % every == 0:
                asked.append((table, name))
    return asked


def test_each_command_is_asked_of_each_writer() -> None:
    asked = {(table.write.__name__, name) for table, name in asked_of_tables()}
    assert len(asked) == 10 * len(COMMANDS)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("table", "name"),
    asked_of_tables(),
    ids=lambda given: given if isinstance(given, str) else f"{given.name}-{given.convention}",
)
def test_no_command_answers_wrongly(tmp_path, capsys, table, name) -> None:
    is_right, arguments = COMMANDS[name]
    path = table.made(tmp_path)
    words = [one.format(own=tmp_path / "collection.toml", data=path) for one in arguments]
    report = told(capsys, path, name, *words)
    if name == "probe" and not table.posed:
        assert report is None
    else:
        assert report is not None and is_right(report, table), report


@pytest.mark.slow
def test_a_reading_told_on_the_command_line_or_beside_the_data_is_the_same(
    tmp_path, capsys
) -> None:
    table = Foreign("log", canonical, ".csv", "picture", 0.0, True, 2)
    path = table.made(tmp_path)
    own, out = str(tmp_path / "collection.toml"), ["--json", "-", "--out", str(tmp_path / "out")]
    data = ["probe", "--protocol", own, "--data", str(path)]
    assert run([*data, *out]) == 2
    assert "give --angles clockwise --frame mirrored" in capsys.readouterr().err
    assert run([*data, "--angles", "clockwise", "--frame", "mirrored", *out]) == 0
    by_options = json.loads(capsys.readouterr().out)
    file = tmp_path / "collection.toml"
    file.write_text(f'{file.read_text()}\n[data]\nangles = "clockwise"\nframe = "mirrored"\n')
    assert run([*data, *out]) == 0
    assert json.loads(capsys.readouterr().out) == by_options
    assert run([*data, "--angles", "widdershins", *out]) == 2


@pytest.mark.slow
def test_no_material_is_written_of_data_that_nothing_explains_but_by_force(
    tmp_path, capsys, monkeypatch
) -> None:
    """Ends of pushes at random: refused, the errors named; with --force written, and without a next
    step.
    """
    monkeypatch.chdir(tmp_path)
    table = Foreign("log", canonical, ".csv", "ours", 0.0, True, 2)
    lines = table.made(tmp_path).read_text().splitlines()
    rng = np.random.default_rng(4)
    rows = [[float(field) for field in line.split(",")] for line in lines[1:25]]
    for row in rows:
        x, y, turn = (
            rng.uniform(-0.15, 0.15),
            rng.uniform(-0.15, 0.15),
            rng.uniform(-math.pi, math.pi),
        )
        row[3:6] = [row[0] + x, row[1] + y, row[2] + turn]
    (tmp_path / "log.csv").write_text(
        "\n".join([lines[0], *(",".join(map(str, row)) for row in rows)]) + "\n"
    )
    few = ["identify", "log.csv", "--starts", "1", "--folds", "0"]
    assert run(few) == 1
    said = capsys.readouterr().err
    assert (
        "no material is written" in said
        and "--force" in said
        and not list(tmp_path.glob("out/*.toml"))
    )
    assert run([*few, "--force"]) == 0
    said = capsys.readouterr()
    assert (
        "this cannot be right" in said.err
        and "next:" not in said.out
        and list(tmp_path.glob("out/*.toml"))
    )


@pytest.mark.slow
def test_an_object_moved_by_hand_is_told_of_a_log_of_orientations_alone(
    tmp_path, capsys, monkeypatch
) -> None:
    """Twice in 150 pushes: the audit tells, the true material stands, the fitted noise is that of
    the cycles.
    """
    monkeypatch.chdir(tmp_path)
    rng, theta = np.random.default_rng(5), [0.3]
    cycle_map = loop().circle_map(1e-4)
    for number in range(150):
        hand = 1.5 if number in (50, 100) else 0.0
        theta.append(float(cycle_map(theta[-1])) + math.radians(1.1) * rng.standard_normal() + hand)
    (tmp_path / "collection.toml").write_text(
        Foreign("x", canonical, ".csv", "ours", 0.0, True, 0)
        .made(tmp_path / "own")
        .with_name("collection.toml")
        .read_text()
    )
    (tmp_path / "log.csv").write_text(
        "theta0_deg\n" + "".join(f"{math.degrees(one) % 360:.3f}\n" for one in theta)
    )
    assert run(["audit", "log.csv"]) == 0
    assert "behind pushes 50, 100 (from 0) are like no others" in capsys.readouterr().err
    assert run(["staircase", "collection.toml", "--data", "log.csv", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["data"]["fitted"]["noise_deg"] < 1.5


@pytest.mark.slow
def test_a_staircase_beside_locked_data_says_what_it_cannot_tell(
    tmp_path, capsys, monkeypatch
) -> None:
    """A map fitted to a sixth of the circle would be as steep as its harmonics allow: none is."""
    monkeypatch.chdir(tmp_path)
    rng, theta = np.random.default_rng(1), [0.2]
    for _ in range(150):
        theta.append(theta[-1] + 0.25 * math.sin(1.2 - theta[-1]) + 0.02 * rng.standard_normal())
    (tmp_path / "log.csv").write_text(
        "theta0_deg\n" + "".join(f"{math.degrees(one):.3f}\n" for one in theta)
    )
    assert run(["staircase", "plywood", "--data", "log.csv"]) == 0
    assert "No map is fitted to them: θ0 leave a gap of" in " ".join(
        capsys.readouterr().out.split()
    )


def test_an_audit_says_why_a_table_could_not_be_read(tmp_path, capsys) -> None:
    """Millimetres under names that are metres': the row, and the option."""
    poses = "".join(f"{350 + n},20,0.{n},380,-40,1.{n}\n" for n in range(20))
    (tmp_path / "mm.csv").write_text(f"x0,y0,th0,x1,y1,th1\n{poses}")
    assert run(["audit", str(tmp_path / "mm.csv"), "--out", str(tmp_path)]) == 2
    assert "is it in other units? Say them, --units mm" in capsys.readouterr().err
