"""The curve on which a rod's centre lies while it touches the slider: the outline rounded by the rod's radius.

Its pieces are straight (rod on a side), arcs about corners (rod on a corner) or the parallel curve of an ellipse. Each
has a coordinate of its own in which contact point and normal are smooth, and which has no gaps when the radius changes.
"""

import math
from dataclasses import dataclass

from cyclemap.errors import InvalidInput
from cyclemap.mechanics.outline import Ellipse, Outline, Polygon


@dataclass(frozen=True)
class Contact:
    """One contact in the slider's frame: point (x, y), angle of the outward normal, and `metric`: how far the rod's
    centre moves along its curve per unit of the piece's coordinate."""

    x: float
    y: float
    normal: float
    metric: float


@dataclass(frozen=True)
class ContactSlope:
    """Derivatives of a contact by the piece's coordinate, and of its metric by the rod's radius."""

    x: float
    y: float
    normal: float
    metric: float
    metric_by_radius: float


@dataclass(frozen=True)
class SidePiece:
    """Rod on a straight side; coordinate: distance of the contact from the side's first vertex."""

    side: int
    start: tuple[float, float]
    direction: tuple[float, float]
    low: float
    high: float
    normal: float

    def contact(self, coordinate: float, radius: float) -> Contact:
        """Return the contact at a coordinate."""
        x, y = self.start
        return Contact(x + coordinate * self.direction[0], y + coordinate * self.direction[1], self.normal, 1.0)

    def slope(self, coordinate: float, radius: float) -> ContactSlope:
        """Return its derivatives."""
        return ContactSlope(*self.direction, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class CornerPiece:
    """Rod of positive radius on a convex corner; coordinate: angle of the normal, from one side's to the next's."""

    corner: tuple[float, float]
    low: float
    high: float

    def contact(self, coordinate: float, radius: float) -> Contact:
        """Return the contact at a coordinate."""
        return Contact(*self.corner, coordinate, radius)

    def slope(self, coordinate: float, radius: float) -> ContactSlope:
        """Return its derivatives."""
        return ContactSlope(0.0, 0.0, 1.0, 0.0, 1.0)


@dataclass(frozen=True)
class EllipsePiece:
    """Rod on an ellipse; coordinate: eccentric angle, without end."""

    semi_x: float
    semi_y: float
    low: float = -math.inf
    high: float = math.inf

    def contact(self, coordinate: float, radius: float) -> Contact:
        """Return the contact at a coordinate."""
        c, s = math.cos(coordinate), math.sin(coordinate)
        speed = math.hypot(self.semi_x * s, self.semi_y * c)
        turning = self.semi_x * self.semi_y / speed**2
        normal = math.atan2(self.semi_x * s, self.semi_y * c)
        return Contact(self.semi_x * c, self.semi_y * s, normal, speed + radius * turning)

    def slope(self, coordinate: float, radius: float) -> ContactSlope:
        """Return its derivatives."""
        c, s = math.cos(coordinate), math.sin(coordinate)
        speed = math.hypot(self.semi_x * s, self.semi_y * c)
        turning = self.semi_x * self.semi_y / speed**2
        speed_slope = (self.semi_x**2 - self.semi_y**2) * s * c / speed
        metric = speed_slope * (1.0 - 2.0 * radius * turning / speed)
        return ContactSlope(-self.semi_x * s, self.semi_y * c, turning, metric, turning)


Piece = SidePiece | CornerPiece | EllipsePiece


def contact_curve(outline: Outline, radius: float) -> tuple[Piece, ...]:
    """Return the curve's pieces counter-clockwise, starting with side 0; lengths as in the outline and the radius.

    In a concave corner the rod touches both sides before it reaches the vertex; the sides end there. A side too short
    for the rod to touch has low > high.
    """
    if isinstance(outline, Ellipse):
        return (EllipsePiece(outline.semi_x, outline.semi_y),)
    sides = [_side_piece(outline, side, radius) for side in range(outline.sides)]
    pieces: list[Piece] = []
    for side, following in zip(sides, [*sides[1:], sides[0]], strict=True):
        pieces.append(side)
        turn = _turn(side, following)
        if radius > 0.0 and turn > 0.0:
            pieces.append(CornerPiece(following.start, side.normal, side.normal + turn))
    return tuple(pieces)


def side_coordinate(outline: Outline, side: int, fraction: float, radius: float) -> tuple[int, float]:
    """Return (piece, coordinate) of the contact at a fraction of a side, from its first vertex.

    On an ellipse, whose only side is 0, the fraction is of the full eccentric angle. Raises InvalidInput for a side
    or fraction that does not exist or that the rod cannot reach.
    """
    if isinstance(side, bool) or side != int(side) or not 0 <= side < outline.sides:
        raise InvalidInput(f"side {side!r} does not exist: this outline has sides 0 to {outline.sides - 1}")
    if not 0.0 <= fraction <= 1.0:
        raise InvalidInput(f"contact fraction {fraction!r} lies outside the side: it runs from 0 to 1")
    if isinstance(outline, Ellipse):
        return 0, 2.0 * math.pi * fraction
    pieces = contact_curve(outline, radius)
    index = next(i for i, p in enumerate(pieces) if isinstance(p, SidePiece) and p.side == side)
    piece = pieces[index]
    a, b = outline.array[int(side)], outline.array[(int(side) + 1) % outline.sides]
    coordinate = fraction * math.hypot(*(b - a))
    if not piece.low <= coordinate <= piece.high:
        raise InvalidInput(f"the rod cannot touch side {side} at fraction {fraction}: a concave corner is in its way")
    return index, coordinate


def _side_piece(outline: Polygon, side: int, radius: float) -> SidePiece:
    a, b = outline.array[side], outline.array[(side + 1) % outline.sides]
    edge = b - a
    length = math.hypot(*edge)
    before = a - outline.array[side - 1]
    after = outline.array[(side + 2) % outline.sides] - b
    low = radius * _concave_reach(before, edge)
    high = length - radius * _concave_reach(edge, after)
    normal = math.atan2(-edge[0], edge[1])
    return SidePiece(side, (float(a[0]), float(a[1])), (edge[0] / length, edge[1] / length), low, high, normal)


def _concave_reach(edge: tuple[float, float], following: tuple[float, float]) -> float:
    """Tangent of half the angle by which a corner turns right; zero for a convex one."""
    turn = math.atan2(edge[0] * following[1] - edge[1] * following[0], edge[0] * following[0] + edge[1] * following[1])
    return math.tan(-turn / 2.0) if turn < 0.0 else 0.0


def _turn(side: SidePiece, following: SidePiece) -> float:
    """Angle from one side's normal to the next one's, in (-pi, pi]."""
    turn = following.normal - side.normal
    return math.pi - (math.pi - turn) % (2.0 * math.pi)
