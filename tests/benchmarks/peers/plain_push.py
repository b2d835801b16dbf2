"""The push on support points in plain NumPy, and by SciPy's `solve_ivp` and `root`; neither uses the engine."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy
from scipy.integrate import solve_ivp
from scipy.optimize import root

from cyclemap.mechanics import Pose, SidePush
from tests.benchmarks.peers.push_problem import CORNERS, GRID, PushProblem, Simulator
from tests.benchmarks.peers.support_points import Array, Balance, SupportPoints

_ITERATIONS, _SMALLEST_STEP = 100, 1e-9
# What may be left of SciPy's balance of forces, in shares of the weight: `root` gets stuck now and then.
_BALANCED = 1e-5


class PlainPush(ABC):
    """Support points whose balance of forces is solved, and whose motion is integrated, as a subclass does it."""

    def __init__(self, problem: PushProblem, settings: Any) -> None:
        self.problem, self.settings = problem, settings
        self._points = SupportPoints(problem, settings.softness)

    def end_pose(self, pose: Pose, push: SidePush) -> Pose:
        """The object's pose when the rod stops; raises ArithmeticError or AssertionError where there is none."""
        place, direction = map(np.array, self.problem.rod_path(pose, push))
        self._points.forget()

        def velocity(travel: float, now: Array) -> Array:
            return self._points.velocity(now, place + travel * direction, direction, self._solve)

        return Pose(*self._moved(velocity, np.array([pose.x, pose.y, pose.theta]), push.distance).tolist())

    @abstractmethod
    def _moved(self, velocity: Callable[[float, Array], Array], state: Array, distance: float) -> Array:
        """The state (x, y, theta) after a distance."""

    @abstractmethod
    def _solve(self, balance: Balance, guess: Array) -> Array:
        """The unknown that balances the forces."""


@dataclass(frozen=True)
class NumpySettings:
    """What the accuracy and the time of a push hang on.

    steps : of a push. balance : what may be left of the balance of forces. softness : see `SupportPoints`.
    """

    steps: int
    softness: float = 1e-3
    balance: float = 1e-6


class NumpyPush(PlainPush):
    """Nothing but NumPy: Runge-Kutta's fourth-order steps of one length, and Newton's on the balance of forces."""

    def _moved(self, velocity: Callable[[float, Array], Array], state: Array, distance: float) -> Array:
        h = distance / self.settings.steps
        for travel in (h * np.arange(self.settings.steps)).tolist():
            first = velocity(travel, state)
            second = velocity(travel + 0.5 * h, state + 0.5 * h * first)
            third = velocity(travel + 0.5 * h, state + 0.5 * h * second)
            fourth = velocity(travel + h, state + h * third)
            state = state + h / 6.0 * (first + 2.0 * (second + third) + fourth)
        return state

    def _solve(self, balance: Balance, guess: Array) -> Array:
        """Newton's iteration, its steps halved until less is out of balance."""
        unknown = guess
        residual, slope = balance.residual(unknown)
        for _ in range(_ITERATIONS):
            if np.abs(residual).max() <= self.settings.balance:
                return unknown
            step, share = np.linalg.solve(slope, -residual), 1.0
            while share > _SMALLEST_STEP:
                tried = balance.residual(unknown + share * step)
                if np.linalg.norm(tried[0]) < np.linalg.norm(residual):
                    break
                share *= 0.5
            unknown, (residual, slope) = unknown + share * step, tried
        raise ArithmeticError(f"no balance of forces found: {residual} is left")


@dataclass(frozen=True)
class ScipySettings:
    """What the accuracy and the time of a push hang on.

    method, tolerance : of `solve_ivp`; relative, and a tenth of it absolute, in m and rad. longest : step, m, so that
    no trial puts the rod inside the object. balance : tolerance of `root`. softness : see `SupportPoints`.
    """

    tolerance: float
    softness: float = 1e-4
    balance: float = 1e-8
    longest: float = 0.01
    method: str = "RK45"


class ScipyPush(PlainPush):
    """Integrated by `solve_ivp`, the balance of forces found by `root` at every evaluation."""

    def _moved(self, velocity: Callable[[float, Array], Array], state: Array, distance: float) -> Array:
        options = {"rtol": self.settings.tolerance, "atol": 0.1 * self.settings.tolerance}
        options["max_step"] = self.settings.longest
        found = solve_ivp(velocity, (0.0, distance), state, method=self.settings.method, **options)
        assert found.success, found.message
        return np.asarray(found.y[:, -1])

    def _solve(self, balance: Balance, guess: Array) -> Array:
        for method, start in (("hybr", guess), ("lm", guess), ("hybr", 0.0 * guess), ("lm", 0.0 * guess)):
            found = root(balance.residual, start, jac=True, method=method, tol=self.settings.balance)
            if np.abs(found.fun).max() < _BALANCED:
                return np.asarray(found.x)
        raise ArithmeticError(f"no balance of forces found: {found.message}")


NUMPY = Simulator(
    "plain NumPy",
    np.__version__,
    NumpyPush,
    # Found by `python -m tests.benchmarks.peers.settings numpy`, and again with `--problem grid`.
    chosen={
        CORNERS: NumpySettings(5, softness=0.02924, balance=6.8e-5),
        GRID: NumpySettings(20, softness=0.004912, balance=2e-6),
    },
    finer=lambda settings: replace(settings, steps=8 * settings.steps),
    searched={"steps": (3, 200), "softness": (1e-6, 0.1), "balance": (1e-12, 1e-2)},
)
SCIPY = Simulator(
    "SciPy solve_ivp",
    scipy.__version__,
    ScipyPush,
    # Found by `python -m tests.benchmarks.peers.settings scipy`, and again with `--problem grid`.
    chosen={
        CORNERS: ScipySettings(8.4e-4, softness=8.26e-4, balance=2.08e-8, longest=0.03262),
        GRID: ScipySettings(2.188e-4, softness=1.182e-3, balance=1.47e-8, longest=0.006238),
    },
    finer=lambda settings: replace(settings, tolerance=1e-3 * settings.tolerance, longest=0.1 * settings.longest),
    searched={"tolerance": (1e-8, 0.1), "softness": (1e-6, 0.1), "balance": (1e-12, 1e-3), "longest": (1e-3, 0.15)},
)
