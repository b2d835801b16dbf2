"""The pictures that commands draw of two materials: words apart, none cut off, minus signs for
hyphens.
"""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from drawn_words import assert_words_apart, words_of_figure
from matplotlib.figure import Figure

import cyclemap as cm
from cyclemap.cli.main import run
from cyclemap.collection import CollectionLoop

MATERIALS = ("plywood-measured", "pu")
# So noisy that no rest lasts for ages, whose length would take long to find.
NOISY = ("--set", "noise_deg=6", "--cycles", "60")
GRID = ("--tolerance-deg", "1", "--quantities", "fixed_points", "--workers", "1")
HYPHEN = re.compile(r"(?<![\w°.)\]])-\d| - ")


def commands(material: str) -> dict[str, list[str]]:
    """Every command that draws, but those that search for seconds: reset and identify have tests of
    their own.
    """
    data = ["--data", "data"]
    line = ["--over", "hitch_x_mm=-14:-6:2", "--out", "line"]
    plane = ["--over", "hitch_x_mm=-14,-6", "--over", "hitch_y_mm=6,14"]
    return {
        "portrait": ["portrait", material, *NOISY, "--data", "theta0.csv"],
        "staircase": ["staircase", material, *NOISY],
        "fingerprint": ["fingerprint", material],
        "sweep over one key": ["sweep", material, *GRID, *line],
        "sweep over two": ["sweep", material, *GRID, *plane],
        "compare": ["compare", material, *data, "--runs", "19"],
        "fit": ["fit", "data", "--harmonics", "2"],
        "replay": ["replay", material, *data],
        "watch": ["watch", "data"],
        "audit": ["audit", "data"],
        "experiment": ["experiment", material, "--quasi-static", "--cycles", "4", "--batches", "3"],
        "dynamics": ["dynamics", material, "--theta0-deg", "0,180"],
    }


@pytest.fixture
def drawn(monkeypatch, tmp_path) -> list[Figure]:
    """The figures that commands save, on coarse maps, in a folder of their own; nothing is written
    of them.
    """
    figures: list[Figure] = []
    exact = CollectionLoop.circle_map
    monkeypatch.setattr(
        CollectionLoop,
        "circle_map",
        lambda loop, tolerance=1e-3, progress=None: exact(loop, max(tolerance, 1e-3), progress),
    )
    monkeypatch.setattr(Figure, "savefig", lambda figure, *_, **__: figures.append(figure))
    monkeypatch.chdir(tmp_path)
    return figures


def with_few_samples(name: str) -> str:
    """The file of a material with a dozen samples of its posterior, which are drawn as two hundred
    are.
    """
    material = cm.load_material(name)
    if material.posterior is not None:
        few = replace(material.posterior, samples=material.posterior.samples[:12])
        material = replace(material, posterior=few)
    Path(f"{name}.toml").write_text(cm.mechanics.material_toml(material), encoding="utf-8")
    return f"{name}.toml"


@pytest.mark.slow
@pytest.mark.parametrize("name", MATERIALS)
def test_every_picture_of_a_material_can_be_read(name: str, drawn: list[Figure]) -> None:
    material = with_few_samples(name)
    assert run(["simulate", material, "--cycles", "40", "--start-deg", "20", "--out", "data"]) == 0
    theta = np.degrees(np.loadtxt("data/true_theta0.txt", usecols=1))
    np.savetxt("theta0.csv", theta, header="theta0_deg", comments="")
    faults = []
    for what, command in commands(material).items():
        drawn.clear()
        assert run(command) == 0, what
        assert len(drawn) == 1, f"{what} drew {len(drawn)} pictures"
        try:
            assert_words_apart(drawn[0])
        except AssertionError as fault:
            faults.append(f"{what}: {fault}")
        written = [text.get_text() for text in words_of_figure(drawn[0])]
        faults += [f"{what}: a hyphen in {words!r}" for words in written if HYPHEN.search(words)]
    assert faults == []
