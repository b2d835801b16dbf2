"""Measured data: reading it, fitting laws to it, and setting it beside a prediction."""

from cyclemap.evidence.laws.fit_map import FittedMap, fit_map
from cyclemap.evidence.laws.harmonic_map import HarmonicMap, harmonic_map
from cyclemap.evidence.laws.law_bands import LawBand
from cyclemap.evidence.laws.order_choice import OrderScores
from cyclemap.evidence.laws.periodic_law import PeriodicLaw, fit_periodic_law
from cyclemap.evidence.laws.wear import WornLaw, fit_worn_law
from cyclemap.evidence.measured_staircase import MeasuredStaircase, measured_staircase
from cyclemap.evidence.orientations.chain_null import chain_p_value, chain_p_values, refit_harmonic_map
from cyclemap.evidence.orientations.circular_distance import circular_wasserstein, total_variation
from cyclemap.evidence.orientations.circular_law import CircularLaw
from cyclemap.evidence.orientations.goodness_of_fit import (
    kuiper_critical_value,
    kuiper_p_value,
    kuiper_statistic,
    permutation_p_value,
    watson_critical_value,
    watson_p_value,
    watson_statistic,
)
from cyclemap.evidence.orientations.orientation_comparison import OrientationComparison, compare_orientations
from cyclemap.evidence.orientations.orientation_modes import kernel_modes
from cyclemap.evidence.orientations.p_value import PValue
from cyclemap.evidence.pushes.contact_forces import contact_force_ratio
from cyclemap.evidence.pushes.push_files import read_push_file
from cyclemap.evidence.pushes.push_record import PushRecord, ScanRecord
from cyclemap.evidence.pushes.push_table import PushTable, UnreadableFile, load_pushes
from cyclemap.evidence.theta0.overlay import MeasuredOverlay, measured_overlay
from cyclemap.evidence.theta0.theta0_pairs import Theta0Pairs, read_theta0_pairs
from cyclemap.evidence.theta0.theta0_statistics import (
    AngleHistogram,
    MapAgreement,
    TurnBins,
    angle_histogram,
    map_agreement,
    turn_bins,
)

__all__ = [
    "AngleHistogram",
    "CircularLaw",
    "FittedMap",
    "HarmonicMap",
    "LawBand",
    "MapAgreement",
    "MeasuredOverlay",
    "MeasuredStaircase",
    "OrderScores",
    "OrientationComparison",
    "PValue",
    "PeriodicLaw",
    "PushRecord",
    "PushTable",
    "ScanRecord",
    "Theta0Pairs",
    "TurnBins",
    "UnreadableFile",
    "WornLaw",
    "angle_histogram",
    "chain_p_value",
    "chain_p_values",
    "circular_wasserstein",
    "compare_orientations",
    "contact_force_ratio",
    "fit_map",
    "fit_periodic_law",
    "fit_worn_law",
    "harmonic_map",
    "kernel_modes",
    "kuiper_critical_value",
    "kuiper_p_value",
    "kuiper_statistic",
    "load_pushes",
    "map_agreement",
    "measured_overlay",
    "measured_staircase",
    "permutation_p_value",
    "read_push_file",
    "read_theta0_pairs",
    "refit_harmonic_map",
    "total_variation",
    "turn_bins",
    "watson_critical_value",
    "watson_p_value",
    "watson_statistic",
]
