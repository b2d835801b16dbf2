"""Objects of any flat outline: what tips, and what is pushed, dragged and drawn though its centroid
lies beside it.
"""

import math

import numpy as np
import pytest
from force_balance import check
from refusals import refused

import cyclemap as cm
from cyclemap.mechanics import EllipseFriction, Polygon, Pose, QuasiStaticModel, SidePush, Slider
from cyclemap.protocol.own_object import first_settings

LAW = EllipseFriction(0.2545, 0.2346, 0.0325, 0.0082, 2.6175)
L_SHAPE = Polygon(((0, 0), (0.1, 0), (0.1, 0.02), (0.02, 0.02), (0.02, 0.1), (0, 0.1)))
U_SHAPE = Polygon(
    ((0, 0), (0.1, 0), (0.1, 0.1), (0.08, 0.1), (0.08, 0.02), (0.02, 0.02), (0.02, 0.1), (0, 0.1))
)
BENT = {"L": (L_SHAPE, (0.01, 0.01)), "U": (U_SHAPE, (0.01, 0.03))}


def random_band(rng):
    """A bent band of uneven width, and a place within its first part."""
    count, span = int(rng.integers(3, 7)), rng.uniform(1.0, 1.6) * math.pi
    angles = np.linspace(0.0, span, count) + rng.uniform(0.0, 0.1, count)
    around = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    outer, inner = rng.uniform(0.05, 0.06, count), rng.uniform(0.03, 0.045, count)
    outside, inside = outer[:, None] * around, inner[:, None] * around
    corners = np.concatenate([outside, inside[::-1]])
    first_cell = np.concatenate([outside[:2], inside[:2]])
    return Polygon(tuple(map(tuple, corners))), tuple(first_cell.mean(axis=0))


def reachable_push(model, rng):
    """The first of some pushes of a side that the rod can touch."""
    for _ in range(20):
        side = int(rng.integers(model.slider.outline.sides))
        push = SidePush(side, rng.uniform(0.1, 0.9), rng.uniform(-0.8, 0.8), 0.04)
        try:
            return push, model.push(Pose(theta=rng.uniform(-3, 3)), push)
        except cm.CycleMapError as error:
            assert "cannot touch" in str(error) or "concave corner" in str(error)
    return None


@pytest.mark.parametrize("name", BENT)
def test_an_object_whose_centroid_lies_beside_it_is_pushed_and_dragged_with_balanced_forces(name):
    outline, hitch = BENT[name]
    slider = Slider(outline, hitch=hitch)
    assert not outline.contains(np.array(slider.centre_of_mass))
    model = QuasiStaticModel(slider, LAW)
    push = model.push(Pose(theta=0.4), SidePush(1, 0.6, 0.1, 0.06))
    drag = model.drag(push.end, ((0.0, 0.0),))
    for stroke in (push, drag):
        assert abs(stroke.turn) > 0.1
        assert check(model, stroke.trajectory).worst < 1e-6
        assert stroke.trajectory.residual < 1e-9


def test_an_object_tips_only_where_its_centre_of_mass_is_outside_the_convex_hull():
    """The hull as SciPy has it; random points and random outlines."""
    from scipy.spatial import Delaunay

    rng, notched = np.random.default_rng(3), 0
    for _ in range(30):
        outline, hitch = random_band(rng)
        hull = Delaunay(outline.array)
        for place in rng.uniform(-0.06, 0.06, (10, 2)):
            inside = bool(hull.find_simplex(place) >= 0)
            notched += inside and not outline.contains(place)
            assert outline.bears(tuple(place)) == inside
            if not inside:
                refused(
                    Slider, outline, hitch=hitch, centre_of_mass=tuple(place), told="convex hull"
                )
    assert notched > 30


@pytest.mark.parametrize("name", BENT)
def test_a_first_experiment_with_it_has_its_ring_inside(name):
    settings = first_settings(BENT[name][0], name)
    ring = np.array((settings["hitch_x_mm"], settings["hitch_y_mm"])) * 1e-3
    assert BENT[name][0].contains(ring)


def test_every_random_concave_object_is_pushed_wherever_the_rod_can_touch_it():
    rng, outside = np.random.default_rng(11), 0
    for number in range(20):
        outline, hitch = random_band(rng)
        model = QuasiStaticModel(Slider(outline, hitch=hitch), LAW, accuracy=1e-6)
        outside += not outline.contains(np.array(outline.centroid))
        push, done = reachable_push(model, rng)
        assert done.trajectory.residual < 1e-9, push
        if number % 10 == 0:
            assert check(model, done.trajectory).surface < 1e-9
    assert outside > 10
