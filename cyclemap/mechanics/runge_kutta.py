"""An explicit Runge-Kutta method of order 5: its coefficients, its steps and their lengths."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

# Dormand & Prince's method of order 5 with its estimator of order 4 (Hairer, Norsett & Wanner 1993, II.5). Their method
# of order 8 took a quarter longer for the same error: where the centre of rotation crosses the rim, or a support point,
# the motion is only twice differentiable.
STAGES = 6
A: NDArray[np.float64] = np.array(
    (
        (0, 0, 0, 0, 0),
        (1 / 5, 0, 0, 0, 0),
        (3 / 40, 9 / 40, 0, 0, 0),
        (44 / 45, -56 / 15, 32 / 9, 0, 0),
        (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0),
        (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    )
)
B: NDArray[np.float64] = np.array((35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84))
C: NDArray[np.float64] = np.array((0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1))
# Weights (7,) of the slopes, the end's last, in the estimate.
ERROR: NDArray[np.float64] = np.array((-71 / 57600, 0, 71 / 16695, -71 / 1920, 17253 / 339200, -22 / 525, 1 / 40))

# Weights of the slopes in the difference from a method of order 3 of the same stages. It falls with the fourth power of
# the step, the estimate with the fifth: where the estimate nearly vanishes by chance, as it may when the centre of
# rotation crosses the rim within a step, this share of the step (extents) times the difference takes its place.
ROUGH: NDArray[np.float64] = np.array((-7 / 1152, 0, 16 / 3339, 37 / 192, -2187 / 6784, 11 / 84, 0))
LEAST_SHARE = 0.02

# Exponent, safety and bounds of the step-size controller.
_ORDER = 5
SAFETY, SHRINK, GROW = 0.8, 0.2, 2.0

# One evaluation of a motion: state 2, slope 2, margins 5, the contact's unknowns.
STATE, SLOPE, MARGIN, UNKNOWN = slice(0, 2), slice(2, 4), slice(4, 9), slice(9, None)


@dataclass(frozen=True)
class Step:
    """One step of length h: its 6 stages and its end, (7, 9 + unknowns), and the error estimate (maximum norm)."""

    h: float
    stages: NDArray[np.float64]
    error: float

    @property
    def end(self) -> NDArray[np.float64]:
        """State at the end."""
        return self.stages[-1, STATE]


def step(evaluate: Callable[[NDArray[np.float64]], NDArray[np.float64]], state: NDArray[np.float64], h: float) -> Step:
    """Return the step of length h from `state` (2,), evaluating stage by stage."""
    stages = [evaluate(state)]
    slopes = np.empty((STAGES + 1, 2))
    slopes[0] = stages[0][SLOPE]
    for i in range(1, STAGES + 1):
        weights = A[i, :i] if i < STAGES else B
        stages.append(evaluate(state + h * (weights @ slopes[:i])))
        slopes[i] = stages[-1][SLOPE]
    return Step(h, np.array(stages), abs(h) * error_rate(slopes, h))


def error_rate(slopes: NDArray[np.float64], h: float) -> float:
    """Return the estimate of a step's error (maximum norm) over its length h, from its slopes (7, 2)."""
    return float(max(np.abs(ERROR @ slopes).max(), LEAST_SHARE * abs(h) * np.abs(ROUGH @ slopes).max()))


def next_length(h: float, error: float, tolerance: float) -> float:
    """Return the length at which the error should just meet the tolerance, within the controller's bounds."""
    if not math.isfinite(error):
        return h * SHRINK
    factor = SAFETY * (tolerance / max(error, 1e-300)) ** (1.0 / _ORDER)
    return float(h * min(GROW, max(SHRINK, factor)))
