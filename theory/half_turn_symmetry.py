"""A centred friction ellipse makes the cycle map commute with half a turn: f(θ + π) = f(θ) + π.

Friction is then even, h(-v) = h(v), and the object turned by π feels at every twist of its own
frame what it felt before. What follows is exact: stable directions come in opposite pairs, and so
do bottlenecks, with equal gaps and curvatures; from one to the next is half a turn at most. A step
of a whole turn needs an offset centre. The same evenness makes a drag that retraces its path undo
itself.
"""

import sympy as sp

from theory.turned_surface import (
    PHI,
    SPIN,
    THETA,
    VELOCITY_X,
    VELOCITY_Y,
    dissipation_of_a_point,
    support_function,
)

HARMONIC = sp.Symbol("k", integer=True)


def expanded_root(value: sp.Expr) -> sp.Expr:
    """Return an expression with every radicand multiplied out, so that equal roots cancel."""
    return value.replace(
        lambda part: part.is_Pow and part.exp == sp.S.Half,
        lambda root: sp.sqrt(sp.expand(root.base)),
    )


def oddness_of_the_support() -> sp.Expr:
    """Return h(-v) - h(v) = -2 (m0 v_m + n0 v_n): only the offset is odd."""
    velocity = sp.Matrix([VELOCITY_X, VELOCITY_Y])
    return sp.expand(
        expanded_root(support_function(-velocity, PHI))
        - expanded_root(support_function(velocity, PHI))
    )


def half_turn_residual() -> sp.Expr:
    """Return h of a point at θ + π less h at θ, the twist of the object's frame being the same:
    zero when centred.
    """
    there = dissipation_of_a_point(THETA + sp.pi, PHI)
    return sp.expand(expanded_root(there) - expanded_root(dissipation_of_a_point(THETA, PHI)))


def reversal_residual() -> sp.Expr:
    """Return h of a point at the twist -V less h at V: zero when centred; the spin is then odd in
    the ring's velocity.

    If ω minimises D with the ring at velocity u, then -ω does with the ring at -u: a path retraced
    is a turn undone.
    """
    here = dissipation_of_a_point(THETA, PHI)
    back = {VELOCITY_X: -VELOCITY_X, VELOCITY_Y: -VELOCITY_Y, SPIN: -SPIN}
    return sp.expand(expanded_root(here.subs(back, simultaneous=True)) - expanded_root(here))


def harmonic_factor() -> sp.Expr:
    """Return the factor e^{ikπ} by which half a turn multiplies the k-th harmonic of f(θ) - θ.

    f(θ + π) - (θ + π) = f(θ) - θ asks that it be 1 or the harmonic vanish: only even harmonics are
    left.
    """
    return sp.exp(sp.I * sp.pi * HARMONIC)


def even_map(order: int) -> sp.Expr:
    """Return the general lift with even harmonics up to 2·order, θ + Ω + Σ (A_j cos 2jθ + B_j sin
    2jθ).
    """
    value = THETA + sp.Symbol("Omega", real=True)
    for j in range(1, order + 1):
        a, b = sp.symbols(f"A_{j} B_{j}", real=True)
        value += a * sp.cos(2 * j * THETA) + b * sp.sin(2 * j * THETA)
    return value


def doubled(lift: sp.Expr) -> sp.Expr:
    """Return G(y) = 2 f(y/2), in the variable θ: the map on the circle of directions without sense.

    If f commutes with half a turn, G is again a lift of degree one, with twice the rotation number
    in turns and, at y = 2θ, the slope of f at θ. What f does in half a turn, G does in a turn.
    """
    return sp.expand(2 * lift.subs(THETA, THETA / 2))


def last_step(count: int) -> sp.Expr:
    """Return the height (rad) of the last of the steps in a half turn, given the others: π less
    their sum.

    Bottlenecks at θ₁ < ... < θ_p < θ₁ + π repeat after π, and with them the p heights, which are
    positive. So every height is π exactly if there is one bottleneck in each half turn, and below π
    if there are more: 2π never.
    """
    others = sp.symbols(f"s_1:{count}", positive=True) if count > 1 else ()
    return sp.pi - sum(others)
