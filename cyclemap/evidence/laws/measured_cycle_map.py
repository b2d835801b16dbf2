"""The cycle map of measured orientations with its wear, and what it foretells of the very path it
was fitted to.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Mask, Whole, even_angles, shorter_way, stretches
from cyclemap.checks import whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.laws.circular_distance import circular_wasserstein, total_variation
from cyclemap.evidence.laws.fit_map import FittedMap, fit_map, map_of_turn
from cyclemap.evidence.laws.linear_fit import fourier_columns, student_quantile, weighted_fit
from cyclemap.evidence.laws.periodic_law import PeriodicLaw, scatter_weights
from cyclemap.evidence.laws.push_sets import FEWEST
from cyclemap.evidence.laws.turn_bins import AngleHistogram, angle_histogram, is_covered
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs
from cyclemap.maps import Orbit, SlowPassage, fixed_points, slow_passages
from cyclemap.progress import Progress, part_of
from cyclemap.written import ANGLE

_RUNS = 200
# A predicted turn is followed for this many times the pushes that the measured one took, and some.
_PATIENCE = 3
_LEAST = 60
# Early and late are told an eighth of the run from its ends: polynomials are least certain at the
# very ends.
_EARLY = 0.125
_LATE = 0.875
# From here on the turns are counted: a new surface wears in during the first quarter.
_WORN_IN = 0.25
_GRID = 1440
_AROUND = even_angles(_GRID)
# Fewer cycles than these pass any place too seldom to tell wear from scatter.
FEWEST_FOR_WEAR = 100
# Residuals within 10 degrees tell by how much a law is off there; where their mean is this many
# standard errors from 0, it is: by chance some window of the circle is in one fit of twenty.
_MISFIT_REACH = float(np.radians(10.0))
_MISFIT = 3.0
# Scatter is told where so many pairs, or as many as there are anywhere, lie as near.
_CROWD = 10
# Paths that lie less often than this where orientations were measured foretell nothing.
_INSIDE = 0.98
# Radians: turns of less are rounding.
_STILL = 1e-11
# Orientations that stand for all paths, and paths whose distance from these is measured.
_POOLED = 20_000
_COMPARED = 40


@dataclass(frozen=True, eq=False)
class TurnPace:
    """The full turns of a measured path, in order, each beside its prediction.

    Attributes
    ----------
    start : ndarray, shape (k,)
        The cycle in which each began.
    measured : ndarray, shape (k,)
        The pushes that it took.
    predicted, lower, upper : ndarray, shape (k,)
        Median and central 95 % of the pushes that the worn map takes for the same turn, begun
        in the same cycle at the same angle; inf where too many paths took longer than they were
        followed.
    """

    start: Array
    measured: Array
    predicted: Array
    lower: Array
    upper: Array

    @property
    def inside(self) -> float:
        """The share of measured turns within the central 95 % of their predictions; NaN without
        turns.
        """
        held = (self.lower <= self.measured) & (self.measured <= self.upper)
        return float(np.mean(held)) if held.size else float("nan")


def full_turns(path: Array, level: float) -> Whole:
    """The places (k + 1,) in the path (m,), rad, unwrapped, where it first reaches level + 2πj for
    each next whole j.

    A path that turns downward on the whole is read upside down. Empty where it passes no such
    level.
    """
    upward = path[-1] >= path[0]
    climb, mark = (path, level) if upward else (-path, -level)
    highest = np.maximum.accumulate(climb)
    first = np.ceil((climb[0] - mark) / TWO_PI)
    levels = mark + TWO_PI * np.arange(first, np.floor((highest[-1] - mark) / TWO_PI) + 1.0)
    return np.searchsorted(highest, levels)


def turn_pace(
    fitted: FittedMap, path: Array, cycle: Array, level: float, runs: int = _RUNS, seed: int = 0
) -> TurnPace:
    """Time the turns of a path (m,), rad, whose entries were recorded in the cycles ``cycle`` (m,).

    level : rad, where a turn begins and ends: best where the map is fast, so that jitter does not
        move the mark.
    fitted : with wear (``fit_map(..., cycle=...)``). Each prediction is made of ``runs`` paths,
        from ``seed``.

    Raises InvalidInput where the map was fitted without cycle numbers.
    """
    runs = whole_number("runs", runs, least=1)
    sign = 1.0 if path[-1] >= path[0] else -1.0
    places = full_turns(path, level)
    measured = np.diff(cycle[places])
    quantiles = []
    for k, (place, taken) in enumerate(zip(places[:-1], measured, strict=True)):
        start = float(path[place])
        patience = int(_PATIENCE * float(taken)) + _LEAST
        # A turn begins a little past its mark: by so much less it has to climb to the next.
        past = np.remainder(sign * start - sign * level, TWO_PI)
        paths = fitted.paths(
            np.full(runs, start), patience, first=float(cycle[place]), seed=seed + k
        )
        reached = sign * (paths - start) >= TWO_PI - past
        pushes = np.where(reached.any(axis=1), np.argmax(reached, axis=1), np.inf)
        quantiles.append(np.quantile(pushes, [0.025, 0.5, 0.975], method="inverted_cdf"))
    low, middle, high = np.array(quantiles).reshape(-1, 3).T
    return TurnPace(cycle[places[:-1]], measured, middle, low, high)


@dataclass(frozen=True)
class ScatterPlace:
    """An orientation, rad, and how much cycles scatter there, rad."""

    theta: float = field(metadata=ANGLE)
    scatter: float = field(metadata=ANGLE)


@dataclass(frozen=True)
class TurnPlace:
    """An orientation (rad), the fitted turn of a cycle there (rad), and its 95 % interval, wherever
    the place.

    Neighbouring residuals that are alike and the law's own misfit thereabouts are in it.
    cycles : of a slow passage.
    """

    theta: float = field(metadata=ANGLE)
    turn: float = field(metadata=ANGLE)
    lower: float
    upper: float
    cycles: float | None = None


@dataclass(frozen=True, eq=False)
class MapState:
    """The fitted map at one cycle: what attracts, and where it is slow, as far as orientations were
    measured.

    Attributes
    ----------
    cycle : float
        The cycle; NaN where the cycles have no numbers.
    fixed_points : tuple of Orbit
        Of the map, stable and unstable, where the interval of the turn excludes 0 on either
        side with opposite signs.
    passages : tuple of TurnPlace
        Bottlenecks where the interval excludes 0.
    undecided : tuple of TurnPlace
        The least turn of each arc where the interval holds 0 and no sign changes for certain:
        the map may have fixed points there, or none.
    slowest : TurnPlace
        Where |turn| is least.
    """

    cycle: float
    fixed_points: tuple[Orbit, ...]
    passages: tuple[TurnPlace, ...]
    undecided: tuple[TurnPlace, ...]
    slowest: TurnPlace


@dataclass(frozen=True, eq=False)
class WornForecast:
    """Paths of the worn map beside the measured one.

    Attributes
    ----------
    first_cycle : float
        From here on full turns are counted.
    measured_turns : float
        Climbed from there to the end.
    left_out_turns : float
        Those in cycles that the fit left out (gaps and flagged jumps).
    turns : ndarray, shape (runs,)
        Of paths from the same place.
    measured : ndarray, shape (m,)
        The measured path at every cycle, rad, gaps filled in straight.
    run : ndarray, shape (m,)
        One path of the map from the measured start, rad.
    lower, upper : ndarray, shape (m,)
        Between which 95 % of such paths lie in each cycle, rad.
    measured_histogram, histogram : AngleHistogram
        Of θ0 over all cycles.
    total_variation : float
        Between these two.
    wasserstein : float
        Between these two, rad.
    run_distances : ndarray, shape (up to 40,)
        The Wasserstein distance of each path from all of them, rad: what chance makes.
    pace : TurnPace
        The full turns of the measured path, each beside its prediction.
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
    wasserstein: float = field(metadata=ANGLE)
    run_distances: Array
    pace: TurnPace


@dataclass(frozen=True, eq=False)
class MeasuredCycleMap:
    """A fitted cycle map and its account.

    Attributes
    ----------
    pairs : Theta0Pairs
        The measured steps.
    fitted : FittedMap
        With scatter that may depend on the angle and wear in time (of degree 0 where it was not
        asked for, or the order of the cycles is unknown).
    quietest, loudest : ScatterPlace
        Where the pairs within 10 degrees scatter least and most about it, by their root mean
        square.
    early, late : MapState
        The map an eighth of the run from its ends.
    forecast : WornForecast or None
        None where the order of the pushes is unknown, or the map's paths leave the measured
        orientations.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import Theta0Pairs, measured_cycle_map
    >>> rng, path = np.random.default_rng(0), [0.0]
    >>> for scatter in 0.05 * rng.standard_normal(80):
    ...     path.append(path[-1] + 0.5 + 0.3 * np.sin(path[-1]) + scatter)
    >>> theta = np.array(path)
    >>> pairs = Theta0Pairs(theta[:-1], theta[1:], path=theta)
    >>> found = measured_cycle_map(pairs, harmonics=1, wear=False, runs=20)
    >>> found.wears, round(found.late.slowest.theta, 1)
    (False, 4.7)
    """

    pairs: Theta0Pairs
    fitted: FittedMap
    quietest: ScatterPlace = field(metadata={"name": "least_scatter"})
    loudest: ScatterPlace = field(metadata={"name": "most_scatter"})
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
    runs: int = _RUNS,
    seed: int = 0,
    progress: Progress | None = None,
) -> MeasuredCycleMap:
    """Fit the map, and follow it from where the measured path stood.

    Parameters
    ----------
    pairs : Theta0Pairs
        The measured steps.
    harmonics : int or None, optional
        The order; None chooses it, together with the degree of the wear, by cross-validation
        over blocks of successive cycles; the degree is that of least error where there is wear
        at all.
    wear : bool, default True
        False keeps the map the same in all cycles.
    runs : int, optional
        Paths of each forecast.
    seed : int, default 0
        Of the blocks and the paths.
    progress : callable, optional
        Called with the fraction done.

    Returns
    -------
    MeasuredCycleMap
        The map, where it is slow, and what its paths do.

    Raises
    ------
    InvalidInput
        For fewer than 20 pairs, and where they do not fix the map, as where none turns.
    ConvergenceError
        Where the scatter could not be fitted, or the law is far too steep between the measured
        orientations.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.evidence import Theta0Pairs, measured_cycle_map
    >>> rng, path = np.random.default_rng(0), [0.0]
    >>> for scatter in 0.05 * rng.standard_normal(80):
    ...     path.append(path[-1] + 0.5 + 0.3 * np.sin(path[-1]) + scatter)
    >>> theta = np.array(path)
    >>> pairs = Theta0Pairs(theta[:-1], theta[1:], path=theta)
    >>> found = measured_cycle_map(pairs, harmonics=1, wear=False, runs=20)
    >>> round(found.fitted.sigma, 2), found.late.fixed_points
    (0.05, ())
    """
    if pairs.theta.size < FEWEST:
        raise InvalidInput(
            f"{pairs.theta.size} pairs are too few for a cycle map; give at least {FEWEST}"
        )
    if np.max(np.abs(shorter_way(pairs.turn))) <= _STILL:
        raise InvalidInput(
            "θ0 never changed from one push to the next: either each reset took the object back to "
            "the very same orientation, so that all pushes repeat one, or the data repeat one "
            "reading; check the readings, or begin pushes from other orientations"
        )
    fitted = _fitted(pairs, harmonics, wear, seed)
    part_of(progress, 0, 2)(1.0)
    forecast = _forecast(pairs, fitted, whole_number("runs", runs, least=2), seed)
    part_of(progress, 1, 2)(1.0)
    seen = is_covered(pairs.theta, _AROUND)
    off = _residuals(pairs, fitted)
    crowd, mean, square = _around(pairs.theta, off)
    law = fitted.law if fitted.wear is None else fitted.wear.whole
    # Where ten pairs or more scatter least and most, root mean square; of fewer in all, the largest
    # crowds count.
    crowded = np.flatnonzero(seen & (crowd >= np.minimum(_CROWD, np.max(crowd[seen]))))
    square = square[crowded]
    quietest, loudest = (
        ScatterPlace(float(_AROUND[crowded[index]]), math.sqrt(square[index]))
        for index in (np.argmin(square), np.argmax(square))
    )
    # Residuals whose mean is off in a window tell that the law is, by more than chance makes it.
    chance = law.noise(_AROUND) / np.sqrt(np.maximum(crowd, 1.0))
    off_there = np.abs(mean)
    local = np.where(off_there > _MISFIT * chance, off_there + 2.0 * chance, 0.0)
    bias, error = _misfit(law, pairs.theta, off, local)
    early, late = (_map_state(fitted, share, seen, bias, error) for share in (_EARLY, _LATE))
    return MeasuredCycleMap(pairs, fitted, quietest, loudest, early, late, forecast)


def _residuals(pairs: Theta0Pairs, fitted: FittedMap) -> Array:
    """What is left of each turn, rad, beside the law of its own cycle."""
    if fitted.wear is not None and pairs.cycle is not None:
        return pairs.turn - fitted.wear.turns(pairs.theta, pairs.cycle)
    return pairs.turn - fitted.law(pairs.theta)


def _around(theta: Array, off: Array) -> tuple[Array, Array, Array]:
    """How many residuals lie within 10 degrees of each place around, their mean, and that of their
    squares; 0 without any.
    """
    # Place by place: all at once takes gigabytes of a long log.
    near = (off[np.abs(shorter_way(place - theta)) <= _MISFIT_REACH] for place in _AROUND)
    count, total, square = np.array([(own.size, np.sum(own), np.dot(own, own)) for own in near]).T
    most = np.maximum(count, 1.0)
    return count, total / most, square / most


def _misfit(law: PeriodicLaw, theta: Array, off: Array, local: Array) -> tuple[Array, Array]:
    """By how much the law may be off at each place around beyond what its covariance states, and
    the standard error of that, rad.

    What one harmonic more adds to it, as the interval of a smoother is centred by a rougher one
    (Calonico, Cattaneo & Titiunik 2014): the order is chosen to predict, and leaves out what it
    cannot tell from chance; inf where the pairs fix no more. Or ``local``, where that is more.

    theta, off : (n,) of the pairs; local, and what is returned: at the places around.
    """
    columns = fourier_columns(theta, law.harmonics + 1)
    count, size = columns.shape
    weight = scatter_weights(theta, law.log_variance)
    try:
        richer = weighted_fit(columns, off, weight)
    except InvalidInput:
        return np.full(_GRID, np.inf), np.zeros(_GRID)
    scale = np.sum(weight * richer.residuals**2) / (count - size)
    own = weighted_fit(columns[:, :-2], off, weight)
    around = fourier_columns(_AROUND, law.harmonics + 1)
    added = np.einsum("ni,ij,nj->n", around, richer.covariance, around)
    added -= np.einsum("ni,ij,nj->n", around[:, :-2], own.covariance, around[:, :-2])
    bias = np.maximum(np.abs(around @ richer.coefficients), local)
    return bias, np.sqrt(np.maximum(scale * added, 0.0))


def _map_state(fitted: FittedMap, share: float, seen: Mask, bias: Array, error: Array) -> MapState:
    """The fitted map after a share of the cycles; its law may be off by ``bias``, with the standard
    error ``error``, at each place around.
    """
    worn = fitted.wear
    cycle = float("nan") if worn is None else worn.first + share * (worn.last - worn.first)
    law = fitted.law if worn is None else worn.at(cycle)
    turn = law(_AROUND)
    half = _turn_error(law, bias, error)
    sign = np.where(seen & (np.abs(turn) > half), np.sign(turn), 0.0)

    def place(index: int, cycles: float | None = None) -> TurnPlace:
        middle = float(turn[index])
        reach = float(half[index])
        return TurnPlace(float(_AROUND[index]), middle, middle - reach, middle + reach, cycles)

    orbits, passages = _orbits_and_passages(law)
    crossed = set[int]()
    undecided = []
    # The longest runs of neighbours that are open, the last place beside the first; all in one
    # where all are.
    held = seen & (sign == 0.0)
    first = int(np.argmin(held))
    for low, high in stretches(np.roll(held, -first)):
        run = [index % _GRID for index in range(first + low, first + high)]
        if sign[run[0] - 1] * sign[(run[-1] + 1) % _GRID] < 0.0:
            crossed.update(run)
        else:
            undecided.append(place(_least(np.abs(turn), np.array(run))))
    slow = []
    for passage in passages:
        index = round(passage.theta / TWO_PI * _GRID) % _GRID
        if sign[index] != 0.0:
            slow.append(place(index, passage.passage_cycles))
    slowest = place(_least(np.abs(turn), np.flatnonzero(seen)))
    sure = tuple(orbit for index, orbit in orbits.items() if index in crossed)
    return MapState(cycle, sure, tuple(slow), tuple(undecided), slowest)


def _orbits_and_passages(law: PeriodicLaw) -> tuple[dict[int, Orbit], list[SlowPassage]]:
    """The fixed points of the law's map, by their place around, and where it is slow: a law that
    turns alike everywhere has neither.
    """
    if law.harmonics == 0:
        return {}, []
    frozen = map_of_turn(law)
    try:
        orbits = fixed_points(frozen)
        passages = slow_passages(frozen)
    except ConvergenceError:
        steepest = math.degrees(float(np.max(np.abs(law(_AROUND)))))
        raise ConvergenceError(
            f"the fitted law of {law.harmonics} harmonics turns by {steepest:.3g}° where no θ0 was "
            "measured, too steeply to be searched: give fewer harmonics"
        ) from None
    return {round(orbit.points[0] / TWO_PI * _GRID) % _GRID: orbit for orbit in orbits}, passages


def _turn_error(law: PeriodicLaw, bias: Array, error: Array) -> Array:
    """Half of the 95 % interval of the turn at each place, of a law that may be off by ``bias``
    with the standard error ``error``.

    The least of all turns is asked for, and a law of p coefficients is free in p places; more
    where neighbouring residuals are alike.
    """
    alike = min(max(law.lag_correlation, 0.0), 0.99)
    free = law.coefficients.size + 2
    quantile = student_quantile(1.0 - 0.05 / free, max(law.count - free, 1))
    stated = quantile * np.hypot(law.standard_error(_AROUND), error)
    return np.asarray(stated * np.sqrt((1.0 + alike) / (1.0 - alike)) + bias)


def _least(values: Array, places: Whole) -> int:
    """The one of these places where the values are least: in the middle,
    where they are all alike."""
    least = places[values[places] <= np.min(values[places]) + 1e-12]
    return int(least[least.size // 2])


def _fitted(pairs: Theta0Pairs, harmonics: int | None, wear: bool, seed: int) -> FittedMap:
    """With numbered cycles the law may wear; paths without wear are paths of a law of degree 0."""
    fit = partial(
        fit_map,
        pairs.theta,
        pairs.theta_next,
        harmonics=harmonics,
        noise_harmonics=None,
        seed=seed,
        cycle=pairs.cycle,
    )
    if pairs.cycle is None or np.ptp(pairs.cycle) == 0.0:
        return fit(cycle=None)
    may_wear = wear and pairs.theta.size >= FEWEST_FOR_WEAR
    fitted = fit(wear_degree=None if may_wear else 0)
    worn = fitted.wear
    if worn is None or worn.degree == 0 or worn.rmse_by_order is None:
        return fitted
    # Whether it wears the cautious rule of `fit_worn_law` says; how, the least error in cycles left
    # out: the cautious degree depends on how the folds are dealt, and the turns foretold depend on
    # the degree.
    best = int(np.argmin(np.min(worn.rmse_by_order, axis=1)))
    return fitted if best in (0, worn.degree) else fit(wear_degree=best)


def _forecast(pairs: Theta0Pairs, fitted: FittedMap, runs: int, seed: int) -> WornForecast | None:
    pairs = pairs.unbroken
    path = pairs.path
    cycle = pairs.path_cycle
    if pairs.cycle is None or path is None or cycle is None or fitted.wear is None:
        return None
    if np.any(np.diff(cycle) <= 0.0):
        return None
    last = int(cycle[-1] - cycle[0])
    begin = int(np.searchsorted(cycle, cycle[0] + _WORN_IN * last))
    counted = fitted.paths(
        np.full(runs, path[begin]), int(cycle[-1] - cycle[begin]), float(cycle[begin]), seed
    )
    whole = fitted.paths(np.full(runs, path[0]), last, float(cycle[0]), seed + 1)
    if np.mean(is_covered(pairs.theta, whole)) < _INSIDE:
        return None
    # Angles that stand for all paths.
    pooled = whole[:, :: max(1, whole.size // _POOLED)].ravel()
    # Full turns climbed in cycles that no fitted pair covers.
    counts = (pairs.cycle >= cycle[begin]) & (pairs.cycle < cycle[-1])
    climbed = float(path[-1] - path[begin])
    left_out = climbed - float(np.sum(pairs.turn[counts]))
    fastest = float(_AROUND[np.argmax(np.abs(fitted.map.turn(_AROUND)))])
    lower, upper = np.quantile(whole, [0.025, 0.975], axis=0)
    return WornForecast(
        first_cycle=float(cycle[begin]),
        measured_turns=climbed / TWO_PI,
        left_out_turns=left_out / TWO_PI,
        turns=(counted[:, -1] - counted[:, 0]) / TWO_PI,
        measured=np.interp(cycle[0] + np.arange(last + 1.0), cycle, path),
        run=whole[0],
        lower=lower,
        upper=upper,
        measured_histogram=angle_histogram(path),
        histogram=angle_histogram(whole.ravel()),
        total_variation=float(total_variation(path, whole.ravel())),
        wasserstein=float(circular_wasserstein(path, pooled)),
        run_distances=np.array([circular_wasserstein(run, pooled) for run in whole[:_COMPARED]]),
        pace=turn_pace(fitted, path, cycle, fastest, runs, seed + 2),
    )
