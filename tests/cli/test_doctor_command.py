"""`cyclemap doctor`: what it tells people and programs, and its exit codes."""

import json

import pytest
from click.testing import CliRunner

from cyclemap.cli.command_doctor import doctor_command
from cyclemap.collection import self_check
from cyclemap.errors import EngineNotBuilt
from cyclemap.mechanics.engine import library


@pytest.fixture(autouse=True)
def folder(monkeypatch, tmp_path):
    """Measured data in a folder of its own."""
    monkeypatch.setenv("CYCLEMAP_DATA", str(tmp_path))
    return tmp_path


def doctor(*arguments):
    return CliRunner().invoke(doctor_command, arguments)


def test_people_are_told_versions_the_engine_and_how_far_its_cycles_are_from_the_independent_solvers(folder):
    done = doctor()
    assert done.exit_code == 0
    for part in ("numpy", "_engine", "of an independent solver's", str(folder), "healthy"):
        assert part in done.output.replace("\n", "")


def test_json_tells_the_same_and_nothing_else(folder):
    done = doctor("--json", "-")
    report = json.loads(done.output)
    assert done.exit_code == 0
    assert report["healthy"] is True and report["problems"] == []
    assert report["data_folder"] == str(folder)
    assert report["versions"].keys() == {"python", "cyclemap", "numpy", "scipy", "casadi", "matplotlib"}
    assert len(report["engine_version"]) == 64
    assert 0.0 < report["self_check_error_deg"] < 1e-4


@pytest.mark.parametrize("error", [1.0, float("nan")])
def test_a_wrong_number_ends_with_exit_code_1(monkeypatch, error):
    monkeypatch.setattr(self_check, "reference_error", lambda: error)
    done = doctor()
    assert done.exit_code == 1
    assert "PROBLEM: turns in MIT's loop are" in done.output and "not healthy" in done.output


def test_an_engine_that_is_not_built_ends_with_exit_code_1_and_tells_what_to_do(monkeypatch):
    def refuse():
        raise EngineNotBuilt("the compiled engine is missing: build it")

    monkeypatch.setattr(library, "load", refuse)
    done = doctor("--json", "-")
    report = json.loads(done.output)
    assert done.exit_code == 1
    assert report["problems"] == ["the compiled engine is missing: build it"]
    assert report["engine_version"] is None and report["self_check_error_deg"] is None


def test_a_missing_data_folder_ends_with_exit_code_1(monkeypatch, folder):
    monkeypatch.setenv("CYCLEMAP_DATA", str(folder / "nowhere"))
    done = doctor("--json", "-")
    assert done.exit_code == 1
    assert "is no folder" in json.loads(done.output)["problems"][0]
