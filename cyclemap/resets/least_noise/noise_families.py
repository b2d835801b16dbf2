"""Families of extra random turns with one width each, and the total variation that a width leaves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cyclemap.maps.estimate import Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.mixtures.independent_sum import IndependentSum
from cyclemap.maps.noise.noise_law import Noise, UniformNoise, VonMises, WrappedCauchy, WrappedNormal
from cyclemap.maps.operator.transfer_operator import transfer_operator
from cyclemap.resets.least_noise.fourier_left_over import FourierLeftOver
from cyclemap.resets.least_noise.lazy_turns import LazyTurns
from cyclemap.resets.least_noise.turn_costs import TurnCost
from cyclemap.suggestions import unknown_name


@dataclass(frozen=True)
class NoiseFamily:
    """Laws of an extra turn ξ drawn whatever the orientation, wider and wider.

    name : as ``noise_family`` knows it. parameter : of the law, as its class calls it, or "q". least, most : the
    widths that are scanned. law : from a width; None for the lazy family, which turns rarely but by anything.
    even : the width at which ξ is uniform on the circle, so that every map's law is; None where there is none.
    """

    name: str
    parameter: str
    least: float
    most: float
    law: Callable[[float], Noise] | None
    even: float | None

    def mean_cost(self, width: float, cost: TurnCost) -> float:
        """E c(ξ); for the lazy family q times that of a uniformly random turn."""
        if width == 0.0:
            return 0.0
        if self.law is None:
            return width * cost.mean(UniformNoise(np.pi))
        return cost.mean(self.law(width))

    def value(self, width: float) -> float:
        """The law's own parameter at a width."""
        return width if self.law is None else float(getattr(self.law(width), self.parameter))

    def left_over(self, circle_map: CircleMap, own_noise: Noise | None) -> Callable[[float], Estimate]:
        """The function width → total variation from uniform of the stationary law of θ' = F(θ) + η + ξ."""
        if self.law is None:
            return LazyTurns(circle_map, own_noise).total_variation
        make, modes = self.law, FourierLeftOver(circle_map)

        def found(width: float) -> Estimate:
            noise = make(width)
            if own_noise is None and isinstance(noise, UniformNoise):
                return modes.total_variation(noise)
            both = noise if own_noise is None else IndependentSum((noise, own_noise))
            return transfer_operator(circle_map, both).tv_from_uniform

        return found


_FAMILIES = {
    family.name: family
    for family in (
        NoiseFamily("normal", "sigma", 0.05, 4.0, WrappedNormal, None),
        NoiseFamily("uniform", "halfwidth", 0.1, np.pi, UniformNoise, np.pi),
        NoiseFamily("von-mises", "kappa", 0.05, 20.0, lambda width: VonMises(1.0 / width**2), None),
        NoiseFamily("cauchy", "r", 0.1, 5.0, lambda width: WrappedCauchy(float(np.exp(-width))), None),
        NoiseFamily("lazy", "q", 0.05, 1.0, None, 1.0),
    )
}
FAMILIES = tuple(_FAMILIES)


def noise_family(name: str) -> NoiseFamily:
    """The family named, by a width in radians: "normal" (σ), "uniform" (half-width), "von-mises" (1/√κ), "cauchy"
    (-ln r), or "lazy": with probability q a uniformly random turn, else none (the width is q, no angle).

    Raises InvalidInput for another name.

    >>> round(noise_family("von-mises").value(0.5), 12)
    4.0
    """
    if name not in FAMILIES:
        raise unknown_name("family", str(name), FAMILIES)
    return _FAMILIES[name]
