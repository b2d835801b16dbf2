"""The traction law from maximum dissipation: Ma & Rodriguez (2018), Eq. 1 (limit ellipse) gives Eq.
2 (traction).

A point that slides with velocity (v_m, v_n) feels, of all tractions that its limit ellipse allows,
the one that takes the most power. All in the material's axes (m, n), per unit load. Functions named
`..._residual` vanish identically.
"""

import sympy as sp

#: Semi-axes of the limit ellipse.
MU_A, MU_B = sp.symbols("mu_a mu_b", positive=True)
#: Its centre.
M0, N0 = sp.symbols("m0 n0", real=True)
#: Sliding velocity, m/s.
V_M, V_N = sp.symbols("v_m v_n", real=True)
#: Any traction coefficients.
T_M, T_N = sp.symbols("t_m t_n", real=True)

_VELOCITY = sp.Matrix([V_M, V_N])


def limit_ellipse(t_m: sp.Expr = T_M, t_n: sp.Expr = T_N) -> sp.Expr:
    """Return Eq. 1, zero on the limit ellipse and negative inside: ((t_m - m0)/mu_a)^2 + ((t_n -
    n0)/mu_b)^2 - 1.
    """
    return ((t_m - M0) / MU_A) ** 2 + ((t_n - N0) / MU_B) ** 2 - 1


def sliding_speed(v_m: sp.Expr = V_M, v_n: sp.Expr = V_N) -> sp.Expr:
    """Return s = sqrt(mu_a^2 v_m^2 + mu_b^2 v_n^2), m/s: the length of w = (mu_a v_m, mu_b v_n)."""
    return sp.sqrt(MU_A**2 * v_m**2 + MU_B**2 * v_n**2)


def dissipation(v_m: sp.Expr = V_M, v_n: sp.Expr = V_N) -> sp.Expr:
    """Return the support function of the limit ellipse, h(v) = s + m0 v_m + n0 v_n, m/s."""
    return sliding_speed(v_m, v_n) + M0 * v_m + N0 * v_n


def traction() -> sp.Matrix:
    """Return Eq. 2: the traction coefficients (m0 + mu_a^2 v_m / s, n0 + mu_b^2 v_n / s)."""
    return sp.Matrix([M0 + MU_A**2 * V_M / sliding_speed(), N0 + MU_B**2 * V_N / sliding_speed()])


def most_dissipating_traction() -> sp.Matrix:
    """Solve max v.t on Eq. 1 by a Lagrange multiplier, step by step, without using Eq. 2.

    v = lambda grad(Eq. 1) is linear in t for a given lambda; Eq. 1 then gives lambda^2 = s^2/4, and
    the multiplier of a maximum is the positive one.
    """
    multiplier = sp.symbols("lambda", positive=True)
    stationary = [
        sp.Eq(v, multiplier * sp.diff(limit_ellipse(), t))
        for v, t in zip(_VELOCITY, (T_M, T_N), strict=True)
    ]
    found = sp.solve(stationary, [T_M, T_N], dict=True)[0]
    on_ellipse = sp.expand(limit_ellipse().subs(found) * multiplier**2)
    squared = sp.solve(on_ellipse, multiplier**2)[0]
    return sp.Matrix([found[T_M], found[T_N]]).subs(multiplier, sp.sqrt(sp.factor(squared)))


def traction_residual() -> sp.Matrix:
    """Eq. 2 less the solution of the maximum problem."""
    return sp.simplify(traction() - most_dissipating_traction())


def gradient_residual() -> sp.Matrix:
    """Eq. 2 less the gradient of the support function."""
    return sp.simplify(traction() - sp.Matrix([sp.diff(dissipation(), v) for v in _VELOCITY]))


def ellipse_residual() -> sp.Expr:
    """Eq. 1 at the traction of Eq. 2: a sliding point always uses the whole ellipse."""
    return sp.simplify(limit_ellipse(*traction()))


def power_residual() -> sp.Expr:
    """Power of the traction less the support function; for homogeneous h this is Euler's v . grad h
    = h.
    """
    return sp.simplify(traction().dot(_VELOCITY) - dissipation())


def homogeneity_residual() -> sp.Expr:
    """h(c v) - c h(v) for c > 0."""
    c = sp.symbols("c", positive=True)
    return sp.simplify(dissipation(c * V_M, c * V_N) - c * dissipation())


def dissipation_gap() -> sp.Expr:
    """Return h(v) - v.t for any t, written as s/2 (|x - w/s|^2 + 1 - |x|^2), x = ((t_m - m0)/mu_a,
    (t_n - n0)/mu_b).

    Both parts are non-negative wherever t is inside the ellipse (|x| <= 1), and they vanish
    together at x = w/s alone: Eq. 2 is the only maximum, over the whole ellipse and not its rim
    alone.
    """
    s = sliding_speed()
    apart = ((T_M - M0) / MU_A - MU_A * V_M / s) ** 2 + ((T_N - N0) / MU_B - MU_B * V_N / s) ** 2
    return s / 2 * (apart - limit_ellipse())


def maximality_residual() -> sp.Expr:
    """`dissipation_gap` less h(v) - v.t."""
    return sp.simplify(sp.expand(dissipation_gap() - (dissipation() - V_M * T_M - V_N * T_N)))


def curvature() -> sp.Matrix:
    """Return the Hessian of h, (mu_a mu_b)^2/s^3 p p^T with p = (-v_n, v_m): never negative, zero
    along v alone.
    """
    across = sp.Matrix([-V_N, V_M])
    return (MU_A * MU_B) ** 2 / sliding_speed() ** 3 * across * across.T


def curvature_residual() -> sp.Matrix:
    """`curvature` less the second derivatives of h: h is convex."""
    return sp.simplify(curvature() - sp.hessian(dissipation(), list(_VELOCITY)))


def off_centre() -> sp.Expr:
    """Return |c|^2 = (m0/mu_a)^2 + (n0/mu_b)^2: below one where the origin lies inside the limit
    ellipse.
    """
    return (M0 / MU_A) ** 2 + (N0 / MU_B) ** 2


def worst_velocity() -> sp.Matrix:
    """Return the direction of sliding that dissipates least for its s: w = -c, against the centre
    of the ellipse.
    """
    return sp.Matrix([-M0 / MU_A**2, -N0 / MU_B**2])


def worst_dissipation_residual() -> sp.Expr:
    """h(worst velocity) less |c| (1 - |c|): not positive once |c| >= 1."""
    c = sp.sqrt(off_centre())
    return sp.simplify(sp.expand(dissipation(*worst_velocity()) - c * (1 - c)))


def least_dissipation_residual() -> sp.Expr:
    """(|w||c|)^2 - (w.c)^2 less the square of w x c, where h(v) - s (1 - |c|) = |w||c| + w.c.

    The square cannot be negative, so that h(v) >= s (1 - |c|), which is positive for every v while
    |c| < 1.
    """
    w, c = (MU_A * V_M, MU_B * V_N), (M0 / MU_A, N0 / MU_B)
    remainder = dissipation() - sliding_speed() * (1 - sp.sqrt(off_centre()))
    dot = sp.expand(remainder - sliding_speed() * sp.sqrt(off_centre()))
    cross = w[0] * c[1] - w[1] * c[0]
    return sp.simplify(sp.expand(sliding_speed() ** 2 * off_centre() - dot**2 - cross**2))
