"""How often p-values reject under their null, with binomial errors, and how uniform they are."""

import numpy as np

LEVELS = (0.01, 0.05, 0.10)
HEADER = f"{'p-value':<38}{'runs':>6}" + "".join(f"{f'at {level:.0%}':>15}" for level in LEVELS) + f"{'KS p':>8}"


def rejection_rate(values: np.ndarray, level: float) -> tuple[float, float]:
    """The share of p-values at or below ``level``, and the binomial error that the level itself would have."""
    return float(np.mean(values <= level + 1e-12)), float(np.sqrt(level * (1.0 - level) / values.size))


def uniformity(values: np.ndarray, seed: int = 0) -> float:
    """P-value of a Kolmogorov-Smirnov test of uniformity.

    Monte Carlo p-values are multiples of 1/(runs + 1): each is spread evenly over the step below it.
    """
    from scipy.stats import kstest

    step = lattice_step(values)
    shift = np.random.default_rng(seed).uniform(0.0, 1.0, values.size) * step
    return float(kstest(values - shift, "uniform").pvalue)


def lattice_step(values: np.ndarray) -> float:
    """1/(runs + 1) where the p-values are Monte Carlo ones, 0 where they are not multiples of anything."""
    step = float(np.min(np.diff(np.unique(values)), initial=1.0))
    grid = values / step
    return step if step > 1e-4 and bool(np.allclose(grid, np.round(grid), atol=1e-6)) else 0.0


def row(name: str, values: np.ndarray) -> str:
    """One line of the table; a level that no p-value can reach has no rate."""
    if not values.size:
        return f"{name:<38}{0:>6}  too little was seen in every run"
    step, told = lattice_step(values), ""
    for level in LEVELS:
        rate, error = rejection_rate(values, level)
        told += f"{'-' if step > level + 1e-9 else f'{100 * rate:.1f} ± {100 * error:.1f} %':>15}"
    return f"{name:<38}{values.size:>6}{told}{uniformity(values):>8.3f}"
