"""`cyclemap reset` from outside: three lines, a few rows, files that the other commands follow, and
what it refuses.
"""

import json
import tomllib

import pytest

from cyclemap.cli import main
from cyclemap.protocol import read_protocol, read_schedule

pytestmark = pytest.mark.slow

FEW = ("--axes-percent", "5", "--offsets-percent", "20", "--pushes", "200", "--cycles", "30")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The command run once for people, on plywood."""
    folder = tmp_path_factory.mktemp("reset")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COLUMNS", "250")
        assert main.run(["reset", "plywood", *FEW, "--out", str(folder)]) == 0
    return folder


def written(folder) -> dict:
    return json.loads(
        (folder / "reset_plywood.json").read_text(), parse_constant=lambda name: pytest.fail(name)
    )


def test_the_files_are_there_and_the_json_tells_the_rows(made) -> None:
    names = sorted(path.name for path in made.iterdir())
    assert names == [f"reset_plywood.{end}" for end in ("csv", "json", "png", "toml")]
    report = written(made)
    assert report["met"] is True and report["reasons"] == []
    chosen, own = report["rows"][0], report["rows"][-1]
    assert "chosen" in chosen["roles"] and own["roles"] == ["as it is"]
    assert (
        chosen["tv"] <= chosen["worst_tv"] <= 0.10 and chosen["worst_tv_after"] <= 0.12 < own["tv"]
    )
    assert chosen["recipe"].startswith("before every push")
    assert sum(action["weight"] for action in chosen["actions"]) == pytest.approx(1.0)
    assert len(report["rows"]) <= 7 and len(report["range"]["materials"]) == 13
    assert own["histogram_distance"] > 5 * report["independent_histogram_distance"] > 0.5


def test_protocol_and_schedule_hold_the_chosen_strategy(made) -> None:
    report = written(made)
    settings, strategy = read_protocol(made / "reset_plywood.toml")
    assert settings["noise_deg"] == pytest.approx(1.1)
    assert [action.push.side for action in strategy.actions] == [
        a["side"] for a in report["rows"][0]["actions"]
    ]
    actions = read_schedule(made / "reset_plywood.csv")
    assert len(actions) == 30 and {action.push for action in actions} == {
        a.push for a in strategy.actions
    }
    table = tomllib.loads((made / "reset_plywood.toml").read_text())
    assert table["predicted"]["worst_tv"] == pytest.approx(report["rows"][0]["worst_tv"])


def test_the_other_commands_follow_the_protocol(made, here, report_of) -> None:
    protocol = str(made / "reset_plywood.toml")
    asked = ["plywood", "--protocol", protocol]
    cycles = report_of("cycle", *asked, "--theta0-deg", "0")["cycles"]
    assert len(cycles) == len(written(made)["rows"][0]["actions"])
    stationary = report_of("portrait", *asked, "--cycles", "50")["stationary"]
    assert stationary["tv_from_uniform"] == pytest.approx(written(made)["rows"][0]["tv"], abs=2e-3)


def test_people_are_told_three_lines_and_the_rows(tmp_path, capsys, monkeypatch) -> None:
    """Where nothing meets the demands these say so, and what is the least of each demand missed."""
    monkeypatch.setenv("COLUMNS", "250")
    asked = [
        "reset",
        "isotropic",
        *FEW,
        "--keep-push",
        "--drag-ratio",
        "0.5",
        "--out",
        str(tmp_path),
    ]
    assert main.run(asked) == 0
    shown = capsys.readouterr()
    assert all(" % done, " in line for line in shown.err.splitlines())
    for part in (
        "What to do:",
        "What it leaves at the worst of",
        "What it costs:",
        "Nothing that was considered meets all demands",
    ):
        assert shown.out.count(part) == 1
    assert "The least mean drag considered is" in shown.out and "as it is" in shown.out
