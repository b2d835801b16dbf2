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
    pressure = ca.SX.sym("pressure", QUADRATIC.size)
    functions = {
        "assembled": _assembled(twist),
        "corner": function_of("corner", [twist, matrix, place], [_image(twist, matrix, place)]),
    }
    # Edges are summed in two passes, so that the slow steps of one do not wait for those of
    # another.
    side, angle, parts = _Side(images), ca.SX.sym("angle"), ca.SX.sym("side", 6)
    kept = ca.vertcat(side.t, side.d, side.rise, side.ts, side.excess)
    functions["side"] = function_of("side", [images], [kept])
    side.take_along(parts[:2])
    side.d, side.rise, side.ts = parts[2], parts[3], parts[4]
    side.take_angle(angle)
    functions["edge"] = function_of("edge", [matrix, parts, angle], [_edge(side, matrix)])
    own = _Side(ca.vertcat(_image(twist, matrix, ends[:2]), _image(twist, matrix, ends[2:])))
    # One over how a patch's area grows in the velocity plane.
    scale = 1 / (TWIST.of(twist).omega ** 2 * ca.det(_square(matrix)))
    functions["lean"] = function_of(
        "lean", [twist, matrix, images, lean], [_leaning_edge(_Side(images), twist, matrix, lean)]
    )
    functions["line"] = function_of("line", [matrix, images], [_line(_Side(images), matrix)])
    # The wrench of a unit of load at a point.
    w = _velocity(twist, matrix, place)
    force = _square(matrix).T @ (w / _length(w))
    wrench = ca.vertcat(force, ca.dot(_left(place), force))
    for name, given, sums in (
        ("edge", [ends], scale * _edge(own, matrix)[:3]),
        ("lean", [ends, lean], scale * _leaning_edge(own, twist, matrix, lean)[:3]),
        ("line", [ends], _line(own, matrix)[:3]),
        ("point", [place], wrench),
        ("pressed_image", [pressure], _about_rotation(twist, matrix, pressure)),
    ):
        moved = ca.jtimes(sums, matrix, toward)
        functions[f"{name}_toward"] = function_of(
            f"{name}_toward", [twist, matrix, *given, toward], [moved]
        )
    functions["pressed_image"] = function_of(
        "pressed_image", [twist, matrix, pressure], [_about_rotation(twist, matrix, pressure)]
    )
    moved = _chord_toward(twist, matrix, chord, toward)
    functions["chord_toward"] = function_of("chord_toward", [twist, matrix, chord, toward], [moved])
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
    first, second = ends[:2], ends[2:]
    images = ca.vertcat(first, ca.norm_2(first), second, ca.norm_2(second))
    side = _pressed_side(_Side(images), image)
    given = ca.vertcat(ends, image)
    functions = {"pressed_side": function_of("pressed_side", [given], [side])}
    for name, place, sums in (
        ("pressed_side_toward", ends, side[:3]),
        ("pressed_cone_toward", cone, _pressed_cone(cone, image)),
    ):
        given = ca.vertcat(place, image)
        motion = ca.SX.sym("motion", given.numel())
        results = ca.vertcat(ca.jtimes(sums, given, motion), sums[1:])
        functions[name] = function_of(name, [ca.vertcat(given, motion)], [results])
    return functions


def function_of(name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> ca.Function:
    """Return a function of dense results whose common parts are computed once."""
    return ca.Function(name, inputs, ca.cse([ca.densify(output) for output in outputs]))


# What one piece of a pressure adds. Twists and M (by columns) come first; `sums` are D, the force
# and the Hessian by (vx, vy) of pieces whose torque follows from homogeneity, or the wrench and the
# Hessian's six entries of others. Vectors have two rows.


def _square(matrix: ca.SX) -> ca.SX:
    return ca.reshape(matrix, 2, 2)


def _left(vector: ca.SX) -> ca.SX:
    """A vector a right angle counter-clockwise of it; of a matrix, those of its columns."""
    return ca.vertcat(-vector[1, :], vector[0, :])


def _length(vector: ca.SX) -> ca.SX:
    return ca.sqrt(ca.sumsqr(vector) + TINIEST**2)


def _upper(matrix: ca.SX) -> ca.SX:
    """xx, xy, yy of a symmetric matrix."""
    return ca.vertcat(matrix[0, 0], matrix[0, 1], matrix[1, 1])


def _symmetric(xx: ca.SX, xy: ca.SX, yy: ca.SX) -> ca.SX:
    return ca.blockcat([[xx, xy], [xy, yy]])


def _velocity(twist: ca.SX, matrix: ca.SX, place: ca.SX) -> ca.SX:
    return _square(matrix) @ (twist[:2] + twist[2] * _left(place))


def _image(twist: ca.SX, matrix: ca.SX, place: ca.SX) -> ca.SX:
    w = _velocity(twist, matrix, place)
    return ca.vertcat(w, ca.norm_2(w))


def _centre_of_rotation(twist: ca.SX) -> ca.SX:
    return _left(twist[:2]) / twist[2]


class _Side:
    """A straight side in the velocity plane: w = d n + t tau, and its integrals that keep their
    digits from afar.
    """

    def __init__(self, images: ca.SX) -> None:
        first, second = images[:2], images[3:5]
        self.s0, self.s1 = s0, s1 = images[2], images[5]
        along = second - first
        self.size = size = ca.norm_2(along)
        self.take_along(along * (1 / size))
        self.d = d = ca.dot(first, self.n)
        self.start, self.end = ca.dot(first, self.t), ca.dot(second, self.t)
        total, between = s0 + s1, self.start + self.end
        # s0 + start and s1 - end, whose sum is total - size: neither cancels where the origin is
        # beside the side.
        before, after = ca.fabs(self.start), ca.fabs(self.end)
        nearer, farther = s0 + before + TINY, s1 + after + TINY
        spare = (self.start + before) + (after - self.end)
        spare = d * d * (nearer + farther) + spare * nearer * farther
        # Integrals of 1/s, t/s and s along the side, s = sqrt(d^2 + t^2).
        self.excess = 2 * size * nearer * farther / (spare + TINIEST)
        self.rise = size * between / total
        self.ts = (size * total + self.rise * between) / 2
        self.take_angle(ca.log1p(self.excess))

    def take_along(self, t: ca.SX) -> None:
        """Take the side's direction."""
        self.t, self.n = t, -_left(t)

    def take_angle(self, angle: ca.SX) -> None:
        """Take the logarithm log1p(excess), on which the rest depends."""
        self.angle, square = angle, self.d * self.d * angle
        self.length, self.moment = (self.ts + square) / 2, (self.ts - square) / 2

    def across(self, along: ca.SX, mixed: ca.SX, across: ca.SX) -> ca.SX:
        """Return the matrix along t t^T + mixed (n t^T + t n^T) + across n n^T."""
        axes = ca.horzcat(self.n, self.t)
        return axes @ _symmetric(across, mixed, along) @ axes.T


def _homogeneous(matrix: ca.SX, speed: ca.SX, force: ca.SX, curve: ca.SX) -> ca.SX:
    """D, the force and the Hessian by v, from integrals in the velocity plane."""
    m = _square(matrix)
    return ca.vertcat(speed, m.T @ force, _upper(m.T @ curve @ m))


def _edge(side: _Side, matrix: ca.SX) -> ca.SX:
    """What one side adds to an even patch, times the image's area over the patch's, by the
    divergence theorem:

    int |w| = 1/3 rim |w| (w.n), int grad |w| = rim |w| n, int hess |w| = rim (w/|w|) n^T.
    """
    # The rim's (w/|w|) n^T is symmetric as a whole; what is mixed is shared.
    curve = side.across(0, side.rise / 2, side.d * side.angle)
    return _homogeneous(matrix, side.length * side.d / 3, side.length * side.n, curve)


def _leaning_edge(side: _Side, twist: ca.SX, matrix: ca.SX, lean: ca.SX) -> ca.SX:
    """The same of a pressure g . (r - r0), `lean` being (g, r0), as c + s . w in the velocity
    plane:

    int w |w| = 1/4 rim w |w| (w.n), int w_i grad |w| = rim w_i |w| n - e_i int |w|, and alike for
    the Hessian.
    """
    # r = r_c + B^-1 w with B = omega M J; c is the pressure at the centre of rotation r_c.
    m, g = _square(matrix), lean[:2]
    s = _left(m @ g) / (twist[2] * ca.det(m))
    level = ca.dot(g, _centre_of_rotation(twist) - lean[2:])
    d, n, t, length, rise = side.d, side.n, side.t, side.length, side.rise
    cube = rise * (side.s0**2 + side.s0 * side.s1 + side.s1**2) / 3
    along = ca.dot(s, d * length * n + cube * t)
    speed = d * (level * length / 3 + along / 4)
    force = (level * length + along) * n - s * (d * length / 3)
    # rim (s.w) (w/|w|) n^T - int (w/|w|) s^T, symmetric as a whole.
    curve = side.across(side.moment, d * rise, d * d * side.angle)
    rim = level * (d * side.angle * n + rise * t) + curve @ s
    whole = rim @ n.T - length * n @ s.T
    return _homogeneous(matrix, speed, force, (whole + whole.T) / 2)


def _line(side: _Side, matrix: ca.SX) -> ca.SX:
    """What a load spread along one side adds: the means of |w|, w/|w| and hess |w| along it."""
    size = side.size
    sine = side.end / (side.s1 + TINY) - side.start / (side.s0 + TINY)
    cosine = side.d / (side.s1 + TINY) - side.d / (side.s0 + TINY)
    curve = side.across(sine / size, cosine / size, (side.angle - sine) / size)
    force = (side.d * side.angle * side.n + side.rise * side.t) / size
    return _homogeneous(matrix, side.length / size, force, curve)


def _parts_of(quadratic: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Level, slope and matrix of a quadratic."""
    q = QUADRATIC.of(quadratic)
    return q.level, ca.vertcat(q.slope_x, q.slope_y), _symmetric(q.xx, q.xy, q.yy)


def _about_rotation(twist: ca.SX, matrix: ca.SX, pressure: ca.SX) -> ca.SX:
    """Return a quadratic of places as one of w, over how areas grow: (QUADRATIC.size, 1).

    r = r_c + B^-1 w with B = omega M J, r_c the centre of rotation.
    """
    (level, slope, bent), m, centre = (
        _parts_of(pressure),
        _square(matrix),
        _centre_of_rotation(twist),
    )
    shrinks = 1 / (twist[2] * ca.det(m))
    back = shrinks * _left(m).T
    level += ca.dot(centre, slope + bent @ centre)
    slope = back.T @ (slope + 2 * bent @ centre)
    return ca.vertcat(level, slope, _upper(back.T @ bent @ back)) * (shrinks / twist[2])


def _pressed_side(side: _Side, quadratic: ca.SX) -> ca.SX:
    """What one side of the contact adds under a quadratic of w, in the velocity plane.

    The contact is cut into cones from the centre of rotation, where w = 0: F homogeneous of degree
    k, int P F = rim (w x dw) F int_0^1 P(s w) s^(k+1) ds; along a side all that is in closed form.
    """
    (level, slope, bent), t, n = _parts_of(quadratic), side.t, side.n
    d, square = side.d, side.d * side.d
    # P's terms of degree 1 and 2 in w = d n + t tau, by powers of t.
    first = (d * ca.dot(slope, n), ca.dot(slope, t))
    along = bent @ t
    second = (square * ca.dot(n, bent @ n), 2 * d * ca.dot(along, n), ca.dot(along, t))

    def coned(degree: int) -> tuple[ca.SX, ca.SX, ca.SX]:
        a, b, c = 1.0 / (degree + 2), 1.0 / (degree + 3), 1.0 / (degree + 4)
        return level * a + first[0] * b + second[0] * c, first[1] * b + second[1] * c, second[2] * c

    s0, s1, t0, t1 = side.s0, side.s1, side.start, side.end
    cube = side.rise * (s0 * s0 + s0 * s1 + s1 * s1) * (1 / 3)
    # Integrals of t^k s, t^k / s and t^k / s^3 along the side.
    fourth = (t1 * s1**3 - t0 * s0**3) / 4 - square * side.length / 4
    over = (side.angle, side.rise, side.moment, cube - square * side.rise)
    sine = t1 / (s1 + TINY) - t0 / (s0 + TINY)
    steep = side.rise / (s0 * s1 + TINY)
    rest = side.angle - sine
    thrice = (steep, rest, side.rise - square * steep, side.moment - square * rest)
    a, b, c = coned(1)
    speed = a * side.length + b * cube + c * fourth
    a, b, c = coned(0)
    even = a * over[0] + b * over[1] + c * over[2]
    odd = a * over[1] + b * over[2] + c * over[3]
    a, b, c = coned(-1)
    # d^2 of the integral of 1 / s^3 is sine.
    curve = side.across(
        a * sine + square * (b * thrice[0] + c * thrice[1]),
        -d * (a * thrice[0] + b * thrice[1] + c * thrice[2]),
        a * thrice[1] + b * thrice[2] + c * thrice[3],
    )
    return d * ca.vertcat(speed, d * even * n + odd * t, _upper(curve))


def _pressed_cone(cone: ca.SX, quadratic: ca.SX) -> ca.SX:
    """D and force, in the velocity plane, of one thin cone from the centre of rotation to a place
    w on the rim; `cone`: it, and w x dw.
    """
    (level, slope, bent), w, cross = _parts_of(quadratic), cone[:2], cone[2]
    first, second, size = ca.dot(slope, w), ca.dot(w, bent @ w), _length(w)
    force = cross * (level / 2 + first / 3 + second / 4) / size
    return ca.vertcat(cross * (level / 3 + first / 4 + second / 5) * size, force * w)


def _assembled(twist: ca.SX) -> ca.Function:
    """(twist, sums) -> friction, by homogeneity: D = V . grad D, hess D . V = 0."""
    sums, v, omega = ca.SX.sym("sums", 6), twist[:2], twist[2]
    force, cross = sums[1:3], -_symmetric(*ca.vertsplit(sums[3:])) @ v / omega
    wrench = ca.vertcat(force, (sums[0] - v[0] * force[0] - v[1] * force[1]) / omega)
    friction = ca.vertcat(wrench, sums[3:], cross, -ca.dot(cross, v) / omega)
    return function_of("assembled", [twist, sums], [friction])


def _chord_toward(twist: ca.SX, matrix: ca.SX, given: ca.SX, toward: ca.SX) -> ca.SX:
    """What a chord through the centre of rotation adds to an elliptic patch's wrench as M moves.

    Through M itself, and through how u, the chord's one direction, turns along it. Given: u, the
    chord's middle m and its direction e (places: m + tau e, |tau| <= q), and for a pressure f0 +
    tau f1 the moments of (1, tau) for u and of (1, tau, tau^2) for the curvature across it.
    """
    u, middle, along = given[:2], given[2:4], given[4:6]
    first, second, k0, k1, k2 = ca.vertsplit(given[6:])
    force, bent = _square(toward).T @ u, _square(matrix).T @ _left(u)
    turn = ca.dot(_left(u), _velocity(twist, toward, middle))
    further = ca.dot(_left(u), _square(toward) @ (twist[2] * _left(along)))
    even, odd = k0 * turn + k1 * further, k1 * turn + k2 * further
    pull = force * first + bent * even
    rest = ca.dot(_left(along), force * second + bent * odd)
    return ca.vertcat(pull, ca.dot(_left(middle), pull) + rest)


def contacts() -> dict[str, ca.Function]:
    """Return the functions of a contact: begin, slopes of each kind and law, finish of each law."""
    functions = {f"finish_{law}": _finish(law) for law in LAWS}
    for kind, law in PAIRS:
        state, p = ca.SX.sym("state", STATE.size), ca.SX.sym("p", MOTION.size)
        z = ca.SX.sym("z", LAWS[law])
        given = MOTION.of(p)
        # Cosines and sines of the angles as C has them.
        direction = ca.vertcat(given.cos_direction, given.sin_direction)
        phi = ca.vertcat(given.cos_phi, given.sin_phi)
        begun = list(_begun(kind, law, state, p, direction, phi, z))
        functions[f"begin_{kind}_{law}"] = function_of(f"begin_{kind}_{law}", [state, p, z], begun)
        functions[f"slopes_{kind}_{law}"] = _slopes(kind, law, by_all=False)
        functions[f"all_slopes_{kind}_{law}"] = _slopes(kind, law, by_all=True)
    return functions


def _facing(angle: ca.SX) -> ca.SX:
    return ca.vertcat(ca.cos(angle), ca.sin(angle))


def _unknowns(z: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Spin and slip; none is zero."""
    spin, *slip = ca.vertsplit(z)
    return spin, slip.pop() if slip else ca.SX(0)


def _place(kind: str, coordinate: ca.SX, p: SimpleNamespace) -> tuple[ca.SX, ca.SX, ca.SX | float]:
    """Contact point, normal, and travel of the rod's centre per unit of coordinate."""
    g = KINDS[kind].of(p.geometry)
    if kind == "side":
        along = ca.vertcat(g.along_x, g.along_y)
        return ca.vertcat(g.x, g.y) + coordinate * along, -_left(along), 1.0
    if kind in ("ring", "wedge"):
        return ca.vertcat(g.x, g.y), _facing(g.first_normal if kind == "wedge" else 0), 1.0
    circle = _facing(coordinate)
    if kind == "corner":
        return ca.vertcat(g.x, g.y), circle, p.radius
    a, b = g.semi_x, g.semi_y
    outward = ca.vertcat(b, a) * circle
    speed = ca.norm_2(outward)
    return ca.vertcat(a, b) * circle, outward / speed, speed + p.radius * a * b / speed**2


def _begun(
    kind: str, law: str, state: ca.SX, p: ca.SX, direction: ca.SX, phi: ca.SX, z: ca.SX
) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return twist, matrix and frame of a contact for a rod that travels by one; direction and phi
    as unit vectors.

    stick: the contact point moves with the rod; the spin is unknown. slide: it moves by -n + slip
    t, for a unit approach; spin and slip are unknown, and the true twist is that one times the
    approach -n.u, so that the equations stay well-conditioned up to the moment when the rod leaves.
    In ring and wedge the rod's centre stays where it is.
    """
    given, (theta, coordinate), (spin, slip) = MOTION.of(p), ca.vertsplit(state), _unknowns(z)
    point, normal, metric = _place(kind, coordinate, given)
    # Of the world's directions, as seen from the object.
    own = ca.horzcat(_facing(theta), _left(_facing(theta))).T
    ahead, axis = own @ direction, own @ phi
    approach, along = -ca.dot(normal, ahead), ca.dot(_left(normal), ahead)
    moves = slip * _left(normal) - normal if law == "slide" else ahead
    twist = ca.vertcat(moves - spin * _left(point), spin)
    axes = ca.horzcat(axis, _left(axis))
    matrix = ca.vec(ca.diag(ca.vertcat(given.mu_a, given.mu_b)) @ axes.T)
    force = axes @ ca.vertcat(given.m0, given.n0)
    torque = ca.dot(_left(ca.vertcat(given.centre_x, given.centre_y)), force)
    second = ca.SX.zeros(2)
    if kind == "wedge":
        second = _facing(KINDS[kind].of(given.geometry).second_normal)
    room = (coordinate - given.low, given.high - coordinate)
    frame = ca.vertcat(force, torque, point, normal, approach, along, metric, *room, second)
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
    at, given, force, smu = FRAME.of(frame), MOTION.of(p), g[:2], MOTION.of(p).smu
    point, normal = ca.vertcat(at.x, at.y), ca.vertcat(at.cosine, at.sine)
    torque = g[2] - ca.dot(_left(point), force)
    compression, tangential = -ca.dot(normal, force), ca.dot(_left(normal), force)
    if law == "slide":
        return ca.vertcat(torque, tangential - smu * compression), compression, tangential
    if law == "turn":
        return torque + smu * ca.norm_2(force), compression, tangential
    if law == "wedge":
        sense = KINDS[law].of(given.geometry).sense
        first, second = ca.vertsplit(ca.inv(_edges(frame, p)) @ force)
        return torque + given.radius * smu * (first + sense * second), first, second
    return torque, compression, tangential


def _edges(frame: ca.SX, p: ca.SX) -> ca.SX:
    """The edges of both cones between which the force in a wedge lies, as columns."""
    at, given = FRAME.of(frame), MOTION.of(p)
    first = ca.vertcat(at.cosine, at.sine)
    second = ca.vertcat(at.second_cosine, at.second_sine)
    other = given.smu * KINDS["wedge"].of(given.geometry).sense
    return ca.horzcat(given.smu * _left(first) - first, other * _left(second) - second)


def _wedge_margins(frame: ca.SX, p: ca.SX, first: ca.SX, second: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Margins of both contacts: their compressions; but a point's edges may be over half a turn
    apart.

    Then the force is between them unless it is in what is left of the turn, where both are
    positive; it comes there by the edge of that contact which stays.
    """
    det = ca.det(_edges(frame, p))
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
    # By the angles themselves: they are varied.
    direction, phi = _facing(motion.direction), _facing(motion.phi)
    twist, _, frame = _begun(kind, law, state, p, direction, phi, z)
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
