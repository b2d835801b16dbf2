"""A strategy that is a list of cycles: exactly what a robot did, or is going to do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.schedules import INDEPENDENT, SEQUENCE
from cyclemap.resets.strategies.strategy import DEFAULT_NODES, PERIODIC, ActionLaw, Seed, checked_size

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ScheduledActions:
    """The actions of a list, one a cycle, from the first; nothing is drawn, and a seed changes nothing.

    scheduled : one `CycleAction` or more. repeats : True begins anew after the last; False ends there: more cycles
    are refused. Its law is that of the whole list: each action as often as it comes, `periodic` where it repeats.

    >>> twice = ScheduledActions((CycleAction(turn=0.1), CycleAction(turn=0.2)), repeats=True)
    >>> [action.turn for action in twice.actions(3)]
    [0.1, 0.2, 0.1]
    """

    scheduled: tuple[CycleAction, ...]
    repeats: bool = False

    def __post_init__(self) -> None:
        given = tuple(self.scheduled) if isinstance(self.scheduled, Sequence) else ()
        if not given or not all(isinstance(action, CycleAction) for action in given):
            raise InvalidInput(f"a schedule is one CycleAction or more, not {self.scheduled!r}")
        if not isinstance(self.repeats, bool):
            raise InvalidInput(f"repeats must be True or False, not {self.repeats!r}")
        object.__setattr__(self, "scheduled", given)

    @property
    def name(self) -> str:
        """Its length."""
        return f"schedule of {len(self.scheduled)} cycles"

    @property
    def needs(self) -> tuple[str, ...]:
        """A gripper, where it turns."""
        return ("gripper",) if any(action.turn for action in self.scheduled) else ()

    def prepared(self, loop: CollectionLoop) -> CollectionLoop:
        """Return the loop as it is: a schedule says nothing of the ring's place."""
        return loop

    def actions(self, cycles: int, seed: Seed = 0) -> tuple[CycleAction, ...]:
        """Return the first `cycles` actions; InvalidInput beyond the end of a list that does not repeat."""
        return tuple(self.scheduled[place] for place in self._places(cycles))

    def draws(self, cycles: int, seed: Seed = 0) -> Array:
        """Return the middles of the shares of the list that its actions take, in turn, (cycles, 1)."""
        return np.array([(place + 0.5) / len(self.scheduled) for place in self._places(cycles)]).reshape(-1, 1)

    def interpolation(self, shares: Array, nodes: int = DEFAULT_NODES) -> Array:
        """Return a one (n, k) for the action of the law that is meant, zero for the others."""
        last = len(self.scheduled) - 1
        at = np.minimum((shares[:, 0] * len(self.scheduled)).astype(int), last)
        columns = np.array([self._law_places[place] for place in at.tolist()], dtype=int)
        return np.asarray(np.eye(max(self._law_places) + 1)[columns])

    def law(self, nodes: int = DEFAULT_NODES) -> ActionLaw:
        """Return the actions in their order where the list repeats, else each once, with how often it comes."""
        counts = np.bincount(self._law_places).astype(float)
        checked_size(counts.size)
        first = dict(zip(self._law_places, self.scheduled, strict=True))
        kind = INDEPENDENT if counts.size == 1 else PERIODIC if self.repeats else SEQUENCE
        return ActionLaw(tuple(first[column] for column in range(counts.size)), counts / counts.sum(), kind)

    def _places(self, cycles: int) -> list[int]:
        count, length = whole_number("cycles", cycles, least=0), len(self.scheduled)
        if count > length and not self.repeats:
            raise InvalidInput(
                f"{count} cycles are more than the {length} of the schedule: ask for fewer, or repeat it"
            )
        return [number % length for number in range(count)]

    @cached_property
    def _law_places(self) -> tuple[int, ...]:
        """For each cycle of the list the number of its action in the law."""
        if self.repeats and len(set(self.scheduled)) > 1:
            return tuple(range(len(self.scheduled)))
        place: dict[CycleAction, int] = {}
        return tuple(place.setdefault(action, len(place)) for action in self.scheduled)
