"""Whether the engine comes to the numbers of an independent solver on this machine."""

import math

import numpy as np

from cyclemap.collection.loop import CollectionLoop

# MIT's loop on plywood: theta0, turn of the push and of the drag that follows, degrees, by that solver.
REFERENCE_DEG = (
    (0.0, 73.65314, -63.68794),
    (60.0, 73.84911, -73.51442),
    (150.0, 65.58227, -77.99290),
    (270.0, 72.40902, -49.51194),
)
# How far off that the turns may be, rad: they are within 6e-5 degrees, at any accuracy of ours.
REFERENCE_ERROR = math.radians(1e-4)


def reference_error() -> float:
    """Return the largest difference (rad) of turns in MIT's loop on plywood from the independent solver's."""
    theta, push_turn, drag_turn = np.radians(REFERENCE_DEG).T
    cycles = CollectionLoop.mit("plywood").cycles(theta)
    return float(np.abs([cycles.push_turn - push_turn, cycles.drag_turn - drag_turn]).max())
