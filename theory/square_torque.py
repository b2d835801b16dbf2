"""Isotropic friction torques of bodies that turn about their centre: square, rectangle, regular
polygon, disc.

Torques per unit load, m. The sides' integrals come from `theory.patch_dissipation`; turning about
the centre, M(v + omega z x r) is mu omega times r turned by a right angle, so that the mean of |w|
is mu omega times the mean of |r|. Functions named `..._residual` vanish identically.
"""

import sympy as sp

from theory.patch_dissipation import polygon_integral, rim_integral, side_term

#: Coefficient of friction.
MU = sp.Symbol("mu", positive=True)
#: Side of the square, m; sides of a rectangle, m; radius of a disc or circumradius of a polygon, m.
L, A, B, R = sp.symbols("L a b R", positive=True)

_ANGLE = sp.Symbol("theta", real=True)


def square_torque(mu: sp.Expr = MU, side: sp.Expr = L) -> sp.Expr:
    """Return mu L (sqrt 2 + ln(1 + sqrt 2))/6, the torque of an evenly loaded square."""
    return mu * side * (sp.sqrt(2) + sp.log(1 + sp.sqrt(2))) / 6


def _rectangle(a: sp.Expr, b: sp.Expr) -> list[tuple[sp.Expr, sp.Expr]]:
    return [(-a / 2, -b / 2), (a / 2, -b / 2), (a / 2, b / 2), (-a / 2, b / 2)]


def square_residual() -> sp.Expr:
    """`square_torque` less mu/L^2 times the sum over sides of `theory.patch_dissipation`."""
    closed = MU * polygon_integral(_rectangle(L, L)) / L**2
    return sp.simplify(sp.expand(square_torque() - closed.rewrite(sp.log)))


def secant_cubed_integral(angle: sp.Expr = _ANGLE) -> sp.Expr:
    """Return int_0^theta sec^3 = (sec tan + ln(sec + tan))/2."""
    return (sp.sec(angle) * sp.tan(angle) + sp.log(sp.sec(angle) + sp.tan(angle))) / 2


def secant_residual() -> sp.Expr:
    """Derivative of `secant_cubed_integral` less sec^3; it is zero at zero."""
    return sp.simplify(
        (sp.diff(secant_cubed_integral(), _ANGLE) - sp.sec(_ANGLE) ** 3).rewrite(sp.cos)
    )


def direct_square_torque() -> sp.Expr:
    """Return mu/L^2 int |r| dA in polar coordinates: eight wedges 0 <= theta <= pi/4, r <= (L/2)
    sec(theta).
    """
    r = sp.Symbol("r", positive=True)
    along = sp.integrate(r * r, (r, 0, L / 2 * sp.sec(_ANGLE)))
    factor = sp.simplify(along / sp.sec(_ANGLE) ** 3)
    return 8 * MU / L**2 * factor * secant_cubed_integral(sp.pi / 4)


def direct_square_residual() -> sp.Expr:
    """`square_torque` less the direct integral."""
    return sp.simplify(sp.expand(square_torque() - direct_square_torque()))


def rectangle_torque() -> sp.Expr:
    """Return mu [c/3 + a^2 asinh(b/a)/(6 b) + b^2 asinh(a/b)/(6 a)]/2 with the diagonal c, for a
    rectangle a x b.
    """
    c = sp.sqrt(A**2 + B**2)
    return MU * (c / 3 + A**2 * sp.asinh(B / A) / (6 * B) + B**2 * sp.asinh(A / B) / (6 * A)) / 2


def rectangle_residual() -> sp.Expr:
    """`rectangle_torque` less the sum over sides."""
    closed = MU * sum(side_term(d / 2, -t / 2, t / 2) * 2 for d, t in ((A, B), (B, A))) / (A * B)
    return sp.simplify(sp.expand(rectangle_torque() - closed))


def rim_ratio_residual() -> sp.Expr:
    """Torque of a square's weight on the line of its rim less 3/2 of `square_torque`.

    All sides are equally far from the centre, and the mean of |r| over a triangle about its apex is
    2/3 of its base's.
    """
    rim = MU * rim_integral(_rectangle(L, L)) / (4 * L)
    return sp.simplify(sp.expand(rim.rewrite(sp.log) - sp.Rational(3, 2) * square_torque()))


def polygon_torque(count: sp.Expr) -> sp.Expr:
    """Return the torque of a regular polygon: mu R/3 [1 + cos^2 x asinh(tan x)/sin x], x =
    pi/count.
    """
    x = sp.pi / count
    return MU * R / 3 * (1 + sp.cos(x) ** 2 * sp.asinh(sp.tan(x)) / sp.sin(x))


def polygon_residual() -> sp.Expr:
    """`polygon_torque` less the sum over sides, d = R cos x and t from -R sin x to R sin x, for
    every x < pi/2.

    With x = 2 arctan q all is rational in q but for asinh and the square root of a square.
    """
    q = sp.Symbol("q", positive=True)
    cosine, sine = (1 - q**2) / (1 + q**2), 2 * q / (1 + q**2)
    d, t = sp.symbols("d t", positive=True)
    # The area is n d t, the sum n times one side's term; d^2 + t^2 = R^2.
    one = MU * side_term(d, -t, t) / (d * t)
    one = one.subs(sp.sqrt(d**2 + t**2), R).subs({d: R * cosine, t: R * sine})
    x = sp.Symbol("x", positive=True)
    closed = polygon_torque(sp.pi / x).subs(
        {sp.cos(x): cosine, sp.sin(x): sine, sp.tan(x): sine / cosine}
    )
    return sp.simplify(closed - one.subs(sp.Abs(cosine), cosine))


def disc_torque() -> sp.Expr:
    """Return 2/3 mu R, from int r^2 dr."""
    r = sp.Symbol("r", positive=True)
    return MU * sp.integrate(r * r, (r, 0, R)) * 2 * sp.pi / (sp.pi * R**2)


def polygon_series(order: int = 4) -> sp.Expr:
    """Return `polygon_torque` as a series in x = pi/count: 2/3 mu R (1 - x^2/3 + ...).

    asinh(tan x) is int_0^x sec, so that all terms are series of trigonometric functions.
    """
    x, y = sp.symbols("x y", positive=True)
    angle = sp.integrate(sp.series(1 / sp.cos(y), y, 0, order + 2).removeO(), (y, 0, x))
    return sp.series(MU * R / 3 * (1 + sp.cos(x) ** 2 * angle / sp.sin(x)), x, 0, order).removeO()


def inverse_gudermannian_residual() -> sp.Expr:
    """Derivative of asinh(tan x) less sec x, on 0 <= x < pi/2, with u = tan x: asinh(tan x) is
    int_0^x sec.
    """
    u = sp.Symbol("u", nonnegative=True)
    return sp.simplify(sp.diff(sp.asinh(u), u) * (1 + u**2) - sp.sqrt(1 + u**2))


def disc_limit_residual() -> sp.Expr:
    """Limit of `polygon_torque` for ever more corners less `disc_torque`."""
    x = sp.Symbol("x", positive=True)
    return sp.simplify(sp.limit(polygon_torque(sp.pi / x), x, 0, "+") - disc_torque())


def anisotropic_disc_torque(mu_a: sp.Expr, mu_b: sp.Expr) -> sp.Expr:
    """Return the torque of a disc under a centred ellipse, 4/(3 pi) mu_a R E(1 - mu_b^2/mu_a^2),
    E(m) complete.
    """
    return 4 * mu_a * R * sp.elliptic_e(1 - mu_b**2 / mu_a**2) / (3 * sp.pi)


def anisotropic_disc_residual() -> sp.Expr:
    """Square of |M z x r|/r around the disc less mu_a^2 (1 - m sin^2): its root's mean is 2/pi mu_a
    E(m).
    """
    mu_a, mu_b = sp.symbols("mu_a mu_b", positive=True)
    around = (mu_a * sp.cos(_ANGLE)) ** 2 + (mu_b * sp.sin(_ANGLE)) ** 2
    return sp.simplify(around - mu_a**2 * (1 - (1 - mu_b**2 / mu_a**2) * sp.sin(_ANGLE) ** 2))
