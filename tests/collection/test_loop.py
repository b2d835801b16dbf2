"""The collection loop: a cycle is a push and a drag, its sensitivities are their derivatives."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import (
    DragBack,
    Ellipse,
    EllipseFriction,
    Material,
    PatchFootprint,
    Pusher,
    SidePush,
    Slider,
    WorldPush,
    grid_footprint,
)
from cyclemap.mechanics.cycle_batch import CYCLE_OUTPUTS
from cyclemap.mechanics.engine.strokes import PARAMETERS

MIT = CollectionLoop.mit()
SHARES = ("inner_share", "rim_share", "corner_share")
STRONG = Material("strong", EllipseFriction(0.35, 0.2, 0.05, -0.03, 0.7))

# name: loop, orientation, how its push ends.
LOOPS = {
    "the MIT loop, leaving": (MIT, 0.0, "left"),
    "the MIT loop, by distance": (MIT, 1.0, "distance"),
    "a hexagon on strong friction": (
        CollectionLoop(Slider.mit("hex"), STRONG, Pusher(friction=0.3), SidePush(2, 0.35, 0.3, 0.04)),
        -2.0,
        "distance",
    ),
    "an ellipse": (
        CollectionLoop(Slider.mit("ellip2"), STRONG, Pusher(friction=0.2), SidePush(0, 0.13, -0.2, 0.08)),
        0.7,
        "distance",
    ),
    "an ellipse, leaving": (
        CollectionLoop(Slider.mit("ellip3"), STRONG, Pusher(friction=0.1), SidePush(0, 0.13, 0.8, 0.15)),
        0.7,
        "left",
    ),
    "a thick rod around a corner": (
        CollectionLoop(Slider.mit("rect3"), STRONG, Pusher(0.03, 0.4), SidePush(1, 0.9, 0.4, 0.15)),
        2.0,
        None,
    ),
    "a point rod": (
        CollectionLoop(Slider.mit("rect1"), STRONG, Pusher(0.0, 0.15), SidePush(0, 0.6, 0.1, 0.05)),
        0.4,
        "distance",
    ),
    "a point rod that leaves at a corner": (
        CollectionLoop(Slider.mit("rect1"), STRONG, Pusher(0.0, 0.15), SidePush(0, 0.02, 0.7, 0.1)),
        0.4,
        "left",
    ),
    "a frictionless rod": (
        CollectionLoop(Slider.mit("rect2"), STRONG, Pusher(friction=0.0), SidePush(3, 0.4, 0.2, 0.06)),
        0.4,
        "distance",
    ),
    "the papers grid": (replace(MIT, footprint=grid_footprint(MIT.slider.outline, 8)), 1.0, "distance"),
    "a ring with friction, pressure at the rim": (
        replace(
            MIT,
            reset=DragBack(((0.05, 0.02),), 0.002),
            footprint=PatchFootprint(MIT.slider.outline, 0.1, 0.3, 0.2, (0.001, -0.0005)),
        ),
        0.8,
        "distance",
    ),
    "an ellipse with more pressure in the middle and at the rim": (
        CollectionLoop(
            Slider.mit("ellip2"),
            STRONG,
            Pusher(friction=0.2),
            SidePush(0, 0.13, -0.2, 0.05),
            DragBack(pin_friction_radius=0.004),
            PatchFootprint(Slider.mit("ellip2").outline, 0.3, 0.1),
        ),
        0.7,
        "distance",
    ),
    "way-points": (replace(MIT, reset=DragBack(((0.05, 0.02), (-0.02, 0.06)))), 1.0, "distance"),
}


def changed(loop, theta, parameter, amount):
    """The loop and orientation with one parameter moved."""
    law, rod, push = loop.material.friction, loop.pusher, loop.push
    x, y = loop.slider.hitch
    if parameter == "theta":
        return loop, theta + amount
    if parameter in ("mu_a", "mu_b", "m0", "n0", "phi"):
        moved = replace(law, **{parameter: getattr(law, parameter) + amount})
        return replace(loop, material=Material("moved", moved)), theta
    if parameter == "pusher_friction":
        return replace(loop, pusher=replace(rod, friction=rod.friction + amount)), theta
    if parameter in SHARES:
        patch = loop.model.pressure
        return replace(loop, footprint=replace(patch, **{parameter: getattr(patch, parameter) + amount})), theta
    if parameter == "pin_friction_radius":
        radius = loop.reset.pin_friction_radius + amount
        return replace(loop, reset=replace(loop.reset, pin_friction_radius=radius)), theta
    if parameter == "pusher_radius":
        return replace(loop, pusher=replace(rod, radius=rod.radius + amount)), theta
    if parameter in ("hitch_x", "hitch_y"):
        ring = (x + amount, y) if parameter == "hitch_x" else (x, y + amount)
        return replace(loop, slider=replace(loop.slider, hitch=ring)), theta
    return replace(loop, push=replace(push, **{parameter: getattr(push, parameter) + amount})), theta


def outputs(loop, theta):
    cycle = loop.cycle(theta)
    return np.array((cycle.push_turn, *cycle.push_displacement, cycle.drag_turn, cycle.drag_length, cycle.theta_next))


def differenced(loop, theta, parameter):
    """Richardson's central difference of the outputs; one-sided where a value is 0, its least."""
    value = {
        **{name: getattr(loop.model.pressure, name, 0.0) for name in SHARES},
        "pusher_friction": loop.pusher.friction,
        "pusher_radius": loop.pusher.radius,
        "pin_friction_radius": loop.reset.pin_friction_radius,
    }.get(parameter, 1.0)
    lengths = ("pusher_radius", "hitch_x", "hitch_y", "distance", "pin_friction_radius")
    step = 2e-6 if parameter in lengths else 2e-5

    def at(amount):
        return outputs(*changed(loop, theta, parameter, amount))

    if value == 0.0:
        return (4.0 * at(step) - 3.0 * at(0.0) - at(2.0 * step)) / (2.0 * step)
    return (8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step)


@pytest.mark.slow
@pytest.mark.parametrize("name", LOOPS)
def test_all_sensitivities_of_all_six_outputs_are_the_differences(name):
    loop, theta, ended = LOOPS[name]
    loop = replace(loop, accuracy=1e-10)
    assert ended in (None, loop.cycle(theta).ended)
    found = loop.sensitivity(theta)
    assert found.jacobian.shape == (len(CYCLE_OUTPUTS), len(PARAMETERS)) == (6, 17)
    for column, parameter in enumerate(PARAMETERS):
        if name == "a frictionless rod" and parameter == "pusher_friction":
            continue  # Stick and slip part at zero friction: there is no derivative.
        if name == "a point rod that leaves at a corner" and parameter == "pusher_radius":
            assert np.isnan(found.jacobian[:, column]).all()
            continue  # Every thicker rod goes around the corner: the point's own motion does not tell how.
        ellipse = isinstance(loop.slider.outline, Ellipse)
        if (name == "the papers grid" and parameter in SHARES) or (ellipse and parameter == "corner_share"):
            assert np.isnan(found.jacobian[:, column]).all()
            continue  # Support points have no parts, ellipses no corners.
        wanted = differenced(loop, theta, parameter)
        size = np.maximum(1.0, np.abs(wanted).max())
        assert np.abs(found.jacobian[:, column] - wanted).max() < 2e-4 * size, parameter


@pytest.mark.parametrize("theta", [-2.5, -0.6, 0.3, 2.2, 4.0, 17.1])
def test_the_multiplier_is_the_slope_of_the_cycle_map(theta):
    loop = replace(MIT, accuracy=1e-11)
    found = loop.sensitivity(theta)
    assert abs(found.by_theta - differenced(loop, theta, "theta")[-1]) < 1e-6
    assert found.by_theta == found.by("theta") == found.by("theta", "theta_next")
    assert abs(found.theta_next - loop.cycle(theta).theta_next) < 1e-14


def test_a_sensitivity_of_an_unknown_name_is_refused():
    with pytest.raises(InvalidInput, match="no derivative of 'theta_next' by 'mass'"):
        MIT.sensitivity(0.0).by("mass")


def test_a_cycle_starts_and_ends_with_its_ring_at_the_target():
    for theta in (-2.0, 0.0, 9.1):
        cycle = MIT.cycle(theta)
        for pose in (cycle.push.start, cycle.drag.end):
            assert np.allclose(MIT.model.ring_place(pose), 0.0, atol=1e-16)
        assert cycle.push.start.theta == theta
        assert cycle.theta_next == cycle.drag.end.theta
        assert abs(theta + cycle.push_turn + cycle.drag_turn - cycle.theta_next) < 1e-14


def test_the_lift_commutes_with_full_turns():
    for theta in (-1.0, 0.5, 2.0):
        assert abs(MIT.cycle(theta + 6 * math.pi).theta_next - MIT.cycle(theta).theta_next - 6 * math.pi) < 1e-8


def test_the_order_of_calls_does_not_change_a_cycle():
    first = [CollectionLoop.mit().cycle(t).theta_next for t in (0.0, 2.0, 4.0)]
    loop = CollectionLoop.mit()
    second = [loop.cycle(t).theta_next for t in (4.0, 2.0, 0.0)][::-1]
    assert first == second


def test_the_drawn_trajectory_is_the_cycles_own_only_finer():
    cycle = MIT.cycle(1.0)
    drawn = cycle.trajectory
    assert len(drawn.push.path) > 60
    assert len(drawn.drag.path) > 20
    assert abs(drawn.push.pose[-1, 2] - cycle.push.end.theta) < 1e-7
    assert abs(drawn.drag.pose[-1, 2] - cycle.theta_next) < 1e-6
    assert np.allclose(drawn.drag.pusher[-1], 0.0, atol=1e-15)


def test_values_that_fit_no_loop_are_refused():
    for theta in (float("nan"), "1", None, True):
        with pytest.raises(InvalidInput, match="theta"):
            MIT.cycle(theta)
    with pytest.raises(InvalidInput, match="sides 0 to 3"):
        replace(MIT, push=SidePush(side=7)).cycle(0.0)
    with pytest.raises(InvalidInput, match="did you mean 'plywood'"):
        CollectionLoop.mit("plywod")
    with pytest.raises(InvalidInput, match="finite"):
        MIT.next_theta([0.0, float("inf")])
    with pytest.raises(InvalidInput):
        WorldPush((0.0, 0.0), 0.0, -1.0)
