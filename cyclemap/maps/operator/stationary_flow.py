"""The stationary flow of a noisy circle map between arcs, to full relative accuracy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.passages.elimination import eliminated
from cyclemap.maps.passages.nystrom import KilledChain
from cyclemap.maps.quadrature import arc_rule

_FINER = 1.5  # bandwidth of flow times density over that of the chain's nodes


@dataclass(frozen=True, eq=False)
class StationaryFlow:
    """A chain on the whole circle and its stationary ``mass`` on the nodes, (n,), sum 1."""

    chain: KilledChain
    mass: Array

    @classmethod
    def of(cls, chain: KilledChain) -> StationaryFlow:
        """The flow of a chain that has no exits (Grassmann, Taksar & Heyman 1985: each entry keeps its digits)."""
        moves = chain.transitions(chain.images)
        return cls(chain, eliminated(moves, np.zeros(chain.theta.size)).stationary())

    def density(self, theta: Array) -> Array:
        """Stationary density per radian at ``theta``, shape (m,): ∫ p(x) g(θ - F(x)) dx."""
        return np.asarray(self.chain.noise.density(theta[:, None] - self.chain.images) @ self.mass)

    def between_cells(self, count: int) -> Array:
        """(count, count): probability of being in cell i now and in cell j next, cells of equal width from 0 on."""
        edges = np.linspace(0.0, TWO_PI, count + 1)
        ends = np.union1d(edges, self.chain.map.breaks)
        x, w = np.polynomial.legendre.leggauss(4)
        width = np.diff(ends)
        theta = (ends[:-1, None] + width[:, None] * (0.5 + 0.5 * x)).ravel()
        mass = self.density(theta) * (0.5 * width[:, None] * w).ravel()
        owner = np.searchsorted(edges, theta) - 1
        flow = np.zeros((count, count))
        images = self.chain.map(theta)[:, None]
        np.add.at(
            flow, owner, mass[:, None] * self.chain.noise.arc_probability(edges[:-1] - images, edges[1:] - images)
        )
        return flow

    def between_arcs(self, cuts: Array) -> tuple[Array, Array]:
        """Weights (k,) of the arcs between successive cuts, and P(next in b | now in a), (k, k)."""
        ends = np.append(cuts, cuts[0] + TWO_PI)
        weights, moves = np.empty(cuts.size), np.empty((cuts.size, cuts.size))
        for a in range(cuts.size):
            images, mass = self._on_arc(ends[a], ends[a + 1])
            weights[a] = mass.sum()
            for b in range(cuts.size):
                moves[a, b] = mass @ self._arrival(images, ends[b], ends[b + 1]) / weights[a]
        return weights / weights.sum(), moves

    def refined(self, cuts: Array, reach: float) -> Array:
        """Cuts within ``reach`` of the given ones with the least sum of chances of leaving, rising from [0, 2π).

        Each keeps less than half of its distance to the next, so that no arc vanishes.
        """
        from scipy.optimize import minimize

        scale = self._leaving(cuts)[0]
        ahead = np.minimum(1.0, 0.45 * np.diff(np.append(cuts, cuts[0] + TWO_PI)) / reach)

        def objective(shift: Array) -> tuple[float, Array]:
            total, slope = self._leaving(cuts + reach * shift)
            return total / scale, slope * reach / scale

        found = minimize(
            objective,
            np.zeros(cuts.size),
            jac=True,
            method="L-BFGS-B",
            bounds=list(zip(-np.roll(ahead, 1), ahead, strict=True)),
            options={"ftol": 1e-15, "gtol": 1e-10},
        )
        return np.sort(np.mod(cuts + reach * found.x, TWO_PI))

    def _leaving(self, cuts: Array) -> tuple[float, Array]:
        """Σ P(outside next | inside now) over the arcs between the cuts, and its slope by each cut."""
        total, slope = 0.0, np.zeros(cuts.size)
        ends = np.append(cuts, cuts[0] + TWO_PI)
        for a in range(cuts.size):
            images, mass = self._on_arc(ends[a], ends[a + 1])
            weight = mass.sum()
            chance = mass @ self._arrival(images, ends[a + 1], ends[a] + TWO_PI) / weight
            total += chance
            for end, sign in ((a, -1.0), (a + 1, 1.0)):
                here = self._end_slope(ends[end], ends[a], ends[a + 1], images, mass, chance)
                slope[end % cuts.size] += sign * here / weight
        return float(total), slope

    def _end_slope(self, at: float, start: float, end: float, images: Array, mass: Array, chance: float) -> float:
        """Weight times how fast a chance of leaving grows as the arc's end at ``at`` moves outward."""
        point = np.array([at])
        gone = self._arrival(self.chain.map(point), end, start + TWO_PI)[0]
        return float(self.density(point)[0] * (gone - chance) - mass @ self.chain.noise.density(at - images))

    def _on_arc(self, start: float, end: float) -> tuple[Array, Array]:
        theta, weight = arc_rule(self.chain.map, start, end, _FINER * self.chain.bandwidth)
        return self.chain.map(theta), weight * self.density(theta)

    def _arrival(self, images: Array, start: float, end: float) -> Array:
        if end - start >= TWO_PI:
            return np.ones_like(images)
        return self.chain.noise.arc_probability(start - images, end - images)
