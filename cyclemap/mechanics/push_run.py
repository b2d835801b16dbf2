"""A straight push in normalised units: phases of sticking and sliding on sides and around corners, joined."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.errors import ConvergenceError, InvalidInput, UnsupportedContact
from cyclemap.mechanics.contact_curve import STRAIGHT, OutlinePiece, SidePiece
from cyclemap.mechanics.contact_solver import ContactSolver, NoSlip
from cyclemap.mechanics.event_integration import FIRST_PUSH_STEP, Phase, integrate
from cyclemap.mechanics.motion import SLIDE_FREE, SLIDE_LEFT, SLIDE_RIGHT, STICK, Motion, Rod
from cyclemap.mechanics.motion_functions import MARGINS
from cyclemap.mechanics.runge_kutta import MARGIN

_APPROACH, _AFTER_LOW, _BEFORE_HIGH, _FIRST, _SECOND = range(len(MARGINS))
MOST_PHASES = 10_000


@dataclass(frozen=True)
class RunPhase:
    """A stretch of a run under one motion, and the state it started from."""

    motion: Motion
    start: NDArray[np.float64]
    phase: Phase


@dataclass(frozen=True)
class PushRun:
    """The phases of a push, its end state (theta, coordinate of the last piece) and why it ended: distance or left."""

    phases: tuple[RunPhase, ...]
    end: NDArray[np.float64]
    ended: str

    @property
    def length(self) -> float:
        """Rod travel in contact, extents."""
        return math.fsum(phase.phase.length for phase in self.phases)


@dataclass(frozen=True)
class PushStart:
    """Where a push starts: piece of the contact curve, coordinate on it, orientation (rad)."""

    piece: int
    coordinate: float
    theta: float


def run_push(
    solver: ContactSolver,
    pieces: tuple[OutlinePiece, ...],
    start: PushStart,
    rod: Rod,
    length: float,
    tolerance: float,
    longest_step: float = math.inf,
) -> PushRun:
    """Push over `length` (extents of rod travel), or until the rod leaves, with a step error of `tolerance`.

    Raises InvalidInput if the rod moves away from the outline at the start, UnsupportedContact where it would touch
    two sides at once, or slide without bound, ConvergenceError where the contact cannot be solved.
    """
    with _slip_is_bounded(rod):
        index, left, h = start.piece, length, FIRST_PUSH_STEP
        state = np.array((start.theta, start.coordinate))
        motion = _first_motion(solver, pieces[index], rod, state)
        phases: list[RunPhase] = []
        for _ in range(MOST_PHASES):
            phase = integrate(motion, state, left, tolerance, h, longest_step)
            phases.append(RunPhase(motion, state, phase))
            state, h, left = phase.steps[-1].end, phase.next_h, left - phase.length
            if phase.broken is None or phase.broken == _APPROACH or left <= 1e-14 * length:
                return PushRun(tuple(phases), state, "left" if phase.broken == _APPROACH else "distance")
            if phase.broken in (_AFTER_LOW, _BEFORE_HIGH):
                forward = phase.broken == _BEFORE_HIGH
                neighbour = (index + (1 if forward else -1)) % len(pieces)
                across = _across(pieces[index], pieces[neighbour], forward, state, rod)
                if rod.radius == 0.0 and _turned_away(pieces[neighbour], rod, across):
                    return PushRun(tuple(phases), state, "left")
                state = across
                index, motion = neighbour, _same_mode(motion, pieces[neighbour], state)
            else:
                motion = _other_mode(motion, state, phase.broken)
        raise ConvergenceError(f"the contact changes its mode more than {MOST_PHASES} times: it chatters at {state}")


@contextmanager
def _slip_is_bounded(rod: Rod) -> Iterator[None]:
    try:
        yield
    except NoSlip as cause:
        raise UnsupportedContact(
            f"no slip of the rod, however fast, balances the surface's friction at pusher friction {rod.friction:.3g}: "
            "the friction is too one-sided for this push; choose a lower pusher friction or a smaller offset m0, n0"
        ) from cause


def _first_motion(solver: ContactSolver, piece: OutlinePiece, rod: Rod, state: NDArray[np.float64]) -> Motion:
    """Stick if the force that sticking needs lies in the friction cone, else slide the way it points."""
    stick = Motion(solver, piece, STICK, rod)
    margins = stick.evaluate(state)[MARGIN]
    if margins[_APPROACH] <= 0.0:
        raise InvalidInput(
            "the push points away from the object: its direction must have a component into the side that it touches"
        )
    if margins[_FIRST] >= 0.0 and margins[_SECOND] >= 0.0 and rod.friction > 0.0:
        return stick
    return _other_mode(stick, state, _FIRST if margins[_FIRST] < margins[_SECOND] else _SECOND)


def _other_mode(motion: Motion, state: NDArray[np.float64], broken: int) -> Motion:
    """Return the motion on the other side of a broken margin, its unknowns those of the same twist."""
    contact, _ = motion.piece.contact(float(state[1]), motion.rod.radius)
    off = contact.normal + float(state[0]) - motion.rod.direction
    approach, along = -math.cos(off), -math.sin(off)
    if motion.slides:
        stick = Motion(motion.solver, motion.piece, STICK, motion.rod)
        stick.unknowns = [approach * motion.unknowns[0]]
        return stick
    mode = SLIDE_FREE if motion.rod.friction == 0.0 else SLIDE_LEFT if broken == _FIRST else SLIDE_RIGHT
    slide = Motion(motion.solver, motion.piece, mode, motion.rod)
    slide.unknowns = [motion.unknowns[0] / max(approach, 1e-6), along / max(approach, 1e-6)]
    return slide


def _same_mode(motion: Motion, piece: OutlinePiece, state: NDArray[np.float64]) -> Motion:
    """Return the same mode on the next piece; a point that passes a corner starts afresh, its normal having jumped."""
    if motion.rod.radius == 0.0:
        return _first_motion(motion.solver, piece, motion.rod, state)
    following = Motion(motion.solver, piece, motion.mode, motion.rod)
    following.unknowns = list(motion.unknowns)
    return following


def _turned_away(piece: OutlinePiece, rod: Rod, state: NDArray[np.float64]) -> bool:
    """Whether a rod that comes around a corner without radius finds the next side facing away: it leaves there."""
    contact, _ = piece.contact(float(state[1]), rod.radius)
    return math.cos(contact.normal + float(state[0]) - rod.direction) >= 0.0


def _across(
    old: OutlinePiece, new: OutlinePiece, forward: bool, state: NDArray[np.float64], rod: Rod
) -> NDArray[np.float64]:
    """Return the state on the next piece; what the last step overshot is carried over at the same speed."""
    _refuse_concave(old, new, forward)
    edge_old, edge_new = (old.high, new.low) if forward else (old.low, new.high)
    _, metric_old = old.contact(edge_old, rod.radius)
    _, metric_new = new.contact(edge_new, rod.radius)
    return np.array((state[0], edge_new + (state[1] - edge_old) * metric_old / metric_new))


def _refuse_concave(old: OutlinePiece, new: OutlinePiece, forward: bool) -> None:
    """Two sides that follow each other without a corner piece meet in a concave corner, unless the rod is a point."""
    if not (isinstance(old, SidePiece) and isinstance(new, SidePiece)):
        return
    before, after = (old, new) if forward else (new, old)
    if math.sin(after.normal - before.normal) < -STRAIGHT:
        raise UnsupportedContact(
            f"the rod reaches the concave corner between sides {before.side} and {after.side} and touches both: "
            "two-point contact is outside this model; push less far, or elsewhere"
        )
