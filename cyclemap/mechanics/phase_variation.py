"""How the end of a phase varies with its start and its parameters: its variational equation, step by step."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.contact_equations import RING_FRICTION
from cyclemap.mechanics.footprint import PointFootprint
from cyclemap.mechanics.motion import RING, Motion
from cyclemap.mechanics.motion_functions import PARAMETERS, variation_function
from cyclemap.mechanics.patch_integrals import far_ratio
from cyclemap.mechanics.pressure_family import PressureFamily
from cyclemap.mechanics.push_run import RunPhase
from cyclemap.mechanics.runge_kutta import SLOPE, STATE, UNKNOWN

Array = NDArray[np.float64]

# A support point slower than this (unit rod travel) has a kink beneath it: tangents are then taken by differences.
STILL = 1e-7
_DIFFERENCE = 1e-6
# Unknowns in the middle of a step that a Newton iteration corrects by more than this are solved first.
MIDDLE = 1e-5

_SMU, _RIM_SHARE = PARAMETERS.index("smu"), PARAMETERS.index("rim_share")
_WARP = (PARAMETERS.index("warp_a"), PARAMETERS.index("warp_b"))


@dataclass(frozen=True, eq=False)
class _Nodes:
    """Places of a motion: rows (n, 9 + u) as in a step, derivatives (n, 2, 2 + w) of their slopes by state and wanted
    parameters, what the unknowns do along the motion (n, u), and what a Newton iteration corrects of them (n,)."""

    rows: Array
    jacobians: Array
    drift: Array
    correction: Array

    @property
    def bend(self) -> Array:
        """What the slope does along the motion, (n, 2)."""
        return np.asarray(np.einsum("nij,nj->ni", self.jacobians[:, :, :2], self.rows[:, SLOPE]))


def vary_phase(run_phase: RunPhase, start: Array, parameters: Array) -> Array:
    """Return the variation (2, k) of the state at the end of a phase.

    `start` (2, k): variation of its start; `parameters` (18, k): variation of the motion's PARAMETERS. The phase's
    steps keep their lengths: rates are continuous across its end, so that where it lies does not matter to first order.

    The variational equation is solved by Lobatto's method of order 4 from the ends and the middles of the steps.
    """
    motion, steps = run_phase.motion, run_phase.phase.steps
    lengths = np.array([taken.h for taken in steps])
    wanted = np.flatnonzero(np.any(parameters != 0.0, axis=1))
    ends = _nodes(motion, np.array([steps[0].stages[0], *(taken.stages[-1] for taken in steps)]), wanted)
    varied = start
    for tangent in _step_tangents(ends.jacobians, _middles(motion, ends, lengths, wanted).jacobians, lengths):
        varied = tangent[:, :2] @ varied + tangent[:, 2:] @ parameters[wanted]
    return varied


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


def _middles(motion: Motion, ends: _Nodes, lengths: Array, wanted: NDArray[np.intp]) -> _Nodes:
    """The middles of steps: by polynomials of degree five (states) and three (unknowns) between their ends."""
    h, rows = lengths[:, None], (ends.rows[:-1] + ends.rows[1:]) / 2.0
    rows[:, STATE] += h * 5.0 / 32.0 * -np.diff(ends.rows[:, SLOPE], axis=0)
    rows[:, STATE] += h**2 / 64.0 * (ends.bend[:-1] + ends.bend[1:])
    rows[:, UNKNOWN] += h / 8.0 * -np.diff(ends.drift, axis=0)
    nodes = _nodes(motion, rows, wanted)
    unsolved = np.flatnonzero(~(nodes.correction <= MIDDLE))
    if unsolved.size:
        rows[unsolved] = [_solved(motion, row) for row in rows[unsolved]]
        nodes.jacobians[unsolved] = _nodes(motion, rows[unsolved], wanted).jacobians
    return nodes


def _solved(motion: Motion, row: Array) -> Array:
    """The row of a place, from a guess of its unknowns."""
    before, motion.unknowns = motion.unknowns, row[UNKNOWN].tolist()
    solved = motion.evaluate(row[STATE])
    motion.unknowns = before
    return solved


def _nodes(motion: Motion, rows: Array, wanted: NDArray[np.intp]) -> _Nodes:
    """Places with their derivatives; where a support point hardly moves by differences, the unknowns held."""
    states, unknowns = rows[:, STATE].T, rows[:, UNKNOWN].T
    pressure = _pressure(motion, wanted)
    law = (pressure, motion.piece.kind, _family(motion, wanted))
    found = np.empty((2 * (2 + wanted.size) + len(unknowns) + 2, len(rows)))
    for near in (True, False):
        chosen = np.ones(len(rows), bool) if near else ~(found[-1] <= far_ratio(pressure))
        if chosen.any():
            function = variation_function(*law, near, tuple(wanted.tolist()))
            found[:, chosen] = np.array(function(states[:, chosen], unknowns[:, chosen], motion.parameters))
    drift = found[-2 - len(unknowns) : -2].T
    jacobians = found[: -2 - len(unknowns)].reshape(2 + wanted.size, 2, -1).transpose(2, 1, 0)
    for index in _kinked(motion, rows):
        jacobians[index], drift[index] = _by_differences(motion, rows[index], wanted), 0.0
    return _Nodes(rows, jacobians, drift, found[-2])


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
