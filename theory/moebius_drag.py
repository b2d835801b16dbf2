"""The drag of an ellipsoidal limit surface: one straight leg is a Möbius map of the circle.

The object's limit surface is the ellipsoid D² = μ²N²(|v|² + c²ω²), v and ω the twist of its centre
(Goyal, Ruina & Papadopoulos 1991; Lynch & Mason 1996). The rod moves the ring, at distance r from
the centre, by the unit vector u per unit of path. `HEADING` is the angle of the lever (from the
centre to the ring) seen from u: 0 where the ring leads and the object trails, π where the object
goes ahead. Lengths in m, angles in rad.
"""

import sympy as sp

LEVER, SPIN_RADIUS, LENGTH = sp.symbols("r c ell", positive=True)
HEADING = sp.Symbol("psi", real=True)
SPIN = sp.Symbol("omega", real=True)
POINT = sp.Symbol("z", nonzero=True)


def squared_dissipation() -> sp.Expr:
    """Return (D/μN)² of a spin ω (rad/m) when the ring moves by u = (1, 0), which is v = u - ω z ×
    lever.
    """
    velocity_x = 1 + SPIN * LEVER * sp.sin(HEADING)
    velocity_y = -SPIN * LEVER * sp.cos(HEADING)
    return velocity_x**2 + velocity_y**2 + SPIN_RADIUS**2 * SPIN**2


def spin_of_least_dissipation() -> sp.Expr:
    """Return the spin dψ/ds (rad/m) at which dD²/dω vanishes: the only one, since D² is a parabola
    in ω.
    """
    (found,) = sp.solve(sp.diff(squared_dissipation(), SPIN), SPIN)
    return sp.simplify(found)


def rate() -> sp.Expr:
    """Return κ = r/(r² + c²), 1/m: how fast a small heading dies away, dψ/ds = -κ sin ψ."""
    return LEVER / (LEVER**2 + SPIN_RADIUS**2)


def half_angle_tangent() -> sp.Expr:
    """Return tan(ψ/2) after a leg of length ℓ that began at heading ψ: tan(ψ/2) exp(-κℓ)."""
    return sp.tan(HEADING / 2) * sp.exp(-rate() * LENGTH)


def heading_after() -> sp.Expr:
    """Return the heading (rad) after a leg of length ℓ that began at a heading ψ in (-π, π)."""
    return 2 * sp.atan(half_angle_tangent())


def strength() -> sp.Expr:
    """Return a(ℓ) = tanh(κℓ/2), between 0 (no leg) and 1 (a leg without end)."""
    return sp.tanh(rate() * LENGTH / 2)


def leg_of_the_lever(a: sp.Expr) -> sp.Expr:
    """Return where a leg of strength a takes z = e^{iψ}, ψ the heading of the lever: (z + a)/(1 + a
    z).
    """
    return (POINT + a) / (1 + a * POINT)


def leg_of_the_trail(a: sp.Expr) -> sp.Expr:
    """Return where a leg takes z = e^{iχ}, χ = ψ + π the angle from the ring to the centre: (z -
    a)/(1 - a z).

    This is the textbook form of the Möbius map: z = 1, where the object goes ahead, is repelling.
    """
    return -leg_of_the_lever(a).subs(POINT, -POINT)


def riccati_residual() -> sp.Expr:
    """Return dz/dℓ - κ(1 - z²)/2 along `leg_of_the_lever`: zero, since dψ/ds = -κ sin ψ is that
    equation.
    """
    along = leg_of_the_lever(strength())
    return sp.simplify(sp.diff(along, LENGTH) - rate() * (1 - along**2) / 2)


def strength_of_two(first: sp.Expr, second: sp.Expr) -> sp.Expr:
    """Return the strength of two legs in the same direction, one after the other: the addition
    theorem of tanh.
    """
    return (first + second) / (1 + first * second)


def turned_leg(a: sp.Expr, direction: sp.Expr) -> sp.Expr:
    """Return where a leg in a world direction (rad) takes z = e^{iθ}, θ the lever's angle in the
    world.
    """
    phase = sp.exp(sp.I * direction)
    return sp.together(phase * leg_of_the_lever(a).subs(POINT, POINT / phase))


def matrix_of_leg(a: sp.Expr, direction: sp.Expr) -> sp.Matrix:
    """Return the matrix ((1, a e^{iβ}), (a e^{-iβ}, 1)) of `turned_leg`: paths of many legs
    multiply matrices.
    """
    return sp.Matrix([[1, a * sp.exp(sp.I * direction)], [a * sp.exp(-sp.I * direction), 1]])


def strength_of_path(matrix: sp.Matrix) -> sp.Expr:
    """Return |m₁₂/m₁₁|, the strength of a whole path of legs: it is a rotation after one leg."""
    return sp.Abs(matrix[0, 1] / matrix[0, 0])
