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
material_range, MaterialRange : the surfaces it must work on
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
    from cyclemap.protocol.strategy import (
        CycleAction as CycleAction,
        ResetStrategy as ResetStrategy,
        gripper_turns as gripper_turns,
        legs as legs,
    )
    from cyclemap.resets.action_cycles import (
        map_turns as map_turns,
        sample_turns as sample_turns,
        strategy_maps as strategy_maps,
    )
    from cyclemap.resets.audit import Audit as Audit, audit as audit
    from cyclemap.resets.bias_evidence import Rest as Rest
    from cyclemap.resets.bias_monitor import (
        Advice as Advice,
        Alarm as Alarm,
        BiasMonitor as BiasMonitor,
        BiasReport as BiasReport,
        watch as watch,
    )
    from cyclemap.resets.coverage import (
        Coverage as Coverage,
        CoverageState as CoverageState,
        NextAction as NextAction,
        next_action as next_action,
    )
    from cyclemap.resets.material_range import (
        MaterialRange as MaterialRange,
        material_range as material_range,
    )
    from cyclemap.resets.orientation_law import (
        OrientationLaw as OrientationLaw,
        orientation_law as orientation_law,
    )
    from cyclemap.resets.reset_design import (
        ResetDesign as ResetDesign,
        ResetRow as ResetRow,
        design_reset as design_reset,
    )
    from cyclemap.resets.reset_ranking import Limit as Limit, ResetDemands as ResetDemands
    from cyclemap.resets.strategy_run import (
        StrategyRun as StrategyRun,
        histogram_distances as histogram_distances,
        histogram_shares as histogram_shares,
        independent_distance as independent_distance,
        run_strategy as run_strategy,
        sampled_orientations as sampled_orientations,
        steered_orientations as steered_orientations,
    )
else:
    import_on_first_use(__name__)
