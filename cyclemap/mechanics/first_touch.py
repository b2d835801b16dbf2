"""Where a rod that moves straight first touches an outline."""

import math

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.contact_curve import CornerPiece, OutlinePiece, SidePiece
from cyclemap.mechanics.outline import Ellipse, Outline

Array = NDArray[np.float64]
Touch = tuple[float, int, float]

# Pieces reach this far over their ends, so that rounding leaves no gap where they meet; by the second, per radius, as
# well, since wedges are no sharper than a curve's rounding, and a rod that is no point keeps inside its curve there.
_SEAM, _WEDGE_SEAM = 1e-12, 1e-8
# Travels that differ by less are one touch, which belongs to the piece that it lies on, not over the end of.
_SAME_TRAVEL = 1e-12
# A rod this far inside still counts as touching.
_OVERLAP = 1e-9


def first_touch(pieces: tuple[OutlinePiece, ...], radius: float, start: Array, direction: float) -> Touch | None:
    """Return (travel, piece, coordinate) of the first touch, None if there is none; everything in the slider's frame.

    The rod must not overlap the object at its start. Where it touches two pieces at once, in a wedge, one of them is
    returned, at its end.
    """
    toward = np.array((math.cos(direction), math.sin(direction)))
    seam = _SEAM + _WEDGE_SEAM * radius
    touches: list[tuple[float, Touch]] = []
    for index, piece in enumerate(pieces):
        for travel, coordinate in _meetings(piece, radius, start, toward):
            contact, _ = piece.contact(coordinate, radius)
            enters = math.cos(contact.normal - direction) < 0.0
            beyond = max(piece.low - coordinate, coordinate - piece.high, 0.0)
            if travel >= -_OVERLAP and enters and beyond <= seam:
                touches.append((beyond, (travel, index, min(max(coordinate, piece.low), piece.high))))
    if not touches:
        return None
    first = min(travel for _, (travel, _, _) in touches)
    travel, index, coordinate = min(touch for touch in touches if touch[1][0] <= first + _SAME_TRAVEL)[1]
    return max(travel, 0.0), index, coordinate


def overlaps(outline: Outline, radius: float, place: Array) -> bool:
    """Whether a rod at a place reaches into an outline."""
    inside = bool(outline.contains(place))
    return inside or outline.distance((float(place[0]), float(place[1]))) < radius - _OVERLAP


def _meetings(piece: OutlinePiece, radius: float, start: Array, toward: Array) -> list[tuple[float, float]]:
    """(travel, coordinate) of the places where the rod's path meets a piece of the contact curve, or its extension."""
    if isinstance(piece, SidePiece):
        normal = np.array((math.cos(piece.normal), math.sin(piece.normal)))
        closing = float(normal @ toward)
        if closing >= 0.0:
            return []
        travel = float(normal @ (np.asarray(piece.start) - start) + radius) / closing
        return [(travel, float((start + travel * toward - piece.start) @ np.asarray(piece.direction)))]
    if isinstance(piece, CornerPiece):
        lever = start - np.asarray(piece.corner)
        along = float(lever @ toward)
        under = along**2 - float(lever @ lever) + radius**2
        if under < 0.0:
            return []
        travel = -along - math.sqrt(under)
        x, y = lever + travel * toward
        # The piece's angles may lie a turn away from atan2's.
        return [(travel, math.atan2(y, x) + 2.0 * math.pi * turn) for turn in (-1, 0, 1)]
    # The distance to a convex outline is convex along the path: its minimum splits the two places where it is r.
    from scipy.optimize import brentq, minimize_scalar

    ellipse = Ellipse(piece.semi_x, piece.semi_y)

    def gap(travel: float) -> float:
        place = start + travel * toward
        distance, _ = ellipse.nearest((float(place[0]), float(place[1])))
        return (-distance if ellipse.contains(place) else distance) - radius

    reach = float(np.hypot(*start)) + piece.semi_x + piece.semi_y + radius
    nearest = minimize_scalar(gap, bounds=(-2.0 * reach, 2.0 * reach), method="bounded", options={"xatol": 1e-9}).x
    if gap(nearest) >= 0.0:
        return []
    travel = float(brentq(gap, nearest - 4.0 * reach, nearest, xtol=1e-15, rtol=1e-14))
    x, y = (start + travel * toward).tolist()
    return [(travel, ellipse.nearest((x, y))[1])]
