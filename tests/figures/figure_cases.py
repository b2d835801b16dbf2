"""What the tests of figures share: small simulated runs, folders of recorded pushes, and what every
drawing must be.
"""

import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drawn_words import assert_words_apart, words_of_figure
from matplotlib.figure import Figure

from cyclemap.collection import CollectionLoop
from cyclemap.evidence import RecordingNoise, simulate_collection
from cyclemap.figures import MeasuredFolder, load_exhibit
from cyclemap.figures.repeated_pushes import Sampling
from cyclemap.mechanics import SidePush
from cyclemap.views.panels.layout import render

# Of every run of these tests, so that one computation serves them all.
SMALL = Sampling(pushes=300, states=2, tolerance=1e-3)
# Long enough for plywood to climb; the maps are coarse.
LONG = Sampling(pushes=2000, states=SMALL.states, tolerance=SMALL.tolerance)
NOWHERE = MeasuredFolder(None)
RECORDED_ABS, RECORDED_PLYWOOD, SCANS = 24, 20, 144
DRAWN = 24
# The fewest that count as a set.
RECORDED = 20
RUNS = 20
# Of each exhibit: how its small version is computed.
_SAMPLED, _PATHS = {"sampling": SMALL}, {"sampling": LONG, "drawn": DRAWN}
OPTIONS: dict[str, dict[str, Any]] = {
    "trajectories-object-frame": _PATHS,
    "trajectories-robot-frame": _PATHS,
    "simulated-against-measured": {"nodes": 24},
    "turn-over-theta0": _SAMPLED,
    "theta0-histograms": _SAMPLED,
    "turn-histograms": {**_SAMPLED, "runs": RUNS},
    "staircases": {**_SAMPLED, "runs": RUNS},
    "table-deviations": _SAMPLED,
    "table-law-errors": _SAMPLED,
    "anisotropic-against-isotropic": {"batches": 3, "cycles": 5},
    "dynamic-against-quasi-static": {"orientations": 3, "speeds": (0.01, 0.02, 0.04), "fewer": 1},
    "fingerprint": {
        "scales": np.array([1.0, 1 / 8, 1 / 16, 1 / 32]),
        "rays": np.radians([0.0, 90.0]),
    },
    "saddle-node": {"nodes": 6, "angles": 48, "count": 8, "counted": (5e-4,)},
    "phase-diagram": {
        "nodes": (6, 4),
        "angles": 16,
        "shape": (15, 7),
        "scales": 2,
        "fingerprints": 6,
    },
    "staircase-bottleneck": {"cycles": 8_000, "tolerance": 1e-4},
    "wear-drift": {"points": 5, "tolerance": 5e-3},
    "locking-in": {
        "start": np.radians(57.0),
        "locked": np.radians(3.0),
        "pace": ((1, 3, 2),),
        "slow": (2, 2),
    },
}
UNIT = re.compile(r"\((mm|mm/s|°|1|N|per degree|mean pressures)\)")
DIMENSIONLESS = ("coefficient", "cycle", "harmonic")


def recorded_loop(material: str) -> CollectionLoop:
    """The loop that is recorded: shorter pushes than the paper's, for time's sake."""
    return CollectionLoop.mit(material, accuracy=1e-5, push=SidePush(distance=0.05))


@cache
def _made(place: Path) -> MeasuredFolder:
    simulate_collection(recorded_loop("abs"), place / "one", RECORDED_ABS, start=2.6)
    simulate_collection(recorded_loop("plywood"), place / "two", RECORDED_PLYWOOD, scans=True)
    return MeasuredFolder(place)


def recorded_folder(tmp_path_factory) -> MeasuredFolder:
    """24 pushes on abs, 20 on plywood with its 144 friction scans: simulated, in files as a robot
    leaves them.
    """
    return _made(tmp_path_factory.getbasetemp() / "recorded collections")


@cache
def small(name: str, measured: MeasuredFolder = NOWHERE) -> Any:
    """The result of the small version of an exhibit."""
    return load_exhibit(name).compute(measured, **OPTIONS.get(name, {}))


def exhibited(name: str) -> Any:
    """A fixture: the result of the small version of an exhibit, without measured data."""
    return pytest.fixture(lambda: small(name))


def recorded_plywood(factory: pytest.TempPathFactory) -> MeasuredFolder:
    """Recorded pushes on "plywood", as the MIT dataset names them, made by the mechanics without
    noise.

    All tests of a run share them: a collection that is complete is not made again.
    """
    loop = CollectionLoop.mit("plywood", accuracy=1e-6)
    folder = factory.getbasetemp() / "recorded_pushes"
    simulate_collection(loop, folder, RECORDED, noise=RecordingNoise(turn=0.0))
    return MeasuredFolder(folder)


def assert_drawn(figure: Figure, panels: int) -> None:
    """A picture comes out; so many panels, bars of shades among them, none empty, all with units,
    words apart.
    """
    assert render(figure, "png", 60).startswith(b"\x89PNG")
    assert len(figure.axes) == panels
    for axes in figure.axes:
        assert axes.lines or axes.collections or axes.patches, "an empty panel"
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            is_one = any(word in label for word in DIMENSIONLESS)
            assert not label or UNIT.search(label) or is_one, label
        assert axes.get_xlabel() or axes.get_ylabel()
    assert_words_apart(figure)


def words_of(figure: Figure) -> str:
    """All texts of the figure and its panels, legends included, in one line."""
    return " | ".join(text.get_text() for text in words_of_figure(figure))
