"""`cyclemap doctor`: what it tells people and programs, and its exit codes."""

import json

import pytest
from click.testing import CliRunner

from cyclemap.cli import run_doctor as module
from cyclemap.cli.command_doctor import doctor_command
from cyclemap.collection.kernel_check import KernelCheck

SOUND = KernelCheck("/usr/bin/cc", "", 1e-6, 5e-3, 5e-4, 1e-14)
INTERPRETED = KernelCheck(None, "no C compiler found (cc): install one", 1e-6, 5e-3, None, None)
WRONG = KernelCheck("/usr/bin/cc", "", 1.0, 5e-3, 5e-4, 1e-14)


@pytest.fixture(autouse=True)
def folder(monkeypatch, tmp_path):
    """Measured data in a folder of its own."""
    monkeypatch.setenv("CYCLEMAP_DATA", str(tmp_path))
    monkeypatch.setenv("CYCLEMAP_CACHE", str(tmp_path / "kernels"))
    return tmp_path


def doctor(monkeypatch, found, *arguments):
    monkeypatch.setattr(module, "check_kernels", lambda: found)
    return CliRunner().invoke(doctor_command, arguments)


def test_people_are_told_what_is_installed_and_what_runs(monkeypatch, folder):
    done = doctor(monkeypatch, SOUND)
    assert done.exit_code == 0
    for part in (
        "numpy",
        "/usr/bin/cc",
        "compiled, kept in",
        str(folder),
        "0.5 ms compiled, 5 ms interpreted",
        "healthy",
    ):
        assert part in done.output


def test_json_tells_the_same_and_nothing_else(monkeypatch, folder):
    done = doctor(monkeypatch, SOUND, "--json", "-")
    report = json.loads(done.output)
    assert done.exit_code == 0
    assert report["healthy"] is True and report["problems"] == []
    assert report["data_folder"] == str(folder)
    assert report["versions"].keys() == {"python", "cyclemap", "numpy", "scipy", "casadi", "matplotlib"}
    assert report["kernels"]["compiled"] is True and report["kernels"]["why_not"] is None
    assert report["kernels"]["compiled_ms"] == pytest.approx(0.5)


def test_no_compiler_is_healthy_and_told(monkeypatch):
    done = doctor(monkeypatch, INTERPRETED, "--json", "-")
    kernels = json.loads(done.output)["kernels"]
    assert done.exit_code == 0
    assert kernels["compiled"] is False and kernels["why_not"].startswith("no C compiler found")
    assert "interpreted: no C compiler" in doctor(monkeypatch, INTERPRETED).output


def test_a_wrong_number_or_a_missing_data_folder_ends_with_exit_code_1(monkeypatch, folder):
    done = doctor(monkeypatch, WRONG)
    assert done.exit_code == 1
    assert "PROBLEM" in done.output and "not healthy" in done.output
    monkeypatch.setenv("CYCLEMAP_DATA", str(folder / "nowhere"))
    done = doctor(monkeypatch, SOUND, "--json", "-")
    assert done.exit_code == 1
    assert "is no folder" in json.loads(done.output)["problems"][0]
