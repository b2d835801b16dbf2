"""Derivatives of pushes, drags and whole cycles are their differences, by every parameter and for every footprint."""

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
    Material,
    PatchFootprint,
    PointFootprint,
    Polygon,
    Pose,
    Pusher,
    QuasiStaticModel,
    SidePush,
    Slider,
    WorldPush,
    corner_footprint,
    grid_footprint,
    load_material,
)
from cyclemap.mechanics.cycle_batch import CYCLE_OUTPUTS, CycleSlopes, derivative_units, run_batch
from cyclemap.mechanics.engine.strokes import PARAMETERS
from cyclemap.mechanics.quasi_static import run_strokes

PLYWOOD, RECT = load_material("plywood").friction, Slider.mit("rect1")
LAW = ("mu_a", "mu_b", "m0", "n0", "phi")
SHARES = ("inner_share", "rim_share", "corner_share")
LENGTHS = ("pusher_radius", "distance", "hitch_x", "hitch_y", "pin_friction_radius")
LEGS = ((0.05, 0.03), (-0.02, 0.06), (0.0, 0.0))
# What a stroke from a given pose along a given path depends on.
OF_STROKES = (*LAW, "pusher_friction", "hitch_x", "hitch_y", *SHARES, "pin_friction_radius")


def parts(shape, *shares, lean=0.0):
    """A slider, and its pressure in parts, its centre off the centroid by a share of the extent."""
    slider = Slider.mit(shape)
    x, y = slider.outline.centroid
    centre = (x + 0.8 * lean * slider.outline.extent, y - 0.6 * lean * slider.outline.extent)
    return slider, PatchFootprint(slider.outline, *shares, centre=centre)


def model_of(shape="rect1", *shares, lean=0.0, friction=0.15, radius=0.00475, footprint=None):
    slider, patch = parts(shape, *shares, lean=lean)
    return QuasiStaticModel(slider, PLYWOOD, Pusher(radius, friction), footprint or patch, 1e-10)


def changed_model(model, name, amount):
    """The model with one parameter moved."""
    if name in LAW:
        return replace(model, friction=replace(model.friction, **{name: getattr(model.friction, name) + amount}))
    if name in ("pusher_friction", "pusher_radius"):
        field = name.removeprefix("pusher_")
        return replace(model, pusher=replace(model.pusher, **{field: getattr(model.pusher, field) + amount}))
    if name in SHARES:
        share = getattr(model.pressure, name) + amount
        return replace(model, footprint=replace(model.pressure, **{name: share}))
    if name in ("hitch_x", "hitch_y"):
        x, y = model.slider.hitch
        ring = (x + amount, y) if name == "hitch_x" else (x, y + amount)
        return replace(model, slider=replace(model.slider, hitch=ring))
    return model


def differenced(outcome, name):
    """Richardson's central difference."""
    step = 2e-6 if name in LENGTHS else 2e-5
    return (8.0 * (outcome(step) - outcome(-step)) - (outcome(2.0 * step) - outcome(-2.0 * step))) / (12.0 * step)


def assert_differences(found, outcome_by, names):
    for column, name in enumerate(names):
        wanted = differenced(lambda amount, name=name: outcome_by(name, amount), name)
        assert np.abs(found[:, column] - wanted).max() < 1e-4 * max(1.0, np.abs(wanted).max()), name


def stroke_jacobian(model, strokes, pose, names):
    """d (x, y, theta) / d names, (3, k), SI units, of a stroke's end, its start and the rod's path being fixed."""
    found = run_strokes([model.course(strokes, pose)], len(PARAMETERS)).derivatives[0, 3:6]
    found = found * np.array((model.unit, model.unit, 1.0))[:, None]
    return found[:, [PARAMETERS.index(name) for name in names]] * derivative_units(model, names)


def numbers(pose):
    return np.array((pose.x, pose.y, pose.theta))


def names_for(model):
    """What a push depends on: ellipses have no corners, and points no shares."""
    shares = () if isinstance(model.pressure, PointFootprint) else SHARES
    return (*LAW, "pusher_friction", *(shares[:2] if isinstance(model.slider.outline, Ellipse) else shares))


# name: model, pose, push, its end, modes that it goes through.
PUSHES = {
    "leaving": (model_of("rect1", 0.1, 0.1, 0.1), Pose(0.1, 0.0, 0.4), SidePush(distance=0.2), "left", {"slide_right"}),
    "leaning": (model_of("rect1", 0.2, 0.2, 0.1, lean=0.05), Pose(theta=1.0), SidePush(distance=0.08), "distance", {}),
    "from afar": (
        model_of("tri1", 0.3, 0.1, 0.05, friction=0.3),
        Pose(0.02, 0.01, 1.0),
        WorldPush((0.2, 0.02), 3.2, 0.2),
        "distance",
        {"slide_left"},
    ),
    "around a corner": (
        model_of("rect3", 0.1, 0.3, 0.1, friction=0.1, radius=0.03),
        Pose(theta=2.0),
        SidePush(1, 0.98, 0.9, 0.15),
        "distance",
        {"slide_right"},
    ),
    "an ellipse": (model_of("ellip2", 0.2, 0.2), Pose(theta=0.7), SidePush(0, 0.13, -0.2, 0.05), "distance", {}),
    "a leaning ellipse": (model_of("ellip3", 0.1, 0.3, lean=0.04), Pose(), SidePush(0, 0.3, 0.2, 0.05), "distance", {}),
    "points": (
        model_of(footprint=grid_footprint(RECT.outline, 6)),
        Pose(theta=1.0),
        SidePush(distance=0.08),
        "distance",
        {},
    ),
    "a point rod": (
        model_of("rect1", 0.1, 0.1, 0.1, radius=0.0),
        Pose(theta=1.0),
        SidePush(distance=0.05),
        "distance",
        {},
    ),
    "a point that rests at a corner": (
        model_of("rect1", 0.1, 0.1, 0.1, friction=1.0, radius=0.0),
        Pose(theta=2.0),
        SidePush(1, 0.0, 0.75, 0.3),
        "left",
        {"stick"},
    ),
}


@pytest.mark.parametrize("name", PUSHES)
def test_a_pushs_derivatives_are_the_differences_of_its_end(name):
    model, pose, push, ended, modes = PUSHES[name]
    found, names = model.push(pose, push), names_for(model)
    assert ended == found.ended
    assert set(modes) <= {mode for mode, _ in story(found)}
    assert name != "around a corner" or "corner" in {kind for _, kind in story(found)}
    jacobian = stroke_jacobian(model, model.push_strokes(pose, push), pose, names)
    assert jacobian.shape == (3, len(names))
    assert_differences(
        jacobian, lambda name, amount: numbers(changed_model(model, name, amount).push(pose, push).end), names
    )


def test_random_pushes_have_the_derivatives_of_their_differences():
    for seed in (1, 4, 12, 16):
        case = random_case(seed, 1e-10)
        outline = case.model.slider.outline
        patch = PatchFootprint(outline, 0.1, 0.1, 0.0 if isinstance(outline, Ellipse) else 0.1)
        model, pose, push = replace(case.model, footprint=patch), case.pose, case.push
        names = names_for(model)
        jacobian = stroke_jacobian(model, model.push_strokes(pose, push), pose, names)
        outcome = lambda name, amount, m=model, c=case: numbers(changed_model(m, name, amount).push(c.pose, c.push).end)  # noqa: E731
        assert_differences(jacobian, outcome, names)


@pytest.mark.parametrize(
    ("model", "radius", "theta", "modes"),
    [
        (model_of("rect1", 0.1, 0.2, 0.1), 0.002, 1.0, {"ring_left", "ring_right", "ring_stuck"}),
        (model_of("tri2", 0.3, 0.1, 0.1), 0.006, -2.0, {"ring_right", "ring_stuck"}),
        (model_of("hex", 0.1, 0.4, 0.1, lean=0.03), 0.0005, 0.5, {"ring_left", "ring_right"}),
        (model_of("ellip2", 0.1, 0.4), 0.0005, 0.5, {"ring_left", "ring_right"}),
    ],
)
def test_a_drags_derivatives_are_the_differences_of_its_end(model, radius, theta, modes):
    start = Pose(0.1, 0.05, theta)
    drag = model.drag(start, LEGS, pin_friction_radius=radius)
    assert {mode for mode, _ in story(drag)} == modes
    names = tuple(name for name in OF_STROKES if name not in SHARES or name in names_for(model))

    def outcome(name, amount):
        rubbed = radius + amount * (name == "pin_friction_radius")
        return numbers(changed_model(model, name, amount).drag(start, LEGS, pin_friction_radius=rubbed).end)

    assert_differences(stroke_jacobian(model, model.drag_strokes(LEGS, radius), start, names), outcome, names)


def test_without_friction_in_the_ring_its_derivative_is_the_one_sided_difference():
    for model in (model_of(), model_of(footprint=grid_footprint(RECT.outline, 6))):
        start, step = Pose(0.1, 0.05, 1.0), 1e-6
        at = [numbers(model.drag(start, LEGS, pin_friction_radius=k * step).end) for k in range(3)]
        wanted = (4.0 * at[1] - 3.0 * at[0] - at[2]) / (2.0 * step)
        found = stroke_jacobian(model, model.drag_strokes(LEGS, 0.0), start, ("pin_friction_radius",))
        assert np.abs(found[:, 0] - wanted).max() < 1e-3 * np.abs(wanted).max()


def test_a_stuck_object_follows_its_ring_and_depends_on_nothing_else():
    model, start = model_of(), Pose(0.1, 0.05, 1.0)
    drag = model.drag(start, LEGS, pin_friction_radius=0.06)
    assert {mode for mode, _ in story(drag)} == {"ring_stuck"}
    c, s = math.cos(1.0), math.sin(1.0)
    wanted = np.zeros((3, len(OF_STROKES)))
    hitch = OF_STROKES.index("hitch_x")
    wanted[:2, hitch : hitch + 2] = -np.array(((c, -s), (s, c)))
    found = stroke_jacobian(model, model.drag_strokes(LEGS, 0.06), start, OF_STROKES)
    assert np.allclose(found, wanted, atol=1e-15)


def test_what_a_stroke_does_not_depend_on_is_zero_and_shares_that_cannot_be_are_nan():
    model, push = model_of(footprint=grid_footprint(RECT.outline, 4)), SidePush(distance=0.03)
    found = stroke_jacobian(model, model.push_strokes(Pose(), push), Pose(), OF_STROKES)
    for name, column in zip(OF_STROKES, found.T, strict=True):
        assert np.isnan(column).all() if name in SHARES else np.isfinite(column).all()
        assert (name in (*LAW, "pusher_friction", *SHARES)) == bool(np.any(column != 0.0))
    assert np.isnan(derivative_units(model_of("ellip2"), ("corner_share",))).all()
    rest = stroke_jacobian(model, model.drag_strokes((), 0.0), Pose(), OF_STROKES)
    assert all(np.all(column == 0.0) for name, column in zip(OF_STROKES, rest.T, strict=True) if name not in SHARES)


def loop_of(outline, *shares, centre=None, push=None, **changes):
    slider, footprint = Slider(outline, hitch=(0.005, 0.008)), PatchFootprint(outline, *shares, centre=centre)
    push = push or SidePush()
    return cm.CollectionLoop.mit(slider=slider, footprint=footprint, push=push, accuracy=1e-10, **changes)


SQUARE, OVAL = RECT.outline, Ellipse(0.05, 0.035)
L_SHAPE = Polygon(((0.05, 0.05), (-0.05, 0.05), (-0.05, -0.05), (0.0, -0.05), (0.0, 0.0), (0.05, 0.0)))
MIT = cm.CollectionLoop.mit(accuracy=1e-10, push=SidePush(distance=0.05))
LOOPS = {
    "square": loop_of(SQUARE, 0.2, 0.15, 0.1, reset=DragBack(((0.03, 0.05),), 0.001)),
    "leaning square": loop_of(SQUARE, 0.2, 0.15, 0.1, centre=(0.003, -0.002)),
    "triangle": loop_of(Slider.mit("tri1").outline, 0.1, 0.2, 0.1, push=SidePush(1, 0.4, 0.2, 0.08)),
    "L shape": loop_of(L_SHAPE, push=SidePush(0, 0.4, 0.1, 0.05)),
    "ellipse": loop_of(OVAL, 0.2, 0.2, push=SidePush(0, 0.2, 0.1, 0.06)),
    "leaning ellipse": loop_of(OVAL, 0.2, 0.2, centre=(0.001, 0.001), push=SidePush(0, 0.2, 0.1, 0.06)),
    "8 x 8 points": replace(MIT, footprint=grid_footprint(SQUARE, 8)),
    "corners": replace(MIT, footprint=corner_footprint(SQUARE)),
    "point rod": replace(MIT, pusher=Pusher(0.0)),
}


# What has all parameters.
SOLID = ("square", "leaning square", "triangle", "L shape", "point rod")


def changed_loop(loop, name, amount):
    if name in ("fraction", "angle", "distance"):
        return replace(loop, push=replace(loop.push, **{name: getattr(loop.push, name) + amount}))
    if name == "pin_friction_radius":
        return replace(loop, reset=replace(loop.reset, pin_friction_radius=loop.reset.pin_friction_radius + amount))
    model = changed_model(loop.model, name, amount)
    material = Material("moved", model.friction)
    return replace(loop, slider=model.slider, material=material, pusher=model.pusher, footprint=model.footprint)


def outputs_of(cycle):
    return np.array((cycle.push_turn, *cycle.push_displacement, cycle.drag_turn, cycle.drag_length, cycle.theta_next))


@pytest.mark.slow
@pytest.mark.parametrize("name", LOOPS)
def test_a_cycles_derivatives_by_all_parameters_are_its_differences(name):
    loop, theta = LOOPS[name], 0.7
    found, model = loop.sensitivity(theta), loop.model
    assert found.parameters == PARAMETERS and found.outputs == CYCLE_OUTPUTS and len(PARAMETERS) == 17
    skipped = [name for name, column in zip(PARAMETERS, found.jacobian.T, strict=True) if np.isnan(column).all()]
    assert set(skipped) <= {*SHARES, "pusher_radius"} and (len(skipped) > 0) == (name not in SOLID)
    if loop.reset.pin_friction_radius == 0.0:
        skipped.append("pin_friction_radius")
    if loop.pusher.radius == 0.0:
        skipped.append("pusher_radius")
    # Of these there cannot be less.
    skipped += [share for share in SHARES if share not in skipped and getattr(model.pressure, share) == 0.0]
    names = [name for name in PARAMETERS if name not in skipped]

    def outcome(name, amount):
        if name == "theta":
            return outputs_of(loop.cycle(theta + amount))
        return outputs_of(changed_loop(loop, name, amount).cycle(theta))

    columns = found.jacobian[:, [PARAMETERS.index(name) for name in names]]
    assert_differences(columns, outcome, names)
    assert len(names) >= 12


def test_derivatives_in_a_batch_are_those_of_single_cycles_whatever_their_number():
    loops, theta = list(LOOPS.values()), np.array([[0.7, 2.0]] * len(LOOPS))
    every = run_batch(loops, theta, len(PARAMETERS))
    slopes, plain = run_batch(loops, theta, 1), run_batch(loops, theta)
    np.testing.assert_array_equal(slopes.jacobian[..., 0], every.jacobian[..., 0])
    assert plain.jacobian.shape == (len(loops), 2, 6, 0)
    for number, loop in enumerate(loops):
        np.testing.assert_array_equal(every.jacobian[number, 0], loop.sensitivity(0.7).jacobian)
        assert every.theta_next[number, 0] == plain.theta_next[number, 0] == loop.cycle(0.7).theta_next


def test_pushes_kept_for_another_ring_leave_the_same_bits():
    """The ring has no part in a push: drags from kept ends are those of whole cycles, slopes too."""
    plain = cm.CollectionLoop.mit("plywood")
    theta = np.linspace(-3.0, 9.0, 25)
    for hitch in ((-0.0106, 0.0106), (0.03, -0.02), (0.0, 0.0)):
        for reset in (DragBack(), DragBack(way_points=((0.05, 0.02),), pin_friction_radius=0.001)):
            loop = replace(plain, slider=replace(plain.slider, hitch=hitch), reset=reset)
            values, slopes = CycleSlopes(loop)(theta)
            whole = run_batch((loop,), theta[None], 1)
            np.testing.assert_array_equal(values, whole.theta_next[0])
            np.testing.assert_array_equal(slopes, whole.jacobian[0, :, -1, 0])
