"""Rival explanations of the same data: each with free numbers of its own, fitted, cross-validated, and compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import whole_number
from cyclemap.errors import ConvergenceError, InvalidInput, UnsupportedContact
from cyclemap.evidence.identification.data_block import DataBlock
from cyclemap.evidence.identification.identification import Identification
from cyclemap.evidence.identification.identify import identify
from cyclemap.evidence.identification.noise_scales import NoiseLaw
from cyclemap.evidence.identification.shared_progress import Progress, part_of

Array = NDArray[np.float64]

# A difference in loss of so many of its standard errors is told from chance, if it is worth a free number at all.
_TOLD, _WORTH = 2.0, 2.0
# What a uniform pressure and an ideal ring leave open, by what it frees.
OPEN_QUESTIONS: Mapping[str, tuple[str, ...]] = {
    "even pressure, ideal ring": (),
    "weight on the rim": ("rim_share",),
    "another lever": ("hitch_scale",),
    "friction in the ring": ("pin_friction_radius",),
    "weight on the rim, another lever": ("rim_share", "hitch_scale"),
    "weight on the rim, friction in the ring": ("rim_share", "pin_friction_radius"),
}


@dataclass(frozen=True, eq=False)
class Explanation:
    """One explanation and how it does.

    name : what it says. extra : what it frees beyond what all free. found : the fit; None where none was found, and
    `problem` says why. deviance : -2 log likelihood of rows left out, less the best's, the noise of each kind being its
    own; what it is sorted by. worse : how much larger its loss of rows left out is than the best's at the best's noise.
    standard_error : of `worse`, from its scatter over groups of rows.
    """

    name: str
    extra: tuple[str, ...]
    found: Identification | None
    deviance: float
    worse: float
    standard_error: float
    problem: str = ""

    @property
    def told_apart(self) -> bool:
        """Whether the data tell it from the best."""
        return self.found is not None and self.worse > max(_TOLD * self.standard_error, _WORTH)


@dataclass(frozen=True, eq=False)
class ExplanationComparison:
    """Explanations, the best first, those without a fit last. free : what all of them free.

    Of those whose deviance is within 2 of the lowest the one with the fewest free numbers counts as the best.
    """

    explanations: tuple[Explanation, ...]
    free: tuple[str, ...]

    @property
    def best(self) -> Explanation:
        """The one that predicts rows left out best."""
        return self.explanations[0]

    @property
    def equals(self) -> tuple[Explanation, ...]:
        """Those that the data do not tell from the best, the best left out."""
        return tuple(one for one in self.explanations[1:] if one.found is not None and not one.told_apart)


def compare_explanations(
    blocks: Sequence[DataBlock],
    base_free: Sequence[str],
    alternatives: Mapping[str, Sequence[str]] = OPEN_QUESTIONS,
    fixed: Mapping[str, float] | None = None,
    *,
    folds: int = 5,
    student: float | None = None,
    seed: int = 0,
    progress: Progress | None = None,
    **options: Any,
) -> ExplanationComparison:
    """Fit every alternative to the blocks, cross-validate it on the same folds, and say which predicts best.

    base_free : parameters that all free; those that alternatives name are left to these. alternatives : by name, what
    each frees besides; what it does not free has its value in `fixed`, else its nominal one. options : of `identify`
    (starts, space, noise, level).

    Rows that some fold of some alternative could not predict count for none. Raises InvalidInput for fewer than two
    alternatives or folds, ConvergenceError where no alternative has a fit.
    """
    if len(alternatives) < 2:
        raise InvalidInput(f"there is nothing to compare: {len(alternatives)} explanations; give two or more")
    whole_number("folds", folds, least=2)
    named = {name for extra in alternatives.values() for name in extra}
    base, given = tuple(name for name in base_free if name not in named), dict(fixed or {})
    settings = {"folds": folds, "student": student, "seed": seed, "intervals": "covariance", **options}
    found: dict[str, Identification | str] = {}
    for number, (name, extra) in enumerate(alternatives.items()):
        settings["progress"] = part_of(progress, number, len(alternatives))
        found[name] = _fitted(blocks, (*base, *extra), given, settings)
    return ExplanationComparison(_sorted(found, alternatives, NoiseLaw(student)), base)


def _fitted(
    blocks: Sequence[DataBlock], free: tuple[str, ...], given: Mapping[str, float], settings: Mapping[str, Any]
) -> Identification | str:
    """The fit, or why there is none."""
    held = {key: value for key, value in given.items() if key not in free}
    try:
        return identify(blocks, free, held, **settings)
    except (ConvergenceError, UnsupportedContact) as cause:
        return str(cause)


def _sorted(
    found: Mapping[str, Identification | str], alternatives: Mapping[str, Sequence[str]], law: NoiseLaw
) -> tuple[Explanation, ...]:
    fits = {name: one for name, one in found.items() if isinstance(one, Identification)}
    if not fits:
        raise ConvergenceError(f"no explanation has a fit; the first: {next(iter(found.values()))}")
    errors = {name: _left_out(one) for name, one in fits.items()}
    known = np.all(np.isfinite(list(errors.values())), axis=0)
    if not np.any(known):
        raise ConvergenceError("no row was predicted by every explanation: take fewer folds or other data")
    first = next(iter(fits.values())).problem
    kinds, groups = first.kind_index[known], first.groups[known]
    deviance = {name: _deviance(one[known], kinds) for name, one in errors.items()}
    order = _best_first(deviance, alternatives)
    best = errors[order[0]][known]
    told = []
    for name in order:
        above = deviance[name] - deviance[order[0]]
        worse, scatter = _difference(errors[name][known], best, kinds, groups, law)
        told.append(Explanation(name, tuple(alternatives[name]), fits[name], above, worse, scatter))
    return (*told, *(_lost(name, alternatives[name], str(found[name])) for name in found if name not in fits))


def _best_first(deviance: Mapping[str, float], alternatives: Mapping[str, Sequence[str]]) -> list[str]:
    """Names by deviance, but first the one with fewest free numbers of those that are as good as the lowest."""
    order = sorted(deviance, key=lambda name: deviance[name])
    near = [name for name in order if deviance[name] - deviance[order[0]] < _WORTH]
    best = min(near, key=lambda name: len(alternatives[name]))
    return [best, *(name for name in order if name != best)]


def _lost(name: str, extra: Sequence[str], problem: str) -> Explanation:
    nan = float("nan")
    return Explanation(name, tuple(extra), None, nan, nan, nan, problem)


def _left_out(found: Identification) -> Array:
    assert found.validation is not None
    return found.validation.residuals


def _sizes(errors: Array, kinds: NDArray[np.int64]) -> Array:
    """Root mean square of each kind of row, (kinds,)."""
    count = np.bincount(kinds)
    return np.asarray(np.sqrt(np.bincount(kinds, errors**2) / np.maximum(count, 1)))


def _deviance(errors: Array, kinds: NDArray[np.int64]) -> float:
    return 2.0 * float(np.sum(np.log(np.maximum(_sizes(errors, kinds)[kinds], 1e-300))))


def _difference(
    errors: Array, best: Array, kinds: NDArray[np.int64], groups: NDArray[np.int64], law: NoiseLaw
) -> tuple[float, float]:
    """How much larger the loss is than the best's, at the best's noise, and its standard error over groups."""
    scale = np.maximum(_sizes(best, kinds)[kinds], 1e-300)
    more = law.loss((errors / scale) ** 2)[0] - law.loss((best / scale) ** 2)[0]
    by_group = np.bincount(groups, more)[np.unique(groups)]
    count = len(by_group)
    scatter = float(np.std(by_group, ddof=1)) if count > 1 else np.inf
    return float(np.sum(by_group)), scatter * count**0.5
