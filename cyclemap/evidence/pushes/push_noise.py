"""How far measured pushes and drags are off from what a model says of them."""

from __future__ import annotations

import math

import numpy as np

from cyclemap.arrays import Array

# How far the best model is off in measured pushes, m and rad, of seven plates on two floors, and in
# drags, rad.
_MISSED, _MISSED_DRAG = (1.5e-3, math.radians(2.0)), math.radians(6.0)
# How far off its mark a rod is set by hand, m, and what that adds to a push: about as much, and so
# much turn, rad.
SET_OFF, _SET_OFF_TURN = 2e-3, math.radians(2.0)


def push_noise(read: tuple[float, float], by_hand: bool = False) -> Array:
    """Return the deviation (4,) of measured ends of a push (m, m, rad) and of a drag (rad) from
    what a model says.

    read : m and rad, how far off a reading is. What the best model misses of pushes and drags on
        real floors comes on top; it is taken as independent from push to push, and of a long
        push as of a short one. by_hand : whether rods were set by marks, which adds 2 mm and 2 degrees
        in the median of pushes, and more to those that depend on it.

    >>> along, _, turned, dragged = push_noise((1e-3, 0.0)).tolist()
    >>> round(1e3 * along, 3), round(math.degrees(turned), 3), round(math.degrees(dragged), 3)
    (1.803, 2.0, 6.0)
    """
    added = (SET_OFF, _SET_OFF_TURN) if by_hand else (0.0, 0.0)
    along, turned = (math.hypot(*parts) for parts in zip(read, _MISSED, added, strict=True))
    return np.array((along, along, turned, math.hypot(read[1], _MISSED_DRAG)))
