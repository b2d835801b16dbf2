"""The data-collection loop, its cycle map and its portrait: the bridge from the mechanics to the maps."""

from typing import TYPE_CHECKING

from cyclemap.lazy_names import import_on_first_use

if TYPE_CHECKING:
    # What an editor and a type checker see; at run time each name is imported when it is first used.
    from cyclemap.collection.batch_experiment import BatchExperiment, BatchRun, batch_experiment
    from cyclemap.collection.cycle import Cycles
    from cyclemap.collection.dynamic_loop import (
        DynamicCycle,
        DynamicLoop,
        DynamicsComparison,
        compare_dynamics,
        isotropic_twin,
    )
    from cyclemap.collection.fingerprint import Anisotropy, Fingerprint, TurnResponse, fingerprint
    from cyclemap.collection.fingerprint_check import PredictionCheck, check_prediction
    from cyclemap.collection.fingerprint_prediction import Prediction, predict
    from cyclemap.collection.loop import CollectionLoop, Cycle, CycleSensitivity, CycleTrajectory, run_cycles
    from cyclemap.collection.portrait import Portrait, portrait
    from cyclemap.collection.staircase_forecast import StaircaseForecast, staircase_forecast
    from cyclemap.collection.uncertain_directions import (
        DirectionInterval,
        DirectionUncertainty,
        direction_uncertainty,
    )
    from cyclemap.collection.wearing_loop import drifting_map, worn_loop
else:
    import_on_first_use(__name__)

__all__ = [
    "Anisotropy",
    "BatchExperiment",
    "BatchRun",
    "CollectionLoop",
    "Cycle",
    "CycleSensitivity",
    "CycleTrajectory",
    "Cycles",
    "DirectionInterval",
    "DirectionUncertainty",
    "DynamicCycle",
    "DynamicLoop",
    "DynamicsComparison",
    "Fingerprint",
    "Portrait",
    "Prediction",
    "PredictionCheck",
    "StaircaseForecast",
    "TurnResponse",
    "batch_experiment",
    "check_prediction",
    "compare_dynamics",
    "direction_uncertainty",
    "drifting_map",
    "fingerprint",
    "isotropic_twin",
    "portrait",
    "predict",
    "run_cycles",
    "staircase_forecast",
    "worn_loop",
]
