"""Measured pairs set beside a predicted map: what a picture lays over the prediction."""

from collections.abc import Callable
from dataclasses import dataclass

from cyclemap.arrays import Array
from cyclemap.evidence.theta0.theta0_pairs import Theta0Pairs
from cyclemap.evidence.theta0.theta0_statistics import (
    AngleHistogram,
    MapAgreement,
    TurnBins,
    angle_histogram,
    map_agreement,
    turn_bins,
)


@dataclass(frozen=True, eq=False)
class MeasuredOverlay:
    """Measured pairs with their medians by direction, their histogram, and their distance from a map."""

    pairs: Theta0Pairs
    bins: TurnBins
    histogram: AngleHistogram
    agreement: MapAgreement


def measured_overlay(pairs: Theta0Pairs, turn: Callable[[Array], Array]) -> MeasuredOverlay:
    """Summarise `pairs` against the map that turns θ (rad) by `turn(θ)` (rad)."""
    return MeasuredOverlay(
        pairs=pairs,
        bins=turn_bins(pairs),
        histogram=angle_histogram(pairs.theta),
        agreement=map_agreement(pairs, turn),
    )
