"""A second solver in plain numpy and scipy: minimises dissipation by brute force, integrates generically.

It shares nothing with the package but the definitions: the object's full pose is the state (it may drift off the rod),
sticking minimises D over the spin, sliding minimises D on the twists that the cone's edge does unit work on.
"""

import math

import numpy as np
import pytest
from force_balance import story
from scipy.integrate import solve_ivp
from scipy.optimize import minimize, minimize_scalar

from cyclemap.mechanics import (
    EllipseFriction,
    Pose,
    Pusher,
    QuasiStaticModel,
    SidePush,
    Slider,
    grid_footprint,
    load_material,
)

SLIDER = Slider.mit("rect1")
HALF, RADIUS = 0.045, 0.00475


class BruteForce:
    """A square pushed on its top side by a rod, on equally loaded points."""

    def __init__(self, law, points, pusher_friction):
        self.law, self.points, self.mu, self.spin = law, points, pusher_friction, 0.0
        self.sliding = np.zeros(2)

    def dissipation(self, twist, theta):
        """D and its gradient at a twist (vx, vy, omega) of the object's frame."""
        x, y = self.points.T
        velocity = np.stack([twist[0] - twist[2] * y, twist[1] + twist[2] * x], axis=-1)
        c, s = math.cos(self.law.phi - theta), math.sin(self.law.phi - theta)
        turn = np.array(((c, s), (-s, c)))
        v = velocity @ turn.T
        axes, centre = np.array((self.law.mu_a, self.law.mu_b)), np.array((self.law.m0, self.law.n0))
        speed = np.hypot(*(axes * v).T)
        force = (centre + axes**2 * v / speed[:, None]) @ turn
        torque = x * force[:, 1] - y * force[:, 0]
        wrench = np.array((*force.mean(axis=0), torque.mean()))
        return wrench @ twist, wrench

    def twist(self, rod, theta, contact_x):
        """The object's twist for a unit rod velocity `rod` (its own axes), touched at (contact_x, HALF)."""

        def stuck(omega):
            return np.array((rod[0] + omega * HALF, rod[1] - omega * contact_x, omega))

        found = minimize_scalar(
            lambda w: self.dissipation(stuck(w), theta)[0], bracket=(self.spin - 1, self.spin + 1), tol=1e-12
        )
        self.spin = self._polished(stuck, found.x, theta, contact_x)
        force = self.dissipation(stuck(self.spin), theta)[1]
        if abs(force[0]) <= -self.mu * force[1]:
            return stuck(self.spin)
        return self._slid(rod, theta, contact_x, math.copysign(self.mu, force[0]))

    def _polished(self, stuck, omega, theta, contact_x):
        """Newton on the torque about the contact, with a differenced slope."""
        direction = np.array((HALF, -contact_x, 1.0))
        for _ in range(4):
            torque, more = (direction @ self.dissipation(stuck(w), theta)[1] for w in (omega, omega + 1e-5))
            omega -= torque * 1e-5 / (more - torque)
        return omega

    def _slid(self, rod, theta, contact_x, smu):
        """Minimise D on {W . V = 1}, W the wrench of the cone's edge; then scale to the rod's approach."""
        force = np.array((smu, -1.0))
        wrench = np.array((*force, contact_x * force[1] - HALF * force[0]))
        start = wrench / (wrench @ wrench * 1.0)
        scale = np.array((1.0, 1.0, 1.0 / 0.06))
        basis = np.linalg.svd((wrench * scale)[None])[2][1:].T * scale[:, None]
        found = minimize(
            lambda z: (lambda d: (d[0], basis.T @ d[1]))(self.dissipation(start + basis @ z, theta)),
            self.sliding,
            jac=True,
            method="BFGS",
            options={"gtol": 1e-13},
        )
        self.sliding = found.x
        twist = start + basis @ found.x
        return twist * rod[1] / (twist[1] + twist[2] * contact_x)


def brute_force_push(law, theta_0, distance, pusher_friction, points, fraction):
    """Final pose of a push straight down from a fraction of the top side."""
    solver = BruteForce(law, points, pusher_friction)
    c, s = math.cos(theta_0), math.sin(theta_0)
    first = np.array((HALF - fraction * 2 * HALF, HALF + RADIUS))
    start, toward = np.array((c * first[0] - s * first[1], s * first[0] + c * first[1])), np.array((s, -c))

    def rate(travel, pose):
        c, s = math.cos(pose[2]), math.sin(pose[2])
        lever = start + travel * toward - pose[:2]
        rod = np.array((c * toward[0] + s * toward[1], -s * toward[0] + c * toward[1]))
        vx, vy, omega = solver.twist(rod, pose[2], c * lever[0] + s * lever[1])
        return np.array((c * vx - s * vy, s * vx + c * vy, omega))

    return solve_ivp(rate, (0.0, distance), (0.0, 0.0, theta_0), rtol=1e-7, atol=1e-9, method="RK45").y[:, -1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "theta_0", "distance", "pusher_friction"),
    [
        (load_material("plywood").friction, math.radians(150.0), 0.15, 0.15),
        (EllipseFriction(0.35, 0.18, 0.05, -0.03, 0.7), -1.0, 0.08, 0.4),
    ],
    ids=["plywood", "strong"],
)
def test_a_brute_force_solver_moves_the_object_to_the_same_pose(law, theta_0, distance, pusher_friction):
    footprint = grid_footprint(SLIDER.outline, 8)
    model = QuasiStaticModel(SLIDER, law, Pusher(RADIUS, pusher_friction), footprint)
    push = model.push(Pose(theta=theta_0), SidePush(distance=distance))
    assert {kind for _, kind in story(push)} == {"side"}
    assert len(story(push)) >= 2
    x, y, theta = brute_force_push(law, theta_0, distance, pusher_friction, np.array(footprint.positions), 0.7)
    assert abs(theta - push.end.theta) < 2e-5
    assert np.hypot(x - push.end.x, y - push.end.y) < 1e-6
