"""The cycle map of measured orientations with its wear, and what it foretells of the very path it was fitted to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import whole_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.laws.fit_map import FittedMap, fit_map
from cyclemap.evidence.orientations.circular_distance import circular_wasserstein, total_variation
from cyclemap.evidence.tables.push_sets import FEWEST
from cyclemap.evidence.tables.turn_pace import TurnPace, turn_pace
from cyclemap.evidence.theta0.theta0_pairs import Theta0Pairs
from cyclemap.evidence.theta0.theta0_statistics import AngleHistogram, angle_histogram
from cyclemap.maps import Orbit, SlowPassage, fixed_points, slow_passages

Array = NDArray[np.float64]
FULL_TURN = 2 * np.pi

DEFAULT_RUNS = 200
# Early and late are told an eighth of the run from its ends: polynomials are least certain at the very ends.
EARLY, LATE = 0.125, 0.875
# From here on the turns are counted: a new surface wears in during the first quarter.
WORN_IN = 0.25
_GRID = 1440
# Orientations that stand for all paths, and paths whose distance from these is measured.
_POOLED, _COMPARED = 20_000, 40


@dataclass(frozen=True, eq=False)
class MapState:
    """The fitted map at one cycle: what attracts, and where it is slow.

    slowest : (rad, rad a cycle) the angle where |turn| is least, and the turn there.
    passages : bottlenecks without fixed point. fixed_points : of the map, stable and unstable. cycle : NaN where
        the cycles have no numbers.
    """

    cycle: float
    fixed_points: tuple[Orbit, ...]
    passages: tuple[SlowPassage, ...]
    slowest: tuple[float, float]


@dataclass(frozen=True, eq=False)
class WornForecast:
    """Paths of the worn map beside the measured one.

    first_cycle : from here on turns are counted. measured_turns : climbed by then to the end, in full turns.
    left_out_turns : the part of these made in cycles that the fit left out (gaps and flagged jumps).
    turns : (runs,) climbed by paths that start where the measured one stood in ``first_cycle``.
    measured : (m,) rad, the measured path at every cycle, gaps filled in straight. run : (m,) rad, one path of the map
        from the measured start. lower, upper : (m,) rad, between which 95 % of such paths lie in each cycle.
    measured_histogram, histogram : of θ0 over all cycles. total_variation, wasserstein (rad) : between these two.
    run_distances : (up to 40,) rad, the Wasserstein distance of each path from all of them: what chance makes.
    """

    first_cycle: float
    measured_turns: float
    left_out_turns: float
    turns: Array
    measured: Array
    run: Array
    lower: Array
    upper: Array
    measured_histogram: AngleHistogram
    histogram: AngleHistogram
    total_variation: float
    wasserstein: float
    run_distances: Array
    pace: TurnPace


@dataclass(frozen=True, eq=False)
class MeasuredCycleMap:
    """A fitted cycle map and its account.

    fitted : with scatter that may depend on the angle and wear in time (of degree 0 where it was not asked for, or the
        order of the cycles is unknown). quietest, loudest : (rad, rad) where scatter is least and most, and its size.
    early, late : the map an eighth of the run from its ends; one and the same where nothing wears.
    forecast : paths of the map beside the measured one, None where the order of the pushes is unknown.
    """

    pairs: Theta0Pairs
    fitted: FittedMap
    quietest: tuple[float, float]
    loudest: tuple[float, float]
    early: MapState
    late: MapState
    forecast: WornForecast | None

    @property
    def wears(self) -> bool:
        """Whether the fitted map changes with the cycle."""
        return self.fitted.wear is not None and self.fitted.wear.degree > 0


def measured_cycle_map(
    pairs: Theta0Pairs,
    *,
    harmonics: int | None = None,
    wear: bool = True,
    runs: int = DEFAULT_RUNS,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> MeasuredCycleMap:
    """Fit the map, and follow it from where the measured path stood.

    harmonics : the order; None chooses it, together with the degree of the wear, by cross-validation over blocks of
        successive cycles; the degree is that of least error where there is wear at all.
    wear : False keeps the map the same in all cycles. runs : paths of each forecast.

    Raises InvalidInput for fewer than 20 pairs, and where they do not fix the map; ConvergenceError where the scatter
    could not be fitted.
    """
    if pairs.theta.size < FEWEST:
        raise InvalidInput(f"{pairs.theta.size} pairs are too few for a cycle map; give at least {FEWEST}")
    report = progress or (lambda fraction: None)
    fitted = _fitted(pairs, harmonics, wear, seed)
    report(0.5)
    theta = FULL_TURN * np.arange(_GRID) / _GRID
    noise = (fitted.law if fitted.wear is None else fitted.wear.whole).noise(theta)
    quiet, loud = int(np.argmin(noise)), int(np.argmax(noise))
    forecast = _forecast(pairs, fitted, whole_number("runs", runs, least=2), seed)
    report(1.0)
    return MeasuredCycleMap(
        pairs=pairs,
        fitted=fitted,
        quietest=(float(theta[quiet]), float(noise[quiet])),
        loudest=(float(theta[loud]), float(noise[loud])),
        early=map_state(fitted, EARLY),
        late=map_state(fitted, LATE),
        forecast=forecast,
    )


def map_state(fitted: FittedMap, share: float) -> MapState:
    """The fitted map after this share of the measured cycles, 0 to 1."""
    worn = fitted.wear
    cycle = float("nan") if worn is None else worn.first + share * (worn.last - worn.first)
    frozen = fitted.map if worn is None else fitted.map_at(cycle)
    theta = FULL_TURN * np.arange(_GRID) / _GRID
    turn = frozen.turn(theta)
    slowest = int(np.argmin(np.abs(turn)))
    place = (float(theta[slowest]), float(turn[slowest]))
    return MapState(cycle, tuple(fixed_points(frozen)), tuple(slow_passages(frozen)), place)


def _fitted(pairs: Theta0Pairs, harmonics: int | None, wear: bool, seed: int) -> FittedMap:
    """With numbered cycles the law may wear; paths without wear are paths of a law of degree 0.

    Whether it wears is left to the cautious rule of ``fit_worn_law``; how, to the least error in cycles left out: the
    cautious rule's degree depends on how the folds are dealt, and the turns foretold depend on the degree.
    """
    options: dict[str, Any] = {"harmonics": harmonics, "noise_harmonics": None, "seed": seed}
    if pairs.cycle is None or np.ptp(pairs.cycle) == 0.0:
        return fit_map(pairs.theta, pairs.theta_next, **options)
    options["cycle"] = pairs.cycle
    fitted = fit_map(pairs.theta, pairs.theta_next, wear_degree=None if wear else 0, **options)
    worn = fitted.wear
    if worn is None or worn.degree == 0 or worn.rmse_by_order is None:
        return fitted
    best = int(np.argmin(np.min(worn.rmse_by_order, axis=1)))
    same = best in (0, worn.degree)
    return fitted if same else fit_map(pairs.theta, pairs.theta_next, wear_degree=best, **options)


def _forecast(pairs: Theta0Pairs, fitted: FittedMap, runs: int, seed: int) -> WornForecast | None:
    path, cycle = pairs.path, pairs.path_cycle
    if path is None or cycle is None or fitted.wear is None or np.any(np.diff(cycle) <= 0.0):
        return None
    last = int(cycle[-1] - cycle[0])
    begin = int(np.searchsorted(cycle, cycle[0] + WORN_IN * last))
    counted = fitted.paths(np.full(runs, path[begin]), int(cycle[-1] - cycle[begin]), float(cycle[begin]), seed)
    whole = fitted.paths(np.full(runs, path[0]), last, float(cycle[0]), seed + 1)
    tv, apart, chance = _distances(path, whole)
    lower, upper = np.quantile(whole, [0.025, 0.975], axis=0)
    return WornForecast(
        first_cycle=float(cycle[begin]),
        measured_turns=float(path[-1] - path[begin]) / FULL_TURN,
        left_out_turns=_left_out(pairs, path, cycle, begin),
        turns=(counted[:, -1] - counted[:, 0]) / FULL_TURN,
        measured=np.interp(cycle[0] + np.arange(last + 1.0), cycle, path),
        run=whole[0],
        lower=lower,
        upper=upper,
        measured_histogram=angle_histogram(path),
        histogram=angle_histogram(whole.ravel()),
        total_variation=tv,
        wasserstein=apart,
        run_distances=chance,
        pace=turn_pace(fitted, path, cycle, _fastest(fitted), runs, seed + 2),
    )


def _left_out(pairs: Theta0Pairs, path: Array, cycle: Array, begin: int) -> float:
    """Full turns climbed from the entry ``begin`` on in cycles that no fitted pair covers."""
    assert pairs.cycle is not None
    covered = float(np.sum(pairs.turn[pairs.cycle >= cycle[begin]]))
    return float(path[-1] - path[begin] - covered) / FULL_TURN


def _distances(path: Array, paths: Array) -> tuple[float, float, Array]:
    """Total variation and Wasserstein distance of the path from all paths, and the latter of each of them."""
    pooled = paths[:, :: max(1, paths.size // _POOLED)].ravel()
    each = np.array([float(circular_wasserstein(one, pooled)) for one in paths[:_COMPARED]])
    return float(total_variation(path, paths.ravel())), float(circular_wasserstein(path, pooled)), each


def _fastest(fitted: FittedMap) -> float:
    theta = FULL_TURN * np.arange(_GRID) / _GRID
    return float(theta[np.argmax(np.abs(fitted.map.turn(theta)))])
