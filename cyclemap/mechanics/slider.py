"""What is moved and by what: the object, with the shapes of the MIT push dataset by name, its pose,
rod and strokes.
"""

import math
import warnings
from dataclasses import dataclass, field

import numpy as np

from cyclemap.checks import (
    finite_number,
    non_negative_number,
    point,
    positive_number,
    require_kind,
)
from cyclemap.errors import DoubtfulInput, InvalidInput, unknown_name
from cyclemap.mechanics.outline import Ellipse, Outline, Polygon, resting_centre

# Standard gravity, m/s^2.
GRAVITY = 9.80665
# A ring is on the object, or on an arm of it: not ten times as far out as the object reaches.
_FARTHEST_RING = 10.0
# A ring 15 mm from the centre, towards the corner between sides 0 and 1 of rect1.
MIT_HITCH = (-0.015 / math.sqrt(2.0), 0.015 / math.sqrt(2.0))


def _rectangle(width: float, height: float) -> Polygon:
    x, y = width / 2.0, height / 2.0
    return Polygon(((x, y), (-x, y), (-x, -y), (x, -y)))


def _right_triangle(leg_x: float, leg_y: float) -> Polygon:
    corner = 0.045
    return Polygon(((corner, corner), (corner - leg_x, corner), (corner, corner - leg_y)))


_HEXAGON = Polygon(
    tuple(
        (0.0605 * math.cos(k * math.pi / 3), 0.0605 * math.sin(k * math.pi / 3)) for k in range(6)
    )
)
# Outline, mass (kg) and moment of inertia about the centre of mass (kg m^2): Yu et al. 2016,
# dataset documentation.
_MIT_SHAPES: dict[str, tuple[Outline, float, float]] = {
    "rect1": (_rectangle(0.09, 0.09), 0.8374, 0.001131),
    "rect2": (_rectangle(0.08991, 0.11258), 1.045, 0.001808),
    "rect3": (_rectangle(0.13501, 0.08994), 1.2508, 0.002744),
    "tri1": (_right_triangle(0.12590, 0.12587), 0.8028, 0.001414),
    "tri2": (_right_triangle(0.15100, 0.12587), 0.9826, 0.002108),
    "tri3": (_right_triangle(0.17650, 0.12561), 1.1326, 0.002957),
    "hex": (_HEXAGON, 0.9827, 0.001497),
    "ellip1": (Ellipse(0.0525, 0.0525), 0.8937, 0.001231),
    "ellip2": (Ellipse(0.0525, 0.065445), 1.1104, 0.001953),
    "ellip3": (Ellipse(0.0525, 0.0785), 1.3338, 0.002973),
}

MIT_SHAPE_NAMES = tuple(_MIT_SHAPES)


@dataclass(frozen=True)
class Slider:
    """A rigid flat object on the surface, in its own frame.

    Parameters
    ----------
    outline : Polygon or Ellipse
        In m; sides are numbered counter-clockwise from vertex 0.
    mass : float, default 1.0
        kg; in quasi-static motion it scales the contact forces and nothing else.
    centre_of_mass : tuple[float, float], optional
        (x, y), m, inside the outline's convex hull; None: the outline's centroid.
    hitch : tuple[float, float], optional
        (x, y), m: the ring in which the rod drags it back. Outside the outline it is a
        `DoubtfulInput` warning, and refused more than ten times as far from the centre as any
        of the outline.
    inertia : float or None, optional
        Moment of inertia about the centre of mass, kg m^2; None: unknown.
    name : str, default 'slider'
        Names it in material files and in print.

    Attributes
    ----------
    weight : float
        Mass times gravity, N.

    Raises
    ------
    InvalidInput
        For an outline that is none, mass or inertia that is not positive, a centre of mass
        outside the convex hull, where the object would tip, and a ring too far away.

    Examples
    --------
    >>> from cyclemap import Slider
    >>> Slider.mit("rect1").outline.sides
    4
    """

    outline: Outline
    mass: float = 1.0
    centre_of_mass: tuple[float, float] = None  # type: ignore[assignment]  # filled in below
    hitch: tuple[float, float] = MIT_HITCH
    inertia: float | None = None
    name: str = "slider"
    weight: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not isinstance(self.outline, (Polygon, Ellipse)):
            raise InvalidInput(
                f"a slider's outline must be a Polygon or an Ellipse, not {self.outline!r}"
            )
        positive_number("slider mass", self.mass)
        if self.inertia is not None:
            positive_number("slider inertia", self.inertia)
        vars(self).update(
            centre_of_mass=resting_centre(self.outline, self.centre_of_mass),
            hitch=point("hitch", self.hitch),
            weight=self.mass * GRAVITY,
        )
        away, size = math.dist(self.hitch, self.outline.centroid), self.outline.extent
        apart = (
            f"the ring is {1e3 * away:.4g} mm from the centre of an object that reaches "
            f"{1e3 * size:.4g} mm"
        )
        if away > _FARTHEST_RING * size:
            raise InvalidInput(
                f"{apart}: give both in the same unit, and the ring's place (hitch) with a new "
                "outline"
            )
        if not self.outline.contains(self.hitch):
            warnings.warn(
                f"{apart}: it lies outside; is the ring's place (hitch) meant for it?",
                DoubtfulInput,
                stacklevel=3,
            )

    @classmethod
    def mit(cls, name: str, hitch: tuple[float, float] = MIT_HITCH) -> "Slider":
        """Return a shape of MIT's push dataset: rect1-3, tri1-3, hex, ellip1-3 (Yu et al. 2016)."""
        require_kind("slider shape", name, str)
        if name not in _MIT_SHAPES:
            raise unknown_name("slider shape", name, MIT_SHAPE_NAMES)
        outline, mass, inertia = _MIT_SHAPES[name]
        return cls(outline, mass, hitch=hitch, inertia=inertia, name=name)

    def outline_points(self, count: int = 181) -> np.ndarray:
        """Return the closed outline as a polyline (m, 2) in the object frame, m; curves are cut in
        `count` pieces.
        """
        return self.outline.points(count)


@dataclass(frozen=True)
class Pose:
    """Place and orientation of an object in the world.

    Parameters
    ----------
    x : float, default 0.0
        Place of the object's origin along x, m.
    y : float, default 0.0
        Place along y, m.
    theta : float, default 0.0
        Orientation, rad, counter-clockwise, not wrapped.

    Raises
    ------
    InvalidInput
        For what is not finite.

    Examples
    --------
    >>> import math
    >>> from cyclemap import Pose
    >>> x, y = Pose(0.1, 0.0, math.pi / 2).to_world(0.02, 0.0)
    >>> round(x, 3), round(y, 3)
    (0.1, 0.02)
    """

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0

    def __post_init__(self) -> None:
        for name in ("x", "y", "theta"):
            vars(self)[name] = finite_number(f"pose {name}", getattr(self, name))

    def to_world(self, x: float, y: float) -> tuple[float, float]:
        """Return where a point of the object's frame (m) is in the world, m."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return self.x + c * x - s * y, self.y + s * x + c * y

    def to_object(self, x: float, y: float) -> tuple[float, float]:
        """Return where a point of the world (m) is in the object's frame, m.

        >>> from cyclemap import Pose
        >>> Pose(1.0, 2.0, 0.5).to_object(1.0, 2.0)
        (0.0, 0.0)
        """
        c, s = math.cos(self.theta), math.sin(self.theta)
        dx, dy = x - self.x, y - self.y
        return c * dx + s * dy, -s * dx + c * dy


@dataclass(frozen=True)
class Pusher:
    """A vertical rod that pushes the slider.

    Parameters
    ----------
    radius : float, default 0.00475
        m, zero: a point.
    friction : float, default 0.15
        Coefficient of Coulomb's friction with the slider, not negative.

    Raises
    ------
    InvalidInput
        For a radius or a friction that is negative or not finite.

    Examples
    --------
    >>> from cyclemap import Pusher
    >>> Pusher().radius
    0.00475
    """

    radius: float = 0.00475
    friction: float = 0.15

    def __post_init__(self) -> None:
        for name in ("radius", "friction"):
            vars(self)[name] = non_negative_number(f"pusher {name}", getattr(self, name))


@dataclass(frozen=True)
class SidePush:
    """A straight push that starts in contact.

    Parameters
    ----------
    side : int, default 0
        Number of the touched side, counter-clockwise; an ellipse's outline is side 0.
    fraction : float, default 0.7
        Place on the side from its first vertex, 0 to 1; on an ellipse the eccentric angle over
        2 pi.
    angle : float, default 0.0
        Direction of the push from the side's inward normal, rad, counter-clockwise, within
        (-pi/2, pi/2).
    distance : float, default 0.15
        Rod travel from first touch, m, positive.

    Raises
    ------
    InvalidInput
        For values outside these ranges.

    Examples
    --------
    >>> import math
    >>> from cyclemap import SidePush
    >>> SidePush(side=1, fraction=0.5, angle=math.radians(-20.0)).distance
    0.15
    """

    side: int = 0
    fraction: float = 0.7
    angle: float = 0.0
    distance: float = 0.15

    def __post_init__(self) -> None:
        side = finite_number("push side", self.side)
        if side != int(side) or side < 0:
            raise InvalidInput(f"push side must be a whole number from 0, not {self.side!r}")
        vars(self).update(
            side=int(side),
            fraction=finite_number("contact fraction", self.fraction),
            angle=finite_number("push angle", self.angle),
            distance=positive_number("push distance", self.distance),
        )
        if not 0.0 <= self.fraction <= 1.0:
            raise InvalidInput(
                f"contact fraction {self.fraction} lies outside the side: it runs from 0 to 1"
            )
        if not abs(self.angle) < math.pi / 2.0:
            raise InvalidInput(
                f"push angle {math.degrees(self.angle):.6g} degrees points away from the object: "
                "it must lie within 90 degrees of the side's inward normal"
            )


@dataclass(frozen=True)
class WorldPush:
    """A straight push of a rod that starts at a place in the world, not yet in contact.

    Parameters
    ----------
    start : tuple[float, float]
        The rod's centre, (x, y), m, outside the object.
    direction : float
        Of the rod's way, rad, world frame.
    distance : float
        Rod travel from the start, m, positive.

    Raises
    ------
    InvalidInput
        For what is not finite, and a distance that is not positive.

    Examples
    --------
    >>> import math
    >>> from cyclemap.mechanics import WorldPush
    >>> push = WorldPush(start=(0.0, 0.06), direction=-math.pi / 2, distance=0.05)
    >>> push.start
    (0.0, 0.06)
    """

    start: tuple[float, float]
    direction: float
    distance: float

    def __post_init__(self) -> None:
        vars(self).update(
            start=point("push start", self.start),
            direction=finite_number("push direction", self.direction),
            distance=positive_number("push distance", self.distance),
        )


@dataclass(frozen=True)
class DragBack:
    """The reset: the rod, in the ring, goes straight through the way-points to the target, the
    world's origin.

    Parameters
    ----------
    way_points : sequence of (float, float), default ()
        (x, y), m, relative to the target, in order; none: one straight leg.
    pin_friction_radius : float, default 0.0
        Radius of the friction circle of the rod in the ring, m: coefficient of friction times
        radius of the rod. The rod does not turn; the object's spin is opposed by this times the
        rod's force.

    Raises
    ------
    InvalidInput
        For way-points that are no places, and a radius that is negative.

    Examples
    --------
    >>> from cyclemap import DragBack
    >>> DragBack(way_points=((0.05, 0.0),)).way_points
    ((0.05, 0.0),)
    """

    way_points: tuple[tuple[float, float], ...] = ()
    pin_friction_radius: float = 0.0

    def __post_init__(self) -> None:
        radius = non_negative_number("pin friction radius", self.pin_friction_radius)
        vars(self).update(pin_friction_radius=radius, way_points=places_of(self.way_points))


def places_of(way_points: object) -> tuple[tuple[float, float], ...]:
    """Return way-points as pairs of finite floats, m, or raise InvalidInput."""
    places = list(np.atleast_1d(way_points)) if isinstance(way_points, np.ndarray) else way_points
    if not isinstance(places, (tuple, list)):
        raise InvalidInput(
            f"way-points must be places (x, y), m, such as ((0.05, 0.0),), not {places!r}"
        )
    return tuple(point("way-point", place) for place in places)
