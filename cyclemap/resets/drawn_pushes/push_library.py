"""A library of pushes: what each does to the law of the orientation on each of several loops, and what it costs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import finite_array, non_negative_number, read_only, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.maps import CircleMap, Noise, WrappedNormal
from cyclemap.maps.mixtures.mixture_discretisation import mixture_discretisation
from cyclemap.maps.mixtures.random_map import RandomMap
from cyclemap.mechanics import SidePush
from cyclemap.resets.strategies.action_cost import strategy_cost
from cyclemap.resets.strategies.combined import combine
from cyclemap.resets.strategies.push_strategies import DrawnPushes
from cyclemap.resets.strategies.strategy import ResetStrategy
from cyclemap.resets.strategies.strategy_maps import DEFAULT_TOLERANCE, StrategyMaps, strategy_maps

Array = NDArray[np.float64]

DEFAULT_FRACTIONS = (0.15, 0.3, 0.5, 0.7, 0.85)
DEFAULT_NOISE = WrappedNormal(DEFAULT_SIGMA)
SEARCH_MODES = 64
# Even orientations at which drags are measured, and pushes tried.
ORIENTATIONS, _TRIED = 72, 8
# Of its distance, that a push must last in contact, unless told.
LEAST_SHARE = 0.5


@dataclass(frozen=True)
class LeftOutPush:
    """A push that is not in the library. loop : number of the loop that cannot make it. reason : in words."""

    push: SidePush
    loop: int
    reason: str


@dataclass(frozen=True, eq=False)
class PushLibrary:
    """P pushes on S loops (scenarios), each with the same `legs` behind it (None: the loop's own drag).

    random_maps : S rows of P: the cycle of one push, what the legs draw drawn with it, and the noise.
    drag_lengths : (S, P, K), m, the mean over the legs' law at K even orientations from 0 on.
    modes : Fourier modes that the search works with. pushes : (P). loops : (S), or none where the maps are given (see
    `of_maps`). left_out : pushes that were asked for and that not all loops can make.

    Raises InvalidInput where shapes do not agree.
    """

    pushes: tuple[SidePush, ...]
    random_maps: tuple[tuple[RandomMap, ...], ...]
    drag_lengths: Array
    modes: int = SEARCH_MODES
    legs: ResetStrategy | None = None
    loops: tuple[CollectionLoop, ...] = ()
    left_out: tuple[LeftOutPush, ...] = ()

    def __post_init__(self) -> None:
        whole_number("modes", self.modes, least=1)
        shape = (len(self.random_maps), len(self.pushes))
        if not min(shape) or any(len(row) != shape[1] for row in self.random_maps):
            raise InvalidInput(f"a library needs one random map for each of {shape[1]} pushes on each loop")
        if self.loops and len(self.loops) != shape[0]:
            raise InvalidInput(f"{len(self.loops)} loops need as many rows of maps, not {shape[0]}")
        lengths = finite_array("drag_lengths", self.drag_lengths, ndim=3)
        if lengths.shape[:2] != shape or not lengths.shape[2] or np.any(lengths < 0.0):
            raise InvalidInput(f"drag_lengths must be (loops, pushes, orientations), not negative, not {lengths.shape}")
        object.__setattr__(self, "drag_lengths", read_only(lengths))

    @classmethod
    def of_maps(
        cls, maps: Sequence[Sequence[CircleMap]], noise: Noise, drag_lengths: ArrayLike, modes: int = SEARCH_MODES
    ) -> PushLibrary:
        """The library of given maps, S rows of P, without mechanics.

        drag_lengths : (S, P), m, the same at every orientation, or (S, P, K). The pushes are stand-ins: sides 0, 1, ...

        >>> turns = [[CircleMap.rigid(0.1), CircleMap.rigid(0.4)]]
        >>> PushLibrary.of_maps(turns, WrappedNormal(0.1), [[0.1, 0.2]], modes=8).mean_drags.tolist()
        [[0.1, 0.2]]
        """
        lengths = finite_array("drag_lengths", drag_lengths)
        rows = tuple(tuple(RandomMap((one,), None, noise) for one in row) for row in maps)
        pushes = tuple(SidePush(side=number) for number in range(len(rows[0]) if rows else 0))
        return cls(pushes, rows, lengths[..., None] if lengths.ndim == 2 else lengths, modes)

    @property
    def scenarios(self) -> int:
        """S."""
        return len(self.random_maps)

    @property
    def noise(self) -> Noise:
        """Of every cycle."""
        return self.random_maps[0][0].noise

    @cached_property
    def matrices(self) -> Array:
        """(S, P, n, n): the operator of each push on n = 2·modes + 1 Fourier coefficients; 20 ms each, when asked."""
        rows = [[mixture_discretisation(one, self.modes).matrix for one in row] for row in self.random_maps]
        return read_only(rows)

    @property
    def mean_drags(self) -> Array:
        """(S, P): mean drag of each push over even orientations, m."""
        return np.asarray(self.drag_lengths.mean(axis=2))

    def strategy(self, numbers: Sequence[int], weights: Sequence[float]) -> ResetStrategy:
        """Return the drawn pushes with these numbers and weights (positive), combined with the legs."""
        drawn = DrawnPushes(tuple(self.pushes[i] for i in numbers), weights=tuple(weights))
        return drawn if self.legs is None else combine(drawn, self.legs)

    def random_map(self, scenario: int, numbers: Sequence[int], weights: Sequence[float]) -> RandomMap:
        """Return the cycle of the pushes with these numbers and weights on one loop, for its operator or samples."""
        share = np.asarray(weights, dtype=np.float64) / math.fsum(weights)
        parts = [self.random_maps[scenario][i] for i in numbers]
        joined = np.concatenate([w * part.weights for w, part in zip(share, parts, strict=True)])
        return RandomMap(sum((part.maps for part in parts), ()), joined / joined.sum(), self.noise)

    def reach(self, number: int) -> Array:
        """Return the radius (m) about the target that this push needs on each loop, (S,); see `strategy_cost`.

        The largest of runs from 12 even orientations and 8 nodes of the legs' law; kept once found.

        Raises InvalidInput where the library has no loops.
        """
        if not self.loops:
            raise InvalidInput("this library was made of maps: without loops nobody knows the room that a push needs")
        if number not in self._reaches:
            alone = self.strategy([number], [1.0])
            costs = [strategy_cost(loop, alone, orientations=12, nodes=8) for loop in self.loops]
            self._reaches[number] = read_only([cost.reach for cost in costs])
        return self._reaches[number]

    @cached_property
    def _reaches(self) -> dict[int, Array]:
        """What `reach` has found."""
        return {}

    def only(self, numbers: Sequence[int]) -> PushLibrary:
        """Return the library of the pushes with these numbers alone, in this order; InvalidInput for unknown ones."""
        kept = [whole_number("number of a push", i, least=0) for i in np.asarray(numbers).tolist()]
        if max(kept, default=0) >= len(self.pushes):
            raise InvalidInput(f"number of a push is {max(kept)}: the library has pushes 0 to {len(self.pushes) - 1}")
        return replace(
            self,
            pushes=tuple(self.pushes[i] for i in kept),
            random_maps=tuple(tuple(row[i] for i in kept) for row in self.random_maps),
            drag_lengths=self.drag_lengths[:, kept],
        )


def push_library(
    loops: CollectionLoop | Sequence[CollectionLoop],
    pushes: Sequence[SidePush] | None = None,
    *,
    sides: Sequence[int] | None = None,
    fractions: Sequence[float] = DEFAULT_FRACTIONS,
    angles: Sequence[float] = (0.0,),
    distances: Sequence[float] | None = None,
    legs: ResetStrategy | None = None,
    least_travel: float | None = None,
    noise: Noise = DEFAULT_NOISE,
    modes: int = SEARCH_MODES,
    tolerance: float = DEFAULT_TOLERANCE,
    nodes: int = 16,
    progress: Callable[[float], None] | None = None,
) -> PushLibrary:
    """Return the library of `pushes`, or of all pushes on a grid, on one loop or several (materials, footprints, ...).

    sides : None: all that every loop's outline has. fractions : of a side. angles : rad, from the inward normal.
    distances : m; None: that of the first loop's own push. legs : a strategy of the drag that all pushes share, such
    as a `TrailingLeg`; its law has `nodes` nodes for a full turn. noise : of a cycle; 1.1 degrees unless told.
    least_travel : m, that the rod must go in contact; None: half of the push's distance. modes : of the search;
    tolerance : of the maps, rad. progress : called with the fraction done.

    A push is left out, and named in `left_out`, where on any loop the mechanics refuse it or the rod loses the object
    sooner than that from one of eight orientations. Takes 0.3 to 2 s a push, loop and node.

    Raises InvalidInput for bad values, and where no push is left.

    >>> library = push_library(CollectionLoop.mit(), sides=(0, 2), fractions=(0.7,), modes=8, tolerance=1e-2)
    >>> library.matrices.shape, (1000 * library.mean_drags).round().tolist()
    ((1, 2, 17, 17), [[100.0, 73.0]])
    """
    given = (loops,) if isinstance(loops, CollectionLoop) else tuple(loops)
    if not given or not all(isinstance(loop, CollectionLoop) for loop in given):
        raise InvalidInput(f"loops must be one CollectionLoop or more, not {loops!r}")
    least = None if least_travel is None else non_negative_number("least_travel", least_travel)
    asked = _grid(given, sides, fractions, angles, distances) if pushes is None else _distinct(pushes)
    report, kept, columns, left_out = progress or (lambda fraction: None), [], [], []
    for number, push in enumerate(asked):
        found = _on_all(given, push, LEAST_SHARE * push.distance if least is None else least, legs, nodes, tolerance)
        if isinstance(found, LeftOutPush):
            left_out.append(found)
        else:
            kept.append(push)
            columns.append(found)
        report((number + 1) / len(asked))
    if not kept:
        raise InvalidInput(f"none of the {len(asked)} pushes can be made: {left_out[0].reason}")
    rows = tuple(tuple(RandomMap(c[s].maps, c[s].weights, noise) for c in columns) for s in range(len(given)))
    even = 2.0 * math.pi * np.arange(ORIENTATIONS) / ORIENTATIONS
    lengths = np.array([[c[s].mean_drag_length(even) for c in columns] for s in range(len(given))])
    return PushLibrary(tuple(kept), rows, lengths, modes, legs, given, tuple(left_out))


def _grid(
    loops: tuple[CollectionLoop, ...],
    sides: Sequence[int] | None,
    fractions: Sequence[float],
    angles: Sequence[float],
    distances: Sequence[float] | None,
) -> tuple[SidePush, ...]:
    every = range(min(loop.slider.outline.sides for loop in loops)) if sides is None else sides
    lengths = (loops[0].push.distance,) if distances is None else distances
    return _distinct([SidePush(*row) for row in product(every, fractions, angles, lengths)])


def _distinct(pushes: Sequence[SidePush]) -> tuple[SidePush, ...]:
    given = tuple(dict.fromkeys(pushes))
    if not given or not all(isinstance(push, SidePush) for push in given):
        raise InvalidInput(f"pushes must be one or more of SidePush, not {pushes!r}")
    return given


def _on_all(
    loops: tuple[CollectionLoop, ...],
    push: SidePush,
    least: float,
    legs: ResetStrategy | None,
    nodes: int,
    tolerance: float,
) -> list[StrategyMaps] | LeftOutPush:
    """The maps of the push on every loop, or why it is left out."""
    strategy: ResetStrategy = DrawnPushes((push,)) if legs is None else combine(DrawnPushes((push,)), legs)
    found = []
    for number, loop in enumerate(loops):
        try:
            travel = _least_travel(strategy.prepared(loop), push)
            if travel < least:
                return LeftOutPush(push, number, f"the rod loses the object after {1000.0 * travel:.1f} mm")
            found.append(strategy_maps(loop, strategy, nodes=nodes, tolerance=tolerance))
        except CycleMapError as error:
            return LeftOutPush(push, number, str(error))
    return found


def _least_travel(loop: CollectionLoop, push: SidePush) -> float:
    """The shortest travel in contact (m) over even orientations."""
    starts = (2.0 * math.pi * np.arange(_TRIED) / _TRIED).tolist()
    return min(loop.model.push(loop.start_pose(start), push).travel for start in starts)
