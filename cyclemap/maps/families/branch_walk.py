"""One walk along a branch of periodic orbits: steps in arclength, and what is met on the way."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from cyclemap.maps.arcs import Array, shorter_way
from cyclemap.maps.families.break_collisions import Collision, border_collision
from cyclemap.maps.families.orbit_equations import OrbitEquations, OrbitState, crossed_break
from cyclemap.maps.families.parameter_tangent import break_motion
from cyclemap.maps.families.special_points import Bifurcation, smooth_bifurcation

_FIRST, _LARGEST, _SMALLEST = 0.01, 0.08, 1e-8  # of the scaled arclength
_STRAIGHT = 0.95  # cosine of the largest turn of the tangent in one step
_GROWTH = 1.5


@dataclass(eq=False)
class BranchWalk:
    """A walk along the branch from one state in the direction ``initial``: what it has passed, why it ended."""

    equations: OrbitEquations
    first: OrbitState
    initial: Array
    allowed: int
    step: float = _FIRST
    reason: str = ""
    states: list[OrbitState] = field(default_factory=list)
    special: list[Bifurcation] = field(default_factory=list)
    direction: Array = field(default_factory=lambda: np.zeros(0))

    def walked(self) -> BranchWalk:
        """The walk, once it has ended."""
        self.states, self.direction = [self.first], self.initial
        while not self.reason:
            if len(self.states) > self.allowed:
                self.reason = "steps"
            elif self.step < _SMALLEST:
                self.reason = "lost"
            else:
                self._advance()
        return self

    @property
    def last(self) -> OrbitState:
        """Where the walk stands."""
        return self.states[-1]

    def _advance(self) -> None:
        """One attempt at a step: it succeeds, ends the walk, or halves the step."""
        here = self.equations.point(self.last)
        room = self._room(here)
        if room <= 1e-12:
            self.reason = "end of the range"
            return
        guess = here + min(self.step, room) * self.direction
        solved = self._at_end(guess) if room <= self.step else self.equations.solved_along(guess, self.direction)
        hit = self._collision(guess, solved)
        if hit is not None:
            self._pass(hit)
        elif solved is None or not self._accepted(solved):
            self.step *= 0.5
        elif room <= self.step:
            self.reason = self.reason or "end of the range"

    def _room(self, here: Array) -> float:
        """Length of the step along the direction that reaches an end of the range."""
        low, high = (end / self.equations.scales[-1] for end in self.equations.within)
        climb = self.direction[-1]
        if climb == 0.0:
            return np.inf
        return float(max(((high if climb > 0.0 else low) - here[-1]) / climb, 0.0))

    def _at_end(self, guess: Array) -> OrbitState | None:
        low, high = self.equations.within
        return self.equations.solved_at(high if self.direction[-1] > 0.0 else low, self._angles(guess))

    def _angles(self, point: Array) -> Array:
        return np.asarray(point[:-1] * self.equations.scales[:-1])

    def _accepted(self, solved: OrbitState) -> bool:
        """Take the step to ``solved`` unless it is too far, too bent or crosses a break that was not located."""
        here, there = self.equations.point(self.last), self.equations.point(solved)
        push = self.equations.push(solved.parameter)(solved.theta) if solved.push is None else solved.push
        direction = self.equations.direction(solved.slopes, push, self.direction)
        change = abs(solved.multiplier - self.last.multiplier)
        if (
            np.linalg.norm(there - here) > 2.0 * self.step
            or direction @ self.direction < _STRAIGHT
            or (change > 0.5 + 0.5 * abs(self.last.multiplier) and self.step > 1e-4)
            or self._crossed(self._angles(there), solved) is not None
        ):
            return False
        self._take(solved, direction)
        return True

    def _take(self, solved: OrbitState, direction: Array) -> None:
        before = self.last
        if self._halves(before, solved):
            self.reason = "half the period"
            return
        for target in (1.0, -1.0):
            if (before.multiplier - target) * (solved.multiplier - target) < 0.0:
                state, found = smooth_bifurcation(self.equations, before, solved, self.direction, target)
                self.states.append(state)
                self.special.append(found)
        again = self._closing(before, solved, direction)
        self.states.append(solved if again is None else again)
        self.reason = "" if again is None else "closed"
        self.direction, self.step = direction, min(_GROWTH * self.step, _LARGEST)

    def _halves(self, before: OrbitState, solved: OrbitState) -> bool:
        """Whether the orbit has passed through one of half its period, where its two halves change places."""
        half = self.equations.period // 2
        if self.equations.period != 2 * half:
            return False
        old, new = (np.roll(state.theta, -half) - state.theta for state in (before, solved))
        gap = shorter_way(old)
        return float(gap @ (gap + new - old)) <= 0.0 or float(np.max(np.abs(gap + new - old))) < 1e-9

    def _closing(self, before: OrbitState, solved: OrbitState, direction: Array) -> OrbitState | None:
        """The first state, on this step's whole turns and choice of the first point, if it lies on the step."""
        if len(self.states) < 6 or abs(before.parameter - self.first.parameter) > self._reach(before, solved):
            return None
        step = self.equations.point(solved) - self.equations.point(before)
        for k in range(self.equations.period):
            back = shorter_way(np.roll(self.first.theta, -k) - before.theta)
            offset = np.append(back, self.first.parameter - before.parameter) / self.equations.scales
            share = float(offset @ step) / float(step @ step)
            heading = np.append(np.roll(self.initial[:-1], -k), self.initial[-1])
            if 0.0 < share <= 1.0 and np.linalg.norm(offset - share * step) < 0.3 * np.linalg.norm(step):
                rolled = replace(
                    self.first, theta=before.theta + back, slopes=np.roll(self.first.slopes, -k), push=None
                )
                return rolled if heading @ direction > 0.5 else None
        return None

    def _reach(self, before: OrbitState, solved: OrbitState) -> float:
        return 2.0 * abs(solved.parameter - before.parameter) + 1e-3 * float(self.equations.scales[-1])

    # -- breaks ----------------------------------------------------------------------------------------------

    def _crossed(self, theta: Array, state: OrbitState | None) -> tuple[int, int, float] | None:
        if self.last.member.breaks.size == 0:
            return None
        member = state.member if state is not None else self.last.member
        return crossed_break(self.last, theta, break_motion(self.last.member.breaks, member.breaks))

    def _collision(self, guess: Array, solved: OrbitState | None) -> Collision | None:
        """The collision with a break on this step, whether the step or only its prediction crosses it."""
        reached = guess if solved is None else self.equations.point(solved)
        crossed = self._crossed(self._angles(reached), solved) or self._crossed(self._angles(guess), None)
        if crossed is None:
            return None
        point, which, share = crossed
        here = self.equations.point(self.last)
        near = here + share * (reached - here)
        p = float(np.clip(near[-1] * self.equations.scales[-1], *self.equations.within))
        found = border_collision(self.equations, self.last, (self._angles(near), p), point, which)
        if found is None:
            return None
        offset = self.equations.point(found.state) - here
        ahead = float(offset @ self.direction) > 0.0
        return found if ahead and float(np.linalg.norm(offset)) <= 2.0 * self.step else None

    def _pass(self, hit: Collision) -> None:
        self.special.append(hit.bifurcation)
        self.states.append(hit.state)
        if hit.beyond is None or hit.outward is None:
            self.reason = "jump"
            return
        self.states[-1] = hit.beyond
        self.direction, self.step = hit.outward, min(self.step, _FIRST)
