"""Small simulated runs, and a folder of collections as MIT files, for the tests of several figures."""

from functools import cache
from pathlib import Path

from cyclemap.collection import CollectionLoop
from cyclemap.evidence import simulate_collection
from cyclemap.figures.measured_folder import MeasuredFolder
from cyclemap.figures.simulated_collections import Sampling
from cyclemap.mechanics import SidePush

# Of every run of these tests, so that one computation serves them all.
SMALL = Sampling(pushes=300, states=2, tolerance=1e-3)
NOWHERE = MeasuredFolder(None)
RECORDED_ABS, RECORDED_PLYWOOD, SCANS = 24, 20, 144


def recorded_loop(material: str) -> CollectionLoop:
    """The loop that is recorded: shorter pushes than the paper's, for time's sake."""
    return CollectionLoop.mit(material, accuracy=1e-5, push=SidePush(distance=0.05))


@cache
def _made(place: Path) -> MeasuredFolder:
    simulate_collection(recorded_loop("abs"), place / "one", RECORDED_ABS, start=2.6)
    simulate_collection(recorded_loop("plywood"), place / "two", RECORDED_PLYWOOD, scans=True)
    return MeasuredFolder(place)


def recorded_folder(tmp_path_factory) -> MeasuredFolder:
    """24 pushes on abs, 20 on plywood with its 144 friction scans: simulated, in files as a robot leaves them."""
    return _made(tmp_path_factory.getbasetemp() / "recorded collections")


def labels(figure) -> list[tuple[str, str]]:
    """The labels of both axes of every panel."""
    return [(axes.get_xlabel(), axes.get_ylabel()) for axes in figure.axes]
