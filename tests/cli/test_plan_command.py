"""`cyclemap plan` from outside: its tables, JSON and words; what it makes of a table that is filled
in.
"""

import json
import math
import shlex
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import cyclemap as cm
from cyclemap.evidence import plan_pushes
from cyclemap.evidence.tables.planned_table import mark_columns, marks_of
from cyclemap.mechanics import Pose, SidePush
from cyclemap.protocol import loop_from_settings


@pytest.fixture(autouse=True)
def box(here, said, monkeypatch) -> None:
    """The file of an object, and plans of few candidates over few floors."""
    small = partial(plan_pushes, samples=4, candidates=30)
    monkeypatch.setattr("cyclemap.cli.collected.run_plan.plan_pushes", small)
    said("init box.toml --rectangle-mm 80,60 --quiet")


def fill_in(path: Path, material: str) -> None:
    """Make the planned pushes on a surface, and write down the corners to a tenth of a
    millimetre."""
    loop = loop_from_settings(cm.read_protocol("box.toml")[0], cm.CollectionLoop.mit(material))
    table = pd.read_csv(path)
    corners = [name for state in "012" for name in mark_columns(state)]
    table[corners] = table[corners].astype(float)
    for number, row in table.iterrows():
        x, y = 1e-3 * row["set_x_mm"], 1e-3 * row["set_y_mm"]
        start = Pose(x, y, math.radians(row["set_theta_deg"]))
        angle, length = math.radians(row["angle_deg"]), 1e-3 * row["push_mm"]
        end = loop.model.push(start, SidePush(int(row["side"]), row["fraction"], angle, length)).end
        back = loop.model.drag(end, (start.to_world(*loop.slider.hitch),)).end
        for state, pose in zip("012", (start, end, back), strict=True):
            places = [pose.to_world(*mark) for mark in marks_of(loop.slider)]
            table.loc[number, list(mark_columns(state))] = np.round(1e3 * np.ravel(places), 1)
    table.to_csv(path, index=False)


def test_a_plan_writes_tables_and_picture_and_says_what_will_be_known(here, said) -> None:
    line = "plan box.toml --pushes 3 --for pushes --room-mm '600, 400' --floor unknown"
    told = said(line).out
    assert told.startswith("3 pushes of box that tell most of where pushes end.")
    # What goes on asks the same again.
    following = told.splitlines()[-1].removeprefix("next: cyclemap ")
    words, typed = shlex.split(following), shlex.split(line)
    assert words[-2:] == ["--after", "out/plan_box.csv"] and sorted(words[:-2]) == sorted(typed)
    report = json.loads((here / "out/plan_box.json").read_text())
    assert len(report["pushes"]) == 3 and report["floor"] == "unknown"
    assert [after["pushes"] for after in report["knowledge"]] == [0, 3, 4, 8, 16]
    turns = [after["planned"]["turn_deg"] for after in report["knowledge"]]
    assert turns == sorted(turns, reverse=True)
    robot, table = (pd.read_csv(f"out/plan_box{name}.csv") for name in ("_robot", ""))
    # The rod goes as far as the table says, straight on from where it comes from.
    way = np.hypot(robot["end_x_mm"] - robot["touch_x_mm"], robot["end_y_mm"] - robot["touch_y_mm"])
    assert way.to_numpy() == pytest.approx(table["push_mm"].to_numpy(), abs=1e-3)
    assert (here / "out/plan_box.png").stat().st_size > 10_000
    # A table that was filled in is never written over.
    table.loc[0, "a_x0_mm"] = 1.0
    table.to_csv("out/plan_box.csv", index=False)
    kept = (here / "out/plan_box.csv").read_bytes()
    said("plan box.toml --pushes 3 --for pushes --quiet")
    assert (here / "out/plan_box.csv").read_bytes() == kept
    assert (here / "out/plan_box_2.csv").exists()


BAD_USES = {
    "plywood": "give the file of your object",
    "box.toml --grid some": "--grid 'some': give the degrees",
    "box.toml --grid 0": "0.1 to 180, or free",
    "box.toml --room-mm 600": "--room-mm '600'",
    "box.toml --floor plywood": "plywood: a plan needs samples",
    "box.toml --pushes 40": "40",
    "box.toml --after none.csv": "none.csv",
    "box.toml --after box.toml": "another kind (.toml); --after takes the table that",
    "box.toml --after .": "holds no .h5, .json or .csv file; --after takes the table",
}


@pytest.mark.parametrize("words", BAD_USES)
def test_bad_use_is_one_line_that_names_the_value(refused, words) -> None:
    refused(f"plan {words}", BAD_USES[words])


def test_a_table_that_is_given_twice_or_would_be_written_over_another_is_refused(
    here, said
) -> None:
    said("plan box.toml --pushes 2 --quiet")
    planned = Path("out/plan_box.csv")
    fill_in(planned, "isotropic")
    for name, words in (
        ("out/plan_box.csv", "is given twice"),
        ("plan_box.csv", "has the name of"),
        ("copy.csv", "would count twice"),
    ):
        (here / name).write_bytes(planned.read_bytes())
        assert words in said(f"plan box.toml --after {planned} --after {name}", 2).err


@pytest.mark.slow
def test_filled_tables_are_identified_and_the_plan_goes_on_or_ends(here, said) -> None:
    said("plan box.toml --pushes 8 --quiet")
    fill_in(here / "out/plan_box.csv", "plywood-floor")
    line = "plan box.toml --after out/plan_box.csv"
    report = json.loads(said(f"{line} --pushes 2 --json -").out)
    assert report["uncertainty"]["samples"] > 100
    assert report["enough"] is (len(report.get("pushes", [])) == 0)
    told = said(f"{line} --until-deg 180").out
    assert ("Enough" in told) == (not 0.05 < report["uncertainty"]["chance_of_lock_in"] < 0.95)
    # What was found is a file that every command reads.
    found = cm.load_material("out/plan_box_measured.toml")
    assert found.posterior is not None and found.pressure_of("box") is not None
