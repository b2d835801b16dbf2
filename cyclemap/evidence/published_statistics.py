"""What Ma & Rodriguez (2018) publish of 2000 equal pushes on four materials: Tables II and III, and their sentences.

The paper gives standard deviations and root mean square errors, and both as percentages of the mean: the mean is one
over the other. Percentages carry no sign. In this package's frame the object moves along -y: the means of the
published plywood, 69.1 deg, 36.6 mm and 94.3 mm, put the rod's centre 48.9 mm from the middle of the pushed side, where
it must be 49.75 mm, if the motion is (+36.6, -94.3) mm, and nowhere near that side with any other signs or with x and y
exchanged. So dx is the published Δx, dy minus the published Δy. Orientations are those of this package: the measured
plywood staircase lingers near 95 deg, where the paper sees its high peak ("around 100 deg").
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from cyclemap.arrays import Array, shorter_way
from cyclemap.checks import finite_array, positive_number, whole_number
from cyclemap.errors import InvalidInput, unknown_name

SOURCE = "Ma & Rodriguez 2018, Tables II and III and the text on stable directions"
PUBLISHED_CYCLES = 2000

Triple = tuple[float, float, float]
# A run that starts in a named direction starts within this standard deviation of it (rad): it is read off a histogram.
START_SPREAD = float(np.deg2rad(10.0))
# Standard deviations of noise beyond which it counts as zero.
_REACH = 7.0
# Every so many cycles it is seen whether the law has settled: whether no share changes any more by the second number.
_CHECKED, _STILL = 50, 1e-14


@dataclass(frozen=True)
class PublishedStatistics:
    """What is published of one material, in the order dtheta (rad), dx, dy (m, initial object frame).

    mean, std : of the pushes. rmse : of them about the paper's fitted law of θ0; rmse_percent : as printed beside it,
    per cent of a mean that is up to 3 % off that of Table II. directions : rad, where the histogram
    of θ0 has the peaks that the text names, the one visited first in front. always_advancing : the text sees no stable
    direction, θ0 always increases. first_share : share of the cycles spent in the first direction, where the run starts
    there and leaves it for good; None where no such story is told.
    """

    material: str
    mean: Triple
    std: Triple
    rmse: Triple
    rmse_percent: Triple
    directions: tuple[float, ...]
    always_advancing: bool = False
    first_share: float | None = None

    def __post_init__(self) -> None:
        if not all(0.0 <= r <= s for r, s in zip(self.rmse, self.std, strict=True)):
            raise InvalidInput(f"{self.material}: a law's error {self.rmse} cannot exceed the spread {self.std}")
        if self.first_share is not None and len(self.directions) < 2:
            raise InvalidInput(f"{self.material}: a share of the first direction needs a second one")

    @property
    def start(self) -> float | None:
        """Where the run starts (rad), as far as the text tells; None if it does not."""
        return None if self.first_share is None else self.directions[0]


def published_statistics(material: str) -> PublishedStatistics:
    """Return what is published of `material`: plywood, abs, delrin or pu. Raises InvalidInput for another.

    >>> [round(1e3 * length, 1) for length in published_statistics("abs").mean[1:]]
    [40.1, -67.6]
    """
    if material not in PUBLISHED:
        raise unknown_name("material of Ma & Rodriguez (2018)", material, PUBLISHED)
    return PUBLISHED[material]


def _row(
    material: str,
    spreads: tuple[float, ...],
    errors: tuple[float, ...],
    directions_deg: tuple[float, ...],
    always_advancing: bool = False,
    first_share: float | None = None,
) -> PublishedStatistics:
    """A row of both tables as it is printed: std and percent of Δθ (deg), Δx, Δy (mm) in turn; RMSE and percent."""
    std, percent, rmse, rmse_percent = spreads[::2], spreads[1::2], errors[::2], errors[1::2]
    mean = [sign * 100.0 * s / p for sign, s, p in zip((1.0, 1.0, -1.0), std, percent, strict=True)]
    moments: dict[str, Any] = {
        name: tuple(unit * size for unit, size in zip((math.radians(1.0), 1e-3, 1e-3), sizes, strict=True))
        for name, sizes in (("mean", mean), ("std", std), ("rmse", rmse))
    }
    return PublishedStatistics(
        material,
        **moments,
        rmse_percent=(rmse_percent[0], rmse_percent[1], rmse_percent[2]),
        directions=tuple(math.radians(angle) for angle in directions_deg),
        always_advancing=always_advancing,
        first_share=first_share,
    )


# abs: "stuck in one stable direction" for "about 150 times", then in a second for good; the first has the small peak.
PUBLISHED = MappingProxyType(
    {
        "plywood": _row(
            "plywood", (4.74, 6.86, 2.84, 7.75, 8.57, 9.09), (2.07, 2.99, 0.91, 2.46, 3.39, 3.66), (100.0, 280.0)
        ),
        "abs": _row(
            "abs",
            (3.21, 4.30, 1.59, 3.97, 5.31, 7.86),
            (2.99, 4.00, 1.56, 3.88, 3.21, 4.75),
            (-150.0, 150.0),
            first_share=150.0 / PUBLISHED_CYCLES,
        ),
        "delrin": _row("delrin", (1.28, 1.63, 0.97, 2.49, 3.21, 6.33), (1.28, 1.63, 0.81, 2.07, 1.61, 3.08), (80.0,)),
        "pu": _row(
            "pu",
            (4.53, 6.53, 2.93, 7.30, 11.39, 13.40),
            (1.14, 1.64, 0.60, 1.49, 1.56, 1.86),
            (),
            always_advancing=True,
        ),
    }
)


def run_law(turn: Array, sigma: float, cycles: int, start: float | None = None) -> Array:
    """Return the mean share (n,) of a run's cycles that begin at each angle 2 pi k / n.

    turn (n,) : rad, of a noiseless cycle from each of the angles. sigma : rad, standard deviation of a cycle's noise
    (normal), at least 1.2 spacings of the angles. cycles : in the run. start : rad; None where it is not known, and
    taken as equally likely anywhere.

    The law of the k-th cycle is L^k applied to that of the first, L the transfer operator of the noisy map; the mean
    over k < cycles is returned. Where the map mixes within far fewer cycles it is the stationary law. Where noise
    hardly ever frees an orbit from a stable direction, the stationary law hangs on how often that happens in millions
    of cycles; this one only on what happens in a run. Accurate to the trapezoidal rule: to 1e-4 or better where the
    noise, seen through the map's slope, spans a spacing.

    >>> run_law(np.full(8, 0.3), 1.0, 50).round(12).tolist()
    [0.125, 0.125, 0.125, 0.125, 0.125, 0.125, 0.125, 0.125]
    """
    from scipy.sparse import csr_array

    turns, cycles = finite_array("turn", turn, ndim=1), whole_number("cycles", cycles, least=1)
    count, spacing = turns.size, 2.0 * np.pi / turns.size
    if positive_number("sigma", sigma) < 1.2 * spacing:
        raise InvalidInput(f"noise of {sigma:.3g} rad is finer than 1.2 spacings of {count} angles: take more angles")
    # Column k of the transfer operator is the law of what comes after angle k.
    half = min(int(np.ceil(_REACH * sigma / spacing)) + 1, count // 2)
    place = np.arange(count) + turns / spacing
    nearest = np.rint(place).astype(np.int64)
    offsets = np.arange(-half, half + count % 2 if half == count // 2 else half + 1)
    weight = np.exp(-0.5 * ((nearest - place)[:, np.newaxis] + offsets) ** 2 * (spacing / sigma) ** 2)
    weight /= weight.sum(axis=1, keepdims=True)
    rows = (nearest[:, np.newaxis] + offsets) % count
    columns = np.broadcast_to(np.arange(count)[:, np.newaxis], rows.shape)
    matrix: Any = csr_array((weight.ravel(), (rows.ravel(), columns.ravel())), shape=(count, count))
    step, total = np.full(count, 1.0 / count), np.zeros(count)
    if start is not None:
        off = 2.0 * np.pi * np.arange(count) / count - start
        step = np.exp(-0.5 * (shorter_way(off) / START_SPREAD) ** 2)
        step /= step.sum()
    for done in range(1, cycles + 1):
        total += step
        ahead = matrix @ step
        if done % _CHECKED == 0 and np.max(np.abs(ahead - step)) < _STILL:
            total += (cycles - done) * ahead
            break
        step = ahead
    return np.asarray(total / total.sum())
