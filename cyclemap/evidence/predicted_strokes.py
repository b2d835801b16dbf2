"""Measured strokes as they are predicted: with what loop, where they end, and how that depends on
the surface; and where on the object the rod of measured pushes was, and which way it went, where a
table tells its places and no side and fraction, or such as the rod was far from.
"""

from __future__ import annotations

import cmath
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import Array, Mask, Place, Whole, shorter_way, turned
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.surface_parameters import (
    FIELD_REACH,
    FLOOR_NAMES,
    FRICTION_NAMES,
    PLATE_NAMES,
    field_factors,
)
from cyclemap.evidence.pushes.measured_strokes import (
    LARGEST_TIP_ERROR,
    SET_OFF,
    MeasuredDrag,
    MeasuredPush,
    told_push,
)
from cyclemap.evidence.tables.columns import RODS
from cyclemap.mechanics import MIT_SHAPE_NAMES, Material, Pose, QuasiStaticModel, SidePush, Slider
from cyclemap.mechanics.contact_curve import contact_curve, first_contact, first_touches, side_place
from cyclemap.mechanics.cycle_batch import derivative_units
from cyclemap.mechanics.engine.schema import PARAMETERS, SHAPES
from cyclemap.mechanics.engine.strokes import Strokes
from cyclemap.mechanics.foundation import FloorField
from cyclemap.mechanics.outline import Ellipse
from cyclemap.mechanics.plate_footprint import mean_pressure, plate_footprint
from cyclemap.mechanics.quasi_static import run_strokes
from cyclemap.mechanics.trajectory import Course

if TYPE_CHECKING:
    import pandas

# Where n strokes end: poses (n, 3), m and rad; derivatives (n, 3, k); which are taken to stay (n,).
StrokeEnds = tuple[Array, Array, Mask]

# A few strokes of many may have no answer where the rod grazes a tip: these count as if the object
# stayed.
FAILING = 0.05
# A rod that starts further inside the object than this, m, is in another frame: measured poses
# overlap by tenths of mm.
DEEPEST = 0.04
# What moves an object that is pushed, and one that is dragged.
_RESTING = (*FRICTION_NAMES, *FLOOR_NAMES, *PLATE_NAMES)
PUSH_NAMES = (*_RESTING, "pusher_friction")
DRAG_NAMES = (*_RESTING, "pin_friction_radius")
# What the engine calls the shapes.
ENGINE_NAMES = dict(zip((*FLOOR_NAMES, *PLATE_NAMES), SHAPES, strict=True))
# What a shift of the rod's path changes.
_SHIFTED = [PARAMETERS.index(name) for name in ("fraction", "angle", "distance")]
_THETA = PARAMETERS.index("theta")
_WORLD = (0.0, 0.0)
CONTACT = ("side", "fraction", "angle")
# Places that are further apart along a side (m), and ways (rad), are other contacts; contacts that
# scatter by more, in the standard deviation, are a push's own each.
_APART = (LARGEST_TIP_ERROR, math.radians(5.0))
_SCATTER = (SET_OFF, math.radians(2.0))
# Contacts that are told are passed over where the rod is so far from them, m.
_ELSEWHERE = 0.02
# Where fewer of the rods touch the object they are in another frame than it.
_FEWEST_TOUCH = 0.5
_NO_RODS = "the rod's places are told of other pushes alone"
_NO_SIDE = "the rod's places touch no side of the object"
# File names give fractions and angles to three decimals.
_ROUNDED = 6e-4
# Contacts as near as this to the protocol's (shares of a side, rad) go unsaid.
_HARDLY = 0.02
# Contacts that are told one by one.
_MOST_TOLD = 2


def loop_of_session(loop: CollectionLoop, slider: Slider, session: str = "") -> CollectionLoop:
    """Return the loop with another object, which rests as the material says.

    session : its name. Where the material saw it, the floor is as it was then, without a posterior,
        which is of the mean of sessions.
    """
    material = loop.material
    for seen in material.sessions:
        if seen.name == session:
            material = replace(material, floor=seen.shape, posterior=None)
    footprint = plate_footprint(material, slider)
    return replace(loop, slider=slider, material=material, footprint=footprint)


def loop_of_plate(loop: CollectionLoop, plate: str | None) -> CollectionLoop:
    """Return the loop with a plate of the MIT dataset, its ring where it was; with its own object
    for another name, or none.
    """
    if plate is None or plate == loop.slider.name or plate not in MIT_SHAPE_NAMES:
        return loop
    return loop_of_session(loop, Slider.mit(plate, loop.slider.hitch))


def frame_shift(material: Material, plate: str) -> Place:
    """Return what to add to the robot's places to have them in the frame of a plate's poses, m."""
    for frame in material.frames:
        if frame.plate == plate:
            return frame.x, frame.y
    return _WORLD


def push_from_contact(
    slider: Slider, radius: float, push: SidePush, start: Pose, end: Pose
) -> MeasuredPush:
    """Return a measured push whose rod, of a radius in m, went from its first touch on."""
    place, way = first_contact(slider, push, radius)
    tips = (start.to_world(*place), start.to_world(*(place + push.distance * way)))
    return MeasuredPush(start, end, *tips)


def predicted_ends(
    courses: Sequence[Course], most_failing: float = FAILING, derivatives: int = 0
) -> StrokeEnds:
    """Return where strokes end, with derivatives by so many of the engine's parameters.

    most_failing : share of the strokes that may have no answer: they are taken to stay. Raises as
        the first of them where more have none.
    """
    ran = run_strokes(courses, derivatives, most_failing)
    stayed = ran.status <= 0
    units = np.array([(course.unit, course.unit, 1.0) for course in courses]).reshape(-1, 3)
    begun = np.array([course.pose for course in courses]).reshape(-1, 3)
    ends = np.where(stayed[:, None], begun, ran.ended) * units
    slopes = np.where(stayed[:, None, None], 0.0, ran.derivatives[:, 3:6]) * units[..., None]
    return ends, slopes, stayed


def predicted_motions(courses: Sequence[Course], most_failing: float) -> Array:
    """Return how strokes turn the object, rad, and move it, m, in its own frame before: (n, 3); nan
    where they have no answer, else as `predicted_ends`.
    """
    ends, _, stayed = predicted_ends(courses, most_failing)
    motions = np.full(ends.shape, np.nan)
    for index in np.flatnonzero(~stayed).tolist():
        course = courses[index]
        x, y, theta = course.pose
        begun = Pose(course.unit * x, course.unit * y, theta)
        end_x, end_y, end_theta = ends[index].tolist()
        motions[index] = end_theta - theta, *begun.to_object(end_x, end_y)
    return motions


def predicted_push_ends(
    model: QuasiStaticModel,
    pushes: Sequence[MeasuredPush],
    shift: ArrayLike = _WORLD,
    names: tuple[str, ...] = (),
    target: Place | None = None,
    turns: ArrayLike = 0.0,
) -> StrokeEnds:
    """Return where pushes end whose rod paths are shifted (m; all alike, or (n, 2)), and whose
    objects lay turned from their start poses (rad; all alike, or (n,)).

    Derivatives (n, 3, k + 3) are by `names` of the mechanics, with a target by the floor's heights,
    by both components of the shift, and by that turn. An object that the rod does not touch stays,
    and so does one of the few (a twentieth at most) whose push has no answer.
    target : m, from which a floor's shape that varies with the place is told.
    """
    origin = target or _WORLD
    starts = np.array([(push.start.x, push.start.y, push.start.theta) for push in pushes])
    starts[:, 2] += turns
    touched, strokes = _from_first_touch(model, pushes, starts, np.asarray(shift))
    begins = [Pose(*start) for start in (starts[touched] - (*origin, 0.0)).tolist()]
    courses = [model.course(*both) for both in zip(strokes, begins, strict=True)]
    felt = []
    for stroke, begin in zip(strokes, begins, strict=True):
        # A quarter of the way ahead, as the engine takes it.
        ahead = cmath.rect(0.25 * model.unit * stroke.length, stroke.direction)
        place = complex(*model.slider.outline.centroid) + ahead
        felt.append(begin.to_world(place.real, place.imag))
    moved, slopes, still = predicted_ends(courses, FAILING, len(PARAMETERS))
    angles = [begin.theta for begin in begins]
    by_start = [_by_set_up(model, *both) for both in zip(strokes, angles, strict=True)]
    by_set_up = slopes[..., _SHIFTED] @ np.reshape(by_start, (-1, 3, 3))
    by_set_up[..., 2] += slopes[..., _THETA]
    by_touched = np.concatenate([_by_names(model, names, slopes, target, felt), by_set_up], axis=-1)
    ends = starts
    by = np.zeros((len(pushes), *by_touched.shape[1:]))
    # What stays is as its object lay.
    by[:, 2, -1] = 1.0
    stayed = np.full(len(pushes), True)
    ends[touched[~still]] = moved[~still] + np.array((*origin, 0.0))
    by[touched[~still]] = by_touched[~still]
    stayed[touched] = still
    return ends, by, stayed


def predicted_drag_ends(
    model: QuasiStaticModel,
    drags: Sequence[MeasuredDrag],
    pin_friction_radius: float,
    target: Place | None = None,
) -> StrokeEnds:
    """Return where drags end, each ring going straight to where it ended, as of pushes.

    Derivatives are by DRAG_NAMES, and with a target by the floor's heights.
    """
    origin = target or _WORLD
    courses = []
    felt = []
    for drag in drags:
        start = drag.start
        begin = Pose(start.x - origin[0], start.y - origin[1], start.theta)
        goal_x, goal_y = drag.end.to_world(*model.slider.hitch)
        goal = goal_x - origin[0], goal_y - origin[1]
        strokes = model.drag_strokes((goal,), pin_friction_radius)
        courses.append(model.course(strokes, begin))
        ring = begin.to_world(*model.slider.hitch)
        x, y = begin.to_world(*model.slider.outline.centroid)
        felt.append((x + 0.5 * (goal[0] - ring[0]), y + 0.5 * (goal[1] - ring[1])))
    ends, slopes, stayed = predicted_ends(courses, FAILING, len(PARAMETERS))
    by = _by_names(model, DRAG_NAMES, slopes, target, felt)
    return ends + np.array((*origin, 0.0)), by, stayed


def _from_first_touch(
    model: QuasiStaticModel, pushes: Sequence[MeasuredPush], starts: Array, shift: Array
) -> tuple[Whole, list[Strokes]]:
    """Which pushes touch the object that lies at `starts` (n, 3), and their strokes from there on.

    They go along with the object, so that they are differentiated by where they start and how far
    they go, too.
    """
    theta = starts[:, 2]
    tips = np.array([push.tip_start for push in pushes]) + shift
    rods = turned(tips - starts[:, :2], -theta) / model.unit
    toward = np.array([push.direction for push in pushes]) - theta
    travel, piece, coordinate = first_touches(model.curve.pieces, model.radius, rods, toward)
    for index in np.flatnonzero(travel * model.unit < -DEEPEST)[:1].tolist():
        at = pushes[index].tip_start
        pose = pushes[index].start
        raise InvalidInput(
            f"the rod at {at} m lies deep inside the object at {pose}: check the frames"
        )
    way = np.array([push.length for push in pushes]) / model.unit - travel
    touched = np.flatnonzero(way > 0.0)
    still = replace(model.drag_strokes((), 0.0), by_fraction=1.0, with_object=True)
    strokes = [
        replace(
            still,
            start_piece=int(piece[index]),
            start_coordinate=float(coordinate[index]),
            direction=float(toward[index]),
            length=float(way[index]),
        )
        for index in touched.tolist()
    ]
    return touched, strokes


def _by_set_up(model: QuasiStaticModel, strokes: Strokes, theta: float) -> Array:
    """Derivatives of a side push's start, angle and length (extents, rad) by a shift of the rod's
    path (m) and a turn of the object about its origin (rad) while the rod goes as it goes, (3, 3).
    """
    piece = model.curve.pieces[strokes.start_piece]
    contact = piece.contact(strokes.start_coordinate, model.radius)
    c = math.cos(contact.normal + theta)
    s = math.sin(contact.normal + theta)
    normal = np.array((c, s))
    tangent = np.array((-s, c))
    toward = np.array((math.cos(strokes.direction + theta), math.sin(strokes.direction + theta)))
    longer = normal / (normal @ toward)
    along = (tangent - (tangent @ toward) * longer) / contact.travel
    # The rod keeps its direction where the normal turns.
    by_shift = np.array((along, -contact.turning * along, longer)) / model.unit
    # Seen from the object its turn takes the rod the other way around the origin.
    x, y = Pose(theta=theta).to_world(*contact.rod_centre(model.radius))
    by_turn = by_shift @ (model.unit * np.array((y, -x))) - (0.0, 1.0, 0.0)
    return np.column_stack([by_shift, by_turn])


def _by_names(
    model: QuasiStaticModel,
    names: tuple[str, ...],
    by_engine: Array,
    target: Place | None,
    felt: Sequence[Place],
) -> Array:
    """Columns (n, 3, k) by `names`, SI units and shapes in kPa, of derivatives by all of the
    engine's parameters; with a target also by the floor's heights, felt at places (n, 2), m from
    there.
    """
    columns = in_kpa(model.slider, names, by_engine) * derivative_units(
        model, [ENGINE_NAMES.get(name, name) for name in names]
    )
    if target is None:
        return columns
    by_floor = _by_names(model, FLOOR_NAMES, by_engine, None, ())
    reaching = FloorField(((0.0,) * 5,) * 3, FIELD_REACH)
    # Without any push, too, as many columns.
    terms = np.reshape([reaching.terms_at(place) for place in felt], (len(felt), 5))
    by_heights = np.einsum("nms,stk,nt->nmk", by_floor, field_factors(), terms)
    return np.concatenate([columns, by_heights], axis=-1)


def in_kpa(slider: Slider, names: Sequence[str], by_engine: Array) -> Array:
    """Return columns (..., k) by `names` of derivatives by all of the engine's parameters, shapes
    told in kPa instead of the object's own mean pressures.
    """
    per_kpa = 1.0 / mean_pressure(slider)
    units = [per_kpa if name in ENGINE_NAMES else 1.0 for name in names]
    columns = [PARAMETERS.index(ENGINE_NAMES.get(name, name)) for name in names]
    return by_engine[..., columns] * units


def by_contact(
    rows: pandas.DataFrame, loop: CollectionLoop, left_out: Counter[str]
) -> list[pandas.DataFrame]:
    """Return the pushes of a set, whose facts are alike, by their contacts, with side, fraction and
    angle as the rod's places tell them, and in the place of these how far the rod went from its
    first touch on.

    The set stays as it is where its facts tell the contact, and the rod was there, where no places
    are told, and where they are in another frame than the object. Pushes that touch no side are
    counted by reason.
    """
    has_rods = rows[["x0", *RODS]].notna().all(axis=1).to_numpy()
    if not has_rods.any():
        return [rows]
    posed = rows[has_rods]
    contacts, touched = _contacts(posed, loop)
    if touched.mean() < _FEWEST_TOUCH:
        return [rows]
    stated = rows[[*CONTACT]].iloc[0]
    if stated.notna().all() and _off(contacts[touched], stated, loop) < _ELSEWHERE:
        return [rows]
    on_side = np.isfinite(contacts).all(axis=1)
    left_out[_NO_RODS] += int(np.sum(~has_rods))
    left_out[_NO_SIDE] += int(np.sum(~on_side))
    known = contacts[on_side]
    own = posed[on_side].assign(length=known[:, 4], **dict.fromkeys(RODS, math.nan))
    sets: list[pandas.DataFrame] = []
    for chosen in _alike(known):
        side, fraction, angle = np.median(known[chosen, :3], axis=0).tolist()
        if isinstance(loop.slider.outline, Ellipse):
            fraction %= 1.0
        sets.append(own.iloc[chosen].assign(side=side, fraction=fraction, angle=angle))
    return sets


def _off(contacts: Array, stated: pandas.Series, loop: CollectionLoop) -> float:
    """How far (m, in the median) rods on sides are from where the stated contact has them; 0 where
    none is on a side.
    """
    place, _ = first_contact(
        loop.slider, told_push(loop.push, stated, math.nan), loop.pusher.radius
    )
    away = []
    for side, fraction, *_ in contacts[np.isfinite(contacts[:, 0])].tolist():
        push = replace(loop.push, side=int(side), fraction=fraction % 1.0)
        own, _ = first_contact(loop.slider, push, loop.pusher.radius)
        away.append(math.dist(own, place))
    return float(np.median(away)) if away else 0.0


def _contacts(rows: pandas.DataFrame, loop: CollectionLoop) -> tuple[Array, Mask]:
    """Side, fraction, angle (rad), the place along the side (m), and how far (m) the rod went from
    its first touch on, (n, 5), NaN on no side; and which rods touch the object at all.
    """
    columns = ["x0", "y0", "theta0", *RODS]
    x, y, theta, tip_x0, tip_y0, tip_x1, tip_y1 = rows[columns].to_numpy(dtype=float).T
    back = np.exp(-1j * theta)
    begun = (tip_x0 - x + 1j * (tip_y0 - y)) * back
    way = (tip_x1 - tip_x0 + 1j * (tip_y1 - tip_y0)) * back
    outline = loop.slider.outline
    radius = loop.pusher.radius
    pieces = contact_curve(outline, radius).pieces
    starts = np.column_stack([begun.real, begun.imag])
    travel, index, coordinate = first_touches(pieces, radius, starts, np.angle(way))
    length = np.abs(way) - travel
    touched = (length > 0.0) & (travel > -DEEPEST)
    if isinstance(outline, Ellipse) and touched.any():
        # Its only side has no end: the first contact may be anywhere.
        middle = np.angle(np.exp(1j * coordinate[touched]).sum())
        coordinate = middle + shorter_way(coordinate - middle)
    contacts = np.full((len(rows), 5), math.nan)
    for row in np.flatnonzero(touched).tolist():
        piece = pieces[index[row]]
        at = float(coordinate[row])
        place = side_place(outline, piece, at)
        if place is not None:
            side, fraction, along = place
            angle = shorter_way(np.angle(way[row]) - piece.contact(at, radius).normal - math.pi)
            contacts[row] = side, fraction, angle, along, length[row]
    return contacts, touched


def _alike(contacts: Array) -> list[Whole]:
    """The rows (n, 5) of `_contacts` at each contact, in their order."""
    groups = [np.flatnonzero(contacts[:, 0] == side) for side in np.unique(contacts[:, 0])]
    for column, apart in zip((3, 2), _APART, strict=True):
        parted = [_parted(rows, contacts[:, column], apart) for rows in groups]
        groups = list(chain.from_iterable(parted))
    alike = list[Whole]()
    for rows in groups:
        scattered = np.std(contacts[rows][:, (3, 2)], axis=0) > _SCATTER
        alike += np.split(rows, rows.size) if scattered.any() else [rows]
    return alike


def _parted(rows: Whole, values: Array, apart: float) -> list[Whole]:
    """Rows parted where their values, in order, have gaps."""
    ordered = rows[np.argsort(values[rows], kind="stable")]
    gaps = np.flatnonzero(np.diff(values[ordered]) > apart)
    return [np.sort(near) for near in np.split(ordered, gaps + 1)]


def contact_words(sets: Sequence[pandas.DataFrame], push: SidePush) -> tuple[str, ...]:
    """Return where the rod was, in words, of sets whose contact its places tell, unless that is
    where the protocol's is.
    """
    others = list[str]()
    for rows in sets:
        side, fraction, angle = rows[[*CONTACT]].iloc[0].tolist()
        if not is_near(push, side, fraction, angle, _HARDLY):
            way = round(math.degrees(angle), 1) + 0.0
            others.append(f"side {side:.0f} at {fraction:.3g}, {way:g}° ({len(rows)} pushes)")
    if not others:
        return ()
    listed = others[:_MOST_TOLD]
    more = len(others) - _MOST_TOLD
    listed += [f"{more} contacts more"] if more > 0 else []
    own = f"side {push.side} at {push.fraction:.3g}, {math.degrees(push.angle):.3g}°"
    return (
        f"the rod's places tell its contact: {'; '.join(listed)}; the protocol's, {own}, is passed "
        "over there",
    )


def is_near(
    push: SidePush, side: float, fraction: float, angle: float, within: float = _ROUNDED
) -> bool:
    """Return whether a contact is that of a push, but for the three decimals of a file's name."""
    off = max(abs(push.fraction - fraction), abs(push.angle - angle))
    return push.side == side and off <= within
