"""What an extra turn costs: convex functions of the angle turned, each with what the bounds need to know of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.noise.noise_law import Noise
from cyclemap.suggestions import unknown_name

_MEAN_CELLS = 8_192


@dataclass(frozen=True)
class TurnCost:
    """c(ξ), the cost of an extra turn by ξ, even, zero at 0, of period 2π (a longer way round is never taken).

    name : as ``turn_cost`` knows it. function : c of angles in [-π, π], vectorised. lipschitz : a bound on |c'|, per
    radian. curvature : B with c - B ξ²/2 concave between any two angles, per radian²; inf where there is none.

    >>> turn_cost("squared").of(np.array([0.5, 2 * np.pi - 0.5])).round(12).tolist()
    [0.25, 0.25]
    """

    name: str
    function: Callable[[Array], Array]
    lipschitz: float
    curvature: float

    def of(self, turns: Array) -> Array:
        """c of turns in radians, any shape, taken the short way round."""
        return self.function(np.mod(turns + np.pi, TWO_PI) - np.pi)

    def mean(self, noise: Noise) -> float:
        """E c(ξ) for ξ drawn from a noise law, wrapped: midpoints of 8,192 cells, exact to about 1e-7 of c(π).

        >>> from cyclemap.maps.noise.noise_law import UniformNoise
        >>> round(turn_cost("absolute").mean(UniformNoise(1.0)), 6)
        0.5
        """
        edges = np.linspace(-np.pi, np.pi, _MEAN_CELLS + 1)
        shares = noise.arc_probability(edges[:-1], edges[1:])
        return float(np.dot(shares, self.function(0.5 * (edges[:-1] + edges[1:]))) / np.sum(shares))


_COSTS = {
    "absolute": TurnCost("absolute", np.abs, 1.0, np.inf),
    "squared": TurnCost("squared", np.square, TWO_PI, 2.0),
    "cosine": TurnCost("cosine", lambda turns: 2.0 * np.sin(0.5 * turns) ** 2, 1.0, 1.0),
}


def turn_cost(name: str) -> TurnCost:
    """The cost named: "absolute" |ξ| (radians), "squared" ξ² (radians²) or "cosine" 1 - cos ξ.

    Raises InvalidInput for any other name.
    """
    if not isinstance(name, str):
        raise InvalidInput(f"cost is {name!r}: give one of {', '.join(_COSTS)}")
    if name not in _COSTS:
        raise unknown_name("cost", name, _COSTS)
    return _COSTS[name]
