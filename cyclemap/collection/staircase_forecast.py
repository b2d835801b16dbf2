"""The staircase a collection loop is going to climb: one noisy run of it, and what such runs have in common."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_CYCLES, known_directions, noises_of
from cyclemap.collection.uncertain_directions import DirectionUncertainty
from cyclemap.collection.wearing_loop import drift_of
from cyclemap.errors import ConvergenceError
from cyclemap.maps import (
    CircleMap,
    DriftingMap,
    Estimate,
    Staircase,
    StaircaseSummary,
    StepComparison,
    Steps,
    WrappedNormal,
    compare_steps,
    find_steps,
    log10_passage_time,
    predict_staircase,
    sample_staircase,
    shifted,
)


@dataclass(frozen=True, eq=False)
class StaircaseForecast:
    """A predicted staircase.

    map : the cycle map, θ in rad. noise : white, added to every cycle. prediction : what runs are like on average.
    log10_residences : of each of the prediction's zones, log10 of its mean residence in cycles, beyond every float
    too; None where it could not be certified. run : one noisy run. steps : the dwells and steps found in it.
    comparison : these steps beside the prediction. drifting, worn : where the surface wears, its map over the cycles of
    the run, which then follows it, and what runs on the surface of the last cycle are like; `map`, `prediction` and
    `comparison` are of the fresh surface. uncertainty : how well its stable directions are known, None where the
    mechanics is not.
    """

    loop: CollectionLoop
    map: CircleMap
    noise: WrappedNormal
    prediction: StaircaseSummary
    log10_residences: tuple[Estimate | None, ...]
    run: Staircase
    steps: Steps
    comparison: StepComparison
    drifting: DriftingMap | None = None
    worn: StaircaseSummary | None = None
    uncertainty: DirectionUncertainty | None = None


def staircase_forecast(
    loop: CollectionLoop,
    *,
    sigma: float | None = None,
    cycles: int = DEFAULT_CYCLES,
    start: float = 0.0,
    seed: int = 0,
    tolerance: float = 1e-6,
    progress: Callable[[float], None] | None = None,
) -> StaircaseForecast:
    """Predict the staircase of `loop`.

    sigma : standard deviation (rad) of the noise of one cycle; None: the run takes the material's own, where it has
    one, and what is predicted the white noise that carries as far at its slowest place, else 1.1 degrees.
    cycles, start (rad), seed : of the run.
    tolerance : of the cycle map (rad). progress : called with the fraction done, in [0, 1].

    Raises InvalidInput for values that make no sense, ConvergenceError where a tolerance cannot be met.
    """
    report = progress or (lambda fraction: None)
    share = 0.6 if loop.material.wear is None else 0.2
    cycle_map = loop.circle_map(tolerance=tolerance, progress=lambda fraction: report(share * fraction))
    noise, kicks = noises_of(loop, cycle_map, sigma)
    prediction = predict_staircase(cycle_map, noise)
    drifting = drift_of(loop, cycles, lambda done: report(0.2 + 0.4 * done))
    uncertainty = known_directions(loop, lambda done: report(0.6 + 0.2 * done))
    report(0.8)
    run = sample_staircase(drifting or cycle_map, kicks, cycles, start, seed)
    worn = None if drifting is None else predict_staircase(drifting.maps[-1], noise)
    residences: list[Estimate | None] = []
    for zone in prediction.zones:
        if np.isfinite(zone.residence_cycles):
            residences.append(Estimate(np.log10(zone.residence_cycles), 0.0))
            continue
        still = shifted(cycle_map, -zone.winding)
        try:
            # From the point that `SlowZone.residence_cycles` starts from.
            residences.append(log10_passage_time(still, noise, zone.middle, zone.arc, lifted=zone.whole_turn))
        except ConvergenceError:
            residences.append(None)
    report(1.0)
    steps = find_steps(run.theta)
    comparison = compare_steps(steps, prediction)
    return StaircaseForecast(
        loop, cycle_map, noise, prediction, tuple(residences), run, steps, comparison, drifting, worn, uncertainty
    )
