"""An offset limit ellipse as a centred one and a constant force at the centre of pressure.

Twists (v_x, v_y, omega) are those of the frame's origin, wrenches (force, torque) are about it; the
frame stands at the angle zero over the surface. Wrenches are those that keep the object moving,
grad D; friction is their opposite. Functions named `..._residual` vanish identically.
"""

import sympy as sp

from theory.plane_rotation import rotation
from theory.traction_law import M0, N0, dissipation

#: Twist of the frame's origin: m/s, m/s, rad/s.
V_X, V_Y, OMEGA = sp.symbols("v_x v_y omega", real=True)
#: Angle of the material's first axis, rad.
PHI = sp.symbols("phi", real=True)

TWIST = sp.Matrix([V_X, V_Y, OMEGA])

Point = tuple[sp.Expr, sp.Expr]


def velocity_at(point: Point) -> sp.Matrix:
    """Return the velocity v + omega z x r of the object at a point (m) of the frame."""
    return sp.Matrix([V_X - OMEGA * point[1], V_Y + OMEGA * point[0]])


def point_dissipation(point: Point) -> sp.Expr:
    """Return the power lost at one support point per unit of its load, h(R(phi)^T (v + omega z x
    r)).
    """
    return dissipation(*(rotation(PHI).T * velocity_at(point)))


def centred(expression: sp.Expr) -> sp.Expr:
    """Return an expression for the ellipse moved to the origin, m0 = n0 = 0."""
    return expression.subs({M0: 0, N0: 0})


def support_points(count: int) -> tuple[list[Point], list[sp.Symbol]]:
    """Return symbols for positions (m) and loads (N) of support points."""
    points = [sp.symbols(f"x_{i} y_{i}", real=True) for i in range(count)]
    return points, [sp.Symbol(f"N_{i}", positive=True) for i in range(count)]


def total_dissipation(points: list[Point], loads: list[sp.Expr]) -> sp.Expr:
    """Return D(V) = sum N_i h(v_i), W."""
    return sum(
        (load * point_dissipation(point) for point, load in zip(points, loads, strict=True)),
        sp.Integer(0),
    )


def centre_of_pressure(points: list[Point], loads: list[sp.Expr]) -> Point:
    """Return the mean position, weighted by load, m."""
    total = sum(loads)
    x = sum(load * point[0] for point, load in zip(points, loads, strict=True)) / total
    y = sum(load * point[1] for point, load in zip(points, loads, strict=True)) / total
    return x, y


def offset_force() -> sp.Matrix:
    """Return the constant force per unit load, R(phi) (m0, n0), in the frame's axes."""
    return rotation(PHI) * sp.Matrix([M0, N0])


def offset_wrench(centre: Point) -> sp.Matrix:
    """Return the constant wrench per unit load about the frame's origin: `offset_force` acting at a
    point (m).
    """
    force = offset_force()
    return sp.Matrix([force[0], force[1], centre[0] * force[1] - centre[1] * force[0]])


def power_residual(count: int = 3) -> sp.Expr:
    """D less the centred D less N R(phi)(m0, n0) . (velocity of the centre of pressure), for
    `count` points.
    """
    points, loads = support_points(count)
    whole = total_dissipation(points, loads)
    constant = sum(loads) * offset_force().dot(velocity_at(centre_of_pressure(points, loads)))
    return sp.simplify(sp.expand(whole - centred(whole) - constant))


def pressure_residual() -> sp.Expr:
    """The same for a pressure p(x, y): the integrands' difference less F.(v p + omega z x (r p)).

    The latter is linear in p, x p and y p, so that its integral holds load and centre of pressure
    alone.
    """
    x, y = sp.symbols("x y", real=True)
    p = sp.Function("p")(x, y)
    integrand = p * point_dissipation((x, y))
    moments = sp.Matrix([V_X * p - OMEGA * (y * p), V_Y * p + OMEGA * (x * p)])
    return sp.simplify(sp.expand(integrand - centred(integrand) - offset_force().dot(moments)))


def limit_surface_residual(count: int = 2) -> sp.Matrix:
    """grad D less the centred grad D less a wrench that no twist changes: the limit surface is
    shifted as a whole.
    """
    points, loads = support_points(count)
    whole = total_dissipation(points, loads)
    difference = whole - centred(whole)
    constant = sum(loads) * offset_wrench(centre_of_pressure(points, loads))
    return sp.simplify(sp.expand(sp.Matrix([sp.diff(difference, v) for v in TWIST]) - constant))


def torque_at_centre_residual(count: int = 3) -> sp.Expr:
    """Torque about the centre of pressure of the offset forces N_i R(phi)(m0, n0) at `count`
    points.
    """
    points, loads = support_points(count)
    x, y = centre_of_pressure(points, loads)
    force = offset_force()
    torque = sum(
        load * ((point[0] - x) * force[1] - (point[1] - y) * force[0])
        for point, load in zip(points, loads, strict=True)
    )
    return sp.simplify(sp.expand(torque))


def slope() -> sp.Expr:
    """Return the slope tan(alpha) of the table on which a centred ellipse does the same."""
    return sp.sqrt(M0**2 + N0**2)


def tilted_table_residual() -> sp.Matrix:
    """Needed force with an offset less the one on a table tilted by arctan(slope), centred ellipse;
    per unit load.

    On the tilted table the load is m g cos(alpha) and gravity pulls with m g sin(alpha) down the
    slope, against `offset_force`; the contact then has to supply what friction takes less what
    gravity gives.
    """
    alpha = sp.atan(slope())
    g, m = sp.symbols("g m", positive=True)
    load = m * g * sp.cos(alpha)
    downhill = -rotation(PHI) * sp.Matrix([M0, N0]) / slope()
    gravity = m * g * sp.sin(alpha) * downhill
    return sp.simplify(offset_force() - (-gravity / load))


def closed_path_work_residual() -> sp.Expr:
    """Work of the offset force once around any closed path x(t), y(t) of the centre of pressure,
    here of three modes.

    The force is constant in the world, hence has a potential: only where the centre of pressure
    ends counts.
    """
    t = sp.symbols("t", real=True)
    modes = [sp.symbols(f"a_{i} b_{i} c_{i} d_{i}", real=True) for i in range(1, 4)]
    x = sum(a * sp.cos(k * t) + b * sp.sin(k * t) for k, (a, b, _, _) in enumerate(modes, 1))
    y = sum(c * sp.cos(k * t) + d * sp.sin(k * t) for k, (_, _, c, d) in enumerate(modes, 1))
    power = offset_force().dot(sp.Matrix([sp.diff(x, t), sp.diff(y, t)]))
    return sp.simplify(sp.integrate(sp.expand(power), (t, 0, 2 * sp.pi)))
