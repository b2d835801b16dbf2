"""Measured against predicted staircase: turns, steps, their height, how long they last."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.evidence.orientations.goodness_of_fit import PValue, monte_carlo_p_value
from cyclemap.maps import StaircaseSummary, StepComparison, Steps, compare_steps, find_steps

# The share of simulated collections within the range that is told.
RANGE = (0.025, 0.975)


@dataclass(frozen=True)
class SimulatedQuantity:
    """A number of the measured staircase among those of simulated collections; None where it does not exist.

    predicted : median of the simulated ones. lower, upper : the range of 95 % of them.
    p_value : two-sided, by the distance from their median, among the simulated collections that have such a number:
        exact for a prediction that was not fitted to these data. None where the measured one has none.
    """

    measured: float | None
    predicted: float | None
    lower: float | None
    upper: float | None
    p_value: PValue | None


@dataclass(frozen=True, eq=False)
class StaircaseAgreement:
    """The staircase of a collection beside simulated ones that begin alike; angles in rad, lengths in cycles.

    steps : found in the measured path without a model. run : one simulated collection, (n,) rad.
    turns : whole turns climbed. step_count : steps found. step_height, residence : medians over the steps and the
        dwells of a collection, dwells that its ends cut off included.
    theory : the visits to the predicted zones and the pace, against their exact law; None for a map that wears and
        where that law could not be computed. Its p-values do not know of parameters fitted to the same data.
    """

    steps: Steps
    run: Array
    turns: SimulatedQuantity
    step_count: SimulatedQuantity
    step_height: SimulatedQuantity
    residence: SimulatedQuantity
    theory: StepComparison | None


def staircase_agreement(
    path: Array,
    null: Array,
    summary: StaircaseSummary | None,
    progress: Callable[[float], None] | None = None,
) -> StaircaseAgreement:
    """Set the path (n,) rad, unwrapped, beside simulated ones ``null`` (runs, n), from the same start.

    summary : of the map where it does not wear. progress : called with the fraction done, in (0, 1].
    """
    report, found, measured = progress or (lambda fraction: None), [], _numbers(path, find_steps(path))
    for done, one in enumerate(null, 1):
        found.append(_numbers(one, find_steps(one)))
        report(done / len(null))
    columns = np.array(found).T
    quantities = [simulated_quantity(value, column) for value, column in zip(measured, columns, strict=True)]
    named = dict(zip(("turns", "step_count", "step_height", "residence"), quantities, strict=True))
    return StaircaseAgreement(find_steps(path), null[0], theory=_theory(path, summary), **named)


def simulated_quantity(measured: float, simulated: Array) -> SimulatedQuantity:
    """Where ``measured`` lies among ``simulated`` (runs,); NaN stands for a number that does not exist.

    >>> found = simulated_quantity(9.0, np.arange(99.0))
    >>> found.predicted, round(found.p_value.value, 2)
    (49.0, 0.22)
    """
    known = simulated[np.isfinite(simulated)]
    value = measured if np.isfinite(measured) else None
    if not known.size:
        return SimulatedQuantity(value, None, None, None, None)
    lower, middle, upper = np.quantile(known, [RANGE[0], 0.5, RANGE[1]]).tolist()
    if value is None:
        return SimulatedQuantity(value, middle, lower, upper, None)
    # The median of all of them: the measured number is then treated as every simulated one is.
    centre = float(np.median(np.append(known, value)))
    p_value = monte_carlo_p_value(abs(value - centre), np.abs(known - centre))
    return SimulatedQuantity(value, middle, lower, upper, p_value)


def _numbers(path: Array, steps: Steps) -> tuple[float, float, float, float]:
    """Turns, steps, median height and median length; NaN without steps or dwells."""
    height = float(np.median(np.abs(steps.heights))) if steps.heights.size else np.nan
    length = float(np.median(steps.lengths)) if steps.lengths.size else np.nan
    return float(path[-1] - path[0]) / TWO_PI, float(steps.count), height, length


def _theory(path: Array, summary: StaircaseSummary | None) -> StepComparison | None:
    if summary is None:
        return None
    zones = summary.zones or None
    return compare_steps(find_steps(path, zones=zones), summary)
