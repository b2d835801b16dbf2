"""One Runge-Kutta step of a pushed or dragged slider as a single CasADi function, with its contact solved inside.

The state is (theta, coordinate): orientation, and place of the rod on its contact curve. All of a step's stages are
solved by a fixed number of Newton iterations from a linear predictor; the last correction tells whether they converged.
"""

from functools import lru_cache

import casadi as ca
import numpy as np

from cyclemap.mechanics.contact_equations import SLIDE, STICK, ContactFunctions, contact_functions
from cyclemap.mechanics.footprint import PointFootprint
from cyclemap.mechanics.pressure_family import PressureFamily
from cyclemap.mechanics.runge_kutta import ERROR, STAGES, A, B, C

# Parameters of a motion, in order. geometry: side (x, y, tx, ty, normal), corner (x, y), ellipse (semi_x, semi_y),
# ring (x, y), padded with zeros; smu: pusher friction, negative when the rod slides clockwise over the slider, or
# radius of the ring's friction circle, negative when the object turns clockwise.
PARAMETERS = (
    *("direction", "radius", "smu", "mu_a", "mu_b", "m0", "n0", "phi", "rim_share", "warp_a", "warp_b"),
    *("geometry_0", "geometry_1", "geometry_2", "geometry_3", "geometry_4", "low", "high"),
)
MARGINS = ("approach", "after_low", "before_high", "mode_first", "mode_second")

# Newton iterations a stage, for patches and for support points, whose friction is less smooth.
_ITERATIONS_PATCH, _ITERATIONS_POINTS = 2, 3
# Functions up to this many operations a Newton iteration are unrolled into scalars, larger ones are called.
_UNROLLED = 2000


@lru_cache(maxsize=256)
def step_function(pressure: PressureFamily, kind: str, mode: str, near: bool) -> ca.Function:
    """Build (once) the step of a normalised footprint's family, kind of contact, mode and regime.

    (state 2, unknowns u, h, parameters) -> (error, last Newton correction, least far, greatest far) followed, for each
    of the 6 stages and the end, by state 2, slope 2, margins 5, unknowns u.
    """
    contact = _contact_functions(pressure, mode, near)
    iterations = _ITERATIONS_POINTS if isinstance(pressure.footprint, PointFootprint) else _ITERATIONS_PATCH
    return _step(contact, _arguments(kind), _rate(kind, mode), iterations)


@lru_cache(maxsize=256)
def variation_function(
    pressure: PressureFamily, kind: str, mode: str, near: bool, wanted: tuple[int, ...]
) -> ca.Function:
    """Build (once) the derivatives of a motion's slope, its unknowns being solved for.

    (state, unknowns, parameters) -> derivatives by the state and by the `wanted` ones of PARAMETERS, by columns; far.
    """
    return _variation(_contact_functions(pressure, mode, near), _arguments(kind), _rate(kind, mode), wanted)


def _contact_functions(pressure: PressureFamily, mode: str, near: bool) -> ContactFunctions:
    """Return the equations of a mode; without friction a ring is a contact that sticks."""
    return contact_functions(pressure, STICK if mode == "ring" else mode, near)


def _contact(kind: str, coordinate: ca.SX, geometry: ca.SX, radius: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
    """Contact point, angle of the normal, and travel of the rod's centre along its curve per unit of coordinate."""
    g = [geometry[i] for i in range(5)]
    if kind == "side":
        return g[0] + coordinate * g[2], g[1] + coordinate * g[3], g[4], ca.SX(1)
    if kind == "corner":
        return g[0], g[1], coordinate, radius
    if kind == "ring":
        return g[0], g[1], ca.SX(0), ca.SX(1)
    c, s = ca.cos(coordinate), ca.sin(coordinate)
    speed = ca.sqrt((g[0] * s) ** 2 + (g[1] * c) ** 2)
    turning = g[0] * g[1] / speed**2
    return g[0] * c, g[1] * s, ca.atan2(g[0] * s, g[1] * c), speed + radius * turning


@lru_cache(maxsize=16)
def _arguments(kind: str) -> ca.Function:
    """(state, parameters) -> the contact equations' arguments."""
    state, p = ca.SX.sym("state", 2), ca.SX.sym("parameters", len(PARAMETERS))
    x, y, normal, _ = _contact(kind, state[1], p[11:16], p[1])
    return ca.Function("arguments", [state, p], [ca.vertcat(state[0], p[0], x, y, normal, p[2:11])])


@lru_cache(maxsize=16)
def _rate(kind: str, mode: str) -> ca.Function:
    """(state, unknowns, forces, parameters) -> (slope, margins); forces: compression and tangential, per unit load."""
    unknowns = 2 if mode == SLIDE else 1
    state, p = ca.SX.sym("state", 2), ca.SX.sym("parameters", len(PARAMETERS))
    z, forces = ca.SX.sym("unknowns", unknowns), ca.SX.sym("forces", 2)
    _, _, normal, metric = _contact(kind, state[1], p[11:16], p[1])
    off = normal + state[0] - p[0]
    approach, along = -ca.cos(off), -ca.sin(off)
    room = (state[1] - p[16], p[17] - state[1])
    if kind == "ring":
        slope, margins = ca.vertcat(z[0], 0), ca.SX.ones(5)
    elif mode == STICK:
        slope = ca.vertcat(z[0], -z[0] * p[1] / metric)
        margins = ca.vertcat(approach, *room, p[2] * forces[0] - forces[1], p[2] * forces[0] + forces[1])
    else:
        omega, slip = approach * z[0], along - approach * z[1]
        slope = ca.vertcat(omega, (slip - omega * p[1]) / metric)
        margins = ca.vertcat(approach, *room, ca.sign(p[2]) * slip, 1)
    return ca.Function("rate", [state, z, forces, p], [slope, margins])


def _step(contact: ContactFunctions, arguments: ca.Function, rate: ca.Function, iterations: int) -> ca.Function:
    solver = contact.solver
    count = solver.size1_in(0)
    state, h, p = ca.MX.sym("state", 2), ca.MX.sym("h"), ca.MX.sym("parameters", len(PARAMETERS))
    guess = ca.MX.sym("unknowns", count)
    slope_of_unknowns = _solution_slope(contact, arguments, ())(state, guess, p)
    states: list[ca.MX] = []
    unknowns: list[ca.MX] = []
    slopes: list[ca.MX] = []
    stages: list[ca.MX] = []
    corrections: list[ca.MX] = []
    ratios: list[ca.MX] = []

    def solve(at: ca.MX, nearby: int | None) -> None:
        q = arguments(at, p)
        z = guess if nearby is None else unknowns[nearby] + slope_of_unknowns @ (at - states[nearby])
        # The start comes solved; its one iteration certifies that it is.
        for _ in range(iterations if nearby is not None else 1):
            found = solver(z, q)
            step = found[count : 2 * count]
            z = z + step
        slope, margins = rate(at, z, found[-3:-1], p)
        states.append(at)
        unknowns.append(z)
        slopes.append(slope)
        stages.append(ca.vertcat(at, slope, margins, z))
        corrections.append(step)
        ratios.append(found[-1])

    solve(state, None)
    for i in range(1, STAGES + 1):
        weights, place = (A[i, :i], C[i]) if i < STAGES else (B, 1.0)
        # Newton starts at the solved stage that lies nearest, moved along the solution's slope.
        nearby = int(np.argmin(np.abs(C[:i] - place)))
        solve(state + h * sum(float(a) * k for a, k in zip(weights, slopes, strict=True) if a), nearby)
    correction, far = ca.mmax(ca.fabs(ca.vertcat(*corrections))), ca.vertcat(*ratios)
    certificate = ca.vertcat(h * _error(slopes), correction, ca.mmin(far), ca.mmax(far))
    outputs = ca.vertcat(certificate, *stages)
    function = ca.Function("step", [state, guess, h, p], [outputs])
    return _unrolled(function, solver)


def _error(slopes: list[ca.MX]) -> ca.MX:
    """Error estimate per unit length."""
    return ca.mmax(ca.fabs(sum(float(e) * k for e, k in zip(ERROR, slopes, strict=True) if e)))


def _solution_slope(contact: ContactFunctions, arguments: ca.Function, wanted: tuple[int, ...]) -> ca.Function:
    """(state, unknowns, parameters) -> derivatives of the solved unknowns by the state and the wanted parameters."""
    tangent = contact.tangent
    state, p = ca.SX.sym("state", 2), ca.SX.sym("parameters", len(PARAMETERS))
    chain = ca.jacobian(arguments(state, p), ca.vertcat(state, p[list(wanted)]))
    chained = ca.Function("chain", [state, p], [chain])
    s, z, q = ca.MX.sym("state", 2), ca.MX.sym("unknowns", tangent.size1_in(0)), ca.MX.sym("p", len(PARAMETERS))
    return ca.Function("slope", [s, z, q], [tangent(z, arguments(s, q)) @ chained(s, q)])


def _variation(
    contact: ContactFunctions, arguments: ca.Function, rate: ca.Function, wanted: tuple[int, ...]
) -> ca.Function:
    solver = contact.solver
    state, p = ca.SX.sym("state", 2), ca.SX.sym("parameters", len(PARAMETERS))
    z = ca.SX.sym("unknowns", rate.size1_in(1))
    slope = rate(state, z, ca.SX.zeros(2), p)[0]
    by_wanted = ca.jacobian(slope, ca.vertcat(state, p[list(wanted)]))
    direct = ca.Function("direct", [state, z, p], [by_wanted, ca.jacobian(slope, z)])
    s, u, q = ca.MX.sym("state", 2), ca.MX.sym("unknowns", z.shape[0]), ca.MX.sym("p", len(PARAMETERS))
    explicit, by_unknowns = direct(s, u, q)
    total = explicit + by_unknowns @ _solution_slope(contact, arguments, wanted)(s, u, q)
    far = solver(u, arguments(s, q))[-1]
    return _unrolled(ca.Function("variation", [s, u, q], [ca.vertcat(ca.vec(ca.densify(total)), far)]), solver)


def _unrolled(function: ca.Function, solver: ca.Function) -> ca.Function:
    """Return the function in scalars, where the contact's equations are small enough for that."""
    small = solver.is_a("SXFunction") and solver.n_instructions() <= _UNROLLED
    return function.expand() if small else function
