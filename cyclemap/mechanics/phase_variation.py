"""How the end of a phase varies with its start and its parameters: the tangent of the integration itself."""

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
from cyclemap.mechanics.runge_kutta import STAGES, STATE, UNKNOWN, A, B

Array = NDArray[np.float64]

# A support point slower than this (unit rod travel) has a kink beneath it: tangents are then taken by differences.
STILL = 1e-7
_DIFFERENCE = 1e-6

_SMU, _RIM_SHARE = PARAMETERS.index("smu"), PARAMETERS.index("rim_share")
_WARP = (PARAMETERS.index("warp_a"), PARAMETERS.index("warp_b"))


def vary_phase(run_phase: RunPhase, start: Array, parameters: Array) -> Array:
    """Return the variation (2, k) of the state at the end of a phase.

    `start` (2, k): variation of its start; `parameters` (18, k): variation of the motion's PARAMETERS. The phase's
    steps keep their lengths: rates are continuous across its end, so that where it lies does not matter to first order.
    """
    steps = run_phase.phase.steps
    stages = np.concatenate([taken.stages[:STAGES] for taken in steps])
    wanted = np.flatnonzero(np.any(parameters != 0.0, axis=1))
    jacobians = _slope_jacobians(run_phase.motion, stages, wanted).reshape(len(steps), STAGES, 2, -1)
    varied = start
    for tangent in _step_tangents(jacobians, np.array([taken.h for taken in steps])):
        varied = tangent[:, :2] @ varied + tangent[:, 2:] @ parameters[wanted]
    return varied


def _step_tangents(jacobians: Array, lengths: Array) -> Array:
    """Derivatives (n, 2, 2 + w) of the ends of steps by start and wanted parameters, from those of their slopes."""
    start = np.zeros((len(lengths), 2, jacobians.shape[-1]))
    start[:, 0, 0] = start[:, 1, 1] = 1.0
    h = lengths[:, None, None]
    slopes = np.zeros((STAGES, *start.shape))
    for i in range(STAGES):
        state = start + h * np.einsum("s,snij->nij", A[i, :i], slopes[:i])
        slopes[i] = jacobians[:, i, :, :2] @ state
        slopes[i, :, :, 2:] += jacobians[:, i, :, 2:]
    return np.asarray(start + h * np.einsum("s,snij->nij", B, slopes))


def _slope_jacobians(motion: Motion, stages: Array, wanted: NDArray[np.intp]) -> Array:
    """Derivatives (n, 2, 2 + w) of the slope by state and wanted parameters at solved stages (n, ...)."""
    states, unknowns = stages[:, STATE].T, stages[:, UNKNOWN].T
    values = np.empty((2 * (2 + wanted.size) + 1, len(stages)))
    pressure = _pressure(motion, wanted)
    law = (pressure, motion.piece.kind, _family(motion, wanted))
    for near in (True, False):
        chosen = np.ones(len(stages), bool) if near else ~(values[-1] <= far_ratio(pressure))
        if chosen.any():
            function = variation_function(*law, near, tuple(wanted.tolist()))
            found = function(states[:, chosen], unknowns[:, chosen], motion.parameters)
            values[:, chosen] = np.array(found).reshape(values.shape[0], -1)
    jacobians = values[:-1].reshape(2 + wanted.size, 2, -1).transpose(2, 1, 0)
    for index in _kinked(motion, stages):
        jacobians[index] = _by_differences(motion, stages[index], wanted)
    return jacobians


def _pressure(motion: Motion, wanted: NDArray[np.intp]) -> PressureFamily:
    """Return the family whose equations hold every wanted parameter, also where its term vanishes."""
    pressure = motion.solver.pressure
    if any(index in wanted for index in _WARP):
        return replace(pressure, framed=True, warped=True)
    return replace(pressure, framed=True) if _RIM_SHARE in wanted else pressure


def _family(motion: Motion, wanted: NDArray[np.intp]) -> str:
    """Return the kind of equations that hold the wanted friction of the ring, also where it vanishes."""
    return RING_FRICTION if motion.mode == RING and _SMU in wanted else motion.family


def _kinked(motion: Motion, stages: Array) -> list[int]:
    """Stages at which a support point hardly moves."""
    footprint = motion.solver.footprint
    if not isinstance(footprint, PointFootprint):
        return []
    points, _ = footprint.quadrature
    still = []
    for index, stage in enumerate(stages):
        contact, _ = motion.piece.contact(float(stage[1]), motion.rod.radius)
        if np.hypot(*motion.velocities(stage, contact, points).T).min() < STILL:
            still.append(index)
    return still


def _by_differences(motion: Motion, stage: Array, wanted: NDArray[np.intp]) -> Array:
    """Central differences of the solved slope by state and wanted parameters, (2, 2 + w)."""
    base = np.concatenate([stage[STATE], motion.parameters])
    columns = []
    for index in (0, 1, *(wanted + 2).tolist()):
        sides = []
        for sign in (1.0, -1.0):
            moved = base.copy()
            moved[index] += sign * _DIFFERENCE
            sides.append(motion.with_parameters(moved[2:], stage[UNKNOWN].tolist()).evaluate(moved[:2])[2:4])
        columns.append((sides[0] - sides[1]) / (2.0 * _DIFFERENCE))
    return np.array(columns).T
