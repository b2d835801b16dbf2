"""Starting angles that stand for all: an even grid and both sides of every break, and what may happen in between."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from cyclemap.maps.arcs import TWO_PI, Array

_SAME = 1e-9  # radians: a start of the even grid this near to a break is left out


@dataclass(frozen=True, eq=False)
class StartGrid:
    """Starts in rising order, and triples of neighbours on one smooth piece of the map.

    angles : (k,), radians in [0, 2π). from_left : (k,), whether the start stands for the limit from below (at a
    break, which is there twice). triples : (3, t), indices of starts. factors : (3, t): the sum of factor times value
    over a triple bounds, to second order, how far a function of the start strays from the line between neighbours.
    """

    angles: Array
    from_left: npt.NDArray[np.bool_]
    triples: npt.NDArray[np.int64]
    factors: Array

    def bends(self, values: Any) -> Any:
        """That sum for every triple, (..., t), of values (..., k)."""
        return sum(factor * values[..., at] for factor, at in zip(self.factors, self.triples, strict=True))


def start_grid(count: int, breaks: Array) -> StartGrid:
    """``count`` evenly spaced starts and both sides of the ``breaks`` (radians, sorted, in [0, 2π)).

    A cell between neighbours at distance h strays by at most h²/8 times the second derivative, which is taken from
    the triples at both its ends.

    >>> grid = start_grid(8, np.array([1.0]))
    >>> grid.angles.size, int(np.sum(grid.from_left)), bool(np.max(np.abs(grid.bends(grid.angles)[:5])) < 1e-15)
    (10, 1, True)
    """
    even = TWO_PI * np.arange(count) / count
    if breaks.size == 0:
        middle = np.arange(count)
        triples = np.stack([np.roll(middle, 1), middle, np.roll(middle, -1)])
        return StartGrid(even, np.zeros(count, dtype=bool), triples, _factors(np.full((2, count), even[1])))
    apart = np.abs(np.mod(even[:, None] - breaks + np.pi, TWO_PI) - np.pi)
    even = even[np.all(apart > _SAME, axis=1)]
    # From the right side of the first break once around to its left side, so that no piece is cut by 2π.
    first = float(breaks[0])
    lifted = np.concatenate([first + np.mod(even - first, TWO_PI), breaks, breaks[1:], [first + TWO_PI]])
    left = np.repeat([False, True], [even.size + breaks.size, breaks.size])
    order = np.lexsort((~left, lifted))
    lifted, left = lifted[order], left[order]
    middle = np.flatnonzero(~np.isin(np.arange(lifted.size), [0, lifted.size - 1]))
    steps = np.diff(lifted)
    middle = middle[(steps[middle - 1] > 0.0) & (steps[middle] > 0.0)]
    triples = np.stack([middle - 1, middle, middle + 1])
    angles = np.mod(lifted, TWO_PI)
    angles[-1] = first
    return StartGrid(angles, left, triples, _factors(np.stack([steps[middle - 1], steps[middle]])))


def _factors(steps: Array) -> Array:
    """h²/8 times the weights of the divided second difference, h the wider of the two steps (2, t) of a triple."""
    before, after = steps
    scale = 0.25 * np.maximum(before, after) ** 2 / (before + after)
    return np.asarray(np.stack([scale / before, -scale / before - scale / after, scale / after]))
