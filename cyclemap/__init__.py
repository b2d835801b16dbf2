"""cyclemap: the push-then-drag-back data-collection loop of a robot as a map of the circle.

>>> import cyclemap as cm
>>> cm.fixed_points(cm.CircleMap.arnold(omega=0.1, K=0.9))[0].kind
'stable'
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    # What an editor and a type checker see; at run time a room is imported when it is first used.
    from cyclemap.collection import *
    from cyclemap.errors import *
    from cyclemap.evidence import *
    from cyclemap.maps import *
    from cyclemap.mechanics import *
    from cyclemap.resets import *
    from cyclemap.sweeps import *

__version__ = "0.1.0"

_ROOMS = (
    "cyclemap.errors",
    "cyclemap.maps",
    "cyclemap.mechanics",
    "cyclemap.collection",
    "cyclemap.evidence",
    "cyclemap.sweeps",
    "cyclemap.resets",
)

# fmt: off
__all__ = [
    "Advice", "Alarm", "AlternatingPushes", "Anisotropy", "Basin", "BatchExperiment", "BatchRun", "BiasGradient",
    "BiasMonitor", "BiasReport", "Bifurcation", "Branch", "CircleMap", "CircularLaw", "CollectionLoop",
    "CollectionModel", "Comparison", "ConvergenceError", "CoverageRule", "Cycle", "CycleAction", "CycleMapError",
    "CyclePairBlock", "CycleSensitivity", "DataBlock", "DataFileError", "DemandOutlook", "DragBack", "DrawnPushes",
    "DriftSummary", "DriftingMap", "DynamicCycle", "DynamicDrag", "DynamicLoop", "DynamicModel", "DynamicPush",
    "DynamicsComparison", "Ellipse", "EllipseFriction", "Estimate", "Fingerprint", "FittedMap", "FoundWith",
    "FourierLaw", "FunctionBlock", "GripperTurn", "HarmonicMap", "HittingResponse", "Identification", "IndependentSum",
    "InvalidInput", "JumpCrossing", "LeftOutPush", "LimitSurface", "Material", "MaterialPosterior", "MaterialRange",
    "MeasuredCycleMap", "MeasuredDrag", "MeasuredPush", "MeasuredStaircase", "MetastableSets", "MixtureOperator",
    "NextAction", "Noise", "Orbit", "OrbitBranch", "OrientationComparison", "PValue", "Parameter", "ParameterSearch",
    "ParameterSpace", "ParameterTangent", "ParametricLift", "ParetoFront", "PassageResponse", "PatchFootprint",
    "PeriodicLaw", "PeriodicPoints", "PeriodicSchedule", "PointFootprint", "Polygon", "Portrait", "PortraitNumbers",
    "Pose", "Prediction", "PredictionCheck", "PushBound", "PushLibrary", "PushLimits", "PushSet", "PushStatistics",
    "PushTable", "PushWeights", "Pusher", "PusherFriction", "QuasiStaticModel", "QuasiStationaryLaw", "RandomMap",
    "RecordingNoise", "Replay", "ReplayedPushes", "ResetCandidate", "ResetDemands", "ResetDesign", "ResetKernel",
    "ResetNumbers", "ResetScores", "ResetStrategy", "ResetTrial", "ResetUnderWear", "Response", "RestRule", "RingPlace",
    "RobustPushes", "RobustReset", "RotationInterval", "RotationNumber", "RotationNumbers", "RotationPlane",
    "ScheduledActions", "ScoredReset", "SearchedFront", "SetFit", "SetLaws", "SidePush", "SimulatedCollection",
    "Slider", "Slip", "SlowPassage", "SlowZone", "Spectrum", "Staircase", "StaircaseForecast", "StaircaseSummary",
    "StartEnsemble", "StepComparison", "Steps", "StoreWriteError", "StrategyFamily", "StrategyPortrait",
    "StrategyScores", "StrategyStaircase", "SurfaceParameters", "Sweep", "SweepAxis", "SweepPlan", "SweepRange",
    "SweepStatus", "Theta0Pairs", "Tongue", "TongueBoundaries", "TooManySteps", "TrailingLeg", "TransferOperator",
    "TurnHistogram", "TurnResponse", "UniformNoise", "UnsupportedContact", "Verdict", "VonMises", "WayPoints", "Wear",
    "WorldPush", "WornLaw", "WorstCase", "WrappedCauchy", "WrappedNormal", "WrenchTwists", "arnold_family", "basins",
    "batch_experiment", "best_push_weights", "bias_gradient", "bifurcations", "birkhoff_average", "border_collisions",
    "branches", "chain_p_value", "chain_p_values", "check_prediction", "circular_wasserstein", "collected_blocks",
    "collection_p_values", "compare", "compare_dynamics", "compare_explanations", "compare_orientations",
    "compare_steps", "comparison_table", "compose", "conjugate", "crossings_by_jump", "dataset_sliders", "design_reset",
    "drag_turn_block", "drawn_push_family", "drifting_map", "find_steps", "fingerprint", "fit_map", "fit_periodic_law",
    "fit_set", "fit_worn_law", "fixed_leg_family", "fixed_points", "follow_orbit", "friction_ellipse_from_scans",
    "friction_scan_block", "gripper_family", "harmonic_map", "hitting_probability", "hitting_response", "hypervolume",
    "identified_material", "identify", "inverse", "is_nondecreasing", "isotropic_twin", "kernel_modes",
    "kuiper_critical_value", "kuiper_p_value", "kuiper_statistic", "law_after", "least_correction", "least_noise",
    "load_material", "load_pushes", "load_sweep", "log10_passage_time", "lower_envelope", "lyapunov_exponent",
    "material_names", "material_score", "material_toml", "mean_passage_time", "measured_cycle_map",
    "measured_staircase", "metastable_sets", "mixture_operator", "moebius_family", "next_action", "non_dominated",
    "nth_iterate", "orbit_branches", "parameter_tangent", "pareto_front", "passage_response", "period_doublings",
    "periodic_orbits", "periodic_points", "permutation_p_value", "portrait", "predict", "predict_drift",
    "predict_staircase", "preimages", "published_comparison", "push_bound", "push_end_block", "push_library",
    "push_sets", "push_statistics", "push_weights", "pusher_friction_from_forces", "quasi_stationary_law",
    "random_leg_family", "read_measured_drags", "read_measured_pushes", "read_protocol", "read_schedule",
    "read_theta0_pairs", "read_wrench_twists", "redesign_under_wear", "refit_harmonic_map", "replay_push",
    "replay_pushes", "reset_curves", "reset_scores", "reset_trial", "reset_under_wear", "ring_family",
    "robust_push_weights", "robust_reset", "rotation_interval", "rotation_number", "rotation_numbers", "rotation_plane",
    "run_cycles", "run_strategy", "run_sweep", "saddle_nodes", "sample_random_paths", "sample_staircase",
    "sample_staircases", "scored_candidate", "search_front", "search_parameters", "set_laws", "shifted",
    "simulate_collection", "simulated_ensemble", "slip_probabilities", "slow_passages", "staircase_forecast",
    "strategy_cost", "strategy_maps", "strategy_portrait", "strategy_sampler", "strategy_scores", "strategy_staircase",
    "survival_probabilities", "sweep_curves", "sweep_status", "tongue", "tongues", "total_variation",
    "transfer_operator", "turn_histogram", "upper_envelope", "watson_critical_value", "watson_p_value",
    "watson_statistic", "way_point_family", "wear_path", "worn_friction", "worn_loop", "worst_case", "worst_scores",
    "wrench_twist_block", "write_protocol", "write_schedule",
]
# fmt: on


def __getattr__(name: str) -> Any:
    # Rooms are imported when they are first used, so that a command which needs one does not wait for the others.
    if name in __all__:
        for room in map(import_module, _ROOMS):
            if hasattr(room, name):
                return getattr(room, name)
    raise AttributeError(f"module 'cyclemap' has no attribute {name!r}")
