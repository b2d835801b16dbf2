"""Strategies of the drag: where the ring sits, way-points, a trailing last leg, a scattered aim, a gripper's turn."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

from cyclemap.checks import point, positive_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.resets.strategies.cycle_action import CycleAction, Points
from cyclemap.resets.strategies.schedules import Independent, Schedule
from cyclemap.resets.strategies.spread import Number, Spread, checked_number, lowest
from cyclemap.resets.strategies.strategy import DrawnStrategy


def checked_schedule(schedule: object) -> None:
    """Raise InvalidInput for what is not a schedule."""
    if not isinstance(schedule, Schedule):
        raise InvalidInput(f"{schedule!r} is no schedule: give one such as Independent() or GoldenAngle()")


@dataclass(frozen=True)
class StraightReset(DrawnStrategy):
    """MIT's reset: the drag goes straight to the target.

    >>> StraightReset().actions(1)
    (CycleAction(way_points=(), push=None, turn=0.0),)
    """

    name: ClassVar[str] = "straight"

    def action(self, numbers: tuple[float, ...]) -> CycleAction:
        """Return the drag without way-points."""
        return CycleAction(())


@dataclass(frozen=True)
class RingPlace(DrawnStrategy):
    """The ring at another place of the object for the whole collection: `hitch` (x, y), m, in the object's frame.

    >>> RingPlace((0.0, 0.02)).prepared(CollectionLoop.mit()).slider.hitch
    (0.0, 0.02)
    """

    hitch: tuple[float, float]
    name: ClassVar[str] = "ring at another place"
    needs: ClassVar[tuple[str, ...]] = ("ring at another place",)

    def __post_init__(self) -> None:
        object.__setattr__(self, "hitch", point("hitch", self.hitch))

    def prepared(self, loop: CollectionLoop) -> CollectionLoop:
        """Return the loop with its ring there."""
        return replace(loop, slider=replace(loop.slider, hitch=self.hitch))


@dataclass(frozen=True)
class WayPoints(DrawnStrategy):
    """The drag goes through the same way-points (x, y), m from the target, in every cycle; (): straight.

    >>> WayPoints(((0.1, 0.0), (0.0, 0.1))).law().actions[0].leg_direction == math.pi / 2
    True
    """

    points: Points
    name: ClassVar[str] = "way-points"

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", CycleAction(tuple(self.points)).way_points)

    def action(self, numbers: tuple[float, ...]) -> CycleAction:
        """Return the drag through the points."""
        return CycleAction(self.points)


@dataclass(frozen=True)
class TrailingLeg(DrawnStrategy):
    """The drag first goes to a place off the target, then straight to it, the object trailing behind the rod.

    length : of the last leg, m, fixed or a spread. direction : rad, of that place seen from the target, fixed or a
    spread: the last leg runs along direction + pi. side_step : m, fixed or a spread: where not zero, the drag comes to
    that place across the leg, from a place as far to the left of the leg as seen from the target (negative: right). An
    object that is led out along the leg and straight back forgets little: on the way back it is undone what was done on
    the way out. schedule : of what is drawn.

    Under isotropic friction a direction drawn uniformly leaves the orientations exactly unbiased at any length
    (docs/theory/random-leg.md); the length sets how fast the past is forgotten. A direction within a spread about a
    fixed one is a randomised drag direction, a spread of lengths a randomised length.

    >>> TrailingLeg(0.05, math.pi / 2).law().actions[0].turned(-math.pi / 2).way_points[0][0]
    0.05
    >>> TrailingLeg(0.05).law(16).weights.size
    16
    """

    length: Number
    direction: Number = Spread.full_turn()
    schedule: Schedule = Independent()
    side_step: Number = 0.0
    name: ClassVar[str] = "trailing leg"

    def __post_init__(self) -> None:
        for field in ("length", "direction", "side_step"):
            object.__setattr__(self, field, checked_number(f"leg's {field}", getattr(self, field)))
        positive_number("leg's length", lowest(self.length))
        checked_schedule(self.schedule)

    def drawn(self) -> tuple[Number, ...]:
        """Length, direction and side step."""
        return self.length, self.direction, self.side_step

    def action(self, numbers: tuple[float, ...]) -> CycleAction:
        """Return the drag by that place."""
        length, direction, aside = numbers
        c, s = math.cos(direction), math.sin(direction)
        start = (length * c, length * s)
        return CycleAction(((start[0] - aside * s, start[1] + aside * c), start) if aside else (start,))


@dataclass(frozen=True)
class ScatteredAim(DrawnStrategy):
    """The drag aims at a place drawn evenly from the disc of `radius` (m) about the target, then mends its aim.

    From a distance d the first leg's direction is then off by up to asin(radius/d), and its length by the radius: the
    least that randomises MIT's drag without moving its end.

    >>> len(ScatteredAim(0.02).actions(3, seed=1))
    3
    """

    radius: float
    schedule: Schedule = Independent()
    name: ClassVar[str] = "scattered aim"

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", positive_number("radius of the disc", self.radius))
        checked_schedule(self.schedule)

    def drawn(self) -> tuple[Number, ...]:
        """The share of the disc's area that lies nearer to the target, and the direction."""
        return Spread(0.0, 1.0), Spread.full_turn()

    def action(self, numbers: tuple[float, ...]) -> CycleAction:
        """Return the drag by that place."""
        share, direction = numbers
        away = self.radius * math.sqrt(share)
        return CycleAction(((away * math.cos(direction), away * math.sin(direction)),))


@dataclass(frozen=True)
class GripperTurn(DrawnStrategy):
    """A gripper turns the object about its ring after each drag, by a fixed or a drawn angle (rad).

    >>> GripperTurn(0.5).law().actions[0].turn
    0.5
    """

    turn: Number = Spread.full_turn()
    schedule: Schedule = Independent()
    name: ClassVar[str] = "gripper turn"
    needs: ClassVar[tuple[str, ...]] = ("gripper",)

    def __post_init__(self) -> None:
        object.__setattr__(self, "turn", checked_number("gripper turn", self.turn))
        checked_schedule(self.schedule)

    def drawn(self) -> tuple[Number, ...]:
        """The turn."""
        return (self.turn,)

    def action(self, numbers: tuple[float, ...]) -> CycleAction:
        """Return the turn alone."""
        return CycleAction(turn=numbers[0])
