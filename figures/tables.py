"""Tables I to III: the friction ellipses of the materials, how much equal pushes differ, and how
far they lie from a law of θ0 that is fitted to them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import TWO_PI, Array
from cyclemap.collection import CollectionLoop
from cyclemap.collection.loop_surfaces import Anisotropy
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence import PushSet, friction_ellipse_from_scans, push_statistics
from cyclemap.evidence.laws.set_fit import MotionLaw
from cyclemap.mechanics import EllipseFriction, load_material
from cyclemap.views.sentences import angle, listed

from . import Exhibit, MeasuredFolder
from .repeated_pushes import (
    PAPER,
    PUBLISHED_CYCLES,
    QUANTITIES,
    SIMULATED,
    MaterialPushes,
    Sampling,
    fitted_laws,
    material_pushes,
    measured_scans,
    not_found,
)

FRICTION_HEADER = (
    "material",
    "source",
    "μa",
    "μb",
    "m0",
    "n0",
    "φ (°)",
    "mean √(μa μb)",
    "axis ratio",
    "offset (% of mean)",
    "offset towards (°)",
)


@dataclass(frozen=True)
class FrictionRow:
    """One limit ellipse.

    surface : the paper's name.
    material : the row's.
    source : where the numbers come from.
    """

    surface: str
    material: str
    source: str
    law: EllipseFriction

    @property
    def mean(self) -> float:
        """The geometric mean of the axes: the radius of the circle of the same area."""
        return math.sqrt(self.law.mu_a * self.law.mu_b)

    @property
    def axis_ratio(self) -> float:
        """The longer axis over the shorter."""
        return math.exp(2.0 * self.anisotropy.ellipticity)

    @property
    def anisotropy(self) -> Anisotropy:
        """How far its centre lies from zero, over the mean, and where; and its shape."""
        return Anisotropy.of(self.law)


@dataclass(frozen=True)
class FrictionEllipses:
    """The table.

    absent : materials without friction scans.
    unfitted : those whose scans fix no ellipse, and why.
    """

    rows: tuple[FrictionRow, ...]
    absent: tuple[str, ...]
    unfitted: tuple[tuple[str, str], ...]


def friction_ellipses(measured: MeasuredFolder) -> FrictionEllipses:
    """Gather the materials' ellipses, and fit one to the friction scans of each where the folder
    has them.
    """
    weight = CollectionLoop.mit().model.weight
    rows: list[FrictionRow] = []
    absent, unfitted = [], []
    for surface, materials in SIMULATED.items():
        for name in materials:
            # The fresh surface and, where it wears, the worn one.
            material = load_material(name)
            wear, source = material.wear, "inferred from motion" if material.inferred else "paper"
            fresh = source if wear is None else f"{source}, fresh"
            rows.append(FrictionRow(surface, name, fresh, material.friction))
            if wear is not None:
                rows.append(
                    FrictionRow(
                        surface, name, f"{source}, after {wear.cycles:.0f} pushes", wear.friction
                    )
                )
        scans = measured_scans(measured, surface)
        if scans is None:
            absent.append(surface)
            continue
        try:
            law = friction_ellipse_from_scans(scans, weight)
        except (InvalidInput, ConvergenceError) as error:
            unfitted.append((surface, str(error)))
        else:
            rows.append(
                FrictionRow(surface, surface, f"{len(scans)} recorded scans", law.friction())
            )
    return FrictionEllipses(tuple(rows), tuple(absent), tuple(unfitted))


def friction_rows(result: FrictionEllipses) -> list[tuple[str, ...]]:
    """A row an ellipse."""
    cells = []
    for row in result.rows:
        law, direction = row.law, f"{math.degrees(row.anisotropy.offset_direction % TWO_PI):.1f}"
        given = [f"{value:.4f}" for value in (law.mu_a, law.mu_b, law.m0, law.n0)]
        derived = [
            f"{row.mean:.4f}",
            f"{row.axis_ratio:.3f}",
            f"{100 * row.anisotropy.offset:.1f}",
            direction,
        ]
        cells.append((row.material, row.source, *given, f"{math.degrees(law.phi):.2f}", *derived))
    return cells


def friction_caption(result: FrictionEllipses) -> str:
    """Where the rows come from, and what the paper's ellipse is like beside the others."""
    paper = next(row for row in result.rows if row.source == "paper")
    others = [row for row in result.rows if row.source.startswith("inferred")]
    ratios, offsets = (
        [row.axis_ratio for row in others],
        [100 * row.anisotropy.offset for row in others],
    )
    scanned = [row.surface for row in result.rows if row.source.endswith("recorded scans")]
    sentences = [
        f"Limit ellipses of point friction. The paper gives that of {paper.material} alone, with φ "
        f"= {paper.law.phi:.4f} rad: its axes differ by {100 * (paper.axis_ratio - 1):.1f} %, and "
        f"its centre lies {100 * paper.anisotropy.offset:.1f} % of the mean coefficient from "
        f"zero, towards {angle(paper.anisotropy.offset_direction, 0)}. The others are inferred "
        "from how objects moved, which does not tell the size of friction: their mean is 0.25 by "
        f"convention. Their axis ratios are {min(ratios):.2f} to {max(ratios):.2f}, their offsets "
        f"{min(offsets):.1f} to {max(offsets):.1f} % of the mean.",
        f"Ellipses are fitted to recorded friction scans on {listed(scanned)}." if scanned else "",
        *[
            f"The recorded friction scans on {name} fix no ellipse: {why}."
            for name, why in result.unfitted
        ],
        not_found("friction scans", result.absent),
    ]
    return " ".join(filter(None, sentences))


def _header(*columns: str) -> tuple[str, ...]:
    """The header of a table of pushes, with columns for each quantity."""
    words = ["material", "source", "pushes"]
    for name, unit, _ in QUANTITIES:
        words += [column.format(name=name, unit=unit) for column in columns]
    return tuple(words)


DEVIATION_HEADER = _header("{name} mean ({unit})", "std ({unit})", "% of mean")


def _spread(pushes: PushSet) -> tuple[int, Array]:
    """How many pushes there are, and (3, 2) mean and standard deviation; NaN of too few."""
    statistics = push_statistics(pushes)
    numbers = [
        (statistic.mean, statistic.std) if statistic else (np.nan, np.nan)
        for statistic in (statistics.dtheta, statistics.dx, statistics.dy)
    ]
    return statistics.count, np.array(numbers)


def deviation_rows(result: list[MaterialPushes]) -> list[tuple[str, ...]]:
    """The paper's row of each material, then those simulated, then the recorded one where it was
    found.
    """
    rows = []
    for each in result:
        published = np.transpose([each.published.mean, each.published.std])
        spreads = {"paper": (PUBLISHED_CYCLES, published)}
        spreads |= {source: _spread(pushes) for source, pushes in each.sets}
        for source, (count, numbers) in spreads.items():
            cells = []
            for (mean, std), (_, _, factor) in zip(numbers, QUANTITIES, strict=True):
                percent = 100.0 * std / abs(mean)
                cells += [f"{factor * mean:.1f}", f"{abs(factor) * std:.2f}", f"{percent:.2f}"]
            rows.append((each.published.material, source, str(count), *cells))
    return rows


def deviation_caption(result: list[MaterialPushes]) -> str:
    """What the rows are, and how far the simulated ones lie from the paper's."""
    offs, shares = [], []
    for each in result:
        for source, pushes in each.sets:
            if source.startswith("simulated"):
                _, numbers = _spread(pushes)
                offs.append(np.abs(numbers[:, 0] - each.published.mean))
                shares.append(numbers[:, 1] / each.published.std)
    furthest, low, high = np.max(offs, axis=0), np.min(shares, axis=0), np.max(shares, axis=0)
    sentences = [
        "Mean and standard deviation of equal pushes. The paper's means are its standard "
        "deviations over their percentages; its Δy is minus this package's dy. Simulated: friction "
        "is off by a random offset in each push, as much as makes the next θ0 scatter by 1.1°; no "
        "error of the instruments is added."
    ]
    for index, (name, unit, factor) in enumerate(QUANTITIES):
        within = f"{abs(factor) * furthest[index]:.1f} {unit}".replace(" °", "°")
        sentences.append(
            f"Simulated means of {name} are within {within} of the paper's, simulated spreads "
            f"{low[index]:.2f} to {high[index]:.2f} of the paper's."
        )
    return " ".join(filter(None, [*sentences, _not_recorded(result)]))


def _not_recorded(materials: list[MaterialPushes]) -> str:
    absent = [each.published.material for each in materials if len(each.sets) == len(each.runs)]
    return not_found("pushes", absent)


LAW_ERROR_HEADER = _header("{name} RMSE ({unit})", "% of mean", "harmonics")
# A material's pushes, and of each of its sets source and laws.
LawErrors = list[tuple[MaterialPushes, list[tuple[str, tuple[MotionLaw, ...]]]]]


def law_errors(measured: MeasuredFolder, sampling: Sampling = PAPER) -> LawErrors:
    """Simulate pushes on each material, look for recorded ones, and fit the laws of Δθ,
    Δx and Δy."""
    materials = material_pushes(measured, sampling)
    return [
        (material, [(source, fitted_laws(pushes)) for source, pushes in material.sets])
        for material in materials
    ]


def law_error_rows(result: LawErrors) -> list[tuple[str, ...]]:
    """The paper's row of each material, then those simulated, then the recorded one where it was
    found.
    """
    lines = []
    for each, sets in result:
        cells, paper = [], each.published
        for rmse, percent, (_, _, factor) in zip(
            paper.rmse, paper.rmse_percent, QUANTITIES, strict=True
        ):
            cells += [f"{abs(factor) * rmse:.2f}", f"{percent:.2f}", ""]
        lines.append((paper.material, "paper", str(PUBLISHED_CYCLES), *cells))
        for source, laws in sets:
            cells = []
            for fitted, (_, _, factor) in zip(laws, QUANTITIES, strict=True):
                law = fitted.law
                cells += [_error(fitted, factor)]
                cells += ["", ""] if law is None else [f"{law.percent:.2f}", str(law.harmonics)]
            lines.append((paper.material, source, str(laws[0].value.size), *cells))
    return lines


def law_error_caption(result: LawErrors) -> str:
    """What the rows are, and how much of the paper's errors the simulated scatter explains."""
    jitter = [
        np.sqrt(np.mean(np.sum(run.jitter**2, axis=1))) for each, _ in result for run in each.runs
    ]
    sentences = []
    for index, (name, unit, factor) in enumerate(QUANTITIES):
        errors = []
        for each, sets in result:
            # The last material simulated is the one that stands for the paper's.
            law = sets[len(each.runs) - 1][1][index]
            paper = f"{abs(factor) * each.published.rmse[index]:.2f} on {each.published.material}"
            errors.append(f"{_error(law, factor)} of {paper}")
        sentences.append(f"{name} ({unit}): {listed(errors)}.")
    paragraphs = [
        "Root mean square error of the law of θ0 fitted to the pushes, the number of harmonics "
        "chosen by cross-validation. The paper's percentages are as it prints them, of means up to "
        "3 % off those of Table II. Simulated: in each push the centre of the limit ellipse is off "
        f"by {100 * min(jitter):.1f} to {100 * max(jitter):.1f} % RMS of the mean coefficient, as "
        "much as makes the next θ0 scatter by 1.1°, and nothing else.",
        *sentences,
        "What is left of the paper's errors may be wear, other scatter of friction and the "
        "instruments.",
        _not_recorded([each for each, _ in result]),
    ]
    return " ".join(filter(None, paragraphs))


def _error(fitted: MotionLaw, factor: float) -> str:
    return "no law" if fitted.law is None else f"{abs(factor) * fitted.law.rmse:.2f}"


EXHIBITS = {
    "table-friction": Exhibit(
        friction_ellipses, friction_caption, header=FRICTION_HEADER, rows=friction_rows
    ),
    "table-deviations": Exhibit(
        material_pushes, deviation_caption, header=DEVIATION_HEADER, rows=deviation_rows
    ),
    "table-law-errors": Exhibit(
        law_errors, law_error_caption, header=LAW_ERROR_HEADER, rows=law_error_rows
    ),
}
