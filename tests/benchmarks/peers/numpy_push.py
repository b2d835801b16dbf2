"""The push in plain NumPy: Runge-Kutta's fourth-order steps of one length, and Newton's on the balance of forces."""

from dataclasses import dataclass, replace

import numpy as np

from cyclemap.mechanics import Pose, SidePush
from tests.benchmarks.peers.push_problem import CORNERS, GRID, PushProblem
from tests.benchmarks.peers.simulator import Simulator
from tests.benchmarks.peers.support_points import Array, Balance, SupportPoints, start_of

_ITERATIONS = 100
_SMALLEST_STEP = 1e-9


@dataclass(frozen=True)
class NumpySettings:
    """What the accuracy and the time of a push hang on.

    steps : of a push. balance : what may be left of the balance of forces. softness : see `SupportPoints`.
    """

    steps: int
    softness: float = 1e-3
    balance: float = 1e-6


class NumpyPush:
    """Support points whose motion is integrated with nothing but NumPy."""

    def __init__(self, problem: PushProblem, settings: NumpySettings) -> None:
        self.problem, self.settings = problem, settings
        self._points = SupportPoints(problem, settings.softness)

    def end_pose(self, pose: Pose, push: SidePush) -> Pose:
        """The object's pose when the rod stops; raises ArithmeticError where Newton's steps end nowhere."""
        state, place, direction = start_of(self.problem, pose, push)
        self._points.forget()

        def velocity(travel: float, now: Array) -> Array:
            return self._points.velocity(now, place + travel * direction, direction, self._solve)

        h = push.distance / self.settings.steps
        for travel in (h * np.arange(self.settings.steps)).tolist():
            first = velocity(travel, state)
            second = velocity(travel + 0.5 * h, state + 0.5 * h * first)
            third = velocity(travel + 0.5 * h, state + 0.5 * h * second)
            fourth = velocity(travel + h, state + h * third)
            state = state + h / 6.0 * (first + 2.0 * (second + third) + fourth)
        return Pose(*state.tolist())

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


SIMULATOR = Simulator(
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
