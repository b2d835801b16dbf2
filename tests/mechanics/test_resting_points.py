"""Support points that come to rest: the object turns about them, or passes their rest, and no kink
is stepped over.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from force_balance import check
from random_cases import random_case

import cyclemap as cm
from cyclemap.mechanics import (
    DragBack,
    EllipseFriction,
    LimitSurface,
    PatchFootprint,
    PointFootprint,
    Pusher,
    QuasiStaticModel,
    SidePush,
    Slider,
    grid_footprint,
    load_material,
)
from cyclemap.mechanics.cycle_batch import CycleSlopes

SLIDER, PUSH = Slider.mit("rect1"), SidePush(0, 0.7)
PLYWOOD = load_material("plywood").friction
# Orientations from which a point comes to rest while the rod slides, sets out again, and passes its
# rest in the ring.
ORIENTATIONS = np.linspace(-math.pi, math.pi, 12, endpoint=False) + 0.15


def on_points(side, accuracy=1e-8, pusher=None):
    """MIT's square on side x side points, on plywood."""
    footprint = grid_footprint(SLIDER.outline, side)
    return QuasiStaticModel(SLIDER, PLYWOOD, pusher or Pusher(), footprint, accuracy)


def speeds_of(model, twists):
    """Speeds (n, points) of the support points, over the fastest one's, at twists (n, 3)."""
    x, y = np.array(model.pressure.positions).T
    v, omega = twists[:, :2, None], twists[:, 2:]
    moving = np.stack([v[:, 0] - omega * y, v[:, 1] + omega * x], axis=-1)
    return moving / np.linalg.norm(moving, axis=-1).max(axis=1)[:, None, None]


def resting_samples(model, push):
    """Samples of a push in which a support point rests, besides the sample before and after."""
    found = check(model, push.trajectory)
    # Where a contact changes, its margin is off by the root of the tolerance.
    assert found.worst < 1e-6
    speeds = np.linalg.norm(speeds_of(model, found.twists), axis=-1)
    rests = speeds.min(axis=1) < 1e-6
    return np.flatnonzero(rests[1:-1] & rests[:-2] & rests[2:]) + 1, found, speeds


@pytest.mark.slow
def test_an_object_turns_about_a_point_that_rests_by_least_dissipation():
    """Of all twists at which the rod's force has the same power none dissipates less; and the point
    stays the same.

    check() has the forces: that of the point at rest is any that its own friction ellipse holds.
    """
    model, rng, seen = on_points(4), np.random.default_rng(3), 0
    for theta in (0.8, 1.0):
        push = model.push(model.start_pose(theta), PUSH, longest_step=2e-3)
        samples, found, speeds = resting_samples(model, push)
        for i in samples:
            assert push.trajectory.mode[i].startswith("slide")
            assert speeds[i].argmin() in (speeds[i - 1].argmin(), speeds[i + 1].argmin())
            surface, twist, wrench = (
                LimitSurface(model.pressure, model.friction),
                found.twists[i],
                found.wrenches[i],
            )
            unit = np.array((1.0, 1.0, 1.0 / model.unit))
            aside = rng.normal(size=(200, 3)) * 10.0 ** rng.uniform(-4.0, 0.0, (200, 1)) * unit
            aside -= np.outer(aside @ wrench, wrench * unit**2) / (wrench * unit**2 @ wrench)
            at = push.trajectory.pose[i, 2]
            assert np.all(
                surface.dissipation(twist + aside, at) >= surface.dissipation(twist, at) - 1e-9
            )
            seen += 1
    assert seen >= 6


def landings(model, theta):
    """Orientations at samples of a drag at which some point lies beside the ring, straight across
    the rod's way.

    Only there a point may rest: its velocity has no part along the way left for the spin to take
    away.
    """
    drag = model.cycle(theta, PUSH, DragBack())[1].trajectory
    way = drag.pusher[-1] - drag.pusher[0]
    angle = math.atan2(way[1], way[0]) - drag.pose[:, 2]
    ahead = np.column_stack([np.cos(angle), np.sin(angle)])
    across = ahead @ (np.array(model.pressure.positions) - model.slider.hitch).T / model.unit
    return drag.pose[np.abs(across).min(axis=1) < 1e-5, 2]


def test_steps_end_on_kinks_whatever_the_accuracy():
    """A drag asked for a hundred thousand times as exact passes the same rests of points, and ends
    steps there.
    """
    seen = 0
    for theta in ORIENTATIONS:
        coarse, fine = (landings(on_points(8, accuracy), theta) for accuracy in (1e-6, 1e-11))
        assert all(np.abs(coarse - rest).min() < 1e-4 for rest in fine)
        seen += len(fine)
    assert seen >= 5


def test_points_take_about_as_many_steps_as_a_patch():
    """Kinks cost two steps each, not a ladder of shorter and shorter ones."""
    patch = QuasiStaticModel(SLIDER, PLYWOOD, Pusher())
    counts = [
        sum(
            len(stroke.trajectory.path)
            for theta in ORIENTATIONS
            for stroke in model.cycle(theta, PUSH, DragBack())
        )
        for model in (patch, on_points(8), on_points(4))
    ]
    assert max(counts[1:]) < 1.3 * counts[0]


@pytest.mark.parametrize("law", [PLYWOOD, EllipseFriction(0.3, 0.2, 0.05, 0.02, 0.4)])
@pytest.mark.parametrize(
    "footprint",
    [
        *(grid_footprint(SLIDER.outline, side) for side in (2, 4, 8)),
        *(PatchFootprint(SLIDER.outline, corner_share=share) for share in (0.2, 0.6, 1.0)),
    ],
)
def test_cycles_on_points_and_corners_that_carry_a_load_keep_their_accuracy(footprint, law):
    """What a patch puts on its corners has the kinks of points."""
    surface = cm.Material("points", law)
    loops = [
        cm.CollectionLoop.mit(surface, footprint=footprint, accuracy=accuracy)
        for accuracy in (1e-11, 1e-8, 1e-6)
    ]
    fine, close, coarse = (loop.cycles(ORIENTATIONS) for loop in loops)
    for cycles, most in ((close, 1e-8), (coarse, 1e-6)):
        off = cycles.push_turn + cycles.drag_turn - fine.push_turn - fine.drag_turn
        assert np.abs(off).max() < most


def test_slopes_of_cycles_on_points_are_their_differences():
    """Rates go on without a jump where a point comes to rest, passes it or sets out, and so do
    derivatives.
    """
    loop = cm.CollectionLoop.mit(
        "plywood", footprint=grid_footprint(SLIDER.outline, 8), accuracy=1e-10
    )
    apart = 1e-5
    sides = [loop.cycles(ORIENTATIONS + sign * apart).theta_next for sign in (-1.0, 1.0)]
    slopes = CycleSlopes(loop)(ORIENTATIONS)[1]
    np.testing.assert_allclose(slopes, (sides[1] - sides[0]) / (2.0 * apart), atol=2e-5)


def test_slopes_go_on_where_a_watched_corner_is_lost_in_the_middle_of_a_step():
    """A drag whose ring rubs: of the corner's unknowns there the plain ones have to serve (each
    angle met one).
    """
    loop = cm.CollectionLoop.mit("pu", accuracy=1e-5)
    slider = replace(loop.slider, hitch=(-0.025, 0.005))
    footprint = PatchFootprint(slider.outline, corner_share=0.4)
    loop = replace(
        loop, slider=slider, footprint=footprint, reset=DragBack(pin_friction_radius=0.002)
    )
    theta, apart = np.array((-2.168, -2.164, -1.414, -1.412, -1.408, 1.502)), 1e-5
    slopes, fine = CycleSlopes(loop)(theta)[1], replace(loop, accuracy=1e-10)
    sides = [fine.cycles(theta + sign * apart).theta_next for sign in (-1.0, 1.0)]
    np.testing.assert_allclose(slopes, (sides[1] - sides[0]) / (2.0 * apart), atol=1e-3)


def heavy_point(seed):
    """A random push over random points, one of which carries half of the load."""
    case, rng = random_case(seed), np.random.default_rng([seed, 3])
    places = rng.uniform(-0.03, 0.03, (int(rng.integers(4, 12)), 2))
    weights = np.append(rng.uniform(0.1, 1.0, len(places) - 1), 3.0)
    footprint = PointFootprint(tuple(map(tuple, places)), tuple(weights))
    return replace(case, model=replace(case.model, footprint=footprint, accuracy=1e-8))


@pytest.mark.slow
def test_heavy_points_hold_the_object_as_independent_balances_say():
    """Forces and twists of check(), which knows nothing of the engine's events; accuracy against a
    finer run.
    """
    held = 0
    for seed in range(6):
        case = heavy_point(seed)
        push = case.model.push(case.pose, case.push, longest_step=5e-3)
        held += len(resting_samples(case.model, push)[0])
        fine = replace(case.model, accuracy=1e-11).push(case.pose, case.push)
        assert abs(push.turn - fine.turn) < 1e-8
    assert held >= 2
