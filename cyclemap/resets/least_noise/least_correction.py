"""The least extra turn of a robot that knows the orientation: optimal transport back to an even law, with proof."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from cyclemap.checks import finite_number, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise_law import Noise
from cyclemap.resets.least_noise.certified_bounds import lower_bound, upper_bound
from cyclemap.resets.least_noise.circular_matching import CircularMatching
from cyclemap.resets.least_noise.correction_programme import ProgrammeSolution, solve_by_flow, solve_by_plan
from cyclemap.resets.least_noise.cycle_cells import CycleCells, checked_own_noise
from cyclemap.resets.least_noise.turn_costs import TurnCost, turn_cost

GAP = 1e-8  # what a solution's relative duality gap may be at most to be called certified
MOST_CELLS = {"flow": 2048, "plan": 160}
_CELLS = {"flow": 512, "plan": 96}


@dataclass(frozen=True, eq=False)
class ReplayedCorrection:
    """What points drawn evenly from the stationary law become after one cycle and the extra turn.

    tv : distance in total variation, over the cells, of where they end from the law they began with; the points
    themselves leave about cells/points, or √(cells/(2π points)) where own noise is drawn. mean_cost : their mean
    cost. points : how many.
    """

    tv: float
    mean_cost: float
    points: int


@dataclass(frozen=True, eq=False)
class LeastCorrection:
    """The least mean cost of an extra turn that keeps a law within ``allowed_tv`` of the target stationary.

    cost : "absolute" (radians), "squared" (radians²) or "cosine". allowed_tv : the allowance ε. cells : N.
    lower, upper : proven bounds on the optimum over all laws and all corrections, in the cost's unit.
    primal, dual : the values of the programme on N cells, each computed afresh from a point that is feasible to
    rounding. gap : (primal - dual) over the larger of primal and the cost of a turn by one cell.
    is_certified : gap ≤ 1e-8. potential : (N,), the dual certificate ψ at the cells' middles.
    masses : (N,), the stationary law's mass in each cell [2πj/N, 2π(j+1)/N). tv : its distance from the target.
    matching : the correction itself, see ``extra_turn``.

    Stationary does not mean reached: with ε = 0 and an invertible map the corrected cycle is a rigid rotation, which
    keeps the uniform law but never forgets where it began.
    """

    cost: str
    allowed_tv: float
    cells: int
    lower: float
    upper: float
    primal: float
    dual: float
    gap: float
    is_certified: bool
    potential: Array
    masses: Array
    tv: float
    matching: CircularMatching
    grid: CycleCells

    def density(self, theta: Any) -> Array:
        """The stationary density per radian, in each cell of the target's shape; ``theta`` of any shape."""
        angles = np.asarray(theta, dtype=np.float64)
        part = (np.mod(angles, TWO_PI) / self.grid.part_width).astype(np.int64) % self.grid.parts
        return np.asarray(self.grid.spread_over_parts(self.masses)[part] / self.grid.part_width)

    def extra_turn(self, angle: Any) -> Array:
        """The turn, radians in [-π, π), at orientation ``angle`` = F(θ) + η, after cycle and own noise; any shape."""
        return self.matching.turn(angle)

    def replayed(self, points: int = 20_000, seed: int = 0) -> ReplayedCorrection:
        """One cycle of the map itself on ``points`` from the law, then ``extra_turn``: no programme, no matrix."""
        count = whole_number("points", points, least=self.cells)
        reached = np.append(0.0, np.cumsum(self.masses))
        levels = (np.arange(count) + 0.5) / count
        angle = self.grid.circle_map(_within_cells(levels, reached, self.grid))
        if self.grid.own_noise is not None:
            angle = angle + self.grid.own_noise.sample(np.random.default_rng(seed), count)
        turn = self.extra_turn(angle)
        cell = (np.mod(angle + turn, TWO_PI) / self.grid.width).astype(np.int64) % self.cells
        found = np.bincount(cell, minlength=self.cells) / count
        mean = float(np.mean(turn_cost(self.cost).of(turn)))
        return ReplayedCorrection(0.5 * float(np.sum(np.abs(found - self.masses))), mean, count)


def least_correction(
    circle_map: CircleMap,
    allowed_tv: float,
    target: Callable[[Array], Array] | None = None,
    cost: str = "absolute",
    cells: int | None = None,
    own_noise: Noise | None = None,
) -> LeastCorrection:
    """The least extra turn, chosen from the orientation after the cycle, that makes θ' = F(θ) + η + ξ even enough.

    circle_map : F. allowed_tv : ε in [0, 1), total variation of the stationary law from the target.
    target : density per radian, period 2π, vectorised, as ``CircularLaw`` tabulates it; None for uniform.
    own_noise : law of η, None for none. The correction is made after it, and knows the orientation that it left.
    cost : "absolute", "squared" or "cosine" (see ``turn_cost``). cells : 8 to 2048 for |ξ|, to 160 for the others.

    With m(θ, θ') the law of two successive orientations the problem is linear: minimise ∫ c(θ' - F(θ)) dm over m
    with both marginals p and TV(p, target) ≤ ε: optimal transport from F#p to p, jointly over p (Kantorovich 1942;
    Villani 2009). For |ξ| it is the circle's Wasserstein-1 distance (Rabin, Delon & Gousseau 2011). For ε = 0, the
    uniform target and an invertible map of degree 1 the optimum is the mean absolute deviation of the turn F - id
    from its median (its variance for ξ²): a closed form that the bounds hold.

    The programme on N cells (HiGHS) gives a law and a potential; ``upper`` is the cost of a correction that keeps
    that law, ``lower`` the value of that potential on the whole circle. Both are proved, up to double rounding and
    the map's own ``max_error`` (which is counted); they close as 1/N, or 1/N² for ε = 0.

    Raises InvalidInput for values that cannot be used, ConvergenceError where the programme is not solved.

    >>> found = least_correction(CircleMap.arnold(0.1, 0.9), 0.0, cells=64)
    >>> found.lower <= 1.8 / np.pi <= found.upper, found.is_certified
    (True, True)
    """
    price, allowed = turn_cost(cost), checked_allowance(allowed_tv)
    if not isinstance(circle_map, CircleMap):
        raise InvalidInput(f"the map is {circle_map!r}: give a CircleMap")
    if target is not None and not callable(target):
        raise InvalidInput(f"target is {target!r}: give a density per radian, or None for uniform")
    grid = CycleCells(circle_map, _cells(price, cells), target, checked_own_noise(own_noise))
    flows = _programme(price) == "flow"
    solution = solve_by_flow(grid, allowed) if flows else solve_by_plan(grid, allowed, price)
    return _certified(grid, solution, price, allowed)


def _certified(grid: CycleCells, found: ProgrammeSolution, price: TurnCost, allowed: float) -> LeastCorrection:
    upper, matching = upper_bound(grid, found.masses, price)
    lower = lower_bound(grid, found.potential, price, allowed)
    gap = (found.primal - found.dual) / max(found.primal, float(price.of(np.array(grid.width))))
    return LeastCorrection(
        cost=price.name,
        allowed_tv=allowed,
        cells=grid.cells,
        lower=lower,
        upper=upper,
        primal=found.primal,
        dual=found.dual,
        gap=gap,
        is_certified=bool(abs(gap) <= GAP and lower <= upper),
        potential=read_only(found.potential),
        masses=read_only(found.masses),
        tv=0.5 * float(np.sum(np.abs(found.masses - grid.target_masses))),
        matching=matching,
        grid=grid,
    )


def _programme(price: TurnCost) -> str:
    return "plan" if np.isfinite(price.curvature) else "flow"


def _cells(price: TurnCost, cells: int | None) -> int:
    kind = _programme(price)
    count = _CELLS[kind] if cells is None else whole_number("cells", cells, least=8)
    if count > MOST_CELLS[kind]:
        raise InvalidInput(f"cells is {count}: at most {MOST_CELLS[kind]} can be solved for the cost {price.name!r}")
    return count


def checked_allowance(allowed_tv: Any) -> float:
    """An allowance in [0, 1), or InvalidInput."""
    allowed = finite_number("allowed_tv", allowed_tv)
    if not 0.0 <= allowed < 1.0:
        raise InvalidInput(f"allowed_tv is {allowed:g}: give a total variation of at least 0 and below 1")
    return allowed


def _within_cells(levels: Array, reached: Array, grid: CycleCells) -> Array:
    """Quantiles of the law whose cells have the target's shape."""
    cell = np.minimum(np.searchsorted(reached, levels, side="right") - 1, grid.cells - 1)
    mass = reached[cell + 1] - reached[cell]
    inside = np.divide(levels - reached[cell], mass, out=np.full(levels.shape, 0.5), where=mass > 0.0)
    ends = np.append(0.0, np.cumsum(grid.shares))
    # In every cell the shares sum to one.
    return np.asarray(np.interp(cell + np.clip(inside, 0.0, 1.0), ends, np.arange(ends.size) * grid.part_width))
