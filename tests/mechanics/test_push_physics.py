"""What Coulomb and maximum dissipation demand of every moment of a push, on random pushes."""

import math

import numpy as np
import pytest
from random_cases import SLOWEST, balance_errors, random_case, twists_and_wrenches

from cyclemap.mechanics import LimitSurface, corner_footprint, grid_footprint

FINE = 2e-4
SEEDS = tuple(range(24))


@pytest.fixture(scope="module")
def runs():
    """Case, push and its trajectory sampled every 0.2 mm, for each seed."""
    cases = [random_case(seed, accuracy=1e-8) for seed in SEEDS]
    pushes = [case.model.push(case.pose, case.push, longest_step=FINE) for case in cases]
    return [(case, push, push.trajectory) for case, push in zip(cases, pushes, strict=True)]


def modes(trajectory):
    """Index ranges of the stretches under one mode."""
    breaks = np.flatnonzero(np.diff(trajectory.path) <= 1e-12) + 1
    return [r for r in np.split(np.arange(len(trajectory.path)), breaks) if len(r) > 4]


def contact_forces(trajectory, rows):
    """Compression and tangential force at samples, from the world's force and the rod's place."""
    outward = trajectory.pusher[rows] - trajectory.contact_point[rows]
    outward = outward / np.hypot(*outward.T)[:, None]
    along = np.stack([-outward[:, 1], outward[:, 0]], axis=-1)
    force = trajectory.contact_force[rows]
    return -(force * outward).sum(-1), (force * along).sum(-1), along


def slip(trajectory, rows):
    """Velocity of the rod over the slider along the outline, from differences of the trajectory alone."""
    path = trajectory.path[rows]
    x, y, theta = (np.gradient(trajectory.pose[rows, k], path, edge_order=2) for k in range(3))
    rod = np.stack([np.gradient(trajectory.pusher[rows, k], path, edge_order=2) for k in range(2)], axis=-1)
    lever = trajectory.contact_point[rows] - trajectory.pose[rows, :2]
    slider = np.stack([x - theta * lever[:, 1], y + theta * lever[:, 0]], axis=-1)
    _, _, along = contact_forces(trajectory, rows)
    return ((rod - slider) * along).sum(-1)


def test_the_rod_only_presses(runs):
    for _, _, trajectory in runs:
        assert contact_forces(trajectory, slice(None))[0].min() > 0.0


def test_sticking_forces_lie_in_the_cone_and_sliding_ones_on_the_edge_against_the_slip(runs):
    seen = dict.fromkeys(("stick", "slide_left", "slide_right"), 0)
    for case, _, trajectory in runs:
        mu = case.model.pusher.friction
        for rows in modes(trajectory):
            mode = str(trajectory.mode[rows[0]])
            compression, tangential, _ = contact_forces(trajectory, rows)
            velocity = slip(trajectory, rows)[1:-1]
            if mode == "stick":
                assert np.abs(velocity).max() < 1e-3
                assert (np.abs(tangential) - mu * compression).max() < 1e-4 * compression.max()
            else:
                sign = 1.0 if mode == "slide_left" else -1.0
                assert np.abs(tangential - sign * mu * compression).max() < 1e-9 * compression.max()
                assert (sign * velocity).min() > -1e-3
                assert np.abs(velocity).max() > 1e-3
            seen[mode] += 1
    assert min(seen.values()) >= 5
    assert sum(seen.values()) >= 40


def test_the_contact_point_stays_on_the_outline_and_the_rod_at_its_radius(runs):
    for case, _, trajectory in runs:
        gap = np.hypot(*(trajectory.pusher - trajectory.contact_point).T) - case.model.pusher.radius
        assert np.abs(gap).max() < 1e-15
        theta, lever = trajectory.pose[:, 2], trajectory.contact_point - trajectory.pose[:, :2]
        c, s = np.cos(theta), np.sin(theta)
        local = np.stack([c * lever[:, 0] + s * lever[:, 1], -s * lever[:, 0] + c * lever[:, 1]], axis=-1)
        outline = case.model.slider.outline
        if hasattr(outline, "semi_x"):
            off = np.hypot(local[:, 0] / outline.semi_x, local[:, 1] / outline.semi_y) - 1.0
        else:
            off = np.array([outline.distance(tuple(p)) for p in local[::20]])
        assert np.abs(off).max() < 2e-5


def test_contact_force_and_ground_friction_balance_at_the_twist_of_the_integrated_motion(runs):
    checked = 0
    for case, push, trajectory in runs:
        errors = balance_errors(case.model, push.run.phases, trajectory)
        assert errors.max() < 1e-10
        checked += len(errors)
    assert checked > 5_000


def test_the_rods_work_goes_into_the_ground_and_into_slip_at_the_contact(runs):
    for case, push, trajectory in runs:
        twists, _ = twists_and_wrenches(case.model, push.run.phases, trajectory)
        surface = LimitSurface(case.model.pressure, case.model.friction)
        toward = np.array(
            (math.cos(push.run.phases[0].motion.rod.direction), math.sin(push.run.phases[0].motion.rod.direction))
        )
        for rows in modes(trajectory):
            power = trajectory.contact_force[rows] @ toward / case.model.weight
            ground = [float(surface.dissipation(twists[i], trajectory.pose[i, 2])) for i in rows[2:-2:10]]
            _, tangential, _ = contact_forces(trajectory, rows)
            rubbed = np.abs(tangential * slip(trajectory, rows))[2:-2:10] / case.model.weight
            assert np.abs(power[2:-2:10] - ground - rubbed).max(initial=0.0) < 1e-3 * power.max()


def footprints_of(model):
    outline = model.slider.outline
    yield grid_footprint(outline, 4)
    yield corner_footprint(outline) if hasattr(outline, "vertices") else grid_footprint(outline, 2)


def test_wrench_and_twist_dissipate_maximally_even_where_a_support_point_stands_still():
    """For support points the wrench at a twist need not be unique; the inequality holds all the same."""
    rng, checked = np.random.default_rng(1), 0
    for seed in range(10):
        case = random_case(seed)
        for footprint in footprints_of(case.model):
            model = type(case.model)(case.model.slider, case.model.friction, case.model.pusher, footprint, 1e-6)
            push = model.push(case.pose, case.push)
            trajectory, surface = push.trajectory, LimitSurface(footprint, model.friction)
            twists, wrenches = twists_and_wrenches(model, push.run.phases, trajectory)
            others = rng.normal(size=(200, 3)) * (1.0, 1.0, 1.0 / footprint.extent)
            for twist, wrench, theta in zip(twists, wrenches, trajectory.pose[:, 2], strict=True):
                if np.hypot(*twist[:2]) + footprint.extent * abs(twist[2]) < SLOWEST:
                    continue
                dissipated = float(surface.dissipation(twist, theta))
                assert abs(wrench @ twist - dissipated) < 1e-9
                assert (others @ wrench - surface.dissipation(others, theta)).max() < 1e-9
                assert (surface.wrench(others, theta) @ twist).max() < dissipated + 1e-9
                checked += 1
    assert checked > 150
