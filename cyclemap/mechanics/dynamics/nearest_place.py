"""The place of an outline that lies nearest to a point outside, as a CasADi expression."""

import casadi as ca
import numpy as np

from cyclemap.errors import InvalidInput
from cyclemap.mechanics.outline import Ellipse, Outline, Polygon

# Newton's steps towards the nearest place of an ellipse; 5 reach rounding at an axis ratio of 1.5, 7 at 4.
_NEWTON_STEPS = 8


def nearest_place(outline: Outline, x: ca.SX, y: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return where a convex outline is nearest to the point (x, y) outside it; all in one frame and unit.

    Raises InvalidInput for a concave outline, which a rod may touch in two places at once.
    """
    if isinstance(outline, Ellipse):
        return _on_ellipse(outline, x, y)
    if not outline.is_convex:
        raise InvalidInput(
            "the dynamic simulation needs a convex outline, since a rod touches a concave one in two places at once: "
            "use the quasi-static model"
        )
    return _on_polygon(outline, x, y)


def _on_polygon(outline: Polygon, x: ca.SX, y: ca.SX) -> tuple[ca.SX, ca.SX]:
    starts = outline.array
    places = [_on_side(a, b, x, y) for a, b in zip(starts, np.roll(starts, -1, axis=0), strict=True)]
    nearest, least = places[0], _square(places[0], x, y)
    for place in places[1:]:
        nearer = _square(place, x, y) < least
        nearest = (ca.if_else(nearer, place[0], nearest[0]), ca.if_else(nearer, place[1], nearest[1]))
        least = ca.fmin(least, _square(place, x, y))
    return nearest


def _on_side(a: np.ndarray, b: np.ndarray, x: ca.SX, y: ca.SX) -> tuple[ca.SX, ca.SX]:
    side = b - a
    share = ((x - a[0]) * side[0] + (y - a[1]) * side[1]) / float(side @ side)
    share = ca.fmin(ca.fmax(share, 0.0), 1.0)
    return a[0] + share * side[0], a[1] + share * side[1]


def _on_ellipse(outline: Ellipse, x: ca.SX, y: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Newton on the eccentric angle at which the lever to the point is normal to the outline."""
    a, b = outline.semi_x, outline.semi_y
    angle = ca.atan2(a * y, b * x)
    for _ in range(_NEWTON_STEPS):
        c, s = ca.cos(angle), ca.sin(angle)
        slope = (a**2 - b**2) * s * c - a * x * s + b * y * c
        angle -= slope / ((a**2 - b**2) * (c**2 - s**2) - a * x * c - b * y * s)
    return a * ca.cos(angle), b * ca.sin(angle)


def _square(place: tuple[ca.SX, ca.SX], x: ca.SX, y: ca.SX) -> ca.SX:
    return (x - place[0]) ** 2 + (y - place[1]) ** 2
