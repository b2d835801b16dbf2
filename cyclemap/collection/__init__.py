"""The data-collection loop, its cycle map and its portrait: the bridge from the mechanics to the maps."""

from cyclemap.collection.loop import CollectionLoop, Cycle, Cycles, CycleSensitivity, CycleTrajectory
from cyclemap.collection.portrait import Portrait, portrait
from cyclemap.collection.staircase_forecast import StaircaseForecast, staircase_forecast
from cyclemap.collection.wearing_loop import drifting_map, worn_loop

__all__ = [
    "CollectionLoop",
    "Cycle",
    "CycleSensitivity",
    "CycleTrajectory",
    "Cycles",
    "Portrait",
    "StaircaseForecast",
    "drifting_map",
    "portrait",
    "staircase_forecast",
    "worn_loop",
]
