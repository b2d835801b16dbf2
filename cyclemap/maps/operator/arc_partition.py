"""The best partition of a circle of cells into arcs that a stationary flow seldom leaves, by dynamic programming."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from cyclemap.maps.arcs import Array


def leaving_chances(flow: Array) -> Array:
    """P(outside after a cycle | inside now) of every arc: shape (n, n), at [i, l - 1] for cells i, ..., i + l - 1.

    flow : (n, n), the stationary probability of being in cell i now and in cell j next, all >= 0. The last column, the
    whole circle, is 0. Nothing is subtracted, so small chances keep their digits.

    >>> leaving_chances(np.array([[0.4, 0.1], [0.1, 0.4]])).tolist()
    [[0.2, 0.0], [0.2, 0.0]]
    """
    size = flow.shape[0]
    chances = np.zeros((size, size))
    weight = flow.sum(axis=1)
    inside = np.arange(size)[:, None] <= np.arange(size - 1)
    for start in range(size):
        turned = np.roll(flow, (-start, -start), axis=(0, 1))
        beyond = np.cumsum(turned[:, :0:-1], axis=1)[:, ::-1]
        mass = np.cumsum(np.roll(weight, -start))[:-1]
        chances[start, :-1] = np.sum(beyond, axis=0, where=inside) / np.maximum(mass, np.finfo(float).tiny)
    return chances


def best_cuts(cost: Array, count: int) -> npt.NDArray[np.int64]:
    """First cells of the ``count`` arcs that divide the circle at least total cost, in rising order.

    cost : (n, n), of the arc of l cells from cell i at [i, l - 1]. The minimum over all choices is found: for each
    first cut, shortest paths of ``count`` arcs around the circle (Bellman 1957), O(count·n³) together.

    >>> best_cuts(leaving_chances(np.eye(4) + np.eye(4)[[1, 0, 3, 2]]), 2).tolist()
    [0, 2]
    """
    size = cost.shape[0]
    behind, ahead = np.meshgrid(np.arange(size), np.arange(1, size + 1), indexing="ij")
    length = ahead - behind - 1
    least, best = np.inf, np.zeros(count, dtype=np.int64)
    for start in range(size):
        steps = np.where(length >= 0, cost[(start + behind) % size, np.maximum(length, 0)], np.inf)
        total, cuts = _shortest(steps, count)
        if total < least:
            least, best = total, (start + cuts) % size
    return np.sort(best)


def _shortest(steps: Array, count: int) -> tuple[float, npt.NDArray[np.int64]]:
    """The cheapest way from 0 to n in ``count`` steps; steps[l, j - 1] is the cost from l to j. Its points but n."""
    reached, came = steps[0], []
    for _ in range(count - 1):
        through = reached[:-1, None] + steps[1:]
        origin = np.argmin(through, axis=0)
        reached = through[origin, np.arange(origin.size)]
        came.append(origin + 1)
    at, cuts = steps.shape[0], []
    for origins in reversed(came):
        at = int(origins[at - 1])
        cuts.append(at)
    return float(reached[-1]), np.array([0, *reversed(cuts)], dtype=np.int64)
