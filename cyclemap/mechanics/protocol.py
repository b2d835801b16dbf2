"""The rod, and what the robot does with it: a push by side or from a place in the world, the way back in the ring."""

import math
from dataclasses import dataclass

from cyclemap.checks import finite_number, non_negative_number, point, positive_number
from cyclemap.errors import InvalidInput


@dataclass(frozen=True)
class Pusher:
    """A vertical rod: radius in m (zero: a point) and its Coulomb friction coefficient with the slider.

    >>> Pusher().radius
    0.00475
    """

    radius: float = 0.00475
    friction: float = 0.15

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", non_negative_number("pusher radius", self.radius))
        object.__setattr__(self, "friction", non_negative_number("pusher friction", self.friction))


@dataclass(frozen=True)
class SidePush:
    """A straight push that starts in contact.

    Parameters
    ----------
    side : number of the touched side, counter-clockwise; an ellipse's outline is side 0.
    fraction : place on the side from its first vertex, 0 to 1; on an ellipse the eccentric angle over 2 pi.
    angle : direction of the push from the side's inward normal, rad, counter-clockwise, within (-pi/2, pi/2).
    distance : rod travel from first touch, m.
    """

    side: int = 0
    fraction: float = 0.7
    angle: float = 0.0
    distance: float = 0.15

    def __post_init__(self) -> None:
        side = finite_number("push side", self.side)
        if side != int(side) or side < 0:
            raise InvalidInput(f"push side must be a whole number from 0, not {self.side!r}")
        object.__setattr__(self, "side", int(side))
        object.__setattr__(self, "fraction", finite_number("contact fraction", self.fraction))
        object.__setattr__(self, "angle", finite_number("push angle", self.angle))
        object.__setattr__(self, "distance", positive_number("push distance", self.distance))
        if not 0.0 <= self.fraction <= 1.0:
            raise InvalidInput(f"contact fraction {self.fraction} lies outside the side: it runs from 0 to 1")
        if not abs(self.angle) < math.pi / 2.0:
            raise InvalidInput(
                f"push angle {math.degrees(self.angle):.6g} degrees points away from the object: it must lie within 90 "
                "degrees of the side's inward normal"
            )


@dataclass(frozen=True)
class WorldPush:
    """A straight push of a rod that starts at a place in the world, not yet in contact.

    Parameters
    ----------
    start : rod's centre, (x, y), m, outside the object.
    direction : rad, world frame.
    distance : rod travel from the start, m.
    """

    start: tuple[float, float]
    direction: float
    distance: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", point("push start", self.start))
        object.__setattr__(self, "direction", finite_number("push direction", self.direction))
        object.__setattr__(self, "distance", positive_number("push distance", self.distance))


@dataclass(frozen=True)
class Pose:
    """Place (m) and orientation (rad, not wrapped) of an object in the world."""

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0

    def __post_init__(self) -> None:
        for name in ("x", "y", "theta"):
            object.__setattr__(self, name, finite_number(f"pose {name}", getattr(self, name)))

    def to_world(self, x: float, y: float) -> tuple[float, float]:
        """Return where a point of the object's frame (m) is in the world, m."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return self.x + c * x - s * y, self.y + s * x + c * y

    def to_object(self, x: float, y: float) -> tuple[float, float]:
        """Return where a point of the world (m) is in the object's frame, m.

        >>> Pose(1.0, 2.0, 0.5).to_object(1.0, 2.0)
        (0.0, 0.0)
        """
        c, s = math.cos(self.theta), math.sin(self.theta)
        dx, dy = x - self.x, y - self.y
        return c * dx + s * dy, -s * dx + c * dy


@dataclass(frozen=True)
class DragBack:
    """The reset: the rod, in the ring, goes straight through the way-points to the target, the world's origin.

    Parameters
    ----------
    way_points : (x, y), m, relative to the target, in order; none: one straight leg.
    pin_friction_radius : radius of the friction circle of the rod in the ring, m: coefficient of friction times radius
        of the rod. The rod does not turn; the object's spin is opposed by this times the rod's force.
    """

    way_points: tuple[tuple[float, float], ...] = ()
    pin_friction_radius: float = 0.0

    def __post_init__(self) -> None:
        radius = non_negative_number("pin friction radius", self.pin_friction_radius)
        object.__setattr__(self, "pin_friction_radius", radius)
        points = tuple(point("way-point", p) for p in self.way_points)
        object.__setattr__(self, "way_points", points)
