"""How much of the circle has been recorded, what each push still tells, and where the next one would help most."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import positive_number, whole_number
from cyclemap.evidence.laws.periodic_basis import fourier_columns
from cyclemap.maps.arcs import TWO_PI

Array = NDArray[np.float64]

CELLS = 720  # the circle is told in cells of half a degree
_CENTRES = (np.arange(CELLS) + 0.5) * (TWO_PI / CELLS)
_COARSE = 8  # every how many cells the information is looked at: 4 degrees


@dataclass(frozen=True)
class CoverageRule:
    """What covering means. reach : rad, a push covers so much on either side; harmonics : of the law to be learned."""

    reach: float = math.radians(5.0)
    harmonics: int = 6

    def __post_init__(self) -> None:
        positive_number("reach", self.reach)
        whole_number("harmonics", self.harmonics, least=1)


@dataclass(frozen=True)
class CoverageState:
    """What a collection covers.

    covered : share of the circle within ``reach`` of a recorded direction. largest_gap : rad, the widest arc without
        one; gap_centre : its middle, rad in [0, 2π). least_covered : rad in [0, 2π), the direction to record next.
    effective_pushes : the collection is worth so many pushes spread evenly. gain : what the last direction would tell
        if it were recorded once more, as a share of what the most telling direction would, in (0, 1].
    """

    covered: float
    largest_gap: float
    gap_centre: float
    least_covered: float
    effective_pushes: float
    gain: float


class Coverage:
    """The directions recorded, and what they fix of a periodic law of θ0.

    The information is that of a Fourier series with ``harmonics`` harmonics under noise of equal size: M = Σ x xᵀ, x
    the columns 1, √2 cos kθ, √2 sin kθ. An even spread is D-optimal for it (Hoel 1965) and makes M the number of pushes
    times the identity, so det(1 + M)^(1/p) - 1 pushes spread evenly would tell as much as those recorded; a push at θ
    tells log(1 + xᵀ(1 + M)⁻¹x) nats times ½. The least covered direction is where Σ φ(θ - θ_i) is least, φ the density
    of the wrapped Cauchy law with scale ``reach``: near by it counts visits, and its tail finds the middle of what is
    empty. Recording there every time is kernel herding (Chen, Welling & Smola 2010) towards the uniform law.

    Directions are kept in cells of half a degree; a push costs a few thousand operations, however many came before.
    """

    def __init__(self, rule: CoverageRule | None = None) -> None:
        self.rule = rule or CoverageRule()
        size = 2 * self.rule.harmonics + 1
        self._visited = np.zeros(CELLS, dtype=bool)
        self._covered = np.zeros(CELLS, dtype=bool)
        self._crowding = np.zeros(CELLS)
        self._inverse = np.eye(size)
        self._log_determinant = 0.0
        self._coarse = _columns(_CENTRES[::_COARSE], self.rule.harmonics)
        self._last: Array | None = None

    def add(self, theta: float) -> None:
        """Record the direction ``theta`` (rad, any number of turns)."""
        place = theta % TWO_PI
        distance = np.abs((_CENTRES - place + math.pi) % TWO_PI - math.pi)
        self._visited[min(int(place * (CELLS / TWO_PI)), CELLS - 1)] = True
        self._covered |= distance <= self.rule.reach
        decay = math.exp(-self.rule.reach)
        self._crowding += (1.0 - decay**2) / (1.0 + decay**2 - 2.0 * decay * np.cos(distance))
        column = self._last = _columns(place, self.rule.harmonics)
        pulled = self._inverse @ column
        gain = 1.0 + float(column @ pulled)
        self._inverse -= np.outer(pulled, pulled) / gain
        self._log_determinant += math.log(gain)

    @property
    def effective_pushes(self) -> float:
        """The collection is worth so many pushes spread evenly."""
        return math.expm1(self._log_determinant / self._inverse.shape[0])

    def state(self) -> CoverageState:
        """What is covered by now; before the first push nothing is, and every direction tells as much."""
        gap, centre = _largest_gap(self._visited)
        best = float(self._information(self._coarse).max())
        here = best if self._last is None else float(self._information(self._last))
        return CoverageState(
            covered=float(self._covered.mean()),
            largest_gap=gap,
            gap_centre=centre,
            least_covered=float(_CENTRES[int(np.argmin(self._crowding))]),
            effective_pushes=self.effective_pushes,
            gain=min(here / best, 1.0),
        )

    def useful_repeats(self, directions: tuple[float, ...], least_gain: float) -> int:
        """How many more pushes on each of ``directions`` (rad) tell ``least_gain`` of the best direction's, or more.

        Recorded j times more, a direction's xᵀ(1 + M)⁻¹x = v falls to v/(1 + j·v).
        """
        best = least_gain * float(self._information(self._coarse).max())
        now = self._information(_columns(directions, self.rule.harmonics))
        return int(np.floor(np.clip(1.0 / best - 1.0 / now, -1.0, None)).sum()) + now.size

    def first_covered(self, visited: Array) -> Array:
        """When each cell is covered, (runs, cells): 0 where it is by now, given when each cell is first visited.

        visited : (runs, cells) push numbers from 1, inf for never.
        """
        from scipy.ndimage import minimum_filter1d

        # The reach rounded to whole cells: a run of visits does not feel the difference.
        cells = min(round(self.rule.reach * CELLS / TWO_PI), CELLS // 2 - 1)
        reached = minimum_filter1d(visited, 2 * cells + 1, axis=1, mode="wrap")
        return np.asarray(np.where(self._covered, 0.0, reached), dtype=np.float64)

    def worth_of(self, theta: Array) -> float:
        """The gain in effective pushes if the directions ``theta`` (n,) rad were recorded too."""
        columns = _columns(theta, self.rule.harmonics)
        grown = np.eye(theta.size) + columns @ self._inverse @ columns.T
        added = float(np.linalg.slogdet(grown)[1])
        size = self._inverse.shape[0]
        return math.exp(self._log_determinant / size) * math.expm1(added / size)

    def crowding(self, theta: Any) -> Array:
        """How crowded recorded directions are at ``theta`` (...) rad, as a share of their mean over the circle.

        Zeros before the first push.
        """
        cells = ((np.asarray(theta, dtype=float) % TWO_PI) * (CELLS / TWO_PI)).astype(int)
        mean = float(self._crowding.mean())
        return np.asarray(self._crowding[np.minimum(cells, CELLS - 1)] / (mean or 1.0), dtype=np.float64)

    def _information(self, columns: Array) -> Array:
        return np.asarray(np.einsum("...i,ij,...j->...", columns, self._inverse, columns), dtype=np.float64)


def _columns(theta: Any, harmonics: int) -> Array:
    columns = fourier_columns(theta, harmonics)
    columns[..., 1:] *= math.sqrt(2.0)
    return columns


def _largest_gap(visited: NDArray[np.bool_]) -> tuple[float, float]:
    """Width and middle (rad) of the widest arc between neighbouring visited cells; the whole circle before any."""
    cells = np.flatnonzero(visited)
    if cells.size == 0:
        return TWO_PI, 0.0
    gaps = np.diff(np.append(cells, cells[0] + CELLS))
    widest = int(np.argmax(gaps))
    width = float(gaps[widest]) * (TWO_PI / CELLS)
    return width, (float(_CENTRES[cells[widest]]) + 0.5 * width) % TWO_PI
