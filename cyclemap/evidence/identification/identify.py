"""Identify parameters from blocks of data: several starts, intervals, cross-validation, and all that qualifies them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import whole_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.cross_validation import (
    CrossValidation,
    cross_validate,
    kind_errors,
    labelled_folds,
    random_folds,
)
from cyclemap.evidence.identification.data_block import DataBlock
from cyclemap.evidence.identification.identifiability import Uncertainty, student_quantile, uncertainty
from cyclemap.evidence.identification.identification import Identification, estimate
from cyclemap.evidence.identification.joint_problem import JointProblem
from cyclemap.evidence.identification.least_squares import (
    NO_ANSWER,
    Fit,
    MultiStart,
    fit_with_noise,
    multi_start,
    spread_starts,
)
from cyclemap.evidence.identification.noise_scales import NoiseLaw
from cyclemap.evidence.identification.parameter_space import ParameterSpace
from cyclemap.evidence.identification.profile_likelihood import Interval, covariance_interval, profile_interval
from cyclemap.evidence.identification.surface_parameters import SURFACE
from cyclemap.suggestions import unknown_name

METHODS = ("profile", "covariance")
# Fewer degrees of freedom than this make an interval rough.
_FEW = 4.0

Folds = int | Mapping[str, ArrayLike]
Progress = Callable[[float], None]


@dataclass(frozen=True)
class _Method:
    """How the uncertainty is told: level and method of the intervals, law and known sizes of the noise."""

    level: float
    intervals: str
    law: NoiseLaw
    noise: Mapping[str, float] | None

    def __post_init__(self) -> None:
        student_quantile(self.level, 10.0)
        if self.intervals not in METHODS:
            raise unknown_name("method of intervals", self.intervals, METHODS)


def identify(
    blocks: Sequence[DataBlock],
    free: Sequence[str],
    fixed: Mapping[str, float] | None = None,
    *,
    starts: int = 8,
    level: float = 0.95,
    intervals: str = "profile",
    folds: Folds = 0,
    noise: Mapping[str, float] | None = None,
    student: float | None = None,
    space: ParameterSpace = SURFACE,
    seed: int = 0,
    progress: Progress | None = None,
) -> Identification:
    """Identify the `free` parameters from blocks of data by maximum likelihood.

    Parameters
    ----------
    blocks : the data; a block with an attribute `own_parameters` (tuple of Parameter) adds those to `space`.
    free : names to be identified. fixed : values of others; what is not given has its nominal value, and a note.
    starts : searches, the first from the natural start, the rest spread about it (seeded).
    level : of the intervals. intervals : `profile` (up to 12 fits a parameter) or `covariance` (none).
    folds : 0, a number of random folds, or labels of rows by block name (leave one label out).
    noise : sizes of kinds of noise that are known; all others are estimated.
    student : degrees of freedom of Student noise, for data with outliers; None: normal.
    progress : called with the fraction done.

    Raises InvalidInput for names or numbers that do not fit, ConvergenceError if no start has an answer.

    >>> from cyclemap.evidence.identification.data_block import FunctionBlock
    >>> x = np.linspace(0.0, 1.0, 8)
    >>> data = 0.2 + 0.01 * np.cos(40.0 * x)
    >>> law = lambda v: (v["pusher_friction"] - data, np.ones((8, 1)))
    >>> found = identify([FunctionBlock("ratios", ("pusher_friction",), law, range(8), "ratio")], ["pusher_friction"])
    >>> print(found["pusher_friction"])
    pusher_friction 0.1986 (0.1919 to 0.2053)
    """
    method = _Method(level, intervals, NoiseLaw(student), noise)
    whole_number("seed", seed, least=0)
    problem, taken = _problem(blocks, tuple(free), fixed or {}, space)
    fold = _folds(problem, folds, seed)
    report = _Stages(progress)
    found = multi_start(problem, spread_starts(problem, starts, seed), method.law, noise, report.stage(0.0, 0.5))
    fit, errors, ends, improved = _intervals(problem, found.best, method, report.stage(0.5, 0.8))
    validation = None if fold is None else cross_validate(problem, fit, fold, method.law, report.stage(0.8, 1.0))
    report.stage(0.0, 1.0)(1.0)
    estimates = tuple(
        estimate(part, float(value), float(error), end, part.name in fit.on_bounds, intervals)
        for part, value, error, end in zip(
            problem.space.parameters, fit.vector, errors.standard_error, ends, strict=True
        )
    )
    notes = (*taken, *improved, *_notes(found, fit, errors, problem, ends, validation))
    table = kind_errors(problem, fit, validation)
    return Identification(estimates, problem.fixed, level, table, found, fit, errors, validation, notes, problem)


class _Stages:
    """Passes on the progress of parts of the work as progress of the whole."""

    def __init__(self, progress: Progress | None) -> None:
        self._progress = progress

    def stage(self, start: float, end: float) -> Progress:
        def told(fraction: float) -> None:
            if self._progress is not None:
                self._progress(start + (end - start) * fraction)

        return told


def _problem(
    blocks: Sequence[DataBlock], free: tuple[str, ...], fixed: Mapping[str, float], space: ParameterSpace
) -> tuple[JointProblem, tuple[str, ...]]:
    """The problem, and a note for every value that was not given."""
    for block in blocks:
        space = space.extended(*getattr(block, "own_parameters", ()))
    both = sorted(set(free) & set(fixed))
    if both or not free:
        raise InvalidInput(f"name what is free, and give no value for it: free {list(free)}, also fixed {both}")
    for name in fixed:
        space[name]
    asked = {name for block in blocks for name in block.parameters}
    taken = [name for name in space.names if name in asked and name not in free and name not in fixed]
    nominal = {name: space.nominal[name] for name in taken}
    notes = tuple(f"{name} was neither free nor given: taken as {value:.4g}" for name, value in nominal.items())
    return JointProblem(tuple(blocks), space.select(free), {**nominal, **fixed}), notes


def _folds(problem: JointProblem, folds: Folds, seed: int) -> NDArray[np.int64] | None:
    if isinstance(folds, Mapping):
        return labelled_folds(problem, folds)
    return None if folds == 0 else random_folds(problem, folds, seed)


def _intervals(
    problem: JointProblem, fit: Fit, method: _Method, progress: Progress
) -> tuple[Fit, Uncertainty, tuple[Interval, ...], tuple[str, ...]]:
    """Intervals of all parameters; where they meet a better minimum, everything starts again from there, once."""
    errors, ends = _all_intervals(problem, fit, method, progress)
    found = _refitted(problem, [end.better for end in ends if end.better is not None], method)
    if found is None or found.deviance >= fit.deviance:
        return fit, errors, ends, ()
    errors, ends = _all_intervals(problem, found, method, progress)
    return found, errors, ends, ("the profiles met a lower minimum than any start did: take more starts",)


def _refitted(problem: JointProblem, points: Sequence[NDArray[np.float64]], method: _Method) -> Fit | None:
    """The best fit from points that the profiles met; None if there is none."""
    fits = []
    for point in points:
        try:
            fits.append(fit_with_noise(problem, point, method.law, method.noise))
        except NO_ANSWER:
            continue
    return min(fits, key=lambda fit: fit.deviance, default=None)


def _all_intervals(
    problem: JointProblem, fit: Fit, method: _Method, progress: Progress
) -> tuple[Uncertainty, tuple[Interval, ...]]:
    errors, ends = uncertainty(problem, fit, method.law), []
    for number, name in enumerate(problem.space.names):
        if method.intervals == "profile":
            ends.append(profile_interval(problem, fit, errors, name, method.level, method.law))
        else:
            ends.append(covariance_interval(problem, fit, errors, name, method.level))
        progress((number + 1) / len(problem.space))
    return errors, tuple(ends)


def _notes(
    found: MultiStart,
    fit: Fit,
    errors: Uncertainty,
    problem: JointProblem,
    ends: tuple[Interval, ...],
    validation: CrossValidation | None,
) -> list[str]:
    """All that qualifies the result, in words."""
    names, notes = problem.space.names, [str(direction) for direction in errors.open]
    if not fit.converged:
        notes.append(f"the search did not converge: {fit.message}")
    if found.failed:
        notes.append(f"{found.failed} of {len(found.starts)} starts had no answer")
    elsewhere = len(found.starts) - found.failed - found.arrived
    if elsewhere:
        notes.append(f"{elsewhere} of {len(found.starts)} starts ended in other, worse minima")
    notes += [f"{name} lies on a bound" for name in fit.on_bounds]
    notes += [f"{n} is not identifiable" for n, end in zip(names, ends, strict=True) if not end.identifiable]
    notes += [
        f"the interval of {n} reaches further than told" for n, e in zip(names, ends, strict=True) if not e.resolved
    ]
    few = [name for name, freedom in zip(names, errors.freedom, strict=True) if freedom < _FEW]
    if few:
        notes.append(f"few independent groups: the intervals of {', '.join(few)} are rough")
    if validation is not None:
        notes += list(validation.failures)
    return notes
