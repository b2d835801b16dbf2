"""Strategies of the push: several pushes in turn or drawn, and a push whose place, angle or length is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import positive_number, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import SidePush
from cyclemap.resets.strategies.cycle_action import CycleAction
from cyclemap.resets.strategies.drag_strategies import checked_schedule
from cyclemap.resets.strategies.schedules import INDEPENDENT, Independent, Schedule
from cyclemap.resets.strategies.spread import Number, Spread, checked_number
from cyclemap.resets.strategies.strategy import DEFAULT_NODES, PERIODIC, ActionLaw, DrawnStrategy, Seed

Array = NDArray[np.float64]


def side_pushes(push: SidePush, sides: Sequence[int]) -> tuple[SidePush, ...]:
    """Return the same push on each of the sides.

    >>> [made.side for made in side_pushes(SidePush(), (0, 2))]
    [0, 2]
    """
    return tuple(replace(push, side=side) for side in sides)


def fraction_pushes(push: SidePush, fractions: Sequence[float]) -> tuple[SidePush, ...]:
    """Return the same push at each of the fractions of its side.

    >>> [made.fraction for made in fraction_pushes(SidePush(), (0.3, 0.7))]
    [0.3, 0.7]
    """
    return tuple(replace(push, fraction=fraction) for fraction in fractions)


class PushChoice(DrawnStrategy):
    """One of several pushes in every cycle: what alternating and drawing have in common."""

    pushes: tuple[SidePush, ...]

    @property
    def chances(self) -> Array:
        """How often each push comes, (k,), summing to one: all alike."""
        return np.full(len(self.pushes), 1.0 / len(self.pushes))

    def drawn(self) -> tuple[Number, ...]:
        """The share of the pushes, laid end to end by their chances, up to the one that is chosen."""
        return (Spread(0.0, 1.0),)

    def action(self, numbers: tuple[float, ...]) -> CycleAction:
        """Return the push at that place."""
        return CycleAction(push=self.pushes[int(self._chosen(np.array(numbers[0])))])

    def interpolation(self, shares: Array, nodes: int = DEFAULT_NODES) -> Array:
        """Return a one (n, k) for the push that is chosen, zero for the others."""
        return np.asarray(np.eye(len(self.pushes))[self._chosen(shares[:, 0])])

    def law(self, nodes: int = DEFAULT_NODES) -> ActionLaw:
        """Return the pushes in their order, with their chances."""
        kind = self.schedule.kind if len(self.pushes) > 1 else INDEPENDENT
        return ActionLaw(tuple(CycleAction(push=push) for push in self.pushes), self.chances, kind)

    def _chosen(self, share: Array) -> NDArray[np.int64]:
        ends = np.cumsum(self.chances)[:-1]
        return np.asarray(np.searchsorted(ends, share, side="right"))


@dataclass(frozen=True)
class AlternatingPushes(PushChoice):
    """The pushes come in this order, again and again, from the first.

    >>> [made.push.side for made in AlternatingPushes(side_pushes(SidePush(), (0, 2))).actions(3)]
    [0, 2, 0]
    """

    pushes: tuple[SidePush, ...]
    name: ClassVar[str] = "alternating pushes"

    def __post_init__(self) -> None:
        object.__setattr__(self, "pushes", _checked_pushes(self.pushes))

    def draws(self, cycles: int, seed: Seed = 0) -> Array:
        """Return the middles of the sectors of the pushes in turn, (cycles, 1); nothing is drawn."""
        count, period = whole_number("cycles", cycles, least=0), len(self.pushes)
        return np.asarray((np.arange(count)[:, None] % period + 0.5) / period)

    def law(self, nodes: int = DEFAULT_NODES) -> ActionLaw:
        """Return the pushes in their order, alike in weight."""
        kind = PERIODIC if len(self.pushes) > 1 else INDEPENDENT
        return replace(super().law(nodes), kind=kind)


@dataclass(frozen=True)
class DrawnPushes(PushChoice):
    """One of several pushes, drawn in every cycle by a schedule.

    weights : how likely each push is, positive, scaled to sum one; None: all alike.
    schedule : independent draws spread orientations most, since chance excesses of one push add up; for four pushes on
    plywood the golden angle left four times their bias.

    >>> DrawnPushes(fraction_pushes(SidePush(), (0.3, 0.7)), weights=(1.0, 3.0)).law().weights.tolist()
    [0.25, 0.75]
    """

    pushes: tuple[SidePush, ...]
    schedule: Schedule = Independent()
    weights: tuple[float, ...] | None = None
    name: ClassVar[str] = "drawn pushes"

    def __post_init__(self) -> None:
        object.__setattr__(self, "pushes", _checked_pushes(self.pushes))
        checked_schedule(self.schedule)
        if self.weights is not None:
            object.__setattr__(self, "weights", _checked_weights(self.weights, len(self.pushes)))
        sectors = self.schedule.sectors
        often = (sectors or 0) * self.chances
        if np.abs(often - np.round(often)).max() > 1e-9:
            raise InvalidInput(
                f"blocks of {sectors} cannot give the pushes the shares {self.chances.tolist()}: choose another size"
            )

    @property
    def chances(self) -> Array:
        """How likely each push is, (k,)."""
        if self.weights is None:
            return super().chances
        # By the largest first: a sum of huge weights would overflow.
        shares = np.array(self.weights) / max(self.weights)
        return np.asarray(shares / shares.sum())


@dataclass(frozen=True)
class VariedPush(DrawnStrategy):
    """A push whose fraction, angle (rad) or distance (m) are drawn evenly; None: as in `push`.

    >>> law = VariedPush(SidePush(), fraction=Spread(0.6, 0.8)).law(16)
    >>> round(float(law.weights @ [made.push.fraction for made in law.actions]), 12)
    0.7
    """

    push: SidePush
    fraction: Number | None = None
    angle: Number | None = None
    distance: Number | None = None
    schedule: Schedule = Independent()
    name: ClassVar[str] = "varied push"

    def __post_init__(self) -> None:
        if not isinstance(self.push, SidePush):
            raise InvalidInput(f"the push that is varied must be a SidePush, not {self.push!r}")
        for field in ("fraction", "angle", "distance"):
            if getattr(self, field) is None:
                object.__setattr__(self, field, getattr(self.push, field))
            checked_number(f"push {field}", getattr(self, field))
        checked_schedule(self.schedule)
        for end in (0.0, 1.0):
            # A push that cannot be is refused here, not in the middle of a run.
            self.action(tuple(n.at(end) if isinstance(n, Spread) else n for n in self.drawn()))

    def drawn(self) -> tuple[Number, ...]:
        """Fraction, angle and distance."""
        assert self.fraction is not None and self.angle is not None and self.distance is not None
        return self.fraction, self.angle, self.distance

    def action(self, numbers: tuple[float, ...]) -> CycleAction:
        """Return the push with these numbers."""
        fraction, angle, distance = numbers
        return CycleAction(push=replace(self.push, fraction=fraction, angle=angle, distance=distance))


def _checked_weights(weights: tuple[float, ...], count: int) -> tuple[float, ...]:
    given = tuple(positive_number("weight of a push", weight) for weight in weights)
    if len(given) != count:
        raise InvalidInput(f"{count} pushes need as many weights, not {len(given)}")
    return given


def _checked_pushes(pushes: tuple[SidePush, ...]) -> tuple[SidePush, ...]:
    given = tuple(pushes)
    if not given or not all(isinstance(push, SidePush) for push in given):
        raise InvalidInput(f"pushes must be one or more of SidePush, not {pushes!r}")
    return given
