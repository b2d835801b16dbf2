"""A polygon's friction under uneven pressure in forty digits: where rounding is all that is left to compare.

As in patch_reference.py, about the centre of rotation, but summed in multiple precision; for centres away from the rim.
"""

import math

import mpmath
import numpy as np
from patch_reference import traction_matrix
from warp_reference import parts_of

DIGITS = 30


def exact_wrench(footprint, law, twist, frame):
    """Return grad D (3,) at a twist of the footprint's frame, per unit load, for a law whose ellipse is centred."""
    assert law.m0 == law.n0 == 0.0
    with mpmath.workdps(DIGITS):
        matrix, (vx, vy, omega) = mpmath.matrix(traction_matrix(law, frame).tolist()), map(mpmath.mpf, twist)
        centre = (-vy / omega, vx / omega)
        total = [mpmath.mpf(0)] * 3
        for factor, region, pressure in parts_of(footprint):
            found = _about(region, centre, matrix * mpmath.sign(omega), pressure, footprint.outline.centroid)
            total = [a + factor * b / _area(region) for a, b in zip(total, found, strict=True)]
        fx, fy, torque = total
        return np.array([float(fx), float(fy), float(torque + centre[0] * fy - centre[1] * fx)])


def _area(outline):
    corners = [tuple(map(mpmath.mpf, corner)) for corner in outline.array.tolist()]
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(corners, corners[1:] + corners[:1], strict=True)) / 2


def _about(region, centre, matrix, pressure, centroid):
    """Force and torque about the centre of rotation, times the area."""
    corners = [(mpmath.mpf(x) - centre[0], mpmath.mpf(y) - centre[1]) for x, y in region.array.tolist()]
    lever = [a - mpmath.mpf(b) for a, b in zip(centre, centroid, strict=True)]
    total = [mpmath.mpf(0)] * 3
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        cross = a[0] * b[1] - a[1] * b[0]
        for i in range(3):

            def integrand(t, a=a, b=b, i=i):
                place = [p + t * (q - p) for p, q in zip(a, b, strict=True)]
                return _weighted(place, lever, matrix, pressure, i)

            total[i] += cross * mpmath.quad(integrand, [0, 1], method="gauss-legendre")
    return total


def _weighted(p, lever, matrix, pressure, i):
    """Component i of the friction's wrench at a place, times its pressure, integrated from the centre outwards."""
    motion = (-p[1], p[0])
    w = [matrix[k, 0] * motion[0] + matrix[k, 1] * motion[1] for k in (0, 1)]
    speed = mpmath.hypot(*w)
    force = [(matrix[0, k] * w[0] + matrix[1, k] * w[1]) / speed for k in (0, 1)]
    value = force[i] if i < 2 else p[0] * force[1] - p[1] * force[0]
    gradient, bend = map(mpmath.mpf, pressure.gradient), np.array(pressure.bend).tolist()
    g = list(gradient)
    bent = [sum(mpmath.mpf(bend[j][k]) * lever[k] for k in (0, 1)) for j in (0, 1)]
    even = mpmath.mpf(pressure.constant) + sum((g[k] + bent[k]) * lever[k] for k in (0, 1))
    slope = sum((g[k] + 2 * bent[k]) * p[k] for k in (0, 1))
    square = sum(mpmath.mpf(bend[j][k]) * p[j] * p[k] for j in (0, 1) for k in (0, 1))
    degree = 0 if i < 2 else 1
    return value * sum(share / (2 + degree + k) for k, share in enumerate((even, slope, square)))


def twist_about(ratio, angle, law, frame, footprint):
    """A twist whose centre of rotation is so many extents from the centre of pressure in the velocity plane."""
    size, (x, y) = footprint.extent, footprint.centre
    w = ratio * max(law.mu_a, law.mu_b) * np.array((math.cos(angle), math.sin(angle)))
    velocity = np.linalg.solve(traction_matrix(law, frame), w)
    return np.array((velocity[0] + y / size, velocity[1] - x / size, 1.0 / size))
