"""The equations of a pushed or dragged slider, as CasADi functions: residual, Newton step, contact force, tangent.

All are quasi-static balances of the contact force with the footprint's friction, grad D(V) = W, in the slider's frame,
about its origin, for a rod that moves by unit length (Lynch, Maekawa & Tanie 1992; Ma & Rodriguez 2018):

- stick: the contact point moves with the rod, v_c = u, and a free spin omega minimises D (no torque about the contact).
- slide: the contact force lies on the friction cone's edge, f ~ -n + smu t, and v_c = -n + tau t for a unit approach;
  omega and tau are unknown. As D is homogeneous the true twist is that one times the approach speed -n.u, so that the
  equations stay well-conditioned up to the moment when the rod leaves.
- ring_friction: the rod sticks in a ring whose friction makes a torque of smu |F| about it, F the rod's force (the
  friction circle of a journal bearing; Mason 2001): smu |F| is added to the torque. smu is the circle's radius,
  positive when the object turns counter-clockwise.

n is the outward normal at angle `normal`, t = z x n; smu is the signed pusher friction: positive when the rod slides
along +t over the slider.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

import casadi as ca

from cyclemap.mechanics.footprint import PatchFootprint
from cyclemap.mechanics.outline import Polygon
from cyclemap.mechanics.patch_integrals import PatchExpressions, patch_expressions
from cyclemap.mechanics.pressure_family import PressureFamily
from cyclemap.mechanics.rim import Expression

Symbol: TypeAlias = Callable[..., Expression]

# The order of the equations' arguments; lengths in footprint extents, angles in rad.
ARGUMENTS = (
    *("theta", "rod_direction", "x", "y", "normal", "smu"),
    *("mu_a", "mu_b", "m0", "n0", "phi", "rim_share", "warp_a", "warp_b"),
)

# Those that change with the state, and the rod's direction.
STATE_ARGUMENTS = 5

STICK, SLIDE, RING_FRICTION = "stick", "slide", "ring_friction"


@dataclass(frozen=True)
class ContactFunctions:
    """Functions (unknowns, arguments) of one set of equations in one regime (near or far centre of rotation).

    `solver`: -> (residuals, Newton step, f_n, f_t, far), with f_n, f_t the compression and tangential force on the
    slider per unit load; `tangent` (unknowns, 14): derivatives of the solution by the arguments; `state_tangent`
    (unknowns, 5): by the first five of them, at less cost, and what `solver` returns. Unknowns: omega, and where the
    rod slides tau.
    """

    solver: ca.Function
    tangent: ca.Function
    state_tangent: ca.Function


@dataclass(frozen=True)
class _Balance:
    """Symbols and expressions of one set of equations; what depends on the twist does so through its own symbol."""

    unknowns: Expression
    arguments: Expression
    twist: Expression
    twist_of: Expression
    patch: PatchExpressions
    residual: Expression
    normal_force: Expression
    tangential_force: Expression
    gradient: Expression

    def residual_by(self, variables: Expression) -> Expression:
        """Chain rule: what the residual holds itself, and through the twist by the Hessian."""
        explicit = ca.jacobian(self.with_gradient(self.residual), variables)
        by_twist = ca.jacobian(self.residual, self.gradient) @ self.patch.hessian
        return explicit + by_twist @ ca.jacobian(self.twist_of, variables)

    def with_gradient(self, expression: Expression) -> Expression:
        """Return an expression with grad D in place of its symbol."""
        return ca.substitute(expression, self.gradient, ca.vertcat(self.patch.force, self.patch.torque))

    def substituted(self, expression: Expression) -> Expression:
        """Return an expression of the unknowns and arguments alone."""
        inner = self.patch.substituted(self.with_gradient(expression))
        return ca.cse(ca.substitute(inner, self.twist, self.twist_of))


# Sums over up to so many support points are written out.
_FEW_POINTS = 16


@lru_cache(maxsize=256)
def contact_functions(pressure: PressureFamily, equations: str, near: bool) -> ContactFunctions:
    """Build (once) the functions of a normalised footprint's family (extent one): stick, slide or ring_friction."""
    # Sums over many points are faster as vector operations, closed forms and short sums as scalars.
    footprint = pressure.footprint
    if isinstance(footprint, PatchFootprint):
        scalar = near and isinstance(footprint.outline, Polygon)
    else:
        scalar = len(footprint.positions) <= _FEW_POINTS
    symbol = ca.SX.sym if scalar else ca.MX.sym
    if equations == SLIDE:
        balance = _slide_balance(pressure, near, symbol)
    else:
        balance = _stick_balance(pressure, near, symbol, with_friction=equations == RING_FRICTION)
    return ContactFunctions(_solver(balance), _tangent(balance), _state_tangent(balance))


def _stick_balance(pressure: PressureFamily, near: bool, symbol: Symbol, with_friction: bool) -> _Balance:
    omega, q, gradient = symbol("omega"), symbol("arguments", len(ARGUMENTS)), symbol("gradient", 3)
    theta, direction, x, y, _, smu = (q[i] for i in range(6))
    rod = ca.vertcat(ca.cos(direction - theta), ca.sin(direction - theta))
    # Spin about the contact: V(omega) = (u - omega z x c, omega).
    residual = ca.dot(ca.vertcat(y, -x, 1), gradient)
    if with_friction:
        residual = residual + smu * ca.sqrt(gradient[0] ** 2 + gradient[1] ** 2)
    return _balance(pressure, near, symbol, (omega, q, gradient), rod, residual)


def _slide_balance(pressure: PressureFamily, near: bool, symbol: Symbol) -> _Balance:
    z, q, gradient = symbol("unknowns", 2), symbol("arguments", len(ARGUMENTS)), symbol("gradient", 3)
    x, y, normal, smu = q[2], q[3], q[4], q[5]
    n, t = ca.vertcat(ca.cos(normal), ca.sin(normal)), ca.vertcat(-ca.sin(normal), ca.cos(normal))
    # No torque about the contact, and no force across the cone's edge -n + smu t.
    rows = ca.horzcat(ca.vertcat(y, -x, 1), ca.vertcat(t + smu * n, 0)).T
    return _balance(pressure, near, symbol, (z, q, gradient), -n + z[1] * t, rows @ gradient)


def _balance(
    pressure: PressureFamily,
    near: bool,
    symbol: Symbol,
    symbols: tuple[Expression, Expression, Expression],
    contact_velocity: Expression,
    residual: Expression,
) -> _Balance:
    unknowns, q, gradient = symbols
    x, y, normal, omega = q[2], q[3], q[4], unknowns[0]
    twist, twist_of = symbol("twist", 3), ca.vertcat(contact_velocity + omega * ca.vertcat(y, -x), omega)
    patch = patch_expressions(pressure, twist, q[6:14], q[0], near)
    c, s = ca.cos(normal), ca.sin(normal)
    normal_force, tangential_force = -(c * gradient[0] + s * gradient[1]), c * gradient[1] - s * gradient[0]
    return _Balance(unknowns, q, twist, twist_of, patch, residual, normal_force, tangential_force, gradient)


def _solver(balance: _Balance) -> ca.Function:
    return ca.Function("balance", [balance.unknowns, balance.arguments], [balance.substituted(_solution(balance))])


def _solution(balance: _Balance) -> Expression:
    step = -_solved(balance.residual_by(balance.unknowns), balance.residual)
    return ca.vertcat(balance.residual, step, balance.normal_force, balance.tangential_force, balance.patch.far)


def _tangent(balance: _Balance) -> ca.Function:
    """Implicit function theorem: d unknowns / d arguments = -(d residual / d unknowns)^-1 d residual / d arguments."""
    by_unknowns, by_arguments = balance.residual_by(balance.unknowns), balance.residual_by(balance.arguments)
    tangent = ca.densify(-_solved(by_unknowns, by_arguments))
    return ca.Function("tangent", [balance.unknowns, balance.arguments], [balance.substituted(tangent)])


def _state_tangent(balance: _Balance) -> ca.Function:
    """The same by the first five arguments alone: of these the footprint's integrals know only theta."""
    q, theta = balance.arguments, ca.DM.eye(len(ARGUMENTS))[:, 0]
    explicit = ca.jacobian(balance.residual, q)[:, 1:STATE_ARGUMENTS]
    by_theta = ca.jtimes(balance.with_gradient(balance.residual), q, theta)
    by_twist = ca.jacobian(balance.residual, balance.gradient) @ balance.patch.hessian
    twist_by = ca.jacobian(balance.twist_of, q)[:, :STATE_ARGUMENTS]
    by_state = ca.horzcat(by_theta, explicit) + by_twist @ twist_by
    tangent = ca.densify(-_solved(balance.residual_by(balance.unknowns), by_state))
    size = tangent.numel()
    outputs = balance.substituted(ca.vertcat(ca.vec(tangent), _solution(balance)))
    results = [ca.reshape(outputs[:size], tangent.shape), outputs[size:]]
    return ca.Function("state_tangent", [balance.unknowns, q], results)


def _solved(matrix: Expression, right: Expression) -> Expression:
    """Return matrix^-1 right for a matrix of one or two rows, in scalars."""
    if matrix.shape[0] == 1:
        return right / matrix
    a, c, b, d = (matrix[0, 0], matrix[1, 0], matrix[0, 1], matrix[1, 1])
    adjugate = ca.blockcat([[d, -b], [-c, a]])
    return adjugate @ right / (a * d - b * c)
