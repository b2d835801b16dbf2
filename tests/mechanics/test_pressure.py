"""Friction of whole footprints: its definition by plain quadrature, wherever the object turns;
closed forms; limits.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from pressure_reference import reference, traction_matrix
from random_cases import random_friction
from refusals import refused

from cyclemap.errors import InvalidInput
from cyclemap.mechanics import (
    Ellipse,
    EllipseFriction,
    LimitSurface,
    PatchFootprint,
    PointFootprint,
    Polygon,
    Slider,
    corner_footprint,
    grid_footprint,
)

SQUARE = Slider.mit("rect1").outline


def box(length, width):
    return Polygon(((length, width), (-length, width), (-length, -width), (length, -width)))


OUTLINES = {
    "square": SQUARE,
    "triangle": Slider.mit("tri3").outline,
    "concave": Polygon(((0, 0), (0.1, 0), (0.1, 0.06), (0.06, 0.06), (0.06, 0.1), (0, 0.1))),
    "far from the origin": Polygon(((1, 1), (1.1, 1), (1.05, 1.1))),
    "strip": box(0.1, 0.001),
    "blade": box(0.1, 3e-5),
    "ellipse": Slider.mit("ellip3").outline,
    "slim ellipse": Ellipse(0.1, 0.01),
    "needle": Ellipse(2e-5, 0.1),
}
# Inner, rim and corner share.
SHARES = {
    "even": (0, 0, 0),
    "inner": (1, 0, 0),
    "rim": (0, 1, 0),
    "corners": (0, 0, 1),
    "all": (0.2, 0.15, 0.1),
}
ALLOWED = {"strip": 1e-8, "blade": 2e-6}
PLACES = (
    "centroid",
    "vertex",
    "rim",
    "beside the rim",
    "inside",
    "around",
    "handover",
    "far",
    "1000 extents",
    "none",
)


TRIANGLE = Slider.mit("tri3").outline
SCATTERED = PointFootprint(
    tuple(map(tuple, np.random.default_rng(5).uniform(-0.05, 0.05, (7, 2)))), (1, 2, 3, 1, 1, 2, 5)
)
FOOTPRINTS = {
    "square": PatchFootprint(SQUARE),
    "triangle in parts": PatchFootprint(TRIANGLE, 0.2, 0.15, 0.1, (-0.01, 0.0)),
    "ellipse": PatchFootprint(Slider.mit("ellip2").outline),
    "ellipse in parts": PatchFootprint(
        Slider.mit("ellip3").outline, 0.3, 0.2, 0.0, (0.003, -0.002)
    ),
    "grid": grid_footprint(SQUARE, 8),
    "corners": corner_footprint(TRIANGLE),
    "points": SCATTERED,
}
every_footprint = pytest.mark.parametrize("footprint", FOOTPRINTS.values(), ids=FOOTPRINTS)


def random_twists(footprint, count, seed):
    return np.random.default_rng(seed).normal(size=(count, 3)) * (1.0, 1.0, 1.0 / footprint.extent)


@every_footprint
def test_dissipation_wrench_and_hessian_are_those_of_the_definition_in_any_frame(footprint):
    """By quadrature of the point law over any pressure; object and surface turn together, and
    speeds do not matter.
    """
    law, scale = (
        random_friction(np.random.default_rng(8)),
        np.array((1.0, 1.0, 1.0 / footprint.extent)),
    )
    surface = LimitSurface(footprint, law)
    for twist in random_twists(footprint, 8, 9):
        value, slope, bend = reference(footprint, law, twist, 0.4)
        assert surface.dissipation(twist, 0.4) == pytest.approx(float(value), rel=1e-12)
        assert np.allclose(
            surface.wrench(twist, 0.4) * scale,
            (slope * scale).astype(float),
            rtol=0.0,
            atol=1e-12,
        )
        both = np.outer(scale, scale)
        wanted = (bend * both).astype(float)
        assert np.allclose(
            surface.hessian(twist, 0.4) * both, wanted, rtol=1e-9, atol=1e-10 * np.abs(wanted).max()
        )
        turned = LimitSurface(footprint, law.turned(0.9)).wrench(twist, frame=1.3)
        assert np.allclose(turned, surface.wrench(twist, 0.4), rtol=0.0, atol=1e-13)
        for factor in (1e-6, 1e5):
            assert surface.dissipation(factor * twist, 0.4) == pytest.approx(
                factor * float(value), rel=1e-12
            )
            assert np.allclose(
                surface.wrench(factor * twist, 0.4) * scale,
                (slope * scale).astype(float),
                rtol=0.0,
                atol=1e-12,
            )


def footprint_of(outline, shares, rng=None):
    """A footprint, with `rng` leaning half as far as it stands; of ellipses without corners."""
    shares = (*shares[:2], 0) if isinstance(outline, Ellipse) else shares
    footprint = PatchFootprint(outline, *shares)
    away = outline.extent * (np.zeros(2) if rng is None else rng.uniform(-1.0, 1.0, 2))
    while np.any(away):
        try:
            replace(footprint, centre=tuple(outline.centroid + away))
            return replace(footprint, centre=tuple(outline.centroid + 0.5 * away))
        except InvalidInput:
            away = 0.8 * away
    return footprint


def twist_about(place, outline, law, frame, rng):
    """A random twist about a centre as named; the handover is where twists from afar are summed by
    other means.
    """
    angle, omega = rng.uniform(0, 2 * math.pi), rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 2.0)
    toward = np.array((math.cos(angle), math.sin(angle)))
    if place == "none":
        return np.array((*toward, 0.0))
    if place in ("vertex", "rim", "beside the rim"):
        share = 0.0 if place == "vertex" else rng.uniform()
        if isinstance(outline, Ellipse):
            around = 2.0 * math.pi * (0.25 * rng.integers(4) if place == "vertex" else share)
            x, y = outline.semi_x * math.cos(around), outline.semi_y * math.sin(around)
        else:
            i = rng.integers(outline.sides)
            x, y = (1 - share) * outline.array[i] + share * outline.array[(i + 1) % outline.sides]
        if place == "beside the rim":
            x, y = (x, y) + 10 ** rng.uniform(-14, -2) * outline.extent * rng.normal(size=2)
    elif place == "handover":
        # Distances in the velocity plane.
        w = max(law.mu_a, law.mu_b) * rng.uniform(2.0, 14.0) * outline.extent * toward
        vx, vy = np.linalg.solve(traction_matrix(law, frame).astype(float), w)
        x, y = np.array(outline.centroid) + np.array((-vy, vx))
    else:
        low, high = {
            "centroid": (0, 0),
            "inside": (1e-9, 0.3),
            "around": (0.5, 2),
            "far": (10, 200),
        }.get(place, (1e3, 1e6))
        away = math.exp(rng.uniform(math.log(low + 1e-300), math.log(high + 1e-300)))
        x, y = np.array(outline.centroid) + away * outline.extent * toward
    return omega * np.array((y, -x, 1.0))


def relative_errors(footprint, place, seed):
    """Of D, its gradient and its Hessian, on anisotropy up to 10 to 1."""
    rng = np.random.default_rng(seed)
    ratio, outline = 10 ** rng.uniform(-0.5, 0.5), footprint.outline
    law, frame = (
        EllipseFriction(0.3 * ratio, 0.3 / ratio, 0.0, 0.0, rng.uniform(0, 3)),
        rng.uniform(-3, 3),
    )
    twist = twist_about(place, outline, law, frame, rng)
    surface, scale = LimitSurface(footprint, law), np.array((1.0, 1.0, 1.0 / outline.extent))
    value, slope, hessian = reference(footprint, law, twist, frame)
    both = np.outer(scale, scale)
    return [
        float(np.linalg.norm(by * (found - wanted)) / np.linalg.norm((by * wanted).astype(float)))
        for by, found, wanted in (
            (np.ones(1), surface.dissipation(twist, frame), value),
            (scale, surface.wrench(twist, frame), slope),
            (both, surface.hessian(twist, frame), hessian),
        )
    ]


@pytest.mark.slow
@pytest.mark.parametrize("name", OUTLINES)
def test_dissipation_wrench_and_hessian_of_each_part_match_quadrature_wherever_the_centre_lies(
    name,
):
    """To 1e-10 on plates down to a tenth as thick as long; the thinner, the less is left."""
    outline, rng, checked = OUTLINES[name], np.random.default_rng(7), 0
    for part, shares in SHARES.items():
        if part == "corners" and (isinstance(outline, Ellipse) or name == "concave"):
            continue
        footprint = footprint_of(outline, shares, None if 1 in shares else rng)
        for place in PLACES:
            # Friction about a corner that carries load is not unique, and no Hessian is finite on a
            # line load.
            if place == "vertex" and footprint.corner_share:
                continue
            errors = relative_errors(footprint, place, [len(part), len(place)])
            if place in ("vertex", "rim", "beside the rim") and footprint.rim_share:
                errors.pop()
            assert max(errors) < ALLOWED.get(name, 1e-10), (part, place, errors)
            checked += 1
    assert checked >= 38


@pytest.mark.parametrize("name", ["square", "triangle", "concave", "ellipse"])
def test_no_digit_is_lost_where_far_twists_are_summed_anew(name):
    """Along centres that move outwards by a ten-millionth of an extent a step, no step jumps."""
    outline, law = OUTLINES[name], EllipseFriction(0.5, 0.2, 0.0, 0.0, 0.3)
    surface = LimitSurface(footprint_of(outline, SHARES["all"], np.random.default_rng(1)), law)
    away = outline.extent * np.concatenate(
        [start + 1e-7 * np.arange(200) for start in np.linspace(1.0, 40.0, 80)]
    )
    x, y = np.array(outline.centroid)[:, None] + np.outer((0.6, 0.8), away)
    wrench = surface.wrench(np.stack([y, -x, np.ones_like(x)], axis=-1) / away[:, None]) / (
        1.0,
        1.0,
        outline.extent,
    )
    bends = np.diff(wrench.reshape(80, 200, 3), n=2, axis=1)
    assert np.abs(bends).max() < 2e-12


def test_pressures_and_twists_that_cannot_be_are_refused_by_name():
    for bad in ((0.0, 0.0, 0.0), (1.0, 0.0), (math.nan, 0.0, 1.0), ("a", 0.0, 1.0)):
        refused(LimitSurface(FOOTPRINTS["square"], EllipseFriction.isotropic(0.3)).dissipation, bad)
    hook = Polygon(((0, 0), (0.1, 0), (0.1, 0.1), (0.09, 0.1), (0.09, 0.01), (0, 0.01)))
    for outline, values, told in (
        (SQUARE, (1.01,), "inner share 1.01 must lie from 0 to 1"),
        (SQUARE, (0, -0.01), "rim share -0.01"),
        (SQUARE, (0, 0, math.nan), "corner share"),
        (SQUARE, (0.5, 0.4, 0.2), r"add to 1\.1"),
        (SQUARE, (0.5, 0.5, 0, (0.001, 0)), "lifts"),
        (SQUARE, (0, 0, 0, (0.02, 0)), "lifts"),
        (SQUARE, (0, 0, 0, (0.0,)), "centre of pressure"),
        (Ellipse(0.05, 0.03), (0, 0, 0.1), "an ellipse has no corners"),
        (hook, (0.1, 0), "does not lie inside"),
        (hook, (0, 0.1), "does not lie inside"),
        (box(0.1, 4e-6), (), "times as thick as it is long"),
        (Ellipse(0.1, 9e-6), (), "times as thick as it is long"),
        (Polygon(((0, 0), (0.1, 0), (0.05, 1e-6))), (), "times as thick as it is long"),
    ):
        refused(PatchFootprint, outline, *values, told=told)
    assert PatchFootprint(hook, corner_share=0.1).corner_share == 0.1


@pytest.mark.slow
@pytest.mark.parametrize("name", OUTLINES)
def test_a_lean_puts_the_centre_of_pressure_under_the_centre_of_mass_while_the_load_stays_on(
    name,
):
    outline = OUTLINES[name]
    footprint = footprint_of(outline, SHARES["all"], np.random.default_rng(8))
    away = np.array(footprint.centre) - outline.centroid
    # A pure translation's torque tells where the friction acts.
    law = EllipseFriction.isotropic(1.0)
    wrench = LimitSurface(footprint, law).wrench([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
    assert np.allclose(
        (wrench[1, 2], -wrench[0, 2]),
        footprint.centre,
        rtol=0.0,
        atol=1e-14 + 1e-12 * outline.extent,
    )
    low, high = 0.0, 1e3
    for _ in range(60):
        try:
            middle = 0.5 * (low + high)
            replace(footprint, centre=tuple(outline.centroid + middle * away))
            low = middle
        except InvalidInput:
            high = middle
    edge = replace(footprint, centre=tuple(outline.centroid + low * away))
    least = edge.even_share + ((outline.points(100_000) - outline.centroid) @ edge.gradient).min()
    assert abs(least) < 1e-4 and low > 1.0
