"""What a sample of materials tells of those in between: shares with confidence, and slopes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import finite_array, finite_number, whole_number
from cyclemap.errors import InvalidInput

Array = NDArray[np.float64]

_PROBES = 4096
_NEIGHBOURS = 8


def share_bound(exceeding: int, drawn: int, confidence: float = 0.95) -> float:
    """Return the upper confidence bound of the share of all materials that exceed, from independent draws.

    Clopper & Pearson (1934), one-sided: the share for which `exceeding` or fewer of `drawn` have probability
    1 - confidence. None of n: 1 - (1 - confidence)^(1/n), about 3/n at 95 %. One where nothing was drawn.

    >>> round(share_bound(0, 1000), 6), share_bound(4, 4)
    (0.002991, 1.0)
    """
    from scipy.stats import beta

    count = whole_number("drawn", drawn, least=0)
    over = whole_number("exceeding", exceeding, least=0)
    if over > count:
        raise InvalidInput(f"{over} of {count} cannot exceed")
    if not 0.0 < finite_number("confidence", confidence) < 1.0:
        raise InvalidInput(f"confidence is {confidence}: it lies between 0 and 1, such as 0.95")
    return 1.0 if over == count else float(beta.ppf(confidence, over + 1, count - over))


def largest_between(points: Array, values: Array, seed: int = 0) -> float:
    """Return how large a function on the cube [-1, 1]^d may be between points where it is known: an estimate.

    Its steepest slope L is taken from each point to its eight nearest, and the function, if nowhere steeper, is at most
    f_i + L |p - p_i| at p for the nearest p_i; the largest of these over 4096 places (Sobol) and the corners. No proof:
    a spike between all points would escape it. Needs at least d + 2 different points, else inf.

    >>> grid = np.stack(np.meshgrid(*[np.linspace(-1, 1, 9)] * 2), axis=-1).reshape(-1, 2)
    >>> found = largest_between(grid, grid @ [0.3, 0.4])
    >>> 0.7 < found < 0.8
    True
    """
    from scipy.spatial import KDTree
    from scipy.stats import qmc

    known, heights = finite_array("points", points, ndim=2), finite_array("values", values, ndim=1)
    dimensions = known.shape[1]
    if dimensions == 0:
        return float(np.max(heights))
    known, first = np.unique(known, axis=0, return_index=True)
    heights = heights[first]
    if len(known) < dimensions + 2:
        return float("inf")
    tree = KDTree(known)
    away, near = tree.query(known, k=min(_NEIGHBOURS + 1, len(known)))
    steepest = float(np.max(np.abs(heights[near[:, 1:]] - heights[:, None]) / away[:, 1:]))
    probes = 2.0 * qmc.Sobol(dimensions, rng=np.random.default_rng(seed)).random(_PROBES) - 1.0
    corners = np.array(np.meshgrid(*[[-1.0, 1.0]] * dimensions)).reshape(dimensions, -1).T
    distance, nearest = tree.query(np.concatenate([probes, corners]))
    return float(np.max(heights[nearest] + steepest * distance))
