"""What comes of pushing along a chain of strokes: the object's pose at every travel of the rod."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array


@dataclass(frozen=True, eq=False)
class ChainRun:
    """The object's poses along a chain of strokes.

    travel : (n,) m along the chain, never falling. pose : (n, 3) x, y (m), theta (rad). touched : whether the rod
    ever pushed. left : whether the rod had lost the object by the end of the chain.
    """

    travel: Array
    pose: Array
    touched: bool
    left: bool

    def pose_at(self, travel: Array) -> Array:
        """Return the poses (..., 3) at travels (...), m."""
        return np.stack([np.interp(travel, self.travel, self.pose[:, column]) for column in range(3)], axis=-1)
