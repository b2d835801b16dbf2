"""Forces of friction scans by direction, as tractions of one point in the world's axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, positive_number, read_only
from cyclemap.errors import InvalidInput


@dataclass(frozen=True, eq=False)
class ScanForces:
    """direction (n,) : rad, of the motion. force_along, force_across (n,) : N, of the rod. weight : N, of the object.

    Raises InvalidInput where lengths differ or a number is not finite.

    >>> ScanForces([0.0], [2.0], [0.5], 8.0).traction.tolist()
    [[0.25, 0.0625]]
    """

    direction: Array
    force_along: Array
    force_across: Array
    weight: float

    def __post_init__(self) -> None:
        for name in ("direction", "force_along", "force_across"):
            object.__setattr__(self, name, read_only(finite_array(name, getattr(self, name), ndim=1)))
        positive_number("weight", self.weight)
        if not self.direction.shape == self.force_along.shape == self.force_across.shape:
            raise InvalidInput("friction scans need one force along and one across for each direction")

    @classmethod
    def joined(cls, parts: Sequence[ScanForces]) -> ScanForces:
        """Return several sets of scans of one object as one."""
        direction, along, across = (np.concatenate([getattr(part, name) for part in parts]) for name in cls.columns())
        return cls(direction, along, across, parts[0].weight)

    @staticmethod
    def columns() -> tuple[str, str, str]:
        """Names of the columns, as a table of scans has them."""
        return "direction", "force_along", "force_across"

    @property
    def traction(self) -> Array:
        """(n, 2) traction coefficient along x and y of the world."""
        way = np.stack([np.cos(self.direction), np.sin(self.direction)], axis=-1)
        left = np.stack([-way[:, 1], way[:, 0]], axis=-1)
        return np.asarray((self.force_along[:, None] * way + self.force_across[:, None] * left) / self.weight)
