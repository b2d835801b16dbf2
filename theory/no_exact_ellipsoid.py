"""No footprint of finite extent has an exactly ellipsoidal limit surface under isotropic point
friction.

Around translation the dissipation of a footprint and of an ellipsoid agree up to the second order
in the spin, with c² the pressure's second moment; at the fourth order, averaged over the directions
of motion, the footprint has +⟨ρ⁴⟩/64 and the ellipsoid -c⁴/8, ρ the distance from the centre of
pressure. The one is positive, the other negative.
"""

import sympy as sp

SPIN, DISTANCE, AZIMUTH = sp.symbols("omega rho alpha", real=True)
SPIN_RADIUS = sp.Symbol("c", positive=True)


def speed_of_a_point() -> sp.Expr:
    """Return |u + ω z × x| of a point x = ρ(cos α, sin α), u = (1, 0)."""
    x, y = DISTANCE * sp.cos(AZIMUTH), DISTANCE * sp.sin(AZIMUTH)
    return sp.sqrt((1 - SPIN * y) ** 2 + (SPIN * x) ** 2)


def mean_over_directions(order: int) -> sp.Expr:
    """Return the coefficient of ω^order in the speed, averaged over the angle between lever and
    motion.
    """
    polar = sp.series(speed_of_a_point(), SPIN, 0, order + 1).removeO().coeff(SPIN, order)
    return sp.integrate(sp.expand(polar), (AZIMUTH, 0, 2 * sp.pi)) / (2 * sp.pi)


def ellipsoid_coefficient(order: int) -> sp.Expr:
    """Return the coefficient of ω^order in √(1 + c²ω²)."""
    return (
        sp.series(sp.sqrt(1 + SPIN_RADIUS**2 * SPIN**2), SPIN, 0, order + 1)
        .removeO()
        .coeff(SPIN, order)
    )
