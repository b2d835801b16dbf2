"""The data-collection loop, its cycle map and its portrait: the bridge from the mechanics to the maps."""

from cyclemap.collection.loop import CollectionLoop, Cycle, Cycles, CycleSensitivity, CycleTrajectory
from cyclemap.collection.portrait import Portrait, portrait

__all__ = ["CollectionLoop", "Cycle", "CycleSensitivity", "CycleTrajectory", "Cycles", "Portrait", "portrait"]
