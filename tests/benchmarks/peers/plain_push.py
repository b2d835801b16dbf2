"""The push on support points in plain NumPy, and by SciPy's `solve_ivp` and `root`; neither uses
the engine.
"""

from collections.abc import Callable

import numpy as np
import scipy
from scipy.integrate import solve_ivp
from scipy.optimize import root

from cyclemap.mechanics import Pose, SidePush
from tests.benchmarks.peers.push_problem import CORNERS, GRID, EndPose, PushProblem, Simulator
from tests.benchmarks.peers.support_points import Array, Balance, Solve, SupportPoints, Velocity

# The state (x, y, theta) after a distance.
Moved = Callable[[Velocity, Array, float], Array]
_ITERATIONS, _SMALLEST_STEP = 100, 1e-9
# What may be left of SciPy's balance of forces, in shares of the weight: `root` gets stuck now and
# then.
_BALANCED = 1e-5
# Steps, softness, balance; and tolerance, softness, balance, longest step.
NUMPY_SETTINGS = {CORNERS: (5, 0.02924, 6.8e-5), GRID: (20, 0.004912, 2e-6)}
SCIPY_SETTINGS = {
    CORNERS: (8.4e-4, 8.26e-4, 2.08e-8, 0.03262),
    GRID: (2.188e-4, 1.182e-3, 1.47e-8, 0.006238),
}


def numpy_push(
    problem: PushProblem, steps: int, softness: float = 1e-3, balance: float = 1e-6
) -> EndPose:
    """Nothing but NumPy: Runge-Kutta's fourth-order steps of one length, and Newton's on the
    balance of forces.

    steps : of a push.
    softness : see `SupportPoints`.
    balance : what may be left of the balance of forces.

    The pushes raise ArithmeticError where no balance is found.
    """

    def moved(velocity: Velocity, state: Array, distance: float) -> Array:
        h = distance / steps
        for travel in (h * np.arange(steps)).tolist():
            first = velocity(travel, state)
            second = velocity(travel + 0.5 * h, state + 0.5 * h * first)
            third = velocity(travel + 0.5 * h, state + 0.5 * h * second)
            fourth = velocity(travel + h, state + h * third)
            state = state + h / 6.0 * (first + 2.0 * (second + third) + fourth)
        return state

    def solve(forces: Balance, guess: Array) -> Array:
        """Newton's iteration, its steps halved until less is out of balance."""
        unknown = guess
        residual, slope = forces.residual(unknown)
        for _ in range(_ITERATIONS):
            if np.abs(residual).max() <= balance:
                return unknown
            step, share = np.linalg.solve(slope, -residual), 1.0
            while share > _SMALLEST_STEP:
                tried = forces.residual(unknown + share * step)
                if np.linalg.norm(tried[0]) < np.linalg.norm(residual):
                    break
                share *= 0.5
            unknown, (residual, slope) = unknown + share * step, tried
        raise ArithmeticError(f"no balance of forces found: {residual} is left")

    return _pushed(problem, softness, moved, solve)


def scipy_push(
    problem: PushProblem, tolerance: float, softness: float, balance: float, longest: float
) -> EndPose:
    """Integrated by `solve_ivp`, the balance of forces found by `root` at every evaluation.

    tolerance : relative, and a tenth of it absolute, in m and rad.
    balance : tolerance of `root`.
    softness : see `SupportPoints`.
    longest : step, m, so that no trial puts the rod inside the object.
    """

    def moved(velocity: Velocity, state: Array, distance: float) -> Array:
        found = solve_ivp(
            velocity, (0.0, distance), state, rtol=tolerance, atol=0.1 * tolerance, max_step=longest
        )
        assert found.success, found.message
        return np.asarray(found.y[:, -1])

    def solve(forces: Balance, guess: Array) -> Array:
        for method, start in (
            ("hybr", guess),
            ("lm", guess),
            ("hybr", 0.0 * guess),
            ("lm", 0.0 * guess),
        ):
            found = root(forces.residual, start, jac=True, method=method, tol=balance)
            if np.abs(found.fun).max() < _BALANCED:
                return np.asarray(found.x)
        raise ArithmeticError(f"no balance of forces found: {found.message}")

    return _pushed(problem, softness, moved, solve)


def _pushed(problem: PushProblem, softness: float, moved: Moved, solve: Solve) -> EndPose:
    points = SupportPoints(problem, softness)

    def end_pose(pose: Pose, push: SidePush) -> Pose:
        place, direction = map(np.array, problem.rod_path(pose, push))
        points.forget()

        def velocity(travel: float, now: Array) -> Array:
            return points.velocity(now, place + travel * direction, direction, solve)

        return Pose(
            *moved(velocity, np.array([pose.x, pose.y, pose.theta]), push.distance).tolist()
        )

    return end_pose


def _numpy(problem: PushProblem, finer: bool = False) -> EndPose:
    steps, *rest = NUMPY_SETTINGS[problem.name]
    return numpy_push(problem, 8 * steps if finer else steps, *rest)


def _scipy(problem: PushProblem, finer: bool = False) -> EndPose:
    tolerance, softness, balance, longest = SCIPY_SETTINGS[problem.name]
    if finer:
        tolerance, longest = 1e-3 * tolerance, 0.1 * longest
    return scipy_push(problem, tolerance, softness, balance, longest)


NUMPY = Simulator("plain NumPy", np.__version__, _numpy)
SCIPY = Simulator("SciPy solve_ivp", scipy.__version__, _scipy)
