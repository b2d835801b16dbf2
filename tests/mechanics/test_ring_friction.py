"""Friction of the rod in the ring: a second route to the motion, its limits, and that there is only one."""

import math
from dataclasses import replace

import numpy as np
import pytest
from random_cases import random_friction
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from cyclemap.errors import InvalidInput
from cyclemap.mechanics import (
    MIT_SHAPE_NAMES,
    DragBack,
    EllipseFriction,
    LimitSurface,
    PatchFootprint,
    Pose,
    QuasiStaticModel,
    Slider,
    grid_footprint,
    load_material,
)
from cyclemap.mechanics.runge_kutta import SLOPE, STATE

PLYWOOD = load_material("plywood").friction
RECT = Slider.mit("rect1")
MODEL = QuasiStaticModel(RECT, PLYWOOD, accuracy=1e-9)


def wrench_on_points(law, points, twist, theta):
    """Mean force and torque about the object's origin of equally loaded points, from the point law alone."""
    x, y = points.T
    traction = law.traction(np.stack([twist[0] - twist[2] * y, twist[1] + twist[2] * x], axis=-1), frame=theta)
    return np.array((*traction.mean(axis=0), (x * traction[:, 1] - y * traction[:, 0]).mean()))


def brute_force_spin(law, points, hitch, direction, theta, radius):
    """The spin at which the torque about the ring is radius |F| against it, zero if less than that would hold it."""
    u = np.array((math.cos(direction - theta), math.sin(direction - theta)))
    x, y = hitch

    def torques(omega):
        wrench = wrench_on_points(law, points, (u[0] + omega * y, u[1] - omega * x, omega), theta)
        return wrench[2] - x * wrench[1] + y * wrench[0], radius * math.hypot(wrench[0], wrench[1])

    torque, limit = torques(0.0)
    if abs(torque) <= limit:
        return 0.0
    sign = -math.copysign(1.0, torque)

    def excess(omega):
        torque, limit = torques(omega)
        return torque + sign * limit

    return brentq(excess, 0.0, sign * 1e4, xtol=1e-12)


@pytest.mark.parametrize("radius", [0.0, 0.001, 0.005])
def test_a_brute_force_solver_turns_the_object_to_the_same_angle(radius):
    footprint, law = grid_footprint(RECT.outline, 8), EllipseFriction(0.35, 0.18, 0.05, -0.03, 0.7)
    model = QuasiStaticModel(RECT, law, footprint=footprint)
    points, pose = np.array(footprint.positions), Pose(0.08, -0.04, 2.0)
    ring = model.ring_place(pose)
    direction, length = math.atan2(-ring[1], -ring[0]), math.hypot(*ring)
    rate = lambda _, theta: [brute_force_spin(law, points, RECT.hitch, direction, theta[0], radius)]  # noqa: E731
    wanted = solve_ivp(rate, (0.0, length), [2.0], rtol=1e-8, atol=1e-10).y[0, -1]
    found = model.drag(pose, ((0.0, 0.0),), pin_friction_radius=radius)
    assert abs(found.turn) > 0.3
    assert abs(found.end.theta - wanted) < 1e-6


def test_without_friction_the_drag_is_the_old_one_and_little_friction_changes_little():
    start, goal = Pose(0.1, 0.05, 1.0), ((0.0, 0.0),)
    free = MODEL.drag(start, goal)
    assert MODEL.drag(start, goal, pin_friction_radius=0.0).end == free.end
    for radius in (1e-8, 1e-6):
        turn = MODEL.drag(start, goal, pin_friction_radius=radius).turn
        assert 0.0 < abs(turn - free.turn) < 100.0 * radius


def test_friction_turns_the_object_less_and_much_of_it_not_at_all():
    start, goal = Pose(0.1, 0.05, 3.0), ((0.0, 0.0),)
    turns = [abs(MODEL.drag(start, goal, pin_friction_radius=r).turn) for r in (0.0, 0.002, 0.006, 0.012, 0.1)]
    assert (np.diff(turns[:4]) < -1e-3).all()
    assert turns[4] == 0.0
    stuck = MODEL.drag(start, goal, longest_step=0.01, pin_friction_radius=0.1)
    assert stuck.length == pytest.approx(MODEL.drag(start, goal).length, rel=1e-14)
    assert np.allclose(MODEL.ring_place(stuck.end), 0.0, atol=1e-16)
    assert set(stuck.trajectory.mode) == {"ring_stuck"}
    assert len(stuck.trajectory.path) > 8
    assert (stuck.trajectory.pose[:, 2] == 3.0).all()


def test_a_long_drag_ends_with_the_force_at_the_friction_circles_edge():
    """On isotropic friction the object trails at the angle whose sine is the circle's radius over the lever."""
    model, lever = replace(MODEL, friction=EllipseFriction.isotropic(0.3)), math.hypot(*RECT.hitch)
    for theta in (2.0, 3.0, 0.0):
        drag = model.drag(Pose(0.0, 0.0, theta), ((20.0, 0.0),), pin_friction_radius=0.004)
        ahead = drag.end.theta + math.atan2(RECT.hitch[1], RECT.hitch[0]) - drag.legs[0].phase.motion.rod.direction
        trailing = math.remainder(ahead, 2.0 * math.pi)
        assert abs(trailing) == pytest.approx(math.asin(0.004 / lever), abs=1e-6)
        assert math.copysign(1.0, trailing) == -math.copysign(1.0, drag.turn)


@pytest.mark.parametrize("radius", [0.001, 0.004])
def test_the_rods_power_is_dissipated_by_ground_and_ring(radius):
    """F . u = D(V) + radius |F| |omega| at every sample, D from the limit surface, F as reported."""
    footprint = PatchFootprint(RECT.outline, rim_share=0.3)
    model, checked = replace(MODEL, footprint=footprint), 0
    surface = LimitSurface(footprint, PLYWOOD)
    drag = model.drag(Pose(0.1, 0.05, 1.0), ((0.05, 0.1), (0.0, 0.0)), pin_friction_radius=radius)
    course, node = drag.trajectory, 0
    for leg in drag.legs:
        direction = leg.phase.motion.rod.direction
        u = np.array((math.cos(direction), math.sin(direction)))
        rows = [leg.phase.phase.steps[0].stages[0], *(taken.stages[-1] for taken in leg.phase.phase.steps)]
        for row in rows:
            theta, omega = row[STATE][0], row[SLOPE][0] / model.unit
            c, s = math.cos(direction - theta), math.sin(direction - theta)
            twist = (c + omega * RECT.hitch[1], s - omega * RECT.hitch[0], omega)
            force = course.contact_force[node] / model.weight
            lost = float(surface.dissipation(twist, theta)) + radius * np.hypot(*force) * abs(omega)
            assert force @ u == pytest.approx(lost, rel=1e-9)
            checked, node = checked + (omega != 0.0), node + 1
    assert node == len(course.path)
    assert checked > 8


def test_a_mirror_image_turns_the_other_way():
    for theta in (0.4, 2.0, -1.2):
        found = MODEL.drag(Pose(0.1, 0.05, theta), ((0.0, 0.03),), pin_friction_radius=0.002)
        mirrored = EllipseFriction(PLYWOOD.mu_a, PLYWOOD.mu_b, PLYWOOD.m0, -PLYWOOD.n0, -PLYWOOD.phi)
        slider = replace(RECT, hitch=(RECT.hitch[0], -RECT.hitch[1]))
        image = QuasiStaticModel(slider, mirrored, accuracy=1e-9)
        seen = image.drag(Pose(0.1, -0.05, -theta), ((0.0, -0.03),), pin_friction_radius=0.002)
        assert seen.turn == pytest.approx(-found.turn, abs=1e-8)
        assert abs(found.turn) > 0.01


def test_cutting_a_leg_in_two_changes_nothing_though_the_mode_is_chosen_anew():
    start = Pose(0.1, 0.05, 1.0)
    ring = np.array(MODEL.ring_place(start))
    for radius in (0.002, 0.02):
        whole = MODEL.drag(start, ((0.0, 0.0),), pin_friction_radius=radius)
        cut = MODEL.drag(start, (tuple(0.4 * ring), (0.0, 0.0)), pin_friction_radius=radius)
        assert len(cut.legs) == 2
        assert abs(cut.turn - whole.turn) < 1e-9


def test_there_is_one_spin_as_long_as_the_circle_is_smaller_than_half_the_lever():
    """The radius that a spin balances, -torque/|F|, must fall as the spin grows: then every radius has one spin.

    Among 3000 random motions it rose in 12, all at radii above 0.7 of the ring's lever from the centre of pressure.
    """
    rng, spins, checked = np.random.default_rng(1), np.geomspace(1e-3, 1e2, 200), 0
    for index in range(40):
        outline, law = Slider.mit(MIT_SHAPE_NAMES[index % 7]).outline, random_friction(rng)
        lever, angle = rng.uniform(0.05, 1.5) * outline.extent, rng.uniform(0.0, 2.0 * math.pi)
        x, y = np.array(outline.centroid) + lever * np.array((math.cos(angle), math.sin(angle)))
        surface, direction = LimitSurface(PatchFootprint(outline), law), rng.uniform(-3.0, 3.0)
        for sign in (1.0, -1.0):
            omega = sign * spins / outline.extent
            velocity = (math.cos(direction) + omega * y, math.sin(direction) - omega * x)
            wrench = surface.wrench(np.stack([*velocity, omega], axis=-1))
            torque = wrench @ np.array((y, -x, 1.0))
            radius = -sign * torque / np.hypot(wrench[:, 0], wrench[:, 1])
            counts = (radius[:-1] > 0.0) & (radius[:-1] < 0.5 * lever)
            assert (np.diff(radius)[counts] < 1e-12).all()
            checked += counts.any()
    assert checked >= 30


def test_the_reset_carries_the_friction_and_refuses_what_is_none():
    assert DragBack().pin_friction_radius == 0.0
    for bad, told in ((-0.001, "-0.001"), (float("nan"), "nan"), ("rough", "rough")):
        with pytest.raises(InvalidInput, match=told):
            DragBack(pin_friction_radius=bad)
        with pytest.raises(InvalidInput, match=told):
            MODEL.drag(Pose(), ((0.1, 0.0),), pin_friction_radius=bad)
