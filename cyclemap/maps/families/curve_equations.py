"""Saddle-nodes, period doublings and border collisions in a plane of two parameters as solutions of
equations.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cyclemap.arrays import TWO_PI, Array, shorter_way
from cyclemap.checks import read_only
from cyclemap.maps.estimate import EPS, LIFT, STENCIL, Estimate
from cyclemap.maps.families.family import Family, Range, family_member, parameter_tangent
from cyclemap.maps.families.orbit_equations import (
    OrbitEquations,
    OrbitState,
    least_step,
    one_sided,
)
from cyclemap.maps.lifts.lift_checks import distance_to_break

KINDS = {"saddle-node": 1.0, "period-doubling": -1.0, "border-collision": 0.0}
_STEP = 1e-5  # of a range: for second-order differences in a parameter
# radians: spacing of the five-point differences of (F^n)'
_WIDE = 4e-3
_NARROW = 1e-6
_ITERATIONS = 12
_CLOSE = 1e-13
_ANGLES = np.linspace(0.0, TWO_PI, 64, endpoint=False)
_STENCILS = np.array([[1.0, -8.0, 0.0, 8.0, -1.0], [-1.0, 16.0, -30.0, 16.0, -1.0]]) / 12.0


@dataclass(frozen=True, eq=False)
class CodimensionTwo:
    """A point of a plane at which the bifurcation along a curve changes its kind.

    Attributes
    ----------
    kind : str
        "cusp" (of a saddle-node's curve: (F^n)'' = 0), "generalised flip" (of a period
        doubling's: the first Lyapunov coefficient is 0, and a curve of saddle-nodes of twice
        the period ends), "tip" (F^n is a rotation, as where the two edges of a tongue meet),
        "border saddle-node" and "border flip" (a multiplier of 1 or -1 while a point of the
        orbit is on a break of the map).
    first, second : Estimate
        The parameters.
    points : ndarray, shape (period,)
        Of the orbit, radians in [0, 2π).
    period, winding : int
        Of the orbit.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, follow_bifurcation, saddle_nodes
    >>> [born] = saddle_nodes(lambda p: CircleMap.arnold(p, 0.9), (0.0, 0.5))
    >>> edge = follow_bifurcation(CircleMap.arnold, born, 0.9, (0.0, 0.5), (-1.0, 2.0))
    >>> [tip] = edge.special
    >>> tip.kind, tip.first.holds(0.0), tip.second.holds(0.0)
    ('tip', True, True)
    """

    kind: str
    first: Estimate
    second: Estimate
    points: Array
    period: int
    winding: int


@dataclass(frozen=True, eq=False)
class CurveSpot:
    """A solution: scaled coordinates (θ/√n, p/range, q/range), the orbit, the equations' residual
    and derivative.
    """

    at: Array
    state: OrbitState
    residual: Array
    matrix: Array
    multipliers: list[float]
    hops: Array

    @cached_property
    def bend(self) -> tuple[Array, Array]:
        """(F^n)'' and (F^n)''' at the orbit's first point, and bounds: four times what half as wide
        stencils change. Narrower where a break is near: at half the distance at most.
        """
        growth = np.maximum(1.0, np.abs(np.cumprod(np.append(1.0, self.state.slopes[:-1]))))
        free = float(np.min(distance_to_break(self.state.member.breaks, self.state.theta) / growth))
        if free < 8.0 * _NARROW:  # at a break there is no such derivative
            return np.full(2, np.nan), np.full(2, np.inf)
        narrow = min(_WIDE, free / 8.0)
        found = []
        for width in (narrow, 2.0 * narrow):
            theta = self.state.theta[0] + width * np.arange(-2.0, 3.0)
            slopes = np.ones(5)
            for hop in self.hops:
                slopes *= self.state.member.derivative(theta)
                theta = self.state.member(theta) - TWO_PI * hop
            found.append(_STENCILS @ slopes / np.array([width, width**2]))
        rounding = STENCIL * self.hops.size / np.array([narrow, narrow**2])
        return found[0], np.abs(found[1] - found[0]) / 4.0 + rounding

    @property
    def halves(self) -> Array:
        """How far, radians, the point half a period later is from each; empty where the period is
        odd.
        """
        theta = self.state.theta
        half = self.hops.size // 2
        return np.roll(theta, -half) - theta if theta.size == 2 * half else np.zeros(0)

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
            theta = self.state.member(theta)
        return float(np.ptp(theta - _ANGLES))


@dataclass(frozen=True, eq=False)
class CurveEquations:
    """The orbit's n equations and the condition of the bifurcation, for θ and both parameters.

    side : of a border collision, from where the point comes to its break.
    jump : whether the map jumps there: then there is no orbit on the far side.
    """

    family: Family
    hops: Array
    winding: int
    kind: str
    ranges: tuple[Range, Range]
    side: int = 0
    jump: bool = False

    @cached_property
    def scales(self) -> Array:
        """Radians, and units of the parameters, to a unit of the scaled space."""
        spans = [high - low for low, high in self.ranges]
        return np.append(np.full(self.hops.size, np.sqrt(self.hops.size)), spans)

    def spot(self, at: Array) -> CurveSpot:
        """The equations at these scaled coordinates, their derivative by differences in the
        parameters.
        """
        theta = at[:-2] * self.scales[:-2]
        p, q = (float(np.clip(at[k] * self.scales[k], *self.ranges[k])) for k in (-2, -1))
        slices = (
            lambda first: family_member(self.family, first, q),
            lambda second: family_member(self.family, p, second),
        )
        tangents = [
            parameter_tangent(family, value, _STEP, within)
            for family, value, within in zip(slices, (p, q), self.ranges, strict=True)
        ]
        member = tangents[0].member
        equations = OrbitEquations(slices[0], self.hops, self.winding, self.ranges[0])
        if self.side:
            state, residual, first, along = one_sided(equations, tangents[0], theta, 0, self.side)
            _, _, second, across = one_sided(equations, tangents[1], theta, 0, self.side)
            beyond, *_ = one_sided(equations, tangents[0], theta, 0, -self.side)
            gap = shorter_way(theta[0] - member.breaks)
            missed = float(gap[np.argmin(np.abs(gap))])
            condition = np.append(along, across[-1])
            multipliers = [state.multiplier] if self.jump else [state.multiplier, beyond.multiplier]
        else:
            state = equations.state(p, theta, member)
            pushes = [tangent(theta) for tangent in tangents]
            residual = equations.residual(member(theta), theta)
            (first, second) = pushes
            missed = state.multiplier - KINDS[self.kind]
            condition = state.multiplier_gradient(tangents)
            multipliers = [state.multiplier]
        matrix = np.vstack(
            [np.column_stack([equations.jacobian(state.slopes), first, second]), condition]
        )
        return CurveSpot(
            at, state, np.append(residual, missed), matrix * self.scales, multipliers, self.hops
        )

    def solved(self, guess: Array, row: Array) -> CurveSpot | None:
        """The solution nearest to ``guess`` across ``row``, or None."""
        at = guess
        last = np.inf
        for _ in range(_ITERATIONS):
            for k in (-2, -1):
                low, high = self.ranges[k]
                if (
                    not low - 1e-9 * (high - low)
                    <= at[k] * self.scales[k]
                    <= high + 1e-9 * (high - low)
                ):
                    return None
            spot = self.spot(at)
            moved = least_step(
                np.vstack([spot.matrix, row]), -np.append(spot.residual, row @ (at - guess))
            )
            size = float(np.max(np.abs(moved)))
            if not size < 0.5:
                return None
            at = at + moved
            # A lift that is itself known to a tolerance only lets steps shrink to what that allows.
            if size <= _CLOSE or (
                size < 1e-9 + 1e3 * spot.state.member.max_error and size > 0.25 * last
            ):
                return self.spot(at)
            last = size
        return None

    def direction(self, spot: CurveSpot, along: Array | None = None) -> Array:
        """The unit tangent of the curve in the scaled space, turned towards ``along``."""
        unit = np.linalg.svd(spot.matrix)[2][-1]
        return np.asarray(-unit if along is not None and unit @ along < 0.0 else unit)

    def tests(self, spot: CurveSpot) -> Iterator[tuple[str, float, float]]:
        """What changes its sign at points of codimension two: their kind, the value and a bound on
        its error.
        """
        if self.side:
            for multiplier in spot.multipliers:
                yield "border saddle-node", multiplier - 1.0, 1e-9
                yield "border flip", multiplier + 1.0, 1e-9
        else:
            value, error = self.coefficient(spot)
            yield "cusp" if self.kind == "saddle-node" else "generalised flip", value, error

    def coefficient(self, spot: CurveSpot) -> tuple[float, float]:
        """Of the normal form, and a bound on its error."""
        if self.side:
            return float("nan"), float("inf")
        (second, third), (off, far) = (pair.tolist() for pair in spot.bend)
        if self.kind == "saddle-node":
            return second, off
        return 0.25 * second**2 + third / 6.0, 0.5 * abs(second) * off + 0.25 * off**2 + far / 6.0

    def recorded(
        self, kind: str, spot: CurveSpot, shift: float, tangent: Array, curved: float
    ) -> CodimensionTwo:
        """The point with bounds of first order: residual and rounding, and ``shift`` along the
        curve.
        """
        rounding = np.append(
            2.0 * LIFT * (2.0 * TWO_PI + np.abs(spot.state.theta)), 1e-15 * self.hops.size
        )
        rounding += spot.state.member.max_error
        if not self.side:
            slope_errors = spot.state.member.derivative_and_error(spot.state.theta)[1]
            rounding[-1] += np.abs(spot.state.other_slopes) @ slope_errors
        rows = np.abs(np.linalg.pinv(np.vstack([spot.matrix, tangent]))[-2:, :-1])
        error = (
            rows @ (np.abs(spot.residual) + rounding)
            + np.abs(tangent[-2:]) * shift
            + curved * shift**2
        )
        return self.placed(kind, spot, spot.at[-2:], error + 4.0 * EPS)

    def placed(self, kind: str, spot: CurveSpot, at: Array, error: Array) -> CodimensionTwo:
        """The point at scaled parameters with scaled errors."""
        first, second = (
            Estimate(*pair)
            for pair in zip(at * self.scales[-2:], error * self.scales[-2:], strict=True)
        )
        return CodimensionTwo(
            kind,
            first,
            second,
            read_only(np.mod(spot.state.theta, TWO_PI)),
            self.hops.size,
            self.winding,
        )
