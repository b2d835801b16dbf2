"""Short runs of pushes that several tests look at, and a folder of recorded pushes."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from drawn_figures import assert_drawn, words_of

from cyclemap.collection import CollectionLoop
from cyclemap.evidence import RecordingNoise, simulate_collection
from cyclemap.figures.catalogue import PaperFigure
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


def assert_starts_where_the_robot_did(exhibit: PaperFigure, found: Any) -> None:
    """The pushes drawn of plywood begin at measured orientations, from the first to the last, and it is said."""
    plywood = found.surfaces[0]
    assert plywood.orientations.shape == (2000,) and plywood.theta0.shape == (DRAWN,)
    assert np.degrees(plywood.theta0[[0, -1]]) == pytest.approx(np.degrees(plywood.orientations[[0, -1]]))
    told, figure = exhibit.caption(found), exhibit.draw(found)
    assert f"from {DRAWN} of the 2000 measured orientations of plywood" in told
    assert "plywood, from measured θ0" in words_of(figure).replace("\n", " ")
    assert_drawn(figure, 5)
