"""Point friction: between two states of wear it is the one between; what is no law, no velocity, no
wear.
"""

import math

import numpy as np
import pytest
from refusals import refused

from cyclemap.mechanics import (
    Ellipse,
    EllipseFriction,
    LimitSurface,
    Material,
    PatchFootprint,
    Wear,
    load_material,
    worn_friction,
)

FRESH = load_material("plywood").friction
WORN = EllipseFriction(0.31, 0.19, m0=-0.02, n0=0.05, phi=0.7)
# Other names of the same ellipse: half a turn on, and with its axes exchanged.
NAMES = (
    WORN,
    EllipseFriction(0.31, 0.19, m0=0.02, n0=-0.05, phi=0.7 + math.pi),
    EllipseFriction(0.19, 0.31, m0=0.05, n0=0.02, phi=0.7 + math.pi / 2.0),
)
ANGLES = np.linspace(0.0, 2.0 * math.pi, 720, endpoint=False)
WAYS = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=-1)


@pytest.mark.parametrize("law", [FRESH, *NAMES])
def test_traction_is_the_slope_of_dissipation_and_turns_with_the_surface(law):
    step, frame = 1e-6, 0.4
    slopes = [
        (law.dissipation(WAYS + step * axis, frame) - law.dissipation(WAYS - step * axis, frame))
        for axis in np.eye(2)
    ]
    traction = law.traction(WAYS, frame)
    np.testing.assert_allclose(traction, np.stack(slopes, axis=-1) / (2 * step), atol=1e-9)
    c, s = math.cos(0.9), math.sin(0.9)
    turn = np.array([[c, s], [-s, c]])
    np.testing.assert_allclose(
        law.turned(0.9).traction(WAYS @ turn, frame), traction @ turn, rtol=0, atol=1e-14
    )


def test_what_is_no_law_no_velocity_and_no_wear_is_refused_by_name():
    for values, told in (
        ((0.25, 0.2, 0.25, 0.0), "m0=0.25"),
        ((0.25, 0.2, 0.2, 0.15), "n0=0.15"),
        ((0.0, 0.2), "mu_a"),
        ((0.2, -0.1), "-0.1"),
        ((0.2, 0.2, 0.0, 0.0, "1"), "phi"),
        ((True, 0.2), "mu_a"),
    ):
        refused(EllipseFriction, *values, told=told)
    refused(FRESH.traction, [[1.0, 0.0], [0.0, 0.0]], told="zero")
    for velocity, told in (
        ([1.0, 2.0, 3.0], "shape"),
        ([1.0, math.nan], "finite"),
        ("a", "velocities must hold numbers only"),
    ):
        refused(FRESH.dissipation, velocity, told=told)
    patch = PatchFootprint(Ellipse(1.0, 1.0))
    whole = LimitSurface(patch, FRESH)
    for power, motion in (
        (FRESH.dissipation, [1.0, 0.0]),
        (FRESH.traction, [1.0, 0.0]),
        (whole.dissipation, [1.0, 0.0, 0.0]),
    ):
        for frame in (math.nan, "a"):
            refused(power, motion, frame=frame, told="frame must be a finite number")
    refused(LimitSurface, 3, FRESH, told="footprint must be a PatchFootprint or .*, not 3")
    refused(LimitSurface, patch, 4, told="friction must be an EllipseFriction, not 4")
    refused(worn_friction, FRESH, None, 0.5, told="friction must be an EllipseFriction, not None")
    for share in (-0.1, 1.1, math.nan):
        refused(worn_friction, FRESH, WORN, share, told="share of wear")
    back = ((100.0, 0.5), (50.0, 0.6)), ((100.0, 0.5), (200.0, 0.4))
    for course in (*back, ((1000.0, 0.5),), ((10.0, 1.5),), ((0.0, 0.1),)):
        refused(Wear, WORN, 1000.0, course, told="must be pairs")
    for course in (5, True, (10.0, 0.5), (((10.0, 0.5),),), ((),)):
        refused(Wear, WORN, 1000.0, course, told="course of wear must have")
    refused(Wear, None, 1000.0, told="worn surface must be an EllipseFriction, not None")
    refused(Wear, WORN, 1000.0, floor=3, told="worn surface must be a SurfaceShape or None, not 3")


@pytest.mark.parametrize("worn", NAMES)
def test_centre_and_squared_radius_go_straight_in_every_direction(worn):
    """Support function h(v) = c.v + sqrt(v.S v): half the sum and half the difference of h(v),
    h(-v) give c and S.
    """

    def parts(law):
        ahead, behind = law.dissipation(WAYS), law.dissipation(-WAYS)
        return (ahead - behind) / 2.0, ((ahead + behind) / 2.0) ** 2

    for share in (0.001, 0.25, 0.5, 0.999):
        found = parts(worn_friction(FRESH, worn, share))
        for got, first, last in zip(found, parts(FRESH), parts(WORN), strict=True):
            assert got == pytest.approx((1.0 - share) * first + share * last, abs=1e-13)


def edge_friction(generator):
    """A law whose centre may lie at the very edge."""
    mu_a, mu_b = generator.uniform(0.02, 1.0, 2)
    radius, angle = 0.999 * math.sqrt(generator.uniform()), generator.uniform(0.0, 2.0 * math.pi)
    centre = radius * mu_a * math.cos(angle), radius * mu_b * math.sin(angle)
    return EllipseFriction(mu_a, mu_b, *centre, phi=generator.uniform(-4.0, 4.0))


def test_no_path_between_two_laws_leaves_the_laws():
    """Zero stays inside the ellipse (else EllipseFriction refuses),
    also for laws at the very edge."""
    generator = np.random.default_rng(5)
    for _ in range(100):
        fresh, worn = edge_friction(generator), edge_friction(generator)
        worst = max(math.hypot(law.m0 / law.mu_a, law.n0 / law.mu_b) for law in (fresh, worn))
        between = worn_friction(fresh, worn, generator.uniform())
        assert math.hypot(between.m0 / between.mu_a, between.n0 / between.mu_b) <= worst + 1e-12


def test_a_course_says_when_the_way_is_gone_and_leaves_the_way_itself():
    even, early = Wear(WORN, 1000.0), Wear(WORN, 1000.0, ((100.0, 0.5), (600.0, 0.5)))
    assert [
        early.share(n) for n in (0.0, 50.0, 100.0, 300.0, 600.0, 800.0, 1000.0, 2000.0)
    ] == pytest.approx([0.0, 0.25, 0.5, 0.5, 0.5, 0.75, 1.0, 1.0])
    refused(early.share, -5.0, told="cycles must not be negative, not -5.0")
    slow, fast = (Material("floor", FRESH, wear=wear) for wear in (even, early))
    assert fast.friction_after(50.0) == slow.friction_after(250.0)
    assert fast.friction_after(2000.0) == WORN and fast.friction_after(0.0) == FRESH
