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
from cyclemap.protocol import loop_from_file, loop_from_settings

BOX = "init box.toml --rectangle-mm 120,60"
FEW = "--starts 1 --folds 0"


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
    own, data, found = (place / name for name in ("tee.toml", "data", "out/felt-identified.toml"))

    def call(name: str, line: str) -> None:
        told = place / f"{name}.json"
        assert run(f"{line} --json {told} --out {place}/out".split()) == 0
        reports[name] = json.loads(told.read_text())

    surface = "--surface felt --set mu_a=0.4 --set mu_b=0.3"
    assert run(f"init {own} --outline {place}/tee.svg {surface}".split()) == 0
    noise = "--pose-noise-mm 0.3 --pose-noise-deg 0.3"
    assert run(f"simulate {own} --cycles 40 --seed 1 {noise} --out {data}".split()) == 0
    call("check", f"check {own}")
    call("identify", f"identify {data} {FEW}")
    call("truth", f"compare {own} --data {data} --runs 19")
    call("compare", f"compare {found} --data {data} --runs 19")
    call("replay", f"replay {found} --data {data}")
    call("watch", f"watch {data}")
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
    shortest, *_, longest = sorted(1e3 * np.abs([*low, *high]))
    assert (shortest, longest) == pytest.approx((80.0 - along, along), abs=0.1)
    assert loop_from_file(place / "data" / "collection.toml").slider == slider
    assert (place / "tee.png").stat().st_size > 10_000


def test_a_tees_friction_lies_in_the_intervals_identified_from_its_pushes(tee) -> None:
    """Axes 0.4 : 0.3 along the frame, centred: ratio, direction and offset, each in a narrow
    interval.
    """
    found = {row["name"]: row for row in tee[1]["identify"]["derived"]}
    for name, truth, narrow in (
        ("axis_ratio", 0.4 / 0.3, 0.03),
        ("axis_direction", 0.0, 2.0),
        ("offset_size", 0.0, 0.02),
    ):
        low, high = found[name]["lower"], found[name]["upper"]
        assert low <= truth <= high <= low + narrow


def test_a_tees_data_agree_with_what_made_them_and_with_what_is_identified_of_them(tee) -> None:
    """Every verdict on the truth; of the identified one the map, whose replayed pushes end within
    the noise's reach.
    """
    reports = tee[1]
    assert reports["watch"]["pushes"] == 40 and reports["watch"]["alarm"] is None
    truth, verdicts = (
        {verdict["question"]: verdict["agrees"] for verdict in reports[name]["verdicts"]}
        for name in ("truth", "compare")
    )
    assert len(truth) >= 8 and False not in truth.values()
    assert verdicts["cycle map"] and verdicts["histogram of directions"]
    (row,) = reports["replay"]["by_object"]
    assert row["count"] == 40
    assert row["mean_error_mm"] < 0.1 * row["isotropic_mean_error_mm"]
    assert row["mean_turn_error_deg"] < 0.2 * row["isotropic_mean_turn_error_deg"]


@pytest.mark.slow
def test_data_whose_object_nobody_tells_are_refused_with_what_to_do(here, said, refused) -> None:
    said(BOX)
    said("simulate box.toml --cycles 4 --out data")
    (here / "data" / "collection.toml").unlink()
    refused("compare isotropic --data data", "put it with the data as collection.toml")
    refused("replay plywood --data data", "object 'box' has no outline", 1)


def test_an_own_outline_by_set_alone_is_told_what_it_takes_over_from_mit(report_of) -> None:
    outline = "vertices_mm=[[60,30],[-60,30],[-60,-30],[60,-30]]"
    report = report_of(f"cycle plywood --set {outline} --theta0-deg 0", silent=False)
    assert len(report["warnings"]) == 1 and "the ring, the mass" in report["warnings"][0]


UNFIT_FOR_INIT = {
    "box.txt --rectangle-mm 1,2": "must end in .toml",
    "box.toml": "say what the object is",
    "box.toml --rectangle-mm 120": "give two lengths in mm",
    "box.toml --rectangle-mm 120,-60": "give two lengths in mm",
    "box.toml --rectangle-mm 120,60 --shape hex": "both say the outline",
    "box.toml --shape hexx": "did you mean 'hex'",
    "box.toml --outline gone.svg": "there is no such file",
    "box.toml --rectangle-mm 120,60 --set hitch_x_mm=5000": "same unit",
    "box.toml --rectangle-mm 12,6 --unit inch": "are about --outline FILE",
    "box.toml --shape hex --name mine": "hex keeps its name",
    "box.toml --outline a.svg --tolerance-mm nan": "--tolerance-mm",
    "drawn.toml --rectangle-mm 120,60": "drawn.png is there already",
}


@pytest.mark.parametrize("words", UNFIT_FOR_INIT)
def test_what_init_cannot_use_is_one_clear_line(here, refused, monkeypatch, words) -> None:
    monkeypatch.setattr(sys.stdin, "isatty", lambda: False, raising=False)
    (here / "drawn.png").write_text("precious")
    refused(f"init {words}", UNFIT_FOR_INIT[words])
    assert (here / "drawn.png").read_text() == "precious"


@pytest.mark.parametrize(
    ("options", "message", "code"),
    [
        ('--command "\'"', "No closing quotation", 2),
        ("--command ' '", "--command is empty", 2),
        ("--python gone:push", "gone", 2),
        ("--python pushes:number", "number is no function", 2),
        ("--python broken:push", "SyntaxError", 2),
        ("--python pushes:fails", "theta = 0 rad: ValueError: no robot", 1),
        ("", "say what is probed", 2),
        ("--data two.csv", "pushes of several objects, a, b: give", 2),
    ],
)
def test_what_a_probe_cannot_call_is_one_clear_line(
    here, refused, monkeypatch, options, message, code
) -> None:
    """What is wrong in a function, or a command, of people's own ends in a line, not in a
    traceback.
    """
    fails = "def fails(theta):\n    raise ValueError('no robot')\n"
    (here / "pushes.py").write_text(f"number = 3\n\n\n{fails}")
    (here / "broken.py").write_text("def push(\n")
    rows = "".join(f"0,0,{n},0.04,0.03,{n + 1},{'ab'[n % 2]}\n" for n in range(8))
    (here / "two.csv").write_text(f"x0,y0,theta0,x1,y1,theta1,object\n{rows}")
    monkeypatch.syspath_prepend(str(here))
    monkeypatch.delitem(sys.modules, "pushes", raising=False)
    refused(f"probe plywood {options}", message, code)


@pytest.mark.slow
def test_init_asks_back_and_writes_over_nothing(here, said, monkeypatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    monkeypatch.setattr(sys, "stdin", Terminal("ellipse\n100,60\npuck\nglass\n"))
    said("init puck.toml")
    loop = loop_from_file("puck.toml")
    assert (loop.slider.name, loop.material.name) == ("puck", "glass")
    assert (loop.slider.outline.semi_x, loop.slider.outline.semi_y) == pytest.approx((0.05, 0.03))
    assert "is there already" in said("init puck.toml --shape hex", 2).err
    said("init puck.toml --shape hex --force")


def test_check_of_a_file_with_which_nothing_runs_ends_with_2_and_says_why(here, said) -> None:
    said(BOX)
    path = here / "box.toml"
    path.write_text(path.read_text().replace("side = 0", "side = 7"))
    assert "side" in said("check box.toml", 2).err
    assert (here / "out" / "check_box.png").is_file()


@pytest.mark.slow
def test_probe_of_a_function_a_program_and_data(here, said, report_of, monkeypatch) -> None:
    (here / "alike.py").write_text("def push(theta):\n    return 0.04, -0.07, 1.3\n")
    monkeypatch.syspath_prepend(str(here))
    assert report_of("probe --python alike:push --count 24")["found"] is False
    said(f"{BOX} --set mu_a=0.35 --set mu_b=0.3")
    said("simulate box.toml --cycles 40 --noise-deg 40 --out data")
    found = report_of("probe box.toml --data data", silent=False)
    assert found["found"] and found["axis_ratio"]["value"] == pytest.approx(0.35 / 0.3, abs=2e-3)
    assert math.isclose(found["offset"]["value"], 0.0, abs_tol=2e-3)


@pytest.mark.slow
def test_own_tables_are_read_by_fit_and_audit_and_told_on_stderr(here, said, report_of) -> None:
    rows = [f"{n};{(n * 27.3) % 360.0:.2f}".replace(".", ",") for n in range(30)]
    (here / "log.csv").write_text("\n".join(["Nr;Winkel vorher [°]", *rows]) + "\n")
    shown = said("fit log.csv")
    assert "29 pairs" in shown.out and "read as theta0 in deg, by its name" in shown.err
    assert report_of("audit log.csv", silent=False)["pushes"] == 30
    (here / "bad.csv").write_text("speed;force\n1;2\n3;4\n")
    told = "say which, --columns theta0=NAME; it has speed, force"
    assert told in said("fit bad.csv", 2).err


def test_a_prediction_takes_a_log_of_ones_own_as_it_takes_its_pairs_in_degrees(
    here, report_of
) -> None:
    random, theta = np.random.default_rng(0), [0.2]
    for _ in range(60):
        theta.append(theta[-1] + 0.3 + 0.2 * math.sin(theta[-1]) + 0.02 * random.normal())
    steps = [(a % math.tau, b % math.tau) for a, b in pairwise(np.round(theta, 6).tolist())]
    rows = "".join(f"{n};{a};{b}\n" for n, (a, b) in enumerate(steps))
    (here / "log.csv").write_text(f"run;yaw;yaw_after\n{rows}")
    rows = "".join(f"{math.degrees(a)},{math.degrees(b)}\n" for a, b in steps)
    (here / "pairs.csv").write_text(f"theta0_deg,theta_next_deg\n{rows}")
    own, ours = (
        report_of(f"portrait isotropic --data {data}", silent=False)["data"]
        for data in ("log.csv --columns theta_next=yaw_after", "pairs.csv")
    )
    assert own == ours != {}


def test_what_the_folder_of_a_log_says_of_the_push_holds_for_identify_and_portrait(
    here, report_of
) -> None:
    """Orientations and poses alone tell no rod: collection.toml beside the log does, as a protocol
    would.
    """
    (here / "data").mkdir()
    (here / "data" / "collection.toml").write_text("push_mm = 60\nfraction = 0.6\n")
    loop = loop_from_settings({"push_mm": 60, "fraction": 0.6, "mu_a": 0.3, "mu_b": 0.2})
    rows = ["start_x,start_y,start_yaw,end_x,end_y,end_yaw"]
    for theta in np.linspace(0.1, 6.0, 12).tolist():
        start = loop.start_pose(theta)
        end = loop.model.push(start, loop.push).end
        rows.append(f"{start.x},{start.y},{theta},{end.x},{end.y},{end.theta}")
    (here / "data" / "log.csv").write_text("\n".join(rows) + "\n")
    free = "--free ellipticity_x,ellipticity_y"
    report = report_of(f"identify data/log.csv --units rad,m {FEW} {free}", silent=False)
    ratio = next(row["value"] for row in report["derived"] if row["name"] == "axis_ratio")
    assert ratio == pytest.approx(1.5, abs=0.02)
    angles = "".join(f"{0.3 * n + 0.1 * n % 0.07}\n" for n in range(12))
    (here / "data" / "yaw.csv").write_text(f"yaw\n{angles}")
    beside, protocol = (
        report_of(f"portrait isotropic {told}", silent=False)["map"]
        for told in ("--data data/yaw.csv --units rad", "--protocol data/collection.toml")
    )
    assert beside == protocol


def test_a_report_judges_poses_that_tell_no_cycle_and_a_portrait_says_that_they_tell_none(
    here, said, refused
) -> None:
    turned = ((a, (0.04 - 0.07j) * np.exp(1j * a)) for a in np.linspace(0.0, 6.0, 30))
    poses = "".join(f"0,0,{a},{moved.real},{moved.imag},{a + 1.3},150\n" for a, moved in turned)
    (here / "ends.csv").write_text(f"x0,y0,theta0,x1,y1,theta1,push_mm\n{poses}")
    said("report isotropic --data ends.csv")
    assert "ends.csv" in (here / "out" / "report_isotropic.html").read_text()
    refused("portrait isotropic --data ends.csv", "tells the orientation before the next one")
