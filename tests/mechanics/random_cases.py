"""Random pushes and drags, seeded; and with one thing taken to its extreme."""

import math
from dataclasses import dataclass, replace

import numpy as np

from cyclemap.mechanics import (
    MIT_SHAPE_NAMES,
    EllipseFriction,
    PointFootprint,
    Polygon,
    Pose,
    Pusher,
    QuasiStaticModel,
    SidePush,
    Slider,
    corner_footprint,
    grid_footprint,
)


@dataclass(frozen=True)
class Case:
    """One random push: the model, where the object is, how it is pushed."""

    model: QuasiStaticModel
    pose: Pose
    push: SidePush

    def run(self):
        """Push, then drag the ring back to the world's origin."""
        pushed = self.model.push(self.pose, self.push)
        return pushed, self.model.drag(pushed.end, ((0.0, 0.0),))


def random_friction(rng: np.random.Generator) -> EllipseFriction:
    """Axis ratio in [1/3, 3], centre out to 60 % of the smaller axis, any direction."""
    mu_a = rng.uniform(0.1, 0.5)
    mu_b = mu_a * math.exp(rng.uniform(-math.log(3.0), math.log(3.0)))
    off, towards = 0.6 * min(mu_a, mu_b) * math.sqrt(rng.uniform()), rng.uniform(0.0, 2.0 * math.pi)
    return EllipseFriction(mu_a, mu_b, off * math.cos(towards), off * math.sin(towards), rng.uniform(0, math.pi))


def random_case(seed: int, accuracy: float = 1e-6) -> Case:
    """Return the random case of a seed: shapes in turn, all else drawn."""
    rng = np.random.default_rng(seed)
    slider = Slider.mit(MIT_SHAPE_NAMES[seed % len(MIT_SHAPE_NAMES)])
    friction, pusher = random_friction(rng), Pusher(friction=rng.uniform(0.0, 1.0))
    side = int(rng.integers(slider.outline.sides))
    angle, distance = math.radians(rng.uniform(-60.0, 60.0)), rng.uniform(0.01, 0.15)
    push = SidePush(side, rng.uniform(0.02, 0.98), angle, distance)
    model = QuasiStaticModel(slider, friction, pusher, accuracy=accuracy)
    return Case(model, Pose(*rng.uniform(-0.1, 0.1, 2), rng.uniform(-math.pi, math.pi)), push)


def sized(case: Case, factor: float) -> Case:
    """The case with every length times a factor."""
    slider, (x, y), rod = case.model.slider, case.model.slider.hitch, case.model.pusher
    slider = Slider(slider.outline.scaled(factor), hitch=(factor * x, factor * y))
    model = replace(case.model, slider=slider, pusher=Pusher(factor * rod.radius, rod.friction))
    pose = Pose(factor * case.pose.x, factor * case.pose.y, case.pose.theta)
    return Case(model, pose, replace(case.push, distance=factor * case.push.distance))


def _pushed(**changes):
    return lambda case, rng: replace(
        case, push=replace(case.push, **{name: value(rng) for name, value in changes.items()})
    )


def _rod(**changes):
    def change(case, rng):
        rod = replace(case.model.pusher, **{name: value(rng) for name, value in changes.items()})
        return replace(case, model=replace(case.model, pusher=rod))

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
    "tiny and huge": lambda case, rng: sized(case, 10 ** rng.uniform(-5, 4)),
    "ends of a side": _pushed(fraction=lambda rng: float(rng.integers(2))),
    "sticky rod": _rod(friction=lambda rng: 5.0),
    "extreme offset": _extreme_offset,
    "thick rod": _rod(radius=lambda rng: 10 ** rng.uniform(-2, 0)),
    "long push": _pushed(distance=lambda rng: 1.0),
    "grid": _on(lambda outline, rng: grid_footprint(outline, int(rng.integers(2, 9)))),
    "corners": _on(_corners),
    "point rod": _rod(radius=lambda rng: 0.0),
    "frictionless rod": _rod(friction=lambda rng: 0.0),
    "grazing push": _pushed(angle=lambda rng: math.radians(rng.uniform(-89.9, 89.9))),
    "scattered points": _on(_scattered),
}


def harsh_case(kind: str, seed: int) -> Case:
    """Return the random case of a seed with one thing taken to its extreme."""
    return EXTREMES[kind](random_case(seed), np.random.default_rng([seed, 1]))
