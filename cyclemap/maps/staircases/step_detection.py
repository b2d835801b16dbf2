"""Steps in a path: where it dwells, for how long, and how high it climbs in between."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, Mask, Whole, stretches
from cyclemap.checks import finite_array
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import STAIRCASE
from cyclemap.maps.staircases.slow_zones import SlowZone
from cyclemap.written import ANGLE

_SLOW = 2.0  # a dwell is at least this much slower than the path is on average over its height
_SHORTEST = 3  # cycles: nothing shorter is a dwell
_WIDEST = np.pi / 4  # radians: half the height that the widest window tried lets a dwell cover
_HALVINGS = 7  # windows tried: the widest, and so many halves of it
# share of the time less share of the height in dwells: drifts and random walks stay below 0.44
_CONTRAST = 0.47
_ALIKE = 0.03  # of windows whose contrasts differ by less, the widest is taken
_JITTERS = 1.5  # windows narrower than this many median changes of one cycle are not tried
_SPAN = 3.3  # standard deviations from the 5th to the 95th percentile
# dwells are trimmed to so many median deviations: three standard deviations of a normal law
_TRIM = 4.45


@dataclass(frozen=True, eq=False)
class Steps:
    """Dwells of a path in order, and the steps between them; m dwells, v visits, cycles counted
    from 0.

    Attributes
    ----------
    start, end : ndarray of int, shape (m,)
        First and last cycle of each dwell.
    levels, scatter : ndarray, shape (m,)
        Mean and standard deviation of the angle during its visits, radians, lifted.
    visit_start, visit_end : ndarray of int, shape (v,)
        The uninterrupted stays that make up the dwells: a dwell has more than one where the
        path left and came back before it dwelt elsewhere.
    visit_zone : ndarray of int, shape (v,)
        Which of ``zones`` a visit is in (-1: none).
    cycles : int
        Last cycle of the path.
    climb : float
        Its last angle less its first, radians (less the zones' turns 2πwn).
    zones : tuple of SlowZone
        Those looked for, else ().

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import find_steps
    >>> stairs = np.repeat([0.0, 1.0, 2.0], [20, 30, 40])
    >>> steps = find_steps(stairs)
    >>> steps.count, steps.levels.tolist(), steps.climb
    (2, [0.0, 1.0, 2.0], 2.0)
    """

    start: Whole
    end: Whole
    levels: Array
    scatter: Array
    visit_start: Whole
    visit_end: Whole
    visit_zone: Whole
    cycles: int
    climb: float = field(metadata=ANGLE)
    zones: tuple[SlowZone, ...] = ()

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    @property
    def heights(self) -> Array:
        """Shape (m - 1,), radians: how much higher each dwell is than the one before."""
        return np.diff(self.levels)

    @property
    def lengths(self) -> Whole:
        """Shape (m,), cycles that each dwell lasts, both ends included; too short where
        ``censored``.
        """
        return self.end - self.start + 1

    @property
    def censored(self) -> Mask:
        """Shape (m,): the path begins or ends in this dwell, which lasted longer than was seen."""
        return np.asarray((self.start == 0) | (self.end == self.cycles))

    @property
    def visit_dwell(self) -> Whole:
        """Shape (v,): which dwell a visit belongs to."""
        return np.searchsorted(self.start, self.visit_start, side="right") - 1

    @property
    def count(self) -> int:
        """Number of steps."""
        return max(int(self.levels.size) - 1, 0)


def find_steps(theta: ArrayLike, *, zones: Sequence[SlowZone] | None = None) -> Steps:
    """The dwells and steps of a measured or sampled path.

    Parameters
    ----------
    theta : array_like, shape (n,)
        n ≥ 2, radians, one angle a cycle, on the lifted line (``np.unwrap`` lifts angles mod 2π
        where no cycle turns by half a turn).
    zones : sequence of SlowZone or None, optional
        Slow zones that are looked for (``predict_staircase(...).zones``); None: dwells wherever
        they are.

    Returns
    -------
    Steps
        Dwells and visits, and the steps between them.

    Raises
    ------
    InvalidInput
        For fewer than 2 angles, angles that are not finite, or zones of several windings.

    Notes
    -----
    With zones: a visit is a maximal run of cycles inside one copy of a zone's arc that reaches the
    zone's core, so jitter at the arc's edge makes none (milestones: Buchete & Hummer 2008).
    Successive visits to one copy are one dwell. All zones must have the same winding w; levels are
    those of θ_n - 2πwn.

    Without: for a window h, a cycle dwells if it lies in some number of successive cycles whose
    angles span at most 2h: twice what the path takes for a height 2h at its mean pace over height
    (3 at least). Runs of such cycles, trimmed to three robust deviations from their median, are
    dwells, and neighbours whose means differ by at most 2h are one (the dispersion rule of Salvucci
    & Goldberg 2000). Of π/4 (or an eighth of the path's span) and seven halvings, h is the window
    whose dwells hold the largest share of the cycles less their share of the height travelled; no
    dwells where that is below 0.47 (drifts, rotations and random walks stay below 0.44 at a
    thousand cycles). A path that spans less than π/2 and whose halves differ in mean by less than
    its scatter is one dwell. Shifting, mirroring or reversing the path shifts, mirrors or reverses
    its dwells.

    References
    ----------
    - Buchete, N.-V. & Hummer, G. (2008), Coarse master equations for peptide folding dynamics,
      Journal of Physical Chemistry B 112.
    - Salvucci, D. D. & Goldberg, J. H. (2000), Identifying fixations and saccades in eye-tracking
      protocols, ETRA.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import find_steps
    >>> stairs = np.repeat([0.0, 1.0, 2.0], [20, 30, 40])
    >>> found = find_steps(stairs)
    >>> found.lengths.tolist(), found.heights.tolist(), found.censored.tolist()
    ([20, 30, 40], [1.0, 1.0], [True, False, True])
    """
    path = finite_array("theta", theta, ndim=1)
    if path.size < 2:
        raise InvalidInput(f"theta has {path.size} angles: give 2 cycles at least")
    if zones is None:
        return _best_window(path)
    try:
        wanted = tuple(zones)
    except TypeError as cause:
        raise InvalidInput(f"zones is {zones!r}: give a sequence of SlowZones or None") from cause
    return _in_zones(path, wanted)


def _best_window(path: Array) -> Steps:
    span = float(np.ptp(path))
    widest = min(_WIDEST, span / 8.0)
    half = path.size // 2
    if span <= 2.0 * _WIDEST and abs(path[:half].mean() - path[-half:].mean()) <= path.std():
        return _made(path, [(0, path.size - 1)], span / 2.0)
    jitter = float(np.median(np.abs(np.diff(path))))
    windows = [widest * 0.5**halving for halving in range(_HALVINGS + 1)]
    tried = [_within(path, window) for window in windows if window >= _JITTERS * jitter]
    contrast = [_contrast(path, steps) for steps in tried]
    if max(contrast, default=0.0) < _CONTRAST:
        return _made(path, [], widest)
    return tried[int(np.argmax(np.array(contrast) >= max(contrast) - _ALIKE))]


def _contrast(path: Array, steps: Steps) -> float:
    """Share of the cycles in dwells, less that of their scatter in the height travelled."""
    if steps.start.size == 0:
        return 0.0
    travelled = float(np.sum(np.abs(np.diff([path[0], *steps.levels, path[-1]]))))
    covered = _SPAN * float(np.sum(steps.scatter))
    share = float(np.sum(steps.visit_end - steps.visit_start + 1)) / path.size
    return share - (min(1.0, covered / travelled) if travelled > 0.0 else 1.0)


def _within(path: Array, window: float) -> Steps:
    """Dwells for one window."""
    reach = _reach(path, 2.0 * window * (1.0 + STAIRCASE))
    cycle = np.arange(path.size)
    length = reach - cycle + 1
    before = np.searchsorted(reach, cycle)
    # Twice the cycles that the window's height takes at the mean pace: stays weighted by the height
    # they cover.
    whole = np.append(length[reach < path.size - 1], (cycle - before + 1)[before > 0])
    shortest = float(_SHORTEST)
    if whole.size:
        pace = np.sum(1.0 / whole) / np.sum(1.0 / whole**2)
        shortest = max(shortest, np.ceil(_SLOW * pace))
    # Runs of cycles in which each neighbouring pair lies in one of the long windows.
    farthest = np.maximum.accumulate(np.where(length >= shortest, reach, -1))
    runs = []
    for first, last in stretches(farthest > cycle):
        # Without the ends that already lead away.
        away = np.abs(path[first : last + 1] - np.median(path[first : last + 1]))
        kept = first + np.flatnonzero(away <= _TRIM * np.median(away) + STAIRCASE * window)
        if kept[-1] - kept[0] + 1 >= _SHORTEST:
            runs.append((int(kept[0]), int(kept[-1])))
    return _made(path, runs, window)


def _reach(path: Array, span: float) -> Whole:
    """For each cycle n the last cycle m for which the angles n, ..., m span at most ``span``."""
    values = path.tolist()
    reach = np.empty(path.size, dtype=np.int64)
    high: deque[int] = deque()
    low: deque[int] = deque()
    first = 0
    for last, value in enumerate(values):
        while high and values[high[-1]] <= value:
            high.pop()
        while low and values[low[-1]] >= value:
            low.pop()
        high.append(last)
        low.append(last)
        while values[high[0]] - values[low[0]] > span:
            reach[first] = last - 1
            first += 1
            if high[0] < first:
                high.popleft()
            if low[0] < first:
                low.popleft()
    reach[first:] = path.size - 1
    return reach


def _made(path: Array, runs: list[tuple[int, int]], window: float) -> Steps:
    """Steps from runs in order: neighbours less than the window's height apart are one dwell."""
    start, end = (np.array([run[side] for run in runs], dtype=np.int64) for side in (0, 1))
    level = np.array([path[a : b + 1].mean() for a, b in runs])
    moves = np.abs(np.diff(level)) > 2.0 * window
    return _gathered(path, start, end, moves, np.full(start.size, -1), ())


def _in_zones(path: Array, zones: tuple[SlowZone, ...]) -> Steps:
    are_zones = all(isinstance(zone, SlowZone) for zone in zones)
    if not are_zones or len({zone.winding for zone in zones}) != 1:
        raise InvalidInput(
            f"zones is {zones!r}: give one SlowZone or more, all of the same winding"
        )
    still = path - TWO_PI * zones[0].winding * np.arange(path.size)
    visits = []
    for i, zone in enumerate(zones):
        copy = np.floor((still - zone.arc[0]) / TWO_PI).astype(np.int64)
        place = still - TWO_PI * copy
        inside = place < zone.arc[1]
        deep = np.r_[0, np.cumsum((place >= zone.core[0]) & (place <= zone.core[1]))]
        # Runs in one copy of the arc, of which those that reach its core are kept.
        edges = np.flatnonzero(np.diff(2 * copy + inside)) + 1
        first = np.r_[0, edges]
        last = np.r_[edges, path.size] - 1
        kept = inside[first] & (deep[last + 1] > deep[first])
        index = np.full(first.size, i)
        visits.append(np.stack([first, last, copy[first], index])[:, kept])
    table = np.concatenate(visits, axis=1)
    start, end, copy, index = table[:, np.argsort(table[0], kind="stable")]
    return _gathered(still, start, end, (np.diff(copy) != 0) | (np.diff(index) != 0), index, zones)


def _gathered(
    path: Array, start: Whole, end: Whole, moves: Mask, zone: Whole, zones: tuple[SlowZone, ...]
) -> Steps:
    """Steps from visits, between which the path moves on to another dwell or not."""
    first = np.flatnonzero(np.append(True, moves)[: start.size])
    last = np.flatnonzero(np.append(moves, True)[: start.size])
    stays = [
        np.concatenate([path[start[v] : end[v] + 1] for v in range(a, b + 1)])
        for a, b in zip(first.tolist(), last.tolist(), strict=True)
    ]
    return Steps(
        start=start[first],
        end=end[last],
        levels=np.array([np.mean(stay) for stay in stays]),
        scatter=np.array([np.std(stay) for stay in stays]),
        visit_start=start,
        visit_end=end,
        visit_zone=zone,
        cycles=path.size - 1,
        climb=float(path[-1] - path[0]),
        zones=zones,
    )
