"""The equations of one contact as CasADi functions: a rod on a side, corner or ellipse, in the ring or in a wedge.

It begins with the twist that its unknowns mean, and ends with what they become by Newton's method; between them C adds
up the friction (equations.py), G with its Hessian H. Lengths and friction are normalised as there.
"""

import casadi as ca

from cyclemap.mechanics.engine.equations import function_of

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


def contacts() -> dict[str, ca.Function]:
    """Return the functions of a contact: begin and slopes of each kind and law, finish of each law."""
    found = {f"finish_{law}": _finish(law) for law in LAWS}
    for kind, law in pairs():
        state, p, z = ca.SX.sym("state", 2), ca.SX.sym("p", len(PARAMETERS)), ca.SX.sym("z", unknowns(law))
        begun = list(_begun(kind, law, state, p, p[17:], z))
        found[f"begin_{kind}_{law}"] = function_of(f"begin_{kind}_{law}", [state, p, z], begun)
        found[f"slopes_{kind}_{law}"] = _slopes(kind, law, 3)
        found[f"all_slopes_{kind}_{law}"] = _slopes(kind, law, 2 + len(VARIED) + len(SHARES))
    return found


def pairs() -> list[tuple[str, str]]:
    """Return the kinds of contact with the laws that they may be under."""
    outline = [(kind, law) for kind in KINDS[:3] for law in LAWS[:2]]
    return [*outline, ("ring", "stick"), ("ring", "turn"), ("wedge", "wedge")]


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


def unknowns(law: str) -> int:
    """Return how many unknowns a contact has: its spin, and where it slides its slip."""
    return 2 if law == "slide" else 1


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

    row: slope (2), margins (5: approach, room after low and before high, two of the law), corrected unknowns (2).
    report: the correction (maximum norm), the residual, the two forces.
    """
    count = unknowns(law)
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
    row = ca.vertcat(theta_rate, rate, *ends, *margins, corrected, *(0,) * (2 - count))
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
    count, name = unknowns(law), f"{'all_' if columns > 3 else ''}slopes_{kind}_{law}"
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
