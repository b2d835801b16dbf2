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

STICK, SLIDE, RING_FRICTION = "stick", "slide", "ring_friction"


@dataclass(frozen=True)
class ContactFunctions:
    """Functions (unknowns, arguments) of one set of equations in one regime (near or far centre of rotation).

    `solver`: -> (residuals, Newton step, f_n, f_t, far), with f_n, f_t the compression and tangential force on the
    slider per unit load; `tangent` (unknowns, 14): derivatives of the solution by the arguments. Unknowns: omega, and
    where the rod slides tau.
    """

    solver: ca.Function
    tangent: ca.Function


@dataclass(frozen=True)
class _Balance:
    """Symbols and residuals of one set of equations."""

    unknowns: Expression
    arguments: Expression
    patch: PatchExpressions
    residual: Expression
    jacobian: Expression
    normal_force: Expression
    tangential_force: Expression


@lru_cache(maxsize=256)
def contact_functions(pressure: PressureFamily, equations: str, near: bool) -> ContactFunctions:
    """Build (once) the functions of a normalised footprint's family (extent one): stick, slide or ring_friction."""
    # Sums over many points are faster as vector operations, closed forms as scalars.
    footprint = pressure.footprint
    closed = near and isinstance(footprint, PatchFootprint) and isinstance(footprint.outline, Polygon)
    symbol = ca.SX.sym if closed else ca.MX.sym
    if equations == SLIDE:
        balance = _slide_balance(pressure, near, symbol)
    else:
        balance = _stick_balance(pressure, near, symbol, with_friction=equations == RING_FRICTION)
    return ContactFunctions(_solver(balance), _tangent(balance))


def _stick_balance(pressure: PressureFamily, near: bool, symbol: Symbol, with_friction: bool) -> _Balance:
    omega, q = symbol("omega"), symbol("arguments", len(ARGUMENTS))
    theta, direction, x, y, normal, smu = (q[i] for i in range(6))
    rod = ca.vertcat(ca.cos(direction - theta), ca.sin(direction - theta))
    patch = _patch(pressure, rod, omega, q, near)
    # Spin about the contact: V(omega) = (u - omega z x c, omega).
    spin = ca.vertcat(y, -x, 1)
    gradient = ca.vertcat(patch.force, patch.torque)
    residual, jacobian = ca.dot(spin, gradient), spin.T @ patch.hessian @ spin
    if with_friction:
        force = ca.sqrt(patch.force[0] ** 2 + patch.force[1] ** 2)
        residual = residual + smu * force
        jacobian = jacobian + smu * (patch.force.T / force) @ patch.hessian[:2, :] @ spin
    return _balance(omega, q, patch, residual, jacobian, normal)


def _slide_balance(pressure: PressureFamily, near: bool, symbol: Symbol) -> _Balance:
    z, q = symbol("unknowns", 2), symbol("arguments", len(ARGUMENTS))
    x, y, normal, smu = q[2], q[3], q[4], q[5]
    n, t = ca.vertcat(ca.cos(normal), ca.sin(normal)), ca.vertcat(-ca.sin(normal), ca.cos(normal))
    patch = _patch(pressure, -n + z[1] * t, z[0], q, near)
    spin, slip = ca.vertcat(y, -x, 1), ca.vertcat(t, 0)
    # Perpendicular to the cone's edge -n + smu t.
    across = ca.vertcat(t + smu * n, 0)
    gradient = ca.vertcat(patch.force, patch.torque)
    rows = ca.horzcat(spin, across).T
    return _balance(z, q, patch, rows @ gradient, rows @ patch.hessian @ ca.horzcat(spin, slip), normal)


def _patch(
    pressure: PressureFamily, contact_velocity: Expression, omega: Expression, q: Expression, near: bool
) -> PatchExpressions:
    x, y = q[2], q[3]
    velocity = contact_velocity + omega * ca.vertcat(y, -x)
    return patch_expressions(pressure, ca.vertcat(velocity, omega), q[6:14], q[0], near)


def _balance(
    unknowns: Expression,
    q: Expression,
    patch: PatchExpressions,
    residual: Expression,
    jacobian: Expression,
    normal: Expression,
) -> _Balance:
    fx, fy = patch.force[0], patch.force[1]
    c, s = ca.cos(normal), ca.sin(normal)
    return _Balance(unknowns, q, patch, residual, jacobian, -(c * fx + s * fy), c * fy - s * fx)


def _solver(balance: _Balance) -> ca.Function:
    step = -_solved(balance.jacobian, balance.residual)
    outputs = ca.vertcat(balance.residual, step, balance.normal_force, balance.tangential_force, balance.patch.far)
    return ca.Function("balance", [balance.unknowns, balance.arguments], [ca.cse(balance.patch.substituted(outputs))])


def _tangent(balance: _Balance) -> ca.Function:
    """Implicit function theorem: d unknowns / d arguments = -(d residual / d unknowns)^-1 d residual / d arguments."""
    by_arguments = ca.jacobian(balance.residual, balance.arguments)
    tangent = -_solved(balance.jacobian, by_arguments)
    return ca.Function("tangent", [balance.unknowns, balance.arguments], [ca.cse(balance.patch.substituted(tangent))])


def _solved(matrix: Expression, right: Expression) -> Expression:
    """Return matrix^-1 right for a matrix of one or two rows, in scalars."""
    if matrix.shape[0] == 1:
        return right / matrix
    a, c, b, d = (matrix[0, 0], matrix[1, 0], matrix[0, 1], matrix[1, 1])
    adjugate = ca.blockcat([[d, -b], [-c, a]])
    return adjugate @ right / (a * d - b * c)
