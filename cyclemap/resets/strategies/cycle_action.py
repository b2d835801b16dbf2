"""What the robot does otherwise than the loop in one cycle: way-points, push, and a turn by a gripper."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from cyclemap.checks import finite_number, point
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import SidePush

Points = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class CycleAction:
    """One cycle as a strategy wants it; what is None is done as the loop does it.

    Parameters
    ----------
    way_points : (x, y), m, from the target: where the drag goes before its last leg to the target; (): straight.
    push : the push of this cycle.
    turn : rad, counter-clockwise: a gripper turns the object about its ring after the drag. The ring stays at the
        target, so that the state before the next push is still the orientation alone.

    Raises InvalidInput for a value that is not finite, or a push that is not a `SidePush`.

    >>> CycleAction(way_points=((0.05, 0.0),)).on(CollectionLoop.mit()).reset.way_points
    ((0.05, 0.0),)
    """

    way_points: Points | None = None
    push: SidePush | None = None
    turn: float = 0.0

    def __post_init__(self) -> None:
        if self.way_points is not None:
            object.__setattr__(self, "way_points", tuple(point("way-point", p) for p in self.way_points))
        if self.push is not None and not isinstance(self.push, SidePush):
            raise InvalidInput(f"the push of an action must be a SidePush or None, not {self.push!r}")
        object.__setattr__(self, "turn", finite_number("gripper turn", self.turn))

    def on(self, loop: CollectionLoop) -> CollectionLoop:
        """Return the loop with this action's push and way-points; the gripper's turn is no part of a loop."""
        reset = loop.reset if self.way_points is None else replace(loop.reset, way_points=self.way_points)
        return replace(loop, push=self.push or loop.push, reset=reset)

    def filled(self, loop: CollectionLoop) -> CycleAction:
        """Return the same action with the loop's push and way-points where it has none of its own."""
        acted = self.on(loop)
        return CycleAction(acted.reset.way_points, acted.push, self.turn)

    def turned(self, angle: float) -> CycleAction:
        """Return the action with its way-points turned about the target by `angle` (rad).

        On a surface turned along with it the same cycle results, turned: f -> angle + f(theta - angle).

        >>> [round(x, 12) for x in CycleAction(((0.05, 0.0),)).turned(math.pi / 2).way_points[0]]
        [0.0, 0.05]
        """
        if self.way_points is None:
            return self
        c, s = math.cos(angle), math.sin(angle)
        return replace(self, way_points=tuple((c * x - s * y, s * x + c * y) for x, y in self.way_points))

    def then(self, other: CycleAction) -> CycleAction:
        """Return both at once: this action's way-points, then the other's; turns add up.

        Raises InvalidInput where both bring a push of their own.

        >>> CycleAction(((0.1, 0.0),), turn=0.5).then(CycleAction(((0.0, 0.1),))).way_points
        ((0.1, 0.0), (0.0, 0.1))
        """
        if self.push is not None and other.push is not None:
            raise InvalidInput(f"two pushes for one cycle: {self.push} and {other.push}; leave one of them out")
        points = [given for given in (self.way_points, other.way_points) if given is not None]
        joined = sum(points, ()) if points else None
        return CycleAction(joined, self.push or other.push, self.turn + other.turn)

    @property
    def leg_direction(self) -> float | None:
        """Direction of the last way-point seen from the target, rad; None where the drag has no way-point off it."""
        last = self.way_points[-1] if self.way_points else (0.0, 0.0)
        return None if last == (0.0, 0.0) else math.atan2(last[1], last[0])
