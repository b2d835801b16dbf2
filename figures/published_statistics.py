"""What Ma & Rodriguez (2018) publish of 2000 equal pushes on four materials.

The paper gives standard deviations and root mean square errors, and both as percentages of the
mean: the mean is one over the other. Percentages carry no sign. In this package's frame the object
moves along -y: the means of the published plywood, 69.1 deg, 36.6 mm and 94.3 mm, put the rod's
centre 48.9 mm from the middle of the pushed side, where it must be 49.75 mm, if the motion is
(+36.6, -94.3) mm, and nowhere near that side with any other signs or with x and y exchanged. So dx
is the published Δx, dy minus the published Δy. Orientations are those of this package: the measured
plywood staircase lingers near 95 deg, where the paper sees its high peak ("around 100 deg").
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from cyclemap.errors import unknown_name

SOURCE = "Ma & Rodriguez 2018, Tables II and III and the text on stable directions"
PUBLISHED_CYCLES = 2000


@dataclass(frozen=True)
class PublishedStatistics:
    """What is published of one material, in the order dtheta (rad), dx, dy (m, initial object
    frame).

    mean, std : of the pushes.
    rmse : of them about the paper's fitted law of θ0; rmse_percent : as printed beside it, per cent
        of a mean that is up to 3 % off that of Table II.
    directions : rad, where the histogram of θ0 has the peaks that the text names, the one visited
        first in front.
    always_advancing : the text sees no stable direction.
    first_share : of the cycles, spent in the first direction, where the run starts there and leaves
        it for good.
    """

    material: str
    mean: tuple[float, ...]
    std: tuple[float, ...]
    rmse: tuple[float, ...]
    rmse_percent: tuple[float, ...]
    directions: tuple[float, ...]
    always_advancing: bool = False
    first_share: float | None = None


def published_statistics(material: str) -> PublishedStatistics:
    """Return what is published of `material`: plywood, abs, delrin or pu. Raises InvalidInput for
    another.

    >>> [round(1e3 * length, 1) for length in published_statistics("abs").mean[1:]]
    [40.1, -67.6]
    """
    if material not in PUBLISHED:
        raise unknown_name("material of Ma & Rodriguez (2018)", material, PUBLISHED)
    return PUBLISHED[material]


# As printed: standard deviations of Δθ (deg), Δx, Δy (mm), these in per cent of the means, errors
# of the fitted law, these in per cent, and directions (deg). abs is "stuck in one stable direction"
# for "about 150 times", then in a second for good; the first has the small peak.
_TABLES: dict[str, tuple[tuple[float, ...], ...]] = {
    "plywood": (
        (4.74, 2.84, 8.57),
        (6.86, 7.75, 9.09),
        (2.07, 0.91, 3.39),
        (2.99, 2.46, 3.66),
        (100.0, 280.0),
    ),
    "abs": (
        (3.21, 1.59, 5.31),
        (4.30, 3.97, 7.86),
        (2.99, 1.56, 3.21),
        (4.00, 3.88, 4.75),
        (-150.0, 150.0),
    ),
    "delrin": (
        (1.28, 0.97, 3.21),
        (1.63, 2.49, 6.33),
        (1.28, 0.81, 1.61),
        (1.63, 2.07, 3.08),
        (80.0,),
    ),
    "pu": ((4.53, 2.93, 11.39), (6.53, 7.30, 13.40), (1.14, 0.60, 1.56), (1.64, 1.49, 1.86), ()),
}
_SI = np.array([math.radians(1.0), 1e-3, 1e-3])
PUBLISHED = MappingProxyType(
    {
        name: PublishedStatistics(
            name,
            tuple((_SI * [1.0, 1.0, -1.0] * 100.0 * std / percent).tolist()),
            tuple((_SI * std).tolist()),
            tuple((_SI * rmse).tolist()),
            rmse_percent,
            tuple(np.radians(directions).tolist()),
            always_advancing=name == "pu",
            first_share=150.0 / PUBLISHED_CYCLES if name == "abs" else None,
        )
        for name, (std, percent, rmse, rmse_percent, directions) in _TABLES.items()
    }
)
