"""Integrates a motion while its margins stay positive, and lands on the place where the first one vanishes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.errors import ConvergenceError, TooManySteps
from cyclemap.mechanics.motion import STICK, Motion
from cyclemap.mechanics.motion_functions import MARGINS
from cyclemap.mechanics.runge_kutta import MARGIN, UNKNOWN, C, Step, next_length

# A margin this share of the tolerance's root below zero still counts as kept, and a place where one is that near to
# zero as landed on: rates are continuous from one law to the next, so that what is wrong is of its square ...
SLACK_SHARE = 0.03
# ... but for a rod that leaves while it sticks, and a point that passes a corner: rates jump there, and the slack is
# this share of the tolerance itself.
STRICT_SHARE = 0.1
# A margin that dips this many slacks below zero at a stage, though not at the step's end, calls for a shorter step.
DIP = 30.0
# A step this short is taken even if a margin is broken on it.
LEAST_ADVANCE = 1e-9
# A motion that cannot go on by this much, where a margin is zero, has ended there.
STUCK = 1e-8
# Steps above this share of the length are made in one call or not at all: shorter ones are cheaper than certainty.
SHORT = 0.01
MOST_STEPS = 20_000
# A leg of a drag this short, extents, is none.
NO_LEG = 1e-12
# First steps to try, extents: where they are too long, the estimate of their error may flatter.
FIRST_PUSH_STEP, FIRST_DRAG_STEP = 0.07, 0.12

# The stages in the order of their places along a step; the end, last, in place of the stage beside it.
STAGE_ORDER = np.array([i for i in np.argsort(C, kind="stable").tolist() if C[i] < 1.0] + [len(C)])
STAGE_PLACES = np.append(C, 1.0)[STAGE_ORDER]


@dataclass(frozen=True)
class Phase:
    """A stretch under one law: its steps, the margin that ended it (None: the length was reached), next step size."""

    steps: Sequence[Step]
    broken: int | None
    next_h: float

    @property
    def length(self) -> float:
        """Rod travel over the stretch."""
        return math.fsum(taken.h for taken in self.steps)


def integrate(
    motion: Motion,
    state: NDArray[np.float64],
    length: float,
    tolerance: float,
    first_h: float,
    longest_h: float = math.inf,
) -> Phase:
    """Integrate a motion over `length`, or until a margin falls below zero.

    `tolerance` bounds the error estimate of each step (maximum norm). Where a margin breaks, the last step is
    shortened until it is zero to within what changes the state by less than that. Raises ConvergenceError when the
    steps needed are too short, TooManySteps when they are too many.
    """
    steps: list[Step] = []
    done, h, slack = 0.0, first_h, _slack(motion, tolerance)
    # After a step that was too long the next one grows no further.
    refused = False
    motion.evaluate(state)
    while done < length:
        if len(steps) > MOST_STEPS:
            raise _too_many(h, done, length)
        if h < 1e-15 * length:
            raise ConvergenceError(f"the motion needs steps below {h:.2e} at {done:.6g} of {length:.6g}: state {state}")
        tried = min(h, length - done, longest_h)
        taken = _attempt(motion, state, tried, tolerance, fast=tried > SHORT * length)
        if taken is None or not taken.error <= tolerance:
            ended = _ended(steps, slack) if tried <= max(tolerance, STUCK) else None
            if ended is not None:
                return Phase(tuple(steps), ended, first_h)
            h = 0.5 * tried if taken is None else next_length(tried, taken.error, tolerance)
            refused = True
            continue
        least, broken = (math.inf, None) if motion.in_ring else _broken(taken, slack)
        if broken is None and least < -DIP and tried > 1e-4 * length:
            h = 0.4 * tried
            continue
        if broken is not None and tried > LEAST_ADVANCE:
            taken, broken = _land(motion, state, taken, tolerance, slack)
        steps.append(taken)
        motion.unknowns = taken.stages[-1, UNKNOWN].tolist()
        done, state = done + taken.h, taken.end
        # A last short step says nothing about the size that the next phase can take.
        if taken.h == h:
            h = min(next_length(tried, taken.error, tolerance), h if refused else math.inf)
        refused = False
        if broken is not None:
            return Phase(tuple(steps), broken, h)
        if length - done <= 1e-14 * length:
            break
    return Phase(tuple(steps), None, h)


def _too_many(h: float, done: float, length: float) -> TooManySteps:
    return TooManySteps(
        f"the motion turns so abruptly towards its steady course that it needs more than {MOST_STEPS} steps, now of "
        f"{h:.2e} at {done:.6g} of {length:.6g} extents: ask for a shorter way or less accuracy, or take a friction "
        "law nearer to isotropic, a footprint that leans less, or a thicker outline"
    )


def _attempt(motion: Motion, state: NDArray[np.float64], h: float, tolerance: float, fast: bool = False) -> Step | None:
    """Return a step, or None where a stage cannot be solved: a mode's equations may end just beyond the mode itself."""
    unknowns = list(motion.unknowns)
    try:
        return motion.fast_step(state, h, tolerance) if fast else motion.step(state, h, tolerance)
    except ConvergenceError:
        if h <= LEAST_ADVANCE:
            raise
        motion.unknowns = unknowns
        return None


def _broken(taken: Step, slack: NDArray[np.float64]) -> tuple[float, int | None]:
    """Return the least margin of a step, in slacks, and which one is broken at its end."""
    relative = taken.stages[:, MARGIN] / slack
    least = float(relative.min())
    return least, int(relative[-1].argmin()) if least < -1.0 and relative[-1].min() < -1.0 else None


def _ended(steps: list[Step], slack: NDArray[np.float64]) -> int | None:
    """Return the margin that is zero to within its slack, if there is one: no step leads on from there."""
    if not steps:
        return None
    relative = steps[-1].stages[-1, MARGIN] / slack
    return int(relative.argmin()) if relative.min() <= 1.0 else None


def _slack(motion: Motion, tolerance: float) -> NDArray[np.float64]:
    """How far below zero each margin may go, less for those where the motion changes at once."""
    slack = np.full(MARGIN.stop - MARGIN.start, SLACK_SHARE * math.sqrt(tolerance))
    if motion.mode == STICK:
        slack[MARGINS.index("approach")] = STRICT_SHARE * tolerance
    if motion.rod.radius == 0.0:
        slack[[MARGINS.index("after_low"), MARGINS.index("before_high")]] = STRICT_SHARE * tolerance
    return slack


def _land(
    motion: Motion, state: NDArray[np.float64], taken: Step, tolerance: float, slack: NDArray[np.float64]
) -> tuple[Step, int]:
    """Shorten a step until the first margin to break is zero: secants on the step's length inside a bracket."""
    unknowns = list(motion.unknowns)
    low, high = 0.0, taken.h
    broken, h, slope = _first_crossing(taken, slack)
    before = (math.nan, math.nan)
    for iteration in range(400):
        h = max(h, LEAST_ADVANCE)
        motion.unknowns = list(unknowns)
        attempt = _attempt(motion, state, h, tolerance)
        if attempt is None:
            high, h, before = h, 0.5 * (low + h), (math.nan, math.nan)
            continue
        taken = attempt
        relative = taken.stages[-1, MARGIN] / slack
        if relative[broken] > 1.0 and relative.min() < -1.0:
            broken, slope, before = int(relative.argmin()), math.nan, (math.nan, math.nan)
        margin = float(relative[broken])
        if abs(margin) <= 1.0 or h <= LEAST_ADVANCE or high - low <= 1e-13:
            return taken, broken
        low, high = (low, h) if margin < 0.0 else (h, high)
        if h != before[0]:
            secant = (margin - before[1]) / (h - before[0])
            slope = slope if math.isnan(secant) else secant
        before = (h, margin)
        h = h - margin / slope if slope < 0.0 else math.nan
        # Secants creep where a margin jumps, as it may between support points: now and then the bracket is halved.
        if not low < h < high or iteration % 8 == 7:
            h = 0.5 * (low + high)
    raise ConvergenceError(f"the place where margin {broken} of a contact mode ends could not be located: {margin}")


def _first_crossing(taken: Step, slack: NDArray[np.float64]) -> tuple[int, float, float]:
    """Return the margin that breaks first, where, and its slope (in slacks) there, as the stages tell roughly."""
    order = STAGE_ORDER
    places, margins = STAGE_PLACES * taken.h, taken.stages[order][:, MARGIN] / slack
    crossings = []
    for index in np.flatnonzero(margins[-1] < -1.0).tolist():
        after = max(int(np.argmax(margins[:, index] < -1.0)), 1)
        a, b = max(margins[after - 1, index], 0.0), margins[after, index]
        width = places[after] - places[after - 1]
        crossings.append((float(places[after - 1] + width * a / (a - b)), index, float((b - a) / width)))
    place, index, slope = min(crossings)
    return index, place, slope
