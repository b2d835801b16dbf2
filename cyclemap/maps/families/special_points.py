"""Where a branch of periodic orbits bifurcates: saddle-node, period doubling, collision with a break."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import TWO_PI, Array, shorter_way
from cyclemap.checks import read_only
from cyclemap.errors import ConvergenceError
from cyclemap.maps.estimate import EPS, Estimate
from cyclemap.maps.families.orbit_equations import OrbitEquations, OrbitState
from cyclemap.maps.families.parameter_tangent import ParameterTangent, break_motion, limit_at_break
from cyclemap.maps.lifts.circle_map import JUMP, CircleMap

_BEND = 1e-4  # radians: step of the differences of F'
_TRANSVERSE = 1e-6  # a saddle-node's orbit moves with the parameter by more than this share of ∂F/∂p


@dataclass(frozen=True, eq=False)
class Bifurcation:
    """A parameter at which a periodic orbit changes.

    kind : "saddle-node" (two orbits merge, multiplier 1), "period-doubling" (multiplier -1), "border-collision" (a
        point of the orbit meets a break of the map) or "branch point" (multiplier 1 where branches cross).
    parameter : where, with a bound on its error. points : shape (period,), radians in [0, 2π), in order of visit,
        the smallest first; of a border collision the one on the break first.
    period, winding : of the orbit. multiplier : (Fⁿ)' there; at a border collision with the slope from the right of
        the break, and left_multiplier with that from the left (equal otherwise).
    jump : whether the break met is a jump of the map, where the branch ends, and not a kink.
    residual : the largest residual of the equations of the orbit and of the condition.
    """

    kind: str
    parameter: Estimate
    points: Array
    period: int
    winding: int
    multiplier: float
    left_multiplier: float
    jump: bool
    residual: float

    @property
    def theta(self) -> float:
        """The first of the points, radians."""
        return float(self.points[0])

    @property
    def folds(self) -> bool:
        """Whether two orbits meet and vanish here: a saddle-node, or its like at a kink.

        At a kink that is so where 1 lies between the one-sided multipliers (di Bernardo et al. 2008, ch. 3).
        """
        if self.kind != "border-collision":
            return self.kind == "saddle-node"
        return not self.jump and (self.multiplier - 1.0) * (self.left_multiplier - 1.0) < 0.0


# -- multiplier ±1 ---------------------------------------------------------------------------------------------


def smooth_bifurcation(
    equations: OrbitEquations, before: OrbitState, after: OrbitState, direction: Array, target: float
) -> tuple[OrbitState, Bifurcation]:
    """The orbit with multiplier ``target`` (1 or -1) between two neighbouring states of a branch.

    The extended system (orbit, multiplier) is solved by bisection and interpolation along the branch.
    """
    from scipy.optimize import brentq

    length = float(direction @ (equations.point(after) - equations.point(before)))
    found: dict[float, OrbitState] = {0.0: before, length: after}

    def excess(s: float) -> float:
        if s not in found:
            solved = equations.solved_along(equations.point(before) + s * direction, direction)
            if solved is None:
                raise ConvergenceError(
                    f"the orbit of period {equations.period} near parameter {before.parameter:.9g} was lost while "
                    f"its multiplier was brought to {target:g}"
                )
            found[s] = solved
        return found[s].multiplier - target

    at = found[brentq(excess, 0.0, length, xtol=EPS * length, rtol=8.0 * EPS)]
    push = equations.push(at.parameter)(at.theta)
    kind = "period-doubling" if target < 0.0 else _kind_at_one(equations, at, push)
    condition = np.append(_multiplier_gradient(at), _multiplier_rate(equations, at))
    residual = np.append(equations.residual(at.member(at.theta), at.theta), at.multiplier - target)
    return at, recorded(kind, equations, at, push, condition, residual)


def _kind_at_one(equations: OrbitEquations, at: OrbitState, push: Array) -> str:
    left, _, _ = np.linalg.svd(equations.jacobian(at.slopes))
    share = abs(float(left[:, -1] @ push))
    return "saddle-node" if share > _TRANSVERSE * float(np.max(np.abs(push))) else "branch point"


def _multiplier_gradient(at: OrbitState) -> Array:
    """d(multiplier)/dθ_i, by centred differences of F'."""
    ahead, behind = at.member.derivative(at.theta + _BEND), at.member.derivative(at.theta - _BEND)
    others = np.array([np.prod(np.delete(at.slopes, i)) for i in range(at.theta.size)])
    return np.asarray((ahead - behind) / (2.0 * _BEND) * others)


def _multiplier_rate(equations: OrbitEquations, at: OrbitState) -> float:
    step = 1e-5 * (equations.within[1] - equations.within[0])
    low, high = (float(np.clip(at.parameter + k * step, *equations.within)) for k in (-1, 1))
    change = [float(np.prod(equations.member(p).derivative(at.theta))) for p in (low, high)]
    return (change[1] - change[0]) / (high - low)


def recorded(
    kind: str,
    equations: OrbitEquations,
    at: OrbitState,
    push: Array,
    condition: Array,
    residual: Array,
    *,
    multipliers: tuple[float, float] | None = None,
    first: int | None = None,
    jump: bool = False,
) -> Bifurcation:
    """The bifurcation with its bound: |last row of the extended Jacobian's inverse|·(|residual| + rounding).

    push : ∂F/∂p at the points. condition : derivative of the extra equation with respect to (θ, p). residual :
    of all n + 1 equations. multipliers : from the right and from the left where they differ. The bound is good to
    first order; nothing beyond that is proved.
    """
    points = np.mod(at.theta, TWO_PI)
    extended = np.vstack([np.column_stack([equations.jacobian(at.slopes), push]), condition])
    error = _parameter_error(equations, at, extended, residual)
    return Bifurcation(
        kind,
        Estimate(at.parameter, error),
        read_only(np.roll(points, -(int(np.argmin(points)) if first is None else first))),
        points.size,
        equations.winding,
        *(multipliers or (at.multiplier, at.multiplier)),
        jump,
        float(np.max(np.abs(residual))),
    )


def _parameter_error(equations: OrbitEquations, at: OrbitState, extended: Array, residual: Array) -> float:
    angle = 2.0 * TWO_PI + np.abs(np.roll(at.theta, -1) + TWO_PI * equations.hops)
    rounding = np.append(2.0 * EPS * angle, 8.0 * EPS * angle.size * max(1.0, abs(at.multiplier)))
    try:
        row = np.abs(np.linalg.inv(extended)[-1])
    except np.linalg.LinAlgError:
        return float("inf")
    return float(row @ (np.abs(residual) + rounding)) + 2.0 * EPS * abs(at.parameter)


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
