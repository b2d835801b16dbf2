"""Where a branch of periodic orbits bifurcates: saddle-node, period doubling, collision with a break."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.checks import read_only
from cyclemap.errors import ConvergenceError
from cyclemap.maps.arcs import TWO_PI, Array
from cyclemap.maps.estimate import Estimate
from cyclemap.maps.families.orbit_equations import OrbitEquations, OrbitState
from cyclemap.maps.rounding import EPS

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
