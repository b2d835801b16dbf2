"""`cyclemap fit` from outside: its JSON, its pictures, its tables and words,
and what it refuses."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from cyclemap.cli.main import run

TURN = 2 * math.pi
HEADER = "surface,shape,v_mm_s,i,s,t,rep,x0,y0,th0,x1,y1,th1\n"
SET_KEYS = {
    "name",
    "source",
    "surface",
    "object",
    "acceleration_mm_s2",
    "speed_mm_s",
    "side",
    "fraction",
}
SET_KEYS |= {
    "angle_deg",
    "contacts",
    "pushes",
    "covered_deg",
    "statistics",
    "laws",
    "dtheta_histogram",
    "cycle_map",
    "last_cycles",
}


def worn_path(count: int) -> np.ndarray:
    rng, path = np.random.default_rng(0), [0.0]
    for n in range(count):
        path.append(
            path[-1] + 0.26 + 0.25 * math.cos(path[-1]) + 1e-3 * n + 0.02 * rng.standard_normal()
        )
    return np.array(path)


def collection(file: Path, count: int = 120) -> Path:
    """Pushes that turn by 1.2 + 0.1 cos 2θ rad and move by (40, -80) mm, over a path that wears."""
    rng, rows = np.random.default_rng(1), [HEADER]
    for n, theta in enumerate(worn_path(count).tolist()):
        end = (theta + 1.2 + 0.1 * math.cos(2 * theta) + 0.02 * rng.standard_normal()) % TURN
        dx, dy = 0.04 + 0.001 * rng.standard_normal(), -0.08 + 0.001 * rng.standard_normal()
        c, s = math.cos(theta), math.sin(theta)
        place = f"{0.35 + c * dx - s * dy:.9f},{-0.03 + s * dx + c * dy:.9f}"
        rows.append(
            f"plywood,rect1,20,0,0.7,0,{n},0.35,-0.03,{theta % TURN:.9f},{place},{end:.9f}\n"
        )
    file.write_text("".join(rows))
    return file


@pytest.mark.slow
def test_json_tells_what_was_read_and_fitted_and_nothing_else(here, capsys) -> None:
    collection(here / "pushes.csv")
    assert run(["fit", "pushes.csv", "--out", "results", "--json", "-"]) == 0
    shown = capsys.readouterr()
    assert "axes right-handed" in shown.err
    report = json.loads(shown.out)
    assert list(report) == ["pushes", "scans", "unreadable", "sets"]
    (found,) = report["sets"]
    assert set(found) == SET_KEYS
    assert (found["name"], found["pushes"], found["speed_mm_s"]) == ("plywood rect1", 121, 20.0)
    law, cycle = found["laws"]["dtheta"], found["cycle_map"]
    assert found["statistics"]["dtheta"]["mean_deg"] == pytest.approx(math.degrees(1.2), abs=3.0)
    assert law["rmse_deg"] == pytest.approx(math.degrees(0.02), rel=0.2) and law["harmonics"] == 2
    assert found["laws"]["dx"]["rmse_mm"] == pytest.approx(1.0, rel=0.2)
    assert sum(found["dtheta_histogram"]["measured"]) == 121
    assert (cycle["pairs"], cycle["wear_degree"], cycle["harmonics"]) == (120, 1, 1)
    assert cycle["late"]["slowest"]["theta_deg"] == pytest.approx(180.0, abs=10.0)
    assert sorted(path.suffix for path in (here / "results").iterdir()) == [".json", ".png"]
    assert json.loads((here / "results" / "fit_plywood_rect1.json").read_text()) == found


@pytest.mark.slow
def test_people_get_both_tables_whole_the_sentences_and_the_picture(here, capsys) -> None:
    collection(here / "pushes.csv", count=60)
    assert (
        run(
            ["fit", "pushes.csv", "--format", "svg", "--no-wear", "--harmonics", "2", "--seed", "3"]
        )
        == 0
    )
    shown = capsys.readouterr().out
    assert "…" not in shown
    for part in (
        "61 pushes read, in 1 set",
        "Δθ (°)",
        "Δy (mm)",
        "RMSE",
        "cv",
        "wear unknown",
        "plywood_rect1.svg",
    ):
        assert part in shown
    assert "a law of θ0 with 2 harmonics leaves" in shown
    assert (here / "out" / "fit_plywood_rect1.svg").read_bytes().startswith(b"<?xml")


@pytest.mark.slow
def test_theta0_alone_gives_a_cycle_map_and_no_tables(here, capsys, theta0_file) -> None:
    theta0_file(here / "angles.csv", worn_path(100))
    assert run(["fit", "angles.csv"]) == 0
    shown = capsys.readouterr().out
    assert "100 pushes of which θ0 alone is known" in shown
    assert "RMSE" not in shown
    assert "From push 25 on (the last three quarters)" in shown
    assert (here / "out" / "fit_angles.png").exists()
    assert json.loads((here / "out" / "fit_angles.json").read_text())["laws"]["dtheta"][
        "problem"
    ].startswith("too few")


@pytest.mark.slow
def test_a_folder_of_several_sets_is_fitted_set_by_set_or_as_selected(here, capsys) -> None:
    folder = here / "data"
    folder.mkdir()
    collection(folder / "one.csv", count=40)
    lines = (folder / "one.csv").read_text().replace("plywood", "pu").splitlines(keepends=True)
    (folder / "few.csv").write_text("".join(lines[:4]))
    (folder / "cut.json").write_text('{"object_pose": [[0')
    assert run(["fit", "data", "--harmonics", "1", "--json", "all.json"]) == 0
    shown = capsys.readouterr().out
    assert "could not be read: data/cut.json" in shown
    assert "too few pushes with a known end" in shown and "3 of 20" in shown
    report = json.loads((here / "all.json").read_text())
    assert [found["surface"] for found in report["sets"]] == ["plywood", "pu"]
    assert [file["path"] for file in report["unreadable"]] == ["data/cut.json"]
    assert {path.stem for path in (here / "out").glob("*.png")} == {"fit_plywood_rect1"}
    assert run(["fit", "data", "--harmonics", "1", "--select", "surface=pu", "--json", "-"]) == 0
    assert [found["pushes"] for found in json.loads(capsys.readouterr().out)["sets"]] == [3]


def test_what_is_too_small_or_unreadable_is_told_and_nothing_is_drawn(here, capsys) -> None:
    collection(here / "pushes.csv", count=9)
    assert run(["fit", "pushes.csv"]) == 0
    assert "nothing could be fitted" in capsys.readouterr().out and not (here / "out").exists()
    (here / "bad").mkdir()
    for number in range(13):
        (here / "bad" / f"{number:02}.json").write_text("{")
    assert run(["fit", "bad"]) == 1
    (told,) = capsys.readouterr().err.splitlines()
    assert "no push could be read: bad/00.json" in told
    assert told.count(".json:") == 10 and "and 3 more" in told


def test_why_nothing_could_be_fitted_is_told_of_the_largest_set(here, capsys) -> None:
    """Sixty pushes from one orientation are enough of them: it is another reason."""
    (here / "still.csv").write_text("theta0_deg\n" + "45\n" * 60)
    assert run(["fit", "still.csv"]) == 0
    said = capsys.readouterr().out
    assert "nothing could be fitted" in said and "enough pushes" not in said
    assert "still: 59 pushes" in said
    assert "No cycle map: θ0 never changed from one push to the next: either each reset" in said
