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
fit_set, SetFit, set_laws, MotionLaw : a set with all its laws, as in the paper's tables
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
        CollectionModel as CollectionModel,
        collection_p_values as collection_p_values,
        simulated_ensemble as simulated_ensemble,
    )
    from cyclemap.evidence.comparison.compare import Comparison as Comparison, compare as compare
    from cyclemap.evidence.comparison.replay_push import (
        Replay as Replay,
        replay_push as replay_push,
    )
    from cyclemap.evidence.comparison.replay_table import (
        ReplayedPushes as ReplayedPushes,
        dataset_sliders as dataset_sliders,
        replay_pushes as replay_pushes,
    )
    from cyclemap.evidence.identification.collected_blocks import (
        collected_blocks as collected_blocks,
    )
    from cyclemap.evidence.identification.data_block import DataBlock as DataBlock
    from cyclemap.evidence.identification.force_blocks import (
        WrenchTwists as WrenchTwists,
        friction_ellipse_from_scans as friction_ellipse_from_scans,
        friction_scan_block as friction_scan_block,
        wrench_twist_block as wrench_twist_block,
    )
    from cyclemap.evidence.identification.identify import (
        Identification as Identification,
        identify as identify,
    )
    from cyclemap.evidence.identification.stroke_block import (
        cycle_pair_block as cycle_pair_block,
        drag_turn_block as drag_turn_block,
        push_end_block as push_end_block,
    )
    from cyclemap.evidence.identification.surface_parameters import (
        Parameter as Parameter,
        ParameterSpace as ParameterSpace,
        SurfaceParameters as SurfaceParameters,
    )
    from cyclemap.evidence.identified_material import identified_material as identified_material
    from cyclemap.evidence.laws.circular_distance import (
        CircularLaw as CircularLaw,
        PValue as PValue,
        circular_wasserstein as circular_wasserstein,
        kernel_modes as kernel_modes,
        kuiper_statistic as kuiper_statistic,
        total_variation as total_variation,
        watson_statistic as watson_statistic,
    )
    from cyclemap.evidence.laws.fit_map import (
        FittedMap as FittedMap,
        MeasuredStaircase as MeasuredStaircase,
        WornLaw as WornLaw,
        fit_map as fit_map,
        fit_worn_law as fit_worn_law,
        measured_staircase as measured_staircase,
    )
    from cyclemap.evidence.laws.measured_cycle_map import (
        MeasuredCycleMap as MeasuredCycleMap,
        measured_cycle_map as measured_cycle_map,
    )
    from cyclemap.evidence.laws.periodic_law import (
        PeriodicLaw as PeriodicLaw,
        fit_periodic_law as fit_periodic_law,
    )
    from cyclemap.evidence.laws.push_sets import (
        PushSet as PushSet,
        PushStatistics as PushStatistics,
        push_sets as push_sets,
        push_statistics as push_statistics,
    )
    from cyclemap.evidence.laws.set_fit import (
        MotionLaw as MotionLaw,
        SetFit as SetFit,
        TurnHistogram as TurnHistogram,
        fit_set as fit_set,
        set_laws as set_laws,
        turn_histogram as turn_histogram,
    )
    from cyclemap.evidence.laws.turn_bins import (
        AngleHistogram as AngleHistogram,
        MapAgreement as MapAgreement,
        MeasuredOverlay as MeasuredOverlay,
        TurnBins as TurnBins,
        angle_histogram as angle_histogram,
        measured_overlay as measured_overlay,
        turn_bins as turn_bins,
    )
    from cyclemap.evidence.measured_plan import (
        MeasuredPlan as MeasuredPlan,
        measured_plan as measured_plan,
        table_to_fill as table_to_fill,
    )
    from cyclemap.evidence.plan_pushes import (
        PushPlan as PushPlan,
        plan_pushes as plan_pushes,
    )
    from cyclemap.evidence.push_probe import (
        Probe as Probe,
        command_push as command_push,
        probe as probe,
        probe_pushes as probe_pushes,
        simulated_push as simulated_push,
    )
    from cyclemap.evidence.pushes.contact_forces import contact_force_ratio as contact_force_ratio
    from cyclemap.evidence.pushes.measured_strokes import (
        MeasuredDrag as MeasuredDrag,
        MeasuredPush as MeasuredPush,
    )
    from cyclemap.evidence.pushes.push_files import read_push_file as read_push_file
    from cyclemap.evidence.pushes.push_table import (
        PushTable as PushTable,
        UnreadableFile as UnreadableFile,
        load_pushes as load_pushes,
    )
    from cyclemap.evidence.pushes.recordings import (
        PushRecord as PushRecord,
        ScanRecord as ScanRecord,
    )
    from cyclemap.evidence.pushes.theta0_pairs import (
        Theta0Pairs as Theta0Pairs,
        read_theta0_pairs as read_theta0_pairs,
    )
    from cyclemap.evidence.recorded_push import RecordingNoise as RecordingNoise
    from cyclemap.evidence.simulated_collection import (
        SimulatedCollection as SimulatedCollection,
        simulate_collection as simulate_collection,
    )
    from cyclemap.evidence.tables.planned_table import filled_text as filled_text
else:
    import_on_first_use(__name__)
