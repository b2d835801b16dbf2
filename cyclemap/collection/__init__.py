"""The data-collection loop, its cycle map and its portrait: the bridge from the mechanics to the maps."""

from cyclemap.collection.loop import CollectionLoop, Cycle, Cycles, CycleSensitivity, CycleTrajectory
from cyclemap.collection.portrait import Portrait, portrait
from cyclemap.collection.staircase_forecast import StaircaseForecast, staircase_forecast

__all__ = [
    "CollectionLoop",
    "Cycle",
    "CycleSensitivity",
    "CycleTrajectory",
    "Cycles",
    "Portrait",
    "StaircaseForecast",
    "portrait",
    "staircase_forecast",
]
