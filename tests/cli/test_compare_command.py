"""`cyclemap compare` from outside: its JSON, its picture, and data that do not tell a length."""

import math
from pathlib import Path

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.maps import CircleMap

KEYS = (
    "prediction data pushes ends_off cycle orientations directions staircase verdicts uncertified"
)
COMPARE = "compare plywood --runs 19 --data"


@pytest.fixture
def here(tmp_path, monkeypatch, theta0_file, sine_path) -> Path:
    """A folder of measured orientations; few simulated collections for what takes longest; a map at
    hand.
    """
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("cyclemap.evidence.comparison.compare.MOST_DETAILED", 19)
    given = CircleMap.arnold(0.11, 0.6)
    monkeypatch.setattr(CollectionLoop, "circle_map", lambda *_, **__: given)
    theta0_file(tmp_path / "measured.csv", sine_path(0.1, 120))
    return tmp_path


def poses() -> str:
    loop, lines = CollectionLoop.mit("plywood"), ["rep,surface,shape,i,s,t,x0,y0,theta0,x1,y1,th1"]
    for number, theta in enumerate(np.linspace(0.1, 6.0, 5).tolist()):
        push = loop.model.push(loop.start_pose(theta), loop.push)
        moved = complex(*push.displacement) * np.exp(1j * theta)
        end = f"{moved.real},{moved.imag},{theta + push.turn}"
        lines.append(f"{number},plywood,rect1,0,0.7,0,0,0,{theta},{end}")
    return "\n".join(lines) + "\n"


@pytest.mark.slow
def test_json_tells_everything_that_was_asked_and_nothing_else(saved_report) -> None:
    told = "--set noise_deg=5.7 --first 20 --out pictures"
    report = saved_report("pictures/compare_plywood", f"{COMPARE} measured.csv {told}")
    assert " ".join(report) == KEYS
    told = {"material": "plywood", "kind": "loop", "posterior_samples": 0, "refitted": False}
    assert report["prediction"] == {**told, "noise_deg": pytest.approx(5.7)}
    left_out = {"among the first": 20}
    assert report["data"] == {"cycles": 100, "left_out": left_out, "unreadable_files": 0}
    assert report["pushes"] == []
    assert report["cycle"]["rms_deg"] == pytest.approx(math.degrees(0.1), rel=0.3)
    histogram = report["orientations"]["histogram"]
    for whose in ("measured_per_deg", "predicted_per_deg"):
        assert 5.0 * sum(histogram[whose]) == pytest.approx(1.0)
    assert len(report["directions"]["predicted"]) == 1
    assert report["staircase"]["turns"]["lower"] <= report["staircase"]["turns"]["upper"]
    assert all({"question", "agrees", "words"} == set(row) for row in report["verdicts"])


@pytest.mark.slow
def test_a_length_that_the_data_do_not_tell_is_asked_for(here, refused, report_of) -> None:
    (here / "poses.csv").write_text(poses())
    refused(f"{COMPARE} poses.csv", "do not tell how far the rod moved")
    (pushes,) = report_of(f"{COMPARE} poses.csv --set push_mm=150")["pushes"]
    assert pushes["push_mm"] == pytest.approx(150.0) and pushes["dx_mm"]["rmse"] < 1e-3
