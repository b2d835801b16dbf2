"""The curve on which a rod's centre lies while it touches the slider: the outline rounded by the rod's radius.

Its pieces are straight (rod on a side), arcs about corners (rod on a corner) or the parallel curve of an ellipse. Each
has a coordinate of its own in which contact point and normal are smooth, and which has no gaps when the radius changes.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import ClassVar, NamedTuple

from cyclemap.errors import InvalidInput
from cyclemap.mechanics.outline import Ellipse, Outline, Polygon

# Sides that turn by less than this (rad) go on as one: a vertex on a straight side is no corner.
STRAIGHT = 1e-9


class Contact(NamedTuple):
    """One contact in the slider's frame: its point and the angle of the outward normal."""

    x: float
    y: float
    normal: float

    def rod_centre(self, radius: float) -> tuple[float, float]:
        """Return where the centre of a touching rod is."""
        return self.x + radius * math.cos(self.normal), self.y + radius * math.sin(self.normal)


@dataclass(frozen=True)
class SidePiece:
    """Rod on a straight side; coordinate: distance of the contact from the side's first vertex."""

    side: int
    start: tuple[float, float]
    direction: tuple[float, float]
    normal: float
    low: float
    high: float
    kind: ClassVar[str] = "side"

    @property
    def geometry(self) -> tuple[float, ...]:
        """Numbers that place the piece, as the motion's functions take them."""
        return (*self.start, *self.direction, self.normal)

    def moved(self, geometry: tuple[float, ...]) -> "SidePiece":
        """Return the piece with other numbers in `geometry`, padded to five."""
        return replace(self, start=(geometry[0], geometry[1]), direction=(geometry[2], geometry[3]), normal=geometry[4])

    def contact(self, coordinate: float, radius: float) -> tuple[Contact, float]:
        """Return the contact, and the travel of the rod's centre along its curve per unit of coordinate."""
        x, y = self.start
        return Contact(x + coordinate * self.direction[0], y + coordinate * self.direction[1], self.normal), 1.0

    def normal_slope(self, coordinate: float) -> float:
        """Return the derivative of the normal's angle by the coordinate."""
        return 0.0


@dataclass(frozen=True)
class CornerPiece:
    """Rod of positive radius on a convex corner; coordinate: angle of the normal, from one side's to the next's."""

    corner: tuple[float, float]
    low: float
    high: float
    kind: ClassVar[str] = "corner"

    @property
    def geometry(self) -> tuple[float, ...]:
        """Numbers that place the piece, as the motion's functions take them."""
        return self.corner

    def moved(self, geometry: tuple[float, ...]) -> "CornerPiece":
        """Return the piece with other numbers in `geometry`, padded to five."""
        return replace(self, corner=(geometry[0], geometry[1]))

    def contact(self, coordinate: float, radius: float) -> tuple[Contact, float]:
        """Return the contact, and the travel of the rod's centre along its curve per unit of coordinate."""
        return Contact(*self.corner, coordinate), radius

    def normal_slope(self, coordinate: float) -> float:
        """Return the derivative of the normal's angle by the coordinate."""
        return 1.0


@dataclass(frozen=True)
class EllipsePiece:
    """Rod on an ellipse; coordinate: eccentric angle, without end."""

    semi_x: float
    semi_y: float
    low: float = -math.inf
    high: float = math.inf
    kind: ClassVar[str] = "ellipse"

    @property
    def geometry(self) -> tuple[float, ...]:
        """Numbers that place the piece, as the motion's functions take them."""
        return self.semi_x, self.semi_y

    def moved(self, geometry: tuple[float, ...]) -> "EllipsePiece":
        """Return the piece with other numbers in `geometry`, padded to five."""
        return replace(self, semi_x=geometry[0], semi_y=geometry[1])

    def contact(self, coordinate: float, radius: float) -> tuple[Contact, float]:
        """Return the contact, and the travel of the rod's centre along its curve per unit of coordinate."""
        c, s = math.cos(coordinate), math.sin(coordinate)
        speed = math.hypot(self.semi_x * s, self.semi_y * c)
        normal = math.atan2(self.semi_x * s, self.semi_y * c)
        return Contact(self.semi_x * c, self.semi_y * s, normal), speed + radius * self.semi_x * self.semi_y / speed**2

    def normal_slope(self, coordinate: float) -> float:
        """Return the derivative of the normal's angle by the coordinate."""
        c, s = math.cos(coordinate), math.sin(coordinate)
        return self.semi_x * self.semi_y / ((self.semi_x * s) ** 2 + (self.semi_y * c) ** 2)


@dataclass(frozen=True)
class RingPiece:
    """Rod in the ring: a contact that stays at one point of the slider."""

    hitch: tuple[float, float]
    low: float = -math.inf
    high: float = math.inf
    kind: ClassVar[str] = "ring"

    @property
    def geometry(self) -> tuple[float, ...]:
        """Numbers that place the piece, as the motion's functions take them."""
        return self.hitch

    def moved(self, geometry: tuple[float, ...]) -> "RingPiece":
        """Return the piece with other numbers in `geometry`, padded to five."""
        return replace(self, hitch=(geometry[0], geometry[1]))

    def normal_slope(self, coordinate: float) -> float:
        """Return zero: the normal means nothing."""
        return 0.0

    def contact(self, coordinate: float, radius: float) -> tuple[Contact, float]:
        """Return the contact; its normal means nothing."""
        return Contact(*self.hitch, 0.0), 1.0


OutlinePiece = SidePiece | CornerPiece | EllipsePiece
Piece = OutlinePiece | RingPiece


@lru_cache(maxsize=256)
def contact_curve(outline: Outline, radius: float) -> tuple[OutlinePiece, ...]:
    """Return the curve's pieces counter-clockwise, starting with side 0; lengths as in the outline and the radius.

    In a concave corner the rod touches both sides before it reaches the vertex; the sides end there. A side too short
    for the rod to touch has low > high.
    """
    if isinstance(outline, Ellipse):
        return (EllipsePiece(outline.semi_x, outline.semi_y),)
    sides = [_side_piece(outline, side, radius) for side in range(outline.sides)]
    pieces: list[OutlinePiece] = []
    for side, following in zip(sides, [*sides[1:], sides[0]], strict=True):
        pieces.append(side)
        turn = _turn(side, following)
        if radius > 0.0 and turn > STRAIGHT:
            pieces.append(CornerPiece(following.start, side.normal, side.normal + turn))
    return tuple(pieces)


def side_coordinate(
    outline: Outline, pieces: tuple[OutlinePiece, ...], side: int, fraction: float
) -> tuple[int, float]:
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
    index, piece = next((i, p) for i, p in enumerate(pieces) if isinstance(p, SidePiece) and p.side == side)
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
    return SidePiece(side, (float(a[0]), float(a[1])), (edge[0] / length, edge[1] / length), normal, low, high)


def _concave_reach(edge: tuple[float, float], following: tuple[float, float]) -> float:
    """Tangent of half the angle by which a corner turns right; zero for a convex one."""
    turn = math.atan2(edge[0] * following[1] - edge[1] * following[0], edge[0] * following[0] + edge[1] * following[1])
    return math.tan(-turn / 2.0) if turn < 0.0 else 0.0


def _turn(side: SidePiece, following: SidePiece) -> float:
    """Angle from one side's normal to the next one's, in (-pi, pi]."""
    turn = following.normal - side.normal
    return math.pi - (math.pi - turn) % (2.0 * math.pi)
