"""What the shapes of plate and floor do to the cycle map, friction being isotropic.

A foundation that is pressed bears p = max(0, c + l.x + q_plate + q_floor): in the object's frame
q_plate stays and q_floor turns as the object does. So only the floor's bow makes the map depend on
where the object points, by its second harmonic to first order. Functions named `..._residual`
vanish.
"""

import sympy as sp

THETA, TURN = sp.symbols("theta beta", real=True)
#: A place of the object's frame; dome, and both parts of a bow, of a plate and of a floor.
X, Y = sp.symbols("x y", real=True)
PLATE_DOME, PLATE_BOW_X, PLATE_BOW_Y = sp.symbols("K_p A_p B_p", real=True)
FLOOR_DOME, BOW, AXIS = sp.symbols("K b alpha", real=True)


def quadratic(
    dome: sp.Expr, bow_x: sp.Expr, bow_y: sp.Expr, x: sp.Expr = X, y: sp.Expr = Y
) -> sp.Expr:
    """Return dome r^2 + bow_x (x^2 - y^2) + 2 bow_y x y."""
    return dome * (x**2 + y**2) + bow_x * (x**2 - y**2) + 2 * bow_y * x * y


def floor_seen_by_the_object(theta: sp.Expr = THETA, axis: sp.Expr = AXIS) -> sp.Expr:
    """Return q_floor at a place of an object that has turned by theta."""
    c, s = sp.cos(theta), sp.sin(theta)
    bow_x, bow_y = BOW * sp.cos(2 * axis), BOW * sp.sin(2 * axis)
    return quadratic(FLOOR_DOME, bow_x, bow_y, c * X - s * Y, s * X + c * Y)


def turned_bow_residual() -> sp.Expr:
    """q_floor less the quadratic of the same dome and a bow along axis - theta."""
    apart = 2 * (AXIS - THETA)
    turned = quadratic(FLOOR_DOME, BOW * sp.cos(apart), BOW * sp.sin(apart))
    return _spelled_out(floor_seen_by_the_object() - turned)


def half_turn_residual() -> sp.Expr:
    """q_floor at theta + pi less that at theta: so f(theta + pi) = f(theta) + pi."""
    return _spelled_out(floor_seen_by_the_object(THETA + sp.pi) - floor_seen_by_the_object())


def turned_floor_residual() -> sp.Expr:
    """q_floor of a floor and an object that are both turned by beta less that of neither."""
    turned = floor_seen_by_the_object(THETA + TURN, AXIS + TURN)
    return _spelled_out(turned - floor_seen_by_the_object())


def shapes_without_bow() -> sp.Expr:
    """Return the whole quadratic where the floor has a dome alone: theta drops out."""
    plate = quadratic(PLATE_DOME, PLATE_BOW_X, PLATE_BOW_Y)
    return _spelled_out(plate + floor_seen_by_the_object().subs(BOW, 0))


def first_order_harmonics(response_x: sp.Expr, response_y: sp.Expr) -> dict[int, sp.Expr]:
    """Return the harmonics of what a small bow adds to the turn of a cycle, by their order.

    To first order the bow acts along the motion without it, which is the same from every theta: its
    parts in the object's frame at the start, b cos 2(alpha - theta) and b sin 2(alpha - theta),
    count with a response each.
    """
    apart = 2 * (AXIS - THETA)
    change = BOW * (response_x * sp.cos(apart) + response_y * sp.sin(apart))
    return _harmonics(change, 4)


def offset_harmonics(response_x: sp.Expr, response_y: sp.Expr) -> dict[int, sp.Expr]:
    """Return the same of the friction ellipse's centre, a constant force R(phi) (m0, n0) of the
    world.
    """
    m, n = sp.symbols("m n", real=True)
    c, s = sp.cos(THETA), sp.sin(THETA)
    change = response_x * (c * m + s * n) + response_y * (c * n - s * m)
    return _harmonics(change, 4)


def loads_of_three_supports() -> sp.Matrix:
    """Return the loads of three support points, whatever the shapes: balance alone.

    Three equations, of load and both moments, for three loads: c and l take up any q.
    """
    places = sp.symbols("x_1 y_1 x_2 y_2 x_3 y_3", real=True)
    centre = sp.symbols("x_0 y_0", real=True)
    rows = sp.Matrix([[1, 1, 1], places[0::2], places[1::2]])
    return rows.LUsolve(sp.Matrix([1, *centre]))


def level_of_three_supports() -> sp.Matrix:
    """Return c and l (3,) under which three supports bear given loads in spite of a shape q."""
    places = sp.symbols("x_1 y_1 x_2 y_2 x_3 y_3", real=True)
    loads, shape = sp.symbols("N_1:4", real=True), sp.symbols("q_1:4", real=True)
    rows = sp.Matrix([[1, places[2 * k], places[2 * k + 1]] for k in range(3)])
    return rows.LUsolve(sp.Matrix([load - q for load, q in zip(loads, shape, strict=True)]))


def _harmonics(change: sp.Expr, highest: int) -> dict[int, sp.Expr]:
    """Coefficients of exp(i k theta), k = 0 to `highest`, that do not vanish."""
    wave = sp.Symbol("z", positive=True)
    powers = sp.expand(_spelled_out(change).subs(THETA, -sp.I * sp.log(wave)))
    found = {order: sp.simplify(powers.coeff(wave, order)) for order in range(highest + 1)}
    return {order: value for order, value in found.items() if value != 0}


def _spelled_out(value: sp.Expr) -> sp.Expr:
    """A trigonometric polynomial as a sum of exponentials, in which equal things cancel."""
    return sp.expand(value.rewrite(sp.exp))
