"""Maps that change with the cycle, as a surface wears, and what theory says of their staircase."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, Whole
from cyclemap.checks import (
    finite_array,
    finite_number,
    non_negative_number,
    positive_number,
    read_only,
    require_room,
    whole_number,
)
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import EPS, Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise import Noise
from cyclemap.maps.operator.transfer_operator import TransferOperator, transfer_operator
from cyclemap.maps.staircases.slow_zones import StaircaseSummary, predict_staircase
from cyclemap.one_thread import one_thread

MAX_KNOTS = 4_096
_PIECES = 8  # stretches into which a family's run is cut before any test
_GRID = TWO_PI * (np.arange(512) + 0.382) / 512


@dataclass(frozen=True, eq=False)
class Stretch:
    """Cycles first, ..., last - 1, in which F_n = (1 - share) before + share after; ``share`` has
    one entry a cycle.
    """

    first: int
    last: int
    before: CircleMap
    after: CircleMap
    share: Array

    def images(self, theta: Array, cycle: Whole | int) -> Array:
        """F_n(θ) in cycles n of the stretch, one or as many as ``theta`` has columns."""
        before = self.before(theta)
        if self.before is self.after:
            return before
        return before + self.share[cycle - self.first] * (self.after(theta) - before)

    def path(self, theta: float, kicks: list[float]) -> list[float]:
        """The angles to which ``theta`` is carried with these kicks, one a cycle."""
        visited = []
        before = self.before.scalar()
        if self.before is self.after:
            for kick in kicks:
                theta = before(theta) + kick
                visited.append(theta)
            return visited
        after = self.after.scalar()
        for share, kick in zip(self.share.tolist(), kicks, strict=True):
            image = before(theta)
            theta = image + share * (after(theta) - image) + kick
            visited.append(theta)
        return visited


@dataclass(frozen=True, eq=False)
class DriftingMap:
    """A map that changes with the cycle: cycle n (0, 1, ...) carries θ_n to F_n(θ_n) + ξ_n.

    Parameters
    ----------
    cycles : array_like, shape (k,)
        Increasing.
    maps : tuple of CircleMap
        k maps, all of degree 1.
    max_error : float, default 0.0
        Radians, how far the blend is from the family it stands for, as measured; 0 for a blend
        as such.

    Raises
    ------
    InvalidInput
        For cycles that do not increase, another number of maps, a degree other than 1, or an error
        below 0.

    Notes
    -----
    F_n is given at some cycles and blended linearly between them, F_n = (1 - s) F_a + s F_b, s
    = (n - a)/(b - a): a lift again, since the degrees agree. Before the first of these cycles
    F_n is the first map, after the last the last.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CircleMap, DriftingMap
    >>> worn = DriftingMap.between([(0, CircleMap.rigid(0.1)), (100, CircleMap.rigid(0.3))])
    >>> round(float(worn.at(50).turn(0.0)) / (2 * np.pi), 12)
    0.2
    """

    cycles: Array
    maps: tuple[CircleMap, ...]
    max_error: float = 0.0

    def __post_init__(self) -> None:
        knots = finite_array("cycles", self.cycles, ndim=1)
        if knots.size == 0 or np.any(np.diff(knots) <= 0.0):
            raise InvalidInput(
                f"cycles is {knots.tolist()}: give one cycle or more, each above the one before"
            )
        try:
            maps = tuple(self.maps)
        except TypeError as cause:
            raise InvalidInput(f"maps is {self.maps!r}: give a tuple of CircleMaps") from cause
        if len(maps) != knots.size:
            raise InvalidInput(f"{len(maps)} maps for {knots.size} cycles: give one map a cycle")
        for given in maps:
            if not isinstance(given, CircleMap) or given.degree != 1:
                raise InvalidInput(
                    f"one of the maps is {given!r}: a path drifts under CircleMaps of degree 1"
                )
        object.__setattr__(self, "cycles", read_only(knots))
        object.__setattr__(self, "maps", maps)
        object.__setattr__(self, "max_error", non_negative_number("max_error", self.max_error))

    @classmethod
    def between(cls, knots: Sequence[tuple[float, CircleMap]]) -> DriftingMap:
        """The linear blend of maps given as (cycle, map) pairs, in order of the cycles."""
        try:
            cycles, maps = zip(*((cycle, given) for cycle, given in knots), strict=True)
        except (TypeError, ValueError) as cause:
            raise InvalidInput(
                f"knots is {knots!r}: give a list of pairs (cycle, map), at least one"
            ) from cause
        return cls(finite_array("cycles", cycles, ndim=1), maps)

    @classmethod
    def of_family(
        cls,
        family: Callable[[Any], CircleMap],
        schedule: Callable[[int], Any] | ArrayLike,
        cycles: int,
        tolerance: float = 1e-6,
    ) -> DriftingMap:
        """F_n = family(p(n)) for the cycles 0 to ``cycles`` - 1, as a blend between cycles chosen
        to fit.

        Parameters
        ----------
        family : callable
            Parameter → CircleMap.
        schedule : callable or array_like
            n → parameter, or an array with one entry (or row) a cycle.
        cycles : int
            How many cycles.
        tolerance : float, default 1e-6
            Radians, at 512 angles: a stretch of cycles is halved until the blend of its ends
            lies within it of the family at its quarter points, or has no cycle inside: a
            schedule that jumps costs nothing.

        Returns
        -------
        DriftingMap
            Its ``max_error`` is the largest difference that was accepted; what moves only
            between the quarter points of a long stretch can escape it.

        Raises
        ------
        ConvergenceError
            When 4096 maps do not reach the tolerance: the message carries what they reach.

        Examples
        --------
        >>> from cyclemap import CircleMap, DriftingMap
        >>> def family(omega):
        ...     return CircleMap.arnold(omega, 0.9)
        >>> worn = DriftingMap.of_family(family, lambda n: 0.1 + 1e-5 * n, 1000)
        >>> worn.cycles.size < 12, worn.max_error < 1e-12
        (True, True)
        """
        count = whole_number("cycles", cycles, least=1)
        if not callable(family):
            raise InvalidInput(
                f"family is {family!r}: give a callable that turns a parameter into a CircleMap"
            )
        parameter_at = schedule
        if not callable(parameter_at):
            values = finite_array("schedule", parameter_at)
            if values.ndim == 0 or values.shape[0] < count:
                raise InvalidInput(
                    f"schedule has shape {values.shape}: it needs one entry for each of {count} "
                    "cycles"
                )
            parameter_at = values.__getitem__
        accepted = positive_number("tolerance", tolerance)
        return _fitted(lambda n: family(parameter_at(n)), count - 1, accepted)

    def at(self, cycle: float) -> CircleMap:
        """The map frozen at ``cycle`` (any real number); between the maps that are given,
        ``max_error`` is added to theirs.
        """
        now = float(np.clip(finite_number("cycle", cycle), self.cycles[0], self.cycles[-1]))
        after = int(np.searchsorted(self.cycles, now))
        if self.cycles[after] == now:
            return self.maps[after]
        a, b = self.cycles[after - 1 : after + 1].tolist()
        share = (now - a) / (b - a)
        return _blended(self.maps[after - 1], self.maps[after], share, self.max_error)

    def images(self, theta: Array, cycle: Array) -> Array:
        """F_n(θ) of angles (..., k) in the whole cycles n (k,): (..., k), radians, on the lift of
        ``theta``.
        """
        images = np.empty_like(theta)
        for stretch in self.stretches(int(cycle.min()), int(cycle.max()) + 1):
            here = (cycle >= stretch.first) & (cycle < stretch.last)
            images[..., here] = stretch.images(theta[..., here], cycle[here].astype(np.int64))
        return images

    def stretches(self, first: int, last: int) -> Iterator[Stretch]:
        """The cycles first, ..., last - 1 in stretches between neighbouring maps, in order."""
        inner = np.ceil(self.cycles[(self.cycles > first) & (self.cycles < last)]).astype(int)
        bounds = np.unique([first, *inner, last]).tolist()
        for low, high in pairwise(bounds):
            after = min(int(np.searchsorted(self.cycles, low, side="right")), self.cycles.size - 1)
            before = max(after - 1, 0) if low < self.cycles[after] else after
            ends = self.cycles[[before, after]]
            share = np.interp(np.arange(low, high), ends, [0.0, 1.0])
            yield Stretch(low, high, self.maps[before], self.maps[after], share)


def _fitted(at: Callable[[int], CircleMap], last: int, tolerance: float) -> DriftingMap:
    """The blend of the maps at chosen cycles; ``max_error``: the largest difference that was
    accepted.
    """
    ends = np.unique(np.linspace(0, last, _PIECES + 1).astype(int)).tolist()
    knots = {n: at(n) for n in ends}
    worst = 0.0
    waiting = list(pairwise(ends))
    while waiting:
        a, b = waiting.pop()
        tried = {n: at(n) for n in {(3 * a + b) // 4, (a + b) // 2, (a + 3 * b) // 4} - {a, b}}
        before = knots[a](_GRID)
        change = knots[b](_GRID) - before
        error = 0.0
        for n, truth in tried.items():
            blend = before + (n - a) / (b - a) * change
            error = max(error, float(np.max(np.abs(blend - truth(_GRID)))))
        if error <= tolerance:
            worst = max(worst, error)
        elif len(knots) >= MAX_KNOTS:
            raise ConvergenceError(
                f"{MAX_KNOTS} maps still leave {error:.3g} rad: raise tolerance above {tolerance:g}"
            )
        else:
            middle = (a + b) // 2
            knots[middle] = tried[middle]
            waiting += [(a, middle), (middle, b)]
    order = sorted(knots)
    return DriftingMap(np.array(order, dtype=float), tuple(knots[n] for n in order), worst)


def _blended(before: CircleMap, after: CircleMap, share: float, off: float) -> CircleMap:
    rest = 1.0 - share
    breaks = np.union1d(before.breaks, after.breaks)
    error = rest * before.max_error + share * after.max_error + off
    if before.pieces is not None and after.pieces is not None:
        cubics = before.pieces.blended(after.pieces, share)
        return CircleMap.from_pieces(cubics, breaks, before.samples + after.samples, error)
    first = before.scalar()
    last = after.scalar()
    return CircleMap.with_scalar(
        lambda theta: rest * before(theta) + share * after(theta),
        lambda theta: rest * before.derivative(theta) + share * after.derivative(theta),
        lambda theta: rest * first(theta) + share * last(theta),
        breaks=breaks,
        max_error=error,
    ).remade_by(_blended, before, after, share, off)


_TOLERANCE = 1e-2  # turns
_SUMMED = 200  # cycles up to which windings are added up: no dearer than to integrate
_NODES = 21  # of the quadrature, a panel
_KINKS = 12  # knots of a blend, at which its winding bends, up to which each is an end of a panel


@dataclass(frozen=True, eq=False)
class DriftSummary:
    """The staircase of a slowly drifting map, as if each cycle's map had been there for ever.

    Attributes
    ----------
    cycles : ndarray, shape (k,)
        Where the frozen map was analysed.
    summaries : tuple of StaircaseSummary
        What theory says of each frozen map.
    turns : Estimate
        Whole turns expected over the run, Σ_n ρ_n, an Estimate whose bound covers the sum, not
        the lag.
    lag_turns : float
        Σ |ρ_{n+1} - ρ_n| × (cycles in which the law forgets), over the chosen cycles: the size,
        not a bound, of what the adiabatic picture leaves out. Trust ``turns`` no better than
        that.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, DriftingMap, WrappedNormal, predict_drift
    >>> worn = DriftingMap.between([(0, CircleMap.rigid(0.1)), (99, CircleMap.rigid(0.3))])
    >>> drift = predict_drift(worn, WrappedNormal(1.0), 100, points=2)
    >>> drift.cycles.tolist(), [round(summary.mean_turn, 4) for summary in drift.summaries]
    ([0.0, 99.0], [0.6283, 1.885])
    """

    cycles: Array
    summaries: tuple[StaircaseSummary, ...]
    turns: Estimate
    lag_turns: float

    @property
    def steps(self) -> float | None:
        """Steps expected over the run, ``turns`` × 2π/step; None where the step changes or there is
        none.
        """
        height = np.array([summary.step for summary in self.summaries], dtype=np.float64)
        return None if not np.ptp(height) <= 1e-9 else float(self.turns * TWO_PI / height[0])


@one_thread
def predict_drift(
    drifting: DriftingMap, noise: Noise, cycles: int, points: int = 5
) -> DriftSummary:
    """The adiabatic (quasi-static) staircase of a run under slow wear.

    Parameters
    ----------
    drifting : DriftingMap
        The map at every cycle.
    noise : Noise
        Added after it.
    cycles : int
        Cycles of the run.
    points : int, default 5
        At how many cycles, evenly spread from the first to the last, the frozen map is
        analysed.

    Returns
    -------
    DriftSummary
        The staircases of the frozen maps, and the expected climb.

    Notes
    -----
    At each of these cycles, ``predict_staircase`` of the frozen map; and the expected climb Σ_n
    ρ_n, ρ_n the frozen map's rotation number. Up to 200 cycles, and where the wear goes to and fro
    so fast that quadrature would be dearer, it is added up, and so are the bounds of ρ_n. Else it
    is integrated by adaptive quadrature over the run to a hundredth of a turn; the bound is its
    estimate of its error, and what the sum may differ from the integral by, from how much the slope
    of ρ_n changes over the run (measured). The law lags behind a drifting map (Gardiner, Stochastic
    Methods, 2009, ch. 8): ``lag_turns`` tells how much that may matter, and the start's own
    approach adds up to a turn.

    References
    ----------
    Gardiner, C. (2009), Stochastic methods, chapter 8.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, DriftingMap, WrappedNormal, predict_drift
    >>> worn = DriftingMap.between([(0, CircleMap.rigid(0.1)), (99, CircleMap.rigid(0.3))])
    >>> round(predict_drift(worn, WrappedNormal(1.0), 100, points=2).turns, 9)
    20.0
    """
    if not isinstance(drifting, DriftingMap):
        raise InvalidInput(
            f"the map is {drifting!r}: give a DriftingMap, or use predict_staircase for a fixed map"
        )
    count = whole_number("cycles", cycles, least=2)
    require_room("the run", count, "give fewer cycles")
    many = whole_number("points", points, least=2)
    require_room("the frozen maps", many, "give fewer points")
    chosen = np.linspace(0.0, count - 1.0, many)
    operators = [transfer_operator(drifting.at(n), noise) for n in chosen]
    return DriftSummary(
        read_only(chosen),
        tuple(predict_staircase(operator.map, noise, operator) for operator in operators),
        _expected_turns(drifting, noise, chosen),
        _lag(operators),
    )


def _expected_turns(drifting: DriftingMap, noise: Noise, chosen: Array) -> Estimate:
    """The sum of the winding over the cycles 0 to the last of those chosen.

    Cycle by cycle where they are few, or else as the integral from -½ to half a cycle beyond
    (midpoint rule read backwards).
    """
    count = round(chosen[-1]) + 1
    if count <= _SUMMED:
        return _added_turns(drifting, noise, count)
    from scipy.integrate import quad_vec  # slow to import

    def winding(n: float) -> float:
        """The rotation number without its bound, which costs several times as much."""
        operator = transfer_operator(drifting.at(n), noise)
        theta, weight = operator.discretisation.rule
        return float((weight * operator.density(theta)) @ operator.map.turn(theta)) / TWO_PI

    ends = -0.5, chosen[-1] + 0.5
    inner = drifting.cycles[(drifting.cycles > ends[0]) & (drifting.cycles < ends[1])]
    kinks = inner if inner.size < _KINKS else ()
    panels = count // _NODES
    turns, off = quad_vec(winding, *ends, epsabs=_TOLERANCE, epsrel=0.0, points=kinks, limit=panels)
    if not off <= _TOLERANCE:
        return _added_turns(drifting, noise, count)
    # The midpoint rule is off by an eighth of how much the slope changes, or less.
    places = np.union1d(chosen, inner)
    slopes = np.diff([winding(n) for n in places.tolist()]) / np.diff(places)
    off += float(np.max(np.abs(slopes)) + np.sum(np.abs(np.diff(slopes)))) / 8.0
    return Estimate(turns, off)


def _added_turns(drifting: DriftingMap, noise: Noise, count: int) -> Estimate:
    """The windings of the frozen maps of so many cycles, added up with their bounds."""
    turns = 0.0
    off = 0.0
    known: dict[CircleMap, Estimate] = {}
    for n in range(count):
        frozen = drifting.at(n)
        if frozen not in known:
            known = {frozen: transfer_operator(frozen, noise).rotation_number}
        turns += known[frozen]
        off += known[frozen].error_bound + EPS * abs(turns)
    return Estimate(turns, off)


def _lag(operators: Sequence[TransferOperator]) -> float:
    """Σ |change of the winding| over the smaller gap, of neighbouring operators."""
    lag = 0.0
    for before, after in pairwise(operators):
        change = abs(after.rotation_number - before.rotation_number)
        gap = min(before.spectral_gap, after.spectral_gap)
        if change > 0.0:
            lag += change / gap if gap > 0.0 else float("inf")
    return lag
