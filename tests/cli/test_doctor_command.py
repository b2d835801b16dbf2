"""`cyclemap doctor`: what it tells people and programs, and its exit codes."""

import json

import pytest

from cyclemap.cli import run_doctor
from cyclemap.cli.main import run
from cyclemap.errors import EngineNotBuilt
from cyclemap.mechanics.engine import library


def test_people_and_programs_are_told_versions_engine_and_how_far_its_cycles_are_off(
    here, capsys, monkeypatch
):
    monkeypatch.setenv("CYCLEMAP_DATA", str(here))
    assert run(["doctor"]) == 0
    shown = capsys.readouterr().out
    for part in ("numpy", "_engine", "of an independent solver's", str(here), "healthy"):
        assert part in shown.replace("\n", "")
    assert run(["doctor", "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["healthy"] is True and report["problems"] == []
    assert report["data_folder"] == str(here)
    assert report["versions"].keys() == {
        "python",
        "cyclemap",
        "numpy",
        "scipy",
        "casadi",
        "matplotlib",
    }
    assert len(report["engine_version"]) == 64
    assert 0.0 < report["self_check_error_deg"] < 1e-4


def no_engine():
    raise EngineNotBuilt("the compiled engine is missing: build it")


@pytest.mark.parametrize(
    ("place", "name", "broken", "problem"),
    [
        (run_doctor, "reference_error", lambda: 1.0, "turns in MIT's loop are"),
        (run_doctor, "reference_error", lambda: float("nan"), "turns in MIT's loop are"),
        (library, "load", no_engine, "the compiled engine is missing: build it"),
    ],
)
def test_what_does_not_work_is_told_with_exit_code_1(
    capsys, monkeypatch, place, name, broken, problem
):
    monkeypatch.setattr(place, name, broken)
    assert run(["doctor"]) == 1
    shown = capsys.readouterr().out
    assert f"PROBLEM: {problem}" in shown and "not healthy" in shown


def test_a_missing_data_folder_ends_with_exit_code_1(here, capsys, monkeypatch):
    monkeypatch.setenv("CYCLEMAP_DATA", str(here / "nowhere"))
    assert run(["doctor", "--json", "-"]) == 1
    assert "is no folder" in json.loads(capsys.readouterr().out)["problems"][0]
