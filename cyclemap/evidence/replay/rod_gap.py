"""How far a rod is from an object, and the least shift that takes it out of one."""

from __future__ import annotations

import numpy as np

from cyclemap.arrays import Array
from cyclemap.errors import InvalidInput
from cyclemap.evidence.pushes.contact_forces import nearest_on_polyline
from cyclemap.mechanics import Pose, QuasiStaticModel

# More than this is no offset of a calibration: the record and the outline do not fit each other.
LARGEST_SHIFT = 5e-3
# Curved outlines are cut into pieces of a thousandth of their size: gaps are exact to 0.1 micrometre.
_PIECES = 3600
# What is left between rod and object after a shift.
_CLEARANCE = 1e-7
_MOST_SHIFTS = 10


def rod_gap(model: QuasiStaticModel, pose: Pose, place: tuple[float, float]) -> tuple[float, Array]:
    """Return the gap (m) between a rod at `place` (m, world frame) and the object, and the outward normal (2,) there.

    The gap is negative where the rod reaches into the object; the normal is in the world frame.

    >>> from cyclemap.mechanics import EllipseFriction, Slider
    >>> model = QuasiStaticModel(Slider.mit("rect1"), EllipseFriction.isotropic(0.25))
    >>> gap, normal = rod_gap(model, Pose(), (0.05, 0.0))
    >>> round(1e3 * gap, 6), normal.tolist()
    (0.25, [1.0, 0.0])
    """
    outline = model.slider.outline
    rod = np.array(pose.to_object(*place))
    corners = outline.points(_PIECES)
    (place_on,), (edge,) = nearest_on_polyline(rod[np.newaxis], corners)
    offset = rod - place_on
    distance = float(np.hypot(*offset))
    inside = bool(outline.contains(rod))
    outward = _outward(offset, corners[edge + 1] - corners[edge], inside)
    gap = (-distance if inside else distance) - model.pusher.radius
    return gap, np.array(Pose(theta=pose.theta).to_world(*outward))


def clearing_shift(model: QuasiStaticModel, pose: Pose, place: tuple[float, float]) -> Array:
    """Return the least shift (2,), m, world frame, that takes a rod at `place` out of the object; zero outside.

    Along the outward normal, until rod and object are 0.1 micrometre apart. Raises InvalidInput where 5 mm are not
    enough: that is no offset between two calibrations.
    """
    shift = np.zeros(2)
    for _ in range(_MOST_SHIFTS):
        gap, normal = rod_gap(model, pose, (place[0] + float(shift[0]), place[1] + float(shift[1])))
        if gap >= 0.5 * _CLEARANCE:
            return shift
        shift = shift + (_CLEARANCE - gap) * normal
        if np.hypot(*shift) > LARGEST_SHIFT:
            break
    raise InvalidInput(
        f"the rod starts {1e3 * np.hypot(*shift):.3g} mm inside the object, more than the {1e3 * LARGEST_SHIFT:.0f} mm "
        "that a calibration may be off: check the object's outline and the rod's radius"
    )


def _outward(offset: Array, edge: Array, inside: bool) -> Array:
    """Unit normal that points out of the object; on the outline itself the edge's own."""
    length = float(np.hypot(*offset))
    if length < 1e-12:
        return np.asarray(np.array([edge[1], -edge[0]]) / np.hypot(*edge))
    return np.asarray((-offset if inside else offset) / length)
