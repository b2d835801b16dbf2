"""Derivatives of a whole cycle, push and drag back, by its start and every parameter of material, pusher, protocol."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.handling import DragResult, PushResult
from cyclemap.mechanics.stroke_variation import (
    quarter,
    rotation,
    turned,
    unit_rows,
    vary_drag,
    vary_push,
    without_frame,
)
from cyclemap.suggestions import unknown_name

if TYPE_CHECKING:
    from cyclemap.mechanics.quasi_static import QuasiStaticModel

Array = NDArray[np.float64]

# Parameters of a cycle; angles in rad, lengths in m.
PARAMETER_NAMES = (
    *("theta", "mu_a", "mu_b", "m0", "n0", "phi", "pusher_friction", "pusher_radius"),
    *("fraction", "angle", "distance", "hitch_x", "hitch_y", "rim_share", "pin_friction_radius"),
    *("warp_a", "warp_b"),
)
CYCLE_OUTPUTS = ("push_turn", "push_dx", "push_dy", "drag_turn", "drag_length", "theta_next")


def cycle_jacobian(
    model: "QuasiStaticModel", push: PushResult, drag: DragResult, names: tuple[str, ...] = PARAMETER_NAMES
) -> Array:
    """Return d CYCLE_OUTPUTS / d names, (6, k), of a push from the ring's target and the drag back to it.

    The push is a `SidePush`. Mostly good to a hundred times the accuracy of the run, except on trajectories that
    touch a discontinuity; by the radius of a point rod that comes to a corner it is nan, and by rim share and warp of
    a footprint that can have none. By the friction of a ring that has none it is one-sided. Raises InvalidInput
    for an unknown name.
    """
    for name in names:
        if name not in PARAMETER_NAMES:
            raise unknown_name("parameter", name, PARAMETER_NAMES)
    unit, one = model.unit, unit_rows(model, names)
    by_push = vary_push(model, push, one)
    theta_0, theta_1 = push.start.theta, push.end.theta
    by_theta_0, by_theta_1 = one["theta"], by_push[0]
    moved = by_push[1:3] * unit
    shift = np.array((push.end.x - push.start.x, push.end.y - push.start.y))
    back = rotation(-theta_0)
    displacement = back @ (moved - np.outer(quarter(shift), by_theta_0))
    hitch = np.array(model.slider.hitch)
    by_hitch = np.stack([one["hitch_x"], one["hitch_y"]])
    # Before the push the ring is at the origin: x0 = -R(theta_0) hitch.
    ring = moved - turned(theta_0, hitch, by_theta_0, by_hitch) + turned(theta_1, hitch, by_theta_1, by_hitch)
    theta, length = vary_drag(model, drag, by_theta_1, ring, one)
    outputs = np.stack([by_theta_1 - by_theta_0, *displacement, theta - by_theta_1, length, theta])
    return without_frame(model, names, outputs)
