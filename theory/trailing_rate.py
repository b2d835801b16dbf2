"""Near the trailing direction every footprint drags as an ellipsoid: its fixed point and rate,
exact for any pressure.

A patch of points x (from the centre of pressure) with the traction law h(v) = √(vᵀQv) + m·v in the
world's frame, Q positive and symmetric, m the offset: friction ellipses of any axes, offset and
angle. The ring, at the lever ρ, moves by the unit vector u. Q, m and u are fixed in the world; ρ
and x turn with the object.

The object goes on without turning where the friction force f = Qu/s + m, s = √(uᵀQu), has no torque
about the ring: where ρ lies along ±f. There d(dθ/ds)/dθ = -(f·ρ) s³/(det Q ⟨(u·(x - ρ))²⟩): stable
where the ring leads.
"""

import sympy as sp

from theory.plane_rotation import rotation

FIRST, MIXED, SECOND = sp.symbols("q_1 q_12 q_2", real=True)
OFFSET_1, OFFSET_2 = sp.symbols("m_1 m_2", real=True)
TOWARDS = sp.Symbol("beta", real=True)
SPIN, TURN = sp.symbols("omega theta", real=True)
POINT_1, POINT_2 = sp.symbols("x_1 x_2", real=True)
RING_1, RING_2 = sp.symbols("rho_1 rho_2", real=True)


def law_matrix() -> sp.Matrix:
    """Return Q: for axes μa, μb at the angle φ it is R(φ) diag(μa², μb²) R(φ)ᵀ."""
    return sp.Matrix([[FIRST, MIXED], [MIXED, SECOND]])


def direction() -> sp.Matrix:
    """Return u, the direction in which the ring moves."""
    return sp.Matrix([sp.cos(TOWARDS), sp.sin(TOWARDS)])


def sliding_speed() -> sp.Expr:
    """Return s = √(uᵀQu), the friction coefficient of sliding along u without the offset."""
    return sp.sqrt((direction().T * law_matrix() * direction())[0])


def friction_force() -> sp.Matrix:
    """Return f = Qu/s + m, the force per unit load that keeps the object translating along u."""
    return law_matrix() * direction() / sliding_speed() + sp.Matrix([OFFSET_1, OFFSET_2])


def turned(x: sp.Expr, y: sp.Expr) -> sp.Matrix:
    """Return a vector of the object after it has turned by `TURN`."""
    return rotation(TURN) * sp.Matrix([x, y])


def dissipation_of_a_point() -> sp.Expr:
    """Return h at the point x of the object, turned by `TURN`, while it spins by `SPIN` about its
    moving ring.
    """
    lever = turned(POINT_1 - RING_1, POINT_2 - RING_2)
    velocity = direction() + SPIN * sp.Matrix([-lever[1], lever[0]])
    quadratic = (velocity.T * law_matrix() * velocity)[0]
    return sp.sqrt(quadratic) + OFFSET_1 * velocity[0] + OFFSET_2 * velocity[1]


def ring_torque() -> sp.Expr:
    """Return dD/dω at ω = 0 of a patch centred at the origin: -f·(z × ρ),
    zero where ρ is along f."""
    lever = turned(RING_1, RING_2)
    force = friction_force()
    return force[0] * lever[1] - force[1] * lever[0]


def spin_stiffness(second_moment: sp.Expr) -> sp.Expr:
    """Return d²D/dω² at ω = 0, turn zero: det Q ((u·ρ)² + ⟨(u·x)²⟩)/s³, given the pressure's second
    moment along u.
    """
    along = direction()[0] * RING_1 + direction()[1] * RING_2
    return law_matrix().det() * (along**2 + second_moment) / sliding_speed() ** 3


def trailing_rate(lever: sp.Expr, second_moment: sp.Expr) -> sp.Expr:
    """Return d(dθ/ds)/dθ (1/m) where the ring leads: -|f| r s³/(det Q ((u·ρ)² + ⟨(u·x)²⟩)), ρ = r
    f/|f|.

    Over a leg of length ℓ the multiplier is exp(rate·ℓ). Behind the object (ρ = -r f/|f|) the rate
    has the other sign.
    """
    force = friction_force()
    size = sp.sqrt(force.dot(force))
    at = {RING_1: lever * force[0] / size, RING_2: lever * force[1] / size}
    return -size * lever / spin_stiffness(second_moment).subs(at)
