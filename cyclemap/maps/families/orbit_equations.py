"""A periodic orbit as the solution of F(θ_i; p) = θ_{i+1} + 2πh_i: residual, Newton's method, direction in p."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Mask, shorter_way
from cyclemap.errors import InvalidInput
from cyclemap.maps.families.parameter_tangent import Family, ParameterTangent, Range, family_member, parameter_tangent
from cyclemap.maps.lifts.circle_map import CircleMap

_ITERATIONS = 12
_STEP = 1e-5  # of the range: for second-order differences in p
_LONGEST = 1.0  # scaled length of a Newton step that counts as lost
_CLOSE = 1e-13


@dataclass(frozen=True, eq=False)
class OrbitState:
    """A periodic orbit at one parameter: its points (radians, continuous along a branch) and their slopes F'.

    ``push`` is ∂F/∂p at the points where it is known, read at a parameter nearby: good enough for a prediction.
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


@dataclass(frozen=True, eq=False)
class OrbitEquations:
    """The n equations of a period-n orbit and the scaled space (θ/√n, p/scale) in which branches are followed.

    hops : shape (n,), whole turns taken off after each cycle. winding : of the orbit (for degree 1 their sum).
    within : the range of the parameter, outside which the family is never called; its length is the scale.
    """

    family: Family
    hops: Array
    winding: int
    within: Range

    @property
    def period(self) -> int:
        """n."""
        return int(self.hops.size)

    @property
    def scales(self) -> Array:
        """Radians, and units of the parameter, to a unit of the scaled space."""
        return np.append(np.full(self.period, np.sqrt(self.period)), self.within[1] - self.within[0])

    def member(self, p: float) -> CircleMap:
        """The family's map at ``p``."""
        return family_member(self.family, p)

    def push(self, p: float) -> ParameterTangent:
        """∂F/∂p at ``p``."""
        step = _STEP * (self.within[1] - self.within[0])
        return parameter_tangent(self.family, p, step=step, within=self.within, order=2)

    def residual(self, images: Array, theta: Array) -> Array:
        """F(θ_i) - θ_{i+1} - 2πh_i from the images F(θ_i)."""
        return np.asarray(images - np.roll(theta, -1) - TWO_PI * self.hops)

    def jacobian(self, slopes: Array) -> Array:
        """(n, n): derivative of the residual with respect to θ."""
        return np.diag(slopes) - np.roll(np.eye(self.period), 1, axis=1)

    def point(self, state: OrbitState) -> Array:
        """The state in the scaled space."""
        return np.append(state.theta, state.parameter) / self.scales

    def state(self, p: float, theta: Array, member: CircleMap | None = None) -> OrbitState:
        """The state at these points, not corrected."""
        at = member or self.member(p)
        return OrbitState(p, theta, at, np.asarray(at.derivative(theta)))

    def solved_at(self, p: float, theta: Array, member: CircleMap | None = None) -> OrbitState | None:
        """The orbit near ``theta`` at a fixed parameter, to rounding; None when Newton's method finds none."""
        at = member or self.member(p)
        last = np.inf
        for _ in range(_ITERATIONS):
            moved = _solved(self.jacobian(at.derivative(theta)), -self.residual(at(theta), theta))
            size = float(np.max(np.abs(moved)))
            if not size < _LONGEST:
                return None
            theta = theta + moved
            if size <= _CLOSE or (size < 1e-9 and size > 0.25 * last):
                return self.state(p, theta, at)
            last = size
        return None

    def solved_along(self, guess: Array, direction: Array) -> OrbitState | None:
        """The orbit nearest to ``guess`` across ``direction`` (both scaled), or None (Keller 1977)."""
        if not self._inside(guess):
            return None
        tangent = self.push(self._parameter(guess))
        at, last, point = tangent.member, np.inf, guess
        for _ in range(_ITERATIONS):
            theta = point[:-1] * self.scales[:-1]
            residual = self.residual(at(theta), theta)
            system = np.vstack([self._bordered(at.derivative(theta), tangent(theta)), direction])
            moved = _solved(system, -np.append(residual, direction @ (point - guess)))
            size, point = float(np.max(np.abs(moved))), point + moved
            if not size < _LONGEST or not self._inside(point):
                return None
            at = self.member(self._parameter(point))
            if size <= _CLOSE or (size < 1e-9 and size > 0.25 * last):
                theta = point[:-1] * self.scales[:-1]
                return replace(self.state(self._parameter(point), theta, at), push=tangent(theta))
            last = size
        return None

    def _parameter(self, point: Array) -> float:
        return float(np.clip(point[-1] * self.scales[-1], *self.within))

    def _inside(self, point: Array) -> bool:
        slack = 1e-12 * self.scales[-1]
        return bool(self.within[0] - slack <= point[-1] * self.scales[-1] <= self.within[1] + slack)

    def _bordered(self, slopes: Array, push: Array) -> Array:
        return np.asarray(np.column_stack([self.jacobian(slopes), push]) * self.scales)

    def direction(self, slopes: Array, push: Array, along: Array | None = None) -> Array:
        """The unit tangent of the branch in the scaled space, turned towards ``along``."""
        if along is not None:
            unit = _solved(np.vstack([self._bordered(slopes, push), along]), np.append(np.zeros(self.period), 1.0))
            return np.asarray(unit / np.linalg.norm(unit))
        _, _, rows = np.linalg.svd(self._bordered(slopes, push))
        return np.asarray(rows[-1])


def _solved(matrix: Array, right: Array) -> Array:
    try:
        return np.asarray(np.linalg.solve(matrix, right))
    except np.linalg.LinAlgError:
        # Right on a branch point: the shortest step is the one across both branches.
        return np.asarray(np.linalg.lstsq(matrix, right)[0])


def orbit_equations(family: Family, points: Array, parameter: float, winding: int, within: Range) -> OrbitEquations:
    """The equations of the orbit through ``points`` (nearly one of the family at ``parameter``, in order of visit)."""
    member = family_member(family, parameter)
    hops = np.round((member(points) - np.roll(points, -1)) / TWO_PI)
    turns = int(hops @ float(member.degree) ** np.arange(points.size - 1, -1, -1))
    if turns != winding:
        raise InvalidInput(
            f"the points wind {turns} times at {parameter:.9g}, not {winding}: give an orbit of that map"
        )
    return OrbitEquations(family, hops, winding, within)


def crossed_break(before: OrbitState, theta: Array, motion: Array) -> tuple[int, int, float] | None:
    """(point, break, share of the step) of the first break crossed on the way from ``before`` to ``theta``.

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
