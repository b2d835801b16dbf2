"""Periodic orbits as solutions of F(θ_i; p) = θ_{i+1} + 2πh_i, and where they bifurcate."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Mask, shorter_way
from cyclemap.checks import read_only
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import EPS, Estimate
from cyclemap.maps.families.family import (
    Family,
    ParameterTangent,
    Range,
    break_motion,
    family_member,
    limit_at_break,
    parameter_tangent,
)
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.lift_checks import JUMP

_ITERATIONS = 12
_STEP = 1e-5  # of the range: for second-order differences in p
_LONGEST = 1.0  # scaled length of a Newton step that counts as lost
_CLOSE = 1e-13
_BEND = 1e-4  # radians: step of the differences of F'


@dataclass(frozen=True, eq=False)
class OrbitState:
    """A periodic orbit at one parameter: its points (radians, continuous along a branch) and their
    slopes F'.

    ``push`` is ∂F/∂p at the points where it is known, read at a parameter nearby: good enough for a
    prediction.
    """

    parameter: float
    theta: Array
    member: CircleMap
    slopes: Array
    push: Array | None = None

    @property
    def multiplier(self) -> float:
        """(Fⁿ)' along the orbit."""
        return float(np.prod(self.slopes))

    @property
    def other_slopes(self) -> Array:
        """The product of all slopes but each: how the multiplier moves with that one."""
        return np.array([np.prod(np.delete(self.slopes, i)) for i in range(self.slopes.size)])

    def multiplier_gradient(self, tangents: Sequence[ParameterTangent]) -> Array:
        """The multiplier's derivatives by θ_i, from differences of F' that reach across no break,
        and by the tangents' parameters.
        """
        others = self.other_slopes
        gaps = shorter_way(
            self.theta[:, None] - np.append(self.member.breaks, self.theta[0] + np.pi)
        )
        gap = gaps[np.arange(self.theta.size), np.argmin(np.abs(gaps), axis=1)]
        below = np.where((gap > 0.0) & (gap <= _BEND), 0.0, _BEND)
        above = np.where((gap < 0.0) & (gap >= -_BEND), 0.0, _BEND)
        rise = self.member.derivative(self.theta + above) - self.member.derivative(
            self.theta - below
        )
        bend = rise / (below + above)
        changes = [others @ tangent.of_slopes(self.theta, bend) for tangent in tangents]
        return np.append(others * bend, changes)


@dataclass(frozen=True, eq=False)
class OrbitEquations:
    """The n equations of a period-n orbit and the scaled space (θ/√n, p/scale) in which branches
    are followed.

    hops : shape (n,), whole turns taken off after each cycle.
    winding : of the orbit (for degree 1 their sum).
    within : the range of the parameter, outside which the family is never called; its length is the
        scale.
    """

    family: Family
    hops: Array
    winding: int
    within: Range

    @property
    def scales(self) -> Array:
        """Radians, and units of the parameter, to a unit of the scaled space."""
        period = self.hops.size
        return np.append(np.full(period, np.sqrt(period)), self.within[1] - self.within[0])

    def push(self, p: float) -> ParameterTangent:
        """∂F/∂p at ``p``."""
        return parameter_tangent(self.family, p, _STEP, self.within)

    def residual(self, images: Array, theta: Array) -> Array:
        """F(θ_i) - θ_{i+1} - 2πh_i from the images F(θ_i)."""
        return images - np.roll(theta, -1) - TWO_PI * self.hops

    def jacobian(self, slopes: Array) -> Array:
        """(n, n): derivative of the residual with respect to θ."""
        return np.diag(slopes) - np.roll(np.eye(self.hops.size), 1, axis=1)

    def point(self, state: OrbitState) -> Array:
        """The state in the scaled space."""
        return np.append(state.theta, state.parameter) / self.scales

    def state(self, p: float, theta: Array, member: CircleMap | None = None) -> OrbitState:
        """The state at these points, not corrected."""
        at = member or family_member(self.family, p)
        return OrbitState(p, theta, at, at.derivative(theta))

    def solved_at(
        self, p: float, theta: Array, member: CircleMap | None = None
    ) -> OrbitState | None:
        """The orbit near ``theta`` at a fixed parameter, to rounding; None when Newton's method
        finds none.
        """
        at = member or family_member(self.family, p)
        last = np.inf
        for _ in range(_ITERATIONS):
            moved = least_step(
                self.jacobian(at.derivative(theta)), -self.residual(at(theta), theta)
            )
            size = float(np.max(np.abs(moved)))
            if not size < _LONGEST:
                return None
            theta = theta + moved
            if size <= _CLOSE or (size < 1e-9 and size > 0.25 * last):
                return self.state(p, theta, at)
            last = size
        return None

    def solved_along(self, guess: Array, direction: Array) -> OrbitState | None:
        """The orbit nearest to ``guess`` across ``direction`` (both scaled),
        or None (Keller 1977)."""
        low, high = self.within
        slack = 1e-12 * (high - low)
        span = high - low
        if not low - slack <= guess[-1] * span <= high + slack:
            return None
        tangent = self.push(float(np.clip(guess[-1] * span, low, high)))
        at = tangent.member
        last = np.inf
        point = guess
        for _ in range(_ITERATIONS):
            theta = point[:-1] * self.scales[:-1]
            residual = self.residual(at(theta), theta)
            bordered = (
                np.column_stack([self.jacobian(at.derivative(theta)), tangent(theta)]) * self.scales
            )
            moved = least_step(
                np.vstack([bordered, direction]), -np.append(residual, direction @ (point - guess))
            )
            size = float(np.max(np.abs(moved)))
            point = point + moved
            if not size < _LONGEST or not low - slack <= point[-1] * span <= high + slack:
                return None
            p = float(np.clip(point[-1] * span, low, high))
            at = family_member(self.family, p)
            if size <= _CLOSE or (size < 1e-9 and size > 0.25 * last):
                theta = point[:-1] * self.scales[:-1]
                return replace(self.state(p, theta, at), push=tangent(theta))
            last = size
        return None

    def direction(self, slopes: Array, push: Array, along: Array | None = None) -> Array:
        """The unit tangent of the branch in the scaled space, turned towards ``along``."""
        bordered = np.column_stack([self.jacobian(slopes), push]) * self.scales
        if along is not None:
            unit = least_step(
                np.vstack([bordered, along]), np.append(np.zeros(self.hops.size), 1.0)
            )
            return np.asarray(unit / np.linalg.norm(unit))
        _, _, rows = np.linalg.svd(bordered)
        return np.asarray(rows[-1])


def least_step(matrix: Array, right: Array) -> Array:
    """The step of Newton's method, the shortest one where there are many."""
    try:
        return np.asarray(np.linalg.solve(matrix, right))
    except np.linalg.LinAlgError:
        # Right on a branch point: the shortest step is the one across both branches.
        return np.asarray(np.linalg.lstsq(matrix, right)[0])


def orbit_equations(
    family: Family, points: Array, parameter: float, winding: int, within: Range
) -> OrbitEquations:
    """The equations of the orbit through ``points`` (nearly one of the family at ``parameter``, in
    order of visit).
    """
    member = family_member(family, parameter)
    hops = np.round((member(points) - np.roll(points, -1)) / TWO_PI)
    turns = int(hops @ float(member.degree) ** np.arange(points.size - 1, -1, -1))
    if turns != winding:
        raise InvalidInput(
            f"the points wind {turns} times at {parameter:.9g}, not {winding}: give an orbit of "
            "that map"
        )
    return OrbitEquations(family, hops, winding, within)


def crossed_break(before: OrbitState, theta: Array, motion: Array) -> tuple[int, int, float] | None:
    """(point, break, share of the step) of the first break crossed on the way from ``before`` to
    ``theta``.

    ``motion`` : how far each break has moved meanwhile. None when none is crossed.
    """
    if motion.size == 0:
        return None
    old = shorter_way(before.theta[:, None] - before.member.breaks)
    new = old + (theta - before.theta)[:, None] - motion
    crossed: Mask = (old * new < 0.0) & (np.abs(old) < 1.0) & (np.abs(old) > 1e-11)
    if not np.any(crossed):
        return None
    share = np.where(crossed, np.abs(old) / np.where(crossed, np.abs(old - new), 1.0), np.inf)
    point, which = np.unravel_index(int(np.argmin(share)), share.shape)
    return int(point), int(which), float(share[point, which])


_TRANSVERSE = (
    1e-6  # a saddle-node's orbit moves with the parameter by more than this share of ∂F/∂p
)


@dataclass(frozen=True, eq=False)
class Bifurcation:
    """A parameter at which a periodic orbit changes.

    Attributes
    ----------
    kind : str
        "saddle-node" (two orbits merge, multiplier 1), "period-doubling" (multiplier -1),
        "border-collision" (a point of the orbit meets a break of the map) or "branch point"
        (multiplier 1 where branches cross).
    parameter : Estimate
        Where, with a bound on its error, to first order; it holds the map's ``max_error`` and
        what ``derivative_and_error`` tells of F'; of a sampled map that is the table's slope,
        not the truth's, and period doublings and branch points move with the difference.
    points : ndarray, shape (period,)
        Radians in [0, 2π), in order of visit, the smallest first; of a border collision the one
        on the break first.
    period, winding : int
        Of the orbit.
    multiplier, left_multiplier : float
        (Fⁿ)' there; at a border collision with the slopes from the right and from the left of
        the break.
    jump : bool
        Whether the break met is a jump of the map, where the branch ends, and not a kink.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CircleMap, saddle_nodes
    >>> [birth] = saddle_nodes(lambda K: CircleMap.arnold(0.1, K), (0.1, 1.5))
    >>> birth.kind, birth.parameter.holds(0.2 * np.pi), birth.folds, round(birth.theta, 6)
    ('saddle-node', True, True, 1.570796)
    """

    kind: str
    parameter: Estimate
    points: Array
    period: int
    winding: int
    multiplier: float
    left_multiplier: float
    jump: bool

    @property
    def theta(self) -> float:
        """The first of the points, radians."""
        return float(self.points[0])

    @property
    def folds(self) -> bool:
        """Whether two orbits meet and vanish here: a saddle-node, or its like at a kink.

        At a kink that is so where 1 lies between the one-sided multipliers (di Bernardo et al.
        2008, ch. 3).
        """
        if self.kind != "border-collision":
            return self.kind == "saddle-node"
        return not self.jump and (self.multiplier - 1.0) * (self.left_multiplier - 1.0) < 0.0


Solution = TypeVar("Solution")


def zero_along(
    ends: tuple[Solution, Solution],
    length: float,
    solved: Callable[[float], Solution | None],
    value: Callable[[Solution], float],
    lost: str,
) -> Solution:
    """The solution at which ``value`` is 0, between two on a curve that are ``length`` apart, by
    its sign there.

    solved : the solution at a distance from the first, or None: then ConvergenceError says what is
        ``lost``.
    """
    from scipy.optimize import brentq

    known = {0.0: ends[0], length: ends[1]}

    def value_at(distance: float) -> float:
        if distance not in known:
            solution = solved(distance)
            if solution is None:
                raise ConvergenceError(lost)
            known[distance] = solution
        return value(known[distance])

    return known[brentq(value_at, 0.0, length, xtol=EPS * length, rtol=8.0 * EPS)]


def smooth_bifurcation(
    equations: OrbitEquations,
    before: OrbitState,
    after: OrbitState,
    direction: Array,
    target: float,
) -> tuple[OrbitState, Bifurcation]:
    """The orbit with multiplier ``target`` (1 or -1) between two neighbouring states of a branch.

    The extended system (orbit, multiplier) is solved by bisection and interpolation along the
    branch.
    """
    begin = equations.point(before)
    at = zero_along(
        (before, after),
        float(direction @ (equations.point(after) - begin)),
        lambda distance: equations.solved_along(begin + distance * direction, direction),
        lambda state: state.multiplier - target,
        f"the orbit of period {equations.hops.size} near parameter {before.parameter:.9g} was lost "
        f"while its multiplier was brought to {target:g}",
    )
    tangent = equations.push(at.parameter)
    push = tangent(at.theta)
    kind = "period-doubling"
    if target > 0.0:
        left, _, _ = np.linalg.svd(equations.jacobian(at.slopes))
        transverse = abs(float(left[:, -1] @ push)) > _TRANSVERSE * float(np.max(np.abs(push)))
        kind = "saddle-node" if transverse else "branch point"
    condition = at.multiplier_gradient([tangent])
    residual = np.append(equations.residual(at.member(at.theta), at.theta), at.multiplier - target)
    slope_errors = at.member.derivative_and_error(at.theta)[1]
    unknown = float(np.abs(at.other_slopes) @ slope_errors)
    return at, recorded(kind, equations, at, push, condition, residual, unknown=unknown)


def recorded(
    kind: str,
    equations: OrbitEquations,
    at: OrbitState,
    push: Array,
    condition: Array,
    residual: Array,
    *,
    unknown: float = 0.0,
    multipliers: tuple[float, float] | None = None,
    first: int | None = None,
    jump: bool = False,
) -> Bifurcation:
    """The bifurcation with its bound: |last row of the extended Jacobian's inverse|·(|residual| +
    rounding + error).

    error : the map's ``max_error``, of the orbit's equations alone. A saddle-node's row is 0 at the
        multiplier, so that it does not move with F'; a period doubling does.
    unknown : what the extra equation may be off by the error of F' that the map tells.

    push : ∂F/∂p at the points.
    condition : derivative of the extra equation with respect to (θ, p).
    residual : of all n + 1 equations.
    multipliers : from the right and from the left where they differ. Good to first order; nothing
        beyond that is proved.
    """
    points = np.mod(at.theta, TWO_PI)
    extended = np.vstack([np.column_stack([equations.jacobian(at.slopes), push]), condition])
    angle = 2.0 * TWO_PI + np.abs(np.roll(at.theta, -1) + TWO_PI * equations.hops)
    rounding = np.append(2.0 * EPS * angle, 8.0 * EPS * angle.size * max(1.0, abs(at.multiplier)))
    rounding[:-1] += at.member.max_error
    rounding[-1] += unknown
    try:
        row = np.abs(np.linalg.inv(extended)[-1])
        error = float(row @ (np.abs(residual) + rounding)) + 2.0 * EPS * abs(at.parameter)
    except np.linalg.LinAlgError:
        error = float("inf")
    return Bifurcation(
        kind,
        Estimate(at.parameter, error),
        read_only(np.roll(points, -(int(np.argmin(points)) if first is None else first))),
        points.size,
        equations.winding,
        *(multipliers or (at.multiplier, at.multiplier)),
        jump,
    )


_BESIDE = 1e-9  # radians: how far below a break ∂F/∂p is read for its limit from the left


def one_sided(
    equations: OrbitEquations, tangent: ParameterTangent, theta: Array, point: int, side: int
) -> tuple[OrbitState, Array, Array, Array]:
    """The orbit with θ_point on a break, the map there that of one side (-1 below, 1 above).

    Its state, the residual of its equations, ∂F/∂p, and the derivative of θ_point - break with
    respect to (θ, p).
    """
    member = tangent.member
    beside = np.array(theta)
    at = theta[point]
    images = np.array(member(theta))
    slopes = np.array(member.derivative(theta))
    images[point] = limit_at_break(member, at, side)
    slopes[point] = member.derivative(at, side)
    beside[point] -= _BESIDE * (side < 0)
    rate = tangent.break_rates[int(np.argmin(np.abs(shorter_way(at - member.breaks))))]
    condition = np.append(np.arange(theta.size) == point, -rate)
    state = OrbitState(tangent.parameter, theta, member, slopes)
    return state, equations.residual(images, theta), tangent(beside), condition


def border_collision(
    equations: OrbitEquations, before: OrbitState, near: tuple[Array, float], point: int, which: int
) -> tuple[Bifurcation, OrbitState, Array | None] | None:
    """The collision of θ_point with the break ``which`` of ``before``, near (θ, p); None when there
    is none.

    Newton's method on the extended system: the orbit's equations with the map of the side it comes
    from, and θ_point on the break, which itself moves with the parameter. Returned are the record,
    the orbit there, beyond a kink with the slopes of the far side, and the scaled direction in
    which the branch leaves there, None at a jump.
    """
    gap = float(shorter_way(before.theta[point] - before.member.breaks[which]))
    side = 1 if gap > 0.0 else -1
    theta = np.array(near[0])
    p = near[1]
    last = np.inf
    for _ in range(_ITERATIONS):
        if not equations.within[0] <= p <= equations.within[1]:
            return None
        tangent = equations.push(p)
        theta[point] = (
            before.theta[point]
            - gap
            + break_motion(before.member.breaks, tangent.member.breaks)[which]
        )
        state, residual, push, condition = one_sided(equations, tangent, theta, point, side)
        extended = np.vstack([np.column_stack([equations.jacobian(state.slopes), push]), condition])
        try:
            moved = np.linalg.solve(extended, -np.append(residual, 0.0))
        except np.linalg.LinAlgError:
            return None
        size = float(np.max(np.abs(moved)))
        if size <= 1e-14 or (size < 1e-10 and size > 0.25 * last):
            break
        if not size < 1.0:
            return None
        theta = theta + moved[:-1]
        p = p + float(moved[-1])
        last = size
    else:
        return None
    beyond, _, far_push, far_condition = one_sided(equations, tangent, theta, point, -side)
    jump = bool(
        abs(float(state.member.right(theta[point]) - state.member.left(theta[point]))) > JUMP
    )
    right, left = (state, beyond) if side > 0 else (beyond, state)
    sides = right.multiplier, left.multiplier
    whole = np.append(residual, 0.0)
    record = recorded(
        "border-collision",
        equations,
        state,
        push,
        condition,
        whole,
        multipliers=sides,
        first=point,
        jump=jump,
    )
    if jump:
        return record, state, None
    outward = equations.direction(beyond.slopes, far_push)
    leaving = -side * float(far_condition @ (outward * equations.scales))
    return record, beyond, outward if leaving >= 0.0 else -outward
