"""No finite footprint is an ellipsoid: the expansion of its dissipation in the spin, in symbols and
in the code.
"""

import math

import numpy as np
import pytest
import sympy as sp

from cyclemap.mechanics import (
    EllipseFriction,
    LimitSurface,
    PatchFootprint,
    Slider,
    corner_footprint,
    grid_footprint,
)
from cyclemap.mechanics.outline import area_quadrature
from theory import no_exact_ellipsoid as theory


@pytest.mark.slow
def test_the_fourth_order_of_every_footprint_is_positive_and_of_every_ellipsoid_negative():
    assert theory.mean_over_directions(4) == theory.DISTANCE**4 / 64
    assert theory.ellipsoid_coefficient(4) == -(theory.SPIN_RADIUS**4) / 8
    assert theory.mean_over_directions(1) == theory.mean_over_directions(3) == 0


def test_the_second_order_of_one_direction_is_half_the_moment_along_the_motion():
    """An ellipsoid can agree up to there: c² = ⟨(u·x)²⟩."""
    second = sp.diff(theory.speed_of_a_point(), theory.SPIN, 2).subs(theory.SPIN, 0)
    assert sp.simplify(second - (theory.DISTANCE * sp.cos(theory.AZIMUTH)) ** 2) == 0


def test_the_codes_footprints_have_the_fourth_order_of_the_theory():
    """The mean over 24 directions of D(u, ω)/μ is a polynomial in ω near 0; its ω⁴ is ⟨ρ⁴⟩/64 +
    O(ω²).
    """
    square = Slider.mit("rect1").outline
    direction = np.arange(24) * math.pi / 12.0
    spins = np.array((0.0, 2.0, 4.0, 6.0))
    for footprint in (PatchFootprint(square), grid_footprint(square, 8), corner_footprint(square)):
        surface = LimitSurface(footprint, EllipseFriction.isotropic(1.0))
        twist = np.stack(
            np.broadcast_arrays(np.cos(direction), np.sin(direction), spins[:, None]), axis=-1
        )
        mean = surface.dissipation(twist).mean(axis=-1)
        even = np.linalg.solve(np.vander(spins**2, increasing=True), mean)
        even_patch = isinstance(footprint, PatchFootprint)
        points, weights = area_quadrature(square) if even_patch else footprint.quadrature
        fourth = weights @ np.hypot(*points.T) ** 4
        assert abs(even[1] / (weights @ (points**2).sum(axis=-1) / 4.0) - 1.0) < 1e-5
        assert abs(even[2] / (fourth / 64.0) - 1.0) < 0.1
