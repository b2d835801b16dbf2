"""What the next pushes will bring if nothing is changed: runs of the map fitted to what was recorded."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import whole_number
from cyclemap.evidence.laws.harmonic_map import HarmonicMap, harmonic_map
from cyclemap.evidence.theta0.theta0_pairs import Theta0Pairs
from cyclemap.maps import WrappedNormal, sample_staircases
from cyclemap.maps.arcs import TWO_PI, shorter_way
from cyclemap.resets.monitor.bias_monitor import BiasMonitor
from cyclemap.resets.monitor.coverage import CELLS

Array = NDArray[np.float64]

FEWEST_PAIRS = 100
WIDEST_GAP = math.radians(30.0)  # a law with six harmonics is not read across wider gaps
MOST_SCATTER = math.radians(45.0)
_RUNS = 64
_WORTH_RUNS = 16
_COVER_STEP = 0.1
# Radians: no angle is measured better than this.
_LEAST_SCATTER = 1e-9


@dataclass(frozen=True, eq=False)
class Forecast:
    """The next ``ahead`` pushes with the reset as it is, from runs of the fitted map with its noise.

    fitted : the map, and the noise in it; wear is taken as noise. ahead : pushes looked ahead.
    worth : effective pushes gained a push, on average.
    pushes_to_leave : median pushes until θ0 is more than the rest's half width away from where it rests; None where it
        does not rest on one direction, inf where over half the runs stay.
    cover_target : the next share of the circle to be covered; pushes_to_cover : median pushes until it is, inf where
        over half the runs do not come to it.
    """

    fitted: HarmonicMap
    ahead: int
    worth: float
    pushes_to_leave: float | None
    cover_target: float
    pushes_to_cover: float


def forecast(monitor: BiasMonitor, ahead: int = 500, seed: int = 0) -> Forecast | None:
    """The next ``ahead`` pushes, or None where too little was recorded since the reset was last changed.

    Needed are 100 pairs of successive pushes, no gap wider than 30° between the directions recorded, and less than 45°
    of scatter about the fitted map: beyond that a turn, taken the shorter way round, says little of a map. 64 runs;
    about 0.1 s for 500 pushes.

    >>> forecast(BiasMonitor()) is None
    True
    """
    count, path = whole_number("ahead", ahead, least=1), np.array(monitor.path)
    if path.size <= FEWEST_PAIRS or _widest_gap(path) > WIDEST_GAP:
        return None
    fitted = harmonic_map(Theta0Pairs(path[:-1], path[:-1] + shorter_way(np.diff(path))))
    if fitted.sigma > MOST_SCATTER:
        return None
    noise = WrappedNormal(max(fitted.sigma, _LEAST_SCATTER))
    runs = sample_staircases(fitted.map, noise, count, np.full(_RUNS, path[-1]), seed)[:, 1:]
    target = min(monitor.report.coverage.covered + _COVER_STEP, 1.0)
    return Forecast(
        fitted=fitted,
        ahead=count,
        worth=float(np.mean([monitor.coverage.worth_of(run) for run in runs[:_WORTH_RUNS]])) / count,
        pushes_to_leave=_pushes_to_leave(monitor, runs),
        cover_target=target,
        pushes_to_cover=_pushes_to_cover(monitor, runs, target),
    )


def _widest_gap(path: Array) -> float:
    places = np.sort(np.mod(path, TWO_PI))
    return float(np.diff(np.append(places, places[0] + TWO_PI)).max())


def _pushes_to_leave(monitor: BiasMonitor, runs: Array) -> float | None:
    rest = monitor.report.rest
    if rest is None or len(rest.directions) > 1:
        return None
    away = np.abs(shorter_way(runs - rest.directions[0])) > monitor.rest_rule.half_width
    return _median_first(away)


def _pushes_to_cover(monitor: BiasMonitor, runs: Array, target: float) -> float:
    """The median over runs of the pushes after which the share ``target`` of the circle is covered."""
    first = np.full((len(runs), CELLS), np.inf)
    cells = np.minimum((np.mod(runs, TWO_PI) * (CELLS / TWO_PI)).astype(np.int64), CELLS - 1)
    rows, pushes = np.indices(runs.shape)
    np.minimum.at(first, (rows, cells), pushes + 1.0)
    soon = np.sort(monitor.coverage.first_covered(first), axis=1)
    return float(np.median(soon[:, math.ceil(target * CELLS - 1e-9) - 1]))


def _median_first(happened: NDArray[np.bool_]) -> float:
    """The median over rows of how many pushes it takes until ``happened`` first holds; inf for never."""
    first = np.where(happened.any(axis=1), happened.argmax(axis=1) + 1.0, np.inf)
    return float(np.sort(first)[len(first) // 2])
