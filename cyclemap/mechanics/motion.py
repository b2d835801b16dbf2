"""One law of motion at a time: a rod on one piece of the outline in one mode, or in the ring; stepped and certified."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.buffered_function import BufferedFunction
from cyclemap.mechanics.contact_curve import Contact, Piece
from cyclemap.mechanics.contact_solver import ContactSolver, Slide, Stick
from cyclemap.mechanics.footprint import Footprint, PointFootprint
from cyclemap.mechanics.friction import EllipseFriction
from cyclemap.mechanics.motion_functions import MARGINS, PARAMETERS, step_function
from cyclemap.mechanics.runge_kutta import STAGES, UNKNOWN, Step, step

# How a rod moves over the slider: not at all, or along the outline's counter-clockwise (left) or clockwise tangent;
# a frictionless rod slides freely, without a cone's edge to stay on. In the ring it only turns.
STICK, SLIDE_LEFT, SLIDE_RIGHT, SLIDE_FREE, RING = "stick", "slide_left", "slide_right", "slide_free", "ring"
_SIGN = {STICK: 1.0, SLIDE_LEFT: 1.0, SLIDE_RIGHT: -1.0, SLIDE_FREE: 0.0, RING: 0.0}

# A fast step counts when what Newton's last correction leaves, about its square, is this share of the step's tolerance
# (support points: when the correction itself is, since their friction is not smooth) ...
_LEFT = 0.01
# ... and its centres of rotation stay where the regime's integrals have ten digits or more of the Hessian.
_NEAR_LIMIT, _FAR_LIMIT = 14.0, 5.5

_KEPT = (math.inf,) * len(MARGINS)


@dataclass(frozen=True)
class Rod:
    """A rod as the equations see it: radius (extents), friction coefficient, direction of motion (rad, world)."""

    radius: float
    friction: float
    direction: float


class Motion:
    """The motion of one slider, piece, mode and rod; it keeps the contact's unknowns from call to call."""

    def __init__(self, solver: ContactSolver, piece: Piece, mode: str, rod: Rod) -> None:
        self.solver, self.piece, self.mode, self.rod = solver, piece, mode, rod
        self.parameters = motion_parameters(solver.friction, piece, mode, rod)
        self.unknowns = [0.0, 0.0] if self.slides else [0.0]
        self._regime = 0
        self._calls = [_step_call(solver, piece.kind, self.family, near) for near in (True, False)]

    @property
    def slides(self) -> bool:
        """Whether the rod slides over the slider."""
        return self.mode.startswith("slide")

    @property
    def family(self) -> str:
        """The kind of equations that hold: stick, slide or ring."""
        return "slide" if self.slides else self.mode

    def evaluate(self, state: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (state, slope per unit of rod travel, margins, unknowns), solved until certain."""
        theta, coordinate = state.tolist()
        contact, metric = self.piece.contact(coordinate, self.rod.radius)
        if self.mode == RING:
            omega, *_ = self.solver.stick(theta, self.rod.direction, contact, self.unknowns[0])
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
        if self.slides:
            smu = _SIGN[self.mode] * self.rod.friction
            found = self.solver.slide(theta, contact, smu, (self.unknowns[0], self.unknowns[1]))
        else:
            found = self.solver.stick(theta, self.rod.direction, contact, self.unknowns[0])
        return found.normal_force, found.tangential_force, found.residual

    def fast_step(self, state: NDArray[np.float64], h: float, tolerance: float) -> Step | None:
        """Return a step of length h, made in one call, or None where its contact is not certified to be solved."""
        taken = self._calls[self._regime](state, self.unknowns, h, self.parameters, tolerance)
        if taken is None and not self._calls[self._regime].in_regime:
            self._regime = 1 - self._regime
            taken = self._calls[self._regime](state, self.unknowns, h, self.parameters, tolerance)
        return taken

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
        direction, radius, smu, mu_a, mu_b, m0, n0, phi, *geometry, _low, _high = parameters.tolist()
        solver = ContactSolver(self.solver.footprint, EllipseFriction(mu_a, mu_b, m0, n0, phi))
        moved = Motion(solver, self.piece.moved(tuple(geometry)), self.mode, Rod(radius, abs(smu), direction))
        moved.unknowns = list(unknowns)
        return moved

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


def motion_parameters(friction: EllipseFriction, piece: Piece, mode: str, rod: Rod) -> NDArray[np.float64]:
    """Return the parameters of a motion's CasADi functions, in the order of PARAMETERS."""
    law = (friction.mu_a, friction.mu_b, friction.m0, friction.n0, friction.phi)
    radius = 0.0 if mode == RING else rod.radius
    geometry = (*piece.geometry, *(0.0,) * (5 - len(piece.geometry)))
    values = (rod.direction, radius, _SIGN[mode] * rod.friction, *law, *geometry, piece.low, piece.high)
    assert len(values) == len(PARAMETERS)
    return np.array(values)


def _step_call(solver: ContactSolver, kind: str, family: str, near: bool) -> "_StepCall":
    """Return the solver's own call of a step, made once."""
    key = (kind, family, near)
    if key not in solver.step_calls:
        solver.step_calls[key] = _StepCall(solver.footprint, kind, family, near)
    call = solver.step_calls[key]
    assert isinstance(call, _StepCall)
    return call


class _StepCall:
    """A step's CasADi function, with its buffers, built when it is first needed."""

    def __init__(self, footprint: Footprint, kind: str, family: str, near: bool) -> None:
        self._build = (footprint, kind, family, near)
        self._near = near
        self._exact = not isinstance(footprint, PointFootprint)
        self._unknowns = 2 if family == "slide" else 1
        self.in_regime = True

    def __call__(
        self,
        state: NDArray[np.float64],
        unknowns: list[float],
        h: float,
        parameters: NDArray[np.float64],
        tolerance: float,
    ) -> Step | None:
        """Return the step, or None where its Newton iterations or its regime do not hold."""
        at, guess, length, numbers = self._function.arguments
        at[:], guess[:], length[0], numbers[:] = state, unknowns, h, parameters
        result = self._function()
        error, correction, least, greatest = result[:4].tolist()
        self.in_regime = not self._exact or (greatest <= _NEAR_LIMIT if self._near else least >= _FAR_LIMIT)
        allowed = math.sqrt(_LEFT * tolerance) if self._exact else _LEFT * tolerance
        if not (correction <= allowed and self.in_regime and math.isfinite(error)):
            return None
        return Step(h, result[4:].reshape(STAGES + 1, -1).copy(), error)

    @cached_property
    def _function(self) -> BufferedFunction:
        inputs = (np.zeros(2), np.zeros(self._unknowns), np.zeros(1), np.zeros(len(PARAMETERS)))
        return BufferedFunction(step_function(*self._build), *inputs)
