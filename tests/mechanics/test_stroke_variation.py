"""Derivatives of single pushes and drags: they are the differences of the strokes themselves."""

import math
from dataclasses import replace

import numpy as np
import pytest
from random_cases import random_case

from cyclemap.errors import InvalidInput
from cyclemap.mechanics import (
    PatchFootprint,
    Pose,
    Pusher,
    QuasiStaticModel,
    SidePush,
    Slider,
    WorldPush,
    grid_footprint,
    load_material,
)
from cyclemap.mechanics.motion_functions import PARAMETERS
from cyclemap.mechanics.phase_variation import vary_phase
from cyclemap.mechanics.stroke_variation import STROKE_PARAMETERS, drag_jacobian, push_jacobian

PLYWOOD = load_material("plywood").friction
LAW = ("mu_a", "mu_b", "m0", "n0", "phi")
WARP = ("warp_a", "warp_b")
PUSHED = (*LAW, "pusher_friction", "rim_share", *WARP)
LEGS = ((0.05, 0.03), (-0.02, 0.06), (0.0, 0.0))


def model_of(shape="rect1", friction=0.15, rim_share=0.0, radius=0.00475, footprint=None, law=PLYWOOD, warp=(0.0, 0.0)):
    slider = Slider.mit(shape)
    footprint = footprint or PatchFootprint.under(slider.outline, slider.centre_of_mass, rim_share, warp)
    return QuasiStaticModel(slider, law, Pusher(radius, friction), footprint, 1e-10)


def changed(model, radius, name, amount):
    """The model and the radius of the ring's friction circle with one parameter moved."""
    if name in LAW:
        law = replace(model.friction, **{name: getattr(model.friction, name) + amount})
        return replace(model, friction=law), radius
    if name == "pusher_friction":
        return replace(model, pusher=replace(model.pusher, friction=model.pusher.friction + amount)), radius
    if name == "rim_share":
        return replace(model, footprint=replace(model.pressure, rim_share=model.pressure.rim_share + amount)), radius
    if name in WARP:
        a, b = model.pressure.warp
        warp = (a + amount, b) if name == "warp_a" else (a, b + amount)
        return replace(model, footprint=replace(model.pressure, warp=warp)), radius
    if name == "pin_friction_radius":
        return model, radius + amount
    x, y = model.slider.hitch
    ring = (x + amount, y) if name == "hitch_x" else (x, y + amount)
    return replace(model, slider=replace(model.slider, hitch=ring)), radius


def differenced(end, model, radius, name):
    """Richardson's central difference of an end pose."""
    step = 2e-6 if name in ("hitch_x", "hitch_y", "pin_friction_radius") else 2e-5

    def at(amount):
        pose = end(*changed(model, radius, name, amount))
        return np.array((pose.x, pose.y, pose.theta))

    return (8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step)


def assert_the_differences(jacobian, end, model, radius, names):
    assert jacobian.shape == (3, len(names))
    for column, name in enumerate(names):
        wanted = differenced(end, model, radius, name)
        assert np.abs(jacobian[:, column] - wanted).max() < 1e-4 * max(1.0, np.abs(wanted).max()), name


# name: model, pose, push, its end, modes that it goes through.
PUSHES = {
    "leaving": (model_of(), Pose(0.1, 0.0, 0.4), SidePush(), "left", {"slide_right"}),
    "at the rim": (model_of(rim_share=0.4), Pose(theta=1.0), SidePush(distance=0.08), "distance", {"slide_right"}),
    "from afar": (
        model_of("tri1", 0.3, -0.3),
        Pose(0.02, 0.01, 1.0),
        WorldPush((0.2, 0.02), 3.2, 0.2),
        "distance",
        {"slide_left"},
    ),
    "around a corner": (
        model_of("rect3", 0.1, 0.5, 0.03),
        Pose(theta=2.0),
        SidePush(1, 0.98, 0.9, 0.15),
        "distance",
        {"slide_right"},
    ),
    "warped": (model_of(rim_share=0.2, warp=(0.1, -0.2)), Pose(theta=1.0), SidePush(), "distance", {"slide_right"}),
    "warped alone": (model_of("tri3", warp=(-0.1, 0.1)), Pose(), SidePush(distance=0.05), "distance", set()),
    "an ellipse": (
        model_of("ellip2", 0.2, 0.2, warp=(0.2, 0.1)),
        Pose(theta=0.7),
        SidePush(0, 0.13, -0.2, 0.05),
        "distance",
        set(),
    ),
}


@pytest.mark.parametrize("name", PUSHES)
def test_a_pushs_derivatives_are_the_differences_of_its_end(name):
    model, pose, push, ended, modes = PUSHES[name]
    found = model.push(pose, push)
    assert ended == found.ended
    assert modes <= {phase.motion.mode for phase in found.run.phases}
    jacobian = push_jacobian(model, found, PUSHED)
    assert_the_differences(jacobian, lambda moved, _: moved.push(pose, push).end, model, 0.0, PUSHED)


def test_some_push_goes_around_a_corner():
    model, pose, push, _, _ = PUSHES["around a corner"]
    assert "corner" in {phase.motion.piece.kind for phase in model.push(pose, push).run.phases}


def test_random_pushes_have_the_derivatives_of_their_differences():
    for seed in (1, 4, 12, 16):
        case = random_case(seed, 1e-10)
        slider = case.model.slider
        patch = PatchFootprint.under(slider.outline, slider.centre_of_mass, 0.2)
        model, pose, push = replace(case.model, footprint=patch), case.pose, case.push
        jacobian = push_jacobian(model, model.push(pose, push), PUSHED)
        end = lambda moved, _, pose=pose, push=push: moved.push(pose, push).end  # noqa: E731
        assert_the_differences(jacobian, end, model, 0.0, PUSHED)


@pytest.mark.parametrize(
    ("model", "radius", "theta", "modes"),
    [
        (model_of(rim_share=0.3), 0.002, 1.0, {"ring_left", "ring_right", "ring_stuck"}),
        (model_of("tri2", rim_share=-0.2), 0.006, -2.0, {"ring_right", "ring_stuck"}),
        (model_of("hex", rim_share=0.6, warp=(0.2, 0.3)), 0.0005, 0.5, {"ring_left", "ring_right"}),
    ],
)
def test_a_drags_derivatives_are_the_differences_of_its_end(model, radius, theta, modes):
    start = Pose(0.1, 0.05, theta)
    drag = model.drag(start, LEGS, pin_friction_radius=radius)
    assert len(drag.legs) == 3
    assert {leg.phase.motion.mode for leg in drag.legs} == modes
    jacobian = drag_jacobian(model, drag)
    end = lambda moved, r: moved.drag(start, LEGS, pin_friction_radius=r).end  # noqa: E731
    assert_the_differences(jacobian, end, model, radius, STROKE_PARAMETERS)


def test_without_friction_in_the_ring_its_derivative_is_the_one_sided_difference():
    for model in (model_of(), model_of(footprint=grid_footprint(Slider.mit("rect1").outline, 6))):
        start, step = Pose(0.1, 0.05, 1.0), 1e-6
        ends = [model.drag(start, LEGS, pin_friction_radius=k * step).end for k in range(3)]
        at = [np.array((end.x, end.y, end.theta)) for end in ends]
        wanted = (4.0 * at[1] - 3.0 * at[0] - at[2]) / (2.0 * step)
        found = drag_jacobian(model, model.drag(start, LEGS), ("pin_friction_radius",))
        assert np.abs(found[:, 0] - wanted).max() < 1e-3 * np.abs(wanted).max()


def test_a_stuck_object_follows_its_ring_and_depends_on_nothing_else():
    model, start = model_of(), Pose(0.1, 0.05, 1.0)
    drag = model.drag(start, LEGS, pin_friction_radius=0.06)
    assert {leg.phase.motion.mode for leg in drag.legs} == {"ring_stuck"}
    c, s = math.cos(1.0), math.sin(1.0)
    wanted = np.zeros((3, len(STROKE_PARAMETERS)))
    wanted[:2, 7:9] = -np.array(((c, -s), (s, c)))
    assert np.allclose(drag_jacobian(model, drag), wanted, atol=1e-15)


def test_names_that_mean_nothing_here_are_zero_nan_or_refused():
    model = model_of(footprint=grid_footprint(Slider.mit("rect1").outline, 4))
    push = model.push(Pose(), SidePush(distance=0.03))
    jacobian = push_jacobian(model, push)
    assert np.all(jacobian[:, 7:10] == 0.0)
    assert np.isnan(jacobian[:, [6, 10, 11]]).all()
    assert np.isfinite(jacobian[:, :6]).all()
    assert np.all(drag_jacobian(model, model.drag(Pose(), ())) == 0.0)
    with pytest.raises(InvalidInput, match="did you mean 'mu_a'"):
        push_jacobian(model, push, ("mu_aa",))
    with pytest.raises(InvalidInput, match="theta"):
        drag_jacobian(model, model.drag(Pose(), LEGS), ("theta",))


def test_the_variational_equation_is_solved_to_order_four():
    """Halving the steps of a drag whose centre of rotation keeps off the rim divides the error by 2^4."""
    model = replace(model_of(), accuracy=1e-3)
    start, parameters = np.array([[1.0, 0.0], [0.0, 0.0]]), np.zeros((len(PARAMETERS), 2))
    parameters[PARAMETERS.index("direction"), 1] = 1.0
    found = []
    for count in (4, 8, 16, 32, 256):
        drag = model.drag(Pose(0.1, 0.05, 1.2), ((0.0, 0.0),), longest_step=0.115 / count)
        found.append(vary_phase(drag.legs[0].phase, start, parameters)[0])
    errors = np.abs(np.array(found[:-1]) - found[-1]).max(axis=1)
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 4.0, atol=0.4)
