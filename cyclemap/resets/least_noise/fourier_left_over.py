"""TV left over by extra turns whose Fourier coefficients fall slowly, from one matrix for all widths."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import Array
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.noise.noise_law import Noise, WrappedNormal
from cyclemap.maps.operator.fourier_discretisation import FourierDiscretisation
from cyclemap.maps.operator.transfer_operator import transfer_operator

_MODES = 192
_GOOD = 1e-3  # of TV; where the modes do worse the law's own basis is used, which takes seconds
_SAFETY = 4.0
_NO_NOISE = WrappedNormal(1e-9)  # coefficients of 1 to rounding


@dataclass(frozen=True, eq=False)
class FourierLeftOver:
    """The stationary law of θ' = F(θ) + ξ in 192 Fourier modes, for any noise.

    Uniform noise gains the law one derivative a cycle, so that where F is smooth and invertible the law is smooth
    and the modes converge fast, though the noise's own coefficients fall as 1/m only. The bound is measured: four
    times the change from half the modes, and the grid's. Where that change exceeds 1e-3 ``transfer_operator`` is asked.
    """

    circle_map: CircleMap

    def total_variation(self, noise: Noise) -> Estimate:
        """TV of the stationary law from uniform."""
        fine, coarse = (self._left_over(noise, modes) for modes in (_MODES, _MODES // 2))
        if fine is None or coarse is None or abs(fine - coarse) > _GOOD:
            return transfer_operator(self.circle_map, noise).tv_from_uniform
        return Estimate(float(fine), fine.error_bound + _SAFETY * abs(fine - coarse) + 1e-12)

    @cached_property
    def _cycle(self) -> Array:
        return FourierDiscretisation(self.circle_map, _NO_NOISE, _MODES).matrix

    def _left_over(self, noise: Noise, modes: int) -> Estimate | None:
        """None where the modes give no law: they then are too few."""
        kept = np.concatenate([np.arange(modes + 1), _MODES + np.arange(1, modes + 1)])
        orders = np.concatenate([np.arange(modes + 1), np.arange(1, modes + 1)])
        cycle = noise.coefficients(orders)[:, None] * self._cycle[np.ix_(kept, kept)]
        system = np.eye(kept.size) - cycle
        system[0, 0] = 1.0
        law = np.linalg.solve(system, np.append(1.0, np.zeros(kept.size - 1)))
        moments = law[: modes + 1] + 1j * np.append(0.0, law[modes + 1 :])
        try:
            return FourierLaw(moments).total_variation()
        except InvalidInput:
            return None
