"""How much of the circle has been recorded, what each push still tells, and which action would help
most next.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, shorter_way
from cyclemap.checks import finite_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.laws.linear_fit import fourier_columns
from cyclemap.evidence.laws.turn_bins import bin_index
from cyclemap.maps import CircleMap
from cyclemap.written import ANGLE, DIRECTION, UNWRITTEN

CELLS = 720  # the circle is told in cells of half a degree
_CENTRES = (np.arange(CELLS) + 0.5) * (TWO_PI / CELLS)
REACH = math.radians(5.0)  # a push covers so much on either side
HARMONICS = 6  # of the periodic law to be learned
_COARSE = 8  # every how many cells the information is looked at: 4 degrees


@dataclass(frozen=True)
class CoverageState:
    """What a collection covers.

    Attributes
    ----------
    covered : float
        Share of the circle within ``reach`` of a recorded direction.
    largest_gap : float
        The widest arc without one, rad.
    gap_centre : float
        Its middle, rad in [0, 2π).
    least_covered : float
        The direction to record next, rad in [0, 2π).
    effective_pushes : float
        The collection is worth so many pushes spread evenly.
    gain : float
        What the last direction would tell if it were recorded once more, as a share of what the
        most telling direction would, in (0, 1].

    Examples
    --------
    >>> import math
    >>> from cyclemap.resets import Coverage
    >>> coverage = Coverage()
    >>> for recorded in (0.0, math.pi / 2.0):
    ...     coverage.add(recorded)
    >>> round(math.degrees(coverage.state().largest_gap))
    270
    """

    covered: float
    effective_pushes: float
    gain: float
    largest_gap: float = field(metadata=ANGLE)
    gap_centre: float = field(metadata=DIRECTION)
    least_covered: float = field(metadata=UNWRITTEN)


class Crowding:
    """How crowded recorded directions are, for `runs` collections side by side.

    Each direction adds the density of the wrapped Cauchy law whose scale is what a push covers
    (5°): near by it counts visits, and its tail finds the middle of what is empty. Cells of half a
    degree.
    """

    def __init__(self, runs: int = 1) -> None:
        decay = math.exp(-REACH)
        offsets = np.arange(CELLS) * (TWO_PI / CELLS)
        self._kernel = (1.0 - decay**2) / (1.0 + decay**2 - 2.0 * decay * np.cos(offsets))
        self.crowding = np.zeros((runs, CELLS))

    def add(self, theta: Array) -> None:
        """Record a direction of each collection, (runs,) rad."""
        self.crowding += self._kernel[np.arange(CELLS) - bin_index(theta, CELLS)[:, np.newaxis]]

    def at(self, theta: Array) -> Array:
        """Return the crowding at directions (..., runs), as a share of the mean over the circle; 0
        before any.
        """
        mean = self.crowding.mean(axis=1)
        crowding = self.crowding[np.arange(len(self.crowding)), bin_index(theta, CELLS)]
        return crowding / np.where(mean > 0.0, mean, 1.0)


class Coverage:
    """The directions recorded, and what they fix of a periodic law of θ0.

    Notes
    -----
    The information is that of a Fourier series with six harmonics under noise of equal size: M
    = Σ x xᵀ, x the columns 1, √2 cos kθ, √2 sin kθ. An even spread is D-optimal for it (Hoel
    1965) and makes M the number of pushes times the identity, so det(1 + M)^(1/p) - 1 pushes
    spread evenly would tell as much as those recorded; a push at θ tells log(1 + xᵀ(1 + M)⁻¹x)
    nats times ½. The least covered direction is where Σ φ(θ - θ_i) is least, φ the density of
    `Crowding`. Recording there every time is kernel herding (Chen, Welling & Smola 2010)
    towards the uniform law.

    Directions are kept in cells of half a degree; a push costs a few thousand operations,
    however many came before.

    References
    ----------
    - Hoel, P. G. (1965), Minimax designs in two dimensional regression, Annals of Mathematical
      Statistics 36.
    - Chen, Y., Welling, M. & Smola, A. (2010), Super-samples from kernel herding, UAI.

    Examples
    --------
    >>> import math
    >>> import numpy as np
    >>> from cyclemap.resets import Coverage
    >>> coverage = Coverage()
    >>> for recorded in np.arange(36) * math.radians(10.0):
    ...     coverage.add(recorded)
    >>> round(coverage.effective_pushes, 1)
    36.0
    """

    def __init__(self) -> None:
        self._visited = np.zeros(CELLS, dtype=bool)
        self._covered = np.zeros(CELLS, dtype=bool)
        self.crowding = Crowding()
        # 1 + M.
        self._known = np.eye(2 * HARMONICS + 1)
        self._coarse = _columns(_CENTRES[::_COARSE])
        self._last: Array | None = None

    def add(self, theta: float) -> None:
        """Record the direction ``theta`` (rad, any number of turns)."""
        place = theta % TWO_PI
        distance = np.abs(shorter_way(_CENTRES - place))
        visit = np.array([place])
        self._visited[bin_index(visit, CELLS)] = True
        self._covered |= distance <= REACH
        self.crowding.add(visit)
        self._last = _columns(place)
        self._known += np.outer(self._last, self._last)

    @property
    def effective_pushes(self) -> float:
        """The collection is worth so many pushes spread evenly."""
        return math.expm1(float(np.linalg.slogdet(self._known)[1]) / len(self._known))

    def state(self) -> CoverageState:
        """What is covered by now; before the first push nothing is, and every direction tells as
        much.
        """
        # The widest arc between neighbouring visited cells; the whole circle before any.
        gap = TWO_PI
        centre = 0.0
        cells = np.flatnonzero(self._visited)
        if cells.size:
            gaps = np.diff(cells, append=cells[0] + CELLS)
            widest = int(np.argmax(gaps))
            gap = float(gaps[widest]) * (TWO_PI / CELLS)
            centre = (float(_CENTRES[cells[widest]]) + 0.5 * gap) % TWO_PI
        best = float(self._information(self._coarse).max())
        here = best if self._last is None else float(self._information(self._last))
        return CoverageState(
            covered=float(self._covered.mean()),
            largest_gap=gap,
            gap_centre=centre,
            least_covered=float(_CENTRES[int(np.argmin(self.crowding.crowding[0]))]),
            effective_pushes=self.effective_pushes,
            gain=min(here / best, 1.0),
        )

    def useful_repeats(self, directions: tuple[float, ...], least_gain: float) -> int:
        """How many more pushes on each of ``directions`` (rad) tell ``least_gain`` of the best
        direction's, or more.

        Recorded j times more, a direction's xᵀ(1 + M)⁻¹x = v falls to v/(1 + j·v).
        """
        best = least_gain * float(self._information(self._coarse).max())
        now = self._information(_columns(directions))
        return int(np.floor(np.clip(1.0 / best - 1.0 / now, -1.0, None)).sum()) + now.size

    def _information(self, columns: Array) -> Array:
        return np.asarray(
            np.einsum("...i,...i->...", columns, np.linalg.solve(self._known, columns.T).T)
        )


def _columns(theta: ArrayLike) -> Array:
    columns = fourier_columns(theta, HARMONICS)
    columns[..., 1:] *= math.sqrt(2.0)
    return columns


@dataclass(frozen=True)
class NextAction:
    """An action chosen for what the push after it will tell.

    Attributes
    ----------
    number : int
        Of the action in the strategy, from 0.
    lands : float
        rad in [0, 2 pi), where its map takes the orientation.
    crowding : float
        Of the recorded directions there, as a share of the mean over the circle: 0 where
        nothing is near, 1 on evenly covered ground.

    Examples
    --------
    >>> import math
    >>> from cyclemap import CircleMap
    >>> from cyclemap.resets import Coverage, next_action
    >>> covered = Coverage()
    >>> covered.add(0.0)
    >>> action = next_action([CircleMap.rigid(0.0), CircleMap.rigid(0.5)], covered, 0.0)
    >>> action.number, round(math.degrees(action.lands))
    (1, 180)
    """

    number: int
    lands: float = field(metadata=DIRECTION)
    crowding: float


def next_action(maps: Sequence[CircleMap], coverage: Coverage, theta: float) -> NextAction:
    """Return which of a strategy's actions takes the object to where least is recorded.

    Parameters
    ----------
    maps : sequence of CircleMap
        Of its actions, as `strategy_maps` makes them.
    coverage : Coverage
        Of the collection so far, `theta` fed to it; before anything is recorded the first
        action is chosen.
    theta : float
        Orientation before the cycle, rad.

    Returns
    -------
    NextAction
        The action, and where it leads.

    Raises
    ------
    InvalidInput
        Where there is no map.

    Notes
    -----
    The noise of a cycle is left out: it blurs all landings alike. Chosen so in every cycle, it is
    the greedy step of kernel herding towards the uniform law (Chen, Welling & Smola 2010), among
    the places that the actions reach; how even that becomes is not bounded. The action then depends
    on the orientation: record it with each push, for data that are even in orientation need not be
    even in action.

    References
    ----------
    Chen, Y., Welling, M. & Smola, A. (2010), Super-samples from kernel herding, UAI.

    Examples
    --------
    >>> import math
    >>> from cyclemap import CircleMap
    >>> from cyclemap.resets import Coverage, next_action
    >>> quarter, half = CircleMap.rigid(0.25), CircleMap.rigid(0.5)
    >>> covered = Coverage()
    >>> for recorded in (1.0, 1.0 + math.pi / 2.0):
    ...     covered.add(recorded)
    >>> next_action([quarter, half], covered, 1.0).number
    1
    """
    if not maps:
        raise InvalidInput("there is no action to choose from: give the map of one or more")
    place = finite_number("theta", theta)
    lands = np.array([[float(cycle_map(place))] for cycle_map in maps]) % TWO_PI
    crowding = coverage.crowding.at(lands)[:, 0]
    best = int(np.argmin(crowding))
    return NextAction(best, float(lands[best, 0]), float(crowding[best]))
