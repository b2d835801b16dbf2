"""Measured data: reading it, fitting laws to it, and setting it beside a prediction.

Reading
-------
load_pushes, PushTable, UnreadableFile : pushes and friction scans of files, folders, tables
read_push_file, PushRecord, ScanRecord : one recording in full
read_theta0_pairs, Theta0Pairs : orientations before successive pushes
MeasuredPush, MeasuredDrag, WrenchTwists : single strokes, and wrenches with the twists they keep up
push_sets, PushSet, dataset_sliders : pushes made alike; the objects that files name

Fitting
-------
fit_map, FittedMap : a cycle map from pairs
fit_periodic_law, PeriodicLaw, fit_worn_law, WornLaw : a periodic function of θ with its bands, one
    that wears
fit_set, SetFit, set_laws, SetLaws : a set with all its laws, as in the paper's tables
push_statistics, PushStatistics : mean and deviation of what pushes did
measured_cycle_map, MeasuredCycleMap, measured_staircase, MeasuredStaircase : map and steps of a
    measured path
turn_bins, TurnBins, angle_histogram, AngleHistogram, turn_histogram, TurnHistogram : medians and
    counts
measured_overlay, MeasuredOverlay, MapAgreement : pairs over a map, and their distance from it

Identifying
-----------
identify, Identification, Parameter, ParameterSpace, SurfaceParameters : maximum likelihood of what
    is unknown
identified_material : the answer as a material
DataBlock : data of one sort and their prediction
push_end_block, drag_turn_block, cycle_pair_block, friction_scan_block, wrench_twist_block : blocks
    by sort
collected_blocks : the blocks of all data in files and folders
friction_ellipse_from_scans, contact_force_ratio : from forces alone
plan_pushes, PushPlan, table_to_fill : which pushes to make, what they will tell, the table for them
measured_plan, MeasuredPlan, filled_text : what that table tells once it is filled in

Comparing
---------
compare, Comparison : a prediction beside data, question by question
replay_pushes, ReplayedPushes, replay_push, Replay : recorded pushes, run again by the mechanics
collection_p_values, PValue, CollectionModel, simulated_ensemble : p-values of a path by simulated
    collections
CircularLaw, kernel_modes : a tabulated distribution; maxima of an estimated density
circular_wasserstein, total_variation : distances
kuiper_statistic, watson_statistic : of orientations against a distribution

Making
------
simulate_collection, SimulatedCollection, RecordingNoise : a collection's files, as a robot would
    record them
probe, probe_pushes, command_push, simulated_push, Probe : what a function, program or log says of
    pushes
"""

from typing import TYPE_CHECKING

from cyclemap.lazy_names import import_on_first_use

if TYPE_CHECKING:
    # What an editor and a type checker see; at run time each name is imported when it is first
    # used.
    from cyclemap.evidence.comparison.collection_null import (
        CollectionModel,
        collection_p_values,
        simulated_ensemble,
    )
    from cyclemap.evidence.comparison.compare import Comparison, compare
    from cyclemap.evidence.comparison.replay_push import Replay, replay_push
    from cyclemap.evidence.comparison.replay_table import (
        ReplayedPushes,
        dataset_sliders,
        replay_pushes,
    )
    from cyclemap.evidence.data_blocks.collected_blocks import collected_blocks
    from cyclemap.evidence.data_blocks.force_blocks import (
        WrenchTwists,
        friction_ellipse_from_scans,
        friction_scan_block,
        wrench_twist_block,
    )
    from cyclemap.evidence.data_blocks.stroke_block import (
        cycle_pair_block,
        drag_turn_block,
        push_end_block,
    )
    from cyclemap.evidence.identification.data_block import DataBlock
    from cyclemap.evidence.identification.identify import Identification, identify
    from cyclemap.evidence.identification.surface_parameters import (
        Parameter,
        ParameterSpace,
        SurfaceParameters,
    )
    from cyclemap.evidence.identified_material import identified_material
    from cyclemap.evidence.laws.circular_distance import (
        CircularLaw,
        PValue,
        circular_wasserstein,
        kernel_modes,
        kuiper_statistic,
        total_variation,
        watson_statistic,
    )
    from cyclemap.evidence.laws.fit_map import (
        FittedMap,
        MeasuredStaircase,
        WornLaw,
        fit_map,
        fit_worn_law,
        measured_staircase,
    )
    from cyclemap.evidence.laws.measured_cycle_map import MeasuredCycleMap, measured_cycle_map
    from cyclemap.evidence.laws.periodic_law import PeriodicLaw, fit_periodic_law
    from cyclemap.evidence.laws.push_sets import (
        PushSet,
        PushStatistics,
        push_sets,
        push_statistics,
    )
    from cyclemap.evidence.laws.set_fit import (
        SetFit,
        SetLaws,
        TurnHistogram,
        fit_set,
        set_laws,
        turn_histogram,
    )
    from cyclemap.evidence.measured_plan import MeasuredPlan, measured_plan
    from cyclemap.evidence.push_plan.plan_pushes import PushPlan, plan_pushes
    from cyclemap.evidence.push_plan.plan_table import table_to_fill
    from cyclemap.evidence.push_probe import (
        Probe,
        command_push,
        probe,
        probe_pushes,
        simulated_push,
    )
    from cyclemap.evidence.pushes.contact_forces import contact_force_ratio
    from cyclemap.evidence.pushes.measured_strokes import MeasuredDrag, MeasuredPush
    from cyclemap.evidence.pushes.planned_table import filled_text
    from cyclemap.evidence.pushes.push_files import PushRecord, ScanRecord, read_push_file
    from cyclemap.evidence.pushes.push_table import PushTable, UnreadableFile, load_pushes
    from cyclemap.evidence.pushes.theta0_pairs import (
        AngleHistogram,
        MapAgreement,
        MeasuredOverlay,
        Theta0Pairs,
        TurnBins,
        angle_histogram,
        measured_overlay,
        read_theta0_pairs,
        turn_bins,
    )
    from cyclemap.evidence.recorded_push import RecordingNoise
    from cyclemap.evidence.simulated_collection import SimulatedCollection, simulate_collection
else:
    import_on_first_use(__name__)

__all__ = ["Comparison", "compare"]
__all__ += [
    "WrenchTwists",
    "collected_blocks",
    "cycle_pair_block",
    "drag_turn_block",
    "friction_ellipse_from_scans",
]
__all__ += ["friction_scan_block", "push_end_block", "wrench_twist_block"]
__all__ += ["DataBlock", "Identification", "Parameter", "ParameterSpace", "SurfaceParameters"]
__all__ += ["identified_material", "identify"]
__all__ += ["FittedMap", "MeasuredStaircase", "PeriodicLaw", "WornLaw", "fit_map"]
__all__ += ["fit_periodic_law", "fit_worn_law", "measured_staircase"]
__all__ += [
    "CircularLaw",
    "CollectionModel",
    "PValue",
    "circular_wasserstein",
    "collection_p_values",
    "kernel_modes",
]
__all__ += ["kuiper_statistic", "simulated_ensemble", "total_variation", "watson_statistic"]
__all__ += [
    "MeasuredPlan",
    "PushPlan",
    "filled_text",
    "measured_plan",
    "plan_pushes",
    "table_to_fill",
]
__all__ += ["Probe", "command_push", "probe", "probe_pushes", "simulated_push"]
__all__ += [
    "AngleHistogram",
    "MapAgreement",
    "MeasuredDrag",
    "MeasuredOverlay",
    "MeasuredPush",
    "PushRecord",
]
__all__ += [
    "PushTable",
    "ScanRecord",
    "Theta0Pairs",
    "TurnBins",
    "UnreadableFile",
    "angle_histogram",
]
__all__ += ["contact_force_ratio", "load_pushes", "measured_overlay"]
__all__ += ["read_push_file", "read_theta0_pairs", "turn_bins"]
__all__ += ["Replay", "ReplayedPushes", "dataset_sliders", "replay_push", "replay_pushes"]
__all__ += ["RecordingNoise", "SimulatedCollection", "simulate_collection"]
__all__ += [
    "MeasuredCycleMap",
    "PushSet",
    "PushStatistics",
    "SetFit",
    "SetLaws",
    "TurnHistogram",
    "fit_set",
]
__all__ += ["measured_cycle_map", "push_sets", "push_statistics", "set_laws", "turn_histogram"]
