"""Predicted against measured pushes, set by set: turn and displacement, bias and spread, as in the
published tables.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import read_only
from cyclemap.errors import ConvergenceError, UnsupportedContact
from cyclemap.evidence.comparison.collection_data import PosedSet
from cyclemap.evidence.comparison.collection_null import posterior_samples
from cyclemap.evidence.laws.linear_fit import fit_linear, window_lags
from cyclemap.evidence.laws.push_sets import QUANTITIES
from cyclemap.evidence.predicted_strokes import FAILING, predicted_motions
from cyclemap.evidence.tables.columns import Row
from cyclemap.mechanics import QuasiStaticModel
from cyclemap.mechanics.trajectory import Course
from cyclemap.progress import Progress, part_of
from cyclemap.written import NUMBER, UNWRITTEN

# Below so many pushes the error of a bias is not told.
FEWEST = 3
# A bias below this, rad or m, is none: no camera sees it, and of exact simulated pushes it is
# rounding.
SEEN_ANGLE = np.radians(0.005)
SEEN_LENGTH = 5e-6
# Critical values of a mean over its error, of so few values.
_CRITICAL_OF_FEW = {3: 6.9, 4: 5.6}
# Pushes that are run on each sample of a posterior, of a set and of all sets: they tell how far the
# mean moves.
_SAMPLED_PUSHES = 100
# Pushes of the object that is meant end within a tenth of their way of any surface's, or so.
_LOST_SHARE, _LOST_TURN = 0.5, math.radians(35.0)


@dataclass(frozen=True)
class QuantityAgreement:
    """One quantity of pushes or cycles, in rad (``dtheta``, ``turn``) or m (``dx``, ``dy``), of so
    many.

    Attributes
    ----------
    name : str
        ``dtheta``, ``dx``, ``dy`` or ``turn``.
    count : int
        Of how many pushes or cycles.
    measured_mean : float
        Mean of what was measured.
    measured_std : float
        Also the least RMSE of any law that ignores θ0, as an isotropic one does.
    predicted_mean, predicted_std : float
        Mean and standard deviation of what was predicted.
    bias : float
        Mean of predicted less measured, each at its own θ0.
    spread : float
        Standard deviation of that difference.
    rmse : float
        Root mean square of predicted less measured.
    bias_error : float or None
        Standard error of the bias, correlation of successive pushes allowed for (Newey & West
        1987), and ``model_error`` with it; None below three pushes.
    model_error : float
        Of the predicted mean alone, by how well the material's parameters are known; 0 where it
        has no posterior.
    agrees : bool or None
        Whether the bias is within its error of 0 at the 5 % level, or below 0.005 degrees or
        mm; None if unknown.
    percent, std_percent : float
        RMSE and measured standard deviation in per cent of the measured mean (Ma & Rodriguez
        2018, Tables II and III); inf for a mean of 0.
    explains : bool
        Whether the prediction is nearer to the pushes than any law that ignores θ0 can be.
    """

    name: str = field(metadata=UNWRITTEN)
    count: int = field(metadata=UNWRITTEN)
    measured_mean: float
    measured_std: float
    predicted_mean: float
    predicted_std: float
    bias: float
    spread: float
    rmse: float
    bias_error: float | None
    model_error: float
    agrees: bool | None = field(metadata=UNWRITTEN)
    percent: float = field(metadata={"name": "rmse_percent", "unit": NUMBER})
    std_percent: float = field(metadata={"name": "measured_std_percent", "unit": NUMBER})
    explains: bool = field(metadata=UNWRITTEN)


@dataclass(frozen=True, eq=False)
class PushAgreement:
    """The pushes of one set beside the loop's.

    Attributes
    ----------
    facts : mapping of str to object
        Of the set.
    length : float
        Of its pushes, their median, m.
    theta : ndarray, shape (n,)
        Orientations before, rad.
    measured, predicted, isotropic : ndarray, shape (n, 3)
        Dtheta (rad), dx, dy (m), the last of isotropic friction under even pressure, all else
        alike.
    sampled : ndarray, shape (k, 3), or None
        Means of some of the pushes on samples of the material's posterior, less those
        predicted; None without a posterior.
    """

    facts: Row
    length: float
    theta: Array
    measured: Array
    predicted: Array
    isotropic: Array
    sampled: Array | None = None

    @property
    def count(self) -> int:
        """How many pushes."""
        return self.theta.size

    @cached_property
    def quantities(self) -> tuple[QuantityAgreement, ...]:
        """Dtheta, dx, dy."""
        return pooled_quantities([self])

    @property
    def name(self) -> str:
        """Of the set, for sentences: " of rect1 on plywood", or "" where neither is known."""
        known = [
            str(self.facts[key]) for key in ("object", "surface") if self.facts[key] is not None
        ]
        return f" of {' on '.join(known)}" if known else ""


def push_agreements(
    sets: Sequence[PosedSet], progress: Progress
) -> tuple[tuple[PushAgreement, ...], int]:
    """Set the pushes of each set beside those of their loop, each at its own θ0, as long as it was;
    the largest first. Also how many were left out, for which the mechanics have no answer.

    Raises UnsupportedContact or ConvergenceError where that is more than one in twenty.
    """
    if not sets:
        return (), 0
    count = sum(len(pushes.push) for pushes in sets)
    most_failing = math.ceil(FAILING * count) / count
    models = [pushes.loop.model for pushes in sets]
    motions = []
    for of_sets in (models, [model.isotropic for model in models]):
        courses = list[Course]()
        for model, pushes in zip(of_sets, sets, strict=True):
            courses += _courses(model, pushes)
        motions.append(predicted_motions(courses, most_failing))
        part_of(progress, len(motions) - 1, 3)(1.0)
    both = np.stack(motions)
    edges = np.cumsum([len(pushes.push) for pushes in sets])[:-1]
    agreements = []
    for index, (pushes, moved) in enumerate(zip(sets, np.split(both, edges, axis=1), strict=True)):
        is_sampled = index % (1 + len(sets) // _SAMPLED_PUSHES) == 0
        if np.isfinite(moved).all(axis=(0, 2)).any():
            sampled = _sampled_shifts(pushes, moved[0]) if is_sampled else None
            agreements.append(_agreement(pushes, moved, sampled))
        part_of(part_of(progress, 2, 3), index, len(sets))(1.0)
    ordered = sorted(agreements, key=lambda agreement: -agreement.count)
    return tuple(ordered), count - sum(agreement.count for agreement in ordered)


def _courses(model: QuasiStaticModel, pushes: PosedSet, stride: int = 1) -> list[Course]:
    """Every so many-th push of a set on a model of its object, from its own θ0."""
    courses = []
    for theta, push in zip(pushes.theta[::stride].tolist(), pushes.push[::stride], strict=True):
        pose = model.start_pose(theta)
        courses.append(model.course(model.push_strokes(pose, push), pose))
    return courses


def _sampled_shifts(pushes: PosedSet, predicted: Array) -> Array | None:
    """Means of some of the pushes on samples of the material's posterior less those predicted,
    (k, 3); None where there are not two.
    """
    stride = 1 + len(pushes.push) // _SAMPLED_PUSHES
    shifts = []
    for sample in posterior_samples(pushes.loop):
        with suppress(UnsupportedContact, ConvergenceError):
            moved = predicted_motions(_courses(sample.model, pushes, stride), 0.0)
            shifts.append(np.nanmean(moved - predicted[::stride], axis=0))
    return np.array(shifts) if len(shifts) > 1 else None


def _agreement(pushes: PosedSet, moved: Array, sampled: Array | None) -> PushAgreement:
    """The agreement of the pushes of a set that have an answer; moved : (2, n, 3), predicted and
    isotropic.
    """
    kept = np.isfinite(moved).all(axis=(0, 2))
    measured, predicted, isotropic = (read_only(motion[kept]) for motion in (pushes.motion, *moved))
    return PushAgreement(
        facts=pushes.facts,
        length=float(np.median([push.distance for push in pushes.push])),
        theta=read_only(pushes.theta[kept]),
        measured=measured,
        predicted=predicted,
        isotropic=isotropic,
        sampled=sampled,
    )


def mean_distances(sets: Sequence[PushAgreement]) -> list[tuple[float, float]]:
    """How far pushes end from the prediction on average, place (m) and turn (rad), and from
    isotropic friction's.
    """
    distances = []
    for name in ("predicted", "isotropic"):
        off = np.concatenate([getattr(pushes, name) - pushes.measured for pushes in sets])
        turn, x, y = off.T
        distances.append((float(np.mean(np.hypot(x, y))), float(np.mean(np.abs(turn)))))
    return distances


def astray(sets: Sequence[PushAgreement]) -> int:
    """How many pushes end further from the prediction than half their way, or turned by more than
    35 degrees against it.
    """
    count = 0
    for pushes in sets:
        turn, x, y = (pushes.predicted - pushes.measured).T
        lost = (np.hypot(x, y) > _LOST_SHARE * pushes.length) | (np.abs(turn) > _LOST_TURN)
        count += int(lost.sum())
    return count


def pooled_quantities(sets: Sequence[PushAgreement]) -> tuple[QuantityAgreement, ...]:
    """The quantities of all sets, of which there is one at least, taken together."""
    known = [(pushes.count, pushes.sampled) for pushes in sets if pushes.sampled is not None]
    errors = np.zeros(len(QUANTITIES))
    if known:
        most = max(len(sampled) for _, sampled in known)
        complete = [(count, sampled) for count, sampled in known if len(sampled) == most]
        counts, samples = zip(*complete, strict=True)
        errors = np.std(np.average(samples, axis=0, weights=counts), axis=0, ddof=1)
    measured = np.concatenate([pushes.measured for pushes in sets])
    predicted = np.concatenate([pushes.predicted for pushes in sets])
    columns = zip(QUANTITIES, measured.T, predicted.T, errors.tolist(), strict=True)
    sizes = [pushes.count for pushes in sets]
    return tuple(quantity_agreement(*column, sizes) for column in columns)


def quantity_agreement(
    name: str,
    measured: Array,
    predicted: Array,
    model_error: float = 0.0,
    sizes: Sequence[int] = (),
) -> QuantityAgreement:
    """Bias, spread and RMSE of ``predicted`` (n,) about ``measured`` (n,), n ≥ 1, in order of
    recording.

    Both in rad or m; model_error, sizes : see ``mean_error``.

    >>> found = quantity_agreement("dx", np.array([1.0, 2.0, 3.0]), np.array([1.5, 2.5, 3.5]))
    >>> found.bias, found.spread, found.rmse, found.percent
    (0.5, 0.0, 0.5, 25.0)
    """
    off = predicted - measured
    mean = float(np.mean(measured))
    deviation = float(np.std(measured))
    bias = float(np.mean(off))
    rmse = float(np.sqrt(np.mean(off**2)))
    percent, std_percent = (
        100.0 * size / abs(mean) if mean else math.inf for size in (rmse, deviation)
    )
    error = mean_error(off, model_error, sizes)
    seen = SEEN_LENGTH if name in ("dx", "dy") else SEEN_ANGLE
    return QuantityAgreement(
        name=name,
        count=off.size,
        measured_mean=mean,
        measured_std=deviation,
        predicted_mean=float(np.mean(predicted)),
        predicted_std=float(np.std(predicted)),
        bias=bias,
        spread=float(np.std(off)),
        rmse=rmse,
        bias_error=error,
        model_error=model_error,
        agrees=within_error(bias, error, off.size, seen),
        percent=percent,
        std_percent=std_percent,
        explains=rmse < deviation,
    )


def mean_error(values: Array, model_error: float = 0.0, sizes: Sequence[int] = ()) -> float | None:
    """Standard error of the mean of ``values`` (n,), correlated with their neighbours; None below
    three.

    model_error : an independent error of the mean, in the unit of ``values``, added in squares.
    sizes : of the sets that the values are of, one behind the other: what values of a set have in
        common counts once a set (Liang & Zeger 1986), where that makes the error larger.
    """
    if values.size < FEWEST:
        return None
    own = fit_linear(np.ones((values.size, 1)), values, correlated=True).covariance[0, 0]
    if len(sizes) > 1:
        begins = np.cumsum([0, *sizes[:-1]])
        together = np.add.reduceat(values - np.mean(values), begins) / values.size
        own = max(own, together @ together * len(sizes) / (len(sizes) - 1))
    return float(np.sqrt(own + model_error**2))


def within_error(bias: float, error: float | None, count: int, seen: float = 0.0) -> bool | None:
    """Whether a mean of ``count`` values, with the error of ``mean_error``, is 0 at the 5 % level,
    or below ``seen``.

    The critical value grows with the share b of the values that the error's window spans:
    1.96 + 2.9694 b + 0.4160 b² - 0.5324 b³ (Kiefer & Vogelsang 2005, Bartlett's window); of three
    and four values it is that of independent normal ones. A mean of 0 is measured to be refused in
    4.2 to 5.7 % of cases where values are independent; at a correlation of 0.4 with the next value
    in 10 to 19 % below ten values, 8 % of 20, 6 % of 100.

    >>> within_error(2.2, 1.0, 20), within_error(2.2, 1.0, 2000)
    (True, False)
    """
    if error is None:
        return None
    share = (window_lags(count) + 1.0) / count
    critical = 1.96 + 2.9694 * share + 0.416 * share**2 - 0.5324 * share**3
    critical = _CRITICAL_OF_FEW.get(count, critical)
    return bool(abs(bias) <= max(critical * error, seen))
