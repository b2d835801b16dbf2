"""The command line from outside: JSON, pictures, exit codes; what is installed, and whether it is
healthy.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from cyclemap.cli import run_doctor
from cyclemap.cli.main import cli
from cyclemap.errors import EngineNotBuilt
from cyclemap.mechanics.engine import library

CYCLE_KEYS = "theta0_deg push_turn_deg push_dx_mm push_dy_mm drag_turn_deg drag_mm theta1_deg"
PORTRAIT_KEYS = {
    "map": "degree samples max_error_deg mean_turn_deg min_turn_deg max_turn_deg min_slope "
    "max_slope",
    "rotation_number": "value lower upper locked",
    "stationary": "noise_deg peaks_deg spectral_gap mixing_cycles tv_from_uniform",
    "staircase": "mean_turn_deg mean_residence_cycles step_deg",
}


@pytest.mark.slow
def test_portrait_prints_the_promised_json_and_leaves_picture_and_json(saved_report) -> None:
    report = saved_report("pictures/portrait_plywood", "portrait plywood --out pictures")
    keys = "map fixed_points rotation_number stationary staircase uncertainty"
    assert " ".join(report) == keys
    for part, keys in PORTRAIT_KEYS.items():
        assert set(report[part]) == set(keys.split()), part
    for orbit in report["fixed_points"]:
        assert set(orbit) == {"theta_deg", "multiplier", "stable"} and 0 <= orbit["theta_deg"] < 360
        assert orbit["stable"] is (abs(orbit["multiplier"]) < 1)
    assert sorted(orbit["stable"] for orbit in report["fixed_points"]) == [False, True]
    assert (report["rotation_number"]["locked"], report["map"]["degree"]) == ("0/1", 1)
    assert report["map"]["min_turn_deg"] < 0 < report["map"]["max_turn_deg"]


@pytest.mark.slow
def test_portrait_for_people_answers_in_sentences_also_about_data(here, said) -> None:
    rows = "".join(f"{theta},{theta + 5.0}\n" for theta in range(0, 360, 2))
    (here / "pairs.csv").write_text("theta0_deg,theta_next_deg\n" + rows)
    shown = said("portrait plywood --data pairs.csv --cycles 50 --format svg")
    assert shown.err == "" and shown.out.startswith("plywood locks into ")
    told = ("multiplier", "recorded directions", "The staircase", "unstable")
    for words in (*told, "180 measured cycles lie", "picture: out/portrait_plywood.svg"):
        assert words in shown.out
    assert (here / "out" / "portrait_plywood.svg").read_bytes().startswith(b"<?xml")
    data = json.loads((here / "out" / "portrait_plywood.json").read_text())["data"]
    assert (data["pairs"], data["dropped"]) == (180, {}) and 0 < data["rms_deg"] < 30


def test_cycle_adds_up_and_matches_the_independent_solver(report_of) -> None:
    cycles = report_of("cycle plywood --theta0-deg 60,-30,400")["cycles"]
    assert [cycle["theta0_deg"] for cycle in cycles] == pytest.approx([60, -30, 400])
    for cycle in cycles:
        assert " ".join(cycle) == CYCLE_KEYS
        added = cycle["theta0_deg"] + cycle["push_turn_deg"] + cycle["drag_turn_deg"]
        assert cycle["theta1_deg"] == pytest.approx(added, abs=1e-9)
    expected = (60.0, 73.84911, 42.21066, -71.18737, -73.51442, 97.47321)
    assert [*cycles[0].values()][:6] == pytest.approx(expected, abs=1e-4)


def test_json_file_and_out_folder_leave_the_terminal_to_people(here, said) -> None:
    shown = said("cycle plywood --theta0-deg 60 --json a.json --out made").out
    assert "73.849" in shown and "dx (mm)" in shown
    assert (here / "a.json").read_bytes() == (here / "made" / "cycles_plywood.json").read_bytes()


def test_a_material_file_is_an_argument_or_an_option_and_its_name_no_markup(
    here, said, report_of
) -> None:
    (here / "mine.toml").write_text('name = "[red]rust[/]"\n[friction]\nmu_a = 0.25\nmu_b = 0.25\n')
    report = report_of("cycle mine.toml --theta0-deg 10")
    assert report_of("cycle --material mine.toml --theta0-deg 10") == report
    # Isotropic friction: the same at every angle, as the independent solver has it.
    assert report["cycles"][0]["push_turn_deg"] == pytest.approx(74.52037, abs=1e-4)
    assert "on [red]rust[/]" in said("cycle mine.toml --theta0-deg 10").out


def test_folder_that_cannot_be_made_exits_1(here, refused) -> None:
    (here / "taken").write_text("a file")
    refused("cycle plywood --theta0-deg 0 --out taken --json -", "taken", 1)


@pytest.mark.slow
def test_real_entry_point_exits_2_without_traceback() -> None:
    entry = Path(sys.executable).with_name("cyclemap")
    done = subprocess.run([entry, "cycle", "plywod"], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and done.stderr.startswith("error: unknown material 'plywod'")


def test_version_and_help_answer_without_a_numerical_library(said) -> None:
    assert said("--version").out.startswith("cyclemap, version 0.")
    probe = (
        "import sys; from cyclemap.cli.main import run; run(['--help']); print(sorted(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    modules = done.stdout.splitlines()[-1]
    assert "'click'" in modules
    for heavy in ("numpy", "scipy", "casadi", "matplotlib", "rich"):
        assert f"'{heavy}'" not in modules


def test_no_two_parameters_of_a_command_fill_one_field() -> None:
    """Groups of options that meet in a command would else overwrite each other without a word."""
    for name, command in cli.commands.items():
        fields = [parameter.name for parameter in command.params]
        flags = [flag for parameter in command.params for flag in parameter.opts]
        assert len(fields) == len({*fields}) and len(flags) == len({*flags}), name


def test_no_command_shows_the_help_and_exits_2(said) -> None:
    shown = said("", 2)
    assert shown.out == "" and "Commands:" in shown.err


@pytest.mark.slow
@pytest.mark.parametrize("more", [[], ["--json", "-"]])
def test_reader_that_goes_away_is_no_noise(more) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    words = [sys.executable, "-m", "cyclemap", "cycle", "plywood", "--theta0-deg", "0", *more]
    done = subprocess.run(words, stdout=writing, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writing)
    assert (done.returncode, done.stderr) == (141, "")


def test_doctor_tells_versions_engine_and_how_far_its_cycles_are_off(
    here, said, report_of, monkeypatch
) -> None:
    monkeypatch.setenv("CYCLEMAP_DATA", str(here))
    shown = said("doctor").out.replace("\n", "")
    for words in ("numpy", "_engine", "of an independent solver's", str(here), "healthy"):
        assert words in shown
    report = report_of("doctor")
    assert report["healthy"] is True and report["problems"] == []
    assert report["data_folder"] == str(here)
    assert " ".join(report["versions"]) == "python cyclemap numpy scipy casadi matplotlib"
    assert len(report["engine_version"]) == 64
    assert 0.0 < report["self_check_error_deg"] < 1e-4
    monkeypatch.setenv("CYCLEMAP_DATA", str(here / "nowhere"))
    (problem,) = json.loads(said("doctor --json -", 1).out)["problems"]
    assert "is no folder" in problem


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
def test_what_does_not_work_is_told_by_doctor_with_exit_code_1(
    said, monkeypatch, place, name, broken, problem
) -> None:
    monkeypatch.setattr(place, name, broken)
    shown = said("doctor", 1).out
    assert f"PROBLEM: {problem}" in shown and "not healthy" in shown
