"""Curves of orbits followed in their arclength (Keller 1977): how far a step goes, what is met on
the way, where the range ends, loops that close.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Generic, Self, TypeVar

import numpy as np

from cyclemap.arrays import Array, Mask, shorter_way
from cyclemap.errors import ConvergenceError
from cyclemap.maps.families.family import break_motion
from cyclemap.maps.families.orbit_equations import OrbitEquations, OrbitState, curve_direction
from cyclemap.maps.lifts.circle_map import CircleMap
from cyclemap.maps.lifts.scan import root_between

FIRST = 0.01  # scaled arclength of the first step
SMALLEST = 1e-8  # of a step that finds no way on
_STRAIGHT = 0.95  # cosine of the largest turn of the tangent in one step
_LARGEST = 0.06
_GROWTH = 1.5
_MOST_STEPS = 4_000

Special = TypeVar("Special")


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
        self._tested(here, solved, direction)
        self.taken(here, solved, direction)
        return True

    def _tested(self, here: OrbitState, solved: OrbitState, direction: Array) -> None:
        """Record what happens between two neighbouring solutions."""
        length = float(self.direction @ (solved.at - here.at))
        curved = float(np.linalg.norm(direction - self.direction)) / length
        tests = zip(self.equations.tests(here), self.equations.tests(solved), strict=True)
        for index, ((kind, before, off), (_, after, far)) in enumerate(tests):
            if before * after < 0.0 and abs(before) > off and abs(after) > far:
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
        """Go on from ``here`` to ``solved``, or to the first solution where the step passes it, but
        for whole turns and the choice of the first point.
        """
        first = self._passed(here.at, solved.at, direction)
        if first is not None:
            self.reason = "closed"
            solved = self.equations.state(first)
        self.states.append(solved)
        self.direction = direction
        self.step = min(_GROWTH * self.step, _LARGEST)

    def _passed(self, here: Array, there: Array, direction: Array) -> Array | None:
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
