"""A measured staircase: its dwells and steps, and what the map fitted to the same data makes of them."""

from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array
from cyclemap.errors import InvalidInput
from cyclemap.evidence.laws.harmonic_map import HarmonicMap, harmonic_map
from cyclemap.evidence.theta0.theta0_pairs import Theta0Pairs
from cyclemap.maps import (
    Staircase,
    StaircaseSummary,
    StepComparison,
    Steps,
    WrappedNormal,
    compare_steps,
    find_steps,
    predict_staircase,
    sample_staircase,
)

# Radians: no angle is measured better than this.
LEAST_SCATTER = 1e-9


@dataclass(frozen=True, eq=False)
class MeasuredStaircase:
    """A measured path, and the staircase of the map fitted to it.

    path : (m,) rad, unwrapped. steps : the dwells and steps found in it, without a model.
    fitted : the map and noise fitted to its pairs. prediction : the staircase of that map, on average.
    run : one noisy run of it, as long as the path and from the same start.
    comparison : the path against the prediction, its visits counted in the predicted slow zones.
    """

    path: Array
    steps: Steps
    fitted: HarmonicMap
    prediction: StaircaseSummary
    run: Staircase
    comparison: StepComparison

    @property
    def cycles_a_turn(self) -> float:
        """Cycles the path took to climb a full turn, on average; inf where it ended where it began."""
        climb = abs(float(self.path[-1] - self.path[0])) / (2 * np.pi)
        return (len(self.path) - 1) / climb if climb > 0.0 else float("inf")


def measured_staircase(pairs: Theta0Pairs, seed: int = 0) -> MeasuredStaircase:
    """Find the steps of the measured path, fit its map, and predict the staircase from that.

    The fit takes all pairs alike: where the surface wears, its noise contains the wear.
    Raises InvalidInput where the order of the pushes is unknown, or the pairs do not fix the map.
    """
    if pairs.path is None:
        raise InvalidInput("the pairs come in no known order: a staircase needs theta0_deg, one row a push in order")
    fitted = harmonic_map(pairs)
    if fitted.sigma < LEAST_SCATTER:
        raise InvalidInput("the measured turns lie exactly on a smooth curve: they are no measurement with noise")
    noise, fitted_map = WrappedNormal(fitted.sigma), fitted.map
    prediction = predict_staircase(fitted_map, noise)
    visits = find_steps(pairs.path, zones=prediction.zones) if prediction.zones else find_steps(pairs.path)
    return MeasuredStaircase(
        path=pairs.path,
        steps=find_steps(pairs.path),
        fitted=fitted,
        prediction=prediction,
        run=sample_staircase(fitted_map, noise, len(pairs.path) - 1, float(pairs.path[0]), seed),
        comparison=compare_steps(visits, prediction),
    )
