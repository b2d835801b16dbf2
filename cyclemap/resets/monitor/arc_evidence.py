"""Evidence, within the first dozens of pushes, that orientations keep to an arc of the circle."""

from __future__ import annotations

import math

import numpy as np

from cyclemap.arrays import TWO_PI, Array

CELLS = 36  # visits are counted in cells of ten degrees, arcs begin and end between them
# of a cell: the first push lies off the cells' ends, where rounding would move it to and fro
_OFFSET = 0.382
_WIDTHS = (6, 9, 12, 15, 18, 21, 24)  # of the arcs, in cells
# Pushes after which the orders are compared; all have the same weight.
CHECKS = (*range(14, 31, 2), 34, 40, 48)
_FEW, _MANY = 199, 19_999  # other orders: to see whether more are worth it, and what counts
_PROMISING = 20.0


class ArcEvidence:
    """All pushes so far set against their own turns in other orders, at a few early times.

    Where a reset has no bias its turns t_1, ..., t_n are exchangeable: the path from the first θ0
    with the turns in another order is as likely as the recorded one. Let L(path) be the likelihood
    of its visits where they spread evenly over an arc, all of them on it, against chance, mixed
    over arcs (60 to 240 degrees, beginning anywhere), and

        E_n = L(recorded) / mean of L over the recorded order and N orders drawn at random.

    Recorded and drawn orders are exchangeable, so the mean of E_n is 1 whatever the law of the
    turns (0 for 0 / 0 only lessens it). A climb that never turns back, by turns of less than 120
    degrees, cannot leap over what an arc leaves out, and lies between its first and its last θ0 in
    every order: its E_n is 1 at most, however slow it is and however its turns depend on θ0, as
    those of the mechanics do. A collection that keeps to half a circle with turns
    that would carry it off in most other orders has an E_n near N + 1. A single visit elsewhere
    ends it; what gathers more loosely, blocks of pushes tell (`VisitEvidence`).

    Theorem: with weights w_n of sum 1, S_n = sum of w_k E_k over the times k up to n never exceeds
    c, at any n, but with probability 1/c. Proof: S_n grows with n, and the mean of its limit is at
    most 1 (Markov). Its conditional means E[S_∞ | n pushes] ≥ S_n are a martingale that starts at 1
    or less, so S shared with another martingale obeys Ville's inequality (1939). An E_n that is not
    looked at counts as 0, which only lessens the mean: where 199 orders promise little the 19,999
    are not drawn. E-values and their means: Vovk & Wang 2021.

    >>> evidence = ArcEvidence()
    >>> for theta in np.random.default_rng(1).uniform(0.0, math.pi, 31).tolist():
    ...     evidence.add(theta)
    >>> evidence.log_evidence > math.log(400.0)
    True
    """

    def __init__(self, seed: int = 0) -> None:
        self._random = np.random.default_rng([seed, 1])
        self._path: list[float] = []
        self._sum = 0.0

    @property
    def log_evidence(self) -> float:
        """Natural logarithm of S; minus infinity while nothing was seen."""
        return math.log(self._sum) if self._sum > 0.0 else -math.inf

    def add(self, theta: float) -> None:
        """Take the next θ0 (rad, any number of turns)."""
        if len(self._path) > CHECKS[-1]:
            return
        self._path.append(theta)
        if len(self._path) - 1 in CHECKS:
            turns = np.diff(self._path)
            if self._e_value(turns, _FEW) >= _PROMISING:
                self._sum += self._e_value(turns, _MANY) / len(CHECKS)

    def _e_value(self, turns: Array, orders: int) -> float:
        """E of the recorded turns among so many other orders."""
        paths = np.tile(turns, (orders + 1, 1))
        paths[1:] = self._random.permuted(paths[1:], axis=1)
        likelihoods = arc_likelihoods(np.cumsum(paths, axis=1))
        return float(likelihoods[0] / np.mean(likelihoods)) if likelihoods[0] > 0.0 else 0.0


def arc_likelihoods(paths: Array) -> Array:
    """Return the likelihood of the visits of each path (n, m), rad from its start, mixed over arcs;
    of chance: 1.
    """
    cells = np.floor(paths * (CELLS / TWO_PI) + _OFFSET).astype(np.int64) % CELLS
    visited = np.zeros((len(paths), CELLS), dtype=bool)
    visited[np.arange(len(paths))[:, None], cells] = True
    # The start is a visit, too.
    visited[:, 0] = True
    before = np.cumsum(
        np.concatenate([np.zeros((len(paths), 1)), visited, visited], axis=1), axis=1
    )
    every, visits = before[:, CELLS], paths.shape[1] + 1
    total = np.zeros(len(paths))
    for width in _WIDTHS:
        on_it = before[:, width : width + CELLS] - before[:, :CELLS] == every[:, None]
        total += (CELLS / width) ** visits * np.sum(on_it, axis=1)
    return np.asarray(total / (CELLS * len(_WIDTHS)), dtype=np.float64)
