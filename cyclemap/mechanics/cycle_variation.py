"""Derivatives of a whole cycle, push and drag back, by its start and every parameter of material, pusher, protocol."""

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.contact_curve import Piece
from cyclemap.mechanics.handling import DragResult, PushResult
from cyclemap.mechanics.motion import RING, SLIDE_RIGHT, Motion
from cyclemap.mechanics.motion_functions import MARGINS, PARAMETERS
from cyclemap.mechanics.outline import Ellipse
from cyclemap.mechanics.phase_variation import vary_phase
from cyclemap.mechanics.push_run import PushRun, RunPhase
from cyclemap.mechanics.runge_kutta import SLOPE
from cyclemap.suggestions import unknown_name

if TYPE_CHECKING:
    from cyclemap.mechanics.quasi_static import QuasiStaticModel

Array = NDArray[np.float64]
Rows = dict[str, Array]

# Parameters of a cycle; angles in rad, lengths in m.
PARAMETER_NAMES = (
    *("theta", "mu_a", "mu_b", "m0", "n0", "phi", "pusher_friction", "pusher_radius"),
    *("fraction", "angle", "distance", "hitch_x", "hitch_y"),
)
CYCLE_OUTPUTS = ("push_turn", "push_dx", "push_dy", "drag_turn", "drag_length", "theta_next")

_ROW = {name: index for index, name in enumerate(PARAMETERS)}
_FRICTION = ("mu_a", "mu_b", "m0", "n0", "phi")


def cycle_jacobian(
    model: "QuasiStaticModel", push: PushResult, drag: DragResult, names: tuple[str, ...] = PARAMETER_NAMES
) -> Array:
    """Return d CYCLE_OUTPUTS / d names, (6, k), of a push from the ring's target and the drag back to it.

    The push is a `SidePush`. Exact to the accuracy of the run, except on trajectories that touch a discontinuity; by
    the radius of a point rod that comes to a corner it is nan. Raises InvalidInput for an unknown name.
    """
    for name in names:
        if name not in PARAMETER_NAMES:
            raise unknown_name("parameter", name, PARAMETER_NAMES)
    unit, one = model.unit, _unit_rows(names)
    by_push = _push_variation(model, push, one)
    theta_0, theta_1 = push.start.theta, push.end.theta
    by_theta_0, by_theta_1 = one["theta"], by_push[0]
    moved = by_push[1:3] * unit
    shift = np.array((push.end.x - push.start.x, push.end.y - push.start.y))
    back = _rotation(-theta_0)
    displacement = back @ (moved - np.outer(_quarter(shift), by_theta_0))
    hitch = np.array(model.slider.hitch)
    by_hitch = np.stack([one["hitch_x"], one["hitch_y"]])
    # Before the push the ring is at the origin: x0 = -R(theta_0) hitch.
    ring = moved - _turned(theta_0, hitch, by_theta_0, by_hitch) + _turned(theta_1, hitch, by_theta_1, by_hitch)
    theta, length = _drag_variation(model, drag, by_theta_1, ring, one)
    return np.stack([by_theta_1 - by_theta_0, *displacement, theta - by_theta_1, length, theta])


def _unit_rows(names: tuple[str, ...]) -> dict[str, Array]:
    """Variation (k,) of each parameter: one by itself; none if it is not among the names."""
    rows = np.eye(len(names))
    return {name: rows[names.index(name)] if name in names else np.zeros(len(names)) for name in PARAMETER_NAMES}


def _rotation(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array(((c, -s), (s, c)))


def _quarter(vector: Array) -> Array:
    return np.array((-vector[1], vector[0]))


def _turned(angle: float, vector: Array, by_angle: Array, by_vector: Array) -> Array:
    """Variation of R(angle) vector, (2, k)."""
    return _rotation(angle) @ (np.outer(_quarter(vector), by_angle) + by_vector)


def _push_variation(model: "QuasiStaticModel", push: PushResult, one: Rows) -> Array:
    """Variation (3, k) of the push's end: theta, and displacement of the object's origin in units of length."""
    first = push.run.phases[0]
    motion = first.motion
    coordinate = float(first.start[1])
    by_coordinate = _side_length(model, motion.piece) * one["fraction"]
    by_direction = one["theta"] + one["angle"] + motion.piece.normal_slope(coordinate) * by_coordinate
    by_radius = one["pusher_radius"] / model.unit
    if motion.rod.radius == 0.0 and _passes_corner(push.run):
        by_radius = np.where(by_radius == 0.0, 0.0, math.nan)
    parameters = _parameter_rows(one)
    parameters[_ROW["direction"]], parameters[_ROW["radius"]] = by_direction, by_radius
    state = np.stack([one["theta"], by_coordinate])
    start_shift = _rod_shift(motion, first.start, state, by_radius)
    state = _vary_run(push.run, state, parameters, one)
    last = push.run.phases[-1]
    end_slope = last.phase.steps[-1].stages[-1, SLOPE]
    by_travel = one["distance"] / model.unit
    if push.ended == "left":
        by_travel = _leaving(last, push.run.end, end_slope, state, by_direction)
    state = state + np.outer(end_slope, by_travel)
    travel = push.run.length
    toward = np.array((math.cos(motion.rod.direction), math.sin(motion.rod.direction)))
    rod = np.outer(toward, by_travel) + travel * np.outer(_quarter(toward), by_direction)
    end_shift = _rod_shift(last.motion, push.run.end, state, by_radius)
    return np.vstack([state[0], start_shift + rod - end_shift])


def _passes_corner(run: PushRun) -> bool:
    """Whether the rod comes to a corner, where a point skips the arc that every thicker rod goes around."""
    return any(MARGINS[phase.phase.broken or 0] in ("after_low", "before_high") for phase in run.phases)


def _parameter_rows(one: Rows) -> Array:
    """Variation (15, k) of a motion's parameters that every motion shares."""
    rows = np.zeros((len(PARAMETERS), one["theta"].size))
    for name in _FRICTION:
        rows[_ROW[name]] = one[name]
    return rows


def _side_length(model: "QuasiStaticModel", piece: Piece) -> float:
    """Derivative of the start's coordinate by the fraction."""
    outline = model.slider.outline
    if isinstance(outline, Ellipse):
        return 2.0 * math.pi
    side = getattr(piece, "side", 0)
    edge = outline.array[(side + 1) % outline.sides] - outline.array[side]
    return float(np.hypot(*edge)) / model.unit


def _vary_run(run: PushRun, state: Array, parameters: Array, one: Rows) -> Array:
    """Variation of the end of the last phase at fixed rod travel."""
    for phase, following in zip(run.phases, [*run.phases[1:], None], strict=True):
        sign = -1.0 if phase.motion.mode == SLIDE_RIGHT else 1.0
        parameters[_ROW["smu"]] = sign * one["pusher_friction"]
        state = vary_phase(phase, state, parameters)
        if following is not None and following.motion.piece is not phase.motion.piece:
            state = _across_pieces(phase, following, state)
    return state


def _across_pieces(phase: RunPhase, following: RunPhase, state: Array) -> Array:
    """Carry a variation to the next piece's coordinate; where the rates jump (a point rod at a corner), they count."""
    radius = phase.motion.rod.radius
    end = phase.phase.steps[-1].stages[-1]
    _, metric_old = phase.motion.piece.contact(float(end[1]), radius)
    _, metric_new = following.motion.piece.contact(float(following.start[1]), radius)
    ratio = np.array((1.0, metric_old / metric_new))
    slope_old, slope_new = end[SLOPE] * ratio, following.phase.steps[0].stages[0, SLOPE]
    later = -state[1] / end[SLOPE][1]
    return np.asarray(state * ratio[:, None] + np.outer(slope_old - slope_new, later))


def _leaving(last: RunPhase, end: Array, slope: Array, state: Array, by_direction: Array) -> Array:
    """Variation of the travel at which the rod leaves: where the angle from its direction to the normal is a right one.

    A point leaves at the corner that it slides over.
    """
    if MARGINS[last.phase.broken or 0] != "approach":
        return np.asarray(-state[1] / slope[1])
    turning = last.motion.piece.normal_slope(float(end[1]))
    rate = slope[0] + turning * slope[1]
    return np.asarray(-(state[0] + turning * state[1] - by_direction) / rate)


def _rod_shift(motion: Motion, at: Array, state: Array, by_radius: Array) -> Array:
    """Variation (2, k) of the rod's centre seen from the object's origin, in the world's axes."""
    theta, coordinate, radius = float(at[0]), float(at[1]), motion.rod.radius
    contact, metric = motion.piece.contact(coordinate, radius)
    normal = np.array((math.cos(contact.normal), math.sin(contact.normal)))
    centre = np.array(contact.rod_centre(radius))
    by_place = metric * np.outer(_quarter(normal), state[1]) + np.outer(normal, by_radius)
    return _turned(theta, centre, state[0], by_place)


def _drag_variation(
    model: "QuasiStaticModel", drag: DragResult, theta: Array, ring: Array, one: Rows
) -> tuple[Array, Array]:
    """Variation of the last orientation and of the drag's length, from those of the push's end; `ring` (2, k), m."""
    length = np.zeros_like(theta)
    parameters = _parameter_rows(one)
    parameters[_ROW["geometry_0"]] = one["hitch_x"] / model.unit
    parameters[_ROW["geometry_1"]] = one["hitch_y"] / model.unit
    for leg in drag.legs:
        assert leg.phase.motion.mode == RING
        direction = leg.phase.motion.rod.direction
        toward = np.array((math.cos(direction), math.sin(direction)))
        travel = leg.frame.unit * leg.phase.phase.length
        by_length = -toward @ ring
        parameters[_ROW["direction"]] = -_quarter(toward) @ ring / travel
        state = vary_phase(leg.phase, np.stack([theta, np.zeros_like(theta)]), parameters)
        spin = leg.phase.phase.steps[-1].stages[-1, SLOPE][0]
        theta = state[0] + spin * by_length / model.unit
        length, ring = length + by_length, np.zeros_like(ring)
    return theta, length
