"""Measured cycles beside the predicted: the map, orientations, stable directions and the staircase
of a collection.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np

from cyclemap.arrays import TWO_PI, Array, shorter_way
from cyclemap.checks import read_only
from cyclemap.collection import CollectionLoop, isotropic_twin
from cyclemap.errors import InvalidInput, UnsupportedContact
from cyclemap.evidence.comparison.collection_null import DISTANCES, CollectionModel, Ensemble
from cyclemap.evidence.comparison.push_agreement import QuantityAgreement, quantity_agreement
from cyclemap.evidence.laws.circular_distance import (
    PValue,
    kernel_modes,
    monte_carlo_p_value,
)
from cyclemap.evidence.laws.fit_map import HARMONICS
from cyclemap.evidence.laws.linear_fit import fourier_columns
from cyclemap.evidence.laws.periodic_law import fit_periodic_law
from cyclemap.evidence.laws.turn_bins import (
    AngleHistogram,
    MapAgreement,
    TurnBins,
    angle_histogram,
    root_mean_square,
    turn_bins,
)
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs
from cyclemap.maps import SlowZone, StaircaseSummary, StepComparison, compare_steps, find_steps
from cyclemap.progress import Progress, part_of
from cyclemap.written import ANGLE, DIRECTION

# Orientations of the ensemble from which the predicted modes are taken.
_POOLED = 12_000
# The share of simulated collections within the range that is told.
RANGE = (0.025, 0.975)


@dataclass(frozen=True, eq=False)
class CycleAgreement:
    """Measured cycles beside the predicted map, all angles in rad.

    Attributes
    ----------
    agreement : MapAgreement
        Root mean squares over pairs, and over the medians of 5 degree bins, each bin counting
        once.
    off : ndarray, shape (n,)
        Measured less predicted turn of each pair.
    bins : TurnBins
        The measured medians.
    turn : QuantityAgreement
        Of the cycles, its mean tested.
    isotropic_rms : float or None
        Root mean square that a loop on isotropic friction under even pressure, all else alike,
        would leave; None of a prediction that is no loop.
    scatter : float or None
        Of the turns about the map with six harmonics that fits these very pairs best; None
        where they fix none.
    noise : float
        Standard deviation of the predicted noise of one cycle.
    lag_correlation : float or None
        Of what a turn differs from that best map by, with the next one; None with ``scatter``.
    p_value : PValue or None
        Of the map, whatever its noise: see ``map_misfit``; None where the order of the pushes
        is unknown.
    """

    agreement: MapAgreement
    off: Array
    bins: TurnBins
    turn: QuantityAgreement
    isotropic_rms: float | None
    scatter: float | None
    noise: float
    lag_correlation: float | None
    p_value: PValue | None


def cycle_agreement(
    model: CollectionModel,
    loop: CollectionLoop | None,
    pairs: Theta0Pairs,
    p_value: PValue | None = None,
) -> CycleAgreement:
    """Set measured pairs, each of its own cycle (from 0 where they tell none), beside the predicted
    map; loop : whose it is, where it is one's.
    """
    predicted, *sampled = model.turns(pairs.theta, pairs.numbers)
    best = None
    with suppress(InvalidInput):
        best = fit_periodic_law(pairs.theta, pairs.turn, harmonics=HARMONICS)
    off = pairs.turn - predicted
    medians = turn_bins(Theta0Pairs(pairs.theta, pairs.theta + off))
    # How well the material's parameters fix the mean: its standard deviation over the samples.
    model_error = float(np.std(np.mean(sampled, axis=1), ddof=1)) if sampled else 0.0
    isotropic_rms = None
    if isinstance(loop, CollectionLoop):
        with suppress(UnsupportedContact):
            # On a surface without direction the turn of a cycle is one for all θ0.
            isotropic = replace(isotropic_twin(loop), footprint=None).cycle(0.0).theta_next
            isotropic_rms = root_mean_square(pairs.turn - isotropic)
    turn = quantity_agreement("turn", pairs.turn, predicted, model_error)
    return CycleAgreement(
        agreement=MapAgreement(
            off.size, turn.rmse, medians.median.size, root_mean_square(medians.median)
        ),
        off=read_only(off),
        bins=turn_bins(pairs),
        turn=turn,
        isotropic_rms=isotropic_rms,
        scatter=None if best is None else best.sigma,
        noise=float(np.sqrt(model.noise.variance)),
        lag_correlation=None if best is None else best.lag_correlation,
        p_value=p_value,
    )


def map_misfit(paths: Array, ensemble: Ensemble) -> Array:
    """How much of what the turns of each path (k, n) differ from the model's is a smooth function
    of θ0: shape (k,).

    The F ratio of the least-squares fit of six harmonics: mean square explained over mean square
    left, whatever the size of the noise. A ``CollectionStatistic``.
    """
    ratios = np.zeros(len(paths))
    order = min(HARMONICS, (paths.shape[1] - 3) // 4)
    if order < 0:
        return ratios
    off = paths[:, 1:] - ensemble.model.images(paths)
    for index, (theta, values) in enumerate(zip(paths[:, :-1], off, strict=True)):
        # A path that sees few directions fixes fewer coefficients.
        columns = fourier_columns(theta, order)
        coefficients, _, rank, _ = np.linalg.lstsq(columns, values, rcond=1e-9)
        fitted = columns @ coefficients
        left = float(np.sum((values - fitted) ** 2))
        explained = float(fitted @ fitted)
        free = values.size - rank
        ratios[index] = explained / rank * free / left if left > 0.0 else 0.0
    return ratios


@dataclass(frozen=True, eq=False)
class OrientationAgreement:
    """The recorded orientations beside the predicted ones.

    Attributes
    ----------
    count : int
        How many orientations were recorded.
    tests : dict of str to PValue
        Wasserstein (statistic in rad), total_variation, kuiper, watson: distances from the law
        of the predicted collections, with p-values under simulated collections as long and from
        the same start.
    measured, predicted : AngleHistogram
        Histograms over the same bins, per rad.
    """

    count: int
    tests: dict[str, PValue]
    measured: AngleHistogram
    predicted: AngleHistogram


def orientation_agreement(
    path: Array, ensemble: Ensemble, tested: dict[str, PValue]
) -> OrientationAgreement:
    """Gather what ``tested`` says of the path (n,) rad, and both histograms."""
    measured = angle_histogram(path)
    bins = measured.density.size
    predicted = AngleHistogram(
        measured.edges, read_only(ensemble.law.bin_probabilities(bins) * (bins / TWO_PI))
    )
    return OrientationAgreement(
        path.size, {name: tested[name] for name in DISTANCES}, measured, predicted
    )


@dataclass(frozen=True)
class DirectionMatch:
    """A predicted direction and the measured mode nearest to it, rad in [0, 2π).

    Attributes
    ----------
    kind, centre : str, float
        Of the ``SlowZone``.
    predicted_mode : float or None
        Mode of the predicted collections' orientations nearest to the centre (a ghost's lies
        beside its slowest point); None where there is none.
    measured_mode : float or None
        Nearest to that; None where there is none.
    difference : float or None
        Measured less predicted mode, in [-π, π).
    p_value : PValue or None
        Of one so large, among simulated collections; exact for a prediction that was not fitted
        to these data, else too large.
    """

    kind: str
    centre: float = field(metadata=DIRECTION)
    predicted_mode: float | None = field(metadata=DIRECTION | {"name": "predicted_peak"})
    measured_mode: float | None = field(metadata=DIRECTION | {"name": "measured_peak"})
    difference: float | None = field(metadata=ANGLE)
    p_value: PValue | None


@dataclass(frozen=True, eq=False)
class DirectionAgreement:
    """All directions, predicted and measured.

    Attributes
    ----------
    matches : tuple of DirectionMatch
        One a predicted zone.
    measured_modes : ndarray, shape (k,)
        rad, sorted.
    """

    matches: tuple[DirectionMatch, ...]
    measured_modes: Array = field(metadata=DIRECTION | {"name": "measured_peaks"})


def direction_agreement(
    path: Array, zones: tuple[SlowZone, ...], ensemble: Ensemble, null: Array
) -> DirectionAgreement:
    """Match the predicted ``zones`` with the modes of ``path`` (n,) rad.

    ensemble : of the predicted collections.
    null : (runs, n) others, of which the p-values are made.
    """
    measured = kernel_modes(path)
    stride = max(1, ensemble.paths.size // _POOLED)
    predicted = kernel_modes(ensemble.paths.ravel()[::stride])
    simulated = [kernel_modes(run) for run in null] if zones else []
    matches = []
    for zone in zones:
        mode = _nearest(predicted, zone.centre)
        off = None
        p_value = None
        seen = None if mode is None else _nearest(measured, mode)
        if mode is not None and seen is not None:
            off = float(shorter_way(seen - mode))
            # A simulated collection without any mode is as far off as can be.
            others = [
                float(np.min(np.abs(shorter_way(modes - mode)), initial=np.pi))
                for modes in simulated
            ]
            p_value = monte_carlo_p_value(abs(off), others)
        matches.append(DirectionMatch(zone.kind, zone.centre, mode, seen, off, p_value))
    return DirectionAgreement(tuple(matches), read_only(measured))


def _nearest(modes: Array, angle: float) -> float | None:
    """The mode nearest to an angle, rad; None without any."""
    return float(modes[np.argmin(np.abs(shorter_way(modes - angle)))]) if modes.size else None


@dataclass(frozen=True)
class SimulatedQuantity:
    """A number of the measured staircase among those of simulated collections; None where it does
    not exist.

    Attributes
    ----------
    measured : float or None
        That of the measured staircase.
    predicted : float or None
        Median of the simulated ones.
    lower, upper : float or None
        The range of 95 % of them.
    p_value : PValue or None
        Two-sided, by the distance from their median, among the simulated collections that have
        such a number: exact for a prediction that was not fitted to these data. None where the
        measured one has none.
    """

    measured: float | None
    predicted: float | None
    lower: float | None
    upper: float | None
    p_value: PValue | None


@dataclass(frozen=True, eq=False)
class StaircaseAgreement:
    """The staircase of a collection beside simulated ones that begin alike; angles in rad, lengths
    in cycles.

    Attributes
    ----------
    run : ndarray, shape (n,)
        One simulated collection, rad.
    quantities : dict of str to SimulatedQuantity
        Turns, whole ones climbed; steps; step_height, residence: medians over the steps and the
        dwells of a collection, dwells that its ends cut off included.
    theory : StepComparison or None
        The visits to the predicted zones and the pace, against their exact law; None for a map
        that wears and where that law could not be computed.
    """

    run: Array
    quantities: dict[str, SimulatedQuantity]
    theory: StepComparison | None


def staircase_agreement(
    path: Array,
    null: Array,
    summary: StaircaseSummary | None,
    progress: Progress | None = None,
) -> StaircaseAgreement:
    """Set the path (n,) rad, unwrapped, beside simulated ones ``null`` (runs, n), from the same
    start.

    summary : of the map where it does not wear.
    progress : called with the fraction done, in (0, 1].
    """
    simulated = []
    for index, run in enumerate(null):
        simulated.append(_numbers(run))
        part_of(progress, index, len(null))(1.0)
    quantities = {
        name: simulated_quantity(value, np.array([numbers[name] for numbers in simulated]))
        for name, value in _numbers(path).items()
    }
    theory = None
    if summary is not None:
        theory = compare_steps(find_steps(path, zones=summary.zones or None), summary)
    return StaircaseAgreement(null[0], quantities, theory)


def simulated_quantity(measured: float, simulated: Array) -> SimulatedQuantity:
    """Where ``measured`` lies among ``simulated`` (runs,); NaN stands for a number that does not
    exist.

    >>> found = simulated_quantity(9.0, np.arange(99.0))
    >>> found.predicted, round(found.p_value.value, 2)
    (49.0, 0.22)
    """
    known = simulated[np.isfinite(simulated)]
    value = measured if np.isfinite(measured) else None
    lower = middle = upper = p_value = None
    if known.size:
        lower, middle, upper = np.quantile(known, [RANGE[0], 0.5, RANGE[1]]).tolist()
    if known.size and value is not None:
        # The median of all of them: the measured number is then treated as every simulated one is.
        centre = float(np.median(np.append(known, value)))
        p_value = monte_carlo_p_value(abs(value - centre), np.abs(known - centre))
    return SimulatedQuantity(value, middle, lower, upper, p_value)


def _numbers(path: Array) -> dict[str, float]:
    """Turns, steps, median height and median length; NaN without steps or dwells."""
    steps = find_steps(path)
    return {
        "turns": float(path[-1] - path[0]) / TWO_PI,
        "steps": float(steps.count),
        "step_height": float(np.median(np.abs(steps.heights))) if steps.heights.size else np.nan,
        "residence": float(np.median(steps.lengths)) if steps.lengths.size else np.nan,
    }
