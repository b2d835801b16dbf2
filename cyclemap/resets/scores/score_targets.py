"""The law that is wished for in the forms that scores ask for, and where a law has its peaks."""

from __future__ import annotations

import numpy as np

from cyclemap.evidence.orientations.circular_law import CircularLaw
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.resets.scores.evenness import Target

_TARGET_MODES = 1024
_GRID = 4096  # angles at which peaks are sought
_FLAT = 1e-6  # of the uniform density


def target_law(target: Target) -> FourierLaw:
    """A target as a law: None is uniform, a density per radian is expanded in 1024 Fourier modes."""
    if target is None or isinstance(target, FourierLaw):
        return FourierLaw.uniform() if target is None else target
    return FourierLaw.from_density(target, _TARGET_MODES)


def target_table(target: Target) -> CircularLaw | None:
    """A target as a table of its probabilities; None for uniform."""
    if target is None:
        return None
    return CircularLaw(target.density if isinstance(target, FourierLaw) else target)


def law_peaks(law: FourierLaw) -> Array:
    """Angles in [0, 2π), radians, of the maxima of a law's density on a grid of 4096; none where it is uniform.

    >>> np.degrees(law_peaks(FourierLaw(np.array([1.0, 0.2j])))).round(9).tolist()
    [90.0]
    """
    grid = TWO_PI * np.arange(_GRID) / _GRID
    density = law.density(grid)
    top = (density > np.roll(density, 1)) & (density >= np.roll(density, -1))
    return np.asarray(grid[top] if np.ptp(density) * TWO_PI > _FLAT else np.empty(0))
