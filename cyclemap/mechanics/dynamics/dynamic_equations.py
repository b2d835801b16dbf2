"""The equations of motion of the pushed or dragged slider, as CasADi expressions: the one place they are written.

Newton-Euler (Ma & Rodriguez 2018, Eq. 3): M q'' = F_pusher + F_friction, q = (x, y, theta) of the centre of mass.
Lengths are in extents L of the footprint, speeds in rod speeds v, forces in weights m g. Then M = Fr diag(1, 1, J) with
the Froude number Fr = v^2 / (g L) and J = I / (m L^2): the speed enters squared, and nowhere else.
"""

from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

import casadi as ca
import numpy as np

from cyclemap.mechanics.dynamics.nearest_place import nearest_place
from cyclemap.mechanics.footprint import PointFootprint
from cyclemap.mechanics.outline import Outline

STATE = ("x", "y", "theta", "vx", "vy", "omega")
# How a leg lies (rod's start and velocity, duration), then what it meets; creep: the speed below which friction fades.
LEG = ("rod_x", "rod_y", "rod_vx", "rod_vy", "duration")
PHYSICS = (
    *("froude", "inertia", "stiffness", "damping", "radius", "pusher_mu", "pin_radius", "creep"),
    *("mu_a", "mu_b", "m0", "n0", "phi"),
)
PARAMETERS = (*LEG, *PHYSICS)
# What is integrated along: the rod's work, and what floor and contact dissipate.
WORKS = ("rod", "floor", "contact")

Vector = tuple[ca.SX, ca.SX]
Named = Mapping[str, ca.SX]


class Body(NamedTuple):
    """What the contact sees, in the slider's axes: rod from the centre of mass, their relative velocity, the spin."""

    rod: Vector
    velocity: Vector
    omega: ca.SX

    def slip(self, place: Vector) -> Vector:
        """Velocity of the rod relative to the slider's material at a place."""
        return self.velocity[0] + self.omega * place[1], self.velocity[1] - self.omega * place[0]


class Load(NamedTuple):
    """Force of the rod on the slider at a place (its axes), torque beyond it, energy stored, power dissipated."""

    force: Vector
    place: Vector
    torque: ca.SX
    stored: ca.SX
    lost: ca.SX


class DynamicEquations(NamedTuple):
    """The initial value problem of one leg over its duration (time 0 to 1), and what is to be seen of it.

    observed : (time, state, parameters) -> force on the slider (2) and its place (2), world frame; energy stored.
    """

    problem: dict[str, ca.SX]
    observed: ca.Function


@lru_cache(maxsize=64)
def dynamic_equations(
    footprint: PointFootprint, centre: tuple[float, float], touched: Outline | tuple[float, float]
) -> DynamicEquations:
    """Return the equations of a slider on support points; all lengths in extents of the footprint.

    `centre`: its centre of mass; `touched`: the outline that a rod pushes, or the place of the ring that it drags.
    """
    time, state, parameters = ca.SX.sym("time"), ca.SX.sym("state", 6), ca.SX.sym("parameters", len(PARAMETERS))
    p = dict(zip(PARAMETERS, ca.vertsplit(parameters), strict=True))
    q = dict(zip(STATE, ca.vertsplit(state), strict=True))
    rod = (p["rod_x"] + p["rod_vx"] * p["duration"] * time, p["rod_y"] + p["rod_vy"] * p["duration"] * time)
    body = _body(q, rod, (p["rod_vx"], p["rod_vy"]))
    load = _ring_load(touched, centre, body, p) if isinstance(touched, tuple) else _push(touched, centre, body, p)
    floor, floor_torque, floor_loss = _floor_friction(footprint, centre, q, p)
    force = _turned(load.force, q["theta"])
    torque = floor_torque + load.torque + load.place[0] * load.force[1] - load.place[1] * load.force[0]
    forces = ca.vertcat(floor[0] + force[0], floor[1] + force[1], torque / p["inertia"])
    rates = ca.vertcat(state[3:], forces / p["froude"])
    powers = ca.vertcat(force[0] * p["rod_vx"] + force[1] * p["rod_vy"], floor_loss, load.lost)
    problem = {"t": time, "x": state, "p": parameters, "ode": p["duration"] * rates, "quad": p["duration"] * powers}
    lever = _turned(load.place, q["theta"])
    seen = ca.vertcat(*force, q["x"] + lever[0], q["y"] + lever[1], load.stored)
    return DynamicEquations(problem, ca.Function("observed", [time, state, parameters], [seen]))


def _body(q: Named, rod: Vector, velocity: Vector) -> Body:
    lever, relative = (rod[0] - q["x"], rod[1] - q["y"]), (velocity[0] - q["vx"], velocity[1] - q["vy"])
    return Body(_turned(lever, -q["theta"]), _turned(relative, -q["theta"]), q["omega"])


def _push(outline: Outline, centre: tuple[float, float], body: Body, p: Named) -> Load:
    """A rod on the outline: spring and damper that never pull, and Coulomb friction faded below the creep speed."""
    x, y = nearest_place(outline, body.rod[0] + centre[0], body.rod[1] + centre[1])
    place = (x - centre[0], y - centre[1])
    lever = (body.rod[0] - place[0], body.rod[1] - place[1])
    distance = ca.sqrt(lever[0] ** 2 + lever[1] ** 2)
    out = (lever[0] / distance, lever[1] / distance)
    slip = body.slip(place)
    depth, closing = p["radius"] - distance, -slip[0] * out[0] - slip[1] * out[1]
    sideways = -slip[0] * out[1] + slip[1] * out[0]
    touches = depth > 0.0
    normal = ca.if_else(touches, ca.fmax(p["stiffness"] * depth + p["damping"] * closing, 0.0), 0.0)
    tangential = p["pusher_mu"] * normal * sideways / ca.sqrt(sideways**2 + p["creep"] ** 2)
    force = (-normal * out[0] - tangential * out[1], -normal * out[1] + tangential * out[0])
    spring = ca.if_else(touches, p["stiffness"] * depth, 0.0)
    lost = (normal - spring) * closing + tangential * sideways
    return Load(force, place, ca.SX(0), spring * depth / 2.0, lost)


def _ring_load(hitch: tuple[float, float], centre: tuple[float, float], body: Body, p: Named) -> Load:
    """A rod in the ring: a spring and damper both ways, and the friction torque of the pin."""
    place = (ca.SX(hitch[0] - centre[0]), ca.SX(hitch[1] - centre[1]))
    stretch = (body.rod[0] - place[0], body.rod[1] - place[1])
    slip = body.slip(place)
    force = tuple(p["stiffness"] * d + p["damping"] * rate for d, rate in zip(stretch, slip, strict=True))
    # The root's small addend keeps its derivative finite where there is no force.
    size = ca.sqrt(force[0] ** 2 + force[1] ** 2 + 1e-16)
    torque = -p["pin_radius"] * size * body.omega / ca.sqrt(body.omega**2 + p["creep"] ** 2)
    stored = p["stiffness"] * (stretch[0] ** 2 + stretch[1] ** 2) / 2.0
    lost = p["damping"] * (slip[0] ** 2 + slip[1] ** 2) - torque * body.omega
    return Load((force[0], force[1]), place, torque, stored, lost)


def _floor_friction(
    footprint: PointFootprint, centre: tuple[float, float], q: Named, p: Named
) -> tuple[Vector, ca.SX, ca.SX]:
    """Force (world) and torque of the floor on the slider, and the power it takes.

    At every point the traction is the gradient of h(v) = s + m0 v_m + n0 v_n, the offset ellipse's (Ma & Rodriguez
    2018, Eq. 2), with s = sqrt(mu_a^2 v_m^2 + mu_b^2 v_n^2 + mu_a mu_b creep^2): convex, smooth, exact far above creep.
    """
    phi = p["phi"] - q["theta"]
    vm, vn = _turned((q["vx"], q["vy"]), -p["phi"])
    levers = np.asarray(footprint.positions) - centre
    fading, force_m, force_n, torque, power = p["mu_a"] * p["mu_b"] * p["creep"] ** 2, 0.0, 0.0, 0.0, 0.0
    for lever, weight in zip(levers, footprint.weights, strict=True):
        lever_m, lever_n = _turned((float(lever[0]), float(lever[1])), -phi)
        along, across = vm - q["omega"] * lever_n, vn + q["omega"] * lever_m
        s = ca.sqrt((p["mu_a"] * along) ** 2 + (p["mu_b"] * across) ** 2 + fading)
        f, g = p["m0"] + p["mu_a"] ** 2 * along / s, p["n0"] + p["mu_b"] ** 2 * across / s
        force_m, force_n = force_m - weight * f, force_n - weight * g
        torque -= weight * (lever_m * g - lever_n * f)
        power += weight * (f * along + g * across)
    return _turned((force_m, force_n), p["phi"]), torque, power


def _turned(vector: tuple[object, object], angle: ca.SX) -> Vector:
    """A vector turned counter-clockwise."""
    c, s = ca.cos(angle), ca.sin(angle)
    return c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]
