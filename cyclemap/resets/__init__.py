"""Resets: what the robot does otherwise, how evenly the orientations spread then, and how to watch it."""

from cyclemap.resets.least_noise.least_correction import LeastCorrection, least_correction
from cyclemap.resets.least_noise.least_noise import LeastNoise, least_noise
from cyclemap.resets.least_noise.noise_bound import NoiseBound, independent_noise_bound
from cyclemap.resets.least_noise.turn_law_search import TurnLaw, search_turn_law
from cyclemap.resets.monitor.bias_monitor import BiasMonitor, watch
from cyclemap.resets.monitor.bias_report import Advice, Alarm, BiasReport
from cyclemap.resets.monitor.coverage import Coverage, CoverageRule, CoverageState
from cyclemap.resets.monitor.forecast import Forecast, forecast
from cyclemap.resets.monitor.rest_direction import Rest
from cyclemap.resets.monitor.rest_evidence import RestRule
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
from cyclemap.resets.strategies.schedules import GoldenAngle, Independent, LatinBlocks, Schedule, Sobol, VanDerCorput
from cyclemap.resets.strategies.shared_strokes import run_action
from cyclemap.resets.strategies.spread import Spread
from cyclemap.resets.strategies.strategy import ActionLaw, DrawnStrategy, ResetStrategy
from cyclemap.resets.strategies.strategy_maps import StrategyMaps, strategy_maps
from cyclemap.resets.strategies.strategy_run import StrategyRun, run_strategy
from cyclemap.resets.strategies.strategy_sampling import interpolation_error, sample_strategy

__all__ = [
    "GOLDEN_ANGLE",
    "ActionLaw",
    "Advice",
    "Alarm",
    "AlternatingPushes",
    "BiasMonitor",
    "BiasReport",
    "Combined",
    "Coverage",
    "CoverageRule",
    "CoverageState",
    "CycleAction",
    "CycleCost",
    "DrawnPushes",
    "DrawnStrategy",
    "EffectiveSize",
    "EllipsoidLeg",
    "Evenness",
    "Forecast",
    "GoldenAngle",
    "GripperTurn",
    "Independent",
    "LatinBlocks",
    "LeastCorrection",
    "LeastNoise",
    "LegFlow",
    "NoiseBound",
    "Pace",
    "ResetScores",
    "ResetStrategy",
    "Rest",
    "RestRule",
    "RingPlace",
    "SampledEvenness",
    "SampledMean",
    "ScatteredAim",
    "Schedule",
    "SectorVisits",
    "SimulatedCoverage",
    "Sobol",
    "Spread",
    "StraightReset",
    "StrategyCost",
    "StrategyMaps",
    "StrategyRun",
    "TrailingLeg",
    "TrailingPoint",
    "TurnLaw",
    "VanDerCorput",
    "VariedPush",
    "WayPoints",
    "action_cost",
    "chain_sampler",
    "combine",
    "coverage_measures",
    "effective_size",
    "evenness",
    "forecast",
    "fraction_pushes",
    "headings_after",
    "independent_full_cover",
    "independent_kuiper",
    "independent_largest_gap",
    "independent_noise_bound",
    "independent_sector_share",
    "interpolation_error",
    "least_correction",
    "least_noise",
    "leg_flow",
    "reset_scores",
    "rotation_angles",
    "run_action",
    "run_strategy",
    "sample_strategy",
    "sampled_evenness",
    "schedule_sampler",
    "search_turn_law",
    "sector_visits",
    "sector_visits_from",
    "side_pushes",
    "simulated_coverage",
    "strategy_cost",
    "strategy_maps",
    "trailing_point",
    "watch",
]
