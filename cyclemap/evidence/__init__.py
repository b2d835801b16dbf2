"""Measured data: reading it, summarising it, and setting it beside a prediction."""

from cyclemap.evidence.harmonic_map import HarmonicMap, harmonic_map
from cyclemap.evidence.measured_staircase import MeasuredStaircase, measured_staircase
from cyclemap.evidence.overlay import MeasuredOverlay, measured_overlay
from cyclemap.evidence.theta0_pairs import Theta0Pairs, read_theta0_pairs
from cyclemap.evidence.theta0_statistics import (
    AngleHistogram,
    MapAgreement,
    TurnBins,
    angle_histogram,
    map_agreement,
    turn_bins,
)

__all__ = [
    "AngleHistogram",
    "HarmonicMap",
    "MapAgreement",
    "MeasuredOverlay",
    "MeasuredStaircase",
    "Theta0Pairs",
    "TurnBins",
    "angle_histogram",
    "harmonic_map",
    "map_agreement",
    "measured_overlay",
    "measured_staircase",
    "read_theta0_pairs",
    "turn_bins",
]
