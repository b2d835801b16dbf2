"""How well data left out are predicted: whole groups leave together, the rest is fitted, the errors are collected."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import whole_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.data_block import PLANE_KINDS, PRIOR_KIND, JointProblem, Labels, Progress
from cyclemap.evidence.identification.least_squares import NO_ANSWER, Fit, NoiseLaw, Search

# A fold's fit starts from that to all: it is close when the deviance stands still to this share.
_CLOSE = 1e-3


@dataclass(frozen=True)
class KindErrors:
    """Sizes of the errors of one kind in one block, in its own unit: in the sample, and of rows left out (nan: none).

    rows : how many errors; of a place or a force one each, the length of the vector by which it is off.
    mean, median : of the size. rms : root mean square. isotropic : the same errors of isotropic friction under even
    pressure, all else usual; nan where that has no answer.
    """

    block: str
    kind: str
    rows: int
    mean: float
    median: float
    rms: float
    left_out_mean: float
    left_out_median: float
    left_out_rms: float
    isotropic_mean: float
    isotropic_median: float


def random_folds(problem: JointProblem, folds: int, seed: int = 0) -> Labels:
    """Return the fold of each row (n,): the groups of each block dealt at random, in equal numbers; -1 for beliefs.

    Raises InvalidInput for fewer than two folds or more folds than groups.
    """
    stays = np.isin(problem.groups, problem.groups[problem.kinds == PRIOR_KIND])
    groups = len(np.unique(problem.groups[~stays]))
    if not 2 <= whole_number("folds", folds) <= groups:
        raise InvalidInput(f"folds must be from 2 to the {groups} groups of the data, not {folds}")
    rng, dealt, fold = np.random.default_rng(seed), 0, np.full(int(np.max(problem.groups)) + 1, -1)
    for block in range(len(problem.blocks)):
        members = rng.permutation(np.unique(problem.groups[(problem.block_index == block) & ~stays]))
        fold[members] = (dealt + np.arange(len(members))) % folds
        dealt += len(members)
    return fold[problem.groups]


def cross_validate(
    problem: JointProblem, fit: Fit, fold: Labels, law: NoiseLaw | None = None, progress: Progress | None = None
) -> tuple[Array, list[str]]:
    """Fit without each fold (n,), from the fit to all, and predict it; kinds keep the weights of the fit to all.

    Returns residuals (n,), predicted less measured, nan where a row was never left out (fold -1) or its fold had no
    answer, and why folds had none. `progress` is called with the fraction done.
    """
    count, whole = int(np.max(fold)) + 1, problem.values(fit.vector)
    residuals, failures = np.full(len(fold), np.nan), []
    for one in range(count):
        try:
            part = problem.subset(fold != one, whole)
            noise = np.array([fit.noise[problem.kind_names.index(kind)] for kind in part.kind_names])
            found = Search(part, law or NoiseLaw()).minimise(part.space.vector(whole), noise, _CLOSE)
            values = part.values(found.vector)
            left_out = problem.subset(fold == one, values)
            residuals[fold == one] = left_out.evaluate(left_out.space.vector(values))[0]
        except NO_ANSWER as cause:
            failures.append(f"fold {one}: {type(cause).__name__}: {cause}")
        if progress is not None:
            progress((one + 1) / count)
    return residuals, failures


def kind_errors(
    problem: JointProblem, fit: Fit, left_out: Array | None = None, isotropic: Array | None = None
) -> tuple[KindErrors, ...]:
    """Return the sizes of the errors of every kind in every block; also of rows left out, and of even isotropy."""
    nothing, found = np.full(len(fit.residuals), np.nan), []
    told = [fit.residuals, *(nothing if one is None else one for one in (left_out, isotropic))]
    for number, block in enumerate(problem.blocks):
        for kind in np.unique(np.asarray(block.kinds)).tolist():
            if kind == PRIOR_KIND:
                continue
            rows = (problem.block_index == number) & (problem.kinds == kind)
            sizes = []
            for errors in (residuals[rows] for residuals in told):
                # Of components the lengths of their vectors count.
                size = np.hypot(errors[::2], errors[1::2]) if kind in PLANE_KINDS else np.abs(errors)
                known = size[np.isfinite(size)]
                moments = (np.mean(known), np.median(known), np.sqrt(np.mean(known**2))) if known.size else [np.nan] * 3
                sizes += [float(moment) for moment in moments]
            found.append(KindErrors(block.name, kind, size.size, *sizes[:8]))
    return tuple(found)
