"""Table II: how much equal pushes differ; mean, standard deviation and percentage of Δθ, Δx and Δy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array
from cyclemap.evidence import PushStatistics, push_statistics
from cyclemap.evidence.published_statistics import PUBLISHED_CYCLES

from .catalogue import MeasuredFolder, PaperTable
from .measured_sets import not_found
from .simulated_collections import PAPER, QUANTITIES, MaterialPushes, Sampling, absent, material_pushes

_COLUMNS = [word for name, unit, _ in QUANTITIES for word in (f"{name} mean ({unit})", f"std ({unit})", "% of mean")]
HEADER = ("material", "source", "pushes", *_COLUMNS)


@dataclass(frozen=True, eq=False)
class Deviations:
    """The table. materials : with the pushes. statistics : (source, statistics) of every set of each material."""

    materials: tuple[MaterialPushes, ...]
    statistics: tuple[tuple[tuple[str, PushStatistics], ...], ...]


def compute(measured: MeasuredFolder, sampling: Sampling = PAPER) -> Deviations:
    """Simulate pushes on each material, look for recorded ones, and take their statistics."""
    materials = material_pushes(measured, sampling)
    found = tuple(tuple((source, push_statistics(one)) for source, one in each.sets) for each in materials)
    return Deviations(materials, found)


def rows(result: Deviations) -> list[tuple[str, ...]]:
    """The paper's row of each material, then those simulated, then the recorded one where it was found."""
    told = []
    for each, statistics in zip(result.materials, result.statistics, strict=True):
        given = zip(each.published.mean, each.published.std, strict=True)
        told.append((each.surface, "paper", str(PUBLISHED_CYCLES), *_cells(np.array(list(given)))))
        told += [(each.surface, source, str(one.count), *_cells(_numbers(one))) for source, one in statistics]
    return told


def _numbers(one: PushStatistics) -> Array:
    """(3, 2): mean and standard deviation of Δθ, dx, dy; NaN where there are too few pushes."""
    given = (one.dtheta, one.dx, one.dy)
    return np.array([(np.nan, np.nan) if row is None else (row.mean, row.std) for row in given])


def _cells(numbers: Array) -> list[str]:
    cells = []
    for (mean, std), (_, _, factor) in zip(numbers, QUANTITIES, strict=True):
        cells += [f"{factor * mean:.1f}", f"{abs(factor) * std:.2f}", f"{100.0 * std / abs(mean):.2f}"]
    return cells


def caption(result: Deviations) -> str:
    """What the rows are, and how far the simulated ones lie from the paper's."""
    told = [
        "Mean and standard deviation of equal pushes. The paper's means are its standard deviations over their "
        "percentages; its Δy is minus this package's dy. Simulated: friction is off by a random offset in each push, "
        "as much as makes the next θ0 scatter by 1.1°; no error of the instruments is added.",
        *[_sentence(index, *QUANTITIES[index], result) for index in range(len(QUANTITIES))],
        not_found("pushes", absent(result.materials)),
    ]
    return " ".join(filter(None, told))


def _sentence(index: int, name: str, unit: str, factor: float, result: Deviations) -> str:
    offs, shares = simulated_against_paper(result)[index]
    furthest = abs(factor) * float(np.max(np.abs(offs)))
    return (
        f"Simulated means of {name} are within {furthest:.1f} {unit} of the paper's, simulated spreads "
        f"{min(shares):.2f} to {max(shares):.2f} of the paper's."
    ).replace(" °", "°")


def simulated_against_paper(result: Deviations) -> list[tuple[list[float], list[float]]]:
    """For Δθ, dx, dy: the simulated means less the paper's (rad, m), and the simulated spreads over the paper's."""
    found = []
    for index in range(len(QUANTITIES)):
        offs, shares = [], []
        for each, statistics in zip(result.materials, result.statistics, strict=True):
            for source, one in statistics:
                if source.startswith("simulated"):
                    mean, std = _numbers(one)[index]
                    offs.append(float(mean - each.published.mean[index]))
                    shares.append(float(std / each.published.std[index]))
        found.append((offs, shares))
    return found


TABLE = PaperTable(compute, HEADER, rows, caption)
