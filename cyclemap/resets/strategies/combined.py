"""Several strategies at once: way-points one after the other, turns added, the push of the one that brings one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import reduce
from itertools import product

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.push_strategies import AlternatingPushes
from cyclemap.resets.strategies.schedules import BLOCKS, INDEPENDENT, SEQUENCE, GoldenAngle
from cyclemap.resets.strategies.strategy import (
    DEFAULT_NODES,
    PERIODIC,
    ActionLaw,
    DrawnStrategy,
    ResetStrategy,
    Seed,
    checked_size,
    products_of_rows,
)

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Combined:
    """Strategies applied together in every cycle, their laws independent of each other; made by `combine`.

    Parts with the same schedule draw from one sequence of as many coordinates, so that together they spread evenly too;
    others draw by themselves. Two different fixed sequences could march in step, and are refused (InvalidInput), but
    for pushes that alternate beside the golden angle (Weyl 1916: n modulo k tells nothing of n times an irrational).
    """

    parts: tuple[ResetStrategy, ...]

    def __post_init__(self) -> None:
        if not self.parts or not all(isinstance(part, ResetStrategy) for part in self.parts):
            raise InvalidInput(f"a combination is made of one or more strategies, not of {self.parts!r}")
        _refuse_marching_in_step(self.parts)

    @property
    def name(self) -> str:
        """The names of the parts."""
        return " + ".join(part.name for part in self.parts)

    @property
    def needs(self) -> tuple[str, ...]:
        """What any part needs, each once."""
        return tuple(dict.fromkeys(need for part in self.parts for need in part.needs))

    def prepared(self, loop: CollectionLoop) -> CollectionLoop:
        """Return the loop as all parts, one after the other, set it up."""
        return reduce(lambda made, part: part.prepared(made), self.parts, loop)

    def actions(self, cycles: int, seed: Seed = 0) -> tuple[CycleAction, ...]:
        """Return the actions of all parts at once, cycle by cycle."""
        count = whole_number("cycles", cycles, least=0)
        points = _points(self.parts, count, seed)
        rows = [
            part.actions_at(points[i]) if isinstance(part, DrawnStrategy) else part.actions(count, _own(seed, i))
            for i, part in enumerate(self.parts)
        ]
        return tuple(reduce(CycleAction.then, row) for row in zip(*rows, strict=True))

    def draws(self, cycles: int, seed: Seed = 0) -> Array:
        """Return what a run draws for all parts, side by side: points (cycles, dimensions) of the unit cube.

        Raises InvalidInput where a part is not a `DrawnStrategy`.
        """
        count = whole_number("cycles", cycles, least=0)
        _drawn(self.parts)
        points = _points(self.parts, count, seed)
        return np.hstack([points[i] for i in range(len(self.parts))])

    def interpolation(self, shares: Array, nodes: int = DEFAULT_NODES) -> Array:
        """Return the weights (n, k) of the law's actions in the interpolant at drawn points (n, dimensions)."""
        drawn = _drawn(self.parts)
        ends = np.cumsum([part.dimensions for part in drawn])
        columns = np.split(shares, ends[:-1], axis=1)
        rows = [part.interpolation(column, nodes) for part, column in zip(drawn, columns, strict=True)]
        return reduce(products_of_rows, rows)

    def law(self, nodes: int = DEFAULT_NODES) -> ActionLaw:
        """Return the product of the parts' laws."""
        laws = [part.law(nodes) for part in self.parts]
        checked_size(math.prod(len(law.actions) for law in laws))
        actions = tuple(reduce(CycleAction.then, row) for row in product(*(law.actions for law in laws)))
        weights = np.array([math.prod(row) for row in product(*(law.weights.tolist() for law in laws))])
        return ActionLaw(actions, weights / weights.sum(), _kind(laws))


def combine(*strategies: ResetStrategy) -> Combined:
    """Return the strategies applied together, in this order.

    >>> from cyclemap.resets.strategies.drag_strategies import GripperTurn, WayPoints
    >>> both = combine(WayPoints(((0.1, 0.0),)), GripperTurn(0.2))
    >>> both.name, both.needs, both.actions(1)[0].turn
    ('way-points + gripper turn', ('gripper',), 0.2)
    """
    flat: list[ResetStrategy] = []
    for strategy in strategies:
        flat.extend(strategy.parts if isinstance(strategy, Combined) else (strategy,))
    return Combined(tuple(flat))


def _drawn(parts: tuple[ResetStrategy, ...]) -> list[DrawnStrategy]:
    for part in parts:
        if not isinstance(part, DrawnStrategy):
            raise InvalidInput(f"{part.name} does not say what it draws: derive it from DrawnStrategy")
    return [part for part in parts if isinstance(part, DrawnStrategy)]


def _own(seed: Seed, index: int) -> np.random.SeedSequence:
    """The random numbers of one part."""
    source = seed if isinstance(seed, np.random.SeedSequence) else np.random.SeedSequence(seed)
    return np.random.SeedSequence(source.entropy, spawn_key=(*source.spawn_key, index))


def _points(parts: tuple[ResetStrategy, ...], count: int, seed: Seed) -> dict[int, Array]:
    """What each part draws, by its number: together with all others of its schedule."""
    together: dict[object, list[tuple[int, DrawnStrategy]]] = {}
    for index, part in enumerate(parts):
        if isinstance(part, DrawnStrategy):
            scheduled = part.dimensions and type(part).draws is DrawnStrategy.draws
            together.setdefault(part.schedule if scheduled else index, []).append((index, part))
    points: dict[int, Array] = {}
    for members in together.values():
        first, drawn = members[0]
        if len(members) == 1:
            points[first] = drawn.draws(count, _own(seed, first))
            continue
        ends = np.cumsum([part.dimensions for _, part in members])
        shares = drawn.schedule.draws(count, int(ends[-1]), _own(seed, first))
        columns = np.split(shares, ends[:-1], axis=1)
        points |= {index: column for (index, _), column in zip(members, columns, strict=True)}
    return points


def _refuse_marching_in_step(parts: tuple[ResetStrategy, ...]) -> None:
    fixed: dict[object, str] = {}
    for part in parts:
        if isinstance(part, AlternatingPushes) and len(part.pushes) > 1:
            fixed[AlternatingPushes] = part.name
        elif isinstance(part, DrawnStrategy) and part.dimensions and part.schedule.kind == SEQUENCE:
            fixed[part.schedule] = part.name
    if len(fixed) > 1 and set(fixed) != {AlternatingPushes, GoldenAngle()}:
        raise InvalidInput(
            f"{' and '.join(fixed.values())} follow different fixed sequences, which could march in step: give "
            "both the same schedule, or draw one of them independently"
        )


def _kind(laws: list[ActionLaw]) -> str:
    kinds = {law.kind for law in laws if len(law.actions) > 1}
    if kinds <= {INDEPENDENT}:
        return INDEPENDENT
    if len(kinds) == 1 and sum(len(law.actions) > 1 for law in laws) == 1:
        return kinds.pop()
    return SEQUENCE if kinds & {SEQUENCE, PERIODIC} else BLOCKS
