"""The equations of friction and of one contact as CasADi functions.

Friction is that of one edge, line, chord or point of a pressure; a contact that of a rod on a side,
corner or ellipse, in the ring or in a wedge: it begins with the twist that its unknowns mean, and
ends with what they become by Newton's method; between them C adds up the friction, G with its
Hessian H.

What ellipses and points add to the friction itself is summed in pressure.c and ellipse.c, several
places at once.

A slider that moves with the twist V = (vx, vy, omega) of its own frame dissipates, per unit load,
the mean of |w| over its pressure, w(r) = M (v + omega z x r), besides the constant force of the
friction ellipse's centre (m0, n0) at the centre of pressure; M has the half axes mu_a, mu_b at the
angle alpha = phi - theta. G = grad D balances the contact force (Goyal, Ruina & Papadopoulos 1991),
H is the Hessian of D. C loops over what a pressure is made of and adds up.

Lengths are in extents of the footprint, friction coefficients in units of sqrt(mu_a mu_b): nothing
depends on scales.
"""

from types import SimpleNamespace

import casadi as ca

from cyclemap.mechanics.engine.parts import ROW_KINDS
from cyclemap.mechanics.engine.schema import (
    FRAME,
    FRICTION,
    KINDS,
    LAWS,
    MATRIX,
    MOTION,
    OF_PRESSURE,
    PAIRS,
    QUADRATIC,
    STATE,
    TWIST,
    UNKNOWN,
    VARIED,
)

# Keep quotients and logarithms finite where the centre of rotation lies on a side, or at a point.
TINY, TINIEST = 1e-60, 1e-150


def kernels() -> dict[str, ca.Function]:
    """Return the functions of one piece of pressure, and how those along a motion of M are called:
    name_toward.

    Sides come as the images of their ends in the velocity plane with their distances from the
    origin, which neighbours share; for the motion of M, as their ends.
    """
    twist, matrix = ca.SX.sym("twist", TWIST.size), ca.SX.sym("matrix", MATRIX.size)
    toward = ca.SX.sym("toward", MATRIX.size)
    ends, images = ca.SX.sym("ends", ROW_KINDS["edge"].size), ca.SX.sym("images", 6)
    lean, place, chord = ca.SX.sym("lean", 4), ca.SX.sym("place", 2), ca.SX.sym("chord", 11)
    own = ca.vertcat(_image(twist, matrix, ends[:2]), _image(twist, matrix, ends[2:]))
    # One over how a patch's area grows in the velocity plane.
    scale = 1 / (TWIST.of(twist).omega ** 2 * _det(matrix))
    functions = {"assembled": _assembled(twist, matrix)}
    # Edges are summed in two passes, so that the slow steps of one do not wait for those of
    # another.
    side, angle = _Side(images), ca.SX.sym("angle")
    kept = ca.vertcat(side.tx, side.ty, side.d, side.rise, side.ts, side.excess)
    functions["side"] = function_of("side", [images], [kept])
    parts = ca.SX.sym("side", 6)
    side.tx, side.ty, side.d, side.rise, side.ts, _ = ca.vertsplit(parts)
    side.nx, side.ny = side.ty, -side.tx
    side.set_angle(angle)
    functions["edge"] = function_of(
        "edge", [matrix, parts, angle], [ca.vertcat(*_edge(side, twist, matrix))]
    )
    for name, sums_of, more in (
        ("edge", _edge, ()),
        ("lean", _leaning_edge, (lean,)),
        ("line", _line, ()),
    ):
        whole = ca.vertcat(*sums_of(_Side(own), twist, matrix, *more)[:3]) * (
            1 if name == "line" else scale
        )
        if name != "edge":
            sums = ca.vertcat(*sums_of(_Side(images), twist, matrix, *more))
            functions[name] = function_of(name, [twist, matrix, images, *more], [sums])
        moved = ca.jtimes(whole, matrix, toward)
        functions[f"{name}_toward"] = function_of(
            f"{name}_toward", [twist, matrix, ends, *more, toward], [moved]
        )
    # The wrench of a unit of load at a point.
    x, y = ca.vertsplit(place)
    wx, wy = _velocity(twist, matrix, x, y)
    inverse = 1 / ca.sqrt(wx * wx + wy * wy + TINIEST**2)
    fx, fy = _transposed(matrix, wx * inverse, wy * inverse)
    moved = ca.jtimes(ca.vertcat(fx, fy, x * fy - y * fx), matrix, toward)
    functions["point_toward"] = function_of("point_toward", [twist, matrix, place, toward], [moved])
    moved = ca.vertcat(*_chord_toward(twist, matrix, chord, toward))
    functions["chord_toward"] = function_of("chord_toward", [twist, matrix, chord, toward], [moved])
    functions["corner"] = function_of(
        "corner", [twist, matrix, place], [_image(twist, matrix, place)]
    )
    pressure = ca.SX.sym("pressure", QUADRATIC.size)
    image = _about_rotation(twist, matrix, pressure)
    functions["pressed_image"] = function_of("pressed_image", [twist, matrix, pressure], [image])
    functions["pressed_image_toward"] = function_of(
        "pressed_image_toward",
        [twist, matrix, pressure, toward],
        [ca.jtimes(image, matrix, toward)],
    )
    return functions


def rim_kernels() -> dict[str, ca.Function]:
    """Return functions of what bounds the contact of a foundation that is pressed, compiled for
    some places at once, of one row of numbers each.

    pressed_side: the images of both ends and the quadratic of w, to the sums in the velocity plane.
    pressed_side_toward: the same, then how they move, to how D and the force move, and the force.
    pressed_cone_toward: of a thin cone to w, instead of ends w and w x dw.
    """
    ends, cone = ca.SX.sym("ends", 4), ca.SX.sym("cone", 3)
    image = ca.SX.sym("image", QUADRATIC.size)
    sizes = [ca.sqrt(ca.sumsqr(ends[k : k + 2])) for k in (0, 2)]
    side = _pressed_side(_Side(ca.vertcat(ends[:2], sizes[0], ends[2:], sizes[1])), image)
    given = ca.vertcat(ends, image)
    functions = {"pressed_side": function_of("pressed_side", [given], [ca.vertcat(*side)])}
    for name, place, (speed, fx, fy, *_) in (
        ("pressed_side_toward", ends, side),
        ("pressed_cone_toward", cone, _pressed_cone(cone, image)),
    ):
        given = ca.vertcat(place, image)
        motion = ca.SX.sym("motion", given.numel())
        moved = ca.jtimes(ca.vertcat(speed, fx, fy), given, motion)
        results = ca.vertcat(moved, fx, fy)
        functions[name] = function_of(name, [ca.vertcat(given, motion)], [results])
    return functions


def function_of(name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> ca.Function:
    """Return a function of dense results whose common parts are computed once."""
    return ca.Function(name, inputs, ca.cse([ca.densify(output) for output in outputs]))


# What one piece of a pressure adds. Twists and M (by columns) come first; `sums` are D, the force
# and the Hessian by (vx, vy) of pieces whose torque follows from homogeneity, or the wrench and the
# Hessian's six entries of others.


def _velocity(twist: ca.SX, matrix: ca.SX, x: ca.SX, y: ca.SX) -> tuple[ca.SX, ca.SX]:
    v, m = TWIST.of(twist), MATRIX.of(matrix)
    vx, vy = v.vx - v.omega * y, v.vy + v.omega * x
    return m.xx * vx + m.xy * vy, m.yx * vx + m.yy * vy


def _transposed(matrix: ca.SX, x: ca.SX, y: ca.SX) -> tuple[ca.SX, ca.SX]:
    m = MATRIX.of(matrix)
    return m.xx * x + m.yx * y, m.xy * x + m.yy * y


def _det(matrix: ca.SX) -> ca.SX:
    m = MATRIX.of(matrix)
    return m.xx * m.yy - m.yx * m.xy


def _image(twist: ca.SX, matrix: ca.SX, place: ca.SX) -> ca.SX:
    x, y = _velocity(twist, matrix, *ca.vertsplit(place))
    return ca.vertcat(x, y, ca.sqrt(x * x + y * y))


class _Side:
    """A straight side in the velocity plane: w = d n + t tau, and its integrals that keep their
    digits from afar.
    """

    def __init__(self, images: ca.SX) -> None:
        x0, y0, s0, x1, y1, s1 = ca.vertsplit(images)
        ex, ey = x1 - x0, y1 - y0
        self.size = size = ca.sqrt(ex * ex + ey * ey)
        inverse = 1 / size
        self.tx, self.ty = ex * inverse, ey * inverse
        self.nx, self.ny = self.ty, -self.tx
        self.d = d = x0 * self.nx + y0 * self.ny
        self.start, self.end = x0 * self.tx + y0 * self.ty, x1 * self.tx + y1 * self.ty
        self.s0, self.s1 = s0, s1
        total, between = s0 + s1, self.start + self.end
        # s0 + start and s1 - end, whose sum is total - size: neither cancels where the origin is
        # beside the side.
        before, after = ca.fabs(self.start), ca.fabs(self.end)
        first, second = s0 + before + TINY, s1 + after + TINY
        spare = (
            d * d * (first + second) + ((self.start + before) + (after - self.end)) * first * second
        )
        # Integrals of 1/s, t/s and s along the side, s = sqrt(d^2 + t^2).
        self.excess = 2 * size * first * second / (spare + TINIEST)
        self.rise = size * between / total
        self.ts = (size * total + self.rise * between) / 2
        self.set_angle(ca.log1p(self.excess))

    def set_angle(self, angle: ca.SX) -> None:
        """Take the logarithm log1p(excess), on which the rest depends."""
        self.angle, square = angle, self.d * self.d * angle
        self.length, self.moment = (self.ts + square) / 2, (self.ts - square) / 2

    def across(self, along: ca.SX, mixed: ca.SX, across: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Return xx, xy, yy of along t t^T + mixed (n t^T + t n^T) + across n n^T."""
        tx, ty, nx, ny = self.tx, self.ty, self.nx, self.ny
        return (
            along * tx * tx + 2 * mixed * nx * tx + across * nx * nx,
            along * tx * ty + mixed * (nx * ty + tx * ny) + across * nx * ny,
            along * ty * ty + 2 * mixed * ny * ty + across * ny * ny,
        )


def _homogeneous(
    matrix: ca.SX, speed: ca.SX, fx: ca.SX, fy: ca.SX, curve: tuple[ca.SX, ca.SX, ca.SX]
) -> list[ca.SX]:
    """D, the force and the Hessian by v, from integrals in the velocity plane."""
    xx, xy, yy = curve
    (ax, bx), (ay, by), m = (
        _transposed(matrix, xx, xy),
        _transposed(matrix, xy, yy),
        MATRIX.of(matrix),
    )
    return [
        *(speed, *_transposed(matrix, fx, fy)),
        *(m.xx * ax + m.yx * ay, m.xy * ax + m.yy * ay, m.xy * bx + m.yy * by),
    ]


def _edge(side: _Side, twist: ca.SX, matrix: ca.SX) -> list[ca.SX]:
    """What one side adds to an even patch, times the image's area over the patch's, by the
    divergence theorem:

    int |w| = 1/3 rim |w| (w.n), int grad |w| = rim |w| n, int hess |w| = rim (w/|w|) n^T.
    """
    # The rim's (w/|w|) n^T is symmetric as a whole; what is mixed is shared.
    curve = side.across(0, side.rise / 2, side.d * side.angle)
    force = side.length
    return _homogeneous(matrix, force * side.d / 3, force * side.nx, force * side.ny, curve)


def _leaning_edge(side: _Side, twist: ca.SX, matrix: ca.SX, lean: ca.SX) -> list[ca.SX]:
    """The same of a pressure g . (r - r0), `lean` being (g, r0), as c + s . w in the velocity
    plane:

    int w |w| = 1/4 rim w |w| (w.n), int w_i grad |w| = rim w_i |w| n - e_i int |w|, and alike for
    the Hessian.
    """
    # r = r_c + B^-1 w with B = omega M J; c is the pressure at the centre of rotation r_c.
    v, m = TWIST.of(twist), MATRIX.of(matrix)
    det = v.omega * _det(matrix)
    gx, gy, x0, y0 = ca.vertsplit(lean)
    sx, sy = -(m.yx * gx + m.yy * gy) / det, (m.xx * gx + m.xy * gy) / det
    level = gx * (-v.vy / v.omega - x0) + gy * (v.vx / v.omega - y0)
    d, length, angle, rise = side.d, side.length, side.angle, side.rise
    cube = rise * (side.s0**2 + side.s0 * side.s1 + side.s1**2) / 3
    first_x, first_y = d * length * side.nx + cube * side.tx, d * length * side.ny + cube * side.ty
    along = sx * first_x + sy * first_y
    even = d * length / 3
    speed = d * (level * length / 3 + along / 4)
    fx, fy = (
        (level * length + along) * side.nx - sx * even,
        (level * length + along) * side.ny - sy * even,
    )
    # rim (s.w) (w/|w|) n^T - int (w/|w|) s^T, symmetric as a whole.
    xx, xy, yy = side.across(side.moment, d * rise, d * d * angle)
    px, py = xx * sx + xy * sy, xy * sx + yy * sy
    ux, uy = d * angle * side.nx + rise * side.tx, d * angle * side.ny + rise * side.ty
    px, py, lx, ly = level * ux + px, level * uy + py, length * side.nx, length * side.ny
    mixed = (px * side.ny + py * side.nx - lx * sy - ly * sx) / 2
    return _homogeneous(
        matrix, speed, fx, fy, (px * side.nx - lx * sx, mixed, py * side.ny - ly * sy)
    )


def _line(side: _Side, twist: ca.SX, matrix: ca.SX) -> list[ca.SX]:
    """What a load spread along one side adds: the means of |w|, w/|w| and hess |w| along it."""
    sine = side.end / (side.s1 + TINY) - side.start / (side.s0 + TINY)
    cosine = side.d / (side.s1 + TINY) - side.d / (side.s0 + TINY)
    curve = side.across(sine / side.size, cosine / side.size, (side.angle - sine) / side.size)
    fx = (side.d * side.angle * side.nx + side.rise * side.tx) / side.size
    fy = (side.d * side.angle * side.ny + side.rise * side.ty) / side.size
    return _homogeneous(matrix, side.length / side.size, fx, fy, curve)


def _about_rotation(twist: ca.SX, matrix: ca.SX, pressure: ca.SX) -> ca.SX:
    """Return a quadratic of places as one of w, over how areas grow: (QUADRATIC.size, 1).

    r = r_c + B^-1 w with B = omega M J, r_c the centre of rotation.
    """
    v, m, p = TWIST.of(twist), MATRIX.of(matrix), QUADRATIC.of(pressure)
    slowness, shrinks = 1 / v.omega, 1 / (v.omega * _det(matrix))
    x, y = -v.vy * slowness, v.vx * slowness
    gx = p.slope_x + 2 * (p.xx * x + p.xy * y)
    gy = p.slope_y + 2 * (p.xy * x + p.yy * y)
    level = p.level + x * (p.slope_x + p.xx * x + 2 * p.xy * y) + y * (p.slope_y + p.yy * y)
    (ax, ay), (bx, by) = (-m.yx * shrinks, -m.yy * shrinks), (m.xx * shrinks, m.xy * shrinks)
    # B^-1 = ((ax, bx), (ay, by))
    mixed = p.xx * ax * bx + p.xy * (ax * by + ay * bx) + p.yy * ay * by
    image = (
        *(level, ax * gx + ay * gy, bx * gx + by * gy),
        p.xx * ax * ax + 2 * p.xy * ax * ay + p.yy * ay * ay,
        mixed,
        p.xx * bx * bx + 2 * p.xy * bx * by + p.yy * by * by,
    )
    return ca.vertcat(*image) * (slowness * shrinks)


def _pressed_side(side: _Side, quadratic: ca.SX) -> list[ca.SX]:
    """What one side of the contact adds under a quadratic of w, in the velocity plane.

    The contact is cut into cones from the centre of rotation, where w = 0: F homogeneous of degree
    k, int P F = rim (w x dw) F int_0^1 P(s w) s^(k+1) ds; along a side all that is in closed form.
    """
    q, tx, ty, nx, ny = QUADRATIC.of(quadratic), side.tx, side.ty, side.nx, side.ny
    d, square = side.d, side.d * side.d
    # P's terms of degree 1 and 2 in w = d n + t tau, by powers of t.
    first = (d * (q.slope_x * nx + q.slope_y * ny), q.slope_x * tx + q.slope_y * ty)
    bent_x, bent_y = q.xx * tx + q.xy * ty, q.xy * tx + q.yy * ty
    second = (
        square * (q.xx * nx * nx + 2 * q.xy * nx * ny + q.yy * ny * ny),
        2 * d * (bent_x * nx + bent_y * ny),
        bent_x * tx + bent_y * ty,
    )

    def coned(degree: int) -> tuple[ca.SX, ca.SX, ca.SX]:
        a, b, c = 1.0 / (degree + 2), 1.0 / (degree + 3), 1.0 / (degree + 4)
        even = q.level * a + first[0] * b + second[0] * c
        return even, first[1] * b + second[1] * c, second[2] * c

    s0, s1, t0, t1 = side.s0, side.s1, side.start, side.end
    cube = side.rise * (s0 * s0 + s0 * s1 + s1 * s1) * (1 / 3)
    # Integrals of t^k s, t^k / s and t^k / s^3 along the side.
    fourth = (t1 * s1**3 - t0 * s0**3) / 4 - square * side.length / 4
    over = (side.angle, side.rise, side.moment, cube - square * side.rise)
    sine = t1 / (s1 + TINY) - t0 / (s0 + TINY)
    slope = side.rise / (s0 * s1 + TINY)
    rest = side.angle - sine
    thrice = (slope, rest, side.rise - square * slope, side.moment - square * rest)
    a, b, c = coned(1)
    speed = a * side.length + b * cube + c * fourth
    a, b, c = coned(0)
    even = a * over[0] + b * over[1] + c * over[2]
    odd = a * over[1] + b * over[2] + c * over[3]
    fx, fy = d * even * nx + odd * tx, d * even * ny + odd * ty
    a, b, c = coned(-1)
    across = a * thrice[1] + b * thrice[2] + c * thrice[3]
    mixed = -d * (a * thrice[0] + b * thrice[1] + c * thrice[2])
    # d^2 of the integral of 1 / s^3 is sine.
    along = a * sine + square * (b * thrice[0] + c * thrice[1])
    return [d * value for value in (speed, fx, fy, *side.across(along, mixed, across))]


def _pressed_cone(cone: ca.SX, quadratic: ca.SX) -> list[ca.SX]:
    """D and force, in the velocity plane, of one thin cone from the centre of rotation to a place
    w on the rim; `cone`: it, and w x dw.
    """
    q = QUADRATIC.of(quadratic)
    x, y, cross = ca.vertsplit(cone)
    first = q.slope_x * x + q.slope_y * y
    second = q.xx * x * x + 2 * q.xy * x * y + q.yy * y * y
    size = ca.sqrt(x * x + y * y + TINIEST**2)
    force = cross * (q.level / 2 + first / 3 + second / 4) / size
    speed = cross * (q.level / 3 + first / 4 + second / 5) * size
    return [speed, force * x, force * y]


def _assembled(twist: ca.SX, matrix: ca.SX) -> ca.Function:
    """(twist, matrix, sums) -> friction, by homogeneity: D = V . grad D, hess D . V = 0."""
    sums, (vx, vy, omega) = ca.SX.sym("sums", 6), ca.vertsplit(twist)
    speed, fx, fy, xx, xy, yy = ca.vertsplit(sums)
    cross_x, cross_y = -(xx * vx + xy * vy) / omega, -(xy * vx + yy * vy) / omega
    wrench = [fx, fy, (speed - vx * fx - vy * fy) / omega]
    hessian = [xx, xy, yy, cross_x, cross_y, -(cross_x * vx + cross_y * vy) / omega]
    return function_of("assembled", [twist, matrix, sums], [ca.vertcat(*wrench, *hessian)])


def _chord_toward(twist: ca.SX, matrix: ca.SX, given: ca.SX, toward: ca.SX) -> list[ca.SX]:
    """What a chord through the centre of rotation adds to an elliptic patch's wrench as M moves.

    Through M itself, and through how u, the chord's one direction, turns along it. Given: u, the
    chord's middle m and its direction e (places: m + tau e, |tau| <= q), and for a pressure f0 +
    tau f1 the moments of (1, tau) for u and of (1, tau, tau^2) for the curvature across it.
    """
    ux, uy, mx, my, ex, ey, first, second, k0, k1, k2 = ca.vertsplit(given)
    omega, t = TWIST.of(twist).omega, MATRIX.of(toward)
    fx, fy = _transposed(toward, ux, uy)
    bx, by = _transposed(matrix, -uy, ux)
    wx, wy = _velocity(twist, toward, mx, my)
    turn = ux * wy - uy * wx
    sx, sy = -omega * ey, omega * ex
    further = ux * (t.yx * sx + t.yy * sy) - uy * (t.xx * sx + t.xy * sy)
    even, odd = k0 * turn + k1 * further, k1 * turn + k2 * further
    middle, along = mx * by - my * bx, ex * by - ey * bx
    torque = (mx * fy - my * fx) * first + (ex * fy - ey * fx) * second
    return [fx * first + bx * even, fy * first + by * even, torque + middle * even + along * odd]


def contacts() -> dict[str, ca.Function]:
    """Return the functions of a contact: begin, slopes of each kind and law, finish of each law."""
    functions = {f"finish_{law}": _finish(law) for law in LAWS}
    for kind, law in PAIRS:
        state, p = ca.SX.sym("state", STATE.size), ca.SX.sym("p", MOTION.size)
        z = ca.SX.sym("z", LAWS[law])
        begun = list(_begun(kind, law, state, p, _facing(p), z))
        functions[f"begin_{kind}_{law}"] = function_of(f"begin_{kind}_{law}", [state, p, z], begun)
        functions[f"slopes_{kind}_{law}"] = _slopes(kind, law, by_all=False)
        functions[f"all_slopes_{kind}_{law}"] = _slopes(kind, law, by_all=True)
    return functions


def _facing(p: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
    """Cosines and sines of the direction and of the friction ellipse's axis, as C has them."""
    given = MOTION.of(p)
    return given.cos_direction, given.sin_direction, given.cos_phi, given.sin_phi


def _unknowns(z: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Spin and slip; none is zero."""
    spin, *slip = ca.vertsplit(z)
    return spin, slip.pop() if slip else ca.SX(0)


def _place(kind: str, coordinate: ca.SX, p: SimpleNamespace) -> tuple[ca.SX, ...]:
    """Contact point, normal, and travel of the rod's centre per unit of coordinate."""
    g = KINDS[kind].of(p.geometry)
    if kind == "side":
        x, y = g.x + coordinate * g.along_x, g.y + coordinate * g.along_y
        return x, y, g.along_y, -g.along_x, ca.SX(1)
    if kind in ("ring", "wedge"):
        angle = g.first_normal if kind == "wedge" else 0
        return g.x, g.y, ca.cos(angle), ca.sin(angle), ca.SX(1)
    c, s = ca.cos(coordinate), ca.sin(coordinate)
    if kind == "corner":
        return g.x, g.y, c, s, p.radius
    a, b = g.semi_x, g.semi_y
    speed = ca.sqrt((a * s) ** 2 + (b * c) ** 2)
    return a * c, b * s, b * c / speed, a * s / speed, speed + p.radius * a * b / speed**2


def _begun(
    kind: str, law: str, state: ca.SX, p: ca.SX, facing: tuple[ca.SX, ...], z: ca.SX
) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return twist, matrix and frame of a contact for a rod that travels by one; `facing` as
    `_facing` gives it.

    stick: the contact point moves with the rod; the spin is unknown. slide: it moves by -n + slip
    t, for a unit approach; spin and slip are unknown, and the true twist is that one times the
    approach -n.u, so that the equations stay well-conditioned up to the moment when the rod leaves.
    In ring and wedge the rod's centre stays where it is.
    """
    given, (theta, coordinate), (spin, slip) = MOTION.of(p), ca.vertsplit(state), _unknowns(z)
    x, y, c, s, metric = _place(kind, coordinate, given)
    c0, s0 = ca.cos(theta), ca.sin(theta)
    cd, sd, cp, sp = facing
    ahead, aside = cd * c0 + sd * s0, sd * c0 - cd * s0
    approach, along = -(c * ahead + s * aside), c * aside - s * ahead
    ux, uy = (-c - slip * s, -s + slip * c) if law == "slide" else (ahead, aside)
    twist = ca.vertcat(ux + spin * y, uy - spin * x, spin)
    ca_, sa = cp * c0 + sp * s0, sp * c0 - cp * s0
    mu_a, mu_b = given.mu_a, given.mu_b
    matrix = ca.vertcat(mu_a * ca_, -mu_b * sa, mu_a * sa, mu_b * ca_)
    fx, fy = ca_ * given.m0 - sa * given.n0, sa * given.m0 + ca_ * given.n0
    torque = given.centre_x * fy - given.centre_y * fx
    second = (0, 0)
    if kind == "wedge":
        angle = KINDS[kind].of(given.geometry).second_normal
        second = ca.cos(angle), ca.sin(angle)
    room = (coordinate - given.low, given.high - coordinate)
    frame = ca.vertcat(fx, fy, torque, x, y, c, s, approach, along, metric, *room, *second)
    return twist, matrix, frame


def _residual(law: str, frame: ca.SX, p: ca.SX, g: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return residuals, and the two forces that bound the law: compression and tangential force, or
    both compressions.

    stick: no torque about the contact. slide: none, and no force across the cone's edge -n + smu t.
    turn: the ring's friction makes a torque of smu |F| (the friction circle of a journal bearing;
    Mason 2001). wedge: two contacts that slide about the rod, each on its cone's edge; their
    compressions N balance the force, r smu (N1 + N2) the torque. A point's force lies between the
    outer edges of both cones.
    """
    at, given, (gx, gy, turning) = FRAME.of(frame), MOTION.of(p), ca.vertsplit(g)
    x, y, c, s, smu = at.x, at.y, at.cosine, at.sine, given.smu
    torque = y * gx - x * gy + turning
    normal, tangential = -(c * gx + s * gy), c * gy - s * gx
    if law == "slide":
        return ca.vertcat(torque, tangential - smu * normal), normal, tangential
    if law == "turn":
        return torque + smu * ca.sqrt(gx**2 + gy**2), normal, tangential
    if law == "wedge":
        sense = KINDS[law].of(given.geometry).sense
        (ax, ay), (bx, by), det = _edges(frame, p)
        first, second = (gx * by - gy * bx) / det, (ax * gy - ay * gx) / det
        return torque + given.radius * smu * (first + sense * second), first, second
    return torque, normal, tangential


def _edges(frame: ca.SX, p: ca.SX) -> tuple[tuple[ca.SX, ca.SX], tuple[ca.SX, ca.SX], ca.SX]:
    """The edges of both cones between which the force in a wedge lies, and their determinant."""
    at, given = FRAME.of(frame), MOTION.of(p)
    c, s, c2, s2, smu = at.cosine, at.sine, at.second_cosine, at.second_sine, given.smu
    other = smu * KINDS["wedge"].of(given.geometry).sense
    ax, ay, bx, by = -c - smu * s, -s + smu * c, -c2 - other * s2, -s2 + other * c2
    return (ax, ay), (bx, by), ax * by - ay * bx


def _wedge_margins(frame: ca.SX, p: ca.SX, first: ca.SX, second: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Margins of both contacts: their compressions; but a point's edges may be over half a turn
    apart.

    Then the force is between them unless it is in what is left of the turn, where both are
    positive; it comes there by the edge of that contact which stays.
    """
    _, _, det = _edges(frame, p)
    sense = KINDS["wedge"].of(MOTION.of(p).geometry).sense
    is_wide = ca.logic_and(sense < 0, det > 0)
    loses_first = first < second
    return (
        ca.if_else(is_wide, ca.if_else(loses_first, -first, 1), first),
        ca.if_else(is_wide, ca.if_else(loses_first, 1, -second), second),
    )


def _rate(law: str, frame: ca.SX, p: ca.SX, z: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return the state's rates by the rod's travel, and the slip of the rod over the slider."""
    at, radius, (spin, slip) = FRAME.of(frame), MOTION.of(p).radius, _unknowns(z)
    if law == "slide":
        slip = at.along - at.approach * slip
        return at.approach * spin, (slip - at.approach * spin * radius) / at.metric, slip
    return spin, -spin * radius / at.metric if law == "stick" else ca.SX(0), ca.SX(0)


def _finish(law: str) -> ca.Function:
    """(frame, parameters, unknowns, friction) -> row, report, as schema.py has them.

    The row without its state. Its unknowns are the corrected
    ones.
    """
    count = LAWS[law]
    frame, p, z = ca.SX.sym("frame", FRAME.size), ca.SX.sym("p", MOTION.size), ca.SX.sym("z", count)
    given, g, at, smu = (
        ca.SX.sym("given", FRICTION.size),
        ca.SX.sym("g", 3),
        FRAME.of(frame),
        MOTION.of(p).smu,
    )
    residual, first, second = _residual(law, frame, p, g)
    # Derivative of the twist by the unknowns.
    toward = ca.vertcat(at.y, -at.x, 1)
    if law == "slide":
        toward = ca.horzcat(toward, ca.vertcat(-at.sine, at.cosine, 0))
    by_unknowns = ca.jacobian(residual, g) @ _hessian(given) @ toward
    step = -_solved(by_unknowns, residual)
    total = given[:3] + frame[:3]
    residual, step, first, second = (
        ca.substitute(value, g, total) for value in (residual, step, first, second)
    )
    corrected = z + step
    theta_rate, rate, slip = _rate(law, frame, p, corrected)
    margins = {
        "stick": (smu * first - second, smu * first + second),
        "slide": (ca.sign(smu) * slip, 1),
        "turn": (1, 1),
    }
    of_law = _wedge_margins(frame, p, first, second) if law == "wedge" else margins[law]
    ends = (1, 1, 1) if law in ("turn", "wedge") else (at.approach, at.after_low, at.before_high)
    # Whether support points rest is told by rest.c.
    all_margins = (*ends, *of_law, 1)
    row = ca.vertcat(theta_rate, rate, *all_margins, corrected, *(0,) * (UNKNOWN.size - count))
    report = ca.vertcat(ca.mmax(ca.fabs(step)), _size(residual), first, second)
    return function_of(f"finish_{law}", [frame, p, z, given], [row, report])


def _size(residual: ca.SX) -> ca.SX:
    """The norm of two residuals; one as it is, with its sign."""
    first, *second = ca.vertsplit(residual)
    return ca.sqrt(first**2 + second.pop() ** 2) if second else first


def _hessian(given: ca.SX) -> ca.SX:
    f = FRICTION.of(given)
    return ca.blockcat([[f.xx, f.xy, f.xw], [f.xy, f.yy, f.yw], [f.xw, f.yw, f.ww]])


def _slopes(kind: str, law: str, by_all: bool) -> ca.Function:
    """(state, parameters, unknowns, friction, by law 9, by turning 3, by pressure) -> derivatives.

    By columns.

    By the implicit function theorem: of the rates (2, columns) by the state and SOURCES, or by the
    state and the direction; of the unknowns by the state, and what a Newton iteration corrects of
    these. `by law`: of the wrench by mu_a, mu_b, alpha, by columns; `by turning`: by theta
    through the pressure alone; `by pressure`: by its parameters.
    """
    count, name = LAWS[law], f"{'all_' if by_all else ''}slopes_{kind}_{law}"
    state, p, z = ca.SX.sym("state", STATE.size), ca.SX.sym("p", MOTION.size), ca.SX.sym("z", count)
    given, by_law = ca.SX.sym("given", FRICTION.size), ca.SX.sym("by_law", 9)
    by_pressure, g = ca.SX.sym("by_pressure", 3 * len(OF_PRESSURE)), ca.SX.sym("g", 3)
    by_turning = ca.SX.sym("by_turning", 3)
    motion = MOTION.of(p)
    # Of the angles themselves: they are varied.
    facing = (
        ca.cos(motion.direction),
        ca.sin(motion.direction),
        ca.cos(motion.phi),
        ca.sin(motion.phi),
    )
    twist, _, frame = _begun(kind, law, state, p, facing, z)
    varied = (
        ca.vertcat(state, *(p[place] for place in VARIED.values()))
        if by_all
        else ca.vertcat(state, motion.direction)
    )
    residual, _, _ = _residual(law, frame, p, g)
    by_g, total = ca.jacobian(residual, g), given[:3] + frame[:3]
    moving = ca.vertcat(motion.mu_a, motion.mu_b, motion.phi - STATE.of(state).theta)
    by_varied = ca.jacobian(residual, varied) + by_g @ (
        ca.jacobian(frame[:3], varied)
        + _hessian(given) @ ca.jacobian(twist, varied)
        + ca.reshape(by_law, 3, 3) @ ca.jacobian(moving, varied)
        + by_turning @ ca.jacobian(STATE.of(state).theta, varied)
    )
    if by_all:
        by_varied = ca.horzcat(by_varied, by_g @ ca.reshape(by_pressure, 3, len(OF_PRESSURE)))
    by_unknowns = by_g @ _hessian(given) @ ca.jacobian(twist, z)
    tangent = -_solved(by_unknowns, by_varied)
    rates = ca.vertcat(*_rate(law, frame, p, z)[:2])
    explicit = ca.horzcat(
        ca.jacobian(rates, varied), ca.SX.zeros(2, by_varied.shape[1] - varied.numel())
    )
    whole = explicit + ca.jacobian(rates, z) @ tangent
    correction = ca.mmax(ca.fabs(_solved(by_unknowns, residual)))
    outputs = [
        ca.substitute(value, g, total)
        for value in (ca.vec(whole), ca.vec(tangent[:, : STATE.size]), correction)
    ]
    return function_of(name, [state, p, z, given, by_law, by_turning, by_pressure], outputs)


def _solved(matrix: ca.SX, right: ca.SX) -> ca.SX:
    """Return matrix^-1 right for a matrix of one or two rows, in scalars."""
    if matrix.is_scalar():
        return right / matrix
    a, c, b, d = ca.vertsplit(ca.vec(matrix))
    return ca.blockcat([[d, -b], [-c, a]]) @ right / (a * d - b * c)
