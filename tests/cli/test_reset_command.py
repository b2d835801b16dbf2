"""`cyclemap reset` from outside: three lines and a few rows, files that the other commands follow, and
what it says where nothing will do.
"""

import json
import tomllib

import pytest

from cyclemap.cli import main
from cyclemap.protocol import read_protocol, read_schedule

pytestmark = pytest.mark.slow

FEW = "--axes-percent 5 --offsets-percent 20 --pushes 200 --cycles 30"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The command run once, on plywood: its folder, and its report."""
    folder = tmp_path_factory.mktemp("reset")
    assert main.run(f"reset plywood {FEW} --out {folder}".split()) == 0
    return folder, json.loads((folder / "reset_plywood.json").read_text())


def test_the_files_are_there_and_the_json_tells_the_rows(made) -> None:
    folder, report = made
    names = sorted(path.name for path in folder.iterdir())
    assert names == [f"reset_plywood.{end}" for end in ("csv", "json", "png", "toml")]
    assert report["met"] is True and report["reasons"] == []
    chosen, own = report["rows"][0], report["rows"][-1]
    assert "chosen" in chosen["roles"] and own["roles"] == ["as it is"]
    assert chosen["tv"] <= chosen["worst_tv"] <= 0.10
    assert chosen["worst_tv_after"] <= 0.12 < own["tv"]
    assert chosen["recipe"].startswith("before every push")
    assert sum(action["weight"] for action in chosen["actions"]) == pytest.approx(1.0)
    assert len(report["rows"]) <= 7 and len(report["range"]["materials"]) == 13
    assert own["histogram_distance"] > 5 * report["independent_histogram_distance"] > 0.5


def test_protocol_and_schedule_hold_the_chosen_strategy(made) -> None:
    folder, report = made
    chosen = report["rows"][0]
    settings, strategy = read_protocol(folder / "reset_plywood.toml")
    assert settings["noise_deg"] == pytest.approx(1.1)
    sides = [action.push.side for action in strategy.actions]
    assert sides == [action["side"] for action in chosen["actions"]]
    actions = read_schedule(folder / "reset_plywood.csv")
    assert len(actions) == 30
    assert {action.push for action in actions} == {action.push for action in strategy.actions}
    predicted = tomllib.loads((folder / "reset_plywood.toml").read_text())["predicted"]
    assert predicted["worst_tv"] == pytest.approx(chosen["worst_tv"])


def test_the_other_commands_follow_the_protocol(made, here, report_of) -> None:
    folder, report = made
    chosen, asked = report["rows"][0], f"plywood --protocol {folder}/reset_plywood.toml"
    assert len(report_of(f"cycle {asked} --theta0-deg 0")["cycles"]) == len(chosen["actions"])
    stationary = report_of(f"portrait {asked} --cycles 50")["stationary"]
    assert stationary["tv_from_uniform"] == pytest.approx(chosen["tv"], abs=2e-3)


def test_people_are_told_three_lines_and_the_rows(here, said, monkeypatch) -> None:
    """Where nothing meets the demands these say so, and what is the least of each demand missed."""
    monkeypatch.setenv("COLUMNS", "250")
    shown = said(f"reset isotropic {FEW} --keep-push --drag-ratio 0.5")
    assert all(" % done, " in line for line in shown.err.splitlines())
    lines = ("What to do:", "What it leaves at the worst of", "What it costs:")
    for words in (*lines, "Nothing that was considered meets all demands"):
        assert shown.out.count(words) == 1
    assert "The least mean drag considered is" in shown.out and "as it is" in shown.out
