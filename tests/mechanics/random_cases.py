"""Random pushes and drags, seeded, and the independent check of their force balance."""

import math
from dataclasses import dataclass

import numpy as np

from cyclemap.mechanics import (
    MIT_SHAPE_NAMES,
    EllipseFriction,
    LimitSurface,
    Pose,
    Pusher,
    QuasiStaticModel,
    SidePush,
    Slider,
)
from cyclemap.mechanics.runge_kutta import MARGIN, SLOPE, STATE, UNKNOWN

# Below this speed (per unit of rod travel) the twist's own direction has too few digits to be checked.
SLOWEST = 1e-4


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


def twists_and_wrenches(model: QuasiStaticModel, phases, trajectory, solved: bool = False):
    """Twists of the object's frame (n, 3) and contact wrenches per unit load (n, 3) about its origin, its own axes.

    The twist comes from the integrated motion and the geometry of the contact curve alone, the wrench from the
    reported contact force: that they belong together is left to be checked. Lengths in m, rates per m of rod travel.
    `solved`: with rates that are solved once more; those of steps are only as exact as the accuracy asks.
    """
    twists, wrenches, node = [], [], 0
    for phase in phases:
        rows = [phase.phase.steps[0].stages[0], *(taken.stages[-1] for taken in phase.phase.steps)]
        for row in rows:
            if solved:
                phase.motion.unknowns = row[UNKNOWN].tolist()
                row = phase.motion.evaluate(row[STATE])
            twists.append(_twist(model, phase.motion, row))
            wrenches.append(_wrench(model, trajectory, node))
            node += 1
    assert node == len(trajectory.path)
    return np.array(twists), np.array(wrenches)


def balance_errors(model: QuasiStaticModel, phases, trajectory) -> np.ndarray:
    """Distance (n,) of the contact wrench from the limit surface's at the object's twist, relative to the friction."""
    twists, wrenches = twists_and_wrenches(model, phases, trajectory)
    surface, errors = LimitSurface(model.pressure, model.friction), []
    scale = np.array([1.0, 1.0, 1.0 / model.unit]) / math.sqrt(model.friction.mu_a * model.friction.mu_b)
    for twist, wrench, theta in zip(twists, wrenches, trajectory.pose[:, 2], strict=True):
        if np.hypot(*twist[:2]) + abs(twist[2]) * model.unit > SLOWEST:
            errors.append(np.abs(scale * (surface.wrench(twist, frame=theta) - wrench)).max())
    return np.array(errors)


def _twist(model, motion, row):
    theta, coordinate = row[STATE]
    omega, rate = row[SLOPE]
    contact, metric = motion.piece.contact(float(coordinate), motion.rod.radius)
    off = motion.rod.direction - theta
    velocity = np.array((math.cos(off), math.sin(off)))
    if motion.slides and row[MARGIN][0] < 0.0:
        # A rod that leaves lands there to within the event's slack, on either side: its force belongs to the twist
        # that vanishes there, from before.
        omega, rate, velocity = -omega, -rate, -velocity
    place, travel = np.array((contact.x, contact.y)), 0.0
    if not motion.in_ring:
        n = np.array((math.cos(contact.normal), math.sin(contact.normal)))
        place, travel = place + motion.rod.radius * n, rate * metric
        velocity = velocity - travel * np.array((-n[1], n[0]))
    # The rod's centre moves with the slider but for its travel along the contact curve.
    return np.array((velocity[0] + omega * place[1], velocity[1] - omega * place[0], omega / model.unit))


def _wrench(model, trajectory, node):
    x, y, theta = trajectory.pose[node]
    back = np.array(((math.cos(theta), math.sin(theta)), (-math.sin(theta), math.cos(theta))))
    force = back @ trajectory.contact_force[node] / model.weight
    lever = back @ (trajectory.contact_point[node] - (x, y))
    return np.array((*force, lever[0] * force[1] - lever[1] * force[0]))
