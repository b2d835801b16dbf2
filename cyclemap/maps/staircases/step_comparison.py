"""Measured steps beside predicted ones: lengths with censoring, heights, their number, and tests of
each.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Mask, Whole
from cyclemap.errors import InvalidInput
from cyclemap.maps.staircases.slow_zones import SlowZone, StaircaseSummary
from cyclemap.maps.staircases.step_detection import Steps
from cyclemap.written import CYCLES

_FEWEST_PERIODS = 8  # periods below which the number of steps is not tested


@dataclass(frozen=True)
class VisitComparison:
    """Visits to one slow zone, measured and predicted; numbers of cycles, None where too little was
    seen or predicted.

    Attributes
    ----------
    zone : SlowZone
        The zone.
    exits : int
        Visits whose end was seen.
    mean, standard_error : float or None
        Measured mean length of a visit. For a zone that is escaped from ("stable", "jump") the
        exposure (cycles seen inside, censored visits and the one that the path begins in too)
        over the exits, the maximum-likelihood value of an exponential law, its error
        mean/√exits; for a ghost the Kaplan-Meier mean.
    spread : float or None
        Measured standard deviation of the complete visits.
    predicted : float or None
        The zone's ``visit_cycles``.
    ratio : float or None
        mean/predicted.
    mean_p_value : float or None
        Two-sided, of so few or so many exits in that exposure if visits are independent with
        the predicted mean and spread: a renewal process of gamma-distributed visits, mid-p
        value. Over some 15 visits it is measured to reject a true prediction at the 5 % level
        in 3.5 % of runs (a ghost) and in 6.3 % (a stable point).
    """

    zone: SlowZone
    exits: int
    mean: float | None = field(metadata=CYCLES)
    standard_error: float | None = field(metadata=CYCLES)
    spread: float | None
    predicted: float | None = field(metadata=CYCLES)
    ratio: float | None
    mean_p_value: float | None = field(metadata={"name": "p_value"})


@dataclass(frozen=True)
class StepComparison:
    """Measured steps against a ``StaircaseSummary``; see ``compare_steps``.

    Attributes
    ----------
    steps : int
        How many steps the path has.
    mean_length, length_error : float or None
        Kaplan-Meier mean of the dwells' lengths, cycles, and its standard error; None where no
        comparison is possible, as of all below.
    predicted_length : float or None
        The prediction's mean residence, cycles.
    ratio : float or None
        ``mean_length`` over ``predicted_length``.
    net_steps, expected_steps, net_error : float or None
        Climb of the path in units of the predicted step, the prediction's for as many cycles,
        and the standard error of their difference: from one dwell to the next, height less
        predicted turn is a reward of mean 0, so the difference has their variance times the
        number of periods (Ross 1996, sec. 3.6).
    pace_p_value : float or None
        Two-sided, Student's law for that difference over its error; None below 8 periods. Over
        12 to 18 periods it is measured to reject a true prediction in 3.5 % of runs at the 5 %
        level, in 8 % at 10 %.
    visits : tuple of VisitComparison
        One ``VisitComparison`` a zone; () unless the steps were found in the prediction's own
        zones.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, WrappedNormal, compare_steps, find_steps
    >>> from cyclemap.maps import predict_staircase, sample_staircase
    >>> sine, noise = CircleMap.arnold(0.15, 0.9), WrappedNormal(0.05)
    >>> expected = predict_staircase(sine, noise)
    >>> path = sample_staircase(sine, noise, 2_000)
    >>> found = compare_steps(find_steps(path.theta, zones=expected.zones), expected)
    >>> found.steps > 30, abs(found.ratio - 1.0) < 0.1
    (True, True)
    """

    steps: int
    mean_length: float | None
    length_error: float | None
    predicted_length: float | None
    ratio: float | None
    net_steps: float | None = field(metadata={"name": "steps"})
    expected_steps: float | None
    net_error: float | None
    pace_p_value: float | None
    visits: tuple[VisitComparison, ...]


def compare_steps(steps: Steps, prediction: StaircaseSummary) -> StepComparison:
    """Compare the steps found in a path with those predicted for a map and its noise.

    Parameters
    ----------
    steps : Steps
        Those found in a path.
    prediction : StaircaseSummary
        What was predicted for the map and its noise.

    Returns
    -------
    StepComparison
        Lengths, pace and visits, side by side.

    Raises
    ------
    InvalidInput
        Unless given ``Steps`` and a ``StaircaseSummary``.

    Notes
    -----
    Dwells found without zones have lengths that depend on the window: their ratio to the
    predicted residence is a rough one, without p-value. Heights, pace and number of steps do
    not depend on it. Steps found with ``zones=prediction.zones`` also compare the visits, whose
    prediction is exact for the stationary path, with p-values that are uniform if it holds (as
    far as the path forgets between visits).

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, WrappedNormal, compare_steps, find_steps
    >>> from cyclemap.maps import predict_staircase, sample_staircase
    >>> sine, noise = CircleMap.arnold(0.15, 0.9), WrappedNormal(0.05)
    >>> expected = predict_staircase(sine, noise)
    >>> path = sample_staircase(sine, noise, 20_000)
    >>> found = compare_steps(find_steps(path.theta, zones=expected.zones), expected)
    >>> abs(found.visits[0].ratio - 1) < 0.02, found.visits[0].mean_p_value > 0.001
    (True, True)
    """
    if not isinstance(steps, Steps) or not isinstance(prediction, StaircaseSummary):
        raise InvalidInput(
            "give Steps (find_steps) and a StaircaseSummary (predict_staircase), in this order"
        )
    length, length_error = kaplan_meier_mean(steps.lengths, steps.censored)
    net, expected, error, pace = _pace(steps, prediction)
    zones = steps.zones if steps.zones == prediction.zones else ()
    return StepComparison(
        steps=steps.count,
        mean_length=length,
        length_error=length_error,
        predicted_length=prediction.mean_residence_cycles,
        ratio=_ratio(length, prediction.mean_residence_cycles),
        net_steps=net,
        expected_steps=expected,
        net_error=error,
        pace_p_value=pace,
        visits=tuple(_compared(steps, index, zone) for index, zone in enumerate(zones)),
    )


def _pace(
    steps: Steps, prediction: StaircaseSummary
) -> tuple[float | None, float | None, float | None, float | None]:
    """Net steps, those expected, the standard error of their difference, and its p-value."""
    if prediction.step is None:
        return None, None, None, None
    turn = prediction.mean_turn - TWO_PI * (steps.zones[0].winding if steps.zones else 0)
    net = steps.climb / prediction.step
    expected = turn * steps.cycles / prediction.step
    if steps.count < 2:
        return net, expected, None, None
    periods = np.diff(steps.start)
    surplus = steps.heights - turn * periods
    between = steps.cycles * float(np.mean(surplus**2) / np.mean(periods))
    within = 2.0 * float(np.mean(steps.scatter**2))
    error = float(np.sqrt(between + within) / prediction.step)
    if error == 0.0 or steps.count < _FEWEST_PERIODS:
        return net, expected, error, None
    from scipy.special import stdtr  # slow to import, as below

    return net, expected, error, float(2.0 * stdtr(steps.count - 1, -abs(net - expected) / error))


def kaplan_meier_mean(lengths: Array | Whole, censored: Mask) -> tuple[float | None, float | None]:
    """Mean and standard error of lengths of which some are only known to be at least so long.

    lengths, censored : shape (n,), none below 0. The integral of the product-limit survival
        function (Kaplan & Meier 1958) up to the longest length, with Greenwood's (1926) variance.
        Where the longest is censored the mean is too small. (None, None) where every length is
        censored; the error is None for one alone.
    """
    if np.all(censored):
        return None, None
    times, where = np.unique(lengths, return_inverse=True)
    ended = np.bincount(where, weights=~censored)
    at_risk = lengths.size - np.searchsorted(np.sort(lengths), times)
    alive = np.cumprod(1.0 - ended / at_risk)
    pieces = np.diff(np.r_[0.0, times]) * np.r_[1.0, alive[:-1]]
    beyond = np.sum(pieces) - np.cumsum(pieces)
    left = at_risk - ended
    terms = np.where(left > 0, beyond**2 * ended / (at_risk * np.maximum(left, 1.0)), 0.0)
    return float(np.sum(pieces)), float(np.sqrt(np.sum(terms))) if lengths.size > 1 else None


def _ratio(measured: float | None, predicted: float | None) -> float | None:
    return (
        None
        if measured is None or predicted is None or not predicted > 0.0
        else float(measured / predicted)
    )


def _compared(steps: Steps, index: int, zone: SlowZone) -> VisitComparison:
    """One zone: the visit that the path begins in is of unknown age, which only an exponential law
    forgives.
    """
    escaped = zone.kind != "ghost"
    mine = (steps.visit_zone == index) & (escaped | (steps.visit_start > 0))
    lengths = (steps.visit_end - steps.visit_start + 1)[mine].astype(float)
    closed = steps.visit_end[mine] < steps.cycles
    exits = int(np.sum(closed))
    exposure = float(np.sum(lengths))
    mean, error = (exposure / exits, exposure / exits**1.5) if escaped and exits else (None, None)
    if not escaped:
        mean, error = kaplan_meier_mean(lengths, ~closed)
    return VisitComparison(
        zone=zone,
        exits=exits,
        mean=mean,
        standard_error=error,
        spread=float(np.std(lengths[closed], ddof=1)) if exits > 1 else None,
        predicted=zone.visit_cycles,
        ratio=_ratio(mean, zone.visit_cycles),
        mean_p_value=_exits_p_value(exits, exposure, zone),
    )


def _exits_p_value(exits: int, exposure: float, zone: SlowZone) -> float | None:
    """P(at least so many exits) = P(that many visits take less than the exposure), with
    gamma-distributed sums, to both sides.
    """
    expected = zone.visit_cycles
    spread = zone.visit_spread
    if expected is None or not spread or not np.isfinite(expected) or exposure == 0.0:
        return None
    from scipy.special import gammainc

    shape = (expected / spread) ** 2
    scale = spread * (spread / expected)
    as_many = float(gammainc(shape * exits, exposure / scale)) if exits else 1.0
    middle = 0.5 * (as_many + float(gammainc(shape * (exits + 1), exposure / scale)))
    return min(1.0, 2.0 * min(middle, 1.0 - middle))
