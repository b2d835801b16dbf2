"""How the end of a phase varies with its start and its parameters: its variational equation, step by step."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.contact_equations import RING_FRICTION
from cyclemap.mechanics.footprint import PointFootprint
from cyclemap.mechanics.motion import RING, Motion
from cyclemap.mechanics.motion_functions import PARAMETERS, variation_function
from cyclemap.mechanics.patch_integrals import far_ratio
from cyclemap.mechanics.pressure_family import PressureFamily
from cyclemap.mechanics.push_run import RunPhase
from cyclemap.mechanics.runge_kutta import MIDDLE_STATE, MIDDLE_VALUE, SLOPE, STATE, UNKNOWN

Array = NDArray[np.float64]

# A support point slower than this (unit rod travel) has a kink beneath it: tangents are then taken by differences.
STILL = 1e-7
_DIFFERENCE = 1e-6
# Unknowns in the middle of a step that a Newton iteration corrects by more than this are solved first.
UNSOLVED = 1e-5

_SMU, _RIM_SHARE = PARAMETERS.index("smu"), PARAMETERS.index("rim_share")
_WARP = (PARAMETERS.index("warp_a"), PARAMETERS.index("warp_b"))


def vary_phase(run_phase: RunPhase, start: Array, parameters: Array) -> Array:
    """Return the variation (2, k) of the state at the end of a phase.

    `start` (2, k): variation of its start; `parameters` (18, k): variation of the motion's PARAMETERS. The phase's
    steps keep their lengths: rates are continuous across its end, so that where it lies does not matter to first order.

    The variational equation is solved by Lobatto's method of order 4 from the ends and the middles of the steps.
    """
    motion, steps = run_phase.motion, run_phase.phase.steps
    lengths, stages = np.array([taken.h for taken in steps]), np.array([taken.stages for taken in steps])
    wanted = np.flatnonzero(np.any(parameters != 0.0, axis=1))
    rows = np.concatenate([stages[:1, 0], stages[:, -1], _middles(stages, lengths)])
    jacobians = _slope_jacobians(motion, rows, wanted)
    varied = start
    for tangent in _step_tangents(jacobians[: len(steps) + 1], jacobians[len(steps) + 1 :], lengths):
        varied = tangent[:, :2] @ varied + tangent[:, 2:] @ parameters[wanted]
    return varied


def _middles(stages: Array, lengths: Array) -> Array:
    """The middles (n, 9 + u) of steps with stages (n, 11, 9 + u), as far as they are known: states and unknowns."""
    rows = np.zeros_like(stages[:, 0])
    rows[:, STATE] = stages[:, 0, STATE] + lengths[:, None] * (MIDDLE_STATE @ stages[..., SLOPE])
    rows[:, UNKNOWN] = MIDDLE_VALUE @ stages[..., UNKNOWN]
    return rows


def _step_tangents(ends: Array, middles: Array, lengths: Array) -> Array:
    """Derivatives (n, 2, 2 + w) of the ends of steps by start and wanted parameters, from those of slopes.

    Of v' = g(v), linear in v: v1 = v0 + h/6 (g0 + 4 gm + g1) with vm = (v0 + v1)/2 + h/8 (g0 - g1), solved for v1
    (Lobatto's method IIIA; Hairer & Wanner 1996, IV.5).
    """
    h, first, last = lengths[:, None, None], ends[:-1], ends[1:]
    start = np.eye(2, ends.shape[-1])
    own, middle = last[..., :2], middles[..., :2]
    # What of the slopes does not depend on the variation at the same place.
    later, given = (np.where(np.arange(ends.shape[-1]) < 2, 0.0, slopes) for slopes in (last, middles))
    known = start + h / 6.0 * (first + 4.0 * given + later) + h * middle @ (start / 3.0 + h / 12.0 * (first - later))
    implicit = np.eye(2) - h / 6.0 * (own + 2.0 * middle) + h**2 / 12.0 * middle @ own
    return np.asarray(np.linalg.solve(implicit, known))


def _slope_jacobians(motion: Motion, rows: Array, wanted: NDArray[np.intp]) -> Array:
    """Derivatives (n, 2, 2 + w) of the slope by state and wanted parameters; rows that are not solved are, first."""
    jacobians, correction = _jacobians(motion, rows, wanted)
    unsolved = np.flatnonzero(~(correction <= UNSOLVED))
    if unsolved.size:
        solved = np.array([_solved(motion, row) for row in rows[unsolved]])
        jacobians[unsolved] = _jacobians(motion, solved, wanted)[0]
    return jacobians


def _solved(motion: Motion, row: Array) -> Array:
    """The row of a place, from a guess of its unknowns."""
    before, motion.unknowns = motion.unknowns, row[UNKNOWN].tolist()
    solved = motion.evaluate(row[STATE])
    motion.unknowns = before
    return solved


def _jacobians(motion: Motion, rows: Array, wanted: NDArray[np.intp]) -> tuple[Array, Array]:
    """Derivatives (n, 2, 2 + w) of the slope, and what a Newton iteration corrects of the unknowns (n,).

    Where a support point hardly moves they come from differences.
    """
    states, unknowns = rows[:, STATE].T, rows[:, UNKNOWN].T
    values = np.empty((2 * (2 + wanted.size) + 2, len(rows)))
    pressure = _pressure(motion, wanted)
    law = (pressure, motion.piece.kind, _family(motion, wanted))
    for near in (True, False):
        chosen = np.ones(len(rows), bool) if near else ~(values[-1] <= far_ratio(pressure))
        if chosen.any():
            function = variation_function(*law, near, tuple(wanted.tolist()))
            values[:, chosen] = np.array(function(states[:, chosen], unknowns[:, chosen], motion.parameters))
    jacobians = values[:-2].reshape(2 + wanted.size, 2, -1).transpose(2, 1, 0)
    for index in _kinked(motion, rows):
        jacobians[index] = _by_differences(motion, rows[index], wanted)
    return jacobians, values[-2]


def _pressure(motion: Motion, wanted: NDArray[np.intp]) -> PressureFamily:
    """Return the family whose equations hold every wanted parameter, also where its term vanishes."""
    pressure = motion.solver.pressure
    if any(index in wanted for index in _WARP):
        return replace(pressure, framed=True, warped=True)
    return replace(pressure, framed=True) if _RIM_SHARE in wanted else pressure


def _family(motion: Motion, wanted: NDArray[np.intp]) -> str:
    """Return the kind of equations that hold the wanted friction of the ring, also where it vanishes."""
    return RING_FRICTION if motion.mode == RING and _SMU in wanted else motion.family


def _kinked(motion: Motion, rows: Array) -> list[int]:
    """Rows at which a support point hardly moves."""
    footprint = motion.solver.footprint
    if not isinstance(footprint, PointFootprint):
        return []
    points, _ = footprint.quadrature
    still = []
    for index, row in enumerate(rows):
        contact, _ = motion.piece.contact(float(row[1]), motion.rod.radius)
        if np.hypot(*motion.velocities(row, contact, points).T).min() < STILL:
            still.append(index)
    return still


def _by_differences(motion: Motion, row: Array, wanted: NDArray[np.intp]) -> Array:
    """Central differences of the solved slope by state and wanted parameters, (2, 2 + w)."""
    base = np.concatenate([row[STATE], motion.parameters])
    columns = []
    for index in (0, 1, *(wanted + 2).tolist()):
        sides = []
        for sign in (1.0, -1.0):
            moved = base.copy()
            moved[index] += sign * _DIFFERENCE
            sides.append(motion.with_parameters(moved[2:], row[UNKNOWN].tolist()).evaluate(moved[:2])[2:4])
        columns.append((sides[0] - sides[1]) / (2.0 * _DIFFERENCE))
    return np.array(columns).T
