"""Staircases: noisy paths of the lifted orientation, under one map or one that wears."""

from __future__ import annotations

import math
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
    positive_number,
    read_only,
    require_room,
    whole_number,
)
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise import Noise

MAX_KNOTS = 4_096
_PIECES = 8  # stretches into which a family's run is cut before any test
_GRID = TWO_PI * (np.arange(512) + 0.382) / 512
_CHUNK = 65_536  # cycles followed at a time
_DRAWS = 1 << 18  # noise draws made at a time for many paths


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
        For cycles that do not increase, another number of maps, or a degree other than 1.

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
        if len(self.maps) != knots.size:
            raise InvalidInput(
                f"{len(self.maps)} maps for {knots.size} cycles: give one map a cycle"
            )
        for given in self.maps:
            if not isinstance(given, CircleMap) or given.degree != 1:
                raise InvalidInput(
                    f"one of the maps is {given!r}: a path drifts under CircleMaps of degree 1"
                )
        object.__setattr__(self, "cycles", read_only(knots))

    @classmethod
    def between(cls, knots: Sequence[tuple[float, CircleMap]]) -> DriftingMap:
        """The linear blend of maps given as (cycle, map) pairs, in order of the cycles."""
        if not len(knots) or any(len(pair) != 2 for pair in knots):
            raise InvalidInput("knots must be a list of pairs (cycle, map), at least one")
        return cls(
            np.array([pair[0] for pair in knots], dtype=float), tuple(pair[1] for pair in knots)
        )

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
        given = schedule
        if not callable(given):
            values = finite_array("schedule", given)
            if values.ndim == 0 or values.shape[0] < count:
                raise InvalidInput(
                    f"schedule has shape {values.shape}: it needs one entry for each of {count} "
                    "cycles"
                )
            given = values.__getitem__
        return _fitted(
            lambda n: family(given(n)), count - 1, positive_number("tolerance", tolerance)
        )

    def at(self, cycle: float) -> CircleMap:
        """The map frozen at ``cycle`` (any real number)."""
        now = float(np.clip(finite_number("cycle", cycle), self.cycles[0], self.cycles[-1]))
        after = int(np.searchsorted(self.cycles, now))
        if self.cycles[after] == now:
            return self.maps[after]
        a, b = self.cycles[after - 1 : after + 1].tolist()
        return _blended(self.maps[after - 1], self.maps[after], (now - a) / (b - a))

    def images(self, theta: Array, cycle: Array) -> Array:
        """F_n(θ) of angles (..., k) in the whole cycles n (k,): (..., k), radians, on the lift of
        ``theta``.
        """
        images = np.empty_like(theta)
        for part in self.stretches(int(cycle.min()), int(cycle.max()) + 1):
            here = (cycle >= part.first) & (cycle < part.last)
            images[..., here] = part.images(theta[..., here], cycle[here].astype(np.int64))
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


def _blended(before: CircleMap, after: CircleMap, share: float) -> CircleMap:
    rest = 1.0 - share
    breaks = np.union1d(before.breaks, after.breaks)
    error = rest * before.max_error + share * after.max_error
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
    ).remade_by(_blended, before, after, share)


@dataclass(frozen=True)
class LocalNoise:
    """Kicks ξ_n = σ(θ_n) z_n of sampled paths; z_n standard normal, with z_{n+1} = ρ z_n + √(1 -
    ρ²) ε_n.

    Parameters
    ----------
    log_sigma : tuple of float
        c_0, a_1, b_1, ...: log σ(θ) = c_0 + Σ a_k cos kθ + b_k sin kθ, σ in radians; an odd
        count of numbers.
    correlation : float, default 0.0
        ρ in [0, 1), of the kicks of successive cycles.

    Raises
    ------
    InvalidInput
        For an even number of coefficients, or a correlation outside [0, 1).

    Notes
    -----
    It has no transfer operator: with a memory the angle alone is no state. `white` is what
    stands for it there.

    Examples
    --------
    >>> import math
    >>> from cyclemap.maps import LocalNoise
    >>> noise = LocalNoise((math.log(0.02), 0.5, 0.0), 0.7)
    >>> round(float(noise.sigma(math.pi / 2)), 12)
    0.02
    """

    log_sigma: tuple[float, ...]
    correlation: float = 0.0

    def __post_init__(self) -> None:
        coefficients = finite_array("log_sigma", self.log_sigma, ndim=1)
        if coefficients.size % 2 == 0:
            raise InvalidInput(
                f"log_sigma has {coefficients.size} coefficients: a constant and pairs of cos "
                "and sin"
            )
        if not 0.0 <= finite_number("correlation", self.correlation) < 1.0:
            raise InvalidInput(
                f"the correlation of successive kicks is {self.correlation:g}: it must lie in "
                "[0, 1)"
            )
        object.__setattr__(self, "log_sigma", tuple(coefficients.tolist()))

    def sigma(self, theta: Array | float) -> Array:
        """Return σ (...) at angles θ (...), radians."""
        c = np.array(self.log_sigma)
        order = np.arange(1, c.size // 2 + 1)
        angle = np.multiply.outer(theta, order)
        return np.asarray(np.exp(c[0] + np.cos(angle) @ c[1::2] + np.sin(angle) @ c[2::2]))

    def white(self, theta: float) -> float:
        """Return σ of the white noise that carries an angle about θ as far over many cycles,
        radians.

        The sum of n kicks has the variance n σ² (1 + ρ)/(1 - ρ), less a constant.
        """
        return float(self.sigma(theta)) * math.sqrt(
            (1.0 + self.correlation) / (1.0 - self.correlation)
        )

    def units(
        self, rng: np.random.Generator, shape: tuple[int, int], before: Array | None = None
    ) -> Array:
        """Return z, shape (cycles, paths), of the next cycles; before : (paths,), that of the last
        one.
        """
        rho = self.correlation
        fresh = rng.standard_normal(shape)
        z = np.empty_like(fresh)
        last = rng.standard_normal(shape[1]) if before is None else before
        for n in range(shape[0]):
            last = z[n] = rho * last + math.sqrt(1.0 - rho**2) * fresh[n]
        return z


@dataclass(frozen=True, eq=False)
class Staircase:
    """One path θ_{n+1} = F(θ_n) + ξ_n of the lifted orientation.

    Attributes
    ----------
    theta : ndarray, shape (cycles + 1,)
        Radians, not wrapped, the start first.
    seed : int
        Of the noise.
    start : float
        Radians.

    Examples
    --------
    >>> from cyclemap import CircleMap, sample_staircase
    >>> path = sample_staircase(CircleMap.rigid(0.25), None, 4, start=1.0)
    >>> path.cycles, path.start, path.theta.shape
    (4, 1.0, (5,))
    """

    theta: Array
    seed: int
    start: float

    @property
    def cycles(self) -> int:
        """Number of cycles."""
        return int(self.theta.size - 1)


def sample_staircase(
    circle_map: CircleMap | DriftingMap,
    noise: Noise | LocalNoise | None,
    cycles: int,
    start: float = 0.0,
    seed: int = 0,
) -> Staircase:
    """Sample one noisy path of a map.

    Parameters
    ----------
    circle_map : CircleMap or DriftingMap
        The map; a ``DriftingMap`` takes cycle n by its map F_n.
    noise : Noise or LocalNoise or None
        Added after every cycle; None follows the map alone. Kicks of a ``LocalNoise`` have the
        size that it has where the cycle starts.
    cycles : int
        How many cycles.
    start : float, default 0.0
        Radians.
    seed : int, default 0
        The same seed gives the same path.

    Returns
    -------
    Staircase
        The path, on the lift.

    Notes
    -----
    Some million cycles a second for sampled and textbook maps, a few hundred thousand for maps
    given by numpy callables.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CircleMap, sample_staircase
    >>> path = sample_staircase(CircleMap.rigid(0.25), None, 4)
    >>> (path.theta / np.pi).round(6).tolist()
    [0.0, 0.5, 1.0, 1.5, 2.0]
    """
    count = whole_number("cycles", cycles, least=1)
    begin = finite_number("start", start)
    if isinstance(noise, LocalNoise):
        path = sample_staircases(circle_map, noise, count, [begin], seed)[0]
        return Staircase(path, seed, begin)
    rng = _generator(circle_map, noise, seed)
    require_room("the path", count, "give fewer cycles")
    path = np.empty(count + 1)
    path[0] = begin
    for at in range(0, count, _CHUNK):
        kicks = _kicks(noise, rng, min(_CHUNK, count - at))
        for part in _stretches(circle_map, at, at + kicks.size):
            given = kicks[part.first - at : part.last - at].tolist()
            path[part.first + 1 : part.last + 1] = part.path(float(path[part.first]), given)
    return Staircase(read_only(path), seed, begin)


def sample_staircases(
    circle_map: CircleMap | DriftingMap,
    noise: Noise | LocalNoise | None,
    cycles: int,
    starts: ArrayLike,
    seed: int = 0,
) -> Array:
    """Sample many independent noisy paths of a map at once.

    Parameters
    ----------
    circle_map : CircleMap or DriftingMap
        As of ``sample_staircase``.
    noise : Noise or LocalNoise or None
        As of ``sample_staircase``.
    cycles : int
        How many cycles.
    starts : array_like, shape (paths,)
        Radians, one a path.
    seed : int, default 0
        The same seed and starts give the same paths; one start alone gives the path of
        ``sample_staircase`` to rounding, and a hundred paths are followed ten times as fast
        together.

    Returns
    -------
    ndarray, shape (paths, cycles + 1)
        Radians, not wrapped, read-only, the starts first.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import CircleMap, sample_staircases
    >>> sample_staircases(CircleMap.rigid(0.5), None, 2, [0.0, np.pi]).shape
    (2, 3)
    """
    count = whole_number("cycles", cycles, least=1)
    begin = finite_array("starts", starts, ndim=1)
    rng = _generator(circle_map, noise, seed)
    if begin.size == 0:
        raise InvalidInput("starts is empty: give one angle a path")
    require_room("the paths", begin.size * count, "give fewer cycles or starts")
    paths = np.empty((count + 1, begin.size))
    paths[0] = begin
    block = max(1, min(count, _DRAWS // begin.size))
    kicks = None
    for at in range(0, count, block):
        size = min(block, count - at), begin.size
        if isinstance(noise, LocalNoise):  # in its own σ, each like the one before
            kicks = noise.units(rng, size, None if kicks is None else kicks[-1])
        else:
            kicks = _kicks(noise, rng, size)
        for part in _stretches(circle_map, at, at + size[0]):
            for n in range(part.first, part.last):
                scale = noise.sigma(paths[n]) if isinstance(noise, LocalNoise) else 1.0
                paths[n + 1] = part.images(paths[n], n) + scale * kicks[n - at]
    return read_only(paths.T)


def _generator(
    circle_map: CircleMap | DriftingMap, noise: Noise | LocalNoise | None, seed: int
) -> np.random.Generator:
    """The random numbers of a path, once it is sure that it can be followed."""
    if not isinstance(circle_map, CircleMap | DriftingMap):
        raise InvalidInput(f"the map is {circle_map!r}: give a CircleMap or a DriftingMap")
    if noise is not None and not isinstance(noise, Noise | LocalNoise):
        raise InvalidInput(
            f"the noise is {noise!r}: give a noise, for example WrappedNormal(0.02), or None"
        )
    return np.random.default_rng(whole_number("seed", seed, least=0))


def _kicks(noise: Noise | None, rng: np.random.Generator, size: int | tuple[int, int]) -> Array:
    return np.zeros(size) if noise is None else noise.sample(rng, size)


def _stretches(circle_map: CircleMap | DriftingMap, first: int, last: int) -> Iterator[Stretch]:
    if isinstance(circle_map, DriftingMap):
        return circle_map.stretches(first, last)
    return iter([Stretch(first, last, circle_map, circle_map, np.empty(0))])
