"""The least correction on finitely many cells, as a linear programme, with primal and dual values computed afresh."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix, eye, hstack, kron, vstack

from cyclemap.errors import ConvergenceError
from cyclemap.maps.arcs import Array
from cyclemap.resets.least_noise.cycle_cells import CycleCells
from cyclemap.resets.least_noise.turn_costs import TurnCost

_TOLERANCE = 1e-10  # of HiGHS, on rows and reduced costs


@dataclass(frozen=True, eq=False)
class ProgrammeSolution:
    """masses : (cells,), the stationary law. potential : (cells,), ψ at the centres. primal ≥ dual : their values."""

    masses: Array
    potential: Array
    primal: float
    dual: float


def least_mean(values: Array, target: Array, allowed_tv: float) -> float:
    """min Σ s_i p_i over probabilities p within ``allowed_tv`` of ``target``: the worst mass moves to the best place.

    values, target : (n,). Exact to rounding.

    >>> round(least_mean(np.array([0.0, 1.0, 3.0]), np.array([0.2, 0.5, 0.3]), 0.4), 12)
    0.4
    """
    order = np.argsort(-values)
    above = np.cumsum(target[order]) - target[order]
    moved = np.clip(allowed_tv - above, 0.0, target[order])
    kept = float(np.dot(values[order], target[order] - moved))
    return kept + float(np.sum(moved)) * float(np.min(values))


def solve_by_flow(grid: CycleCells, allowed_tv: float) -> ProgrammeSolution:
    """Cost |ξ|: min h Σ |r_j| with r_j the mass that flows from centre j to the next (Beckmann 1952), 4N unknowns.

    Unknowns p, a, r⁺, r⁻ ≥ 0; C_f p - C p = div r; p - a ≤ target; Σ a ≤ ε.
    """
    count = grid.cells
    ahead = eye(count, format="csr") - csr_matrix(np.roll(np.eye(count), 1, axis=0))
    rows = hstack([grid.after - grid.before, csr_matrix((count, count)), -ahead, ahead])
    costs = np.concatenate([np.zeros(2 * count), np.full(2 * count, grid.width)])
    found = _solved(grid, allowed_tv, costs, rows)
    masses = _feasible(found.x[:count], grid.target_masses, allowed_tv)
    flow = np.cumsum((grid.after - grid.before) @ masses)
    primal = grid.width * float(np.sum(np.abs(flow - np.median(flow))))
    potential = np.asarray(found.eqlin.marginals[:count], dtype=np.float64)
    steepest = float(np.max(np.abs(np.diff(potential, append=potential[0]))))
    potential = potential / max(1.0, steepest / grid.width)
    worth = grid.before.T @ potential - grid.after.T @ potential
    return ProgrammeSolution(masses, potential, primal, max(0.0, least_mean(worth, grid.target_masses, allowed_tv)))


def solve_by_plan(grid: CycleCells, allowed_tv: float, cost: TurnCost) -> ProgrammeSolution:
    """Any cost: min Σ m_kj c(c_j - c_k), m the mass taken from centre k to centre j (Kantorovich 1942), N² unknowns.

    Rows: Σ_j m_kj = (C_f p)_k, Σ_k m_kj = (C p)_j; p - a ≤ target; Σ a ≤ ε.
    """
    count = grid.cells
    one, ones = eye(count, format="csr"), csr_matrix(np.ones((1, count)))
    nothing = csr_matrix((count, count))
    leave = hstack([-grid.after, nothing, kron(one, ones)])
    arrive = hstack([-grid.before, nothing, kron(ones, one)])
    prices = cost.of(grid.centres - grid.centres[:, None])
    costs = np.concatenate([np.zeros(2 * count), prices.ravel()])
    found = _solved(grid, allowed_tv, costs, vstack([leave, arrive]))
    masses = _feasible(found.x[:count], grid.target_masses, allowed_tv)
    plan = np.maximum(found.x[2 * count :], 0.0).reshape(count, count)
    missing = np.sum(np.abs(plan.sum(axis=1) - grid.after @ masses)) + np.sum(
        np.abs(plan.sum(axis=0) - grid.before @ masses)
    )
    primal = float(np.sum(plan * prices)) + float(missing) * float(np.max(prices))
    potential = np.asarray(found.eqlin.marginals[count : 2 * count], dtype=np.float64)
    leaving = np.min(prices - potential, axis=1)
    worth = grid.before.T @ potential + grid.after.T @ leaving
    return ProgrammeSolution(masses, potential, primal, max(0.0, least_mean(worth, grid.target_masses, allowed_tv)))


def _solved(grid: CycleCells, allowed_tv: float, costs: Array, rows: Any) -> Any:
    """HiGHS on min costs·x with rows·x = 0, total mass 1 and the allowance, unknowns p, a and the rest."""
    from scipy.optimize import linprog

    count, size = grid.cells, costs.size
    total = csr_matrix((np.ones(count), (np.zeros(count, dtype=int), np.arange(count))), shape=(1, size))
    added = csr_matrix((np.ones(count), (np.zeros(count, dtype=int), count + np.arange(count))), shape=(1, size))
    one = eye(count, format="csr")
    limits = vstack([hstack([one, -one, csr_matrix((count, size - 2 * count))]), added])
    found = linprog(
        costs,
        A_ub=limits.tocsr(),
        b_ub=np.append(grid.target_masses, allowed_tv),
        A_eq=vstack([rows, total]).tocsr(),
        b_eq=np.append(np.zeros(rows.shape[0]), 1.0),
        method="highs",
        options={"primal_feasibility_tolerance": _TOLERANCE, "dual_feasibility_tolerance": _TOLERANCE},
    )
    if found.x is None:
        raise ConvergenceError(f"the linear programme on {count} cells was not solved: {found.message}")
    return found


def _feasible(masses: Array, target: Array, allowed_tv: float) -> Array:
    """Probabilities within the allowance, from masses that miss it by rounding."""
    kept = np.maximum(np.asarray(masses, dtype=np.float64), 0.0)
    kept = kept / np.sum(kept)
    distance = 0.5 * float(np.sum(np.abs(kept - target)))
    share = 1.0 if distance <= allowed_tv else allowed_tv / distance
    return np.asarray(target + share * (kept - target))
