"""`cyclemap identify` from outside: its files, JSON, tables and words, and what it refuses."""

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.evidence.identification.stroke_block import surface_model
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters
from cyclemap.evidence.predicted_strokes import predicted_push_ends
from cyclemap.evidence.pushes.measured_strokes import MeasuredPush
from cyclemap.mechanics import EllipseFriction, Pose, Slider, load_material

LAW = EllipseFriction(0.28, 0.22, 0.02, -0.012, 0.6)
KEYS = (
    "name provenance misfit inferred friction worn converged level parameters plates floor_shape "
    "sessions session_spread priors held derived errors starts notes data"
)
HEADER = "surface,shape,i,s,x0,y0,th0,x1,y1,th1,tip_x0,tip_y0,tip_x1,tip_y1\n"


@cache
def push_table(count: int, surface: str = "slate") -> str:
    """Pushes of 40 mm at places all over side 0, as the mechanics on LAW have them, with 0.2 mm and
    0.3 degrees.
    """
    rng, slider = np.random.default_rng(0), Slider.mit("rect1")
    model = surface_model(SurfaceParameters.from_friction(LAW, pusher_friction=0.15), slider)
    lines = [HEADER]
    for number in range(count):
        start, x = Pose(0.3, 0.1, 2.4 * number), -0.03 + 0.06 * number / (count - 1)
        tip, goal = start.to_world(x, 0.05075), start.to_world(x + 0.005, 0.01)
        (end, *_), *_ = predicted_push_ends(model, [MeasuredPush(start, start, tip, goal)])
        seen = end + (2e-4, 2e-4, 5e-3) * rng.standard_normal(3)
        fields = (start.x, start.y, start.theta, *seen.tolist(), *tip, *goal)
        numbers = ",".join(f"{value:.9f}" for value in fields)
        lines.append(f"{surface},rect1,0,{number / count},{numbers}\n")
    return "".join(lines)


@pytest.fixture
def ends(here) -> Path:
    """A table of five pushes."""
    path = here / "ends.csv"
    path.write_text(push_table(5))
    return path


FOUR = "ellipticity_x,ellipticity_y,offset_x,offset_y"
IDENTIFY = "identify ends.csv --starts 1"


@pytest.mark.slow
def test_json_tells_the_friction_within_its_intervals_and_the_material_loads(
    ends, report_of
) -> None:
    ends.write_text(push_table(8))
    report = report_of(f"{IDENTIFY} --folds 2 --free {FOUR} --out results", silent=False)
    assert " ".join(report) == KEYS
    truth = SurfaceParameters.from_friction(LAW).values()
    told = {row["name"]: row for row in report["parameters"]}
    assert ",".join(told) == FOUR
    for name, row in told.items():
        width = row["upper"] - row["lower"]
        assert row["lower"] - 0.5 * width < truth[name] < row["upper"] + 0.5 * width
        assert width < 0.2
    direction = next(row for row in report["derived"] if row["name"] == "axis_direction")
    assert direction["unit"] == "deg"
    assert direction["lower"] < math.degrees(0.6) < direction["upper"]
    turn = next(row for row in report["errors"] if row["kind"] == "push turn")
    assert (turn["unit"], turn["rows"]) == ("deg", 8)
    assert 0.0 < turn["rms"] < turn["left_out_rms"] < 2.0
    written = sorted(path.name for path in Path("results").iterdir())
    name = "slate-identified"
    assert written == [f"identify_{name}.json", f"identify_{name}.png", f"{name}.toml"]
    material = load_material("results/slate-identified.toml")
    assert material.inferred
    assert material.found_with.pusher_friction == report["held"]["pusher_friction"] == 0.15
    assert material.friction.phi == pytest.approx(math.radians(report["friction"]["phi_deg"]))


@pytest.mark.slow
def test_people_get_a_headline_tables_and_what_to_do_next(ends, said) -> None:
    more = "--name 'my slate' --set pusher_mu=0.16 --format svg"
    shown = said(f"{IDENTIFY} --folds 0 --free {FOUR} {more}").out
    assert shown.startswith("my slate: friction ellipse with axes 1.")
    told = ("5 push ends", "Parameters", "95 % interval", "held", "axis ratio", "left out")
    for words in (*told, "note: ", "next: cyclemap portrait out/my_slate.toml\n"):
        assert words in shown
    assert Path("out/identify_my_slate.svg").read_bytes().startswith(b"<?xml")
    assert CollectionLoop.mit("out/my_slate.toml").pusher.friction == 0.16


@pytest.mark.slow
def test_fixed_and_started_values_are_taken(ends, report_of) -> None:
    held = "--free offset_x --fix plate_dome=0.1 --start plywood --folds 0"
    report = report_of(f"{IDENTIFY} {held}", silent=False)
    plywood = SurfaceParameters.from_friction(load_material("plywood").friction).values()
    assert report["held"]["plate_dome"] == 0.1
    assert report["held"]["ellipticity_x"] == pytest.approx(plywood["ellipticity_x"])
    assert all(row["left_out_rms"] is None for row in report["errors"])


BAD_USES = {
    "": "Missing argument",
    "absent.csv": "there is nothing there",
    "notes.txt": "notes.txt: a file of another kind (.txt)",
    "ends.csv --free offset_z": "unknown parameter 'offset_z': did you mean",
    "ends.csv --free friction_scale": "no block of data depends on friction_scale",
    "ends.csv --fix plate_dome": "--fix 'plate_dome' is not of the form name=number",
    "ends.csv --fix plate_dime=0.1": "did you mean 'plate_dome'?",
    "ends.csv --select shape=rect2": "5 left out: of rect1, not rect2",
    "ends.csv --select colour=red": "unknown selection 'colour'",
    "ends.csv --set noise_deg=1": "the noise is estimated from the data",
    "ends.csv --set footprint=grid:8": "exact footprint",
    "ends.csv --set rim_share=0.2": "shapes of floor and plate, not shares",
    "ends.csv --plate rect9": "unknown plate 'rect9'",
    "ends.csv --plate ends.toml": "ends.toml",
    "ends.csv --floor plywood --start abs": "leave --start out",
    "ends.csv --student 1": "--student",
    "ends.csv --folds 40 --free offset_x --starts 1": "folds must be from 2",
    "ends.csv more.csv": "several surfaces: felt, slate",
}


@pytest.mark.parametrize("words", BAD_USES)
def test_bad_use_is_refused_in_one_line(here, ends, refused, words) -> None:
    (here / "more.csv").write_text(push_table(5, "felt"))
    (here / "notes.txt").write_text("rod bent")
    refused(f"identify {words}", BAD_USES[words])


def test_no_answer_from_any_start_is_a_failure(here, ends, refused) -> None:
    """A rod that starts 20 mm deep inside the object has no quasi-static push."""
    header, *lines = ends.read_text().splitlines()
    cells = [line.split(",") for line in lines]
    bad = [",".join([*row[:10], row[4], row[5], "0.9", "0.9"]) for row in cells]
    ends.write_text("\n".join([header, *bad]) + "\n")
    refused("identify ends.csv --starts 2", "none of 2 starts has an answer", 1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("place", "made"), [("os.fsync", True), ("cyclemap.views.panels.layout.render", False)]
)
def test_an_interrupt_leaves_nothing_half_written(
    here, ends, said, monkeypatch, place, made
) -> None:
    """All files are made before the first is written."""

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(place, interrupted)
    said(f"{IDENTIFY} --free offset_x --folds 0", 130)
    assert (here / "out").exists() is made and not list(here.glob("out/*"))
