"""How a noisy path spreads on the line: the diffusion constant of the lifted angle."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import INTEGRAL, Estimate
from cyclemap.maps.noise.noise import Noise, WrappedNormal
from cyclemap.maps.noise.uniform_noise import UniformNoise
from cyclemap.maps.operator.fourier_basis import Discretisation, FourierDiscretisation, waves
from cyclemap.maps.operator.solution_error import BorderedSystem
from cyclemap.maps.orbits.scan import crossings, monotone_cells
from cyclemap.maps.quadrature import arc_rule, gauss_rule

_NEGLIGIBLE = 1e-19  # chance beyond which the noise is cut off
_NOWHERE = 1e-17  # a density at half a turn below which the kicks count as smooth on the circle
_ORDER = 24  # Gauss nodes a panel of the kick
_CHECK_ORDER = 36
_PHASE = 16.0  # radians of phase that a panel carries at most
_ENTRIES = 2_000_000
_RESOLUTION = 512


def diffusion_constant(system: BorderedSystem, law: Array, order: int = _ORDER) -> float:
    """D = lim Var(θ_n)/2n, radians² a cycle, of the lifted path θ' = F(θ) + ξ under its stationary law.

    With z - Pz = u - E u, u = F(θ) - θ the turn (Poisson's equation), z(θ') - Pz(θ) + ξ is a martingale difference
    that adds up to the path but for what stays bounded, so D is half its mean square (Gordin & Lifsic 1978):
    2D = E (u - Eu)² + 2 E (u - Eu) Pz + 2 E ξ z(θ') + E ξ². The third term is there because the kick ξ moves θ'
    too; for normal noise it is 2σ² E z'(θ') (Stein's identity), for others an integral over kicks. inf where ξ has
    no variance. ``order``: Gauss nodes a panel of that integral. Raises InvalidInput unless the degree is 1.
    """
    basis = system.basis
    if basis.map.degree != 1:
        raise InvalidInput(f"the map has degree {basis.map.degree}: a diffusion constant needs degree 1")
    if np.isinf(basis.noise.variance):
        return float("inf")
    theta, weight = basis.rule()
    waves_there = basis.evaluate(theta)
    turn, mass = basis.map.turn(theta), weight * (waves_there @ law)
    turn = turn - np.dot(mass, turn)
    dual = system.dual((weight * turn) @ waves_there, law)
    later = _later(basis, dual, theta) - turn
    correlated = float(np.dot(mass, turn * (turn + 2.0 * (later - np.dot(mass, later)))))
    return 0.5 * (correlated + basis.noise.variance) + _kick_covariance(basis, law, dual, theta, mass, order)


def diffusion_estimate(system: BorderedSystem, law: Array, finer: tuple[BorderedSystem, Array] | None) -> Estimate:
    """``diffusion_constant`` with a measured bound: its distance from D on a ``finer`` system and its law.

    To which is added rounding, as the norm of (I - L)⁻¹ magnifies it; inf where there is no finer system.
    """
    found = diffusion_constant(system, law)
    if np.isinf(found) or finer is None:
        return Estimate(found, 0.0 if np.isinf(found) else float("inf"))
    rounding = INTEGRAL * (1.0 + system.inverse_norm) * (1.0 + abs(found))
    return Estimate(found, abs(diffusion_constant(*finer, _CHECK_ORDER) - found) + rounding)


def _later(basis: Discretisation, dual: Array, theta: Array) -> Array:
    """The solution z of Poisson's equation for the turn at ``theta``, but for a constant; ``dual``: its ∫ zφ_j."""
    if isinstance(basis, FourierDiscretisation):
        after = waves(basis.map(theta), basis.modes)
        return np.asarray(basis.map.turn(theta) + (basis.kappa * dual) @ after)
    return np.asarray(basis.evaluate(theta) @ _coefficients_of(basis, dual))


# -- E ξ z(F(θ) + ξ) -----------------------------------------------------------------------------------------


def _kick_covariance(basis: Discretisation, law: Array, dual: Array, theta: Array, mass: Array, order: int) -> float:
    noise = basis.noise
    smooth = isinstance(noise, WrappedNormal) or float(noise.line_density(np.pi)) < _NOWHERE
    if isinstance(basis, FourierDiscretisation) and smooth:
        return float(np.dot(mass, basis.expected_slope(dual, _kick_factors(noise, basis.order))))
    if isinstance(noise, UniformNoise):
        return _uniform_kicks(basis, dual, theta, mass)
    if basis.map.breaks.size:
        theta, weight = _cut_rule(basis)
        mass = weight * (basis.evaluate(theta) @ law)
    return _over_kicks(basis, lambda at: _later(basis, dual, at), basis.map(theta), mass, order)


def _cut_rule(basis: Discretisation) -> tuple[Array, Array]:
    """Nodes on panels that end also where the longest kick leads from F(θ) to a break: z jumps there."""
    reach = kick_reach(basis.noise)
    cells = monotone_cells(basis.map, 1, 0.0, _RESOLUTION)
    levels = [float(b) + side * reach for b in basis.map.breaks for side in (-1.0, 1.0)]
    cuts = np.concatenate([crossings(basis.map, cells, level)[0] for level in levels])
    return arc_rule(basis.map, 0.0, TWO_PI, basis.size // 2, getattr(basis, "finer", 1), cuts=cuts)


def _kick_factors(noise: Noise, orders: Array) -> Array:
    """E ξ sin(mξ)/m for every order: σ² κ_m for normal noise."""
    if isinstance(noise, WrappedNormal):
        return np.asarray(noise.sigma**2 * noise.coefficients(orders))
    reach, top = kick_reach(noise), float(np.max(orders))
    edges = np.linspace(0.0, reach, 2 + int(reach * top / _PHASE))
    kicks, weight = gauss_rule(edges[:-1], np.diff(edges), _ORDER)
    m = np.arange(1.0, top + 1.0)
    factors = 2.0 * np.sin(np.multiply.outer(m, kicks)) @ (weight * kicks * noise.line_density(kicks)) / m
    return np.asarray(np.append(0.0, factors)[orders.astype(np.int64)])


def kick_reach(noise: Noise) -> float:
    """The least x, to rounding, with P(ξ > x) ≤ 1e-19 (the end of the support of bounded noise)."""
    low, high = 0.0, 1.0
    while float(noise.exceedance(high)) > _NEGLIGIBLE:
        low, high = high, 2.0 * high
    while high - low > 1e-15 * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if float(noise.exceedance(middle)) > _NEGLIGIBLE else (low, middle)
    return high


def _uniform_kicks(basis: Any, dual: Array, theta: Array, mass: Array) -> float:
    """Σ mass ∫ ξ z(F + ξ) dξ/2h over [-h, h], from the first two antiderivatives of z, panel by panel."""
    panels, width, image = basis.panels, basis.noise.halfwidth, basis.map(theta)
    function = _without_mean(basis, _coefficients_of(basis, dual))
    first = _without_mean(basis, panels.coefficients(panels.integral(function, panels.nodes)))
    above, below = np.mod(image + width, TWO_PI), np.mod(image - width, TWO_PI)
    ends = (basis.evaluate(above) + basis.evaluate(below)) @ first
    between = (panels.integral(first, above) - panels.integral(first, below)) / width
    return 0.5 * float(np.dot(mass, ends - between))


def _without_mean(basis: Discretisation, coefficients: Array) -> Array:
    return np.asarray(coefficients - np.dot(basis.mass, coefficients) * basis.uniform)


def _coefficients_of(basis: Discretisation, dual: Array) -> Array:
    """The function in the basis with the integrals ``dual``, ∫ zφ_j."""
    nodes, weight = basis.rule()
    values = basis.evaluate(nodes)
    return np.asarray(np.linalg.solve((values.T * weight) @ values, dual))


def _over_kicks(basis: Discretisation, later: Callable[[Array], Array], image: Array, mass: Array, order: int) -> float:
    """Σ mass ∫ ξ g(ξ) z(image + ξ) dξ, on panels of ξ that end where z jumps: at the map's breaks."""
    reach = kick_reach(basis.noise)
    steepest = float(np.max(np.abs(basis.map.derivative(basis.rule()[0]))))
    plain = np.linspace(-reach, reach, 2 + int(reach * 0.5 * basis.size * np.hypot(1.0, steepest) / _PHASE))
    laps = TWO_PI * np.arange(-np.ceil(reach / TWO_PI) - 1, np.ceil(reach / TWO_PI) + 2)
    cuts = np.add.outer(laps, basis.map.breaks).ravel()
    panels = plain.size + cuts.size
    total, step = 0.0, max(1, _ENTRIES // (basis.size * panels * order))
    for at in range(0, image.size, step):
        part = image[at : at + step, None]
        edges = np.concatenate([np.tile(plain, (part.size, 1)), cuts - np.mod(part, TWO_PI)], axis=1)
        edges = np.sort(np.clip(edges, -reach, reach), axis=1)
        kicks, weight = gauss_rule(edges[:, :-1].ravel(), np.diff(edges, axis=1).ravel(), order)
        owner = np.repeat(np.arange(part.size), kicks.size // part.size)
        values = weight * kicks * basis.noise.line_density(kicks) * later(part[owner, 0] + kicks)
        total += float(np.dot(mass[at : at + step][owner], values))
    return total
