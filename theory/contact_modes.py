"""Sticking and sliding twist of a pushed object: stationarity for any friction, closed form for an
ellipsoid.

D(V) is the dissipation of the twist V = (v_x, v_y, omega) of the frame's origin, convex and
homogeneous of degree one; the object moves under the wrench grad D. The contact is at (x, y) with
outward normal n at the angle nu, t = z x n; J takes a twist to the contact's velocity. A rod that
sticks moves the contact with its own velocity u; one that slides presses along d = -n + smu t, on
the edge of its friction cone. Functions named `..._residual` vanish identically.
"""

import sympy as sp

#: Contact point, m.
X, Y = sp.symbols("x y", real=True)
#: Rod's velocity, m/s.
U_X, U_Y = sp.symbols("u_x u_y", real=True)
#: Angle of the outward normal, rad, and signed coefficient of friction of the rod.
NU, SMU = sp.symbols("nu smu", real=True)
#: Twist: m/s, m/s, rad/s.
V_X, V_Y, OMEGA = sp.symbols("v_x v_y omega", real=True)
#: Inverse factor of the ellipsoid's matrix: A = (C C^T)^-1, any positive definite matrix.
C = sp.Matrix(3, 3, lambda i, j: sp.Symbol(f"c_{i}{j}", real=True) if j <= i else sp.Integer(0))

ROD = sp.Matrix([U_X, U_Y])
TWIST = sp.Matrix([V_X, V_Y, OMEGA])


def contact_jacobian() -> sp.Matrix:
    """Return J, (2, 3): the contact's velocity is J V, and a force f at the contact is the wrench
    J^T f.
    """
    return sp.Matrix([[1, 0, -Y], [0, 1, X]])


def spin() -> sp.Matrix:
    """Return the twist that leaves the contact at rest and turns with unit rate, (y, -x, 1)."""
    return sp.Matrix([Y, -X, 1])


def normal() -> sp.Matrix:
    """Return n, the outward normal."""
    return sp.Matrix([sp.cos(NU), sp.sin(NU)])


def tangent() -> sp.Matrix:
    """Return t = z x n."""
    return sp.Matrix([-sp.sin(NU), sp.cos(NU)])


def cone_edge(smu: sp.Expr = SMU) -> sp.Matrix:
    """Return d = -n + smu t."""
    return -normal() + smu * tangent()


def _cross(a: sp.Matrix, b: sp.Matrix) -> sp.Expr:
    return a[0] * b[1] - a[1] * b[0]


def sticking_residual() -> sp.Expr:
    """dD/domega at a prescribed contact velocity less the torque of grad D about the contact, for
    any grad D.

    A spin that minimises D therefore asks for no torque about the contact: grad D is the wrench of
    a force there.
    """
    gradient = sp.Matrix(sp.symbols("D_x D_y D_omega", real=True))
    along = gradient.dot(sp.diff(sticking_family(OMEGA), OMEGA))
    return sp.simplify(along - (gradient[2] - (X * gradient[1] - Y * gradient[0])))


def sticking_family(omega: sp.Expr) -> sp.Matrix:
    """Return the twists that move the contact with the rod, (u - omega z x r, omega)."""
    return sp.Matrix([U_X, U_Y, 0]) + omega * spin()


def prescribed_velocity_residual() -> sp.Matrix:
    """J V less u on `sticking_family`."""
    return sp.simplify(contact_jacobian() * sticking_family(OMEGA) - ROD)


def force_at_contact_residual() -> sp.Matrix:
    """A wrench without torque about the contact, (f_x, f_y, x f_y - y f_x), less J^T f; and its
    product with spin().
    """
    f_x, f_y = sp.symbols("f_x f_y", real=True)
    wrench = contact_jacobian().T * sp.Matrix([f_x, f_y])
    difference = sp.Matrix([f_x, f_y, X * f_y - Y * f_x]) - wrench
    return sp.simplify(sp.Matrix([*difference, wrench.dot(spin())]))


def sliding_wrench() -> sp.Matrix:
    """Return W = J^T d, the wrench of a unit-normal force on the cone's edge."""
    return contact_jacobian().T * cone_edge()


def sliding_residual() -> sp.Matrix:
    """The two equations that annul multiples of W, applied to W: (spin, across) . W, across = (t +
    smu n, 0).

    grad D = lambda W is the stationarity of D on {W.V = const}. The rows are independent (their
    third and first two components differ), so that spin . grad D = 0 and across . grad D = 0 say
    the same without the multiplier.
    """
    across = sp.Matrix([*(tangent() + SMU * normal()), 0])
    return sp.simplify(sp.Matrix([spin().dot(sliding_wrench()), across.dot(sliding_wrench())]))


def multiplier_residual() -> sp.Expr:
    """Stationary D on {W.V = 1} less its multiplier: grad D = lambda W and Euler's V.grad D = D
    give D = lambda.
    """
    multiplier = sp.Symbol("lambda", positive=True)
    wrench = sp.Matrix(sp.symbols("w_x w_y w_t", real=True))
    power = (multiplier * wrench).dot(TWIST)
    return sp.simplify(power.subs(V_X, sp.solve(wrench.dot(TWIST) - 1, V_X)[0]) - multiplier)


def shared_direction() -> sp.Expr:
    """Return (v_x omega' - omega v_x') x + (v_y omega' - omega v_y') y + (v x v'): zero where two
    twists move alike.

    D curves along V' unless V' moves every support point along V's velocity there (`curvature` of
    `theory.traction_law`). The points that two different twists move alike lie on one line; support
    points that do not therefore leave D flat along V alone, and both minima, sticking and sliding,
    are unique.
    """
    other = sp.Matrix(sp.symbols("v_x' v_y' omega'", real=True))
    slope = [TWIST[i] * other[2] - OMEGA * other[i] for i in range(2)]
    return slope[0] * X + slope[1] * Y + TWIST[0] * other[1] - TWIST[1] * other[0]


def shared_direction_residual() -> sp.Expr:
    """`shared_direction` less the cross product of the velocities that both twists give a point."""
    other = sp.Matrix(sp.symbols("v_x' v_y' omega'", real=True))
    velocities = contact_jacobian() * TWIST, contact_jacobian() * other
    return sp.expand(shared_direction() - _cross(*velocities))


def ellipsoid_matrix() -> sp.Matrix:
    """Return A of an ellipsoidal limit surface, D = sqrt(V^T A V): the wrenches with W^T A^-1 W =
    1.
    """
    inverse = C.inv()
    return inverse.T * inverse


def mobility() -> sp.Matrix:
    """Return K = J A^-1 J^T = (J C)(J C)^T, (2, 2), positive definite: contact velocity per force
    at the contact.
    """
    reach = contact_jacobian() * C
    return reach * reach.T


def twist_of_force(force: sp.Matrix) -> sp.Matrix:
    """Return A^-1 J^T f: the twist, up to a positive factor, of an object pushed by a force at the
    contact.
    """
    return C * C.T * contact_jacobian().T * force


def sticking_force(k: sp.Matrix) -> sp.Matrix:
    """Return K^-1 u, which is D(V) times the contact force of the sticking rod."""
    return k.inv() * ROD


def sliding_force(k: sp.Matrix) -> sp.Matrix:
    """Return kappa d, kappa = (n.u)/(n.K d), which is D(V) times the contact force of the sliding
    rod.
    """
    return normal().dot(ROD) / normal().dot(k * cone_edge()) * cone_edge()


def sticking_twist() -> sp.Matrix:
    """Return V = A^-1 J^T K^-1 u (Lynch, Maekawa & Tanie 1992)."""
    return twist_of_force(sticking_force(mobility()))


def sliding_twist() -> sp.Matrix:
    """Return V = kappa A^-1 J^T d with kappa = (n.u)/(n.K d): pushed along the cone's edge,
    approaching as the rod.
    """
    return twist_of_force(sliding_force(mobility()))


def _any_force() -> sp.Matrix:
    return sp.Matrix(sp.symbols("f_x f_y", real=True))


def _any_mobility() -> sp.Matrix:
    return sp.Matrix(
        [[sp.Symbol("k_11"), sp.Symbol("k_12")], [sp.Symbol("k_12"), sp.Symbol("k_22")]]
    )


def twist_of_force_residual() -> sp.Matrix:
    """(J V - K f, A V - J^T f) at V = A^-1 J^T f, for any force f.

    A V = D grad D is the force's wrench, and K f = u makes the contact follow a sticking rod.
    """
    force = _any_force()
    twist = twist_of_force(force)
    follows = contact_jacobian() * twist - mobility() * force
    balance = ellipsoid_matrix() * twist - contact_jacobian().T * force
    return sp.Matrix([*follows, *balance]).applyfunc(sp.cancel)


def stationary_spin_residual() -> sp.Expr:
    """Derivative by omega of V^T A V/2 on `sticking_family`, at the omega of `sticking_twist`."""
    slope = spin().dot(ellipsoid_matrix() * sticking_family(OMEGA))
    return sp.cancel(sp.together(slope.subs(OMEGA, sticking_twist()[2])))


def approach_residual() -> sp.Expr:
    """n.(J V - u) at the sliding twist: the rod stays on the surface. J V = K f, by
    `twist_of_force_residual`.
    """
    k = _any_mobility()
    return sp.simplify(sp.together(normal().dot(k * sliding_force(k) - ROD)))


def continuity_residual() -> sp.Matrix:
    """Sticking less sliding force for a rod that moves along the motion cone's edge, u = kappa K d;
    for any K.

    Equal forces have equal twists: the motion is continuous from sticking to sliding.
    """
    kappa, k = sp.Symbol("kappa", positive=True), _any_mobility()
    edge = kappa * k * cone_edge()
    at_edge = {U_X: edge[0], U_Y: edge[1]}
    difference = (sticking_force(k) - sliding_force(k)).subs(at_edge, simultaneous=True)
    return difference.applyfunc(sp.simplify)


def cone_residual() -> sp.Expr:
    """(K d) x u less det K (d x K^-1 u), for any symmetric K and in axes along n and t (nu = 0).

    As det K > 0, the rod moves past the edge K d of the motion cone exactly where the force that
    sticking needs, along K^-1 u, lies past the edge d of the friction cone, and on the same side.
    """
    k, edge = _any_mobility(), cone_edge().subs(NU, 0)
    return sp.simplify(sp.expand(_cross(k * edge, ROD) - k.det() * _cross(edge, k.inv() * ROD)))


def slip_residual() -> sp.Expr:
    """(u - J V).t at the sliding twist less -((K d) x u)/(-n.K d), for any symmetric K and in axes
    along n and t.

    -n.K d > 0 where pushing along d moves the contact inward. Past the edge smu = +mu_p, where
    sticking needs a force turned further towards +t, the product is negative: the rod slips along
    +t. At the other edge all signs turn.
    """
    moved, n = _any_mobility() * cone_edge().subs(NU, 0), normal().subs(NU, 0)
    contact_velocity = n.dot(ROD) / n.dot(moved) * moved
    slip = tangent().subs(NU, 0).dot(ROD - contact_velocity)
    return sp.cancel(sp.together(slip + _cross(moved, ROD) / (-n.dot(moved))))


def envelope_residual() -> sp.Matrix:
    """Gradient by u of the least dissipation E(u) = sqrt(u^T K^-1 u) less the contact force K^-1 u
    / E.

    So a stuck contact is itself a point with an elliptic friction law, traction = grad E: the
    ring's drag.
    """
    k = _any_mobility()
    least = sp.sqrt((ROD.T * k.inv() * ROD)[0])
    return sp.simplify(sp.Matrix([sp.diff(least, u) for u in ROD]) - k.inv() * ROD / least)


def least_dissipation_residual() -> sp.Matrix:
    """(V^T A V - f^T K f) at V = A^-1 J^T f for any f, and f^T K f - u^T K^-1 u at f = K^-1 u."""
    force, k = _any_force(), _any_mobility()
    twist = twist_of_force(force)
    power = (twist.T * ellipsoid_matrix() * twist)[0] - (force.T * mobility() * force)[0]
    stuck = sticking_force(k)
    return sp.Matrix([sp.cancel(power), sp.simplify((stuck.T * k * stuck)[0] - ROD.dot(stuck))])


def isotropic_sticking_twist(c: sp.Expr) -> sp.Matrix:
    """Return the sticking twist of Lynch, Maekawa & Tanie (1992), origin at the centre of pressure.

    c (m) is the greatest torque over the greatest force: v_x = ((c^2 + x^2) u_x + x y u_y)/(c^2 +
    x^2 + y^2), v_y likewise, omega = (x v_y - y v_x)/c^2.
    """
    total = c**2 + X**2 + Y**2
    v_x = ((c**2 + X**2) * U_X + X * Y * U_Y) / total
    v_y = (X * Y * U_X + (c**2 + Y**2) * U_Y) / total
    return sp.Matrix([v_x, v_y, (X * v_y - Y * v_x) / c**2])


def isotropic_residual() -> sp.Matrix:
    """`isotropic_sticking_twist` less `sticking_twist` with A = f^2 diag(1, 1, c^2)."""
    f, c = sp.symbols("f c", positive=True)
    values = {C[i, j]: 0 for i in range(3) for j in range(i)}
    values |= {C[0, 0]: 1 / f, C[1, 1]: 1 / f, C[2, 2]: 1 / (f * c)}
    return (isotropic_sticking_twist(c) - sticking_twist().subs(values)).applyfunc(sp.simplify)
