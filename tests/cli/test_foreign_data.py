"""Tables as robots write them through the commands: right as they stand, or refused with what mends
them.
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
FEW = "--starts 1 --folds 0"


@pytest.fixture(autouse=True)
def _no_pictures(monkeypatch) -> None:
    """Answers are asked for, of many tables; pictures are drawn elsewhere."""
    monkeypatch.setattr("cyclemap.views.panels.layout.render", lambda figure, form: b"")


@pytest.fixture
def report_after_mends(here, capsys):
    """The report of a command, after what its refusals said to give; None where it was refused for
    good.
    """

    def read(line: str) -> dict | None:
        words = f"{line} --json -".split(" ")
        for _ in range(3):
            code = run(words)
            said = capsys.readouterr()
            if code == 0:
                return json.loads(said.out)
            last = said.err.splitlines()[-1]
            assert code in (1, 2) and last.startswith("error: ")
            mend = _MEND.search(last)
            if mend is None:
                return None
            words += mend[1].split()
        raise AssertionError(f"refused three times: {said.err}")

    return read


def probe_is_right(report: dict | None, table: Foreign) -> bool:
    """Plywood's axes, longer along 150 degrees, or turned by a quarter with the world; no mirror
    image has that, and orientations alone tell no push.
    """
    if not table.posed or report is None:
        return not table.posed and report is None
    along = [abs((report["axis_deg"] - axis + 90.0) % 180.0 - 90.0) for axis in (150.0, 60.0)]
    off = abs(report["axis_ratio"]["value"] - 1.085)
    return off < 0.005 + 0.03 * table.noise_mm and min(along) < 10.0


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
    if off is None:
        return bool(np.mean([verdict["agrees"] for verdict in report["verdicts"]]) >= 0.6)
    turned = 8.0 if table.convention in ("north east down", "swapped") else 0.0
    return off["mean_mm"] < 0.5 + 2.5 * table.noise_mm + turned


def identify_is_right(report: dict, table: Foreign) -> bool:
    """Axes near those of plywood, 1.085 : 1."""
    ratio = next(row for row in report["derived"] if row["name"] == "axis_ratio")
    return ratio["lower"] - 0.02 < 1.085 < ratio["upper"] + 0.02 and ratio["upper"] < 1.3


COMMANDS = {
    "probe --protocol collection.toml --data": probe_is_right,
    "audit": audit_is_right,
    "watch": watch_is_right,
    "compare collection.toml --runs 19 --data": compare_is_right,
    f"identify {FEW} --most 40": identify_is_right,
}


def test_each_command_is_asked_of_six_writers_in_our_convention_and_in_others() -> None:
    for command in COMMANDS:
        tables = [table for table, asked in asked_of_tables() if asked == command]
        assert len({table.write for table in tables}) == 6
        assert 0 < sum(table.convention == "ours" for table in tables) < 6


def asked_of_tables() -> list[tuple[Foreign, str]]:
    """Each table and the command that is asked of it, by turns: three of each writer."""
    commands = list(COMMANDS)
    return [
        (table, commands[(index + index // 10) % len(commands)])
        for index, table in enumerate(thirty())
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("table", "command"),
    asked_of_tables(),
    ids=lambda given: given if isinstance(given, str) else f"{given.name}-{given.convention}",
)
def test_no_command_answers_wrongly(here, report_after_mends, table, command) -> None:
    report = report_after_mends(f"{command} {table.made(here).name}")
    assert COMMANDS[command](report, table), report


@pytest.mark.slow
def test_a_reading_told_on_the_command_line_or_beside_the_data_is_the_same(
    here, said, report_of
) -> None:
    Foreign("log", canonical, ".csv", "picture", 0.0, True, 2).made(here)
    line = "probe --protocol collection.toml --data log.csv"
    assert "give --angles clockwise --frame mirrored" in said(line, 2).err
    by_options = report_of(f"{line} --angles clockwise --frame mirrored", silent=False)
    file = here / "collection.toml"
    file.write_text(f'{file.read_text()}\n[data]\nangles = "clockwise"\nframe = "mirrored"\n')
    assert report_of(line, silent=False) == by_options
    said(f"{line} --angles widdershins", 2)


@pytest.mark.parametrize(
    ("told", "known_as", "y", "turn"),
    [
        ("", "clockwise_mirrored", -0.2, -0.3),
        ("--angles counter-clockwise", "counter-clockwise_mirrored", -0.2, 0.3),
        ("--frame right-handed", "clockwise_right-handed", 0.2, -0.3),
    ],
)
def test_what_is_told_goes_before_what_the_folder_says_and_names_the_table_as_read(
    here, said, told, known_as, y, turn
) -> None:
    rows = "".join(f"0.1,0.2,{n},0.1,0.2,{n + 0.3}\n" for n in range(4))
    (here / "log.csv").write_text(f"x,y,yaw,x2,y2,yaw2\n{rows}")
    (here / "collection.toml").write_text('[data]\nangles = "clockwise"\nframe = "mirrored"\n')
    columns = "x0=x,y0=y,theta0=yaw,x1=x2,y1=y2,theta1=yaw2"
    shown = said(f"audit log.csv --columns {columns} --units rad,m {told}", 2)
    assert "4 pushes of one set; an audit needs 10" in shown.err
    (table,) = (here / "out").glob("*.csv")
    assert table.name == f"log_{known_as}_as_read.csv"
    read = np.genfromtxt(table, delimiter=",", names=True)
    assert read["theta1"] - read["theta0"] == pytest.approx(turn)
    assert read["y0"] == pytest.approx(y)


def test_what_the_folder_says_of_data_must_be_a_table(here, refused) -> None:
    (here / "log.csv").write_text("yaw\n0.1\n")
    (here / "collection.toml").write_text("data = 3\n")
    refused("audit log.csv --units rad", "data must be a table, [data], not 3")


@pytest.mark.slow
def test_no_material_is_written_of_data_that_nothing_explains_but_by_force(here, said) -> None:
    """Ends of pushes at random: refused, the errors named; with --force written, and without a next
    step.
    """
    table = Foreign("log", canonical, ".csv", "ours", 0.0, True, 2)
    header, *lines = table.made(here).read_text().splitlines()
    rows = np.array([line.split(",") for line in lines[:24]], dtype=float)
    random = np.random.default_rng(4).uniform(-1.0, 1.0, (24, 3))
    rows[:, 3:6] = rows[:, :3] + random * (0.15, 0.15, math.pi)
    text = "\n".join([header, *(",".join(map(str, row)) for row in rows.tolist())])
    (here / "log.csv").write_text(f"{text}\n")
    shown = said(f"identify log.csv {FEW}", 1)
    assert "no material is written" in shown.err and "--force" in shown.err
    assert not list(here.glob("out/*.toml"))
    shown = said(f"identify log.csv {FEW} --force")
    assert "this cannot be right" in shown.err and "next:" not in shown.out
    assert list(here.glob("out/*.toml"))


@pytest.mark.slow
def test_poses_of_another_origin_than_the_objects_are_told_to_miss_more_than_floors_do(
    here, said
) -> None:
    """Poses of a point 17 mm beside the origin: the misfit is told; of the origin's own it is not."""
    told = "on floors that were measured half lie within a tenth"
    table = Foreign("log", canonical, ".csv", "ours", 0.0, True, 2)
    header, *lines = table.made(here).read_text().splitlines()
    (here / "log.csv").write_text("\n".join([header, *lines[:12], ""]))
    assert told not in said(f"identify log.csv {FEW}").err
    rows = np.array([line.split(",") for line in lines[:12]], dtype=float)
    for x, y, theta in ((0, 1, 2), (3, 4, 5)):
        c, s = np.cos(rows[:, theta]), np.sin(rows[:, theta])
        rows[:, x] += 0.015 * c - 0.008 * s
        rows[:, y] += 0.015 * s + 0.008 * c
    text = "\n".join([header, *(",".join(map(str, row)) for row in rows.tolist())])
    (here / "log.csv").write_text(f"{text}\n")
    assert told in said(f"identify log.csv {FEW} --force").err


def write_log(theta: list[float]) -> None:
    lines = [f"{math.degrees(angle) % 360.0:.3f}\n" for angle in theta]
    Path("log.csv").write_text("theta0_deg\n" + "".join(lines))


@pytest.mark.slow
def test_an_object_moved_by_hand_is_told_of_a_log_of_orientations_alone(
    here, said, report_of
) -> None:
    """Twice in 150 pushes: the audit tells, the true material stands, the fitted noise is that of
    the cycles.
    """
    rng, theta = np.random.default_rng(5), [0.3]
    cycle_map = loop().circle_map(1e-4)
    for number in range(150):
        hand = 1.5 if number in (50, 100) else 0.0
        noise = math.radians(1.1) * rng.standard_normal()
        theta.append(float(cycle_map(theta[-1])) + noise + hand)
    Foreign("x", canonical, ".csv", "ours", 0.0, True, 2).made(here)
    write_log(theta)
    assert "behind pushes 50, 100 (from 0) are like no others" in said("audit log.csv").err
    report = report_of("staircase collection.toml --data log.csv", silent=False)
    assert report["data"]["fitted"]["noise_deg"] < 1.5


@pytest.mark.slow
def test_a_staircase_beside_locked_data_says_what_it_cannot_tell(here, said) -> None:
    """A map fitted to a sixth of the circle would be as steep as its harmonics allow: none is."""
    rng, theta = np.random.default_rng(1), [0.2]
    for _ in range(150):
        theta.append(theta[-1] + 0.25 * math.sin(1.2 - theta[-1]) + 0.02 * rng.standard_normal())
    write_log(theta)
    shown = " ".join(said("staircase plywood --data log.csv").out.split())
    assert "No map is fitted to them: θ0 leave a gap of" in shown


def test_an_audit_says_why_a_table_could_not_be_read(here, refused) -> None:
    """Millimetres under names that are metres': the row, and the option."""
    poses = "".join(f"{350 + n},20,0.{n},380,-40,1.{n}\n" for n in range(20))
    (here / "mm.csv").write_text(f"x0,y0,th0,x1,y1,th1\n{poses}")
    refused("audit mm.csv", "is it in other units? Say them, --units mm")
