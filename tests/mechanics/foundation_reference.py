"""A second route to a foundation that is pressed: its area along rays from the centre of rotation.

Along a ray everything is a polynomial between the outline and where the pressure ends; over the
angle, Gauss's rule on many short panels between the outline's corners. No sum over a boundary, no
arcs, no homogeneity.
"""

import math

import numpy as np

from cyclemap.mechanics import Ellipse
from cyclemap.mechanics.engine.strokes import pressure_at, pressure_tables

RADIAL, RADIAL_WEIGHT = np.polynomial.legendre.leggauss(3)
ANGULAR, ANGULAR_WEIGHT = np.polynomial.legendre.leggauss(6)
PANELS = 80


def quadratic_of(footprint, theta):
    """c, l and the bends (6,) of the pressure per unit load: bends by definition, lengths in
    extents off the centroid.
    """
    plate, floor = footprint.plate, footprint.floor
    unit = footprint.bend_unit
    dome = plate.dome + floor.dome
    plate_axis, floor_axis = 2.0 * plate.axis, 2.0 * (floor.axis - theta)
    x = plate.bow * math.cos(plate_axis) + floor.bow * math.cos(floor_axis)
    y = plate.bow * math.sin(plate_axis) + floor.bow * math.sin(floor_axis)
    level, slope_x, slope_y, *bends = pressure_at(pressure_tables(footprint), theta)
    expected = unit * np.array((dome + x, y, dome - x))
    np.testing.assert_allclose(bends, expected, rtol=1e-12, atol=1e-12 * unit)
    return np.array((level, slope_x, slope_y, *expected))


def pressed_reference(footprint, quadratic, matrix, twist):
    """Load and moments (3,), D, wrench (3,) and Hessian (3, 3) about the centroid; all lengths in
    extents.
    """
    outline, size = footprint.outline, footprint.extent
    vx, vy, omega = twist
    centre = np.array((-vy, vx)) / omega
    round_by = np.ones(2)
    if isinstance(outline, Ellipse):
        round_by = np.array((outline.semi_x, outline.semi_y)) / size
        corners = None
    else:
        corners = outline.array / size - np.array(outline.centroid) / size
    angle, weight = _angles(centre / round_by, corners)
    along = round_by * np.column_stack((np.cos(angle), np.sin(angle)))
    rim = _rim(centre, along, round_by, corners)
    stops = np.sort(np.concatenate((rim, _roots(quadratic, centre, along)), axis=1), axis=1)
    stops = np.concatenate((np.zeros((len(angle), 1)), stops), axis=1)
    low, high = stops[:, :-1], stops[:, 1:]
    radius = (low + high)[..., None] / 2 + (high - low)[..., None] / 2 * RADIAL
    share = weight[:, None, None] * (high - low)[..., None] / 2 * RADIAL_WEIGHT
    is_inside = np.sum(rim[:, None] > (low + high)[..., None] / 2, axis=2) % 2 == 1
    place = centre + radius[..., None] * along[:, None, None]
    pressure = np.maximum(_value(quadratic, place), 0.0) * is_inside[..., None]
    load = (share * radius * np.prod(round_by) * pressure).ravel()
    return _summed(place.reshape(-1, 2)[load > 0.0], load[load > 0.0], matrix, twist)


def _summed(place, load, matrix, twist):
    x, y = place.T
    vx, vy, omega = twist
    w = np.column_stack((vx - omega * y, vy + omega * x)) @ np.transpose(matrix)
    speed = np.hypot(*w.T)
    lever = np.zeros((len(place), 2, 3))
    lever[:, 0, 0], lever[:, 1, 1], lever[:, 0, 2], lever[:, 1, 2] = 1.0, 1.0, -y, x
    lever = np.asarray(matrix) @ lever
    wrench = np.einsum("i,ik,ikj->j", load / speed, w, lever)
    across = (w[:, 0, None] * lever[:, 1] - w[:, 1, None] * lever[:, 0]) / speed[:, None]
    hessian = np.einsum("i,ij,ik->jk", load / speed, across, across)
    moments = np.array((load.sum(), load @ x, load @ y))
    return moments, load @ speed, wrench, hessian


def _angles(centre, corners):
    """Angles around a centre, and their weights, on panels between the corners, or the tangents."""
    if corners is not None:
        breaks = np.sort(np.arctan2(*(corners - centre).T[::-1]))
        breaks = np.append(breaks, breaks[0] + 2.0 * np.pi)
    elif math.hypot(*centre) > 1.0:
        half, towards = math.asin(1.0 / math.hypot(*centre)), math.atan2(*-centre[::-1])
        # the root at the tangents goes away in the angle's cosine
        breaks = towards - half * np.cos(np.linspace(0.0, np.pi, 9 * PANELS))
    else:
        breaks = np.linspace(0.0, 2.0 * np.pi, 9)
    parts = np.linspace(0.0, 1.0, PANELS + 1)[:-1]
    starts = (breaks[:-1, None] + np.diff(breaks)[:, None] * parts).ravel()
    ends = np.append(starts[1:], breaks[-1])
    angle = (starts + ends)[:, None] / 2 + (ends - starts)[:, None] / 2 * ANGULAR
    return angle.ravel(), ((ends - starts)[:, None] / 2 * ANGULAR_WEIGHT).ravel()


def _rim(centre, along, round_by, corners):
    """Where rays meet the outline, (n, k); 0 where they do not."""
    if corners is None:
        c, e = centre / round_by, along / round_by
        return _quadratic_roots(np.sum(e * e, axis=1), 2.0 * e @ c, c @ c - 1.0)
    side = np.roll(corners, -1, axis=0) - corners
    off = corners - centre
    down = along[:, :1] * side[:, 1] - along[:, 1:] * side[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = (off[:, 0] * side[:, 1] - off[:, 1] * side[:, 0]) / down
        share = (off[:, 0] * along[:, 1:] - off[:, 1] * along[:, :1]) / down
    return np.where((share >= 0.0) & (share < 1.0) & (radius > 0.0), radius, 0.0)


def _roots(quadratic, centre, along):
    _, gx, gy, xx, xy, yy = quadratic
    (x, y), (ex, ey) = centre, along.T
    bend = xx * ex * ex + 2 * xy * ex * ey + yy * ey * ey
    slope = ex * (gx + 2 * (xx * x + xy * y)) + ey * (gy + 2 * (xy * x + yy * y))
    return _quadratic_roots(bend, slope, _value(quadratic, centre))


def _quadratic_roots(a, b, c):
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(b * b - 4.0 * a * c)
        down = -0.5 * (b + np.copysign(root, b))
        found = np.column_stack((c / down, down / a))
    return np.where(np.isfinite(found) & (found > 0.0), found, 0.0)


def _value(quadratic, place):
    level, gx, gy, xx, xy, yy = quadratic
    x, y = np.moveaxis(np.asarray(place), -1, 0)
    return level + x * (gx + xx * x + 2 * xy * y) + y * (gy + yy * y)
