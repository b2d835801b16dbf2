"""How many pushes each full turn took, and how many the fitted map that wears gives it from where it began."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import whole_number
from cyclemap.evidence.laws.fit_map import FittedMap

DEFAULT_RUNS = 200
# A predicted turn is followed for this many times the pushes that the measured one took, and some.
_PATIENCE, _LEAST = 3, 60


@dataclass(frozen=True, eq=False)
class TurnPace:
    """The full turns of a measured path, in order, each beside its prediction.

    start : (k,) the cycle in which each turn began. measured : (k,) the pushes that it took.
    predicted, lower, upper : (k,) median and central 95 % of the pushes that the worn map takes for the same turn,
        begun in the same cycle at the same angle; inf where too many paths took longer than they were followed.
    """

    start: Array
    measured: Array
    predicted: Array
    lower: Array
    upper: Array

    @property
    def inside(self) -> float:
        """The share of measured turns within the central 95 % of their predictions; NaN without turns."""
        held = (self.lower <= self.measured) & (self.measured <= self.upper)
        return float(np.mean(held)) if held.size else float("nan")


def full_turns(path: Array, level: float = 0.0) -> NDArray[np.int64]:
    """The places (k + 1,) in the path (m,), rad, unwrapped, where it first reaches level + 2πj for each next whole j.

    A path that turns downward on the whole is read upside down. Empty where it passes no such level.

    >>> full_turns(np.arange(20.0), level=1.0).tolist()
    [1, 8, 14]
    """
    upward = path[-1] >= path[0]
    climb, mark = (path, level) if upward else (-path, -level)
    highest = np.maximum.accumulate(climb)
    first = np.ceil((climb[0] - mark) / TWO_PI)
    levels = mark + TWO_PI * np.arange(first, np.floor((highest[-1] - mark) / TWO_PI) + 1.0)
    return np.searchsorted(highest, levels)


def turn_pace(
    fitted: FittedMap, path: Array, cycle: Array, level: float, runs: int = DEFAULT_RUNS, seed: int = 0
) -> TurnPace:
    """Time the turns of a path (m,), rad, whose entries were recorded in the cycles ``cycle`` (m,).

    level : rad, where a turn begins and ends: best where the map is fast, so that jitter does not move the mark.
    fitted : with wear (``fit_map(..., cycle=...)``). Each prediction is made of ``runs`` paths, from ``seed``.

    Raises InvalidInput where the map was fitted without cycle numbers.
    """
    runs, sign = whole_number("runs", runs, least=1), 1.0 if path[-1] >= path[0] else -1.0
    places = full_turns(path, level)
    measured = np.diff(cycle[places])
    quantiles = [
        _predicted(fitted, (float(path[place]), float(cycle[place])), sign * level, sign, float(taken), runs, seed + k)
        for k, (place, taken) in enumerate(zip(places[:-1], measured, strict=True))
    ]
    low, middle, high = np.array(quantiles).reshape(-1, 3).T
    return TurnPace(cycle[places[:-1]], measured, middle, low, high)


def _predicted(
    fitted: FittedMap, begun: tuple[float, float], mark: float, sign: float, taken: float, runs: int, seed: int
) -> Array:
    """The 2.5, 50 and 97.5 % points of the pushes until the next mark, from the angle where the turn began."""
    start, cycle = begun
    # A turn begins a little past its mark: by so much less it has to climb to the next.
    past = np.remainder(sign * start - mark, TWO_PI)
    paths = fitted.paths(np.full(runs, start), int(_PATIENCE * taken) + _LEAST, first=cycle, seed=seed)
    reached = sign * (paths - start) >= TWO_PI - past
    pushes = np.where(reached.any(axis=1), np.argmax(reached, axis=1), np.inf)
    return np.asarray(np.quantile(pushes, [0.025, 0.5, 0.975], method="inverted_cdf"))
