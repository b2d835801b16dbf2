"""Periodic orbits as solutions of F(θ_i; p) = θ_{i+1} + 2πh_i in one or two parameters, alone or
with the condition of a bifurcation; and curves of them followed in their arclength (Keller 1977):
how far a step goes, what is met on the way, where the range ends, loops that close.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Generic, Self, TypeVar

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Mask, shorter_way
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps.estimate import EPS, LIFT, STENCIL
from cyclemap.maps.families.family import (
    Family,
    ParameterTangent,
    Range,
    break_motion,
    family_member,
    parameter_tangent,
)
from cyclemap.maps.lifts.branches import limit_at_break
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.lift_checks import JUMP, differences, distance_to_break
from cyclemap.maps.lifts.scan import root_between

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
FIRST = 0.01  # scaled arclength of the first step
SMALLEST = 1e-8  # of a step that finds no way on
_STRAIGHT = 0.95  # cosine of the largest turn of the tangent in one step
_LARGEST = 0.06
_GROWTH = 1.5
_MOST_STEPS = 4_000

Special = TypeVar("Special")


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


@dataclass(eq=False)
class ArclengthWalk(Generic[Special]):
    """A walk along the solutions of ``equations`` from ``states[0]`` in the direction ``initial``:
    where it has been, what it has met (``special``), why it ended.

    blocked : what the last step that was refused ran into.
    """

    equations: OrbitEquations
    states: list[OrbitState]
    initial: Array
    special: list[Special] = field(default_factory=list)
    step: float = FIRST
    reason: str = ""
    blocked: str = "lost"
    direction: Array = field(init=False)

    def walked(self) -> Self:
        """The walk, once it has ended."""
        self.direction = self.initial
        while not self.reason:
            if len(self.states) > _MOST_STEPS:
                self.reason = "steps"
            elif self.step < SMALLEST:
                self.stop()
            else:
                self.advance()
        return self

    def stop(self) -> None:
        """End where steps have become too small."""
        self.reason = self.blocked

    def advance(self) -> None:
        """One attempt at a step: it succeeds, ends the walk, or halves the step."""
        length, row, at_end = self._ahead()
        end = "end of the plane" if self.equations.kind else "end of the range"
        if length <= 1e-12:
            self.reason = end
            return
        guess = self.states[-1].at + length * self.direction
        solved = self.equations.solved(guess, row)
        if self.meets_break(guess, solved):
            return
        if solved is None or not self._accepted(solved):
            self.step *= 0.5
        elif at_end:
            self.reason = self.reason or end

    def meets_break(self, guess: Array, solved: OrbitState | None) -> bool:
        """Whether the walk has gone on by itself because this step meets a break."""
        raise NotImplementedError

    def passes(self, kind: str, state: OrbitState, shift: float, curved: float) -> None:
        """Record what is met at ``state``, which may be ``shift`` off along a curve so ``curved``
        (all scaled).
        """
        raise NotImplementedError

    def _ahead(self) -> tuple[float, Array, bool]:
        """The length of the next step, across what it is corrected, and whether it leads to an end
        of the ranges.
        """
        here = self.states[-1].at
        length = self.step
        row = self.direction
        at_end = False
        for k, (low, high) in enumerate(self.equations.ranges, start=self.equations.hops.size):
            climb = float(self.direction[k])
            end = (high if climb > 0.0 else low) / self.equations.scales[k]
            room = max((end - here[k]) / climb, 0.0) if climb else np.inf
            if room <= length:
                length = room
                row = np.eye(here.size)[k]
                at_end = True
        return length, row, at_end

    def crossed(self, at: Array, member: CircleMap | None) -> tuple[int, int, float] | None:
        """(point, side it comes from, share of the step) of the first break that is crossed on the
        way to ``at``, the breaks moving to those of ``member``; None when none is.
        """
        here = self.states[-1]
        breaks = here.member.breaks
        if breaks.size == 0:
            return None
        theta = (at * self.equations.scales)[: here.theta.size]
        motion = 0.0 if member is None else break_motion(breaks, member.breaks)
        old = shorter_way(here.theta[:, None] - breaks)
        new = old + (theta - here.theta)[:, None] - motion
        crossed: Mask = (old * new < 0.0) & (np.abs(old) < 1.0) & (np.abs(old) > 1e-11)
        if not np.any(crossed):
            return None
        share = np.where(crossed, np.abs(old) / np.where(crossed, np.abs(old - new), 1.0), np.inf)
        place = np.unravel_index(int(np.argmin(share)), share.shape)
        return int(place[0]), int(np.sign(old[place])), float(share[place])

    def _accepted(self, solved: OrbitState) -> bool:
        """Take the step to ``solved`` unless it is too far, too bent or crosses what it must stop
        before.
        """
        here = self.states[-1]
        direction = curve_direction(solved.matrix, self.direction)
        change = abs(solved.multiplier - here.multiplier)
        if (
            np.linalg.norm(solved.at - here.at) > 2.0 * self.step
            or direction @ self.direction < _STRAIGHT
            or (change > 0.5 + 0.5 * abs(here.multiplier) and self.step > 1e-4)
            or self.crossed(solved.at, solved.member) is not None
        ):
            return False
        # Through an orbit of half the period, where the two halves change places?
        ahead = here.gap + solved.halves - here.halves
        if ahead.size and ((here.gap @ ahead) <= 0.0 or np.max(np.abs(ahead)) < 1e-9):
            self.blocked = "half the period"
            if not self.equations.kind:
                self.stop()
            return bool(self.reason)
        first = self._passed(here.at, solved.at, direction)
        if first is not None:
            self.reason = "closed"
            solved = self.equations.state(first)
        self._tested(here, solved, direction)
        self.taken(here, solved, direction)
        return True

    def _tested(self, here: OrbitState, solved: OrbitState, direction: Array) -> None:
        """Record what happens between two neighbouring solutions, 0 counted as below it: what
        happens on one of them is met once.
        """
        length = float(self.direction @ (solved.at - here.at))
        if length <= 0.0:
            return
        curved = float(np.linalg.norm(direction - self.direction)) / length
        # A loop ends with the signs that it began with, and not with those of another rounding.
        ended = self.reason == "closed" and not self.equations.kind
        end = self.states[0] if ended else solved
        tests = zip(self.equations.tests(here), self.equations.tests(end), strict=True)
        for index, ((kind, before, off), (_, after, far)) in enumerate(tests):
            if (before > 0.0) != (after > 0.0) and abs(before) >= off and abs(after) >= far:
                state = self._located(index, here, solved, length)
                error = self.equations.tests(state)[index][2]
                self.passes(kind, state, 4.0 * error * length / abs(after - before), curved)

    def _located(
        self, index: int, here: OrbitState, solved: OrbitState, length: float
    ) -> OrbitState:
        """The solution at which a test is 0, between two that are ``length`` apart, by its sign
        there.
        """
        known = {0.0: here, length: solved}

        def value(distance: float) -> float:
            if distance not in known:
                guess = here.at + distance * self.direction
                state = self.equations.solved(guess, self.direction)
                if state is None:
                    kind, _, _ = self.equations.tests(here)[index]
                    given = ", ".join(f"{parameter:.9g}" for parameter in here.parameters)
                    raise ConvergenceError(
                        f"the orbit of period {here.theta.size} near parameter {given} was lost "
                        f"on the way to its {kind}"
                    )
                known[distance] = state
            return self.equations.tests(known[distance])[index][1]

        return known[root_between(value, 0.0, length)]

    def taken(self, here: OrbitState, solved: OrbitState, direction: Array) -> None:
        """Go on from ``here`` to ``solved``."""
        self.states.append(solved)
        self.direction = direction
        self.step = min(_GROWTH * self.step, _LARGEST)

    def _passed(self, here: Array, there: Array, direction: Array) -> Array | None:
        """The first solution where the step passes it, but for whole turns and the choice of the
        first point.
        """
        begin = self.states[0].at
        n = self.equations.hops.size
        moved = there - here
        length = float(np.linalg.norm(moved))
        away = begin[n:] - here[n:]
        if len(self.states) < 6 or np.linalg.norm(away) > 1.5 * length:
            return None
        turn = self.equations.scales[0]
        for k in range(n):
            back = shorter_way(turn * (np.roll(begin[:n], -k) - here[:n])) / turn
            offset: Array = np.append(back, away)
            share = float(offset @ moved) / length**2
            heading = np.append(np.roll(self.initial[:n], -k), self.initial[n:])
            near = np.linalg.norm(offset - share * moved) < 0.3 * length
            if -1e-9 < share <= 1.0 and near and heading @ direction > 0.5:
                return here + offset
        return None


def walked_both_ways(
    begun: Callable[[Array], ArclengthWalk[Special]], direction: Array
) -> tuple[list[OrbitState], tuple[Special, ...], tuple[str, str]]:
    """The solutions on both sides of the first, what was met, and why both walks ended.

    begun : the walk in a direction.
    """
    forward = begun(direction).walked()
    if forward.reason == "closed":
        return forward.states, tuple(forward.special), ("closed", "closed")
    backward = begun(-direction).walked()
    return (
        backward.states[:0:-1] + forward.states,
        (*backward.special[::-1], *forward.special),
        (backward.reason, forward.reason),
    )
