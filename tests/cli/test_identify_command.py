"""`cyclemap identify` from outside: its files, JSON, tables and words, and what it refuses."""

import json
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from cyclemap.cli.main import run
from cyclemap.collection.loop import CollectionLoop
from cyclemap.evidence.identification.stroke_block import surface_model
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters
from cyclemap.evidence.predicted_strokes import predicted_push_ends
from cyclemap.evidence.pushes.measured_strokes import MeasuredPush
from cyclemap.mechanics import EllipseFriction, Pose, Slider, load_material

LAW = EllipseFriction(0.28, 0.22, 0.02, -0.012, 0.6)
KEYS = [
    "name",
    "provenance",
    "misfit",
    "inferred",
    "friction",
    "worn",
    "converged",
    "level",
    "parameters",
]
KEYS += ["plates", "floor_shape", "sessions", "session_spread", "priors", "held"]
KEYS += ["derived", "errors", "starts", "notes", "data"]
HEADER = "surface,shape,i,s,x0,y0,th0,x1,y1,th1,tip_x0,tip_y0,tip_x1,tip_y1\n"
RADIUS = 0.00475


def push_file(path: Path, count: int = 8, surface: str = "slate") -> Path:
    path.write_text(push_table(count, surface))
    return path


@cache
def push_table(count: int, surface: str) -> str:
    """Pushes of 40 mm at places all over side 0, as the mechanics on LAW have them, with 0.2 mm and
    0.3 degrees.
    """
    rng, slider = np.random.default_rng(0), Slider.mit("rect1")
    model = surface_model(SurfaceParameters.from_friction(LAW, pusher_friction=0.15), slider)
    lines = [HEADER]
    for number in range(count):
        start, x = Pose(0.3, 0.1, 2.4 * number), -0.03 + 0.06 * number / (count - 1)
        tip, goal = start.to_world(x, 0.045 + RADIUS + 1e-3), start.to_world(x + 0.005, 0.01)
        ((x, y, theta),), *_ = predicted_push_ends(model, [MeasuredPush(start, start, tip, goal)])
        end = Pose(float(x), float(y), float(theta))
        place = np.array([end.x, end.y]) + 2e-4 * rng.standard_normal(2)
        poses = (
            start.x,
            start.y,
            start.theta,
            *place.tolist(),
            end.theta + 5e-3 * rng.standard_normal(),
        )
        lines.append(
            f"{surface},rect1,0,{number / count},{','.join(f'{v:.9f}' for v in (*poses, *tip, *goal))}\n"
        )
    return "".join(lines)


QUICK = ["--starts", "1", "--folds", "2", "--free", "ellipticity_x,ellipticity_y,offset_x,offset_y"]


@pytest.mark.slow
def test_json_tells_the_friction_within_its_intervals_and_the_material_loads(here, capsys) -> None:
    push_file(here / "ends.csv")
    assert run(["identify", "ends.csv", *QUICK, "--json", "-", "--out", "results"]) == 0
    shown = capsys.readouterr()
    assert all(line.startswith(("reading: ", "identifying: ")) for line in shown.err.splitlines())
    report = json.loads(shown.out, parse_constant=lambda name: pytest.fail(f"JSON holds {name}"))
    assert list(report) == KEYS
    truth = SurfaceParameters.from_friction(LAW).values()
    told = {one["name"]: one for one in report["parameters"]}
    assert list(told) == ["ellipticity_x", "ellipticity_y", "offset_x", "offset_y"]
    for name, one in told.items():
        slack = one["upper"] - one["lower"]
        assert one["lower"] - 0.5 * slack < truth[name] < one["upper"] + 0.5 * slack and slack < 0.2
    direction = next(one for one in report["derived"] if one["name"] == "axis_direction")
    assert (
        direction["unit"] == "deg" and direction["lower"] < math.degrees(0.6) < direction["upper"]
    )
    turn = next(one for one in report["errors"] if one["kind"] == "push turn")
    assert (turn["unit"], turn["rows"]) == ("deg", 8) and 0.0 < turn["rms"] < turn[
        "left_out_rms"
    ] < 2.0
    names = [
        "identify_slate-identified.json",
        "identify_slate-identified.png",
        "slate-identified.toml",
    ]
    assert sorted(path.name for path in (here / "results").iterdir()) == names
    material = load_material(here / "results" / "slate-identified.toml")
    assert (
        material.inferred
        and material.found_with.pusher_friction == report["held"]["pusher_friction"] == 0.15
    )
    assert material.friction.phi == pytest.approx(math.radians(report["friction"]["phi_deg"]))


@pytest.mark.slow
def test_people_get_a_headline_tables_and_what_to_do_next(here, capsys) -> None:
    push_file(here / "ends.csv", 6)
    arguments = [
        *QUICK,
        "--folds",
        "0",
        "--name",
        "my slate",
        "--set",
        "pusher_mu=0.16",
        "--format",
        "svg",
    ]
    assert run(["identify", "ends.csv", *arguments]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("my slate: friction ellipse with axes 1.")
    for words in (
        "6 push ends",
        "Parameters",
        "95 % interval",
        "held",
        "axis ratio",
        "left out",
        "note: ",
    ):
        assert words in shown
    assert "next: cyclemap portrait out/my_slate.toml\n" in shown
    assert (here / "out" / "identify_my_slate.svg").read_bytes().startswith(b"<?xml")
    assert CollectionLoop.mit("out/my_slate.toml").pusher.friction == 0.16


@pytest.mark.slow
def test_fixed_and_started_values_are_taken(here, capsys) -> None:
    push_file(here / "ends.csv", 5)
    arguments = [
        "--free",
        "offset_x",
        "--fix",
        "plate_dome=0.1",
        "--start",
        "plywood",
        "--folds",
        "0",
        "--starts",
        "1",
    ]
    assert run(["identify", "ends.csv", *arguments, "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out)
    plywood = SurfaceParameters.from_friction(load_material("plywood").friction).values()
    assert report["held"]["plate_dome"] == 0.1
    assert report["held"]["ellipticity_x"] == pytest.approx(plywood["ellipticity_x"])
    assert all(one["left_out_rms"] is None for one in report["errors"])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["absent.csv"], "there is nothing there"),
        (["notes.txt"], "notes.txt: a file of another kind (.txt)"),
        (["ends.csv", "--free", "offset_z"], "unknown parameter 'offset_z': did you mean"),
        (["ends.csv", "--free", "friction_scale"], "no block of data depends on friction_scale"),
        (["ends.csv", "--fix", "plate_dome"], "--fix 'plate_dome' is not of the form name=number"),
        (["ends.csv", "--fix", "plate_dime=0.1"], "did you mean 'plate_dome'?"),
        (["ends.csv", "--select", "shape=rect2"], "5 left out: of rect1, not rect2"),
        (["ends.csv", "--select", "colour=red"], "unknown selection 'colour'"),
        (["ends.csv", "--set", "noise_deg=1"], "the noise is estimated from the data"),
        (["ends.csv", "--set", "footprint=grid:8"], "exact footprint"),
        (["ends.csv", "--set", "rim_share=0.2"], "shapes of floor and plate, not shares"),
        (["ends.csv", "--plate", "rect9"], "unknown plate 'rect9'"),
        (["ends.csv", "--plate", "ends.toml"], "ends.toml"),
        (["ends.csv", "--floor", "plywood", "--start", "abs"], "leave --start out"),
        (["ends.csv", "--student", "1"], "--student"),
        (
            ["ends.csv", "--folds", "40", "--free", "offset_x", "--starts", "1"],
            "folds must be from 2",
        ),
        (["ends.csv", "more.csv"], "several surfaces: felt, slate"),
        ([], "Missing argument"),
    ],
)
def test_bad_use_is_refused_in_one_line(here, refused, arguments, words) -> None:
    push_file(here / "ends.csv", 5)
    push_file(here / "more.csv", 5, "felt")
    (here / "notes.txt").write_text("rod bent")
    refused(["identify", *arguments], words)


def test_no_answer_from_any_start_is_a_failure(here, refused) -> None:
    """A rod that starts 20 mm deep inside the object has no quasi-static push."""
    lines = (push_file(here / "ends.csv", 5)).read_text().splitlines()
    cells = [line.split(",") for line in lines[1:]]
    bad = [",".join([*row[:10], row[4], row[5], "0.9", "0.9"]) for row in cells]
    (here / "deep.csv").write_text("\n".join([lines[0], *bad]) + "\n")
    refused(["identify", "deep.csv", "--starts", "2"], "none of 2 starts has an answer", 1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("place", "made"), [("os.fsync", True), ("cyclemap.views.panels.layout.render", False)]
)
def test_an_interrupt_leaves_nothing_half_written(here, monkeypatch, place, made) -> None:
    """All files are made before the first is written."""
    push_file(here / "ends.csv", 5)

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(place, interrupted)
    assert (
        run(["identify", "ends.csv", "--free", "offset_x", "--folds", "0", "--starts", "1"]) == 130
    )
    assert (here / "out").exists() is made and not list(here.glob("out/*"))
