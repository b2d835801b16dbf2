"""How evenly a law spreads orientations: its distances from uniform or from a density that is wished for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cyclemap.errors import InvalidInput
from cyclemap.evidence.orientations.circular_law import CircularLaw
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.law_distances import (
    cumulative_on_grid,
    density_on_grid,
    total_variation_on_grid,
    wasserstein_on_grid,
)

Target = FourierLaw | Callable[[Array], Array] | None
_CELLS = 1 << 14  # of the table of a density that is given as a callable


@dataclass(frozen=True)
class Evenness:
    """How far a law is from the target; every number with a bound on its error.

    total_variation : ½ ∫ |p - q| dθ, in [0, 1]. wasserstein : W1 on the circle, radians, in [0, π].
    peak_to_mean : largest density over 1/2π, ≥ 1, whatever the target.
    certified : whether the total variation is known to 0.005 or better.
    """

    total_variation: Estimate
    wasserstein: Estimate
    peak_to_mean: Estimate

    @property
    def certified(self) -> bool:
        """Whether the total variation is known to 0.005 or better."""
        return self.total_variation.error_bound <= 0.005


def evenness(law: FourierLaw, target: Target = None) -> Evenness:
    """Set a law against a target: None for uniform, a ``FourierLaw``, or a density per radian (vectorised callable).

    A callable may jump: it is tabulated in 16384 cells, and the bound is then measured on half of them, with the
    law's own error. Raises InvalidInput for a law that is none, and a density that is none.

    >>> found = evenness(FourierLaw(np.array([1.0, 0.25])))
    >>> round(found.total_variation, 4), round(found.wasserstein, 4), round(found.peak_to_mean, 6), found.certified
    (0.1592, 0.3183, 1.5, True)
    """
    if not isinstance(law, FourierLaw):
        raise InvalidInput(f"the law is {law!r}: give a FourierLaw, for example stationary_fourier_law(operator)")
    if target is None or isinstance(target, FourierLaw):
        return Evenness(law.total_variation(target), law.wasserstein(target), law.peak_to_mean())
    table = CircularLaw(target, cells=max(_CELLS, 1 << int(np.ceil(np.log2(16 * law.modes + 16)))))
    moments = np.array(law.moments)
    density = density_on_grid(moments, table.cells) - table.heights[:-1]
    moments[0] = 0.0
    reached = cumulative_on_grid(moments, table.cells) + table.knots[:-1] / TWO_PI - table.masses[:-1]
    variation, grid = total_variation_on_grid(density)
    distance, spread = wasserstein_on_grid(reached)
    return Evenness(
        Estimate(min(1.0, float(variation)), min(1.0, float(grid) + np.pi * law.error_bound)),
        Estimate(float(distance), min(np.pi, float(spread) + np.pi**2 * law.error_bound)),
        law.peak_to_mean(),
    )
