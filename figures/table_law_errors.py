"""Table III: how far pushes lie from the law of θ0 that is fitted to them."""

from __future__ import annotations

import numpy as np

from cyclemap.evidence.laws.set_fit import MotionLaw
from cyclemap.views.sentences import listed

from .catalogue import MeasuredFolder
from .measured_sets import not_found
from .published_statistics import PUBLISHED_CYCLES
from .simulated_collections import (
    PAPER,
    QUANTITIES,
    MaterialPushes,
    Sampling,
    fitted_laws,
    material_pushes,
)

_COLUMNS = [
    word
    for name, unit, _ in QUANTITIES
    for word in (f"{name} RMSE ({unit})", "% of mean", "harmonics")
]
HEADER = ("material", "source", "pushes", *_COLUMNS)
# A material's pushes, and of each of its sets source and laws.
LawErrors = list[tuple[MaterialPushes, list[tuple[str, tuple[MotionLaw, ...]]]]]


def compute(measured: MeasuredFolder, sampling: Sampling = PAPER) -> LawErrors:
    """Simulate pushes on each material, look for recorded ones, and fit the laws of Δθ,
    Δx and Δy."""
    materials = material_pushes(measured, sampling)
    return [
        (material, [(source, fitted_laws(pushes)) for source, pushes in material.sets])
        for material in materials
    ]


def rows(result: LawErrors) -> list[tuple[str, ...]]:
    """The paper's row of each material, then those simulated, then the recorded one where it was
    found.
    """
    told = []
    for each, sets in result:
        cells, paper = [], each.published
        for rmse, percent, (_, _, factor) in zip(
            paper.rmse, paper.rmse_percent, QUANTITIES, strict=True
        ):
            cells += [f"{abs(factor) * rmse:.2f}", f"{percent:.2f}", ""]
        told.append((paper.material, "paper", str(PUBLISHED_CYCLES), *cells))
        for source, laws in sets:
            cells = []
            for found, (_, _, factor) in zip(laws, QUANTITIES, strict=True):
                law = found.law
                cells += [_error(found, factor)]
                cells += ["", ""] if law is None else [f"{law.percent:.2f}", str(law.harmonics)]
            told.append((paper.material, source, str(laws[0].value.size), *cells))
    return told


def caption(result: LawErrors) -> str:
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
    told = [
        "Root mean square error of the law of θ0 fitted to the pushes, the number of harmonics "
        "chosen by cross-validation. The paper's percentages are as it prints them, of means up to "
        "3 % off those of Table II. Simulated: in each push the centre of the limit ellipse is off "
        f"by {100 * min(jitter):.1f} to {100 * max(jitter):.1f} % RMS of the mean coefficient, as "
        "much as makes the next θ0 scatter by 1.1°, and nothing else.",
        *sentences,
        "What is left of the paper's errors may be wear, other scatter of friction and the "
        "instruments.",
        not_found("pushes", [each.published.material for each, _ in result if not each.recorded]),
    ]
    return " ".join(filter(None, told))


def _error(found: MotionLaw, factor: float) -> str:
    return "no law" if found.law is None else f"{abs(factor) * found.law.rmse:.2f}"
