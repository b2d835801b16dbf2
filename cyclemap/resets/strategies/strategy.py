"""What a reset strategy is: the actions of a run, cycle by cycle, and their law in one cycle.

A strategy of one's own is a class with `name`, `needs`, `prepared`, `actions` and `law`; the shortest way is to derive
it from `DrawnStrategy`, which makes the last three of two methods. This one steps aside by a drawn length:

>>> from dataclasses import dataclass
>>> from cyclemap.resets.strategies.cycle_action import CycleAction
>>> @dataclass(frozen=True)
... class SideStep(DrawnStrategy):
...     width: float
...     name = "side step"
...     def drawn(self):
...         return (Spread(-self.width, self.width),)
...     def action(self, numbers):
...         return CycleAction(way_points=((0.0, numbers[0]),))
>>> mine = SideStep(0.05)
>>> isinstance(mine, ResetStrategy), len(mine.actions(5, seed=1)), len(mine.law().actions)
(True, 5, 8)
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import ClassVar, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import finite_array, read_only, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.schedules import INDEPENDENT, Independent, Schedule
from cyclemap.resets.strategies.spread import Number, Spread

Array = NDArray[np.float64]
Seed = int | np.random.SeedSequence

# How cycles depend on each other besides the kinds of schedules: the actions of the law in turn, again and again.
PERIODIC = "periodic"
# Nodes of a full turn, unless more are asked for.
DEFAULT_NODES = 32
_MOST_ACTIONS = 20_000


@dataclass(frozen=True, eq=False)
class ActionLaw:
    """The law of a strategy's action in one cycle: `actions` (k) with `weights` (k,) that sum to one.

    kind : `independent`: drawn anew in every cycle, so that the orientations are a Markov chain whose kernel is the
    mean over the law. `periodic`: the actions come in this order, again and again: the chain of whole periods is the
    product of their kernels. `blocks`, `sequence`: of each cycle by itself, and of a long run, this is the law, but
    cycles know of each other: a deterministic schedule is not an independent draw.
    """

    actions: tuple[CycleAction, ...]
    weights: Array
    kind: str = INDEPENDENT

    def __post_init__(self) -> None:
        weights = finite_array("weights", self.weights, ndim=1)
        if weights.size != len(self.actions) or not weights.size:
            raise InvalidInput(f"a law needs one weight for each action, not {weights.size} for {len(self.actions)}")
        if np.any(weights < 0.0) or abs(float(weights.sum()) - 1.0) > 1e-9:
            raise InvalidInput(f"the weights of a law must not be negative and sum to one, not to {weights.sum()}")
        object.__setattr__(self, "actions", tuple(self.actions))
        object.__setattr__(self, "weights", read_only(weights))


@runtime_checkable
class ResetStrategy(Protocol):
    """What everything that scores, runs or designs a reset asks of a strategy.

    name : for people. needs : what it asks for besides the same rod and ring, in words; empty: nothing.
    """

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def needs(self) -> tuple[str, ...]:
        """What it asks for besides the same rod and ring."""

    def prepared(self, loop: CollectionLoop) -> CollectionLoop:
        """Return the loop as it is set up once, before the first cycle: the ring's place, the usual push."""

    def actions(self, cycles: int, seed: Seed = 0) -> tuple[CycleAction, ...]:
        """Return what the robot does in each of `cycles` cycles; the same for the same seed."""

    def law(self, nodes: int = DEFAULT_NODES) -> ActionLaw:
        """Return the law of one cycle; a continuous one as a quadrature with `nodes` nodes for a full turn."""


class DrawnStrategy:
    """A strategy whose action is a function of a few numbers, each fixed or drawn evenly, by a schedule.

    A class derived from it says which numbers (`drawn`; by itself none) and what the robot does with them (`action`; by
    itself nothing that the loop does not do); it may have a field `schedule` and name what it `needs`. Fixed numbers
    are given to `action` as they are.
    """

    name: ClassVar[str] = "unchanged"
    needs: ClassVar[tuple[str, ...]] = ()
    schedule: Schedule = Independent()

    def drawn(self) -> tuple[Number, ...]:
        """The numbers of one cycle: fixed ones and spreads."""
        return ()

    def action(self, numbers: tuple[float, ...]) -> CycleAction:
        """What the robot does with the numbers of one cycle."""
        return CycleAction()

    def prepared(self, loop: CollectionLoop) -> CollectionLoop:
        """Return the loop as it is: nothing is set up otherwise."""
        return loop

    @property
    def dimensions(self) -> int:
        """How many numbers are drawn in a cycle."""
        return sum(isinstance(number, Spread) for number in self.drawn())

    def draws(self, cycles: int, seed: Seed = 0) -> Array:
        """Return what a run draws: points (cycles, dimensions) of the unit cube."""
        count = whole_number("cycles", cycles, least=0)
        return self.schedule.draws(count, self.dimensions, seed) if self.dimensions else np.empty((count, 0))

    def actions(self, cycles: int, seed: Seed = 0) -> tuple[CycleAction, ...]:
        """Return the actions of a run of `cycles` cycles."""
        return self.actions_at(self.draws(cycles, seed))

    def actions_at(self, shares: Array) -> tuple[CycleAction, ...]:
        """Return the actions at points (cycles, dimensions) of the unit cube."""
        made = []
        for row in shares.tolist():
            share = iter(row)
            numbers = tuple(n.at(next(share)) if isinstance(n, Spread) else n for n in self.drawn())
            made.append(self.action(numbers))
        return tuple(made)

    def interpolation(self, shares: Array, nodes: int = DEFAULT_NODES) -> Array:
        """Return the weights (n, k) of the law's actions in the interpolant at drawn points (n, dimensions)."""
        sectors, rows = self.schedule.sectors, np.ones((len(shares), 1))
        spreads = [number for number in self.drawn() if isinstance(number, Spread)]
        for spread, share in zip(spreads, shares.T, strict=True):
            rows = products_of_rows(rows, spread.interpolation(share, nodes, sectors))
        return rows

    def law(self, nodes: int = DEFAULT_NODES) -> ActionLaw:
        """Return the law of one cycle: the product of the laws of its numbers."""
        count, sectors = whole_number("nodes", nodes, least=1), self.schedule.sectors
        parts = [
            number.nodes(count, sectors) if isinstance(number, Spread) else (np.array([number]), np.ones(1))
            for number in self.drawn()
        ]
        checked_size(math.prod(len(values) for values, _ in parts))
        actions = tuple(self.action(tuple(numbers)) for numbers in product(*(v.tolist() for v, _ in parts)))
        weights = np.array([math.prod(w) for w in product(*(w.tolist() for _, w in parts))])
        return ActionLaw(actions, weights, self.schedule.kind if self.dimensions else INDEPENDENT)


def products_of_rows(left: Array, right: Array) -> Array:
    """Return the rows (n, k m) of all products of a row (n, k) with a row (n, m), the last varying fastest.

    >>> products_of_rows(np.array([[1.0, 2.0]]), np.array([[3.0, 4.0]])).tolist()
    [[3.0, 4.0, 6.0, 8.0]]
    """
    return np.asarray((left[:, :, None] * right[:, None, :]).reshape(len(left), -1))


def checked_size(actions: int) -> int:
    """Return the number of actions of a law, or raise InvalidInput where they are too many to be worked with."""
    if actions > _MOST_ACTIONS:
        raise InvalidInput(f"this law has {actions} actions, more than {_MOST_ACTIONS}: ask for fewer nodes")
    return actions
