"""`cyclemap staircase` from outside: its JSON, its picture, its words, and what it refuses."""

import json
import math
from pathlib import Path

import pytest

from cyclemap.cli.main import run
from cyclemap.maps import CircleMap, WrappedNormal, sample_staircase

ZONE_KEYS = {"centre_deg", "arc_deg", "kind", "residence_cycles", "log10_residence_cycles"}
RUN_KEYS = {"seed", "cycles", "climb_deg", "steps", "heights_deg", "dwells"}
# A ring 9.8 mm from the centre instead of 15: the two fixed points of plywood have met and gone.
GHOST = ["staircase", "plywood", "--set", "hitch_x_mm=-6.9", "--set", "hitch_y_mm=6.9"]


@pytest.fixture
def here(tmp_path, monkeypatch) -> Path:
    """An empty current folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def staircase_file(folder: Path, cycles: int = 1_500) -> Path:
    path = sample_staircase(CircleMap.arnold(0.11, 0.6), WrappedNormal(0.03), cycles, seed=1).theta
    file = folder / "measured.csv"
    rows = "".join(f"{math.degrees(theta) % 360:.4f}\n" for theta in path)
    file.write_text("theta0_deg\n" + rows)
    return file


@pytest.mark.slow
def test_json_tells_prediction_run_and_data_and_nothing_else(here, capsys) -> None:
    data = staircase_file(here)
    assert run([*GHOST, "--data", str(data), "--json", "-", "--out", "pictures"]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    report = json.loads(shown.out, parse_constant=lambda name: pytest.fail(f"JSON holds {name}"))
    assert list(report) == ["noise_deg", "prediction", "run", "uncertainty", "data"]
    (zone,) = report["prediction"]["zones"]
    assert set(zone) == ZONE_KEYS
    assert zone["kind"] == "ghost"
    assert report["prediction"]["step_deg"] == pytest.approx(360.0)
    assert set(report["run"]) == RUN_KEYS
    assert report["run"]["cycles"] == 1_500
    assert len(report["run"]["heights_deg"]) == report["run"]["steps"] == len(report["run"]["dwells"]) - 1
    assert set(report["data"]) == RUN_KEYS - {"seed"} | {"fitted", "comparison"}
    assert report["data"]["fitted"]["noise_deg"] == pytest.approx(math.degrees(0.03), rel=0.1)
    written = {path.name: path.read_bytes() for path in (here / "pictures").iterdir()}
    assert set(written) == {"staircase_plywood.png", "staircase_plywood.json"}
    assert written["staircase_plywood.png"].startswith(b"\x89PNG")
    assert written["staircase_plywood.json"].decode() == shown.out


@pytest.mark.slow
def test_people_are_told_where_it_rests_how_long_and_how_high_it_climbs(here, capsys) -> None:
    assert run([*GHOST, "--format", "svg", "--cycles", "1000"]) == 0
    shown = capsys.readouterr().out
    for part in ("θ0 rests near", "steps are 360° high", "In one run of 1000 cycles", "staircase_plywood.svg"):
        assert part in shown
    assert (here / "out" / "staircase_plywood.svg").read_bytes().startswith(b"<?xml")


def test_pairs_without_an_order_are_refused(here, capsys) -> None:
    (here / "pairs.csv").write_text("theta0_deg,theta_next_deg\n" + "".join(f"{k},{k + 2}\n" for k in range(50)))
    assert run(["staircase", "plywood", "--data", "pairs.csv"]) == 2
    assert "order" in capsys.readouterr().err
