"""Measured orientations against those of simulated collections: distances, p-values, histograms side by side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import read_only
from cyclemap.evidence.orientations.collection_null import Ensemble
from cyclemap.evidence.orientations.goodness_of_fit import PValue
from cyclemap.evidence.pushes.theta0_statistics import AngleHistogram, angle_histogram

ORIENTATION_TESTS = ("wasserstein", "total_variation", "kuiper", "watson")


@dataclass(frozen=True, eq=False)
class OrientationAgreement:
    """The recorded orientations beside the predicted ones.

    wasserstein (statistic in rad), total_variation, kuiper, watson : distances from the law of the predicted
        collections, with p-values under simulated collections as long and from the same start.
    measured, predicted : histograms over the same bins, per rad.
    """

    count: int
    wasserstein: PValue
    total_variation: PValue
    kuiper: PValue
    watson: PValue
    measured: AngleHistogram
    predicted: AngleHistogram

    @property
    def tests(self) -> dict[str, PValue]:
        """The four by name."""
        return {name: getattr(self, name) for name in ORIENTATION_TESTS}


def orientation_agreement(path: Array, ensemble: Ensemble, tested: dict[str, PValue]) -> OrientationAgreement:
    """Gather what ``tested`` says of the path (n,) rad, and both histograms."""
    measured = angle_histogram(path)
    bins = measured.density.size
    density = ensemble.law.bin_probabilities(bins) * (bins / TWO_PI)
    predicted = AngleHistogram(measured.edges, np.asarray(read_only(density)))
    return OrientationAgreement(
        path.size, **{name: tested[name] for name in ORIENTATION_TESTS}, measured=measured, predicted=predicted
    )
