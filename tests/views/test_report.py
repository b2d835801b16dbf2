"""The report: one file, the same bytes each time, its numbers the command's, alive without a
network.
"""

import html
import json
import math
import re

import numpy as np
import pytest
from click.testing import CliRunner

import cyclemap as cm
from cyclemap.cli.main import cli
from cyclemap.views import sentences

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def theta0_file(tmp_path_factory):
    """A short staircase on plywood, with noise."""
    loop = cm.CollectionLoop.mit(material="plywood")
    noise = cm.WrappedNormal(math.radians(1.1))
    theta = np.degrees(cm.sample_staircase(loop.circle_map(1e-4), noise, 120, 0.5, 3).theta)
    path, pairs = tmp_path_factory.mktemp("data") / "mine.csv", np.stack([theta[:-1], theta[1:]])
    np.savetxt(path, pairs.T, "%.6f", ",", header="theta0_deg,theta_next_deg", comments="")
    return path


@pytest.fixture(scope="module")
def report(theta0_file, tmp_path_factory):
    return written(theta0_file, tmp_path_factory.mktemp("one"))


def written(theta0_file, folder):
    done = CliRunner().invoke(
        cli, ["report", "plywood", "--data", str(theta0_file), "--out", str(folder)]
    )
    assert done.exit_code == 0, done.output
    return folder / "report_plywood.html"


def test_the_same_input_makes_the_same_bytes_and_less_than_900_kb(
    report, theta0_file, tmp_path
) -> None:
    assert report.read_bytes() == written(theta0_file, tmp_path).read_bytes()
    assert len(report.read_bytes()) < 900e3


def test_numbers_are_those_of_the_mechanics_and_words_those_of_the_comparison(
    report, theta0_file
) -> None:
    text = report.read_text()
    data = json.loads(
        re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)[1]
    )
    loop = cm.CollectionLoop.mit(material="plywood")
    points = cm.fixed_points(loop.circle_map())
    assert [one["theta_deg"] for one in data["answer"]["fixed_points"]] == [
        round(math.degrees(orbit.points[0]), 6) for orbit in points
    ]
    assert len(data["measured"]["theta"]) == len(theta0_file.read_text().splitlines()) - 1
    known = sentences.uncertainty_sentence("plywood", cm.portrait(loop, cycles=10).uncertainty)
    left = "cycles there is left as root mean square "
    for words in (known, "Recorded against predicted", left, "SHA-256"):
        assert words in html.unescape(text)
    assert text.count("<figure><img") == len(data["answer"]["may_lie"]) == 1


def test_report_lives_without_a_network(report, open_page) -> None:
    """The fixed points end in a saddle-node as the ring moves in, computed in the page."""
    page = open_page(report.as_uri(), offline=True)
    page.wait_for_selector("#even:enabled")
    assert page.evaluate("cyclemap.answer.fixed_points.length") == 2
    for key, value in (("hitch_x_mm", "-6.4"), ("hitch_y_mm", "6.4")):
        page.fill(f"#{key}-number", value)
        page.press(f"#{key}-number", "Enter")
    page.wait_for_selector("body[data-drawn='2-fine']")
    assert page.evaluate("cyclemap.answer.fixed_points.length") == 0
    assert "locks into no direction" in page.inner_text("#headline")


def test_a_name_cannot_bring_script_into_the_report(tmp_path) -> None:
    material = tmp_path / "evil.toml"
    material.write_text(
        'name = "x</script><script>alert(1)</script>"\nprovenance = "<img src=x '
        'onerror=alert(1)>"\n'
        "[friction]\nmu_a = 0.25\nmu_b = 0.24\nm0 = 0.0\nn0 = 0.0\nphi_deg = 0.0\n"
    )
    done = CliRunner().invoke(cli, ["report", str(material), "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    [page] = tmp_path.glob("*.html")
    assert "<script>alert" not in page.read_text()
    assert "<img src=x" not in page.read_text()
