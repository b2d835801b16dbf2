"""Where a rod that moves straight first touches an outline: of a push, and of any straight way."""

import math

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.mechanics.contact_curve import (
    CornerPiece,
    EllipsePiece,
    OutlinePiece,
    SidePiece,
    contact_curve,
    side_coordinate,
)
from cyclemap.mechanics.slider import SidePush, Slider

# Pieces reach this far over their ends, so that rounding leaves no gap where they meet; by the
# second, per radius, as well, since wedges are no sharper than a curve's rounding, and a rod that
# is no point keeps inside its curve there.
_SEAM, _WEDGE_SEAM = 1e-12, 1e-8
# Travels that differ by less are one touch, which belongs to the piece that it lies on, not over
# the end of.
_SAME_TRAVEL = 1e-12
# A rod this far inside still counts as touching.
OVERLAP = 1e-9
# Halvings that find an angle to rounding.
_HALVINGS = 54


def first_contact(slider: Slider, push: SidePush, radius: float) -> tuple[Array, Array]:
    """Return the centre of the rod as it first touches, (2,) m, and the push's unit vector, (2,).

    Both in the object's frame.
    radius : of the rod, m.

    Raises InvalidInput for a side that is not there, and a place that the rod cannot touch.

    >>> place, way = first_contact(Slider.mit("rect1"), SidePush(), 0.00475)
    >>> (1e3 * place).round(6).tolist(), (way.round(9) + 0.0).tolist()
    ([-18.0, 49.75], [0.0, -1.0])
    """
    pieces = contact_curve(slider.outline, radius).pieces
    index, coordinate, _ = side_coordinate(slider.outline, pieces, push.side, push.fraction)
    contact = pieces[index].contact(coordinate, radius)
    way = contact.normal + math.pi + push.angle
    return np.array(contact.rod_centre(radius)), np.array((math.cos(way), math.sin(way)))


def first_touches(
    pieces: tuple[OutlinePiece, ...], radius: float, starts: Array, directions: Array
) -> tuple[Array, NDArray[np.int64], Array]:
    """Return travel, piece and coordinate (n,) of the first touches of rods from starts (n, 2) in
    directions (n,), rad.

    A rod that starts inside touched behind its start: its travel is negative. nan where a rod meets
    nothing. Where a rod touches two pieces at once, in a wedge, one of them is returned, at its
    end.
    """
    count = len(starts)
    toward = np.column_stack([np.cos(directions), np.sin(directions)])
    travels, entering, coordinates, over, owners = [], [], [], [], []
    for index, piece in enumerate(pieces):
        for travel, coordinate, enters in _crossings(piece, radius, starts, toward):
            beyond = np.maximum(np.maximum(piece.low - coordinate, coordinate - piece.high), 0.0)
            on = np.isfinite(travel) & (beyond <= _SEAM + _WEDGE_SEAM * radius)
            travels.append(np.where(on, travel, np.nan))
            entering.append(on & enters)
            over.append(beyond)
            coordinates.append(np.clip(coordinate, piece.low, piece.high))
            owners.append(index)
    crossed, enters = np.array(travels), np.array(entering)
    # Inside, the last crossing behind the start was an entry: that one counts, else the first entry
    # ahead. A rod that touches and moves away has left.
    behind = np.where(crossed < np.where(enters, -OVERLAP, OVERLAP), crossed, -np.inf)
    last, column = np.argmax(behind, axis=0), np.arange(count)
    inside = np.isfinite(behind[last, column]) & enters[last, column]
    ahead = np.where(enters & (crossed >= -OVERLAP), crossed, np.inf)
    first = ahead <= ahead.min(axis=0) + _SAME_TRAVEL
    chosen = np.where(inside, last, np.argmin(np.where(first, over, np.inf), axis=0))
    known = inside | np.isfinite(ahead[chosen, column])
    return (
        np.where(known, crossed[chosen, column], np.nan),
        np.array(owners)[chosen],
        np.array(coordinates)[chosen, column],
    )


def _crossings(
    piece: OutlinePiece, radius: float, starts: Array, toward: Array
) -> list[tuple[Array, Array, NDArray[np.bool_]]]:
    """Where lines cross a piece of the contact curve: travel, coordinate, and whether they enter
    there, (n,) each.
    """
    if isinstance(piece, SidePiece):
        normal = np.array((math.cos(piece.normal), math.sin(piece.normal)))
        closing = toward @ normal
        with np.errstate(divide="ignore", invalid="ignore"):
            travel = ((np.asarray(piece.start) - starts) @ normal + radius) / closing
            place = starts + travel[:, None] * toward
            along = (place - piece.start) @ np.asarray(piece.direction)
        return [(travel, along, closing < 0.0)]
    if isinstance(piece, CornerPiece):
        lever = starts - np.asarray(piece.corner)
        along = np.sum(lever * toward, axis=1)
        with np.errstate(invalid="ignore"):
            half = np.sqrt(along**2 - np.sum(lever * lever, axis=1) + radius**2)
        meetings, middle = [], 0.5 * (piece.low + piece.high)
        for sign in (-1.0, 1.0):
            x, y = (lever + (sign * half - along)[:, None] * toward).T
            angle = middle + np.remainder(np.arctan2(y, x) - middle + np.pi, 2.0 * np.pi) - np.pi
            meetings.append((sign * half - along, angle, np.full(len(starts), sign < 0.0)))
        return meetings
    a, b, meetings = piece.semi_x, piece.semi_y, []
    for sign in (-1.0, 1.0):
        # Between the two tangents along the path the distance from it changes sign once.
        facing = np.arctan2(sign * toward[:, 1], sign * toward[:, 0])
        low = np.arctan2(b * np.sin(facing - np.pi / 2.0), a * np.cos(facing - np.pi / 2.0))
        high = np.arctan2(b * np.sin(facing + np.pi / 2.0), a * np.cos(facing + np.pi / 2.0))
        high = low + np.remainder(high - low, 2.0 * np.pi)
        aside, _ = _from_line(piece, radius, low, starts, toward)
        meets = aside * _from_line(piece, radius, high, starts, toward)[0] < 0.0
        for _ in range(_HALVINGS):
            angle = 0.5 * (low + high)
            same = _from_line(piece, radius, angle, starts, toward)[0] * aside > 0.0
            low, high = np.where(same, angle, low), np.where(same, high, angle)
        travel = _from_line(piece, radius, angle, starts, toward)[1]
        meetings.append((np.where(meets, travel, np.nan), angle, np.full(len(starts), sign < 0.0)))
    return meetings


def _from_line(
    piece: EllipsePiece, radius: float, angle: Array, starts: Array, toward: Array
) -> tuple[Array, Array]:
    """How far the rod's centre at an eccentric angle is beside the line, and along it."""
    c, s = np.cos(angle), np.sin(angle)
    speed = np.hypot(piece.semi_y * c, piece.semi_x * s)
    x = piece.semi_x * c + radius * piece.semi_y * c / speed - starts[:, 0]
    y = piece.semi_y * s + radius * piece.semi_x * s / speed - starts[:, 1]
    return toward[:, 0] * y - toward[:, 1] * x, toward[:, 0] * x + toward[:, 1] * y
