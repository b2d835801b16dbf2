"""Measured data: reading it, fitting laws to it, and setting it beside a prediction."""

from cyclemap.evidence.contact_forces import contact_force_ratio
from cyclemap.evidence.fit_map import FittedMap, fit_map
from cyclemap.evidence.harmonic_map import HarmonicMap, harmonic_map
from cyclemap.evidence.law_bands import LawBand
from cyclemap.evidence.measured_staircase import MeasuredStaircase, measured_staircase
from cyclemap.evidence.order_choice import OrderScores
from cyclemap.evidence.overlay import MeasuredOverlay, measured_overlay
from cyclemap.evidence.periodic_law import PeriodicLaw, fit_periodic_law
from cyclemap.evidence.push_files import read_push_file
from cyclemap.evidence.push_record import PushRecord, ScanRecord
from cyclemap.evidence.push_table import PushTable, UnreadableFile, load_pushes
from cyclemap.evidence.theta0_pairs import Theta0Pairs, read_theta0_pairs
from cyclemap.evidence.theta0_statistics import (
    AngleHistogram,
    MapAgreement,
    TurnBins,
    angle_histogram,
    map_agreement,
    turn_bins,
)
from cyclemap.evidence.wear import WornLaw, fit_worn_law

__all__ = [
    "AngleHistogram",
    "FittedMap",
    "HarmonicMap",
    "LawBand",
    "MapAgreement",
    "MeasuredOverlay",
    "MeasuredStaircase",
    "OrderScores",
    "PeriodicLaw",
    "PushRecord",
    "PushTable",
    "ScanRecord",
    "Theta0Pairs",
    "TurnBins",
    "UnreadableFile",
    "WornLaw",
    "angle_histogram",
    "contact_force_ratio",
    "fit_map",
    "fit_periodic_law",
    "fit_worn_law",
    "harmonic_map",
    "load_pushes",
    "map_agreement",
    "measured_overlay",
    "measured_staircase",
    "read_push_file",
    "read_theta0_pairs",
    "turn_bins",
]
