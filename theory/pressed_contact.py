"""Friction over the contact of a foundation that is pressed, as a sum over the contact's rim.

In the velocity plane, w = M (v + omega z x r), the contact is cut into cones from the centre of
rotation, w = 0. Along a cone w grows by a factor s; |w|, its gradient and its Hessian are
homogeneous of degree 1, 0 and -1, and the pressure is a quadratic: all is a power of s. What is
left is an integral along the rim, closed on straight sides, and rational on the conic where the
pressure ends. Functions named `..._residual` vanish.
"""

import sympy as sp

#: A velocity w, m/s; along a straight side w = d n + t e.
W_X, W_Y = sp.symbols("w_x w_y", real=True)
D, T = sp.Symbol("d", positive=True), sp.Symbol("t", real=True)
#: Place on an arc, 0 to 1, and its weight.
S, WEIGHT = sp.symbols("s w", positive=True)

Place = tuple[sp.Expr, sp.Expr]


def speed() -> sp.Expr:
    """Return |w|."""
    return sp.sqrt(W_X**2 + W_Y**2)


def cone_share(degree: int, power: int) -> sp.Expr:
    """Return 1/(k + j + 2): what a cone holds of a term of degree k times pressure of degree j.

    int_0^1 s^k s^j s ds, the last factor from the area.
    """
    rho = sp.Symbol("rho", positive=True)
    return sp.integrate(rho ** (degree + power + 1), (rho, 0, 1))


def cone_residual(pressure: sp.Expr, term: sp.Expr) -> sp.Expr:
    """div(p F w) - (k + j + 2) p F, for p and F homogeneous of degree j and k.

    So int p F = 1/(k + j + 2) rim p F (w.n), and w.n dl = w x dw: the cones' formula again, by the
    divergence theorem.
    """
    growth = sum(sp.diff(pressure * term, w) * w for w in (W_X, W_Y))
    factor = 1 / cone_share(degree_of(term), degree_of(pressure))
    return sp.simplify(growth + 2 * pressure * term - factor * pressure * term)


def degree_of(term: sp.Expr) -> int:
    """Return the degree of a homogeneous term, by Euler's theorem."""
    growth = sum(sp.diff(term, w) * w for w in (W_X, W_Y))
    return int(sp.simplify(growth / term))


def side_integral(power: int, degree: int) -> sp.Expr:
    """Return int t^power |w|^degree dt along a side, |w| = sqrt(d^2 + t^2), up to a constant.

    Degrees 1, -1 and -3; powers 0 to 3 (of degree 1: to 2).
    """
    size, angle = sp.sqrt(D**2 + T**2), sp.asinh(T / D)
    length = (T * size + D**2 * angle) / 2
    cube = size**3 / 3
    known = {
        (0, 1): length,
        (1, 1): cube,
        (2, 1): T * size**3 / 4 - D**2 * length / 4,
        (0, -1): angle,
        (1, -1): size,
        (2, -1): length - D**2 * angle,
        (3, -1): cube - D**2 * size,
        (0, -3): T / (D**2 * size),
        (1, -3): -1 / size,
        (2, -3): angle - T / size,
        (3, -3): size + D**2 / size,
    }
    return known[power, degree]


def side_residual(power: int, degree: int) -> sp.Expr:
    """Derivative of `side_integral` less what it integrates."""
    size = sp.sqrt(D**2 + T**2)
    return sp.simplify(sp.diff(side_integral(power, degree), T) - T**power * size**degree)


def arc_place(first: Place, middle: Place, last: Place) -> sp.Matrix:
    """Return the place on an arc of a conic, a rational curve of Bezier's.

    ((1-s)^2 a + 2 w s (1-s) c + s^2 b) / ((1-s)^2 + 2 w s (1-s) + s^2)
    """
    parts = _bernstein()
    above = sum(
        (part * sp.Matrix(at) for part, at in zip(parts, (first, middle, last), strict=True)),
        sp.zeros(2, 1),
    )
    return above / sum(parts)


def swept_area(first: Place, middle: Place, last: Place) -> sp.Expr:
    """Return w x dw/ds along an arc: a quadratic over the square of its denominator."""
    a, c, b = sp.Matrix(first), sp.Matrix(middle), sp.Matrix(last)
    t = 1 - S
    above = 2 * (WEIGHT * t**2 * _cross(a, c) + S * t * _cross(a, b) + WEIGHT * S**2 * _cross(c, b))
    return above / sum(_bernstein()) ** 2


def swept_residual(first: Place, middle: Place, last: Place) -> sp.Expr:
    """`swept_area` less the cross product of `arc_place` with its derivative."""
    place = arc_place(first, middle, last)
    return sp.simplify(swept_area(first, middle, last) - _cross(place, sp.diff(place, S)))


def moving_rim_residual() -> sp.Expr:
    """Derivative of int (c - x^2) over |x| < sqrt(c) by c less the contact's length, 2 sqrt(c).

    The rim moves, but the pressure vanishes there: loads change with c and l as if it stayed, which
    makes Newton's matrix the contact's area with its moments, and friction's derivatives by shapes
    integrals over the contact at hand.
    """
    x, level = sp.symbols("x c", positive=True)
    load = sp.integrate(level - x**2, (x, -sp.sqrt(level), sp.sqrt(level)))
    return sp.simplify(sp.diff(load, level) - 2 * sp.sqrt(level))


def _bernstein() -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    t = 1 - S
    return t**2, 2 * WEIGHT * S * t, S**2


def _cross(a: sp.Matrix, b: sp.Matrix) -> sp.Expr:
    return a[0] * b[1] - a[1] * b[0]
