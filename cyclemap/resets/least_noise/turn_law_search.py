"""A better law of the independent extra turn, cell by cell: local search by linear programmes from several starts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.checks import finite_array, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise_law import Noise
from cyclemap.resets.least_noise.cycle_cells import CycleCells, checked_own_noise, circulant
from cyclemap.resets.least_noise.least_correction import checked_allowance
from cyclemap.resets.least_noise.turn_costs import TurnCost, turn_cost

_STEPS = 60
_PENALTY = 50.0  # of a unit of TV above the allowance, in units of the largest cost
_FINER = 8  # cells of the check in one of the search
_ROUNDS = 4  # searches with the allowance lowered by what the check found over it


@dataclass(frozen=True, eq=False)
class TurnLaw:
    """An extra turn drawn evenly from the arc of width 2π/n about 2πk/n with probability ``masses[k]``.

    masses : (n,). mean_cost : E c(ξ), by midpoints. tv : left over, on cells eight times finer, its bound measured
    (twice the change from cells four times finer). is_met : whether tv.upper is within ``allowed_tv``. A local
    optimum: not proven least; ``independent_noise_bound`` and ``least_correction`` bound what can be.
    """

    cost: str
    allowed_tv: float
    masses: Array
    mean_cost: float
    tv: Estimate
    is_met: bool


def left_over_masses(cycle: Array, masses: Array) -> Array:
    """(n,): the stationary law of the chain that is carried by ``cycle`` (n, n), then turned by k with masses[k]."""
    count = masses.size
    system = np.eye(count) - circulant(masses) @ cycle + 1.0 / count
    return np.asarray(np.linalg.solve(system, np.full(count, 1.0 / count)))


def local_optimum(cycle: Array, prices: Array, allowed_tv: float, start: Array) -> tuple[Array, float]:
    """Masses of a turn, and their mean price plus a penalty on TV above the allowance, locally least from ``start``.

    cycle : (n, n), columns of sum 1. prices : (n,), of a turn by k cells. Successive linear programmes in a trust
    region: p(g) is made linear, with p' = (I - GC + u 1ᵀ)⁻¹ (Cp)*, and the step kept where it improves.
    """
    weight = _PENALTY * float(np.max(prices))
    masses, radius = start, 0.25
    merit = _merit(cycle, prices, allowed_tv, masses, weight)
    for _ in range(_STEPS):
        trial = _step(cycle, prices, allowed_tv, masses, radius, weight)
        found = _merit(cycle, prices, allowed_tv, trial, weight)
        if found < merit - 1e-10:
            masses, merit, radius = trial, found, min(1.0, 2.0 * radius)
        elif radius < 1e-7:
            break
        else:
            radius *= 0.25
    return masses, merit


def search_turn_law(
    circle_map: CircleMap,
    allowed_tv: float,
    cost: str = "absolute",
    own_noise: Noise | None = None,
    cells: int = 48,
    seed: int = 0,
) -> TurnLaw:
    """The best independent turn found, over all laws that are even within ``cells`` arcs, symmetric or not.

    Starts: lazy, uniform arcs of several widths, and random ones. cells : 8 to 96; the law is even within an arc, so
    that even no turn at all is spread over one. Where no search meets the allowance the uniform turn is returned.
    Raises InvalidInput for values that cannot be used.

    >>> found = search_turn_law(CircleMap.arnold(0.1, 0.9), 0.05, cells=16)
    >>> found.is_met, 0.95 < found.mean_cost < 1.4
    (True, True)
    """
    price, allowed = turn_cost(cost), checked_allowance(allowed_tv)
    count = whole_number("cells", cells, least=8)
    if count > 96:
        raise InvalidInput(f"cells is {count}: at most 96 can be searched")
    own, coarse = checked_own_noise(own_noise), _FINER // 2
    cycles = [_cycle(circle_map, count * finer, own) for finer in (1, coarse, _FINER)]
    prices = _cell_prices(price, count)
    aim, masses, left = allowed, np.full(count, 1.0 / count), Estimate(0.0, 0.0)
    for _ in range(_ROUNDS):
        found = [local_optimum(cycles[0], prices, aim, start) for start in _starts(count, seed)]
        trial = min(found, key=lambda pair: pair[1])[0]
        tv = _checked(cycles[1], cycles[2], trial)
        if tv.upper <= allowed:
            masses, left = trial, tv
            break
        aim = max(0.0, aim - 1.05 * (tv.upper - allowed))
    return TurnLaw(price.name, allowed, read_only(masses), float(masses @ prices), left, left.upper <= allowed)


def _step(cycle: Array, prices: Array, allowed: float, masses: Array, radius: float, weight: float) -> Array:
    """The best masses within ``radius`` in every entry, for the law made linear: unknowns g, (p - u)⁺ and slack."""
    from scipy.optimize import linprog

    count = masses.size
    law = left_over_masses(cycle, masses)
    system = np.eye(count) - circulant(masses) @ cycle + 1.0 / count
    response = np.linalg.solve(system, circulant(cycle @ law))
    rows = np.hstack([response, -np.eye(count), np.zeros((count, 1))])
    total = np.concatenate([np.zeros(count), np.ones(count), [-1.0]])[None]
    bounds = [(max(0.0, g - radius), min(1.0, g + radius)) for g in masses] + [(0.0, None)] * (count + 1)
    found = linprog(
        np.concatenate([prices, np.zeros(count), [weight]]),
        A_ub=np.vstack([rows, total]),
        b_ub=np.append(1.0 / count - law + response @ masses, allowed),
        A_eq=np.concatenate([np.ones(count), np.zeros(count + 1)])[None],
        b_eq=[1.0],
        bounds=bounds,
    )
    if found.x is None:
        return masses
    kept = np.maximum(found.x[:count], 0.0)
    return np.asarray(kept / np.sum(kept))


def _merit(cycle: Array, prices: Array, allowed: float, masses: Array, weight: float) -> float:
    return float(masses @ prices) + weight * max(0.0, _tv(left_over_masses(cycle, masses)) - allowed)


def _tv(law: Array) -> float:
    return 0.5 * float(np.sum(np.abs(law - 1.0 / law.size)))


def _cycle(circle_map: CircleMap, cells: int, own_noise: Noise | None) -> Array:
    return np.asarray(CycleCells(circle_map, cells, None, own_noise).after.toarray())


def _cell_prices(price: TurnCost, count: int) -> Array:
    """(count,): the mean cost over the arc about every multiple of 2π/count."""
    offsets = (np.arange(64) + 0.5) / 64 - 0.5
    angles = np.add.outer(np.arange(count), offsets) * (TWO_PI / count)
    return np.asarray(np.mean(price.of(angles), axis=1))


def _starts(count: int, seed: int) -> list[Array]:
    distance = np.minimum(np.arange(count), count - np.arange(count)) / count
    lazy = np.full(count, 0.85 / count) + 0.15 * (distance == 0.0)
    arcs = [np.where(distance <= share, 1.0, 0.0) for share in (0.2, 0.35, 0.5)]
    random = np.random.default_rng(seed).dirichlet(np.ones(count), 2)
    return [finite_array("start", start / np.sum(start)) for start in (lazy, *arcs, *random)]


def _checked(coarse: Array, fine: Array, masses: Array) -> Estimate:
    """TV on both grids, the arcs' masses spread evenly over the finer cells; ends fall half a cell apart."""
    tvs = [_tv(left_over_masses(cycle, _spread(masses, len(cycle)))) for cycle in (coarse, fine)]
    return Estimate(tvs[1], 2.0 * abs(tvs[1] - tvs[0]) + 1e-12)


def _spread(masses: Array, count: int) -> Array:
    """(count,): an even number of finer cells an arc, the outermost two shared with the neighbours by halves."""
    finer = count // masses.size
    block = np.append(np.append(0.5, np.ones(finer - 1)), 0.5) / finer
    places = np.add.outer(np.arange(masses.size) * finer, np.arange(finer + 1) - finer // 2) % count
    return np.asarray(np.bincount(places.ravel(), weights=np.outer(masses, block).ravel(), minlength=count))
