"""The predicted cycle map against measured pairs: RMS over pairs and directions, the mean turn, a test of the map."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import read_only
from cyclemap.collection import CollectionLoop, isotropic_twin
from cyclemap.errors import InvalidInput, UnsupportedContact
from cyclemap.evidence.comparison.prediction import Prediction
from cyclemap.evidence.comparison.push_agreement import SEEN_ANGLE, mean_error, within_error
from cyclemap.evidence.laws.fit_map import HARMONICS
from cyclemap.evidence.laws.linear_fit import fourier_columns
from cyclemap.evidence.laws.periodic_law import PeriodicLaw, fit_periodic_law
from cyclemap.evidence.orientations.collection_null import Ensemble
from cyclemap.evidence.orientations.goodness_of_fit import PValue
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs
from cyclemap.evidence.pushes.theta0_statistics import MapAgreement, TurnBins, turn_bins


@dataclass(frozen=True, eq=False)
class CycleAgreement:
    """Measured cycles beside the predicted map, all angles in rad.

    agreement : root mean squares over pairs, and over the medians of 5 degree bins, each bin counting once.
    off : (n,) measured less predicted turn of each pair. bins : the measured medians.
    measured_turn, predicted_turn : means over the pairs. bias : predicted less measured. bias_error : its standard
        error, correlation of successive cycles allowed for, and ``model_error`` with it; None below three pairs.
        model_error : of the predicted mean alone, by how well the material is known; 0 without a posterior.
    isotropic_rms : root mean square that a loop on isotropic friction under even pressure, all else alike, would leave;
        None of a prediction that is no loop. blind_rms : what one turn for all θ0 would leave.
    scatter : of the measured turns about the map with six harmonics that fits these very pairs best, what no smooth
        map of θ0 alone can do much better than; None where the pairs do not fix it.
    noise : standard deviation of the predicted noise of one cycle.
    lag_correlation : of what a turn differs from that best map by, with the next one in the data: far from 0 where the
        surface wears or is disturbed slowly. None with ``scatter``.
    p_value : of the map, whatever its noise: see ``map_misfit``; None where the order of the pushes is unknown.
    """

    agreement: MapAgreement
    off: Array
    bins: TurnBins
    measured_turn: float
    predicted_turn: float
    bias: float
    bias_error: float | None
    model_error: float
    isotropic_rms: float | None
    blind_rms: float
    scatter: float | None
    noise: float
    lag_correlation: float | None
    p_value: PValue | None

    @property
    def agrees(self) -> bool | None:
        """Whether the mean turn is the predicted one within its error (5 % level), or 0.005 degrees."""
        return within_error(self.bias, self.bias_error, self.agreement.pairs, SEEN_ANGLE)


def cycle_agreement(
    prediction: Prediction, pairs: Theta0Pairs, cycle: Array, p_value: PValue | None = None
) -> CycleAgreement:
    """Set measured pairs, that begin with the pushes ``cycle`` (n,), beside the predicted map."""
    predicted, best = prediction.turn(pairs.theta, cycle), _best_law(pairs)
    off = pairs.turn - predicted
    medians = turn_bins(Theta0Pairs(pairs.theta, pairs.theta + off))
    over_bins = float(np.sqrt(np.mean(medians.median**2))) if medians.median.size else np.nan
    model_error, isotropic = prediction.mean_turn_error(pairs.theta, cycle), _isotropic_turn(prediction.given)
    return CycleAgreement(
        agreement=MapAgreement(off.size, float(np.sqrt(np.mean(off**2))), medians.median.size, over_bins),
        off=read_only(off),
        bins=turn_bins(pairs),
        measured_turn=float(np.mean(pairs.turn)),
        predicted_turn=float(np.mean(predicted)),
        bias=float(-np.mean(off)),
        bias_error=mean_error(off, model_error),
        model_error=model_error,
        isotropic_rms=None if isotropic is None else float(np.sqrt(np.mean((pairs.turn - isotropic) ** 2))),
        blind_rms=float(np.std(pairs.turn)),
        scatter=None if best is None else best.sigma,
        noise=float(np.sqrt(prediction.noise.variance)),
        lag_correlation=None if best is None else best.lag_correlation,
        p_value=p_value,
    )


def _isotropic_turn(given: Any) -> float | None:
    """The turn of a cycle on a surface without direction, which is one for all θ0."""
    if not isinstance(given, CollectionLoop):
        return None
    try:
        return float(replace(isotropic_twin(given), footprint=None).cycle(0.0).theta_next)
    except UnsupportedContact:
        return None


def map_misfit(paths: Array, ensemble: Ensemble) -> Array:
    """How much of what the turns of each path (k, n) differ from the model's is a smooth function of θ0: shape (k,).

    The F ratio of the least-squares fit of six harmonics to turn less predicted turn: mean square explained over
    mean square left. It does not depend on the size of the noise. A ``CollectionStatistic``.
    """
    off = paths[:, 1:] - ensemble.model.images(paths)
    return np.array([_f_ratio(theta, values) for theta, values in zip(paths[:, :-1], off, strict=True)])


def _f_ratio(theta: Array, values: Array) -> float:
    order = min(HARMONICS, (values.size - 2) // 4)
    if order < 0:
        return 0.0
    design = fourier_columns(theta, order)
    # By singular vectors: a path that sees few directions fixes fewer coefficients.
    basis, sizes, _ = np.linalg.svd(design, full_matrices=False)
    basis = basis[:, sizes > 1e-9 * sizes[0]]
    explained = float(np.sum((basis.T @ values) ** 2))
    left = float(values @ values) - explained
    free = values.size - basis.shape[1]
    return explained / basis.shape[1] * free / left if left > 0.0 else 0.0


def _best_law(pairs: Theta0Pairs) -> PeriodicLaw | None:
    try:
        return fit_periodic_law(pairs.theta, pairs.turn, harmonics=HARMONICS)
    except InvalidInput:
        return None
