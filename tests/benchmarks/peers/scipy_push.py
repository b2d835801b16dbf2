"""The push by SciPy: `solve_ivp` on the support points, the balance of forces found by `root` at every evaluation."""

from dataclasses import dataclass, replace

import numpy as np
import scipy
from scipy.integrate import solve_ivp
from scipy.optimize import root

from cyclemap.mechanics import Pose, SidePush
from tests.benchmarks.peers.push_problem import CORNERS, GRID, PushProblem
from tests.benchmarks.peers.simulator import Simulator
from tests.benchmarks.peers.support_points import Array, Balance, SupportPoints, start_of

# What may be left of the balance of forces, in shares of the weight: `root` gets stuck now and then.
_BALANCED = 1e-5


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


class ScipyPush:
    """Support points whose motion SciPy integrates."""

    def __init__(self, problem: PushProblem, settings: ScipySettings) -> None:
        self.problem, self.settings = problem, settings
        self._points = SupportPoints(problem, settings.softness)

    def end_pose(self, pose: Pose, push: SidePush) -> Pose:
        """The object's pose when the rod stops; raises AssertionError where SciPy gives up."""
        state, place, direction = start_of(self.problem, pose, push)
        self._points.forget()

        def velocity(travel: float, now: Array) -> Array:
            return self._points.velocity(now, place + travel * direction, direction, self._solve)

        options = {"rtol": self.settings.tolerance, "atol": 0.1 * self.settings.tolerance}
        options["max_step"] = self.settings.longest
        found = solve_ivp(velocity, (0.0, push.distance), state, method=self.settings.method, **options)
        assert found.success, found.message
        return Pose(*found.y[:, -1].tolist())

    def _solve(self, balance: Balance, guess: Array) -> Array:
        for method, start in (("hybr", guess), ("lm", guess), ("hybr", 0.0 * guess), ("lm", 0.0 * guess)):
            found = root(balance.residual, start, jac=True, method=method, tol=self.settings.balance)
            if np.abs(found.fun).max() < _BALANCED:
                return np.asarray(found.x)
        raise ArithmeticError(f"no balance of forces found: {found.message}")


SIMULATOR = Simulator(
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
