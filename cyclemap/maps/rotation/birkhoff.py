"""Weighted Birkhoff averages: means along one orbit that converge fast where the orbit is quasi-periodic."""

from __future__ import annotations

from math import floor

import numpy as np

from cyclemap.checks import finite_array, finite_number, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.lifts.circle_map import CircleMap, Lift
from cyclemap.maps.rounding import MEAN

ITERATES = 40_000


def birkhoff_average(
    circle_map: CircleMap,
    function: Lift | None = None,
    *,
    start: float = 0.0,
    iterates: int = ITERATES,
    transient: int = 0,
) -> Estimate:
    """The mean of ``function`` along one orbit, with weights exp(-1/t(1 - t)), t = k/(N + 1), k = 1..N.

    On a quasi-periodic orbit with Diophantine rotation number of a smooth map the error falls faster than
    any power of 1/N; a plain mean has 1/N. (Das, Saiki, Sander & Yorke, Nonlinearity 30, 2017.) On a chaotic
    orbit it is about that of a plain mean, 1/√N.

    function : vectorised, of angles in [0, 2π) (radians); None averages the turn F(θ) - θ, radians a cycle,
        which needs degree 1. -inf is allowed as a value and makes the mean -inf.
    start : radians; iterates : N, at least 16; transient : cycles run before the averaging begins.

    The error bound is estimated, not proved: the larger distance from the means over the first and the last half of
    the orbit, which converge like the whole at half its length, plus rounding of a few units of the largest value.
    It says how well this orbit's mean is known, in exact arithmetic on the map as given.

    >>> mean = birkhoff_average(CircleMap.moebius(0.5, 0.3))
    >>> abs(mean / (2 * np.pi) - 0.262536755898823346733597549046) < 1e-14, mean.error_bound < 1e-13
    (True, True)
    """
    if not isinstance(circle_map, CircleMap):
        raise InvalidInput(f"the map is {circle_map!r}: give a CircleMap")
    if function is None and circle_map.degree != 1:
        raise InvalidInput(f"the map has degree {circle_map.degree}: its turn has a mean only for degree 1")
    count = whole_number("iterates", iterates, least=16)
    skipped = whole_number("transient", transient, least=0)
    visited = orbit_angles(circle_map, finite_number("start", start), skipped + count)[skipped:]
    values = np.asarray((function or circle_map.turn)(visited), dtype=np.float64)
    if values.shape != visited.shape:
        raise InvalidInput(f"function turns shape {visited.shape} into {values.shape}: it must act entry by entry")
    return weighted_mean(values)


def orbit_angles(circle_map: CircleMap, start: float, count: int) -> Array:
    """The first ``count`` angles of the orbit of ``start``, itself included, radians, each within [0, 2π)."""
    lift, theta = circle_map.scalar(), start - TWO_PI * floor(start / TWO_PI)
    visited = []
    for _ in range(count):
        visited.append(theta)
        image = lift(theta)
        theta = image - TWO_PI * floor(image / TWO_PI)
    return np.array(visited)


def weighted_mean(values: Array) -> Estimate:
    """The mean of ``values``, shape (n,), n ≥ 16, in the order of time, as in ``birkhoff_average``.

    >>> float(weighted_mean(np.full(16, 0.25)))
    0.25
    """
    if np.any(np.isneginf(values)):
        return Estimate(-np.inf, 0.0)
    sequence = finite_array("values", values, ndim=1)
    if sequence.size < 16:
        raise InvalidInput(f"values has {sequence.size} entries: give at least 16")
    half = sequence.size // 2
    mean = _windowed(sequence)
    apart = max(abs(_windowed(part) - mean) for part in (sequence[:half], sequence[-half:]))
    return Estimate(mean, apart + MEAN * float(np.max(np.abs(sequence))))


def _windowed(values: Array) -> float:
    t = np.arange(1.0, values.size + 1.0) / (values.size + 1.0)
    weight = np.exp(-1.0 / (t * (1.0 - t)))
    # Sums of numpy are pairwise: their rounding grows with log n only.
    return float(np.sum(weight * values) / np.sum(weight))
