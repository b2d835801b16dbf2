"""What no independent extra turn can do without: a proven lower bound on its mean cost, over all laws."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.checks import read_only, whole_number
from cyclemap.errors import ConvergenceError
from cyclemap.maps.arcs import Array
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise_law import Noise
from cyclemap.maps.quadrature import circle_rule
from cyclemap.resets.least_noise.cycle_cells import checked_own_noise
from cyclemap.resets.least_noise.departure_bound import least_departure
from cyclemap.resets.least_noise.least_correction import checked_allowance
from cyclemap.resets.least_noise.turn_costs import TurnCost, turn_cost

_MODES = 96
_ROUNDING = 1e-11  # of the moments of F
_TRIED = 1_024  # angles on which the certificate is sought
_CHECKED = 1 << 19  # angles on which it is checked


_LEAST_COST = {"absolute": lambda d: d, "squared": lambda d: d * d, "cosine": lambda d: 0.5 * d * d}


@dataclass(frozen=True, eq=False)
class NoiseBound:
    """Any law of ξ that leaves TV ≤ ``allowed_tv`` has mean cost ≥ ``lower``, in the unit of ``cost``.

    limits : (modes,), the most that |E e^{imξ}| can be, m = 1, 2, ...; 1 where nothing is known.
    certificate : (modes,), λ with c(ξ) ≥ by_limits + Σ |λ_m| limits_m + Σ λ_m cos mξ for all ξ.
    by_limits : the bound that this proves. departure : a proven bound on |1 - E e^{imξ}|/m for some m, at most E|ξ|;
    see ``least_departure``. ``lower`` is the better of what the two prove.
    """

    cost: str
    allowed_tv: float
    lower: float
    limits: Array
    certificate: Array
    by_limits: float
    departure: float


def pushed_moments(circle_map: CircleMap, modes: int = _MODES) -> Array:
    """|E e^{imF(θ)}|, m = 1 to ``modes``, θ uniform: all 0 exactly where F keeps the uniform law.

    >>> bool(np.max(pushed_moments(CircleMap.blaschke([0, 0.5]))) < 1e-12)
    True
    """
    theta, weight = circle_rule(circle_map, whole_number("modes", modes, least=1), 2)
    waves = np.exp(1j * np.multiply.outer(np.arange(1, modes + 1), circle_map(theta)))
    return np.abs(waves @ weight) / (2.0 * np.pi)


def independent_noise_bound(
    circle_map: CircleMap, allowed_tv: float, cost: str = "absolute", own_noise: Noise | None = None
) -> NoiseBound:
    """The mean cost that any extra turn needs whose law does not depend on the orientation.

    With p = g * N * F#p the moments are p_m = g_m N_m (F#p)_m. Within ε of uniform |p_m| ≤ ε + sin(πε)/π, and
    |(F#p)_m| ≥ |(F#u)_m| - 2ε, so that |g_m| is at most their ratio. The least mean cost of all g that obey this is
    a linear programme; its dual, checked on the whole circle, gives one number. The other is from
    ``least_departure`` d: E|ξ| ≥ d, E ξ² ≥ d² and E(1 - cos ξ) ≥ d²/2, since |1 - e^{imξ}| ≤ m|1 - e^{iξ}| ≤ m|ξ|.
    Proved up to the quadrature of F#u (its ``max_error`` is counted). 0 where nothing follows.

    >>> bound = independent_noise_bound(CircleMap.arnold(0.1, 0.9), 0.0)
    >>> 0.97 * np.pi / 2 < bound.lower <= np.pi / 2
    True
    """
    price, allowed = turn_cost(cost), checked_allowance(allowed_tv)
    own, orders = checked_own_noise(own_noise), np.arange(1, _MODES + 1)
    pushed = pushed_moments(circle_map) - orders * circle_map.max_error - _ROUNDING
    limits = _limits(pushed, allowed, own)
    certificate = _certificate(limits, price)
    by_limits = max(0.0, _least_left(certificate, price) - float(np.dot(np.abs(certificate), limits)))
    departure = least_departure(circle_map, allowed, pushed, own)
    lower = max(by_limits, _LEAST_COST[price.name](departure))
    return NoiseBound(price.name, allowed, lower, read_only(limits), read_only(certificate), by_limits, departure)


def _limits(pushed: Array, allowed: float, own_noise: Noise | None) -> Array:
    kept = 1.0 if own_noise is None else np.abs(own_noise.coefficients(np.arange(1, _MODES + 1)))
    floor = (pushed - 2.0 * allowed) * kept
    reach = allowed + np.sin(np.pi * allowed) / np.pi
    return np.asarray(np.divide(reach, floor, out=np.ones(_MODES), where=floor > reach))


def _certificate(limits: Array, price: TurnCost) -> Array:
    """λ that maximises λ_0 - Σ |λ_m| limits_m under λ_0 + Σ λ_m cos mξ ≤ c(ξ) on a grid; the primal gives it."""
    from scipy.optimize import linprog

    used = np.flatnonzero(limits < 1.0)
    certificate = np.zeros(limits.size)
    if used.size == 0:
        return certificate
    angles = np.linspace(0.0, np.pi, _TRIED + 1)
    waves = np.cos(np.multiply.outer(used + 1.0, angles))
    found = linprog(
        price.of(angles),
        A_ub=np.concatenate([waves, -waves]),
        b_ub=np.tile(limits[used], 2),
        A_eq=np.ones((1, angles.size)),
        b_eq=[1.0],
        method="highs",
    )
    if found.x is None:
        raise ConvergenceError(f"the bound on independent noise was not found: {found.message}")
    both = np.asarray(found.ineqlin.marginals)
    certificate[used] = both[: used.size] - both[used.size :]
    return certificate


def _least_left(certificate: Array, price: TurnCost) -> float:
    """A lower bound on c(ξ) - Σ λ_m cos mξ over the circle, from many angles and the Lipschitz constant."""
    padded = np.zeros(_CHECKED // 2 + 1)
    padded[1 : certificate.size + 1] = certificate
    waves = np.fft.irfft(padded, _CHECKED) * (_CHECKED / 2.0)
    angles = 2.0 * np.pi * np.arange(_CHECKED) / _CHECKED
    steep = price.lipschitz + float(np.dot(np.arange(1, certificate.size + 1), np.abs(certificate)))
    return float(np.min(price.of(angles) - waves)) - steep * np.pi / _CHECKED
