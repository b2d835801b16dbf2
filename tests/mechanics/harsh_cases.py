"""Random pushes with one thing taken to its extreme, seeded."""

import math
from dataclasses import replace

import numpy as np
from random_cases import Case, random_case

from cyclemap.mechanics import (
    Ellipse,
    EllipseFriction,
    PointFootprint,
    Polygon,
    Pose,
    Pusher,
    Slider,
    corner_footprint,
    grid_footprint,
)


def _sized(case, rng):
    factor, slider = 10 ** rng.uniform(-5, 4), case.model.slider
    outline = slider.outline
    if isinstance(outline, Ellipse):
        scaled = Ellipse(factor * outline.semi_x, factor * outline.semi_y)
    else:
        scaled = Polygon(tuple(map(tuple, factor * outline.array)))
    slider = Slider(scaled, hitch=(factor * slider.hitch[0], factor * slider.hitch[1]))
    rod = Pusher(factor * case.model.pusher.radius, case.model.pusher.friction)
    pose = Pose(factor * case.pose.x, factor * case.pose.y, case.pose.theta)
    push = replace(case.push, distance=factor * case.push.distance)
    return Case(replace(case.model, slider=slider, pusher=rod), pose, push)


def _pushed(**changes):
    def change(case, rng):
        drawn = {name: value(rng) for name, value in changes.items()}
        return replace(case, push=replace(case.push, **drawn))

    return change


def _rod(radius=None, friction=None):
    def change(case, rng):
        rod = case.model.pusher
        values = (radius(rng) if radius else rod.radius, friction if friction is not None else rod.friction)
        return replace(case, model=replace(case.model, pusher=Pusher(*values)))

    return change


def _extreme_offset(case, rng):
    law, towards = case.model.friction, rng.uniform(0, 2 * math.pi)
    centre = 0.95 * law.mu_a * math.cos(towards), 0.95 * law.mu_b * math.sin(towards)
    return replace(case, model=replace(case.model, friction=EllipseFriction(law.mu_a, law.mu_b, *centre, law.phi)))


def _on(footprint):
    def change(case, rng):
        return replace(case, model=replace(case.model, footprint=footprint(case.model.slider.outline, rng)))

    return change


def _corners(outline, rng):
    return corner_footprint(outline) if isinstance(outline, Polygon) else grid_footprint(outline, 2)


def _scattered(outline, rng):
    count = int(rng.integers(2, 7))
    points, weights = rng.uniform(-0.04, 0.04, (count, 2)), rng.uniform(0.05, 1.0, count)
    return PointFootprint(tuple(map(tuple, points)), tuple(weights))


EXTREMES = {
    "tiny and huge": _sized,
    "ends of a side": _pushed(fraction=lambda rng: float(rng.integers(2))),
    "sticky rod": _rod(friction=5.0),
    "extreme offset": _extreme_offset,
    "thick rod": _rod(radius=lambda rng: 10 ** rng.uniform(-2, 0)),
    "long push": _pushed(distance=lambda rng: 1.0),
    "grid": _on(lambda outline, rng: grid_footprint(outline, int(rng.integers(2, 9)))),
    "corners": _on(_corners),
    "point rod": _rod(radius=lambda rng: 0.0),
    "frictionless rod": _rod(friction=0.0),
    "grazing push": _pushed(angle=lambda rng: math.radians(rng.uniform(-89.9, 89.9))),
    "scattered points": _on(_scattered),
}


def harsh_case(kind: str, seed: int) -> Case:
    """Return the random case of a seed with one thing taken to its extreme."""
    return EXTREMES[kind](random_case(seed), np.random.default_rng([seed, 1]))
