"""How far the rod's force along a motion is from what the ground does at the object's twist."""

import math
from functools import partial

import numpy as np
from random_cases import SLOWEST, twists_and_wrenches

from cyclemap.mechanics import EllipseFriction, LimitSurface, PatchFootprint, PointFootprint

# Support points slower than this, per unit of rod travel, rest: of them only the friction's bound is checked.
STILL = 1e-5


def imbalance(model, phases, course, pin: float) -> float:
    """Largest distance of the contact's wrench from the ground's, relative to the friction."""
    twists, wrenches = twists_and_wrenches(model, phases, course, solved=True)
    if isinstance(model.pressure, PatchFootprint):
        surface = LimitSurface(model.pressure, model.friction)
        balance = partial(_off_surface, surface)
    else:
        balance = partial(off_points, model.pressure, model.friction)
    worst = 0.0
    scale = np.array([1.0, 1.0, 1.0 / model.unit]) / math.sqrt(model.friction.mu_a * model.friction.mu_b)
    for twist, wrench, theta, mode in zip(twists, wrenches, course.pose[:, 2], course.mode, strict=True):
        if np.hypot(*twist[:2]) + abs(twist[2]) * model.unit <= SLOWEST:
            continue
        off, held = balance(twist, wrench, theta), pin * np.hypot(*wrench[:2])
        if mode in ("ring_left", "ring_right"):
            off[2] += held if mode == "ring_left" else -held
        elif mode == "ring_stuck":
            off[2] -= np.clip(off[2], -held, held)
        worst = max(worst, float(np.abs(scale * off).max()))
    return worst


def _off_surface(surface: LimitSurface, twist, wrench, theta: float) -> np.ndarray:
    return surface.wrench(twist, frame=theta) - wrench


def off_points(footprint: PointFootprint, law: EllipseFriction, twist, wrench, theta: float) -> np.ndarray:
    """Wrench (3,) of the points at a twist less a contact's: that of points that slide, and the best of one that rests.

    A point slower than STILL rests: it takes the force that is left, as far as its friction goes.
    """
    points, weights = footprint.quadrature
    velocity = twist[:2] + twist[2] * np.stack([-points[:, 1], points[:, 0]], axis=-1)
    rests = np.hypot(*velocity.T) <= STILL
    assert rests.sum() <= 1
    slides = points[~rests]
    force = weights[~rests, None] * law.traction(velocity[~rests], frame=theta)
    found = np.array((*force.sum(axis=0), (slides[:, 0] * force[:, 1] - slides[:, 1] * force[:, 0]).sum()))
    if rests.any():
        (x, y), (fx, fy) = points[rests][0], _nearest_held(law, (wrench - found)[:2] / weights[rests], theta)
        found = found + weights[rests] * np.array((fx, fy, x * fy - y * fx))
    return found - wrench


def _nearest_held(law: EllipseFriction, traction, theta: float) -> np.ndarray:
    """A traction (object's frame), drawn towards the friction ellipse's centre until it lies inside."""
    c, s = math.cos(law.phi - theta), math.sin(law.phi - theta)
    back = np.array(((c, -s), (s, c)))
    centre = np.array((law.m0, law.n0))
    arm = back.T @ traction - centre
    return back @ (centre + arm / max(1.0, math.hypot(arm[0] / law.mu_a, arm[1] / law.mu_b)))
