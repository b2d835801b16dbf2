"""Where a point of a periodic orbit meets a break of the map, and how its branch goes on beyond a kink."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.maps.arcs import Array, shorter_way
from cyclemap.maps.families.orbit_equations import OrbitEquations, OrbitState
from cyclemap.maps.families.parameter_tangent import ParameterTangent, break_motion, limit_at_break
from cyclemap.maps.families.special_points import Bifurcation, recorded
from cyclemap.maps.lifts.circle_map import JUMP, CircleMap

_ITERATIONS = 12
_BESIDE = 1e-9  # radians: how far below a break ∂F/∂p is read for its limit from the left


@dataclass(frozen=True, eq=False)
class Collision:
    """A point of an orbit on a break of the map.

    state : the orbit there, slopes of the side it came from. bifurcation : the record.
    beyond : the same with the slopes of the far side, None at a jump.
    outward : the scaled direction in which the branch leaves on the far side, None at a jump.
    """

    state: OrbitState
    bifurcation: Bifurcation
    beyond: OrbitState | None
    outward: Array | None


@dataclass(frozen=True, eq=False)
class _OneSided:
    """An orbit with one point held on a break, the map there being that of one side (-1 below, 1 above)."""

    equations: OrbitEquations
    tangent: ParameterTangent
    theta: Array
    point: int
    side: int

    @property
    def member(self) -> CircleMap:
        return self.tangent.member

    def residual(self) -> Array:
        images = np.array(self.member(self.theta))
        images[self.point] = limit_at_break(self.member, self.theta[self.point], self.side)
        return self.equations.residual(images, self.theta)

    def state(self) -> OrbitState:
        slopes = np.array(self.member.derivative(self.theta))
        limit = self.member.right_derivative if self.side > 0 else self.member.left_derivative
        slopes[self.point] = limit(self.theta[self.point])
        return OrbitState(self.tangent.parameter, self.theta, self.member, slopes)

    def push(self) -> Array:
        beside = np.array(self.theta)
        beside[self.point] -= _BESIDE * (self.side < 0)
        return self.tangent(beside)

    def condition(self) -> Array:
        """Derivative of θ_point - break with respect to (θ, p)."""
        gaps = np.abs(shorter_way(self.theta[self.point] - self.member.breaks))
        rate = self.tangent.break_rates[int(np.argmin(gaps))]
        return np.append(np.arange(self.theta.size) == self.point, -rate)

    def jumps(self) -> bool:
        at = self.theta[self.point]
        return bool(abs(float(self.member.right(at) - self.member.left(at))) > JUMP)

    def across(self) -> _OneSided:
        return _OneSided(self.equations, self.tangent, self.theta, self.point, -self.side)


def border_collision(
    equations: OrbitEquations, before: OrbitState, near: tuple[Array, float], point: int, which: int
) -> Collision | None:
    """The collision of θ_point with the break ``which`` of ``before``, near (θ, p); None when there is none.

    Newton's method on the extended system: the orbit's equations with the map of the side it comes from, and
    θ_point on the break, which itself moves with the parameter.
    """
    gap = float(shorter_way(before.theta[point] - before.member.breaks[which]))
    theta, p, last = np.array(near[0]), near[1], np.inf
    for _ in range(_ITERATIONS):
        if not equations.within[0] <= p <= equations.within[1]:
            return None
        tangent = equations.push(p)
        theta[point] = before.theta[point] - gap + break_motion(before.member.breaks, tangent.member.breaks)[which]
        held = _OneSided(equations, tangent, theta, point, 1 if gap > 0.0 else -1)
        moved = _newton_step(held)
        size = float(np.max(np.abs(moved)))
        if size <= 1e-14 or (size < 1e-10 and size > 0.25 * last):
            return _collision(held)
        if not size < 1.0:
            return None
        theta, p, last = theta + moved[:-1], p + float(moved[-1]), size
    return None


def _newton_step(held: _OneSided) -> Array:
    jacobian = held.equations.jacobian(held.state().slopes)
    extended = np.vstack([np.column_stack([jacobian, held.push()]), held.condition()])
    try:
        return np.asarray(np.linalg.solve(extended, -np.append(held.residual(), 0.0)))
    except np.linalg.LinAlgError:
        return np.full(held.theta.size + 1, np.nan)


def _collision(held: _OneSided) -> Collision:
    state, far, jump = held.state(), held.across(), held.jumps()
    sides = {held.side: state.multiplier, far.side: far.state().multiplier}
    bifurcation = recorded(
        "border-collision",
        held.equations,
        state,
        held.push(),
        held.condition(),
        np.append(held.residual(), 0.0),
        multipliers=(sides[1], sides[-1]),
        first=held.point,
        jump=jump,
    )
    if jump:
        return Collision(state, bifurcation, None, None)
    beyond = far.state()
    outward = held.equations.direction(beyond.slopes, far.push())
    leaving = far.side * float(far.condition() @ (outward * held.equations.scales))
    return Collision(state, bifurcation, beyond, outward if leaving >= 0.0 else -outward)
