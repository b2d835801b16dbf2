"""The command line from outside: JSON, pictures, exit codes, and one clear line for every misuse."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cyclemap.cli.main import run

CYCLE_KEYS = ["theta0_deg", "push_turn_deg", "push_dx_mm", "push_dy_mm", "drag_turn_deg", "drag_mm", "theta1_deg"]
PORTRAIT_KEYS = {
    "map": {
        "degree",
        "samples",
        "max_error_deg",
        "mean_turn_deg",
        "min_turn_deg",
        "max_turn_deg",
        "min_slope",
        "max_slope",
    },
    "rotation_number": {"value", "lower", "upper", "locked"},
    "stationary": {"noise_deg", "peaks_deg", "spectral_gap", "mixing_cycles", "tv_from_uniform"},
    "staircase": {"mean_turn_deg", "mean_residence_cycles", "step_deg"},
}


def refuse_constant(name: str) -> None:
    raise AssertionError(f"JSON holds {name}")


def strict_json(text: str) -> dict:
    return json.loads(text, parse_constant=refuse_constant)


@pytest.fixture(scope="module")
def plywood_run(tmp_path_factory) -> tuple[Path, subprocess.CompletedProcess]:
    """`cyclemap portrait plywood --json -`, run once as a user would."""
    folder = tmp_path_factory.mktemp("portrait")
    command = [sys.executable, "-m", "cyclemap", "portrait", "plywood", "--json", "-", "--out", "pictures"]
    return folder, subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def test_portrait_prints_nothing_but_the_promised_json(plywood_run) -> None:
    _, done = plywood_run
    assert done.returncode == 0 and all(" % done, " in line for line in done.stderr.splitlines())
    report = strict_json(done.stdout)
    assert list(report) == ["map", "fixed_points", "rotation_number", "stationary", "staircase", "uncertainty"]
    for part, keys in PORTRAIT_KEYS.items():
        assert set(report[part]) == keys, part
    assert report["fixed_points"]
    for orbit in report["fixed_points"]:
        assert set(orbit) == {"theta_deg", "multiplier", "stable"}
        assert 0 <= orbit["theta_deg"] < 360
        assert orbit["stable"] is (abs(orbit["multiplier"]) < 1)


def test_plywood_has_one_stable_and_one_unstable_direction_and_is_locked(plywood_run) -> None:
    report = strict_json(plywood_run[1].stdout)
    assert sorted(orbit["stable"] for orbit in report["fixed_points"]) == [False, True]
    assert report["rotation_number"]["locked"] == "0/1"
    assert report["map"]["degree"] == 1
    assert report["map"]["min_turn_deg"] < 0 < report["map"]["max_turn_deg"]


def test_portrait_leaves_picture_and_json_and_nothing_else(plywood_run) -> None:
    folder, done = plywood_run
    written = {path.name: path.read_bytes() for path in (folder / "pictures").iterdir()}
    assert set(written) == {"portrait_plywood.png", "portrait_plywood.json"}
    assert written["portrait_plywood.png"].startswith(b"\x89PNG")
    assert written["portrait_plywood.json"].decode() == done.stdout


@pytest.mark.slow
def test_portrait_for_people_answers_in_sentences(here, capsys) -> None:
    assert run(["portrait", "plywood", "--cycles", "100", "--format", "svg"]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    assert shown.out.startswith("plywood locks into ")
    for part in ("multiplier", "recorded directions", "The staircase", "unstable", "picture: out/portrait_plywood.svg"):
        assert part in shown.out
    assert (here / "out" / "portrait_plywood.svg").read_bytes().startswith(b"<?xml")


@pytest.mark.slow
def test_portrait_with_data_reports_the_distance(here, capsys) -> None:
    rows = "".join(f"{theta},{theta + 5.0}\n" for theta in range(0, 360, 2))
    (here / "pairs.csv").write_text("theta0_deg,theta_next_deg\n" + rows)
    assert run(["portrait", "plywood", "--data", "pairs.csv", "--json", "-", "--cycles", "50"]) == 0
    data = strict_json(capsys.readouterr().out)["data"]
    assert data["pairs"] == 180
    assert data["dropped"] == {}
    assert 0 < data["rms_deg"] < 30


def test_cycle_json_has_the_promised_keys_and_adds_up(capsys) -> None:
    assert run(["cycle", "plywood", "--theta0-deg", "0,-30,400", "--json", "-"]) == 0
    shown = capsys.readouterr()
    cycles = strict_json(shown.out)["cycles"]
    assert shown.err == ""
    assert [cycle["theta0_deg"] for cycle in cycles] == pytest.approx([0, -30, 400])
    for cycle in cycles:
        assert list(cycle) == CYCLE_KEYS
        added = cycle["theta0_deg"] + cycle["push_turn_deg"] + cycle["drag_turn_deg"]
        assert cycle["theta1_deg"] == pytest.approx(added, abs=1e-9)


def test_cycle_matches_the_independent_solver(capsys) -> None:
    assert run(["cycle", "plywood", "--theta0-deg", "60", "--json", "-"]) == 0
    (cycle,) = strict_json(capsys.readouterr().out)["cycles"]
    expected = (60.0, 73.84911, 42.21066, -71.18737, -73.51442, 97.47321)
    assert [cycle[key] for key in CYCLE_KEYS[:6]] == pytest.approx(expected, abs=1e-4)


def test_cycle_for_people_is_a_table(capsys) -> None:
    assert run(["cycle", "plywood", "--theta0-deg", "60"]) == 0
    shown = capsys.readouterr()
    assert "73.849" in shown.out
    assert "dx (mm)" in shown.out


def test_json_file_and_out_folder_leave_the_terminal_to_people(here, capsys) -> None:
    assert run(["cycle", "plywood", "--theta0-deg", "60", "--json", "a.json", "--out", "made"]) == 0
    assert "73.849" in capsys.readouterr().out
    assert (here / "a.json").read_bytes() == (here / "made" / "cycles_plywood.json").read_bytes()


def test_material_file_by_argument_and_by_option_are_the_same(here, capsys) -> None:
    (here / "mine.toml").write_text('name = "mine"\n[friction]\nmu_a = 0.25\nmu_b = 0.25\n')
    assert run(["cycle", "mine.toml", "--theta0-deg", "10", "--json", "-"]) == 0
    by_argument = capsys.readouterr().out
    assert run(["cycle", "--material", "mine.toml", "--theta0-deg", "10", "--json", "-"]) == 0
    assert capsys.readouterr().out == by_argument
    # Isotropic friction: the same at every angle, as the independent solver has it.
    assert strict_json(by_argument)["cycles"][0]["push_turn_deg"] == pytest.approx(74.52037, abs=1e-4)


def test_folder_that_cannot_be_made_exits_1(here, capsys) -> None:
    (here / "taken").write_text("a file")
    assert run(["cycle", "plywood", "--theta0-deg", "0", "--out", "taken"]) == 1
    assert capsys.readouterr().err.startswith("error: ")


def cyclemap(*arguments: str, **options) -> subprocess.Popen:
    command = [sys.executable, "-m", "cyclemap", *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)


@pytest.mark.slow
def test_real_entry_point_exits_2_without_traceback() -> None:
    entry = Path(sys.executable).with_name("cyclemap")
    done = subprocess.run([entry, "cycle", "plywod"], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("error: unknown material 'plywod'")
    assert done.stderr.count("\n") == 1


def test_version_and_help_answer() -> None:
    assert cyclemap("--version").communicate()[0].startswith("cyclemap, version 0.")
    help_text = cyclemap("--help").communicate()[0]
    assert "portrait" in help_text and "cycle" in help_text


def test_help_imports_no_numerical_library() -> None:
    probe = "import sys; from cyclemap.cli.main import run; run(['--help']); print(sorted(sys.modules))"
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    modules = done.stdout.splitlines()[-1]
    assert "'click'" in modules
    for heavy in ("numpy", "scipy", "casadi", "matplotlib", "rich"):
        assert f"'{heavy}'" not in modules


def test_no_command_shows_the_help_and_exits_2() -> None:
    process = cyclemap()
    out, err = process.communicate()
    assert (process.returncode, out) == (2, "")
    assert "Commands:" in err


@pytest.mark.slow
@pytest.mark.parametrize("json_option", [[], ["--json", "-"]])
def test_reader_that_goes_away_is_no_noise(json_option) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "cyclemap", "cycle", "plywood", "--theta0-deg", "0", *json_option]
    done = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writing)
    assert (done.returncode, done.stderr) == (141, "")


def test_name_with_markup_is_shown_as_it_is(here, capsys) -> None:
    (here / "mine.toml").write_text('name = "[red]rust[/]"\n[friction]\nmu_a = 0.25\nmu_b = 0.25\n')
    assert run(["cycle", "mine.toml", "--theta0-deg", "10"]) == 0
    assert "on [red]rust[/]" in capsys.readouterr().out


@pytest.mark.slow
def test_interrupt_exits_130_quietly(tmp_path) -> None:
    many = ",".join(str(angle) for angle in range(5000))
    # A test run in the background ignores interrupts, and so would all that it starts.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    process = cyclemap("cycle", "plywood", "--theta0-deg", many, "--json", "-", cwd=tmp_path)
    signal.signal(signal.SIGINT, before)
    time.sleep(2.0)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate()
    assert (process.returncode, err) == (130, "")
