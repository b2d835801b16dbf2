"""One law of motion at a time: a rod on one piece of the outline in one mode, or in the ring; stepped and certified."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.buffered_function import BufferedFunction
from cyclemap.mechanics.contact_curve import Contact, Piece, RingPiece
from cyclemap.mechanics.contact_equations import RING_FRICTION, SLIDE
from cyclemap.mechanics.contact_solver import ContactSolver, Slide, Stick
from cyclemap.mechanics.footprint import PatchFootprint, PointFootprint
from cyclemap.mechanics.friction import EllipseFriction
from cyclemap.mechanics.motion_functions import MARGINS, PARAMETERS, step_function
from cyclemap.mechanics.patch_integrals import far_ratio
from cyclemap.mechanics.pressure_family import PressureFamily, rim_share, warp
from cyclemap.mechanics.runge_kutta import STAGES, UNKNOWN, Step, step

# How a rod moves over the slider: not at all, or along the outline's counter-clockwise (left) or clockwise tangent;
# a frictionless rod slides freely, without a cone's edge to stay on. In the ring the object only turns: freely, or
# left or right against the ring's friction, or not at all where that holds it.
STICK, SLIDE_LEFT, SLIDE_RIGHT, SLIDE_FREE = "stick", "slide_left", "slide_right", "slide_free"
RING, RING_LEFT, RING_RIGHT, RING_STUCK = "ring", "ring_left", "ring_right", "ring_stuck"
_SIGN = {STICK: 1.0, SLIDE_LEFT: 1.0, SLIDE_RIGHT: -1.0, SLIDE_FREE: 0.0}
_SIGN |= {RING: 0.0, RING_LEFT: 1.0, RING_RIGHT: -1.0, RING_STUCK: 0.0}

# A fast step counts when what Newton's last correction leaves, about its square, is off by this share of the step's
# tolerance over its length (support points: when the correction itself is, since their friction is not smooth) ...
LEFT_OVER, LEFT_AT_POINTS = 0.05, 0.1
# ... and its centres of rotation stay where the regime's integrals have ten digits or more of the Hessian: these shares
# of the ratio at which one regime hands over to the other.
NEAR_LIMIT, FAR_LIMIT = 14.0 / 8.0, 5.5 / 8.0
# A step that does not count yet is made again, this often at most, from the unknowns that it found.
AGAIN = 3
# Spins in the ring (rad per extent of rod travel) against the sense of its friction that count as none.
TURNS_BACK = 1e-3

_KEPT = (math.inf,) * len(MARGINS)


@dataclass(frozen=True)
class Rod:
    """A rod as the equations see it: radius (extents), friction coefficient, direction of motion (rad, world).

    In the ring `friction` is the radius of the friction circle, extents.
    """

    radius: float
    friction: float
    direction: float


class Motion:
    """The motion of one slider, piece, mode and rod; it keeps the contact's unknowns from call to call."""

    def __init__(self, solver: ContactSolver, piece: Piece, mode: str, rod: Rod) -> None:
        self.solver, self.piece, self.mode, self.rod = solver, piece, mode, rod
        self.unknowns = [0.0, 0.0] if self.slides else [0.0]
        self._regime = 0

    @cached_property
    def parameters(self) -> NDArray[np.float64]:
        """The parameters of its CasADi functions, in the order of PARAMETERS."""
        return motion_parameters(self.solver, self.piece, self.mode, self.rod)

    @cached_property
    def _calls(self) -> list[tuple["_StepCall", "_StepCall"]]:
        """Calls of a step, near and far: the first one, and those that go on from what it found."""
        kind, family = self.piece.kind, self.family
        calls = [
            [_step_call(self.solver, kind, family, near, again) for again in (False, True)] for near in (True, False)
        ]
        return [(first, further) for first, further in calls]

    @property
    def slides(self) -> bool:
        """Whether the rod slides over the slider."""
        return self.mode.startswith("slide")

    @property
    def in_ring(self) -> bool:
        """Whether the rod is in the ring."""
        return self.mode in (RING, RING_LEFT, RING_RIGHT, RING_STUCK)

    @property
    def family(self) -> str:
        """The kind of equations that hold: stick, slide, ring or ring_friction."""
        if self.slides:
            return SLIDE
        return RING_FRICTION if self.mode in (RING_LEFT, RING_RIGHT) else self.mode

    def evaluate(self, state: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (state, slope per unit of rod travel, margins, unknowns), solved until certain."""
        theta, coordinate = state.tolist()
        contact, metric = self.piece.contact(coordinate, self.rod.radius)
        if self.in_ring:
            omega = 0.0 if self.mode == RING_STUCK else self._in_ring(theta, contact).omega
            self.unknowns = [omega]
            return np.array((theta, coordinate, omega, 0.0, *_KEPT, omega))
        off = contact.normal + theta - self.rod.direction
        approach, along = -math.cos(off), -math.sin(off)
        if self.slides:
            omega, slip, mode_margins = self._sliding(theta, contact, approach, along)
        else:
            omega, slip, mode_margins = self._sticking(theta, contact)
        rate = (slip - omega * self.rod.radius) / metric
        room = (coordinate - self.piece.low, self.piece.high - coordinate)
        return np.array((theta, coordinate, omega, rate, approach, *room, *mode_margins, *self.unknowns))

    def forces(self, state: NDArray[np.float64]) -> tuple[float, float, float]:
        """Return compression and tangential force on the slider per unit load, and the residual of their balance."""
        theta, coordinate = state.tolist()
        contact, _ = self.piece.contact(coordinate, self.rod.radius)
        found: Stick | Slide
        if self.mode == RING_STUCK:
            return held_in_ring(self.solver, theta, contact, self.rod)[1:]
        if self.in_ring:
            found = self._in_ring(theta, contact)
        elif self.slides:
            smu = _SIGN[self.mode] * self.rod.friction
            found = self.solver.slide(theta, contact, smu, (self.unknowns[0], self.unknowns[1]))
        else:
            found = self.solver.stick(theta, self.rod.direction, contact, self.unknowns[0])
        return found.normal_force, found.tangential_force, found.residual

    def fast_step(self, state: NDArray[np.float64], h: float, tolerance: float) -> Step | None:
        """Return a step of length h, made in a few calls, or None where its contact is not certified to be solved."""
        if self.mode == RING_STUCK:
            return step(self.evaluate, state, h)
        tried = self._calls[self._regime][0](state, self.unknowns, h, self.parameters, tolerance)
        if not tried.in_regime:
            self._regime = 1 - self._regime
            tried = self._calls[self._regime][0](state, self.unknowns, h, self.parameters, tolerance)
        for _ in range(AGAIN):
            # What leaves both regimes on the way needs a shorter step, not more iterations.
            if tried.certified or not tried.in_regime:
                break
            found = tried.step.stages[:, UNKNOWN].ravel()
            tried = self._calls[self._regime][1](state, found, h, self.parameters, tolerance)
        return tried.step if tried.certified else None

    def step(self, state: NDArray[np.float64], h: float, tolerance: float) -> Step:
        """Return a step of length h: in one call where that is certified, else stage by stage."""
        return self.fast_step(state, h, tolerance) or step(self.evaluate, state, h)

    def velocities(
        self, stage: NDArray[np.float64], contact: Contact, points: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the velocities (k, 2), slider's frame, of points (k, 2) at a solved stage (sliding: unit approach)."""
        n = np.array((math.cos(contact.normal), math.sin(contact.normal)))
        t = np.array((-n[1], n[0]))
        off = self.rod.direction - float(stage[0])
        omega = stage[UNKNOWN][0]
        touch = stage[UNKNOWN][1] * t - n if self.slides else np.array((math.cos(off), math.sin(off)))
        lever = points - np.array((contact.x, contact.y))
        return np.asarray(touch + omega * np.stack([-lever[:, 1], lever[:, 0]], axis=-1))

    def with_parameters(self, parameters: NDArray[np.float64], unknowns: list[float]) -> "Motion":
        """Return the same motion with other numbers, in the order of PARAMETERS."""
        direction, radius, smu, mu_a, mu_b, m0, n0, phi, share, warp_a, warp_b, *geometry, _low, _high = (
            parameters.tolist()
        )
        footprint, mode = self.solver.footprint, self.mode
        if isinstance(footprint, PatchFootprint):
            footprint = replace(footprint, rim_share=share, warp=(warp_a, warp_b))
        if mode == RING and smu != 0.0:
            mode = RING_LEFT if smu > 0.0 else RING_RIGHT
        solver = ContactSolver(footprint, EllipseFriction(mu_a, mu_b, m0, n0, phi))
        moved = Motion(solver, self.piece.moved(tuple(geometry)), mode, Rod(radius, abs(smu), direction))
        moved.unknowns = list(unknowns)
        return moved

    def _in_ring(self, theta: float, contact: Contact) -> Stick:
        if self.mode == RING:
            return self.solver.stick(theta, self.rod.direction, contact, self.unknowns[0])
        smu = _SIGN[self.mode] * self.rod.friction
        return self.solver.ring(theta, self.rod.direction, contact, smu, self.unknowns[0])

    def _sticking(self, theta: float, contact: Contact) -> tuple[float, float, tuple[float, float]]:
        found = self.solver.stick(theta, self.rod.direction, contact, self.unknowns[0])
        self.unknowns = [found.omega]
        limit = self.rod.friction * found.normal_force
        return found.omega, 0.0, (limit - found.tangential_force, limit + found.tangential_force)

    def _sliding(
        self, theta: float, contact: Contact, approach: float, along: float
    ) -> tuple[float, float, tuple[float, float]]:
        sign = _SIGN[self.mode]
        found = self.solver.slide(theta, contact, sign * self.rod.friction, (self.unknowns[0], self.unknowns[1]))
        self.unknowns = [found.omega, found.tau]
        slip = along - approach * found.tau
        return approach * found.omega, slip, (sign * slip, math.inf)


def ring_mode(solver: ContactSolver, theta: float, piece: RingPiece, rod: Rod) -> str:
    """Return how the object moves in the ring at orientation theta, and as long as the rod goes straight on.

    A spin that depends continuously on the orientation alone never changes its sign on the way, so that the mode stays.
    """
    if rod.friction == 0.0:
        return RING
    excess, *_ = held_in_ring(solver, theta, piece.contact(0.0, 0.0)[0], rod)
    return RING_STUCK if excess == 0.0 else RING_LEFT if excess < 0.0 else RING_RIGHT


def held_in_ring(solver: ContactSolver, theta: float, contact: Contact, rod: Rod) -> tuple[float, float, float, float]:
    """Return the torque that the ring's friction leaves over in translation, the rod's force per unit load, and zero.

    Forces as `Motion.forces` returns them, with the residual of a balance that the ring's friction closes.
    """
    torque, normal_force, tangential_force = solver.held(theta, rod.direction, contact)
    limit = rod.friction * math.hypot(normal_force, tangential_force)
    return math.copysign(max(abs(torque) - limit, 0.0), torque), normal_force, tangential_force, 0.0


def motion_parameters(solver: ContactSolver, piece: Piece, mode: str, rod: Rod) -> NDArray[np.float64]:
    """Return the parameters of a motion's CasADi functions, in the order of PARAMETERS."""
    friction = solver.friction
    law = (friction.mu_a, friction.mu_b, friction.m0, friction.n0, friction.phi)
    pressure = (rim_share(solver.footprint), *warp(solver.footprint))
    radius = 0.0 if isinstance(piece, RingPiece) else rod.radius
    geometry = (*piece.geometry, *(0.0,) * (5 - len(piece.geometry)))
    values = (rod.direction, radius, _SIGN[mode] * rod.friction, *law, *pressure, *geometry, piece.low, piece.high)
    assert len(values) == len(PARAMETERS)
    return np.array(values)


def _step_call(solver: ContactSolver, kind: str, family: str, near: bool, again: bool) -> "_StepCall":
    """Return the solver's own call of a step, made once."""
    key = (kind, family, near, again)
    if key not in solver.step_calls:
        solver.step_calls[key] = _StepCall(solver.pressure, kind, family, near, again)
    call = solver.step_calls[key]
    assert isinstance(call, _StepCall)
    return call


class _Tried(NamedTuple):
    """A step, whether its centres of rotation stay in the regime, and whether its Newton iterations hold there."""

    step: Step
    in_regime: bool
    certified: bool


class _StepCall:
    """A step's CasADi function, with its buffers, built when it is first needed."""

    def __init__(self, pressure: PressureFamily, kind: str, family: str, near: bool, again: bool) -> None:
        self._build = (pressure, kind, family, near, again)
        self._near, self._limit = near, far_ratio(pressure) * (NEAR_LIMIT if near else FAR_LIMIT)
        self._exact = not isinstance(pressure.footprint, PointFootprint)

    def __call__(
        self,
        state: NDArray[np.float64],
        unknowns: list[float] | NDArray[np.float64],
        h: float,
        parameters: NDArray[np.float64],
        tolerance: float,
    ) -> _Tried:
        function = self._function
        at, guess, length, numbers = function.arguments
        at[:], guess[:], length[0], numbers[:] = state, unknowns, h, parameters
        result = function()
        error, correction, least, greatest = result[:4].tolist()
        in_regime = not self._exact or (greatest <= self._limit if self._near else least >= self._limit)
        allowed = math.sqrt(LEFT_OVER * tolerance / h) if self._exact else LEFT_AT_POINTS * tolerance
        certified = in_regime and math.isfinite(error) and correction <= allowed
        return _Tried(Step(h, result[4:].reshape(STAGES + 1, -1).copy(), error), in_regime, certified)

    @cached_property
    def _function(self) -> BufferedFunction:
        function = step_function(*self._build)
        return BufferedFunction(function, *(np.zeros(function.numel_in(i)) for i in range(function.n_in())))
