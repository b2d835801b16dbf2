"""The dissipation of a uniformly loaded polygon in closed form, its gradient, its limits.

w(r) = M (v + omega z x r) maps the polygon to one in the velocity plane; the dissipation is the
mean of |w| over it. On one side of that polygon w = d n + t e, with n the outward normal, e = z x n
the side's direction, d the signed distance of the origin from the side's line and t the position
along it. Functions named `..._residual` vanish.
"""

import sympy as sp

#: Distance of the origin from a side's line (its sign does not matter to the integrals), and
#: position along the side.
D, T = sp.Symbol("d", positive=True), sp.Symbol("t", real=True)
#: Where the side starts and ends.
T0, T1 = sp.symbols("t_0 t_1", real=True)
#: A velocity w, m/s.
W_X, W_Y = sp.symbols("w_x w_y", real=True)
#: Semi-axes of the limit ellipse, and the object's spin, rad/s.
MU_A, MU_B = sp.symbols("mu_a mu_b", positive=True)
OMEGA = sp.Symbol("omega", real=True)

Corner = tuple[sp.Expr, sp.Expr]


def inverse_integral(d: sp.Expr = D, t: sp.Expr = T) -> sp.Expr:
    """Return int_0^t dt / |w| = asinh(t/|d|)."""
    return sp.asinh(t / sp.Abs(d))


def length_integral(d: sp.Expr = D, t: sp.Expr = T) -> sp.Expr:
    """Return int_0^t |w| dt = [t sqrt(d^2 + t^2) + d^2 asinh(t/|d|)]/2."""
    if d == 0:
        return t * sp.Abs(t) / 2
    return (t * sp.sqrt(d**2 + t**2) + d**2 * inverse_integral(d, t)) / 2


def side_term(d: sp.Expr = D, t_0: sp.Expr = T0, t_1: sp.Expr = T1) -> sp.Expr:
    """Return one side's part of int |w|, d/3 int |w| dt.

    That is d/6 [t sqrt(d^2 + t^2) + d^2 asinh(t/|d|)] between the side's ends.
    """
    return d / 3 * (length_integral(d, t_1) - length_integral(d, t_0))


def side_geometry(start: Corner, end: Corner) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """Return (d, t_0, t_1) of the side from one corner to the next of a
    counter-clockwise polygon."""
    e_x, e_y = end[0] - start[0], end[1] - start[1]
    size = sp.sqrt(e_x**2 + e_y**2)
    distance = (start[0] * e_y - start[1] * e_x) / size
    return distance, (start[0] * e_x + start[1] * e_y) / size, (end[0] * e_x + end[1] * e_y) / size


def sides(corners: list[Corner]) -> list[tuple[sp.Expr, sp.Expr, sp.Expr]]:
    """Return (d, t_0, t_1) of every side of a counter-clockwise polygon."""
    return [side_geometry(a, b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]


def normals(corners: list[Corner]) -> list[sp.Matrix]:
    """Return the outward normal of every side of a counter-clockwise polygon."""
    found = []
    for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
        size = sp.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2)
        found.append(sp.Matrix([b[1] - a[1], a[0] - b[0]]) / size)
    return found


def polygon_integral(corners: list[Corner]) -> sp.Expr:
    """Return int |w| over a counter-clockwise polygon of the velocity plane, whether or not it
    holds the origin.
    """
    return sum((side_term(*side) for side in sides(corners)), sp.Integer(0))


def polygon_force(corners: list[Corner]) -> sp.Matrix:
    """Return int grad |w| = rim |w| n over a counter-clockwise polygon of the velocity plane."""
    total = sp.zeros(2, 1)
    for outward, (d, t_0, t_1) in zip(normals(corners), sides(corners), strict=True):
        total += outward * (length_integral(d, t_1) - length_integral(d, t_0))
    return total


def polygon_curvature(corners: list[Corner]) -> sp.Matrix:
    """Return int hess |w| = rim (w/|w|) n^T over a counter-clockwise polygon of the velocity plane,
    (2, 2).
    """
    total = sp.zeros(2, 2)
    for outward, (d, t_0, t_1) in zip(normals(corners), sides(corners), strict=True):
        along = sp.Matrix([-outward[1], outward[0]])
        rise = sp.sqrt(d**2 + t_1**2) - sp.sqrt(d**2 + t_0**2)
        turned = 0 if d == 0 else d * (inverse_integral(d, t_1) - inverse_integral(d, t_0))
        total += (turned * outward + rise * along) * outward.T
    return total


def rim_integral(corners: list[Corner]) -> sp.Expr:
    """Return int |w| along the sides: the dissipation of weight that the rim's line carries, in the
    velocity plane.
    """
    return sum(
        (length_integral(d, t_1) - length_integral(d, t_0) for d, t_0, t_1 in sides(corners)),
        sp.Integer(0),
    )


def velocity_image(
    corners: list[Corner], velocity: Corner, omega: sp.Expr, matrix: sp.Matrix
) -> list[Corner]:
    """Return the images w = M (v + omega z x r) of a polygon's corners."""
    images = [
        matrix * sp.Matrix([velocity[0] - omega * y, velocity[1] + omega * x]) for x, y in corners
    ]
    return [(image[0], image[1]) for image in images]


def traction_matrix(angle: sp.Expr) -> sp.Matrix:
    """Return M with s = |M v|, the material's first axis at `angle` in the frame of v."""
    c, s = sp.cos(angle), sp.sin(angle)
    return sp.Matrix([[MU_A * c, MU_A * s], [-MU_B * s, MU_B * c]])


def length_residual() -> sp.Expr:
    """Derivative of `length_integral` less |w|; both are zero at t = 0."""
    return sp.simplify(sp.diff(length_integral(), T) - sp.sqrt(D**2 + T**2))


def inverse_residual() -> sp.Expr:
    """Derivative of `inverse_integral` less 1/|w|; both integrals are zero at t = 0."""
    return sp.simplify(sp.diff(inverse_integral(), T) - 1 / sp.sqrt(D**2 + T**2))


def divergence_residual(weight: sp.Expr = 1) -> sp.Expr:
    """div(p |w| w) - (3 + k) p |w| for a homogeneous polynomial p(w) of degree k.

    With p = 1: int |w| = 1/3 rim |w| (w.n), and w.n = d on a side. With k = 1: leaning pressure.
    """
    speed = sp.sqrt(W_X**2 + W_Y**2)
    degree = sp.Poly(weight, W_X, W_Y).total_degree()
    divergence = sum(sp.diff(weight * speed * w, w) for w in (W_X, W_Y))
    return sp.simplify(sp.expand(divergence - (3 + degree) * weight * speed))


def triangle_residual() -> sp.Expr:
    """int |w| over the triangle from the origin to a side less `side_term`, by their growth with
    the side's end.

    w = rho (d n + t e), 0 <= rho <= 1, has area element rho d; both are zero for a side without
    length. Every polygon is a signed sum of such triangles: a second way to the sum over sides,
    without the divergence theorem.
    """
    rho = sp.Symbol("rho", positive=True)
    place = sp.Matrix([rho * D, rho * T])
    element = place.jacobian([rho, T]).det()
    along = sp.integrate(rho * element, (rho, 0, 1)) * sp.sqrt(D**2 + T**2)
    return sp.simplify(along - sp.diff(side_term(D, T0, T), T))


def image_area_residual() -> sp.Expr:
    """Determinant of dw/dr less omega^2 mu_a mu_b, the ratio of the image's area to the patch's."""
    x, y, angle = sp.symbols("x y phi", real=True)
    v_x, v_y = sp.symbols("v_x v_y", real=True)
    image = sp.Matrix(velocity_image([(x, y)], (v_x, v_y), OMEGA, traction_matrix(angle))[0])
    return sp.simplify(image.jacobian([x, y]).det() - OMEGA**2 * MU_A * MU_B)


def gradient_residual() -> sp.Matrix:
    """Gradient of one side's term by a shift of the origin, less n int |w| dt, less the ends'
    difference of G.

    In the axes (n, e), with G(w) = |w| (z x w)/3, which depends on the corner alone: around a
    closed polygon the differences cancel, and what is left is int grad |w| = rim |w| n.
    """
    s = [sp.sqrt(D**2 + t**2) for t in (T0, T1)]
    change = sp.Matrix(
        [sp.diff(side_term(), D), sp.diff(side_term(), T0) + sp.diff(side_term(), T1)]
    )
    corner = [sp.Matrix([-t, D]) * length / 3 for t, length in zip((T0, T1), s, strict=True)]
    normal = sp.Matrix([length_integral(D, T1) - length_integral(D, T0), 0])
    return sp.simplify(sp.expand(change - normal - (corner[1] - corner[0])))


def unit_vector_residual() -> sp.Matrix:
    """Derivative of (d asinh(t/|d|), |w|) less w/|w| in the axes (n, e): the sides' integrals in
    the Hessian.
    """
    integral = sp.Matrix([D * inverse_integral(), sp.sqrt(D**2 + T**2)])
    return sp.simplify(sp.diff(integral, T) - sp.Matrix([D, T]) / sp.sqrt(D**2 + T**2))
