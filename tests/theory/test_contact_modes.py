"""Sticking and sliding twists: the conditions hold on the code's solutions, the ellipsoid's forms on minimisers'."""

import math
from itertools import pairwise

import numpy as np
import pytest
import sympy as sp
from residuals import residuals, vanishes
from scipy.optimize import minimize, minimize_scalar

from cyclemap.mechanics.contact_curve import Contact
from cyclemap.mechanics.contact_solver import ContactSolver
from cyclemap.mechanics.event_integration import SLACK_SHARE
from cyclemap.mechanics.footprint import PatchFootprint, PointFootprint, grid_footprint
from cyclemap.mechanics.friction import EllipseFriction
from cyclemap.mechanics.limit_surface import LimitSurface, normalised
from cyclemap.mechanics.material import load_material
from cyclemap.mechanics.outline import Polygon
from cyclemap.mechanics.protocol import Pose, SidePush
from cyclemap.mechanics.quasi_static import QuasiStaticModel
from cyclemap.mechanics.runge_kutta import SLOPE
from cyclemap.mechanics.slider import Slider
from theory import contact_modes as theory

RESIDUALS = residuals(theory)
SQUARE = Slider.mit("rect1").outline
PATCHES = {"patch": normalised(PatchFootprint(SQUARE)), "grid": normalised(grid_footprint(SQUARE, 8))}
OUTLINE = Polygon(((-1, -1), (1, -1), (1, 1), (-1, 1))).scaled(math.sqrt(0.5))
every_patch = pytest.mark.parametrize("footprint", PATCHES.values(), ids=PATCHES)

_FACTOR = [theory.C[i, j] for i in range(3) for j in range(i + 1)]
_PLACE = (theory.X, theory.Y)
_ELLIPSOID = (*_FACTOR, *_PLACE, theory.U_X, theory.U_Y)
STICKING = sp.lambdify(_ELLIPSOID, theory.sticking_twist(), cse=True)
SLIDING = sp.lambdify((*_ELLIPSOID, theory.NU, theory.SMU), theory.sliding_twist(), cse=True)
MOBILITY = sp.lambdify((*_FACTOR, *_PLACE), theory.mobility(), cse=True)
EDGE_WRENCH = sp.lambdify((*_PLACE, theory.NU, theory.SMU), list(theory.sliding_wrench()))
FAMILY = sp.lambdify((*_PLACE, theory.U_X, theory.U_Y, theory.OMEGA), list(theory.sticking_family(theory.OMEGA)))


@pytest.mark.parametrize("name", RESIDUALS)
def test_every_residual_of_the_contact_modes_is_exactly_zero(name):
    assert vanishes(RESIDUALS[name]())


def test_there_are_fifteen_residuals():
    assert len(RESIDUALS) == 15


class Case:
    """A random contact on the square's sides, a random law, a rod that approaches."""

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
        self.theta, side = rng.uniform(-3, 3), int(rng.integers(4))
        start, end = OUTLINE.array[side], OUTLINE.array[(side + 1) % 4]
        place, self.nu = start + rng.uniform(0.05, 0.95) * (end - start), side * math.pi / 2 - math.pi / 2
        self.contact = Contact(*place.tolist(), self.nu)
        self.away = rng.uniform(-1.2, 1.2)
        self.smu = rng.choice((-1, 1)) * rng.uniform(0.05, 0.4)
        self.surface, self.solver = LimitSurface(footprint, self.law), ContactSolver(footprint, self.law)

    @property
    def rod(self):
        """Unit velocity of the rod in the object's frame."""
        return math.cos(self.nu + math.pi + self.away), math.sin(self.nu + math.pi + self.away)

    def sticking(self, rod):
        """Return the code's sticking solution and its twist for a rod velocity of any length."""
        speed = math.hypot(*rod)
        direction = self.theta + math.atan2(rod[1], rod[0])
        found = self.solver.stick(self.theta, direction, self.contact, 0.0)
        return found, self.twist(rod, found.omega * speed)

    def twist(self, rod, omega):
        return np.array(FAMILY(self.contact.x, self.contact.y, *rod, omega))

    def dissipation(self, spin):
        """Return the code's dissipation for the rod's velocity and a spin."""
        return float(self.surface.dissipation(self.twist(self.rod, spin), self.theta))

    def sliding(self):
        """Return the code's sliding solution for a unit approach, its twist and its contact velocity."""
        found = self.solver.slide(self.theta, self.contact, self.smu, (0.0, 0.0))
        normal = np.array((math.cos(self.nu), math.sin(self.nu)))
        moved = -normal + found.tau * np.array((-normal[1], normal[0]))
        return found, self.twist(moved, found.omega), moved


@every_patch
def test_the_codes_sticking_spin_minimises_the_dissipation_and_asks_for_a_force_at_the_contact_alone(footprint):
    for seed in range(20):
        case = Case(footprint, seed)
        found, twist = case.sticking(case.rod)
        fx, fy, torque = case.surface.wrench(twist, case.theta)
        assert abs(torque - (case.contact.x * fy - case.contact.y * fx)) < 1e-11
        least = case.surface.dissipation(twist, case.theta)
        assert min(case.dissipation(found.omega + away) for away in (-1.0, -1e-3, 1e-3, 1.0)) > least
        searched = minimize_scalar(case.dissipation, bracket=(found.omega - 0.7, found.omega + 0.4), tol=1e-10)
        assert abs(searched.x - found.omega) < 1e-5
        assert abs(searched.fun - least) < 1e-13


@every_patch
def test_the_codes_sliding_twist_minimises_the_dissipation_among_those_of_the_same_power_of_the_cones_edge(footprint):
    rng, compared = np.random.default_rng(0), 0
    for seed in range(20):
        case = Case(footprint, seed)
        found, twist, _ = case.sliding()
        wrench = np.array(EDGE_WRENCH(case.contact.x, case.contact.y, case.nu, case.smu))
        assert np.abs(case.surface.wrench(twist, case.theta) - found.normal_force * wrench).max() < 1e-11
        # The multiplier is D per power, by Euler's theorem.
        least = case.surface.dissipation(twist, case.theta)
        assert abs(found.normal_force * (wrench @ twist) - least) < 1e-11
        along = np.linalg.svd(wrench[None])[2][1:]
        others = twist + (rng.normal(size=(50, 2)) * rng.choice((0.01, 1.0), (50, 1))) @ along
        assert (case.surface.dissipation(others, case.theta) > least).all()
        compared += 1
    assert compared == 20


@every_patch
def test_on_the_edge_of_the_codes_motion_cone_sticking_and_sliding_are_one_motion(footprint):
    for seed in range(20):
        case = Case(footprint, seed)
        slide, slid, moved = case.sliding()
        stick, stuck = case.sticking(moved)
        assert np.abs(stuck - slid).max() < 1e-9 * max(1.0, np.abs(slid).max())
        assert abs(stick.tangential_force - case.smu * stick.normal_force) < 1e-10
        assert abs(stick.normal_force - slide.normal_force) < 1e-10


def test_the_codes_rod_slips_the_way_in_which_the_force_that_sticking_needs_leaves_its_cone():
    slipped = 0
    for seed in range(60):
        case = Case(PATCHES["patch"], seed)
        stick, _ = case.sticking(case.rod)
        case.smu = math.copysign(case.smu, stick.tangential_force)
        beyond = abs(stick.tangential_force) > abs(case.smu) * stick.normal_force
        _, _, moved = case.sliding()
        tangent = np.array((-math.sin(case.nu), math.cos(case.nu)))
        slip = tangent @ (case.rod - math.cos(case.away) * moved)
        assert (slip * case.smu > 0.0) == beyond
        slipped += beyond
    assert 15 < slipped < 55


def test_the_codes_contact_force_is_the_gradient_of_the_least_dissipation_by_the_rods_velocity():
    for seed in range(10):
        case = Case(PATCHES["patch"], seed)
        moved = case.rod + 1e-5 * np.array(((1, 0), (-1, 0), (0, 1), (0, -1)))
        least = np.array([case.surface.dissipation(case.sticking(rod)[1], case.theta) for rod in moved])
        force = case.surface.wrench(case.sticking(case.rod)[1], case.theta)[:2]
        assert np.allclose((least[::2] - least[1::2]) / 2e-5, force, atol=1e-8)


def test_spin_and_slip_are_continuous_where_a_push_goes_from_sticking_to_sliding():
    """To a few times the margin within which the switch is landed on."""
    switches = 0
    for theta in np.linspace(0.0, 6.0, 7):
        model = QuasiStaticModel(Slider.mit("rect1"), load_material("plywood").friction, accuracy=1e-9)
        phases = model.push(Pose(theta=theta), SidePush()).run.phases
        landed = SLACK_SHARE * math.sqrt(model.step_tolerance)
        for before, after in pairwise(phases):
            if "stick" not in (before.motion.mode, after.motion.mode):
                continue
            last, first = before.phase.steps[-1].stages[-1][SLOPE], after.phase.steps[0].stages[0][SLOPE]
            assert np.abs(last - first).max() < 20.0 * landed < 1e-5
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
