"""How far from doing nothing an independent extra turn must be: a proven bound from one Fourier mode at a time."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from cyclemap.maps.arcs import Array
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise_law import Noise
from cyclemap.resets.least_noise.cycle_cells import CycleCells

_MODES = 3
_CELLS = 512
_SPACING = 0.025  # of the values of E e^{imξ} that are tried
_DIRECTIONS = 12

Waves = npt.NDArray[np.complex128]


def least_departure(circle_map: CircleMap, allowed_tv: float, pushed: Array, own_noise: Noise | None) -> float:
    """A lower bound on |1 - g_m|/m for the best m, g_m = E e^{imξ}: for every law of ξ that leaves TV ≤ ``allowed_tv``.

    With p = u + e the stationary law, g_m N_m (F#u)_m = ∫ (e^{imθ} - g_m N_m e^{imF(θ)}) e(dθ), and e is the
    difference of two measures of mass ε at most: the left side is no more than ε times the diameter of the curve in
    brackets. All g_m about 1 that break this are impossible; they are tried on rings, with Lipschitz constants
    between the values tried. pushed : |(F#u)_m|, m from 1, not above the truth. E|ξ| is at least what is returned.
    """
    grid = CycleCells(circle_map, _CELLS)
    images = grid.by_cell(grid.images)
    middle = images[:, images.shape[1] // 2]
    reach = np.max(np.abs(images - middle[:, None]), axis=1) + np.max(grid.by_cell(grid.image_reach), axis=1)
    theta = grid.by_cell(grid.middles)[:, images.shape[1] // 2]
    best = 0.0
    for m in range(1, _MODES + 1):
        kept = 1.0 if own_noise is None else float(own_noise.coefficients(m))
        slack = m * (0.5 * grid.width + grid.part_width + float(np.max(reach)))
        curve = np.exp(1j * m * theta), kept * np.exp(1j * m * middle)
        best = max(best, _impossible_radius(curve, abs(kept) * float(pushed[m - 1]), allowed_tv, slack) / m)
    return best


def _impossible_radius(curve: tuple[Waves, Waves], moment: float, allowed: float, slack: float) -> float:
    """The radius about 1 inside which no g in the unit disc has |g|·moment ≤ allowed·diameter."""
    margin = _SPACING * (moment + 2.0 * allowed)
    radius = 0.0
    while radius < 1.0:
        count = int(np.ceil(2.0 * np.pi * radius / _SPACING)) + 1
        tried = 1.0 + radius * np.exp(2j * np.pi * np.arange(count) / count)
        tried = tried[np.abs(tried) <= 1.0 + _SPACING]
        left = np.abs(tried) * moment - allowed * (_diameters(curve, tried) + 2.0 * slack)
        if np.any(left <= margin):
            break
        radius += _SPACING
    return max(0.0, radius - _SPACING)


def _diameters(curve: tuple[Waves, Waves], factors: Waves) -> Array:
    """(n,): upper bounds on the diameters of the points A - gB, one a factor g, from widths in several directions."""
    points = curve[0] - factors[:, None] * curve[1]
    turns = np.exp(1j * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS)
    widths = [np.ptp((points * turn).real, axis=1) for turn in turns]
    return np.asarray(np.max(widths, axis=0) / np.cos(0.5 * np.pi / _DIRECTIONS))
