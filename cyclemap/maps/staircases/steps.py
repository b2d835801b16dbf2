"""Steps in a path: where it dwells, how long, how high it climbs in between; and all that beside
what theory predicts.
"""

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
from cyclemap.maps.staircases.slow_zones import SlowZone, StaircaseSummary
from cyclemap.written import ANGLE, CYCLES

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


_FEWEST_PERIODS = 8  # periods below which the number of steps is not tested


@dataclass(frozen=True)
class VisitComparison:
    """Visits to one slow zone, measured and predicted; numbers of cycles, None where too little was
    seen or predicted.

    Attributes
    ----------
    zone : SlowZone
        The zone.
    exits : int
        Visits whose end was seen.
    mean, standard_error : float or None
        Measured mean length of a visit. For a zone that is escaped from ("stable", "jump") the
        exposure (cycles seen inside, censored visits and the one that the path begins in too)
        over the exits, the maximum-likelihood value of an exponential law, its error
        mean/√exits; for a ghost the Kaplan-Meier mean.
    spread : float or None
        Measured standard deviation of the complete visits.
    predicted : float or None
        The zone's ``visit_cycles``.
    ratio : float or None
        mean/predicted.
    mean_p_value : float or None
        Two-sided, of so few or so many exits in that exposure if visits are independent with
        the predicted mean and spread: a renewal process of gamma-distributed visits, mid-p
        value. Over some 15 visits it is measured to reject a true prediction at the 5 % level
        in 3.5 % of runs (a ghost) and in 6.3 % (a stable point).
    """

    zone: SlowZone
    exits: int
    mean: float | None = field(metadata=CYCLES)
    standard_error: float | None = field(metadata=CYCLES)
    spread: float | None
    predicted: float | None = field(metadata=CYCLES)
    ratio: float | None
    mean_p_value: float | None = field(metadata={"name": "p_value"})


@dataclass(frozen=True)
class StepComparison:
    """Measured steps against a ``StaircaseSummary``; see ``compare_steps``.

    Attributes
    ----------
    steps : int
        How many steps the path has.
    mean_length, length_error : float or None
        Kaplan-Meier mean of the dwells' lengths, cycles, and its standard error; None where no
        comparison is possible, as of all below.
    predicted_length : float or None
        The prediction's mean residence, cycles.
    ratio : float or None
        ``mean_length`` over ``predicted_length``.
    net_steps, expected_steps, net_error : float or None
        Climb of the path in units of the predicted step, the prediction's for as many cycles,
        and the standard error of their difference: from one dwell to the next, height less
        predicted turn is a reward of mean 0, so the difference has their variance times the
        number of periods (Ross 1996, sec. 3.6).
    pace_p_value : float or None
        Two-sided, Student's law for that difference over its error; None below 8 periods. Over
        12 to 18 periods it is measured to reject a true prediction in 3.5 % of runs at the 5 %
        level, in 8 % at 10 %.
    visits : tuple of VisitComparison
        One ``VisitComparison`` a zone; () unless the steps were found in the prediction's own
        zones.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, WrappedNormal, compare_steps, find_steps
    >>> from cyclemap.maps import predict_staircase, sample_staircase
    >>> sine, noise = CircleMap.arnold(0.15, 0.9), WrappedNormal(0.05)
    >>> expected = predict_staircase(sine, noise)
    >>> path = sample_staircase(sine, noise, 2_000)
    >>> found = compare_steps(find_steps(path.theta, zones=expected.zones), expected)
    >>> found.steps > 30, abs(found.ratio - 1.0) < 0.1
    (True, True)
    """

    steps: int
    mean_length: float | None
    length_error: float | None
    predicted_length: float | None
    ratio: float | None
    net_steps: float | None = field(metadata={"name": "steps"})
    expected_steps: float | None
    net_error: float | None
    pace_p_value: float | None
    visits: tuple[VisitComparison, ...]


def compare_steps(steps: Steps, prediction: StaircaseSummary) -> StepComparison:
    """Compare the steps found in a path with those predicted for a map and its noise.

    Parameters
    ----------
    steps : Steps
        Those found in a path.
    prediction : StaircaseSummary
        What was predicted for the map and its noise.

    Returns
    -------
    StepComparison
        Lengths, pace and visits, side by side.

    Raises
    ------
    InvalidInput
        Unless given ``Steps`` and a ``StaircaseSummary``.

    Notes
    -----
    Dwells found without zones have lengths that depend on the window: their ratio to the
    predicted residence is a rough one, without p-value. Heights, pace and number of steps do
    not depend on it. Steps found with ``zones=prediction.zones`` also compare the visits, whose
    prediction is exact for the stationary path, with p-values that are uniform if it holds (as
    far as the path forgets between visits).

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, WrappedNormal, compare_steps, find_steps
    >>> from cyclemap.maps import predict_staircase, sample_staircase
    >>> sine, noise = CircleMap.arnold(0.15, 0.9), WrappedNormal(0.05)
    >>> expected = predict_staircase(sine, noise)
    >>> path = sample_staircase(sine, noise, 20_000)
    >>> found = compare_steps(find_steps(path.theta, zones=expected.zones), expected)
    >>> abs(found.visits[0].ratio - 1) < 0.02, found.visits[0].mean_p_value > 0.001
    (True, True)
    """
    if not isinstance(steps, Steps) or not isinstance(prediction, StaircaseSummary):
        raise InvalidInput(
            "give Steps (find_steps) and a StaircaseSummary (predict_staircase), in this order"
        )
    length, length_error = kaplan_meier_mean(steps.lengths, steps.censored)
    net, expected, error, pace = _pace(steps, prediction)
    zones = steps.zones if steps.zones == prediction.zones else ()
    return StepComparison(
        steps=steps.count,
        mean_length=length,
        length_error=length_error,
        predicted_length=prediction.mean_residence_cycles,
        ratio=_ratio(length, prediction.mean_residence_cycles),
        net_steps=net,
        expected_steps=expected,
        net_error=error,
        pace_p_value=pace,
        visits=tuple(_compared(steps, index, zone) for index, zone in enumerate(zones)),
    )


def _pace(
    steps: Steps, prediction: StaircaseSummary
) -> tuple[float | None, float | None, float | None, float | None]:
    """Net steps, those expected, the standard error of their difference, and its p-value."""
    if prediction.step is None:
        return None, None, None, None
    turn = prediction.mean_turn - TWO_PI * (steps.zones[0].winding if steps.zones else 0)
    net = steps.climb / prediction.step
    expected = turn * steps.cycles / prediction.step
    if steps.count < 2:
        return net, expected, None, None
    periods = np.diff(steps.start)
    surplus = steps.heights - turn * periods
    between = steps.cycles * float(np.mean(surplus**2) / np.mean(periods))
    within = 2.0 * float(np.mean(steps.scatter**2))
    error = float(np.sqrt(between + within) / prediction.step)
    if error == 0.0 or steps.count < _FEWEST_PERIODS:
        return net, expected, error, None
    from scipy.special import stdtr  # slow to import, as below

    return net, expected, error, float(2.0 * stdtr(steps.count - 1, -abs(net - expected) / error))


def kaplan_meier_mean(lengths: Array | Whole, censored: Mask) -> tuple[float | None, float | None]:
    """Mean and standard error of lengths of which some are only known to be at least so long.

    lengths, censored : shape (n,), none below 0. The integral of the product-limit survival
        function (Kaplan & Meier 1958) up to the longest length, with Greenwood's (1926) variance.
        Where the longest is censored the mean is too small. (None, None) where every length is
        censored; the error is None for one alone.
    """
    if np.all(censored):
        return None, None
    times, where = np.unique(lengths, return_inverse=True)
    ended = np.bincount(where, weights=~censored)
    at_risk = lengths.size - np.searchsorted(np.sort(lengths), times)
    alive = np.cumprod(1.0 - ended / at_risk)
    pieces = np.diff(np.r_[0.0, times]) * np.r_[1.0, alive[:-1]]
    beyond = np.sum(pieces) - np.cumsum(pieces)
    left = at_risk - ended
    terms = np.where(left > 0, beyond**2 * ended / (at_risk * np.maximum(left, 1.0)), 0.0)
    return float(np.sum(pieces)), float(np.sqrt(np.sum(terms))) if lengths.size > 1 else None


def _ratio(measured: float | None, predicted: float | None) -> float | None:
    return (
        None
        if measured is None or predicted is None or not predicted > 0.0
        else float(measured / predicted)
    )


def _compared(steps: Steps, index: int, zone: SlowZone) -> VisitComparison:
    """One zone: the visit that the path begins in is of unknown age, which only an exponential law
    forgives.
    """
    escaped = zone.kind != "ghost"
    mine = (steps.visit_zone == index) & (escaped | (steps.visit_start > 0))
    lengths = (steps.visit_end - steps.visit_start + 1)[mine].astype(float)
    closed = steps.visit_end[mine] < steps.cycles
    exits = int(np.sum(closed))
    exposure = float(np.sum(lengths))
    mean, error = (exposure / exits, exposure / exits**1.5) if escaped and exits else (None, None)
    if not escaped:
        mean, error = kaplan_meier_mean(lengths, ~closed)
    return VisitComparison(
        zone=zone,
        exits=exits,
        mean=mean,
        standard_error=error,
        spread=float(np.std(lengths[closed], ddof=1)) if exits > 1 else None,
        predicted=zone.visit_cycles,
        ratio=_ratio(mean, zone.visit_cycles),
        mean_p_value=_exits_p_value(exits, exposure, zone),
    )


def _exits_p_value(exits: int, exposure: float, zone: SlowZone) -> float | None:
    """P(at least so many exits) = P(that many visits take less than the exposure), with
    gamma-distributed sums, to both sides.
    """
    expected = zone.visit_cycles
    spread = zone.visit_spread
    if expected is None or not spread or not np.isfinite(expected) or exposure == 0.0:
        return None
    from scipy.special import gammainc

    shape = (expected / spread) ** 2
    scale = spread * (spread / expected)
    as_many = float(gammainc(shape * exits, exposure / scale)) if exits else 1.0
    middle = 0.5 * (as_many + float(gammainc(shape * (exits + 1), exposure / scale)))
    return min(1.0, 2.0 * min(middle, 1.0 - middle))
