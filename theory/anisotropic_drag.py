"""The drag of an ellipsoid whose axes are fixed in the world: fixed points, multiplier and elapsed
length; not Möbius.

D² = N²(p v_m² + q v_n² + C ω²), p = μa², q = μb², in the surface's axes. The ring, at distance r
from the centre, moves by u, at the angle `TOWARDS` from the m axis; `LEVER_ANGLE` is the lever's
angle ϑ from there. With (p u_m, q u_n) = w (cos γ, sin γ), dϑ/ds = -r w sin(ϑ - γ)/(C + r²(p sin²ϑ
+ q cos²ϑ)): so the ring leads along γ, not along u.
"""

import sympy as sp

P, Q, SPIN_TERM, LEVER, PULL = sp.symbols("p q C r w", positive=True)
TOWARDS, PULL_ANGLE, LEVER_ANGLE, SPIN = sp.symbols("beta gamma vartheta omega", real=True)
HEADING = sp.Symbol("psi", real=True)


def squared_dissipation() -> sp.Expr:
    """Return D²/N² of a spin ω (rad/m) while the ring moves by u."""
    along = sp.cos(TOWARDS) + SPIN * LEVER * sp.sin(LEVER_ANGLE)
    across = sp.sin(TOWARDS) - SPIN * LEVER * sp.cos(LEVER_ANGLE)
    return P * along**2 + Q * across**2 + SPIN_TERM * SPIN**2


def spin_of_least_dissipation() -> sp.Expr:
    """Return dϑ/ds (rad/m) as the zero of dD²/dω, in terms of u."""
    (found,) = sp.solve(sp.diff(squared_dissipation(), SPIN), SPIN)
    return found


def inertia() -> sp.Expr:
    """Return C + r²(p sin²ϑ + q cos²ϑ), what resists the turn."""
    return SPIN_TERM + LEVER**2 * (P * sp.sin(LEVER_ANGLE) ** 2 + Q * sp.cos(LEVER_ANGLE) ** 2)


def spin() -> sp.Expr:
    """Return dϑ/ds (rad/m) in terms of the pull w (cos γ, sin γ) = (p u_m, q u_n)."""
    return -LEVER * PULL * sp.sin(LEVER_ANGLE - PULL_ANGLE) / inertia()


def trailing_rate() -> sp.Expr:
    """Return d(dϑ/ds)/dϑ (1/m) where the ring leads, ϑ = γ, and its opposite at γ + π; multiplier
    exp(rate·ℓ).
    """
    return -LEVER * PULL / inertia().subs(LEVER_ANGLE, PULL_ANGLE)


def elapsed_length() -> sp.Expr:
    """Return s(ψ), m, up to a constant: the path on which the heading ψ = ϑ - γ, in (0, π), is
    reached.

    r w s = -(A - B cos 2γ) ln tan(ψ/2) + 2B (cos 2γ cos ψ - sin 2γ sin ψ), A = C + r²(p + q)/2, B =
    r²(p - q)/2.
    """
    a, b = SPIN_TERM + LEVER**2 * (P + Q) / 2, LEVER**2 * (P - Q) / 2
    cosine, sine = sp.cos(2 * PULL_ANGLE), sp.sin(2 * PULL_ANGLE)
    bent = 2 * b * (cosine * sp.cos(HEADING) - sine * sp.sin(HEADING))
    return (bent - (a - b * cosine) * sp.log(sp.tan(HEADING / 2))) / (LEVER * PULL)


def moebius_field_times_inertia(order: int) -> sp.Expr:
    """Return the coefficient of e^{i order ϑ} in (α + β cos ϑ + δ sin ϑ)(C + r²(p sin²ϑ + q
    cos²ϑ)).

    A flow on the circle maps by Möbius maps at all times only if its field is X = α + β cos ϑ + δ
    sin ϑ (in z = e^{iϑ}: Riccati's equation). Then X times the inertia would be -r w sin(ϑ - γ),
    which has no third harmonic; that of the product is r²(q - p)(β - iδ)/8. So β = δ = 0 unless p =
    q, and a constant α leaves no first harmonic at all.
    """
    z = sp.Symbol("z")
    constant, cosine, sine = sp.symbols("alpha beta delta", real=True)
    field = constant + cosine * (z + 1 / z) / 2 + sine * (z - 1 / z) / (2 * sp.I)
    double = (z**2 + z**-2) / 2
    resistance = SPIN_TERM + LEVER**2 * (P * (1 - double) + Q * (1 + double)) / 2
    return sp.factor(sp.expand(field * resistance).coeff(z, order))
