"""Calibration of every p-value under its null: `python -m tests.calibration [RUNS] [STUDY ...]`
from the root.

How often p-values reject, with binomial errors, and how uniform they are.
"""

import os
import sys
import time

# As the command line does, and before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from tests.calibration.p_value_studies import STUDIES

LEVELS = (0.01, 0.05, 0.10)
HEADER = (
    f"{'p-value':<38}{'runs':>6}"
    + "".join(f"{f'at {level:.0%}':>15}" for level in LEVELS)
    + f"{'KS p':>8}"
)


def lattice_step(values: np.ndarray) -> float:
    """1/(runs + 1) where the p-values are Monte Carlo ones, 0 where they are not multiples of
    anything.
    """
    step = float(np.min(np.diff(np.unique(values)), initial=1.0))
    grid = values / step
    return step if step > 1e-4 and bool(np.allclose(grid, np.round(grid), atol=1e-6)) else 0.0


def row(name: str, values: np.ndarray) -> str:
    """One line of the table; a level that no p-value can reach has no rate."""
    from scipy.stats import kstest

    if not values.size:
        return f"{name:<38}{0:>6}  too little was seen in every run"
    step, told = lattice_step(values), ""
    for level in LEVELS:
        rate, error = np.mean(values <= level + 1e-12), np.sqrt(level * (1.0 - level) / values.size)
        told += f"{'-' if step > level + 1e-9 else f'{100 * rate:.1f} ± {100 * error:.1f} %':>15}"
    # Monte Carlo p-values are multiples of 1/(runs + 1): each is spread evenly over the step below
    # it.
    spread = values - np.random.default_rng(0).uniform(0.0, 1.0, values.size) * step
    return f"{name:<38}{values.size:>6}{told}{kstest(spread, 'uniform').pvalue:>8.3f}"


if __name__ == "__main__":
    arguments = sys.argv[1:]
    count = int(arguments.pop(0)) if arguments and arguments[0].isdigit() else 400
    unknown = set(arguments) - set(STUDIES)
    if unknown:
        sys.exit(f"unknown study {', '.join(sorted(unknown))}; known: {', '.join(STUDIES)}")
    print(HEADER, flush=True)
    for name in arguments or STUDIES:
        study, runs = STUDIES[name]
        begun = time.perf_counter()
        for test, values in study(count, runs, 1000).items():
            print(row(test, values), flush=True)
        print(f"  {name}: {time.perf_counter() - begun:.0f} s", flush=True)
