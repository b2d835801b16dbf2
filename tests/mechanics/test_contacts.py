"""Where the rod touches: from the world, in contact, around corners, off the object; thin rods,
small feet.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from force_balance import check, story
from random_cases import random_case
from refusals import refused

from cyclemap.errors import UnsupportedContact
from cyclemap.mechanics import (
    Ellipse,
    EllipseFriction,
    PointFootprint,
    Pose,
    Pusher,
    QuasiStaticModel,
    SidePush,
    Slider,
    WorldPush,
    grid_footprint,
    load_material,
)

PLYWOOD, RECT = load_material("plywood").friction, Slider.mit("rect1")
ISOTROPIC = EllipseFriction.isotropic(0.25)


def direction_of(push):
    """Unit vector along the rod's way."""
    path = push.trajectory.pusher
    return (path[-1] - path[0]) / np.hypot(*(path[-1] - path[0]))


def test_a_push_from_the_world_equals_the_one_that_starts_in_contact():
    compared = 0
    for seed in range(15):
        case = random_case(seed, accuracy=1e-8)
        side = case.model.push(case.pose, case.push)
        towards, place = direction_of(side), side.trajectory.pusher[0]
        direction = math.atan2(towards[1], towards[0])
        for away in (0.0, 0.03):
            start = tuple(place - away * towards)
            world = case.model.push(
                case.pose, WorldPush(start, direction, case.push.distance + away)
            )
            if np.hypot(*(world.trajectory.pusher[0] - place)) > 1e-6:
                continue  # From that far back another side is in the way.
            assert world.ended == side.ended
            assert abs(world.turn - side.turn) < 1e-7
            assert np.abs(world.displacement - side.displacement).max() < 1e-8
            compared += 1
    assert compared > 20


def test_a_rod_goes_around_a_corner_and_leaves_where_it_no_longer_approaches():
    push = QuasiStaticModel(RECT, PLYWOOD).push(Pose(), SidePush())
    assert story(push) == [
        ("slide_right", "side"),
        ("stick", "side"),
        ("slide_left", "side"),
        ("slide_left", "corner"),
    ]
    assert push.ended == "left"
    assert push.travel < 0.15
    outward = push.trajectory.pusher[-1] - push.trajectory.contact_point[-1]
    assert abs(outward @ direction_of(push)) / 0.00475 < 1e-5


def test_a_disc_pushed_off_centre_without_friction_translates():
    """A frictionless rod presses through a disc's centre, where isotropic friction answers without
    a torque.
    """
    disc = Slider(Ellipse(0.05, 0.05), hitch=(0.01, 0.0))
    push = QuasiStaticModel(disc, ISOTROPIC, Pusher(0.005, 0.0)).push(
        Pose(), SidePush(0, 0.2, 0.3, 0.05)
    )
    assert abs(push.turn) < 1e-12
    assert np.hypot(*push.displacement) > 0.03
    assert {mode for mode, _ in story(push)} == {"slide_free"}


def test_a_point_that_slides_off_a_corner_leaves_there_with_no_more_than_the_sides_force():
    model = QuasiStaticModel(RECT, ISOTROPIC, Pusher(0.0, 0.15), accuracy=1e-9)
    push = model.push(Pose(), SidePush(0, 0.02, math.radians(40.0)))
    assert push.ended == "left"
    assert {kind for _, kind in story(push)} == {"side"}
    x, y = push.trajectory.contact_point[-1] - push.trajectory.pose[-1, :2]
    c, s = math.cos(push.end.theta), math.sin(push.end.theta)
    assert np.allclose((c * x + s * y, -s * x + c * y), (0.045, 0.045), atol=1e-9)
    assert check(model, push.trajectory).surface < 1e-10


def test_pushes_that_do_not_touch_or_start_inside_and_a_tripod_of_a_micrometre_are_refused():
    for push, told in (
        (SidePush(side=4), "sides 0 to 3"),
        (WorldPush((0.0, 0.2), math.pi / 2, 0.3), "never touches"),
        (WorldPush((0.2, 0.2), -math.pi / 2, 0.3), "never touches"),
        (WorldPush((0.0, 0.2), -math.pi / 2, 0.1), "short of the object"),
        (WorldPush((0.01, 0.02), 0.0, 0.1), "inside the object"),
        (WorldPush((0.01, 0.047), 0.0, 0.1), "inside the object"),
    ):
        refused(QuasiStaticModel(RECT, PLYWOOD).push, Pose(), push, told=told)
    refused(QuasiStaticModel, RECT, PLYWOOD, footprint=tripod(1e-6), told="tip rather than slide")


def test_a_push_that_no_slip_balances_is_refused():
    """However fast the rod slips, the force of this strongly one-sided friction of two points stays
    inside its cone.
    """
    slider, law = (
        Slider.mit("tri1"),
        EllipseFriction(0.184621216, 0.118933260, -0.023441769, -0.111881219, 0.218223227),
    )
    feet = PointFootprint(
        ((-0.030424356, 0.039849053), (-0.013999353, -0.003751398)), (0.776174908, 0.223825092)
    )
    model = QuasiStaticModel(slider, law, Pusher(friction=1.07286), feet)
    push, told = (
        (Pose(theta=-1.65369732), SidePush(2, 0.100212143, -0.116887542, 0.125242)),
        r"no slip of the rod.* a lower",
    )
    refused(model.push, *push, told=told, kind=UnsupportedContact)
    assert replace(model, pusher=Pusher(friction=0.5)).push(*push).travel > 0.0


def test_a_rod_leaves_a_disc_as_the_point_at_its_centre_comes_to_rest():
    """The centre's velocity lies along the rod's way exactly as long as the rod comes nearer: both
    end at once.
    """
    slider = Slider(Ellipse(0.0217, 0.0217), mass=0.9)
    law = EllipseFriction(0.2442, 0.6212, -0.0650, -0.4432, 4.1806)
    model = QuasiStaticModel(slider, law, Pusher(0.002, 1.2), grid_footprint(slider.outline, 3))
    push = model.push(Pose(theta=4.86), SidePush(0, 0.15385, -0.907, 0.1))
    assert push.ended == "left" and set(push.trajectory.mode) == {"stick"}
    toward = push.trajectory.pusher[-1] - push.trajectory.pusher[0]
    outward = push.trajectory.pusher[-1] - push.trajectory.contact_point[-1]
    assert abs(toward @ outward) < 1e-8 * np.hypot(*toward) * np.hypot(*outward)


def from_a_corner(radius, accuracy):
    """A push that starts at a corner, where a rod sticks for a tenth of its radius."""
    law = EllipseFriction(
        0.30861728598, 0.25904648895, -0.02573658839, 0.05206305240, math.radians(-50.646232833)
    )
    model = QuasiStaticModel(RECT, law, Pusher(radius, 1.0), accuracy=accuracy)
    return model.push(
        Pose(theta=0.5130809722898073), SidePush(1, 0.0, math.radians(43.96024077736354), 0.8)
    )


@pytest.mark.parametrize("radius", [1e-4, 1e-5, 1e-6])
def test_a_thin_rod_that_starts_at_a_corner_keeps_its_accuracy(radius):
    """The end of the corner is found as exactly as the corner is small."""
    fine, coarse = (from_a_corner(radius, accuracy) for accuracy in (1e-11, 1e-8))
    assert fine.ended == coarse.ended == "left" and abs(fine.turn - coarse.turn) < 1e-8
    assert np.abs(np.subtract((fine.end.x, fine.end.y), (coarse.end.x, coarse.end.y))).max() < 5e-10


def test_a_point_that_starts_at_a_corner_leaves_where_thinner_and_thinner_rods_do():
    """It rests until the force comes to the cone's edge; a rod that starts from rest takes a root
    of its radius.
    """
    exact = from_a_corner(0.0, 1e-11).turn
    assert max(abs(from_a_corner(0.0, accuracy).turn - exact) for accuracy in (1e-8, 1e-4)) < 1e-9
    thin, thick = (abs(from_a_corner(radius, 1e-11).turn - exact) for radius in (1e-9, 1e-8))
    assert 0.0 < thin < 2e-5 and 3.0 < thick / thin < 3.5


@pytest.mark.slow
@pytest.mark.parametrize("reach", [0.01, 0.001, 1e-4])
def test_a_tripod_narrower_than_the_rod_turns_about_its_feet(reach):
    """The narrower it stands, the nearer the push comes to turning the side along the rod: a
    quarter turn.
    """
    model = QuasiStaticModel(RECT, PLYWOOD, footprint=tripod(reach))
    push = model.push(Pose(theta=0.3), SidePush())
    assert push.ended == "left" and abs(push.turn - math.pi / 2.0) < 5.0 * reach
    assert reach != 0.001 or check(model, push.trajectory).surface < 1e-8


def tripod(reach):
    angles = np.array((0.0, 2.1, 4.2))
    return PointFootprint(
        tuple(map(tuple, reach * np.stack([np.cos(angles), np.sin(angles)], axis=-1))), (1, 1, 1)
    )
