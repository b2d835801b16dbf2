"""How an object rests on its underside, in unknowns whose bounds do not depend on each other."""

import numpy as np
from numpy.typing import NDArray

from cyclemap.evidence.identification.surface_parameters import SurfaceParameters
from cyclemap.mechanics import PatchFootprint, Slider
from cyclemap.mechanics.footprint import RIM_INNER, RIM_RISE
from cyclemap.mechanics.warp import Saddle

# A saddle that just lifts an edge stays this far below it; between the points looked at it may be a little lower.
_ROOM = 0.999


def largest_saddles(slider: Slider) -> tuple[float, float]:
    """Return the largest warps (a, b), each alone and of either sign, under which an even underside lifts nowhere.

    With the rim share w they grow by 1 + RIM_RISE w, as the pressure of the frame does.

    >>> [round(value, 3) for value in largest_saddles(Slider.mit("rect1"))]
    [0.719, 0.36]
    """
    assert slider.centre_of_mass is not None
    footprint = PatchFootprint.under(slider.outline, slider.centre_of_mass)
    rim = _dense(slider.outline.points(720)) - slider.outline.centroid
    levers = np.concatenate([rim, RIM_INNER * rim])
    pressure = np.minimum(1.0 + levers @ np.array(footprint.gradient), 1.0)
    first, second = (_largest(saddle, levers, pressure) for saddle in footprint.saddles)
    return first, second


def warp_of(surface: SurfaceParameters, slider: Slider) -> tuple[float, float]:
    """Return the warp (a, b) of the footprint: saddle_b of what is possible, and saddle_a of what that leaves."""
    (first, second), level = largest_saddles(slider), 1.0 + RIM_RISE * surface.rim_share
    left = 1.0 - abs(surface.saddle_b)
    return surface.saddle_a * left * first * level, surface.saddle_b * second * level


def warp_jacobian(surface: SurfaceParameters, slider: Slider) -> NDArray[np.float64]:
    """Return d (warp_a, warp_b) / d (rim_share, saddle_a, saddle_b), (2, 3)."""
    (first, second), level = largest_saddles(slider), 1.0 + RIM_RISE * surface.rim_share
    a, b = warp_of(surface, slider)
    left, sign = 1.0 - abs(surface.saddle_b), float(np.sign(surface.saddle_b))
    by_a = (a / level * RIM_RISE, left * first * level, -sign * surface.saddle_a * first * level)
    return np.array((by_a, (b / level * RIM_RISE, 0.0, second * level)))


def _dense(polyline: NDArray[np.float64], pieces: int = 32) -> NDArray[np.float64]:
    """The points of a polyline (k, 2) and those that cut each of its sides into pieces."""
    share = np.linspace(0.0, 1.0, pieces, endpoint=False)[:, np.newaxis]
    cut = polyline[:-1, np.newaxis] + share * np.diff(polyline, axis=0)[:, np.newaxis]
    return np.asarray(cut.reshape(-1, 2))


def _largest(saddle: Saddle, levers: NDArray[np.float64], pressure: NDArray[np.float64]) -> float:
    values = np.abs(saddle.at(levers))
    return float(_ROOM * (1.0 - RIM_INNER**2) * np.min(pressure / np.maximum(values, 1e-12)))
