"""Table II: how much equal pushes differ; mean, standard deviation and percentage of Δθ,
Δx and Δy."""

from __future__ import annotations

import numpy as np

from cyclemap.arrays import Array
from cyclemap.evidence import push_statistics

from .catalogue import MeasuredFolder
from .measured_sets import not_found
from .published_statistics import PUBLISHED_CYCLES
from .simulated_collections import PAPER, QUANTITIES, MaterialPushes, Sampling, material_pushes

_COLUMNS = [
    word
    for name, unit, _ in QUANTITIES
    for word in (f"{name} mean ({unit})", f"std ({unit})", "% of mean")
]
HEADER = ("material", "source", "pushes", *_COLUMNS)
# A material's pushes; and of each of its sets source, number of pushes, and (3, 2) mean and
# standard deviation.
Deviations = list[tuple[MaterialPushes, list[tuple[str, int, Array]]]]


def compute(measured: MeasuredFolder, sampling: Sampling = PAPER) -> Deviations:
    """Simulate pushes on each material, look for recorded ones, and take their statistics; NaN of
    too few pushes.
    """
    found: Deviations = []
    for each in material_pushes(measured, sampling):
        numbers = []
        for source, pushes in each.sets:
            told = push_statistics(pushes)
            given = [
                (statistic.mean, statistic.std) if statistic else (np.nan, np.nan)
                for statistic in (told.dtheta, told.dx, told.dy)
            ]
            numbers.append((source, told.count, np.array(given)))
        found.append((each, numbers))
    return found


def rows(result: Deviations) -> list[tuple[str, ...]]:
    """The paper's row of each material, then those simulated, then the recorded one where it was
    found.
    """
    told = []
    for each, sets in result:
        paper = ("paper", PUBLISHED_CYCLES, np.transpose([each.published.mean, each.published.std]))
        for source, count, numbers in (paper, *sets):
            cells = []
            for (mean, std), (_, _, factor) in zip(numbers, QUANTITIES, strict=True):
                cells += [
                    f"{factor * mean:.1f}",
                    f"{abs(factor) * std:.2f}",
                    f"{100.0 * std / abs(mean):.2f}",
                ]
            told.append((each.published.material, source, str(count), *cells))
    return told


def caption(result: Deviations) -> str:
    """What the rows are, and how far the simulated ones lie from the paper's."""
    offs, shares = [], []
    for each, sets in result:
        for source, _, numbers in sets:
            if source.startswith("simulated"):
                offs.append(np.abs(numbers[:, 0] - each.published.mean))
                shares.append(numbers[:, 1] / each.published.std)
    furthest, low, high = np.max(offs, axis=0), np.min(shares, axis=0), np.max(shares, axis=0)
    told = [
        "Mean and standard deviation of equal pushes. The paper's means are its standard "
        "deviations over their percentages; its Δy is minus this package's dy. Simulated: friction "
        "is off by a random offset in each push, as much as makes the next θ0 scatter by 1.1°; no "
        "error of the instruments is added."
    ]
    for index, (name, unit, factor) in enumerate(QUANTITIES):
        within = f"{abs(factor) * furthest[index]:.1f} {unit}".replace(" °", "°")
        told.append(
            f"Simulated means of {name} are within {within} of the paper's, simulated spreads "
            f"{low[index]:.2f} to {high[index]:.2f} of the paper's."
        )
    told.append(
        not_found("pushes", [each.published.material for each, _ in result if not each.recorded])
    )
    return " ".join(filter(None, told))
