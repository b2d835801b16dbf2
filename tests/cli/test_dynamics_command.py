"""`cyclemap dynamics` from outside: its JSON, its picture, its table, and what it refuses."""

import json
from pathlib import Path

import pytest

from cyclemap.cli.main import run
from cyclemap.collection import CollectionLoop, DynamicLoop, DynamicsComparison, compare_dynamics, isotropic_twin
from cyclemap.views.dynamics_page import difference_sentence, dynamics_page

ROW_KEYS = ["theta0_deg", "push_turn_deg", "push_dx_mm", "push_dy_mm", "drag_turn_deg", "theta1_deg", "left"]
SHORT = ["--set", "push_mm=30"]


@pytest.fixture
def here(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
def test_json_tells_both_models_on_both_laws_and_nothing_else(here, capsys) -> None:
    assert run(["dynamics", "plywood", "--theta0-deg", "0,90", *SHORT, "--json", "-"]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    report = json.loads(shown.out, parse_constant=lambda name: pytest.fail(f"JSON holds {name}"))
    assert list(report) == ["speed_mm_s", "anisotropic", "isotropic"]
    assert report["isotropic"].pop("mu") == pytest.approx((0.2545 * 0.2346) ** 0.5)
    for law in ("anisotropic", "isotropic"):
        assert list(report[law]) == ["dynamic", "quasi_static"]
        for rows in report[law].values():
            assert [row["theta0_deg"] for row in rows] == [0.0, 90.0]
            assert all(list(row) == ROW_KEYS for row in rows)
        pairs = list(zip(report[law]["dynamic"], report[law]["quasi_static"], strict=True))
        assert len(pairs) == 2
        assert all(0.0 < abs(a["theta1_deg"] - b["theta1_deg"]) < 0.3 for a, b in pairs)
    one, other = report["isotropic"]["dynamic"]
    assert one["push_turn_deg"] == pytest.approx(other["push_turn_deg"], abs=1e-3)
    written = {path.name: path.read_bytes() for path in (here / "out").iterdir()}
    assert set(written) == {"dynamics_plywood.png", "dynamics_plywood.json"}
    assert written["dynamics_plywood.png"].startswith(b"\x89PNG")
    assert written["dynamics_plywood.json"].decode() == shown.out


def test_people_are_told_the_largest_differences_and_every_cycle(here, capsys) -> None:
    assert run(["dynamics", "plywood", "--theta0-deg", "30", "--speed-mm-s", "50", *SHORT, "--format", "svg"]) == 0
    shown = capsys.readouterr().out
    for part in ("differ by at most", "Cycles at 50 mm/s", "quasi-static", "isotropic", "dynamics_plywood.svg"):
        assert part in shown
    assert (here / "out" / "dynamics_plywood.svg").read_bytes().startswith(b"<?xml")


def test_one_orientation_shows_the_quasi_static_turn_by_a_marker() -> None:
    loop = DynamicLoop(CollectionLoop.from_settings({"push_mm": 20}))
    one, two = compare_dynamics(loop, [1.0]), compare_dynamics(loop, [1.0, 2.0])
    shown = [[line.get_marker() for line in dynamics_page(each, each).axes[0].lines] for each in (one, two)]
    assert shown == [["x", "o", "x", "o"], ["None", "o", "None", "o"]]


def test_the_page_shows_both_laws_and_says_how_far_they_differ() -> None:
    loop = CollectionLoop.from_settings({"push_mm": 20})
    comparisons: list[DynamicsComparison] = [
        compare_dynamics(DynamicLoop(each), [0.0, 2.0]) for each in (loop, isotropic_twin(loop))
    ]
    page = dynamics_page(*comparisons)
    assert len(page.axes) == 3
    assert [axes.get_xlabel() for axes in page.axes] == ["θ0 (°)"] * 3
    # Three turns and two components of the displacement, each on two laws, and the line at zero.
    assert [len(axes.lines) for axes in page.axes] == [4, 7, 5]
    words = " ".join(" ".join(text.get_text().split()) for text in page.texts)
    assert all(difference_sentence(comparison) in words for comparison in comparisons)
