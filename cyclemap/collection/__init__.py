"""The data-collection loop, its cycle map and its portrait: the bridge from the mechanics to the
maps.

The loop
--------
CollectionLoop : the protocol: object, surface, rod, push, reset
Cycle, CycleTrajectory, CycleSensitivity : one push and drag back, its course, its derivatives
run_cycles, Cycles : many, as arrays or a frame
on_material, worn_loop, drifting_map : on another surface, or one that wears

What it does
------------
portrait, Portrait : cycle map, fixed points, rotation, stationary distribution, staircase
staircase_forecast, StaircaseForecast : the staircase alone
direction_uncertainty, DirectionUncertainty, DirectionInterval : how well stable directions are
    known
batch_experiment, BatchExperiment, BatchRun : batches of cycles from all around, as in the paper

To first order in the anisotropy
--------------------------------
fingerprint, Fingerprint, TurnResponse, Anisotropy : how a protocol answers a surface that is nearly
    isotropic
predict, Prediction : the map of any surface from the fingerprint
check_prediction, PredictionCheck : beside the full map

With inertia
------------
DynamicLoop, DynamicCycle : the loop by the dynamic simulation
compare_dynamics, DynamicsComparison : both routes from the same orientations
isotropic_twin : the loop on a surface that has no preferred direction
"""

from typing import TYPE_CHECKING

from cyclemap.lazy_names import import_on_first_use

if TYPE_CHECKING:
    # What an editor and a type checker see; at run time each name is imported when it is first
    # used.
    from cyclemap.collection.cycles import (
        Cycles as Cycles,
        CycleSensitivity as CycleSensitivity,
        CycleTrajectory as CycleTrajectory,
    )
    from cyclemap.collection.dynamic_loop import (
        BatchExperiment as BatchExperiment,
        BatchRun as BatchRun,
        DynamicCycle as DynamicCycle,
        DynamicLoop as DynamicLoop,
        DynamicsComparison as DynamicsComparison,
        batch_experiment as batch_experiment,
        compare_dynamics as compare_dynamics,
    )
    from cyclemap.collection.fingerprint import (
        Fingerprint as Fingerprint,
        TurnResponse as TurnResponse,
        fingerprint as fingerprint,
    )
    from cyclemap.collection.fingerprint_prediction import (
        Prediction as Prediction,
        PredictionCheck as PredictionCheck,
        check_prediction as check_prediction,
        predict as predict,
    )
    from cyclemap.collection.loop import (
        CollectionLoop as CollectionLoop,
        Cycle as Cycle,
        run_cycles as run_cycles,
    )
    from cyclemap.collection.loop_surfaces import (
        Anisotropy as Anisotropy,
        drifting_map as drifting_map,
        isotropic_twin as isotropic_twin,
        on_material as on_material,
        worn_loop as worn_loop,
    )
    from cyclemap.collection.portrait import (
        Portrait as Portrait,
        StaircaseForecast as StaircaseForecast,
        portrait as portrait,
        staircase_forecast as staircase_forecast,
    )
    from cyclemap.collection.uncertain_directions import (
        DirectionInterval as DirectionInterval,
        DirectionUncertainty as DirectionUncertainty,
        direction_uncertainty as direction_uncertainty,
    )
else:
    import_on_first_use(__name__)
