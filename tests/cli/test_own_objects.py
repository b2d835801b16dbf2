"""From one's own object to a judgement: what each command writes the next one reads, nothing edited
by hand.
"""

import io
import json
import math
import sys
from itertools import pairwise

import numpy as np
import pytest

from cyclemap.cli.main import run
from cyclemap.protocol import loop_from_file, loop_from_settings, read_protocol


def report(capsys, *arguments: str) -> dict:
    """The report of a command that may say something on stderr."""
    capsys.readouterr()
    assert run([*arguments, "--json", "-"]) == 0, capsys.readouterr().err
    return json.loads(capsys.readouterr().out)


@pytest.fixture(scope="module")
def tee(tmp_path_factory):
    """The folder of a T-shaped block from its file to an identified material, by one command each;
    and the reports.
    """
    pytest.importorskip("shapely")
    place, reports = tmp_path_factory.mktemp("tee"), {}
    frame = 'width="80mm" height="80mm" viewBox="0 0 80 80"'
    path = '<path d="M0 60H30V0H50V60H80V80H0Z"/>'
    (place / "tee.svg").write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {frame}>{path}</svg>')

    def call(name: str, *arguments: str) -> dict:
        told = place / f"{name}.json"
        assert run([name, *arguments, "--json", str(told), "--out", str(place / "out")]) == 0
        reports[name] = json.loads(told.read_text())
        return reports[name]

    own, data, found = (
        str(place / name) for name in ("tee.toml", "data", "out/felt-identified.toml")
    )
    surface = ["--surface", "felt", "--set", "mu_a=0.4", "--set", "mu_b=0.3"]
    assert run(["init", own, "--outline", str(place / "tee.svg"), *surface]) == 0
    errors = ["--pose-noise-mm", "0.3", "--pose-noise-deg", "0.3"]
    assert run(["simulate", own, "--cycles", "40", "--seed", "1", *errors, "--out", data]) == 0
    call("check", own)
    call("portrait", own, "--cycles", "200")
    call("fit", data)
    call("identify", data, "--starts", "1", "--folds", "0")
    reports["compare the truth"] = call("compare", own, "--data", data, "--runs", "19")
    call("compare", found, "--data", data, "--runs", "19")
    call("replay", found, "--data", data)
    few = ["--axes-percent", "5", "--offsets-percent", "20", "--pushes", "100", "--cycles", "20"]
    call("reset", own, "--keep-push", *few)
    call("watch", data)
    return place, reports


def test_a_tee_is_what_its_file_says(tee) -> None:
    """80 by 80 mm in eight sides, its centroid where two rectangles put it; the data's folder tells
    the same.
    """
    place, reports = tee
    assert reports["check"]["wrong"] == [] and reports["check"]["doubts"] == []
    slider = loop_from_file(place / "tee.toml").slider
    low, high = np.min(slider.outline.vertices, axis=0), np.max(slider.outline.vertices, axis=0)
    assert len(slider.outline.vertices) == 8 and high - low == pytest.approx([0.08, 0.08], abs=1e-4)
    # From the stem's end: bar of 80 x 20 mm at 70 mm, stem of 20 x 60 mm at 30 mm.
    along = (1600.0 * 70.0 + 1200.0 * 30.0) / 2800.0
    ends = sorted(np.abs(np.concatenate([low, high])))
    assert 1e3 * ends[0] == pytest.approx(80.0 - along, abs=0.1) and 1e3 * ends[
        -1
    ] == pytest.approx(along, abs=0.1)
    assert loop_from_file(place / "data" / "collection.toml").slider == slider
    assert (place / "tee.png").stat().st_size > 10_000


def test_a_tees_friction_lies_in_the_intervals_identified_from_its_pushes(tee) -> None:
    """Axes 0.4 : 0.3 along the frame, centred: ratio, direction and offset, each in a narrow
    interval.
    """
    found = {one["name"]: one for one in tee[1]["identify"]["derived"]}
    truths = {
        "axis_ratio": (0.4 / 0.3, 0.03),
        "axis_direction": (0.0, 2.0),
        "offset_size": (0.0, 0.02),
    }
    for name, (truth, narrow) in truths.items():
        assert (
            found[name]["lower"] <= truth <= found[name]["upper"] <= found[name]["lower"] + narrow
        )


def test_a_tees_data_agree_with_what_made_them_and_with_what_is_identified_of_them(tee) -> None:
    """Every verdict on the truth; of the identified one the map, whose replayed pushes end within
    the noise's reach.
    """
    reports = tee[1]
    assert len(reports["compare the truth"]["verdicts"]) >= 8
    assert not any(
        verdict["agrees"] is False for verdict in reports["compare the truth"]["verdicts"]
    )
    verdicts = {
        verdict["question"]: verdict["agrees"] for verdict in reports["compare"]["verdicts"]
    }
    assert verdicts["cycle map"] and verdicts["histogram of directions"]
    (row,) = reports["replay"]["by_object"]
    assert row["count"] == 40
    assert row["mean_error_mm"] < 0.1 * row["isotropic_mean_error_mm"]
    assert row["mean_turn_error_deg"] < 0.2 * row["isotropic_mean_turn_error_deg"]


def test_a_tees_lock_in_is_watched_and_a_reset_is_found(tee) -> None:
    place, reports = tee
    assert reports["watch"]["pushes"] == 40 and reports["watch"]["alarm"] is None
    rows, own = reports["reset"]["rows"], loop_from_file(place / "tee.toml").push
    assert {(action["side"], action["fraction"]) for action in rows[0]["actions"]} == {
        (own.side, own.fraction)
    }
    assert rows[0]["tv"] < rows[-1]["tv"]
    assert len(read_protocol(place / "out" / "reset_tee_on_felt.toml")[1].actions) == len(
        rows[0]["actions"]
    )


@pytest.mark.slow
def test_data_whose_object_nobody_tells_are_refused_with_what_to_do(here, refused) -> None:
    assert run(["init", "box.toml", "--rectangle-mm", "120,60"]) == 0
    assert run(["simulate", "box.toml", "--cycles", "4", "--out", "data"]) == 0
    (here / "data" / "collection.toml").unlink()
    refused(["compare", "isotropic", "--data", "data"], "put it with the data as collection.toml")
    refused(["replay", "plywood", "--data", "data"], "object 'box' has no outline", 1)


def test_an_own_outline_by_set_alone_is_told_what_it_takes_over_from_mit(here, capsys) -> None:
    outline = "vertices_mm=[[60,30],[-60,30],[-60,-30],[60,-30]]"
    told = report(capsys, "cycle", "plywood", "--set", outline, "--theta0-deg", "0")
    assert len(told["warnings"]) == 1 and "the ring, the mass" in told["warnings"][0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["box.txt", "--rectangle-mm", "1,2"], "must end in .toml"),
        (["box.toml"], "say what the object is"),
        (["box.toml", "--rectangle-mm", "120"], "give two lengths in mm"),
        (["box.toml", "--rectangle-mm", "120,-60"], "give two lengths in mm"),
        (["box.toml", "--rectangle-mm", "120,60", "--shape", "hex"], "both say the outline"),
        (["box.toml", "--shape", "hexx"], "did you mean 'hex'"),
        (["box.toml", "--outline", "gone.svg"], "there is no such file"),
        (["box.toml", "--rectangle-mm", "120,60", "--set", "hitch_x_mm=5000"], "same unit"),
        (["box.toml", "--rectangle-mm", "12,6", "--unit", "inch"], "are about --outline FILE"),
        (["box.toml", "--shape", "hex", "--name", "mine"], "hex keeps its name"),
        (["box.toml", "--outline", "a.svg", "--tolerance-mm", "nan"], "--tolerance-mm"),
    ],
)
def test_what_init_cannot_use_is_one_clear_line(
    here, refused, monkeypatch, arguments, message
) -> None:
    monkeypatch.setattr(sys.stdin, "isatty", lambda: False, raising=False)
    refused(["init", *arguments], message)


def test_init_writes_over_no_picture(here, refused) -> None:
    (here / "box.png").write_text("precious")
    refused(["init", "box.toml", "--rectangle-mm", "120,60"], "box.png is there already")
    assert (here / "box.png").read_text() == "precious"


@pytest.mark.parametrize(
    ("options", "message", "code"),
    [
        (["--command", "'"], "No closing quotation", 2),
        (["--command", " "], "--command is empty", 2),
        (["--python", "pushes:number"], "number is no function", 2),
        (["--python", "broken:push"], "SyntaxError", 2),
        (["--python", "pushes:fails"], "theta = 0 rad: ValueError: no robot", 1),
    ],
)
def test_what_a_probe_cannot_call_is_one_clear_line(
    here, refused, monkeypatch, options, message, code
) -> None:
    """What is wrong in a function, or a command, of people's own ends in a line, not in a
    traceback.
    """
    (here / "pushes.py").write_text(
        "number = 3\n\n\ndef fails(theta):\n    raise ValueError('no robot')\n"
    )
    (here / "broken.py").write_text("def push(\n")
    monkeypatch.syspath_prepend(str(here))
    monkeypatch.delitem(sys.modules, "pushes", raising=False)
    refused(["probe", "plywood", *options], message, code)


@pytest.mark.slow
def test_init_asks_back_and_writes_over_nothing(here, capsys, monkeypatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    monkeypatch.setattr(sys, "stdin", Terminal("ellipse\n100,60\npuck\nglass\n"))
    assert run(["init", "puck.toml"]) == 0
    loop = loop_from_file("puck.toml")
    assert (loop.slider.name, loop.material.name) == ("puck", "glass")
    assert (loop.slider.outline.semi_x, loop.slider.outline.semi_y) == pytest.approx((0.05, 0.03))
    assert run(["init", "puck.toml", "--shape", "hex"]) == 2
    assert "is there already" in capsys.readouterr().err
    assert run(["init", "puck.toml", "--shape", "hex", "--force"]) == 0


def test_check_of_a_file_with_which_nothing_runs_ends_with_2_and_says_why(here, capsys) -> None:
    assert run(["init", "box.toml", "--rectangle-mm", "120,60"]) == 0
    path = here / "box.toml"
    path.write_text(path.read_text().replace("side = 0", "side = 7"))
    capsys.readouterr()
    assert run(["check", "box.toml"]) == 2
    assert "side" in capsys.readouterr().err
    assert (here / "out" / "check_box.png").is_file()


@pytest.mark.slow
def test_probe_of_a_function_a_program_and_data(here, capsys, refused, monkeypatch) -> None:
    (here / "alike.py").write_text("def push(theta):\n    return 0.04, -0.07, 1.3\n")
    monkeypatch.syspath_prepend(str(here))
    assert report(capsys, "probe", "--python", "alike:push", "--count", "24")["found"] is False
    assert (
        run(
            [
                "init",
                "box.toml",
                "--rectangle-mm",
                "120,60",
                "--set",
                "mu_a=0.35",
                "--set",
                "mu_b=0.3",
            ]
        )
        == 0
    )
    assert (
        run(["simulate", "box.toml", "--cycles", "40", "--noise-deg", "40", "--out", "data"]) == 0
    )
    found = report(capsys, "probe", "box.toml", "--data", "data")
    assert found["found"] and found["axis_ratio"]["value"] == pytest.approx(0.35 / 0.3, abs=2e-3)
    assert math.isclose(found["offset"]["value"], 0.0, abs_tol=2e-3)
    (here / "two.csv").write_text(
        "x0,y0,theta0,x1,y1,theta1,object\n"
        + "".join(f"0,0,{n},0.04,0.03,{n + 1},{'ab'[n % 2]}\n" for n in range(8))
    )
    refused(["probe", "box.toml", "--data", "two.csv"], "pushes of several objects, a, b: give")
    refused(["probe", "box.toml"], "say what is probed")
    refused(["probe", "--python", "gone:push"], "gone")


@pytest.mark.slow
def test_own_tables_are_read_by_fit_and_audit_and_told_on_stderr(here, capsys) -> None:
    rows = [f"{n};{(n * 27.3) % 360.0:.2f}".replace(".", ",") for n in range(30)]
    (here / "log.csv").write_text("\n".join(["Nr;Winkel vorher [°]", *rows]) + "\n")
    assert run(["fit", "log.csv"]) == 0
    shown = capsys.readouterr()
    assert "29 pairs" in shown.out and "read as theta0 in deg, by its name" in shown.err
    assert report(capsys, "audit", "log.csv")["pushes"] == 30
    (here / "bad.csv").write_text("speed;force\n1;2\n3;4\n")
    assert run(["fit", "bad.csv"]) == 2
    assert "say which, --columns theta0=NAME; it has speed, force" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["portrait", "staircase"])
def test_a_prediction_takes_a_log_of_ones_own_as_it_takes_its_pairs_in_degrees(
    command, here, capsys
) -> None:
    random, theta = np.random.default_rng(0), [0.2]
    for _ in range(60):
        theta.append(theta[-1] + 0.3 + 0.2 * math.sin(theta[-1]) + 0.02 * random.normal())
    steps = [(a % math.tau, b % math.tau) for a, b in pairwise(np.round(theta, 6).tolist())]
    (here / "log.csv").write_text(
        "run;yaw;yaw_after\n" + "".join(f"{n};{a};{b}\n" for n, (a, b) in enumerate(steps))
    )
    rows = "".join(f"{math.degrees(a)},{math.degrees(b)}\n" for a, b in steps)
    (here / "pairs.csv").write_text("theta0_deg,theta_next_deg\n" + rows)
    data = (["log.csv", "--columns", "theta_next=yaw_after"], ["pairs.csv"])
    own, ours = (report(capsys, command, "isotropic", "--data", *one)["data"] for one in data)
    assert own == ours != {}


def test_what_the_folder_of_a_log_says_of_the_push_holds_for_identify_and_portrait(
    here, capsys
) -> None:
    """Orientations and poses alone tell no rod: collection.toml beside the log does, as a protocol
    would.
    """
    (here / "data").mkdir()
    (here / "data" / "collection.toml").write_text("push_mm = 60\nfraction = 0.6\n")
    loop, rows = loop_from_settings({"push_mm": 60, "fraction": 0.6, "mu_a": 0.3, "mu_b": 0.2}), []
    for theta in np.linspace(0.1, 6.0, 12):
        end = loop.model.push(loop.start_pose(theta), loop.push).end
        rows.append(
            f"{loop.start_pose(theta).x},{loop.start_pose(theta).y},{theta},{end.x},{end.y},{end.theta}\n"
        )
    (here / "data" / "log.csv").write_text(
        "start_x,start_y,start_yaw,end_x,end_y,end_yaw\n" + "".join(rows)
    )
    few = ["--units", "rad,m", "--starts", "1", "--folds", "0"]
    ratio = next(
        one
        for one in report(capsys, "identify", "data/log.csv", *few)["derived"]
        if one["name"] == "axis_ratio"
    )
    assert ratio["value"] == pytest.approx(1.5, abs=1e-3)
    (here / "data" / "yaw.csv").write_text(
        "yaw\n" + "".join(f"{0.3 * n + 0.1 * n % 0.07}\n" for n in range(12))
    )
    beside = report(capsys, "portrait", "isotropic", "--data", "data/yaw.csv", "--units", "rad")
    assert (
        beside["map"]
        == report(capsys, "portrait", "isotropic", "--protocol", "data/collection.toml")["map"]
    )


def test_a_report_judges_poses_that_tell_no_cycle_and_a_portrait_says_that_they_tell_none(
    here, refused
) -> None:
    turned = ((a, (0.04 - 0.07j) * np.exp(1j * a)) for a in np.linspace(0.0, 6.0, 30))
    poses = "".join(f"0,0,{a},{moved.real},{moved.imag},{a + 1.3},150\n" for a, moved in turned)
    (here / "ends.csv").write_text("x0,y0,theta0,x1,y1,theta1,push_mm\n" + poses)
    assert run(["report", "isotropic", "--data", "ends.csv"]) == 0
    assert "ends.csv" in (here / "out" / "report_isotropic.html").read_text()
    refused(
        ["portrait", "isotropic", "--data", "ends.csv"],
        "no push tells the orientation before the next one",
    )
