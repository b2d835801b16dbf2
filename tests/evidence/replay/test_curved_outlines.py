"""Outlines cut into short sides move as the curves they stand for; the butterfly is the dataset's."""

import math

import numpy as np
import pytest
from made_replays import FRICTION, model_of

from cyclemap.evidence.replay.replay_table import dataset_sliders
from cyclemap.evidence.replay.stroke_chain import push_along
from cyclemap.mechanics import Pose, Pusher, QuasiStaticModel, Slider
from cyclemap.mechanics.footprint import PatchFootprint
from cyclemap.mechanics.outline import Ellipse, Polygon

SEMI_X, SEMI_Y = 0.045, 0.060
BUTTER = dataset_sliders()["butter"]


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.0, 0.25, 1.0])
@pytest.mark.parametrize("offset", [-0.02, 0.004, 0.03])
def test_an_ellipse_cut_into_192_sides_moves_as_the_ellipse_does(friction, offset) -> None:
    """Two routes: a chain of contacts with sides and corners, and the exact contact of the ellipse."""
    whole, rod = Ellipse(SEMI_X, SEMI_Y), Pusher(friction=friction)
    exact, cut = (
        QuasiStaticModel(Slider(outline), FRICTION, rod, PatchFootprint(whole), accuracy=1e-6)
        for outline in (whole, Polygon(whole.points(192)[:-1]))
    )
    corners = np.array([[-0.06, offset], [-0.03, offset], [-0.01, offset + 0.004]])
    wanted, found = (push_along(model, Pose(), corners) for model in (exact, cut))
    travel = np.linspace(0.0, wanted.travel[-1], 41)
    off = found.pose_at(travel) - wanted.pose_at(travel)
    assert np.hypot(*off[:, :2].T).max() < 0.06e-3
    assert np.abs(off[:, 2]).max() < math.radians(0.2)
    assert np.ptp(wanted.pose[:, 0]) > 0.002
    assert found.left == wanted.left


def test_the_butterfly_is_symmetric_as_large_as_the_datasets_mesh_and_has_its_plates_inertia() -> None:
    """Two routes to the inertia: the number given, and the second moment of area by triangles about the centre."""
    outline, p = BUTTER.outline, BUTTER.outline.array
    points = {(round(x, 9), round(y, 9)) for x, y in outline.vertices}
    assert {(round(-x, 9), y) for x, y in points} == points == {(x, round(-y, 9)) for x, y in points}
    assert np.abs(p).max(axis=0) == pytest.approx([0.0477, 0.0786], abs=1e-4)
    assert outline.centroid == pytest.approx((0.0, 0.0), abs=1e-12)
    q = np.roll(p, -1, axis=0)
    cross = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    moment = float((cross * ((p * p) + (p * q) + (q * q)).sum(1)).sum()) / 12.0
    assert BUTTER.mass / outline.area == pytest.approx(0.8374 / 0.09**2)
    assert BUTTER.inertia == pytest.approx(moment * BUTTER.mass / outline.area, rel=1e-3)


def test_mirrored_pushes_of_the_butterfly_are_mirror_images() -> None:
    model = model_of(BUTTER, accuracy=1e-5)
    corners = np.array([[-0.06, 0.02], [-0.02, 0.012]])
    up = push_along(model, Pose(), corners).pose[-1]
    down = push_along(model, Pose(), corners * (1.0, -1.0)).pose[-1]
    assert up * (1.0, -1.0, -1.0) == pytest.approx(down, abs=2e-6)
    assert abs(up[2]) > 0.05
