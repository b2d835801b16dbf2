"""The equations of friction and of one contact as CasADi functions.

Friction is that of one edge, line, chord or point of a pressure; a contact that of a rod on a side, corner or ellipse,
in the ring or in a wedge: it begins with the twist that its unknowns mean, and ends with what they become by Newton's
method; between them C adds up the friction, G with its Hessian H.

What ellipses and points add to the friction itself is summed in pressure.c and ellipse.c, several places at once.

A slider that moves with the twist V = (vx, vy, omega) of its own frame dissipates, per unit load, the mean of |w| over
its pressure, w(r) = M (v + omega z x r), besides the constant force of the friction ellipse's centre (m0, n0) at the
centre of pressure; M has the half axes mu_a, mu_b at the angle alpha = phi - theta. G = grad D balances the contact
force (Goyal, Ruina & Papadopoulos 1991), H is the Hessian of D. C loops over what a pressure is made of and adds up.

Lengths are in extents of the footprint, friction coefficients in units of sqrt(mu_a mu_b): nothing depends on scales.
"""

import casadi as ca

# Keep quotients and logarithms finite where the centre of rotation lies on a side, or at a point.
TINY, TINIEST = 1e-60, 1e-150


def kernels() -> dict[str, ca.Function]:
    """Return the functions of one piece of pressure, and how those along a motion of M are called: name_toward.

    Sides come as the images of their ends in the velocity plane with their distances from the origin, which neighbours
    share; for the motion of M, as their ends.
    """
    twist, matrix, toward = ca.SX.sym("twist", 3), ca.SX.sym("matrix", 4), ca.SX.sym("toward", 4)
    ends, images = ca.SX.sym("ends", 4), ca.SX.sym("images", 6)
    lean, place, chord = ca.SX.sym("lean", 4), ca.SX.sym("place", 2), ca.SX.sym("chord", 11)
    own = ca.vertcat(_image(twist, matrix, ends[:2]), _image(twist, matrix, ends[2:]))
    # One over how a patch's area grows in the velocity plane.
    scale = 1 / (twist[2] ** 2 * (matrix[0] * matrix[3] - matrix[1] * matrix[2]))
    found = {"assembled": _assembled(twist, matrix)}
    # Edges are summed in two passes, so that the slow steps of one do not wait for those of another.
    side, angle = _Side(images), ca.SX.sym("angle")
    kept = ca.vertcat(side.tx, side.ty, side.d, side.rise, side.ts, side.excess)
    found["side"] = function_of("side", [images], [kept])
    parts = ca.SX.sym("side", 6)
    side.tx, side.ty, side.d, side.rise, side.ts, _ = ca.vertsplit(parts)
    side.nx, side.ny = side.ty, -side.tx
    side.set_angle(angle)
    found["edge"] = function_of("edge", [matrix, parts, angle], [ca.vertcat(*_edge(side, twist, matrix))])
    for name, sums_of, more in (("edge", _edge, ()), ("lean", _leaning_edge, (lean,)), ("line", _line, ())):
        whole = ca.vertcat(*sums_of(_Side(own), twist, matrix, *more)[:3]) * (1 if name == "line" else scale)
        if name != "edge":
            sums = ca.vertcat(*sums_of(_Side(images), twist, matrix, *more))
            found[name] = function_of(name, [twist, matrix, images, *more], [sums])
        moved = ca.jtimes(whole, matrix, toward)
        found[f"{name}_toward"] = function_of(f"{name}_toward", [twist, matrix, ends, *more, toward], [moved])
    # The wrench of a unit of load at a point.
    wx, wy = _velocity(twist, matrix, place[0], place[1])
    inverse = 1 / ca.sqrt(wx * wx + wy * wy + TINIEST**2)
    fx, fy = _transposed(matrix, wx * inverse, wy * inverse)
    moved = ca.jtimes(ca.vertcat(fx, fy, place[0] * fy - place[1] * fx), matrix, toward)
    found["point_toward"] = function_of("point_toward", [twist, matrix, place, toward], [moved])
    moved = ca.vertcat(*_chord_toward(twist, matrix, chord, toward))
    found["chord_toward"] = function_of("chord_toward", [twist, matrix, chord, toward], [moved])
    found["corner"] = function_of("corner", [twist, matrix, place], [_image(twist, matrix, place)])
    return found


def function_of(name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> ca.Function:
    """Return a function of dense results whose common parts are computed once."""
    return ca.Function(name, inputs, ca.cse([ca.densify(output) for output in outputs]))


# What one piece of a pressure adds. Twists and M (by columns) come first; `sums` are D, the force and the Hessian by
# (vx, vy) of pieces whose torque follows from homogeneity, or the wrench and the Hessian's six entries of others.


def _velocity(twist: ca.SX, matrix: ca.SX, x: ca.SX, y: ca.SX) -> tuple[ca.SX, ca.SX]:
    vx, vy = twist[0] - twist[2] * y, twist[1] + twist[2] * x
    return matrix[0] * vx + matrix[2] * vy, matrix[1] * vx + matrix[3] * vy


def _transposed(matrix: ca.SX, x: ca.SX, y: ca.SX) -> tuple[ca.SX, ca.SX]:
    return matrix[0] * x + matrix[1] * y, matrix[2] * x + matrix[3] * y


def _image(twist: ca.SX, matrix: ca.SX, place: ca.SX) -> ca.SX:
    x, y = _velocity(twist, matrix, place[0], place[1])
    return ca.vertcat(x, y, ca.sqrt(x * x + y * y))


class _Side:
    """A straight side in the velocity plane: w = d n + t tau, and its integrals that keep their digits from afar."""

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
        # s0 + start and s1 - end, whose sum is total - size: neither cancels where the origin is beside the side.
        before, after = ca.fabs(self.start), ca.fabs(self.end)
        first, second = s0 + before + TINY, s1 + after + TINY
        spare = d * d * (first + second) + ((self.start + before) + (after - self.end)) * first * second
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


def _homogeneous(matrix: ca.SX, speed: ca.SX, fx: ca.SX, fy: ca.SX, curve: tuple[ca.SX, ca.SX, ca.SX]) -> list[ca.SX]:
    """D, the force and the Hessian by v, from integrals in the velocity plane."""
    hx, hy = _transposed(matrix, curve[0], curve[1]), _transposed(matrix, curve[1], curve[2])
    return [
        *(speed, *_transposed(matrix, fx, fy)),
        *(matrix[0] * hx[0] + matrix[1] * hy[0], matrix[2] * hx[0] + matrix[3] * hy[0]),
        matrix[2] * hx[1] + matrix[3] * hy[1],
    ]


def _edge(side: _Side, twist: ca.SX, matrix: ca.SX) -> list[ca.SX]:
    """What one side adds to an even patch, times the image's area over the patch's, by the divergence theorem:

    int |w| = 1/3 rim |w| (w.n), int grad |w| = rim |w| n, int hess |w| = rim (w/|w|) n^T.
    """
    # The rim's (w/|w|) n^T is symmetric as a whole; what is mixed is shared.
    curve = side.across(0, side.rise / 2, side.d * side.angle)
    force = side.length
    return _homogeneous(matrix, force * side.d / 3, force * side.nx, force * side.ny, curve)


def _leaning_edge(side: _Side, twist: ca.SX, matrix: ca.SX, lean: ca.SX) -> list[ca.SX]:
    """The same of a pressure g . (r - r0), `lean` being (g, r0), as c + s . w in the velocity plane:

    int w |w| = 1/4 rim w |w| (w.n), int w_i grad |w| = rim w_i |w| n - e_i int |w|, and alike for the Hessian.
    """
    # r = r_c + B^-1 w with B = omega M J; c is the pressure at the centre of rotation r_c.
    det = twist[2] * (matrix[0] * matrix[3] - matrix[1] * matrix[2])
    gx, gy = lean[0], lean[1]
    sx, sy = -(matrix[1] * gx + matrix[3] * gy) / det, (matrix[0] * gx + matrix[2] * gy) / det
    level = gx * (-twist[1] / twist[2] - lean[2]) + gy * (twist[0] / twist[2] - lean[3])
    d, length, angle, rise = side.d, side.length, side.angle, side.rise
    cube = rise * (side.s0**2 + side.s0 * side.s1 + side.s1**2) / 3
    first_x, first_y = d * length * side.nx + cube * side.tx, d * length * side.ny + cube * side.ty
    along = sx * first_x + sy * first_y
    even = d * length / 3
    speed = d * (level * length / 3 + along / 4)
    fx, fy = (level * length + along) * side.nx - sx * even, (level * length + along) * side.ny - sy * even
    # rim (s.w) (w/|w|) n^T - int (w/|w|) s^T, symmetric as a whole.
    second = side.across(side.moment, d * rise, d * d * angle)
    px, py = second[0] * sx + second[1] * sy, second[1] * sx + second[2] * sy
    ux, uy = d * angle * side.nx + rise * side.tx, d * angle * side.ny + rise * side.ty
    px, py, lx, ly = level * ux + px, level * uy + py, length * side.nx, length * side.ny
    mixed = (px * side.ny + py * side.nx - lx * sy - ly * sx) / 2
    return _homogeneous(matrix, speed, fx, fy, (px * side.nx - lx * sx, mixed, py * side.ny - ly * sy))


def _line(side: _Side, twist: ca.SX, matrix: ca.SX) -> list[ca.SX]:
    """What a load spread along one side adds: the means of |w|, w/|w| and hess |w| along it."""
    sine = side.end / (side.s1 + TINY) - side.start / (side.s0 + TINY)
    cosine = side.d / (side.s1 + TINY) - side.d / (side.s0 + TINY)
    curve = side.across(sine / side.size, cosine / side.size, (side.angle - sine) / side.size)
    fx = (side.d * side.angle * side.nx + side.rise * side.tx) / side.size
    fy = (side.d * side.angle * side.ny + side.rise * side.ty) / side.size
    return _homogeneous(matrix, side.length / side.size, fx, fy, curve)


def _assembled(twist: ca.SX, matrix: ca.SX) -> ca.Function:
    """(twist, matrix, sums) -> wrench and Hessian, by homogeneity: D = V . grad D, hess D . V = 0."""
    sums = ca.SX.sym("sums", 6)
    vx, vy, omega = twist[0], twist[1], twist[2]
    cross_x, cross_y = -(sums[3] * vx + sums[4] * vy) / omega, -(sums[4] * vx + sums[5] * vy) / omega
    wrench = [sums[1], sums[2], (sums[0] - vx * sums[1] - vy * sums[2]) / omega]
    hessian = [sums[3], sums[4], sums[5], cross_x, cross_y, -(cross_x * vx + cross_y * vy) / omega]
    return function_of("assembled", [twist, matrix, sums], [ca.vertcat(*wrench, *hessian)])


def _chord_toward(twist: ca.SX, matrix: ca.SX, given: ca.SX, toward: ca.SX) -> list[ca.SX]:
    """What a chord through the centre of rotation adds to an elliptic patch's wrench as M moves.

    Through M itself, and through how u, the chord's one direction, turns along it. Given: u, the chord's middle m and
    its direction e (places: m + tau e, |tau| <= q), and for a pressure f0 + tau f1 the moments of (1, tau) for u and of
    (1, tau, tau^2) for the curvature across it.
    """
    ux, uy, mx, my, ex, ey = (given[i] for i in range(6))
    fx, fy = _transposed(toward, ux, uy)
    bx, by = _transposed(matrix, -uy, ux)
    wx, wy = _velocity(twist, toward, mx, my)
    turn = ux * wy - uy * wx
    sx, sy = -twist[2] * ey, twist[2] * ex
    further = ux * (toward[1] * sx + toward[3] * sy) - uy * (toward[0] * sx + toward[2] * sy)
    k0, k1, k2 = given[8], given[9], given[10]
    even, odd = k0 * turn + k1 * further, k1 * turn + k2 * further
    middle, along = mx * by - my * bx, ex * by - ey * bx
    torque = (mx * fy - my * fx) * given[6] + (ex * fy - ey * fx) * given[7]
    return [fx * given[6] + bx * even, fy * given[6] + by * even, torque + middle * even + along * odd]


# Parameters of a motion. smu: friction of the rod, negative where it slides clockwise over the slider; in the ring the
# radius of the friction circle, negative where the object turns clockwise. geometry: side (x, y, tx, ty),
# corner and ring (x, y), ellipse (semi_x, semi_y), wedge (x, y of the rod's centre, angles
# of both normals, sense of the second contact's friction: -1 for a point).
PARAMETERS = (
    *("direction", "radius", "smu", "mu_a", "mu_b", "m0", "n0", "phi", "centre_x", "centre_y"),
    *("geometry_0", "geometry_1", "geometry_2", "geometry_3", "geometry_4", "low", "high"),
    *("cos_direction", "sin_direction", "cos_phi", "sin_phi"),
)
# Those by which a motion is differentiated, after its state (theta, coordinate); and the shares of the pressure.
VARIED = ("direction", "radius", "smu", "mu_a", "mu_b", "m0", "n0", "phi", "geometry_0", "geometry_1")
SHARES = ("inner", "rim", "corner")
KINDS = ("side", "corner", "ellipse", "ring", "wedge")
LAWS = ("stick", "slide", "turn", "wedge")
# Kinds of contact with the laws that they may be under; and how many unknowns a law has: its spin, and if it slides the
# slip.
PAIRS = (
    *(("side", "stick"), ("side", "slide"), ("corner", "stick"), ("corner", "slide"), ("ellipse", "stick")),
    *(("ellipse", "slide"), ("ring", "stick"), ("ring", "turn"), ("wedge", "wedge")),
)
UNKNOWNS = {"stick": 1, "slide": 2, "turn": 1, "wedge": 1}


def contacts() -> dict[str, ca.Function]:
    """Return the functions of a contact: begin and slopes of each kind and law, finish of each law."""
    found = {f"finish_{law}": _finish(law) for law in LAWS}
    for kind, law in PAIRS:
        state, p, z = ca.SX.sym("state", 2), ca.SX.sym("p", len(PARAMETERS)), ca.SX.sym("z", UNKNOWNS[law])
        begun = list(_begun(kind, law, state, p, p[17:], z))
        found[f"begin_{kind}_{law}"] = function_of(f"begin_{kind}_{law}", [state, p, z], begun)
        found[f"slopes_{kind}_{law}"] = _slopes(kind, law, 3)
        found[f"all_slopes_{kind}_{law}"] = _slopes(kind, law, 2 + len(VARIED) + len(SHARES))
    return found


def _place(kind: str, coordinate: ca.SX, g: ca.SX, radius: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX, ca.SX]:
    """Contact point, normal, and travel of the rod's centre along its curve per unit of coordinate."""
    if kind == "side":
        return g[0] + coordinate * g[2], g[1] + coordinate * g[3], g[3], -g[2], ca.SX(1)
    if kind in ("ring", "wedge"):
        angle = g[2] if kind == "wedge" else 0
        return g[0], g[1], ca.cos(angle), ca.sin(angle), ca.SX(1)
    c, s = ca.cos(coordinate), ca.sin(coordinate)
    if kind == "corner":
        return g[0], g[1], c, s, radius
    speed = ca.sqrt((g[0] * s) ** 2 + (g[1] * c) ** 2)
    return g[0] * c, g[1] * s, g[1] * c / speed, g[0] * s / speed, speed + radius * g[0] * g[1] / speed**2


# What `begin` finds, besides twist and matrix: the constant wrench of the friction ellipse's centre, and the contact.
FRAME = (
    *("force_x", "force_y", "torque", "x", "y", "cosine", "sine"),
    *("approach", "along", "metric", "after_low", "before_high", "second_cosine", "second_sine"),
)


def _begun(kind: str, law: str, state: ca.SX, p: ca.SX, angles: ca.SX, z: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return twist, matrix and frame of a contact for a rod that travels by one; `angles`: cosines and sines in p.

    stick: the contact point moves with the rod; omega is unknown. slide: it moves by -n + tau t, for a unit approach;
    omega and tau are unknown, and the true twist is that one times the approach -n.u, so that the equations stay
    well-conditioned up to the moment when the rod leaves. In ring and wedge the rod's centre stays where it is.
    """
    x, y, c, s, metric = _place(kind, state[1], p[10:15], p[1])
    c0, s0 = ca.cos(state[0]), ca.sin(state[0])
    cd, sd, cp, sp = ca.vertsplit(angles)
    ahead, aside = cd * c0 + sd * s0, sd * c0 - cd * s0
    approach, along = -(c * ahead + s * aside), c * aside - s * ahead
    ux, uy = (-c - z[1] * s, -s + z[1] * c) if law == "slide" else (ahead, aside)
    twist = ca.vertcat(ux + z[0] * y, uy - z[0] * x, z[0])
    ca_, sa = cp * c0 + sp * s0, sp * c0 - cp * s0
    matrix = ca.vertcat(p[3] * ca_, -p[4] * sa, p[3] * sa, p[4] * ca_)
    fx, fy = ca_ * p[5] - sa * p[6], sa * p[5] + ca_ * p[6]
    second = (ca.cos(p[13]), ca.sin(p[13])) if kind == "wedge" else (0, 0)
    room = (state[1] - p[15], p[16] - state[1])
    frame = ca.vertcat(fx, fy, p[8] * fy - p[9] * fx, x, y, c, s, approach, along, metric, *room, *second)
    return twist, matrix, frame


def _residual(law: str, frame: ca.SX, p: ca.SX, g: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return residuals, and the two forces that bound the law: compression and tangential force, or both compressions.

    stick: no torque about the contact. slide: none, and no force across the cone's edge -n + smu t. turn: the ring's
    friction makes a torque of smu |F| (the friction circle of a journal bearing; Mason 2001). wedge: two contacts that
    slide about the rod, each on its cone's edge; their compressions N balance the force, r smu (N1 + N2) the torque. A
    point's force lies between the outer edges of both cones.
    """
    x, y, c, s = frame[3], frame[4], frame[5], frame[6]
    torque = y * g[0] - x * g[1] + g[2]
    normal, tangential = -(c * g[0] + s * g[1]), c * g[1] - s * g[0]
    if law == "slide":
        return ca.vertcat(torque, tangential - p[2] * normal), normal, tangential
    if law == "turn":
        return torque + p[2] * ca.sqrt(g[0] ** 2 + g[1] ** 2), normal, tangential
    if law == "wedge":
        other = p[2] * p[14]
        d1, d2 = (-c - p[2] * s, -s + p[2] * c), (-frame[12] - other * frame[13], -frame[13] + other * frame[12])
        det = d1[0] * d2[1] - d1[1] * d2[0]
        first, second = (g[0] * d2[1] - g[1] * d2[0]) / det, (d1[0] * g[1] - d1[1] * g[0]) / det
        # Both cones of a point together may hold every force.
        first, second = (ca.if_else(ca.logic_and(p[14] < 0, det >= 0), 1, force) for force in (first, second))
        return torque + p[1] * (p[2] * first + other * second), first, second
    return torque, normal, tangential


def _rate(law: str, frame: ca.SX, p: ca.SX, z: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return the state's rates by the rod's travel, and the slip of the rod over the slider."""
    approach, along, metric = frame[7], frame[8], frame[9]
    if law == "slide":
        slip = along - approach * z[1]
        return approach * z[0], (slip - approach * z[0] * p[1]) / metric, slip
    return z[0], -z[0] * p[1] / metric if law == "stick" else ca.SX(0), ca.SX(0)


def _finish(law: str) -> ca.Function:
    """(frame, parameters, unknowns, wrench and Hessian 9) -> row, report.

    row: slope (2), margins (6: approach, room after low and before high, two of the law, one of points that rest),
    corrected unknowns (2).
    report: the correction (maximum norm), the residual, the two forces.
    """
    count = UNKNOWNS[law]
    frame, p, z = ca.SX.sym("frame", len(FRAME)), ca.SX.sym("p", len(PARAMETERS)), ca.SX.sym("z", count)
    given, g = ca.SX.sym("given", 9), ca.SX.sym("g", 3)
    residual, first, second = _residual(law, frame, p, g)
    # Derivative of the twist by the unknowns.
    toward = ca.vertcat(frame[4], -frame[3], 1)
    if law == "slide":
        toward = ca.horzcat(toward, ca.vertcat(-frame[6], frame[5], 0))
    by_unknowns = ca.jacobian(residual, g) @ _hessian(given) @ toward
    step = -_solved(by_unknowns, residual)
    total = given[:3] + frame[:3]
    residual, step, first, second = (ca.substitute(value, g, total) for value in (residual, step, first, second))
    corrected = z + step
    theta_rate, rate, slip = _rate(law, frame, p, corrected)
    margins = {
        "stick": (p[2] * first - second, p[2] * first + second),
        "slide": (ca.sign(p[2]) * slip, 1),
        "turn": (1, 1),
        "wedge": (first, second),
    }[law]
    ends = (1, 1, 1) if law in ("turn", "wedge") else (frame[7], frame[10], frame[11])
    # The margin of a support point that rests is not told here.
    row = ca.vertcat(theta_rate, rate, *ends, *margins, 1, corrected, *(0,) * (2 - count))
    size = residual if count == 1 else ca.sqrt(residual[0] ** 2 + residual[1] ** 2)
    report = ca.vertcat(ca.mmax(ca.fabs(step)), size, first, second)
    return function_of(f"finish_{law}", [frame, p, z, given], [row, report])


def _hessian(given: ca.SX) -> ca.SX:
    xx, xy, yy, xo, yo, oo = (given[i] for i in range(3, 9))
    return ca.blockcat([[xx, xy, xo], [xy, yy, yo], [xo, yo, oo]])


def _slopes(kind: str, law: str, columns: int) -> ca.Function:
    """(state, parameters, unknowns, wrench and Hessian 9, by law 9, by shares 9) -> derivatives, by columns.

    By the implicit function theorem: of the rates (2, columns) by the state, VARIED and SHARES, of the unknowns by the
    state, and what a Newton iteration corrects of these. `by law`: of the wrench by mu_a, mu_b, alpha, by columns.
    """
    count, name = UNKNOWNS[law], f"{'all_' if columns > 3 else ''}slopes_{kind}_{law}"
    state, p, z = ca.SX.sym("state", 2), ca.SX.sym("p", len(PARAMETERS)), ca.SX.sym("z", count)
    given, by_law, by_shares = ca.SX.sym("given", 9), ca.SX.sym("by_law", 9), ca.SX.sym("by_shares", 9)
    g = ca.SX.sym("g", 3)
    # Of the angles themselves: they are varied.
    angles = ca.vertcat(ca.cos(p[0]), ca.sin(p[0]), ca.cos(p[7]), ca.sin(p[7]))
    twist, _, frame = _begun(kind, law, state, p, angles, z)
    varied = ca.vertcat(state, *(p[PARAMETERS.index(name)] for name in VARIED))[: min(columns, 2 + len(VARIED))]
    residual = _residual(law, frame, p, g)[0]
    by_g, total = ca.jacobian(residual, g), given[:3] + frame[:3]
    moving = ca.vertcat(p[3], p[4], p[7] - state[0])
    by_varied = ca.jacobian(residual, varied) + by_g @ (
        ca.jacobian(frame[:3], varied)
        + _hessian(given) @ ca.jacobian(twist, varied)
        + ca.reshape(by_law, 3, 3) @ ca.jacobian(moving, varied)
    )
    if columns > 3:
        by_varied = ca.horzcat(by_varied, by_g @ ca.reshape(by_shares, 3, 3))
    by_unknowns = by_g @ _hessian(given) @ ca.jacobian(twist, z)
    tangent = -_solved(by_unknowns, by_varied)
    rates = ca.vertcat(*_rate(law, frame, p, z)[:2])
    explicit = ca.horzcat(ca.jacobian(rates, varied), ca.SX.zeros(2, columns - varied.numel()))
    whole = explicit + ca.jacobian(rates, z) @ tangent
    correction = ca.mmax(ca.fabs(_solved(by_unknowns, residual)))
    outputs = [ca.substitute(value, g, total) for value in (ca.vec(whole), ca.vec(tangent[:, :2]), correction)]
    return function_of(name, [state, p, z, given, by_law, by_shares], outputs)


def _solved(matrix: ca.SX, right: ca.SX) -> ca.SX:
    """Return matrix^-1 right for a matrix of one or two rows, in scalars."""
    if matrix.shape[0] == 1:
        return right / matrix
    a, c, b, d = matrix[0, 0], matrix[1, 0], matrix[0, 1], matrix[1, 1]
    return ca.blockcat([[d, -b], [-c, a]]) @ right / (a * d - b * c)
