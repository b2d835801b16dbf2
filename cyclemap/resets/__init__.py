"""Resets: what the robot does otherwise, how evenly the orientations spread then, and how to watch it."""

from typing import TYPE_CHECKING

from cyclemap.lazy_names import import_on_first_use

if TYPE_CHECKING:
    # What an editor and a type checker see; at run time each name is imported when it is first used.
    from cyclemap.resets.design.action_cache import ActionCache
    from cyclemap.resets.design.push_proof import PushProof, push_proof
    from cyclemap.resets.design.push_stages import PushStage, push_stages
    from cyclemap.resets.design.reset_candidates import Effort, ResetCandidate
    from cyclemap.resets.design.reset_curves import reset_curves
    from cyclemap.resets.design.reset_demands import ResetDemands
    from cyclemap.resets.design.reset_design import ResetDesign, design_reset
    from cyclemap.resets.design.reset_numbers import ResetKernel, ResetNumbers
    from cyclemap.resets.design.reset_ranking import DemandOutlook, ScoredReset
    from cyclemap.resets.design.reset_trial import ResetTrial, reset_trial
    from cyclemap.resets.drawn_pushes.push_bound import PushBound, push_bound
    from cyclemap.resets.drawn_pushes.push_library import LeftOutPush, PushLibrary, push_library
    from cyclemap.resets.drawn_pushes.push_weights import PushLimits, PushWeights, best_push_weights, push_weights
    from cyclemap.resets.least_noise.least_correction import LeastCorrection, least_correction
    from cyclemap.resets.least_noise.least_noise import LeastNoise, least_noise
    from cyclemap.resets.least_noise.noise_bound import NoiseBound, independent_noise_bound
    from cyclemap.resets.least_noise.turn_law_search import TurnLaw, search_turn_law
    from cyclemap.resets.monitor.bias_monitor import BiasMonitor, watch
    from cyclemap.resets.monitor.bias_report import Advice, Alarm, BiasReport
    from cyclemap.resets.monitor.coverage import Coverage, CoverageRule, CoverageState
    from cyclemap.resets.monitor.forecast import Forecast, forecast
    from cyclemap.resets.monitor.next_action import NextAction, next_action
    from cyclemap.resets.monitor.rest_direction import Rest
    from cyclemap.resets.monitor.rest_evidence import RestRule
    from cyclemap.resets.parameters.parameter_families import (
        drawn_push_family,
        fixed_leg_family,
        gripper_family,
        random_leg_family,
        ring_family,
        way_point_family,
    )
    from cyclemap.resets.parameters.parameter_gradient import SCORES, BiasGradient, Resolution, bias_gradient
    from cyclemap.resets.parameters.parameter_search import ParameterSearch, search_parameters
    from cyclemap.resets.parameters.parameter_space import StrategyFamily
    from cyclemap.resets.parameters.pareto_front import Candidate, ParetoFront, hypervolume, non_dominated, pareto_front
    from cyclemap.resets.parameters.pareto_search import SearchedFront, scored_candidate, search_front
    from cyclemap.resets.protocol.protocol_file import read_protocol, write_protocol
    from cyclemap.resets.protocol.schedule_file import read_schedule, write_schedule
    from cyclemap.resets.protocol.scheduled_actions import ScheduledActions
    from cyclemap.resets.robust.design_under_wear import ResetUnderWear, redesign_under_wear, reset_under_wear
    from cyclemap.resets.robust.material_posterior import MaterialPosterior
    from cyclemap.resets.robust.material_range import MaterialRange
    from cyclemap.resets.robust.material_score import MaterialScore, QuickGrid, material_score
    from cyclemap.resets.robust.robust_reset import RobustReset, corner_check, robust_reset
    from cyclemap.resets.robust.robust_weights import RobustPushes, robust_push_weights
    from cyclemap.resets.robust.sampled_materials import MaterialList, SampledMaterials
    from cyclemap.resets.robust.scenario_loops import direction_matters, loop_on
    from cyclemap.resets.robust.wear_stages import wear_path
    from cyclemap.resets.robust.worst_case import Allowance, WorstCase, worst_case, worst_scores
    from cyclemap.resets.scores.coverage_measures import (
        GOLDEN_ANGLE,
        coverage_measures,
        independent_full_cover,
        independent_kuiper,
        independent_largest_gap,
        independent_sector_share,
        rotation_angles,
    )
    from cyclemap.resets.scores.effective_size import EffectiveSize, effective_size
    from cyclemap.resets.scores.evenness import Evenness, evenness
    from cyclemap.resets.scores.reset_scores import ResetScores, reset_scores
    from cyclemap.resets.scores.sampled_evenness import SampledEvenness, sampled_evenness
    from cyclemap.resets.scores.sector_visits import SectorVisits, sector_visits, sector_visits_from
    from cyclemap.resets.scores.simulated_coverage import (
        SampledMean,
        SimulatedCoverage,
        chain_sampler,
        schedule_sampler,
        simulated_coverage,
    )
    from cyclemap.resets.scores.strategy_sampler import strategy_sampler
    from cyclemap.resets.scores.strategy_scores import StrategyScores, strategy_scores
    from cyclemap.resets.strategies.action_cost import CycleCost, Pace, StrategyCost, action_cost, strategy_cost
    from cyclemap.resets.strategies.combined import Combined, combine
    from cyclemap.resets.strategies.cycle_action import CycleAction
    from cyclemap.resets.strategies.drag_strategies import (
        GripperTurn,
        RingPlace,
        ScatteredAim,
        StraightReset,
        TrailingLeg,
        WayPoints,
    )
    from cyclemap.resets.strategies.ellipsoid_leg import EllipsoidLeg, TrailingPoint, trailing_point
    from cyclemap.resets.strategies.forgetting import LegFlow, headings_after, leg_flow
    from cyclemap.resets.strategies.push_strategies import (
        AlternatingPushes,
        DrawnPushes,
        VariedPush,
        fraction_pushes,
        side_pushes,
    )
    from cyclemap.resets.strategies.schedules import (
        GoldenAngle,
        Independent,
        LatinBlocks,
        Schedule,
        Sobol,
        VanDerCorput,
    )
    from cyclemap.resets.strategies.shared_strokes import run_action
    from cyclemap.resets.strategies.spread import Spread
    from cyclemap.resets.strategies.strategy import ActionLaw, DrawnStrategy, ResetStrategy
    from cyclemap.resets.strategies.strategy_maps import StrategyMaps, strategy_maps
    from cyclemap.resets.strategies.strategy_run import StrategyRun, run_strategy
    from cyclemap.resets.strategies.strategy_sampling import interpolation_error, sample_strategy
    from cyclemap.resets.strategy_portrait import StrategyPortrait, strategy_portrait
    from cyclemap.resets.strategy_staircase import StrategyStaircase, strategy_staircase
else:
    import_on_first_use(__name__)

__all__ = [
    "GOLDEN_ANGLE",
    "SCORES",
    "ActionCache",
    "ActionLaw",
    "Advice",
    "Alarm",
    "Allowance",
    "AlternatingPushes",
    "BiasGradient",
    "BiasMonitor",
    "BiasReport",
    "Candidate",
    "Combined",
    "Coverage",
    "CoverageRule",
    "CoverageState",
    "CycleAction",
    "CycleCost",
    "DemandOutlook",
    "DrawnPushes",
    "DrawnStrategy",
    "EffectiveSize",
    "Effort",
    "EllipsoidLeg",
    "Evenness",
    "Forecast",
    "GoldenAngle",
    "GripperTurn",
    "Independent",
    "LatinBlocks",
    "LeastCorrection",
    "LeastNoise",
    "LeftOutPush",
    "LegFlow",
    "MaterialList",
    "MaterialPosterior",
    "MaterialRange",
    "MaterialScore",
    "NextAction",
    "NoiseBound",
    "Pace",
    "ParameterSearch",
    "ParetoFront",
    "PushBound",
    "PushLibrary",
    "PushLimits",
    "PushProof",
    "PushStage",
    "PushWeights",
    "QuickGrid",
    "ResetCandidate",
    "ResetDemands",
    "ResetDesign",
    "ResetKernel",
    "ResetNumbers",
    "ResetScores",
    "ResetStrategy",
    "ResetTrial",
    "ResetUnderWear",
    "Resolution",
    "Rest",
    "RestRule",
    "RingPlace",
    "RobustPushes",
    "RobustReset",
    "SampledEvenness",
    "SampledMaterials",
    "SampledMean",
    "ScatteredAim",
    "Schedule",
    "ScheduledActions",
    "ScoredReset",
    "SearchedFront",
    "SectorVisits",
    "SimulatedCoverage",
    "Sobol",
    "Spread",
    "StraightReset",
    "StrategyCost",
    "StrategyFamily",
    "StrategyMaps",
    "StrategyPortrait",
    "StrategyRun",
    "StrategyScores",
    "StrategyStaircase",
    "TrailingLeg",
    "TrailingPoint",
    "TurnLaw",
    "VanDerCorput",
    "VariedPush",
    "WayPoints",
    "WorstCase",
    "action_cost",
    "best_push_weights",
    "bias_gradient",
    "chain_sampler",
    "combine",
    "corner_check",
    "coverage_measures",
    "design_reset",
    "direction_matters",
    "drawn_push_family",
    "effective_size",
    "evenness",
    "fixed_leg_family",
    "forecast",
    "fraction_pushes",
    "gripper_family",
    "headings_after",
    "hypervolume",
    "independent_full_cover",
    "independent_kuiper",
    "independent_largest_gap",
    "independent_noise_bound",
    "independent_sector_share",
    "interpolation_error",
    "least_correction",
    "least_noise",
    "leg_flow",
    "loop_on",
    "material_score",
    "next_action",
    "non_dominated",
    "pareto_front",
    "push_bound",
    "push_library",
    "push_proof",
    "push_stages",
    "push_weights",
    "random_leg_family",
    "read_protocol",
    "read_schedule",
    "redesign_under_wear",
    "reset_curves",
    "reset_scores",
    "reset_trial",
    "reset_under_wear",
    "ring_family",
    "robust_push_weights",
    "robust_reset",
    "rotation_angles",
    "run_action",
    "run_strategy",
    "sample_strategy",
    "sampled_evenness",
    "schedule_sampler",
    "scored_candidate",
    "search_front",
    "search_parameters",
    "search_turn_law",
    "sector_visits",
    "sector_visits_from",
    "side_pushes",
    "simulated_coverage",
    "strategy_cost",
    "strategy_maps",
    "strategy_portrait",
    "strategy_sampler",
    "strategy_scores",
    "strategy_staircase",
    "trailing_point",
    "watch",
    "way_point_family",
    "wear_path",
    "worst_case",
    "worst_scores",
    "write_protocol",
    "write_schedule",
]
