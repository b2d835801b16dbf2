"""Circle maps and everything asked of one: orbits, rotation, stationary densities, passage times, staircases.

Angles are radians, maps are lifts, rotation numbers are in turns a cycle. Knows no mechanics.
"""

from cyclemap.maps.circle_map import CircleMap
from cyclemap.maps.diagonal import JumpCrossing
from cyclemap.maps.envelopes import is_nondecreasing, lower_envelope, upper_envelope
from cyclemap.maps.lyapunov import lyapunov_exponent
from cyclemap.maps.noise import Noise, WrappedCauchy, WrappedNormal
from cyclemap.maps.orbits import Orbit, crossings_by_jump, fixed_points, periodic_orbits
from cyclemap.maps.passage import hitting_probability, mean_passage_time
from cyclemap.maps.rotation import RotationInterval, RotationNumber, rotation_interval, rotation_number
from cyclemap.maps.staircase import (
    SlowZone,
    Staircase,
    StaircaseSummary,
    predict_staircase,
    sample_staircase,
)
from cyclemap.maps.transfer_operator import TransferOperator, transfer_operator

__all__ = [
    "CircleMap",
    "JumpCrossing",
    "Noise",
    "Orbit",
    "RotationInterval",
    "RotationNumber",
    "SlowZone",
    "Staircase",
    "StaircaseSummary",
    "TransferOperator",
    "WrappedCauchy",
    "WrappedNormal",
    "crossings_by_jump",
    "fixed_points",
    "hitting_probability",
    "is_nondecreasing",
    "lower_envelope",
    "lyapunov_exponent",
    "mean_passage_time",
    "periodic_orbits",
    "predict_staircase",
    "rotation_interval",
    "rotation_number",
    "sample_staircase",
    "transfer_operator",
    "upper_envelope",
]
