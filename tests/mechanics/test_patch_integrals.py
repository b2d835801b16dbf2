"""The exact patch against an independent quadrature, wherever its centre of rotation lies."""

import math

import numpy as np
import pytest
from patch_reference import reference
from random_cases import random_friction

from cyclemap.mechanics import Ellipse, EllipseFriction, LimitSurface, PatchFootprint, Polygon, Slider
from cyclemap.mechanics.patch_integrals import FAR_RATIO

OUTLINES = {
    "square": Slider.mit("rect1").outline,
    "triangle": Slider.mit("tri3").outline,
    "hexagon": Slider.mit("hex").outline,
    "concave": Polygon(((0, 0), (0.1, 0), (0.1, 0.04), (0.04, 0.04), (0.04, 0.1), (0, 0.1))),
    "thin": Polygon(((0, 0), (0.2, 0), (0.2, 0.01), (0, 0.01))),
    "far from the origin": Polygon(((1, 1), (1.1, 1), (1.05, 1.1))),
    "disc": Ellipse(0.05, 0.05),
    "ellipse": Slider.mit("ellip3").outline,
    "thin ellipse": Ellipse(0.1, 0.01),
}
PLACES = ("centroid", "vertex", "rim", "beside the rim", "inside", "around", "near", "switch", "far", "beyond", "none")


def rim_point(outline, rng, at_vertex):
    share = 0.0 if at_vertex else rng.uniform()
    if isinstance(outline, Ellipse):
        angle = 2 * math.pi * (0.25 if at_vertex else share)
        return np.array((outline.semi_x * math.cos(angle), outline.semi_y * math.sin(angle)))
    i = rng.integers(outline.sides)
    return (1 - share) * outline.array[i] + share * outline.array[(i + 1) % outline.sides]


def centre_of_rotation(place, outline, rng):
    """A random centre of the kind that is named; the switch is where the rim integrals hand over to the area rule."""
    if place in ("vertex", "rim", "beside the rim"):
        aside = 10 ** rng.uniform(-14, -2) if place == "beside the rim" else 0.0
        return rim_point(outline, rng, place == "vertex") + aside * outline.extent * rng.normal(size=2)
    low, high = {
        "centroid": (0.0, 0.0),
        "inside": (0.0, 0.3),
        "around": (0.5, 2.0),
        "near": (3.0, FAR_RATIO),
        "switch": (0.999 * FAR_RATIO, 1.001 * FAR_RATIO),
        "far": (FAR_RATIO, 30.0),
        "beyond": (1e2, 1e9),
    }[place]
    angle = rng.uniform(0, 2 * math.pi)
    distance = outline.extent * math.exp(rng.uniform(math.log(low + 1e-300), math.log(high + 1e-300)))
    return np.array(outline.centroid) + distance * np.array((math.cos(angle), math.sin(angle)))


def twist_about(place, outline, rng):
    angle, omega = rng.uniform(0, 2 * math.pi), rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 2.0)
    if place == "none":
        return np.array((math.cos(angle), math.sin(angle), 0.0))
    x, y = centre_of_rotation(place, outline, rng)
    return np.array((omega * y, -omega * x, omega))


def relative_errors(outline, gradient, place, seed):
    rng = np.random.default_rng(seed)
    law = random_friction(rng)
    if place == "switch":
        # For an isotropic law the distance in the velocity plane is the one in space.
        law = EllipseFriction(0.3, 0.3, law.m0 / 5, law.n0 / 5)
    twist, frame = twist_about(place, outline, rng), rng.uniform(-3, 3)
    surface = LimitSurface(PatchFootprint(outline, gradient), law)
    scale = np.array((1.0, 1.0, 1.0 / outline.extent))
    value, slope, hessian = reference(outline, law, twist, frame, gradient)
    both = np.outer(scale, scale)
    return (
        abs(surface.dissipation(twist, frame) / value - 1.0),
        np.linalg.norm(scale * (surface.wrench(twist, frame) - slope)) / np.linalg.norm(scale * slope),
        np.linalg.norm(both * (surface.hessian(twist, frame) - hessian)) / np.linalg.norm(both * hessian),
    )


@pytest.mark.parametrize("leans", [False, True], ids=["even", "leaning"])
@pytest.mark.parametrize("name", OUTLINES)
def test_dissipation_wrench_and_hessian_match_quadrature_to_1e_10_wherever_the_centre_lies(name, leans):
    outline = OUTLINES[name]
    gradient = (0.5 / outline.extent, -0.3 / outline.extent) if leans else (0.0, 0.0)
    seeds = [(place, 10 * i + k) for i, place in enumerate(PLACES) for k in range(4)]
    errors = np.array([relative_errors(outline, gradient, place, seed) for place, seed in seeds])
    assert len(errors) == 44
    assert errors[:, :2].max() < 1e-11
    assert errors[:, 2].max() < 1e-10


def both_sides_of_the_switch(outline, rng):
    """Values just inside and just outside the switch, whose true difference is smaller than what is asserted."""
    angle = rng.uniform(0, 2 * math.pi)
    surface = LimitSurface(PatchFootprint(outline), EllipseFriction.isotropic(0.3))
    values = []
    for ratio in (FAR_RATIO * (1 - 1e-14), FAR_RATIO * (1 + 1e-14)):
        c = np.array(outline.centroid) + ratio * outline.extent * np.array((math.cos(angle), math.sin(angle)))
        twist = np.array((c[1], -c[0], 1.0)) / outline.extent
        values.append(
            np.concatenate([[surface.dissipation(twist)], surface.wrench(twist), surface.hessian(twist).ravel()])
        )
    return values


@pytest.mark.parametrize("name", OUTLINES)
def test_rim_integrals_and_area_rule_agree_where_one_hands_over_to_the_other(name):
    rng, worst = np.random.default_rng(3), 0.0
    for _ in range(10):
        inside, outside = both_sides_of_the_switch(OUTLINES[name], rng)
        worst = max(worst, np.abs(inside - outside).max() / np.abs(inside).max())
    assert 0.0 < worst < 2e-11
