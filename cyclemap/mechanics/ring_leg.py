"""One straight leg of a drag by the ring, and where the ring's friction ends the turn."""

import math

import numpy as np

from cyclemap.errors import ConvergenceError, TooManySteps, UnsupportedContact
from cyclemap.mechanics.contact_curve import RingPiece
from cyclemap.mechanics.contact_solver import ContactSolver
from cyclemap.mechanics.event_integration import FIRST_DRAG_STEP, integrate
from cyclemap.mechanics.motion import TURNS_BACK, Motion, Rod, ring_mode
from cyclemap.mechanics.push_run import RunPhase
from cyclemap.mechanics.runge_kutta import SLOPE

# A friction circle beyond this many levers of the ring holds the object, for all rounding.
_HELD = 1.0 + 1e-9


def has_one_spin(radius: float, lever: float) -> bool:
    """Whether a friction circle of the ring is below half the ring's lever from the centre of pressure, or above it.

    Below, a patch has one spin on a friction ellipse whose centre is within 60 % of its smaller axis
    (tests/mechanics/test_ring_friction.py); above, the ring always holds the object, since friction in translation acts
    at the centre of pressure. In between, and on laws and support points more extreme, a turn may end on its way.
    """
    return not 0.5 * lever < radius < _HELD * lever


def run_leg(
    solver: ContactSolver, piece: RingPiece, theta: float, rod: Rod, length: float, tolerance: float, longest: float
) -> RunPhase:
    """Drag the slider over `length` (extents) from an orientation; raises UnsupportedContact where its turn ends."""
    motion, state = Motion(solver, piece, ring_mode(solver, theta, piece, rod), rod), np.array((theta, 0.0))
    given = length, tolerance, FIRST_DRAG_STEP, longest
    if rod.friction == 0.0:
        return RunPhase(motion, state, integrate(motion, state, *given))
    share = rod.friction / max(math.dist(piece.contact(0.0, 0.0)[0][:2], solver.footprint.centre), 1e-12)
    try:
        phase = integrate(motion, state, *given)
    except TooManySteps:
        raise
    except ConvergenceError as cause:
        raise _stopped(share) from cause
    sense = np.sign(motion.parameters[2])
    if any(sense * taken.stages[-1, SLOPE][0] < -TURNS_BACK for taken in phase.steps):
        raise _stopped(share)
    return RunPhase(motion, state, phase)


def _stopped(share: float) -> UnsupportedContact:
    return UnsupportedContact(
        f"the ring's friction stops the object on its way while it turns: its radius is {share:.3g} times the ring's "
        "distance from the centre of pressure; choose a smaller pin friction radius or a ring farther away"
    )
