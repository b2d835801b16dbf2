"""How far measured pushes and drags are off from what a model says of them."""

from __future__ import annotations

import math

import numpy as np

from cyclemap.arrays import Array

# How far the best model is off in measured pushes, m and rad, of seven plates on two floors, and in
# drags, rad.
_MISSED, _MISSED_DRAG = (1.5e-3, math.radians(2.0)), math.radians(6.0)
# How far off its mark a rod is set by hand, m along x and y, and what that of one push is called.
SET_OFF, ROD_OFF = 2e-3, "rod_off_"


def push_noise(read: tuple[float, float]) -> Array:
    """Return the deviation (4,) of measured ends of a push (m, m, rad) and of a drag (rad) from
    what a model says.

    read : m and rad, how far off a reading is. What the best model misses of pushes and drags on
        real floors comes on top; it is taken as independent from push to push, and of a long
        push as of a short one. What a rod does that was set off its mark is no noise: it depends on
        the push, by how much the rod was off.

    >>> along, _, turned, dragged = push_noise((1e-3, 0.0)).tolist()
    >>> round(1e3 * along, 3), round(math.degrees(turned), 3), round(math.degrees(dragged), 3)
    (1.803, 2.0, 6.0)
    """
    along, turned = (math.hypot(*errors) for errors in zip(read, _MISSED, strict=True))
    return np.array((along, along, turned, math.hypot(read[1], _MISSED_DRAG)))
