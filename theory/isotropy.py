"""Isotropic friction makes the cycle map a rigid rotation, f(θ) = θ + Ω, whatever the object,
footprint and push.

The dissipation does not see the orientation, so the push, laid down in the object's frame, turns
the object by the same angle and leaves the ring at the same place of that frame; so does the target
lie, and so goes the straight leg back. Way-points of the reset, fixed in the world, break it.
"""

import sympy as sp

from theory.plane_rotation import rotation
from theory.turned_surface import (
    M0,
    MU_A,
    MU_B,
    N0,
    PHI,
    POINT_X,
    POINT_Y,
    SPIN,
    THETA,
    VELOCITY_X,
    VELOCITY_Y,
    dissipation_of_a_point,
    leg_in_object_frame,
    spelled_out,
)

MU = sp.Symbol("mu", positive=True)
PUSH_TURN = sp.Symbol("Delta", real=True)
RING_X, RING_Y = sp.symbols("d_x d_y", real=True)
LEVER_X, LEVER_Y = sp.symbols("h_x h_y", real=True)
RATE = sp.Symbol("kappa", positive=True)


def squared_isotropic_dissipation() -> sp.Expr:
    """Return h² of a point when μa = μb = μ and there is no offset: orientation and φ drop out."""
    law = {MU_A: MU, MU_B: MU, M0: 0, N0: 0}
    return spelled_out(dissipation_of_a_point(THETA, PHI).subs(law) ** 2)


def wrench_times_dissipation() -> sp.Matrix:
    """Return h times the wrench (f_x, f_y, torque) = grad h of a point: half the gradient of h²."""
    squared = squared_isotropic_dissipation()
    return sp.Matrix(
        [sp.expand(sp.diff(squared, one) / 2) for one in (VELOCITY_X, VELOCITY_Y, SPIN)]
    )


def turning_residual() -> sp.Matrix:
    """Return (h², h·wrench) of a turned point at a turned twist less the turned ones: zero.

    D(RV) = D(V); the force turns along and the torque stays.
    """
    here = wrench_times_dissipation()
    velocity = rotation(THETA) * sp.Matrix([VELOCITY_X, VELOCITY_Y])
    place = rotation(THETA) * sp.Matrix([POINT_X, POINT_Y])
    new = {VELOCITY_X: velocity[0], VELOCITY_Y: velocity[1], POINT_X: place[0], POINT_Y: place[1]}
    force = rotation(THETA) * sp.Matrix(here[:2])
    there = sp.Matrix([squared_isotropic_dissipation(), *here]).subs(new, simultaneous=True)
    return (there - sp.Matrix([squared_isotropic_dissipation(), *force, here[2]])).applyfunc(
        spelled_out
    )


def leg_seen_by_the_object() -> sp.Matrix:
    """Return the leg back to the target as the object sees it after the push: -R(-Δ)d, without θ.

    The push began at θ with the ring on the target; it turned the object by Δ and took the ring to
    R(θ)d.
    """
    ring = rotation(THETA) * sp.Matrix([RING_X, RING_Y])
    leg = leg_in_object_frame(sp.zeros(2, 1), ring, THETA + PUSH_TURN)
    return leg.applyfunc(lambda part: sp.expand(spelled_out(part).rewrite(sp.cos)))


def turn_of_the_ellipsoids_leg() -> sp.Expr:
    """Return tan(ψ/2) at the end of the leg under an ellipsoid: the rotation Ω is Δ + ψ_end -
    ψ_start.

    tan(ψ/2) of the start is sin ψ/(1 + cos ψ), from cross and dot product of the leg with the lever
    (h_x, h_y), and a leg of length |d| multiplies it by exp(-κ|d|).
    """
    leg = leg_seen_by_the_object()
    length, lever = sp.sqrt(RING_X**2 + RING_Y**2), sp.sqrt(LEVER_X**2 + LEVER_Y**2)
    cross = leg[0] * LEVER_Y - leg[1] * LEVER_X
    dot = leg[0] * LEVER_X + leg[1] * LEVER_Y
    return cross / (length * lever + dot) * sp.exp(-RATE * length)
