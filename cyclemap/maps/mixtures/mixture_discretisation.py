"""One cycle of a random map as a matrix on trigonometric polynomials: the weighted mean of its maps' matrices."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from cyclemap.errors import InvalidInput
from cyclemap.maps.arcs import Array
from cyclemap.maps.mixtures.random_map import RandomMap
from cyclemap.maps.noise.noise_law import UniformNoise
from cyclemap.maps.operator.fourier_discretisation import (
    Block,
    FourierDiscretisation,
    Waves,
    needed_modes,
    waves,
)

_ENTRIES = 2_000_000  # nodes times basis functions that are kept or handled at a time


@dataclass(frozen=True, eq=False)
class MixtureDiscretisation(FourierDiscretisation):
    """``FourierDiscretisation`` of a ``RandomMap``, made by ``mixture_discretisation``; ``map`` is its mean map.

    The integral over θ is one over θ and the drawn map: the nodes of ``rule`` are those of every map in turn, with
    weights times w_i, and F at a node is the map that owns it. All that the base class does with its nodes then
    holds for the mixture: one cycle, its transpose, residuals, conditional means given θ and the drawn map.

    owner : the map of each node, (nodes,).
    """

    random_map: RandomMap = field(kw_only=True)

    @cached_property
    def parts(self) -> tuple[tuple[float, FourierDiscretisation], ...]:
        """(w_i, the discretisation of map i) of every map that is drawn at all."""
        drawn = zip(self.random_map.weights.tolist(), self.random_map.maps, strict=True)
        return tuple(
            (weight, FourierDiscretisation(part, self.noise, self.modes, self.finer))
            for weight, part in drawn
            if weight > 0.0
        )

    @cached_property
    def _rule(self) -> tuple[Array, Array]:
        rules = [(weight, *part.rule()) for weight, part in self.parts]
        theta = np.concatenate([nodes for _, nodes, _ in rules])
        return theta, np.concatenate([share * weight for share, _, weight in rules])

    def images(self) -> Array:
        """F_i(θ) at the nodes of ``rule``, i the map that owns the node: (nodes,), radians, lifted."""
        return np.concatenate([part.map(part.rule()[0]) for _, part in self.parts])

    def refined(self) -> MixtureDiscretisation:
        """The same with every mode that the noise lets through and twice as many nodes: for residuals."""
        modes = max(self.modes, needed_modes(self.noise))
        return MixtureDiscretisation(self.map, self.noise, modes, 2 * self.finer, random_map=self.random_map)

    def map_response(self, law: Any, tangent: Callable[[Array], Array], break_shifts: Array) -> Any:
        """Refused: InvalidInput. Which of the maps moves is not said; use the response of one map's operator."""
        raise InvalidInput("a mixture has no map response of its own: give each map's, times its weight")

    def _blocks(self) -> Iterable[Block]:
        return self._kept_blocks if self._rule[0].size * self.size <= _ENTRIES else self._streamed()

    @property
    def _before(self) -> Iterable[Waves]:
        return ((part, before) for part, before, _ in self._blocks())

    @property
    def _after(self) -> Iterable[Waves]:
        return ((part, after) for part, _, after in self._blocks())

    @cached_property
    def _kept_blocks(self) -> list[Block]:
        return list(self._streamed())

    def _streamed(self) -> Iterator[Block]:
        """Blocks of nodes that belong to one map each; waves of θ are made once for maps on the same nodes."""
        at, known, before = 0, np.empty(0), np.empty((0, 0))
        step = max(64, _ENTRIES // self.size)
        for _, part in self.parts:
            nodes, _ = part.rule()
            for begin in range(0, nodes.size, step):
                theta = nodes[begin : begin + step]
                if not np.array_equal(theta, known):
                    known, before = theta, waves(theta, self.modes)
                yield slice(at, at + theta.size), before, waves(part.map(theta), self.modes)
                at += theta.size


def mixture_discretisation(random_map: RandomMap, modes: int | None = None) -> MixtureDiscretisation:
    """A basis of all the modes that the noise lets through, or of ``modes``; InvalidInput for uniform noise alone.

    >>> from cyclemap.maps.lifts.circle_map import CircleMap
    >>> from cyclemap.maps.noise.noise_law import WrappedNormal
    >>> turned = RandomMap((CircleMap.rigid(0.0), CircleMap.rigid(0.5)), None, WrappedNormal(1.0))
    >>> bool(np.max(np.abs(mixture_discretisation(turned, 3).matrix[[1, 3], [1, 3]])) < 1e-16)
    True
    """
    if isinstance(random_map.noise, UniformNoise):
        raise InvalidInput(
            f"the noise is {random_map.noise!r}: a mixture is resolved in Fourier modes, which it does not damp; "
            "add a narrow smooth noise, IndependentSum((WrappedNormal(0.01), UniformNoise(...)))"
        )
    kept = needed_modes(random_map.noise) if modes is None else modes
    return MixtureDiscretisation(random_map.mean_map, random_map.noise, kept, random_map=random_map)
