"""How the end of a phase varies with its start and its parameters: its variational equation, step by step."""

import math
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
# Unknowns inside a step that a Newton iteration corrects by more than this are solved first.
UNSOLVED = 1e-5
# Lobatto's places along a step, for its method IIIA of order 6 (Hairer & Wanner 1996, IV.5).
PLACES: NDArray[np.float64] = np.array((0.0, 0.5 - math.sqrt(0.05), 0.5 + math.sqrt(0.05), 1.0))


def _integrals() -> NDArray[np.float64]:
    """Integrals (4, 4) of the Lagrange polynomials of the places (by columns) from zero to each place (by rows)."""
    columns = []
    for k, place in enumerate(PLACES):
        others = np.delete(PLACES, k)
        columns.append(np.polynomial.Polynomial.fromroots(others).integ()(PLACES) / np.prod(place - others))
    return np.array(columns).T


def _hermite(derivatives: int) -> NDArray[np.float64]:
    """Weights (2, 2 (1 + d)) of values and d derivatives at 0 and at 1 in the polynomial through them, inside a step."""
    count = 2 * (derivatives + 1)
    basis = [np.polynomial.Polynomial.basis(power) for power in range(count)]
    known = [[power.deriv(order)(end) for power in basis] for order in range(derivatives + 1) for end in (0.0, 1.0)]
    inside = np.vander(PLACES[1:-1], count, increasing=True)
    return np.asarray(np.linalg.solve(np.array(known).T, inside.T).T)


COLLOCATION = _integrals()
# Inside a step states lie on polynomials of degree five between its ends, unknowns on such of degree three.
STATES_INSIDE, UNKNOWNS_INSIDE = _hermite(2), _hermite(1)

_SMU, _RIM_SHARE = PARAMETERS.index("smu"), PARAMETERS.index("rim_share")
_WARP = (PARAMETERS.index("warp_a"), PARAMETERS.index("warp_b"))


@dataclass(frozen=True)
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

    The variational equation is solved by collocation at Lobatto's places of each step, to order 6.
    """
    motion, steps = run_phase.motion, run_phase.phase.steps
    lengths = np.array([taken.h for taken in steps])
    wanted = np.flatnonzero(np.any(parameters != 0.0, axis=1))
    ends = _nodes(motion, np.array([steps[0].stages[0], *(taken.stages[-1] for taken in steps)]), wanted)
    inside = _inside(motion, ends, lengths, wanted)
    jacobians = np.stack([ends.jacobians[:-1], *inside, ends.jacobians[1:]])
    varied = start
    for tangent in _step_tangents(jacobians, lengths):
        varied = tangent[:, :2] @ varied + tangent[:, 2:] @ parameters[wanted]
    return varied


def _step_tangents(jacobians: Array, lengths: Array) -> Array:
    """Derivatives (n, 2, 2 + w) of the ends of steps by start and wanted parameters, from those of slopes (4, n, ...).

    v_i = v_0 + h sum_j a_ij g_j(v_j) with slopes g that are linear in v, solved for v_1, v_2, v_3.
    """
    h, start = lengths[:, None, None], np.eye(2, jacobians.shape[-1])
    # What of the slopes does not depend on the variation at the same place.
    given = np.where(np.arange(jacobians.shape[-1]) < 2, 0.0, jacobians)
    given[0] = jacobians[0]
    known = [start + h * np.tensordot(row, given, 1) for row in COLLOCATION[1:]]
    implicit = [
        [(i == j) * np.eye(2) - h * COLLOCATION[i, j] * jacobians[j, ..., :2] for j in (1, 2, 3)] for i in (1, 2, 3)
    ]
    return np.asarray(np.linalg.solve(np.block(implicit), np.concatenate(known, axis=1))[:, 4:])


def _inside(motion: Motion, ends: _Nodes, lengths: Array, wanted: NDArray[np.intp]) -> Array:
    """Derivatives (2, n, 2, 2 + w) of the slopes at the places inside steps, from their ends."""
    h, count = lengths[:, None], len(lengths)
    rows = np.zeros((2 * count, ends.rows.shape[1]))
    rows[:, STATE] = _between(STATES_INSIDE, h, ends.rows[:, STATE], ends.rows[:, SLOPE], ends.bend)
    rows[:, UNKNOWN] = _between(UNKNOWNS_INSIDE, h, ends.rows[:, UNKNOWN], ends.drift)
    nodes = _nodes(motion, rows, wanted)
    unsolved = np.flatnonzero(~(nodes.correction <= UNSOLVED))
    if unsolved.size:
        solved = np.array([_solved(motion, row) for row in rows[unsolved]])
        nodes.jacobians[unsolved] = _nodes(motion, solved, wanted).jacobians
    return nodes.jacobians.reshape(2, count, *nodes.jacobians.shape[1:])


def _between(weights: Array, h: Array, *derivatives: Array) -> Array:
    """Values (2 n, k) inside steps of lengths h (n, 1), from values and derivatives (n + 1, k) at their ends."""
    given = [h**order * side for order, values in enumerate(derivatives) for side in (values[:-1], values[1:])]
    return np.asarray(np.concatenate(np.tensordot(weights, given, 1)))


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
    found = np.empty((0, len(rows)))
    for near in (True, False):
        chosen = np.ones(len(rows), bool) if near else ~(found[-1] <= far_ratio(pressure))
        if chosen.any():
            function = variation_function(*law, near, tuple(wanted.tolist()))
            values = np.array(function(states[:, chosen], unknowns[:, chosen], motion.parameters))
            found = values if near else found
            found[:, chosen] = values
    slopes, drift = np.split(found[:-2], [2 * (2 + wanted.size)])
    jacobians = slopes.reshape(2 + wanted.size, 2, -1).transpose(2, 1, 0)
    drift = drift.T
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
