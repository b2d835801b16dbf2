"""Short runs of pushes that several tests look at, and a folder of recorded pushes."""

from functools import cache

import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.evidence.simulation.recorded_motion import RecordingNoise
from cyclemap.evidence.simulation.simulated_collection import simulate_collection
from cyclemap.figures.measured_folder import MeasuredFolder
from cyclemap.figures.pushed_paths import PushedPaths, paths_on_four_surfaces

# Enough cycles for the runs to leave where they start.
CYCLES, DRAWN = 400, 24
# The fewest that count as a set.
RECORDED = 20


@cache
def small_paths() -> list[PushedPaths]:
    return paths_on_four_surfaces(MeasuredFolder(None), CYCLES, DRAWN)


def recorded_folder(factory: pytest.TempPathFactory) -> MeasuredFolder:
    """Recorded pushes on "plywood", as the MIT dataset names them, made by the mechanics without noise.

    All tests of a run share them: a collection that is complete is not made again.
    """
    loop, folder = CollectionLoop.mit("plywood", accuracy=1e-6), factory.getbasetemp() / "recorded_pushes"
    simulate_collection(loop, folder, RECORDED, noise=RecordingNoise(turn=0.0))
    return MeasuredFolder(folder)
