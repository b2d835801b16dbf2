"""An explicit Runge-Kutta method of order 7: its coefficients, its steps and their lengths."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

# Verner's efficient method of order 7 with its estimator of order 6 (Numerically optimal Runge-Kutta pairs with
# interpolants, Numerical Algorithms 53, 2010: pair IIa). For errors of 1e-10 it evaluates two fifths less often than
# Dormand & Prince's method of order 5, for errors of 1e-7 no more often.
STAGES = 10
_ROWS: tuple[tuple[float, ...], ...] = (
    (),
    (0.005,),
    (-1.0767901234567901, 1.1856790123456790),
    (0.040833333333333333, 0.0, 0.1225),
    (0.63891392362557267, 0.0, -2.4556726382236568, 2.2722587145980841),
    (-2.6615773750187571, 0.0, 10.804513886456137, -8.3539146573961994, 0.82048759495665697),
    (6.0677414346967710, 0.0, -24.711273635911086, 20.427517930788894, -1.9061579788166471, 1.0061722492420680),
    (
        *(12.054670076253203, 0.0, -49.754784950468989, 41.142888638604677, -4.4617601499740042),
        *(2.0423348222391750, -0.098348436654061074),
    ),
    (
        *(10.138146522881808, 0.0, -42.641136031717502, 35.763840039922571, -4.3480228403929077),
        *(2.0098622683770359, 0.34874904603382724, -0.27143900510483128),
    ),
    (
        *(-45.030072034298677, 0.0, 187.32724376545888, -154.02882369350187, 18.564653063475362),
        *(-7.1418096792950789, 1.3088085781613786),
    ),
)
A: NDArray[np.float64] = np.array([row + (0.0,) * (STAGES - 1 - len(row)) for row in _ROWS])
_WEIGHTS = (
    *(0.047155618486272222, 0.0, 0.0, 0.25750564298434152, 0.26216653977412620),
    *(0.15216092656738557, 0.49399691700324842, -0.29430311714032504, 0.081317472324951099, 0.0),
)
_LOWER = (
    *(0.044608606606341176, 0.0, 0.0, 0.26716403785713727, 0.22010183001772930),
    *(0.21884317031431568, 0.22898717054112028, 0.0, 0.0, 0.020295184663356282),
)
B: NDArray[np.float64] = np.array(_WEIGHTS)
C: NDArray[np.float64] = np.array((0, 0.005, 49 / 450, 49 / 300, 0.4555, 0.60950944899783813, 0.884, 0.925, 1.0, 1.0))
# Weights (11,) of the slopes, the end's last, in the estimate.
ERROR: NDArray[np.float64] = np.append(B - np.array(_LOWER), 0.0)


def _rough() -> NDArray[np.float64]:
    """Weights (11,) of the fifth divided difference of the slopes at six stages, that of the last as in the method."""
    used = np.array((0, 3, 4, 5, 6, 7))
    apart = C[used, None] - C[used] + np.eye(used.size)
    weights = np.zeros(STAGES + 1)
    weights[used] = 1.0 / apart.prod(axis=1)
    return np.asarray(weights * B[used[-1]] / weights[used[-1]])


# What a method of order 5 of the same stages would add. It falls with the sixth power of the step, the estimate with
# the seventh. This share of the step (extents) times the difference counts where it is the larger: as large on usual
# steps, it remains where the estimate nearly vanishes by chance, as it may when the centre of rotation crosses the rim
# within a step. Shares of 0.05 left single cycles eight accuracies off, 0.3 and 0.5 none beyond one and a half.
ROUGH = _rough()
LEAST_SHARE = 0.3

# Weights (11,) for the middle of a step: of the slopes, for the state there off that at the start; of what depends on
# the state, for its value there. The least that meet all conditions of order 5 (Hairer, Norsett & Wanner 1993, II.6).
MIDDLE_STATE: NDArray[np.float64] = np.array(
    (
        *(0.035872124140919226, 0.0, 0.0, 0.2927778629723282, 0.15466583111049065, 0.035335738322645936),
        *(
            -0.022795887222108478,
            -0.01598795836457182,
            -0.002983084893816224,
            -0.00813462606585775,
            0.03124999999997027,
        ),
    )
)
MIDDLE_VALUE: NDArray[np.float64] = np.array(
    (
        *(-0.013511819410986205, 0.0, 0.0, 0.02972671393272141, 0.5677895152953676, 0.49678072753427055),
        *(-0.06264859328084359, -0.09655820701226067, -0.043937232907102934, -0.06514110415106912, 0.18749999999990288),
    )
)

# Exponent, safety and bounds of the step-size controller.
ORDER = 7
SAFETY, SHRINK, GROW = 0.8, 0.2, 4.0

# One evaluation of a motion: state 2, slope 2, margins 5, the contact's unknowns.
STATE, SLOPE, MARGIN, UNKNOWN = slice(0, 2), slice(2, 4), slice(4, 9), slice(9, None)


@dataclass(frozen=True)
class Step:
    """One step of length h: its 10 stages and its end, (11, 9 + unknowns), and the error estimate (maximum norm)."""

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
    """Return the estimate of a step's error (maximum norm) over its length h, from its slopes (11, 2)."""
    return float(max(np.abs(ERROR @ slopes).max(), LEAST_SHARE * abs(h) * np.abs(ROUGH @ slopes).max()))


def next_length(h: float, error: float, tolerance: float) -> float:
    """Return the length at which the error should just meet the tolerance, within the controller's bounds.

    To eight binary digits, downwards: else it would follow the rounding of an error that is itself a difference.
    """
    if not math.isfinite(error):
        return h * SHRINK
    factor = SAFETY * (tolerance / max(error, 1e-300)) ** (1.0 / ORDER)
    mantissa, exponent = math.frexp(h * min(GROW, max(SHRINK, factor)))
    return math.ldexp(math.floor(256.0 * mantissa), exponent - 8)
