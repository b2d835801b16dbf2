"""Turning the surface by α turns the cycle map along: f_{φ+α}(θ + α) = f_φ(θ) + α.

Friction knows the object's orientation θ and the material's angle φ only by their difference; the
push is laid down in the object's frame, the target is a point, and friction is homogeneous. So a
cycle on the turned surface is the turned cycle. Way-points of the reset, where there are any, must
be turned about the target as well.
"""

import sympy as sp

from theory.plane_rotation import rotation

MU_A, MU_B = sp.symbols("mu_a mu_b", positive=True)
M0, N0, PHI = sp.symbols("m_0 n_0 phi", real=True)
THETA, TURN = sp.symbols("theta alpha", real=True)
VELOCITY_X, VELOCITY_Y, SPIN = sp.symbols("v_x v_y omega", real=True)
POINT_X, POINT_Y = sp.symbols("x y", real=True)


def support_function(velocity: sp.Matrix, phi: sp.Expr) -> sp.Expr:
    """Return h of a velocity in the world, the friction ellipse's axes turned by φ (Ma & Rodriguez
    2018, Eq. 2).
    """
    along, across = rotation(-phi) * velocity
    return sp.sqrt((MU_A * along) ** 2 + (MU_B * across) ** 2) + M0 * along + N0 * across


def dissipation_of_a_point(theta: sp.Expr, phi: sp.Expr) -> sp.Expr:
    """Return h at the point (x, y) of an object at orientation θ whose twist, in its own frame, is
    (v_x, v_y, ω).

    The patch's D is the mean of this over its pressure, which is fixed in the object's frame.
    """
    velocity = sp.Matrix([VELOCITY_X - SPIN * POINT_Y, VELOCITY_Y + SPIN * POINT_X])
    return support_function(rotation(theta) * velocity, phi)


def spelled_out(value: sp.Expr) -> sp.Expr:
    """Return a trigonometric polynomial as a sum of exponentials, in which equal things cancel."""
    return sp.expand(value.rewrite(sp.exp))


def turning_residual() -> sp.Matrix:
    """Return the velocity in the material's axes at (θ + α, φ + α) less that at (θ, φ), the
    object's own kept.

    It is zero, and h is a function of that velocity alone: object and surface turned together feel
    the same friction.
    """
    velocity = sp.Matrix([VELOCITY_X, VELOCITY_Y])
    there = rotation(-PHI - TURN) * rotation(THETA + TURN) * velocity
    return (there - rotation(-PHI) * rotation(THETA) * velocity).applyfunc(spelled_out)


def leg_in_object_frame(way_point: sp.Matrix, ring: sp.Matrix, theta: sp.Expr) -> sp.Matrix:
    """Return a leg from the ring's place to a way-point (world frame, from the target) as the
    object sees it.
    """
    return rotation(-theta) * (way_point - ring)


def leg_residual() -> sp.Matrix:
    """Return the leg after everything is turned by α, less the leg before, both seen by the object:
    zero.
    """
    px, py, rx, ry = sp.symbols("p_x p_y r_x r_y", real=True)
    point, ring, turn = sp.Matrix([px, py]), sp.Matrix([rx, ry]), rotation(TURN)
    there = leg_in_object_frame(turn * point, turn * ring, THETA + TURN)
    return (there - leg_in_object_frame(point, ring, THETA)).applyfunc(spelled_out)


def turned_iterate(count: int) -> sp.Expr:
    """Return the n-th iterate, at θ + α, of g(θ) = f(θ - α) + α, for an unknown f: it is fⁿ(θ) + α.

    So g has the rotation number of f, its fixed points lie α further, and the multipliers are the
    same.
    """
    f, angle = sp.Function("f"), THETA + TURN
    for _ in range(count):
        angle = f(angle - TURN) + TURN
    return angle


def infinitesimal_identity() -> sp.Expr:
    """Return ∂f/∂θ + ∂f/∂φ - 1: the derivative by α, at α = 0, of f(θ + α, φ + α) - f(θ, φ) - α,
    hence zero.
    """
    f = sp.Function("f")
    conjugacy = f(THETA + TURN, PHI + TURN) - f(THETA, PHI) - TURN
    return sp.simplify(sp.diff(conjugacy, TURN).subs(TURN, 0).doit())
