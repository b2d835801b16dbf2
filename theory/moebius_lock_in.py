"""A cycle whose reset ends with a leg in a fixed direction, on an ellipsoidal limit surface:
everything in closed form.

The push and the rest of the cycle turn the object by `TURNS` (turns a cycle), the leg has the
strength a of `theory.moebius_drag`: z -> e^{2πiΩ}(z - a)/(1 - a z), z = e^{iχ}, χ the angle from
the ring to the object's centre, seen from the leg's direction.
"""

import sympy as sp

from theory.moebius_drag import POINT

STRENGTH = sp.Symbol("a", positive=True)
TURNS = sp.Symbol("Omega", real=True)
ANGLE = sp.Symbol("chi", real=True)
EXCESS = sp.Symbol("eta", positive=True)


def cycle_map() -> sp.Expr:
    """Return the image of z = e^{iχ} under one cycle."""
    return sp.exp(2 * sp.pi * sp.I * TURNS) * (POINT - STRENGTH) / (1 - STRENGTH * POINT)


def cycle_matrix() -> sp.Matrix:
    """Return the cycle's matrix, scaled to determinant one; it preserves |z| = 1."""
    half = sp.exp(sp.pi * sp.I * TURNS)
    return sp.Matrix([[half, -STRENGTH * half], [-STRENGTH / half, 1 / half]]) / sp.sqrt(
        1 - STRENGTH**2
    )


def half_trace() -> sp.Expr:
    """Return half the trace, cos πΩ/√(1 - a²): below one in size the map turns, above it locks."""
    return sp.simplify(cycle_matrix().trace().rewrite(sp.cos) / 2)


def rotation_number() -> sp.Expr:
    """Return ρ = arccos(cos πΩ/√(1 - a²))/π, turns a cycle, for Ω in (0, 1) outside the lock-in.

    A matrix of determinant one whose half trace is cos πρ is a rotation by 2πρ in other
    coordinates.
    """
    return sp.acos(half_trace()) / sp.pi


def lock_in_margin() -> sp.Expr:
    """Return a² - sin² πΩ: the cycle locks where it is not negative, that is where |sin πΩ| ≤ a."""
    return STRENGTH**2 - sp.sin(sp.pi * TURNS) ** 2


def lock_in_edge() -> sp.Expr:
    """Return the turn of the cycle at which the lock-in ends, arcsin(a)/π, turns: locked in |Ω| ≤
    that.
    """
    return sp.asin(STRENGTH) / sp.pi


def stable_multiplier() -> sp.Expr:
    """Return the multiplier of the stable fixed point, |Ω| < 1/2 inside the lock-in; the other's is
    its inverse.

    It is the inverse square of the matrix's larger eigenvalue.
    """
    root, cosine = sp.sqrt(lock_in_margin()), sp.cos(sp.pi * TURNS)
    return (cosine - root) / (cosine + root)


def fixed_points() -> tuple[sp.Expr, sp.Expr]:
    """Return z of the stable and of the unstable fixed point, |Ω| < 1/2 inside the lock-in."""
    root, half = sp.sqrt(lock_in_margin()), sp.exp(sp.pi * sp.I * TURNS)
    sine = sp.I * sp.sin(sp.pi * TURNS)
    return half * (-sine - root) / STRENGTH, half * (-sine + root) / STRENGTH


def slope() -> sp.Expr:
    """Return f'(χ), the Poisson kernel (1 - a²)/(1 - 2a cos χ + a²)."""
    return (1 - STRENGTH**2) / (1 - 2 * STRENGTH * sp.cos(ANGLE) + STRENGTH**2)


def least_move() -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """Return where f(χ) - χ is least, the gap ε there and the curvature A (f ≈ χ + ε + A x²), rad.

    The place is -arccos a; with Ω_c the edge of the lock-in, ε = 2π(Ω - Ω_c) and A = tan πΩ_c.
    """
    gap = 2 * sp.pi * (TURNS - lock_in_edge())
    return -sp.acos(STRENGTH), gap, STRENGTH / sp.sqrt(1 - STRENGTH**2)


def cosine_beyond_the_edge() -> sp.Expr:
    """Return cos πρ a little beyond the edge, at Ω = Ω_c + η, written in η and a alone."""
    return sp.cos(sp.pi * EXCESS) - least_move()[2] * sp.sin(sp.pi * EXCESS)


def square_root_law() -> sp.Expr:
    """Return the leading term of ρ² beyond the edge, 2Aη/π: the saddle-node's square-root law ρ ≈
    √(2Aη/π).

    Its inverse root is the passage time π/√(Aε) of the bottleneck: close to the edge a turn is that
    passage.
    """
    return 2 * least_move()[2] * EXCESS / sp.pi
