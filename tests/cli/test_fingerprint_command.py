"""`cyclemap fingerprint` from outside: its JSON, its picture, its sentences, and what it refuses."""

import json
import math

import pytest

from cyclemap.cli import main
from cyclemap.cli.commands import fingerprint_command

FIVE = ("turn_deg", "offset_amplitude_deg", "offset_phase_deg", "ellipse_amplitude_deg", "ellipse_phase_deg")


@pytest.fixture(autouse=True)
def known_command(monkeypatch) -> None:
    monkeypatch.setitem(main.cli.commands, "fingerprint", fingerprint_command)


def run_json(tmp_path, capsys, *arguments):
    assert main.run(["fingerprint", *arguments, "--out", str(tmp_path), "--json", "-"]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    return json.loads(shown.out, parse_constant=lambda name: pytest.fail(f"JSON holds {name}")), shown.out


@pytest.mark.slow
def test_json_of_a_material_tells_the_numbers_of_the_protocol_and_where_the_full_map_locks(tmp_path, capsys) -> None:
    report, text = run_json(tmp_path, capsys, "plywood", "--check")
    assert [report[key] for key in FIVE] == pytest.approx([8.0022, 117.279, 129.478, 101.365, -111.061], abs=1e-3)
    assert report["push"]["turn_deg"] + report["drag"]["turn_deg"] == pytest.approx(report["turn_deg"])
    prediction = report["prediction"]
    assert (prediction["material"], prediction["verdict"], prediction["trusted"]) == ("plywood", "locks", True)
    assert prediction["offset"] == pytest.approx(math.hypot(0.0325, 0.0082) / math.sqrt(0.2545 * 0.2346))
    stable, unstable = prediction["directions"]
    assert (stable["stable"], unstable["stable"]) == (True, False)
    full = report["full_map"]["fixed_points"]
    assert [point["theta_deg"] for point in full] == pytest.approx([63.168, 199.876], abs=2e-3)
    for predicted, checked, point in zip(prediction["directions"], report["full_map"]["checked"], full, strict=True):
        assert checked["full_deg"] == point["theta_deg"] and checked["within_error"]
        assert checked["miss_deg"] == pytest.approx(abs(predicted["theta_deg"] - point["theta_deg"]))
        assert checked["miss_deg"] <= predicted["error_deg"]
    low, high = prediction["lock_in_scale_range"]
    assert low < prediction["lock_in_scale"] < high < 1.0
    written = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert set(written) == {"fingerprint_plywood.png", "fingerprint_plywood.json"}
    assert written["fingerprint_plywood.png"].startswith(b"\x89PNG")
    assert written["fingerprint_plywood.json"].decode() == text


@pytest.mark.slow
def test_without_a_material_only_the_protocol_is_told_and_settings_change_it(tmp_path, capsys) -> None:
    plain, _ = run_json(tmp_path, capsys)
    assert set(plain) == {*FIVE, "push", "drag", "remainder_per_rad"}
    changes = ("--set", "push_mm=50", "--set", "mu_a=.26", "--set", "mu_b=.24", "--format", "svg")
    changed, _ = run_json(tmp_path, capsys, *changes)
    assert changed["turn_deg"] == pytest.approx(-1.5527, abs=1e-3) != plain["turn_deg"]
    assert changed["prediction"]["ellipticity"] == pytest.approx(0.5 * math.log(0.26 / 0.24))
    assert changed["prediction"]["offset"] == 0.0
    written = {path.name for path in tmp_path.iterdir()}
    assert {"fingerprint_protocol.png", "fingerprint_isotropic_changed.svg"} < written


@pytest.mark.slow
def test_people_read_the_five_numbers_and_the_direction_with_its_error(tmp_path, capsys) -> None:
    assert main.run(["fingerprint", "plywood", "--out", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    for words in ("8.002", "117.279", "129.478", "101.365", "−111.061", "plywood locks into 59.4° ± 21.1°"):
        assert words in shown
