"""Circle maps that change from cycle to cycle (wear), and the staircase that slow change predicts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import finite_array, finite_number, positive_number, read_only, whole_number
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise import Noise
from cyclemap.maps.operator.transfer_operator import TransferOperator, transfer_operator
from cyclemap.maps.staircases.slow_zones import StaircaseSummary, predict_staircase

MAX_KNOTS = 4_096
_PIECES = 8  # stretches into which a family's run is cut before any test
_PANELS = 12  # at most so many first panels when the mean turn is summed over a run
_GRID = TWO_PI * (np.arange(512) + 0.382) / 512


@dataclass(frozen=True, eq=False)
class Stretch:
    """Cycles first, ..., last - 1, in which F_n = (1 - share) before + share after; ``share`` has one entry a cycle."""

    first: int
    last: int
    before: CircleMap
    after: CircleMap
    share: Array


@dataclass(frozen=True, eq=False)
class DriftingMap:
    """A map that changes with the cycle: cycle n (0, 1, ...) carries θ_n to F_n(θ_n) + ξ_n.

    F_n is given at some cycles and blended linearly between them, F_n = (1 - s) F_a + s F_b, s = (n - a)/(b - a): a
    lift again, since the degrees agree. Before the first of these cycles F_n is the first map, after the last the last.

    cycles : shape (k,), increasing. maps : the k maps, all of degree 1.
    max_error : radians, how far the blend is from the family it stands for, as measured; 0 for a blend as such.

    Raises InvalidInput for cycles that do not increase, another number of maps, or a degree other than 1.

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
            raise InvalidInput(f"cycles is {knots.tolist()}: give one cycle or more, each above the one before")
        if len(self.maps) != knots.size:
            raise InvalidInput(f"{len(self.maps)} maps for {knots.size} cycles: give one map a cycle")
        for given in self.maps:
            if not isinstance(given, CircleMap) or given.degree != 1:
                raise InvalidInput(f"one of the maps is {given!r}: a path drifts under CircleMaps of degree 1")
        object.__setattr__(self, "cycles", read_only(knots))

    @classmethod
    def between(cls, knots: Sequence[tuple[float, CircleMap]]) -> DriftingMap:
        """The linear blend of maps given as (cycle, map) pairs, in order of the cycles."""
        if not len(knots) or any(len(pair) != 2 for pair in knots):
            raise InvalidInput("knots must be a list of pairs (cycle, map), at least one")
        return cls(np.array([pair[0] for pair in knots], dtype=float), tuple(pair[1] for pair in knots))

    @classmethod
    def of_family(
        cls, family: Callable[[Any], CircleMap], schedule: Any, cycles: int, tolerance: float = 1e-6
    ) -> DriftingMap:
        """F_n = family(p(n)) for the cycles 0 to ``cycles`` - 1, as a blend between cycles chosen to fit.

        family : parameter to CircleMap. schedule : callable n → parameter, or an array with one entry (or row) a
        cycle. A stretch of cycles is halved until the blend of its ends lies within ``tolerance`` (radians, at
        512 angles) of the family at its quarter points, or until it has no cycle inside, where the blend is
        exact: a schedule that jumps costs nothing. ``max_error`` is the largest difference that was accepted;
        measured, so a schedule that moves only between the quarter points of a long stretch can escape it.

        Raises ConvergenceError when 4096 maps do not reach the tolerance: the message carries what they reach.

        >>> worn = DriftingMap.of_family(lambda omega: CircleMap.arnold(omega, 0.9), lambda n: 0.1 + 1e-5 * n, 1000)
        >>> worn.cycles.size < 12, worn.max_error < 1e-12
        (True, True)
        """
        count = whole_number("cycles", cycles, least=1)
        at = _scheduled(family, schedule, count)
        knots, error = _fitted(at, count - 1, positive_number("tolerance", tolerance))
        return cls(np.array(sorted(knots), dtype=float), tuple(knots[n] for n in sorted(knots)), error)

    def at(self, cycle: float) -> CircleMap:
        """The map frozen at ``cycle`` (any real number)."""
        now = finite_number("cycle", cycle)
        after = int(np.searchsorted(self.cycles, now, side="left"))
        if after == self.cycles.size:
            return self.maps[-1]
        if after == 0 or self.cycles[after] == now:
            return self.maps[after]
        a, b = self.cycles[after - 1], self.cycles[after]
        return _blended(self.maps[after - 1], self.maps[after], float((now - a) / (b - a)))

    def stretches(self, first: int, last: int) -> Iterator[Stretch]:
        """The cycles first, ..., last - 1 in stretches between neighbouring maps, in order."""
        inner = np.ceil(self.cycles[(self.cycles > first) & (self.cycles < last)]).astype(int)
        bounds = np.unique(np.concatenate([[first], inner, [last]]))
        for low, high in zip(bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
            after = min(int(np.searchsorted(self.cycles, low, side="right")), self.cycles.size - 1)
            before = max(after - 1, 0) if low < self.cycles[after] else after
            a, width = self.cycles[before], self.cycles[after] - self.cycles[before] if after > before else 1.0
            share = np.clip((np.arange(low, high) - a) / width, 0.0, 1.0)
            yield Stretch(low, high, self.maps[before], self.maps[after], share)


# -- families as blends -----------------------------------------------------------------------------------------


def _scheduled(family: Callable[[Any], CircleMap], schedule: Any, count: int) -> Callable[[int], CircleMap]:
    if not callable(family):
        raise InvalidInput(f"family is {family!r}: give a callable that turns a parameter into a CircleMap")
    if callable(schedule):
        return lambda n: family(schedule(n))
    values = finite_array("schedule", schedule)
    if values.ndim == 0 or values.shape[0] < count:
        raise InvalidInput(f"schedule has shape {values.shape}: it needs one entry for each of {count} cycles")
    return lambda n: family(values[n])


def _fitted(at: Callable[[int], CircleMap], last: int, tolerance: float) -> tuple[dict[int, CircleMap], float]:
    """The maps at the chosen cycles, and the largest difference that was accepted."""
    ends = np.unique(np.linspace(0, last, _PIECES + 1).astype(int)).tolist()
    knots, worst, waiting = {n: at(n) for n in ends}, 0.0, list(pairwise(ends))
    while waiting:
        a, b = waiting.pop()
        tried = {n: at(n) for n in {(3 * a + b) // 4, (a + b) // 2, (a + 3 * b) // 4} - {a, b}}
        found = [_distance(knots[a], knots[b], (n - a) / (b - a), truth) for n, truth in tried.items()]
        error = max(found, default=0.0)
        if error <= tolerance:
            worst = max(worst, error)
        elif len(knots) >= MAX_KNOTS:
            raise ConvergenceError(f"{MAX_KNOTS} maps still leave {error:.3g} rad: raise tolerance above {tolerance:g}")
        else:
            middle = (a + b) // 2
            knots[middle] = tried[middle]
            waiting += [(a, middle), (middle, b)]
    return knots, worst


def _distance(before: CircleMap, after: CircleMap, share: float, truth: CircleMap) -> float:
    blend = (1.0 - share) * before(_GRID) + share * after(_GRID)
    return float(np.max(np.abs(blend - truth(_GRID))))


def _blended(before: CircleMap, after: CircleMap, share: float) -> CircleMap:
    one, other, rest = before.scalar(), after.scalar(), 1.0 - share
    return CircleMap.with_scalar(
        lambda theta: rest * before(theta) + share * after(theta),
        lambda theta: rest * before.derivative(theta) + share * after.derivative(theta),
        lambda theta: rest * one(theta) + share * other(theta),
        breaks=np.union1d(before.breaks, after.breaks),
        max_error=rest * before.max_error + share * after.max_error,
    ).remade_by(_blended, before, after, share)


# -- the staircase of slow wear ---------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class DriftSummary:
    """The staircase of a slowly drifting map, as if each cycle's map had been there for ever.

    cycles : shape (k,), where the frozen map was analysed; summaries : one ``StaircaseSummary`` each.
    turns : whole turns expected over the run, Σ_n ρ_n, an Estimate whose bound covers the sum, not the lag.
    lag_turns : Σ |ρ_{n+1} - ρ_n| × (cycles in which the law forgets), over the chosen cycles: the size, not a bound,
        of what the adiabatic picture leaves out. Trust ``turns`` no better than that.
    """

    cycles: Array
    summaries: tuple[StaircaseSummary, ...]
    turns: Estimate
    lag_turns: float

    @property
    def mean_turn(self) -> Array:
        """Shape (k,), radians a cycle."""
        return np.array([one.mean_turn for one in self.summaries])

    @property
    def mean_residence_cycles(self) -> Array:
        """Shape (k,), cycles; nan where the frozen map has no slow zone."""
        return np.array([_or_nan(one.mean_residence_cycles) for one in self.summaries])

    @property
    def step(self) -> Array:
        """Shape (k,), radians; nan where the frozen map has no slow zone."""
        return np.array([_or_nan(one.step) for one in self.summaries])

    @property
    def steps(self) -> float | None:
        """Steps expected over the run, ``turns`` × 2π/step; None where the step changes or there is none."""
        height = self.step
        return None if not np.ptp(height) <= 1e-9 else float(self.turns * TWO_PI / height[0])


def predict_drift(
    drifting: DriftingMap, noise: Noise, cycles: int, points: int = 5, tolerance: float = 1e-2
) -> DriftSummary:
    """The adiabatic (quasi-static) staircase of a run of ``cycles`` cycles under slow wear.

    At ``points`` cycles, evenly spread from the first to the last, ``predict_staircase`` of the frozen map; and the
    expected climb Σ_n ρ_n, ρ_n the frozen map's rotation number, by adaptive Simpson rules over the run until
    halving changes the sum by less than ``tolerance`` turns, that change being the bound (measured). The
    law follows a drifting map with a lag of its relaxation time (Gardiner, Stochastic Methods, 2009, ch. 8):
    ``lag_turns`` tells how much that may matter, and the start's own approach adds up to a turn.

    >>> from cyclemap.maps.noise.noise import WrappedNormal
    >>> worn = DriftingMap.between([(0, CircleMap.rigid(0.1)), (99, CircleMap.rigid(0.3))])
    >>> round(predict_drift(worn, WrappedNormal(1.0), 100, points=2).turns, 9)
    20.0
    """
    if not isinstance(drifting, DriftingMap):
        raise InvalidInput(f"the map is {drifting!r}: give a DriftingMap, or use predict_staircase for a fixed map")
    count, many = whole_number("cycles", cycles, least=2), whole_number("points", points, least=2)
    chosen = np.linspace(0.0, count - 1.0, many)
    operators = [transfer_operator(drifting.at(n), noise) for n in chosen]
    summaries = tuple(predict_staircase(one.map, noise, one) for one in operators)
    turns = _summed(lambda n: _winding(transfer_operator(drifting.at(n), noise)), drifting, count, tolerance)
    return DriftSummary(read_only(chosen), summaries, turns, _lag(operators))


def _winding(operator: TransferOperator) -> float:
    """The rotation number without its bound, which costs several times as much."""
    theta, weight = operator.discretisation.rule()
    return float((weight * operator.density(theta)) @ operator.map.turn(theta)) / TWO_PI


def _lag(operators: list[TransferOperator]) -> float:
    rho = np.array([one.rotation_number for one in operators])
    forgetting = np.array([1.0 / one.spectral_gap if one.spectral_gap > 0.0 else np.inf for one in operators])
    change = np.abs(np.diff(rho))
    return float(np.sum(change * np.maximum(forgetting[:-1], forgetting[1:]))) if np.any(change) else 0.0


def _or_nan(value: float | None) -> float:
    return np.nan if value is None else float(value)


def _summed(rho: Callable[[float], float], drifting: DriftingMap, count: int, tolerance: float) -> Estimate:
    """Σ_{n<count} ρ(n) as the integral from -½ to count - ½ (midpoint rule read backwards), by Simpson's rule."""
    low, high = -0.5, count - 0.5
    inner = drifting.cycles[(drifting.cycles > low) & (drifting.cycles < high)]
    edges = np.concatenate([[low], inner, [high]]) if inner.size < _PANELS else np.linspace(low, high, _PANELS + 1)
    allowed = positive_number("tolerance", tolerance) / count
    panels = [_simpson(rho, a, b, (rho(a), rho(0.5 * (a + b)), rho(b)), allowed, 0) for a, b in pairwise(edges)]
    return Estimate(float(sum(p[0] for p in panels)), float(sum(p[1] for p in panels)))


def _simpson(
    rho: Callable[[float], float], a: float, b: float, at: tuple[float, float, float], allowed: float, depth: int
) -> tuple[float, float]:
    """The integral over [a, b] and how much the last halving changed it; ``at``: values at a, the middle and b."""
    middle, width = 0.5 * (a + b), b - a
    left, right = rho(0.5 * (a + middle)), rho(0.5 * (middle + b))
    once = width / 6.0 * (at[0] + 4.0 * at[1] + at[2])
    twice = width / 12.0 * (at[0] + 4.0 * left + 2.0 * at[1] + 4.0 * right + at[2])
    if abs(twice - once) <= allowed * width or depth >= 12:
        return twice, abs(twice - once)
    first = _simpson(rho, a, middle, (at[0], left, at[1]), allowed, depth + 1)
    second = _simpson(rho, middle, b, (at[1], right, at[2]), allowed, depth + 1)
    return first[0] + second[0], first[1] + second[1]
