"""`cyclemap fit` from outside: its JSON, its pictures, its tables and words, and what it refuses."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

SET_KEYS = (
    "name source surface object acceleration_mm_s2 speed_mm_s side fraction angle_deg contacts "
    "pushes covered_deg statistics laws dtheta_histogram last_cycles cycle_map"
)


def worn_path(count: int) -> np.ndarray:
    rng, path = np.random.default_rng(0), [0.0]
    for n in range(count):
        turn = 0.26 + 0.25 * math.cos(path[-1]) + 1e-3 * n
        path.append(path[-1] + turn + 0.02 * rng.standard_normal())
    return np.array(path)


def collection(file: Path, count: int) -> None:
    """Pushes that turn by 1.2 + 0.1 cos 2θ rad and move by (40, -80) mm, over a path that wears."""
    rng, rows = np.random.default_rng(1), ["surface,shape,v_mm_s,i,s,t,rep,x0,y0,th0,x1,y1,th1"]
    for n, theta in enumerate(worn_path(count).tolist()):
        end = theta + 1.2 + 0.1 * math.cos(2 * theta) + 0.02 * rng.standard_normal()
        moved = complex(*((0.04, -0.08) + 0.001 * rng.standard_normal(2)))
        place = 0.35 - 0.03j + moved * np.exp(1j * theta)
        poses = (0.35, -0.03, theta % math.tau, place.real, place.imag, end % math.tau)
        numbers = ",".join(f"{value:.9f}" for value in poses)
        rows.append(f"plywood,rect1,20,0,0.7,0,{n},{numbers}")
    file.write_text("\n".join(rows) + "\n")


@pytest.mark.slow
def test_json_tells_what_was_read_and_fitted_and_nothing_else(here, said) -> None:
    collection(here / "pushes.csv", 120)
    shown = said("fit pushes.csv --out results --json -")
    assert "axes right-handed" in shown.err
    report = json.loads(shown.out)
    assert list(report) == ["pushes", "scans", "unreadable", "sets"]
    (found,) = report["sets"]
    assert set(found) == set(SET_KEYS.split())
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
def test_people_get_both_tables_whole_the_sentences_and_the_picture(here, said) -> None:
    collection(here / "pushes.csv", 60)
    shown = said("fit pushes.csv --format svg --no-wear --harmonics 2 --seed 3").out
    assert "…" not in shown
    tables = ("61 pushes read, in 1 set", "Δθ (°)", "Δy (mm)", "RMSE", "cv")
    law = "a law of θ0 with 2 harmonics leaves"
    for words in (*tables, "wear unknown", law, "plywood_rect1.svg"):
        assert words in shown
    assert (here / "out" / "fit_plywood_rect1.svg").read_bytes().startswith(b"<?xml")


@pytest.mark.slow
def test_theta0_alone_gives_a_cycle_map_and_no_tables(here, said, theta0_file) -> None:
    theta0_file(here / "angles.csv", worn_path(100))
    shown = said("fit angles.csv").out
    assert "100 pushes of which θ0 alone is known" in shown and "RMSE" not in shown
    assert "From push 25 on (the last three quarters)" in shown
    assert (here / "out" / "fit_angles.png").exists()
    laws = json.loads((here / "out" / "fit_angles.json").read_text())["laws"]
    assert laws["dtheta"]["problem"].startswith("too few")


@pytest.mark.slow
def test_a_folder_of_several_sets_is_fitted_set_by_set_or_as_selected(
    here, said, report_of
) -> None:
    folder = here / "data"
    folder.mkdir()
    collection(folder / "one.csv", 40)
    lines = (folder / "one.csv").read_text().replace("plywood", "pu").splitlines(keepends=True)
    (folder / "few.csv").write_text("".join(lines[:4]))
    (folder / "cut.json").write_text('{"object_pose": [[0')
    shown = said("fit data --harmonics 1 --json all.json").out
    too_few = "too few pushes with a known end"
    for words in ("could not be read: data/cut.json", too_few, "3 of 20"):
        assert words in shown
    report = json.loads((here / "all.json").read_text())
    assert [found["surface"] for found in report["sets"]] == ["plywood", "pu"]
    assert [file["path"] for file in report["unreadable"]] == ["data/cut.json"]
    assert {path.stem for path in (here / "out").glob("*.png")} == {"fit_plywood_rect1"}
    selected = report_of("fit data --harmonics 1 --select surface=pu", silent=False)
    assert [found["pushes"] for found in selected["sets"]] == [3]


def test_what_is_too_small_or_unreadable_is_told_and_nothing_is_drawn(here, said, refused) -> None:
    """Sixty pushes from one orientation are enough of them: it is another reason."""
    collection(here / "pushes.csv", 9)
    assert "nothing could be fitted" in said("fit pushes.csv").out
    (here / "still.csv").write_text("theta0_deg\n" + "45\n" * 60)
    shown = said("fit still.csv").out
    assert "nothing could be fitted" in shown and "enough pushes" not in shown
    assert "still: 59 pushes" in shown
    assert "No cycle map: θ0 never changed from one push to the next: either each reset" in shown
    assert not (here / "out").exists()
    (here / "bad").mkdir()
    for number in range(13):
        (here / "bad" / f"{number:02}.json").write_text("{")
    refused("fit bad", "no push could be read: bad/00.json", 1)
    told = said("fit bad", 1).err
    assert told.count(".json:") == 10 and "and 3 more" in told
