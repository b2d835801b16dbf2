"""The explorer's page: its numbers are Python's, in a browser without a network, and it lets nobody
else in.
"""

import json
import math
import re
import shlex
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import cyclemap as cm
from cyclemap.cli.main import cli
from cyclemap.collection import portrait
from cyclemap.mechanics.browser_tables import browser_tables
from cyclemap.protocol import loop_from_settings, read_protocol
from cyclemap.protocol.chosen_loop import set_settings
from cyclemap.views.explorer_page import explorer_frame, page_html, slider_controls, slider_values

SIGMA = math.radians(1.1)
L_SHAPE = {"vertices_mm": [[-45, 45], [-45, -45], [45, -45], [45, 0], [0, 0], [0, 45]], "side": 1}
L_SHAPE |= {"hitch_x_mm": -15.0, "hitch_y_mm": -10.0}
BENT = {"floor_dome": 4.0, "floor_bow": 4.0, "floor_bow_deg": 90.0, "plate_warp": 1.0}
MOVED = {"hitch_x_mm": -9.4, "mu_a": 0.3, "phi_deg": 20.0, "rim_share": 0.4, "corner_share": 0.1}
# Of a loop, then of sliders.
CASES = [
    ("plywood-measured", {}, {}),
    ("plywood-floor", {}, {}),
    ("abs-floor", {}, {}),
    ("isotropic", {}, BENT),
    ("pu", {"noise_deg": 4.0}, {}),
    ("plywood", {"noise_deg": 100.0}, {}),
    ("plywood", {"shape": "ellip1"}, {"fraction": 0.3, "rim_share": 0.2}),
    ("plywood", L_SHAPE, {"angle_deg": 10.0, "pusher_mu": 0.3}),
    ("plywood", {"footprint": "grid:8"}, {}),
    ("plywood", {}, MOVED),
    ("delrin", {}, {"side": 2.0, "push_mm": 80.0, "pusher_radius_mm": 8.0, "m0": 0.01}),
]
# Ask a worker of the page's own for one loop after another.
ASK = """async (cases) => {
  const given = JSON.parse(document.getElementById("data").textContent);
  const found = [];
  for (const { tables, values, cycles } of cases) {
    const text = document.getElementById("worker").textContent;
    const worker = new Worker(URL.createObjectURL(new Blob([text], { type: "text/javascript" })));
    found.push(await new Promise((done) => {
      worker.onmessage = ({ data }) => {
        if (data.ready) worker.postMessage({ id: 1, values, start: 0.3, cycles });
        else if (data.fine || data.refused) done(data);
      };
      worker.postMessage({ wasm: given.wasm, tables });
    }));
    worker.terminate();
  }
  return found;
}"""


@pytest.fixture(scope="module")
def explored(tmp_path_factory):
    return written(tmp_path_factory.mktemp("explored"))


def written(folder, *words):
    done = CliRunner().invoke(
        cli, ["explore", "plywood", "--no-browser", "--out", str(folder), *words]
    )
    assert done.exit_code == 0, done.output
    return folder / "explore_plywood.html"


def loop_of(material, settings):
    return loop_from_settings(settings, cm.CollectionLoop.mit(material=material))


def assert_fixed_points(loop, circle_map, points) -> None:
    """The page's fixed points are all that the map has, to 1e-8 rad by a step of Newton's, and so
    are their multipliers.
    """
    sharp = replace(loop, accuracy=1e-11)
    for point, orbit in zip(points, cm.fixed_points(circle_map), strict=True):
        theta = math.radians(point["theta_deg"])
        assert theta == pytest.approx(orbit.points[0], abs=1e-4)
        slope = sharp.sensitivity(theta, ("theta",)).by("theta")
        off = math.remainder(float(sharp.next_theta(theta)) - theta, 2 * math.pi)
        assert abs(off / (1.0 - slope)) < 1e-8
        assert point["multiplier"] == pytest.approx(slope, abs=1e-4)


def asked_of(material, settings, moved):
    """What a worker of the page is asked for a loop, and sliders moved."""
    loop = loop_of(material, settings)
    sigma = math.radians(settings.get("noise_deg", 1.1))
    return {
        "tables": browser_tables(loop.model, loop.reset),
        "values": {**slider_values(loop, sigma), **moved},
        "cycles": 50,
    }


@pytest.mark.slow
def test_numbers_of_the_browser_are_those_of_python(explored, open_page) -> None:
    """The turn to 1e-6 rad, fixed points to 1e-8 rad, the density to .5 % of its peak, for loops
    and sliders alike.
    """
    asked = [asked_of(*case) for case in CASES]
    page = open_page(explored.as_uri(), offline=True)
    answers = page.evaluate(ASK, asked)
    theta = np.radians(np.arange(360))
    with_points = 0
    for (material, settings, moved), answer in zip(CASES, answers, strict=True):
        assert "refused" not in answer, (material, moved, answer)
        loop = loop_of(material, {**settings, **moved})
        following = replace(loop, accuracy=1e-9).next_theta(theta)
        off = following - theta - np.radians(answer["turn"][:360])
        assert np.abs(off).max() < 1e-6, (material, moved)
        circle_map = loop.circle_map()
        assert_fixed_points(loop, circle_map, answer["fixed_points"])
        with_points += bool(answer["fixed_points"])
        sigma = math.radians(settings.get("noise_deg", 1.1))
        operator = cm.transfer_operator(circle_map, cm.WrappedNormal(sigma))
        density = 2 * np.pi * operator.density(theta)
        assert np.abs(density - answer["density"]).max() < 5e-3 * density.max(), (material, moved)
        cycle = loop.cycle(0.3)
        push, drag = answer["courses"][0]
        ends = (cycle.push.end, cycle.push.end.theta), (cycle.drag.end, cycle.theta_next)
        pushed, dragged = ([1e3 * end.x, 1e3 * end.y, math.degrees(angle)] for end, angle in ends)
        assert push[-1][:3] == pytest.approx(pushed, abs=1e-3)
        assert drag[-1] == pytest.approx([*dragged, 0.0, 0.0], abs=1e-3)
    assert with_points >= 3


@pytest.mark.slow
def test_firefox_computes_what_chromium_does(explored, open_page, firefox) -> None:
    """From a file, without a network: every number to 1e-9 of a degree."""
    asked = [asked_of(*case) for case in CASES[2:4]]
    firefox.open(explored.as_uri())
    answers = firefox.evaluate(ASK, asked)
    page = open_page(explored.as_uri(), offline=True)
    for there, here in zip(answers, page.evaluate(ASK, asked), strict=True):
        assert there["turn"] == pytest.approx(here["turn"], abs=1e-9)
        assert there["density"] == pytest.approx(here["density"], abs=1e-9)
        assert there["staircase"]["turns"] == pytest.approx(here["staircase"]["turns"], abs=1e-9)
        for point, same in zip(there["fixed_points"], here["fixed_points"], strict=True):
            assert point == pytest.approx(same, abs=1e-9)


@pytest.mark.slow
def test_the_page_lives_in_firefox(explored, firefox) -> None:
    """A slider moves words and pictures; the page is as wide as the window."""
    firefox.open(explored.as_uri(), width=500)
    firefox.wait_for("#even:enabled")
    before = firefox.evaluate("() => document.getElementById('headline').textContent")
    firefox.evaluate(
        """() => {
          const slider = document.getElementById("hitch_x_mm");
          slider.value = -2;
          slider.dispatchEvent(new Event("input"));
        }"""
    )
    firefox.wait_for("body[data-drawn='1-fine']")
    assert firefox.evaluate("() => document.getElementById('headline').textContent") != before
    assert firefox.evaluate("() => document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.slow
def test_cycles_in_webassembly_are_the_native_ones(explored, open_page) -> None:
    """To 1e-12 rad, and slopes to 1e-10: what differs is the rounding of sines and logarithms
    alone.
    """
    page = open_page(explored.as_uri(), offline=True)
    loop = cm.CollectionLoop.mit(material="plywood")
    theta = np.radians(np.arange(0, 360, 45)).tolist()
    source = Path(cm.__file__).parent / "views" / "explorer" / "engine.js"
    ask = """async ([source, tables, values, theta]) => {
      const { wasm } = JSON.parse(document.getElementById("data").textContent);
      const told = "onmessage = async ({ data }) => { const engine = new Engine(await compiled(data[0]), data[1]);"
        + "engine.set(data[2], 1e-9); const { next, slope } = engine.cycles(data[3]);"
        + "postMessage([[...next], [...slope]]); };";
      const worker = new Worker(URL.createObjectURL(new Blob([source, told])));
      const answer = new Promise((done) => { worker.onmessage = ({ data }) => done(data); });
      worker.postMessage([wasm, tables, values, theta]);
      return answer;
    }"""
    tables, values = browser_tables(loop.model, loop.reset), slider_values(loop, SIGMA)
    following, slopes = page.evaluate(ask, [source.read_text(), tables, values, theta])
    native = replace(loop, accuracy=1e-9)
    assert following == pytest.approx(native.next_theta(theta).tolist(), abs=1e-12)
    by_theta = [native.sensitivity(angle, ("theta",)).by("theta") for angle in theta]
    assert slopes == pytest.approx(by_theta, abs=1e-10)


@pytest.mark.slow
def test_page_in_a_real_browser(explored, open_page, tmp_path) -> None:
    """A slider moves pictures, words and address; command and protocol give the same loop; start
    anew goes back.
    """
    page = open_page(explored.as_uri(), offline=True)
    page.wait_for_selector("body[data-drawn='0-written']")
    written_words = page.inner_text("#said")
    page.wait_for_selector("#even:enabled")
    frames = page.evaluate("document.body.dataset.frames")
    page.wait_for_function(
        "(frames) => Number(document.body.dataset.frames) > frames", arg=int(frames)
    )
    page.fill("#hitch_x_mm-number", "-9.4")
    page.press("#hitch_x_mm-number", "Enter")
    page.wait_for_selector("body[data-drawn='1-fine']")
    assert "hitch_x_mm=-9.4" in page.url
    loop = loop_of("plywood", {"hitch_x_mm": -9.4})
    stable = [orbit for orbit in cm.fixed_points(loop.circle_map()) if orbit.stable]
    assert stable and all(
        f"{math.degrees(orbit.points[0]):.1f}°" in page.inner_text("#headline") for orbit in stable
    )
    words = shlex.split(page.inner_text("#command"))
    assert words[:3] == ["cyclemap", "portrait", "plywood"]
    with page.expect_download() as saved:
        page.click("#save")
    saved.value.save_as(tmp_path / "saved.toml")
    for settings in (set_settings(words[4::2]), read_protocol(tmp_path / "saved.toml")[0]):
        assert loop_of("plywood", settings).cycle(0.4).theta_next == loop.cycle(0.4).theta_next
    page.click("#reset")
    page.wait_for_selector("body[data-drawn='2-written']")
    assert page.inner_text("#said") == written_words


@pytest.mark.slow
def test_three_stories_are_one_click_each_and_refusals_are_in_plain_words(
    explored, open_page
) -> None:
    page = open_page(explored.as_uri(), offline=True)
    page.wait_for_selector("#even:enabled")
    told = {}
    for number, name in enumerate(("locks", "slips", "even"), 1):
        page.click(f"#{name}")
        page.wait_for_selector(f"body[data-drawn='{number}-fine']")
        told[name] = (
            page.inner_text("#headline") + page.inner_text("#said"),
            page.evaluate("cyclemap.answer.fixed_points"),
        )
    assert any(point["stable"] for point in told["locks"][1])
    assert "locks into orientation" in told["locks"][0]
    assert told["slips"][1] == [] and "biased" in told["slips"][0]
    assert told["even"][1] == [] and "no bias to speak of" in told["even"][0]
    page.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
    for key in ("rim_share", "inner_share"):
        page.fill(f"#{key}-number", "0.7")
        page.press(f"#{key}-number", "Enter")
    page.wait_for_selector("body[data-drawn='5-refused']")
    told = "Loads inside, on rim and corners come to 1.40: together they may be 1.00 at most."
    assert page.inner_text("#headline") == told
    # What is refused is not to be copied or saved; what follows is.
    taken = "['copy', 'save'].map((name) => document.getElementById(name).disabled)"
    assert page.evaluate(taken) == [True, True]
    assert "inner_share=0.7" not in page.inner_text("#command")
    page.fill("#inner_share-number", "0.2")
    page.press("#inner_share-number", "Enter")
    page.wait_for_selector("body[data-drawn='6-fine']")
    assert page.evaluate(taken) == [False, False]
    assert "inner_share=0.2" in page.inner_text("#command")


@pytest.mark.slow
def test_links_and_numbers_are_told_as_they_are_computed(explored, open_page) -> None:
    """A link moves what sliders can move, as far as they reach; what lies between two steps is
    shown whole; a field that is emptied shows again what holds; another link of the same page is
    followed, whatever its stories look for meanwhile.
    """
    address = f"{explored.as_uri()}#rim_share=-0.5&push_mm=120.5&mu_a=&side=0.6"
    page = open_page(address, offline=True)
    page.wait_for_selector("body[data-drawn='1-fine']")
    told = page.evaluate("cyclemap.values")
    assert (told["rim_share"], told["push_mm"], told["side"]) == (0.0, 120.5, 1.0)
    assert told["mu_a"] == pytest.approx(0.2545)
    shown = page.evaluate(
        "['push_mm', 'mu_a'].map((key) => document.getElementById(key + '-number').value)"
    )
    assert shown == ["120.5", "0.2545"]
    friction = page.locator("#mu_a-number")
    friction.fill("")
    friction.blur()
    assert friction.input_value() == "0.2545"
    page.evaluate("location.hash = 'hitch_x_mm=-9.4&mu_a=0.3'")
    page.wait_for_selector("body[data-drawn='2-fine']")
    followed = page.evaluate("cyclemap.values")
    assert (followed["hitch_x_mm"], followed["push_mm"]) == (-9.4, 150.0)
    loop = loop_of("plywood", {"hitch_x_mm": -9.4, "mu_a": 0.3})
    assert_fixed_points(loop, loop.circle_map(), page.evaluate("cyclemap.answer.fixed_points"))


@pytest.mark.slow
def test_the_staircase_is_as_long_as_the_measured_one_and_starts_with_it(tmp_path) -> None:
    """Else what was measured later is left out of the picture, and turns are counted from
    elsewhere.
    """
    rows = [f"{(40 + 8 * index) % 360}" for index in range(3000)]
    (tmp_path / "measured.csv").write_text("\n".join(["theta0_deg", *rows]))
    page = written(tmp_path, "--data", str(tmp_path / "measured.csv")).read_text()
    shown = json.loads(
        re.search(r'<script type="application/json" id="data">(.*?)</script>', page)[1]
    )
    assert (shown["cycles"], shown["start_deg"]) == (2999, pytest.approx(40.0))
    assert shown["answer"]["staircase"]["turns"][0] == shown["measured"]["staircase"][0]


@pytest.mark.slow
def test_a_turn_and_a_third_gets_around_once(open_page, tmp_path) -> None:
    """Sixty cycles of 8 degrees each, as many as a short collection has."""
    shown = portrait(cm.CollectionLoop.mit("isotropic"), cycles=60)
    place = tmp_path / "short.html"
    place.write_text(page_html(shown, 0.0, ("isotropic",), {}))
    page = open_page(f"{place.as_uri()}#start_deg=1", offline=True)
    page.wait_for_selector("body[data-drawn='1-fine']")
    assert "In 60 pushes with this noise it gets around once." in page.inner_text("#said")


@pytest.mark.slow
def test_the_page_is_small_and_the_same_each_time_and_lets_no_other_script_in(
    explored, tmp_path
) -> None:
    content = explored.read_bytes()
    assert content == written(tmp_path).read_bytes()
    assert len(content) < 450e3
    policy = re.search(rb'Content-Security-Policy" content="([^"]*)"', content)[1].decode()
    assert "default-src &#39;none&#39;" in policy and "connect-src" not in policy
    assert "unsafe" not in policy.replace("wasm-unsafe-eval", "")


@pytest.mark.slow
def test_a_notebook_shows_a_loop_as_the_page_and_else_as_its_picture(open_page, tmp_path) -> None:
    """The frame hides the picture, which stays where a notebook takes frames out."""
    shown = explorer_frame(loop_of("plywood", {"push_mm": 120.0}))
    (tmp_path / "notebook.html").write_text(f"<!doctype html><meta charset='utf-8'>{shown}")
    notebook = open_page((tmp_path / "notebook.html").as_uri(), offline=True)
    frame = notebook.frame_locator("iframe")
    frame.locator("#even:enabled").click()
    frame.locator("body[data-drawn='1-fine']").wait_for()
    assert "--set push_mm=120" in frame.locator("#command").inner_text()
    assert notebook.locator("iframe").bounding_box() == notebook.locator("div").bounding_box()
    assert notebook.locator("img").evaluate("(picture) => picture.naturalWidth") > 600


@pytest.mark.slow
def test_notebooks_are_told_how_to_show_a_loop() -> None:
    """By IPython's own registry, where a session of it imports the package; nothing is loaded
    before a loop is shown.
    """
    session = """
import sys, types
told = {}
html = types.SimpleNamespace(for_type_by_name=lambda *words: told.update({words[:2]: words[2]}))
shell = types.SimpleNamespace(display_formatter=types.SimpleNamespace(formatters={"text/html": html}))
sys.modules["IPython"] = types.SimpleNamespace(get_ipython=lambda: shell, version_info=(9, 0))
import cyclemap
assert "cyclemap.views" not in sys.modules
loop = cyclemap.CollectionLoop.mit()
show = told[type(loop).__module__, type(loop).__name__]
assert show(loop).count("<iframe") == 1
"""
    subprocess.run([sys.executable, "-c", session], check=True)


@pytest.mark.slow
def test_without_script_there_is_a_picture(explored, open_page) -> None:
    page = open_page(explored.as_uri(), offline=True, java_script_enabled=False)
    assert page.locator("noscript img").bounding_box()["width"] > 600


def test_sliders_stand_where_the_loop_is_and_reach_as_far() -> None:
    loop = loop_of("plywood", {"push_mm": 400.0})
    shown = {row["key"]: row for row in controls_of(loop)}
    assert shown["push_mm"]["value"] == shown["push_mm"]["high"] == pytest.approx(400.0)
    assert all(row["low"] <= row["value"] <= row["high"] for row in shown.values())
    same = loop_of("plywood", {key: row["value"] for key, row in shown.items()})
    assert same.cycle(1.0).theta_next == pytest.approx(loop.cycle(1.0).theta_next, abs=1e-12)


@pytest.mark.parametrize(
    ("settings", "left_out"),
    [
        ({}, set()),
        ({"shape": "ellip1"}, {"side", "corner_share"}),
        # A contact curve about a concave outline, and points that carry the weight, are Python's.
        (L_SHAPE, {"pusher_radius_mm", "corner_share"}),
        ({"footprint": "grid:8"}, {"rim_share", "corner_share", "floor_bow", "plate_warp"}),
        # About corners a point has no arcs for a thicker rod to roll along.
        ({"pusher_radius_mm": 0.0}, {"pusher_radius_mm"}),
        ({"pusher_radius_mm": 0.0, "shape": "ellip1"}, {"side", "corner_share"}),
    ],
)
def test_a_slider_is_left_out_where_the_page_cannot_compute_what_it_moves(
    settings, left_out
) -> None:
    watched = {"side", "corner_share", "rim_share", "pusher_radius_mm", "floor_bow", "plate_warp"}
    shown = {row["key"] for row in controls_of(loop_of("plywood", settings))}
    assert watched - shown == left_out and "hitch_x_mm" in shown


def controls_of(loop):
    return slider_controls(loop, slider_values(loop, SIGMA), browser_tables(loop.model, loop.reset))


def test_tables_hold_in_json() -> None:
    """Infinities are packed, and nothing is lost on the way."""
    loop = cm.CollectionLoop.mit(material="plywood-floor")
    tables = browser_tables(loop.model, loop.reset)
    assert json.loads(json.dumps(tables, allow_nan=False))["unit"] == loop.model.unit
