"""Solves the contact equations for one state: Newton's method, guarded so that it converges or raises."""

import math
from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cyclemap.errors import ConvergenceError
from cyclemap.mechanics.buffered_function import BufferedFunction
from cyclemap.mechanics.contact_curve import Contact
from cyclemap.mechanics.contact_equations import ARGUMENTS, RING_FRICTION, SLIDE, STICK, contact_functions
from cyclemap.mechanics.footprint import Footprint, PointFootprint
from cyclemap.mechanics.friction import EllipseFriction
from cyclemap.mechanics.patch_integrals import far_ratio
from cyclemap.mechanics.pinned_point import PinnedPoints
from cyclemap.mechanics.pressure_family import PressureFamily, rim_share, warp

# Residuals, relative to the mean friction coefficient, at which a solution counts as found, and above which one that
# rounding keeps from getting there is refused.
FOUND = 2e-13
ACCEPTED = 1e-10

Values = list[float]


class NoSlip(ConvergenceError):
    """No slip, however fast, puts the contact's force on the friction cone's edge."""


class Stick(NamedTuple):
    """Sticking contact: spin (rad per extent of rod travel), forces per unit load, residual (relative)."""

    omega: float
    normal_force: float
    tangential_force: float
    residual: float


class Slide(NamedTuple):
    """Sliding contact for a unit approach: spin, tangential velocity of the contact point; forces, residual."""

    omega: float
    tau: float
    normal_force: float
    tangential_force: float
    residual: float


class ContactSolver:
    """The contact equations of one footprint (extent one) on one material, ready to be solved many times.

    It holds the CasADi functions' buffers and the regime of the last solution; a solver is not for two threads.
    """

    def __init__(self, footprint: Footprint, friction: EllipseFriction) -> None:
        self.footprint, self.friction = footprint, friction
        self.pressure = PressureFamily.of(footprint)
        # Calls of step functions with their buffers, shared by the motions that this solver serves.
        self.step_calls: dict[tuple[str, str, bool, bool], object] = {}
        self.arguments = np.zeros(len(ARGUMENTS))
        self.arguments[6:11] = friction.mu_a, friction.mu_b, friction.m0, friction.n0, friction.phi
        self.arguments[11:14] = rim_share(footprint), *warp(footprint)
        self._scale = math.sqrt(friction.mu_a * friction.mu_b)
        self._stick = _RegimeSwitch(self.pressure, STICK, self.arguments)
        self._slide = _RegimeSwitch(self.pressure, SLIDE, self.arguments)
        self._pinned = PinnedPoints(footprint, friction) if isinstance(footprint, PointFootprint) else None

    @cached_property
    def _ring(self) -> "_RegimeSwitch":
        return _RegimeSwitch(self.pressure, RING_FRICTION, self.arguments)

    def stick(self, theta: float, direction: float, contact: Contact, omega: float) -> Stick:
        """Return the sticking solution for a rod moving at angle `direction`, from a guess of omega.

        Raises ConvergenceError if the residual stays above 1e-10.
        """
        self.arguments[:5] = theta, direction, *contact
        return self._newton_spin(self._stick, omega) or self._bracketed_spin(self._stick, omega, "sticking contact")

    def ring(self, theta: float, direction: float, contact: Contact, smu: float, omega: float) -> Stick:
        """Return the solution in a ring with a friction circle of signed radius `smu` (extents), from a guess of omega.

        Where the ring's friction does not hold the object there is a spin in the sense of `smu`, since from rest to
        the fastest spin the torque changes its sign; that one is returned. Just beyond it is the small one back that
        goes on from there. Raises ConvergenceError if the residual stays above 1e-10.
        """
        self.arguments[:6] = theta, direction, *contact, smu
        found = self._newton_spin(self._ring, omega)
        if found is not None and (found.omega * smu >= 0.0 or self._ring.at(0.0)[0] * smu >= 0.0):
            return found
        return self._bracketed_spin(self._ring, 0.0, "ring with friction")

    def held(self, theta: float, direction: float, contact: Contact) -> tuple[float, float, float]:
        """Return torque about the contact and forces (normal, tangential) that move the slider without turning it."""
        self.arguments[:5] = theta, direction, *contact
        torque, _, normal_force, tangential_force, _far = self._stick.at(0.0)
        return torque, normal_force, tangential_force

    def _newton_spin(self, equation: "_RegimeSwitch", omega: float) -> Stick | None:
        """Newton's method from a guess; None where it does not converge."""
        best = math.inf
        for _ in range(12):
            residual, step, normal_force, tangential_force, _far = equation.at(omega)
            size = abs(residual) / self._scale
            if size <= FOUND:
                return Stick(omega, normal_force, tangential_force, size)
            if not size < 0.7 * best:
                break
            best = size
            omega += step
        return None

    def slide(self, theta: float, contact: Contact, smu: float, guess: tuple[float, float]) -> Slide:
        """Return the sliding solution for a unit approach, from a guess of (omega, tau).

        Raises ConvergenceError if the residual stays above 1e-10, or where the cone's edge moves no contact inward.
        """
        self.arguments[:6] = theta, 0.0, *contact, smu
        if self._pinned is not None:
            pinned = self._pinned.remembered(self.arguments)
            if pinned is not None:
                return Slide(*pinned, 0.0)
        omega, tau = guess
        best, nearest = math.inf, guess
        for _ in range(12):
            r0, r1, s0, s1, normal_force, tangential_force, _far = self._slide.at(omega, tau)
            size = math.hypot(r0, r1) / self._scale
            # The opposite of the cone's edge satisfies the equations too, but a rod cannot pull.
            if size <= FOUND and normal_force > 0.0:
                return Slide(omega, tau, normal_force, tangential_force, size)
            if not size < 0.7 * best:
                break
            best, nearest = size, (omega, tau)
            omega, tau = omega + s0, tau + s1
        return self._slide_bracketed(nearest)

    def _bracketed_spin(self, equation: "_RegimeSwitch", omega: float, what: str) -> Stick:
        """The torque about the contact grows with omega, so that a bracket always closes on the solution.

        With a ring's friction it need not, but from zero on it does as a whole.
        """

        def torque(spin: float) -> Values:
            return equation.at(spin)

        low, high = _bracket(torque, omega if math.isfinite(omega) else 0.0, f"spin of the {what}")
        solution, values = _close(torque, low, high, FOUND * self._scale)
        residual, _, normal_force, tangential_force, _ = values
        return Stick(solution, normal_force, tangential_force, self._accepted(residual, what))

    def _slide_bracketed(self, guess: tuple[float, float]) -> Slide:
        """With omega solved for each tau, the force turns one way as tau grows: a bracket in tau closes too."""
        if self._pinned is not None:
            pinned = self._pinned.nearest(self.arguments, guess)
            if pinned is not None:
                return Slide(*pinned, 0.0)
        theta, _, x, y, normal, smu = self.arguments[:6].tolist()
        contact, state = Contact(x, y, normal), [guess[0]]

        def excess(tau: float) -> Values:
            speed, angle = math.hypot(1.0, tau), theta + normal + math.pi - math.atan(tau)
            stick = self.stick(theta, angle, contact, state[0] / speed)
            state[0] = stick.omega * speed
            value = _beyond_edge(stick.normal_force, stick.tangential_force, smu)
            return [value, math.nan, stick.normal_force, stick.tangential_force, state[0]]

        try:
            low, high = _bracket(excess, guess[1], "slip of the sliding contact")
        except ConvergenceError as cause:
            raise NoSlip(str(cause)) from cause
        tau, values = _close(excess, low, high, FOUND * self._scale)
        self.arguments[:6] = theta, 0.0, x, y, normal, smu
        return Slide(values[4], tau, values[2], values[3], self._accepted(values[0], "sliding contact"))

    def _accepted(self, residual: float, what: str) -> float:
        size = abs(residual) / self._scale
        if not size <= ACCEPTED:
            state = dict(zip(ARGUMENTS, self.arguments.tolist(), strict=True))
            raise ConvergenceError(f"the residual of the {what} stays at {size:.2e}, above {ACCEPTED}, at {state}")
        return size


class _RegimeSwitch:
    """One equation in both regimes: evaluates the one that is accurate where the centre of rotation lies."""

    def __init__(self, pressure: PressureFamily, equations: str, arguments: NDArray[np.float64]) -> None:
        functions = [contact_functions(pressure, equations, near).solver for near in (True, False)]
        self._unknowns = np.zeros(functions[0].size1_in(0))
        self._calls = [BufferedFunction(f, self._unknowns, arguments) for f in functions]
        self._is_far, self._far_ratio = 0, far_ratio(pressure)

    def at(self, *unknowns: float) -> Values:
        """Return the function's outputs; the last one tells the regime."""
        self._unknowns[:] = unknowns
        values: Values = self._calls[self._is_far]().tolist()
        is_far = 0 if values[-1] <= self._far_ratio else 1
        if is_far != self._is_far:
            self._is_far = is_far
            values = self._calls[is_far]().tolist()
        return values


def _beyond_edge(normal_force: float, tangential_force: float, smu: float) -> float:
    """Return the force's part across the cone's edge; all of it, with the turn's sign, beyond a right angle.

    The force's angle from the inward normal grows with tau between -pi and pi, so that this changes sign once.
    """
    turn = math.atan2(tangential_force, normal_force) - math.atan(smu)
    if abs(turn) > math.pi / 2.0:
        return math.copysign(math.hypot(normal_force, tangential_force), turn)
    return tangential_force - smu * normal_force


def _bracket(function: Callable[[float], Values], start: float, what: str) -> tuple[float, float]:
    """Return (low, high) with function(low)[0] <= 0 <= function(high)[0], for a function that grows."""
    step = 0.1 * (1.0 + abs(start))
    value = function(start)[0]
    if not math.isfinite(value):
        raise ConvergenceError(f"the {what} cannot be evaluated at {start}: {value}")
    sign = -1.0 if value > 0.0 else 1.0
    inner = start
    for _ in range(60):
        outer = inner + sign * step
        if function(outer)[0] * sign >= 0.0:
            return (inner, outer) if sign > 0.0 else (outer, inner)
        inner, step = outer, 2.0 * step
    raise ConvergenceError(f"the {what} has no bracket within {inner:.3g} of {start:.3g}: no such motion exists")


def _close(function: Callable[[float], Values], low: float, high: float, tolerance: float) -> tuple[float, Values]:
    """Close a bracket by bisection and secants; where the function jumps, mix both sides so that it vanishes.

    The mixture is what the equations ask for: at a support point that does not slide, friction is any force between
    those of the motions on either side.
    """
    at_low, at_high = function(low), function(high)
    for iteration in range(200):
        if high - low <= 4.0 * math.ulp(max(abs(low), abs(high), 1e-3)):
            break
        rise = at_high[0] - at_low[0]
        middle = low - at_low[0] * (high - low) / rise if rise > 0.0 and iteration % 3 else (low + high) / 2.0
        if not low < middle < high:
            middle = (low + high) / 2.0
        values = function(middle)
        if abs(values[0]) <= tolerance:
            return middle, values
        if values[0] < 0.0:
            low, at_low = middle, values
        else:
            high, at_high = middle, values
    share = at_low[0] / (at_low[0] - at_high[0]) if at_high[0] != at_low[0] else 0.5
    return (low + high) / 2.0, [(1.0 - share) * a + share * b for a, b in zip(at_low, at_high, strict=True)]
