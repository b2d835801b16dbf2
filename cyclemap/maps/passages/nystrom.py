"""A noisy map killed when it leaves some arcs: its chain on quadrature nodes (Nyström), solved without subtraction."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Arc, Array
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise_law import Noise, UniformNoise
from cyclemap.maps.passages.elimination import Elimination, eliminated
from cyclemap.maps.quadrature import arc_rule
from cyclemap.maps.rounding import EPS

MAX_UNKNOWNS = 6_000
NEGLECTED = 1e-6  # noise coefficients beyond the nodes' bandwidth are smaller; residuals then are rounding
_MIN_BANDWIDTH = 4


def killed_chain(
    circle_map: CircleMap,
    noise: Noise,
    arcs: tuple[Arc, ...],
    exits: tuple[Arc, ...],
    lifted: bool,
    *,
    every_sample: bool = False,
    stretch: float = 1.0,
    most: int = MAX_UNKNOWNS,
) -> KilledChain:
    """The chain on the nodes of ``arcs``, killed where it enters one of ``exits``: together they fill the space.

    lifted : the space is the real line, and an exit may reach to ±inf; else the circle. every_sample : panels
    of nodes end at every sample of a sampled map. stretch : factor on the nodes' bandwidth.

    Raises InvalidInput when the noise is so narrow that more than ``most`` nodes would be needed, and for
    ``UniformNoise``, whose density jumps.
    """
    if not isinstance(circle_map, CircleMap):
        raise InvalidInput(f"the map is {circle_map!r}: give a CircleMap")
    if not isinstance(noise, Noise):
        raise InvalidInput(f"the noise is {noise!r}: passages need some, for example WrappedNormal(0.02)")
    if isinstance(noise, UniformNoise):
        raise InvalidInput(f"{noise!r} has a density that jumps, which this method cannot resolve: take a smooth law")
    bandwidth = float(_MIN_BANDWIDTH)
    while noise.coefficients(bandwidth) > NEGLECTED and bandwidth < 1e5:
        bandwidth *= 1.05
    bandwidth *= stretch
    rules = [arc_rule(circle_map, *ends, bandwidth, every_sample=every_sample) for ends in arcs]
    theta, weight = (np.concatenate(part) for part in zip(*rules, strict=True))
    if theta.size > most:
        raise InvalidInput(f"{noise!r} needs {theta.size} nodes on the arc, more than {most}: raise its width")
    return KilledChain(circle_map, noise, arcs, exits, lifted, every_sample, bandwidth, theta, weight)


@dataclass(frozen=True, eq=False)
class KilledChain:
    """θ' = F(θ) + ξ on ``theta`` (n nodes of its arcs), until it enters an exit.

    Below ``images`` are values F(x), shape (m,): the same questions are asked at nodes and between them.
    """

    map: CircleMap
    noise: Noise
    arcs: tuple[Arc, ...]
    exits: tuple[Arc, ...]
    lifted: bool
    every_sample: bool
    bandwidth: float
    theta: Array
    weight: Array

    @cached_property
    def images(self) -> Array:
        """(n,): F at the nodes."""
        return self.map(self.theta)

    @cached_property
    def elimination(self) -> Elimination:
        """The chain on its own nodes, eliminated."""
        return eliminated(self.transitions(self.images), self.departures(self.images).sum(axis=0))

    def with_noise(self, noise: Noise) -> KilledChain:
        """The same map, arcs and exits under another noise, on nodes for it."""
        most = max(MAX_UNKNOWNS, self.theta.size)
        return killed_chain(
            self.map, noise, self.arcs, self.exits, self.lifted, every_sample=self.every_sample, most=most
        )

    def distance(self, gap: Array) -> Array:
        """How far a noise must carry the path over a gap, at least: the shorter way where it is on the circle."""
        return np.abs(gap if self.lifted else gap - TWO_PI * np.round(gap / TWO_PI))

    def finer(self) -> KilledChain:
        """The same chain on twice as many nodes."""
        rules = [arc_rule(self.map, *ends, self.bandwidth, 2, self.every_sample) for ends in self.arcs]
        theta, weight = (np.concatenate(part) for part in zip(*rules, strict=True))
        return replace(self, theta=theta, weight=weight)

    # -- chances and their derivatives ---------------------------------------------------------------------

    def transitions(self, images: Array) -> Array:
        """(m, n): g(θ_j - F(x)) w_j, the chance of going to node j."""
        gap = self.theta - images[:, None]
        return (self.noise.line_density(gap) if self.lifted else self.noise.density(gap)) * self.weight

    def transition_slopes(self, images: Array) -> Array:
        """(m, n): d/dF of ``transitions``."""
        gap = self.theta - images[:, None]
        return -(self.noise.line_slope(gap) if self.lifted else self.noise.slope(gap)) * self.weight

    def transition_rates(self, images: Array) -> Array:
        """(m, n): d/d(the noise's parameter) of ``transitions``."""
        gap = self.theta - images[:, None]
        return (self.noise.line_rate(gap) if self.lifted else self.noise.rate(gap)) * self.weight

    def departures(self, images: Array) -> Array:
        """(exits, m): P(F(x) + ξ in the exit), to full relative accuracy also where it is small."""
        if not self.lifted:
            return np.array([self.noise.arc_probability(low - images, high - images) for low, high in self.exits])
        beyond = [self._half_line(exit_ends, images) for exit_ends in self.exits]
        return np.array([self.noise.exceedance(gap) for gap in beyond])

    def departure_slopes(self, images: Array) -> Array:
        """(exits, m): d/dF of ``departures``."""
        law = self.noise.line_density if self.lifted else self.noise.density
        ends = [(law(low - images), law(high - images)) for low, high in self.exits]
        return np.array([at_low - at_high for at_low, at_high in ends])

    def departure_rates(self, images: Array) -> Array:
        """(exits, m): d/d(the noise's parameter) of ``departures``."""
        if not self.lifted:
            return np.array([self.noise.arc_probability_rate(low - images, high - images) for low, high in self.exits])
        return np.array([self.noise.exceedance_rate(self._half_line(ends, images)) for ends in self.exits])

    @staticmethod
    def _half_line(exit_ends: Arc, images: Array) -> Array:
        """How far the noise must carry the image to enter an exit (-inf, end) or (end, inf)."""
        low, high = exit_ends
        return np.asarray(low - images if np.isinf(high) else images - high)

    # -- expectations --------------------------------------------------------------------------------------

    def expected(self, each: float, at: Array) -> Expectation:
        """What a path collects on average until it leaves: ``each`` a cycle, and ``at[e]`` on leaving by exit e."""
        reward = each + at @ self.departures(self.images)
        return Expectation(self, each, at, *self.elimination.expected(reward))


@dataclass(frozen=True, eq=False)
class Expectation:
    """X(x), the solution of X = c + ∫_arcs g(y - F(x)) X(y) dy with c(x) = each + at·(chances of leaving).

    It is kept twice at the nodes: as ``values``, and as ``top`` + ``change``, top its value at the node visited most.
    Values have their digits where they are small, changes have theirs where top is 1e100 and the path is most of the
    time; each, at >= 0.
    """

    chain: KilledChain
    each: float
    at: Array
    values: Array
    top: float
    change: Array

    def values_at(self, images: Array) -> tuple[Array, Array]:
        """X, and X - top, at points whose images are given: Nyström's interpolant."""
        moves, gone = self.chain.transitions(images), self.chain.departures(images)
        share = 1.0 / (gone.sum(axis=0) + moves.sum(axis=1))
        value = self.each + self.at @ gone + moves @ self.values
        change = self.each + (self.at - self.top) @ gone + moves @ self.change
        return value * share, change * share

    def value_at(self, theta: float) -> float:
        """X(θ)."""
        return float(self.values_at(self.chain.map(np.array([theta])))[0][0])

    def map_slope(self, images: Array, chain: KilledChain, change: Array) -> Array:
        """How fast c + ∫ g(y - F) X dy grows with F alone; ``change`` is X - top on the nodes of ``chain``."""
        return np.asarray(
            (self.at - self.top) @ chain.departure_slopes(images) + chain.transition_slopes(images) @ change
        )

    def error_bounds(self, theta: float) -> tuple[float, float]:
        """Bounds on the error of X(θ): of the discretisation with rounding, and from the map's ``max_error``.

        The operator I - K is monotone: if (I - K)Φ >= |r|, r the residual of the interpolant on a finer rule, then
        Φ bounds the error everywhere. Φ is solved for on the chain's own nodes.
        """
        chain, fine = self.chain, self.chain.finer()
        images = np.append(chain.images, chain.map(theta))
        on_fine = self.values_at(fine.images)
        residual, size = self._residual(images, fine, on_fine)
        slope = np.abs(self.map_slope(images, fine, on_fine[1]))
        # The distances to the exits are rounded one by one, so that their slopes do not cancel.
        ruggedness = slope + np.abs(self.at - self.top) @ np.abs(chain.departure_slopes(images))
        own = _widened(np.abs(residual)) + 2.0 * EPS * (size + ruggedness * (1.0 + np.abs(images)))
        sources = np.stack([own, slope * chain.map.max_error], axis=1)
        with np.errstate(over="ignore", invalid="ignore"):
            bounds = sources[-1] + chain.transitions(images[-1:])[0] @ chain.elimination.solve(sources[:-1])
        own_bound, from_map = np.where(np.isfinite(bounds), bounds, np.inf)
        return float(own_bound), float(from_map) if chain.map.max_error else 0.0

    def _residual(self, images: Array, fine: KilledChain, on_fine: tuple[Array, Array]) -> tuple[Array, Array]:
        """X - c - ∫ g X dy at points of given images, and the sum of its terms' sizes: of the two forms the better."""
        moves, gone, here = fine.transitions(images), fine.departures(images), self.values_at(images)
        forms = []
        # A constant part of X, however large, drops out of the second form exactly.
        for value, around, top in zip(here, on_fine, (0.0, self.top), strict=True):
            stay, lost = value * moves.sum(axis=1), value * gone.sum(axis=0) - (self.at - top) @ gone
            size = np.abs(lost) + np.abs(stay) + moves @ np.abs(around) + self.each
            forms.append((lost + stay - moves @ around - self.each, size))
        (residual, size), (other, other_size) = forms
        better = size <= other_size
        return np.where(better, residual, other), np.where(better, size, other_size)


def _widened(values: Array) -> Array:
    """The largest of each value and its neighbours: what lies between the nodes."""
    padded = np.concatenate([values[:1], values, values[-1:]])
    return np.asarray(np.maximum(np.maximum(padded[:-2], padded[2:]), values))


def line_exits(ends: Arc) -> tuple[Arc, Arc]:
    """What lies below and above an arc on the line."""
    return (-np.inf, ends[0]), (ends[1], np.inf)


def circle_exit(ends: Arc) -> tuple[Arc]:
    """The rest of the circle."""
    return ((ends[1], ends[0] + TWO_PI),)
