"""The limit surface of every kind of footprint: convex, homogeneous, maximally dissipating; closed forms."""

import math

import numpy as np
import pytest
from random_cases import random_friction

from cyclemap.errors import InvalidInput
from cyclemap.mechanics import (
    EllipseFriction,
    LimitSurface,
    PatchFootprint,
    PointFootprint,
    Slider,
    corner_footprint,
    grid_footprint,
)

SQUARE, TRIANGLE = Slider.mit("rect1").outline, Slider.mit("tri3").outline
SCATTERED = PointFootprint(
    tuple(map(tuple, np.random.default_rng(5).uniform(-0.05, 0.05, (7, 2)))), (1, 2, 3, 1, 1, 2, 5)
)
FOOTPRINTS = {
    "square": PatchFootprint(SQUARE),
    "triangle in parts": PatchFootprint(TRIANGLE, 0.2, 0.15, 0.1, (-0.01, 0.0)),
    "ellipse": PatchFootprint(Slider.mit("ellip2").outline),
    "ellipse in parts": PatchFootprint(Slider.mit("ellip3").outline, 0.3, 0.2, 0.0, (0.003, -0.002)),
    "grid": grid_footprint(SQUARE, 8),
    "corners": corner_footprint(TRIANGLE),
    "points": SCATTERED,
}
every_footprint = pytest.mark.parametrize("footprint", FOOTPRINTS.values(), ids=FOOTPRINTS)


def surface_of(footprint, seed=0):
    return LimitSurface(footprint, random_friction(np.random.default_rng(seed)))


def random_twists(footprint, count, seed):
    return np.random.default_rng(seed).normal(size=(count, 3)) * (1.0, 1.0, 1.0 / footprint.extent)


@every_footprint
def test_dissipation_is_homogeneous_of_degree_one_and_its_wrench_of_degree_zero(footprint):
    surface, twists = surface_of(footprint), random_twists(footprint, 60, 1)
    for factor in (1e-6, 3.7, 1e5):
        assert np.allclose(surface.dissipation(factor * twists), factor * surface.dissipation(twists), rtol=1e-12)
        assert np.allclose(surface.wrench(factor * twists), surface.wrench(twists), rtol=1e-11, atol=1e-13)
    assert np.allclose((surface.wrench(twists) * twists).sum(-1), surface.dissipation(twists), rtol=1e-12)


@every_footprint
def test_dissipation_is_positive_and_convex(footprint):
    surface = surface_of(footprint)
    a, b = random_twists(footprint, 300, 2), random_twists(footprint, 300, 3)
    assert surface.dissipation(a).min() > 0.0
    assert (surface.dissipation(a) + surface.dissipation(b) - surface.dissipation(a + b)).min() > -1e-15


@every_footprint
def test_no_wrench_of_the_surface_dissipates_more_than_the_twists_own(footprint):
    surface, twists = surface_of(footprint), random_twists(footprint, 100, 4)
    others = surface.wrench(random_twists(footprint, 300, 5))
    assert (surface.dissipation(twists)[:, None] - twists @ others.T).min() > -1e-14


@every_footprint
def test_hessian_is_symmetric_positive_and_blind_along_the_twist(footprint):
    surface, twists = surface_of(footprint), random_twists(footprint, 60, 6)
    scale = np.array((1.0, 1.0, 1.0 / footprint.extent))
    scaled = surface.hessian(twists) * np.outer(scale, scale)
    size = np.linalg.norm(scaled, axis=(1, 2))
    assert (np.abs(scaled - scaled.transpose(0, 2, 1)).max(axis=(1, 2)) / size).max() < 1e-12
    assert (np.abs(np.einsum("nij,nj->ni", scaled, twists / scale)).max(axis=1) / size).max() < 1e-11
    assert (np.linalg.eigvalsh(scaled).min(axis=1) / size).min() > -1e-11


@every_footprint
def test_wrench_and_hessian_are_the_derivatives_of_dissipation(footprint):
    surface, twists = surface_of(footprint), random_twists(footprint, 20, 7)
    scale = np.array((1.0, 1.0, 1.0 / footprint.extent))
    for k in range(3):
        step = 1e-6 * scale * np.eye(3)[k]
        slope = (surface.dissipation(twists + step) - surface.dissipation(twists - step)) / 2e-6
        assert np.allclose(slope, surface.wrench(twists)[:, k] * scale[k], atol=1e-7)
        bend = (surface.wrench(twists + step) - surface.wrench(twists - step)) / 2e-6
        assert np.allclose(bend * scale, surface.hessian(twists)[:, k] * scale[k] * scale, rtol=1e-5, atol=1e-5)


@every_footprint
def test_the_ellipses_centre_adds_one_constant_wrench_at_the_centre_of_pressure(footprint):
    law = random_friction(np.random.default_rng(8))
    centred = EllipseFriction(law.mu_a, law.mu_b, 0.0, 0.0, law.phi)
    twists = random_twists(footprint, 50, 9)
    added = LimitSurface(footprint, law).wrench(twists, 0.4) - LimitSurface(footprint, centred).wrench(twists, 0.4)
    c, s = math.cos(law.phi - 0.4), math.sin(law.phi - 0.4)
    fx, fy = c * law.m0 - s * law.n0, s * law.m0 + c * law.n0
    x, y = footprint.centre
    assert np.allclose(added, (fx, fy, x * fy - y * fx), atol=1e-13)


@every_footprint
def test_translation_feels_the_point_law_at_the_centre_of_pressure(footprint):
    law = random_friction(np.random.default_rng(10))
    velocity = np.array((0.6, -0.8))
    force = law.traction(velocity, frame=0.3)
    x, y = footprint.centre
    found = LimitSurface(footprint, law).wrench((*velocity, 0.0), frame=0.3)
    assert np.allclose(found, (*force, x * force[1] - y * force[0]), atol=1e-14)


@every_footprint
def test_object_and_surface_turned_together_feel_the_same(footprint):
    law, twists = random_friction(np.random.default_rng(11)), random_twists(footprint, 30, 12)
    seen = LimitSurface(footprint, law.turned(0.9)).wrench(twists, frame=1.4)
    assert np.allclose(seen, LimitSurface(footprint, law).wrench(twists, frame=0.5), atol=1e-13)


def test_fine_grids_approach_the_exact_patch_at_second_order():
    law, twists = random_friction(np.random.default_rng(13)), random_twists(PatchFootprint(SQUARE), 40, 14)
    exact = LimitSurface(PatchFootprint(SQUARE), law).dissipation(twists)
    errors = [np.abs(LimitSurface(grid_footprint(SQUARE, n), law).dissipation(twists) - exact).max() for n in (8, 32)]
    assert errors[0] / errors[1] > 12.0


def test_rest_and_malformed_twists_are_refused():
    surface = surface_of(FOOTPRINTS["square"])
    for bad in ((0.0, 0.0, 0.0), (1.0, 0.0), (float("nan"), 0.0, 1.0), ("a", 0.0, 1.0)):
        with pytest.raises(InvalidInput):
            surface.dissipation(bad)
