"""Sticking and sliding twists of an ellipsoid: their closed forms are what minimisers find, and one
of them holds.
"""

import math

import numpy as np
import sympy as sp
from scipy.optimize import minimize, minimize_scalar

from cyclemap.mechanics import EllipseFriction, LimitSurface, PatchFootprint, PointFootprint, Slider
from theory import contact_modes as theory

_FACTOR = [theory.C[i, j] for i in range(3) for j in range(i + 1)]
_PLACE = (theory.X, theory.Y)
_ELLIPSOID = (*_FACTOR, *_PLACE, theory.U_X, theory.U_Y)
STICKING = sp.lambdify(_ELLIPSOID, theory.sticking_twist(), cse=True)
SLIDING = sp.lambdify((*_ELLIPSOID, theory.NU, theory.SMU), theory.sliding_twist(), cse=True)
MOBILITY = sp.lambdify((*_FACTOR, *_PLACE), theory.mobility(), cse=True)
EDGE_WRENCH = sp.lambdify((*_PLACE, theory.NU, theory.SMU), list(theory.sliding_wrench()))
FAMILY = sp.lambdify(
    (*_PLACE, theory.U_X, theory.U_Y, theory.OMEGA), list(theory.sticking_family(theory.OMEGA))
)


def flat_directions(footprint, twist):
    """Number of directions of twist along which the code's dissipation has no curvature."""
    hessian = LimitSurface(footprint, EllipseFriction(0.3, 0.2, phi=0.4)).hessian(twist)
    sizes = np.linalg.eigvalsh(hessian)
    return int((np.abs(sizes) < 1e-10 * sizes.max()).sum())


def test_dissipation_is_flat_along_the_twist_alone_unless_all_support_is_in_line_with_its_centre():
    """Two twists move the points of a line alike exactly if both centres of rotation lie on it."""
    square = PatchFootprint(Slider.mit("rect1").outline)
    triangle = PointFootprint(((-1.0, 0.0), (1.0, 0.0), (0.3, 0.7)), (1.0, 1.0, 1.0))
    line = PointFootprint(((-1.0, 0.0), (1.0, 0.0), (0.3, 0.0)), (1.0, 1.0, 1.0))
    about_its_own, beside = (0.0, -0.5, 1.0), (0.4, -0.5, 1.0)
    assert [flat_directions(triangle, twist) for twist in (about_its_own, beside)] == [1, 1]
    assert [flat_directions(line, twist) for twist in (about_its_own, beside)] == [2, 1]
    assert {
        flat_directions(square, twist) for twist in np.random.default_rng(4).normal(size=(20, 3))
    } == {1}


def random_ellipsoid(rng):
    """Lower triangular C, A = (C C^T)^-1, with spread axes and all couplings;
    a contact and a rod."""
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
        assert np.allclose(
            (twist[0] - twist[2] * place[1], twist[1] + twist[2] * place[0]), rod, atol=1e-12
        )
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
    """Complementarity: sticking inside the friction cone, or slip the way the force on the cone's
    edge points.
    """
    rng, counts, mu = np.random.default_rng(3), {"stick": 0, "left": 0, "right": 0}, 0.4
    for _ in range(400):
        factor, place, rod = random_ellipsoid(rng)
        nu = rng.uniform(0, 7)
        normal = np.array((math.cos(nu), math.sin(nu)))
        tangent = np.array((-normal[1], normal[0]))
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
