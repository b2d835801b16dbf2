"""The data-collection loop, its cycle map and its portrait: the bridge from the mechanics to the
maps.

The loop
--------
CollectionLoop : the protocol: object, surface, rod, push, reset
Cycle, CycleTrajectory, CycleSensitivity : one push and drag back, its course, its derivatives
run_cycles, Cycles : many, as arrays or a frame
worn_loop, drifting_map : on a surface that wears

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
    from cyclemap.collection.batch_experiment import BatchExperiment, BatchRun, batch_experiment
    from cyclemap.collection.dynamic_loop import (
        DynamicCycle,
        DynamicLoop,
        DynamicsComparison,
        compare_dynamics,
        isotropic_twin,
    )
    from cyclemap.collection.fingerprint import Anisotropy, Fingerprint, TurnResponse, fingerprint
    from cyclemap.collection.fingerprint_prediction import (
        Prediction,
        PredictionCheck,
        check_prediction,
        predict,
    )
    from cyclemap.collection.loop import (
        CollectionLoop,
        Cycle,
        Cycles,
        CycleSensitivity,
        CycleTrajectory,
        run_cycles,
    )
    from cyclemap.collection.portrait import (
        Portrait,
        StaircaseForecast,
        portrait,
        staircase_forecast,
    )
    from cyclemap.collection.uncertain_directions import (
        DirectionInterval,
        DirectionUncertainty,
        direction_uncertainty,
    )
    from cyclemap.collection.wearing_loop import drifting_map, worn_loop
else:
    import_on_first_use(__name__)

__all__ = [
    "CollectionLoop",
    "Cycle",
    "CycleSensitivity",
    "CycleTrajectory",
    "Cycles",
    "drifting_map",
    "run_cycles",
]
__all__ += ["worn_loop"]
__all__ += ["BatchExperiment", "BatchRun", "DirectionInterval", "DirectionUncertainty", "Portrait"]
__all__ += [
    "StaircaseForecast",
    "batch_experiment",
    "direction_uncertainty",
    "portrait",
    "staircase_forecast",
]
__all__ += [
    "Anisotropy",
    "Fingerprint",
    "Prediction",
    "PredictionCheck",
    "TurnResponse",
    "check_prediction",
]
__all__ += ["fingerprint", "predict"]
__all__ += [
    "DynamicCycle",
    "DynamicLoop",
    "DynamicsComparison",
    "compare_dynamics",
    "isotropic_twin",
]
