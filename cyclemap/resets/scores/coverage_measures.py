"""How well a set of orientations covers the circle, and what independent ones would: largest gap, Kuiper, sectors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cyclemap.checks import finite_number, whole_number
from cyclemap.evidence.orientations.circular_law import CircularLaw, orientations
from cyclemap.evidence.orientations.goodness_of_fit import kuiper_statistic
from cyclemap.maps.arcs import TWO_PI, Array

GOLDEN_ANGLE = float(np.pi * (3.0 - np.sqrt(5.0)))
DEFAULT_SECTORS = 12


@dataclass(frozen=True, eq=False)
class CoverageMeasures:
    """How each set of n orientations covers the circle; arrays (...), one entry a set.

    largest_gap : radians, the widest arc without one. kuiper : Kuiper's discrepancy from the target, in (0, 1].
    sector_share : share of the equal sectors, from 0 on, that hold at least one.
    """

    largest_gap: Array
    kuiper: Array
    sector_share: Array


def coverage_measures(
    theta: Any, sectors: int = DEFAULT_SECTORS, target: CircularLaw | None = None
) -> CoverageMeasures:
    """Coverage of sets of orientations, shape (..., n), radians, any turn, each row a set of its own.

    target : of the discrepancy; None is uniform.

    >>> even = coverage_measures(rotation_angles(8, TWO_PI / 8), sectors=4)
    >>> round(float(even.largest_gap) / np.pi, 12), round(float(even.kuiper), 12), float(even.sector_share)
    (0.25, 0.125, 1.0)
    """
    angles, count = orientations("theta", theta), whole_number("sectors", sectors, least=1)
    ordered = np.sort(angles, axis=-1)
    gaps = np.diff(ordered, axis=-1, append=ordered[..., :1] + TWO_PI)
    place = np.minimum((ordered * (count / TWO_PI)).astype(np.int64), count - 1)
    visited = 1 + np.sum(np.diff(place, axis=-1) > 0, axis=-1)
    return CoverageMeasures(
        np.max(gaps, axis=-1), _kuiper(ordered, target), np.asarray(visited / count, dtype=np.float64)
    )


def _kuiper(ordered: Array, target: CircularLaw | None) -> Array:
    if target is not None:
        return kuiper_statistic(ordered, target)
    size = ordered.shape[-1]
    excess = np.arange(size) / size - ordered / TWO_PI
    return np.asarray(np.max(excess, axis=-1) - np.min(excess, axis=-1) + 1.0 / size)


def rotation_angles(count: int, turn: float = GOLDEN_ANGLE, start: float = 0.0) -> Array:
    """start + i·turn, i = 0, ..., count - 1: a rotation's orbit, the golden angle's unless told otherwise; radians."""
    size = whole_number("count", count, least=1)
    return np.asarray(finite_number("start", start) + finite_number("turn", turn) * np.arange(size))


# -- independent orientations ----------------------------------------------------------------------------------


def independent_largest_gap(count: int) -> float:
    """Mean largest gap, radians, of n independent uniform orientations: (2π/n)(1 + 1/2 + ... + 1/n) (Lévy 1939).

    >>> round(independent_largest_gap(2) / np.pi, 12)
    1.5
    """
    size = whole_number("count", count, least=1)
    return float(TWO_PI / size * np.sum(1.0 / np.arange(1, size + 1)))


def independent_kuiper(count: int) -> float:
    """Mean Kuiper discrepancy of n independent orientations from their own law, about √(π/2)/(√n + .155 + .24/√n).

    √(π/2) is the mean range of a Brownian bridge; the correction is Stephens' (1970). Within 1 % for n ≥ 4.
    """
    root = float(np.sqrt(whole_number("count", count, least=1)))
    return float(np.sqrt(0.5 * np.pi) / (root + 0.155 + 0.24 / root))


def independent_sector_share(count: int, probabilities: Any) -> float:
    """Mean share of sectors visited by n independent orientations: 1 - mean of (1 - P_s)^n.

    probabilities : (sectors,), of the sectors; a whole number means so many equally likely ones.

    >>> independent_sector_share(2, 2)
    0.75
    """
    size = whole_number("count", count, least=1)
    if np.ndim(probabilities) == 0:
        sectors = whole_number("probabilities", probabilities, least=1)
        probabilities = np.full(sectors, 1.0 / sectors)
    return float(1.0 - np.mean((1.0 - np.asarray(probabilities, dtype=np.float64)) ** size))


def independent_full_cover(sectors: int) -> float:
    """Mean number of independent uniform orientations until each of k equal sectors is visited: k(1 + ... + 1/k).

    >>> independent_full_cover(2)
    3.0
    """
    size = whole_number("sectors", sectors, least=1)
    return float(size * np.sum(1.0 / np.arange(1, size + 1)))
