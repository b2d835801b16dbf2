"""Whole pushes by the engine and by an independent solver of all modes; a rod that touches two
places of an outline.
"""

import numpy as np
import pytest
from force_balance import check, story
from two_contact_reference import Contact, Instant, modes_of_both, unit

from cyclemap.mechanics import (
    EllipseFriction,
    LimitSurface,
    PatchFootprint,
    Polygon,
    Pose,
    Pusher,
    QuasiStaticModel,
    SidePush,
    Slider,
)
from cyclemap.mechanics.engine.schema import KINDS, MODES, PIECE, RECORD

PLYWOOD, ISOTROPIC = (0.2545, 0.2346, 0.0325, 0.0082, 2.6175), (0.25, 0.25, 0.0, 0.0, 0.0)
NOTCH = ((-0.05, -0.04), (0.05, -0.04), (0.05, 0.03), (0.0, 0.005), (-0.05, 0.03))
SKEW = ((-0.05, -0.04), (0.05, -0.04), (0.05, 0.04), (0.012, 0.005), (-0.05, 0.03))
SLOT = (*NOTCH[:3], (0.004, 0.03), (0.004, 0.0), (-0.004, 0.0), (-0.004, 0.03), (-0.05, 0.03))

# Whole pushes of plates at the origin under even pressure: plate, surface, rod's radius and
# friction, then side, fraction, orientation (rad), angle (rad), distance as of SidePush; where the
# plate ends (x, y, theta), to 1e-10 m and 1e-9 rad as steps of accuracy 1e-10 and 1e-12 agree, and
# the modes on the way.
PUSHES = (
    (
        (SKEW, ISOTROPIC, 0.002, 0.15, 3, 0.231, 0.8, 0.912, 0.1),
        (0.0521195004040, -0.0309833293934, -0.280234802335),
        ("slide_right", "wedge_right", "slide_right"),
    ),
    (
        (NOTCH, PLYWOOD, 0.00475, 0.15, 3, 0.476, -1.5, 1.217, 0.1),
        (-0.0542007813700, -0.0293443067396, -2.200358490187),
        ("slide_right", "wedge_right", "slide_right"),
    ),
    (
        (SKEW, PLYWOOD, 0.002, 0.3, 2, 0.754, 1.7, -1.048, 0.1),
        (0.0738043741424, -0.0111636259122, 0.457666467312),
        ("slide_left", "stick", "slide_right", "wedge_right"),
    ),
    (
        (NOTCH, PLYWOOD, 0.0, 0.05, 3, 0.476, 2.6, 0.84, 0.1),
        (0.0316036221351, 0.0755721868805, 2.410184947658),
        ("slide_right", "wedge_right", "slide_right"),
    ),
    (
        (SLOT, PLYWOOD, 0.00475, 0.05, 2, 0.99, 0.5, -0.4, 0.08),
        (0.0269667597703, -0.0544214362237, 1.339427671083),
        ("slide_left", "slide_left", "wedge_left", "slide_left"),
    ),
    (
        (NOTCH, PLYWOOD, 0.00475, 0.3, 2, 0.93, 0.2, -0.4636, 0.08),
        (0.0167099740270, -0.0775298325311, 0.160665802096),
        ("slide_left", "wedge_stuck"),
    ),
)


def model_of(push):
    slider = Slider(Polygon(push[0]), hitch=(0.0, -0.03))
    return QuasiStaticModel(slider, EllipseFriction(*push[1]), Pusher(*push[2:4]), accuracy=1e-10)


def pushed(push):
    """By the engine."""
    side, fraction, theta, angle, distance = push[4:]
    return model_of(push).push(Pose(theta=theta), SidePush(side, fraction, angle, distance))


# What the engine calls modes that the solver tells by the contacts that they keep.
NAMES = {
    "turn+": "wedge_left",
    "turn-": "wedge_right",
    "wedged": "wedge_stuck",
    "pivot": "wedge_right",
}


@pytest.mark.parametrize("case", PUSHES)
def test_the_engine_ends_whole_pushes_where_an_independent_solver_did_by_the_same_modes(case):
    push, pose, modes = case
    found = pushed(push)
    assert np.allclose((found.end.x, found.end.y, found.end.theta), pose, rtol=0.0, atol=2e-9)
    assert found.ended == "distance"
    assert tuple(mode for mode, _ in story(found)) == modes


@pytest.mark.slow
@pytest.mark.parametrize("case", PUSHES)
def test_along_whole_pushes_the_independent_solver_finds_the_engines_modes_and_forces_in_wedges(
    case,
):
    """From the place alone; where the rod touches one place, the forces balance what moves the
    contact as it asks.
    """
    (vertices, law, radius, mu, *_), _, modes = case
    push, seen = pushed(case[0]), set()
    course, wrench = (
        push.course,
        LimitSurface(PatchFootprint(Polygon(vertices)), EllipseFriction(*law)).wrench,
    )
    model = model_of(case[0])
    assert check(model, push.trajectory).worst < 1e-6
    for row in course.rows[:: max(1, len(course.rows) // 25)]:
        told = RECORD.of(row)
        name = MODES[int(told.mode)].name
        seen.add(name)
        if not name.startswith("wedge"):
            continue
        at = KINDS["wedge"].of(PIECE.of(course.strokes.pieces[int(told.piece)]).geometry)
        ahead, rod = unit(course.strokes.direction - told.theta), np.array((at.x, at.y))
        instant = Instant(wrench, told.theta, ahead, radius, mu, course.unit)
        places = [
            Contact(tuple(course.unit * rod - radius * unit(angle)), angle)
            for angle in (at.first_normal, at.second_normal)
        ]
        # Where a mode ends a margin is zero.
        held = [mode for mode in modes_of_both(instant, places) if mode.margins.min() > -1e-6]
        (mode,) = {mode.name: mode for mode in held if NAMES[mode.name] == name}.values()
        if name != "wedge_stuck":
            forces = course.scale * np.array((told.compression, told.tangential))
            assert np.allclose(forces, [force for force, _ in mode.forces], rtol=0.0, atol=1e-8)
            own = [
                along * contact.tangent - press * contact.normal
                for (press, along), contact in zip(mode.forces, places, strict=True)
            ]
            turn = np.column_stack([unit(told.theta), unit(told.theta + np.pi / 2.0)])
            force = course.scale * np.array(told.force)
            assert np.allclose(force, turn @ np.sum(own, axis=0), rtol=0.0, atol=1e-8)
    assert seen == set(modes)


def notched(opening, aside):
    """A plate whose notch opens by an angle (rad), its bottom aside (m) from the plate's middle."""
    half = 0.03 * np.tan(opening / 2.0)
    bottom = ((aside + half, 0.03), (aside, 0.0), (aside - half, 0.03))
    return Polygon(((-0.05, -0.04), (0.05, -0.04), (0.05, 0.03), *bottom, (-0.05, 0.03)))


# Pushes into notches that lock themselves at a rod's friction of .6, and swing the plate around
# until the rod pulls: opening (deg), place aside (m), side, orientation (rad), angle (rad).
SWINGING = (
    (47.906, 0.0091, 4, -1.953, 0.892),
    (56.183, -0.0093, 3, -0.2405, -0.3316),
    (57.226, -0.0067, 4, -0.9118, 1.1339),
    (56.542, 0.0037, 3, 0.0354, -1.0286),
)


@pytest.mark.parametrize("case", SWINGING)
def test_a_point_is_the_limit_of_thin_rods_in_a_notch_that_locks_itself(case):
    """It slides out where they do; the turn is off by a few of the rod's radii (extents)."""
    opening, aside, side, theta, angle = case
    slider = Slider(notched(np.radians(opening), aside), hitch=(0.0, -0.03))
    push = SidePush(side, 0.999 if side == 3 else 0.001, angle, 0.3)
    runs = [
        QuasiStaticModel(slider, EllipseFriction(*PLYWOOD), Pusher(radius, 0.6)).push(
            Pose(theta=theta), push
        )
        for radius in (0.0, 1e-7, 1e-6)
    ]
    assert all(any(mode.startswith("wedge") for mode, _ in story(run)) for run in runs)
    assert story(runs[0])[-1][0].startswith("slide")
    off = np.array([abs(run.turn - runs[0].turn) for run in runs[1:]])
    # Radii of 1.5e-6 and 1.5e-5 extents.
    assert (off < [3e-5, 3e-4]).all()


def test_a_push_says_where_another_motion_would_have_been_possible():
    """In a notch that locks itself the wedge holds beside the motion that is taken; in an open one
    nothing does.
    """
    for opening, expected in ((50.0, True), (70.0, False)):
        for radius in (0.0, 0.002):
            slider = Slider(notched(np.radians(opening), 0.0), hitch=(0.0, -0.03))
            model = QuasiStaticModel(slider, EllipseFriction(*PLYWOOD), Pusher(radius, 0.6))
            push = model.push(Pose(theta=1.0), SidePush(4, 0.35, 1.0, 0.08))
            assert "wedge_right" in push.trajectory.mode or "wedge_left" in push.trajectory.mode
            assert push.is_ambiguous == expected
    assert not model.push(Pose(), SidePush(0, 0.5, 0.0, 0.02)).is_ambiguous
