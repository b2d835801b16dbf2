"""Staircases: noisy paths of the lifted orientation, under one map or one that wears."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array
from cyclemap.checks import finite_array, finite_number, read_only, require_room, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise import Noise, require_noise
from cyclemap.maps.staircases.drifting_map import DriftingMap, Stretch

_CHUNK = 65_536  # cycles followed at a time
_DRAWS = 1 << 18  # noise draws made at a time for many paths


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
        for stretch in _stretches(circle_map, at, at + kicks.size):
            given = kicks[stretch.first - at : stretch.last - at].tolist()
            path[stretch.first + 1 : stretch.last + 1] = stretch.path(
                float(path[stretch.first]), given
            )
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
        for stretch in _stretches(circle_map, at, at + size[0]):
            for n in range(stretch.first, stretch.last):
                scale = noise.sigma(paths[n]) if isinstance(noise, LocalNoise) else 1.0
                paths[n + 1] = stretch.images(paths[n], n) + scale * kicks[n - at]
    return read_only(paths.T)


def _generator(
    circle_map: CircleMap | DriftingMap, noise: Noise | LocalNoise | None, seed: int
) -> np.random.Generator:
    """The random numbers of a path, once it is sure that it can be followed."""
    if not isinstance(circle_map, CircleMap | DriftingMap):
        raise InvalidInput(f"the map is {circle_map!r}: give a CircleMap or a DriftingMap")
    if noise is not None and not isinstance(noise, LocalNoise):
        require_noise(noise)
    return np.random.default_rng(whole_number("seed", seed, least=0))


def _kicks(noise: Noise | None, rng: np.random.Generator, size: int | tuple[int, int]) -> Array:
    return np.zeros(size) if noise is None else noise.sample(rng, size)


def _stretches(circle_map: CircleMap | DriftingMap, first: int, last: int) -> Iterator[Stretch]:
    if isinstance(circle_map, DriftingMap):
        return circle_map.stretches(first, last)
    return iter([Stretch(first, last, circle_map, circle_map, np.empty(0))])
