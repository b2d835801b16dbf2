"""A random circle map: in each cycle one of several maps is drawn with given weights, then noise is added."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from cyclemap.checks import finite_array, read_only, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import Array
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.noise.noise_law import Noise

_MASS = 1e-9  # weights may miss 1 by that much: they are rescaled
_DRAWS = 1 << 18  # noise draws made at a time


@dataclass(frozen=True, eq=False)
class RandomMap:
    """θ' = F_i(θ) + ξ, i drawn anew in each cycle with probability w_i, independently of ξ and of all before.

    maps : one CircleMap or more, all of one degree. weights : shape (maps,), ≥ 0, sum 1; None for equal ones.
    noise : the law of ξ, the same whichever map is drawn.
    Raises InvalidInput for anything else.

    >>> from cyclemap.maps.noise.noise_law import WrappedNormal
    >>> drawn = RandomMap((CircleMap.rigid(0.1), CircleMap.rigid(0.3)), (0.5, 0.5), WrappedNormal(0.1))
    >>> round(float(drawn.mean_map.turn(0.0)) / (2 * np.pi), 12)
    0.2
    """

    maps: tuple[CircleMap, ...]
    weights: Any
    noise: Noise

    def __post_init__(self) -> None:
        object.__setattr__(self, "maps", checked_maps(self.maps))
        object.__setattr__(self, "weights", checked_weights(self.weights, len(self.maps)))
        if not isinstance(self.noise, Noise):
            raise InvalidInput(f"the noise is {self.noise!r}: a random map needs some, for example WrappedNormal(0.02)")

    @cached_property
    def mean_map(self) -> CircleMap:
        """θ → Σ w_i F_i(θ), a lift of the same degree; its ``max_error`` is the largest of the maps'."""
        if len(self.maps) == 1:
            return self.maps[0]
        return _mean_of(self.maps, self.weights)


def _mean_of(maps: tuple[CircleMap, ...], weights: Array) -> CircleMap:
    return CircleMap(
        lambda theta: np.asarray(sum(w * part(theta) for w, part in zip(weights, maps, strict=True))),
        lambda theta: np.asarray(sum(w * part.derivative(theta) for w, part in zip(weights, maps, strict=True))),
        np.concatenate([part.breaks for part in maps]),
        maps[0].degree,
        max_error=max(part.max_error for part in maps),
    ).remade_by(_mean_of, maps, weights)


def checked_maps(maps: Any) -> tuple[CircleMap, ...]:
    """``maps`` as a tuple of one CircleMap or more of one degree, or InvalidInput."""
    found = (maps,) if isinstance(maps, CircleMap) else tuple(maps) if isinstance(maps, Sequence) else ()
    wrong = [part for part in found if not isinstance(part, CircleMap)]
    if not found or wrong:
        raise InvalidInput(f"maps is {maps!r}: give one CircleMap or more")
    degrees = {part.degree for part in found}
    if len(degrees) > 1:
        raise InvalidInput(f"the maps have degrees {sorted(degrees)}: give maps of one degree")
    return found


def checked_weights(weights: Any, count: int) -> Array:
    """Probabilities (count,), rescaled to a sum of exactly 1; None gives equal ones; else InvalidInput."""
    if weights is None:
        return read_only(np.full(count, 1.0 / count))
    given = finite_array("weights", weights, ndim=1)
    if given.size != count:
        raise InvalidInput(f"weights has {given.size} entries for {count} maps: give one a map")
    if np.any(given < 0.0) or abs(float(np.sum(given)) - 1.0) > _MASS:
        raise InvalidInput(f"weights is {given.tolist()}: give probabilities, none below 0, that add up to 1")
    return read_only(given / np.sum(given))


def sample_random_paths(random_map: RandomMap, cycles: int, starts: Any, seed: int = 0) -> Array:
    """Independent paths, one a start: shape (paths, cycles + 1), radians, not wrapped, the starts first, read-only.

    starts : shape (paths,), radians. The same seed and starts give the same paths. Each cycle evaluates every map
    on the paths that drew it only.

    >>> from cyclemap.maps.noise.noise_law import WrappedNormal
    >>> drawn = RandomMap((CircleMap.rigid(0.1), CircleMap.rigid(0.3)), None, WrappedNormal(0.1))
    >>> sample_random_paths(drawn, 5, np.zeros(3)).shape
    (3, 6)
    """
    if not isinstance(random_map, RandomMap):
        raise InvalidInput(f"the random map is {random_map!r}: give a RandomMap")
    count, begin = whole_number("cycles", cycles, least=1), finite_array("starts", starts, ndim=1)
    if begin.size == 0:
        raise InvalidInput("starts is empty: give one angle a path")
    rng = np.random.default_rng(whole_number("seed", seed, least=0))
    paths = np.empty((count + 1, begin.size))
    paths[0] = begin
    block = max(1, min(count, _DRAWS // begin.size))
    for at in range(0, count, block):
        size = (min(block, count - at), begin.size)
        kicks = random_map.noise.sample(rng, size)
        chosen = rng.choice(len(random_map.maps), p=random_map.weights, size=size)
        for n in range(size[0]):
            paths[at + n + 1] = _drawn_image(random_map.maps, chosen[n], paths[at + n]) + kicks[n]
    found = np.ascontiguousarray(paths.T)
    found.setflags(write=False)
    return found


def _drawn_image(maps: tuple[CircleMap, ...], chosen: Any, theta: Array) -> Array:
    if len(maps) == 1:
        return maps[0](theta)
    image = np.empty_like(theta)
    for i, part in enumerate(maps):
        use = chosen == i
        image[use] = part(theta[use])
    return image
