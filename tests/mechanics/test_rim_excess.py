"""Friction under uneven pressure keeps its digits where the closed forms of |w| itself would cancel."""

import math

import casadi as ca
import mpmath
import numpy as np
import pytest
from exact_reference import exact_wrench, twist_about

from cyclemap.mechanics import EllipseFriction, LimitSurface, PatchFootprint, Polygon
from cyclemap.mechanics.patch_integrals import far_ratio
from cyclemap.mechanics.pressure_family import PressureFamily
from cyclemap.mechanics.rim import polygon_rim
from cyclemap.mechanics.rim_excess import Tangent, polygon_excess

# 8.8 to 1, as thin as it is easy to turn about far centres.
THIN = Polygon(((0.044, 0.005), (-0.044, 0.005), (-0.044, -0.005), (0.044, -0.005)))
TRIANGLE = Polygon(((0.0, 0.0), (0.1, 0.004), (0.03, 0.02)))
STEEP = EllipseFriction(0.3, 0.03, 0.0, 0.0, 0.4)
FOOTPRINTS = {
    "leaning to its edge across": PatchFootprint(THIN, (0.0, 195.0)),
    "leaning to its edge along": PatchFootprint(THIN, (22.0, 0.0)),
    "leaning triangle": PatchFootprint(TRIANGLE, (8.0, -45.0)),
    "warped along": PatchFootprint(THIN, (0.0, 0.0), 0.1, (0.5, 0.0)),
    "warped across its corners": PatchFootprint(THIN, (0.0, 0.0), 0.0, (-0.1, 1.1)),
    "leaning and warped": PatchFootprint(THIN, (3.0, 40.0), 0.2, (0.1, 0.3)),
}


@pytest.mark.parametrize("name", FOOTPRINTS)
def test_the_wrench_is_that_of_forty_digits_to_1e_11_up_to_where_the_area_rule_takes_over(name):
    footprint, errors = FOOTPRINTS[name], []
    scale = np.array((1.0, 1.0, 1.0 / footprint.extent)) / math.sqrt(STEEP.mu_a * STEEP.mu_b)
    farthest = far_ratio(PressureFamily.of(footprint)) - 0.01
    for ratio in (2.0, farthest):
        for angle in (1.5,):
            for frame in (0.4, -1.0, 1.2):
                twist = twist_about(ratio, angle, STEEP, frame, footprint)
                found = LimitSurface(footprint, STEEP).wrench(twist, frame)
                errors.append(np.abs(scale * (found - exact_wrench(footprint, STEEP, twist, frame))).max())
    assert len(errors) == 6
    assert 0.0 < max(errors) < 3e-11


def side_moments(start, end, centre):
    """Integrals of tau^i (|w| - e . w), i = 0, 1, 2, along a side, e along w_c = centre, in forty digits."""
    with mpmath.workdps(40):
        cx, cy = map(mpmath.mpf, centre)
        (x0, y0), (x1, y1) = ((cx + mpmath.mpf(x), cy + mpmath.mpf(y)) for x, y in (start, end))
        ex, ey = cx / mpmath.hypot(cx, cy), cy / mpmath.hypot(cx, cy)

        def excess(tau):
            x, y = (x0 + x1) / 2 + tau * (x1 - x0), (y0 + y1) / 2 + tau * (y1 - y0)
            return mpmath.hypot(x, y) - (ex * x + ey * y)

        along = (x1 - x0) ** 2 + (y1 - y0) ** 2
        foot = -(((x0 + x1) * (x1 - x0) + (y0 + y1) * (y1 - y0)) / 2) / along
        breaks = sorted({mpmath.mpf(-0.5), mpmath.mpf(0.5), min(max(foot, mpmath.mpf(-0.5)), mpmath.mpf(0.5))})
        return [float(mpmath.quad(lambda tau, i=i: tau**i * excess(tau), breaks)) for i in range(3)]


@pytest.mark.parametrize("away", [0.02, 0.7, 2.0, 2.6, 8.0, 30.0, 100.0])
def test_the_sides_moments_of_the_excess_keep_their_digits_however_far_the_centre_of_rotation(away):
    """Relative to the excess, which falls with the distance, on both sides of where the series ends."""
    corners, errors = np.array(((0.4, -0.3), (0.5, 0.4), (-0.6, 0.2))), []
    for angle in (0.2, 1.9, 4.0):
        centre = away * np.array((math.cos(angle), math.sin(angle)))
        places = corners + centre
        x, y = ca.DM(places[:, 0]), ca.DM(places[:, 1])
        tangent = Tangent.at(ca.DM(centre), ca.DM.eye(2))
        powers = polygon_excess(corners, x, y, polygon_rim(x, y), tangent).powers
        found = np.hstack([np.array(power) for power in powers])
        for k in range(3):
            wanted = np.array(side_moments(corners[k], corners[(k + 1) % 3], centre))
            errors.append(np.abs(found[k] - wanted).max() / wanted[0])
    assert len(errors) == 9
    assert max(errors) < 3e-14
