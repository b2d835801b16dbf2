"""Where on the object the rod of measured pushes was, and which way it went: by its recorded
places, where a table tells these and no side and fraction, or such as the rod was far from.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from cyclemap.arrays import Array, Mask, Whole, shorter_way
from cyclemap.collection import CollectionLoop
from cyclemap.evidence.predicted_strokes import DEEPEST
from cyclemap.evidence.pushes.measured_strokes import LARGEST_TIP_ERROR, SET_OFF, told_push
from cyclemap.evidence.tables.columns import RODS
from cyclemap.mechanics import SidePush
from cyclemap.mechanics.contact_curve import contact_curve, first_contact, first_touches, side_place
from cyclemap.mechanics.outline import Ellipse

if TYPE_CHECKING:
    import pandas

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
