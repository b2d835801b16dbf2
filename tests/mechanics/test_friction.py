"""Point friction: the offset ellipse is a maximum-dissipation law; between two states of wear it is the one between."""

import math

import numpy as np
import pytest
from random_cases import random_friction
from refusals import refused

from cyclemap.mechanics import EllipseFriction, Material, Wear, load_material, worn_friction

LAWS = [random_friction(np.random.default_rng(seed)) for seed in range(40)]
VELOCITIES = np.random.default_rng(0).normal(size=(50, 2))
FRESH = load_material("plywood").friction
WORN = EllipseFriction(0.31, 0.19, m0=-0.02, n0=0.05, phi=0.7)
ANGLES = np.linspace(0.0, 2.0 * math.pi, 720, endpoint=False)
WAYS = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=-1)


@pytest.mark.parametrize("law", LAWS[:8])
def test_a_turned_frame_sees_the_same_forces_turned_back(law):
    angle = 1.1
    turn = np.array(((math.cos(angle), -math.sin(angle)), (math.sin(angle), math.cos(angle))))
    seen = law.traction(VELOCITIES @ turn, frame=angle) @ turn.T
    assert np.allclose(seen, law.traction(VELOCITIES), atol=1e-14)
    turned = law.turned(angle).traction(VELOCITIES @ turn.T) @ turn
    assert np.allclose(turned, law.traction(VELOCITIES), atol=1e-14)


@pytest.mark.parametrize("law", LAWS)
def test_no_other_force_of_the_ellipse_dissipates_more(law):
    others = law.traction(np.random.default_rng(1).normal(size=(200, 2)))
    own = law.dissipation(VELOCITIES)
    assert (own[:, None] - VELOCITIES @ others.T).min() >= -1e-14


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ((0.25, 0.2, 0.25, 0.0), "m0=0.25"),
        ((0.25, 0.2, 0.2, 0.15), "n0=0.15"),
        ((0.0, 0.2), "mu_a"),
        ((0.2, -0.1), "-0.1"),
        ((0.2, 0.2, 0.0, 0.0, "1"), "phi"),
        ((True, 0.2), "mu_a"),
    ],
)
def test_a_law_that_cannot_be_is_refused_by_name(values, named):
    refused(EllipseFriction, *values, told=named)


def test_traction_at_rest_and_bad_velocities_are_refused():
    law = EllipseFriction.isotropic(0.3)
    refused(law.traction, [[1.0, 0.0], [0.0, 0.0]], told="zero")
    for velocity, told in (([1.0, 2.0, 3.0], "shape"), ([1.0, math.nan], "finite")):
        refused(law.dissipation, velocity, told=told)


def edge_friction(generator):
    """A law whose centre may lie at the very edge."""
    mu_a, mu_b = generator.uniform(0.02, 1.0, 2)
    radius, angle = 0.999 * math.sqrt(generator.uniform()), generator.uniform(0.0, 2.0 * math.pi)
    centre = radius * mu_a * math.cos(angle), radius * mu_b * math.sin(angle)
    return EllipseFriction(mu_a, mu_b, *centre, phi=generator.uniform(-4.0, 4.0))


@pytest.mark.parametrize("share", [0.001, 0.25, 0.5, 0.999])
def test_centre_and_squared_radius_go_straight_in_every_direction(share):
    """Support function h(v) = c.v + sqrt(v.S v): half the sum and half the difference of h(v), h(-v) give c and S."""

    def parts(law):
        ahead, behind = law.dissipation(WAYS), law.dissipation(-WAYS)
        return (ahead - behind) / 2.0, ((ahead + behind) / 2.0) ** 2

    found = parts(worn_friction(FRESH, WORN, share))
    for got, first, last in zip(found, parts(FRESH), parts(WORN), strict=True):
        assert got == pytest.approx((1.0 - share) * first + share * last, abs=1e-13)


def test_no_path_between_two_laws_leaves_the_laws():
    """Zero stays inside the ellipse (else EllipseFriction refuses), also for laws at the very edge."""
    generator = np.random.default_rng(5)
    for _ in range(300):
        fresh, worn = edge_friction(generator), edge_friction(generator)
        worst = max(math.hypot(law.m0 / law.mu_a, law.n0 / law.mu_b) for law in (fresh, worn))
        between = worn_friction(fresh, worn, generator.uniform())
        assert math.hypot(between.m0 / between.mu_a, between.n0 / between.mu_b) <= worst + 1e-12


def test_other_names_of_the_same_ellipse_change_nothing():
    half_turned = EllipseFriction(0.31, 0.19, m0=0.02, n0=-0.05, phi=0.7 + math.pi)
    exchanged = EllipseFriction(0.19, 0.31, m0=0.05, n0=0.02, phi=0.7 + math.pi / 2.0)
    expected = worn_friction(FRESH, WORN, 0.4).traction(WAYS)
    for name in (half_turned, exchanged):
        assert name.traction(WAYS) == pytest.approx(WORN.traction(WAYS), abs=1e-14)
        assert worn_friction(FRESH, name, 0.4).traction(WAYS) == pytest.approx(expected, abs=1e-13)


@pytest.mark.parametrize("share", [-0.1, 1.1, math.nan])
def test_a_share_beyond_the_ends_is_refused(share):
    refused(worn_friction, FRESH, WORN, share, told="share of wear")


def test_a_course_says_when_the_way_is_gone_and_leaves_the_way_itself():
    even, early = Wear(WORN, 1000.0), Wear(WORN, 1000.0, ((100.0, 0.5), (600.0, 0.5)))
    assert [early.share(n) for n in (-5.0, 0.0, 50.0, 100.0, 300.0, 600.0, 800.0, 1000.0, 2000.0)] == pytest.approx(
        [0.0, 0.0, 0.25, 0.5, 0.5, 0.5, 0.75, 1.0, 1.0]
    )
    slow, fast = (Material("floor", FRESH, wear=wear) for wear in (even, early))
    assert fast.friction_after(50.0) == slow.friction_after(250.0)
    assert fast.friction_after(2000.0) == WORN and fast.friction_after(0.0) == FRESH


@pytest.mark.parametrize(
    "course",
    [((100.0, 0.5), (50.0, 0.6)), ((100.0, 0.5), (200.0, 0.4)), ((1000.0, 0.5),), ((10.0, 1.5),), ((0.0, 0.1),)],
)
def test_a_course_that_goes_back_or_beyond_is_refused(course):
    refused(Wear, WORN, 1000.0, course, told="must be pairs")
