"""Resets: what the robot does otherwise, how uniformly the orientations spread then, and how to watch it."""

from typing import TYPE_CHECKING

from cyclemap.lazy_names import import_on_first_use

if TYPE_CHECKING:
    # What an editor and a type checker see; at run time each name is imported when it is first used.
    from cyclemap.resets.design.action_cycles import map_turns, sample_turns, strategy_maps
    from cyclemap.resets.design.material_range import MaterialRange, material_range, on_material
    from cyclemap.resets.design.orientation_law import OrientationLaw, orientation_law
    from cyclemap.resets.design.reset_design import ResetDesign, ResetRow, design_reset
    from cyclemap.resets.design.reset_ranking import Limit, ResetDemands
    from cyclemap.resets.design.strategy import CycleAction, ResetStrategy, gripper_turns, legs
    from cyclemap.resets.design.strategy_run import (
        StrategyRun,
        histogram_distances,
        histogram_shares,
        independent_distance,
        run_strategy,
        sampled_orientations,
        steered_orientations,
    )
    from cyclemap.resets.monitor.bias_evidence import Rest
    from cyclemap.resets.monitor.bias_monitor import Advice, Alarm, BiasMonitor, BiasReport, watch
    from cyclemap.resets.monitor.coverage import Coverage, CoverageState, NextAction, next_action
    from cyclemap.resets.protocol.protocol_file import read_protocol, write_protocol
    from cyclemap.resets.protocol.schedule_file import read_schedule, write_schedule
else:
    import_on_first_use(__name__)

__all__ = [
    "Advice",
    "Alarm",
    "BiasMonitor",
    "BiasReport",
    "Coverage",
    "CoverageState",
    "CycleAction",
    "Limit",
    "MaterialRange",
    "NextAction",
    "OrientationLaw",
    "ResetDemands",
    "ResetDesign",
    "ResetRow",
    "ResetStrategy",
    "Rest",
    "StrategyRun",
    "design_reset",
    "gripper_turns",
    "histogram_distances",
    "histogram_shares",
    "independent_distance",
    "legs",
    "map_turns",
    "material_range",
    "next_action",
    "on_material",
    "orientation_law",
    "read_protocol",
    "read_schedule",
    "run_strategy",
    "sample_turns",
    "sampled_orientations",
    "steered_orientations",
    "strategy_maps",
    "watch",
    "write_protocol",
    "write_schedule",
]
