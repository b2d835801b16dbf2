"""Proven bounds on the least mean cost of a correction, from any law (upper) and from any potential (lower)."""

from __future__ import annotations

import numpy as np

from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.noise.noise_law import Noise
from cyclemap.resets.least_noise.circular_matching import CircularMatching, circular_matching
from cyclemap.resets.least_noise.correction_programme import least_mean
from cyclemap.resets.least_noise.cycle_cells import CycleCells, noise_masses
from cyclemap.resets.least_noise.turn_costs import TurnCost

_BETWEEN = 8  # angles a cell at which the cost's transform is minimised


def upper_bound(grid: CycleCells, masses: Array, cost: TurnCost) -> tuple[float, CircularMatching]:
    """A correction that keeps the law on the cells with ``masses`` stationary costs no more than the first value.

    The law, and its image under the cycle, are gathered into points; each mass moves by at most a known angle, and
    with it the mean cost by at most that times the cost's Lipschitz constant. The points are matched monotonely.
    """
    law = grid.spread_over_parts(masses)
    from_angles, from_masses = grid.images, law
    moved = float(np.dot(law, grid.image_reach)) + 0.5 * grid.part_width
    if grid.own_noise is not None:
        from_angles, from_masses = grid.middles, _after_noise(grid, law, grid.own_noise)
        moved += grid.part_width
    used, aims = from_masses > 0.0, law > 0.0
    matching = circular_matching(from_angles[used], from_masses[used], grid.middles[aims], law[aims], cost)
    return matching.mean_cost + cost.lipschitz * moved, matching


def lower_bound(grid: CycleCells, potential: Array, cost: TurnCost, allowed_tv: float) -> float:
    """No correction whose stationary law is within ``allowed_tv`` of the target costs less, whatever the potential.

    With ψ linear between its values at the centres and ψᶜ(φ) = inf_y c(y - φ) - ψ(y), every m(θ, θ') with both
    marginals p has ∫ c dm ≥ ∫ (ψᶜ(F(θ) + η) + ψ(θ)) p(dθ) (Kantorovich 1942); that is least over all p allowed for
    ``least_mean``. Values inside a part are bounded by that at its middle and the Lipschitz constants.
    """
    if not np.isfinite(cost.curvature):
        potential = potential / max(1.0, _steepest(potential, grid.width))
    slope = _steepest(potential, grid.width)
    leaving, slack = _transformed(grid, potential, cost)
    steep = _steepest(leaving, grid.width)
    worth = _between_centres(grid, potential, grid.middles) - 0.5 * slope * grid.part_width
    if grid.own_noise is None:
        ahead = _between_centres(grid, leaving, grid.images)
    else:
        ahead = _expected(grid, _between_centres(grid, leaving, grid.middles), grid.own_noise)
        slack += steep * grid.part_width
    worth = worth + ahead - steep * grid.image_reach - slack
    return max(0.0, least_mean(worth, grid.part_masses, allowed_tv))


def _steepest(values: Array, width: float) -> float:
    return float(np.max(np.abs(np.diff(values, append=values[0])))) / width


def _between_centres(grid: CycleCells, values: Array, angles: Array) -> Array:
    return np.asarray(np.interp(angles, grid.centres, values, period=TWO_PI))


def _transformed(grid: CycleCells, potential: Array, cost: TurnCost) -> tuple[Array, float]:
    """ψᶜ at the centres, and what is to be taken off when it is made linear between them.

    For |ξ|, where |ψ'| ≤ 1, it is -ψ. Else c minus ½ B ξ² is concave, and so is ψᶜ minus ½ B φ²: off the straight line
    by at most B h²/8; likewise the minimum over y is off by at most B/8 times the spacing squared.
    """
    if not np.isfinite(cost.curvature):
        return -potential, 0.0
    spacing = grid.width / _BETWEEN
    goals = grid.centres[0] + spacing * np.arange(grid.cells * _BETWEEN)
    prices = cost.of(goals - grid.centres[:, None]) - _between_centres(grid, potential, goals)
    return np.min(prices, axis=1), cost.curvature * (grid.width**2 + spacing**2) / 8.0


def _after_noise(grid: CycleCells, law: Array, noise: Noise) -> Array:
    """(parts,) masses at the middles: images gathered to their part, then turned by the noise's own parts."""
    part = (np.mod(grid.images, TWO_PI) / grid.part_width).astype(np.int64) % grid.parts
    gathered = np.asarray(np.bincount(part, weights=law, minlength=grid.parts), dtype=np.float64)
    return np.maximum(_convolved(gathered, noise_masses(noise, grid.parts)), 0.0)


def _expected(grid: CycleCells, values: Array, noise: Noise) -> Array:
    """E v(F(middle) + η), from v at the middles; the noise is symmetric."""
    turned = _convolved(values, noise_masses(noise, grid.parts))
    return np.asarray(np.interp(grid.images, grid.middles, turned, period=TWO_PI))


def _convolved(values: Array, masses: Array) -> Array:
    return np.asarray(np.fft.irfft(np.fft.rfft(values) * np.fft.rfft(masses), values.size))
