"""The cycle map of plywood: its fixed points, and how they meet and vanish."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from cyclemap.collection import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import fixed_points
from cyclemap.mechanics import EllipseFriction, Material, Slider, grid_footprint


def plywood(ring_mm=15.0, grid=None):
    """MIT's loop on plywood with the ring at a distance from the centre, towards the same corner."""
    lever = ring_mm * 1e-3 / math.sqrt(2.0)
    slider = Slider.mit("rect1", hitch=(-lever, lever))
    footprint = grid_footprint(slider.outline, grid) if grid else None
    return CollectionLoop.mit(slider=slider, footprint=footprint)


def turn_deg(loop, theta_deg):
    return math.degrees(loop.cycle(math.radians(theta_deg)).theta_next) - theta_deg


@pytest.mark.parametrize(
    ("ring_mm", "stable_deg", "unstable_deg", "within_deg"),
    [(15.0, 61.45, 200.2, 0.05), (13.0, 97.5, 193.4, 0.1), (10.0, 151.0, 172.0, 0.6)],
)
def test_fixed_points_of_the_8x8_grid(ring_mm, stable_deg, unstable_deg, within_deg):
    """On the paper's grid the fixed points lie where the independent solver found them."""
    loop = replace(plywood(ring_mm, grid=8), accuracy=1e-6)
    for expected in (stable_deg, unstable_deg):
        found = brentq(lambda theta: turn_deg(loop, theta), expected - 3.0, expected + 3.0, xtol=1e-4)
        assert found == pytest.approx(expected, abs=within_deg)


def test_fixed_points_meet_in_a_saddle_node_as_the_ring_moves_in():
    """Stable and unstable point approach each other as the ring goes inwards, and are gone at 9 mm."""
    gaps = []
    for ring_mm in (15.0, 13.0, 10.0, 9.0):
        orbits = fixed_points(plywood(ring_mm).circle_map(tolerance=1e-4))
        gaps.append(np.degrees(orbits[1].points[0] - orbits[0].points[0]) if len(orbits) == 2 else None)
        assert [orbit.kind for orbit in orbits] == (["stable", "unstable"] if ring_mm > 9.0 else [])
    assert gaps[0] > gaps[1] > gaps[2] > 0.0 and gaps[3] is None


def centred():
    """MIT's loop on plywood without the ellipse's offset."""
    return CollectionLoop.mit(material=Material("centred", EllipseFriction(0.2545, 0.2346, phi=2.6175)))


def test_turn_of_a_centred_ellipse_on_the_8x8_grid():
    """Without the offset every cycle on the grid turns the object by 3.3 to 11.4 degrees; half a turn tells all."""
    loop = replace(centred(), footprint=grid_footprint(Slider.mit("rect1").outline, 8), accuracy=1e-6)
    theta = np.radians(np.arange(0.0, 180.0, 5.0))
    turn = np.degrees(loop.next_theta(theta) - theta)
    np.testing.assert_allclose([turn.min(), turn.max()], [3.31, 11.37], atol=0.03)


def test_stated_error_of_the_plywood_map_holds():
    """At 40 random orientations the map is within its stated error of single, finer cycles."""
    loop = plywood()
    circle = loop.circle_map(tolerance=1e-6)
    theta = np.random.default_rng(11).uniform(0.0, 2.0 * np.pi, 40)
    error = np.abs(circle(theta) - replace(loop, accuracy=1e-10).next_theta(theta))
    assert error.max() <= circle.max_error <= 1e-6


def test_flip_of_strong_anisotropy_is_kept_steep():
    """Where the push's turn flips under strong anisotropy f climbs steeply but goes on: its slope is above 200."""
    law = EllipseFriction(0.35, 0.18, 0.05, -0.03, 0.7)
    loop = CollectionLoop.mit(material=Material("strong", law))
    theta = math.radians(99.1759)
    assert loop.sensitivity(theta, ("theta",)).by_theta > 200.0


def test_derivative_by_an_unknown_parameter_is_refused():
    """A parameter that does not exist is refused by name, not answered with zero."""
    with pytest.raises(InvalidInput, match="unknown parameter 'mu_c'"):
        plywood().sensitivity(0.0, ("theta", "mu_c"))
