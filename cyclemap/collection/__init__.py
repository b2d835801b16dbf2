"""The data-collection loop, its cycle map and its portrait: the bridge from the mechanics to the maps."""

from cyclemap.collection.anisotropy import Anisotropy
from cyclemap.collection.fingerprint import Fingerprint, TurnResponse, fingerprint
from cyclemap.collection.fingerprint_check import PredictionCheck, check_prediction
from cyclemap.collection.fingerprint_prediction import Prediction, predict
from cyclemap.collection.loop import CollectionLoop, Cycle, Cycles, CycleSensitivity, CycleTrajectory
from cyclemap.collection.portrait import Portrait, portrait
from cyclemap.collection.staircase_forecast import StaircaseForecast, staircase_forecast
from cyclemap.collection.wearing_loop import drifting_map, worn_loop

__all__ = [
    "Anisotropy",
    "CollectionLoop",
    "Cycle",
    "CycleSensitivity",
    "CycleTrajectory",
    "Cycles",
    "Fingerprint",
    "Portrait",
    "Prediction",
    "PredictionCheck",
    "StaircaseForecast",
    "TurnResponse",
    "check_prediction",
    "drifting_map",
    "fingerprint",
    "portrait",
    "predict",
    "staircase_forecast",
    "worn_loop",
]
