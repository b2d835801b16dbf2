"""Random pushes and drags, seeded; and with one thing taken to its extreme."""

import math
from dataclasses import dataclass, replace

import numpy as np

from cyclemap.mechanics import (
    MIT_SHAPE_NAMES,
    EllipseFriction,
    PointFootprint,
    Pose,
    Pusher,
    QuasiStaticModel,
    SidePush,
    Slider,
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
    return EllipseFriction(
        mu_a, mu_b, off * math.cos(towards), off * math.sin(towards), rng.uniform(0, math.pi)
    )


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


def harsh_case(kind: str, seed: int) -> Case:
    """The random case of a seed with one thing taken to its extreme."""
    case, rng = random_case(seed), np.random.default_rng([seed, 1])
    if kind == "grazing push":
        return replace(case, push=replace(case.push, angle=math.radians(rng.uniform(-89.9, 89.9))))
    if kind == "extreme offset":
        law, towards = case.model.friction, rng.uniform(0, 2 * math.pi)
        centre = 0.95 * law.mu_a * math.cos(towards), 0.95 * law.mu_b * math.sin(towards)
        return replace(
            case,
            model=replace(
                case.model, friction=EllipseFriction(law.mu_a, law.mu_b, *centre, law.phi)
            ),
        )
    count = int(rng.integers(2, 7))
    points, weights = rng.uniform(-0.04, 0.04, (count, 2)), rng.uniform(0.05, 1.0, count)
    footprint = PointFootprint(tuple(map(tuple, points)), tuple(weights))
    return replace(case, model=replace(case.model, footprint=footprint))


def distances(outline, places) -> np.ndarray:
    """Of places (n, 2) from an outline, which is cut in forty thousand sides if it is an
    ellipse."""
    corners = outline.points(40_000)
    a, edge = corners[:-1], np.diff(corners, axis=0)
    offset = places[:, None] - a
    share = np.clip((offset * edge).sum(-1) / (edge * edge).sum(-1), 0.0, 1.0)
    return np.linalg.norm(offset - share[..., None] * edge, axis=-1).min(axis=1)
