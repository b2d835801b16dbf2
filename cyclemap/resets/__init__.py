"""Resets: what the robot does otherwise, how uniformly the orientations spread then, and how to
watch it.

Strategies
----------
ResetStrategy, CycleAction : a few actions, how often each comes, in which order
gripper_turns, legs : actions that turn by a gripper, or drag by another way
strategy_maps, map_turns, sample_turns : what each action does to the orientation
run_strategy, StrategyRun : collections by the full mechanics
sampled_orientations, steered_orientations : orientations of collections from turns that are known

Designing one
-------------
design_reset, ResetDesign, ResetRow : the strategies to choose from, the best first
ResetDemands, Limit : what it must keep to, and which demand binds
material_range, MaterialRange, on_material : the surfaces it must work on
orientation_law, OrientationLaw : how orientations are distributed, at once and after n pushes
histogram_shares, histogram_distances, independent_distance : how uniform a histogram is, and would
    be by chance

Watching
--------
BiasMonitor, watch, BiasReport, Alarm, Rest, Advice : whether orientations lock in, where, and what
    would help
Coverage, CoverageState, next_action, NextAction : what was recorded, and what to record next
audit, Audit : the same of a data set that exists
"""

from typing import TYPE_CHECKING

from cyclemap.lazy_names import import_on_first_use

if TYPE_CHECKING:
    # What an editor and a type checker see; at run time each name is imported when it is first
    # used.
    from cyclemap.protocol.strategy import CycleAction, ResetStrategy, gripper_turns, legs
    from cyclemap.resets.action_cycles import map_turns, sample_turns, strategy_maps
    from cyclemap.resets.audit import Audit, audit
    from cyclemap.resets.bias_evidence import Rest
    from cyclemap.resets.bias_monitor import Advice, Alarm, BiasMonitor, BiasReport, watch
    from cyclemap.resets.coverage import Coverage, CoverageState, NextAction, next_action
    from cyclemap.resets.material_range import MaterialRange, material_range, on_material
    from cyclemap.resets.orientation_law import OrientationLaw, orientation_law
    from cyclemap.resets.reset_design import ResetDesign, ResetRow, design_reset
    from cyclemap.resets.reset_ranking import Limit, ResetDemands
    from cyclemap.resets.strategy_run import (
        StrategyRun,
        histogram_distances,
        histogram_shares,
        independent_distance,
        run_strategy,
        sampled_orientations,
        steered_orientations,
    )
else:
    import_on_first_use(__name__)

__all__ = [
    "CycleAction",
    "Limit",
    "MaterialRange",
    "OrientationLaw",
    "ResetDemands",
    "ResetDesign",
    "ResetRow",
]
__all__ += [
    "ResetStrategy",
    "StrategyRun",
    "design_reset",
    "gripper_turns",
    "histogram_distances",
    "histogram_shares",
]
__all__ += [
    "independent_distance",
    "legs",
    "map_turns",
    "material_range",
    "on_material",
    "orientation_law",
]
__all__ += [
    "run_strategy",
    "sample_turns",
    "sampled_orientations",
    "steered_orientations",
    "strategy_maps",
]
__all__ += [
    "Advice",
    "Alarm",
    "Audit",
    "BiasMonitor",
    "BiasReport",
    "Coverage",
    "CoverageState",
    "NextAction",
    "Rest",
]
__all__ += ["audit", "next_action", "watch"]
