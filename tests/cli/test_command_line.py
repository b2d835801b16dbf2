"""The command line from outside: JSON, pictures, exit codes,
and one clear line for every misuse."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from cyclemap.cli.main import cli, run

CYCLE_KEYS = [
    "theta0_deg",
    "push_turn_deg",
    "push_dx_mm",
    "push_dy_mm",
    "drag_turn_deg",
    "drag_mm",
    "theta1_deg",
]
PORTRAIT_KEYS = {
    "map": "degree samples max_error_deg mean_turn_deg min_turn_deg max_turn_deg min_slope "
    "max_slope",
    "rotation_number": "value lower upper locked",
    "stationary": "noise_deg peaks_deg spectral_gap mixing_cycles tv_from_uniform",
    "staircase": "mean_turn_deg mean_residence_cycles step_deg",
}


@pytest.mark.slow
def test_portrait_prints_the_promised_json_and_leaves_picture_and_json(saved_report) -> None:
    report = saved_report("pictures/portrait_plywood", "portrait", "plywood", "--out", "pictures")
    assert list(report) == [
        "map",
        "fixed_points",
        "rotation_number",
        "stationary",
        "staircase",
        "uncertainty",
    ]
    for part, keys in PORTRAIT_KEYS.items():
        assert set(report[part]) == set(keys.split()), part
    for orbit in report["fixed_points"]:
        assert set(orbit) == {"theta_deg", "multiplier", "stable"} and 0 <= orbit["theta_deg"] < 360
        assert orbit["stable"] is (abs(orbit["multiplier"]) < 1)
    assert sorted(orbit["stable"] for orbit in report["fixed_points"]) == [False, True]
    assert (report["rotation_number"]["locked"], report["map"]["degree"]) == ("0/1", 1)
    assert report["map"]["min_turn_deg"] < 0 < report["map"]["max_turn_deg"]


@pytest.mark.slow
def test_portrait_for_people_answers_in_sentences_also_about_data(here, capsys) -> None:
    rows = "".join(f"{theta},{theta + 5.0}\n" for theta in range(0, 360, 2))
    (here / "pairs.csv").write_text("theta0_deg,theta_next_deg\n" + rows)
    assert (
        run(["portrait", "plywood", "--data", "pairs.csv", "--cycles", "50", "--format", "svg"])
        == 0
    )
    shown = capsys.readouterr()
    assert shown.err == "" and shown.out.startswith("plywood locks into ")
    for part in (
        "multiplier",
        "recorded directions",
        "The staircase",
        "unstable",
        "picture: out/portrait_plywood.svg",
    ):
        assert part in shown.out
    assert "180 measured cycles lie" in shown.out
    assert (here / "out" / "portrait_plywood.svg").read_bytes().startswith(b"<?xml")
    data = json.loads((here / "out" / "portrait_plywood.json").read_text())["data"]
    assert (data["pairs"], data["dropped"]) == (180, {}) and 0 < data["rms_deg"] < 30


def test_cycle_adds_up_and_matches_the_independent_solver(report_of) -> None:
    cycles = report_of("cycle", "plywood", "--theta0-deg", "60,-30,400")["cycles"]
    assert [cycle["theta0_deg"] for cycle in cycles] == pytest.approx([60, -30, 400])
    for cycle in cycles:
        assert list(cycle) == CYCLE_KEYS
        added = cycle["theta0_deg"] + cycle["push_turn_deg"] + cycle["drag_turn_deg"]
        assert cycle["theta1_deg"] == pytest.approx(added, abs=1e-9)
    expected = (60.0, 73.84911, 42.21066, -71.18737, -73.51442, 97.47321)
    assert [cycles[0][key] for key in CYCLE_KEYS[:6]] == pytest.approx(expected, abs=1e-4)


def test_json_file_and_out_folder_leave_the_terminal_to_people(here, capsys) -> None:
    assert run(["cycle", "plywood", "--theta0-deg", "60", "--json", "a.json", "--out", "made"]) == 0
    shown = capsys.readouterr().out
    assert "73.849" in shown and "dx (mm)" in shown
    assert (here / "a.json").read_bytes() == (here / "made" / "cycles_plywood.json").read_bytes()


def test_a_material_file_is_an_argument_or_an_option_and_its_name_no_markup(
    here, capsys, report_of
) -> None:
    (here / "mine.toml").write_text('name = "[red]rust[/]"\n[friction]\nmu_a = 0.25\nmu_b = 0.25\n')
    report = report_of("cycle", "mine.toml", "--theta0-deg", "10")
    assert report_of("cycle", "--material", "mine.toml", "--theta0-deg", "10") == report
    # Isotropic friction: the same at every angle, as the independent solver has it.
    assert report["cycles"][0]["push_turn_deg"] == pytest.approx(74.52037, abs=1e-4)
    assert run(["cycle", "mine.toml", "--theta0-deg", "10"]) == 0
    assert "on [red]rust[/]" in capsys.readouterr().out


def test_folder_that_cannot_be_made_exits_1(here, refused) -> None:
    (here / "taken").write_text("a file")
    refused(["cycle", "plywood", "--theta0-deg", "0", "--out", "taken", "--json", "-"], "taken", 1)


@pytest.mark.slow
def test_real_entry_point_exits_2_without_traceback() -> None:
    entry = Path(sys.executable).with_name("cyclemap")
    done = subprocess.run([entry, "cycle", "plywod"], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and done.stderr.startswith("error: unknown material 'plywod'")


def test_version_and_help_answer_without_a_numerical_library(capsys) -> None:
    assert run(["--version"]) == 0 and capsys.readouterr().out.startswith("cyclemap, version 0.")
    probe = (
        "import sys; from cyclemap.cli.main import run; run(['--help']); print(sorted(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    modules = done.stdout.splitlines()[-1]
    assert "'click'" in modules
    for heavy in ("numpy", "scipy", "casadi", "matplotlib", "rich"):
        assert f"'{heavy}'" not in modules


@pytest.mark.slow
def test_a_portrait_does_without_scipy(here) -> None:
    """It takes a fifth as long to import as all of the rest to draw."""
    code = (
        "import sys; from cyclemap.cli.main import run; code = run(['portrait', 'plywood']); "
        "sys.exit(code or 'scipy' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False, cwd=here).returncode == 0


def test_no_two_parameters_of_a_command_fill_one_field() -> None:
    """Groups of options that meet in a command would else overwrite each other without a word."""
    for name, command in cli.commands.items():
        fields = [parameter.name for parameter in command.params]
        flags = [flag for parameter in command.params for flag in parameter.opts]
        assert len(fields) == len({*fields}) and len(flags) == len({*flags}), name


def test_no_command_shows_the_help_and_exits_2(capsys) -> None:
    assert run([]) == 2
    shown = capsys.readouterr()
    assert shown.out == "" and "Commands:" in shown.err


@pytest.mark.slow
@pytest.mark.parametrize("json_option", [[], ["--json", "-"]])
def test_reader_that_goes_away_is_no_noise(json_option) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    command = [
        sys.executable,
        "-m",
        "cyclemap",
        "cycle",
        "plywood",
        "--theta0-deg",
        "0",
        *json_option,
    ]
    done = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writing)
    assert (done.returncode, done.stderr) == (141, "")
