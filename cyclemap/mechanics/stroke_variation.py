"""Derivatives of single pushes and drags, by the chain rule through the tangents of their phases."""

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.contact_curve import Piece
from cyclemap.mechanics.handling import DragLeg, DragResult, PushResult
from cyclemap.mechanics.motion import RING, RING_RIGHT, RING_STUCK, SLIDE_RIGHT, Motion
from cyclemap.mechanics.motion_functions import MARGINS, PARAMETERS
from cyclemap.mechanics.outline import Ellipse
from cyclemap.mechanics.phase_variation import vary_phase
from cyclemap.mechanics.pressure_family import has_frame
from cyclemap.mechanics.push_run import PushRun, RunPhase
from cyclemap.mechanics.runge_kutta import SLOPE
from cyclemap.suggestions import unknown_name

if TYPE_CHECKING:
    from cyclemap.mechanics.quasi_static import QuasiStaticModel

Array = NDArray[np.float64]
Rows = dict[str, Array]

# Parameters of a stroke from a given pose along a given path; angles in rad, lengths in m.
STROKE_PARAMETERS = (
    *("mu_a", "mu_b", "m0", "n0", "phi", "pusher_friction"),
    *("rim_share", "hitch_x", "hitch_y", "pin_friction_radius"),
    *("warp_a", "warp_b"),
)
# What only a footprint with a frame can have.
_FRAME = ("rim_share", "warp_a", "warp_b")
_LAW = ("mu_a", "mu_b", "m0", "n0", "phi", *_FRAME)
_START = ("theta", "pusher_radius", "fraction", "angle", "distance")
_ROW = {name: index for index, name in enumerate(PARAMETERS)}


def push_jacobian(model: "QuasiStaticModel", push: PushResult, names: tuple[str, ...] = STROKE_PARAMETERS) -> Array:
    """Return d (x, y, theta) / d names, (3, k), of a push's end (m, rad), its start and the rod's path being fixed.

    By what belongs to the ring alone it is zero; by rim share and warp of a footprint that can have none it is nan.
    Mostly good to a hundred times the accuracy of the run, except on trajectories that touch a discontinuity. Raises
    InvalidInput for an unknown name.

    >>> from cyclemap.mechanics import EllipseFriction, Pose, QuasiStaticModel, SidePush, Slider
    >>> model = QuasiStaticModel(Slider.mit("rect1"), EllipseFriction.isotropic(0.25))
    >>> push = model.push(Pose(), SidePush(distance=0.05))
    >>> push_jacobian(model, push, ("pusher_friction", "hitch_x")).round(4)
    array([[ 0.0188,  0.    ],
           [ 0.0044,  0.    ],
           [-0.3548,  0.    ]])
    """
    _refuse_unknown(names)
    by_push = vary_push(model, push, unit_rows(model, names))
    jacobian = np.vstack([model.unit * by_push[1:], by_push[:1]])
    return without_frame(model, names, jacobian)


def drag_jacobian(model: "QuasiStaticModel", drag: DragResult, names: tuple[str, ...] = STROKE_PARAMETERS) -> Array:
    """Return d (x, y, theta) / d names, (3, k), of a drag's end (m, rad), its start and its way-points being fixed.

    The ring's own start moves with the hitch. By the friction of a ring that has none it is the one-sided derivative.
    A way-point at which the ring already was counts for nothing. Otherwise as `push_jacobian`.
    """
    _refuse_unknown(names)
    one, hitch = unit_rows(model, names), np.array(model.slider.hitch)
    still, by_hitch = np.zeros(len(names)), np.stack([one["hitch_x"], one["hitch_y"]])
    if not drag.legs:
        return np.zeros((3, len(names)))
    theta, _ = vary_drag(model, drag, still, turned(drag.start.theta, hitch, still, by_hitch), one)
    place = -turned(drag.end.theta, hitch, theta, by_hitch)
    return without_frame(model, names, np.vstack([place, theta]))


def _refuse_unknown(names: tuple[str, ...]) -> None:
    for name in names:
        if name not in STROKE_PARAMETERS:
            raise unknown_name("parameter", name, STROKE_PARAMETERS)


def unit_rows(model: "QuasiStaticModel", names: tuple[str, ...]) -> Rows:
    """Variation (k,) of each parameter: one by itself; none if it is not among the names, or has no meaning."""
    rows = np.eye(len(names))
    known = (*STROKE_PARAMETERS, *_START)
    one = {name: rows[names.index(name)] if name in names else np.zeros(len(names)) for name in known}
    if not has_frame(model.pressure):
        one |= {name: np.zeros(len(names)) for name in _FRAME}
    return one


def without_frame(model: "QuasiStaticModel", names: tuple[str, ...], jacobian: Array) -> Array:
    """Return a jacobian (n, k), nan by a rim share or warp that the footprint cannot have."""
    if not has_frame(model.pressure):
        jacobian[:, [name in _FRAME for name in names]] = math.nan
    return jacobian


def rotation(angle: float) -> Array:
    """Return the matrix that turns by an angle."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array(((c, -s), (s, c)))


def quarter(vector: Array) -> Array:
    """Return z x vector."""
    return np.array((-vector[1], vector[0]))


def turned(angle: float, vector: Array, by_angle: Array, by_vector: Array) -> Array:
    """Variation of R(angle) vector, (2, k)."""
    return rotation(angle) @ (np.outer(quarter(vector), by_angle) + by_vector)


def vary_push(model: "QuasiStaticModel", push: PushResult, one: Rows) -> Array:
    """Variation (3, k) of the push's end: theta, and displacement of the object's origin in units of length."""
    first = push.run.phases[0]
    motion = first.motion
    coordinate = float(first.start[1])
    by_coordinate = _side_length(model, motion.piece) * one["fraction"]
    by_direction = one["theta"] + one["angle"] + motion.piece.normal_slope(coordinate) * by_coordinate
    by_radius = one["pusher_radius"] / model.unit
    if motion.rod.radius == 0.0 and _passes_corner(push.run):
        by_radius = np.where(by_radius == 0.0, 0.0, math.nan)
    parameters = _law_rows(one)
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
    rod = np.outer(toward, by_travel) + travel * np.outer(quarter(toward), by_direction)
    end_shift = _rod_shift(last.motion, push.run.end, state, by_radius)
    return np.vstack([state[0], start_shift + rod - end_shift])


def _passes_corner(run: PushRun) -> bool:
    """Whether the rod comes to a corner, where a point skips the arc that every thicker rod goes around."""
    return any(MARGINS[phase.phase.broken or 0] in ("after_low", "before_high") for phase in run.phases)


def _law_rows(one: Rows) -> Array:
    """Variation (18, k) of a motion's parameters that every motion shares."""
    rows = np.zeros((len(PARAMETERS), one["theta"].size))
    for name in _LAW:
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
    by_place = metric * np.outer(quarter(normal), state[1]) + np.outer(normal, by_radius)
    return turned(theta, centre, state[0], by_place)


def vary_drag(model: "QuasiStaticModel", drag: DragResult, theta: Array, ring: Array, one: Rows) -> tuple[Array, Array]:
    """Variation of the last orientation and of the drag's length, from those of the push's end; `ring` (2, k), m."""
    length = np.zeros_like(theta)
    parameters = _law_rows(one)
    parameters[_ROW["geometry_0"]] = one["hitch_x"] / model.unit
    parameters[_ROW["geometry_1"]] = one["hitch_y"] / model.unit
    for leg in drag.legs:
        direction = leg.phase.motion.rod.direction
        toward = np.array((math.cos(direction), math.sin(direction)))
        travel = leg.frame.unit * leg.phase.phase.length
        by_length = -toward @ ring
        parameters[_ROW["direction"]] = -quarter(toward) @ ring / travel
        parameters[_ROW["smu"]] = _turning(leg) * one["pin_friction_radius"] / model.unit
        theta = _vary_leg(leg, theta, by_length / model.unit, parameters)
        length, ring = length + by_length, np.zeros_like(ring)
    return theta, length


def _turning(leg: DragLeg) -> float:
    """Which way the object turns on a leg: it is the same all along."""
    if leg.phase.motion.mode == RING:
        return float(np.sign(leg.phase.phase.steps[0].stages[0, SLOPE][0]))
    return -1.0 if leg.phase.motion.mode == RING_RIGHT else 1.0


def _vary_leg(leg: DragLeg, theta: Array, by_length: Array, parameters: Array) -> Array:
    """Variation of the orientation at the end of a leg."""
    if leg.phase.motion.mode == RING_STUCK:
        return theta
    state = vary_phase(leg.phase, np.stack([theta, np.zeros_like(theta)]), parameters)
    spin = leg.phase.phase.steps[-1].stages[-1, SLOPE][0]
    return np.asarray(state[0] + spin * by_length)
