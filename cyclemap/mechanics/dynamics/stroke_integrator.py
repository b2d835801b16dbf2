"""One leg of the rod, integrated by CVODES (Hindmarsh et al. 2005), and the rest into which the slider then comes."""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cyclemap.errors import ConvergenceError
from cyclemap.mechanics.dynamics.dynamic_equations import PHYSICS, DynamicEquations, dynamic_equations
from cyclemap.mechanics.footprint import PointFootprint
from cyclemap.mechanics.outline import Outline

Array = NDArray[np.float64]

# The absolute tolerance as a share of the relative one: speeds and lengths are of order one.
_ABSOLUTE = 0.1
# Newton's error as a share of a step's: CVODES' own 0.1 lets the stiff contact turn it into failed error tests.
_NEWTON_SHARE = 1e-3
_MOST_STEPS = 200_000
# Units of the state. Velocities follow from positions through the stiff contact, where a step of length h gives them
# the error of positions over h: tested as strictly as these, they would have steps shortened without end.
_SCALES = np.array([1.0, 1.0, 1.0, 100.0, 100.0, 100.0])
# The slider rests once no speed is above this share of the rod's, or above so many creep speeds.
_REST, _REST_CREEPS = 0.01, 10.0
_MOST_WAITS = 100
# A leg shorter than this (extents) is none.
_SHORTEST = 1e-12


@dataclass(frozen=True, eq=False)
class LegRun:
    """A leg as computed, in the equations' units: `dynamic_equations.STATE` and what is observed of it.

    rod, velocity : (2,) the rod's start and velocity. time : (n,) since the leg's start. state : (n, 6).
    observed : (n, 5) force, its place, energy stored. works : (3,) `dynamic_equations.WORKS`.
    """

    rod: Array
    velocity: Array
    time: Array
    state: Array
    observed: Array
    works: Array


@dataclass(frozen=True)
class StrokeIntegrator:
    """Integrates legs of a slider on support points; `touched` is the outline or the ring's place.

    tolerance : relative error of a step. samples : of the leg, evenly in time, beside its start.
    """

    footprint: PointFootprint
    centre: tuple[float, float]
    touched: Outline | tuple[float, float]
    tolerance: float
    samples: int

    def stroke(self, start: Array, places: list[Array], wait: float, physics: Array) -> tuple[list[LegRun], ...]:
        """Move the rod through places at unit speed, then hold it until the slider rests: the legs of both."""
        moving: list[LegRun] = []
        for place, goal in pairwise(places):
            length = float(np.hypot(*(goal - place)))
            if length > _SHORTEST:
                now = moving[-1].state[-1] if moving else start
                moving.append(self.leg(now, place, (goal - place) / length, length, physics))
        return moving, self.rest(moving[-1].state[-1], places[-1], wait, physics) if moving else []

    def leg(self, start: Array, rod: Array, velocity: Array, time: float, physics: Array) -> LegRun:
        """Move the rod for a time from a place at a velocity, the slider being in the state `start`."""
        parameters = np.array([*rod, *velocity, time, *physics])
        # Whole turns stay out, since the integrator's error is relative to what it integrates.
        wound = 2.0 * np.pi * np.round(start[2] / (2.0 * np.pi)) * (np.arange(6) == 2)
        try:
            found = _solver(self)(x0=(start - wound) / _SCALES, p=parameters)
        except RuntimeError as cause:
            raise ConvergenceError(
                f"the integrator of the dynamic simulation gave up at tolerance {self.tolerance:g}: choose a looser "
                "one, a larger regularisation or a smaller stiffness"
            ) from cause
        state = np.column_stack([start, _SCALES[:, None] * np.array(found["xf"]) + wound[:, None]])
        share = np.linspace(0.0, 1.0, self.samples + 1)
        observed = np.array(self.equations.observed(share[None], state, parameters))
        return LegRun(rod, velocity, time * share, state.T, observed.T, np.array(found["qf"])[:, -1])

    def rest(self, start: Array, rod: Array, wait: float, physics: Array) -> list[LegRun]:
        """Hold the rod until the slider rests, for `wait` at a time. Raises ConvergenceError if it does not."""
        runs: list[LegRun] = []
        now, limit = start, max(_REST, _REST_CREEPS * float(physics[PHYSICS.index("creep")]))
        while not runs or np.abs(now[3:]).max() > limit:
            if len(runs) == _MOST_WAITS:
                raise ConvergenceError(
                    f"the slider still moves at {np.abs(now[3:]).max():.3g} rod speeds long after the rod has stopped: "
                    "choose a smaller regularisation or a friction ellipse whose centre is nearer to zero"
                )
            runs.append(self.leg(now, rod, np.zeros(2), wait, physics))
            now = runs[-1].state[-1]
        return runs

    @property
    def equations(self) -> DynamicEquations:
        """What is integrated."""
        return dynamic_equations(self.footprint, self.centre, self.touched)


@lru_cache(maxsize=32)
def _solver(stroke: StrokeIntegrator) -> ca.Function:
    options = {
        "reltol": stroke.tolerance,
        "abstol": _ABSOLUTE * stroke.tolerance,
        "nonlin_conv_coeff": _NEWTON_SHARE,
        "max_num_steps": _MOST_STEPS,
        "disable_internal_warnings": True,
        "linear_solver": "csparse",
    }
    grid = np.linspace(0.0, 1.0, stroke.samples + 1)[1:].tolist()
    return ca.integrator("leg", "cvodes", _scaled(stroke.equations.problem), 0.0, grid, options)


def _scaled(problem: dict[str, ca.SX]) -> dict[str, ca.SX]:
    """The problem in states that are to be multiplied by _SCALES."""
    state = ca.SX.sym("scaled", 6)
    ode, quad = ca.substitute([problem["ode"], problem["quad"]], [problem["x"]], [_SCALES * state])
    return {**problem, "x": state, "ode": ode / _SCALES, "quad": quad}
