"""How far laws are from where they should be, for the worst start, and for how long."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from cyclemap.checks import read_only
from cyclemap.maps.arcs import Array
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.maps.mixtures.law_distances import (
    cumulative_on_grid,
    density_on_grid,
    total_variation_on_grid,
    wasserstein_on_grid,
)
from cyclemap.maps.mixtures.start_grid import StartGrid

Moments = npt.NDArray[np.complex128]
_BETWEEN = 2.0  # safety on what starts between the grid's may add: its slope's slope is only measured there
_FINENESS = 8  # grid points a mode that counts
_LEAST_GRID = 512
_NEGLIGIBLE = 1e-6  # moments left out of a grid; their sum is in the bound


@dataclass(frozen=True, eq=False)
class WorstStart:
    """The largest distance over all starts from a law, cycle by cycle; n = 1, ..., cycles, each array (cycles,).

    total_variation : sup over starts, in [0, 1]. wasserstein : the same for W1, radians.
    start : the starting angle, of the grid, that is furthest in total variation.
    total_variation_error, wasserstein_error : bounds on their errors: what starts between the grid's may add, the
        grid of angles, the reference law and truncation. A distance is convex, so that a start between two others
        can only be further than both by how far its law is from the line between theirs: h²/8 times the second
        derivative, measured on the grid by differences, and doubled.
    """

    total_variation: Array
    wasserstein: Array
    start: Array
    total_variation_error: Array
    wasserstein_error: Array


@dataclass(frozen=True)
class ReachTime:
    """The least number of cycles after which something holds; inf where it never does.

    earliest, latest : between which it surely lies, by the error bounds; ``latest`` is inf where they cannot tell.
    """

    cycles: float
    earliest: float
    latest: float

    @property
    def certified(self) -> bool:
        """Whether the bounds confirm a latest number of cycles, or that there is none."""
        return bool(np.isfinite(self.latest) or np.isinf(self.earliest))


def worst_starts(rows: list[tuple[float, ...]]) -> WorstStart:
    """What ``farthest_start`` gave, cycle by cycle, as one value."""
    return WorstStart(*(read_only(part) for part in zip(*rows, strict=True)))


def farthest_start(moments: Moments, grid: StartGrid, aim: FourierLaw, left_out: float) -> tuple[float, ...]:
    """(TV, W1, start, their bounds) of the start whose law is furthest from ``aim``.

    moments : (M + 1, starts), of the laws from the starts of ``grid``. left_out : bound in L1 on the error of every
    one of them.
    """
    difference, left = _compressed(_less(moments, aim))
    bent, bent_left = _compressed(grid.bends(moments))
    known = left + _BETWEEN * bent_left + 0.5 * left_out + np.pi * aim.error_bound
    variation, distance = (_measured(difference, *parts) for parts in (_VARIATION, _WASSERSTEIN))
    errors = [
        min(most, _BETWEEN * float(np.max(_measured(bent, *parts)[0])) + float(np.max(found[1])) + most * known)
        for found, parts, most in ((variation, _VARIATION, 1.0), (distance, _WASSERSTEIN, np.pi))
    ]
    worst = int(np.argmax(variation[0]))
    return min(1.0, float(variation[0][worst])), float(np.max(distance[0])), float(grid.angles[worst]), *errors


def largest_variation(moments: Moments, aim: FourierLaw) -> float:
    """The largest total variation distance alone, without its bound."""
    return float(np.max(_measured(_compressed(_less(moments, aim))[0], *_VARIATION)[0]))


_VARIATION = density_on_grid, total_variation_on_grid, _FINENESS
_WASSERSTEIN = cumulative_on_grid, wasserstein_on_grid, _FINENESS // 2


def _measured(moments: Moments, values: Any, measure: Any, fineness: int) -> tuple[Array, Array]:
    count = max(_LEAST_GRID, 1 << int(np.ceil(np.log2(fineness * moments.shape[-1]))))
    found, bound = measure(values(moments, count))
    return found, bound


def _less(moments: Moments, aim: FourierLaw) -> Moments:
    difference = np.zeros((max(aim.modes + 1, len(moments)), moments.shape[1]), dtype=np.complex128)
    difference[: len(moments)] = moments
    difference[: aim.modes + 1] -= aim.moments[:, None]
    return difference


def _compressed(moments: Moments) -> tuple[Moments, float]:
    """The first moments that count in any column, (columns, kept), and a bound on the L1 norm of the rest."""
    size = np.max(np.abs(moments), axis=1)
    kept = int(np.max(np.flatnonzero(size > _NEGLIGIBLE), initial=1)) + 1
    return moments[:kept].T, float(np.sum(size[kept:]))
