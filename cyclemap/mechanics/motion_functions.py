"""One Runge-Kutta step of a pushed or dragged slider as a single CasADi function, with its contact solved inside.

The state is (theta, coordinate): orientation, and place of the rod on its contact curve. All of a step's stages are
solved by a Newton iteration each: from the tangent and what earlier stages bend off it, on support points from the
nearest stage. The last correction tells whether they converged; where they did not, the step is made again from there.
"""

from collections.abc import Callable
from functools import lru_cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.contact_equations import SLIDE, STICK, ContactFunctions, contact_functions
from cyclemap.mechanics.footprint import PointFootprint
from cyclemap.mechanics.pressure_family import PressureFamily
from cyclemap.mechanics.runge_kutta import ERROR, LEAST_SHARE, ROUGH, STAGES, A, B, C

# Parameters of a motion, in order. geometry: side (x, y, tx, ty, normal), corner (x, y), ellipse (semi_x, semi_y),
# ring (x, y), padded with zeros; smu: pusher friction, negative when the rod slides clockwise over the slider, or
# radius of the ring's friction circle, negative when the object turns clockwise.
PARAMETERS = (
    *("direction", "radius", "smu", "mu_a", "mu_b", "m0", "n0", "phi", "rim_share", "warp_a", "warp_b"),
    *("geometry_0", "geometry_1", "geometry_2", "geometry_3", "geometry_4", "low", "high"),
)
DIRECTION = (PARAMETERS.index("direction"),)
MARGINS = ("approach", "after_low", "before_high", "mode_first", "mode_second")

# Newton iterations of each stage, and of the end, whose balance is what is looked at.
ITERATIONS = (*(1,) * STAGES, 2)
# Places of the stages and of the end along a step.
_PLACES = np.append(C, 1.0)


def _bend_weights() -> NDArray[np.float64]:
    """Weights (11, 11) of earlier stages: what their unknowns are off the tangent, over their places' squares, goes on.

    By a parabola through the last three; more would magnify what their states are off the path. The end, and the stage
    that lies there for the estimate alone, go by the first stage at that place.
    """
    weights = np.zeros((STAGES + 1, STAGES + 1))
    for i in range(2, STAGES + 1):
        used = np.arange(max(1 if i < 4 else 2, i - 3), i) if i < 9 else np.array((8,))
        for k in used:
            others = _PLACES[used[used != k]]
            lagrange = np.prod((_PLACES[i] - others) / (_PLACES[k] - others))
            weights[i, k] = lagrange * (_PLACES[i] / _PLACES[k]) ** 2
    return weights


BEND = _bend_weights()
# The stage nearest to each, of those before it.
NEAREST_STAGE = tuple(int(np.argmin(np.abs(_PLACES[: max(i, 1)] - _PLACES[i]))) for i in range(STAGES + 1))
_STATE, _SLOPE, _UNKNOWN = slice(0, 2), slice(2, 4), slice(9, None)
# Functions up to this many operations a Newton iteration are unrolled into scalars, larger ones are called.
_UNROLLED = 2000


@lru_cache(maxsize=256)
def variation_function(
    pressure: PressureFamily, kind: str, mode: str, near: bool, wanted: tuple[int, ...]
) -> ca.Function:
    """Build (once) the derivatives of a motion's slope, its unknowns being solved for.

    (state, unknowns, parameters) -> derivatives by the state and by the `wanted` ones of PARAMETERS, by columns; what a
    Newton iteration corrects of the unknowns, the most; far.
    """
    solver = _contact_functions(pressure, mode, near).solver
    count = solver.size1_in(0)
    s, u, q = _symbols(count)
    explicit, by_unknowns = rate_slopes(kind, mode, wanted)(s, u, q)
    total = explicit + by_unknowns @ _solution_slope(pressure, kind, mode, near, wanted)(s, u, q)
    found = solver(u, arguments_function(kind)(s, q))
    outputs = (ca.vec(total), _largest(found[count : 2 * count]), found[-1])
    return _unrolled(ca.Function("variation", [s, u, q], [ca.vertcat(*outputs)]), solver)


@lru_cache(maxsize=64)
def rate_slopes(kind: str, mode: str, wanted: tuple[int, ...]) -> ca.Function:
    """(state, unknowns, parameters) -> derivatives of the slope by state and wanted parameters; by the unknowns."""
    rate = rate_function(kind, mode)
    state, z, p = (ca.SX.sym(name, rate.size1_in(i)) for name, i in (("state", 0), ("unknowns", 1), ("parameters", 3)))
    slope = rate(state, z, ca.SX.zeros(2), p)[0]
    by_wanted = ca.jacobian(slope, ca.vertcat(state, p[list(wanted)]))
    return ca.Function("rate_slopes", [state, z, p], [ca.densify(by_wanted), ca.densify(ca.jacobian(slope, z))])


@lru_cache(maxsize=64)
def argument_slopes(kind: str, wanted: tuple[int, ...], count: int) -> ca.Function:
    """(state, parameters) -> derivatives of the first `count` arguments by the state and the wanted parameters."""
    state, p = ca.SX.sym("state", 2), ca.SX.sym("parameters", len(PARAMETERS))
    arguments = arguments_function(kind)(state, p)[:count]
    chain = ca.jacobian(arguments, ca.vertcat(state, p[list(wanted)]))
    return ca.Function("argument_slopes", [state, p], [ca.densify(chain)])


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
def arguments_function(kind: str) -> ca.Function:
    """(state, parameters) -> the contact equations' arguments."""
    state, p = ca.SX.sym("state", 2), ca.SX.sym("parameters", len(PARAMETERS))
    x, y, normal, _ = _contact(kind, state[1], p[11:16], p[1])
    return ca.Function("arguments", [state, p], [ca.vertcat(state[0], p[0], x, y, normal, p[2:11])])


@lru_cache(maxsize=16)
def rate_function(kind: str, mode: str) -> ca.Function:
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
    return ca.Function("rate", [state, z, forces, p], [ca.densify(slope), ca.densify(margins)])


@lru_cache(maxsize=256)
def stage_function(pressure: PressureFamily, kind: str, mode: str, near: bool) -> ca.Function:
    """Build (once) one Newton iteration of a motion's contact, and the motion with what it corrected.

    (state, unknowns, parameters) -> (state, slope, margins, unknowns), (correction, far, residual, normal force): the
    correction in the maximum norm; the residual relative to the mean friction coefficient, signed where it is single.
    """
    contact, arguments, rate = (
        _contact_functions(pressure, mode, near),
        arguments_function(kind),
        rate_function(kind, mode),
    )
    count = contact.solver.size1_in(0)
    state, z, p = _symbols(count)
    found = contact.solver(z, arguments(state, p))
    corrected = z + found[count : 2 * count]
    slope, margins = rate(state, corrected, found[-3:-1], p)
    row = ca.vertcat(state, slope, margins, corrected)
    residual = (found[0] if count == 1 else ca.sqrt(found[0] ** 2 + found[1] ** 2)) / ca.sqrt(p[3] * p[4])
    report = ca.vertcat(_largest(found[count : 2 * count]), found[-1], residual, found[-3])
    return _unrolled(ca.Function("stage", [state, z, p], [row, report]), contact.solver)


@lru_cache(maxsize=256)
def step_function(pressure: PressureFamily, kind: str, mode: str, near: bool, again: bool) -> ca.Function:
    """Build (once) the step of a normalised footprint's family, kind of contact, mode and regime.

    (state 2, unknowns u, h, parameters) -> (error, last Newton correction, least far, greatest far) followed, for each
    of the 10 stages and the end, by state 2, slope 2, margins 5, unknowns u. `again`: from the unknowns (11 u) of all
    stages and the end, as a call found them, in place of those of the start.
    """
    stage = stage_function(pressure, kind, mode, near)
    count, (state, _, p), h = stage.size1_in(1), _symbols(stage.size1_in(1)), ca.MX.sym("h")
    guess = ca.MX.sym("guess", count * (STAGES + 1) if again else count)
    course = None if again else _course(pressure, kind, mode, near, (state, guess, p))
    rows: list[ca.MX] = []
    reports: list[ca.MX] = []
    for i in range(STAGES + 1):
        at = state + h * _mixed(A[i, :i] if i < STAGES else B, [row[_SLOPE] for row in rows])
        z = guess[count * i : count * (i + 1)] if course is None else course(rows, at)
        for _ in range(ITERATIONS[i]):
            row, report = stage(at, z, p)
            z = row[_UNKNOWN]
        rows.append(row)
        reports.append(report)
    correction, far = (ca.vertcat(*(report[k] for report in reports)) for k in (0, 1))
    error, rough = (_largest(_mixed(weights, [row[_SLOPE] for row in rows])) for weights in (ERROR, ROUGH))
    # CasADi's maximum passes over what is not a number.
    error = ca.if_else(error >= 0, ca.fmax(error, LEAST_SHARE * h * rough), error)
    certificate = ca.vertcat(h * error, _largest(correction), ca.mmin(far), ca.mmax(far))
    step = ca.Function("step", [state, guess, h, p], [ca.vertcat(certificate, *rows)])
    return _unrolled(step, _contact_functions(pressure, mode, near).solver, shared=not again)


def _course(
    pressure: PressureFamily, kind: str, mode: str, near: bool, start: tuple[ca.MX, ca.MX, ca.MX]
) -> Callable[[list[ca.MX], ca.MX], ca.MX]:
    """Return where Newton's method starts, by the stages before and the state: (state, unknowns, parameters) at first.

    Along the tangent from the start, and bent as far as was seen; friction of support points bends abruptly: there the
    nearest stage is moved along the tangent.
    """
    slope = _solution_slope(pressure, kind, mode, near)(*start)
    smooth = not isinstance(pressure.footprint, PointFootprint)

    def predicted(rows: list[ca.MX], at: ca.MX) -> ca.MX:
        if not rows:
            return start[1]
        bends = [row[_UNKNOWN] - along(rows[0], row[_STATE]) for row in rows]
        if smooth:
            return along(rows[0], at) + _mixed(BEND[len(rows), : len(rows)], bends)
        return along(rows[NEAREST_STAGE[len(rows)]], at)

    def along(row: ca.MX, at: ca.MX) -> ca.MX:
        return row[_UNKNOWN] + slope @ (at - row[_STATE])

    return predicted


@lru_cache(maxsize=16)
def touch_function(kind: str) -> ca.Function:
    """(state, parameters) -> approach and motion along the outline of a rod that travels by one; the curve's metric."""
    state, p = ca.SX.sym("state", 2), ca.SX.sym("parameters", len(PARAMETERS))
    _, _, normal, metric = _contact(kind, state[1], p[11:16], p[1])
    off = normal + state[0] - p[0]
    return ca.Function("touch", [state, p], [ca.vertcat(-ca.cos(off), -ca.sin(off), metric)])


def _largest(values: ca.MX) -> ca.MX:
    return ca.mmax(ca.fabs(values))


def _mixed(weights: NDArray[np.float64], values: list[ca.MX]) -> ca.MX:
    return sum((float(weight) * value for weight, value in zip(weights, values, strict=True) if weight), ca.MX(0))


@lru_cache(maxsize=256)
def _solution_slope(
    pressure: PressureFamily, kind: str, mode: str, near: bool, wanted: tuple[int, ...] = ()
) -> ca.Function:
    """(state, unknowns, parameters) -> derivatives of the solved unknowns by the state and the wanted parameters."""
    contact = _contact_functions(pressure, mode, near)
    # The contact's place and the rod's direction cost little: of these the footprint's integrals know only theta.
    tangent = contact.state_tangent if set(wanted) <= set(DIRECTION) else contact.tangent
    s, z, q = _symbols(tangent.size1_in(0))
    by_arguments = tangent.call([z, arguments_function(kind)(s, q)])[0]
    slope = by_arguments @ argument_slopes(kind, wanted, tangent.size2_out(0))(s, q)
    return _unrolled(ca.Function("slope", [s, z, q], [slope]), contact.solver)


def _symbols(unknowns: int) -> tuple[ca.MX, ca.MX, ca.MX]:
    return ca.MX.sym("state", 2), ca.MX.sym("unknowns", unknowns), ca.MX.sym("parameters", len(PARAMETERS))


def _unrolled(function: ca.Function, solver: ca.Function, shared: bool = True) -> ca.Function:
    """Return the function in scalars, where the contact's equations are small enough for that.

    `shared`: look for those that are computed twice; a step that is made again has hardly any.
    """
    if not (solver.is_a("SXFunction") and solver.n_instructions() <= _UNROLLED):
        return function
    inputs = [ca.SX.sym(function.name_in(i), function.size1_in(i)) for i in range(function.n_in())]
    outputs = function.expand().call(inputs)
    return ca.Function(function.name(), inputs, ca.cse(outputs) if shared else outputs)
