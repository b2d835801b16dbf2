"""The explorer: its answers are the rooms' numbers, its page shows them, and nobody but the page is answered."""

import json
import math
import os
import shlex
import signal
import socket
import subprocess
import sys
import threading
import urllib.request
from contextlib import closing
from http.client import HTTPConnection
from urllib.error import HTTPError

import numpy as np
import pytest

import cyclemap as cm
from cyclemap.collection.portrait import noises_of
from cyclemap.protocol import read_protocol
from cyclemap.protocol.chosen_loop import set_settings
from cyclemap.views.explorer.answers import CONTROLS, cell_density, coarse, exact, explored
from cyclemap.views.explorer.server import LONGEST_BODY, ExplorerServer

SIGMA = math.radians(1.1)


@pytest.mark.slow
def test_what_is_drawn_while_a_slider_moves_is_near_what_is_drawn_when_it_rests() -> None:
    loop = cm.CollectionLoop.mit(material="plywood")
    quick, full = (answer(loop, SIGMA, 0.3, 200) for answer in (coarse, exact))
    assert set(quick) == set(full)
    assert np.abs(np.subtract(quick["turn"], full["turn"])).max() < math.degrees(2e-3)
    assert [one["stable"] for one in quick["fixed_points"]] == [one["stable"] for one in full["fixed_points"]]
    assert quick["orbit"] == full["orbit"][:2]


@pytest.mark.slow
def test_the_exact_answer_is_the_portrait() -> None:
    loop = cm.CollectionLoop.mit(material="plywood")
    answer, points = exact(loop, SIGMA, 0.0, 300), cm.fixed_points(loop.circle_map())
    assert [one["theta_deg"] for one in answer["fixed_points"]] == [
        round(math.degrees(orbit.points[0]), 6) for orbit in points
    ]
    assert len(answer["fixed_points"]) == 2
    known = cm.portrait(loop, sigma=SIGMA, cycles=10).uncertainty.directions
    assert answer["may_lie"] == [[round(math.degrees(end), 2) for end in (one.lower, one.upper)] for one in known]
    stable = next(one["theta_deg"] for one in answer["fixed_points"] if one["stable"])
    assert any(low <= stable <= high for low, high in answer["may_lie"])
    for now, after, (push, drag) in zip(answer["orbit"], answer["orbit"][1:], answer["courses"], strict=False):
        cycle = loop.cycle(math.radians(now))
        assert after == pytest.approx(math.degrees(cycle.theta_next), abs=1e-3)
        assert push[-1][:3] == drag[0][:3]
        assert math.hypot(*drag[-1][3:]) < 1e-2, "the rod ends at the target"
        assert push[-1][2] - push[0][2] == pytest.approx(math.degrees(cycle.push_turn), abs=0.02)


@pytest.mark.parametrize("sigma_deg", [3.0, 6.0, 12.0])
def test_distribution_of_cells_is_that_of_the_transfer_operator(sigma_deg) -> None:
    """Total variation of a percent at most, mass one; the rigid rotation keeps the uniform distribution exactly."""
    circle_map, noise = cm.CircleMap.arnold(0.1, 0.9), cm.WrappedNormal(math.radians(sigma_deg))
    theta = 2 * np.pi * (np.arange(360) + 0.5) / 360
    found, true = cell_density(circle_map, noise), 2 * np.pi * cm.transfer_operator(circle_map, noise).density(theta)
    assert found.mean() == pytest.approx(1.0, abs=1e-9)
    assert 0.5 * np.abs(found - true).mean() < 0.01
    assert cell_density(cm.CircleMap.rigid(0.1234), noise) == pytest.approx(1.0, abs=1e-9)


def test_copied_command_and_saved_protocol_are_the_loop_of_the_page(tmp_path) -> None:
    moved = {"hitch_x_mm": -7.5, "mu_a": 0.3, "phi_deg": 20.0, "rim_share": 0.4, "side": 1, "push_mm": 80.0}
    moved["noise_deg"] = 3.0
    found = explored(("plywood",), "plywood", {"pusher_mu": 0.2}).moved(moved)
    assert found.sigma == math.radians(3.0)
    words = shlex.split(found.command())
    assert words[:3] == ["cyclemap", "portrait", "plywood"]
    (tmp_path / "saved.toml").write_text(found.protocol())
    for settings in (set_settings(words[4::2]), read_protocol(tmp_path / "saved.toml")[0]):
        assert settings.pop("noise_deg") == 3.0
        loop = cm.protocol.loop_from_settings(settings, cm.CollectionLoop.mit(material="plywood"))
        assert loop.cycle(0.4).theta_next == found.loop.cycle(0.4).theta_next


def test_sliders_stand_where_the_loop_is_and_reach_as_far() -> None:
    start = explored(("plywood",), "plywood", {"push_mm": 400.0})
    shown = {one["key"]: one for one in start.controls()}
    assert set(shown) == {one.key for one in CONTROLS}
    assert shown["push_mm"]["value"] == shown["push_mm"]["high"] == 400.0
    assert all(one["low"] <= one["value"] <= one["high"] for one in shown.values())
    same = start.moved({key: one["value"] for key, one in shown.items()})
    assert same.loop.cycle(1.0).theta_next == pytest.approx(start.loop.cycle(1.0).theta_next, abs=1e-7)
    disc = explored(("abs",), "abs", {"shape": "ellip1"})
    assert {"side", "corner_share"}.isdisjoint(one["key"] for one in disc.controls())
    # A material with a noise of its own is drawn with that, not with the usual 1.1 degrees.
    start = explored(("plywood-measured",), "plywood-measured", {})
    (noise,) = (one["value"] for one in start.controls() if one["key"] == "noise_deg")
    used = noises_of(start.loop, start.loop.circle_map(), None)[0].sigma
    assert noise == pytest.approx(math.degrees(used), rel=0.02) and noise < 0.8


@pytest.mark.parametrize(
    ("moved", "said"),
    [
        ({"mu_c": 1.0}, "mu_c"),
        ({"mu_a": "1"}, "mu_a"),
        ({"mu_a": True}, "mu_a"),
        ({"mu_a": math.nan}, "mu_a"),
        ({"vertices_mm": 1.0}, "vertices_mm"),
        ({"rim_share": 0.7, "inner_share": 0.7}, "share"),
    ],
)
def test_what_no_slider_can_mean_is_refused_by_name(moved, said) -> None:
    with pytest.raises(cm.InvalidInput, match=said):
        explored(("plywood",), "plywood", {}).moved(moved)


@pytest.fixture
def server():
    begun, free = threading.Event(), threading.Event()

    def slow(asked, check):
        begun.set()
        assert free.wait(20)
        check()
        return {"got": asked}

    with ExplorerServer({"echo": lambda asked, check: {"got": asked}, "slow": slow}) as made:
        made.begun, made.free = begun, free
        threading.Thread(target=made.serve_forever, daemon=True).start()
        yield made
        made.shutdown()


def request(server, path="/api/echo", body=b'{"a": 1}', **changed):
    """The status and body of a POST as the page sends it, with headers changed (None: left out)."""
    headers = {"Host": server.origin[7:], "Origin": server.origin, "X-Token": server.token}
    headers |= {"Content-Type": "application/json", "Content-Length": str(len(body))}
    headers |= {name.replace("_", "-"): value for name, value in changed.items()}
    with closing(HTTPConnection(*server.server_address, timeout=20)) as connection:
        connection.putrequest("POST", path, skip_host=True)
        for name, value in headers.items():
            if value is not None:
                connection.putheader(name, value)
        connection.endheaders(body)
        reply = connection.getresponse()
        return reply.status, reply.read()


def test_the_page_is_answered(server) -> None:
    status, body = request(server)
    assert (status, json.loads(body)) == (200, {"got": {"a": 1}})
    assert json.loads(request(server, body=b"[1")[1])["refused"]
    assert json.loads(request(server, body=b"[" * 60_000)[1])["refused"]


@pytest.mark.parametrize(
    ("changed", "status"),
    [
        *(({name: value}, 403) for name in ("Host", "Origin", "X_Token") for value in ("http://evil.example", None)),
        ({"Content_Type": "text/plain"}, 415),
        ({"Content_Length": None}, 411),
        ({"Content_Length": "-1"}, 411),
        ({"Content_Length": str(LONGEST_BODY + 1)}, 413),
        ({"path": "/api/none"}, 404),
        ({"path": "/echo"}, 404),
    ],
)
def test_what_does_not_come_from_the_page_is_refused(server, changed, status) -> None:
    assert request(server, **changed)[0] == status


@pytest.mark.parametrize(
    "path", ["/../server.py", "/%2e%2e/server.py", "//etc/passwd", "/server.py", "/uplot/", "/page.html?a"]
)
def test_only_the_pages_own_files_are_served(server, path) -> None:
    with pytest.raises(HTTPError) as refused, urllib.request.urlopen(server.origin + path):
        pass
    assert refused.value.code == 404
    refused.value.close()


def test_the_page_lets_no_other_script_in_and_no_other_machine_reaches_it(server) -> None:
    with urllib.request.urlopen(server.origin) as page:
        policy, text = page.headers["Content-Security-Policy"], page.read().decode()
    assert "default-src 'none'" in policy and "unsafe" not in policy
    assert "<script>" not in text and server.token not in text
    assert server.server_address[0] == "127.0.0.1"


def test_an_overtaken_request_is_given_up(server) -> None:
    """Of three, the first is at work, the second waits and is overtaken by the third, which is answered."""
    replies = {}

    def send(number):
        body = json.dumps({"page": "p", "number": number}).encode()
        replies[number] = json.loads(request(server, "/api/slow", body)[1])

    threads = [threading.Thread(target=send, args=(number,)) for number in (1, 2, 3)]
    threads[0].start()
    assert server.begun.wait(20)
    for thread in threads[1:]:
        thread.start()
    while server.newest.get("p") != 3:
        pass
    server.free.set()
    for thread in threads:
        thread.join(20)
    assert replies[1] == {"stale": True}
    assert replies[3] == {"got": {}}


def test_a_browser_that_goes_away_leaves_the_server_at_work(server) -> None:
    for _ in range(3):
        with socket.create_connection(server.server_address) as cut:
            cut.sendall(b"POST /api/echo HTTP/1.1\r\n")
    assert request(server)[0] == 200


@pytest.fixture
def running():
    command = [sys.executable, "-m", "cyclemap", "explore", "plywood", "--no-browser"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONUNBUFFERED": "1"}
    ) as process:
        process.address = next(word for word in process.stdout.readline().split() if word.startswith("http"))
        yield process
        process.kill()


@pytest.mark.slow
def test_interrupt_ends_it_well(running) -> None:
    running.send_signal(signal.SIGINT)
    told, fault = running.communicate(timeout=30)
    assert (running.returncode, told.strip(), fault) == (0, "ended", "")


@pytest.mark.slow
def test_page_in_a_real_browser(running, open_page) -> None:
    page = open_page(running.address)
    page.wait_for_selector("body[data-exact=true]")
    frames = [int(page.evaluate("document.body.dataset.frames")) for _ in range(2) if not page.wait_for_timeout(500)]
    assert frames[1] > frames[0], "the animation goes on"
    page.locator("#hitch_x_mm-number").fill("-9.4")
    page.locator("#hitch_x_mm-number").press("Enter")
    page.wait_for_selector("#command:has-text('hitch_x_mm=-9.4')")
    page.wait_for_selector("body[data-exact=true]")
    assert "hitch_x_mm=-9.4" in page.url
    loop = cm.protocol.loop_from_settings({"hitch_x_mm": -9.4}, cm.CollectionLoop.mit(material="plywood"))
    shown = page.evaluate("document.getElementById('headline').textContent")
    stable = [orbit for orbit in cm.fixed_points(loop.circle_map()) if orbit.stable]
    assert stable and all(f"{math.degrees(orbit.points[0]):.1f}°" in shown for orbit in stable)
