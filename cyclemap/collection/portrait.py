"""The portrait of a collection loop: its cycle map and everything the map implies; and its
staircase alone.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeVar

import numpy as np

from cyclemap.arrays import TWO_PI, shorter_way
from cyclemap.checks import positive_number, whole_number
from cyclemap.collection.lock_forecast import (
    REST_CYCLES,
    LockForecast,
    forecast_from_turns,
    sampled_turns,
)
from cyclemap.collection.loop import CollectionLoop, Cycle, require_loop
from cyclemap.collection.loop_surfaces import drifting_map
from cyclemap.collection.uncertain_directions import DirectionUncertainty, direction_uncertainty
from cyclemap.errors import ConvergenceError
from cyclemap.inline_svg import BLUE, CIRCLE, DISC, Stroke, inline_svg, map_strokes
from cyclemap.maps import (
    CircleMap,
    DriftingMap,
    Estimate,
    LocalNoise,
    MetastableSet,
    Orbit,
    RotationNumber,
    SlowZone,
    Staircase,
    StaircaseSummary,
    StepComparison,
    Steps,
    TransferOperator,
    WrappedNormal,
    compare_steps,
    crossings_by_jump,
    find_steps,
    fixed_points,
    predict_staircase,
    rotation_number,
    sample_staircase,
    shifted,
    transfer_operator,
)
from cyclemap.maps.quadrature import arc_rule, gauss_rule
from cyclemap.progress import Progress, unheard
from cyclemap.written import ANGLE

# The scatter of 1996 measured plywood cycles about a smooth function of θ0 (six harmonics) is 1.10
# degrees.
DEFAULT_SIGMA = float(np.deg2rad(1.1))

DEFAULT_CYCLES = 2000
# Maps that most drifts take.
_USUAL_MAPS = 12
# Radians: a zone's centre is the stable point itself.
_SAME_PLACE = 1e-6

# Fourier modes that the statistics' quadrature resolves; its nodes are then less than a quarter of
# a degree apart.
_BANDWIDTH = 2048
# Nodes on each cubic of a sampled map: however steep it is, they tell its mean exactly, and its
# extremes closely.
_CUBIC_NODES = 24


@dataclass(frozen=True)
class TurnStatistics:
    """The turn f(θ) - θ over the whole circle (rad), and the slope f'(θ)."""

    mean_turn: float = field(metadata=ANGLE)
    min_turn: float = field(metadata=ANGLE)
    max_turn: float = field(metadata=ANGLE)
    min_slope: float
    max_slope: float


@dataclass(frozen=True, eq=False)
class NoisyLoop:
    """A loop's map and the noise of a cycle, and what comes of both: what `Portrait` and
    `StaircaseForecast` share.
    """

    loop: CollectionLoop
    map: CircleMap
    noise: WrappedNormal
    operator: TransferOperator
    staircase: Staircase
    prediction: StaircaseSummary
    drifting: DriftingMap | None
    uncertainty: DirectionUncertainty | None
    forecast: LockForecast | None

    @cached_property
    def worn(self) -> StaircaseSummary | None:
        """Where the surface wears, what runs on the surface of the last cycle are like."""
        drifting = self.drifting
        return None if drifting is None else predict_staircase(drifting.maps[-1], self.noise)


N = TypeVar("N", bound=NoisyLoop)


class Portrait(NoisyLoop):
    """What a collection loop does, cycle after cycle.

    Attributes
    ----------
    loop : CollectionLoop
        The loop.
    map : CircleMap
        Its cycle map, θ in rad.
    noise : WrappedNormal
        The noise added to every cycle.
    operator : TransferOperator
        The transfer operator of map plus noise.
    staircase : Staircase
        One noisy run.
    prediction : StaircaseSummary
        What such a run looks like on average.
    drifting : DriftingMap or None
        Where the surface wears, its map over the cycles of the run, which then follows it; all
        else is of the fresh surface. None where it does not.
    uncertainty : DirectionUncertainty or None
        How well the stable directions are known, of the fresh surface; None where the mechanics
        is not.
    forecast : LockForecast or None
        What the pushes of the run will bring, of all that is believed; None where there are no
        samples of it.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CollectionLoop, portrait
    >>> loop = CollectionLoop.mit("plywood")
    >>> result = portrait(loop, sigma=0.2, cycles=50, tolerance=1e-3)
    >>> [round(float(np.degrees(orbit.points[0])), 1) for orbit in result.stable_points]
    [63.2]
    """

    def _repr_html_(self) -> str:
        theta = np.linspace(0.0, TWO_PI, 361)
        points = [
            Stroke([[orbit.points[0], 0.0]], BLUE, DISC if orbit.stable else CIRCLE, 4.0)
            for orbit in self.fixed_points
        ]
        caption = (
            f"{self.loop.material.name}: turn of a cycle (rad) over θ from 0 to 2π, "
            f"{len(points)} fixed points"
        )
        return inline_svg(
            [*map_strokes(theta, self.map.turn(theta), self.map.breaks), *points], caption
        )

    @cached_property
    def turns(self) -> TurnStatistics:
        """Statistics of the map's turn."""
        return turn_statistics(self.map)

    @cached_property
    def fixed_points(self) -> tuple[Orbit, ...]:
        """The directions that the map takes to themselves."""
        return tuple(fixed_points(self.map))

    @cached_property
    def gathering_jumps(self) -> tuple[float, ...]:
        """The jumps (rad) about which orbits gather from both sides, as about a stable point."""
        return tuple(jump.theta for jump in crossings_by_jump(self.map) if jump.attracting)

    @cached_property
    def rotation(self) -> RotationNumber:
        """The map's rotation number."""
        return rotation_number(self.map)

    @cached_property
    def cycle(self) -> Cycle:
        """One noiseless cycle, started at the most visited stable point, or at 0."""
        points = self.stable_points
        return self.loop.cycle(float(points[0].points[0]) if points else 0.0)

    @cached_property
    def stable_points(self) -> tuple[Orbit, ...]:
        """The stable fixed points, the most visited first."""
        stable = [orbit for orbit in self.fixed_points if orbit.stable]
        return tuple(
            sorted(stable, key=lambda orbit: -float(self.operator.density(orbit.points[:1])[0]))
        )

    @cached_property
    def highest_peaks(self) -> tuple[float, ...]:
        """The peaks (rad) at which the stationary density is above the uniform one, the highest
        first.

        Where noise is too weak to connect the stable directions, their shares are not determined:
        each is a peak.
        """
        if not self.operator.is_certain:
            return tuple(sorted(float(orbit.points[0]) for orbit in self.stable_points))
        peaks = self.operator.peaks()
        density = self.operator.density(peaks)
        order = np.argsort(-density)
        return tuple(peaks[order][density[order] > 1.0 / TWO_PI].tolist())

    @property
    def tv_from_uniform(self) -> float | None:
        """Total variation distance of the stationary law from uniform; None where the law is not
        determined.
        """
        return self.operator.tv_from_uniform if self.operator.is_certain else None

    @cached_property
    def held(self) -> tuple[MetastableSet, ...]:
        """The sets of directions among which noise rarely carries θ0, where it is known how often
        it is in each.
        """
        return self.operator.metastable_sets() if self.operator.is_certain else ()

    def stay(self, orbit: Orbit) -> float | None:
        """Mean cycles from a stable point until noise has carried θ0 off it; None where that is not
        known.
        """
        near = [
            zone
            for zone in self.prediction.zones
            if abs(shorter_way(zone.centre - orbit.points[0])) < _SAME_PLACE
        ]
        return float(near[0].residence_cycles) if near else None


def portrait(
    loop: CollectionLoop,
    *,
    sigma: float | None = None,
    cycles: int = DEFAULT_CYCLES,
    start: float = 0.0,
    seed: int = 0,
    tolerance: float = 1e-6,
    progress: Progress | None = None,
) -> Portrait:
    """Compute the portrait of a loop: map, fixed points, rotation, stationary law and staircase.

    Parameters
    ----------
    loop : CollectionLoop
        What is run.
    sigma : float or None, optional
        Standard deviation of the noise of one cycle, rad; None as in `staircase_forecast`.
    cycles : int, optional
        Cycles of the noisy run.
    start : float, default 0.0
        Orientation that the noisy run starts from, rad.
    seed : int, default 0
        Of the noisy run.
    tolerance : float, default 1e-6
        Error of the cycle map, rad.
    progress : callable, optional
        Called with the fraction done, in [0, 1].

    Returns
    -------
    Portrait
        What the loop does, cycle after cycle.

    Raises
    ------
    InvalidInput
        For values that make no sense.
    ConvergenceError
        Where a tolerance cannot be met.

    Examples
    --------
    >>> from cyclemap import CollectionLoop, portrait
    >>> result = portrait(CollectionLoop.mit("plywood"), sigma=0.2, cycles=50, tolerance=1e-3)
    >>> result.rotation.locked, len(result.fixed_points), result.staircase.theta.shape
    (Fraction(0, 1), 2, (51,))
    """
    return _run(Portrait, loop, sigma, cycles, start, seed, tolerance, progress)


def _run(
    kind: type[N],
    loop: CollectionLoop,
    sigma: float | None,
    cycles: int,
    start: float,
    seed: int,
    tolerance: float,
    progress: Progress | None,
) -> N:
    """A loop's map and noise, and a run.

    How well directions are known, and what a run brings of all that is believed, stay unknown of
    what stands in for a loop, its map alone being known.
    """
    if not hasattr(loop, "circle_map"):
        require_loop(loop)
    if sigma is not None:
        positive_number("sigma", sigma)
    whole_number("cycles", cycles, least=1)
    report = progress or unheard
    wears = loop.material.wear is not None
    share = 0.2 if wears else 0.6
    cycle_map = loop.circle_map(tolerance=tolerance, progress=lambda done: report(share * done))
    noise, kicks = noises_of(loop, cycle_map, sigma)
    drifting = uncertainty = forecast = None
    if wears:
        # How many maps it takes is not known before.
        drifting = drifting_map(
            loop, cycles, progress=lambda maps: report(0.2 + 0.4 * min(1.0, maps / _USUAL_MAPS))
        )
    if isinstance(loop, CollectionLoop):
        uncertainty = direction_uncertainty(loop, lambda done: report(0.6 + 0.2 * done))
        # A run that is long enough to lock in, on a surface that stays.
        if loop.material.posterior is not None and not wears and cycles >= REST_CYCLES:
            turns = sampled_turns(loop)
            forecast = forecast_from_turns(turns, noise.sigma, cycles, start, seed)
    operator = transfer_operator(cycle_map, noise)
    report(0.9)
    staircase = sample_staircase(drifting or cycle_map, kicks, cycles, start, seed)
    prediction = predict_staircase(cycle_map, noise, operator)
    known = (drifting, uncertainty, forecast)
    made = kind(loop, cycle_map, noise, operator, staircase, prediction, *known)
    report(1.0)
    return made


def noises_of(
    loop: CollectionLoop, cycle_map: CircleMap, sigma: float | None
) -> tuple[WrappedNormal, WrappedNormal | LocalNoise]:
    """The white noise of what is predicted, and the noise of a run: the material's own, where no
    other is asked for.
    """
    measured = loop.material.noise
    if sigma is not None or measured is None:
        white = WrappedNormal(DEFAULT_SIGMA if sigma is None else positive_number("sigma", sigma))
        return white, white
    own = LocalNoise(measured.log_sigma, measured.correlation)
    theta = np.linspace(0.0, TWO_PI, 720, endpoint=False)
    slowest = theta[np.argmin(np.abs(shorter_way(cycle_map.turn(theta))))]
    return WrappedNormal(own.white(float(slowest))), own


def turn_statistics(cycle_map: CircleMap) -> TurnStatistics:
    """Mean of the turn of `cycle_map`, a quadrature that no break spoils, and extremes over its
    thousands of nodes.
    """
    if cycle_map.pieces is None:
        theta, weight = arc_rule(cycle_map, 0.0, TWO_PI, _BANDWIDTH)
    else:
        # For the map itself: waves of it would need more nodes, the steeper it is.
        knots = cycle_map.pieces.knots
        theta, weight = gauss_rule(knots[:-1], np.diff(knots), _CUBIC_NODES)
    turn = cycle_map.turn(theta)
    slope = cycle_map.derivative(theta)
    return TurnStatistics(
        mean_turn=float(weight @ turn / TWO_PI),
        min_turn=float(turn.min()),
        max_turn=float(turn.max()),
        min_slope=float(slope.min()),
        max_slope=float(slope.max()),
    )


class StaircaseForecast(NoisyLoop):
    """A predicted staircase.

    Attributes
    ----------
    loop, map, noise, operator, staircase, prediction, drifting, worn, uncertainty, forecast
        As of a `Portrait`: what is run, its map, the noise of a cycle, one noisy run, and what such
        a run looks like on average.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.collection import CollectionLoop, staircase_forecast
    >>> loop = CollectionLoop.mit("isotropic")
    >>> forecast = staircase_forecast(loop, sigma=0.2, cycles=50, tolerance=1e-3)
    >>> forecast.prediction.zones, round(float(np.degrees(forecast.prediction.mean_turn)), 2)
    ((), 8.0)
    """

    @cached_property
    def log10_residences(self) -> tuple[Estimate | None, ...]:
        """Of each zone of the prediction, log10 of its mean residence in cycles; None where it
        could not be certified.
        """
        return tuple(_log10_residence(self, zone) for zone in self.prediction.zones)

    @cached_property
    def steps(self) -> Steps:
        """The dwells and steps found in the run."""
        return find_steps(self.staircase.theta)

    @cached_property
    def comparison(self) -> StepComparison:
        """These steps beside the prediction, of the fresh surface."""
        return compare_steps(self.steps, self.prediction)


def staircase_forecast(
    loop: CollectionLoop,
    *,
    sigma: float | None = None,
    cycles: int = DEFAULT_CYCLES,
    start: float = 0.0,
    seed: int = 0,
    tolerance: float = 1e-6,
    progress: Progress | None = None,
) -> StaircaseForecast:
    """Predict the staircase of a loop.

    Parameters
    ----------
    loop : CollectionLoop
        What is run.
    sigma : float or None, optional
        Standard deviation of the noise of one cycle, rad; None: the run takes the material's
        own, where it has one, and what is predicted the white noise that carries as far at its
        slowest place, else 1.1 degrees.
    cycles : int, optional
        Cycles of the noisy run.
    start : float, default 0.0
        Orientation that the noisy run starts from, rad.
    seed : int, default 0
        Of the noisy run.
    tolerance : float, default 1e-6
        Error of the cycle map, rad.
    progress : callable or None, optional
        Called with the fraction done, in [0, 1].

    Returns
    -------
    StaircaseForecast
        One run, its steps, and what is predicted of both.

    Raises
    ------
    InvalidInput
        For values that make no sense.
    ConvergenceError
        Where a tolerance cannot be met.

    Examples
    --------
    >>> from cyclemap.collection import CollectionLoop, staircase_forecast
    >>> loop = CollectionLoop.mit("plywood")
    >>> forecast = staircase_forecast(loop, sigma=0.2, cycles=50, tolerance=1e-3)
    >>> round(float(forecast.log10_residences[0]), 1)
    7.6
    """
    return _run(StaircaseForecast, loop, sigma, cycles, start, seed, tolerance, progress)


def _log10_residence(noisy: NoisyLoop, zone: SlowZone) -> Estimate | None:
    # Its SciPy is slow to import, and a portrait does without.
    from cyclemap.maps import log10_passage_time

    if np.isfinite(zone.residence_cycles):
        return Estimate(np.log10(zone.residence_cycles), 0.0)
    still = shifted(noisy.map, -zone.winding)
    try:
        # From the point that `SlowZone.residence_cycles` starts from.
        return log10_passage_time(still, noisy.noise, zone.middle, zone.arc, lifted=zone.whole_turn)
    except ConvergenceError:
        return None
