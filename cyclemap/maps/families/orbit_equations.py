"""Periodic orbits as solutions of F(θ_i; p) = θ_{i+1} + 2πh_i in one or two parameters, alone or
with the condition of a bifurcation.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cyclemap.arrays import TWO_PI, Array, shorter_way
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import EPS, LIFT, STENCIL
from cyclemap.maps.families.family import (
    Family,
    ParameterTangent,
    Range,
    family_member,
    parameter_tangent,
)
from cyclemap.maps.lifts.branches import limit_at_break
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.lift_checks import JUMP, differences, distance_to_break

MULTIPLIERS = {"saddle-node": 1.0, "period-doubling": -1.0}
_ITERATIONS = 12
_STEP = 1e-5  # of the range: for second-order differences in p
_LONGEST = 1.0  # scaled length of a Newton step that counts as lost
_CLOSE = 1e-13
_ROUND_OFF = 2e-14  # radians: a residual that no step makes smaller
_SLACK = 1e-9  # of a range: solutions so little outside are at its end
_BESIDE = 1e-9  # radians: how far below a break ∂F/∂p is read for its limit from the left
# radians: spacing of the five-point differences of (F^n)'
_WIDE = 4e-3
_NARROW = 1e-6
_ANGLES = np.linspace(0.0, TWO_PI, 64, endpoint=False)
_STENCILS = np.array([[1.0, -8.0, 0.0, 8.0, -1.0], [-1.0, 16.0, -30.0, 16.0, -1.0]]) / 12.0


@dataclass(frozen=True, eq=False)
class OrbitState:
    """A periodic orbit: scaled coordinates (θ/√n, p/range, ...), its parameters, its points
    (radians, continuous along a branch), their slopes F'.

    hops : whole turns taken off after each cycle.
    residual, matrix : of the equations that it was made by, and their derivative by ``at``.
    """

    at: Array
    parameters: tuple[float, ...]
    theta: Array
    member: CircleMap
    slopes: Array
    hops: Array
    residual: Array
    matrix: Array

    @property
    def multiplier(self) -> float:
        """(Fⁿ)' along the orbit."""
        return float(np.prod(self.slopes))

    @property
    def other_slopes(self) -> Array:
        """The product of all slopes but each: how the multiplier moves with that one."""
        return _products_of_others(self.slopes)

    @property
    def halves(self) -> Array:
        """How far, radians, the point half a period later is from each; empty where the period is
        odd.
        """
        half, odd = divmod(self.theta.size, 2)
        return np.zeros(0) if odd else np.roll(self.theta, -half) - self.theta

    @property
    def gap(self) -> Array:
        """The same the shorter way round."""
        return shorter_way(self.halves)

    @cached_property
    def spread(self) -> float:
        """How far F^n is from a rotation: the largest less the least of F^n - id at 64 angles,
        radians.
        """
        theta = _ANGLES
        for _ in self.hops:
            theta = self.member(theta)
        return float(np.ptp(theta - _ANGLES))

    @cached_property
    def bend(self) -> tuple[Array, Array]:
        """(F^n)'' and (F^n)''' at the orbit's first point, and bounds: four times what half as wide
        stencils change. Narrower where a break is near: at half the distance at most.
        """
        growth = np.maximum(1.0, np.abs(np.cumprod(np.append(1.0, self.slopes[:-1]))))
        free = float(np.min(distance_to_break(self.member.breaks, self.theta) / growth))
        if free < 8.0 * _NARROW:  # at a break there is no such derivative
            return np.full(2, np.nan), np.full(2, np.inf)
        narrow = min(_WIDE, free / 8.0)
        near, far = (self._differences(width) for width in (narrow, 2.0 * narrow))
        rounding = STENCIL * self.hops.size / np.array([narrow, narrow**2])
        return near, np.abs(far - near) / 4.0 + rounding

    def _differences(self, width: float) -> Array:
        theta = self.theta[0] + width * np.arange(-2.0, 3.0)
        slopes = np.ones(5)
        for hop in self.hops:
            slopes *= self.member.derivative(theta)
            theta = self.member(theta) - TWO_PI * hop
        return np.asarray(_STENCILS @ slopes / np.array([width, width**2]))


def _products_of_others(slopes: Array) -> Array:
    return np.array([np.prod(np.delete(slopes, i)) for i in range(slopes.size)])


@dataclass(frozen=True, eq=False)
class OrbitEquations:
    """The n equations of a period-n orbit in the scaled space (θ/√n, p/range, ...), and with a
    ``kind`` one more: a multiplier of ±1, or a point on a break.

    family : of one or two parameters, never called outside their ``ranges``.
    hops : shape (n,), whole turns taken off after each cycle.
    winding : of the orbit (for degree 1 their sum).
    kind : "", "saddle-node", "period-doubling" or "border-collision".
    point, side : of a border collision, which point is on a break, and from where it comes (1
        above, -1 below): there the map is that of this side, gone on with beyond the break.
    """

    family: Family
    hops: Array
    winding: int
    ranges: tuple[Range, ...]
    kind: str = ""
    point: int = 0
    side: int = 0

    @cached_property
    def scales(self) -> Array:
        """Radians, and units of the parameters, to a unit of the scaled space."""
        spans = [high - low for low, high in self.ranges]
        return np.append(np.full(self.hops.size, np.sqrt(self.hops.size)), spans)

    def parameters(self, at: Array) -> tuple[float, ...]:
        """The parameters of scaled coordinates, inside their ranges."""
        values = (at * self.scales)[self.hops.size :]
        return tuple(np.clip(values, *np.transpose(self.ranges)).tolist())

    def tangents(self, at: Array) -> list[ParameterTangent]:
        """∂F by each of the parameters."""
        values = self.parameters(at)
        made = []
        for k, within in enumerate(self.ranges):

            def along(value: float, k: int = k) -> CircleMap:
                return family_member(self.family, *values[:k], value, *values[k + 1 :])

            made.append(parameter_tangent(along, values[k], _STEP, within))
        return made

    def state(self, at: Array, tangents: list[ParameterTangent] | None = None) -> OrbitState:
        """The orbit at these scaled coordinates, not corrected, and the equations there.

        tangents : ∂F by the parameters where they are known nearby: good enough for a step.
        """
        n = self.hops.size
        theta = at[:n] * self.scales[:n]
        parameters = self.parameters(at)
        tangents = tangents or self.tangents(at)
        member = family_member(self.family, *parameters)
        images = np.array(member(theta))
        slopes = np.array(member.derivative(theta))
        pushed = np.array(theta)
        gap = 0.0
        if self.side:
            gaps = shorter_way(theta[self.point] - member.breaks)
            gap = float(gaps[np.argmin(np.abs(gaps))])
            border = theta[self.point] - gap
            slopes[self.point] = member.derivative(border, self.side)
            limit = limit_at_break(member, border, self.side)
            images[self.point] = limit + slopes[self.point] * gap
            pushed[self.point] = border - _BESIDE * (self.side < 0)
        residual = images - np.roll(theta, -1) - TWO_PI * self.hops
        jacobian = np.diag(slopes) - np.roll(np.eye(n), 1, axis=1)
        matrix = np.column_stack([jacobian, *(tangent(pushed) for tangent in tangents)])
        if self.kind:
            missed, row = self._condition(member, theta, slopes, tangents, gap)
            residual = np.append(residual, missed)
            matrix = np.vstack([matrix, row])
        return OrbitState(
            at, parameters, theta, member, slopes, self.hops, residual, matrix * self.scales
        )

    def _condition(
        self,
        member: CircleMap,
        theta: Array,
        slopes: Array,
        tangents: list[ParameterTangent],
        gap: float,
    ) -> tuple[float, Array]:
        """What the condition of the bifurcation misses by, and its derivative."""
        if self.side:
            border = theta[self.point] - gap
            rates = [
                tangent.break_rates[np.argmin(np.abs(shorter_way(border - tangent.member.breaks)))]
                for tangent in tangents
            ]
            return gap, np.append(np.arange(theta.size) == self.point, np.negative(rates))
        bend, _ = differences(member.derivative, member.breaks, theta)
        others = _products_of_others(slopes)
        changes = [others @ tangent.of_slopes(theta, bend) for tangent in tangents]
        return float(np.prod(slopes)) - MULTIPLIERS[self.kind], np.append(others * bend, changes)

    def solved(self, guess: Array, rows: Array) -> OrbitState | None:
        """The solution nearest to ``guess`` across ``rows`` (both scaled), to rounding; None when
        Newton's method finds none (Keller 1977).
        """
        at = guess
        last = np.inf
        tangents = None if self.kind else self.tangents(guess)
        for _ in range(_ITERATIONS):
            beyond = at[self.hops.size :] - self.parameters(at) / self.scales[self.hops.size :]
            if np.max(np.abs(beyond)) > _SLACK:
                return None
            state = self.state(at, tangents)
            moved = least_step(
                np.vstack([state.matrix, rows]), -np.append(state.residual, rows @ (at - guess))
            )
            size = float(np.max(np.abs(moved)))
            if not size < _LONGEST:
                return None
            at = at + moved
            # A lift that is itself known to a tolerance only lets steps shrink to what that allows.
            least = 1e-9 + 1e3 * state.member.max_error
            if size <= _CLOSE or (size < least and size > 0.25 * last):
                return self.state(at, tangents)
            last = size
        # Near a tip the equations hold to rounding all around.
        return state if np.max(np.abs(state.residual)) < _ROUND_OFF else None

    def jumps(self, state: OrbitState) -> bool:
        """Whether the map jumps at the break on which the point of a border collision is."""
        border = state.theta[self.point]
        return bool(abs(float(state.member.right(border) - state.member.left(border))) > JUMP)

    def tests(self, state: OrbitState) -> list[tuple[str, float, float]]:
        """What changes its sign where something happens on the curve of solutions: its kind, the
        value and a bound on its error.
        """
        if not self.kind:
            return [(kind, state.multiplier - at, 0.0) for kind, at in MULTIPLIERS.items()]
        if not self.side:
            value, error = self.coefficient(state)
            return [("cusp" if self.kind == "saddle-node" else "generalised flip", value, error)]
        multipliers = [state.multiplier]
        if not self.jumps(state):
            beyond = state.member.derivative(state.theta[self.point], -self.side)
            multipliers.append(float(state.other_slopes[self.point] * beyond))
        return [
            (kind, multiplier - at, 1e-9)
            for multiplier in multipliers
            for kind, at in (("border saddle-node", 1.0), ("border flip", -1.0))
        ]

    def coefficient(self, state: OrbitState) -> tuple[float, float]:
        """Of the normal form of a saddle-node or a period doubling, and a bound on its error."""
        if self.side:
            return float("nan"), float("inf")
        (second, third), (off, far) = (pair.tolist() for pair in state.bend)
        if self.kind == "saddle-node":
            return second, off
        return 0.25 * second**2 + third / 6.0, 0.5 * abs(second) * off + 0.25 * off**2 + far / 6.0

    def errors(self, state: OrbitState, rows: Array) -> Array:
        """Bounds of first order on the errors of a solution's scaled parameters, solved across
        ``rows``: rows of the inverse times what the equations may be off by.

        That is the residual, rounding, the map's ``max_error``, and of a multiplier what the map
        tells of the errors of F'. A saddle-node's row is 0 at the multiplier, so that it does not
        move with F'; a period doubling does.
        """
        n = self.hops.size
        images = np.roll(state.theta, -1) + TWO_PI * self.hops
        off = np.append(
            LIFT * (TWO_PI + np.abs(images)),
            8.0 * EPS * n * max(1.0, abs(state.multiplier)),
        )
        off += np.abs(state.residual) + state.member.max_error
        if not self.side:
            off[-1] += (
                np.abs(state.other_slopes) @ state.member.derivative_and_error(state.theta)[1]
            )
        try:
            inverse = np.abs(np.linalg.inv(np.vstack([state.matrix, rows])))
        except np.linalg.LinAlgError:
            return np.full(len(self.ranges), np.inf)
        return np.asarray(inverse[n:, : n + 1] @ off)


def curve_direction(matrix: Array, along: Array | None = None) -> Array:
    """The unit tangent of the solutions of equations with this derivative, turned towards
    ``along``.
    """
    unit = np.linalg.svd(matrix)[2][-1]
    return np.asarray(-unit if along is not None and unit @ along < 0.0 else unit)


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
    return OrbitEquations(family, hops, winding, (within,))
