"""The equations of motion of the pushed or dragged slider, in CasADi, and their integration along one leg of the rod.

Newton-Euler (Ma & Rodriguez 2018, Eq. 3): M q'' = F_pusher + F_friction, q = (x, y, theta) of the centre of mass.
Lengths are in extents L of the footprint, speeds in rod speeds v, forces in weights m g. Then M = Fr diag(1, 1, J) with
the Froude number Fr = v^2 / (g L) and J = I / (m L^2): the speed enters squared, and nowhere else.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from cyclemap.arrays import Array
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.mechanics.footprint import PointFootprint
from cyclemap.mechanics.outline import Ellipse, Outline

Vector = tuple[Any, Any]

# How a leg lies (rod's start and velocity, duration), then what it meets; creep: the speed below which friction fades.
LEG = ("rod_x", "rod_y", "rod_vx", "rod_vy", "duration")
PHYSICS = (
    *("froude", "inertia", "stiffness", "damping", "radius", "pusher_mu", "pin_radius", "creep"),
    *("mu_a", "mu_b", "m0", "n0", "phi"),
)
# The absolute tolerance as a share of the relative one: speeds and lengths are of order one.
_ABSOLUTE = 0.1
# Newton's error as a share of a step's: CVODES' own 0.1 lets the stiff contact turn it into failed error tests.
_NEWTON_SHARE = 1e-3
_MOST_STEPS = 200_000
# Units of the state. Velocities follow from positions through the stiff contact, where a step of length h gives them
# the error of positions over h: tested as strictly as these, they would have steps shortened without end.
_SCALES = np.array([1.0, 1.0, 1.0, 100.0, 100.0, 100.0])
# Newton's steps towards the nearest place of an ellipse; 5 reach rounding at an axis ratio of 1.5, 7 at 4.
_NEWTON_STEPS = 8


@dataclass(frozen=True, eq=False)
class Leg:
    """A leg as computed, in the equations' units.

    time : (n,) since its start. rod : (n, 2). state : (n, 6) x, y, theta of the centre of mass, their velocities.
    force, place : (n, 2) the rod's force on the slider, and where (world frame). stored : (n,) energy in the contact.
    works : (3,) the rod's work, and what floor and contact dissipated.
    """

    time: Array
    rod: Array
    state: Array
    force: Array
    place: Array
    stored: Array
    works: Array


@dataclass(frozen=True)
class LegEquations:
    """The initial value problem of one leg of the rod, everything in the equations' units.

    footprint : support points of extent one. centre : centre of mass. touched : the outline that the rod pushes, or
    the place of the ring in which it drags. tolerance : relative error of a step. samples : of the leg, evenly in
    time, beside its start.
    """

    footprint: PointFootprint
    centre: tuple[float, float]
    touched: Outline | tuple[float, float]
    tolerance: float
    samples: int

    def run(self, start: Array, rod: Array, velocity: Array, time: float, physics: Array) -> Leg:
        """Move the rod for a time from a place at a velocity, the slider being in the state `start` (6,).

        Integrated by CVODES (Hindmarsh et al. 2005). Raises ConvergenceError where it gives up.
        """
        integrator, observed = _functions(self)
        parameters = np.array([*rod, *velocity, time, *physics])
        # Whole turns stay out, since the integrator's error is relative to what it integrates.
        wound = 2.0 * np.pi * np.round(start[2] / (2.0 * np.pi)) * (np.arange(6) == 2)
        try:
            found = integrator(x0=(start - wound) / _SCALES, p=parameters)
        except RuntimeError as cause:
            raise ConvergenceError(
                f"the integrator of the dynamic simulation gave up at tolerance {self.tolerance:g}: choose a looser "
                "one, a larger regularisation or a smaller stiffness"
            ) from cause
        scaled = np.column_stack([(start - wound) / _SCALES, np.array(found["xf"])]) + wound[:, None]
        share = np.linspace(0.0, 1.0, self.samples + 1)
        seen = np.array(observed(share[None], scaled, parameters))
        path = rod + np.outer(time * share, velocity)
        return Leg(
            time * share, path, scaled.T * _SCALES, seen[:2].T, seen[2:4].T, seen[4], np.array(found["qf"])[:, -1]
        )


@lru_cache(maxsize=32)
def _functions(leg: LegEquations) -> tuple[ca.Function, ca.Function]:
    """The integrator over time 0 to 1, and (time, state, parameters) -> force (2), its place (2), energy stored.

    Both know the state in units of _SCALES.
    """
    time, scaled, parameters = ca.SX.sym("time"), ca.SX.sym("scaled", 6), ca.SX.sym("parameters", len(LEG + PHYSICS))
    x, y, theta, vx, vy, omega = ca.vertsplit(_SCALES * scaled)
    p = dict(zip(LEG + PHYSICS, ca.vertsplit(parameters), strict=True))
    along = p["duration"] * time
    # What the contact sees, in the slider's axes: the rod from the centre of mass, and their relative velocity.
    rod = _turned((p["rod_x"] + p["rod_vx"] * along - x, p["rod_y"] + p["rod_vy"] * along - y), -theta)
    velocity = _turned((p["rod_vx"] - vx, p["rod_vy"] - vy), -theta)
    seen_by = (leg.centre, rod, velocity, omega, p)
    contact = _ring(leg.touched, *seen_by) if isinstance(leg.touched, tuple) else _push(leg.touched, *seen_by)
    local, place, pin, stored, lost = contact
    floor, floor_torque, floor_loss = _floor(leg, theta, (vx, vy), omega, p)
    force, lever = _turned(local, theta), _turned(place, theta)
    torque = floor_torque + pin + place[0] * local[1] - place[1] * local[0]
    forces = ca.vertcat(floor[0] + force[0], floor[1] + force[1], torque / p["inertia"])
    rates = ca.vertcat(vx, vy, omega, forces / p["froude"])
    powers = ca.vertcat(force[0] * p["rod_vx"] + force[1] * p["rod_vy"], floor_loss, lost)
    problem = {"t": time, "x": scaled, "p": parameters, "quad": p["duration"] * powers}
    problem["ode"] = p["duration"] * rates / _SCALES
    options = {
        "reltol": leg.tolerance,
        "abstol": _ABSOLUTE * leg.tolerance,
        "nonlin_conv_coeff": _NEWTON_SHARE,
        "max_num_steps": _MOST_STEPS,
        "disable_internal_warnings": True,
        "linear_solver": "csparse",
    }
    grid = np.linspace(0.0, 1.0, leg.samples + 1)[1:].tolist()
    seen = ca.vertcat(*force, x + lever[0], y + lever[1], stored)
    observed = ca.Function("observed", [time, scaled, parameters], [seen])
    return ca.integrator("leg", "cvodes", problem, 0.0, grid, options), observed


def _push(
    outline: Outline, centre: tuple[float, float], rod: Vector, velocity: Vector, omega: ca.SX, p: Mapping[str, ca.SX]
) -> tuple[Vector, Vector, ca.SX, ca.SX, ca.SX]:
    """A rod on the outline: spring and damper that never pull, and Coulomb friction faded below the creep speed.

    Force on the slider and its place (slider's axes), torque beyond it, energy stored, power dissipated.
    """
    x, y = nearest_place(outline, rod[0] + centre[0], rod[1] + centre[1])
    place = (x - centre[0], y - centre[1])
    lever = (rod[0] - place[0], rod[1] - place[1])
    distance = ca.sqrt(lever[0] ** 2 + lever[1] ** 2)
    out = (lever[0] / distance, lever[1] / distance)
    slip = (velocity[0] + omega * place[1], velocity[1] - omega * place[0])
    depth, closing = p["radius"] - distance, -slip[0] * out[0] - slip[1] * out[1]
    sideways = -slip[0] * out[1] + slip[1] * out[0]
    spring = ca.if_else(depth > 0.0, p["stiffness"] * depth, 0.0)
    normal = ca.if_else(depth > 0.0, ca.fmax(p["stiffness"] * depth + p["damping"] * closing, 0.0), 0.0)
    tangential = p["pusher_mu"] * normal * sideways / ca.sqrt(sideways**2 + p["creep"] ** 2)
    force = (-normal * out[0] - tangential * out[1], -normal * out[1] + tangential * out[0])
    return force, place, ca.SX(0), spring * depth / 2.0, (normal - spring) * closing + tangential * sideways


def _ring(
    hitch: tuple[float, float],
    centre: tuple[float, float],
    rod: Vector,
    velocity: Vector,
    omega: ca.SX,
    p: Mapping[str, ca.SX],
) -> tuple[Vector, Vector, ca.SX, ca.SX, ca.SX]:
    """A rod in the ring: a spring and damper both ways, and the friction torque of the pin; returns as `_push`."""
    place = (ca.SX(hitch[0] - centre[0]), ca.SX(hitch[1] - centre[1]))
    stretch = (rod[0] - place[0], rod[1] - place[1])
    slip = (velocity[0] + omega * place[1], velocity[1] - omega * place[0])
    force = tuple(p["stiffness"] * d + p["damping"] * rate for d, rate in zip(stretch, slip, strict=True))
    # The root's small addend keeps its derivative finite where there is no force.
    size = ca.sqrt(force[0] ** 2 + force[1] ** 2 + 1e-16)
    torque = -p["pin_radius"] * size * omega / ca.sqrt(omega**2 + p["creep"] ** 2)
    stored = p["stiffness"] * (stretch[0] ** 2 + stretch[1] ** 2) / 2.0
    lost = p["damping"] * (slip[0] ** 2 + slip[1] ** 2) - torque * omega
    return (force[0], force[1]), place, torque, stored, lost


def _floor(
    leg: LegEquations, theta: ca.SX, velocity: Vector, omega: ca.SX, p: Mapping[str, ca.SX]
) -> tuple[Vector, ca.SX, ca.SX]:
    """Force (world) and torque of the floor on the slider, and the power it takes.

    At every point the traction is the gradient of h(v) = s + m0 v_m + n0 v_n, the offset ellipse's (Ma & Rodriguez
    2018, Eq. 2), with s = sqrt(mu_a^2 v_m^2 + mu_b^2 v_n^2 + mu_a mu_b creep^2): convex, smooth, exact far above creep.
    """
    vm, vn = _turned(velocity, -p["phi"])
    fading, force_m, force_n, torque, power = p["mu_a"] * p["mu_b"] * p["creep"] ** 2, 0.0, 0.0, 0.0, 0.0
    for point, weight in zip(leg.footprint.positions, leg.footprint.weights, strict=True):
        lever = (point[0] - leg.centre[0], point[1] - leg.centre[1])
        lever_m, lever_n = _turned(lever, theta - p["phi"])
        along, across = vm - omega * lever_n, vn + omega * lever_m
        s = ca.sqrt((p["mu_a"] * along) ** 2 + (p["mu_b"] * across) ** 2 + fading)
        f, g = p["m0"] + p["mu_a"] ** 2 * along / s, p["n0"] + p["mu_b"] ** 2 * across / s
        force_m, force_n = force_m - weight * f, force_n - weight * g
        torque -= weight * (lever_m * g - lever_n * f)
        power += weight * (f * along + g * across)
    return _turned((force_m, force_n), p["phi"]), torque, power


def nearest_place(outline: Outline, x: ca.SX, y: ca.SX) -> Vector:
    """Return where a convex outline is nearest to the point (x, y) outside it; all in one frame and unit.

    Raises InvalidInput for a concave outline, which a rod may touch in two places at once.
    """
    if isinstance(outline, Ellipse):
        # Newton on the eccentric angle at which the lever to the point is normal to the outline.
        a, b = outline.semi_x, outline.semi_y
        angle = ca.atan2(a * y, b * x)
        for _ in range(_NEWTON_STEPS):
            c, s = ca.cos(angle), ca.sin(angle)
            slope = (a**2 - b**2) * s * c - a * x * s + b * y * c
            angle -= slope / ((a**2 - b**2) * (c**2 - s**2) - a * x * c - b * y * s)
        return a * ca.cos(angle), b * ca.sin(angle)
    if not outline.is_convex:
        raise InvalidInput(
            "the dynamic simulation needs a convex outline, since a rod touches a concave one in two places at once: "
            "use the quasi-static model"
        )
    nearest, least = (ca.SX(0), ca.SX(0)), ca.SX(np.inf)
    for a, b in zip(outline.array, np.roll(outline.array, -1, axis=0), strict=True):
        side = b - a
        share = ((x - a[0]) * side[0] + (y - a[1]) * side[1]) / float(side @ side)
        share = ca.fmin(ca.fmax(share, 0.0), 1.0)
        place = (a[0] + share * side[0], a[1] + share * side[1])
        square = (x - place[0]) ** 2 + (y - place[1]) ** 2
        nearest = tuple(ca.if_else(square < least, new, old) for new, old in zip(place, nearest, strict=True))
        least = ca.fmin(least, square)
    return nearest


def _turned(vector: Vector, angle: ca.SX) -> Vector:
    """A vector turned counter-clockwise."""
    c, s = ca.cos(angle), ca.sin(angle)
    return c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]
