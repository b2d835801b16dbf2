"""Derivatives of whole cycles are their differences, by every parameter, on every footprint,
through every contact.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from force_balance import story
from random_cases import random_case

import cyclemap as cm
from cyclemap.mechanics import (
    DragBack,
    Ellipse,
    EllipseFriction,
    Material,
    PatchFootprint,
    Polygon,
    PressedFootprint,
    Pusher,
    SidePush,
    Slider,
    SurfaceShape,
    corner_footprint,
    grid_footprint,
)
from cyclemap.mechanics.cycle_batch import CYCLE_OUTPUTS, CycleSlopes, run_batch
from cyclemap.mechanics.engine.schema import PARAMETERS, SHAPES

LAW = ("mu_a", "mu_b", "m0", "n0", "phi")
SHARES = ("inner_share", "rim_share", "corner_share")
LENGTHS = ("pusher_radius", "distance", "hitch_x", "hitch_y", "pin_friction_radius")
LEGS = ((0.05, 0.03), (-0.02, 0.06))


def loop_of(
    shape,
    *shares,
    lean=0.0,
    rod=(0.00475, 0.15),
    push=None,
    reset=None,
    footprint=None,
    surface="plywood",
):
    """A loop of an object whose weight rests in parts, its centre off the centroid by a share of
    the extent.
    """
    slider = Slider.mit(shape) if isinstance(shape, str) else Slider(shape, hitch=(0.005, 0.008))
    outline = slider.outline
    x, y = np.array(outline.centroid) + lean * outline.extent * np.array((0.8, -0.6))
    return cm.CollectionLoop.mit(
        surface,
        slider=slider,
        footprint=footprint or PatchFootprint(outline, *shares, centre=(x, y)),
        pusher=Pusher(*rod),
        push=push or SidePush(distance=0.05),
        reset=reset or DragBack(),
        accuracy=1e-10,
    )


SQUARE, OVAL = Slider.mit("rect1").outline, Ellipse(0.05, 0.035)
L_SHAPE = Polygon(
    ((0.05, 0.05), (-0.05, 0.05), (-0.05, -0.05), (0.0, -0.05), (0.0, 0.0), (0.05, 0.0))
)
ROUND = SidePush(0, 0.2, 0.1, 0.06)
STRONG = Material("strong", EllipseFriction(0.35, 0.2, 0.05, -0.03, 0.7))
# name: loop, orientation, modes and kinds of contact that it goes through.
LOOPS = {
    "square": (
        loop_of(SQUARE, 0.2, 0.15, 0.1, reset=DragBack(((0.03, 0.05),), 0.001), push=SidePush()),
        0.7,
        {},
    ),
    "triangle": (loop_of("tri1", 0.1, 0.2, 0.1, push=SidePush(1, 0.4, 0.2, 0.08)), 0.7, {}),
    "L shape": (loop_of(L_SHAPE, push=SidePush(0, 0.4, 0.1, 0.05)), 0.7, {}),
    "ellipse": (loop_of(OVAL, 0.2, 0.2, push=ROUND), 0.7, {"ellipse"}),
    "leaning ellipse": (loop_of(OVAL, 0.2, 0.2, lean=0.03, push=ROUND), 0.7, {"ellipse"}),
    "corners": (loop_of("rect1", footprint=corner_footprint(SQUARE)), 0.7, {}),
    "point rod": (loop_of("rect1", rod=(0.0, 0.15)), 0.7, {}),
    "leaving": (
        loop_of("rect1", 0.1, 0.1, 0.1, push=SidePush(distance=0.2)),
        0.4,
        {"left", "slide_right"},
    ),
    "around a corner": (
        loop_of("rect3", 0.1, 0.3, 0.1, rod=(0.03, 0.1), push=SidePush(1, 0.98, 0.9, 0.15)),
        2.0,
        {"slide_right", "corner"},
    ),
    "a point that rests at a corner": (
        loop_of("rect1", 0.1, 0.1, 0.1, rod=(0.0, 1.0), push=SidePush(1, 0.0, 0.75, 0.3)),
        2.0,
        {"left", "stick"},
    ),
    "legs in a ring that holds": (
        loop_of("rect1", 0.1, 0.2, 0.1, reset=DragBack(LEGS, 0.003)),
        0.5,
        {"ring_left", "ring_right", "ring_stuck"},
    ),
    "an ellipse that is left": (
        loop_of("ellip3", rod=(0.00475, 0.1), push=SidePush(0, 0.13, 0.8, 0.15), surface=STRONG),
        0.7,
        {"left"},
    ),
    "a frictionless rod": (
        loop_of("rect2", rod=(0.00475, 0.0), push=SidePush(3, 0.4, 0.2, 0.06), surface=STRONG),
        0.4,
        {"slide_free"},
    ),
}
for name, outline in {"square": SQUARE, "oval": OVAL, "L shape": L_SHAPE}.items():
    shapes = SurfaceShape.of_bend(1.0, -2.0, 0.5), SurfaceShape.of_bend(2.0, 3.0, -4.0)
    pressed = PressedFootprint(outline, *shapes)
    bent = loop_of(outline, footprint=pressed, push=SidePush(0, 0.4, 0.1, 0.05), surface=STRONG)
    LOOPS[f"{name} on a floor with a shape"] = (bent, 2.1, {})
# What has all parameters.
SOLID = {"square", "triangle", "L shape", "point rod", "leaving", "around a corner"}
SOLID |= {"a frictionless rod"}


def changed(loop, name, amount):
    """The loop with one parameter moved."""
    if name in LAW:
        law = loop.material.friction
        return replace(
            loop, material=Material("moved", replace(law, **{name: getattr(law, name) + amount}))
        )
    if name in SHARES:
        return replace(
            loop,
            footprint=replace(loop.footprint, **{name: getattr(loop.footprint, name) + amount}),
        )
    if name in SHAPES:
        part, _, field = name.partition("_")
        bend = dict(
            zip(("dome", "bow_x", "bow_y"), getattr(loop.footprint, part).bend, strict=True)
        )
        shape = SurfaceShape.of_bend(**bend | {field: bend[field] + amount})
        return replace(loop, footprint=replace(loop.footprint, **{part: shape}))
    if name in ("hitch_x", "hitch_y"):
        x, y = loop.slider.hitch
        ring = (x + amount, y) if name == "hitch_x" else (x, y + amount)
        return replace(loop, slider=replace(loop.slider, hitch=ring))
    part, field = ("reset", name) if name.startswith("pin") else ("push", name)
    if name.startswith("pusher_"):
        part, field = "pusher", name.removeprefix("pusher_")
    whole = getattr(loop, part)
    return replace(loop, **{part: replace(whole, **{field: getattr(whole, field) + amount})})


def outputs(loop, theta):
    cycle = loop.cycle(theta)
    return np.array(
        (
            cycle.push_turn,
            *cycle.push_displacement,
            cycle.drag_turn,
            cycle.drag_length,
            cycle.theta_next,
        )
    )


def differenced(loop, theta, name):
    """Richardson's central difference of a cycle's outputs; one-sided where a value is zero, its
    least.
    """
    step = 2e-6 if name in LENGTHS else 2e-5
    least = {name: getattr(loop.footprint, name, None) for name in SHARES}
    least |= {
        "pin_friction_radius": loop.reset.pin_friction_radius,
        "pusher_radius": loop.pusher.radius,
    }

    def at(amount):
        return (
            outputs(loop, theta + amount)
            if name == "theta"
            else outputs(changed(loop, name, amount), theta)
        )

    if least.get(name) == 0.0:
        return (4.0 * at(step) - 3.0 * at(0.0) - at(2.0 * step)) / (2.0 * step)
    return (8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step)


def assert_differences(loop, theta):
    """Of all columns that are no nan; returns their names."""
    found, checked = loop.sensitivity(theta), []
    assert (
        found.parameters == PARAMETERS and found.outputs == CYCLE_OUTPUTS and len(PARAMETERS) == 23
    )
    for name, column in zip(PARAMETERS, found.jacobian.T, strict=True):
        # Stick and slip part at zero friction: there is no derivative.
        if np.isnan(column).all() or (name == "pusher_friction" and loop.pusher.friction == 0.0):
            continue
        wanted = differenced(loop, theta, name)
        assert np.abs(column - wanted).max() < 1e-4 * max(1.0, np.abs(wanted).max()), name
        checked.append(name)
    return checked


@pytest.mark.slow
@pytest.mark.parametrize("name", LOOPS)
def test_a_cycles_derivatives_by_all_parameters_are_its_differences(name):
    loop, theta, seen = LOOPS[name]
    cycle = loop.cycle(theta)
    told = {word for stroke in (cycle.push, cycle.drag) for pair in story(stroke) for word in pair}
    assert set(seen) <= told | {cycle.push.ended}
    assert len(assert_differences(loop, theta)) >= 12
    given = ~np.isnan(loop.sensitivity(theta).jacobian).all(axis=0)
    lacking = {name for name, has in zip(PARAMETERS, given.tolist(), strict=True) if not has}
    assert ("floor" in name) == (not lacking & {*SHAPES})
    of_corner = {"pusher_radius", "fraction"} if "rests" in name else set()
    assert lacking <= {*SHARES, *SHAPES, *of_corner} and (name in SOLID) <= (
        not lacking - {*SHAPES}
    )


NOTCH = Polygon(((-0.05, -0.04), (0.05, -0.04), (0.05, 0.04), (0.012, 0.005), (-0.05, 0.03)))
OF_SLOT = ((0.004, 0.03), (0.004, 0.0), (-0.004, 0.0), (-0.004, 0.03))
SLOT = Polygon(((-0.05, -0.04), (0.05, -0.04), (0.05, 0.03), *OF_SLOT, (-0.05, 0.03)))
DOZEN = Polygon(
    tuple(
        (0.05 * math.cos(k * math.pi / 6.0), 0.04 * math.sin(k * math.pi / 6.0)) for k in range(12)
    )
)
# Thin rods and points around and into corners, whose place moves with the radius: outline, rod,
# push, orientation, last mode, why the push ends.
CORNERS = (
    (NOTCH, (0.002, 0.15), SidePush(3, 0.231, 0.912, 0.1), 0.8, "slide_right", "distance"),
    (NOTCH, (0.002, 0.3), SidePush(2, 0.754, -1.048, 0.1), 1.7, "wedge_right", "distance"),
    (SLOT, (0.00475, 0.05), SidePush(2, 0.99, -0.4, 0.08), 0.5, "slide_left", "distance"),
    (NOTCH, (0.00475, 0.45), SidePush(2, 0.93, -0.4636, 0.08), 0.2, "slide_right", "distance"),
    (SQUARE, (0.0, 0.15), SidePush(0, 0.915, -0.563, 0.0477), 2.133, "slide_left", "left"),
    (SLOT, (0.0, 0.15), SidePush(5, 0.817, 0.347, 0.112), 5.15, "slide_left", "left"),
    (SLOT, (0.0, 1.0), SidePush(4, 0.778, -0.981, 0.0743), 0.533, "wedge_right", "distance"),
    (L_SHAPE, (0.0, 0.15), SidePush(4, 0.07, 0.396, 0.0742), 4.205, "slide_left", "distance"),
    (NOTCH, (0.0, 0.6), SidePush(3, 0.176, 0.756, 0.147), 0.873, "slide_right", "distance"),
    (DOZEN, (0.0, 0.15), SidePush(3, 0.9, -0.7, 0.03), 2.0, "slide_left", "distance"),
)


@pytest.mark.parametrize("case", CORNERS)
def test_the_derivative_by_the_rods_radius_goes_on_around_and_into_corners(case):
    """Of points by one-sided differences, at any accuracy of the cycle that is differentiated."""
    outline, rod, push, theta, last, ended = case
    slider = Slider(outline, hitch=(-0.02, -0.02))
    loop = replace(loop_of(SQUARE, rod=rod, push=push), slider=slider, footprint=None)
    pushed = loop.cycle(theta).push
    modes = [mode for mode, _ in story(pushed)]
    assert (modes[-1], pushed.ended) == (last, ended)
    assert rod[0] == 0.0 or any(mode.startswith("wedge") for mode in modes)
    wanted = differenced(loop, theta, "pusher_radius")
    for accuracy in (1e-10,) if rod[0] else (1e-10, 1e-6):
        cycle = replace(loop, accuracy=accuracy)
        found = cycle.sensitivity(theta, ("pusher_radius",)).jacobian[:, 0]
        assert np.abs(found - wanted).max() < 1e-4 * max(1.0, np.abs(wanted).max())


def test_a_point_at_a_corner_has_no_derivative_by_its_radius_since_thin_rods_go_as_a_root():
    loop, theta, _ = LOOPS["a point that rests at a corner"]
    assert np.isnan(loop.sensitivity(theta, ("pusher_radius",)).jacobian).all()
    still = outputs(loop, theta)
    one, four = (
        outputs(replace(loop, pusher=Pusher(radius, 1.0)), theta) - still for radius in (1e-7, 4e-7)
    )
    assert np.abs(four / one - 2.0).max() < 0.25


@pytest.mark.slow
def test_random_cycles_have_the_derivatives_of_their_differences():
    for seed in (4, 16):
        case = random_case(seed)
        outline, model = case.model.slider.outline, case.model
        loop = loop_of(
            outline, 0.1, 0.1, 0.0 if isinstance(outline, Ellipse) else 0.1, push=case.push
        )
        loop = replace(loop, material=Material("drawn", model.friction), pusher=model.pusher)
        assert len(assert_differences(loop, case.pose.theta)) >= 14


def by_name(loop, theta, row="theta_next"):
    return dict(
        zip(
            PARAMETERS,
            loop.sensitivity(theta).jacobian[CYCLE_OUTPUTS.index(row)].tolist(),
            strict=True,
        )
    )


def test_an_object_that_its_ring_holds_turns_by_nothing_whatever_changes():
    loop = loop_of("rect1", reset=DragBack(LEGS, 0.06))
    assert set(loop.cycle(1.0).drag.trajectory.mode) == {"ring_stuck"}
    by = by_name(loop, 1.0, "drag_turn")
    assert all(abs(value) < 1e-15 for name, value in by.items() if name not in SHAPES)


def test_what_a_push_does_not_depend_on_is_zero_and_shares_that_cannot_be_are_nan():
    of_push = {*PARAMETERS[:11], *SHARES}
    for name, value in by_name(
        loop_of("rect1", footprint=grid_footprint(SQUARE, 4)), 0.0, "push_turn"
    ).items():
        lacks = name in SHARES or name in SHAPES
        assert math.isnan(value) if lacks else (value != 0.0) == (name in of_push), name
    assert math.isnan(by_name(loop_of("ellip2"), 0.0)["corner_share"])


def test_derivatives_in_a_batch_are_those_of_single_cycles_whatever_their_number():
    loops, theta = [loop for loop, _, _ in LOOPS.values()], np.array([[0.7, 2.0]] * len(LOOPS))
    every = run_batch(loops, theta, len(PARAMETERS))
    slopes, plain = run_batch(loops, theta, 1), run_batch(loops, theta)
    # By theta alone, and without derivatives, the engine runs shorter equations, whose rounding is
    # their own.
    np.testing.assert_allclose(
        slopes.jacobian[..., 0], every.jacobian[..., 0], rtol=1e-12, atol=1e-13
    )
    assert plain.jacobian.shape == (len(loops), 2, 6, 0)
    for number, loop in enumerate(loops):
        np.testing.assert_array_equal(every.jacobian[number, 0], loop.sensitivity(0.7).jacobian)
        assert plain.theta_next[number, 0] == loop.cycle(0.7).theta_next
    np.testing.assert_allclose(every.theta_next, plain.theta_next, rtol=0.0, atol=1e-14)


def test_pushes_kept_for_another_ring_leave_the_same_bits():
    """The ring has no part in a push: drags from kept ends are those of whole cycles,
    slopes too."""
    plain, theta = cm.CollectionLoop.mit("plywood"), np.linspace(-3.0, 9.0, 7)
    for hitch in ((-0.0106, 0.0106), (0.03, -0.02), (0.0, 0.0)):
        for reset in (DragBack(), DragBack(way_points=((0.05, 0.02),), pin_friction_radius=0.001)):
            loop = replace(plain, slider=replace(plain.slider, hitch=hitch), reset=reset)
            values, slopes = CycleSlopes(loop)(theta)
            whole = run_batch((loop,), theta[None], 1)
            np.testing.assert_array_equal(values, whole.theta_next[0])
            np.testing.assert_array_equal(slopes, whole.jacobian[0, :, -1, 0])
