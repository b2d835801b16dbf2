"""The curve on which a rod's centre lies while it touches the slider: the outline rounded by the
rod's radius.

Its pieces are straight (rod on a side), arcs about corners (rod on a corner) or the parallel curve
of an ellipse. Each has a coordinate of its own in which contact point and normal are smooth, and
which has no gaps when the radius changes. Around a concave outline these pieces cross: only what no
other side overlaps is kept, so that pieces end in wedges, where the rod touches two places at once,
and pockets that the rod fits but cannot enter have loops of their own. A rod that moves straight
first touches the outline where its way meets this curve.
"""

import math
from bisect import insort
from collections import defaultdict
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cyclemap.arrays import TWO_PI, Array
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.mechanics.outline import Ellipse, Outline, Polygon
from cyclemap.mechanics.slider import SidePush, Slider

# Sides that turn by less than this (rad) go on as one: a vertex on a straight side is no corner.
STRAIGHT = 1e-9
# Rounding of a distance, and the least change of the radius that clearly exceeds it, per size of
# outline and rod.
_ROUNDING, _NUDGE = 4e-15, 1e-13
# Radii tried, in nudges: a rod exactly as wide as a notch counts as too wide rather than as
# fitting.
_NUDGES = (0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 5.0, -5.0, 7.0, -7.0)
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


class Contact(NamedTuple):
    """One contact in the slider's frame: point, angle of the outward normal, and by the coordinate
    the derivative of that and the travel of the rod's centre along its curve.
    """

    x: float
    y: float
    normal: float
    turning: float
    travel: float

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

    def contact(self, coordinate: float, radius: float) -> Contact:
        """Return the contact of a rod of a radius."""
        (x, y), (along_x, along_y) = self.start, self.direction
        place = x + coordinate * along_x, y + coordinate * along_y
        return Contact(*place, self.normal, 0.0, 1.0)


@dataclass(frozen=True)
class CornerPiece:
    """Rod of positive radius on a convex corner; coordinate: angle of the normal, from one side's
    to the next's.
    """

    corner: tuple[float, float]
    low: float
    high: float

    def contact(self, coordinate: float, radius: float) -> Contact:
        """Return the contact of a rod of a radius."""
        return Contact(*self.corner, coordinate, 1.0, radius)


@dataclass(frozen=True)
class EllipsePiece:
    """Rod on an ellipse; coordinate: eccentric angle, without end."""

    semi_x: float
    semi_y: float
    low: float = -math.inf
    high: float = math.inf

    def contact(self, coordinate: float, radius: float) -> Contact:
        """Return the contact of a rod of a radius."""
        (a, b), c, s = (self.semi_x, self.semi_y), math.cos(coordinate), math.sin(coordinate)
        speed = math.hypot(a * s, b * c)
        turning = a * b / speed**2
        normal = math.atan2(a * s, b * c)
        return Contact(a * c, b * s, normal, turning, speed + radius * turning)


OutlinePiece = SidePiece | CornerPiece | EllipsePiece
# What joins two pieces: the normal goes on; it jumps at a convex corner (no radius); the rod
# touches two places.
Junction = Literal["smooth", "corner", "wedge"]


@dataclass(frozen=True)
class ContactCurve:
    """The curve of a rod of one radius around one outline: its pieces counter-clockwise, and how
    they follow.

    `after[i]` and `before[i]` are the pieces at the high and the low end of piece i, `junctions[i]`
    is what joins i to after[i]. Pieces form closed loops: one around the object, one for each
    pocket that the rod fits but cannot enter.
    """

    radius: float
    pieces: tuple[OutlinePiece, ...]
    after: tuple[int, ...]
    before: tuple[int, ...]
    junctions: tuple[Junction, ...]

    def contacts_at_end(self, piece: int) -> tuple[Contact, Contact]:
        """Return the contacts where a piece ends and the next one begins; in a wedge the rod has
        both at once.
        """
        ends, begins = self.pieces[piece], self.pieces[self.after[piece]]
        return ends.contact(ends.high, self.radius), begins.contact(begins.low, self.radius)


@lru_cache(maxsize=256)
def contact_curve(outline: Outline, radius: float) -> ContactCurve:
    """Return the curve of a rod's centre: its points are `radius` from the outline, to some 1e-13
    of its size.

    What that cannot decide (a rod as wide as a notch) comes out as for a slightly thicker or
    thinner rod.
    """
    if isinstance(outline, Ellipse):
        return ContactCurve(
            radius, (EllipsePiece(outline.semi_x, outline.semi_y),), (0,), (0,), ("smooth",)
        )
    scale = radius + float(np.abs(outline.array).max())
    for nudge in _NUDGES:
        tried = radius + nudge * _NUDGE * scale
        curve = _trimmed(outline, tried, _ROUNDING * scale) if tried > 0.0 or nudge == 0.0 else None
        if curve is not None:
            return replace(curve, radius=radius)
    raise ConvergenceError(
        f"the contact curve of a rod of radius {radius} does not close: change the radius slightly"
    )


def side_coordinate(
    outline: Outline, pieces: tuple[OutlinePiece, ...], side: int, fraction: float
) -> tuple[int, float, float]:
    """Return piece, coordinate, and its slope by the fraction, of the contact at a fraction of a
    side from its start, as a SidePush has them.

    On an ellipse, whose only side is 0, the fraction is of the full eccentric angle. Raises
    InvalidInput for a side that does not exist, and a place that the rod cannot reach.
    """
    if not side < outline.sides:
        raise InvalidInput(
            f"side {side} does not exist: this outline has sides 0 to {outline.sides - 1}"
        )
    if isinstance(outline, Ellipse):
        return 0, TWO_PI * fraction, TWO_PI
    length = _raw_side(outline, side).high
    for index, piece in enumerate(pieces):
        if (
            isinstance(piece, SidePiece)
            and piece.side == side
            and piece.low <= fraction * length <= piece.high
        ):
            return index, fraction * length, length
    raise InvalidInput(
        f"the rod cannot touch side {side} at fraction {fraction}: a concave corner is in its way"
    )


def side_place(
    outline: Outline, piece: OutlinePiece, coordinate: float
) -> tuple[int, float, float] | None:
    """Return the side that a contact is on, at which fraction of it from its start, as
    `side_coordinate` takes them, and how far that is, of an ellipse on the circle about it; None on
    a corner.
    """
    if isinstance(piece, EllipsePiece):
        return 0, coordinate / TWO_PI, coordinate * outline.extent
    if isinstance(piece, CornerPiece) or isinstance(outline, Ellipse):
        return None
    return piece.side, coordinate / _raw_side(outline, piece.side).high, coordinate


class _Mark(NamedTuple):
    """A place on an untrimmed piece where the curve may end or begin; both marks of a junction
    share its key.
    """

    coordinate: float
    ends: bool
    junction: int


def _trimmed(outline: Polygon, radius: float, rounding: float) -> ContactCurve | None:
    """Return the curve, None where rounding leaves some end without its counterpart."""
    raw, marks, junctions = _untrimmed(outline, radius)
    trims = radius > 0.0 and not outline.is_convex
    if trims:
        for first, second in _near(raw, radius):
            for at_one, at_other, one_ends in _crossings(
                raw[first], raw[second], radius, outline.sides
            ):
                insort(marks[first], _Mark(at_one, one_ends, len(junctions)))
                insort(marks[second], _Mark(at_other, not one_ends, len(junctions)))
                junctions.append("wedge")
    pieces: list[OutlinePiece] = []
    begun: dict[int, int] = {}
    ended: dict[int, int] = {}
    side = 0
    for whole, on_it in zip(raw, marks, strict=True):
        # A corner's piece follows that of the side before it.
        side = whole.side if isinstance(whole, SidePiece) else side
        spans = [
            (a, b)
            for a, b in pairwise(on_it)
            if b.ends and not a.ends and a.coordinate < b.coordinate
        ]
        if trims and spans:
            own = [side] if isinstance(whole, SidePiece) else [side, (side + 1) % outline.sides]
            middles = [whole.contact((a.coordinate + b.coordinate) / 2.0, radius) for a, b in spans]
            away = _clearance(
                outline, own, np.array([middle.rod_centre(radius) for middle in middles])
            )
            spans = [
                span
                for span, gap in zip(spans, away.tolist(), strict=True)
                if gap >= radius - rounding
            ]
        for a, b in spans:
            begun[a.junction] = ended[b.junction] = len(pieces)
            pieces.append(replace(whole, low=a.coordinate, high=b.coordinate))
    if not pieces or begun.keys() != ended.keys():
        return None
    key_at_low, key_at_high = ({piece: key for key, piece in at.items()} for at in (begun, ended))
    order = range(len(pieces))
    after, before = (
        tuple(begun[key_at_high[i]] for i in order),
        tuple(ended[key_at_low[i]] for i in order),
    )
    return ContactCurve(
        radius, tuple(pieces), after, before, tuple(junctions[key_at_high[i]] for i in order)
    )


_RawPiece = SidePiece | CornerPiece


def _untrimmed(
    outline: Polygon, radius: float
) -> tuple[list[_RawPiece], list[list[_Mark]], list[Junction]]:
    """Sides and convex corners in their order, with a mark at each end where the next one follows
    without crossing.
    """
    raw: list[_RawPiece] = []
    marks: dict[int, list[_Mark]] = defaultdict(list)
    junctions: list[Junction] = []
    count = outline.sides
    sides = [_raw_side(outline, side) for side in range(count)]
    turns = [_turn(sides[side], sides[(side + 1) % count]) for side in range(count)]
    for side, turn in zip(sides, turns, strict=True):
        raw.append(side)
        if radius > 0.0 and turn > STRAIGHT:
            raw.append(
                CornerPiece(sides[(side.side + 1) % count].start, side.normal, side.normal + turn)
            )
    for index, piece in enumerate(raw):
        turn = turns[piece.side] if isinstance(piece, SidePiece) else 0.0
        if radius > 0.0 and turn < -STRAIGHT:
            continue
        kind: Junction = "smooth"
        if radius == 0.0 and abs(turn) > STRAIGHT:
            kind = "corner" if turn > 0.0 else "wedge"
        following = (index + 1) % len(raw)
        marks[index].append(_Mark(piece.high, True, len(junctions)))
        marks[following].insert(0, _Mark(raw[following].low, False, len(junctions)))
        junctions.append(kind)
    return raw, [marks[index] for index in range(len(raw))], junctions


def _raw_side(outline: Polygon, side: int) -> SidePiece:
    a, b = outline.array[side], outline.array[(side + 1) % outline.sides]
    x, y = (b - a).tolist()
    length = math.hypot(x, y)
    return SidePiece(
        side, (float(a[0]), float(a[1])), (x / length, y / length), math.atan2(-x, y), 0.0, length
    )


def _turn(side: SidePiece, following: SidePiece) -> float:
    """Angle from one side's normal to the next one's, in (-pi, pi]."""
    turn = following.normal - side.normal
    return math.pi - (math.pi - turn) % TWO_PI


def _near(raw: list[_RawPiece], radius: float) -> list[tuple[int, int]]:
    """Pairs (a, b), a < b, of pieces whose boxes overlap."""
    spans = np.zeros((len(raw), 2, 2))
    for span, piece in zip(spans, raw, strict=True):
        if isinstance(piece, SidePiece):
            span[:] = [
                piece.contact(at, radius).rod_centre(radius) for at in (piece.low, piece.high)
            ]
        else:
            span[:] = np.add(piece.corner, [[-radius], [radius]])
    low, high = spans.min(axis=1), spans.max(axis=1)
    near = np.all((low[:, None] <= high[None]) & (low[None] <= high[:, None]), axis=-1)
    return [(int(a), int(b)) for a, b in zip(*np.nonzero(np.triu(near, 1)), strict=True)]


def _clearance(outline: Polygon, own: list[int], places: Array) -> Array:
    """Distance of places (k, 2) from all sides but those that the piece itself belongs to."""
    edge = np.delete(np.roll(outline.array, -1, axis=0) - outline.array, own, axis=0)
    a = np.delete(outline.array, own, axis=0)
    offset = places[:, None] - a
    share = np.clip((offset * edge).sum(-1) / (edge * edge).sum(-1), 0.0, 1.0)
    away = offset - share[..., None] * edge
    return np.asarray(np.hypot(away[..., 0], away[..., 1]).min(axis=1))


def _crossings(
    a: _RawPiece, b: _RawPiece, radius: float, count: int
) -> list[tuple[float, float, bool]]:
    """(coordinate on a, coordinate on b, whether a ends there) of the places where two untrimmed
    pieces cross.
    """
    if isinstance(a, SidePiece):
        if isinstance(b, CornerPiece):
            crossings = _side_corner(a, b, radius)
        elif (b.side - a.side) % count in (1, count - 1):
            before, after = (a, b) if (b.side - a.side) % count == 1 else (b, a)
            turn = _turn(before, after)
            reach = radius * math.tan(-turn / 2.0)
            ends, begins = before.high - reach, reach
            crossings = (
                [(ends, begins, True) if before is a else (begins, ends, False)]
                if turn < -STRAIGHT
                else []
            )
        else:
            crossings = _side_side(a, b, radius)
    elif isinstance(b, SidePiece):
        crossings = [(at_a, at_b, not b_ends) for at_b, at_a, b_ends in _side_corner(b, a, radius)]
    else:
        crossings = _corner_corner(a, b, radius)
    return [
        (at_a, at_b, b_ends)
        for at_a, at_b, b_ends in crossings
        if a.low <= at_a <= a.high and b.low <= at_b <= b.high
    ]


def _side_side(a: SidePiece, b: SidePiece, radius: float) -> list[tuple[float, float, bool]]:
    (ax, ay), (bx, by) = a.direction, b.direction
    sine = ax * by - ay * bx
    if abs(sine) < STRAIGHT**2:
        return []
    # From the first end of a's line to that of b's; a normal is (y, -x) of its direction (x, y).
    x, y = (
        b.start[0] - a.start[0] + radius * (by - ay),
        b.start[1] - a.start[1] - radius * (bx - ax),
    )
    at_a = (x * by - y * bx) / sine
    # As the foot of the same point, so that both agree on it however flat the angle.
    return [(at_a, (at_a * ax - x) * bx + (at_a * ay - y) * by, sine < 0.0)]


def _side_corner(
    side: SidePiece, corner: CornerPiece, radius: float
) -> list[tuple[float, float, bool]]:
    (dx, dy), (x, y) = (
        side.direction,
        (corner.corner[0] - side.start[0], corner.corner[1] - side.start[1]),
    )
    foot, height = x * dx + y * dy, x * dy - y * dx
    under = height * (2.0 * radius - height)
    if under <= 0.0:
        return []
    crossings = []
    for root in (-math.sqrt(under), math.sqrt(under)):
        from_corner = root * dx + (radius - height) * dy, root * dy - (radius - height) * dx
        crossings.append((foot + root, _angle_on(corner, *from_corner), root < 0.0))
    return crossings


def _corner_corner(
    a: CornerPiece, b: CornerPiece, radius: float
) -> list[tuple[float, float, bool]]:
    x, y = (b.corner[0] - a.corner[0]) / 2.0, (b.corner[1] - a.corner[1]) / 2.0
    half = math.hypot(x, y)
    if half >= radius:
        return []
    root = math.sqrt((radius - half) * (radius + half)) / half
    crossings = []
    for across in (-root, root):
        px, py = -across * y, across * x
        crossings.append((_angle_on(a, x + px, y + py), _angle_on(b, px - x, py - y), across < 0.0))
    return crossings


def _angle_on(corner: CornerPiece, x: float, y: float) -> float:
    """Angle of (x, y), by whole turns the first one from the corner's low end on."""
    return corner.low + (math.atan2(y, x) - corner.low) % TWO_PI


# -- where a rod that moves straight first touches: of a push, and of any straight way


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
        for travel, coordinate, enters in _crossings_on_way(piece, radius, starts, toward):
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


def _crossings_on_way(
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
            angle = middle + np.remainder(np.arctan2(y, x) - middle + np.pi, TWO_PI) - np.pi
            meetings.append((sign * half - along, angle, np.full(len(starts), sign < 0.0)))
        return meetings
    a, b, meetings = piece.semi_x, piece.semi_y, []
    for sign in (-1.0, 1.0):
        # Between the two tangents along the path the distance from it changes sign once.
        facing = np.arctan2(sign * toward[:, 1], sign * toward[:, 0])
        low, high = (
            np.arctan2(b * np.sin(tangent), a * np.cos(tangent))
            for tangent in (facing - np.pi / 2.0, facing + np.pi / 2.0)
        )
        high = low + np.remainder(high - low, TWO_PI)
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
