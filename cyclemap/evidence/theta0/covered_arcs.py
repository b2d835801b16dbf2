"""Which part of the circle was measured: of the rest nothing can be said."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.arrays import TWO_PI
from cyclemap.checks import finite_array

# Measured orientations further apart than this leave a gap: laws of cycles may do anything within 20 degrees.
GAP = float(np.radians(20.0))
# What lies this near an end of an arc is taken with it.
_EDGE = float(np.radians(1.0))


def covered_arcs(measured: ArrayLike) -> tuple[tuple[float, float], ...]:
    """The arcs from the first to the last of orientations (n,), n ≥ 1, rad, that lie no further apart than ``GAP``.

    Each is (from, to), from in [0, 2π), to no less; in order of from. The whole circle is (0, 2π).

    >>> [(round(low, 9), round(high, 9)) for low, high in covered_arcs([6.1, 6.3, 0.2, 3.0])]
    [(3.0, 3.0), (6.1, 6.483185307)]
    """
    places = np.sort(np.mod(finite_array("measured", measured, ndim=1), TWO_PI))
    gaps = np.append(np.diff(places), places[0] + TWO_PI - places[-1])
    ends = np.flatnonzero(gaps > GAP)
    if not ends.size:
        return ((0.0, TWO_PI),)
    begins = np.roll((ends + 1) % places.size, 1)
    arcs = ((float(places[b]), float(places[e])) for b, e in zip(begins, ends, strict=True))
    return tuple(sorted((low, high if high >= low else high + TWO_PI) for low, high in arcs))


def is_covered(measured: ArrayLike, theta: ArrayLike) -> NDArray[np.bool_]:
    """Whether each of ``theta`` (...), rad, lies within 1 degree of a covered arc of ``measured`` (n,), n ≥ 1, rad.

    >>> is_covered([6.2, 6.4], [0.0, 1.0]).tolist()
    [True, False]
    """
    angles = finite_array("theta", theta)
    inside = [np.mod(angles - low + _EDGE, TWO_PI) <= high - low + 2 * _EDGE for low, high in covered_arcs(measured)]
    return np.asarray(np.any(inside, axis=0))
