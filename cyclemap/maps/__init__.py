"""Circle maps and everything asked of one: orbits, rotation, families, laws under noise, passages, staircases.

Angles are radians, maps are lifts, rotation numbers are in turns a cycle. Knows no mechanics.
"""

from typing import TYPE_CHECKING

from cyclemap.lazy_names import import_on_first_use

if TYPE_CHECKING:
    # What an editor and a type checker see; at run time each name is imported when it is first used.
    from cyclemap.maps.algebra.branches import Branch, branches, preimages
    from cyclemap.maps.algebra.map_algebra import compose, conjugate, inverse, nth_iterate, shifted
    from cyclemap.maps.estimate import Estimate
    from cyclemap.maps.families.bifurcations import (
        bifurcations,
        border_collisions,
        orbit_branches,
        period_doublings,
        saddle_nodes,
    )
    from cyclemap.maps.families.continuation import OrbitBranch, follow_orbit
    from cyclemap.maps.families.orbit_diagram import (
        LyapunovExponents,
        OrbitDiagram,
        lyapunov_exponents,
        orbit_diagram,
    )
    from cyclemap.maps.families.parameter_tangent import ParameterTangent, parameter_tangent
    from cyclemap.maps.families.special_points import Bifurcation
    from cyclemap.maps.families.tongues import Tongue, TongueBoundaries, tongue, tongues
    from cyclemap.maps.lifts.circle_map import CircleMap
    from cyclemap.maps.lifts.parametric_lift import ARNOLD_FAMILY, MOEBIUS_FAMILY, ParametricLift
    from cyclemap.maps.noise.local_noise import LocalNoise
    from cyclemap.maps.noise.noise import Noise, WrappedCauchy, WrappedNormal
    from cyclemap.maps.noise.uniform_noise import UniformNoise
    from cyclemap.maps.noise.von_mises import VonMises
    from cyclemap.maps.operator.lyapunov import lyapunov_exponent
    from cyclemap.maps.operator.metastable_sets import MetastableSets, metastable_sets
    from cyclemap.maps.operator.response import Response
    from cyclemap.maps.operator.spectrum import Spectrum
    from cyclemap.maps.operator.transfer_operator import TransferOperator, transfer_operator
    from cyclemap.maps.orbits.basins import Basin, basins
    from cyclemap.maps.orbits.diagonal import JumpCrossing
    from cyclemap.maps.orbits.periodic_points import (
        Orbit,
        PeriodicPoints,
        crossings_by_jump,
        fixed_points,
        periodic_orbits,
        periodic_points,
    )
    from cyclemap.maps.orbits.slow_passages import SlowPassage, slow_passages
    from cyclemap.maps.passages.log_passage import log10_passage_time
    from cyclemap.maps.passages.passage_times import (
        PassageResponse,
        hitting_probability,
        mean_passage_time,
        passage_response,
    )
    from cyclemap.maps.passages.quasi_stationary import (
        QuasiStationaryDistribution,
        Slip,
        quasi_stationary_distribution,
        slip_probabilities,
        survival_probabilities,
    )
    from cyclemap.maps.rotation.envelopes import is_nondecreasing, lower_envelope, upper_envelope
    from cyclemap.maps.rotation.rotation_number import (
        RotationInterval,
        RotationNumber,
        birkhoff_average,
        rotation_interval,
        rotation_number,
    )
    from cyclemap.maps.rotation.rotation_numbers import RotationNumbers, RotationPlane, rotation_numbers, rotation_plane
    from cyclemap.maps.staircases.drifting_map import DriftingMap, DriftSummary, predict_drift
    from cyclemap.maps.staircases.slow_zones import SlowZone, StaircaseSummary, predict_staircase
    from cyclemap.maps.staircases.staircase import Staircase, sample_staircase, sample_staircases
    from cyclemap.maps.staircases.step_comparison import StepComparison, compare_steps
    from cyclemap.maps.staircases.step_detection import Steps, find_steps
else:
    import_on_first_use(__name__)

__all__ = [
    "ARNOLD_FAMILY",
    "MOEBIUS_FAMILY",
    "Basin",
    "Bifurcation",
    "Branch",
    "CircleMap",
    "DriftSummary",
    "DriftingMap",
    "Estimate",
    "JumpCrossing",
    "LocalNoise",
    "LyapunovExponents",
    "MetastableSets",
    "Noise",
    "Orbit",
    "OrbitBranch",
    "OrbitDiagram",
    "ParameterTangent",
    "ParametricLift",
    "PassageResponse",
    "PeriodicPoints",
    "QuasiStationaryDistribution",
    "Response",
    "RotationInterval",
    "RotationNumber",
    "RotationNumbers",
    "RotationPlane",
    "Slip",
    "SlowPassage",
    "SlowZone",
    "Spectrum",
    "Staircase",
    "StaircaseSummary",
    "StepComparison",
    "Steps",
    "Tongue",
    "TongueBoundaries",
    "TransferOperator",
    "UniformNoise",
    "VonMises",
    "WrappedCauchy",
    "WrappedNormal",
    "basins",
    "bifurcations",
    "birkhoff_average",
    "border_collisions",
    "branches",
    "compare_steps",
    "compose",
    "conjugate",
    "crossings_by_jump",
    "find_steps",
    "fixed_points",
    "follow_orbit",
    "hitting_probability",
    "inverse",
    "is_nondecreasing",
    "log10_passage_time",
    "lower_envelope",
    "lyapunov_exponent",
    "lyapunov_exponents",
    "mean_passage_time",
    "metastable_sets",
    "nth_iterate",
    "orbit_branches",
    "orbit_diagram",
    "parameter_tangent",
    "passage_response",
    "period_doublings",
    "periodic_orbits",
    "periodic_points",
    "predict_drift",
    "predict_staircase",
    "preimages",
    "quasi_stationary_distribution",
    "rotation_interval",
    "rotation_number",
    "rotation_numbers",
    "rotation_plane",
    "saddle_nodes",
    "sample_staircase",
    "sample_staircases",
    "shifted",
    "slip_probabilities",
    "slow_passages",
    "survival_probabilities",
    "tongue",
    "tongues",
    "transfer_operator",
    "upper_envelope",
]
