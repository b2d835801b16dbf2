"""The first-order normal form of the cycle map: what isotropy broken a little can do to a rotation,
by symmetry alone.

Turning the surface by α turns the cycle map along: f(θ + α) of the turned surface is f(θ) + α. With
α = -θ the turn f(θ) - θ is a function G of the surface as the object sees it: of its offset turned
by -θ and its ellipticity turned by -2θ. Everything here follows from that (Golubitsky, Stewart &
Schaeffer 1988 for the method).
"""

from collections import Counter
from itertools import combinations_with_replacement

import sympy as sp

from theory.plane_rotation import rotation

THETA, OMEGA = sp.symbols("theta Omega", real=True)
MU_A, MU_B = sp.symbols("mu_a mu_b", positive=True)
M0, N0, PHI, ALPHA = sp.symbols("m_0 n_0 phi alpha", real=True)
# Components of the offset and of the ellipticity as the object sees them.
SEEN = sp.symbols("u_x u_y v_x v_y", real=True)


def offset_vector() -> sp.Matrix:
    """Return the centre of the limit ellipse in the surface's axes over its mean radius sqrt(mu_a
    mu_b): a vector.
    """
    return rotation(PHI) * sp.Matrix([M0, N0]) / sp.sqrt(MU_A * MU_B)


def shape_logarithm() -> sp.Matrix:
    """Return half the logarithm of the ellipse's matrix R(φ) diag(mu_a², mu_b²) R(φ)ᵀ, symmetric, 2
    x 2.

    Its trace is the logarithm of mu_a mu_b, and its traceless part the ellipticity: a tensor that
    turns twice as fast as a vector.
    """
    turn = rotation(PHI)
    return turn * sp.diag(sp.log(MU_A), sp.log(MU_B)) * turn.T


def ellipticity_vector() -> sp.Matrix:
    """Return the two components of the traceless part of `shape_logarithm`: log(mu_a/mu_b)/2 (cos
    2φ, sin 2φ).
    """
    shape = shape_logarithm()
    return sp.Matrix([(shape[0, 0] - shape[1, 1]) / 2, shape[0, 1]])


def generator() -> sp.Matrix:
    """Return d/dθ of (u_x, u_y, v_x, v_y), a matrix: the offset seen turns by -1, the ellipticity
    seen by -2.
    """
    backward = sp.Matrix([[0, 1], [-1, 0]])
    return sp.diag(backward, 2 * backward)


def harmonics(offset_degree: int, ellipticity_degree: int) -> Counter[int]:
    """Return which harmonics of θ a term of these degrees can have, each with its number of free
    real coefficients.

    The derivative d/dθ acts on the polynomials of these degrees in (u, v) as a matrix; its
    eigenvalues are ±i times the harmonics. A harmonic above 0 has two real coefficients, its cosine
    and its sine.
    """
    found: Counter[int] = Counter()
    for eigenvalue, multiplicity in (
        derivative_matrix(offset_degree, ellipticity_degree).eigenvals().items()
    ):
        found[int(abs(sp.im(eigenvalue)))] += multiplicity
    return found


def derivative_matrix(offset_degree: int, ellipticity_degree: int) -> sp.Matrix:
    """Return the matrix of d/dθ on the monomials of these degrees in the offset and the ellipticity
    seen.
    """
    monomials = [
        sp.prod((*of_u, *of_v))
        for of_u in combinations_with_replacement(SEEN[:2], offset_degree)
        for of_v in combinations_with_replacement(SEEN[2:], ellipticity_degree)
    ]
    velocity = generator() * sp.Matrix(SEEN)
    columns = []
    for monomial in monomials:
        change = sp.expand(
            sum(sp.diff(monomial, x) * v for x, v in zip(SEEN, velocity, strict=True))
        )
        columns.append([sp.Poly(change, *SEEN).coeff_monomial(one) for one in monomials])
    return sp.Matrix(columns).T


def response(order: int) -> sp.Matrix:
    """Return the first-order response to the offset (order 1) or to the ellipticity (order 2), from
    equivariance.

    R(θ), a row of two, is how the turn answers the two components in the surface's axes. Turning
    surface and object together must not change the turn: R(θ + α) T(α) = R(θ) with T the rotation
    by order·α. Differentiated at α = 0 this is R' = -order·R·J, J the quarter turn, and its
    solution from R(0) = (a, b) is returned.
    """
    a, b = sp.symbols("a b", real=True)
    quarter = rotation(sp.pi / 2)
    flow = (-order * THETA * quarter).exp()
    return (sp.Matrix([[a, b]]) * flow).applyfunc(lambda entry: sp.simplify(entry.rewrite(sp.cos)))


def first_order_turn() -> sp.Expr:
    """Return Ω + X cos(θ - ψ - δ₁) + Y cos(2(θ - φ) - δ₂): X = offset·A₁, Y = ellipticity·A₂,
    offset along ψ.
    """
    x, y = sp.symbols("X Y", nonnegative=True)
    psi, delta_1, delta_2 = sp.symbols("psi delta_1 delta_2", real=True)
    return OMEGA + x * sp.cos(THETA - psi - delta_1) + y * sp.cos(2 * (THETA - PHI) - delta_2)


def offset_fixed_points() -> tuple[tuple[sp.Expr, sp.Expr], tuple[sp.Expr, sp.Expr]]:
    """Return (θ - ψ - δ₁, multiplier) of the stable and the unstable fixed point without
    ellipticity, |Ω| ≤ X.

    The stable one lies where the turn falls through zero: at the arc cosine of -Ω/X, with
    multiplier 1 - √(X² - Ω²). It attracts for X² - Ω² < 4, and the two meet at |Ω| = X: a
    saddle-node.
    """
    x = sp.Symbol("X", positive=True)
    angle, root = sp.acos(-OMEGA / x), sp.sqrt(x**2 - OMEGA**2)
    return (angle, 1 - root), (-angle, 1 + root)


def lock_in_curve() -> tuple[sp.Expr, sp.Expr]:
    """Return (X, Y) on the saddle-node curve of the two-harmonic map, by the angle s = θ - ψ - δ₁
    at which it happens.

    The turn Ω + X cos s + Y cos(2s - χ), χ = 2(φ - ψ - δ₁) + δ₂, vanishes with its derivative: two
    linear equations for (X, Y) at each s. The curve bounds lock-in where X, Y ≥ 0 and the extremum
    is the least (Ω > 0) or greatest.
    """
    s, chi = sp.symbols("s chi", real=True)
    x, y = sp.symbols("X Y", real=True)
    turn = OMEGA + x * sp.cos(s) + y * sp.cos(2 * s - chi)
    found = sp.solve([turn, sp.diff(turn, s)], [x, y], dict=True)[0]
    return sp.simplify(found[x]), sp.simplify(found[y])


def dissipation(velocity: sp.Matrix) -> sp.Expr:
    """Return the dissipation h(v) = √(mu_a² v_m² + mu_b² v_n²) + m0 v_m + n0 v_n, v in the
    surface's axes.

    It is homogeneous of degree one in (mu_a, mu_b, m0, n0). A quasi-static motion minimises a sum
    of such terms under conditions on the velocity, or balances its gradients: the common factor
    drops out.
    """
    along, across = rotation(-PHI) * velocity
    return sp.sqrt(MU_A**2 * along**2 + MU_B**2 * across**2) + M0 * along + N0 * across


def ellipticity_ratios() -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """Return other measures over those used here, in the ellipticity v, mu_a/mu_b = exp(2v).

    (mu_a - mu_b)/(mu_a + mu_b) over v, and the offset's factor with the mean and with the root mean
    square of mu_a, mu_b in place of sqrt(mu_a mu_b). All are 1 + O(v²): the choice changes the turn
    at third order only.
    """
    v = sp.Symbol("v")
    return sp.tanh(v) / v, 1 / sp.cosh(v), 1 / sp.sqrt(sp.cosh(2 * v))
