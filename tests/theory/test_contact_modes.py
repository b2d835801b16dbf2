"""Sticking and sliding twists: the conditions hold on the code's solutions, the ellipsoid's forms on minimisers'."""

import math

import numpy as np
import pytest
import sympy as sp
from residuals import residuals, vanishes
from scipy.optimize import minimize, minimize_scalar

from cyclemap.mechanics import (
    EllipseFriction,
    LimitSurface,
    PatchFootprint,
    PointFootprint,
    Polygon,
    Pose,
    Pusher,
    QuasiStaticModel,
    SidePush,
    Slider,
    grid_footprint,
    load_material,
)
from theory import contact_modes as theory

RESIDUALS = residuals(theory)
OUTLINE = Polygon(((-1, -1), (1, -1), (1, 1), (-1, 1))).scaled(math.sqrt(0.5))
PATCHES = {"patch": PatchFootprint(OUTLINE), "grid": grid_footprint(OUTLINE, 8)}
# Friction of a rod that always sticks; travel over which a twist is told.
HOLDS, SHORT = 50.0, 1e-6
every_patch = pytest.mark.parametrize("footprint", PATCHES.values(), ids=PATCHES)

_FACTOR = [theory.C[i, j] for i in range(3) for j in range(i + 1)]
_PLACE = (theory.X, theory.Y)
_ELLIPSOID = (*_FACTOR, *_PLACE, theory.U_X, theory.U_Y)
STICKING = sp.lambdify(_ELLIPSOID, theory.sticking_twist(), cse=True)
SLIDING = sp.lambdify((*_ELLIPSOID, theory.NU, theory.SMU), theory.sliding_twist(), cse=True)
MOBILITY = sp.lambdify((*_FACTOR, *_PLACE), theory.mobility(), cse=True)
EDGE_WRENCH = sp.lambdify((*_PLACE, theory.NU, theory.SMU), list(theory.sliding_wrench()))
FAMILY = sp.lambdify((*_PLACE, theory.U_X, theory.U_Y, theory.OMEGA), list(theory.sticking_family(theory.OMEGA)))


@pytest.mark.slow
@pytest.mark.parametrize("name", RESIDUALS)
def test_every_residual_of_the_contact_modes_is_exactly_zero(name):
    assert vanishes(RESIDUALS[name]())


def test_there_are_fifteen_residuals():
    assert len(RESIDUALS) == 15


class Case:
    """A random contact on the square's sides, a random law, a rod without a radius that approaches."""

    def __init__(self, footprint, seed):
        rng = np.random.default_rng(seed)
        mu_a, ratio, off, towards = (
            rng.uniform(0.1, 0.5),
            2.5 ** rng.uniform(-1, 1),
            0.5 * rng.uniform(),
            rng.uniform(0, 7),
        )
        offset = off * mu_a * math.cos(towards), off * mu_a * ratio * math.sin(towards)
        self.law = EllipseFriction(mu_a, mu_a * ratio, *offset, rng.uniform(0, 7))
        self.theta, self.side = rng.uniform(-3, 3), int(rng.integers(4))
        self.fraction, self.nu = rng.uniform(0.05, 0.95), self.side * math.pi / 2 - math.pi / 2
        start, end = OUTLINE.array[self.side], OUTLINE.array[(self.side + 1) % 4]
        self.place = start + self.fraction * (end - start)
        self.away = rng.uniform(-1.2, 1.2)
        self.smu = rng.choice((-1, 1)) * rng.uniform(0.05, 0.4)
        self.footprint, self.surface = footprint, LimitSurface(footprint, self.law)

    def rod(self, away):
        """Unit velocity of the rod in the object's frame."""
        return np.array((math.cos(self.nu + math.pi + away), math.sin(self.nu + math.pi + away)))

    def pushed(self, away, friction=HOLDS):
        """The code's mode and force (object's frame, per weight), and its twist by a push of a millionth."""
        model = QuasiStaticModel(Slider(OUTLINE), self.law, Pusher(0.0, friction), self.footprint, 1e-11)
        push = model.push(Pose(theta=self.theta), SidePush(self.side, self.fraction, away, SHORT))
        course = push.trajectory
        twist = np.array((*push.displacement, push.turn)) / SHORT
        force = np.array(Pose(theta=-self.theta).to_world(*course.contact_force[0].tolist())) / model.weight
        return course.mode[0], force, twist

    def sliding(self):
        """The code's sliding force, twist and contact velocity on one edge of its motion cone, for a unit approach.

        The rod moves almost along the side, so that it slips the way of `smu`.
        """
        mode, force, twist = self.pushed(-math.copysign(1.5, self.smu), abs(self.smu))
        assert mode == ("slide_left" if self.smu > 0.0 else "slide_right")
        x, y = self.place
        moved = twist[:2] + twist[2] * np.array((-y, x))
        normal = np.array((math.cos(self.nu), math.sin(self.nu)))
        return force, twist / -(normal @ moved), moved / -(normal @ moved)

    def dissipation(self, rod, spin):
        """The code's dissipation for a velocity of the contact and a spin."""
        return float(self.surface.dissipation(np.array(FAMILY(*self.place, *rod, spin)), self.theta))


@every_patch
def test_the_codes_sticking_spin_minimises_the_dissipation_and_its_force_is_the_grounds(footprint):
    for seed in range(20):
        case = Case(footprint, seed)
        mode, (fx, fy), twist = case.pushed(case.away)
        wrench = np.array((fx, fy, case.place[0] * fy - case.place[1] * fx))
        assert mode == "stick"
        assert np.abs(case.surface.wrench(twist, case.theta) - wrench).max() < 1e-4
        rod = case.rod(case.away)
        searched = minimize_scalar(lambda spin: case.dissipation(rod, spin), tol=1e-10)  # noqa: B023
        assert abs(searched.x - twist[2]) < 1e-4 * max(1.0, abs(twist[2]))


@every_patch
def test_the_codes_sliding_twist_minimises_the_dissipation_among_those_of_the_same_power_of_the_cones_edge(footprint):
    rng, compared = np.random.default_rng(0), 0
    for seed in range(20):
        case = Case(footprint, seed)
        force, twist, _ = case.sliding()
        wrench = np.array(EDGE_WRENCH(*case.place, case.nu, case.smu))
        multiplier = np.hypot(*force) / np.hypot(*wrench[:2])
        assert np.abs(force - multiplier * wrench[:2]).max() < 1e-9
        assert np.abs(case.surface.wrench(twist, case.theta) - multiplier * wrench).max() < 1e-4
        # The multiplier is D per power, by Euler's theorem.
        least = case.surface.dissipation(twist, case.theta)
        assert abs(multiplier * (wrench @ twist) / least - 1.0) < 1e-4
        along = np.linalg.svd(wrench[None])[2][1:]
        others = twist + (rng.normal(size=(50, 2)) * rng.choice((0.1, 1.0), (50, 1))) @ along
        assert (case.surface.dissipation(others, case.theta) > least).all()
        compared += 1
    assert compared == 20


@every_patch
def test_on_the_edge_of_the_codes_motion_cone_sticking_and_sliding_are_one_motion(footprint):
    for seed in range(20):
        case = Case(footprint, seed)
        force, slid, moved = case.sliding()
        speed, along = np.hypot(*moved), math.atan2(moved[1], moved[0]) - case.nu - math.pi
        _, held, stuck = case.pushed(math.remainder(along, 2.0 * math.pi))
        assert np.abs(held - force).max() < 1e-4
        assert np.abs(speed * stuck - slid).max() < 1e-4 * max(1.0, np.abs(slid).max())


def test_the_codes_rod_slips_the_way_in_which_the_force_that_sticking_needs_leaves_its_cone():
    slipped = 0
    for seed in range(60):
        case = Case(PATCHES["patch"], seed)
        _, force, _ = case.pushed(case.away)
        normal, tangent = case.rod(0.0), np.array((-math.sin(case.nu), math.cos(case.nu)))
        beyond = abs(force @ tangent) > abs(case.smu) * (force @ normal)
        mode, _, _ = case.pushed(case.away, abs(case.smu))
        assert mode == ("stick" if not beyond else "slide_left" if force @ tangent > 0.0 else "slide_right")
        slipped += beyond
    assert 15 < slipped < 55


def test_the_codes_contact_force_is_the_gradient_of_the_least_dissipation_by_the_rods_velocity():
    """Along the rod's velocity by Euler's theorem, across it by differences over its direction."""
    for seed in range(10):
        case, step = Case(PATCHES["patch"], seed), 1e-5
        least = [case.rod(away) @ case.pushed(away)[1] for away in (case.away - step, case.away + step)]
        across = case.rod(case.away + math.pi / 2)
        assert abs((least[1] - least[0]) / (2.0 * step) - across @ case.pushed(case.away)[1]) < 1e-7


def test_forces_are_continuous_where_a_push_goes_from_sticking_to_sliding():
    switches = 0
    for theta in np.linspace(0.0, 6.0, 7):
        model = QuasiStaticModel(Slider.mit("rect1"), load_material("plywood").friction, accuracy=1e-9)
        course = model.push(Pose(theta=theta), SidePush()).trajectory
        for last in np.flatnonzero(np.diff(course.phase)):
            if "stick" in course.mode[last : last + 2]:
                assert course.path[last] == course.path[last + 1]
                jump = course.contact_force[last + 1] - course.contact_force[last]
                assert np.abs(jump).max() < 1e-5 * model.weight
                switches += 1
    assert switches >= 7


def flat_directions(footprint, twist):
    """Number of directions of twist along which the code's dissipation has no curvature."""
    hessian = LimitSurface(footprint, EllipseFriction(0.3, 0.2, phi=0.4)).hessian(twist)
    sizes = np.linalg.eigvalsh(hessian)
    return int((np.abs(sizes) < 1e-10 * sizes.max()).sum())


def test_dissipation_is_flat_along_the_twist_alone_unless_all_support_lies_on_a_line_with_the_centre_of_rotation():
    """Two twists move the points of a line alike exactly if both centres of rotation lie on it."""
    triangle = PointFootprint(((-1.0, 0.0), (1.0, 0.0), (0.3, 0.7)), (1.0, 1.0, 1.0))
    line = PointFootprint(((-1.0, 0.0), (1.0, 0.0), (0.3, 0.0)), (1.0, 1.0, 1.0))
    about_its_own, beside = (0.0, -0.5, 1.0), (0.4, -0.5, 1.0)
    assert [flat_directions(triangle, twist) for twist in (about_its_own, beside)] == [1, 1]
    assert [flat_directions(line, twist) for twist in (about_its_own, beside)] == [2, 1]
    assert {flat_directions(PATCHES["patch"], twist) for twist in np.random.default_rng(4).normal(size=(20, 3))} == {1}


def random_ellipsoid(rng):
    """Lower triangular C, A = (C C^T)^-1, with spread axes and all couplings; a contact and a rod."""
    factor = np.diag(rng.uniform(0.5, 3.0, 3)) + np.tril(rng.normal(size=(3, 3)), -1)
    return factor, rng.normal(size=2), rng.normal(size=2)


def power_of(factor):
    matrix = np.linalg.inv(factor @ factor.T)
    return lambda twist: math.sqrt(twist @ matrix @ twist)


def test_a_minimiser_finds_the_ellipsoids_closed_sticking_twist():
    rng = np.random.default_rng(1)
    for _ in range(30):
        factor, place, rod = random_ellipsoid(rng)
        lower, power = factor[np.tril_indices(3)], power_of(factor)
        twist = STICKING(*lower, *place, *rod).ravel()
        assert np.allclose((twist[0] - twist[2] * place[1], twist[1] + twist[2] * place[0]), rod, atol=1e-12)
        found = minimize_scalar(lambda spin: power(np.array(FAMILY(*place, *rod, spin))), tol=1e-12)  # noqa: B023
        assert abs(found.x - twist[2]) < 1e-6 * max(1.0, abs(twist[2]))
        assert abs(found.fun / power(twist) - 1.0) < 1e-13


def test_a_minimiser_finds_the_ellipsoids_closed_sliding_twist():
    rng = np.random.default_rng(2)
    for _ in range(15):
        factor, place, rod = random_ellipsoid(rng)
        nu, smu = rng.uniform(0, 7), rng.uniform(-0.5, 0.5)
        wrench = np.array(EDGE_WRENCH(*place, nu, smu))
        twist = SLIDING(*factor[np.tril_indices(3)], *place, *rod, nu, smu).ravel()
        twist *= np.sign(wrench @ twist)
        along, power = np.linalg.svd(wrench[None])[2][1:], power_of(factor)
        base = wrench * (wrench @ twist) / (wrench @ wrench)
        found = minimize(lambda z: power(base + z @ along), (0.3, -0.2), tol=1e-12)  # noqa: B023
        assert abs(found.fun / power(twist) - 1.0) < 1e-11
        assert np.allclose(base + found.x @ along, twist, rtol=0, atol=1e-4 * np.abs(twist).max())


def test_on_an_ellipsoid_exactly_one_of_sticking_and_the_two_slides_is_consistent():
    """Complementarity: sticking inside the friction cone, or slip the way the force on the cone's edge points."""
    rng, counts, mu = np.random.default_rng(3), {"stick": 0, "left": 0, "right": 0}, 0.4
    for _ in range(400):
        factor, place, rod = random_ellipsoid(rng)
        nu = rng.uniform(0, 7)
        normal, tangent = np.array((math.cos(nu), math.sin(nu))), np.array((-math.sin(nu), math.cos(nu)))
        mobility = MOBILITY(*factor[np.tril_indices(3)], *place)
        edges = {sign: mobility @ (-normal + sign * mu * tangent) for sign in (1, -1)}
        if normal @ rod >= 0.0 or max(normal @ edge for edge in edges.values()) >= 0.0:
            continue
        force = np.linalg.solve(mobility, rod)
        held = {"stick": force @ normal < 0.0 and abs(force @ tangent) <= -mu * (force @ normal)}
        for name, sign in (("left", 1), ("right", -1)):
            slip = tangent @ (rod - (normal @ rod) / (normal @ edges[sign]) * edges[sign])
            held[name] = slip * sign > 0.0
        assert sum(held.values()) == 1
        for name, holds in held.items():
            counts[name] += holds
    assert min(counts.values()) > 20
