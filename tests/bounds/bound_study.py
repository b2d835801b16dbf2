"""Every number of noisy random lifts beside the same one by dense sums: errors over bounds,
refusals, time.
"""

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps import UniformNoise, lyapunov_exponent, transfer_operator
from tests.bounds.random_lifts import (
    DenseNumbers,
    RandomLift,
    dense_exponent,
    dense_numbers,
    random_lift,
)

ROUNDING = 1e-14  # of the dense sums
EXPONENTS = 0.1  # share of the lifts whose Lyapunov exponent is asked for


@dataclass
class BoundStudy:
    """How many numbers were judged, which bounds broke (with the place of the lift or family), what
    was refused, seconds each took.
    """

    judged: Counter[str] = field(default_factory=Counter)
    broken: list[str] = field(default_factory=list)
    refused: Counter[str] = field(default_factory=Counter)
    largest: dict[str, float] = field(default_factory=dict)
    seconds: list[float] = field(default_factory=list)

    def judge(self, name: str, where: str, error: float, bound: float, off: float = 0.0) -> None:
        """Count one number; ``off`` is what the truth beside it may be off."""
        self.judged[name] += 1
        self.largest[name] = max(self.largest.get(name, 0.0), bound)
        if not error <= bound + off:
            self.broken.append(f"{name} of {where}: off by {error:.3g}, bound {bound:.3g}")


def study(lifts: int, seed: int, late: Callable[[], bool] = lambda: False) -> BoundStudy:
    """Judge so many random lifts, each of its own seed; ends early when it is ``late``."""
    found = BoundStudy()
    for place in range(lifts):
        if late():
            break
        rng = np.random.default_rng([seed, place])
        case = random_lift(rng)
        where = f"lift {place} ({case.kind}, {case.waves} waves, {case.noise})"
        begun = time.process_time()
        try:
            _judge(found, case, where, rng, dense_numbers(case))
        except (ConvergenceError, InvalidInput) as refusal:
            found.refused[" ".join(str(refusal).split()[-6:])] += 1
        found.seconds.append(time.process_time() - begun)
    return found


def _judge(
    found: BoundStudy, case: RandomLift, where: str, rng: np.random.Generator, dense: DenseNumbers
) -> None:
    operator, off = transfer_operator(case.map, case.noise), dense.off + ROUNDING
    for order in (1, 2):
        error = abs(operator.moment(order) - dense.moments[order])
        found.judge("moment", where, error, operator.moment_error(order), off)
    rotation = operator.rotation_number
    found.judge("rotation", where, abs(rotation - dense.rotation), rotation.error_bound, off)
    if isinstance(case.noise, UniformNoise):
        return
    angles = rng.uniform(0.0, 2 * np.pi, 8)
    error = float(np.max(np.abs(operator.density(angles) - dense.density(angles))))
    found.judge("density", where, error, operator.error_bound, off)
    if rng.uniform() < EXPONENTS and np.all(
        case.map.derivative(np.linspace(0.0, 2 * np.pi, 50_000)) > 0.01
    ):
        exponent = lyapunov_exponent(case.map, case.noise)
        error = abs(exponent - dense_exponent(case, dense))
        found.judge("exponent", where, error, exponent.error_bound, 1e-12)


def table(found: BoundStudy) -> str:
    """What was found, a row a number."""
    rows = [
        f"{len(found.seconds)} of them, {np.mean(found.seconds):.3f} s of a core each, the truth "
        "beside it included"
    ]
    rows += [
        f"{name:<26}{count:>7} judged, largest bound {found.largest[name]:.2g}"
        for name, count in found.judged.items()
    ]
    rows += [f"refused {count:>6}: ... {words}" for words, count in found.refused.items()]
    return "\n".join([*rows, f"bounds below the error: {len(found.broken)}", *found.broken])
