"""Limits of the patch's closed form: a centre of rotation on a side, far away, a rim, and a grid of
points instead.

In the notation of `theory.patch_dissipation`. Functions named `..._residual` vanish identically.
"""

import sympy as sp

from theory.patch_dissipation import (
    MU_A,
    MU_B,
    OMEGA,
    Corner,
    polygon_curvature,
    polygon_integral,
    sides,
    velocity_image,
)

#: Velocity of the centre of pressure in the material's axes, m/s, and a lever from there, m.
V_M, V_N = sp.symbols("v_m v_n", real=True)
R_M, R_N = sp.symbols("r_m r_n", real=True)
#: Second moments of the pressure about its centre, in the material's axes, m^2.
C_MM, C_MN, C_NN = sp.symbols("C_mm C_mn C_nn", real=True)
#: omega L/(2 v) of a square of side L that moves with v along one of its axes.
EPSILON = sp.Symbol("epsilon", positive=True)
#: Spacing of a grid of support points, m.
SPACING = sp.Symbol("h", positive=True)
#: By which a polygon is scaled.
SCALE = sp.Symbol("lambda", positive=True)


def touching_residual() -> sp.Expr:
    """Limit of d^2 asinh(t/d) as d -> 0: a side whose line goes through the centre of rotation adds
    nothing.

    With z = t/d it is t^2 asinh(z)/z^2 as z -> oo, which t^2 bounds.
    """
    z = sp.Symbol("z", positive=True)
    return sp.limit(sp.asinh(z) / z**2, z, sp.oo)


def _speed() -> sp.Expr:
    """Return |M (v + omega z x r)| in the material's axes."""
    return sp.sqrt((MU_A * (V_M - OMEGA * R_N)) ** 2 + (MU_B * (V_N + OMEGA * R_M)) ** 2)


def translation_terms() -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """Return the terms of |M (v + omega z x r)| in omega^0, omega^1, omega^2, with s = |M v|.

    s,  (mu_b^2 v_n r_m - mu_a^2 v_m r_n)/s,  (mu_a mu_b)^2 (v.r)^2/(2 s^3).
    """
    s = sp.sqrt(MU_A**2 * V_M**2 + MU_B**2 * V_N**2)
    first = (MU_B**2 * V_N * R_M - MU_A**2 * V_M * R_N) / s
    return s, first, (MU_A * MU_B) ** 2 * (V_M * R_M + V_N * R_N) ** 2 / (2 * s**3)


def translation_residual() -> sp.Matrix:
    """`translation_terms` less the derivatives at omega = 0 (the second one halved)."""
    derivatives = [_speed(), sp.diff(_speed(), OMEGA), sp.diff(_speed(), OMEGA, 2) / 2]
    terms = translation_terms()
    return sp.Matrix(
        [sp.simplify(d.subs(OMEGA, 0) - t) for d, t in zip(derivatives, terms, strict=True)]
    )


def near_translation() -> sp.Expr:
    """Return D near translation, s + omega^2 (mu_a mu_b)^2 v^T C v/(2 s^3), up to terms in omega^3.

    It is the mean of `translation_terms` over a pressure with its centre at r = 0 and second
    moments C: for a square C = L^2/12. The torque is its derivative by omega, proportional to
    omega: no torque resists a pure translation.
    """
    zeroth, first, second = (sp.Poly(sp.expand(term), R_M, R_N) for term in translation_terms())
    means = {(0, 0): 1, (1, 0): 0, (0, 1): 0, (2, 0): C_MM, (1, 1): C_MN, (0, 2): C_NN}

    def mean(term: sp.Poly) -> sp.Expr:
        return sum((value * means[powers] for powers, value in term.terms()), sp.Integer(0))

    return sp.simplify(mean(zeroth) + OMEGA * mean(first)) + OMEGA**2 * sp.factor(mean(second))


def square_far_series() -> list[sp.Expr]:
    """Return the sides' terms of int |w| over [1 - epsilon, 1 + epsilon] x [-epsilon, epsilon], up
    to epsilon^4.

    The unit of velocity is mu v. Right, left, and twice the bottom, which the top equals. Each is
    d/3 int |w| dt (see `length_residual` of `theory.patch_dissipation`) over t = middle + epsilon
    u, expanded under the integral.
    """
    e, u = EPSILON, sp.Symbol("u", real=True)

    def term(d: sp.Expr, middle: sp.Expr) -> sp.Expr:
        length = sp.series(sp.sqrt(d**2 + (middle + e * u) ** 2), e, 0, 4).removeO()
        whole = sp.expand(d / 3 * e * sp.integrate(length, (u, -1, 1)))
        return sum((whole.coeff(e, k) * e**k for k in range(5)), sp.Integer(0))

    return [term(1 + e, sp.Integer(0)), term(e - 1, sp.Integer(0)), 2 * term(e, sp.Integer(1))]


def square_far_residual() -> sp.Expr:
    """Mean of |w| from the sides' series less `near_translation` of the square, 1 + epsilon^2/6."""
    mean = sp.expand(sum(square_far_series()) / (4 * EPSILON**2))
    side = sp.Symbol("L", positive=True)
    mu, v = sp.symbols("mu v", positive=True)
    values = {MU_A: mu, MU_B: mu, V_M: v, V_N: 0, C_MM: side**2 / 12, C_NN: side**2 / 12, C_MN: 0}
    expected = near_translation().subs(values).subs(OMEGA, 2 * EPSILON * v / side) / (mu * v)
    return sp.simplify(mean - expected)


def cancellation() -> sp.Expr:
    """Return the limit of epsilon times sum |terms| / |sum of terms| as epsilon -> 0.

    It is positive: rounding in the sum over sides grows in proportion to the distance 1/epsilon of
    the centre of rotation. The torque, (D - v.F)/omega, loses one more power. The code integrates
    over the area there.
    """
    right, left, others = square_far_series()
    return sp.limit(EPSILON * (right - left + others) / (right + left + others), EPSILON, 0)


def polygon_area(corners: list[Corner]) -> sp.Expr:
    """Return the area, sum of d (t_1 - t_0)/2 over the sides of a counter-clockwise polygon."""
    return sum((d * (t_1 - t_0) / 2 for d, t_0, t_1 in sides(corners)), sp.Integer(0))


def rim_mean(corners: list[Corner], centre: Corner) -> sp.Expr:
    """Return the mean of |w| over a rim, all weight on the polygon's sides: the even form's
    derivative by the scale.

    What a polygon scaled by 1 + epsilon about its centre has more than the polygon is a frame of no
    width.
    """
    x, y = centre
    scaled = [(x + SCALE * (a - x), y + SCALE * (b - y)) for a, b in corners]
    weight, area = (
        sp.diff(form(scaled), SCALE).subs(SCALE, 1) for form in (polygon_integral, polygon_area)
    )
    return weight / area


def midpoint_residual() -> sp.Expr:
    """Mean over a square cell less the value at its middle less h^2/24 times the Laplacian there,
    for any cubic.

    A grid of points in the middle of cells therefore errs by -h^2/24 times the mean Laplacian, up
    to terms in h^4, wherever |w| is smooth.
    """
    x, y = sp.symbols("x y", real=True)
    powers = [(i, j) for i in range(4) for j in range(4 - i)]
    f = sum(sp.Symbol(f"a_{i}{j}") * x**i * y**j for i, j in powers)
    mean = (
        sp.integrate(f, (x, -SPACING / 2, SPACING / 2), (y, -SPACING / 2, SPACING / 2)) / SPACING**2
    )
    laplacian = sp.diff(f, x, 2) + sp.diff(f, y, 2)
    return sp.expand(mean - (f + SPACING**2 / 24 * laplacian).subs({x: 0, y: 0}))


def laplacian_residual() -> sp.Expr:
    """Laplacian by r of |M (v + omega z x r)| less omega^2 tr(M^T H M), H = hess |w| = (1 - w
    w^T/|w|^2)/|w|.
    """
    x, y, w_x, w_y = sp.symbols("x y w_x w_y", real=True)
    matrix = sp.Matrix(2, 2, sp.symbols("M_11 M_12 M_21 M_22", real=True))
    image = sp.Matrix(velocity_image([(x, y)], (V_M, V_N), OMEGA, matrix)[0])
    # w is linear in r, so that second derivatives by r are P^T H P.
    linear = image.jacobian([x, y])
    hessian = sp.hessian(sp.sqrt(w_x**2 + w_y**2), (w_x, w_y))
    w = sp.Matrix([w_x, w_y])
    claimed = (sp.eye(2) - w * w.T / w.dot(w)) / sp.sqrt(w.dot(w))
    return sp.simplify(
        (linear.T * hessian * linear).trace() - OMEGA**2 * (matrix.T * claimed * matrix).trace()
    )


def grid_defect(
    corners: list[Corner], velocity: Corner, omega: sp.Expr, matrix: sp.Matrix, spacing: sp.Expr
) -> sp.Expr:
    """Return the leading error of D on a grid of points, -h^2/24 times the mean Laplacian over the
    polygon.

    The mean is closed too: `theory.patch_dissipation.polygon_curvature` of the image over the
    image's area.
    """
    image = velocity_image(corners, velocity, omega, matrix)
    curvature = matrix.T * polygon_curvature(image) * matrix
    return -(spacing**2) / 24 * omega**2 * curvature.trace() / polygon_area(image)


def spinning_square_grid_defect(count: sp.Expr) -> sp.Expr:
    """Return `grid_defect` of a square that spins about its centre on `count` x `count` points,
    relative to D.

    It is -ln(1 + sqrt 2)/((sqrt 2 + ln(1 + sqrt 2)) count^2) for isotropic friction.
    """
    log = sp.log(1 + sp.sqrt(2))
    return -log / ((sp.sqrt(2) + log) * count**2)


def spinning_square_residual() -> sp.Expr:
    """`spinning_square_grid_defect` less `grid_defect` over the mean of |w|; side 2 a, spin omega >
    0.
    """
    a, mu, omega, count = sp.symbols("a mu omega n", positive=True)
    corners = [(-a, -a), (a, -a), (a, a), (-a, a)]
    still, matrix = (sp.Integer(0), sp.Integer(0)), mu * sp.eye(2)
    image = velocity_image(corners, still, omega, matrix)
    mean = polygon_integral(image) / polygon_area(image)
    relative = grid_defect(corners, still, omega, matrix, 2 * a / count) / mean
    return sp.simplify(relative.rewrite(sp.log) - spinning_square_grid_defect(count))
