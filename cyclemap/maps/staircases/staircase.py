"""Staircases: noisy paths of the lifted orientation, under one map or one that wears."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, finite_number, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.lift_checks import Scalar
from cyclemap.maps.noise.local_noise import LocalNoise
from cyclemap.maps.noise.noise import Noise
from cyclemap.maps.staircases.drifting_map import DriftingMap, Stretch
from cyclemap.maps.staircases.slow_zones import SlowZone, StaircaseSummary, predict_staircase

__all__ = [
    "SlowZone",
    "Staircase",
    "StaircaseSummary",
    "predict_staircase",
    "sample_staircase",
    "sample_staircases",
]

_CHUNK = 65_536  # cycles followed at a time
_DRAWS = 1 << 18  # noise draws made at a time for many paths


@dataclass(frozen=True, eq=False)
class Staircase:
    """One path θ_{n+1} = F(θ_n) + ξ_n of the lifted orientation.

    theta : shape (cycles + 1,), radians, not wrapped, the start first; seed : of the noise; start : radians.
    """

    theta: Array
    seed: int
    start: float

    @property
    def cycles(self) -> int:
        """Number of cycles."""
        return int(self.theta.size - 1)

    @property
    def mean_turn(self) -> float:
        """(θ_N - θ_0)/N, radians a cycle."""
        return float((self.theta[-1] - self.theta[0]) / self.cycles)


def sample_staircase(
    circle_map: CircleMap | DriftingMap,
    noise: Noise | LocalNoise | None,
    cycles: int,
    start: float = 0.0,
    seed: int = 0,
) -> Staircase:
    """A path of ``cycles`` cycles from ``start`` (radians); ``noise`` None follows the map alone.

    A ``DriftingMap`` takes cycle n by its map F_n. The same seed gives the same path. Some million cycles a
    second for sampled and textbook maps, about half that where two of them are blended, a few hundred thousand
    for maps given by numpy callables. Kicks of a ``LocalNoise`` have the size that it has where the cycle starts.

    >>> path = sample_staircase(CircleMap.rigid(0.25), None, 4)
    >>> (path.theta / np.pi).round(6).tolist()
    [0.0, 0.5, 1.0, 1.5, 2.0]
    """
    count = whole_number("cycles", cycles, least=1)
    theta = begin = finite_number("start", start)
    rng = np.random.default_rng(whole_number("seed", seed, least=0))
    _check(circle_map, noise)
    if isinstance(noise, LocalNoise):
        path = sample_staircases(circle_map, noise, count, [theta], seed)[0]
        return Staircase(path, seed, begin)
    path = np.empty(count + 1)
    path[0] = theta
    for at in range(0, count, _CHUNK):
        size = min(_CHUNK, count - at)
        kicks = np.zeros(size) if noise is None else noise.sample(rng, size)
        for part in _stretches(circle_map, at, at + size):
            visited = _followed(part, theta, kicks[part.first - at : part.last - at].tolist())
            path[part.first + 1 : part.last + 1] = visited
            theta = visited[-1]
    return Staircase(read_only(path), seed, begin)


def sample_staircases(
    circle_map: CircleMap | DriftingMap, noise: Noise | LocalNoise | None, cycles: int, starts: Any, seed: int = 0
) -> Array:
    """Many independent paths at once, one a start: shape (paths, cycles + 1), radians, not wrapped, read-only.

    starts : shape (paths,), radians. The same seed and starts give the same paths; one start alone gives the
    path of ``sample_staircase`` to rounding. All paths go through the lift together: ten million cycles a second
    and more for a hundred paths of a textbook map.

    >>> sample_staircases(CircleMap.rigid(0.5), None, 2, [0.0, np.pi]).shape
    (2, 3)
    """
    count = whole_number("cycles", cycles, least=1)
    begin = finite_array("starts", starts, ndim=1)
    rng = np.random.default_rng(whole_number("seed", seed, least=0))
    _check(circle_map, noise)
    if begin.size == 0:
        raise InvalidInput("starts is empty: give one angle a path")
    paths = np.empty((begin.size, count + 1))
    paths[:, 0] = theta = begin
    block = max(1, min(count, _DRAWS // begin.size))
    kicks = np.zeros((0, begin.size))
    for at in range(0, count, block):
        size = min(block, count - at)
        kicks = _kicks(noise, rng, (size, begin.size), kicks[-1] if at else None)
        visited = np.empty((size, begin.size))
        for part in _stretches(circle_map, at, at + size):
            for n in range(part.first, part.last):
                kick = kicks[n - at]
                theta = _image(part, n, theta) + (noise.sigma(theta) * kick if isinstance(noise, LocalNoise) else kick)
                visited[n - at] = theta
        paths[:, at + 1 : at + 1 + size] = visited.T
    paths.setflags(write=False)
    return paths


def _kicks(
    noise: Noise | LocalNoise | None, rng: np.random.Generator, shape: tuple[int, int], before: Array | None
) -> Array:
    """The kicks of the next cycles (cycles, paths); of a local noise in its own σ, `before` being those of the last."""
    if noise is None:
        return np.zeros(shape)
    return noise.units(rng, shape, before) if isinstance(noise, LocalNoise) else noise.sample(rng, shape)


def _check(circle_map: CircleMap | DriftingMap, noise: Noise | LocalNoise | None) -> None:
    if not isinstance(circle_map, CircleMap | DriftingMap):
        raise InvalidInput(f"the map is {circle_map!r}: give a CircleMap or a DriftingMap")
    if noise is not None and not isinstance(noise, Noise | LocalNoise):
        raise InvalidInput(f"the noise is {noise!r}: give a noise, for example WrappedNormal(0.02), or None")


def _stretches(circle_map: CircleMap | DriftingMap, first: int, last: int) -> Iterator[Stretch]:
    if isinstance(circle_map, DriftingMap):
        yield from circle_map.stretches(first, last)
    else:
        yield Stretch(first, last, circle_map, circle_map, np.empty(0))


def _followed(part: Stretch, theta: float, kicks: list[float]) -> list[float]:
    """The angles after each kick, through one map or the blend of two."""
    if part.before is part.after:
        return _through_one(part.before.scalar(), theta, kicks)
    before, after, visited = part.before.scalar(), part.after.scalar(), []
    for share, kick in zip(part.share.tolist(), kicks, strict=True):
        image = before(theta)
        theta = image + share * (after(theta) - image) + kick
        visited.append(theta)
    return visited


def _through_one(lift: Scalar, theta: float, kicks: list[float]) -> list[float]:
    visited = []
    for kick in kicks:
        theta = lift(theta) + kick
        visited.append(theta)
    return visited


def _image(part: Stretch, cycle: int, theta: Array) -> Array:
    if part.before is part.after:
        return part.before(theta)
    image = part.before(theta)
    return np.asarray(image + part.share[cycle - part.first] * (part.after(theta) - image))
